//! Texts of files on a terminal: nothing in them may move its cursor, colour it or turn its
//! direction.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;

/// Characters of a text that a table of facts shows.
const MOST: usize = 200;
/// Characters of a line of a message.
const MOST_OF_LINE: usize = 4000;

/// Whether a terminal obeys `c` in place of showing it.
fn is_command(c: char) -> bool {
    let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || c.is_control() && !matches!(c, '\n' | '\t')
}

/// `text` with `\u001b` in place of a control character, as JSON and TOML write it.
pub fn shown(text: &str) -> Cow<'_, str> {
    if !text.contains(is_command) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_command(c) {
            // Writing to a text does not fail.
            let _ = write!(out, "\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// A name as a shell needs it in a command.
pub fn for_shell(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "_@%+=:,./-".contains(c);
    if text.starts_with('-') {
        return for_shell(&Path::new(".").join(path));
    }
    if !text.is_empty() && text.chars().all(is_plain) {
        return text;
    }
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// [`shown`] on one line that is not too long.
pub fn short(text: &str) -> String {
    cut(&shown(&text.replace(['\n', '\t'], " ")), MOST)
}

/// [`shown`], with lines of a length that a person reads.
pub fn message(text: &str) -> String {
    let lines: Vec<String> = shown(text).split('\n').map(|line| cut(line, MOST_OF_LINE)).collect();
    lines.join("\n")
}

fn cut(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}… ({} characters)", &text[..end], text.chars().count()),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_shown_once() {
        assert_eq!(
            shown("\u{1b}[31mred\u{9b}0m\u{202e}\r\n\ta"),
            "\\u001b[31mred\\u009b0m\\u202e\\u000d\n\ta"
        );
        assert_eq!(shown(&shown("\u{1b}")), "\\u001b");
        assert_eq!(shown("größer → 1"), "größer → 1");
    }

    #[test]
    fn names_in_commands_are_one_word_of_a_shell() {
        for (name, word) in [
            ("drop.toml", "drop.toml"),
            ("größe/a-b_1.toml", "größe/a-b_1.toml"),
            ("my part.toml", "'my part.toml'"),
            ("o'neill", "'o'\\''neill'"),
            ("x;$(y).toml", "'x;$(y).toml'"),
            ("-q.toml", "./-q.toml"),
            ("-a b", "'./-a b'"),
            ("", "''"),
        ] {
            assert_eq!(for_shell(Path::new(name)), word);
        }
    }

    #[test]
    fn long_texts_are_shortened() {
        assert_eq!(short(&"é".repeat(300)), format!("{}… (300 characters)", "é".repeat(200)));
        assert_eq!(short("a\nb"), "a b");
        let long = format!("a\n{}", "b".repeat(5000));
        assert_eq!(message(&long), format!("a\n{}… (5000 characters)", "b".repeat(4000)));
    }
}
