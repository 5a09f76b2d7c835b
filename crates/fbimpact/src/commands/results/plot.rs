//! `fbimpact plot`: figures of result files.

use std::path::{Path, PathBuf};

use adaptive::adaptivity::interval::least_utilisation;
use result_files::error::ResultError;
use result_files::file::fault::{Access, FileFault};
use result_files::file::output::Gate;
use result_files::file::whole_file;
use result_files::plot::data::ResultData;
use result_files::plot::drawing::{self, pdf, raster};
use result_files::plot::figure::Figure;
use result_files::plot::figures::Kind;
use result_files::plot::labels::{LONGEST, Labels, by_values};
use result_files::plot::theme::{Page, STYLES};
use result_files::plot::{PlotError, render};
use result_files::stored::scenario_values::Values;

use crate::cli::PlotArguments;
use crate::commands::print;
use crate::error::{AppError, CommandFault};

/// Draws the figures of all files together and prints the names of the files that it writes.
///
/// # Errors
/// [`AppError::Command`] for more files than can be told apart, [`AppError::Io`] for a file that cannot be read or written.
pub fn plot(arguments: &PlotArguments) -> Result<(), AppError> {
    let mut files = labelled(&arguments.files, arguments.labels)?;
    if arguments.from.is_some() || arguments.to.is_some() {
        cut(&mut files, arguments)?;
    }
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).map_err(|e| AppError::system(folder, Access::Create, e))?;
    let prefix = match arguments.files.as_slice() {
        [one] => stem(one),
        _ => "comparison".to_owned(),
    };
    let kinds = if arguments.figure.is_empty() { Kind::USUAL.to_vec() } else { arguments.figure.clone() };
    let mut written = String::new();
    for kind in kinds {
        match kind.figures(&files) {
            Ok(figures) => {
                for figure in figures {
                    for path in write(&figure, folder, &prefix, arguments)? {
                        written += &format!("{}\n", path.display());
                    }
                }
            }
            // Of those that nobody asked for it is no matter.
            Err(reason) if arguments.figure.is_empty() => {
                tracing::info!("no figure of {}: {reason}", name(kind));
            }
            Err(reason) => tracing::warn!("no figure of {}: {reason}", name(kind)),
        }
    }
    print(&written)
}

/// Contents of results that one figure shows together, under the labels that are asked for.
///
/// # Errors
/// [`AppError::Command`] for more files than can be told apart, [`AppError::Io`] for a file that cannot be read.
pub fn labelled(paths: &[PathBuf], wanted: Labels) -> Result<Vec<ResultData>, AppError> {
    if paths.len() > STYLES.len() {
        let (files, most) = (paths.len(), STYLES.len());
        let reason = format!("{files} files in one figure cannot be told apart, name at most {most}");
        return Err(CommandFault::request(reason).into());
    }
    let files = paths.iter().zip(labels(paths)).map(|(path, label)| ResultData::read(path, label));
    let mut files: Vec<ResultData> = files.collect::<Result<_, ResultError>>()?;
    for utilisation in files.iter_mut().filter_map(|file| file.utilisation.as_mut()) {
        utilisation.least.get_or_insert_with(|| least_utilisation(utilisation.target));
    }
    if wanted == Labels::Values {
        let names: Vec<String> = files.iter().map(|file| file.label.clone()).collect();
        let scenarios: Vec<Values> = files.iter().map(|file| file.scenario.clone()).collect();
        for (file, label) in files.iter_mut().zip(by_values(&scenarios, &names)) {
            file.label = label;
        }
    }
    Ok(files)
}

/// Leaves the times that are asked for.
fn cut(files: &mut [ResultData], arguments: &PlotArguments) -> Result<(), AppError> {
    let (from, to) = (arguments.from.unwrap_or(f64::NEG_INFINITY), arguments.to.unwrap_or(f64::INFINITY));
    for file in files {
        // Contents have one instant at least.
        let (first, last) = (file.time[0], file.time[file.time.len() - 1]);
        if !file.cut(from, to) {
            let label = &file.label;
            let reason =
                format!("{label} has no stored state between them, it holds {first:e} s to {last:e} s");
            return Err(CommandFault::argument("--from", format!("{from} --to {to}"), reason).into());
        }
    }
    Ok(())
}

fn name(kind: Kind) -> String {
    format!("{kind:?}").to_lowercase()
}

/// Writes a figure in every wanted format.
fn write(
    figure: &Figure,
    folder: &Path,
    prefix: &str,
    wanted: &PlotArguments,
) -> Result<Vec<PathBuf>, AppError> {
    let path = |end: &str| folder.join(format!("{}_{}.{end}", prefix, file_name(&figure.name)));
    let fail = |path: &Path, e: PlotError| AppError::io(path, FileFault::contents(e));
    let page = Page { width: wanted.width, has_title: !wanted.no_title };
    let svg = render::svg(figure, page).map_err(|e| fail(&path("svg"), e))?;
    let mut files = Vec::new();
    if wanted.svg || !(wanted.png || wanted.pdf) {
        files.push((path("svg"), drawing::marked(&svg).into_bytes()));
    }
    if wanted.png {
        files.push((path("png"), raster::png(&svg).map_err(|e| fail(&path("png"), e))?));
    }
    if wanted.pdf {
        files.push((path("pdf"), pdf::pdf(&svg, &figure.title).map_err(|e| fail(&path("pdf"), e))?));
    }
    let gate = Gate::of_files(&wanted.files, wanted.force);
    files.iter().try_for_each(|(path, _)| gate.check(path, drawing::FIGURE))?;
    for (path, bytes) in &files {
        whole_file::write(path, bytes)?;
    }
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

/// A name that file systems take.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "._-".contains(c) { c } else { '_' }).collect()
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// What legends call the files: their names without the end, with the folder where names are equal.
fn labels(files: &[PathBuf]) -> Vec<String> {
    let is_shared = |path: &PathBuf| files.iter().filter(|other| stem(other) == stem(path)).count() > 1;
    let label = |path: &PathBuf| {
        let full = if is_shared(path) { path.with_extension("").display().to_string() } else { stem(path) };
        let n = full.chars().count();
        if n <= LONGEST {
            full
        } else {
            format!("…{}", full.chars().skip(n - LONGEST + 1).collect::<String>())
        }
    };
    files.iter().map(label).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_name_are_told_apart_by_their_folders() {
        let paths = ["a/run.h5", "b/run.h5", "c/other.h5"].map(PathBuf::from);
        assert_eq!(labels(&paths), ["a/run", "b/run", "other"]);
        let long = labels(&[PathBuf::from("x".repeat(200))]);
        assert_eq!(long[0].chars().count(), LONGEST);
    }
}
