//! Stress along the lines that the scenario asks for.

use super::{curve, labels, names, title};
use crate::plot::data::{ResultData, StressLine};
use crate::plot::figure::{Axis, Figure, Panel, entries};

/// Part of the largest component below which one is nothing: what elements leave of a stress that
/// vanishes.
const NOTHING: f64 = 1e-6;
/// How the legend calls the von Mises stress.
const VON_MISES: &str = "von Mises";

/// One figure per line over the distance from its first point. One file: a curve per component.
/// Several: a panel per component.
pub fn figures(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let lines = names(files.iter().flat_map(|f| f.lines.iter().map(|l| l.name.as_str())));
    if lines.is_empty() {
        return Err("the scenario asks for no lines, see output.stress".into());
    }
    Ok(lines.into_iter().map(|name| figure(files, name)).collect())
}

fn figure(files: &[ResultData], name: &str) -> Figure {
    let found: Vec<(usize, &StressLine)> = files
        .iter()
        .enumerate()
        .filter_map(|(i, f)| f.lines.iter().find(|l| l.name == name).map(|line| (i, line)))
        .collect();
    let components = acting(&found);
    let mut figure = Figure { name: format!("line_{name}"), columns: 1, ..Figure::default() };
    let panel = |quantity: &str| Panel {
        x: Axis::new("distance", "m"),
        y: Axis::new(quantity, "Pa"),
        ..Panel::default()
    };
    let along = |line: &StressLine, i: usize, component: &str| {
        series(line, component).map(|y| curve(i, &line.distance, y))
    };
    let mut subject = format!("stress along {name}");
    if let ([_], [(_, line)]) = (files, found.as_slice()) {
        subject += &format!(" at {}", super::forces::time(line.time));
        let mut all = panel("stress");
        all.curves.extend(components.iter().enumerate().filter_map(|(i, c)| along(line, i, c)));
        figure.panels.push(all);
        figure.legend = entries(components.iter().copied());
    } else {
        for component in &components {
            let mut one = panel(&format!("stress {component}"));
            one.curves.extend(found.iter().filter_map(|(i, line)| along(line, *i, component)));
            figure.panels.push(one);
        }
        figure.legend = entries(labels(files));
    }
    Figure { title: title(files, &subject), ..figure }
}

fn series<'a>(line: &'a StressLine, component: &str) -> Option<&'a [f64]> {
    if component == VON_MISES {
        return Some(&line.von_mises);
    }
    line.components.iter().find(|(label, _)| label == component).map(|(_, values)| values.as_slice())
}

/// Von Mises stress, and the components that are not nothing in any file.
fn acting<'a>(found: &[(usize, &'a StressLine)]) -> Vec<&'a str> {
    let size = |values: &[f64]| values.iter().filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
    let sizes =
        || found.iter().flat_map(|(_, line)| line.components.iter().map(|(l, v)| (l.as_str(), size(v))));
    let largest = sizes().map(|(_, s)| s).fold(0.0, f64::max);
    let acting = names(sizes().filter(|(_, s)| *s > NOTHING * largest).map(|(label, _)| label));
    [VON_MISES].into_iter().chain(acting).collect()
}
