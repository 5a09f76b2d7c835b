//! Texts and numbers as HTML.

use std::fmt::Write as _;

use result_files::words::shown::shown;
use serde_json::{Map, Value};

/// `text` as it stands between tags and in attributes: nothing in it is obeyed.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 16);
    for c in shown(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// JSON that may stand in a script element.
pub fn in_script(json: &Value) -> String {
    json.to_string().replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

/// A number with six digits, a dash for what is none.
pub fn number(x: f64) -> String {
    if !x.is_finite() {
        return "–".into();
    }
    let size = x.abs();
    if size > 0.0 && !(1e-3..1e6).contains(&size) {
        let text = format!("{x:.5e}");
        let (mantissa, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{power}", trimmed(mantissa));
    }
    let power = if size > 0.0 { size.log10().floor() } else { 0.0 };
    trimmed(&format!("{x:.*}", (5.0 - power).max(0.0) as usize)).to_owned()
}

/// Without zeros at the end of a fraction.
fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// A column of a table: its heading, the explanation of it, and the cell of a row.
pub struct Column<'a> {
    /// Heading.
    pub heading: String,
    /// What it holds; empty if the heading says it.
    pub meaning: &'a str,
    /// Key in the rows.
    pub key: &'a str,
}

/// A table of `rows`; numbers keep all their digits in `data-value`.
pub fn table(caption: &str, columns: &[Column<'_>], rows: &[Map<String, Value>]) -> String {
    let mut out = String::from("<div class=\"wide\"><table>");
    if !caption.is_empty() {
        let _ = write!(out, "<caption>{}</caption>", escaped(caption));
    }
    out.push_str("<thead><tr>");
    for column in columns {
        let _ = write!(
            out,
            "<th scope=\"col\" title=\"{}\">{}</th>",
            escaped(column.meaning),
            escaped(&column.heading)
        );
    }
    out.push_str("</tr></thead><tbody>");
    for row in rows {
        out.push_str("<tr>");
        for column in columns {
            out.push_str(&cell(row.get(column.key).unwrap_or(&Value::Null)));
        }
        out.push_str("</tr>");
    }
    out.push_str("</tbody></table></div>");
    out
}

fn cell(value: &Value) -> String {
    match value {
        Value::Number(n) => {
            let x = n.as_f64().unwrap_or(f64::NAN);
            let text = if n.is_f64() { number(x) } else { n.to_string() };
            format!("<td class=\"n\" data-value=\"{n}\">{text}</td>")
        }
        Value::Null => "<td class=\"n\">–</td>".into(),
        Value::String(text) => format!("<td>{}</td>", escaped(text)),
        Value::Array(all) => {
            let parts: Vec<String> =
                all.iter().map(|v| v.as_f64().map_or_else(|| v.to_string(), number)).collect();
            format!("<td class=\"n\">{}</td>", escaped(&parts.join(" × ")))
        }
        other => format!("<td>{}</td>", escaped(&other.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn foreign_text_is_shown_and_not_obeyed() {
        let text = "</script><img src=x onerror='alert(\"1\")'>&";
        let safe = escaped(text);
        assert!(!safe.contains(['<', '>', '"', '\'']), "{safe}");
        assert_eq!(in_script(&json!({ "a": text })).find('<'), None);
    }

    #[test]
    fn numbers_have_six_digits() {
        for (x, wanted) in [
            (302.712_34, "302.712"),
            (7.31e-5, "7.31e-5"),
            (0.0, "0"),
            (0.166_821_3, "0.166821"),
            (-0.5, "-0.5"),
            (123_456.7, "123457"),
            (100.0, "100"),
            (2.1e11, "2.1e11"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(number(x), wanted);
        }
    }
}
