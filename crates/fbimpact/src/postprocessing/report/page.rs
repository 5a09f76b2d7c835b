//! One page from its parts.

use serde_json::Value;
use sha2::{Digest, Sha256};

use super::encode::{Blob, base64};
use super::html::{escaped, in_script};

const PAGE: &str = include_str!("../../../assets/report/page.html");
const STYLE: &str = include_str!("../../../assets/report/style.css");
const CHARTS_STYLE: &str = include_str!("../../../assets/report/uPlot.css");
const LICENCE: &str = include_str!("../../../assets/report/uPlot.LICENSE");
/// Scripts in the order in which they run.
const SCRIPTS: [&str; 8] = [
    include_str!("../../../assets/report/uPlot.iife.js"),
    include_str!("../../../assets/report/decode.js"),
    include_str!("../../../assets/report/charts.js"),
    include_str!("../../../assets/report/bodies.js"),
    include_str!("../../../assets/report/paint.js"),
    include_str!("../../../assets/report/camera.js"),
    include_str!("../../../assets/report/viewer.js"),
    include_str!("../../../assets/report/main.js"),
];

/// What a page shows.
pub struct Contents<'a> {
    /// Title, as text.
    pub title: &'a str,
    /// Tables, as HTML.
    pub tables: &'a str,
    /// Places of the scenes, as HTML.
    pub scenes: &'a str,
    /// Figures, as HTML.
    pub figures: &'a str,
    /// Remarks at the end, as HTML.
    pub notes: &'a str,
    /// What scripts read.
    pub head: &'a Value,
    /// Numbers that it refers to.
    pub blobs: &'a [Blob],
}

/// The page as text. Nothing in it refers to anything outside; only its own scripts run.
pub fn page(contents: &Contents<'_>) -> String {
    let scripts = SCRIPTS.join("\n");
    let digest = format!("'sha256-{}'", base64(&Sha256::digest(scripts.as_bytes())));
    let blobs: String = contents
        .blobs
        .iter()
        .map(|b| {
            format!("<script type=\"text/plain\" id=\"blob-{}\">{}</script>\n", escaped(&b.name), b.text())
        })
        .collect();
    let style = format!("{CHARTS_STYLE}\n{STYLE}");
    filled(|name| match name {
        "title" => escaped(contents.title),
        "digest" => digest.clone(),
        "style" => style.clone(),
        "tables" => contents.tables.to_owned(),
        "scenes" => contents.scenes.to_owned(),
        "figures" => contents.figures.to_owned(),
        "notes" => contents.notes.to_owned(),
        "licence" => escaped(LICENCE),
        "head" => in_script(contents.head),
        "blobs" => blobs.clone(),
        "scripts" => scripts.clone(),
        _ => String::new(),
    })
}

/// The page with `part` in place of each `{{name}}`; what has been put in is not looked at again.
fn filled(part: impl Fn(&str) -> String) -> String {
    let mut pieces = PAGE.split("{{");
    let mut out = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, rest) = piece.split_once("}}").unwrap_or((piece, ""));
        out.push_str(&part(name));
        out.push_str(rest);
    }
    out
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn page_holds_its_parts_once_and_ends_no_script_early() {
        let head = json!({ "name": "</script><img src=x onerror=alert(1)>{{scripts}}" });
        let contents = Contents {
            title: "<b>{{blobs}}</b>",
            tables: "",
            scenes: "",
            figures: "",
            notes: "",
            head: &head,
            blobs: &[Blob::new("b".into())],
        };
        let page = page(&contents);
        assert!(page.contains("<title>&lt;b&gt;{{blobs}}&lt;/b&gt;"));
        assert!(!page.contains("<img src=x"));
        assert_eq!(page.matches("id=\"head\"").count(), 1);
        assert_eq!(page.matches("<script").count(), page.matches("</script>").count());
    }
}
