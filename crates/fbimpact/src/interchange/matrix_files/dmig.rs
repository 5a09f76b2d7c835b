//! Nastran's `DMIG` in punch files: fields of eight characters, with `*` of sixteen.
//!
//! A header `DMIG NAME 0 IFO TIN TOUT …`, then for each column `DMIG NAME GJ CJ - G1 C1 A1 …` and
//! continuations of `Gi Ci Ai`. `IFO` 6 is symmetric, 1 square.

use super::fault::{MatrixError, MatrixFault};
use super::matrix::{Matrix, Row};
use super::words::{self, number, real};

/// Fields of a line that are looked at.
const FIELDS: usize = 9;
/// Names of matrices that a message lists.
const LISTED: usize = 8;

/// Fields of a line: the first of eight characters, the others of `width`.
fn fields(line: &str) -> (Vec<&str>, bool) {
    if line.contains(',') {
        let all: Vec<&str> = line.split(',').map(str::trim).take(FIELDS).collect();
        let is_long = all.first().is_some_and(|f| f.ends_with('*'));
        return (all, is_long);
    }
    let is_long = line.get(..8).unwrap_or(line).trim_end().ends_with('*') || line.starts_with('*');
    let width = if is_long { 16 } else { 8 };
    let mut out = vec![line.get(..8.min(line.len())).unwrap_or("").trim()];
    let mut at = 8;
    let n = if is_long { 4 } else { 8 };
    while at < line.len() && out.len() <= n {
        out.push(line.get(at..(at + width).min(line.len())).unwrap_or("").trim());
        at += width;
    }
    (out, is_long)
}

/// Reads the matrix `name`, or the only one.
pub fn read(text: &str, name: Option<&str>) -> Result<Matrix, MatrixError> {
    let mut names: Vec<String> = Vec::new();
    let mut entries = Vec::new();
    // The column that goes on, and whether it is of the matrix wanted.
    let mut column: Option<Row> = None;
    for (i, content) in text.lines().enumerate() {
        let (line, content) = (i + 1, content.trim_end());
        let fail = |fault| Err(MatrixError { line, fault });
        if content.starts_with('$') || content.is_empty() {
            continue;
        }
        if !content.is_ascii() {
            let found = content.chars().take(40).collect();
            return fail(MatrixFault::Expected { expected: "fields of plain characters", found });
        }
        let (all, _) = fields(content);
        let field = |k: usize| all.get(k).copied().unwrap_or("");
        if all[0].trim_end_matches('*') == "DMIG" {
            column = None;
            let own = field(1).to_ascii_uppercase();
            if names.len() < LISTED && !names.contains(&own) {
                names.push(own.clone());
            }
            if name.is_some_and(|name| !name.eq_ignore_ascii_case(&own)) {
                continue;
            }
            if field(2) == "0" {
                if !matches!(field(3), "1" | "6") || !matches!(field(4), "1" | "2") {
                    let what = format!("a DMIG of form {} and type {}", field(3), field(4));
                    let remedy = "real matrices of form 6 (symmetric) and 1 (square) are";
                    return fail(MatrixFault::Unsupported { what, remedy });
                }
                continue;
            }
            column = Some(unknown(line, field(2), field(3))?);
            if !field(5).is_empty() && column.is_some() {
                entries.push((
                    unknown(line, field(5), field(6))?,
                    unknown(line, field(2), field(3))?,
                    real(line, &exponent(field(7)))?,
                ));
            }
            continue;
        }
        let is_continuation = all[0].is_empty() || all[0].starts_with(['*', '+']);
        if !is_continuation {
            column = None;
            continue;
        }
        let Some(column) = column else { continue };
        // Small lines hold two entries, large ones one.
        for group in [1, 5] {
            if !field(group).is_empty() {
                let row = unknown(line, field(group), field(group + 1))?;
                entries.push((row, column, real(line, &exponent(field(group + 2)))?));
            }
        }
    }
    if name.is_none() && names.len() > 1 {
        let what = format!("a file with the matrices {}", names.join(" and "));
        let remedy = "name one behind the file, as in FILE:NAME";
        return Err(MatrixError { line: 1, fault: MatrixFault::Unsupported { what, remedy } });
    }
    if entries.is_empty() {
        let remedy = "name another behind the file, as in FILE:NAME";
        return Err(MatrixError {
            line: 1,
            fault: MatrixFault::Missing { what: "entries of that DMIG", remedy },
        });
    }
    Ok(Matrix { format: "DMIG", entries, n_rows: None })
}

/// The number with an exponent as Nastran may leave its letter out: `1.5-7`.
fn exponent(word: &str) -> String {
    let bytes = word.as_bytes();
    let at = (1..bytes.len())
        .find(|&k| matches!(bytes[k], b'+' | b'-') && bytes[k - 1].is_ascii_digit() | (bytes[k - 1] == b'.'));
    match at {
        Some(at) => format!("{}e{}", &word[..at], &word[at..]),
        None => word.to_owned(),
    }
}

fn unknown(line: usize, node: &str, component: &str) -> Result<Row, MatrixError> {
    let node = number(line, node, "a grid point")?;
    if component == "0" {
        let what = format!("point {node} without components, a modal coordinate,");
        let remedy = "a full matrix has displacements only; write the matrices before their reduction";
        return Err(MatrixError { line, fault: MatrixFault::Unsupported { what, remedy } });
    }
    Ok(Row::Unknown { node, component: words::component(line, component)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_and_short_fields() {
        let long = "$ punch\nDMIG    KAAX           0       6       1       0\n\
            DMIG*   KAAX                           1               1\n\
            *                      1               1 2.500000000D+02\n\
            DMIG*   KAAX                           2               3\n\
            *                      1               1-1.250000000D+02\n\
            *                      2               3 4.000000000D+02\n";
        let short = "DMIG    KAAX    0       6       1       0\n\
            DMIG    KAAX    1       1               1       1       250.\n\
            DMIG    KAAX    2       3               1       1       -1.25+2\n\
            +               2       3       400.\n";
        let a = read(long, None).expect("a matrix");
        let short = short.replace("+               2       3       400.", "+       2       3       400.");
        assert_eq!(a, read(&short, Some("kaax")).expect("a matrix"));
        assert_eq!(a.entries.len(), 3);
        let two = long.to_owned() + &long.replace("KAAX", "MAAX");
        assert!(read(&two, None).expect_err("two").to_string().contains("KAAX and MAAX"));
        assert_eq!(read(&two, Some("MAAX")).expect("a matrix").entries.len(), 3);
    }

    #[test]
    fn faults_name_the_line() {
        for (text, words) in [
            ("DMIG    KAAX    0       2       1\n", &["line 1", "form 2"][..]),
            ("DMIG    KAAX    0       6       3\n", &["line 1", "type 3"]),
            (
                "DMIG    KAAX    1       0               1       1       250.\n",
                &["line 1", "modal coordinate"],
            ),
            (
                "DMIG    KAAX    1       1               1       1       2x.\n",
                &["line 1", "a number expected"],
            ),
            ("DMIG    KAAX    0       6       1\n", &["no entries of that DMIG"]),
        ] {
            let text = read(text, None).expect_err(text).to_string();
            assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
        }
    }
}
