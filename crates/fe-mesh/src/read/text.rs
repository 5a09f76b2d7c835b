//! Fields of text files, faults of lines, and what is noted of them.

use crate::fault::{MeshError, Place, ReadFault};

/// Characters of a wrong field that a message shows.
const SHOWN: usize = 40;

/// A fault of line `line`.
pub fn fail<T>(line: usize, fault: ReadFault) -> Result<T, MeshError> {
    Err(MeshError::Read { place: Place::Line(line), fault })
}

/// Something else than `found` was expected in line `line`.
pub fn expected<T>(line: usize, expected: &str, found: &str) -> Result<T, MeshError> {
    let found = found.chars().take(SHOWN).collect();
    fail(line, ReadFault::Expected { expected: expected.to_owned(), found })
}

/// Something in line `line` that is not read, with what to do.
pub fn refuse<T>(line: usize, what: &str, remedy: &'static str) -> Result<T, MeshError> {
    fail(line, ReadFault::Unsupported { what: what.to_owned(), remedy })
}

/// Fields between commas, without blanks and quotes around them; a comma between quotes divides nothing.
pub fn split(text: &str) -> impl Iterator<Item = &str> {
    let mut is_quoted = false;
    let divides = move |c: char| {
        is_quoted ^= c == '"';
        c == ',' && !is_quoted
    };
    text.split(divides).map(|field| field.trim().trim_matches('"'))
}

/// Those of them that are not empty.
pub fn fields(text: &str) -> impl Iterator<Item = &str> {
    split(text).filter(|field| !field.is_empty())
}

/// A number; Fortran writes exponents with d as well, or with their sign alone.
pub fn real(field: &str) -> Option<f64> {
    if let Ok(value) = field.parse() {
        return Some(value);
    }
    let plain = field.replace(['d', 'D'], "e");
    let sign = plain.rfind(['+', '-']).filter(|&at| at > 0 && !plain.contains(['e', 'E']));
    match sign {
        Some(at) => format!("{}e{}", &plain[..at], &plain[at..]).parse().ok(),
        None => plain.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_fortran_and_fields_in_quotes() {
        for (text, value) in
            [("1.5", 1.5), ("-2.d-3", -2e-3), ("7.0-1", 0.7), ("-1.+2", -100.0), (".5E1", 5.0)]
        {
            assert_eq!(real(text), Some(value), "{text}");
        }
        assert!(["", "1.2.3", "-", "a-1", "+"].iter().all(|text| real(text).is_none()));
        let found: Vec<&str> = split(r#"a ,"b, c" , "d"#).collect();
        assert_eq!(found, ["a", "b, c", "d"]);
    }
}
