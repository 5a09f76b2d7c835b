//! The quasistatic problem of two bodies: common normal compliance, solver, displacements.

use faer::Mat;
use ffr_dynamics::error::Rejection;

use super::projection::SurfacePlace;
use super::target::TargetSurface;
use crate::ContactError;
use crate::quasistatic::active_set::{ActiveSet, SolveReport};
use crate::quasistatic::broyden::{Broyden, ModalProblem};
use crate::quasistatic::problem::add_product;
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

    /// Calls `put` with interface freedom and value of every entry of row `i` of `N_T`.
    fn for_each(&self, surface: &TargetSurface, i: usize, mut put: impl FnMut(usize, f64)) {
        let nc = surface.motion.n_components();
        let nodes = &surface.elements[self.elements[i] as usize].nodes;
        for (&node, &value) in nodes.iter().zip(&self.values[i * self.width..]) {
            for c in 0..nc {
                if let Some(b) = surface.freedoms[nc * node as usize + c] {
                    put(b as usize, value * self.normals[i][c]);
                }
            }
        }
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
    half: Vec<f64>,
    /// Rows that `A` was built on.
    rows: Rows,
    is_built: bool,
    saved_rows: Rows,
    is_saved_built: bool,
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
            own,
            n_components,
            normal_compliance: Mat::zeros(n_points, n_points),
            half: vec![0.0; surface.n_interface()],
            saved_rows: rows.clone(),
            rows,
            is_built: false,
            is_saved_built: false,
            solver,
        })
    }

    pub fn normal_compliance(&self) -> &Mat<f64> {
        &self.normal_compliance
    }

    pub fn needs_springs(&self) -> bool {
        matches!(self.solver, Solver::Broyden(_))
    }

    /// Rows of the projection in use, none before the first.
    pub fn built_on(&self) -> Option<&Rows> {
        self.is_built.then_some(&self.rows)
    }

    /// Projects the compliances on `rows` (Eq. C.39).
    pub fn build(&mut self, surface: &TargetSurface, rows: &Rows) {
        self.rows.copy_from(rows);
        self.is_built = true;
        self.project(surface);
    }

    fn project(&mut self, surface: &TargetSurface) {
        let (n, nc) = (self.rows.normals.len(), self.n_components);
        for j in 0..n {
            self.half.fill(0.0);
            let half = &mut self.half;
            self.rows.for_each(surface, j, |b, value| {
                half.iter_mut().zip(surface.compliance.col_as_slice(b)).for_each(|(h, g)| *h += value * g);
            });
            for i in 0..=j {
                let mut entry = 0.0;
                if self.own.nrows() > 0 {
                    for (c, &normal_c) in self.rows.own_normals[j][..nc].iter().enumerate() {
                        let source = &self.own.col_as_slice(nc * j + c)[nc * i..nc * (i + 1)];
                        entry += normal_c * dot(source, &self.rows.own_normals[i]);
                    }
                }
                if !self.half.is_empty() {
                    let half = &self.half;
                    self.rows.for_each(surface, i, |b, value| entry += value * half[b]);
                }
                self.normal_compliance[(i, j)] = entry;
                self.normal_compliance[(j, i)] = entry;
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
        self.is_saved_built = self.is_built;
        match &mut self.solver {
            Solver::ActiveSet(solver) => solver.save(),
            Solver::Broyden(modal) => modal.solver.save(),
        }
    }

    /// Returns to what was saved; the projection is a function of its rows and is made again only if these differ.
    pub fn restore(&mut self, surface: &TargetSurface) {
        let is_same = self.rows.elements == self.saved_rows.elements
            && same_bits(self.rows.values.iter(), self.saved_rows.values.iter())
            && same_bits(self.rows.normals.iter().flatten(), self.saved_rows.normals.iter().flatten())
            && same_bits(
                self.rows.own_normals.iter().flatten(),
                self.saved_rows.own_normals.iter().flatten(),
            );
        self.is_built = self.is_saved_built;
        if !is_same {
            self.rows.copy_from(&self.saved_rows);
            if self.is_built {
                self.project(surface);
            }
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
                    let mut sum = 0.0;
                    rows.for_each(surface, i, |b, value| sum -= value * source[b]);
                    self.normal_shapes[(i, column)] = sum;
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
