//! Stored scenarios as lists of keys with values, to say in what two runs differ.

use std::collections::BTreeMap;
use std::fmt;

/// Dotted keys and their values as TOML, the value of a text without quotes.
pub type Values = BTreeMap<String, String>;

/// Keys and values of a scenario; none if the text is no TOML.
pub fn read(text: &str) -> Values {
    let mut out = Values::new();
    if let Ok(table) = text.parse::<toml::Table>() {
        collect(&toml::Value::Table(table), "", &mut out);
    }
    out
}

/// A value as [`read`] shows it, from the right side of a `--set`.
pub fn shown(text: &str) -> String {
    let table = format!("value = {text}").parse::<toml::Table>();
    let value = table.ok().and_then(|t| t.get("value").cloned());
    value.map_or_else(|| text.to_owned(), |v| show(&v))
}

fn collect(value: &toml::Value, path: &str, out: &mut Values) {
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        toml::Value::Table(table) => table.iter().for_each(|(key, value)| collect(value, &join(key), out)),
        toml::Value::Array(items) if items.iter().any(toml::Value::is_table) => {
            for (i, item) in items.iter().enumerate() {
                collect(item, &format!("{path}[{i}]"), out);
            }
        }
        _ => {
            out.insert(path.to_owned(), show(value));
        }
    }
}

fn show(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        // `1`, `1.0` and `1e0` are one number.
        toml::Value::Integer(i) => format!("{i}"),
        toml::Value::Float(x) => x.to_string(),
        toml::Value::Array(items) => {
            format!("[{}]", items.iter().map(show).collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

/// A key whose values differ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// Dotted key.
    pub key: String,
    /// The new value, if there is one.
    pub new: Option<String>,
    /// The reference's value, if there is one.
    pub reference: Option<String>,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |v: &Option<String>| v.clone().unwrap_or_else(|| "not there".to_owned());
        write!(f, "{} is {}, the reference's is {}", self.key, text(&self.new), text(&self.reference))
    }
}

/// Keys whose values differ.
pub fn changes(new: &Values, reference: &Values) -> Vec<Change> {
    let mut keys: Vec<&String> = new.keys().chain(reference.keys()).collect();
    keys.sort();
    keys.dedup();
    keys.into_iter()
        .filter(|key| new.get(*key) != reference.get(*key))
        .map(|key| Change {
            key: key.clone(),
            new: new.get(key).cloned(),
            reference: reference.get(key).cloned(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_values_are_named_by_their_keys() {
        let a = read("title = 'a'\n[bodies.ball]\nvelocity = [0.0, 0, -1.0]\nrefine = [{ width = 1.0 }]\n");
        let b =
            read("title = 'a'\n[bodies.ball]\nvelocity = [0, 0, -2.5]\nrefine = [{ width = 3.0 }]\nx = 1\n");
        let found: Vec<String> = changes(&b, &a).iter().map(ToString::to_string).collect();
        let expected = [
            "bodies.ball.refine[0].width is 3, the reference's is 1",
            "bodies.ball.velocity is [0, 0, -2.5], the reference's is [0, 0, -1]",
            "bodies.ball.x is 1, the reference's is not there",
        ];
        assert_eq!(found, expected);
        assert_eq!(shown("[0, 0, -2.50]"), a_value(&b));
        assert_eq!(shown("craig-bampton"), "craig-bampton");
    }

    fn a_value(values: &Values) -> String {
        values["bodies.ball.velocity"].clone()
    }
}
