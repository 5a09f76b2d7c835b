//! Pieces of a moving body in the frame of the search, deformed when they are first asked for.

use nalgebra::Vector3;

use super::bezier::{Homogeneous, PieceJet, jet};
use super::boxes::{Bounds, Placement};
use super::surface_model::{Piece, SurfaceModel, cartesian};

/// A place on a surface: piece and parameters in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    /// Number of the piece.
    pub piece: u32,
    /// Parameters in it, from 0 to 1.
    pub s: [f64; 2],
}

/// Deformed pieces of one body; filled piece by piece, emptied at no cost.
#[derive(Debug, Clone, Default)]
pub(super) struct Deformed {
    net: Vec<Homogeneous>,
    points: Vec<Vector3<f64>>,
    boxes: Vec<Bounds>,
    stamps: Vec<u64>,
    stamp: u64,
}

/// A body in one query.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side<'a> {
    pub model: &'a SurfaceModel,
    pub elastic: &'a [f64],
    /// Frame of the body in the frame of the search; none if they are the same.
    pub placement: Option<&'a Placement>,
    /// Bound of the displacement \[m\].
    pub inflation: f64,
}

impl Side<'_> {
    /// Vector of the body's frame in the frame of the search.
    pub fn rotated(&self, v: Vector3<f64>) -> Vector3<f64> {
        self.placement.map_or(v, |p| p.rotation * v)
    }

    /// Point of the frame of the search in the body's frame.
    pub fn in_body(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.placement.map_or(*x, |p| p.rotation.tr_mul(&(x - p.origin)))
    }

    /// Upper end of the parameters: directions that a piece lacks are held.
    pub fn upper(&self, piece: u32) -> [f64; 2] {
        self.model.pieces()[piece as usize].degrees.map(|p| if p > 0 { 1.0 } else { 0.0 })
    }

    /// Parameters of control point `index` of a piece.
    pub fn parameters(&self, piece: u32, index: usize) -> [f64; 2] {
        let [a, b] = self.model.pieces()[piece as usize].degrees;
        [(index % (a + 1)) as f64 / a.max(1) as f64, (index / (a + 1)) as f64 / b.max(1) as f64]
    }
}

impl Deformed {
    /// Forgets all pieces; allocates only for a model that is larger than any before.
    pub fn begin(&mut self, model: &SurfaceModel) {
        self.stamp += 1;
        if self.net.len() < model.n_points() || self.boxes.len() < model.n_pieces() {
            self.net.resize(model.n_points(), [0.0; 4]);
            self.points.resize(model.n_points(), Vector3::zeros());
            self.boxes.resize(model.n_pieces(), Bounds { centre: Vector3::zeros(), half: Vector3::zeros() });
            self.stamps.resize(model.n_pieces(), 0);
        }
    }

    /// Makes sure that a piece is there.
    pub fn load(&mut self, side: &Side<'_>, piece: u32) {
        let k = piece as usize;
        if self.stamps[k] == self.stamp {
            return;
        }
        self.stamps[k] = self.stamp;
        let of = &side.model.pieces()[k];
        let net = &mut self.net[of.start..of.start + of.n_points];
        side.model.deform(of, side.elastic, net);
        for (h, point) in net.iter_mut().zip(&mut self.points[of.start..]) {
            let mut p = cartesian(h);
            if let Some(placement) = side.placement {
                p = placement.rotation * p + placement.origin;
                for c in 0..3 {
                    h[c] = p[c] * h[3];
                }
            }
            *point = p;
        }
        self.boxes[k] = Bounds::around(self.points[of.start..of.start + of.n_points].iter().copied());
    }

    /// Homogeneous points of a loaded piece.
    fn net(&self, of: &Piece) -> &[Homogeneous] {
        &self.net[of.start..of.start + of.n_points]
    }

    /// Control points of a loaded piece.
    pub fn points(&self, of: &Piece) -> &[Vector3<f64>] {
        &self.points[of.start..of.start + of.n_points]
    }

    /// Box around a loaded piece.
    pub fn bounds(&self, piece: u32) -> &Bounds {
        &self.boxes[piece as usize]
    }

    /// Point and derivatives on a loaded piece.
    pub fn jet(&self, side: &Side<'_>, piece: u32, s: [f64; 2]) -> PieceJet {
        let of = &side.model.pieces()[piece as usize];
        jet(of.degrees, self.net(of), s)
    }

    /// Outward unit normal; at a pole of the parametrisation the one next to it.
    pub fn normal(&self, side: &Side<'_>, site: &Site, here: &PieceJet) -> Vector3<f64> {
        /// Share of the way to the middle of the piece: the normal turns by less than 0.01 degrees.
        const ASIDE: f64 = 2e-4;
        self.normal_of(side, site.piece, here).unwrap_or_else(|| {
            let s = site.s.map(|s| s + ASIDE * (0.5 - s));
            let jet = self.jet(side, site.piece, s);
            self.normal_of(side, site.piece, &jet).unwrap_or_else(Vector3::zeros)
        })
    }

    fn normal_of(&self, side: &Side<'_>, piece: u32, here: &PieceJet) -> Option<Vector3<f64>> {
        let of = &side.model.pieces()[piece as usize];
        let second = side.model.across().map_or(here.first[1], |v| side.rotated(v));
        let product = here.first[0].cross(&second);
        let length = product.norm();
        // Parallel tangents leave the round-off of their product; a pole one tangent of round-off
        // beside the piece's size.
        let size = 1e-9 * self.boxes[piece as usize].half.norm();
        let regular = length > 1e-9 * here.first[0].norm() * second.norm()
            && here.first[0].norm() > size
            && (side.model.across().is_some() || second.norm() > size);
        regular.then(|| product * (of.orientation / length))
    }
}

/// Index of the smallest value.
pub(super) fn smallest(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (f64::INFINITY, 0);
    for (i, v) in values.enumerate() {
        if v < best.0 {
            best = (v, i);
        }
    }
    best.1
}
