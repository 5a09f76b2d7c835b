//! What joints transmit, over time.

use super::{bands, curve, labels, names, shade_entries, time_axis, title};
use crate::plot::data::{Components, ResultData};
use crate::plot::figure::{Axis, Figure, Panel, entries};

/// Names of the components.
const AXES: [&str; 3] = ["x", "y", "z"];
/// Part of the largest component below which one is nothing.
const NOTHING: f64 = 1e-9;

/// One figure per joint: force above moment. One file: a curve per component. Several: a panel per
/// component.
pub fn figures(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let joints = names(files.iter().flat_map(|f| f.reactions.iter().map(|r| r.0.as_str())));
    if joints.is_empty() {
        return Err(
            "no reactions are stored: there are no joints, or the file is of an earlier version".into()
        );
    }
    Ok(joints.into_iter().map(|name| figure(files, name)).collect())
}

fn figure(files: &[ResultData], name: &str) -> Figure {
    let mut figure = Figure {
        name: format!("joint_{name}"),
        title: title(files, &format!("reaction of joint {name}")),
        columns: 1,
        ..Figure::default()
    };
    let stored = |f: &ResultData| f.reactions.iter().position(|r| r.0 == name);
    let found: Vec<(usize, &ResultData, usize)> =
        files.iter().enumerate().filter_map(|(i, f)| Some((i, f, stored(f)?))).collect();
    // A moment of round-off is nothing beside the force on a lever of a metre.
    let largest = |pick: fn(&(String, Components, Components)) -> &Components| {
        found
            .iter()
            .map(|(_, f, k)| peak(pick(&f.reactions[*k])))
            .fold([0.0; 3], |a, b| std::array::from_fn(|c| f64::max(a[c], b[c])))
    };
    let (forces, moments) = (largest(|r| &r.1), largest(|r| &r.2));
    let force = forces.into_iter().fold(0.0, f64::max);
    let parts: [(&str, &str, [f64; 3], bool); 2] =
        [("force", "N", forces, false), ("moment", "N m", moments, true)];
    let acting = parts.map(|(_, _, peaks, is_moment)| {
        let all = peaks.into_iter().fold(0.0, f64::max);
        let floor = NOTHING * if is_moment { all.max(force) } else { all };
        (0..3).filter(|c| peaks[*c] > floor).collect::<Vec<usize>>()
    });
    // Styles of the components that are shown, the first one solid.
    let shown: Vec<usize> = (0..3).filter(|c| acting.iter().any(|part| part.contains(c))).collect();
    let style = |c: usize| shown.iter().position(|s| *s == c).unwrap_or(0);
    for ((quantity, unit, _, is_moment), acting) in parts.into_iter().zip(&acting) {
        let values = |f: &ResultData, k: usize, c: usize| {
            let (_, force, moment) = &f.reactions[k];
            if is_moment { moment[c].clone() } else { force[c].clone() }
        };
        if acting.is_empty() {
            continue;
        }
        if let ([_], [(_, file, k)]) = (files, found.as_slice()) {
            let mut panel = Panel { bands: bands(files), ..panel(files, quantity, unit) };
            panel.curves.extend(acting.iter().map(|&c| curve(style(c), &file.time, &values(file, *k, c))));
            figure.panels.push(panel);
            continue;
        }
        for &c in acting {
            let mut one = panel(files, &format!("{quantity} {}", AXES[c]), unit);
            one.curves.extend(found.iter().map(|(i, f, k)| curve(*i, &f.time, &values(f, *k, c))));
            figure.panels.push(one);
        }
    }
    if files.len() > 1 {
        figure.legend = entries(labels(files));
        return figure;
    }
    figure.legend = entries(shown.iter().map(|c| AXES[*c]));
    if let Some(first) = figure.panels.first() {
        figure.legend.extend(shade_entries(&first.bands));
    }
    figure
}

fn panel(files: &[ResultData], quantity: &str, unit: &str) -> Panel {
    Panel { x: time_axis(files), y: Axis::new(quantity, unit), ..Panel::default() }
}

/// Largest magnitude of each component.
fn peak(components: &Components) -> [f64; 3] {
    std::array::from_fn(|c| {
        components[c].iter().filter(|v| v.is_finite()).fold(0.0, |a: f64, v| a.max(v.abs()))
    })
}
