//! Sizes that the program chose for a run, as the scenario in its result tells them: a comment
//! behind the key says that and why.

/// Begins the comment behind a key that the program has chosen.
pub const MARK: &str = "  # chosen by the program: ";

/// A size that the program has chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// Name of the body.
    pub body: String,
    /// What was chosen, and why.
    pub text: String,
}

/// The sizes that the program has chosen, from the resolved text of a scenario.
pub fn notes(resolved: &str) -> Vec<Note> {
    let (mut body, mut found) = (String::new(), Vec::new());
    for line in resolved.lines() {
        if let Some(path) =
            line.trim_matches(['[', ']']).strip_prefix("bodies.").filter(|_| line.starts_with('['))
        {
            body = path.split('.').next().unwrap_or(path).to_owned();
        } else if let Some((_, text)) = line.split_once(MARK) {
            found.push(Note { body: body.clone(), text: text.to_owned() });
        }
    }
    found
}
