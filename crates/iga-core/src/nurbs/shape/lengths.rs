//! Lengths of a shape along its parameters.

use crate::nurbs::interface::{COINCIDENT, FaceId, FaceNet, coinciding_pairs};
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

/// Lengths of the ways through the shape from one of its free faces to another along parameter
/// lines, through as many patches as lie between, each by its longest line \[m\]; each way is
/// listed from both its ends, infinite if it has no other one.
pub fn ways_through(shape: &Shape) -> Vec<f64> {
    let patches = &shape.patches;
    let faces = FaceId::all(patches);
    let nets: Vec<FaceNet> = faces.iter().map(|&id| FaceNet::new(patches, id)).collect();
    let pairs = coinciding_pairs(&nets, COINCIDENT);
    let beyond = |face: FaceId| {
        pairs.iter().find_map(|&(a, b, _)| match face {
            face if face == faces[a] => Some(faces[b]),
            face if face == faces[b] => Some(faces[a]),
            _ => None,
        })
    };
    let way = |from: FaceId| {
        let (mut at, mut length) = (from, 0.0);
        // Where more than two faces are one, a way may come round to itself: it has no end then.
        for _ in &faces {
            length += longest_line(&patches[at.patch], at.direction);
            match beyond(FaceId { upper: !at.upper, ..at }) {
                Some(next) => at = next,
                None => return length,
            }
        }
        f64::INFINITY
    };
    faces.iter().filter(|&&face| beyond(face).is_none()).map(|&face| way(face)).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nurbs::primitives::{SphereNet, rounded_box, solid, sphere};

    /// Chords of the lines: see [`CHORDS`].
    const OF_CHORDS: f64 = 5e-4;

    fn shortest_way(shape: &Shape) -> f64 {
        ways_through(shape).into_iter().fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn ways_lead_through_all_patches_in_between_and_not_around() {
        // A ball of a core and shells is as thick as its diameter, not as a shell.
        let ball = sphere::sphere(0.01, SphereNet::Shells).unwrap();
        assert_eq!(ways_through(&ball).len(), 6);
        assert!((shortest_way(&ball) / 0.02 - 1.0).abs() < OF_CHORDS);
        let rounded = rounded_box::rounded_box([0.03, 0.02, 0.012], 0.002).unwrap();
        assert!(shortest_way(&rounded) >= 0.012 * (1.0 - OF_CHORDS), "{}", shortest_way(&rounded));
        // A tube as its wall: its seam is not free, and the way around has no end.
        let tube = solid::hollow_cylinder(0.01, 0.011, 0.05).unwrap();
        assert!((shortest_way(&tube) / 0.001 - 1.0).abs() < 1e-12, "straight lines");
        assert_eq!(ways_through(&tube).len(), 4);
    }
}
