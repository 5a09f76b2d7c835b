//! What a reader leaves out, for a note.

use std::fmt::Display;

/// Names that a note lists before it ends.
pub const LISTED: usize = 20;

/// Names of sections, cards or elements that are left out, with the place of the first of each.
#[derive(Debug, Default)]
pub struct Skipped {
    names: Vec<(String, String)>,
    has_more: bool,
}

impl Skipped {
    /// Notes a name, once.
    pub fn note(&mut self, name: &str, place: impl Display) {
        if self.names.iter().any(|(known, _)| known == name) {
            return;
        }
        if self.names.len() < LISTED {
            self.names.push((name.to_owned(), place.to_string()));
        } else {
            self.has_more = true;
        }
    }

    /// The names with their places, if there are any.
    pub fn list(&self) -> Option<String> {
        let mut all: Vec<String> =
            self.names.iter().map(|(name, place)| format!("{name} ({place})")).collect();
        if self.has_more {
            all.push("…".to_owned());
        }
        (!all.is_empty()).then(|| all.join(", "))
    }
}
