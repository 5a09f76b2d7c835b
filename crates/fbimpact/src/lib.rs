//! The fbimpact program as a library: command line, scenario, run, results.

pub mod process;
pub mod cache;
pub mod interchange;
pub mod scenario;
pub mod error;
pub mod simulate;
pub mod results;
pub mod studies;
pub mod postprocessing;
pub mod cli;
pub mod progress;
pub mod commands;

use std::ffi::OsString;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::FromArgMatches;

use cli::{Cli, Command, Page};
use commands::Means;
use commands::prepare::check::CostFormat;
use error::AppError;
use process::provenance::Build;

/// Parses the command line of an executable, does what it says and returns the exit code. Never ends the process
/// itself: HDF5 files must be closed first.
pub fn main_with(executable: Build, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    executable.tell();
    result_files::file::hdf5_integrity::forbid();
    let matches = cli::tree::command().try_get_matches_from(arguments);
    let cli = match matches.and_then(|mut found| Cli::from_arg_matches_mut(&mut found)) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version go to standard output with code 0, everything else to standard error
            // with code 2.
            let _ = error.print();
            return if error.use_stderr() { ExitCode::from(2) } else { ExitCode::SUCCESS };
        }
    };
    let bar = progress::bar(cli.log);
    progress::log(cli.log, &bar);
    let scenario = cli.command.scenario().map(Path::to_owned);
    let named = |error| match (error, &scenario) {
        (error @ (AppError::Model(_) | AppError::Run(_)), Some(path)) => error.of_scenario(path),
        (error, _) => error,
    };
    match dispatch(cli.command, bar).map_err(named) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            report(&error);
            error.exit_code()
        }
    }
}

fn dispatch(command: Command, bar: indicatif::ProgressBar) -> Result<(), AppError> {
    match command {
        Command::Run(arguments) => commands::run::run(&arguments, bar),
        Command::Static(arguments) => commands::run::equilibrium::equilibrium(arguments, bar),
        Command::Converge(arguments) => commands::converge::converge(&arguments),
        Command::Drop(arguments) => commands::drop::drop(&arguments),
        Command::Check { scenarios, cost, json, threads, set } => {
            let format = match (cost, json) {
                (false, _) => CostFormat::None,
                (true, false) => CostFormat::Table,
                (true, true) => CostFormat::Json,
            };
            commands::prepare::check::check(&scenarios, &set.set, format, Means { threads, bar: &bar })
        }
        Command::Modes { scenario, system: true, is_static, json, threads, cache, set, .. } => {
            let (form, means) = ((is_static, json), Means { threads, bar: &bar });
            commands::prepare::system_modes::system_modes(&scenario, &set.set, form, means, &cache)
        }
        Command::Modes { scenario, body, json, threads, cache, set, .. } => commands::prepare::modes::modes(
            &scenario,
            &set.set,
            body.as_deref(),
            json,
            Means { threads, bar: &bar },
            &cache,
        ),
        Command::Cache { action } => commands::program::cache::cache(&action),
        Command::MeshSize { scenario, body, output, force, set } => {
            let asked = commands::prepare::mesh_size::MeshSize {
                scenario: &scenario,
                body: body.as_deref(),
                output: output.as_deref(),
                force,
            };
            commands::prepare::mesh_size::mesh_size(&asked, &set.set)
        }
        Command::ExportBody { scenario, body, output, force, nurbs: Some(format), units, set, .. } => {
            let export = commands::BodyExport { scenario: &scenario, body: &body, output: &output, force };
            let form = (format, units.metres());
            commands::bodies::splines::export_splines(&export, form, &set.set)
        }
        Command::ExportBody { scenario, body, output, force, full, threads, set, .. } => {
            let export = commands::BodyExport { scenario: &scenario, body: &body, output: &output, force };
            commands::bodies::export::export_body(&export, full, &set.set, Means { threads, bar: &bar })
        }
        Command::ImportBody(arguments) => commands::bodies::import::import_body(&arguments),
        Command::Info { file, json, check } => commands::results::info::info(&file, json, check),
        Command::Compare(arguments) => commands::results::compare::compare(&arguments),
        Command::Thin { file, output, rows, force } => {
            commands::results::thin::thin(&file, &output, rows, force)
        }
        Command::Plot(arguments) => commands::results::plot::plot(&arguments),
        Command::Export(arguments) if arguments.is_of_scenario() => {
            commands::results::export::setup::export_setup(&arguments)
        }
        Command::Export(arguments) => commands::results::export::export(&arguments),
        Command::Report(arguments) => commands::results::report::write_report(&arguments, &bar),
        Command::Probe(arguments) => commands::results::probe::probe(&arguments),
        Command::Schema => commands::print(&scenario::written::schema::text()),
        Command::Reference { page: Page::Scenario } => {
            commands::print(&scenario::written::reference::markdown())
        }
        Command::Reference { page: Page::Results } => commands::print(&results::reference::markdown()),
        Command::Reference { page: Page::Expressions } => {
            commands::print(&result_files::expression::function::markdown())
        }
        Command::Collect { runs, output, force, column, long } => {
            commands::results::collect::collect(&runs, (&output, force), &column, long)
        }
        Command::Metric { file, expressions } => commands::results::metric::metric(&file, &expressions),
        Command::New { name, template, mesh, section, part, force } => {
            let mesh = mesh.as_deref().map(|mesh| (mesh, section));
            commands::prepare::new::new(&name, (template, mesh, &part), force)
        }
        Command::Completions { shell } => commands::program::shell::completions(shell),
        Command::Man { all: Some(folder), force, .. } => commands::program::shell::manuals(&folder, force),
        Command::Man { command, all: None, .. } => commands::program::shell::manual(&command),
    }
}

/// Writes an error to standard error.
fn report(error: &AppError) {
    let is_plain =
        matches!(error, AppError::Scenario(_) | AppError::Differs { .. } | AppError::Unconverged { .. });
    let prefix = if is_plain { "" } else { "error: " };
    // Nothing can be done when standard error is closed.
    let _ =
        writeln!(std::io::stderr(), "{prefix}{}", result_files::words::shown::message(&error.to_string()));
}
