//! What can be wrong with files of matrices.

use thiserror::Error;

/// A fault and its line.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("line {line}: {fault}")]
pub struct MatrixError {
    /// Line, from 1.
    pub line: usize,
    /// What is wrong there.
    pub fault: MatrixFault,
}

/// What is wrong in a file of a matrix, of nodes or of the order of unknowns.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MatrixFault {
    /// A file without numbers.
    #[error("the file has no {what}; {remedy}")]
    Missing {
        /// What it should have.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Something else was expected.
    #[error("{expected} expected, found \"{found}\"")]
    Expected {
        /// What should stand there.
        expected: &'static str,
        /// What stands there.
        found: String,
    },
    /// Something that a format knows and this program does not.
    #[error("{what} is not read; {remedy}")]
    Unsupported {
        /// What stands there.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Another count than the file says.
    #[error("{found} entries, the header says {expected}; write the file again")]
    Count {
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Something given twice.
    #[error("{what} is given twice")]
    Twice {
        /// What.
        what: String,
    },
}
