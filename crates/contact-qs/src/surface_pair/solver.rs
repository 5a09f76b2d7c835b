//! The quasistatic problem of two bodies: common normal compliance, solver, displacements.

use faer::Mat;
use ffr_dynamics::error::Rejection;

use super::projection::{Projection, SurfacePlace};
use super::target::TargetSurface;
use crate::ContactError;
use crate::quasistatic::active_set::{ActiveSet, SolveReport};
use crate::quasistatic::broyden::{Broyden, ModalProblem};
use crate::quasistatic::problem::{add_columns, add_product};
use crate::quasistatic::{Method, ModalBasis, Problem};

/// Normals and functions at the projected points: the rows that compliances are projected on.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// Normal in the target's frame, for each point.
    pub normals: Vec<[f64; 3]>,
    /// The same normal in the contact body's frame.
    pub own_normals: Vec<[f64; 3]>,
    /// Places of the points' projections.
    pub places: Vec<SurfacePlace>,
    /// Element of the target for each point.
    pub elements: Vec<u32>,
    /// Functions of the target's nodes there, `width` for each point.
    pub values: Vec<f64>,
    pub width: usize,
}

impl Rows {
    pub fn new(n_points: usize, width: usize) -> Self {
        Self {
            normals: vec![[0.0; 3]; n_points],
            own_normals: vec![[0.0; 3]; n_points],
            places: vec![SurfacePlace::default(); n_points],
            elements: vec![0; n_points],
            values: vec![0.0; n_points * width],
            width,
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.normals.copy_from_slice(&other.normals);
        self.own_normals.copy_from_slice(&other.own_normals);
        self.places.copy_from_slice(&other.places);
        self.elements.copy_from_slice(&other.elements);
        self.values.copy_from_slice(&other.values);
    }

    /// Sets the row of point `i`, projected to `found`.
    pub fn set(
        &mut self,
        i: usize,
        found: &Projection,
        own_normal: [f64; 3],
        values: impl Iterator<Item = f64>,
    ) {
        self.normals[i] = found.normal;
        self.own_normals[i] = own_normal;
        self.elements[i] = found.element;
        self.places[i] = found.place;
        let slots = &mut self.values[i * self.width..(i + 1) * self.width];
        slots.fill(0.0);
        slots.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
    }

    /// How far the points chosen by `is_chosen` have moved since `before`: largest change of a normal (radians) or a place
    /// (elements).
    pub fn moved(&self, before: &Self, surface: &TargetSurface, is_chosen: impl Fn(usize) -> bool) -> f64 {
        let mut moved = 0.0_f64;
        for i in (0..self.normals.len()).filter(|i| is_chosen(*i)) {
            let (here, there) = (&self.places[i], &before.places[i]);
            if here.face != there.face {
                return f64::INFINITY;
            }
            let element = &surface.elements[self.elements[i] as usize];
            for a in 0..surface.n_parameters {
                moved = moved.max((here.xi[a] - there.xi[a]).abs() / (element.upper[a] - element.lower[a]));
            }
            let turned = self.normals[i].iter().zip(&before.normals[i]);
            moved = turned.fold(moved, |m, (x, y)| m.max((x - y).abs()));
        }
        moved
    }

    /// Interface freedom and value of every entry of row `i` of `N_T`.
    fn entries<'a>(
        &'a self,
        surface: &'a TargetSurface,
        i: usize,
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        let nc = surface.motion.n_components();
        let nodes = &surface.elements[self.elements[i] as usize].nodes;
        let normal = &self.normals[i];
        nodes.iter().zip(&self.values[i * self.width..]).flat_map(move |(&node, &value)| {
            let freedoms = &surface.freedoms[nc * node as usize..][..nc];
            freedoms.iter().zip(normal).filter_map(move |(b, n)| b.map(|b| (b as usize, value * n)))
        })
    }
}

/// Algorithm 1 with the modes of both compliances.
struct Modal {
    solver: Broyden,
    /// Modes at the contact body's points and at the target's interface.
    bases: [Option<ModalBasis>; 2],
    stiffness: Vec<f64>,
    normal_shapes: Mat<f64>,
}

enum Solver {
    ActiveSet(ActiveSet),
    Broyden(Box<Modal>),
}

/// Both bodies' compliances, projected on the rows of one instant, and the solver's state.
pub(super) struct PairZone {
    /// Compliance of the contact body's points; zero-sized if it has none.
    own: Mat<f64>,
    n_components: usize,
    /// Normal compliance `A` of the points on `rows`.
    normal_compliance: Mat<f64>,
    /// Displacements of the target's interface and of the contact body's points under one point's load.
    half: Vec<f64>,
    own_half: Vec<f64>,
    /// Rows that `A` was built on, and the points it was built for: the others have zero rows and columns.
    rows: Rows,
    members: Vec<bool>,
    saved_rows: Rows,
    saved_members: Vec<bool>,
    solver: Solver,
}

impl PairZone {
    pub fn new(
        method: Method,
        n_components: usize,
        own: Mat<f64>,
        n_points: usize,
        surface: &TargetSurface,
    ) -> Result<Self, ContactError> {
        let solver = match method {
            Method::ActiveSet => Solver::ActiveSet(ActiveSet::new(n_points)),
            Method::Broyden(settings) => {
                let basis =
                    |m: &Mat<f64>| (m.nrows() > 0).then(|| ModalBasis::from_compliance(m)).transpose();
                let bases = [basis(&own)?, basis(&surface.compliance)?];
                let stiffness: Vec<f64> =
                    bases.iter().flatten().flat_map(|b| b.stiffness.iter().copied()).collect();
                let n = stiffness.len();
                Solver::Broyden(Box::new(Modal {
                    solver: Broyden::new(settings, n_points, n),
                    bases,
                    stiffness,
                    normal_shapes: Mat::zeros(n_points, n),
                }))
            }
        };
        let rows = Rows::new(n_points, surface.n_functions);
        Ok(Self {
            n_components,
            normal_compliance: Mat::zeros(n_points, n_points),
            half: vec![0.0; surface.n_interface()],
            own_half: vec![0.0; own.nrows()],
            own,
            saved_rows: rows.clone(),
            rows,
            members: vec![false; n_points],
            saved_members: vec![false; n_points],
            solver,
        })
    }

    pub fn normal_compliance(&self) -> &Mat<f64> {
        &self.normal_compliance
    }

    pub fn needs_springs(&self) -> bool {
        matches!(self.solver, Solver::Broyden(_))
    }

    /// How far the points chosen by `is_chosen` have moved since the projection in use; infinite if it has not all of them.
    pub fn moved(&self, rows: &Rows, surface: &TargetSurface, is_chosen: impl Fn(usize) -> bool) -> f64 {
        if (0..self.members.len()).any(|i| is_chosen(i) && !self.members[i]) {
            return f64::INFINITY;
        }
        rows.moved(&self.rows, surface, is_chosen)
    }

    /// Projects the compliances on `rows` for the points chosen by `is_member` (Eq. C.39). The others are taken to move by
    /// no force and to bear none.
    pub fn build(&mut self, surface: &TargetSurface, rows: &Rows, is_member: impl Fn(usize) -> bool) {
        self.rows.copy_from(rows);
        let is_modal = self.needs_springs();
        self.members.iter_mut().enumerate().for_each(|(i, m)| *m = is_modal || is_member(i));
        self.project(surface);
    }

    fn project(&mut self, surface: &TargetSurface) {
        let (n, nc) = (self.members.len(), self.n_components);
        let Self { own, own_half, half, rows, members, normal_compliance, .. } = self;
        normal_compliance.fill(0.0);
        for j in (0..n).filter(|j| members[*j]) {
            own_half.fill(0.0);
            if own.nrows() > 0 {
                let normal = rows.own_normals[j];
                add_columns(own, (0..nc).map(|c| (nc * j + c, normal[c])), own_half);
            }
            half.fill(0.0);
            if !half.is_empty() {
                add_columns(&surface.compliance, rows.entries(surface, j), half);
            }
            for i in (0..=j).filter(|i| members[*i]) {
                let mut entry = 0.0;
                if !own_half.is_empty() {
                    entry += dot(&own_half[nc * i..nc * (i + 1)], &rows.own_normals[i]);
                }
                if !half.is_empty() {
                    entry += rows.entries(surface, i).map(|(b, value)| value * half[b]).sum::<f64>();
                }
                normal_compliance[(i, j)] = entry;
                normal_compliance[(j, i)] = entry;
            }
        }
        match &mut self.solver {
            Solver::ActiveSet(solver) => solver.invalidate(),
            Solver::Broyden(modal) => modal.project(surface, &self.rows, nc),
        }
    }

    /// Solves for `forces` at gaps `gaps` of the undeformed zone.
    pub fn solve(
        &mut self,
        springs: &[f64],
        gaps: &[f64],
        forces: &mut [f64],
    ) -> Result<SolveReport, Rejection> {
        match &mut self.solver {
            Solver::ActiveSet(solver) => {
                solver.solve(&Problem { compliance: &self.normal_compliance, springs, gaps }, forces)
            }
            Solver::Broyden(modal) => {
                let Modal { solver, stiffness, normal_shapes, .. } = modal.as_mut();
                solver.solve(&ModalProblem { shapes: normal_shapes, stiffness, springs, gaps }, forces)
            }
        }
    }

    /// Replaces `out` by `A forces`.
    pub fn settle(&self, forces: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        add_product(&self.normal_compliance, forces, out);
    }

    /// Displacements of the contact body's points under their loads, components of each point in turn.
    pub fn own_displacements(&self, loads: &[f64], out: &mut [f64]) {
        if self.own.nrows() > 0 {
            out.fill(0.0);
            add_product(&self.own, loads, out);
        }
    }

    /// To be called when the springs have changed.
    pub fn springs_changed(&mut self) {
        if let Solver::ActiveSet(solver) = &mut self.solver {
            solver.invalidate();
        }
    }

    pub fn save(&mut self) {
        self.saved_rows.copy_from(&self.rows);
        self.saved_members.copy_from_slice(&self.members);
        match &mut self.solver {
            Solver::ActiveSet(solver) => solver.save(),
            Solver::Broyden(modal) => modal.solver.save(),
        }
    }

    /// Returns to what was saved; the projection is a function of its rows and is made again only if these differ.
    pub fn restore(&mut self, surface: &TargetSurface) {
        let is_same = self.members == self.saved_members
            && self.rows.elements == self.saved_rows.elements
            && same_bits(self.rows.values.iter(), self.saved_rows.values.iter())
            && same_bits(self.rows.normals.iter().flatten(), self.saved_rows.normals.iter().flatten())
            && same_bits(
                self.rows.own_normals.iter().flatten(),
                self.saved_rows.own_normals.iter().flatten(),
            );
        if !is_same {
            self.rows.copy_from(&self.saved_rows);
            self.members.copy_from_slice(&self.saved_members);
            self.project(surface);
        }
        match &mut self.solver {
            Solver::ActiveSet(solver) => solver.restore(),
            Solver::Broyden(modal) => modal.solver.restore(),
        }
    }
}

impl Modal {
    /// Normal displacements of the points relative to the target, one column a mode.
    fn project(&mut self, surface: &TargetSurface, rows: &Rows, nc: usize) {
        let mut column = 0;
        let n = rows.normals.len();
        if let Some(basis) = &self.bases[0] {
            for k in 0..basis.n_coordinates() {
                let source = basis.shapes.col_as_slice(k);
                for i in 0..n {
                    self.normal_shapes[(i, column)] =
                        dot(&source[nc * i..nc * (i + 1)], &rows.own_normals[i]);
                }
                column += 1;
            }
        }
        if let Some(basis) = &self.bases[1] {
            for k in 0..basis.n_coordinates() {
                let source = basis.shapes.col_as_slice(k);
                for i in 0..n {
                    let sum: f64 = rows.entries(surface, i).map(|(b, value)| value * source[b]).sum();
                    self.normal_shapes[(i, column)] = -sum;
                }
                column += 1;
            }
        }
    }
}

fn same_bits<'a>(a: impl Iterator<Item = &'a f64>, b: impl Iterator<Item = &'a f64>) -> bool {
    a.zip(b).all(|(x, y)| x.to_bits() == y.to_bits())
}

/// Scalar product over the shorter list.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
