//! `fbimpact check`: reads and validates, builds nothing.

use std::path::PathBuf;

use super::threads;
use crate::error::AppError;
use crate::scenario::{self, Override};

/// Checks every file and reports the faults of all.
///
/// # Errors
/// [`AppError::Model`] if the threads cannot be started. The last error; those before it have been reported.
pub fn check(scenarios: &[PathBuf], overrides: &[Override]) -> Result<(), AppError> {
    // Body files are checked with linear algebra.
    threads(0)?;
    let mut last = None;
    for path in scenarios {
        match scenario::read(path, overrides) {
            Ok(scenario) => tracing::info!(
                "{}: valid, {} bodies, {} joints, {} contacts",
                path.display(),
                scenario.bodies.len(),
                scenario.joints.len(),
                scenario.contacts.len()
            ),
            Err(error) => {
                if let Some(previous) = last.replace(error) {
                    crate::report(&previous);
                }
            }
        }
    }
    last.map_or(Ok(()), Err)
}
