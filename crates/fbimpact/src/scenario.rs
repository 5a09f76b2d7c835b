//! The scenario file: from TOML text to a validated [`Scenario`], with every fault located.
//!
//! One set of key tables ([`tables`]) declares every key. The reader (`check`), the JSON schema
//! ([`mod@schema`]), the reference page ([`mod@reference`]) and the check of conditions under which
//! keys have a meaning (`conditions`) follow from it; `build` adds the checks of values that
//! involve several keys.

pub mod types;
pub mod body_places;
pub mod overrides;
pub mod keys;
pub mod tables;
pub mod section;
mod check;
mod body_files;
mod curve_files;
mod body_source;
mod spline_nets;
mod standard_materials;
mod units;
mod build;
mod conditions;
mod resolved;
pub mod schema;
pub mod reference;

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use result_files::file::fault::Access;
use result_files::file::plain_file;
use result_files::toml_text::document::{self, Origin, SourceText, Value};
use sha2::{Digest, Sha256};

use crate::error::AppError;
use check::Checker;

pub use overrides::{Override, OverrideFault};
pub use result_files::toml_text::fault::{Fault, Faults};
pub use types::{Compression, FileBody, FileOfBody, Scenario, Source};

/// Reads and validates the scenario file `path` with `overrides` applied.
///
/// # Errors
/// [`AppError::Io`] if the file cannot be read, [`AppError::Scenario`] with all faults otherwise.
pub fn read(path: &Path, overrides: &[Override]) -> Result<Scenario, AppError> {
    let bytes = plain_file::read(path).map_err(|e| AppError::system(path, Access::Read, e))?;
    Ok(parse(path, &bytes, overrides)?)
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
    Ok(parse(name, &bytes, overrides)?)
}

/// Validates a scenario given as text; `path` is for messages, and files are sought in its
/// directory.
///
/// # Errors
/// All faults of the scenario.
pub fn parse(path: &Path, bytes: &[u8], overrides: &[Override]) -> Result<Scenario, Faults> {
    let mut checker = Checker::default();
    let source = Arc::new(SourceText {
        name: path.display().to_string(),
        text: String::from_utf8_lossy(bytes).into_owned(),
    });
    if let Err(error) = std::str::from_utf8(bytes) {
        let at = error.valid_up_to();
        let message = "the file must be UTF-8 text".to_owned();
        checker.fault(&Origin::File(source, at..at + 1), String::new(), None, message);
        return Err(Faults::new(checker.faults));
    }
    let mut document = document::parse_toml(&source).map_err(Faults::new)?;
    for change in overrides {
        if let Err(fault) = change.apply(&mut document) {
            checker.faults.push(*fault);
        }
    }
    standard_materials::fill(&mut document);
    let Value::Table(entries) = &document.value else { unreachable!("a TOML document is a table") };
    let mut root = checker.section(tables::SCENARIO, entries, "", &document.origin, None);
    let directory = path.parent().unwrap_or(Path::new("."));
    body_files::read_all(&mut checker, &mut root, directory);
    curve_files::read_all(&mut checker, &mut root, directory);
    conditions::check(&mut checker, conditions::Scope::of(&root));
    let resolved = if checker.faults.is_empty() { resolved::write(&root) } else { String::new() };
    let source = Source { path: path.to_owned(), sha256: hex(&Sha256::digest(bytes)), resolved };
    match build::scenario(&mut checker, &root, source) {
        Some(scenario) if checker.faults.is_empty() => Ok(scenario),
        _ => {
            debug_assert!(!checker.faults.is_empty(), "a scenario that is not built has a fault");
            Err(Faults::new(checker.faults))
        }
    }
}

/// Hexadecimal digits of `bytes`.
fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
