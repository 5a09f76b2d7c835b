//! `fbimpact collect`: results of many runs in one table.

use std::io;
use std::path::{Path, PathBuf};

use result_files::collect::{CSV_TABLE, HDF5_TABLE, Run, Table, csv, find, gather, hdf5};
use result_files::expression::named::NamedExpression;
use result_files::file::output::Gate;
use result_files::file::{error_text, whole_file};

use crate::error::{AppError, CommandFault};

/// Gathers runs into a table; runs without a readable result are rows with their status.
///
/// # Errors
/// [`AppError::Command`] if the output has another ending than `.csv` and `.h5`, or an expression has no value in any result, [`AppError::Io`] if a directory cannot be
/// read, the table cannot be written or there is no run at all.
pub fn collect(
    places: &[PathBuf],
    (output, force): (&Path, bool),
    columns: &[NamedExpression],
    is_long: bool,
) -> Result<(), AppError> {
    let is_csv = match output.extension().and_then(|e| e.to_str()) {
        Some("csv") => true,
        Some("h5" | "hdf5") => false,
        _ => {
            let given = output.display().to_string();
            return Err(CommandFault::argument("-o", given, "must end in .csv or .h5").into());
        }
    };
    check_names(columns)?;
    let kind = if is_csv { CSV_TABLE } else { HDF5_TABLE };
    Gate::of_files(places, force).check(output, kind)?;
    let runs = find(places, columns)?;
    Gate::of_files(runs.iter().map(|run| &run.file), force).check(output, kind)?;
    if runs.is_empty() {
        return Err(AppError::io(&places[0], "holds no results (.h5) and no traces of runs (.exit, .set)"));
    }
    check_values(&runs, columns)?;
    let table = gather(&runs, is_long);
    check_columns(&table)?;
    // Written aside first: a table is never half there.
    whole_file::make(output, |part| match is_csv {
        true => std::fs::write(part, csv(&table)),
        false => hdf5(&table, part).map_err(|e| io::Error::other(error_text::of_hdf5(&e))),
    })?;
    let complete = runs.iter().filter(|r| r.status == "complete").count();
    tracing::info!("{}: {} runs, {complete} complete", output.display(), runs.len());
    Ok(())
}

/// Refuses two expressions of one name.
fn check_names(columns: &[NamedExpression]) -> Result<(), AppError> {
    let is_there_before =
        |(i, column): (usize, &NamedExpression)| columns[..i].iter().any(|c| c.name == column.name);
    match columns.iter().enumerate().find(|column| is_there_before(*column)) {
        Some((_, twice)) => Err(CommandFault::column_twice(&twice.name).into()),
        None => Ok(()),
    }
}

/// Refuses a column whose name is that of another one.
fn check_columns(table: &Table) -> Result<(), AppError> {
    let mut names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(CommandFault::column_twice(pair[0]).into()),
        None => Ok(()),
    }
}

/// Refuses an expression that has a value in none of the results that there are, and notes those
/// that lack it in some.
fn check_values(runs: &[Run], columns: &[NamedExpression]) -> Result<(), AppError> {
    let readable = runs.iter().filter(|run| run.n_samples.is_some()).count();
    for column in columns {
        let without =
            |run: &'_ Run| run.valueless.iter().find(|(name, _)| *name == column.name).map(|v| v.1.clone());
        let faults: Vec<_> = runs.iter().filter_map(|run| Some((run, without(run)?))).collect();
        let Some((run, fault)) = faults.first() else { continue };
        if faults.len() == readable {
            return Err(CommandFault::Expression { option: "--column", fault: fault.clone() }.into());
        }
        tracing::warn!(
            "column {} is empty in {} of {readable} results, in {} because: {fault}",
            column.name,
            faults.len(),
            run.name
        );
    }
    Ok(())
}
