//! Words of a text with the lines on which they stand.

use super::fault::{ReadError, ReadFault};

/// Characters of a wrong word that a message shows.
const SHOWN: usize = 40;

/// A text and the place that has been reached.
pub struct Words<'a> {
    rest: &'a str,
    line: usize,
    /// Whether `#` begins a comment that ends with the line.
    has_comments: bool,
    /// What is read, for messages.
    pub section: String,
}

impl<'a> Words<'a> {
    /// `text`, whose first line has the number `line`.
    pub fn new(text: &'a str, line: usize, has_comments: bool, section: &str) -> Self {
        Self { rest: text, line, has_comments, section: section.to_owned() }
    }

    /// Line of the place.
    pub fn line(&self) -> usize {
        self.line
    }

    /// An error at this place.
    pub fn fail<T>(&self, fault: ReadFault) -> Result<T, ReadError> {
        Err(ReadError { line: self.line, fault })
    }

    /// The rest of the line.
    pub fn end_of_line(&mut self) -> &'a str {
        let n = self.rest.find('\n').unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(n);
        self.rest = rest;
        line
    }

    /// The next word, if there is one.
    pub fn next(&mut self) -> Option<&'a str> {
        loop {
            let start = self.rest.find(|c: char| !c.is_whitespace()).unwrap_or(self.rest.len());
            self.line += self.rest[..start].matches('\n').count();
            self.rest = &self.rest[start..];
            if !(self.has_comments && self.rest.starts_with('#')) {
                break;
            }
            self.end_of_line();
        }
        let n = self.rest.find(char::is_whitespace).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(n);
        self.rest = rest;
        (n > 0).then_some(word)
    }

    /// The next word.
    ///
    /// # Errors
    /// [`ReadFault::End`].
    pub fn word(&mut self) -> Result<&'a str, ReadError> {
        match self.next() {
            Some(word) => Ok(word),
            None => self.fail(ReadFault::End { section: self.section.clone() }),
        }
    }

    /// A number.
    ///
    /// # Errors
    /// [`ReadFault::End`], [`ReadFault::Expected`].
    pub fn number<T: std::str::FromStr>(&mut self, expected: &'static str) -> Result<T, ReadError> {
        let word = self.word()?;
        word.parse().or_else(|_| self.unexpected(expected, word))
    }

    /// The word `wanted`.
    ///
    /// # Errors
    /// [`ReadFault::End`], [`ReadFault::Expected`].
    pub fn keyword(&mut self, wanted: &'static str) -> Result<(), ReadError> {
        let word = self.word()?;
        if word == wanted { Ok(()) } else { self.unexpected(wanted, word) }
    }

    /// The fault that `found` stands where something else should.
    ///
    /// # Errors
    /// [`ReadFault::Expected`], always.
    pub fn unexpected<T>(&self, expected: &'static str, found: &str) -> Result<T, ReadError> {
        let found = found.chars().take(SHOWN).collect();
        self.fail(ReadFault::Expected { expected, section: self.section.clone(), found })
    }

    /// Number of characters that are left.
    pub fn n_left(&self) -> usize {
        self.rest.len()
    }

    /// Whether the rest of the text has a character for each of `n` things.
    pub fn can_hold(&self, n: usize) -> bool {
        n <= self.rest.len()
    }

    /// A count of things of which each takes a character and a space at least.
    ///
    /// # Errors
    /// [`ReadFault::End`] for a count that the rest of the file cannot hold; as [`Words::number`].
    pub fn count(&mut self) -> Result<usize, ReadError> {
        let n: usize = self.number("a count")?;
        if !self.can_hold(n) {
            return self.fail(ReadFault::End { section: self.section.clone() });
        }
        Ok(n)
    }

    /// `n` numbers.
    ///
    /// # Errors
    /// As [`Words::number`].
    pub fn reals(&mut self, n: usize) -> Result<Vec<f64>, ReadError> {
        // Each takes two characters; what is not there is not made room for.
        let mut out = Vec::with_capacity(n.min(self.rest.len() / 2 + 1));
        for _ in 0..n {
            out.push(self.number("a number")?);
        }
        Ok(out)
    }

    /// All numbers up to the end as points of so many coordinates, the others zero, and how many
    /// numbers there are; `n` points are expected.
    ///
    /// # Errors
    /// [`ReadFault::Expected`].
    pub fn all_points(&mut self, n: usize, dimension: usize) -> Result<(Vec<[f64; 3]>, usize), ReadError> {
        let mut out = Vec::with_capacity(n.min(self.rest.len() / (2 * dimension) + 1));
        let mut point = [0.0; 3];
        let mut found = 0;
        while let Some(word) = self.next() {
            point[found % dimension] = word.parse().or_else(|_| self.unexpected("a number", word))?;
            found += 1;
            if found % dimension == 0 && out.len() < n {
                out.push(point);
            }
        }
        Ok((out, found))
    }

    /// All numbers up to the end.
    ///
    /// # Errors
    /// [`ReadFault::Expected`].
    pub fn all_reals(&mut self) -> Result<Vec<f64>, ReadError> {
        let mut out = Vec::new();
        while let Some(word) = self.next() {
            out.push(word.parse().or_else(|_| self.unexpected("a number", word))?);
        }
        Ok(out)
    }
}
