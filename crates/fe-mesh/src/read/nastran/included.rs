//! Files that bulk data include, put where they are included.

use std::borrow::Cow;

use super::super::Wanted;
use super::super::text::fail;
use crate::fault::{MeshError, Place, ReadFault};

/// Files that may include each other, one within the other, and includes in all.
const MOST: [usize; 2] = [16, 1000];

/// Where the lines of the text stand from one of them on.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// First line, from 1.
    first: usize,
    /// The included file, an index; none for the file itself.
    file: Option<usize>,
    /// Number of this line in its file.
    line: usize,
}

/// An included file.
#[derive(Debug)]
struct File {
    name: String,
    /// Where it is included.
    by: Option<usize>,
    line: usize,
}

/// A text with all that it includes.
#[derive(Debug, Default)]
pub struct Lines {
    runs: Vec<Run>,
    files: Vec<File>,
}

/// Whether `line` begins with `word`, capitals or not.
fn begins(line: &str, word: &str) -> bool {
    line.trim_start().get(..word.len()).is_some_and(|w| w.eq_ignore_ascii_case(word))
}

/// The file that a line includes.
fn name_of(line: &str) -> Option<&str> {
    let name = line.trim_start().get(7..).filter(|_| begins(line, "INCLUDE"))?;
    let name = name.split('$').next()?.trim().trim_start_matches('=').trim().trim_matches(['\'', '"']);
    (!name.is_empty()).then_some(name)
}

impl Lines {
    /// `text` with the files that its bulk data include.
    ///
    /// # Errors
    /// [`ReadFault::Include`] with the line.
    pub fn expanded<'t>(
        &mut self,
        text: Cow<'t, str>,
        wanted: &mut Wanted<'_>,
    ) -> Result<Cow<'t, str>, MeshError> {
        let begin = text.lines().position(|line| begins(line, "BEGIN")).map_or(0, |at| at + 1);
        self.runs.push(Run { first: 1, file: None, line: 1 });
        if !text.lines().skip(begin).any(|line| name_of(line).is_some()) {
            return Ok(text);
        }
        let (mut out, mut n) = (String::with_capacity(text.len()), 0);
        self.add((&mut out, &mut n), (&text, begin), (None, 0), wanted)?;
        Ok(Cow::Owned(out))
    }

    /// Adds the lines of a file, `depth` files deep, includes from line `begin` on.
    fn add(
        &mut self,
        (out, n): (&mut String, &mut usize),
        (text, begin): (&str, usize),
        (file, depth): (Option<usize>, usize),
        wanted: &mut Wanted<'_>,
    ) -> Result<(), MeshError> {
        self.runs.push(Run { first: *n + 1, file, line: 1 });
        for (i, line) in text.lines().enumerate() {
            let Some(name) = name_of(line).filter(|_| i >= begin) else {
                out.push_str(line);
                out.push('\n');
                *n += 1;
                if i >= begin && begins(line, "ENDDATA") {
                    break;
                }
                continue;
            };
            let [deepest, most] = MOST;
            let cannot = |reason| ReadFault::Include { file: name.to_owned(), reason };
            let found = if depth == deepest || self.files.len() == most {
                Err(format!("{deepest} files within each other, {most} in all, are read"))
            } else {
                (wanted.include)(name)
            };
            // The line of the fault is that of the include.
            self.runs.push(Run { first: *n + 1, file, line: i + 1 });
            let bytes = found.or_else(|reason| fail(*n + 1, cannot(reason)))?;
            self.files.push(File { name: name.to_owned(), by: file, line: i + 1 });
            let own = Some(self.files.len() - 1);
            self.add((&mut *out, &mut *n), (&String::from_utf8_lossy(&bytes), 0), (own, depth + 1), wanted)?;
            self.runs.push(Run { first: *n + 1, file, line: i + 2 });
        }
        Ok(())
    }

    /// The file of a line, and its number there.
    fn find(&self, line: usize) -> (Option<usize>, usize) {
        let run = self.runs.iter().rev().find(|run| run.first <= line);
        run.map_or((None, line), |run| (run.file, run.line + line - run.first))
    }

    /// A line, for a note.
    pub fn place(&self, line: usize) -> String {
        match self.find(line) {
            (Some(file), line) => format!("line {line} of {}", self.files[file].name),
            (None, line) => format!("line {line}"),
        }
    }

    /// `error` with the place of its line in the file that it stands in.
    pub fn told(&self, error: MeshError) -> MeshError {
        let MeshError::Read { place: Place::Line(line), mut fault } = error else { return error };
        let (mut file, mut line) = self.find(line);
        while let Some(File { name, by, line: at }) = file.map(|file| &self.files[file]) {
            let place = Place::Line(line);
            fault = ReadFault::Included { file: name.clone(), place, fault: Box::new(fault) };
            (file, line) = (*by, *at);
        }
        MeshError::Read { place: Place::Line(line), fault }
    }
}
