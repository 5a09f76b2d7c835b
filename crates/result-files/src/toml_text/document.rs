//! TOML (or JSON) text as a tree of values that know where they come from.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use toml::de::{DeTable, DeValue};

use super::blank_lines::blanked;
use super::fault::{Fault, Location};

/// Text of one file.
#[derive(Debug, PartialEq, Eq)]
pub struct SourceText {
    /// Name for messages.
    pub name: String,
    /// Content.
    pub text: String,
}

/// Where a value comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// Bytes of a file.
    File(Arc<SourceText>, Range<usize>),
    /// A `--set` argument.
    Override(Arc<str>),
    /// Not given: filled in.
    Default,
}

impl Origin {
    /// Location for a fault; a filled-in value has none of its own and takes `fallback`'s.
    pub fn location(&self, fallback: &Origin) -> Location {
        match (self, fallback) {
            (Self::File(source, span), _) => locate(source, span),
            (Self::Override(text), _) => Location::Override(text.to_string()),
            (Self::Default, Self::Default) => Location::Override("(default)".into()),
            (Self::Default, other) => other.location(&Self::Default),
        }
    }
}

fn locate(source: &SourceText, span: &Range<usize>) -> Location {
    let text = &source.text;
    let mut start = span.start.min(text.len());
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
    let line_end = text[start..].find('\n').map_or(text.len(), |i| start + i);
    let line_text = text[line_start..line_end].trim_end_matches('\r');
    let column = text[line_start..start].chars().count() + 1;
    let width = text
        .get(start..span.end.clamp(start, line_end))
        .map_or(1, |t| t.trim_end().chars().count().clamp(1, 80));
    // Long lines (matrices, binary junk) would flood the terminal.
    let text = if line_text.len() > 200 { String::new() } else { line_text.to_owned() };
    Location::File {
        file: source.name.clone(),
        line: source.text[..line_start].matches('\n').count() + 1,
        column,
        text,
        width,
    }
}

/// A value and its origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// Where it comes from.
    pub origin: Origin,
}

/// A TOML value.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// `true` or `false`.
    Boolean(bool),
    /// Integer within 64 bits.
    Integer(i64),
    /// Floating-point number, or an integer outside 64 bits.
    Float(f64),
    /// A number that was given with its unit, in that of its key, and the text.
    Measured(f64, String),
    /// String.
    Text(String),
    /// Date or time.
    Datetime(String),
    /// Array.
    Array(Vec<Node>),
    /// Table, in the order of the file.
    Table(Vec<Entry>),
}

/// A key with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Key.
    pub key: String,
    /// Where the key stands.
    pub origin: Origin,
    /// Value.
    pub node: Node,
}

impl Node {
    /// What kind of value this is, for messages.
    pub fn type_name(&self) -> Cow<'static, str> {
        match &self.value {
            Value::Boolean(_) => "a boolean".into(),
            Value::Integer(_) => "an integer".into(),
            Value::Float(_) | Value::Measured(..) => "a number".into(),
            Value::Text(_) => "a string".into(),
            Value::Datetime(_) => "a date".into(),
            Value::Array(items) => format!("a list of {}", items.len()).into(),
            Value::Table(_) => "a table".into(),
        }
    }

    /// The value as it stands in its file.
    fn written(&self) -> Option<String> {
        match &self.origin {
            Origin::File(source, span) if !span.is_empty() => {
                source.text.get(span.clone()).map(str::to_owned)
            }
            _ => None,
        }
    }

    /// The value as text on one line, shortened, for messages.
    pub fn shown(&self) -> String {
        let full = match &self.value {
            Value::Boolean(b) => b.to_string(),
            Value::Integer(i) => i.to_string(),
            Value::Float(x) => self.written().unwrap_or_else(|| show_number(*x)),
            Value::Text(s) | Value::Measured(_, s) => format!("{s:?}"),
            Value::Datetime(s) => s.clone(),
            Value::Array(items) => {
                let shown: Vec<String> = items.iter().take(7).map(Node::shown).collect();
                let more = if items.len() > 7 { ", …" } else { "" };
                format!("[{}{more}]", shown.join(", "))
            }
            Value::Table(entries) => {
                let shown: Vec<&str> = entries.iter().take(7).map(|e| e.key.as_str()).collect();
                format!("{{ {} }}", shown.join(", "))
            }
        };
        // Twice the width of an ordinary value; longer ones are seen in the line below the message.
        if full.chars().count() > 60 { full.chars().take(59).chain(['…']).collect() } else { full }
    }
}

/// A number as a user would write it.
pub fn show_number(x: f64) -> String {
    format!("{x:?}")
}

/// Parses TOML.
///
/// # Errors
/// Every syntax fault of the text.
pub fn parse_toml(source: &Arc<SourceText>) -> Result<Node, Vec<Fault>> {
    let text = blanked(&source.text);
    let (table, errors) = DeTable::parse_recoverable(&text);
    if errors.is_empty() {
        let origin = Origin::File(source.clone(), 0..0);
        return Ok(Node { value: convert_table(table.into_inner(), &file_origin(source)), origin });
    }
    let fault = |e: &toml::de::Error| Fault {
        location: locate(source, &e.span().unwrap_or(0..0)),
        key: String::new(),
        value: None,
        message: format!("not valid TOML: {}", e.message()),
        suggestion: None,
        known: String::new(),
    };
    Err(errors.iter().map(fault).collect())
}

/// Parses one TOML value, as on the right of a `--set`.
pub fn parse_value(text: &str, origin: &Origin) -> Option<Node> {
    let value = DeValue::parse(text).ok()?;
    Some(convert(value.into_inner(), origin.clone(), &|_| origin.clone()))
}

/// Parses JSON; its values are all located at the start of the file.
///
/// # Errors
/// The first syntax fault.
pub fn parse_json(source: &Arc<SourceText>) -> Result<Node, Vec<Fault>> {
    serde_json::from_str(&source.text).map(|v| from_json(v, &Origin::File(source.clone(), 0..0))).map_err(
        |e| {
            let line_start: usize =
                source.text.split_inclusive('\n').take(e.line().saturating_sub(1)).map(str::len).sum();
            let at = line_start + e.column().saturating_sub(1);
            vec![Fault {
                location: locate(source, &(at..at + 1)),
                key: String::new(),
                value: None,
                message: format!("not valid JSON: {e}"),
                suggestion: None,
                known: String::new(),
            }]
        },
    )
}

fn file_origin(source: &Arc<SourceText>) -> impl Fn(Range<usize>) -> Origin + use<> {
    let source = source.clone();
    move |span| Origin::File(source.clone(), span)
}

fn convert_table(table: DeTable<'_>, locate: &dyn Fn(Range<usize>) -> Origin) -> Value {
    let mut entries: Vec<_> = table.into_iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let convert_entry =
        |(key, value): (toml::Spanned<std::borrow::Cow<'_, str>>, toml::Spanned<DeValue<'_>>)| {
            let origin = locate(key.span());
            // The span of a table is that of its header, which says more than that of its first
            // key.
            let node_origin = locate(if value.span().is_empty() { key.span() } else { value.span() });
            Entry {
                key: key.into_inner().into_owned(),
                origin,
                node: convert(value.into_inner(), node_origin, locate),
            }
        };
    Value::Table(entries.into_iter().map(convert_entry).collect())
}

fn convert(value: DeValue<'_>, origin: Origin, locate: &dyn Fn(Range<usize>) -> Origin) -> Node {
    let value = match value {
        DeValue::Boolean(b) => Value::Boolean(b),
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(small) => Value::Integer(small),
            Err(_) => Value::Float(i.as_str().parse().unwrap_or(f64::INFINITY)),
        },
        DeValue::Float(x) => Value::Float(x.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::String(s) => Value::Text(s.into_owned()),
        DeValue::Datetime(d) => Value::Datetime(d.to_string()),
        DeValue::Array(items) => {
            let convert_item = |item: toml::Spanned<DeValue<'_>>| {
                let origin = locate(item.span());
                convert(item.into_inner(), origin, locate)
            };
            Value::Array(items.into_iter().map(convert_item).collect())
        }
        DeValue::Table(table) => convert_table(table, locate),
    };
    Node { value, origin }
}

fn from_json(value: serde_json::Value, origin: &Origin) -> Node {
    use serde_json::Value as Json;
    let value = match value {
        Json::Null => Value::Text("null".into()),
        Json::Bool(b) => Value::Boolean(b),
        Json::Number(n) => {
            n.as_i64().map_or_else(|| Value::Float(n.as_f64().unwrap_or(f64::NAN)), Value::Integer)
        }
        Json::String(s) => Value::Text(s),
        Json::Array(items) => Value::Array(items.into_iter().map(|v| from_json(v, origin)).collect()),
        Json::Object(map) => Value::Table(
            map.into_iter()
                .map(|(key, v)| Entry { key, origin: origin.clone(), node: from_json(v, origin) })
                .collect(),
        ),
    };
    Node { value, origin: origin.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_json_are_those_written_to_the_last_bit() {
        let mut state = 1u64;
        for case in 0..1000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let number = (state >> 11) as f64 / (1u64 << 53) as f64 * 10f64.powi(case % 40 - 20);
            let source = Arc::new(SourceText { name: "net.json".into(), text: format!("[{number:?}]") });
            let Value::Array(read) = parse_json(&source).expect("JSON").value else { panic!("an array") };
            assert_eq!(read[0].value, Value::Float(number), "{}", source.text);
        }
    }
}
