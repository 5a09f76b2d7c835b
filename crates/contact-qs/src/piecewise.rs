//! A surface made of polynomial pieces: what contact needs to know of the surface of a finite
//! element mesh.
//!
//! Each piece maps the unit square by Bernstein polynomials (Eq. C.51); a piece of the curve that bounds
//! a plane or axisymmetric model has degree zero in the second direction, and ends at its edges 1 and 3. Pieces meet along whole
//! edges; where they do so smoothly, points may move on from one to the next.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::DataError;

use crate::ContactError;

/// The edge of a piece: 0 from (0, 0) to (1, 0), 1 to (1, 1), 2 to (0, 1), 3 back. Pieces that meet
/// run along their common edge against each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PieceEdge {
    /// The piece.
    pub piece: u32,
    /// Number of its edge.
    pub edge: u8,
}

/// A piece of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePiece {
    /// Number of the side of the mesh that it belongs to.
    pub side: u32,
    /// Parameters of the side at the corners of the square.
    pub corners: [[f64; 2]; 4],
    /// Degree in each direction: at least 1, in the second 0 of a curve.
    pub degrees: [usize; 2],
    /// Nodes of the body whose functions are not zero here.
    pub nodes: Vec<u32>,
    /// Bernstein coefficients of their functions, one row per node, the first direction fastest.
    pub coefficients: Vec<f64>,
    /// What lies beyond each edge if the surface goes on smoothly there.
    pub neighbours: [Option<PieceEdge>; 4],
}

/// A surface of pieces, whose normals `∂x/∂s × ∂x/∂t` point outwards; curves have their body at the left.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PiecewiseSurface {
    /// The pieces.
    pub pieces: Vec<SurfacePiece>,
    /// Positions of all nodes of the body, in the components of its model \[m\].
    pub positions: Vec<[f64; 3]>,
}

impl PiecewiseSurface {
    /// Checks that a body with the motions `motion` can have this surface.
    ///
    /// # Errors
    /// [`ContactError::Nothing`] without a piece, [`ContactError::Data`] if sizes differ, or if pieces are curves
    /// and the body moves in space, or the other way round.
    pub(crate) fn check(&self, motion: RigidMotion) -> Result<(), ContactError> {
        if self.pieces.is_empty() {
            return Err(ContactError::Nothing { what: "the surface has no side" });
        }
        let (n_nodes, n_pieces) = (self.positions.len(), self.pieces.len());
        let n_directions = motion.n_components() - 1;
        match self.pieces.iter().position(|p| !p.is_consistent(n_directions, n_nodes, n_pieces)) {
            Some(number) => {
                let what = "pieces of a surface that fit its nodes".into();
                Err(DataError::Index { what, number, count: n_pieces }.into())
            }
            None => Ok(()),
        }
    }
}

/// Steps of Newton's method on a bilinear map of a convex quadrilateral: three do, of a place in it.
const NEWTON_STEPS: usize = 10;
/// Part of a piece by which a place may lie beside it: round-off of searches.
const BESIDE: f64 = 1e-6;

impl PiecewiseSurface {
    /// The piece that holds the parameters `eta` of side `side`, and the place in it; none if no
    /// piece does.
    pub fn place_of(&self, side: u32, eta: [f64; 2]) -> Option<(u32, [f64; 2])> {
        let on_side = self.pieces.iter().enumerate().filter(|(_, piece)| piece.side == side);
        on_side.filter_map(|(k, piece)| Some((k as u32, piece.place_of(eta)?))).next()
    }
}

impl SurfacePiece {
    /// Parameters of the side at the place `s` of the square.
    pub fn parameters(&self, s: [f64; 2]) -> [f64; 2] {
        bilinear(&self.corners, s)
    }

    /// Area of the side's parameters over that of the square at `s`.
    pub fn area_at(&self, s: [f64; 2]) -> f64 {
        let [a, b] = self.slopes(s);
        (a[0] * b[1] - a[1] * b[0]).abs()
    }

    /// Derivatives of the parameters of the side by those of the square.
    fn slopes(&self, [s, t]: [f64; 2]) -> [[f64; 2]; 2] {
        let [a, b, c, d] = &self.corners;
        [
            [0, 1].map(|k| (1.0 - t) * (b[k] - a[k]) + t * (c[k] - d[k])),
            [0, 1].map(|k| (1.0 - s) * (d[k] - a[k]) + s * (c[k] - b[k])),
        ]
    }

    /// The place in the square with the parameters `eta` of the side; none if it lies beside it.
    pub fn place_of(&self, eta: [f64; 2]) -> Option<[f64; 2]> {
        let mut s = [0.5; 2];
        for _ in 0..NEWTON_STEPS {
            let at = self.parameters(s);
            let (miss, [a, b]) = ([eta[0] - at[0], eta[1] - at[1]], self.slopes(s));
            let determinant = a[0] * b[1] - a[1] * b[0];
            let step = [miss[0] * b[1] - miss[1] * b[0], a[0] * miss[1] - a[1] * miss[0]];
            s = [0, 1].map(|k| (s[k] + step[k] / determinant).clamp(-1.0, 2.0));
        }
        let is_inside = s.iter().all(|x| (-BESIDE..=1.0 + BESIDE).contains(x));
        let s = s.map(|x| x.clamp(0.0, 1.0));
        // Of a place beside the piece the steps may go round within it. Its sides are two long at most.
        let is_there = self.parameters(s).iter().zip(&eta).all(|(a, b)| (a - b).abs() <= 4.0 * BESIDE);
        (is_inside && is_there).then_some(s)
    }

    /// Coefficients of node `k` of the piece.
    pub(crate) fn row(&self, k: usize) -> &[f64] {
        let n = self.n_points();
        &self.coefficients[k * n..(k + 1) * n]
    }

    /// Number of Bernstein polynomials.
    pub(crate) fn n_points(&self) -> usize {
        (self.degrees[0] + 1) * (self.degrees[1] + 1)
    }

    /// Bernstein coefficients of a field with the values `at` the nodes.
    pub(crate) fn net(&self, at: impl Fn(u32) -> [f64; 3]) -> Vec<[f64; 3]> {
        let mut net = vec![[0.0; 3]; self.n_points()];
        for (k, &node) in self.nodes.iter().enumerate() {
            let value = at(node);
            for (point, c) in net.iter_mut().zip(self.row(k)) {
                (0..3).for_each(|d| point[d] += c * value[d]);
            }
        }
        net
    }

    /// Whether sizes fit each other and every node has a position.
    fn is_consistent(&self, n_directions: usize, n_nodes: usize, n_pieces: usize) -> bool {
        let has_directions = self.degrees.iter().filter(|p| **p > 0).count() == n_directions;
        let fits = has_directions
            && self.degrees[0] > 0
            && self.coefficients.len() == self.nodes.len() * self.n_points();
        let neighbours = self.neighbours.iter().flatten();
        fits && self.nodes.iter().all(|&node| (node as usize) < n_nodes)
            && neighbours.copied().all(|e| (e.piece as usize) < n_pieces && e.edge < 4)
    }
}

/// The bilinear map of the unit square to the quadrilateral `corners`.
pub(crate) fn bilinear(corners: &[[f64; 2]; 4], [s, t]: [f64; 2]) -> [f64; 2] {
    let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t];
    [0, 1].map(|d| weights.iter().zip(corners).map(|(w, c)| w * c[d]).sum())
}

/// Where a point of an edge of a piece lies on the neighbour that meets it there, `u` in `[0, 1]`
/// being its share of the way along `edge`.
pub(crate) fn across(edge: usize, u: f64) -> [f64; 2] {
    let back = 1.0 - u;
    match edge {
        0 => [back, 0.0],
        1 => [1.0, back],
        2 => [u, 1.0],
        _ => [0.0, u],
    }
}
