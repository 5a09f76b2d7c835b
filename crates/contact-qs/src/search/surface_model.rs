//! Surface of a body prepared for searching: Bézier pieces of its outer faces, the modes' shapes on
//! them, and a tree.
//!
//! Displacements have the basis functions of the geometry, so a deformed piece is a Bézier piece
//! with moved points (theory Eq. C.27). The model is built once in the body's frame and never
//! refitted: boxes are widened by a bound of the displacement (Eq. C.28).

use std::collections::HashSet;
use std::sync::Arc;

use faer::MatRef;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::DataError;
use iga_core::nurbs::Face;
use iga_core::nurbs::{FaceId, Patch};
use iga_core::space::{PatchSpace, Space};
use iga_core::surface::{ElementSide, Extraction};
use nalgebra::Vector3;

use super::bezier::Homogeneous;
use super::boxes::{Bounds, Leaf, Node, tree};
use crate::ContactError;
use crate::piecewise::{PiecewiseSurface, bilinear};
use crate::zone::points::DofLookup;

/// Pieces are halved until their control points are as near to the chord, relative to the piece's
/// size: a circular arc then turns by less than 30 degrees.
const FLATNESS: f64 = 0.13;
/// Halvings an element at most; poles and creases never become flat.
const MAX_HALVINGS: usize = 8;

/// Where a piece lies.
#[derive(Debug, Clone)]
pub(super) enum PieceOrigin {
    /// On the side of an element of a spline space: the number of its face, and the side.
    Spline { face: u32, side: ElementSide },
    /// On a side of a mesh: its number, and its parameters at the corners of the piece.
    Side { side: u32, corners: [[f64; 2]; 4] },
}

impl PieceOrigin {
    /// The site at the place `s` of the piece, at `point` of space.
    pub fn site(&self, s: [f64; 2], point: Vector3<f64>) -> SurfaceSite {
        match self {
            Self::Spline { face, side } => SurfaceSite { face: *face, xi: side.parameters(s), point },
            Self::Side { side, corners } => {
                let [a, b] = bilinear(corners, s);
                SurfaceSite { face: *side, xi: [a, b, 0.0], point }
            }
        }
    }
}

/// A point of a body's surface that a search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSite {
    /// Number of the face that it lies on, an index into [`FaceId::all`]; of a mesh that of the
    /// side.
    pub face: u32,
    /// Parameters in the face's patch, of a mesh those of the side.
    pub xi: [f64; 3],
    /// Position in the inertial frame \[m\].
    pub point: Vector3<f64>,
}

/// One Bézier piece of the surface.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    /// Where it lies.
    pub origin: PieceOrigin,
    pub degrees: [usize; 2],
    /// First point in the net.
    pub start: usize,
    pub n_points: usize,
    /// Sign that turns the product of the tangents outwards.
    pub orientation: f64,
}

/// Outer surface of a body: model data of the search, built once.
#[derive(Debug, Clone)]
pub struct SurfaceModel {
    motion: RigidMotion,
    pieces: Vec<Piece>,
    /// Undeformed homogeneous points, piece by piece.
    net: Arc<[Homogeneous]>,
    /// `w Φ` of every point, piece by piece, mode by mode.
    shapes: Arc<[f64]>,
    mode_bounds: Vec<f64>,
    frequencies: Vec<f64>,
    nodes: Vec<Node>,
    radius: f64,
    size: f64,
}

impl SurfaceModel {
    /// Surface of a flexible body.
    ///
    /// `patches`: those of `space` (the coarsest level of a hierarchical one); `shapes`: modes at
    /// the unknowns of `lookup`, `n_dofs × n_q`. An axial model has its `(r, z)` in `x` and `z` of
    /// space, a planar one in `x` and `y`.
    ///
    /// # Errors
    /// [`ContactError::Data`] if the body has no outer face or the modes do not belong to the space.
    pub fn new(
        motion: RigidMotion,
        patches: &[Patch],
        space: &dyn Space,
        lookup: &DofLookup,
        shapes: MatRef<'_, f64>,
    ) -> Result<Self, ContactError> {
        let faces = Face::outer(patches, motion == RigidMotion::Axial);
        if let Some(p) = patches.iter().find(|p| p.dimension() != motion.n_components()) {
            let (found, wanted) = (p.dimension(), motion.n_components());
            let what = "directions of a patch".into();
            return Err(DataError::Count { what, found, expected: wanted }.into());
        }
        let all = FaceId::all(patches);
        let mut builder = Builder::new(motion, patches, space, lookup, shapes);
        for face in &faces {
            let number = all.iter().position(|id| *id == face.id).unwrap_or_default() as u32;
            for side in ElementSide::all(space, face) {
                builder.add_element(number, side)?;
            }
        }
        builder.finish()
    }

    /// Surface of a flexible body that is made of pieces; without modes that of a rigid one.
    ///
    /// # Errors
    /// [`ContactError::Data`] if sizes differ or the modes do not belong to the nodes, [`ContactError::Nothing`] without a piece.
    pub fn of_pieces(
        motion: RigidMotion,
        surface: &PiecewiseSurface,
        lookup: &DofLookup,
        shapes: MatRef<'_, f64>,
    ) -> Result<Self, ContactError> {
        surface.check(motion)?;
        let (mut pieces, mut net, mut modes) = (Vec::new(), Vec::<Homogeneous>::new(), Vec::new());
        for piece in &surface.pieces {
            let places = piece.net(|node| surface.positions[node as usize]);
            let (degrees, start, n_points) = (piece.degrees, net.len(), places.len());
            net.extend(places.iter().map(|x| {
                let x = motion.in_space(x);
                [x[0], x[1], x[2], 1.0]
            }));
            let n_components = motion.n_components();
            let unknowns = || {
                piece.nodes.iter().flat_map(|&n| (0..n_components).filter_map(move |c| lookup.number(n, c)))
            };
            if let Some(number) = unknowns().find(|dof| *dof >= shapes.nrows() && shapes.ncols() > 0) {
                let (what, count) = ("rows of the mode shapes".into(), shapes.nrows());
                return Err(DataError::Index { what, number, count }.into());
            }
            for mode in 0..shapes.ncols() {
                let at = |node: u32| -> [f64; 3] {
                    let mut moved = [0.0; 3];
                    for c in 0..n_components {
                        let shape = lookup.number(node, c).map(|dof| shapes[(dof, mode)]);
                        moved[motion.direction(c)] = shape.unwrap_or_default();
                    }
                    moved
                };
                modes.extend(piece.net(at).as_flattened());
            }
            let origin = PieceOrigin::Side { side: piece.side, corners: piece.corners };
            pieces.push(Piece { origin, degrees, start, n_points, orientation: 1.0 });
        }
        Parts { motion, n_modes: shapes.ncols(), pieces, net, modes }.finish()
    }

    /// Surface of a rigid body.
    ///
    /// # Errors
    /// [`ContactError::Data`] as [`SurfaceModel::new`], or if the patches make no space.
    pub fn rigid(motion: RigidMotion, patches: &[Patch]) -> Result<Self, ContactError> {
        let space = PatchSpace::new(patches.to_vec())?;
        let none = faer::Mat::<f64>::zeros(0, 0);
        Self::new(motion, patches, &space, &DofLookup::new(&[]), none.as_ref())
    }

    /// Adds the angular frequencies of the modes [rad/s], so that bounds of the elastic velocity
    /// hold for the whole free motion and not for one instant (theory Eq. C.33).
    ///
    /// # Errors
    /// [`ContactError::Data`] for another number of modes, or a value that is negative or not finite.
    pub fn with_frequencies(mut self, frequencies: &[f64]) -> Result<Self, ContactError> {
        if frequencies.len() != self.n_modes() {
            let (what, found) = ("frequencies of the modes".into(), frequencies.len());
            return Err(DataError::Count { what, found, expected: self.n_modes() }.into());
        }
        if let Some(w) = frequencies.iter().find(|w| !(w.is_finite() && **w >= 0.0)) {
            let what = "the frequency of a mode [rad/s]".into();
            return Err(DataError::OutOfRange { what, value: *w, range: ">= 0 and finite" }.into());
        }
        self.frequencies = frequencies.to_vec();
        Ok(self)
    }

    /// The pieces that lie on none of the `sides` of a mesh; none if nothing is left. Points and
    /// modes are shared.
    pub fn without(&self, sides: &HashSet<u32>) -> Option<Self> {
        let is_left = |piece: &&Piece| match piece.origin {
            PieceOrigin::Spline { .. } => true,
            PieceOrigin::Side { side, .. } => !sides.contains(&side),
        };
        let pieces: Vec<Piece> = self.pieces.iter().filter(is_left).cloned().collect();
        let leaves: Vec<Leaf> = pieces.iter().map(|piece| leaf(self.motion, &self.net, piece)).collect();
        (!pieces.is_empty()).then(|| Self { nodes: tree(&leaves), pieces, ..self.clone() })
    }

    /// Rigid motions of the model.
    pub fn motion(&self) -> RigidMotion {
        self.motion
    }

    /// Number of modes.
    pub fn n_modes(&self) -> usize {
        self.mode_bounds.len()
    }

    /// Number of Bézier pieces.
    pub fn n_pieces(&self) -> usize {
        self.pieces.len()
    }

    /// Bound of the displacement that a unit of each mode gives anywhere on the surface \[m\].
    pub fn mode_bounds(&self) -> &[f64] {
        &self.mode_bounds
    }

    /// Angular frequencies of the modes, empty if they were not given [rad/s].
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// Largest distance of an undeformed surface point from the origin of the body's frame, or a
    /// little more \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Diagonal of the box around the undeformed surface \[m\].
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Least width of the undeformed body in the plane (x, y): of the bands between two parallel lines that hold the points of its
    /// pieces, in as many directions as a half turn has degrees \[m\].
    pub fn least_width(&self) -> f64 {
        let across = |degrees: u32| {
            let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
            let places = self.net.iter().map(|h| (h[0] * cosine + h[1] * sine) / h[3]);
            let [low, high] =
                places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
            high - low
        };
        (0..180).map(across).fold(f64::INFINITY, f64::min)
    }

    /// Bound of the displacement at elastic coordinates `q` (theory Eq. C.28) \[m\].
    pub fn displacement_bound(&self, q: &[f64]) -> f64 {
        self.mode_bounds.iter().zip(q).map(|(b, q)| b * q.abs()).sum()
    }

    pub(super) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Undeformed homogeneous points of a piece in the body's frame.
    pub(super) fn net(&self, piece: &Piece) -> &[Homogeneous] {
        &self.net[piece.start..piece.start + piece.n_points]
    }

    /// `w Φ` of the points of a piece, one mode after the other.
    pub(super) fn weighted_shapes(&self, piece: &Piece) -> impl Iterator<Item = &[[f64; 3]]> {
        let first = 3 * piece.start * self.n_modes();
        let width = 3 * piece.n_points;
        let shapes = &self.shapes[first..first + width * self.n_modes()];
        shapes.chunks_exact(width.max(1)).map(|shape| shape.as_chunks().0)
    }

    pub(super) fn across(&self) -> Option<Vector3<f64>> {
        across(self.motion)
    }

    /// Homogeneous points of a piece in the body's frame at elastic coordinates `q`.
    pub(super) fn deform(&self, piece: &Piece, q: &[f64], out: &mut [Homogeneous]) {
        let n = piece.n_points;
        out.copy_from_slice(&self.net[piece.start..piece.start + n]);
        let width = 3 * n;
        let first = 3 * piece.start * self.n_modes();
        let shapes = &self.shapes[first..first + width * self.n_modes()];
        for (shape, q) in shapes.chunks_exact(width).zip(q) {
            for (h, u) in out.iter_mut().zip(shape.chunks_exact(3)) {
                h[0] += q * u[0];
                h[1] += q * u[1];
                h[2] += q * u[2];
            }
        }
    }

    /// Number of homogeneous points of all pieces.
    pub(super) fn n_points(&self) -> usize {
        self.net.len()
    }
}

/// Collects pieces.
struct Builder<'a> {
    motion: RigidMotion,
    space: &'a dyn Space,
    lookup: &'a DofLookup,
    shapes: MatRef<'a, f64>,
    extraction: Extraction<'a>,
    active: Vec<u32>,
    pieces: Vec<Piece>,
    net: Vec<Homogeneous>,
    modes: Vec<f64>,
}

impl<'a> Builder<'a> {
    fn new(
        motion: RigidMotion,
        patches: &'a [Patch],
        space: &'a dyn Space,
        lookup: &'a DofLookup,
        shapes: MatRef<'a, f64>,
    ) -> Self {
        Self {
            motion,
            space,
            lookup,
            shapes,
            extraction: Extraction::new(space, patches),
            active: Vec::new(),
            pieces: Vec::new(),
            net: Vec::new(),
            modes: Vec::new(),
        }
    }

    /// Adds one side of an element on the face of number `face`, halved until its pieces are flat.
    fn add_element(&mut self, face: u32, side: ElementSide) -> Result<(), ContactError> {
        self.space.active_functions(side.element, &mut self.active);
        let degrees = self.extraction.degrees(&side.face);
        let directions: Vec<usize> = side.face.directions().collect();
        let n_points = (degrees[0] + 1) * (degrees[1] + 1);
        let orientation = side.face.orientation();
        let mut waiting = vec![(side, 0)];
        while let Some((mut side, halvings)) = waiting.pop() {
            let net = self.geometry(&side);
            match bent_direction(&net, degrees) {
                Some(d) if halvings < MAX_HALVINGS => {
                    let k = directions[d];
                    let middle = 0.5 * (side.lower[k] + side.upper[k]);
                    let mut second = side;
                    side.upper[k] = middle;
                    second.lower[k] = middle;
                    waiting.push((second, halvings + 1));
                    waiting.push((side, halvings + 1));
                }
                _ => {
                    let (start, origin) = (self.net.len(), PieceOrigin::Spline { face, side });
                    self.net.extend(net);
                    self.add_shapes(&side)?;
                    self.pieces.push(Piece { origin, degrees, start, n_points, orientation });
                }
            }
        }
        Ok(())
    }

    /// Undeformed homogeneous points of a piece.
    fn geometry(&mut self, side: &ElementSide) -> Vec<Homogeneous> {
        let points = self.space.control_points();
        let at_node = |row: Vec<f64>| {
            let mut sum = [0.0; 4];
            for (r, &f) in row.iter().zip(&self.active) {
                for c in 0..self.motion.n_components() {
                    sum[self.motion.direction(c)] += r * points[f as usize][c];
                }
                sum[3] += r;
            }
            sum
        };
        let values: Vec<Homogeneous> = self.extraction.numerators(side).into_iter().map(at_node).collect();
        self.extraction.coefficients(&side.face, &values)
    }

    fn add_shapes(&mut self, side: &ElementSide) -> Result<(), ContactError> {
        let n_modes = self.shapes.ncols();
        if n_modes == 0 {
            return Ok(());
        }
        // Unknowns of the active functions: function, direction in space, number.
        let mut unknowns = Vec::new();
        for (k, &f) in self.active.iter().enumerate() {
            for c in 0..self.motion.n_components() {
                unknowns.extend(self.lookup.number(f, c).map(|dof| (k, self.motion.direction(c), dof)));
            }
        }
        if let Some((.., dof)) = unknowns.iter().find(|u| u.2 >= self.shapes.nrows()) {
            let (what, count) = ("rows of the mode shapes".into(), self.shapes.nrows());
            return Err(DataError::Index { what, number: *dof, count }.into());
        }
        let numerators = self.extraction.numerators(side);
        for mode in 0..n_modes {
            let at_node = |row: &Vec<f64>| {
                let mut sum = [0.0; 3];
                for &(k, direction, dof) in unknowns.iter().filter(|u| row[u.0] != 0.0) {
                    sum[direction] += row[k] * self.shapes[(dof, mode)];
                }
                sum
            };
            let values: Vec<[f64; 3]> = numerators.iter().map(at_node).collect();
            self.modes.extend(self.extraction.coefficients(&side.face, &values).as_flattened());
        }
        Ok(())
    }

    fn finish(self) -> Result<SurfaceModel, ContactError> {
        let Self { motion, shapes, pieces, net, modes, .. } = self;
        Parts { motion, n_modes: shapes.ncols(), pieces, net, modes }.finish()
    }
}

/// Pieces with their points and modes, before the tree is built.
struct Parts {
    motion: RigidMotion,
    n_modes: usize,
    pieces: Vec<Piece>,
    net: Vec<Homogeneous>,
    modes: Vec<f64>,
}

impl Parts {
    fn finish(self) -> Result<SurfaceModel, ContactError> {
        if self.pieces.is_empty() {
            return Err(ContactError::Nothing { what: "the body has no outer face to search" });
        }
        let n_modes = self.n_modes;
        let mut mode_bounds = vec![0.0_f64; n_modes];
        for piece in &self.pieces {
            let shapes = &self.modes[3 * piece.start * n_modes..];
            for (mode, bound) in mode_bounds.iter_mut().enumerate() {
                for k in 0..piece.n_points {
                    let u = &shapes[3 * (mode * piece.n_points + k)..][..3];
                    let length = Vector3::new(u[0], u[1], u[2]).norm() / self.net[piece.start + k][3];
                    // Kept this way round, a NaN stays.
                    *bound = if length <= *bound { *bound } else { length };
                }
            }
        }
        if let Some(mode) = mode_bounds.iter().position(|b| !b.is_finite()) {
            let what = format!("the shape of mode {mode} on the surface");
            return Err(DataError::NotFinite { what }.into());
        }
        let leaves: Vec<Leaf> = self.pieces.iter().map(|piece| leaf(self.motion, &self.net, piece)).collect();
        let whole = Bounds::around(self.net.iter().map(cartesian));
        Ok(SurfaceModel {
            motion: self.motion,
            nodes: tree(&leaves),
            radius: self.net.iter().map(|h| cartesian(h).norm()).fold(0.0, f64::max),
            size: 2.0 * whole.half.norm(),
            pieces: self.pieces,
            net: self.net.into(),
            shapes: self.modes.into(),
            mode_bounds,
            frequencies: Vec::new(),
        })
    }
}

/// Control points and mean normal of a piece of `net`.
fn leaf(motion: RigidMotion, net: &[Homogeneous], piece: &Piece) -> Leaf {
    let points: Vec<Vector3<f64>> =
        net[piece.start..piece.start + piece.n_points].iter().map(cartesian).collect();
    let n = piece.degrees[0] + 1;
    let last = points.len() - 1;
    let normal = match across(motion) {
        Some(across) => (points[last] - points[0]).cross(&across),
        // The product of the diagonals.
        None => (points[n - 1] - points[last + 1 - n]).cross(&(points[last] - points[0])),
    };
    let bounds = Bounds::around(points.iter().copied());
    Leaf { points, bounds, normal: normal * piece.orientation }
}

/// Vector that takes the place of the second tangent of a curve: tangent × it points across the
/// curve.
fn across(motion: RigidMotion) -> Option<Vector3<f64>> {
    match motion {
        RigidMotion::Axial => Some(-Vector3::y()),
        RigidMotion::Planar => Some(Vector3::z()),
        RigidMotion::Spatial => None,
    }
}

/// Point in space of a homogeneous one.
pub(super) fn cartesian(h: &Homogeneous) -> Vector3<f64> {
    Vector3::new(h[0], h[1], h[2]) / h[3]
}

/// The direction in which the rows of control points leave their chords farthest, none if the piece
/// is flat.
fn bent_direction(net: &[Homogeneous], degrees: [usize; 2]) -> Option<usize> {
    let limit = FLATNESS * 2.0 * Bounds::around(net.iter().map(cartesian)).half.norm();
    let n = degrees.map(|p| p + 1);
    let at = |i: usize, j: usize| cartesian(&net[i + n[0] * j]);
    let away = |p: Vector3<f64>, a: Vector3<f64>, b: Vector3<f64>| {
        let chord = b - a;
        let length = chord.norm_squared();
        let share = if length > 0.0 { ((p - a).dot(&chord) / length).clamp(0.0, 1.0) } else { 0.0 };
        (p - a - chord * share).norm()
    };
    let mut worst = [0.0_f64; 2];
    for j in 0..n[1] {
        for i in 0..n[0] {
            worst[0] = worst[0].max(away(at(i, j), at(0, j), at(n[0] - 1, j)));
            worst[1] = worst[1].max(away(at(i, j), at(i, 0), at(i, n[1] - 1)));
        }
    }
    let d = usize::from(worst[1] > worst[0]);
    (worst[d] > limit).then_some(d)
}
