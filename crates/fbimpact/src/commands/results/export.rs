//! `fbimpact export`: moving deformed bodies of a result for ParaView.

pub mod setup;

use std::path::{Path, PathBuf};

use result_files::file::fault::{Access, FileFault};
use result_files::file::output::{Gate, Kind};
use result_files::words::shown::for_shell;

use crate::cache;
use crate::cli::ExportArguments;
use crate::commands::{print, threads};
use crate::error::{AppError, CommandFault};
use crate::postprocessing::replay::states::States;
use crate::postprocessing::vtk::bodies::assemble::View;
use crate::postprocessing::vtk::bodies::splines::Cells;
use crate::postprocessing::vtk::bodies::{Bodies, Shown};
use crate::postprocessing::vtk::grid::xml::{MARK, SeriesEntry, pvd, write_vtu};
use crate::postprocessing::vtk::paraview;
use crate::postprocessing::vtk::pressure::contact_pressures;
use crate::postprocessing::vtk::times::chosen;

/// Grids, and files that list them.
const VTK: Kind = Kind::marked("a file for ParaView that fbimpact wrote", MARK);
/// What shows them.
const SCRIPT: Kind =
    Kind::marked("the script that fbimpact writes", "\"\"\"Shows an export of `fbimpact export` in ParaView");
/// Up to so many instants are listed one by one.
const TOLD: usize = 8;

/// Writes a file per body and instant, and the series that opens them all; prints the name of the
/// series.
///
/// # Errors
/// [`AppError::Command`] for a body that there is not and for times that do not exist, [`AppError::Io`] for files, [`AppError::Scenario`] and
/// [`AppError::Model`] if the bodies cannot be built again.
pub fn export(arguments: &ExportArguments) -> Result<(), AppError> {
    if !arguments.set.set.is_empty() {
        return Err(CommandFault::request(
            "--set changes scenarios; a result is as its scenario was, leave the option out or name a scenario",
        )
        .into());
    }
    let n_threads = threads(arguments.threads)?;
    let gate = Gate::of_files([&arguments.file], arguments.force);
    if let Some(movie) = &arguments.movie {
        gate.check(movie, Kind::unmarked("known for a film of this program"))?;
    }
    let pvpython = arguments.movie.as_deref().map(movie_maker).transpose()?;
    let states = States::read(&arguments.file)?;
    let instants = chosen(&states.time, (arguments.times, arguments.every), &states.peaks()?)?;
    tell_instants(&states.time, &instants);
    let cells = if arguments.plain { Cells::Linear(1) } else { Cells::Bezier };
    let cache = cache::open(&arguments.cache.settings());
    let mut bodies = Bodies::build(&states, &arguments.bodies, cells, (n_threads, &cache))?;
    for left_out in bodies.left_out() {
        tracing::warn!("{left_out}");
    }
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
            gate.write(&folder.join(&file), VTK, |part| write_vtu(part, &grid, time))?;
            series.push(SeriesEntry { time, part, name: name.clone(), file: format!("{stem}/{file}") });
        }
        for (k, contact) in contacts.iter_mut().enumerate() {
            let grid = contact.grid(&all[contact.body()], i, view)?;
            // No name has a dot in it.
            let name = format!("{}.pressure", contact.name);
            let file = file_name(&name, number);
            gate.write(&folder.join(&file), VTK, |part| write_vtu(part, &grid, time))?;
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
    let path = arguments.vtk.join(format!("{stem}.pvd"));
    gate.write(&path, VTK, |part| std::fs::write(part, pvd(&series)))?;
    let shown = write_script(&gate, &path)?;
    if let (Some(pvpython), Some(movie)) = (pvpython, &arguments.movie) {
        tracing::info!("{} is made by {}", movie.display(), pvpython.display());
        paraview::film(&pvpython, &shown, movie)
            .map_err(|e| AppError::io(movie, FileFault::Unmade(e.into())))?;
        print(&format!("{}\n", movie.display()))?;
    }
    Ok(())
}

/// The program that makes the film `movie`.
fn movie_maker(movie: &Path) -> Result<PathBuf, AppError> {
    let ending = movie.extension().unwrap_or_default();
    if !paraview::ENDINGS.iter().any(|known| ending == *known) {
        let reason = format!("must end in .{}", paraview::ENDINGS.join(", ."));
        return Err(CommandFault::argument("--movie", movie.display().to_string(), reason).into());
    }
    paraview::pvpython().ok_or_else(|| {
        let variable = paraview::VARIABLE;
        CommandFault::request(format!(
            "--movie needs pvpython, which comes with ParaView 5.10 or later: put its folder on PATH, or its path into {variable}; or leave --movie out, open the export in ParaView and save an animation there"
        ))
        .into()
    })
}

/// Says which stored instants are written: all of a few, or how many from when to when.
fn tell_instants(time: &[f64], instants: &[usize]) {
    let at = |i: &usize| format!("{:e}", time[*i]);
    match instants {
        [first, .., last] if instants.len() > TOLD => {
            tracing::info!(
                "{} of {} stored instants, {} s to {} s",
                instants.len(),
                time.len(),
                at(first),
                at(last)
            );
        }
        _ => {
            let times: Vec<String> = instants.iter().map(at).collect();
            tracing::info!("{} of {} stored instants: {} s", instants.len(), time.len(), times.join(", "));
        }
    }
}

/// Stem of the file that is shown, and the folder of that name for its parts, created if it is not
/// there.
///
/// # Errors
/// [`AppError::Io`] if it cannot be created.
fn folder_of(arguments: &ExportArguments) -> Result<(String, PathBuf), AppError> {
    let stem = arguments.file.file_stem().unwrap_or(arguments.file.as_os_str());
    let stem = stem.to_string_lossy().into_owned();
    let folder = arguments.vtk.join(&stem);
    std::fs::create_dir_all(&folder).map_err(|e| AppError::system(&folder, Access::Create, e))?;
    Ok((stem, folder))
}

fn file_name(name: &str, number: usize) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "._-".contains(c) { c } else { '_' };
    format!("{}_{number:05}.vtu", name.chars().map(safe).collect::<String>())
}

/// Writes the script that shows `export` into the folder of its parts, and prints the name of the
/// export.
///
/// # Errors
/// [`AppError::Io`] if that fails.
fn write_script(gate: &Gate, export: &Path) -> Result<PathBuf, AppError> {
    let path = export.with_extension("").join("show.py");
    gate.write(&path, SCRIPT, |part| std::fs::write(part, paraview::script(export)))?;
    tracing::info!("in colours that fit: paraview --script={}", for_shell(&path));
    print(&format!("{}\n", export.display()))?;
    Ok(path)
}
