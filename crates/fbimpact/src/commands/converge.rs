//! `fbimpact converge`: how far a result depends on its resolution.

use std::path::{Path, PathBuf};

use adaptive::model::subjects;
use adaptive::prepared::Prepared;
use result_files::converge::difference::Difference;
use result_files::converge::outcome::Outcome;
use result_files::converge::report::{self, Study};
use result_files::converge::variant::{Parameter, Variant};
use result_files::converge::verdict::{Compared, Variants, dominant, judge, significant};
use result_files::file::fault::Access;
use result_files::file::whole_file;

use super::run::stop::Stop;
use super::{print, threads};
use crate::cli::{CacheArguments, ConvergeArguments};
use crate::commands::scenario_file;
use crate::converge::execute::{Job, RunSetting, execute, prepare};
use crate::converge::plan::{BASE, Plan};
use crate::converge::sizes::sizes;
use crate::error::{AppError, CommandFault};
use crate::scenario::Override;

/// Runs the scenario and its variants, compares them and judges.
///
/// # Errors
/// [`AppError::Unconverged`] if a change is beyond the tolerance or unknown, [`AppError::Base`] if the run of the scenario as it
/// is fails, [`AppError::InterruptedRuns`] when interrupted; those of reading the scenario.
pub fn converge(arguments: &ConvergeArguments) -> Result<(), AppError> {
    let stop = Stop::listen(false);
    let n_threads = threads(arguments.threads)?;
    let scenario = scenario_file::read(&arguments.scenario, &arguments.set.set)?;
    let spec = &scenario.run;
    let subjects = subjects(&Prepared::new(spec).map_err(AppError::model)?);
    let plan = Plan::new(&scenario, subjects);
    let folder = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.scenario));
    prepare(&folder)?;
    let sizes = sizes(spec);
    stop.begin();
    let runs = Runs { arguments, folder: &folder, n_threads, stop: &stop };
    let size = |body: &str| sizes.get(body).copied().unwrap_or(0.0);

    let singles = plan.singles();
    let (base, outcomes) = runs.with_base(&singles)?;
    let compare = |variants: Vec<Variant>, outcomes: Vec<Outcome>| -> Vec<Compared> {
        let pairs = variants.into_iter().zip(outcomes);
        let compared = pairs.map(|(variant, outcome)| {
            let difference = outcome.is_complete.then(|| Difference::new(&base, &outcome, &size));
            Compared { variant, outcome, difference }
        });
        compared.collect()
    };
    let mut singles = compare(singles, outcomes);
    singles.sort_by_key(|c| c.variant.parameters.clone());

    let tolerance = arguments.tolerance;
    let together: Vec<Variant> = plan.together(&significant(&singles, tolerance)).into_iter().collect();
    let limiting = dominant(&singles).filter(|c| c.largest().is_some_and(|l| l.relative > tolerance));
    let split = limiting.map(|c| plan.split(c.variant.parameters[0])).unwrap_or_default();
    let n_together = together.len();
    let more: Vec<Variant> = together.into_iter().chain(split).collect();
    let outcomes = runs.make(&more)?;
    let mut more = compare(more, outcomes);
    let split = more.split_off(n_together);

    let verdict = judge(Variants { singles: &singles, together: more.first(), split: &split }, tolerance);
    let variants = [singles, more, split].concat();
    let study = Study {
        scenario: &arguments.scenario,
        folder: &folder,
        tolerance,
        base: &base,
        variants: &variants,
        not_varied: &plan.not_varied(),
        verdict: &verdict,
    };
    let json = format!("{:#}\n", study.json());
    whole_file::write(&folder.join(report::FILE), json.as_bytes())?;
    let text = if arguments.json { json } else { study.table() };
    print(&text)?;
    if verdict.is_converged { Ok(()) } else { Err(AppError::Unconverged { tolerance }) }
}

/// The scenario's name with `.converge`, in the working directory.
fn default_folder(scenario: &Path) -> PathBuf {
    let mut name = scenario.file_stem().unwrap_or(scenario.as_os_str()).to_owned();
    name.push(".converge");
    PathBuf::from(name)
}

/// Makes runs as the command line asks for them.
struct Runs<'a> {
    arguments: &'a ConvergeArguments,
    folder: &'a Path,
    n_threads: usize,
    stop: &'a Stop,
}

impl Runs<'_> {
    /// The run of the scenario as it is, and those of `variants`.
    fn with_base(&self, variants: &[Variant]) -> Result<(Outcome, Vec<Outcome>), AppError> {
        let base = Variant {
            name: BASE.to_owned(),
            parameters: Vec::<Parameter>::new(),
            subjects: Vec::new(),
            set: Vec::new(),
        };
        let all: Vec<Variant> = std::iter::once(base).chain(variants.iter().cloned()).collect();
        let mut outcomes = self.run(&all, true)?;
        let base = outcomes.remove(0);
        if base.is_complete {
            return Ok((base, outcomes));
        }
        let code = base.exit_code.and_then(|c| u8::try_from(c).ok()).filter(|c| *c != 0).unwrap_or(5);
        Err(AppError::Base { code, message: base.message })
    }

    /// Runs all `variants` and returns their outcomes.
    fn make(&self, variants: &[Variant]) -> Result<Vec<Outcome>, AppError> {
        self.run(variants, false)
    }

    fn run(&self, variants: &[Variant], has_base: bool) -> Result<Vec<Outcome>, AppError> {
        let at_once =
            self.n_threads.min(self.arguments.jobs.unwrap_or(usize::MAX)).min(variants.len()).max(1);
        let mut passed = cache_arguments(&self.arguments.cache);
        if let Some(memory) = self.arguments.memory {
            passed.extend(["--memory".to_owned(), (memory / at_once as f64).to_string()]);
        }
        let setting = RunSetting {
            program: std::env::current_exe().map_err(|e| AppError::system("fbimpact", Access::Find, e))?,
            scenario: self.arguments.scenario.clone(),
            folder: self.folder.to_owned(),
            arguments: passed,
            threads: (self.n_threads / at_once).max(1),
        };
        let jobs = variants.iter().map(|v| self.job(v)).collect::<Result<Vec<_>, AppError>>()?;
        execute(&setting, &jobs, at_once, has_base, &|| self.stop.is_asked())
    }

    /// The run of `variant`. A variant that is no valid scenario fails when it is run.
    fn job(&self, variant: &Variant) -> Result<Job, AppError> {
        let own = variant.set.iter().map(|s| s.parse().map_err(|fault| CommandFault::Override(fault).into()));
        let own = own.collect::<Result<Vec<Override>, AppError>>()?;
        let all: Vec<Override> = self.arguments.set.set.iter().cloned().chain(own).collect();
        let inputs_sha256 = match scenario_file::read(&self.arguments.scenario, &all) {
            Ok(scenario) => Some(scenario.source.inputs_sha256),
            Err(AppError::Scenario(_)) => None,
            Err(error) => return Err(error),
        };
        let set = all.iter().map(|o| o.text().to_owned()).collect();
        Ok(Job { name: variant.name.clone(), set, inputs_sha256 })
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
