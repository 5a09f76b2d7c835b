//! The words of an expression.

use super::fault::FaultAt;

/// A word.
#[derive(Debug, Clone, PartialEq)]
pub enum Token {
    /// A number that is not negative.
    Number(f64),
    /// A name: letters, digits, `_` and, within it, `-`; any in quotes.
    Name(String),
    /// One of `+ - * / ^ ( ) [ ] : , .`.
    Sign(char),
}

impl Token {
    /// As messages call it.
    pub fn shown(&self) -> String {
        match self {
            Self::Number(x) => format!("{x}"),
            Self::Name(name) => format!("\"{name}\""),
            Self::Sign(sign) => format!("\"{sign}\""),
        }
    }
}

/// The words of `text` with their places in it.
///
/// # Errors
/// A character that begins none.
pub fn tokens(text: &str) -> Result<Vec<(usize, Token)>, FaultAt> {
    let letters: Vec<char> = text.chars().collect();
    let (mut all, mut at) = (Vec::new(), 0);
    while let Some(&c) = letters.get(at) {
        if c.is_whitespace() {
            at += 1;
            continue;
        }
        let is_after_dot = matches!(all.last(), Some((_, Token::Sign('.'))));
        let begin = at;
        let token = if c.is_ascii_digit() && !is_after_dot {
            at = end_of_number(&letters, at);
            let word: String = letters[begin..at].iter().collect();
            let number = word.parse().map_err(|_| (begin, format!("{word} is no number")))?;
            Token::Number(number)
        } else if c == '"' {
            let end = letters[at + 1..].iter().position(|c| *c == '"');
            let end = at + 1 + end.ok_or_else(|| (begin, "the quoted name has no end".to_owned()))?;
            at = end + 1;
            Token::Name(letters[begin + 1..end].iter().collect())
        } else if is_part(c) {
            at = end_of_name(&letters, at);
            Token::Name(letters[begin..at].iter().collect())
        } else if "+-*/^()[]:,.".contains(c) {
            at += 1;
            Token::Sign(c)
        } else {
            return Err((at, format!("\"{c}\" begins no name, number or sign")));
        };
        all.push((begin, token));
    }
    Ok(all)
}

fn is_part(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Behind the name that begins at `at`. A `-` between two of its letters belongs to it, as names in
/// scenarios have it.
fn end_of_name(letters: &[char], mut at: usize) -> usize {
    while let Some(&c) = letters.get(at) {
        let is_within = c == '-' && letters.get(at + 1).is_some_and(|next| is_part(*next));
        if !is_part(c) && !is_within {
            break;
        }
        at += 1;
    }
    at
}

/// Behind the number that begins at `at`: digits, a point with digits, an exponent.
fn end_of_number(letters: &[char], mut at: usize) -> usize {
    let digits = |mut at: usize| {
        while letters.get(at).is_some_and(char::is_ascii_digit) {
            at += 1;
        }
        at
    };
    at = digits(at);
    if letters.get(at) == Some(&'.') && letters.get(at + 1).is_some_and(char::is_ascii_digit) {
        at = digits(at + 1);
    }
    if matches!(letters.get(at), Some('e' | 'E')) {
        let sign = usize::from(matches!(letters.get(at + 1), Some('+' | '-')));
        let behind = digits(at + 1 + sign);
        if behind > at + 1 + sign {
            at = behind;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> Vec<String> {
        tokens(text).expect("words").iter().map(|(_, t)| t.shown()).collect()
    }

    #[test]
    fn words_are_told_apart() {
        assert_eq!(
            shown("a.b[-1] - 2.5e-3*c"),
            ["\"a\"", "\".\"", "\"b\"", "\"[\"", "\"-\"", "1", "\"]\"", "\"-\"", "0.0025", "\"*\"", "\"c\""]
        );
        assert_eq!(shown("left-ball.x -y"), ["\"left-ball\"", "\".\"", "\"x\"", "\"-\"", "\"y\""]);
        // Names may begin with a digit behind a dot, and end where a minus has none of their
        // letters behind it.
        assert_eq!(shown("bodies.1st- 2"), ["\"bodies\"", "\".\"", "\"1st\"", "\"-\"", "2"]);
        assert_eq!(shown("3e"), ["3", "\"e\""]);
        assert_eq!(shown("a.\"b-\" 1"), ["\"a\"", "\".\"", "\"b-\"", "1"]);
        assert_eq!(tokens("a.\"b"), Err((2, "the quoted name has no end".into())));
        assert_eq!(tokens("a % b"), Err((2, "\"%\" begins no name, number or sign".into())));
    }
}
