//! `fbimpact converge`: how far a result depends on its resolution.

use std::path::{Path, PathBuf};

use adaptive::model::subjects;
use adaptive::prepared::Prepared;
use result_files::converge::difference::Difference;
use result_files::converge::outcome::Outcome;
use result_files::converge::report::{self, Study};
use result_files::converge::variant::Variant;
use result_files::converge::verdict::{Compared, Variants, dominant, judge, significant};
use result_files::file::whole_file;

use super::many_runs::{Planned, Runs};
use super::run::stop::Stop;
use super::{print, threads};
use crate::cli::ConvergeArguments;
use crate::commands::scenario_file;
use crate::error::AppError;
use crate::studies::execute::prepare;
use crate::studies::plan::{BASE, Plan};
use crate::studies::sizes::sizes;

/// Runs the scenario and its variants, compares them and judges.
///
/// # Errors
/// [`AppError::Unconverged`] if a change is beyond the tolerance or unknown, [`AppError::Base`] if the run of the scenario as it
/// is fails, [`AppError::InterruptedRuns`] when interrupted; those of reading the scenario.
pub fn converge(arguments: &ConvergeArguments) -> Result<(), AppError> {
    let stop = Stop::listen(false);
    let n_threads = threads(arguments.runs.threads)?;
    let scenario = scenario_file::read(&arguments.scenario, &arguments.set.set)?;
    let spec = &scenario.run;
    let subjects = subjects(&Prepared::new(spec).map_err(AppError::model)?);
    let plan = Plan::new(&scenario, subjects);
    let folder = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.scenario));
    prepare(&folder, report::FILE)?;
    let sizes = sizes(spec);
    stop.begin();
    let runs = Runs {
        scenario: &arguments.scenario,
        set: &arguments.set.set,
        folder: &folder,
        means: (&arguments.runs, n_threads),
        stop: &stop,
    };
    let size = |body: &str| sizes.get(body).copied().unwrap_or(0.0);

    let singles = plan.singles();
    let (base, outcomes) = with_base(&runs, &singles)?;
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
    let outcomes = runs.make(more.iter().map(planned), false)?;
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

/// A variant as a run.
fn planned(variant: &Variant) -> Planned {
    Planned { name: variant.name.clone(), set: variant.set.clone() }
}

/// The run of the scenario as it is, and those of `variants`.
fn with_base(runs: &Runs<'_>, variants: &[Variant]) -> Result<(Outcome, Vec<Outcome>), AppError> {
    let base = Planned { name: BASE.to_owned(), set: Vec::new() };
    let mut outcomes = runs.make(std::iter::once(base).chain(variants.iter().map(planned)), true)?;
    let base = outcomes.remove(0);
    if base.is_complete {
        return Ok((base, outcomes));
    }
    let code = base.exit_code.and_then(|c| u8::try_from(c).ok()).filter(|c| *c != 0).unwrap_or(5);
    Err(AppError::Base { code, message: base.message })
}
