//! `fbimpact collect`: results of many runs in one table.

use std::path::{Path, PathBuf};

use crate::collect::{csv, find, gather, hdf5};
use crate::error::AppError;

/// Gathers runs into a table; runs without a readable result are rows with their status.
///
/// # Errors
/// [`AppError::Command`] if the output has another ending than `.csv` and `.h5`, [`AppError::Io`] if a directory cannot be
/// read, the table cannot be written or there is no run at all.
pub fn collect(places: &[PathBuf], output: &Path, is_long: bool) -> Result<(), AppError> {
    let is_csv = match output.extension().and_then(|e| e.to_str()) {
        Some("csv") => true,
        Some("h5" | "hdf5") => false,
        _ => return Err(AppError::Command(format!("-o {}: must end in .csv or .h5", output.display()))),
    };
    let runs = find(places)?;
    if runs.is_empty() {
        return Err(AppError::io(&places[0], "holds no results (.h5) and no traces of runs (.exit, .set)"));
    }
    let table = gather(&runs, is_long);
    // Written aside first: a table is never half there.
    let mut part = output.as_os_str().to_owned();
    part.push(".tmp");
    let part = PathBuf::from(part);
    let written = if is_csv {
        std::fs::write(&part, csv(&table)).map_err(|e| e.to_string())
    } else {
        hdf5(&table, &part).map_err(|e| e.to_string())
    };
    let renamed = written.and_then(|()| std::fs::rename(&part, output).map_err(|e| e.to_string()));
    renamed.map_err(|e| {
        // What cannot be written may not be there to be removed.
        let _ = std::fs::remove_file(&part);
        AppError::io(output, format!("cannot be written: {e}"))
    })?;
    let complete = runs.iter().filter(|r| r.status == "complete").count();
    tracing::info!("{}: {} runs, {complete} complete", output.display(), runs.len());
    Ok(())
}
