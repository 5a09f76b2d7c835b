//! The quasistatic problem of two bodies: common normal compliance, solver, displacements.

use faer::Mat;
use ffr_dynamics::error::EvaluationFailure;

use super::contact_jacobian::ContactJacobian;
use super::target::TargetSurface;
use crate::ContactError;
use crate::quasistatic::Method;
use crate::quasistatic::active_set::SolveReport;
use crate::quasistatic::compliance::sparse_rows::SparseRows;
use crate::quasistatic::compliance::{Surfaces, Yielding, ZoneCompliance};
use crate::quasistatic::members::Members;
use crate::quasistatic::modal_basis::ModalBasis;
use crate::quasistatic::point_solver::PointSolver;
use crate::quasistatic::problem::{Problem, add_columns, add_product, dot};
use crate::quasistatic::stick_slip::{NormalSolver, StickSlip};

/// Quasistatic compliance of a pair: that of the contact body's points; the target's is that of its
/// surface.
pub(super) struct Compliances {
    /// Of no size if the contact body has none.
    body: Yielding,
    n_components: usize,
    n_points: usize,
    method: Method,
    /// Modes of Algorithm 1 at the contact body's points and at the target's interface.
    bases: [Option<ModalBasis>; 2],
}

/// The compliances of both bodies of a pair, and the surface of the target.
#[derive(Clone, Copy)]
pub(super) struct PairBodies<'a> {
    pub compliances: &'a Compliances,
    pub surface: &'a TargetSurface,
}

/// The surfaces of both bodies under the points: the unknowns of the contact body, then those of the target.
pub(super) struct PairSurfaces<'a> {
    bodies: PairBodies<'a>,
    jacobian: &'a ContactJacobian,
}

impl Surfaces for PairSurfaces<'_> {
    fn n_unknowns(&self) -> usize {
        self.bodies.compliances.body.matrix().nrows() + self.bodies.surface.n_interface()
    }

    fn row(&self, i: usize, d: usize, entry: &mut dyn FnMut(usize, f64)) {
        let PairBodies { compliances: Compliances { body, n_components: nc, .. }, surface } = self.bodies;
        let direction = self.jacobian.direction_in_body(i, d);
        (0..*nc).for_each(|c| body.row(nc * i + c, direction[c], entry));
        if surface.is_quasistatic() {
            let n_body = body.matrix().nrows();
            self.jacobian.entries(surface, i, d).for_each(|(b, value)| entry(n_body + b, -value));
        }
    }

    fn compliance(&self, i: usize, j: usize) -> f64 {
        let (body, target) = (self.bodies.compliances.body.matrix(), &self.bodies.surface.compliance);
        let n_body = body.nrows();
        match (i < n_body, j < n_body) {
            (true, true) => body[(i, j)],
            (false, false) => target[(i - n_body, j - n_body)],
            _ => 0.0,
        }
    }
}

/// Both bodies' compliances, projected on the rows of one instant, and the solver's state.
pub(super) struct PairZone {
    /// Normal compliance `A` of the points on `rows`.
    normal_compliance: Mat<f64>,
    /// Displacements of the target's interface under one point's load, those of the contact body's
    /// points or interface, and a buffer.
    target_half: Vec<f64>,
    body_half: [Vec<f64>; 2],
    /// Rows that `A` was built on, and the points it was built for, in the order in which they came, of their gaps where they came
    /// together: the others have zero rows and columns.
    jacobian: ContactJacobian,
    members: Members,
    /// How many of them `A`, and the projections on tangents with it, hold.
    n_projected: usize,
    saved_jacobian: ContactJacobian,
    saved_members: Vec<usize>,
    solver: PointSolver,
}

impl Compliances {
    pub fn new(
        method: Method,
        n_components: usize,
        (compliance, functions): (ZoneCompliance, &SparseRows),
        n_points: usize,
        surface: &TargetSurface,
    ) -> Result<Self, ContactError> {
        // Algorithm 1 works with the modes of the points.
        let body = Yielding::new(compliance, functions, matches!(method, Method::Broyden(_)));
        let bases = match method {
            Method::ActiveSet => [None, None],
            Method::Broyden(_) => {
                let basis =
                    |m: &Mat<f64>| (m.nrows() > 0).then(|| ModalBasis::from_compliance(m)).transpose();
                [basis(body.matrix())?, basis(&surface.compliance)?]
            }
        };
        Ok(Self { body, n_components, n_points, method, bases })
    }

    pub fn needs_springs(&self) -> bool {
        matches!(self.method, Method::Broyden(_))
    }

    /// A solver without a projection yet, with `n_t` tangents per point.
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
        let jacobian = ContactJacobian::new(n_points, surface.n_functions, n_t);
        PairZone {
            normal_compliance: Mat::zeros(n_points, n_points),
            target_half: vec![0.0; surface.n_interface()],
            body_half: [(); 2].map(|()| vec![0.0; self.body.matrix().nrows()]),
            saved_jacobian: jacobian.clone(),
            jacobian,
            members: Members::new(n_points),
            saved_members: Vec::with_capacity(n_points),
            n_projected: 0,
            solver,
        }
    }
}

impl PairZone {
    pub fn normal_compliance(&self) -> &Mat<f64> {
        &self.normal_compliance
    }

    /// How far those of the points taken that `is_chosen` marks have moved since then.
    pub fn moved(
        &self,
        jacobian: &ContactJacobian,
        surface: &TargetSurface,
        is_chosen: impl Fn(usize) -> bool,
    ) -> f64 {
        jacobian.moved(&self.jacobian, surface, |i| self.members.contains(i) && is_chosen(i))
    }

    /// Whether one of the points that `is_chosen` marks has not been taken.
    pub fn lacks(&self, is_chosen: impl Fn(usize) -> bool) -> bool {
        (0..self.jacobian.normals_in_target.len()).any(|i| !self.members.contains(i) && is_chosen(i))
    }

    /// Takes the rows `jacobian` of the points chosen by `is_member` to project the compliances on (Eq. C.40), anew or, if not
    /// `is_new`, those of further points. The others are taken to move by no force and to bear none. Products are short where points
    /// with small `gap` are pressed.
    pub fn take(
        &mut self,
        (jacobian, is_new): (&ContactJacobian, bool),
        is_member: impl Fn(usize) -> bool,
        gap: impl Fn(usize) -> f64,
    ) {
        if is_new {
            self.members.clear();
            self.n_projected = 0;
        }
        let (is_modal, first) = (self.solver.needs_springs(), self.members.list().len());
        for i in 0..self.jacobian.normals_in_target.len() {
            if !self.members.contains(i) && (is_modal || is_member(i)) {
                self.members.add(i);
                self.jacobian.copy_point(i, jacobian);
            }
        }
        self.members.sort_from(first, |a, b| gap(*a).total_cmp(&gap(*b)).then(a.cmp(b)));
    }

    /// The points taken, and both surfaces under them.
    pub fn surfaces<'a>(&'a self, bodies: PairBodies<'a>) -> (PairSurfaces<'a>, &'a Members) {
        (PairSurfaces { bodies, jacobian: &self.jacobian }, &self.members)
    }

    /// Projects the compliances on the rows taken, on tangents for `friction`, unless they are.
    pub fn project(&mut self, bodies: PairBodies<'_>, mut friction: Option<&mut StickSlip>) {
        if self.n_projected == self.members.list().len() {
            return;
        }
        if self.n_projected == 0 {
            self.normal_compliance.fill(0.0);
            if let Some(friction) = &mut friction {
                friction.blocks.members.clear();
            }
        }
        let n_directions = 1 + if friction.is_some() { self.jacobian.n_t } else { 0 };
        for place in self.n_projected..self.members.list().len() {
            let j = self.members.list()[place];
            if let Some(friction) = &mut friction {
                friction.blocks.members.add(j);
            }
            for d in 0..n_directions {
                self.load(bodies, j, d);
                for &i in &self.members.list()[..=place] {
                    for e in 0..n_directions {
                        let entry = self.answer(bodies, i, e);
                        match (&mut friction, e, d) {
                            (_, 0, 0) => {
                                self.normal_compliance[(i, j)] = entry;
                                self.normal_compliance[(j, i)] = entry;
                            }
                            (Some(friction), 0, _) => friction.blocks.set_coupling(j, d - 1, i, entry),
                            (Some(friction), _, 0) => friction.blocks.set_coupling(i, e - 1, j, entry),
                            (Some(friction), _, _) => {
                                friction.blocks.set_tangential((i, e - 1), (j, d - 1), entry);
                            }
                            (None, _, _) => {}
                        }
                    }
                }
            }
        }
        if let Some(friction) = friction {
            friction.finish_blocks();
        }
        self.n_projected = self.members.list().len();
        self.solver.invalidate();
        self.project_modes(bodies);
    }

    /// Normal displacements of the points relative to the target in the modes of Algorithm 1, one
    /// column per mode.
    fn project_modes(&mut self, PairBodies { compliances, surface }: PairBodies<'_>) {
        let Some(normal_shapes) = self.solver.normal_shapes() else { return };
        let (jacobian, nc) = (&self.jacobian, compliances.n_components);
        let mut column = 0;
        let n = jacobian.normals_in_target.len();
        if let Some(basis) = &compliances.bases[0] {
            for k in 0..basis.n_coordinates() {
                let source = basis.shapes.col_as_slice(k);
                for i in 0..n {
                    normal_shapes[(i, column)] =
                        dot(&source[nc * i..nc * (i + 1)], &jacobian.normals_in_body[i]);
                }
                column += 1;
            }
        }
        if let Some(basis) = &compliances.bases[1] {
            for k in 0..basis.n_coordinates() {
                let source = basis.shapes.col_as_slice(k);
                for i in 0..n {
                    let sum: f64 = jacobian.entries(surface, i, 0).map(|(b, value)| value * source[b]).sum();
                    normal_shapes[(i, column)] = -sum;
                }
                column += 1;
            }
        }
    }

    /// Displacements of both bodies under a unit load of point `j` in direction `d` (0: normal).
    fn load(&mut self, PairBodies { compliances, surface }: PairBodies<'_>, j: usize, d: usize) {
        let nc = compliances.n_components;
        let direction = self.jacobian.direction_in_body(j, d);
        compliances.body.load((0..nc).map(|c| (nc * j + c, direction[c])), &mut self.body_half[0]);
        self.target_half.fill(0.0);
        if !self.target_half.is_empty() {
            add_columns(&surface.compliance, self.jacobian.entries(surface, j, d), &mut self.target_half);
        }
    }

    /// Displacement of point `i` relative to the target in direction `e` under that load.
    fn answer(&self, PairBodies { compliances, surface }: PairBodies<'_>, i: usize, e: usize) -> f64 {
        let nc = compliances.n_components;
        let mut sum = 0.0;
        if !self.body_half[0].is_empty() {
            let direction = self.jacobian.direction_in_body(i, e);
            let along =
                |c: usize| direction[c] * compliances.body.displacement(nc * i + c, &self.body_half[0]);
            sum += (0..nc).map(along).sum::<f64>();
        }
        if !self.target_half.is_empty() {
            sum += self
                .jacobian
                .entries(surface, i, e)
                .map(|(b, value)| value * self.target_half[b])
                .sum::<f64>();
        }
        sum
    }

    /// Displacements of the contact body's points under their loads, components of each point in
    /// turn.
    pub fn displace_body(&mut self, compliances: &Compliances, loads: &[f64], out: &mut [f64]) {
        if !self.body_half[0].is_empty() {
            compliances.body.displacements(loads, &mut self.body_half, out);
        }
    }

    /// Replaces `out` by `A forces`.
    pub fn deflect(&self, forces: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        add_product(&self.normal_compliance, forces, out);
    }

    /// The same for the forces that the last solution has found with springs of compliance `springs` at gaps `gaps`.
    pub fn deflect_solved(&self, springs: &[f64], gaps: &[f64], forces: &[f64], out: &mut [f64]) {
        let problem = Problem { compliance: &self.normal_compliance, springs, gaps };
        self.solver.displacements(&problem, forces, out);
    }

    /// To be called when the springs have changed.
    pub fn springs_changed(&mut self) {
        self.solver.invalidate();
    }

    pub fn save(&mut self) {
        self.saved_jacobian.copy_from(&self.jacobian);
        self.saved_members.clear();
        self.saved_members.extend_from_slice(self.members.list());
        self.solver.save();
    }

    /// Returns to what was saved; the projection is a function of its rows and is made again only
    /// if these differ.
    pub fn restore(&mut self) {
        let is_same =
            self.members.list() == self.saved_members && self.jacobian.is_same(&self.saved_jacobian);
        if !is_same {
            self.jacobian.copy_from(&self.saved_jacobian);
            self.members.set(self.saved_members.iter().copied());
            self.n_projected = 0;
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
    fn solve_on_set(&mut self, rhs: &mut [f64]) -> bool {
        self.solver.solve_on_set(rhs)
    }
}
