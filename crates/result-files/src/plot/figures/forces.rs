//! Contact forces: the whole run, and impact by impact.

use super::{bands, curve, labels, names, shade_entries, time_axis, title};
use crate::plot::data::ResultData;
use crate::plot::figure::{Axis, Figure, Panel, entries};

/// Part of the duration of an impact that is shown before and after it.
const AROUND: f64 = 0.08;
/// Figures of single impacts at most.
const MOST: usize = 40;

/// Normal forces over the whole run. One file: a curve per contact. Several: a panel per contact.
pub fn overview(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let contacts = contacts(files);
    if contacts.is_empty() {
        return Err("the scenario has no contacts".into());
    }
    if files.iter().all(|f| f.forces.iter().all(|(_, force)| force.iter().all(|n| *n <= 0.0))) {
        return Err("no contact ever closed".into());
    }
    let panel = |title: &str| Panel {
        title: title.into(),
        x: time_axis(files),
        y: Axis::new("normal force", "N"),
        bands: bands(files),
        ..Panel::default()
    };
    let mut figure = Figure {
        name: "forces".into(),
        title: title(files, "contact forces"),
        columns: 1,
        ..Figure::default()
    };
    if let [file] = files {
        let mut all = panel("");
        let curves = file.forces.iter().enumerate();
        all.curves.extend(curves.map(|(i, (_, force))| curve(i, &file.time, force)));
        figure.legend = entries(contacts.iter().copied());
        figure.legend.extend(shade_entries(&all.bands));
        figure.panels.push(all);
    } else {
        figure.legend = entries(labels(files));
        for contact in contacts {
            let mut one = panel(contact);
            for (i, file) in files.iter().enumerate() {
                one.curves.extend(force(file, contact).map(|y| curve(i, &file.time, y)));
            }
            figure.panels.push(one);
        }
    }
    Ok(vec![figure])
}

/// One figure an impact, time counted from its first contact; the n-th impact of a contact is
/// compared with the n-th of the other files.
pub fn impacts(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let mut figures: Vec<(f64, Figure)> = Vec::new();
    for contact in contacts(files) {
        let most = files.iter().map(|f| f.impacts_of(contact).count()).max().unwrap_or(0);
        figures.extend((0..most).filter_map(|n| impact(files, contact, n)));
    }
    if figures.is_empty() {
        return Err("there are no impacts in the time that is shown".into());
    }
    figures.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total = figures.len();
    if total > MOST {
        tracing::warn!("{total} impacts: figures of the first {MOST} are made");
    }
    let numbered = figures.into_iter().take(MOST).enumerate().map(|(i, (_, mut figure))| {
        figure.name = format!("impact_{}", i + 1);
        figure.title = title(files, &format!("impact {} {}", i + 1, figure.title));
        figure
    });
    Ok(numbered.collect())
}

/// The figure of impact `n` of `contact`, with the time of the earliest file to sort by.
fn impact(files: &[ResultData], contact: &str, n: usize) -> Option<(f64, Figure)> {
    let found = files.iter().enumerate().filter_map(|(i, f)| Some((i, f, f.impacts_of(contact).nth(n)?)));
    let found: Vec<_> = found.collect();
    let (start, end) = found.first().map(|(_, _, row)| (row.start, row.end))?;
    let longest = found.iter().map(|(_, _, row)| row.end - row.start).fold(0.0, f64::max);
    let range = (-AROUND * longest, (1.0 + AROUND) * longest);
    let mut panel = Panel {
        x: Axis { range: (longest > 0.0).then_some(range), ..Axis::new("time since first contact", "s") },
        y: Axis::new("normal force", "N"),
        ..Panel::default()
    };
    for (i, file, row) in &found {
        let force = force(file, contact)?;
        let times = file.time.iter().map(|t| t - row.start).zip(force);
        let (x, y): (Vec<f64>, Vec<f64>) = times.filter(|(t, _)| *t >= range.0 && *t <= range.1).unzip();
        panel.curves.push(curve(*i, &x, &y));
    }
    if let [file] = files {
        panel.bands = bands(files).into_iter().map(|(a, b, shade)| (a - start, b - start, shade)).collect();
        panel.bands.retain(|(a, b, _)| *b > range.0 && *a < range.1);
        if panel.bands.len() < 2 {
            panel.bands.clear();
        }
        debug_assert!(end >= start, "{}", file.label);
    }
    let mut legend = if let [_] = files { entries([contact]) } else { entries(labels(files)) };
    legend.extend(shade_entries(&panel.bands));
    let when = format!("({contact}) at {}", time(start));
    Some((start, Figure { title: when, columns: 1, panels: vec![panel], legend, ..Figure::default() }))
}

/// A time with SI prefix.
pub fn time(t: f64) -> String {
    if t == 0.0 {
        return "0 s".into();
    }
    let power = crate::plot::ticks::units::exponent(t.abs(), "s");
    format!("{:.3} {}", t * 10f64.powi(-power), crate::plot::ticks::units::prefixed("s", power))
}

fn force<'a>(file: &'a ResultData, contact: &str) -> Option<&'a [f64]> {
    file.forces.iter().find(|(n, _)| n == contact).map(|(_, force)| force.as_slice())
}

fn contacts(files: &[ResultData]) -> Vec<&str> {
    names(files.iter().flat_map(|f| f.forces.iter().map(|(n, _)| n.as_str())))
}
