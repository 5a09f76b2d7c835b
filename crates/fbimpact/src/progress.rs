//! Progress and log on standard error.

use std::io::{IsTerminal, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use adaptive::record::PhaseKind;
use adaptive::record::work;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use result_files::words::shown::{message, short};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use crate::cli::{LogArguments, LogFormat};

/// Wall time between lines of steps when standard error is no terminal; a stage or a step that
/// lasts longer is reported a tick later, within ten seconds.
const LINE_INTERVAL: Duration = Duration::from_secs(9);
/// Wall time between updates of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);
/// Wall time after which the bar shows a new elapsed time, and stages are looked at.
const TICK: Duration = Duration::from_millis(500);
/// Share of the simulated time from which it tells how long the rest takes.
const LEAST_SHARE: f64 = 0.05;
/// Steps of the bar; fine enough for the widest terminal.
const BAR_LENGTH: u64 = 10_000;

/// Sets up the log; the environment variable `FBIMPACT_LOG` overrides the level, such as
/// "adaptive=trace,info".
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

/// Writes log lines above the progress bar, so that neither tears the other. Lines that cannot be
/// written, on a full disk or to a reader that is gone, are dropped: the run is worth more than its
/// log.
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
    /// Whether the time left can be estimated: where nothing touches, every second of motion takes
    /// about as long.
    is_even: bool,
    begin: Instant,
    last: Instant,
    now: Arc<Mutex<Now>>,
    /// Tells that long stages and steps go on; ends when the other end is dropped.
    _ticker: Sender<()>,
}

/// What goes on, and since when.
struct Now {
    what: What,
    since: Instant,
    /// When the last line was written.
    told: Instant,
}

enum What {
    /// Nothing to tell of.
    Nothing,
    /// Work without time steps.
    Stage(String),
    /// A time step behind one that has ended: time reached \[s\], last step \[s\], phase.
    Step(f64, f64, PhaseKind),
}

impl Now {
    fn new(what: What) -> Self {
        Self { what, since: Instant::now(), told: Instant::now() }
    }

    /// What goes on, with the part that is being worked at; none if there is nothing.
    fn text(&self) -> Option<String> {
        match &self.what {
            What::Nothing => None,
            What::Stage(text) => {
                Some(work::now().map_or_else(|| text.clone(), |work| format!("{text}: {work}")))
            }
            What::Step(time, step, phase) => Some(format!(
                "t = {time:.6e} s, {}, a step behind one of {step:.2e} s goes on",
                phase.identifier()
            )),
        }
    }
}

impl Progress {
    /// Starts the clock.
    pub fn new(bar: ProgressBar) -> Self {
        let now = Instant::now();
        let shared = Arc::new(Mutex::new(Now::new(What::Nothing)));
        let (ticker, end) = channel();
        let (watched, shown) = (shared.clone(), bar.clone());
        if !bar.is_hidden() {
            bar.enable_steady_tick(TICK);
        }
        // Where there is no room for a thread, there are no lines.
        let thread = std::thread::Builder::new().name("progress".into());
        let _ = thread.spawn(move || tick((&watched, &shown), &end, [TICK, LINE_INTERVAL + TICK]));
        Self { bar, span: (0.0, 1.0), is_even: false, begin: now, last: now, now: shared, _ticker: ticker }
    }

    /// Sets start and end of the simulated time \[s\], and whether its seconds take about as long
    /// each.
    pub fn set_span(&mut self, span: (f64, f64), is_even: bool) {
        (self.span, self.is_even) = (span, is_even);
        self.begin = Instant::now();
    }

    /// Takes note of work without time steps that begins, or of time steps.
    pub fn stage(&self, text: Option<String>) {
        if let Some(text) = &text {
            self.bar.set_message(short(text));
        }
        let mut now = lock(&self.now);
        now.what = What::Stage(text.unwrap_or_else(|| "making a time step".to_owned()));
        now.since = Instant::now();
    }

    /// Takes note of a step; cheap.
    pub fn step(&mut self, time: f64, step: f64, phase: PhaseKind) {
        let now = Instant::now();
        {
            let mut shared = lock(&self.now);
            (shared.what, shared.since) = (What::Step(time, step, phase), now);
            let is_due = match self.bar.is_hidden() {
                true => now.duration_since(shared.told) >= LINE_INTERVAL,
                false => now.duration_since(self.last) >= BAR_INTERVAL,
            };
            if !is_due {
                return;
            }
            shared.told = now;
        }
        self.last = now;
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

    /// The time left, where it can be estimated from the share that is done.
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
    while_at(bar, "building the models of the bodies".into(), work)
}

/// Tells on `bar`, or every so often in a line, what is done while `work` lasts.
pub fn while_at<R>(bar: &ProgressBar, what: String, work: impl FnOnce() -> R) -> R {
    bar.reset();
    let progress = Progress::new(bar.clone());
    progress.stage(Some(what));
    let done = work();
    progress.finish();
    done
}

/// Looks after every `tick` what goes on: shows on a bar what a stage is at, and writes a line,
/// where there is none, when none has been written for `interval`; until the sender is gone.
fn tick((now, bar): (&Mutex<Now>, &ProgressBar), end: &Receiver<()>, [tick, interval]: [Duration; 2]) {
    while end.recv_timeout(tick) == Err(RecvTimeoutError::Timeout) {
        let mut now = lock(now);
        let Some(text) = now.text() else { continue };
        if !bar.is_hidden() {
            if matches!(now.what, What::Stage(_)) {
                bar.set_message(short(&text));
            }
            continue;
        }
        if now.told.elapsed() >= interval {
            now.told = Instant::now();
            let since = now.since.elapsed().as_secs_f64();
            // The log is slow on some disks, and a step waits for none.
            drop(now);
            tracing::info!("{text}, for {since:.0} s");
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

    /// What is written within `time` while `what` goes on.
    fn lines(what: What, time: Duration) -> Vec<String> {
        let lines = Lines::default();
        let writer = lines.clone();
        let log = tracing_subscriber::fmt()
            .with_writer(move || writer.clone())
            .with_ansi(false)
            .with_target(false)
            .without_time()
            .with_level(false);
        let now = Mutex::new(Now::new(what));
        let (sender, end) = channel();
        let clock = std::thread::spawn(move || {
            std::thread::sleep(time);
            drop(sender);
        });
        let bar = ProgressBar::hidden();
        tracing::subscriber::with_default(log.finish(), || tick((&now, &bar), &end, TICKS));
        clock.join().expect("it ends");
        let text = String::from_utf8(lock(&lines.0).clone()).expect("UTF-8");
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn a_stage_that_lasts_is_told_every_interval_until_the_end() {
        let begin = Instant::now();
        let told = lines(What::Stage("building".into()), Duration::from_millis(300));
        // As many as fit in at most; a machine that is busy makes fewer.
        let most = begin.elapsed().as_millis() / TICKS[1].as_millis();
        assert!(!told.is_empty() && told.len() as u128 <= most, "{told:?}");
        assert!(told.iter().all(|line| line == "building, for 0 s"), "{told:?}");
    }

    #[test]
    fn a_step_that_lasts_is_told_with_its_time() {
        let told = lines(What::Step(2.5e-5, 1e-8, PhaseKind::Impact), Duration::from_millis(300));
        let expected = "t = 2.500000e-5 s, impact, a step behind one of 1.00e-8 s goes on, for 0 s";
        assert!(!told.is_empty() && told.iter().all(|line| line == expected), "{told:?}");
    }

    #[test]
    fn a_stage_names_what_is_worked_at() {
        let stage = Now::new(What::Stage("choosing".into()));
        let work = work::begin("body \"ring\" (2 of 3), modes of 4711 unknowns".into());
        let text = stage.text().expect("a stage");
        assert_eq!(text, "choosing: body \"ring\" (2 of 3), modes of 4711 unknowns");
        drop(work);
        assert_eq!(stage.text().expect("a stage"), "choosing");
    }

    #[test]
    fn nothing_is_told_without_a_stage_or_before_it_has_lasted() {
        assert!(lines(What::Nothing, Duration::from_millis(60)).is_empty());
        let (sender, end) = channel();
        drop(sender);
        let since = Instant::now();
        tick((&Mutex::new(Now::new(What::Stage("building".into()))), &ProgressBar::hidden()), &end, TICKS);
        assert!(since.elapsed() < Duration::from_secs(5), "it ends at once");
    }
}
