//! Warnings in a result file: lines of text, written by the recorder and taken apart for `info` and
//! `collect`.

use hdf5::types::VarLenUnicode;
use hdf5::{File, Result};
use serde_json::{Value, json};

use crate::file::hdf5_integrity;

/// Lines of `/warnings`; none in files of earlier versions.
///
/// # Errors
/// Those of HDF5.
pub fn read(file: &File) -> Result<Vec<String>> {
    if !file.link_exists("warnings") {
        return Ok(Vec::new());
    }
    let lines: Vec<VarLenUnicode> = hdf5_integrity::rows(&file.dataset("warnings")?)?;
    Ok(lines.iter().map(|line| line.as_str().to_owned()).collect())
}

/// Identifier of the warning `line`.
pub fn identifier(line: &str) -> &str {
    line.split_once(": ").map_or(line, |(identifier, _)| identifier)
}

/// The parts of the warning `line` (`identifier: subject: message; remedy`).
pub fn json(line: &str) -> Value {
    let (identifier, rest) = line.split_once(": ").unwrap_or(("", line));
    let (subject, rest) = rest.split_once(": ").unwrap_or(("", rest));
    let (message, remedy) = rest.rsplit_once("; ").unwrap_or((rest, ""));
    json!({ "identifier": identifier, "subject": subject, "message": message, "remedy": remedy })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_without_parts_is_a_message() {
        assert_eq!(json("nothing")["message"], "nothing");
    }
}
