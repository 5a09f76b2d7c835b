//! What an earlier run left of the result that a scenario gives with the files that it names and this program.

use std::path::Path;

use result_files::stored::open::{INPUTS, attribute, of_scenario, open};

use super::file::{linked, restart_path};
use super::journal::{Entries, Entry};
use crate::error::AppError;

/// What is left of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Left {
    /// The result.
    Complete,
    /// A state from which it can be taken up.
    Part,
    /// Nothing of this run.
    Nothing,
}

/// What is left of the run that was to write `target` and follows from `inputs`, see [`crate::scenario::Source`].
///
/// # Errors
/// [`AppError::Io`] if links lead in a circle.
pub fn left(target: &Path, inputs: &str) -> Result<Left, AppError> {
    let target = linked(target)?;
    let is_complete = target.is_file()
        && open(&target).is_ok_and(|file| {
            attribute(&file, "status").as_deref() == Some("complete") && of_scenario(&file, INPUTS) == inputs
        });
    if is_complete {
        return Ok(Left::Complete);
    }
    let restart = restart_path(&target);
    let header = || Entries::open(&restart).and_then(|mut entries| entries.next_entry());
    let is_part = restart.is_file()
        && matches!(header(), Ok(Some(Entry::Header(header))) if header.inputs_sha256 == inputs);
    Ok(if is_part { Left::Part } else { Left::Nothing })
}
