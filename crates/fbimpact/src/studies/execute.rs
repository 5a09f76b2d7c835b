//! Makes runs in processes of their own, several at a time.
//!
//! Processes rather than threads: memory goes back to the system after each run, a run that the
//! system ends for want of memory is one failed row, and a run is exactly what `fbimpact run`
//! makes, with its log and its restart file.

use std::collections::VecDeque;
use std::time::Duration;

use result_files::converge::outcome::Outcome;
use result_files::file::fault::Access;

use super::job::{Running, Setting};
use crate::error::AppError;
use crate::results::left::{Left, left};

pub use super::job::{Job, Setting as RunSetting, prepare};

/// Time between two looks at the processes.
const PAUSE: Duration = Duration::from_millis(10);

/// Makes the runs `jobs`, `at_once` of them at a time, and returns what became of each, in their
/// order; those that an earlier call has finished are not made again. If `is_first_needed` and the
/// first one fails, the others are stopped.
///
/// # Errors
/// [`AppError::InterruptedRuns`] if `stop` says so, [`AppError::Io`] if files cannot be written or read.
pub fn execute(
    setting: &Setting,
    jobs: &[Job],
    at_once: usize,
    is_first_needed: bool,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Outcome>, AppError> {
    let mut queue = Queue {
        setting,
        jobs,
        waiting: VecDeque::new(),
        running: Vec::new(),
        outcomes: vec![Outcome::default(); jobs.len()],
    };
    queue.fill()?;
    let done = queue.work((at_once, is_first_needed), stop);
    if done.is_err() {
        queue.drain();
    }
    done?;
    if stop() {
        return Err(AppError::InterruptedRuns { folder: setting.folder.clone() });
    }
    Ok(queue.outcomes)
}

/// Runs that wait, go on and have ended.
struct Queue<'a> {
    setting: &'a Setting,
    jobs: &'a [Job],
    waiting: VecDeque<(usize, bool)>,
    running: Vec<(usize, Running)>,
    outcomes: Vec<Outcome>,
}

impl Queue<'_> {
    /// Sorts the runs into those that are there and those that wait.
    fn fill(&mut self) -> Result<(), AppError> {
        for (i, job) in self.jobs.iter().enumerate() {
            let result = self.setting.result(&job.name);
            match job.inputs_sha256.as_ref().map_or(Ok(Left::Nothing), |inputs| left(&result, inputs))? {
                Left::Complete => {
                    let outcome = Outcome::read(&result)?;
                    self.outcomes[i] = Outcome { is_reused: true, ..outcome };
                    tracing::info!("{}: finished earlier", job.name);
                }
                left => self.waiting.push_back((i, left == Left::Part)),
            }
        }
        Ok(())
    }

    fn work(
        &mut self,
        (at_once, is_first_needed): (usize, bool),
        stop: &dyn Fn() -> bool,
    ) -> Result<(), AppError> {
        loop {
            if stop() {
                self.waiting.clear();
                self.running.iter_mut().for_each(|(_, run)| run.stop());
            }
            while self.running.len() < at_once.max(1)
                && let Some((i, is_taken_up)) = self.waiting.pop_front()
            {
                let verb = if is_taken_up { "goes on" } else { "starts" };
                tracing::info!("{} {verb} on {} threads", self.jobs[i].name, self.setting.threads);
                self.running.push((i, self.setting.start(&self.jobs[i], is_taken_up)?));
            }
            if self.running.is_empty() {
                return Ok(());
            }
            let has_ended = self.collect()?;
            if has_ended && is_first_needed && self.has_failed(0) {
                self.waiting.clear();
                self.running.iter_mut().for_each(|(_, run)| run.stop());
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn has_failed(&self, index: usize) -> bool {
        !self.outcomes[index].status.is_empty() && !self.outcomes[index].is_complete
    }

    /// Takes up what has ended; whether anything has.
    fn collect(&mut self) -> Result<bool, AppError> {
        let before = self.running.len();
        let mut still = Vec::with_capacity(before);
        for (i, mut run) in std::mem::take(&mut self.running) {
            let job = &self.jobs[i];
            let polled =
                run.poll().map_err(|e| AppError::system(self.setting.result(&job.name), Access::Watch, e));
            match polled {
                Ok(None) => still.push((i, run)),
                Ok(Some(status)) => {
                    let outcome = self.setting.end(job, status)?;
                    // What cannot be taken up, as on another kind of machine, is run anew.
                    if run.is_taken_up && matches!(outcome.exit_code, Some(4 | 6)) {
                        self.waiting.push_front((i, false));
                        continue;
                    }
                    let message = if outcome.is_complete { "" } else { &outcome.message };
                    tracing::info!("{}: {} after {:.1} s {message}", job.name, outcome.status, run.elapsed());
                    self.outcomes[i] = outcome;
                }
                Err(error) => {
                    self.running = still;
                    return Err(error);
                }
            }
        }
        self.running = still;
        Ok(self.running.len() < before)
    }

    /// Stops what goes on and waits for it.
    fn drain(&mut self) {
        self.running.iter_mut().for_each(|(_, run)| run.stop());
        while self.running.iter_mut().any(|(_, run)| matches!(run.poll(), Ok(None))) {
            std::thread::sleep(PAUSE);
        }
    }
}
