//! The fbimpact program as a library: command line, scenario, run, results.

pub mod allocation;
pub mod error;
pub mod provenance;
pub mod scenario;
pub mod thread_pool;
pub mod sizing;
mod one_body;
pub mod simulate;
pub mod results;
pub mod body_file;
pub mod matrix_files;
pub mod cache;
pub mod converge;
pub mod replay;
pub mod vtk;
pub mod probe;
pub mod report;
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
use commands::check::CostFormat;
use error::AppError;

/// Parses the command line, does what it says and returns the exit code. Never ends the process
/// itself: HDF5 files must be closed first.
pub fn main_with(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
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
        Command::Converge(arguments) => commands::converge::converge(&arguments),
        Command::Check { scenarios, cost, json, threads, set } => {
            let format = match (cost, json) {
                (false, _) => CostFormat::None,
                (true, false) => CostFormat::Table,
                (true, true) => CostFormat::Json,
            };
            commands::check::check(&scenarios, &set.set, format, Means { threads, bar: &bar })
        }
        Command::Modes { scenario, system: true, is_static, json, threads, cache, set, .. } => {
            let form = (is_static, json);
            commands::system_modes::system_modes(
                &scenario,
                &set.set,
                form,
                Means { threads, bar: &bar },
                &cache,
            )
        }
        Command::Modes { scenario, body, json, threads, cache, set, .. } => commands::modes::modes(
            &scenario,
            &set.set,
            body.as_deref(),
            json,
            Means { threads, bar: &bar },
            &cache,
        ),
        Command::Cache { action } => commands::cache::cache(&action),
        Command::MeshSize { scenario, body, output, set } => {
            let asked = commands::mesh_size::MeshSize {
                scenario: &scenario,
                body: body.as_deref(),
                output: output.as_deref(),
            };
            commands::mesh_size::mesh_size(&asked, &set.set)
        }
        Command::ExportBody { scenario, body, output, nurbs: Some(format), units, set, .. } => {
            let export = commands::BodyExport { scenario: &scenario, body: &body, output: &output };
            let form = (format, units.metres());
            commands::export_splines::export_splines(&export, form, &set.set)
        }
        Command::ExportBody { scenario, body, output, full, threads, set, .. } => {
            let export = commands::BodyExport { scenario: &scenario, body: &body, output: &output };
            commands::export_body::export_body(&export, full, &set.set, Means { threads, bar: &bar })
        }
        Command::ImportBody(arguments) => commands::import_body::import_body(&arguments),
        Command::Info { file, json } => commands::info::info(&file, json),
        Command::Compare(arguments) => commands::compare::compare(&arguments),
        Command::Thin { file, output, rows, force } => commands::thin::thin(&file, &output, rows, force),
        Command::Plot(arguments) => commands::plot::plot(&arguments),
        Command::Export(arguments) if arguments.is_of_scenario() => {
            commands::export_setup::export_setup(&arguments)
        }
        Command::Export(arguments) => commands::export::export(&arguments),
        Command::Report(arguments) => commands::report::write_report(&arguments),
        Command::Probe(arguments) => commands::probe::probe(&arguments),
        Command::Schema => commands::print(&scenario::schema::text()),
        Command::Reference { page: Page::Scenario } => commands::print(&scenario::reference::markdown()),
        Command::Reference { page: Page::Results } => commands::print(&results::reference::markdown()),
        Command::Reference { page: Page::Expressions } => {
            commands::print(&result_files::expression::function::markdown())
        }
        Command::Collect { runs, output, column, long } => {
            commands::collect::collect(&runs, &output, &column, long)
        }
        Command::Metric { file, expressions } => commands::metric::metric(&file, &expressions),
        Command::New { name, template, force } => commands::new::new(&name, template, force),
        Command::Completions { shell } => commands::shell::completions(shell),
        Command::Man { all: Some(folder), .. } => commands::shell::manuals(&folder),
        Command::Man { command, all: None } => commands::shell::manual(&command),
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
