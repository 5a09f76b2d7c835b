//! `fbimpact report`: one page about results.

use std::io::Write;
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;
use result_files::error::ResultError;
use result_files::file::fault::FileFault;
use result_files::file::output::{Gate, Kind};
use result_files::file::whole_file;
use result_files::stored::open::{open, scenario_text};
use result_files::stored::summary::{self, Summary};
use serde_json::Value;

use super::plot::labelled;
use crate::cache;
use crate::cli::ReportArguments;
use crate::commands::{print, threads};
use crate::error::{AppError, CommandFault};
use crate::postprocessing::replay::states::States;
use crate::postprocessing::report::charts::charts;
use crate::postprocessing::report::motion::Motion;
use crate::postprocessing::report::tables::Told;
use crate::postprocessing::report::whole::{Parts, Scene, report};
use crate::progress::while_at;
use adaptive::store::ModelCache;

/// The page, by an element of its head.
const PAGE: Kind =
    Kind::marked("a page that fbimpact wrote", "<meta name=\"generator\" content=\"fbimpact\">");
/// Stands for standard output.
const STANDARD_OUTPUT: &str = "-";

/// Writes the report and prints the name of its file.
///
/// # Errors
/// [`AppError::Command`] for more files than can be told apart, for bodies without a shape and for those that there are not, [`AppError::Io`] for a
/// file that cannot be read or written.
pub fn write_report(arguments: &ReportArguments, bar: &ProgressBar) -> Result<(), AppError> {
    let output = &arguments.output;
    let is_piped = output.as_os_str() == STANDARD_OUTPUT;
    if !is_piped {
        Gate::of_files(&arguments.files, arguments.force).check(output, PAGE)?;
    }
    let files = labelled(&arguments.files, arguments.labels)?;
    let summaries = arguments
        .files
        .iter()
        .map(|path| summary::read(path))
        .collect::<Result<Vec<Summary>, ResultError>>()?;
    let json: Vec<Value> = summaries.iter().map(Summary::json).collect();
    let texts: Vec<String> =
        arguments.files.iter().map(|path| scenario(path)).collect::<Result<_, AppError>>()?;
    let studies: Vec<Option<Value>> = arguments.files.iter().map(|path| study(path)).collect();
    let charts = charts(&files)?;
    let scenes = scenes(arguments, bar)?;
    let told: Vec<Told<'_>> = (0..files.len())
        .map(|i| Told {
            label: &files[i].label,
            path: &arguments.files[i],
            summary: &summaries[i],
            json: &json[i],
            scenario: &texts[i],
            study: studies[i].as_ref(),
        })
        .collect();
    let parts = Parts { results: &told, charts: &charts, scenes: &scenes };
    let made = while_at(bar, "writing the page".into(), || report(&parts, arguments.max_size));
    if !made.note.is_empty() {
        tracing::warn!("{}", made.note);
    }
    if made.text.len() as f64 > 1e6 * arguments.max_size {
        tracing::warn!("tables and figures alone take {:.2} MB", made.text.len() as f64 / 1e6);
    }
    if is_piped {
        return piped(&made.text);
    }
    whole_file::write(output, made.text.as_bytes())?;
    print(&format!("{}\n", output.display()))
}

/// The page as it is; a reader that closed the pipe is no error.
fn piped(text: &str) -> Result<(), AppError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(AppError::io("standard output", FileFault::Stream(e)))
        }
        _ => Ok(()),
    }
}

/// The scenario of a result; small copies may have none.
fn scenario(path: &Path) -> Result<String, AppError> {
    Ok(scenario_text(&open(path)?).unwrap_or_default())
}

/// The study of the resolution in the folder that `converge` gives it: beside the result, under its
/// name.
fn study(path: &Path) -> Option<Value> {
    let file = path.with_extension("converge").join(result_files::converge::report::FILE);
    serde_json::from_slice(&std::fs::read(file).ok()?).ok()
}

fn scenes(arguments: &ReportArguments, bar: &ProgressBar) -> Result<Vec<Scene>, AppError> {
    if arguments.no_3d {
        return Ok(Vec::new());
    }
    let n_threads = threads(arguments.threads)?;
    let cache = cache::open(&arguments.cache.settings());
    let wanted = (arguments.bodies.as_slice(), arguments.contact_stress);
    let of_file = |path: &PathBuf| {
        let what = format!("building the bodies of {} again", path.display());
        while_at(bar, what, || scene(path, wanted, (n_threads, &cache)))
    };
    arguments.files.iter().map(of_file).collect()
}

/// The motion of a result. A result whose models cannot be built again has the rest of its report.
fn scene(path: &Path, wanted: (&[String], bool), build: (usize, &ModelCache)) -> Result<Scene, AppError> {
    let motion = States::read(path).and_then(|states| Motion::new(&states, wanted, build));
    match motion {
        Ok(motion) => {
            for left_out in &motion.left_out {
                tracing::warn!("{}: {left_out}", path.display());
            }
            Ok(Scene::Moving(Box::new(motion)))
        }
        // Of the bodies that were asked for.
        Err(error @ AppError::Command(CommandFault::Argument { .. })) => Err(error),
        Err(error) => {
            tracing::warn!("{}: bodies in motion are left out: {error}", path.display());
            Ok(Scene::Without(format!("Bodies in motion are left out: {error}")))
        }
    }
}
