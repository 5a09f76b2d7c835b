//! Lengths of a shape along its parameters.

use crate::nurbs::{Patch, Shape};

/// Places across a patch, per direction, at which parameter lines are measured; both ends are among
/// them, for on singular nets the longest lines lie on the surface.
const LINES: usize = 5;
/// Points of the chord of a line, per knot span: a chord of 1/16 of a quarter circle is 0.04 % too
/// short.
const CHORDS: usize = 16;

/// Length of the longest parameter line of each direction \[m\]; lines through several patches are
/// counted patch by patch.
pub fn lengths(shape: &Shape) -> Vec<f64> {
    let n = shape.patches.first().map_or(0, Patch::dimension);
    (0..n).map(|d| shape.patches.iter().map(|patch| longest_line(patch, d)).fold(0.0, f64::max)).collect()
}

/// Length of the longest of the lines of `patch` along its direction `d` \[m\].
pub fn longest_line(patch: &Patch, d: usize) -> f64 {
    let (lower, upper) = patch.domain();
    let n = patch.dimension();
    let mut longest = 0.0_f64;
    for line in 0..LINES.pow(n as u32 - 1) {
        let mut xi = lower;
        let mut rest = line;
        for e in (0..n).filter(|&e| e != d) {
            xi[e] = lower[e] + (upper[e] - lower[e]) * ((rest % LINES) as f64 / (LINES - 1) as f64);
            rest /= LINES;
        }
        longest = longest.max(line_length(patch, &xi, d));
    }
    longest
}

/// Length of the line of `patch` through `start` along its direction `d` \[m\].
fn line_length(patch: &Patch, start: &[f64; 3], d: usize) -> f64 {
    let mut xi = *start;
    let mut point = |u: f64| {
        xi[d] = u;
        patch.point(&xi)
    };
    let mut length = 0.0;
    for span in patch.knots()[d].breaks().windows(2) {
        let mut before = point(span[0]);
        for k in 1..=CHORDS {
            let next = point(span[0] + (span[1] - span[0]) * (k as f64 / CHORDS as f64));
            length += (0..3).map(|c| (next[c] - before[c]).powi(2)).sum::<f64>().sqrt();
            before = next;
        }
    }
    length
}
