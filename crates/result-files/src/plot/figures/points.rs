//! Motion of the points that the scenario names.

use super::{curve, labels, names, time_axis, title};
use crate::plot::data::{Components, Named, ResultData};
use crate::plot::figure::{Axis, Figure, Panel, entries};

/// Names of the components.
const AXES: [&str; 3] = ["x", "y", "z"];
/// Part of the largest component below which one is nothing: what rounding and the parts of a mesh
/// leave of symmetry.
const NOTHING: f64 = 1e-6;
/// The same of stress: what elements leave of a stress that vanishes.
const STRESSLESS: f64 = 1e-6;

/// One figure per point: displacement from its first place, and velocity; a panel per component, a
/// curve per file.
pub fn figures(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let points = names(files.iter().flat_map(|f| f.points.iter().map(|p| p.0.as_str())));
    if points.is_empty() {
        return Err("the scenario names no points, see output.points".into());
    }
    let motions = points.iter().map(|name| figure(files, name));
    let stresses = points.iter().filter_map(|name| stress(files, name));
    Ok(motions.chain(stresses).collect())
}

/// Stress at a point, if any file has it: a panel a component, of those that are not nothing.
fn stress(files: &[ResultData], name: &str) -> Option<Figure> {
    let found: Vec<(usize, &ResultData, &Named)> = files
        .iter()
        .enumerate()
        .filter_map(|(i, f)| f.stresses.iter().find(|s| s.0 == name).map(|s| (i, f, &s.1)))
        .collect();
    let size = |v: &[f64]| v.iter().filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
    let sizes =
        || found.iter().flat_map(|(_, _, all)| all.iter().map(|(label, v)| (label.as_str(), size(v))));
    let largest = sizes().map(|(_, s)| s).fold(0.0, f64::max);
    let acting = names(sizes().filter(|(_, s)| *s > STRESSLESS * largest).map(|(label, _)| label));
    let mut figure = Figure {
        name: format!("stress_{name}"),
        title: title(files, &format!("stress at point {name}")),
        columns: 1,
        legend: if files.len() > 1 { entries(labels(files)) } else { Vec::new() },
        ..Figure::default()
    };
    for component in acting {
        let mut panel = Panel {
            x: time_axis(files),
            y: Axis::new(format!("stress {component}"), "Pa"),
            ..Panel::default()
        };
        panel.curves.extend(found.iter().filter_map(|(i, file, all)| {
            let (_, values) = all.iter().find(|(label, _)| label == component)?;
            Some(curve(if files.len() > 1 { *i } else { 0 }, &file.time, values))
        }));
        figure.panels.push(panel);
    }
    (!figure.panels.is_empty()).then_some(figure)
}

fn figure(files: &[ResultData], name: &str) -> Figure {
    let found: Vec<(usize, &ResultData, &Components, &Components)> = files
        .iter()
        .enumerate()
        .filter_map(|(i, f)| f.points.iter().find(|p| p.0 == name).map(|(_, x, v)| (i, f, x, v)))
        .collect();
    let moving = moving(&found.iter().map(|(_, _, _, v)| *v).collect::<Vec<_>>());
    let mut figure = Figure {
        name: format!("point_{name}"),
        title: title(files, &format!("point {name}")),
        columns: 1,
        legend: if files.len() > 1 { entries(labels(files)) } else { Vec::new() },
        ..Figure::default()
    };
    for (quantity, unit, is_velocity) in [("displacement", "m", false), ("velocity", "m/s", true)] {
        for &c in &moving {
            let mut panel = Panel {
                x: time_axis(files),
                y: Axis::new(format!("{quantity} {}", AXES[c]), unit),
                ..Panel::default()
            };
            let values =
                |x: &Components, v: &Components| if is_velocity { v[c].clone() } else { from_start(&x[c]) };
            panel.curves.extend(found.iter().map(|(i, f, x, v)| curve(*i, &f.time, &values(x, v))));
            figure.panels.push(panel);
        }
    }
    if moving.len() > 1 {
        (figure.columns, figure.panels) = (2, by_columns(figure.panels));
    }
    figure
}

/// A position less the first one.
fn from_start(position: &[f64]) -> Vec<f64> {
    position.iter().map(|x| x - position[0]).collect()
}

/// Displacements left, velocities right.
fn by_columns(panels: Vec<Panel>) -> Vec<Panel> {
    let half = panels.len() / 2;
    let (left, right) = panels.split_at(half);
    left.iter().zip(right).flat_map(|(a, b)| [a.clone(), b.clone()]).collect()
}

/// Components in which the point moves in any file; all if it never does.
fn moving(velocities: &[&Components]) -> Vec<usize> {
    let largest = |c: usize| velocities.iter().flat_map(|v| &v[c]).fold(0.0f64, |a, v| a.max(v.abs()));
    let all = (0..3).map(largest).fold(0.0, f64::max);
    let moving: Vec<usize> = (0..3).filter(|&c| largest(c) > NOTHING * all).collect();
    if moving.is_empty() { (0..3).collect() } else { moving }
}
