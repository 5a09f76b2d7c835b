//! Numbers in the order in which they stand in a Gmsh file, text or binary.

use crate::fault::{MeshError, Place, ReadFault};

/// Characters of a wrong word that a message shows.
const SHOWN: usize = 40;

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// As text.
    Text,
    /// As bytes, least significant first.
    LittleEndian,
    /// As bytes, most significant first.
    BigEndian,
}

/// A file with the place that has been reached.
pub struct Numbers<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Line of the place, as long as there was only text.
    line: usize,
    /// How numbers in sections are written.
    pub encoding: Encoding,
    /// What is read, for messages.
    pub section: String,
}

impl<'a> Numbers<'a> {
    /// The beginning of a file.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, line: 1, encoding: Encoding::Text, section: "the header".into() }
    }

    /// The place that has been reached.
    pub fn place(&self) -> Place {
        if self.encoding == Encoding::Text { Place::Line(self.line) } else { Place::Byte(self.at) }
    }

    /// An error at this place.
    pub fn fail<T>(&self, fault: ReadFault) -> Result<T, MeshError> {
        Err(MeshError::Read { place: self.place(), fault })
    }

    fn expected<T>(&self, expected: &str, found: &[u8]) -> Result<T, MeshError> {
        let found = String::from_utf8_lossy(&found[..found.len().min(SHOWN)]).into_owned();
        self.fail(ReadFault::Expected { expected: format!("{expected} in {}", self.section), found })
    }

    fn end<T>(&self) -> Result<T, MeshError> {
        self.fail(ReadFault::End { section: self.section.clone() })
    }

    fn advance(&mut self, n: usize) {
        let passed = &self.bytes[self.at..self.at + n];
        if self.encoding == Encoding::Text {
            self.line += passed.iter().filter(|b| **b == b'\n').count();
        }
        self.at += n;
    }

    fn skip_space(&mut self) {
        let n = self.bytes[self.at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        self.advance(n);
    }

    /// The next word of a text, if there is one.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let n = rest.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        self.advance(n);
        (n > 0).then(|| &rest[..n])
    }

    /// A text between quotes.
    ///
    /// # Errors
    /// [`ReadFault::Expected`].
    pub fn quoted(&mut self) -> Result<String, MeshError> {
        self.skip_space();
        let rest = &self.bytes[self.at..];
        let line = &rest[..rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len())];
        let inside =
            line.strip_prefix(b"\"").and_then(|l| l.iter().position(|b| *b == b'"').map(|n| &l[..n]));
        let Some(inside) = inside else { return self.expected("a name in quotes", line) };
        self.advance(inside.len() + 2);
        Ok(String::from_utf8_lossy(inside).into_owned())
    }

    /// A number that stands as text in binary files, too.
    ///
    /// # Errors
    /// [`ReadFault::Expected`], [`ReadFault::End`].
    pub fn text_number(&mut self) -> Result<u64, MeshError> {
        let Some(word) = self.word() else { return self.end() };
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.map_or_else(|| self.expected("a count", word), Ok)
    }

    /// The line break before the bytes of a binary section.
    pub fn skip_line_break(&mut self) {
        let rest = &self.bytes[self.at..];
        let n = if rest.starts_with(b"\r\n") { 2 } else { usize::from(rest.starts_with(b"\n")) };
        self.advance(n);
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], MeshError> {
        let Some(array) = self.bytes[self.at..].first_chunk::<N>() else { return self.end() };
        let mut array = *array;
        self.at += N;
        if self.encoding == Encoding::BigEndian {
            array.reverse();
        }
        Ok(array)
    }

    /// A small integer.
    ///
    /// # Errors
    /// [`ReadFault::Expected`], [`ReadFault::End`].
    pub fn int(&mut self) -> Result<i32, MeshError> {
        if self.encoding != Encoding::Text {
            return Ok(i32::from_le_bytes(self.array()?));
        }
        let Some(word) = self.word() else { return self.end() };
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.map_or_else(|| self.expected("an integer", word), Ok)
    }

    /// A count or number of a node or element.
    ///
    /// # Errors
    /// [`ReadFault::Expected`], [`ReadFault::End`].
    pub fn size(&mut self) -> Result<u64, MeshError> {
        if self.encoding == Encoding::Text {
            self.text_number()
        } else {
            Ok(u64::from_le_bytes(self.array()?))
        }
    }

    /// A real number.
    ///
    /// # Errors
    /// [`ReadFault::Expected`], [`ReadFault::End`].
    pub fn real(&mut self) -> Result<f64, MeshError> {
        if self.encoding != Encoding::Text {
            return Ok(f64::from_le_bytes(self.array()?));
        }
        let Some(word) = self.word() else { return self.end() };
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.map_or_else(|| self.expected("a number", word), Ok)
    }

    /// Goes behind the end of the section called `name`.
    ///
    /// # Errors
    /// [`ReadFault::End`].
    pub fn leave(&mut self, name: &str) -> Result<(), MeshError> {
        let end = format!("$End{name}");
        let rest = &self.bytes[self.at..];
        match rest.windows(end.len()).position(|w| w == end.as_bytes()) {
            Some(n) => {
                self.advance(n + end.len());
                Ok(())
            }
            None => self.end(),
        }
    }

    /// Checks that the section called `name` ends here.
    ///
    /// # Errors
    /// [`ReadFault::Expected`], [`ReadFault::End`].
    pub fn close(&mut self, name: &str) -> Result<(), MeshError> {
        match self.word() {
            None => self.end(),
            Some(word) if word.strip_prefix(b"$End") == Some(name.as_bytes()) => Ok(()),
            Some(word) => self.expected(&format!("$End{name}"), word),
        }
    }
}
