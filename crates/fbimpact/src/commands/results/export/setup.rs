//! `fbimpact export SCENARIO.toml`: what a scenario describes, before any run, for ParaView.

use adaptive::model::Arrangement;

use super::{VTK, folder_of, write_script};
use crate::cli::ExportArguments;
use crate::commands::scenario_file;
use crate::commands::{gate_of, threads};
use crate::error::{AppError, CommandFault};
use crate::postprocessing::vtk::bodies::assemble::View;
use crate::postprocessing::vtk::bodies::splines::Cells;
use crate::postprocessing::vtk::grid::xml::{BlockEntry, vtm, write_vtu};
use crate::postprocessing::vtk::setup::blocks;
use crate::scenario::Scenario;

/// Writes a file per body, joint, contact and load in its place at the start, and the one that
/// opens them all; prints its name.
///
/// # Errors
/// [`AppError::Command`] for options that are for results, [`AppError::Scenario`], [`AppError::Model`] if bodies have no place,
/// [`AppError::Io`] for files.
pub fn export_setup(arguments: &ExportArguments) -> Result<(), AppError> {
    let options = [
        (arguments.times.is_some(), "--times"),
        (arguments.every.is_some(), "--every"),
        (!arguments.bodies.is_empty(), "--bodies"),
        (arguments.movie.is_some(), "--movie"),
        (arguments.scale.to_bits() != 1.0_f64.to_bits(), "--scale"),
    ];
    if let Some((_, option)) = options.into_iter().find(|(is_given, _)| *is_given) {
        let reason =
            format!("{option} is for results; a scenario is shown as it starts, leave the option out");
        return Err(CommandFault::request(reason).into());
    }
    threads(arguments.threads)?;
    let scenario = scenario_file::read(&arguments.file, &arguments.set.set)?;
    let arrangement = arrangement(&scenario)?;
    let cells = if arguments.plain { Cells::Linear(1) } else { Cells::Bezier };
    let view = View { scale: 1.0, revolve: arguments.revolve };
    let blocks = blocks(&scenario, &arrangement, (cells, view))?;
    let gate = gate_of(&scenario, arguments.force);
    let (stem, folder) = folder_of(arguments)?;
    let mut entries = Vec::new();
    for block in &blocks {
        let mut parts = Vec::new();
        for (number, (name, grid)) in block.parts.iter().enumerate() {
            // Names may differ in letters that file names lose.
            let file = format!("{}_{number:03}.vtu", block.name);
            gate.write(&folder.join(&file), VTK, |part| write_vtu(part, grid, 0.0))?;
            parts.push((name.clone(), format!("{stem}/{file}")));
        }
        entries.push(BlockEntry { name: block.name.to_owned(), parts });
    }
    let path = arguments.vtk.join(format!("{stem}.vtm"));
    gate.write(&path, VTK, |part| std::fs::write(part, vtm(&entries)))?;
    write_script(&gate, &path).map(|_| ())
}

/// Where everything stands; with the coordinates as given where loops do not close.
fn arrangement(scenario: &Scenario) -> Result<Arrangement, AppError> {
    match Arrangement::new(&scenario.run) {
        Err(error) if !scenario.run.loops.is_empty() => {
            let given = Arrangement::as_given(&scenario.run).map_err(AppError::model)?;
            tracing::warn!("shown with the joint coordinates as given: {error}");
            Ok(given)
        }
        other => other.map_err(AppError::model),
    }
}
