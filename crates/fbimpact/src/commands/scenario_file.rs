//! The scenario file that a command names, or standard input.

use std::io::Read;
use std::path::Path;

use result_files::file::fault::Access;
use result_files::file::plain_file;
use result_files::words::shown::for_shell;

use crate::error::AppError;
use crate::scenario::{self, Override, Scenario};

/// Reads and validates the scenario file `path` with `overrides` applied.
///
/// # Errors
/// [`AppError::Io`] if the file cannot be read, [`AppError::Scenario`] with all faults otherwise.
pub fn read(path: &Path, overrides: &[Override]) -> Result<Scenario, AppError> {
    let bytes = plain_file::read(path).map_err(|e| AppError::system(path, Access::Read, e))?;
    if bytes.starts_with(b"\x89HDF\r\n\x1a\n") {
        let name = for_shell(path);
        let reason = format!(
            "is HDF5 and no scenario; of a result: fbimpact info {name}, fbimpact report {name}, or fbimpact run --resume {name}"
        );
        return Err(AppError::io(path, reason));
    }
    parsed(path, &bytes, overrides)
}

/// The scenario, after a word on what may be meant otherwise.
fn parsed(name: &Path, bytes: &[u8], overrides: &[Override]) -> Result<Scenario, AppError> {
    let scenario = scenario::parse(name, bytes, overrides)?;
    scenario.doubts.iter().for_each(|doubt| tracing::warn!("{doubt}"));
    Ok(scenario)
}

/// Name of standard input in messages.
const STANDARD_INPUT: &str = "standard input";

/// Reads and validates a scenario from standard input if `path` is `-`, else as [`read`]. Files
/// that it names are sought in the working directory.
///
/// # Errors
/// As [`read`].
pub fn read_or_input(path: &Path, overrides: &[Override]) -> Result<Scenario, AppError> {
    if path != Path::new("-") {
        return read(path, overrides);
    }
    let (name, mut bytes) = (Path::new(STANDARD_INPUT), Vec::new());
    std::io::stdin().lock().read_to_end(&mut bytes).map_err(|e| AppError::system(name, Access::Read, e))?;
    parsed(name, &bytes, overrides)
}
