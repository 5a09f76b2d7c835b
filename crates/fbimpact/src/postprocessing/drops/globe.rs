//! A globe of directions, coloured by numbers, as a drawing.

use std::f64::consts::PI;
use std::fmt::Write as _;

use nalgebra::Vector3;

use super::Fall;
use crate::postprocessing::report::html::{escaped, number};

/// Colours from the smallest to the largest number, those of viridis.
const COLOURS: [[f64; 3]; 5] =
    [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];
/// Radius of a globe, and the height of the drawing.
const RADIUS: f64 = 150.0;
const HEIGHT: f64 = 340.0;
/// Pieces of a globe from pole to pole.
const BANDS: usize = 24;

/// Two hemispheres of the directions that pointed down, coloured by the peak force of the nearest of `falls`.
pub fn globe(falls: &[Fall]) -> String {
    let known: Vec<&Fall> = falls.iter().filter(|fall| fall.peak_force.is_finite()).collect();
    let (low, high) = known.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), fall| {
        (a.min(fall.peak_force), b.max(fall.peak_force))
    });
    let mut out = format!(
        "<svg class=\"drawing\" viewBox=\"0 0 760 {HEIGHT}\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\">"
    );
    if known.is_empty() {
        return out + "</svg>";
    }
    let share = |x: f64| if high > low { (x - low) / (high - low) } else { 0.5 };
    for (middle, from) in [(170.0, 1.0), (500.0, -1.0)] {
        hemisphere(&mut out, (middle, from), &known, &share);
    }
    // The scale: from the largest force, above, to the smallest.
    for i in 0..40 {
        let y = 40.0 + 6.5 * f64::from(i);
        let _ = write!(
            out,
            "<rect x=\"680\" y=\"{y}\" width=\"16\" height=\"7\" fill=\"{}\"/>",
            colour(1.0 - f64::from(i) / 39.0)
        );
    }
    for (y, x) in [(32.0, high), (320.0, low)] {
        let _ = write!(
            out,
            "<text x=\"688\" y=\"{y}\" font-size=\"13\" text-anchor=\"middle\">{} N</text>",
            number(x)
        );
    }
    out + "</svg>"
}

/// One hemisphere about x = `middle`, seen from (1, 1, 1) times `from`.
fn hemisphere(out: &mut String, (middle, from): (f64, f64), falls: &[&Fall], share: &dyn Fn(f64) -> f64) {
    let view = Vector3::repeat(from).normalize();
    let right = Vector3::z().cross(&view).normalize();
    let up = view.cross(&right);
    let place = |d: &Vector3<f64>| (middle + RADIUS * d.dot(&right), 0.5 * HEIGHT - RADIUS * d.dot(&up));
    let direction = |band: f64, turn: f64| {
        let (polar, angle) = (PI * band / BANDS as f64, PI * turn / BANDS as f64);
        Vector3::new(polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos())
    };
    let nearest = |d: &Vector3<f64>| falls.iter().max_by(|a, b| a.down.dot(d).total_cmp(&b.down.dot(d)));
    for (band, turn) in (0..BANDS).flat_map(|b| (0..2 * BANDS).map(move |t| (b as f64, t as f64))) {
        let Some(fall) = nearest(&direction(band + 0.5, turn + 0.5)) else { continue };
        let corners =
            [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(b, t)| direction(band + b, turn + t));
        if corners.iter().all(|d| d.dot(&view) < 0.0) {
            continue;
        }
        let points: String = corners.iter().map(|d| seen(d, &view)).map(|d| place(&d)).fold(
            String::new(),
            |mut text, (x, y)| {
                let _ = write!(text, "{x:.1},{y:.1} ");
                text
            },
        );
        let fill = colour(share(fall.peak_force));
        let _ = write!(
            out,
            "<polygon points=\"{points}\" fill=\"{fill}\" stroke=\"{fill}\" stroke-width=\"0.5\"/>"
        );
    }
    for fall in falls.iter().filter(|fall| fall.down.dot(&view) >= 0.0) {
        let (x, y) = place(&fall.down);
        let told = format!("{}: {} N", fall.name, number(fall.peak_force));
        let _ = write!(
            out,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"#fff\" stroke=\"#000\"><title>{}</title></circle>",
            escaped(&told)
        );
    }
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        let (x, y) = place(&(Vector3::ith(axis, from) * 1.06));
        let sign = if from > 0.0 { "+" } else { "-" };
        let _ = write!(
            out,
            "<text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"14\" text-anchor=\"middle\" fill=\"#fff\" stroke=\"#000\" stroke-width=\"2.5\" paint-order=\"stroke\">{letter}{sign}</text>",
            y - 8.0
        );
    }
}

/// A direction moved to the rim if it lies behind.
fn seen(direction: &Vector3<f64>, view: &Vector3<f64>) -> Vector3<f64> {
    let depth = direction.dot(view);
    if depth >= 0.0 { *direction } else { (direction - view * depth).normalize() }
}

/// The colour at a share of the scale.
fn colour(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let i = (at as usize).min(COLOURS.len() - 2);
    let mixed = |k: usize| COLOURS[i][k] + (at - i as f64) * (COLOURS[i + 1][k] - COLOURS[i][k]);
    format!("#{:02x}{:02x}{:02x}", mixed(0) as u8, mixed(1) as u8, mixed(2) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_from_end_to_end_of_the_scale() {
        assert_eq!([colour(0.0), colour(0.5), colour(1.0), colour(f64::NAN)].map(|c| c.len()), [7; 4]);
        assert_eq!(
            (colour(-1.0).as_str(), colour(0.5).as_str(), colour(2.0).as_str()),
            ("#440154", "#21918c", "#fde725")
        );
    }
}
