//! The quasistatic problem of two bodies: common normal compliance, solver, displacements.

use faer::Mat;
use ffr_dynamics::error::EvaluationFailure;

use super::rows::Rows;
use super::target::TargetSurface;
use crate::ContactError;
use crate::quasistatic::active_set::SolveReport;
use crate::quasistatic::point_solver::PointSolver;
use crate::quasistatic::problem::{add_columns, add_product, dot};
use crate::quasistatic::stick_slip::{NormalSolver, StickSlip};
use crate::quasistatic::{Method, ModalBasis};

/// Quasistatic compliance of a pair: that of the contact body's points; the target's is that of its surface.
pub(super) struct Compliances {
    /// Zero-sized if the contact body has none.
    own: Mat<f64>,
    n_components: usize,
    n_points: usize,
    method: Method,
    /// Modes of Algorithm 1 at the contact body's points and at the target's interface.
    bases: [Option<ModalBasis>; 2],
}

/// What both bodies of a pair yield by.
#[derive(Clone, Copy)]
pub(super) struct Both<'a> {
    pub compliances: &'a Compliances,
    pub surface: &'a TargetSurface,
}

/// Both bodies' compliances, projected on the rows of one instant, and the solver's state.
pub(super) struct PairZone {
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
    solver: PointSolver,
}

impl Compliances {
    pub fn new(
        method: Method,
        n_components: usize,
        own: Mat<f64>,
        n_points: usize,
        surface: &TargetSurface,
    ) -> Result<Self, ContactError> {
        let bases = match method {
            Method::ActiveSet => [None, None],
            Method::Broyden(_) => {
                let basis =
                    |m: &Mat<f64>| (m.nrows() > 0).then(|| ModalBasis::from_compliance(m)).transpose();
                [basis(&own)?, basis(&surface.compliance)?]
            }
        };
        Ok(Self { own, n_components, n_points, method, bases })
    }

    pub fn needs_springs(&self) -> bool {
        matches!(self.method, Method::Broyden(_))
    }

    /// A solver without a projection yet, with `n_t` tangents a point.
    pub fn solver(&self, surface: &TargetSurface, n_t: usize) -> PairZone {
        let n_points = self.n_points;
        let solver = match self.method {
            Method::ActiveSet => PointSolver::active_set(n_points),
            Method::Broyden(settings) => {
                let bases = self.bases.iter().flatten();
                let stiffness = bases.flat_map(|b| b.stiffness.iter().copied()).collect();
                PointSolver::broyden(settings, n_points, stiffness)
            }
        };
        let rows = Rows::new(n_points, surface.n_functions, n_t);
        PairZone {
            normal_compliance: Mat::zeros(n_points, n_points),
            half: vec![0.0; surface.n_interface()],
            own_half: vec![0.0; self.own.nrows()],
            saved_rows: rows.clone(),
            rows,
            members: vec![false; n_points],
            saved_members: vec![false; n_points],
            solver,
        }
    }

    /// Displacements of the contact body's points under their loads, components of each point in turn.
    pub fn own_displacements(&self, loads: &[f64], out: &mut [f64]) {
        if self.own.nrows() > 0 {
            out.fill(0.0);
            add_product(&self.own, loads, out);
        }
    }
}

impl PairZone {
    pub fn normal_compliance(&self) -> &Mat<f64> {
        &self.normal_compliance
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
        bodies: Both<'_>,
        rows: &Rows,
        friction: Option<&mut StickSlip>,
        is_member: impl Fn(usize) -> bool,
    ) {
        self.rows.copy_from(rows);
        let is_modal = self.solver.needs_springs();
        self.members.iter_mut().enumerate().for_each(|(i, m)| *m = is_modal || is_member(i));
        self.project(bodies, friction);
    }

    fn project(&mut self, bodies: Both<'_>, mut friction: Option<&mut StickSlip>) {
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
                self.load(bodies, j, d);
                for i in (0..=j).filter(|i| self.members[*i]) {
                    for e in 0..n_directions {
                        let entry = self.answer(bodies, i, e);
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
        self.project_modes(bodies);
    }

    /// Normal displacements of the points relative to the target in the modes of Algorithm 1, one column a mode.
    fn project_modes(&mut self, Both { compliances, surface }: Both<'_>) {
        let Some(normal_shapes) = self.solver.normal_shapes() else { return };
        let (rows, nc) = (&self.rows, compliances.n_components);
        let mut column = 0;
        let n = rows.normals.len();
        if let Some(basis) = &compliances.bases[0] {
            for k in 0..basis.n_coordinates() {
                let source = basis.shapes.col_as_slice(k);
                for i in 0..n {
                    normal_shapes[(i, column)] = dot(&source[nc * i..nc * (i + 1)], &rows.own_normals[i]);
                }
                column += 1;
            }
        }
        if let Some(basis) = &compliances.bases[1] {
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
    fn load(&mut self, Both { compliances, surface }: Both<'_>, j: usize, d: usize) {
        let nc = compliances.n_components;
        self.own_half.fill(0.0);
        if compliances.own.nrows() > 0 {
            let direction = self.rows.own_direction(j, d);
            add_columns(&compliances.own, (0..nc).map(|c| (nc * j + c, direction[c])), &mut self.own_half);
        }
        self.half.fill(0.0);
        if !self.half.is_empty() {
            add_columns(&surface.compliance, self.rows.entries(surface, j, d), &mut self.half);
        }
    }

    /// Displacement of point `i` relative to the target in direction `e` under that load.
    fn answer(&self, Both { compliances, surface }: Both<'_>, i: usize, e: usize) -> f64 {
        let nc = compliances.n_components;
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
    pub fn restore(&mut self, bodies: Both<'_>, friction: Option<&mut StickSlip>) {
        let is_same = self.members == self.saved_members && self.rows.is_same(&self.saved_rows);
        if !is_same {
            self.rows.copy_from(&self.saved_rows);
            self.members.copy_from_slice(&self.saved_members);
            self.project(bodies, friction);
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
