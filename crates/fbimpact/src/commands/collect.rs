//! `fbimpact collect`: results of many runs in one table.

use std::io;
use std::path::{Path, PathBuf};

use crate::collect::{csv, find, gather, hdf5};
use crate::error::{AppError, CommandFault};
use crate::{error_text, whole_file};

/// Gathers runs into a table; runs without a readable result are rows with their status.
///
/// # Errors
/// [`AppError::Command`] if the output has another ending than `.csv` and `.h5`, [`AppError::Io`] if a directory cannot be
/// read, the table cannot be written or there is no run at all.
pub fn collect(places: &[PathBuf], output: &Path, is_long: bool) -> Result<(), AppError> {
    let is_csv = match output.extension().and_then(|e| e.to_str()) {
        Some("csv") => true,
        Some("h5" | "hdf5") => false,
        _ => return Err(CommandFault::TableEnding { output: output.to_owned() }.into()),
    };
    let runs = find(places)?;
    if runs.is_empty() {
        return Err(AppError::io(&places[0], "holds no results (.h5) and no traces of runs (.exit, .set)"));
    }
    let table = gather(&runs, is_long);
    // Written aside first: a table is never half there.
    let written = if is_csv {
        whole_file::write(output, csv(&table).as_bytes()).map_err(|e| error_text::of_io(&e))
    } else {
        whole_file::replace(output, |part| {
            hdf5(&table, part).map_err(|e| io::Error::other(error_text::of_hdf5(&e)))
        })
        .map_err(|e| error_text::of_io(&e))
    };
    written.map_err(|reason| AppError::io(output, format!("cannot be written: {reason}")))?;
    let complete = runs.iter().filter(|r| r.status == "complete").count();
    tracing::info!("{}: {} runs, {complete} complete", output.display(), runs.len());
    Ok(())
}
