//! Lines of a TOML file that hold nothing, which the parser would keep fifty bytes for each.

use std::borrow::Cow;

/// Length from which a text is looked at: shorter ones take little, whatever is in them \[bytes\].
const LONG: usize = 1 << 20;

/// `text` with spaces in place of lines that are empty or hold a comment alone: everything else
/// stays where it is.
pub fn blanked(text: &str) -> Cow<'_, str> {
    if text.len() < LONG {
        return Cow::Borrowed(text);
    }
    String::from_utf8(with_spaces(text.as_bytes().to_vec())).map_or(Cow::Borrowed(text), Cow::Owned)
}

fn with_spaces(mut bytes: Vec<u8>) -> Vec<u8> {
    // Begin of the line, whether nothing stands in it yet, and what ends the string that is open.
    let (mut begin, mut is_empty, mut string) = (0, true, None::<(u8, usize)>);
    let mut i = 0;
    while i < bytes.len() {
        let byte = bytes[i];
        let signs = |quote| bytes[i..].iter().take(3).take_while(|b| **b == quote).count();
        match string {
            Some((b'"', _)) if byte == b'\\' => i += 1,
            Some((quote, n)) if byte == quote && signs(quote) >= n => (string, i) = (None, i + n - 1),
            Some((_, 3)) => {}
            Some(_) if byte != b'\n' => {}
            _ => match byte {
                b'\n' => {
                    if is_empty {
                        bytes[begin..=i].fill(b' ');
                    }
                    (begin, is_empty, string) = (i + 1, true, None);
                }
                b'"' | b'\'' => {
                    let n = if signs(byte) == 3 { 3 } else { 1 };
                    (string, is_empty, i) = (Some((byte, n)), false, i + n - 1);
                }
                b'#' => {
                    let rest = bytes[i..].iter().position(|b| *b == b'\n');
                    i = rest.map_or(bytes.len(), |rest| i + rest) - 1;
                }
                b' ' | b'\t' | b'\r' => {}
                _ => is_empty = false,
            },
        }
        i += 1;
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blank(text: &str) -> String {
        String::from_utf8(with_spaces(text.as_bytes().to_vec())).expect("UTF-8")
    }

    #[test]
    fn empty_lines_and_comments_become_spaces_and_nothing_moves() {
        assert_eq!(blank("\n\na = 1 # x\n\n# ü\r\n  \n[b]\n"), "  a = 1 # x\n          [b]\n");
        assert_eq!(blank("a = \"#\" # \"\n\nb = '\"'\n"), "a = \"#\" # \"\n b = '\"'\n");
        assert_eq!(blank("# the end"), "# the end");
    }

    #[test]
    fn strings_of_several_lines_stay() {
        for quotes in ["\"\"\"", "'''"] {
            let text = format!("a = {quotes}\n\n # no comment\n\n{quotes}\nb = 1\n");
            assert_eq!(blank(&text), text);
        }
        let escaped = "a = \"\"\"\n\\\"\"\"\n\n\"\"\"\nb = \"\\\"#\"\n";
        assert_eq!(blank(escaped), escaped);
        // What is not closed ends with its line, or never.
        assert_eq!(blank("a = \"\n\nb = '''\n\n"), "a = \"\n b = '''\n\n");
    }

    #[test]
    fn long_texts_mean_the_same_as_short_ones() {
        let long = "\n".repeat(LONG) + "a = \"x\" # y\n" + &"# z\n".repeat(9) + "[b]\nc = 1\n";
        let table: toml::Table = blanked(&long).parse().expect("TOML");
        assert_eq!(table, "a = \"x\"\nb = { c = 1 }".parse().expect("TOML"));
    }
}
