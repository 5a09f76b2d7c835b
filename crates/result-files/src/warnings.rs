//! Warnings in a result file: lines of text, written by the recorder and taken apart for `info` and `collect`.

use hdf5::types::VarLenUnicode;
use hdf5::{File, Result};
use serde_json::{Value, json};

use crate::hdf5_integrity;

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

/// The parts of the warning `line` ([`adaptive::record::warning::Warning::line`]).
pub fn json(line: &str) -> Value {
    let (identifier, rest) = line.split_once(": ").unwrap_or(("", line));
    let (subject, rest) = rest.split_once(": ").unwrap_or(("", rest));
    let (message, remedy) = rest.rsplit_once("; ").unwrap_or((rest, ""));
    json!({ "identifier": identifier, "subject": subject, "message": message, "remedy": remedy })
}

#[cfg(test)]
mod tests {
    use super::*;
    use adaptive::record::warning::{Warning, WarningKind};

    #[test]
    fn a_line_is_taken_apart_as_it_was_put_together() {
        let warning = Warning {
            kind: WarningKind::NeverClosed,
            subject: "contact \"c\"".into(),
            message: "it is open; by 1 m".into(),
            remedy: "wait".into(),
            ..Warning::default()
        };
        let line = warning.line();
        assert_eq!(identifier(&line), "never-closed");
        let parts = json(&line);
        let text = |key: &str| parts[key].as_str().map(str::to_owned);
        assert_eq!(text("identifier").as_deref(), Some("never-closed"));
        assert_eq!(text("subject").as_deref(), Some("contact \"c\""));
        assert_eq!(text("message").as_deref(), Some("it is open; by 1 m"));
        assert_eq!(text("remedy").as_deref(), Some("wait"));
        assert_eq!(json("nothing")["message"], "nothing");
    }
}
