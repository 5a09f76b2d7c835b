//! `fbimpact export`: moving deformed bodies of a result for ParaView.

use std::io;
use std::path::{Path, PathBuf};

use super::{print, threads};
use crate::cli::ExportArguments;
use crate::error::{AppError, CommandFault};
use crate::replay::states::States;
use crate::vtk::assemble::View;
use crate::vtk::bodies::{Bodies, Shown};
use crate::vtk::body::Cells;
use crate::vtk::grid::Grid;
use crate::vtk::pressure::contact_pressures;
use crate::vtk::times::chosen;
use crate::vtk::xml::{SeriesEntry, pvd, write_vtu};
use crate::{error_text, whole_file};

/// Writes a file per body and instant, and the series that opens them all; prints the name of the series.
///
/// # Errors
/// [`AppError::UnknownBody`], [`AppError::Command`] for times that do not exist, [`AppError::Io`] for files, [`AppError::Scenario`] and
/// [`AppError::Model`] if the bodies cannot be built again.
pub fn export(arguments: &ExportArguments) -> Result<(), AppError> {
    if !arguments.set.set.is_empty() {
        return Err(CommandFault::SetOnResult.into());
    }
    let n_threads = threads(arguments.threads)?;
    let states = States::read(&arguments.file)?;
    let instants = chosen(&states.time, (arguments.times, arguments.every), &states.peaks()?)?;
    let cells = if arguments.plain { Cells::Linear(1) } else { Cells::Bezier };
    let mut bodies = Bodies::build(&states, &arguments.bodies, cells, n_threads)?;
    let mut contacts = contact_pressures(&states, &bodies)?;
    let (stem, folder) = folder_of(arguments)?;
    let view = View { scale: arguments.scale, revolve: arguments.revolve };
    let mut series = Vec::new();
    for (number, &i) in instants.iter().enumerate() {
        let time = states.time[i];
        let all = bodies.at(time, i)?;
        for (part, drawn) in all.iter().enumerate() {
            let Shown { name, motion, .. } = drawn.body;
            let grid = drawn.grid(&motion.pose(i), view)?;
            let file = file_name(name, number);
            write_grid(&folder.join(&file), &grid, time)?;
            series.push(SeriesEntry { time, part, name: name.clone(), file: format!("{stem}/{file}") });
        }
        for (k, contact) in contacts.iter_mut().enumerate() {
            let grid = contact.grid(&all[contact.body()], i, view)?;
            // No name has a dot in it.
            let name = format!("{}.pressure", contact.name);
            let file = file_name(&name, number);
            write_grid(&folder.join(&file), &grid, time)?;
            let part = all.len() + k;
            series.push(SeriesEntry { time, part, name, file: format!("{stem}/{file}") });
        }
    }
    if bodies.deviations() > 0 {
        tracing::warn!(
            "at {} of {} instants per contact zone could not be solved again as in the run; the local displacement is left out there",
            bodies.deviations(),
            instants.len()
        );
    }
    write_series(&arguments.vtk, &stem, &series)
}

/// Stem of the file that is shown, and the folder of that name for its parts, created if it is not there.
///
/// # Errors
/// [`AppError::Io`] if it cannot be created.
pub(super) fn folder_of(arguments: &ExportArguments) -> Result<(String, PathBuf), AppError> {
    let stem = arguments.file.file_stem().unwrap_or(arguments.file.as_os_str());
    let stem = stem.to_string_lossy().into_owned();
    let folder = arguments.vtk.join(&stem);
    std::fs::create_dir_all(&folder)
        .map_err(|e| AppError::io(&folder, format!("cannot be created: {}", error_text::of_io(&e))))?;
    Ok((stem, folder))
}

/// Writes one grid.
///
/// # Errors
/// [`AppError::Io`] if that fails.
pub(super) fn write_grid(path: &Path, grid: &Grid, time: f64) -> Result<(), AppError> {
    whole_file::replace(path, |part| write_vtu(part, grid, time)).map_err(|e| unwritten(path, &e))
}

/// The error of a file that cannot be written.
pub(super) fn unwritten(path: &Path, error: &io::Error) -> AppError {
    AppError::io(path, format!("cannot be written: {}", error_text::of_io(error)))
}

fn file_name(name: &str, number: usize) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "._-".contains(c) { c } else { '_' };
    format!("{}_{number:05}.vtu", name.chars().map(safe).collect::<String>())
}

fn write_series(folder: &Path, stem: &str, series: &[SeriesEntry]) -> Result<(), AppError> {
    let path: PathBuf = folder.join(format!("{stem}.pvd"));
    whole_file::write(&path, pvd(series).as_bytes()).map_err(|e| unwritten(&path, &e))?;
    print(&format!("{}\n", path.display()))
}
