//! What can be wrong with a file of splines.

use thiserror::Error;

use crate::SplineError;

/// A fault and its line.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("line {line}: {fault}")]
pub struct ReadError {
    /// Line, from 1.
    pub line: usize,
    /// What is wrong there.
    pub fault: ReadFault,
}

/// What is wrong in a file of splines.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ReadFault {
    /// None of the formats.
    #[error(
        "neither XML of G+Smo, which begins with \"<\", nor a mesh that begins with \"MFEM NURBS mesh v1.0\""
    )]
    Format,
    /// Bytes that are no text.
    #[error("not text; write the file in its text form")]
    NoText,
    /// XML that is none.
    #[error("no XML that can be read: {reason}")]
    Xml {
        /// Why.
        reason: String,
    },
    /// The file ends too early.
    #[error("the file ends within {section}; write it again")]
    End {
        /// What was being read.
        section: String,
    },
    /// Something else was expected.
    #[error("{expected} expected in {section}, found \"{found}\"")]
    Expected {
        /// What should stand there.
        expected: &'static str,
        /// What is being read.
        section: String,
        /// What stands there.
        found: String,
    },
    /// Another count of numbers than others ask for.
    #[error("{what}: {found} found, {expected} are needed")]
    Count {
        /// The list of numbers.
        what: String,
        /// How many there are.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// Something without which there is no patch.
    #[error("no {what}; {remedy}")]
    Missing {
        /// What is missing.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Something that the format knows and this program does not.
    #[error("{what} is not read; {remedy}")]
    Unsupported {
        /// What stands there.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A number that names nothing.
    #[error("{user} names {what} {number}, which the file does not have")]
    Unknown {
        /// Who names it.
        user: String,
        /// "vertex", "geometry" …
        what: &'static str,
        /// The number.
        number: String,
    },
    /// Edges of a patch that run along the same direction with different knots.
    #[error(
        "edges of patch {patch} along {direction} have different knots; write the mesh in its form with patches"
    )]
    Edges {
        /// Number of the patch, from 0.
        patch: usize,
        /// Name of the direction.
        direction: &'static str,
    },
    /// A patch that is none.
    #[error(transparent)]
    Spline(#[from] SplineError),
}
