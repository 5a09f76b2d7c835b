//! What is wrong with an expression.

/// Why an expression has no value, and where in its text that shows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text}: column {}: {message}", at + 1)]
pub struct ExpressionFault {
    /// The expression.
    pub text: String,
    /// Number of the character, from 0.
    pub at: usize,
    /// What is wrong, and what would be right.
    pub message: String,
}

/// A fault before the whole text is known: the place and what is wrong.
pub type FaultAt = (usize, String);

impl ExpressionFault {
    /// The fault `found` in `text`.
    pub fn new(text: &str, (at, message): FaultAt) -> Self {
        Self { text: text.to_owned(), at, message }
    }
}
