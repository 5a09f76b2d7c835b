//! What leads from written files to pictures: a script for ParaView beside them, and films by
//! `pvpython`.

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Shows an export in colours that fit.
const SCRIPT: &str = include_str!("../../../../../scripts/paraview_export.py");
/// The line of the script that says which export it shows.
const SHOWN: &str = "EXPORT = None";
/// Kinds of films, and single pictures.
pub const ENDINGS: [&str; 4] = ["mp4", "avi", "ogv", "png"];
/// Where `pvpython` is, if not on the path.
pub const VARIABLE: &str = "FBIMPACT_PVPYTHON";
/// Lines of what `pvpython` says that an error repeats.
const LINES: usize = 4;

/// The script that shows `export`.
pub fn script(export: &Path) -> String {
    let path = std::path::absolute(export).unwrap_or_else(|_| export.to_owned());
    // A text of JSON is one of Python.
    let text = serde_json::Value::from(path.to_string_lossy().into_owned());
    SCRIPT.replacen(SHOWN, &format!("EXPORT = {text}"), 1)
}

/// The program `pvpython`: what the environment names, or the first on the path.
pub fn pvpython() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os(VARIABLE).filter(|named| !named.is_empty()) {
        return Some(PathBuf::from(named)).filter(|path| path.is_file());
    }
    let name = format!("pvpython{}", std::env::consts::EXE_SUFFIX);
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(&name)).find(|path| path.is_file())
}

/// Films an export by its `script`.
///
/// # Errors
/// A program that cannot be started, or the last lines of what it said when it failed.
pub fn film(pvpython: &Path, script: &Path, movie: &Path) -> io::Result<()> {
    let options: [&OsStr; 4] =
        ["--force-offscreen-rendering".as_ref(), script.as_os_str(), "--movie".as_ref(), movie.as_os_str()];
    let output = Command::new(pvpython).args(options).output()?;
    if output.status.success() {
        return Ok(());
    }
    let said =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    let lines: Vec<&str> = said.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    // A trace of the stack may follow what went wrong.
    let is_error = |line: &&str| line.contains("ERR|") || line.contains("Error");
    let mut told: Vec<&str> = lines.iter().copied().filter(is_error).take(LINES).collect();
    if told.is_empty() {
        told.extend(&lines[lines.len().saturating_sub(LINES)..]);
    }
    let screen = match std::env::var_os("DISPLAY") {
        Some(_) => "",
        None => {
            "; there is no screen (DISPLAY is not set), which some builds of ParaView need: put xvfb-run before the command"
        }
    };
    Err(io::Error::other(format!("pvpython failed ({}): {}{screen}", output.status, told.join("; "))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_name_their_export() {
        assert_eq!(SCRIPT.matches(SHOWN).count(), 1);
        let script = script(Path::new("/tmp/a \"quoted\" folder/x.pvd"));
        assert!(script.contains("EXPORT = \"/tmp/a \\\"quoted\\\" folder/x.pvd\"\n"));
    }
}
