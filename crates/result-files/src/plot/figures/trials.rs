//! How the program found interval width and penalty factor: one point per trial.

use super::{labels, title};
use crate::plot::data::ResultData;
use crate::plot::figure::{Axis, Curve, Entry, Figure, Panel, Shade, Sign, entries};
use crate::plot::ticks::Tick;
use crate::tables::{ACCEPTED, TrialRow};

/// Trials whose numbers fit below the axis.
const LABELLED: usize = 24;

/// A quantity of a trial.
type Quantity = fn(&TrialRow) -> f64;

/// Utilisation, penalty factor and width over trials.
pub fn figures(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let most = files.iter().map(|f| f.trials.len()).max().unwrap_or(0);
    if most == 0 {
        return Err("there are no impacts, so there were no trials".into());
    }
    let is_found =
        |f: &ResultData| f.trials.chunk_by(|a, b| a.impact == b.impact).any(|impact| impact.len() > 1);
    if !files.iter().any(is_found) {
        return Err("every impact took one trial".into());
    }
    let ticks = ticks(files, most);
    let quantity = if files.len() == 1 { "impact.trial" } else { "number of the trial in the run" };
    let x = Axis { range: Some((0.5, most as f64 + 0.5)), ticks: Some(ticks), ..Axis::new(quantity, "") };
    let log = |quantity: &str, unit: &str| Axis { is_log: true, ..Axis::new(quantity, unit) };
    let panels: [(Axis, Quantity); 4] = [
        (Axis { holds: vec![0.0, 100.0], ..Axis::new("interval used", "%") }, |t| 100.0 * t.utilisation[0]),
        (log("penalty factor", "N/m³"), |t| t.penalty_end),
        (Axis { holds: vec![0.0], ..Axis::new("interval width", "m") }, |t| t.interval_widths[0]),
        (Axis { holds: vec![0.0], ..Axis::new("peak force", "N") }, |t| t.peak_force),
    ];
    let mut panels: Vec<Panel> = panels
        .into_iter()
        .map(|(y, value)| Panel {
            x: x.clone(),
            y,
            curves: curves(files, value),
            bands: impacts(files),
            ..Panel::default()
        })
        .filter(|p| p.curves.iter().any(|c| c.y.iter().any(|v| v.is_finite() && *v > 0.0)))
        .collect();
    let mut legend = if files.len() > 1 { entries(labels(files)) } else { Vec::new() };
    legend.push(Entry { sign: Sign::Dot, label: "accepted".into() });
    legend.push(Entry { sign: Sign::Ring, label: "repeated".into() });
    let limits = limits(files);
    if let (Some(first), Some([least, wanted])) = (panels.first_mut(), limits) {
        first.limits = vec![100.0 * least, 100.0 * wanted];
        legend.push(Entry { sign: Sign::Limit, label: "least and wanted use of the interval".into() });
    }
    Ok(vec![Figure { name: "tries".into(), title: title(files, "trials"), columns: 1, panels, legend }])
}

/// One curve a file and impact.
fn curves(files: &[ResultData], value: Quantity) -> Vec<Curve> {
    let mut all = Vec::new();
    for (style, file) in files.iter().enumerate() {
        let mut number = 0.0;
        for impact in file.trials.chunk_by(|a, b| a.impact == b.impact) {
            let mut curve = Curve { style, ..Curve::default() };
            for t in impact {
                number += 1.0;
                curve.x.push(number);
                curve.y.push(value(t));
                curve.marks.push(t.outcome.as_str() == ACCEPTED);
            }
            all.push(curve);
        }
    }
    all
}

/// Every second impact of the only file is shaded.
fn impacts(files: &[ResultData]) -> Vec<(f64, f64, Shade)> {
    let [file] = files else { return Vec::new() };
    let mut bands = Vec::new();
    let mut start = 0.5;
    for (i, impact) in file.trials.chunk_by(|a, b| a.impact == b.impact).enumerate() {
        let end = start + impact.len() as f64;
        if i % 2 == 1 {
            bands.push((start, end, Shade::Free));
        }
        start = end;
    }
    bands
}

/// Numbers of impacts and trials, or plain numbers if there are many or several files.
fn ticks(files: &[ResultData], most: usize) -> Vec<Tick> {
    let every = most.div_ceil(LABELLED).max(1);
    let label = |i: usize| match files {
        [file] => file.trials.get(i).map_or_else(String::new, |t| format!("{}.{}", t.impact + 1, t.number)),
        _ => (i + 1).to_string(),
    };
    (0..most).step_by(every).map(|i| ((i + 1) as f64, label(i))).collect()
}

/// Least and wanted utilisation, if all files have the same.
fn limits(files: &[ResultData]) -> Option<[f64; 2]> {
    let limits = |f: &ResultData| f.utilisation.and_then(|u| Some([u.least?, u.target]));
    let mut all: Vec<Option<[f64; 2]>> = files.iter().map(limits).collect();
    all.dedup();
    if let [one] = all[..] { one } else { None }
}
