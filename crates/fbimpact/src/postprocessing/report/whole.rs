//! The report of several results, no larger than it may be.

use serde_json::{Value, json};

use super::charts::Charts;
use super::encode::Blob;
use super::html::{escaped, number};
use super::motion::{FINENESS, Fineness, Motion};
use super::page::{Contents, page};
use super::tables::{Told, overview, result};
use crate::process::provenance;

/// Bytes of a megabyte.
const MEGABYTE: f64 = 1e6;

/// The motion of a result, or why there is none.
pub enum Scene {
    /// Bodies in motion.
    Moving(Box<Motion>),
    /// There is nothing to be seen, for this reason.
    Without(String),
}

/// What a report is made from.
pub struct Parts<'a> {
    /// The results.
    pub results: &'a [Told<'a>],
    /// Figures of all of them.
    pub charts: &'a Charts,
    /// Motions in the order of the results; none if nobody wants them.
    pub scenes: &'a [Scene],
}

/// A report, and what had to be left out of it.
pub struct Report {
    /// The page.
    pub text: String,
    /// What the size cost, a sentence; empty if nothing.
    pub note: String,
}

/// The report of `parts`, of `most` megabytes at most as far as motions can be made coarser.
pub fn report(parts: &Parts<'_>, most: f64) -> Report {
    let mut last = Report { text: String::new(), note: String::new() };
    for (level, fineness) in FINENESS.iter().enumerate() {
        let note = match level {
            0 => String::new(),
            _ if fineness.stress_bits.is_some() => format!(
                "Motion is stored to {} of the largest values, as finer the report were larger than {} MB.",
                number(fineness.tolerance),
                number(most)
            ),
            _ if fineness.has_shapes => format!(
                "Stress of the bodies in motion is left out, as with it the report were larger than {} MB.",
                number(most)
            ),
            _ => format!(
                "Bodies move without deformation, as with it the report were larger than {} MB.",
                number(most)
            ),
        };
        last = Report { text: text(parts, fineness, &note), note };
        if last.text.len() as f64 <= most * MEGABYTE || !parts.has_motion() {
            return last;
        }
    }
    if parts.has_motion() {
        let note = format!(
            "Bodies in motion are left out, as with them the report were larger than {} MB.",
            number(most)
        );
        let without: Vec<Scene> = parts.scenes.iter().map(|_| Scene::Without(note.clone())).collect();
        let parts = Parts { scenes: &without, ..*parts };
        last = Report { text: text(&parts, &FINENESS[0], ""), note };
    }
    last
}

impl Parts<'_> {
    fn has_motion(&self) -> bool {
        self.scenes.iter().any(|scene| matches!(scene, Scene::Moving(_)))
    }
}

fn text(parts: &Parts<'_>, fineness: &Fineness, note: &str) -> String {
    let (mut scenes, mut blobs): (Vec<Value>, Vec<Blob>) = (Vec::new(), vec![parts.charts.blob.clone()]);
    let mut places = String::new();
    for (i, (scene, told)) in parts.scenes.iter().zip(parts.results).enumerate() {
        let title =
            if parts.results.len() > 1 { format!("<h3>{}</h3>", escaped(told.label)) } else { String::new() };
        let inner = match scene {
            Scene::Moving(motion) => {
                let (head, of_scene) = motion.encoded(&format!("scene-{i}"), fineness);
                scenes.push(head);
                blobs.extend(of_scene);
                let script =
                    "The bodies are drawn by a script with WebGL2; the figures below show the same run.";
                let left_out = motion.left_out.iter().map(|sentence| format!("Here {sentence}."));
                let notes = std::iter::once(script.to_owned()).chain(left_out);
                notes.map(|note| format!("<p class=\"note\">{}</p>", escaped(&note))).collect()
            }
            Scene::Without(reason) => {
                scenes.push(Value::Null);
                format!("<p class=\"note\">{}</p>", escaped(reason))
            }
        };
        places += &format!("<div class=\"scene\" id=\"scene-{i}\">{title}{inner}</div>\n");
    }
    if !places.is_empty() {
        places = format!("<section><h2>Motion</h2><div class=\"scenes\">{places}</div></section>");
    }
    let labels: Vec<&str> = parts.results.iter().map(|told| told.label).collect();
    let info: Vec<&Value> = parts.results.iter().map(|told| told.json).collect();
    let head = json!({
        "format": "fbimpact-report", "version": 1, "program": provenance::VERSION,
        "labels": labels, "results": info, "charts": parts.charts.data, "scenes": scenes,
    });
    let title = match parts.results {
        [one] if !one.summary.attribute("title").is_empty() => one.summary.attribute("title").to_owned(),
        _ => labels.join(", "),
    };
    let note =
        if note.is_empty() { String::new() } else { format!("<p class=\"note\">{}</p>", escaped(note)) };
    page(&Contents {
        title: &title,
        tables: &tables(parts.results),
        scenes: &format!("{places}{note}"),
        figures: &parts.charts.html,
        notes: &format!(
            "<p>Written by fbimpact {}. All values in SI units.</p>",
            escaped(provenance::VERSION)
        ),
        head: &head,
        blobs: &blobs,
    })
}

fn tables(results: &[Told<'_>]) -> String {
    match results {
        [one] => result(one, false),
        all => {
            let each: String = all.iter().map(|told| result(told, true)).collect();
            format!("{}<div class=\"results\">{each}</div>", overview(all))
        }
    }
}
