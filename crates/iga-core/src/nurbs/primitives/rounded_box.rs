//! Box with rounded edges and corners: the ball of seven patches, cut in the middle of each
//! direction and drawn apart.
//!
//! The body is the sum of a box and a ball, so that faces are plane, edges quarters of cylinders
//! and corners eighths of balls, all exact. The pieces of the ball are of degree 4 as its net is
//! (docs/decisions/0001-sphere-net.md).

use std::f64::consts::FRAC_PI_4;

use super::sphere::{SphereNet, sphere};
use super::{joined, positive};
use crate::SplineError;
use crate::nurbs::{FaceId, Patch, Shape};
use crate::splines::knots::KnotVector;

/// Degree of the pieces along the surface.
const DEGREE: usize = 4;
/// Control points per direction: half a tile of the ball, a straight part, the other half.
const SIZE: usize = 3 * DEGREE + 1;
/// Depth of the inner box below the faces, over the radius of the fillet: as in the ball, whose
/// inner cube is as deep.
const DEPTH: f64 = 0.7;
/// The same over half the shortest edge: fillets much smaller than the box do not make the outer
/// patches thin.
const LEAST_DEPTH: f64 = 0.35;

/// Box of the size `size` along the axes over all, centred at the origin, whose edges and corners
/// are rounded with the radius `fillet_radius`. Seven patches: an inner box, directions x, y, z,
/// and one to each face, the last direction outwards. Regular throughout.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths; the fillet must be less than half of each edge.
pub fn rounded_box(size: [f64; 3], fillet_radius: f64) -> Result<Shape, SplineError> {
    for length in size {
        positive("size", length)?;
    }
    let f = positive("fillet_radius", fillet_radius)?;
    let half = size.map(|length| 0.5 * length);
    let least = half.iter().copied().fold(f64::INFINITY, f64::min);
    if f >= least {
        let reason = "must be less than half of the shortest edge";
        return Err(SplineError::Dimension { name: "fillet_radius", value: f, reason });
    }
    let net = Net { half, straight: half.map(|h| h - f), depth: (DEPTH * f).max(LEAST_DEPTH * least) };
    let knots = [net.knots(0, f)?, net.knots(1, f)?, net.knots(2, f)?];
    let core: Vec<_> =
        (0..SIZE.pow(3)).map(|i| net.inner([i % SIZE, i / SIZE % SIZE, i / SIZE / SIZE])).collect();
    let mut patches = vec![Patch::from_homogeneous(knots.to_vec(), &core)?];
    let ball = sphere(f, SphereNet::Shells)?;
    for (shell, tile) in ball.patches[1..].iter().enumerate() {
        // The order of the ball's shells and of their directions.
        let (normal, is_upper) = (shell / 2, shell % 2 == 1);
        let (a, b) = if is_upper { (1, 2) } else { (2, 1) };
        let directions = [(normal + a) % 3, (normal + b) % 3];
        let net = net.shell(tile, directions, (normal, is_upper))?;
        let along = directions.map(|d| knots[d].clone());
        let [first, second] = along;
        patches.push(Patch::from_homogeneous(vec![first, second, KnotVector::uniform(1, 1)?], &net)?);
    }
    let [x, y, z] = half;
    let markers = [
        ("centre", [0.0; 3]),
        ("left", [-x, 0.0, 0.0]),
        ("right", [x, 0.0, 0.0]),
        ("front", [0.0, -y, 0.0]),
        ("back", [0.0, y, 0.0]),
        ("bottom", [0.0, 0.0, -z]),
        ("top", [0.0, 0.0, z]),
        ("start", [0.0, 0.0, -z]),
        ("end", [0.0, 0.0, z]),
    ];
    let face = |shell: usize| vec![FaceId { patch: shell + 1, direction: 2, upper: true }];
    let faces = [
        ("x-", face(0)),
        ("x+", face(1)),
        ("y-", face(2)),
        ("y+", face(3)),
        ("z-", face(4)),
        ("z+", face(5)),
        ("start", face(4)),
        ("end", face(5)),
    ];
    Ok(joined(patches, markers, faces))
}

/// Lengths of the box that its nets follow from \[m\].
struct Net {
    /// Half the edges.
    half: [f64; 3],
    /// Half the straight parts of the edges.
    straight: [f64; 3],
    /// Depth of the inner box below the faces.
    depth: f64,
}

impl Net {
    /// Knots of direction `d`, the three parts by their lengths on the surface.
    fn knots(&self, d: usize, fillet: f64) -> Result<KnotVector, SplineError> {
        let arc = FRAC_PI_4 * fillet;
        let at = arc / (2.0 * arc + 2.0 * self.straight[d]);
        let ends = |v: f64| [v; DEGREE];
        let knots = [[0.0].to_vec(), ends(0.0).to_vec(), ends(at).to_vec(), ends(1.0 - at).to_vec()];
        KnotVector::new(DEGREE, [knots.concat(), ends(1.0).to_vec(), vec![1.0]].concat())
    }

    /// Control point of the inner box.
    fn inner(&self, index: [usize; 3]) -> [f64; 4] {
        let [x, y, z] = [0, 1, 2].map(|d| {
            let (core, part) = (self.half[d] - self.depth, self.straight[d] / self.half[d]);
            let s = (index[d] % DEGREE) as f64 / DEGREE as f64;
            let ends = [-1.0, -part, part, 1.0];
            let k = index[d] / DEGREE;
            core * if s == 0.0 { ends[k] } else { (1.0 - s) * ends[k] + s * ends[k + 1] }
        });
        [x, y, z, 1.0]
    }

    /// The net between the inner box and the face with the normal direction `normal`, over the
    /// ball's shell `tile`, whose directions along the face are `directions`.
    fn shell(
        &self,
        tile: &Patch,
        directions: [usize; 2],
        (normal, is_upper): (usize, bool),
    ) -> Result<Vec<[f64; 4]>, SplineError> {
        let cut = tile.insert_knots(0, &[0.5; DEGREE])?.insert_knots(1, &[0.5; DEGREE])?;
        let pieces = cut.homogeneous();
        let outwards = if is_upper { 1.0 } else { -1.0 };
        let (n, layer) = (2 * DEGREE + 1, (2 * DEGREE + 1).pow(2));
        let mut inner = Vec::with_capacity(2 * SIZE * SIZE);
        let mut outer = Vec::with_capacity(SIZE * SIZE);
        for flat in 0..SIZE * SIZE {
            let place = [flat % SIZE, flat / SIZE];
            let mut index = [if is_upper { SIZE - 1 } else { 0 }; 3];
            let mut shift = [0.0; 3];
            shift[normal] = outwards * self.straight[normal];
            for (d, i) in directions.iter().zip(place) {
                index[*d] = i;
                shift[*d] = drawn_apart(i).1 * self.straight[*d];
            }
            inner.push(self.inner(index));
            let [a, b] = place.map(|i| drawn_apart(i).0);
            let [x, y, z, w] = pieces[layer + a + n * b];
            outer.push([x + w * shift[0], y + w * shift[1], z + w * shift[2], w]);
        }
        inner.extend(outer);
        Ok(inner)
    }
}

/// The control point of the cut ball that control point `i` of a direction is made from, and the
/// share of half the straight part by which it is moved.
fn drawn_apart(i: usize) -> (usize, f64) {
    if i <= DEGREE {
        (i, -1.0)
    } else if i >= 2 * DEGREE {
        (i - DEGREE, 1.0)
    } else {
        (DEGREE, 2.0 * (i - DEGREE) as f64 / DEGREE as f64 - 1.0)
    }
}
