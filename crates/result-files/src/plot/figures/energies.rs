//! Energies over time.

use super::{bands, curve, labels, names, shade_entries, time_axis, title};
use crate::plot::data::ResultData;
use crate::plot::figure::{Axis, Figure, Panel, entries};

/// Kinds of energy in the order of the legend, and how people call them.
const WORDS: [(&str, &str); 10] = [
    ("total", "total"),
    ("kinetic", "kinetic"),
    ("elastic_low", "elastic, low frequencies"),
    ("elastic_high", "elastic, contact zone"),
    ("penalty", "penalty"),
    ("gravity", "gravity"),
    ("dissipated", "dissipated"),
    ("supplied", "supplied"),
    ("springs", "springs"),
    ("numerical", "numerical damping"),
];

/// Part of the largest energy below which a kind is nothing.
const NOTHING: f64 = 1e-12;

/// One file: all energies in one panel, the change of the total below. Several: one panel a kind.
pub fn figures(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let kinds = kinds(files);
    if kinds.is_empty() {
        return Err("no energies are stored or all are zero".into());
    }
    let mut figure =
        Figure { name: "energies".into(), title: title(files, "energies"), columns: 1, ..Figure::default() };
    let time = time_axis(files);
    let panel = |title: &str| Panel {
        title: title.into(),
        x: time.clone(),
        y: Axis::new("energy", "J"),
        ..Panel::default()
    };
    if let [file] = files {
        let mut all = Panel { bands: bands(files), ..panel("") };
        for (i, (name, _)) in kinds.iter().enumerate() {
            all.curves.extend(series(file, name).map(|y| curve(i, &file.time, y)));
        }
        figure.legend = entries(kinds.iter().map(|(_, words)| *words));
        figure.legend.extend(shade_entries(&all.bands));
        figure.panels.push(all);
    } else {
        figure.legend = entries(labels(files));
        for (name, words) in kinds.iter().filter(|(name, _)| *name != "total") {
            let mut one = panel(words);
            for (i, file) in files.iter().enumerate() {
                one.curves.extend(series(file, name).map(|y| curve(i, &file.time, y)));
            }
            figure.panels.push(one);
        }
    }
    figure.panels.push(drift(files, &panel("change of the total energy")));
    Ok(vec![figure])
}

fn series<'a>(file: &'a ResultData, name: &str) -> Option<&'a [f64]> {
    file.energies.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
}

/// Kinds that are something in any file, with their words.
fn kinds(files: &[ResultData]) -> Vec<(&str, &str)> {
    let stored = names(files.iter().flat_map(|f| f.energies.iter().map(|(n, _)| n.as_str())));
    let largest = |name: &str| {
        let values = files.iter().filter_map(|f| series(f, name)).flatten();
        values.filter(|v| v.is_finite()).fold(0.0f64, |a, v| a.max(v.abs()))
    };
    let all = stored.iter().map(|n| largest(n)).fold(0.0, f64::max);
    let rank = |name: &str| WORDS.iter().position(|(n, _)| *n == name).unwrap_or(WORDS.len());
    let mut kinds: Vec<(&str, &str)> = stored
        .into_iter()
        .filter(|n| largest(n) > NOTHING * all)
        .map(|n| (n, WORDS.iter().find(|(name, _)| *name == n).map_or(n, |(_, words)| *words)))
        .collect();
    kinds.sort_by_key(|(name, _)| rank(name));
    kinds
}

/// Total energy less that at the start.
fn drift(files: &[ResultData], panel: &Panel) -> Panel {
    let mut panel = panel.clone();
    for (i, file) in files.iter().enumerate() {
        let Some(total) = series(file, "total") else { continue };
        let change: Vec<f64> = total.iter().map(|e| e - total[0]).collect();
        panel.curves.push(curve(i, &file.time, &change));
    }
    panel
}
