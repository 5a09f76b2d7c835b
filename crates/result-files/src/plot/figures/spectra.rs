//! Spectra of the points that the scenario names.

use super::{labels, names, title};
use crate::plot::curve::spectrum::{Spectrum, spectrum};
use crate::plot::curve::thin::thinned;
use crate::plot::data::ResultData;
use crate::plot::figure::{Axis, Curve, Figure, Panel, entries};

/// Part of the largest amplitude below which a line is round-off.
const FLOOR: f64 = 1e-8;
/// Part of the largest component below which one is nothing.
const NOTHING: f64 = 1e-6;

/// A history: its component and its values.
type Component<'a> = (&'a str, &'a [f64]);

/// One figure a point: the amplitudes of its velocity, above those of its stress if that is stored.
pub fn figures(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let points = names(files.iter().flat_map(|f| f.points.iter().map(|p| p.0.as_str())));
    if points.is_empty() {
        return Err("the scenario names no points, see output.points".into());
    }
    let figures: Vec<Figure> = points.into_iter().filter_map(|name| figure(files, name)).collect();
    if figures.is_empty() {
        return Err("too few instants are stored".into());
    }
    Ok(figures)
}

fn figure(files: &[ResultData], name: &str) -> Option<Figure> {
    let mut figure = Figure {
        name: format!("spectrum_{name}"),
        title: title(files, &format!("spectra of point {name}")),
        columns: 1,
        ..Figure::default()
    };
    let mut shown = Vec::new();
    for (quantity, unit) in [("velocity", "m/s"), ("stress", "Pa")] {
        let spectra: Vec<Vec<(&str, Spectrum)>> =
            files.iter().map(|file| spectra(file, &components(file, name, quantity))).collect();
        let found = names(spectra.iter().flatten().map(|(component, _)| *component));
        if found.is_empty() {
            continue;
        }
        let panel = |quantity: String| Panel {
            x: Axis::new("frequency", "Hz"),
            y: Axis { is_log: true, ..Axis::new(quantity, unit) },
            ..Panel::default()
        };
        if let [file] = spectra.as_slice() {
            let mut all = panel(format!("amplitude of {quantity}"));
            let first = shown.len();
            all.curves.extend(file.iter().enumerate().map(|(k, (_, s))| curve(first + k, s)));
            shown.extend(found.iter().map(|component| format!("{quantity} {component}")));
            figure.panels.push(all);
            continue;
        }
        for component in found {
            let mut one = panel(format!("amplitude of {quantity} {component}"));
            let curves = spectra.iter().enumerate().filter_map(|(i, file)| {
                let (_, spectrum) = file.iter().find(|(c, _)| *c == component)?;
                Some(curve(i, spectrum))
            });
            one.curves.extend(curves);
            figure.panels.push(one);
        }
    }
    let words: Vec<&str> = shown.iter().map(String::as_str).collect();
    figure.legend = if files.len() > 1 { entries(labels(files)) } else { entries(words) };
    (!figure.panels.is_empty()).then_some(figure)
}

/// Components of a quantity of point `name`.
fn components<'a>(file: &'a ResultData, name: &str, quantity: &str) -> Vec<Component<'a>> {
    if quantity == "velocity" {
        let point = file.points.iter().find(|p| p.0 == name);
        let of = |(_, _, v): &'a (_, _, crate::plot::data::Components)| -> Vec<Component<'a>> {
            ["x", "y", "z"].into_iter().zip(v).map(|(c, v)| (c, v.as_slice())).collect()
        };
        return point.map(of).unwrap_or_default();
    }
    let stress = file.stresses.iter().find(|s| s.0 == name);
    stress.map(|s| s.1.iter().map(|(c, v)| (c.as_str(), v.as_slice())).collect()).unwrap_or_default()
}

/// Spectra of those components that change, by their names.
fn spectra<'a>(file: &ResultData, components: &[Component<'a>]) -> Vec<(&'a str, Spectrum)> {
    let size = |v: &[f64]| v.iter().filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
    let largest = components.iter().map(|(_, v)| size(v)).fold(0.0, f64::max);
    let acting = components.iter().filter(|(_, v)| largest > 0.0 && size(v) > NOTHING * largest);
    acting.filter_map(|(name, v)| Some((*name, spectrum(&file.time, v)?))).collect()
}

fn curve(style: usize, spectrum: &Spectrum) -> Curve {
    let floor = FLOOR * spectrum.amplitude.iter().fold(0.0f64, |m, a| m.max(*a));
    let amplitude: Vec<f64> = spectrum.amplitude.iter().map(|a| a.max(floor)).collect();
    let (x, y) = thinned(&spectrum.frequency, &amplitude, super::COLUMNS);
    Curve { style, x, y, marks: Vec::new() }
}
