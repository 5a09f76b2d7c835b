//! `fbimpact new`: a commented scenario to start from.

use std::path::{Path, PathBuf};

use crate::error::{AppError, CommandFault};
use crate::file_fault::{Access, OutputFault};
use crate::scenario::schema;
use crate::whole_file;

/// The scenario, with `NAME` for its name.
const STARTER: &str = include_str!("../starter.toml");
/// The schema that the scenario names in its first line.
const SCHEMA: &str = "fbimpact.schema.json";

/// Writes `<name>.toml` and, next to it, the schema for editors if there is none yet.
///
/// # Errors
/// [`AppError::Io`] if the scenario exists and `force` is not set, or if it cannot be written.
pub fn new(name: &Path, force: bool) -> Result<(), AppError> {
    let path = match name.extension() {
        Some(end) if end == "toml" => name.to_owned(),
        _ => {
            let mut name = name.as_os_str().to_owned();
            name.push(".toml");
            PathBuf::from(name)
        }
    };
    let Some(stem) = path.file_stem().map(|s| s.to_string_lossy().into_owned()) else {
        return Err(CommandFault::NoFileName { path: name.to_owned() }.into());
    };
    write(&path, &STARTER.replace("NAME", &stem), force)?
        .then_some(())
        .ok_or_else(|| AppError::io(&path, OutputFault::Exists))?;
    let schema_path = path.with_file_name(SCHEMA);
    if !write(&schema_path, &schema::text(), force)? {
        tracing::debug!("{} is there already", schema_path.display());
    }
    tracing::info!("{} written, next: fbimpact run {}", path.display(), path.display());
    Ok(())
}

/// Writes a file; `false` if it exists and `force` is not set.
fn write(path: &Path, text: &str, force: bool) -> Result<bool, AppError> {
    if !force && path.exists() {
        return Ok(false);
    }
    let written = whole_file::write(path, text.as_bytes());
    written.map(|()| true).map_err(|e| AppError::system(path, Access::Write, e))
}
