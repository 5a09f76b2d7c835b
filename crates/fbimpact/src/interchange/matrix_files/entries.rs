//! Entries of a matrix by rows and columns, or by nodes and components.

use super::fault::{MatrixError, MatrixFault};
use super::matrix::{Matrix, Row};
use super::words::{SHOWN, Words, component as component_of, fail, number, real};

/// A matrix in the form of Matrix Market.
///
/// # Errors
/// [`MatrixError`] with the line.
pub fn market(text: &str) -> Result<Matrix, MatrixError> {
    let header = text.lines().next().unwrap_or("").to_ascii_lowercase();
    let words = Words::new(&header, char::is_whitespace);
    let is_read = matches!(
        words.first(),
        [_, "matrix", "coordinate", "real" | "integer" | "double", "general" | "symmetric"]
    );
    if !is_read {
        let what = format!("\"{}\"", header.chars().take(SHOWN * 2).collect::<String>());
        let remedy = "\"matrix coordinate real symmetric\" and \"general\" are";
        return fail(1, MatrixFault::Unsupported { what, remedy });
    }
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, l)| (i + 1, l))
        .filter(|(_, l)| !l.starts_with('%') && !l.trim().is_empty());
    let Some((line, sizes)) = lines.next() else {
        return fail(1, MatrixFault::Missing { what: "sizes", remedy: "write rows, columns and entries" });
    };
    let words = Words::new(sizes, char::is_whitespace);
    let sizes: Vec<u64> =
        words.first().iter().map(|w| number(line, w, "a count")).collect::<Result<_, _>>()?;
    let [rows, columns, expected] = sizes[..] else {
        return fail(
            line,
            MatrixFault::Expected {
                expected: "rows, columns and entries",
                found: format!("{} numbers", words.n),
            },
        );
    };
    if rows != columns {
        let what = format!("a matrix of {rows} rows and {columns} columns");
        return fail(line, MatrixFault::Unsupported { what, remedy: "stiffness and mass are square" });
    }
    let mut entries = Vec::new();
    for (line, text) in lines {
        entries.push(triple(line, Words::new(text, char::is_whitespace).first())?);
    }
    let expected = usize::try_from(expected).unwrap_or(usize::MAX);
    if entries.len() != expected {
        return fail(line, MatrixFault::Count { found: entries.len(), expected });
    }
    Ok(Matrix { format: "Matrix Market", entries, n_rows: Some(rows) })
}

fn triple(line: usize, words: &[&str]) -> Result<(Row, Row, f64), MatrixError> {
    let [row, column, value] = words[..] else {
        let found = words.join(" ").chars().take(SHOWN).collect();
        return fail(line, MatrixFault::Expected { expected: "row, column and value", found });
    };
    let index = |word| match number(line, word, "a number of a row, from 1")? {
        0 => fail(line, MatrixFault::Expected { expected: "a number of a row, from 1", found: "0".into() }),
        n => Ok(Row::Number(n)),
    };
    Ok((index(row)?, index(column)?, real(line, value)?))
}

/// Lines of three or five numbers, with spaces or commas between them.
///
/// # Errors
/// [`MatrixError`] with the line.
pub fn lists(text: &str) -> Result<Matrix, MatrixError> {
    let mut entries = Vec::new();
    let mut first: Option<usize> = None;
    for (i, content) in text.lines().enumerate() {
        let (line, content) = (i + 1, content.trim());
        if content.is_empty() || content.starts_with(['*', '#', '%']) {
            continue;
        }
        let words = Words::new(content, |c| c == ',' || c.is_whitespace());
        let n = *first.get_or_insert(words.n);
        entries.push(match *words.first() {
            [_, _, _] if n == 3 => triple(line, words.first())?,
            [a, b, c, d, value] if n == 5 => (unknown(line, a, b)?, unknown(line, c, d)?, real(line, value)?),
            _ => {
                let expected = if n == 3 {
                    "row, column and value"
                } else {
                    "node, component, node, component and value, or row, column and value"
                };
                let found = content.chars().take(SHOWN).collect();
                return fail(line, MatrixFault::Expected { expected, found });
            }
        });
    }
    if entries.is_empty() {
        let remedy = "a matrix is Matrix Market, lines of row, column and value, of node, component, node, component and value, or DMIG";
        return fail(1, MatrixFault::Missing { what: "entries of a matrix", remedy });
    }
    let format =
        if first == Some(3) { "row, column, value" } else { "node, component, node, component, value" };
    Ok(Matrix { format, entries, n_rows: None })
}

fn unknown(line: usize, node: &str, component: &str) -> Result<Row, MatrixError> {
    let node = number(line, node, "a node")?;
    let component = component_of(line, component)?;
    Ok(Row::Unknown { node, component })
}
