//! The figures: which curves in which panels.

mod energies;
mod forces;
mod joints;
mod points;
mod pressure;
mod spectra;
mod stress_lines;
mod trials;

use super::curve::thin::thinned;
use super::data::ResultData;
use super::figure::{Axis, Curve, Entry, Figure, Shade, Sign};

/// Parts of a curve that are told apart: two per pixel.
const COLUMNS: usize = 1400;

/// Kinds of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// Energies over time.
    Energies,
    /// Contact forces of the whole run, phases shaded.
    Forces,
    /// Contact force of every impact.
    Impacts,
    /// Utilisation of the contact interval, penalty factor and width of the interval over trials.
    #[value(name = "tries", alias = "trials")]
    Trials,
    /// Position and velocity of the chosen points, and stress where it is stored.
    Points,
    /// Force and moment that each joint transmits.
    Joints,
    /// Stress along the lines that the scenario asks for.
    Stress,
    /// Contact pressure at the largest force of each contact.
    Pressure,
    /// Amplitude spectra of velocity and stress of the chosen points; drawn if asked for.
    Spectra,
}

impl Kind {
    /// The figures that are drawn unless others are asked for.
    pub const USUAL: [Self; 8] = [
        Self::Energies,
        Self::Forces,
        Self::Impacts,
        Self::Trials,
        Self::Points,
        Self::Joints,
        Self::Stress,
        Self::Pressure,
    ];

    /// Figures of this kind, or why there are none.
    pub fn figures(self, files: &[ResultData]) -> Result<Vec<Figure>, String> {
        match self {
            Self::Energies => energies::figures(files),
            Self::Forces => forces::overview(files),
            Self::Impacts => forces::impacts(files),
            Self::Trials => trials::figures(files),
            Self::Points => points::figures(files),
            Self::Joints => joints::figures(files),
            Self::Stress => stress_lines::figures(files),
            Self::Pressure => pressure::figures(files),
            Self::Spectra => spectra::figures(files),
        }
    }
}

/// Title of a figure about `subject`; several files have no title in common.
fn title(files: &[ResultData], subject: &str) -> String {
    match files {
        [one] if !one.title.is_empty() => format!("{}: {subject}", one.title),
        _ => {
            let mut letters = subject.chars();
            let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
            first + letters.as_str()
        }
    }
}

/// The axis of time over the whole run.
fn time_axis(files: &[ResultData]) -> Axis {
    let ends = files.iter().filter_map(|f| Some((*f.time.first()?, *f.time.last()?)));
    let range = ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).filter(|(a, b)| b > a);
    Axis { range, ..Axis::new("time", "s") }
}

/// A curve over time.
fn curve(style: usize, x: &[f64], y: &[f64]) -> Curve {
    let (x, y) = thinned(x, y, COLUMNS);
    Curve { style, x, y, marks: Vec::new() }
}

/// Names that occur in any file, in the order of their first occurrence.
fn names<'a>(lists: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut all = Vec::new();
    for name in lists {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}

/// Phases of the only file as shades, if there are several; those of several files would cover each
/// other.
fn bands(files: &[ResultData]) -> Vec<(f64, f64, Shade)> {
    let [file] = files else { return Vec::new() };
    if file.phases.len() < 2 {
        return Vec::new();
    }
    let phases = file.phases.iter().map(|p| {
        let shade = if p.kind.as_str() == "free" { Shade::Free } else { Shade::Impact };
        (p.start, p.end, shade)
    });
    phases.collect()
}

/// Legend entries of the shades in `bands`.
fn shade_entries(bands: &[(f64, f64, Shade)]) -> Vec<Entry> {
    let kinds = [(Shade::Impact, "impact phase"), (Shade::Free, "free phase")];
    let kinds = kinds.into_iter().filter(|(shade, _)| bands.iter().any(|b| b.2 == *shade));
    kinds.map(|(shade, label)| Entry { sign: Sign::Shade(shade), label: label.into() }).collect()
}

/// Labels of the files.
fn labels(files: &[ResultData]) -> impl Iterator<Item = &str> {
    files.iter().map(|f| f.label.as_str())
}
