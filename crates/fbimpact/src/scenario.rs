//! The scenario file: from TOML text to a validated [`Scenario`], with every fault located.
//!
//! One set of key tables ([`tables`]) declares every key. The reader (`check`), the JSON schema
//! ([`mod@written::schema`]), the reference page ([`mod@written::reference`]) and the check of conditions under which
//! keys have a meaning (`conditions`) follow from it; `build` adds the checks of values that
//! involve several keys.

pub mod body_places;
pub mod types;
pub mod keys;
pub mod tables;
mod body_source;
pub mod section;
mod check;
pub mod changes;
mod files;
mod build;
mod conditions;
pub mod written;

use std::path::Path;
use std::sync::Arc;

use result_files::toml_text::document::{self, Origin, SourceText, Value};
use sha2::{Digest, Sha256};

use crate::process::provenance;
use changes::expanded::Expanded;
use check::Checker;

pub use changes::overrides::Override;
pub use files::bodies::mesh_parts;
pub use result_files::toml_text::fault::{Fault, Faults};
pub use types::{Compression, FileBody, FileOfBody, Scenario, Source};

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
        return Err(Faults::new(checker.faults.take()));
    }
    let mut document = document::parse_toml(&source).map_err(Faults::new)?;
    for change in overrides {
        if let Err(fault) = change.apply(&mut document) {
            checker.faults.push(*fault);
        }
    }
    changes::standard_materials::fill(&mut document);
    let expanded = Expanded::new(&mut checker, &mut document);
    let Value::Table(entries) = &document.value else { unreachable!("a TOML document is a table") };
    let mut root = checker.section(tables::SCENARIO, entries, "", &document.origin, None);
    let directory = path.parent().unwrap_or(Path::new("."));
    files::bodies::read_all(&mut checker, &mut root, directory);
    files::curves::read_all(&mut checker, &mut root, directory);
    // Of a copy, for what these two ask for is not used yet.
    let copy = root.clone();
    conditions::check(conditions::Scope::of(&copy));
    let resolved = if checker.faults.is_empty() { written::resolved::write(&copy) } else { String::new() };
    let source = Source {
        path: path.to_owned(),
        sha256: hex(&Sha256::digest(bytes)),
        inputs_sha256: hex(&Sha256::new()
            .chain_update(provenance::hash())
            .chain_update(&resolved)
            .finalize()),
        resolved,
    };
    let scenario = build::scenario(&mut checker, &root, source);
    if scenario.is_some() {
        // A material may be described of which no body is made, or whose stiffness rigid ones leave out.
        let is_material = |path: &str| path.split('.').next() == Some("materials");
        for (section, key) in root.unasked().into_iter().filter(|(s, key)| !is_material(&s.path_of(key))) {
            let message = "nothing that the scenario describes depends on it: take it out".to_owned();
            section.fault(key, message);
        }
    }
    match scenario {
        Some(scenario) if checker.faults.is_empty() => {
            let doubts = files::curve_doubts::of_all(&copy, scenario.run.settings.end_time);
            Ok(Scenario { doubts, ..scenario })
        }
        _ => {
            debug_assert!(!checker.faults.is_empty(), "a scenario that is not built has a fault");
            Err(Faults::new(expanded.told(checker.faults.take())))
        }
    }
}

/// Hexadecimal digits of `bytes`.
fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
