//! `fbimpact modes`: eigenfrequencies and sizes of the reduced models.

use std::fmt::Write as _;
use std::path::Path;

use result_files::words::band::rounded;

use super::digits::short;
use crate::cache;
use crate::cli::CacheArguments;
use crate::commands::scenario_file;
use crate::commands::{Means, body_index, print, threads};
use crate::error::AppError;
use crate::progress::while_building;
use crate::scenario::Override;
use crate::simulate::{self, BodyModes, Coordinates, ModesReport, StaticAnswers};

/// Builds the reduced models and prints their spectra.
///
/// # Errors
/// [`AppError::Command`] for a body that there is not, and whatever reading and building answer.
pub fn modes(
    path: &Path,
    overrides: &[Override],
    body: Option<&str>,
    json: bool,
    means: Means<'_>,
    cache: &CacheArguments,
) -> Result<(), AppError> {
    let n_threads = threads(means.threads)?;
    let scenario = scenario_file::read(path, overrides)?;
    let index = body.map(|name| body_index(name, scenario.bodies.iter().map(|b| &b.name))).transpose()?;
    let cache = cache::open(&cache.settings());
    let report = while_building(means.bar, || simulate::modes_with(&scenario, index, n_threads, &cache))?;
    let text =
        if json { serde_json::to_string_pretty(&report).map(|t| t + "\n") } else { Ok(table(&report)) };
    print(&text?)
}

/// The report for people. Writing to a string cannot fail.
fn table(report: &ModesReport) -> String {
    let mut out = String::new();
    for body in &report.bodies {
        let _ = writeln!(
            out,
            "{}: {} elements, {} degrees of freedom, {} at the interface, mass {:.6e} kg",
            body.name, body.n_elements, body.n_dofs, body.n_interface, body.mass
        );
        for note in &body.chosen {
            let _ = writeln!(out, "       {note}");
        }
        if !body.points.is_empty() {
            let _ = writeln!(out, "  points {}", points(body));
        }
        if !body.frequencies.is_empty() {
            let _ = writeln!(out, "  {}", coordinates(&body.coordinates));
        }
        let n_free = body.coordinates.free_modes + body.coordinates.interface_modes;
        for (i, f) in body.frequencies.iter().enumerate() {
            let is_static = i >= n_free && body.coordinates.interface_modes == 0;
            let band = body.frequency_bands.get(i).filter(|band| **band > 0.0);
            let end = match band {
                Some(band) => format!(" ± {}", rounded(*band)),
                None => if is_static { "  static answer" } else { "" }.to_owned(),
            };
            let _ = writeln!(out, "{:>6} {f:>18.6} Hz{end}", i + 1);
        }
    }
    out
}

/// Named points: `centre (0, 0, 0), top (0, 0, 0.01)`.
fn points(body: &BodyModes) -> String {
    let place = |at: &[f64]| at.iter().map(|x| short(*x)).collect::<Vec<_>>().join(", ");
    body.points.iter().map(|(name, at)| format!("{name} ({})", place(at))).collect::<Vec<_>>().join(", ")
}

/// How many coordinates come from what:
/// `20 free modes, 6 static answers of hinge (child), 5 of hinge (parent)`.
fn coordinates(counts: &Coordinates) -> String {
    let mut out = format!("{} free modes", counts.free_modes);
    if counts.interface_modes > 0 {
        let _ = write!(out, ", {} interface modes", counts.interface_modes);
    }
    for (i, StaticAnswers { to, count }) in counts.static_answers.iter().enumerate() {
        let _ = write!(out, ", {count} {}of {to}", if i == 0 { "static answers " } else { "" });
    }
    out
}
