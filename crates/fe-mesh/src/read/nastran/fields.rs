//! Entries of bulk data: short, large and free fields, lines that go on.

use crate::fault::MeshError;

/// Columns of a short field, and of a large one.
const WIDTHS: [usize; 2] = [8, 16];
/// Data fields of a line of short fields; large ones are half as many.
const FIELDS: usize = 8;

/// An entry.
#[derive(Debug, Clone)]
pub struct Entry<'a> {
    /// Its name in capitals, without the asterisk of large fields.
    pub name: String,
    pub line: usize,
    fields: Vec<&'a str>,
}

impl<'a> Entry<'a> {
    /// Field `i` behind the name, from 0; empty where there is none.
    pub fn field(&self, i: usize) -> &'a str {
        self.fields.get(i).copied().unwrap_or_default()
    }
}

/// The fields of a line, the first one apart; always as many as the form has.
fn split(text: &str) -> (&str, Vec<&str>) {
    let (first, mut all, is_large) = if text.contains(',') {
        let mut all = text.split(',').map(str::trim);
        let first = all.next().unwrap_or_default();
        (first, all.collect::<Vec<_>>(), first.contains('*'))
    } else {
        let first = text.get(..WIDTHS[0].min(text.len())).unwrap_or(text).trim();
        let is_large = first.contains('*');
        let width = WIDTHS[usize::from(is_large)];
        let mut rest = text.get(WIDTHS[0]..).unwrap_or_default();
        let mut all = Vec::new();
        while !rest.is_empty() {
            let (field, further) = rest.split_at_checked(width).unwrap_or((rest, ""));
            all.push(field.trim());
            rest = further;
        }
        (first, all, is_large)
    };
    // What stands behind these fields is the name of the line that goes on.
    all.resize(if is_large { FIELDS / 2 } else { FIELDS }, "");
    (first, all)
}

/// Gives the entries of the bulk data to `each`, one after the other.
///
/// # Errors
/// Those of `each`.
pub fn entries<'a>(
    text: &'a str,
    mut each: impl FnMut(Entry<'a>) -> Result<(), MeshError>,
) -> Result<(), MeshError> {
    let is = |line: &str, word: &str| line.get(..word.len()).is_some_and(|w| w.eq_ignore_ascii_case(word));
    let begin = text.lines().position(|line| is(line.trim_start(), "BEGIN")).map_or(0, |at| at + 1);
    let mut current: Option<Entry<'a>> = None;
    for (line, number) in text.lines().zip(1..).skip(begin) {
        let line = line.split('$').next().unwrap_or_default().trim_end();
        if is(line, "ENDDATA") {
            break;
        }
        if line.is_empty() {
            continue;
        }
        let (first, fields) = split(line);
        match current.as_mut().filter(|_| first.is_empty() || first.starts_with(['+', '*'])) {
            Some(entry) => entry.fields.extend(fields),
            None => {
                let name = first.trim_end_matches('*').trim().to_ascii_uppercase();
                current.replace(Entry { name, line: number, fields }).map_or(Ok(()), &mut each)?;
            }
        }
    }
    current.map_or(Ok(()), each)
}
