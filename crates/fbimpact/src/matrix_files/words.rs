//! Numbers in a text.

use super::fault::{MatrixError, MatrixFault};

/// Characters of a wrong word that a message shows.
pub const SHOWN: usize = 40;

/// An error on a line.
///
/// # Errors
/// [`MatrixError`], always.
pub fn fail<T>(line: usize, fault: MatrixFault) -> Result<T, MatrixError> {
    Err(MatrixError { line, fault })
}

/// The number `word`.
pub fn number<T: std::str::FromStr>(
    line: usize,
    word: &str,
    expected: &'static str,
) -> Result<T, MatrixError> {
    let found = || word.chars().take(SHOWN).collect();
    word.parse().or_else(|_| fail(line, MatrixFault::Expected { expected, found: found() }))
}

/// A real number, in which Fortran may have written D for the exponent.
pub fn real(line: usize, word: &str) -> Result<f64, MatrixError> {
    let plain: f64 = match word.parse() {
        Ok(x) => x,
        Err(_) => number(line, &word.replace(['d', 'D'], "e"), "a number")?,
    };
    if plain.is_finite() {
        return Ok(plain);
    }
    fail(line, MatrixFault::Expected { expected: "a finite number", found: word.to_owned() })
}

/// A component, which files count from 1.
pub fn component(line: usize, word: &str) -> Result<u8, MatrixError> {
    let expected = "a component, 1 to 6,";
    match number::<u8>(line, word, expected)? {
        n @ 1..=6 => Ok(n - 1),
        n => Err(MatrixError { line, fault: MatrixFault::Expected { expected, found: n.to_string() } }),
    }
}
