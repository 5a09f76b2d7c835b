//! Reading a matrix of any form.

use super::fault::MatrixError;
use super::matrix::Matrix;
use super::{dmig, entries};

/// Reads a matrix; `name` is that of the matrix in files that have several.
///
/// Matrix Market (`coordinate real`, `general` or `symmetric`); Abaqus' `matrix input` (node,
/// component, node, component, value) and `coordinate` (row, column, value), which CalculiX writes
/// too; Nastran's `DMIG` in the fields of bulk data, small or large.
///
/// # Errors
/// [`MatrixError`] with the line.
pub fn read_matrix(text: &str, name: Option<&str>) -> Result<Matrix, MatrixError> {
    if text.starts_with("%%MatrixMarket") {
        return entries::market(text);
    }
    if text.lines().any(|line| line.starts_with("DMIG")) {
        return dmig::read(text, name);
    }
    entries::lists(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_are_told_apart() {
        for (text, format) in [
            (
                "%%MatrixMarket matrix coordinate real symmetric\n% c\n3 3 2\n1 1 2.5\n3 1 -1d0\n",
                "Matrix Market",
            ),
            ("1 1  2.5\n3 1 -1\n", "row, column, value"),
            ("1,1, 1,1, 2.5\n7,3, 1,1, -1.\n", "node, component, node, component, value"),
        ] {
            let matrix = read_matrix(text, None).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!((matrix.format, matrix.entries.len()), (format, 2));
            assert!((matrix.entries[0].2 - 2.5).abs() < 1e-15 && (matrix.entries[1].2 + 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn faults_name_line_and_remedy() {
        for (text, words) in [
            ("", &["line 1", "no entries of a matrix", "Matrix Market"][..]),
            ("1 1 2\n1 x 2\n", &["line 2", "a number of a row", "\"x\""]),
            ("1 1 2\n0 1 2\n", &["line 2", "from 1"]),
            ("1 1 2\n1 1\n", &["line 2", "row, column and value expected"]),
            ("1 1 nan\n", &["line 1", "a finite number"]),
            ("1,9,1,1,2\n", &["line 1", "1 to 6"]),
            ("%%MatrixMarket matrix array real general\n", &["line 1", "array", "coordinate real symmetric"]),
            ("%%MatrixMarket matrix coordinate real general\n2 3 1\n1 1 1\n", &["2 rows and 3 columns"]),
            (
                "%%MatrixMarket matrix coordinate real general\n2 2 5\n1 1 1\n",
                &["1 entries, the header says 5"],
            ),
        ] {
            let text = read_matrix(text, None).expect_err(text).to_string();
            assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
        }
    }
}
