//! The target of a contact: faces of a spline body as data, with low modes and interface compliance
//! of their functions.
//!
//! Whatever the space, its functions on an element of a face are `N_A / Σ N_B` with polynomials
//! `N_A`: their Bernstein coefficients are found once (Eq. C.37), so that an evaluation needs
//! neither space nor patch.

pub(super) mod bezier;
mod smoothing;

use std::collections::BTreeMap;

use faer::{Mat, MatRef};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::{DataError, check_square};
use iga_core::ParameterBox;
use iga_core::nurbs::Face;
use iga_core::nurbs::Patch;
use iga_core::nurbs::jet::diagonal;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::Space;
use iga_core::surface::ElementSide;

use crate::ContactError;
use crate::piecewise::{PiecewiseSurface, SurfacePiece};
use crate::zone::points::{DofLookup, InterfaceCompliance};
use smoothing::Smoothing;

/// Depth below a face from which it presses points, over the least extent of the body.
const DEPTH: f64 = 0.25;

/// A projection counts as held by the end of a face if the point lies farther beyond it than this
/// part of the target's size, and as lying on the axis if it is nearer to that.
const BEYOND: f64 = 1e-12;

/// Distance, as a share of the target's size, by which a point must lie beyond a seam before it is
/// projected on the next face: it must not change between two faces from pass to pass. Gaps are off
/// by this distance times the angle between the normals of the faces.
const SEAM: f64 = 1e-6;

/// A face of a body, or a part of one, that may be touched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetFace {
    /// The face.
    pub face: Face,
    /// Its parameters; the fixed one is ignored.
    pub bounds: ParameterBox,
}

impl TargetFace {
    /// The whole of `face`.
    pub fn whole(face: Face, patches: &[Patch]) -> Self {
        let (lower, upper) = patches[face.id.patch].domain();
        Self { face, bounds: ParameterBox { lower, upper } }
    }
}

/// Functions of one element of a face.
#[derive(Debug, Clone)]
pub(super) struct FaceElement {
    pub lower: [f64; 2],
    pub upper: [f64; 2],
    /// Nodes whose functions are not zero here.
    pub nodes: Vec<u32>,
    /// Bernstein coefficients, one row per node, first direction fastest.
    pub coefficients: Vec<f64>,
    /// Whether all these functions belong to the interface.
    pub is_in_zone: bool,
}

/// One face in its own one or two parameters.
#[derive(Debug, Clone)]
pub(super) struct FaceGrid {
    pub degrees: [usize; 2],
    /// Ends of the cells; a single cell in an absent direction.
    pub breaks: [Vec<f64>; 2],
    /// Element of each cell.
    pub cells: Vec<u32>,
    /// Sign that makes the normal point outwards.
    pub orientation: f64,
    /// Whether the lower and the upper end of each direction are edges of the body that contact
    /// must not reach.
    pub is_edge: [[bool; 2]; 2],
    /// Largest distance of two places of the face: the diagonal of the box around the net of a piece, infinite
    /// for faces with many elements \[m\].
    pub reach: f64,
}

impl FaceGrid {
    /// Element that holds `xi`.
    pub fn element(&self, xi: &[f64; 2]) -> usize {
        let [i, j] = [0, 1].map(|a| {
            let breaks = &self.breaks[a];
            breaks.partition_point(|b| *b <= xi[a]).clamp(1, breaks.len() - 1) - 1
        });
        self.cells[i + j * (self.breaks[0].len() - 1)] as usize
    }

    /// Lower and upper end of direction `a`.
    pub fn range(&self, a: usize) -> [f64; 2] {
        [self.breaks[a][0], self.breaks[a][self.breaks[a].len() - 1]]
    }
}

/// Surface of a reduced body, or of a rigid one, that contact points are projected on.
#[derive(Debug, Clone)]
pub struct TargetSurface {
    pub(super) motion: RigidMotion,
    /// Number of surface parameters.
    pub(super) n_parameters: usize,
    /// Control points, in the model's components.
    pub(super) nodes: Vec<[f64; 3]>,
    pub(super) faces: Vec<FaceGrid>,
    pub(super) elements: Vec<FaceElement>,
    /// Rows of the low-frequency shapes, `n_components node + component`.
    pub(super) low_rows: Vec<f64>,
    /// The low-frequency shapes of the nodes, mode after mode, three entries for each node.
    pub(super) low_columns: Vec<f64>,
    pub(super) n_modes: usize,
    /// Interface degree of freedom of every row.
    pub(super) dofs: Vec<Option<u32>>,
    /// Compliance of the interface, zero-sized for a rigid body or when all modes are dynamic.
    pub(super) compliance: Mat<f64>,
    /// Diagonal of the box around the control points.
    pub(super) size: f64,
    /// Largest number of functions of an element.
    pub(super) n_functions: usize,
    /// Continuous normals, of smooth surfaces made of pieces.
    pub(super) smoothing: Option<Smoothing>,
    /// Largest ratio of the displacement of a point of the surface to the largest displacement of a
    /// node. One for splines, whose functions are positive; more for functions that may be
    /// negative.
    pub(super) spread: f64,
    /// Whether these are all faces of the body. If so, a projection may end on any of them.
    pub(super) is_complete: bool,
    /// How points at the ends of faces are treated, where contact is possible at the edges of the
    /// body.
    pub(super) edges: Option<Edges>,
}

/// How points at the edges of a body are treated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edges {
    /// How far beyond the end of a face points still lie over it \[m\].
    pub overhang: f64,
    /// Depth below a face from which it still presses points \[m\].
    pub reach: f64,
}

impl TargetSurface {
    /// Surface of a rigid body, made of `faces` of `space` over `patches`.
    ///
    /// # Errors
    /// [`ContactError::Data`] if a face lies in no element or has no surface parameter.
    pub fn rigid(
        motion: RigidMotion,
        space: &dyn Space,
        patches: &[Patch],
        faces: &[TargetFace],
    ) -> Result<Self, ContactError> {
        let lookup = DofLookup::new(&[]);
        Self::flexible(motion, space, patches, faces, &lookup, Mat::zeros(0, 0).as_ref(), None)
    }

    /// Surface of a flexible body. `patches` carry the weight function of the space (the refined
    /// ones of a plain space, the coarsest of a hierarchical one); `shapes`: modes of the dynamic
    /// elastic coordinates at the unknowns, `n_dofs × n_q`; `interface`: compliance of the
    /// interface, none when all modes are dynamic.
    ///
    /// # Errors
    /// [`ContactError::Data`] if sizes differ, a face lies in no element, or has no surface parameter.
    pub fn flexible(
        motion: RigidMotion,
        space: &dyn Space,
        patches: &[Patch],
        faces: &[TargetFace],
        lookup: &DofLookup,
        shapes: MatRef<'_, f64>,
        interface: Option<InterfaceCompliance<'_>>,
    ) -> Result<Self, ContactError> {
        let expected = motion.n_components();
        if space.dimension() != expected {
            let (what, found) = ("directions of the target".into(), space.dimension());
            return Err(DataError::Count { what, found, expected }.into());
        }
        let mut collection = Collection { space, patches, numbers: BTreeMap::new(), elements: Vec::new() };
        let grids = faces.iter().map(|f| collection.face(f)).collect::<Result<Vec<_>, _>>()?;
        let Collection { numbers, elements, .. } = collection;
        let mut nodes = vec![[0.0; 3]; numbers.len()];
        for (&function, &node) in &numbers {
            nodes[node as usize] = space.control_points()[function as usize];
        }
        let n_functions = elements.iter().map(|e| e.nodes.len()).max().unwrap_or(0);
        let mut surface = Self {
            motion,
            n_parameters: expected - 1,
            size: diagonal(&nodes),
            low_rows: vec![0.0; nodes.len() * expected * shapes.ncols()],
            low_columns: Vec::new(),
            n_modes: shapes.ncols(),
            dofs: vec![None; nodes.len() * expected],
            compliance: Mat::zeros(0, 0),
            nodes,
            faces: grids,
            elements,
            n_functions,
            smoothing: None,
            spread: 1.0,
            is_complete: false,
            edges: None,
        };
        if surface.elements.is_empty() {
            return Err(ContactError::Nothing { what: "the target has no face" });
        }
        surface.attach(&numbers, lookup, shapes, interface)?;
        Ok(surface)
    }

    /// Surface of a flexible body that is made of pieces; points are projected on it along
    /// continuous normals (Eqs. C.51 to C.53). `shapes` and `interface` are those of
    /// [`TargetSurface::flexible`].
    ///
    /// # Errors
    /// [`ContactError::Data`] if sizes differ, [`ContactError::Nothing`] without a piece.
    pub fn of_pieces(
        motion: RigidMotion,
        surface: &PiecewiseSurface,
        lookup: &DofLookup,
        shapes: MatRef<'_, f64>,
        interface: Option<InterfaceCompliance<'_>>,
    ) -> Result<Self, ContactError> {
        surface.check(motion)?;
        let mut numbers: BTreeMap<u32, u32> = BTreeMap::new();
        let mut nodes = Vec::new();
        for &node in surface.pieces.iter().flat_map(|p| &p.nodes) {
            numbers.entry(node).or_insert_with(|| {
                nodes.push(surface.positions[node as usize]);
                nodes.len() as u32 - 1
            });
        }
        let number = |node: u32| numbers.get(&node).copied().unwrap_or_default();
        let element = |piece: &SurfacePiece| FaceElement {
            lower: [0.0; 2],
            upper: [1.0; 2],
            nodes: piece.nodes.iter().map(|&n| number(n)).collect(),
            coefficients: piece.coefficients.clone(),
            is_in_zone: true,
        };
        let grid = |(i, piece): (usize, &SurfacePiece)| FaceGrid {
            degrees: piece.degrees,
            breaks: [vec![0.0, 1.0], vec![0.0, 1.0]],
            cells: vec![i as u32],
            orientation: 1.0,
            is_edge: [[false; 2]; 2],
            reach: diagonal(&piece.net(|n| surface.positions[n as usize])),
        };
        let smoothing = Smoothing::new(surface, motion, number);
        let n_components = motion.n_components();
        let mut target = Self {
            motion,
            n_parameters: n_components - 1,
            size: diagonal(&nodes),
            low_rows: vec![0.0; nodes.len() * n_components * shapes.ncols()],
            low_columns: Vec::new(),
            n_modes: shapes.ncols(),
            dofs: vec![None; nodes.len() * n_components],
            compliance: Mat::zeros(0, 0),
            faces: surface.pieces.iter().enumerate().map(grid).collect(),
            elements: surface.pieces.iter().map(element).collect(),
            n_functions: surface.pieces.iter().map(|p| p.nodes.len()).max().unwrap_or(0),
            spread: smoothing.spread,
            smoothing: Some(smoothing),
            is_complete: false,
            edges: None,
            nodes,
        };
        target.attach(&numbers, lookup, shapes, interface)?;
        Ok(target)
    }

    /// This surface as the whole surface of a body: where a face ends, the body has an edge, at
    /// which contact is possible. Points that lie beyond the end of a face by no more than
    /// `overhang` \[m\] count as lying over it, as edges that lie on each other may be displaced by
    /// so much (Eq. C.57). Pieces become faces of their own, without continuous normals. `least`: the
    /// least extent of the body along the axes, if this is a part of its surface \[m\].
    #[must_use]
    pub fn with_edges(mut self, overhang: f64, least: Option<f64>) -> Self {
        // Must be less than the distance to the opposite face; the least extent of the control
        // points bounds that.
        let extent = |c: usize| {
            let along = || self.nodes.iter().map(|x| x[c]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        let of_nodes = || (0..self.motion.n_components()).map(extent).fold(f64::INFINITY, f64::min);
        let least = least.unwrap_or_else(of_nodes);
        self.edges = Some(Edges { overhang, reach: DEPTH * least });
        self.is_complete = true;
        self.smoothing = None;
        self
    }

    /// How far beyond the end of a face points still lie over it: round-off, or what edges are
    /// displaced by \[m\].
    pub(super) fn overhang(&self) -> f64 {
        let round_off = if self.is_joined() { SEAM * self.size } else { self.round_off() };
        self.edges.map_or(round_off, |edges| edges.overhang.max(round_off))
    }

    /// Whether the surface consists of several faces of a spline body that are joined by seams, and
    /// is not the whole surface of the body.
    pub(super) fn is_joined(&self) -> bool {
        self.faces.len() > 1 && !self.is_complete && self.smoothing.is_none()
    }

    /// Length of an element: the diagonal of the box of its nodes, over as many as stand in a row \[m\].
    pub(super) fn length(&self, element: u32) -> f64 {
        let nodes = &self.elements[element as usize].nodes;
        diagonal(nodes.iter().map(|node| &self.nodes[*node as usize]))
            / (nodes.len() as f64).powf(1.0 / self.n_parameters as f64)
    }

    /// Round-off of places on the surface \[m\].
    pub(super) fn round_off(&self) -> f64 {
        BEYOND * self.size
    }

    /// Number of continuous normals: that of the nodes, none of splines.
    pub(super) fn n_normals(&self) -> usize {
        if self.smoothing.is_some() { self.nodes.len() } else { 0 }
    }

    /// Continuous normals at the nodes, which stand at `nodes`.
    pub(super) fn normals(&self, nodes: &[[f64; 3]], out: &mut [[f64; 3]]) {
        if let Some(smoothing) = &self.smoothing {
            smoothing.normals(nodes, out);
        }
    }

    /// Copies modes and interface compliance to the nodes.
    fn attach(
        &mut self,
        numbers: &BTreeMap<u32, u32>,
        lookup: &DofLookup,
        shapes: MatRef<'_, f64>,
        interface: Option<InterfaceCompliance<'_>>,
    ) -> Result<(), ContactError> {
        let (nc, n_q) = (self.motion.n_components(), self.n_modes);
        let mut place = vec![None; shapes.nrows()];
        if let Some(interface) = interface {
            let n_b = interface.dofs.len();
            let g = interface.compliance;
            check_square("the compliance of the interface", g, n_b)?;
            for (b, &dof) in interface.dofs.iter().enumerate() {
                match place.get_mut(dof) {
                    Some(entry) => *entry = Some(b as u32),
                    None => {
                        let (what, count) = ("unknowns of the interface".into(), shapes.nrows());
                        return Err(DataError::Index { what, number: dof, count }.into());
                    }
                }
            }
            self.compliance = g.to_owned();
        }
        let mut is_outside = vec![false; self.nodes.len()];
        for (&function, &node) in numbers {
            for c in 0..nc {
                let Some(dof) = lookup.number(function, c) else { continue };
                if dof >= shapes.nrows() {
                    let (what, count) = ("rows of the mode shapes".into(), shapes.nrows());
                    return Err(DataError::Index { what, number: dof, count }.into());
                }
                let row = nc * node as usize + c;
                (0..n_q).for_each(|k| self.low_rows[row * n_q + k] = shapes[(dof, k)]);
                self.dofs[row] = place[dof];
                is_outside[node as usize] |= place[dof].is_none();
            }
        }
        let column = |k: usize| self.low_rows.iter().skip(k).step_by(n_q).copied();
        self.low_columns = (0..n_q).flat_map(|k| by_places(nc, column(k))).collect();
        if !self.low_rows.iter().all(|x| x.is_finite()) {
            return Err(DataError::NotFinite { what: "a mode shape of the target".into() }.into());
        }
        if self.compliance.nrows() > 0 {
            for element in &mut self.elements {
                element.is_in_zone = element.nodes.iter().all(|&n| !is_outside[n as usize]);
            }
        }
        Ok(())
    }

    /// Whether the surface has a quasistatic compliance.
    pub fn is_quasistatic(&self) -> bool {
        self.compliance.nrows() > 0
    }

    /// Number of elastic coordinates.
    pub fn n_modes(&self) -> usize {
        self.n_modes
    }

    /// Number of interface degrees of freedom.
    pub fn n_interface(&self) -> usize {
        self.compliance.nrows()
    }

    /// Row of the low-frequency shapes.
    pub(super) fn low_row(&self, row: usize) -> &[f64] {
        &self.low_rows[row * self.n_modes..(row + 1) * self.n_modes]
    }
}

/// Elements and nodes of the faces as they are gathered.
struct Collection<'a> {
    space: &'a dyn Space,
    patches: &'a [Patch],
    /// Node of each function.
    numbers: BTreeMap<u32, u32>,
    elements: Vec<FaceElement>,
}

impl Collection<'_> {
    /// Gathers one face.
    fn face(&mut self, wanted: &TargetFace) -> Result<FaceGrid, ContactError> {
        let face = &wanted.face;
        let patch = &self.patches[face.id.patch];
        let (first, last) = patch.domain();
        let (mut lower, mut upper, degrees) = ([0.0; 2], [1.0; 2], face.degrees(patch));
        for (a, d) in face.directions().enumerate() {
            lower[a] = wanted.bounds.lower[d].max(first[d]);
            upper[a] = wanted.bounds.upper[d].min(last[d]);
        }
        if face.dimension < 2 || !(0..2).all(|a| lower[a] < upper[a]) {
            return Err(ContactError::EmptyFace { lower, upper });
        }
        let start = self.elements.len();
        let weight = WeightFunction::new(patch);
        let mut breaks = [vec![lower[0], upper[0]], vec![lower[1], upper[1]]];
        for side in ElementSide::all(self.space, face) {
            let (mut low, mut high) = ([0.0; 2], [1.0; 2]);
            for (a, d) in face.directions().enumerate() {
                (low[a], high[a]) = (side.lower[d], side.upper[d]);
            }
            if !(0..2).all(|a| low[a].max(lower[a]) < high[a].min(upper[a])) {
                continue;
            }
            for a in 0..2 {
                breaks[a].extend([low[a], high[a]].iter().filter(|u| **u > lower[a] && **u < upper[a]));
            }
            let element = self.element(&side, (low, high), degrees, &weight);
            self.elements.push(element);
        }
        for list in &mut breaks {
            list.sort_unstable_by(f64::total_cmp);
            list.dedup();
        }
        let cells = self.cells(start, &breaks)?;
        let (orientation, reach) = (face.orientation(), f64::INFINITY);
        Ok(FaceGrid { degrees, breaks, cells, orientation, is_edge: [[false; 2]; 2], reach })
    }

    /// Element of each cell between `breaks`, found by the cell's middle among the elements from
    /// `start` on.
    fn cells(&self, start: usize, breaks: &[Vec<f64>; 2]) -> Result<Vec<u32>, ContactError> {
        let mut cells = Vec::new();
        for v in breaks[1].windows(2) {
            for u in breaks[0].windows(2) {
                let middle = [0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])];
                let holds =
                    |e: &FaceElement| (0..2).all(|a| e.lower[a] <= middle[a] && middle[a] <= e.upper[a]);
                match self.elements[start..].iter().position(holds) {
                    Some(e) => cells.push((start + e) as u32),
                    None => return Err(ContactError::NoElement { parameters: middle }),
                }
            }
        }
        Ok(cells)
    }

    /// Bernstein coefficients of the functions of an element on its `side`, whose ends along the
    /// face are `lower` and `upper`.
    fn element(
        &mut self,
        side: &ElementSide,
        (lower, upper): ([f64; 2], [f64; 2]),
        degrees: [usize; 2],
        weight: &WeightFunction,
    ) -> FaceElement {
        let fits = degrees.map(bezier::fit);
        let (n0, n1) = (degrees[0] + 1, degrees[1] + 1);
        let (mut basis, mut active) = (PointBasis::default(), Vec::new());
        self.space.active_functions(side.element, &mut active);
        let mut samples = vec![0.0; active.len() * n0 * n1];
        for j in 0..n1 {
            for i in 0..n0 {
                let xi = side.parameters([0, 1].map(|a| bezier::sample(degrees[a], [i, j][a])));
                self.space.evaluate(side.element, &xi, 0, &mut basis);
                let w = weight.at(&xi);
                for (row, value) in samples.chunks_exact_mut(n0 * n1).zip(&basis.values) {
                    row[i + n0 * j] = value * w;
                }
            }
        }
        let (mut nodes, mut coefficients) = (Vec::new(), Vec::new());
        for (&function, row) in active.iter().zip(samples.chunks_exact(n0 * n1)) {
            if row.iter().all(|v| v.abs() <= 0.0) {
                continue; // a function of the inside, exactly zero on the face
            }
            let next = self.numbers.len() as u32;
            nodes.push(*self.numbers.entry(function).or_insert(next));
            for l in 0..n1 {
                for k in 0..n0 {
                    let term = |i: usize, j: usize| fits[0][(k, i)] * fits[1][(l, j)] * row[i + n0 * j];
                    coefficients.push(
                        (0..n1).flat_map(|j| (0..n0).map(move |i| (i, j))).map(|(i, j)| term(i, j)).sum(),
                    );
                }
            }
        }
        FaceElement { lower, upper, nodes, coefficients, is_in_zone: true }
    }
}

/// The weight function `W = Σ w_A N_A` of a patch, which refinement keeps.
struct WeightFunction {
    /// The patch with unit weights: its rational functions are the B-splines.
    splines: Option<Patch>,
    weights: Vec<f64>,
}

impl WeightFunction {
    fn new(patch: &Patch) -> Self {
        let ones = vec![1.0; patch.n_functions()];
        let splines = Patch::new(patch.knots().to_vec(), patch.control_points().to_vec(), ones).ok();
        Self { splines, weights: patch.weights().to_vec() }
    }

    fn at(&self, xi: &[f64; 3]) -> f64 {
        let Some(splines) = &self.splines else { return f64::NAN };
        let e = splines.find_element(xi);
        let mut basis = PointBasis::default();
        splines.evaluate(e, xi, 0, &mut basis);
        splines.active_indices(e).zip(&basis.values).map(|(i, n)| self.weights[i] * n).sum()
    }
}

/// The entries `column` of displacements in `nc` components, three for each place, of which the
/// last are zero.
pub(super) fn by_places(nc: usize, column: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut places = Vec::new();
    for (row, entry) in column.enumerate() {
        if row % nc == 0 {
            places.extend([0.0; 3]);
        }
        let place = places.len() - 3;
        places[place + row % nc] = entry;
    }
    places
}

/// All six faces of a cube of unit length.
#[cfg(test)]
pub(super) fn cube() -> TargetSurface {
    use iga_core::{nurbs::FaceId, space::PatchSpace, splines::knots::KnotVector};
    let corners = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(f64::from)).collect();
    let knots = vec![KnotVector::uniform(1, 1).expect("knots"); 3];
    let patches = vec![Patch::new(knots, corners, vec![1.0; 8]).expect("a cube")];
    let space = PatchSpace::new(patches.clone()).expect("a space");
    let faces: Vec<TargetFace> = (0..6)
        .map(|k| FaceId { patch: 0, direction: k / 2, upper: k % 2 == 1 })
        .map(|id| TargetFace::whole(Face::new(&patches, id, false), &patches))
        .collect();
    TargetSurface::rigid(RigidMotion::Spatial, &space, &patches, &faces).expect("a surface").complete()
}
