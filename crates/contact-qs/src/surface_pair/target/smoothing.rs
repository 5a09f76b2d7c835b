//! Continuous normals of a surface of pieces (docs/theory.md Eq. C.52).

use ffr_dynamics::body::RigidMotion;
use iga_core::nurbs::jet::{cross, norm};

use crate::piecewise::{PieceEdge, PiecewiseSurface};

/// Round-off of a function that is one at a corner of a piece.
const IS_ONE: f64 = 1e-9;

/// How the normals at the nodes follow from the places of the nodes.
#[derive(Debug, Clone, Default)]
pub(in crate::surface_pair) struct Smoothing {
    /// The neighbours of each piece over its four edges.
    pub neighbours: Vec<[Option<PieceEdge>; 4]>,
    corners: Vec<Corner>,
    /// Nodes of the pieces with the derivatives of their functions at a corner, corner after
    /// corner.
    slopes: Vec<(u32, [f64; 2])>,
    /// Bound of the sum of the absolute values of all functions at a place.
    pub spread: f64,
    /// Whether pieces are curves, and whether their nodes may lie on an axis of symmetry.
    is_curve: bool,
    is_axial: bool,
}

/// A node at the corner of a piece.
#[derive(Debug, Clone, Copy)]
struct Corner {
    node: u32,
    /// Begin and end of its slopes in the list of slopes.
    range: [u32; 2],
}

/// Places in the net of a piece of the degrees `p`, `q` of the corner `k`, and of its neighbours along
/// both parameters; itself across a curve.
fn net_places([p, q]: [usize; 2], k: usize) -> (usize, [(usize, f64); 2]) {
    let n = p + 1;
    let (i, j) = [(0, 0), (p, 0), (p, q), (0, q)][k];
    let (inwards_s, sign_s) = if i == 0 { (1, 1.0) } else { (p - 1, -1.0) };
    let (inwards_t, sign_t) = if j == 0 { (q.min(1), 1.0) } else { (q - 1, -1.0) };
    (i + n * j, [(inwards_s + n * j, sign_s), (i + n * inwards_t, sign_t)])
}

impl Smoothing {
    /// The normals of `surface`, whose nodes have the numbers `number` in the target.
    pub fn new(surface: &PiecewiseSurface, motion: RigidMotion, number: impl Fn(u32) -> u32) -> Self {
        let mut smoothing = Self {
            neighbours: surface.pieces.iter().map(|p| p.neighbours).collect(),
            is_curve: motion != RigidMotion::Spatial,
            is_axial: motion == RigidMotion::Axial,
            ..Self::default()
        };
        for piece in &surface.pieces {
            let sums = (0..piece.n_points())
                .map(|c| (0..piece.nodes.len()).map(|k| piece.row(k)[c].abs()).sum::<f64>());
            smoothing.spread = sums.fold(smoothing.spread, f64::max);
            // A node in the middle of an edge belongs to two pieces of the side, which have one
            // tangent plane there.
            for corner in 0..if smoothing.is_curve { 2 } else { 3 } {
                let (here, [along, across]) = net_places(piece.degrees, corner);
                let at = |k: usize| (piece.row(k)[here] - 1.0).abs() < IS_ONE;
                let Some(k) = (0..piece.nodes.len()).find(|k| at(*k)) else { continue };
                let first = smoothing.slopes.len() as u32;
                for (i, &node) in piece.nodes.iter().enumerate() {
                    let row = piece.row(i);
                    let slope = |(c, sign): (usize, f64)| sign * (row[c] - row[here]);
                    smoothing.slopes.push((number(node), [slope(along), slope(across)]));
                }
                let range = [first, smoothing.slopes.len() as u32];
                smoothing.corners.push(Corner { node: number(piece.nodes[k]), range });
            }
        }
        smoothing
    }

    /// Unit normals at the nodes, which stand at `nodes`: the mean of those of the pieces there. On the axis
    /// of symmetry, beyond which the surface goes on as its mirror image, that is the axis.
    pub fn normals(&self, nodes: &[[f64; 3]], out: &mut [[f64; 3]]) {
        out.fill([0.0; 3]);
        for Corner { node, range } in &self.corners {
            let (mut u, mut v) = ([0.0; 3], [0.0; 3]);
            for (other, [s, t]) in &self.slopes[range[0] as usize..range[1] as usize] {
                let x = &nodes[*other as usize];
                for d in 0..3 {
                    u[d] += s * x[d];
                    v[d] += t * x[d];
                }
            }
            let normal = if self.is_curve { [u[1], -u[0], 0.0] } else { cross(&u, &v) };
            let length = norm(&normal);
            out[*node as usize].iter_mut().zip(normal).for_each(|(sum, n)| *sum += n / length);
        }
        for (normal, x) in out.iter_mut().zip(nodes) {
            if self.is_axial && x[0] == 0.0 {
                normal[0] = 0.0;
            }
            let length = norm(normal);
            if length > 0.0 {
                normal.iter_mut().for_each(|n| *n /= length);
            }
        }
    }
}
