//! The quasistatic problem of two bodies: common normal compliance, solver, displacements.

use faer::Mat;
use ffr_dynamics::error::EvaluationFailure;

use super::rows::Rows;
use super::target::TargetSurface;
use crate::ContactError;
use crate::quasistatic::active_set::SolveReport;
use crate::quasistatic::point_solver::PointSolver;
use crate::quasistatic::problem::{add_columns, add_product};
use crate::quasistatic::stick_slip::{NormalSolver, StickSlip};
use crate::quasistatic::{Method, ModalBasis};

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
    /// Modes of Algorithm 1 at the contact body's points and at the target's interface.
    bases: [Option<ModalBasis>; 2],
    solver: PointSolver,
}

impl PairZone {
    pub fn new(
        method: Method,
        n_components: usize,
        own: Mat<f64>,
        n_points: usize,
        surface: &TargetSurface,
    ) -> Result<Self, ContactError> {
        let (bases, solver) = match method {
            Method::ActiveSet => ([None, None], PointSolver::active_set(n_points)),
            Method::Broyden(settings) => {
                let basis =
                    |m: &Mat<f64>| (m.nrows() > 0).then(|| ModalBasis::from_compliance(m)).transpose();
                let bases = [basis(&own)?, basis(&surface.compliance)?];
                let stiffness = bases.iter().flatten().flat_map(|b| b.stiffness.iter().copied()).collect();
                (bases, PointSolver::broyden(settings, n_points, stiffness))
            }
        };
        let rows = Rows::new(n_points, surface.n_functions, 0);
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
            bases,
            solver,
        })
    }

    /// Makes room for `n_t` tangents a point.
    pub fn add_tangents(&mut self, n_t: usize) {
        let (n, width) = (self.members.len(), self.rows.width);
        self.rows = Rows::new(n, width, n_t);
        self.saved_rows = self.rows.clone();
        self.members.fill(false);
        self.saved_members.fill(false);
    }

    pub fn normal_compliance(&self) -> &Mat<f64> {
        &self.normal_compliance
    }

    pub fn needs_springs(&self) -> bool {
        self.solver.needs_springs()
    }

    /// How far the points chosen by `is_chosen` have moved since the projection in use; infinite if it has not all of them.
    pub fn moved(&self, rows: &Rows, surface: &TargetSurface, is_chosen: impl Fn(usize) -> bool) -> f64 {
        if (0..self.members.len()).any(|i| is_chosen(i) && !self.members[i]) {
            return f64::INFINITY;
        }
        rows.moved(&self.rows, surface, is_chosen)
    }

    /// Projects the compliances on `rows` for the points chosen by `is_member` (Eq. C.39), on tangents for `friction`. The others
    /// are taken to move by no force and to bear none.
    pub fn build(
        &mut self,
        surface: &TargetSurface,
        rows: &Rows,
        friction: Option<&mut StickSlip>,
        is_member: impl Fn(usize) -> bool,
    ) {
        self.rows.copy_from(rows);
        let is_modal = self.needs_springs();
        self.members.iter_mut().enumerate().for_each(|(i, m)| *m = is_modal || is_member(i));
        self.project(surface, friction);
    }

    fn project(&mut self, surface: &TargetSurface, mut friction: Option<&mut StickSlip>) {
        self.normal_compliance.fill(0.0);
        if let Some(friction) = &mut friction {
            friction.clear_blocks();
        }
        let n_directions = 1 + if friction.is_some() { self.rows.n_t } else { 0 };
        for j in 0..self.members.len() {
            if !self.members[j] {
                continue;
            }
            for d in 0..n_directions {
                self.load(surface, j, d);
                for i in (0..=j).filter(|i| self.members[*i]) {
                    for e in 0..n_directions {
                        let entry = self.answer(surface, i, e);
                        match (&mut friction, e, d) {
                            (_, 0, 0) => {
                                self.normal_compliance[(i, j)] = entry;
                                self.normal_compliance[(j, i)] = entry;
                            }
                            (Some(friction), 0, _) => friction.set_coupling(j, d - 1, i, entry),
                            (Some(friction), _, 0) => friction.set_coupling(i, e - 1, j, entry),
                            (Some(friction), _, _) => friction.set_tangential((i, e - 1), (j, d - 1), entry),
                            (None, _, _) => {}
                        }
                    }
                }
            }
        }
        if let Some(friction) = friction {
            friction.finish_blocks();
        }
        self.solver.invalidate();
        self.project_modes(surface);
    }

    /// Normal displacements of the points relative to the target in the modes of Algorithm 1, one column a mode.
    fn project_modes(&mut self, surface: &TargetSurface) {
        let Some(normal_shapes) = self.solver.normal_shapes() else { return };
        let (rows, nc) = (&self.rows, self.n_components);
        let mut column = 0;
        let n = rows.normals.len();
        if let Some(basis) = &self.bases[0] {
            for k in 0..basis.n_coordinates() {
                let source = basis.shapes.col_as_slice(k);
                for i in 0..n {
                    normal_shapes[(i, column)] = dot(&source[nc * i..nc * (i + 1)], &rows.own_normals[i]);
                }
                column += 1;
            }
        }
        if let Some(basis) = &self.bases[1] {
            for k in 0..basis.n_coordinates() {
                let source = basis.shapes.col_as_slice(k);
                for i in 0..n {
                    let sum: f64 = rows.entries(surface, i, 0).map(|(b, value)| value * source[b]).sum();
                    normal_shapes[(i, column)] = -sum;
                }
                column += 1;
            }
        }
    }

    /// Displacements of both bodies under a unit load of point `j` in direction `d` (0: normal).
    fn load(&mut self, surface: &TargetSurface, j: usize, d: usize) {
        let nc = self.n_components;
        self.own_half.fill(0.0);
        if self.own.nrows() > 0 {
            let direction = self.rows.own_direction(j, d);
            add_columns(&self.own, (0..nc).map(|c| (nc * j + c, direction[c])), &mut self.own_half);
        }
        self.half.fill(0.0);
        if !self.half.is_empty() {
            add_columns(&surface.compliance, self.rows.entries(surface, j, d), &mut self.half);
        }
    }

    /// Displacement of point `i` relative to the target in direction `e` under that load.
    fn answer(&self, surface: &TargetSurface, i: usize, e: usize) -> f64 {
        let nc = self.n_components;
        let mut sum = 0.0;
        if !self.own_half.is_empty() {
            sum += dot(&self.own_half[nc * i..nc * (i + 1)], &self.rows.own_direction(i, e));
        }
        if !self.half.is_empty() {
            sum += self.rows.entries(surface, i, e).map(|(b, value)| value * self.half[b]).sum::<f64>();
        }
        sum
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
        self.solver.invalidate();
    }

    pub fn save(&mut self) {
        self.saved_rows.copy_from(&self.rows);
        self.saved_members.copy_from_slice(&self.members);
        self.solver.save();
    }

    /// Returns to what was saved; the projection is a function of its rows and is made again only if these differ.
    pub fn restore(&mut self, surface: &TargetSurface, friction: Option<&mut StickSlip>) {
        let is_same = self.members == self.saved_members && self.rows.is_same(&self.saved_rows);
        if !is_same {
            self.rows.copy_from(&self.saved_rows);
            self.members.copy_from_slice(&self.saved_members);
            self.project(surface, friction);
        }
        self.solver.restore();
    }
}

impl NormalSolver for PairZone {
    fn solve_normal(
        &mut self,
        springs: &[f64],
        gaps: &[f64],
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        self.solver.solve(&self.normal_compliance, springs, gaps, forces)
    }
}

/// Scalar product over the shorter list.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
