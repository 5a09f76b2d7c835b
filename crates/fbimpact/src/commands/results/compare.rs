//! `fbimpact compare`: a result against a reference.

use result_files::compare::{Rules, compare as compare_files};

use crate::cli::CompareArguments;
use crate::commands::print;
use crate::error::AppError;

/// Prints how far a result is from a reference.
///
/// # Errors
/// [`AppError::Differs`] if they differ, [`AppError::Io`] if a file cannot be read, [`AppError::Scenario`] for faults in the
/// tolerance file.
pub fn compare(arguments: &CompareArguments) -> Result<(), AppError> {
    let rules = Rules::read(arguments.tolerances.as_deref(), arguments.rtol, arguments.atol)?;
    let comparison = compare_files(&arguments.new, &arguments.reference, &rules)?;
    for pattern in &comparison.unused {
        tracing::warn!("the pattern \"{pattern}\" of the tolerance file matches nothing in the reference");
    }
    print(&if arguments.json { format!("{:#}\n", comparison.json()) } else { comparison.table() })?;
    match comparison.counts() {
        (0, _) => Ok(()),
        (differing, all) => Err(AppError::Differs { differing, all }),
    }
}
