//! Contact pressure at the largest force of each contact: over the line of points of flat and
//! axisymmetric models, as a map of the others.

use nalgebra::{Matrix3, Vector3};

use super::{curve, labels, names, title};
use crate::plot::data::ResultData;
use crate::plot::figure::{Axis, Dot, Figure, Panel, entries};
use crate::stored::pressure_series::PressureSeries;

/// Part of the largest extent below which points lie on a line.
const NARROW: f64 = 1e-2;
/// Cosine of the angle between a direction and an axis of the body below which they count as one:
/// 10°, which shortens by 1.5 %.
const ALIGNED: f64 = 0.985;
/// Room about the points of a map, as a part of half its side.
const ROOM: f64 = 1.08;

/// A point under pressure: its undeformed place, area and pressure.
struct Loaded {
    place: Vector3<f64>,
    area: f64,
    pressure: f64,
}

/// One figure per contact whose points are stored.
pub fn figures(files: &[ResultData]) -> Result<Vec<Figure>, String> {
    let contacts = names(files.iter().flat_map(|f| f.pressures.iter().map(|p| p.0.as_str())));
    if contacts.is_empty() {
        return Err("no pressures are stored: contacts by Hertz's formula have no points, and output.pressure may be false".into());
    }
    let figures: Vec<Figure> = contacts.into_iter().filter_map(|name| figure(files, name)).collect();
    if figures.is_empty() {
        return Err(
            "no contact point is loaded at a stored instant; contacts by Hertz's formula have no points"
                .into(),
        );
    }
    Ok(figures)
}

/// The loaded points of contact `name` at the stored instant of its largest force, and that instant
/// \[s\].
fn at_peak(file: &ResultData, name: &str) -> Option<(f64, Vec<Loaded>)> {
    let (_, series) = file.pressures.iter().find(|p| p.0 == name)?;
    let sum = |i: usize| series.range(i).map(|k| force(series, k)).sum::<f64>();
    let peak = (0..file.time.len()).max_by(|a, b| sum(*a).total_cmp(&sum(*b)))?;
    let loaded = series.range(peak).map(|k| {
        let point = series.point[k] as usize;
        let place = Vector3::from(series.position[point]);
        Loaded { place, area: series.area[point], pressure: series.pressure[k] }
    });
    let loaded: Vec<Loaded> = loaded.collect();
    (!loaded.is_empty()).then(|| (file.time[peak], loaded))
}

fn force(series: &PressureSeries, entry: usize) -> f64 {
    series.area[series.point[entry] as usize] * series.pressure[entry]
}

fn figure(files: &[ResultData], name: &str) -> Option<Figure> {
    let found: Vec<(usize, f64, Vec<Loaded>)> = files
        .iter()
        .enumerate()
        .filter_map(|(i, f)| at_peak(f, name).map(|(time, loaded)| (i, time, loaded)))
        .collect();
    let (first, time, points) = found.first()?;
    let ways = directions(points);
    let when = if files.len() > 1 { "its largest force".into() } else { super::forces::time(*time) };
    let subject = format!("pressure of contact {name} at {when}");
    let mut figure = Figure {
        name: format!("pressure_{name}"),
        title: title(files, &subject),
        columns: 1,
        ..Figure::default()
    };
    if found.iter().all(|(.., points)| is_line(points, &ways)) {
        let words = coordinate(&files[*first], name, &ways[0]);
        let y = Axis { holds: vec![0.0], ..Axis::new("contact pressure", "Pa") };
        let mut panel = Panel { x: Axis::new(words, "m"), y, ..Panel::default() };
        for (i, _, points) in &found {
            let mut along: Vec<(f64, f64)> =
                points.iter().map(|p| (ways[0].direction.dot(&p.place), p.pressure)).collect();
            along.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (x, y): (Vec<f64>, Vec<f64>) = along.into_iter().unzip();
            let marks = vec![true; x.len()];
            panel.curves.push(crate::plot::figure::Curve { marks, ..curve(*i, &x, &y) });
        }
        figure.panels.push(panel);
        if files.len() > 1 {
            let drawn = entries(labels(files)).into_iter().enumerate();
            let drawn = drawn.filter(|(i, _)| found.iter().any(|(file, ..)| file == i));
            figure.legend = drawn.map(|(_, entry)| entry).collect();
        }
        return Some(figure);
    }
    let largest = found.iter().flat_map(|(.., points)| points).map(|p| p.pressure).fold(0.0, f64::max);
    figure.columns = 2;
    for (i, _, points) in &found {
        let label = if files.len() > 1 { files[*i].label.clone() } else { String::new() };
        figure.panels.push(Panel { title: label, ..map(points, &ways, largest) });
        if files.len() == 1 {
            figure.panels.push(side_view(points, &ways[0]));
        }
    }
    Some(figure)
}

/// A direction in which points are spread, in the axes of the body, and how it is called.
struct Way {
    direction: Vector3<f64>,
    words: String,
}

/// The two directions of the plane in which `points` lie best; axes of the body where those are
/// about in that plane.
fn directions(points: &[Loaded]) -> [Way; 2] {
    let n = points.len().max(1) as f64;
    let middle = points.iter().map(|p| p.place).sum::<Vector3<f64>>() / n;
    let spread: Matrix3<f64> =
        points.iter().map(|p| (p.place - middle) * (p.place - middle).transpose()).sum();
    let found = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| found.eigenvalues[*b].total_cmp(&found.eigenvalues[*a]));
    let own = order.map(|k| found.eigenvectors.column(k).into_owned());
    let axis = |k: usize| Way { direction: Vector3::ith(k, 1.0), words: ["x", "y", "z"][k].into() };
    // Points on a line have no plane.
    let is_line = found.eigenvalues[order[1]] <= NARROW.powi(2) * found.eigenvalues[order[0]];
    let (to_compare, is_along) = if is_line { (own[0], true) } else { (own[2], false) };
    if let Some(k) = (0..3).find(|k| to_compare[*k].abs() > ALIGNED) {
        let (a, b) = ((k + 1) % 3, (k + 2) % 3);
        return if is_along { [axis(k), axis(a)] } else { [axis(a.min(b)), axis(a.max(b))] };
    }
    [0, 1].map(|k| {
        // The sign that makes the largest part positive.
        let direction = own[k] * own[k][own[k].iamax()].signum();
        let part = |c: usize| crate::plot::ticks::signed(direction[c], 2);
        Way { direction, words: format!("along ({}, {}, {})", part(0), part(1), part(2)) }
    })
}

/// Extent of `points` along `direction`.
fn range(points: &[Loaded], direction: &Vector3<f64>) -> (f64, f64) {
    let along = points.iter().map(|p| direction.dot(&p.place));
    along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

fn is_line(points: &[Loaded], ways: &[Way; 2]) -> bool {
    let [long, short] = [0, 1].map(|k| {
        let (low, high) = range(points, &ways[k].direction);
        high - low
    });
    short <= NARROW * long
}

/// How the direction `way` is called in the model of the contact body of `name`.
fn coordinate(file: &ResultData, name: &str, way: &Way) -> String {
    let value = |key: String| file.scenario.get(&key).map_or("", String::as_str);
    let body = value(format!("contacts.{name}.contact_body"));
    let is_ring = value(format!("bodies.{body}.model")) == "axisymmetric";
    if is_ring && way.words == "x" { "radius".into() } else { way.words.clone() }
}

/// Points in the plane of `ways`, coloured by their pressure up to `largest`, both directions to
/// one scale.
fn map(points: &[Loaded], ways: &[Way; 2], largest: f64) -> Panel {
    let ranges = ways.each_ref().map(|way| range(points, &way.direction));
    // Half of the area's width beyond the outermost points.
    let beyond = points.iter().map(|p| 0.5 * p.area.sqrt()).fold(0.0, f64::max);
    let half = ranges.iter().map(|(low, high)| 0.5 * (high - low)).fold(0.0, f64::max) + beyond;
    let axis = |k: usize| {
        let middle = 0.5 * (ranges[k].0 + ranges[k].1);
        let range = (middle - ROOM * half, middle + ROOM * half);
        Axis { range: Some(range), ..Axis::new(ways[k].words.clone(), "m") }
    };
    let dot = |p: &Loaded| Dot {
        x: ways[0].direction.dot(&p.place),
        y: ways[1].direction.dot(&p.place),
        radius: (p.area / std::f64::consts::PI).sqrt(),
        value: p.pressure,
    };
    let colours = Axis { range: Some((0.0, largest)), ..Axis::new("pressure", "Pa") };
    let dots = points.iter().map(dot).collect();
    Panel { x: axis(0), y: axis(1), dots, colours: Some(colours), ..Panel::default() }
}

/// The same points seen from the side: pressure over the first direction.
fn side_view(points: &[Loaded], way: &Way) -> Panel {
    let dot = |p: &Loaded| Dot { x: way.direction.dot(&p.place), y: p.pressure, ..Dot::default() };
    let y = Axis { holds: vec![0.0], ..Axis::new("contact pressure", "Pa") };
    let dots = points.iter().map(dot).collect();
    Panel { x: Axis::new(way.words.clone(), "m"), y, dots, ..Panel::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a zone of `a` by `b` whose plane holds the unit vectors `u` and `v`, bulged
    /// towards their normal.
    fn zone(u: Vector3<f64>, v: Vector3<f64>, (a, b): (f64, f64)) -> Vec<Loaded> {
        let at = |i: i32, j: i32| (0.1 * f64::from(i), 0.1 * f64::from(j));
        let cells = (-10..=10).flat_map(|i| (-10..=10).map(move |j| at(i, j)));
        let inside = cells.filter(|(s, t)| s * s + t * t <= 1.0);
        let point = |(s, t): (f64, f64)| Loaded {
            place: a * s * u + b * t * v + 0.01 * a * s * s * u.cross(&v),
            area: 0.01 * a * b,
            pressure: 1e9 * (1.0 - s * s - t * t).sqrt(),
        };
        inside.map(point).collect()
    }

    #[test]
    fn maps_lie_in_the_plane_of_the_zone() {
        let flat = directions(&zone(Vector3::y(), Vector3::x(), (2e-3, 1e-3)));
        assert_eq!(flat.each_ref().map(|way| way.words.as_str()), ["x", "y"]);
        // A plane turned by 45° about z: its normal is no axis, the long way is up.
        let slanted = zone(Vector3::new(1.0, 1.0, 0.0).normalize(), Vector3::z(), (1e-3, 2e-3));
        let ways = directions(&slanted);
        assert!(
            ways[0].direction.z > 0.999 && ways[0].words == "along (0.00, 0.00, 1.00)",
            "{}",
            ways[0].words
        );
        assert_eq!(ways[1].words, "along (0.71, 0.71, 0.00)");
        assert!(!is_line(&slanted, &ways));
    }

    #[test]
    fn points_on_a_line_are_no_map() {
        let ring = zone(Vector3::x(), Vector3::y(), (1e-3, 0.0));
        let ways = directions(&ring);
        assert!(is_line(&ring, &ways));
        assert_eq!(ways[0].words, "x");
    }

    #[test]
    fn dots_cover_the_loaded_area() {
        let points = zone(Vector3::x(), Vector3::y(), (2e-3, 1e-3));
        let panel = map(&points, &directions(&points), 1e9);
        let drawn: f64 = panel.dots.iter().map(|d| std::f64::consts::PI * d.radius * d.radius).sum();
        let loaded: f64 = points.iter().map(|p| p.area).sum();
        assert!((drawn / loaded - 1.0).abs() < 1e-12);
        let side = |axis: &Axis| axis.range.map(|(low, high)| high - low).expect("a range");
        assert!((side(&panel.x) / side(&panel.y) - 1.0).abs() < 1e-12);
    }
}
