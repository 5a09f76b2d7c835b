//! Numbers in a text.

use super::fault::{MatrixError, MatrixFault};

/// Characters of a wrong word that a message shows.
pub const SHOWN: usize = 40;

/// Words of a line that are kept: one more than any line here has.
const KEPT: usize = 6;

/// The words of a line, of which there may be any number.
#[derive(Debug, Default)]
pub struct Words<'a> {
    first: [&'a str; KEPT],
    /// How many there are.
    pub n: usize,
}

impl<'a> Words<'a> {
    /// `text` cut where `is_between`.
    pub fn new(text: &'a str, is_between: impl Fn(char) -> bool) -> Self {
        let mut words = Self::default();
        for word in text.split(is_between).filter(|w| !w.is_empty()) {
            if let Some(place) = words.first.get_mut(words.n) {
                *place = word;
            }
            words.n += 1;
        }
        words
    }

    /// The first of them, all unless there are too many.
    pub fn first(&self) -> &[&'a str] {
        &self.first[..self.n.min(KEPT)]
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_keeps_its_first_words_and_their_number() {
        let words = Words::new(" a,,b  c", |c| c == ',' || c.is_whitespace());
        assert_eq!((words.first(), words.n), (&["a", "b", "c"][..], 3));
        let long = "1 ".repeat(50);
        let words = Words::new(&long, char::is_whitespace);
        assert_eq!((words.first().len(), words.n), (KEPT, 50));
    }
}
