//! Progress and log on standard error.

use std::io::{IsTerminal, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use adaptive::record::PhaseKind;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use crate::cli::{LogArguments, LogFormat};
use crate::shown_text::{message, short};

/// Wall time between lines when standard error is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(10);
/// Wall time between updates of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);
/// Wall time after which the bar shows a new elapsed time, and stages are looked at.
const TICK: Duration = Duration::from_millis(500);
/// Share of the simulated time from which it tells how long the rest takes.
const LEAST_SHARE: f64 = 0.05;
/// Steps of the bar; fine enough for the widest terminal.
const BAR_LENGTH: u64 = 10_000;

/// Sets up the log; the environment variable `FBIMPACT_LOG` overrides the level, such as "adaptive=trace,info".
pub fn log(arguments: LogArguments, bar: &ProgressBar) {
    let level = match (arguments.quiet, arguments.verbose) {
        (0, 0) => LevelFilter::INFO,
        (1, _) => LevelFilter::WARN,
        (0, 1) => LevelFilter::DEBUG,
        (0, _) => LevelFilter::TRACE,
        (_, _) => LevelFilter::ERROR,
    };
    let given = std::env::var("FBIMPACT_LOG").ok().and_then(|text| text.parse().ok());
    let filter: Targets = given.unwrap_or_else(|| Targets::new().with_default(level));
    let builder = tracing_subscriber::fmt()
        .with_max_level(LevelFilter::TRACE)
        .with_target(false)
        // Colours would have to be told from those of a text that is shown.
        .with_ansi(false)
        .with_writer(AboveBar(bar.clone()));
    // A second call, as in tests, keeps the first log.
    let _ = match arguments.log_format {
        LogFormat::Text => builder.without_time().finish().with(filter).try_init(),
        LogFormat::Json => builder.json().flatten_event(true).finish().with(filter).try_init(),
    };
}

/// Writes log lines above the progress bar, so that neither tears the other. Lines that cannot be written, on a full disk or
/// to a reader that is gone, are dropped: the run is worth more than its log.
#[derive(Clone)]
struct AboveBar(ProgressBar);

impl Write for AboveBar {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        let text = message(&String::from_utf8_lossy(buffer));
        let _ = self.0.suspend(|| std::io::stderr().write_all(text.as_bytes()));
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
    let style = ProgressStyle::with_template("{bar:30} {percent:>3} % {msg} [{elapsed}]")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(Some(BAR_LENGTH), target).with_style(style)
}

/// Reports how far a run has come, and in stages without time steps that it goes on.
pub struct Progress {
    bar: ProgressBar,
    span: (f64, f64),
    /// Whether the time left can be told: where nothing touches, every second of motion takes about as long.
    is_even: bool,
    begin: Instant,
    last: Instant,
    stage: Arc<Mutex<Option<(String, Instant)>>>,
    /// Writes lines in long stages; ends when the other end is dropped.
    _ticker: Sender<()>,
}

impl Progress {
    /// Starts the clock.
    pub fn new(bar: ProgressBar) -> Self {
        let now = Instant::now();
        let stage = Arc::new(Mutex::new(None));
        let (ticker, end) = channel();
        if bar.is_hidden() {
            let stage = stage.clone();
            // Where there is no room for a thread, there are no lines.
            let ticker = std::thread::Builder::new().name("progress".into());
            let _ = ticker.spawn(move || tick(&stage, &end, [TICK, LINE_INTERVAL]));
        } else {
            bar.enable_steady_tick(TICK);
        }
        Self { bar, span: (0.0, 1.0), is_even: false, begin: now, last: now, stage, _ticker: ticker }
    }

    /// Sets start and end of the simulated time \[s\], and whether its seconds take about as long each.
    pub fn set_span(&mut self, span: (f64, f64), is_even: bool) {
        (self.span, self.is_even) = (span, is_even);
        self.begin = Instant::now();
    }

    /// Takes note of work without time steps that begins, or of its end.
    pub fn stage(&self, text: Option<String>) {
        if let Some(text) = &text {
            self.bar.set_message(short(text));
        }
        *lock(&self.stage) = text.map(|text| (text, Instant::now()));
    }

    /// Takes note of a step; cheap.
    pub fn step(&mut self, time: f64, step: f64, phase: PhaseKind) {
        let interval = if self.bar.is_hidden() { LINE_INTERVAL } else { BAR_INTERVAL };
        if self.last.elapsed() < interval {
            return;
        }
        self.last = Instant::now();
        let fraction = ((time - self.span.0) / (self.span.1 - self.span.0)).clamp(0.0, 1.0);
        let phase = phase.identifier();
        let left = self.left(fraction);
        if self.bar.is_hidden() {
            tracing::info!(
                "t = {time:.6e} s of {:.6e} s ({:.0} %), {phase}, step {step:.2e} s{left}",
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
        self.bar.set_message(format!("t = {time:.4e} s, {phase}, step {step:.1e} s{left}"));
    }

    /// The time left, where it can be told from the share that is done.
    fn left(&self, fraction: f64) -> String {
        if !self.is_even || fraction < LEAST_SHARE {
            return String::new();
        }
        format!(", about {:.0} s left", self.begin.elapsed().as_secs_f64() * (1.0 / fraction - 1.0))
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Tells on `bar`, or every so often in a line, that models of bodies are built while `work` lasts.
pub fn while_building<R>(bar: &ProgressBar, work: impl FnOnce() -> R) -> R {
    bar.reset();
    let progress = Progress::new(bar.clone());
    progress.stage(Some("building the models of the bodies".into()));
    let done = work();
    progress.finish();
    done
}

/// Looks after every `tick` whether a stage has lasted for another `interval`, and writes a line then, until the sender is gone.
fn tick(stage: &Mutex<Option<(String, Instant)>>, end: &Receiver<()>, [tick, interval]: [Duration; 2]) {
    let mut last = Instant::now();
    while end.recv_timeout(tick) == Err(RecvTimeoutError::Timeout) {
        let Some((text, since)) = lock(stage).clone() else { continue };
        let quiet = last.max(since).elapsed();
        if quiet >= interval {
            last = Instant::now();
            tracing::info!("{text}, for {:.0} s", since.elapsed().as_secs_f64());
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICKS: [Duration; 2] = [Duration::from_millis(1), Duration::from_millis(20)];

    /// After ten seconds in which seconds of motion take about as long each, or not.
    fn after_ten_seconds(is_even: bool) -> Progress {
        let mut progress = Progress::new(ProgressBar::hidden());
        progress.set_span((0.0, 1.0), is_even);
        progress.begin = Instant::now().checked_sub(Duration::from_secs(10)).expect("a clock that runs");
        progress
    }

    #[test]
    fn time_left_is_told_in_proportion_once_enough_is_done() {
        let progress = after_ten_seconds(true);
        assert_eq!(progress.left(0.25), ", about 30 s left");
        assert_eq!(progress.left(0.5), ", about 10 s left");
        assert_eq!(progress.left(1.0), ", about 0 s left");
        assert_eq!(progress.left(0.99 * LEAST_SHARE), "");
        assert_eq!(progress.left(0.0), "");
    }

    #[test]
    fn time_left_is_not_told_where_something_may_touch() {
        assert_eq!(after_ten_seconds(false).left(0.5), "");
    }

    /// Keeps the lines of a log.
    #[derive(Clone, Default)]
    struct Lines(Arc<Mutex<Vec<u8>>>);

    impl Write for Lines {
        fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
            lock(&self.0).extend(buffer);
            Ok(buffer.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    /// What is written within `time` in the stage `stage`, if there is one.
    fn lines(stage: Option<&str>, time: Duration) -> Vec<String> {
        let lines = Lines::default();
        let writer = lines.clone();
        let log = tracing_subscriber::fmt()
            .with_writer(move || writer.clone())
            .with_ansi(false)
            .with_target(false)
            .without_time()
            .with_level(false);
        let stage = Mutex::new(stage.map(|text| (text.to_owned(), Instant::now())));
        let (sender, end) = channel();
        let clock = std::thread::spawn(move || {
            std::thread::sleep(time);
            drop(sender);
        });
        tracing::subscriber::with_default(log.finish(), || tick(&stage, &end, TICKS));
        clock.join().expect("it ends");
        let text = String::from_utf8(lock(&lines.0).clone()).expect("UTF-8");
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn a_stage_that_lasts_is_told_every_interval_until_the_end() {
        let begin = Instant::now();
        let told = lines(Some("building"), Duration::from_millis(300));
        // As many as fit in at most; a machine that is busy makes fewer.
        let most = begin.elapsed().as_millis() / TICKS[1].as_millis();
        assert!(!told.is_empty() && told.len() as u128 <= most, "{told:?}");
        assert!(told.iter().all(|line| line == "building, for 0 s"), "{told:?}");
    }

    #[test]
    fn nothing_is_told_without_a_stage_or_before_it_has_lasted() {
        assert!(lines(None, Duration::from_millis(60)).is_empty());
        let (sender, end) = channel();
        drop(sender);
        let since = Instant::now();
        tick(&Mutex::new(Some(("building".to_owned(), since))), &end, TICKS);
        assert!(since.elapsed() < Duration::from_secs(5), "it ends at once");
    }
}
