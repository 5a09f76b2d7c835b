//! Many runs of one scenario, made as a command line asks for them.

use std::path::Path;

use result_files::converge::outcome::Outcome;
use result_files::file::fault::Access;

use super::run::stop::Stop;
use super::scenario_file;
use crate::cli::{CacheArguments, RunsArguments};
use crate::error::{AppError, CommandFault};
use crate::scenario::Override;
use crate::studies::execute::{Job, RunSetting, execute};

/// A run that is planned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Planned {
    /// Name, and that of its files.
    pub name: String,
    /// Its own changes of the scenario, `KEY=VALUE`.
    pub set: Vec<String>,
}

/// How runs are made.
pub struct Runs<'a> {
    /// Scenario of all.
    pub scenario: &'a Path,
    /// Changes of it for all.
    pub set: &'a [Override],
    /// Folder of the results.
    pub folder: &'a Path,
    /// What the command line gives, and the number of threads of all runs together.
    pub means: (&'a RunsArguments, usize),
    /// Says when to stop.
    pub stop: &'a Stop,
}

impl Runs<'_> {
    /// Makes the runs that are not there yet and returns what became of all; others are stopped if `is_first_needed` and the
    /// first fails.
    ///
    /// # Errors
    /// As [`execute`]; [`AppError::Command`] for a change that is none.
    pub fn make(
        &self,
        planned: impl Iterator<Item = Planned>,
        is_first_needed: bool,
    ) -> Result<Vec<Outcome>, AppError> {
        let jobs = planned.map(|planned| self.job(planned)).collect::<Result<Vec<_>, AppError>>()?;
        let (means, n_threads) = self.means;
        let at_once = n_threads.min(means.jobs.unwrap_or(usize::MAX)).min(jobs.len()).max(1);
        let mut passed = cache_arguments(&means.cache);
        if let Some(memory) = means.memory {
            passed.extend(["--memory".to_owned(), (memory / at_once as f64).to_string()]);
        }
        let setting = RunSetting {
            program: std::env::current_exe().map_err(|e| AppError::system("fbimpact", Access::Find, e))?,
            scenario: self.scenario.to_owned(),
            folder: self.folder.to_owned(),
            arguments: passed,
            threads: (n_threads / at_once).max(1),
        };
        execute(&setting, &jobs, at_once, is_first_needed, &|| self.stop.is_asked())
    }

    /// The run of `planned`. One that is no valid scenario fails when it is run.
    fn job(&self, planned: Planned) -> Result<Job, AppError> {
        let own = planned.set.iter().map(|s| s.parse().map_err(|fault| CommandFault::Override(fault).into()));
        let own = own.collect::<Result<Vec<Override>, AppError>>()?;
        let all: Vec<Override> = self.set.iter().cloned().chain(own).collect();
        let inputs_sha256 = match scenario_file::read(self.scenario, &all) {
            Ok(scenario) => Some(scenario.source.inputs_sha256),
            Err(AppError::Scenario(_)) => None,
            Err(error) => return Err(error),
        };
        let set = all.iter().map(|o| o.text().to_owned()).collect();
        Ok(Job { name: planned.name, set, inputs_sha256 })
    }
}

/// The options of the cache as arguments for the runs that are started.
fn cache_arguments(arguments: &CacheArguments) -> Vec<String> {
    let mut list = vec!["--cache-limit".to_owned(), arguments.cache_limit.to_string()];
    if arguments.no_cache {
        list.push("--no-cache".to_owned());
    }
    if let Some(folder) = &arguments.cache_dir {
        list.extend(["--cache-dir".to_owned(), folder.display().to_string()]);
    }
    list
}
