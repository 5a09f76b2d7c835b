//! Faults of a scenario: where, which key, which value, what is allowed. All faults of a file are
//! reported together.

use std::fmt;

/// Where a fault lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Location {
    /// In a file.
    File {
        /// File as named by the user.
        file: String,
        /// Line from 1.
        line: usize,
        /// Column from 1, in characters.
        column: usize,
        /// Text of the line.
        text: String,
        /// Number of characters at fault, at least 1.
        width: usize,
    },
    /// In a `--set` argument, given as typed.
    Override(String),
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Where.
    pub location: Location,
    /// Dotted key; empty for faults of the whole file.
    pub key: String,
    /// Value found, as written.
    pub value: Option<String>,
    /// What is wrong and what is allowed.
    pub message: String,
    /// Nearest known key or name.
    pub suggestion: Option<String>,
    /// What there is to choose from, as a fragment such as `known are "a" or "b"`; empty where that
    /// is said by the message.
    pub known: String,
}

impl Fault {
    /// Line in the file, if the fault lies in one.
    pub fn line(&self) -> Option<usize> {
        match &self.location {
            Location::File { line, .. } => Some(*line),
            Location::Override(_) => None,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.location {
            Location::File { file, line, column, .. } => write!(f, "{file}:{line}:{column}: ")?,
            Location::Override(text) => write!(f, "--set {text}: ")?,
        }
        if !self.key.is_empty() {
            f.write_str(&self.key)?;
            if let Some(value) = &self.value {
                write!(f, " = {value}")?;
            }
            f.write_str(": ")?;
        }
        f.write_str(&self.message)?;
        if let Some(suggestion) = &self.suggestion {
            write!(f, ", did you mean \"{suggestion}\"?")?;
        }
        // What is meant comes first: lists of keys are long.
        match (&self.suggestion, self.known.split_at_checked(1)) {
            (Some(_), Some((first, rest))) => write!(f, " {}{rest}", first.to_uppercase())?,
            (None, Some(_)) => write!(f, ", {}", self.known)?,
            (_, None) => {}
        }
        let Location::File { line, column, text, width, .. } = &self.location else { return Ok(()) };
        if text.trim().is_empty() {
            return Ok(());
        }
        let number = line.to_string();
        let indent: String =
            text.chars().take(column - 1).map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
        let marks = "^".repeat(*width);
        write!(f, "\n  {number} | {text}\n  {:w$} | {indent}{marks}", "", w = number.len())
    }
}

/// All faults of a scenario, in the order of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Faults(Vec<Fault>);

impl Faults {
    /// Wraps a list, which is sorted by line; faults of overrides come last.
    pub fn new(mut faults: Vec<Fault>) -> Self {
        faults.sort_by_key(|f| f.line().unwrap_or(usize::MAX));
        Self(faults)
    }

    /// The faults.
    pub fn list(&self) -> &[Fault] {
        &self.0
    }
}

/// Faults that are shown: more of them have one cause, a key or file that all bodies share.
const SHOWN: usize = 20;

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.0.iter().take(SHOWN).enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{fault}")?;
        }
        let n = self.0.len();
        let first = if n > SHOWN { format!(", the first {SHOWN} are shown") } else { String::new() };
        write!(f, "\n{n} fault{} found{first}", if n == 1 { "" } else { "s" })
    }
}

impl std::error::Error for Faults {}

/// What `word` may stand for among names, each with the words that other programs have for it: that
/// word's name, or the nearest one.
pub fn meant<'a>(
    word: &str,
    known: impl Iterator<Item = (&'a str, &'a [&'a str])> + Clone,
) -> Option<String> {
    let plain = word.to_lowercase().replace([' ', '_'], "-");
    let translated = known.clone().find(|(_, words)| words.contains(&plain.as_str()));
    translated.map(|(name, _)| name.to_owned()).or_else(|| nearest(word, known.map(|(name, _)| name)))
}

/// The entry of `known` that `word` most likely means.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let word = word.to_lowercase();
    known
        .into_iter()
        .map(|k| (strsim::jaro_winkler(&word, &k.to_lowercase()), k))
        // 0.8: accepts a dropped, doubled or swapped letter in words of four letters and more.
        .filter(|(score, _)| *score >= 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, k)| k.to_owned())
}
