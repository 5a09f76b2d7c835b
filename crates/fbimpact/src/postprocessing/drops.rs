//! Falls of a part in many orientations: a table, data for programs, and a page with a globe.

mod globe;

use std::fmt::Write as _;

use nalgebra::Vector3;
use result_files::expression::named::Cell;
use serde_json::{Value, json};

use super::report::html::{escaped, number};
use globe::globe;

/// A fall in one orientation.
#[derive(Debug, Clone, PartialEq)]
pub struct Fall {
    /// Name of the orientation, and of the files of its run.
    pub name: String,
    /// Direction of the part that pointed down, a unit vector.
    pub down: Vector3<f64>,
    /// Whether the run is complete.
    pub is_complete: bool,
    /// Why not.
    pub message: String,
    /// Largest normal force, negative infinity of a run without an impact \[N\].
    pub peak_force: f64,
    /// Impulse \[N s\], duration \[s\] and restitution of that impact.
    pub numbers: [f64; 3],
    /// Largest displacements, accelerations and stresses at observed points.
    pub cells: Vec<Cell>,
    /// Identifiers of warnings.
    pub warnings: Vec<String>,
    /// Whether the run has a report of its own.
    pub has_report: bool,
    /// Pictures of its impact, in the folder `figures`.
    pub pictures: Vec<String>,
}

/// All falls of a part, the hardest first.
#[derive(Debug, Clone, Copy)]
pub struct Falls<'a> {
    /// Title.
    pub title: &'a str,
    /// Name of the body.
    pub body: &'a str,
    /// Speed at the floor [m/s].
    pub speed: f64,
    /// The falls.
    pub rows: &'a [Fall],
}

/// Headings of the numbers of a fall.
const NUMBERS: [&str; 3] = ["impulse [N s]", "duration [s]", "restitution"];
/// The style of reports of single runs.
const STYLE: &str = include_str!("../../assets/report/style.css");

impl Falls<'_> {
    /// Names of observed numbers with their units, in the order of the first fall that has them.
    fn observed(&self) -> Vec<(String, String)> {
        let mut all: Vec<(String, String)> = Vec::new();
        for cell in self.rows.iter().flat_map(|row| &row.cells) {
            if all.iter().all(|(name, _)| *name != cell.name) {
                all.push((cell.name.clone(), cell.unit.clone()));
            }
        }
        all
    }

    /// The falls as a table for people.
    pub fn table(&self) -> String {
        let width = self.rows.iter().map(|row| row.name.len()).max().unwrap_or(0).max(11);
        let mut out =
            format!("{:<width$} {:>13} {:>13} {:>13}\n", "orientation", "peak [N]", NUMBERS[0], NUMBERS[1]);
        for row in self.rows {
            // Writing to a string cannot fail.
            let _ = if row.is_complete && row.peak_force.is_finite() {
                let [impulse, duration, _] = row.numbers;
                writeln!(
                    out,
                    "{:<width$} {:>13} {:>13} {:>13}",
                    row.name,
                    number(row.peak_force),
                    number(impulse),
                    number(duration)
                )
            } else {
                writeln!(out, "{:<width$} {}", row.name, row.fault())
            };
        }
        out
    }

    /// The falls for programs.
    pub fn json(&self) -> Value {
        let finite = |x: f64| x.is_finite().then_some(x);
        let row = |row: &Fall| {
            let [impulse, duration, restitution] = row.numbers.map(finite);
            let observed: serde_json::Map<String, Value> = row
                .cells
                .iter()
                .map(|c| (c.name.clone(), json!({ "unit": c.unit, "value": c.number })))
                .collect();
            json!({
                "orientation": row.name, "down": row.down.as_slice(), "complete": row.is_complete, "message": row.message,
                "peak_force": finite(row.peak_force), "impulse": impulse, "duration": duration, "restitution": restitution,
                "observed": observed, "warnings": row.warnings,
            })
        };
        json!({ "title": self.title, "body": self.body, "speed": self.speed, "falls": self.rows.iter().map(row).collect::<Vec<_>>() })
    }

    /// The falls as a page that opens in any browser.
    pub fn page(&self) -> String {
        let worst = self.rows.first().filter(|row| row.peak_force.is_finite());
        let verdict = worst.map_or("No run has an impact.".to_owned(), |row| {
            format!("Hardest: {}, {} N", row.name, number(row.peak_force))
        });
        let failed = self.rows.iter().filter(|row| !row.is_complete).count();
        let class = if failed > 0 { "bad" } else { "good" };
        let told = if failed > 0 { format!(" {failed} runs are not complete.") } else { String::new() };
        let mut out = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"generator\" content=\"fbimpact\">\
             <meta name=\"viewport\" content=\"width=device-width\"><title>{0}</title><style>{STYLE}</style></head><body>\n<h1>{0}</h1>\n\
             <div class=\"verdict {class}\"><p class=\"status\">{1}</p><p>Body {2} in {3} orientations, {4} m/s at the floor.{told}</p></div>\n",
            escaped(self.title),
            escaped(&verdict),
            escaped(self.body),
            self.rows.len(),
            number(self.speed)
        );
        let _ = writeln!(
            out,
            "<figure><figcaption>Peak force by the side of the part that is down</figcaption>{}<p class=\"note\">The part's directions, seen from x+ y+ z+ \
             and from the opposite side. Dots are the orientations that were run; around them their peak force, without interpolation.</p></figure>",
            globe(self.rows)
        );
        self.write_rows(&mut out);
        for (row, picture) in self.rows.iter().flat_map(|row| row.pictures.iter().map(move |p| (row, p))) {
            let (name, picture) = (escaped(&row.name), escaped(picture));
            let _ = writeln!(
                out,
                "<figure><figcaption>{name}</figcaption><img class=\"drawing\" src=\"figures/{picture}\" alt=\"Force over time of {name}\"></figure>"
            );
        }
        out.push_str("</body></html>\n");
        out
    }

    fn write_rows(&self, out: &mut String) {
        let observed = self.observed();
        out.push_str("<h2>Orientations, the hardest first</h2><div class=\"wide\"><table><thead><tr><th>down</th><th>peak force [N]</th>");
        let columns = NUMBERS.iter().map(|name| (*name).to_owned());
        for heading in columns.chain(
            observed.iter().map(|(name, unit)| format!("{} [{unit}]", name.trim_start_matches("points."))),
        ) {
            let _ = write!(out, "<th>{}</th>", escaped(&heading));
        }
        out.push_str("<th>warnings</th></tr></thead><tbody>\n");
        for row in self.rows {
            let name = escaped(&row.name);
            let link = if row.has_report { format!("<a href=\"{name}.html\">{name}</a>") } else { name };
            let _ = write!(out, "<tr><td>{link}</td>");
            if row.is_complete {
                let value =
                    |name: &String| row.cells.iter().find(|c| c.name == *name).map_or(f64::NAN, |c| c.number);
                let numbers = row.numbers.into_iter().chain(observed.iter().map(|(name, _)| value(name)));
                for x in std::iter::once(row.peak_force).chain(numbers) {
                    let _ = write!(out, "<td class=\"n\">{}</td>", number(x));
                }
                let _ = writeln!(out, "<td>{}</td></tr>", escaped(&row.warnings.join(", ")));
            } else {
                let _ = writeln!(
                    out,
                    "<td colspan=\"{}\">{}</td></tr>",
                    5 + observed.len(),
                    escaped(&row.fault())
                );
            }
        }
        out.push_str("</tbody></table></div>\n");
    }
}

impl Fall {
    /// Why it has no numbers.
    fn fault(&self) -> String {
        if self.is_complete { "no impact".to_owned() } else { self.message.clone() }
    }
}
