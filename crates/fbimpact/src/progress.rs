//! Progress and log on standard error.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use adaptive::record::PhaseKind;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

use crate::cli::{LogArguments, LogFormat};

/// Wall time between lines when standard error is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(10);
/// Wall time between updates of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);
/// Steps of the bar; fine enough for the widest terminal.
const BAR_LENGTH: u64 = 10_000;

/// Sets up the log.
pub fn log(arguments: LogArguments, bar: &ProgressBar) {
    let level = match (arguments.quiet, arguments.verbose) {
        (0, 0) => "info",
        (1, _) => "warn",
        (0, 1) => "debug",
        (0, _) => "trace",
        (_, _) => "error",
    };
    let filter = EnvFilter::builder()
        .with_env_var("FBIMPACT_LOG")
        .try_from_env()
        .unwrap_or_else(|_| EnvFilter::new(level));
    let builder = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_target(false)
        .with_ansi(std::io::stderr().is_terminal())
        .with_writer(AboveBar(bar.clone()));
    // A second call, as in tests, keeps the first log.
    let _ = match arguments.log_format {
        LogFormat::Text => builder.without_time().try_init(),
        LogFormat::Json => builder.json().flatten_event(true).try_init(),
    };
}

/// Writes log lines above the progress bar, so that neither tears the other. Lines that cannot be written, on a full disk or
/// to a reader that is gone, are dropped: the run is worth more than its log.
#[derive(Clone)]
struct AboveBar(ProgressBar);

impl Write for AboveBar {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        let _ = self.0.suspend(|| std::io::stderr().write_all(buffer));
        Ok(buffer.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        let _ = std::io::stderr().flush();
        Ok(())
    }
}

impl<'a> MakeWriter<'a> for AboveBar {
    type Writer = Self;

    fn make_writer(&'a self) -> Self {
        self.clone()
    }
}

/// A bar on a terminal, hidden elsewhere and when quiet.
pub fn bar(arguments: LogArguments) -> ProgressBar {
    let shown =
        arguments.quiet == 0 && arguments.log_format == LogFormat::Text && std::io::stderr().is_terminal();
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let style = ProgressStyle::with_template("{bar:30} {percent:>3} % {msg} [{elapsed}, left {eta}]")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(Some(BAR_LENGTH), target).with_style(style)
}

/// Reports how far a run has come.
pub struct Progress {
    bar: ProgressBar,
    span: (f64, f64),
    begin: Instant,
    last: Instant,
}

impl Progress {
    /// Starts the clock.
    pub fn new(bar: ProgressBar) -> Self {
        let now = Instant::now();
        Self { bar, span: (0.0, 1.0), begin: now, last: now }
    }

    /// Sets start and end of the simulated time \[s\].
    pub fn set_span(&mut self, span: (f64, f64)) {
        self.span = span;
        self.begin = Instant::now();
    }

    /// Takes note of a step; cheap.
    pub fn step(&mut self, time: f64, step: f64, phase: PhaseKind) {
        let interval = if self.bar.is_hidden() { LINE_INTERVAL } else { BAR_INTERVAL };
        if self.last.elapsed() < interval {
            return;
        }
        self.last = Instant::now();
        let fraction = ((time - self.span.0) / (self.span.1 - self.span.0)).clamp(0.0, 1.0);
        let phase = match phase {
            PhaseKind::Free => "free",
            PhaseKind::Impact => "impact",
        };
        if self.bar.is_hidden() {
            let elapsed = self.begin.elapsed().as_secs_f64();
            let left = if fraction > 0.0 { elapsed * (1.0 / fraction - 1.0) } else { f64::NAN };
            tracing::info!(
                "t = {time:.6e} s of {:.6e} s ({:.0} %), {phase}, step {step:.2e} s, about {left:.0} s left",
                self.span.1,
                100.0 * fraction
            );
            return;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the fraction lies between 0 and 1"
        )]
        self.bar.set_position((fraction * BAR_LENGTH as f64) as u64);
        self.bar.set_message(format!("t = {time:.4e} s, {phase}, step {step:.1e} s"));
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
