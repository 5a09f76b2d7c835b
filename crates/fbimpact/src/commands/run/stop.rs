//! The wish to stop a run, and how it is obeyed within a second.
//!
//! A run looks at the wish after every step and between the stages of a fine model. Where it does
//! not come to that soon, in a factorisation of seconds, another thread closes what the run holds
//! open and ends the process: a model that is being built holds nothing that would be lost.

mod signals;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::Thread;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use result_files::file::fault::FileFault;
use result_files::file::whole_file;

use crate::error::AppError;
use crate::process::allocation;
use crate::results::{OutputFile, Recorder, Status};
use signals::Request;

/// Time that the run has to end by itself.
const GRACE: Duration = Duration::from_millis(400);
/// Time between looks at what the run holds open, where it holds nothing at the moment.
const LOOK: Duration = Duration::from_millis(50);
/// Signals that come sooner after the first one are the same one, sent to the process and to its
/// group.
const SAME_SIGNAL: Duration = Duration::from_millis(250);

/// The wish to stop, and what is closed then.
#[derive(Default)]
pub struct Stop {
    is_asked: AtomicBool,
    /// Whether the process shall end even if the run does not look.
    must_end: AtomicBool,
    /// Whether there are files to be closed.
    has_begun: AtomicBool,
    closer: OnceLock<Thread>,
    held: Mutex<Option<Held>>,
}

/// What a run holds open.
pub struct Held {
    /// The file that it writes.
    pub output: OutputFile,
    /// What writes it; none while sizes are chosen.
    pub recorder: Option<Recorder>,
    /// Whether the restart file was made by this run, not by an earlier one that can still be taken
    /// up.
    pub is_restart_own: bool,
    /// Line of progress, which is cleared.
    pub bar: ProgressBar,
    /// Time reached \[s\].
    pub time: f64,
}

impl Stop {
    /// A wish that signals set, and the end of standard input if `until_eof`. A second Ctrl-C ends
    /// the process at once. Comes before any thread is started.
    pub fn listen(until_eof: bool) -> Arc<Self> {
        let stop = Arc::new(Self::default());
        let (by_signal, mut first) = (stop.clone(), None::<Instant>);
        let listening = signals::listen(move |request| match first {
            _ if request == Request::Soon => by_signal.ask(),
            Some(at) if at.elapsed() >= SAME_SIGNAL => end_at_once(),
            Some(_) => {}
            None => {
                first = Some(Instant::now());
                by_signal.ask();
            }
        });
        if let Err(error) = listening {
            tracing::warn!("Ctrl-C will end the run without closing the file: {error}");
        }
        let closing = stop.clone();
        let closer =
            std::thread::Builder::new().name("closer".into()).spawn(move || closing.close_when_asked());
        match closer {
            Ok(closer) => {
                allocation::on_end(closer.thread().clone());
                // Nobody else has set it.
                let _ = stop.closer.set(closer.thread().clone());
            }
            Err(error) => tracing::warn!("signals will be obeyed between two steps only: {error}"),
        }
        if until_eof {
            let stop = stop.clone();
            let reader = std::thread::Builder::new().name("input".into()).spawn(move || {
                // An error ends the input as well.
                let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
                stop.ask();
            });
            if let Err(error) = reader {
                tracing::warn!("the end of standard input will not be seen: {error}");
            }
        }
        stop
    }

    /// From now on there are files to be closed before the process ends.
    pub fn begin(&self) {
        self.has_begun.store(true, Ordering::SeqCst);
    }

    /// Whether the user wants to stop.
    pub fn is_asked(&self) -> bool {
        self.is_asked.load(Ordering::Relaxed)
    }

    /// Notes the wish, for the run to look at; returns whether it was there before.
    pub fn note(&self) -> bool {
        self.is_asked.swap(true, Ordering::Relaxed)
    }

    /// Notes the wish, and sees to it that the process ends soon.
    fn ask(&self) {
        self.note();
        self.must_end.store(true, Ordering::SeqCst);
        if let Some(closer) = self.closer.get() {
            closer.unpark();
        }
    }

    /// Waits for the wish or the end of memory, and closes what the run holds open if it does not
    /// do so itself.
    fn close_when_asked(&self) {
        while !self.must_end.load(Ordering::SeqCst) && !allocation::has_ended() {
            std::thread::park();
        }
        if self.has_begun.load(Ordering::SeqCst) && !allocation::has_ended() {
            std::thread::sleep(GRACE);
        }
        // Again and again: the run may be about to open its file, or to end by itself.
        loop {
            // Locked until the process ends: the run cannot go on.
            let mut held = self.lock();
            let error = match held.take() {
                Some(held) => Some(held.close()),
                None if self.has_begun.load(Ordering::SeqCst) => None,
                None => Some(AppError::InterruptedEarly),
            };
            if let Some(error) = error {
                let code = if allocation::has_ended() { allocation::EXIT_CODE } else { error.code() };
                crate::report(&error);
                let _none = whole_file::no_probe();
                std::process::exit(i32::from(code));
            }
            drop(held);
            std::thread::sleep(LOOK);
        }
    }

    /// Hands over what the run holds open.
    pub fn hold(&self, held: Held) {
        *self.lock() = Some(held);
    }

    /// Takes back what the run holds open.
    ///
    /// # Panics
    /// If it holds nothing.
    pub fn take(&self) -> Held {
        self.lock().take().expect("a run holds its file until it ends")
    }

    /// Does `action` with what the run holds open.
    ///
    /// # Panics
    /// If it holds nothing.
    pub fn with<T>(&self, action: impl FnOnce(&mut Held) -> T) -> T {
        action(self.lock().as_mut().expect("a run holds its file until it ends"))
    }

    fn lock(&self) -> MutexGuard<'_, Option<Held>> {
        // What a panic left behind is still the file.
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Held {
    /// Closes the file of a run that is stopped wherever it is. Returns the error to show.
    pub fn close(self) -> AppError {
        let Self { output, recorder, is_restart_own, bar, time } = self;
        bar.finish_and_clear();
        let mut recorder = match recorder {
            Some(recorder) if recorder.has_begun() => recorder,
            // What it stored before stays as it is.
            Some(recorder) if recorder.is_taken_up() => {
                return AppError::InterruptedResumption { output: output.part().to_owned() };
            }
            _ => {
                if is_restart_own {
                    output.remove_restart();
                }
                output.discard();
                return AppError::InterruptedEarly;
            }
        };
        let part = output.part().to_owned();
        let message = format!("interrupted at t = {time:.9e} s");
        if let Err(fault) = recorder.finish(Status::Interrupted, &message, None) {
            return AppError::io(&part, FileFault::contents(fault));
        }
        match output.finish(Status::Interrupted) {
            Ok(output) => AppError::Interrupted { time, output },
            Err(error) => error,
        }
    }
}

/// Ends the process without closing anything; what was flushed stays, and the run can be taken up.
fn end_at_once() {
    #[cfg(unix)]
    let _ = nix::sys::signal::raise(nix::sys::signal::Signal::SIGKILL);
    std::process::abort();
}
