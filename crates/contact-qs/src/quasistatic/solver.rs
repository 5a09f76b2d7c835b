//! One body's quasistatic contact zone, and its solver, chosen by settings, on the contact normal.

use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::check_square;
use ffr_dynamics::error::EvaluationFailure;

use super::active_set::SolveReport;
use super::point_solver::{Method, PointSolver};
use super::problem::{add_columns, add_multiples, add_product};
use crate::ContactError;
use crate::quasistatic::broyden::BroydenSettings;
use crate::quasistatic::modal_basis::ModalBasis;

/// Compliance of a contact zone, with its modes where Algorithm 1 shall solve it.
///
/// Rows and columns of the compliance are ordered `n_components * point + component`.
pub struct Quasistatic {
    n_components: usize,
    compliance: Mat<f64>,
    /// Algorithm 1 and the modes it works with, rows of the shapes as those of the compliance.
    algorithm_1: Option<(BroydenSettings, ModalBasis)>,
}

/// Solver of a zone: the compliance projected on the contact normal, and what the solver starts
/// from.
pub struct ZoneSolver {
    /// Normal in the model's components that the projections belong to; zero before the first one.
    normal: [f64; 3],
    saved_normal: [f64; 3],
    /// Points whose columns are projected.
    is_projected: Vec<bool>,
    normal_compliance: Mat<f64>,
    /// Displacements of all points under a unit force along the normal at one, column by column; those
    /// of points that are never pressed take no memory.
    under_force: Vec<f64>,
    solver: PointSolver,
}

/// Change of a component of the unit normal up to which a projection is used again. The gaps err by
/// this share of what the zone yields then, as those of pairs may; a body that falls flat turns by
/// less in a step, one that rolls by more.
const SAME_NORMAL: f64 = 1e-8;

/// Whether a projection on the unit vectors `before` may be used for `now`. Asked this way round, a
/// NaN has changed.
pub(super) fn is_same(now: &[[f64; 3]], before: &[[f64; 3]]) -> bool {
    let pairs = now.as_flattened().iter().zip(before.as_flattened());
    pairs.into_iter().all(|(a, b)| (a - b).abs() <= SAME_NORMAL)
}

impl Quasistatic {
    /// Zone with compliance `N_b G N_bᵀ` (docs/theory.md Eq. C.2), `n_c n_p × n_c n_p` [m/N].
    ///
    /// # Errors
    /// [`ContactError::Data`] if its size is no multiple of the number of components or it is not finite; with
    /// [`Method::Broyden`] also where [`ModalBasis::from_compliance`] fails.
    pub fn new(method: Method, motion: RigidMotion, compliance: Mat<f64>) -> Result<Self, ContactError> {
        let (n_components, n_rows) = (motion.n_components(), compliance.nrows());
        let n_points = n_rows / n_components;
        check_square("the compliance of the contact points", compliance.as_ref(), n_points * n_components)?;
        let algorithm_1 = match method {
            Method::ActiveSet => None,
            Method::Broyden(settings) => Some((settings, basis_from_compliance(motion, &compliance)?)),
        };
        Ok(Self { n_components, compliance, algorithm_1 })
    }

    /// Number of points.
    pub fn n_points(&self) -> usize {
        self.compliance.nrows() / self.n_components
    }

    /// Compliance of all components, `n_components n_points` squared [m/N].
    pub fn compliance(&self) -> &Mat<f64> {
        &self.compliance
    }

    /// Whether the solver needs finite penalty factors.
    pub fn needs_springs(&self) -> bool {
        self.algorithm_1.is_some()
    }

    /// A solver of this zone, without a projection yet.
    pub fn solver(&self) -> ZoneSolver {
        let n_points = self.n_points();
        let solver = match &self.algorithm_1 {
            None => PointSolver::active_set(n_points),
            Some((settings, basis)) => PointSolver::broyden(*settings, n_points, basis.stiffness.clone()),
        };
        ZoneSolver {
            normal: [0.0; 3],
            saved_normal: [0.0; 3],
            is_projected: vec![false; n_points],
            normal_compliance: Mat::zeros(n_points, n_points),
            under_force: vec![0.0; self.compliance.nrows() * n_points],
            solver,
        }
    }

    /// Replaces `out` by the quasistatic displacements of the points, `n_components` rows per point
    /// \[m\], under `loads`, the components of the point forces in the same order \[N\].
    pub fn displacements(&self, loads: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        add_product(&self.compliance, loads, out);
    }
}

impl ZoneSolver {
    /// Normal compliance `A` of the last projection, `n_points × n_points` [m/N].
    pub fn normal_compliance(&self) -> &Mat<f64> {
        &self.normal_compliance
    }

    /// Replaces `rhs`, one value per point, by the solution of `(A_aa + D_aa) x_a = rhs_a` on the
    /// last active set, zero outside it; false if the solver is not the active-set solver.
    pub(crate) fn solve_on_set(&mut self, rhs: &mut [f64]) -> bool {
        let PointSolver::ActiveSet(solver) = &mut self.solver else { return false };
        solver.solve_on_set(rhs);
        true
    }

    /// Projects compliance or shapes of `zone`, for which the solver was made, on the unit normal
    /// `normal`, given in the model's components (Eq. C.2). Does nothing when the normal has changed
    /// by round-off alone.
    pub fn project(&mut self, zone: &Quasistatic, normal: [f64; 3]) {
        self.project_members(zone, normal, &[]);
    }

    /// Projects the compliance as [`Self::project`] does, but for the points alone that `is_member`
    /// marks, all if it is empty. Columns of other points are not valid afterwards, and these points
    /// must stay open. The factor of the solver outlives points that come to those of the same normal.
    pub(crate) fn project_members(&mut self, zone: &Quasistatic, normal: [f64; 3], is_member: &[bool]) {
        if !is_same(&[normal], &[self.normal]) {
            self.turn(zone, normal);
        }
        for j in 0..self.is_projected.len() {
            if self.is_projected[j] || !is_member.get(j).is_none_or(|is_member| *is_member) {
                continue;
            }
            self.is_projected[j] = true;
            let (nc, normal) = (zone.n_components, self.normal);
            let n_rows = zone.compliance.nrows();
            let column = &mut self.under_force[n_rows * j..n_rows * (j + 1)];
            column.fill(0.0);
            let components = (0..nc).filter(|c| normal[*c] != 0.0).map(|c| (nc * j + c, normal[c]));
            add_columns(&zone.compliance, components, column);
            let target = self.normal_compliance.col_as_slice_mut(j);
            for (entry, point) in target.iter_mut().zip(column.chunks_exact(nc)) {
                *entry = point.iter().zip(&normal).map(|(u, n)| u * n).sum();
            }
        }
    }

    /// Takes the normal in all its bits: nothing is projected on another one yet but the modes of
    /// Algorithm 1.
    fn turn(&mut self, zone: &Quasistatic, normal: [f64; 3]) {
        if self.normal.map(f64::to_bits) == normal.map(f64::to_bits) {
            return;
        }
        self.normal = normal;
        self.is_projected.fill(false);
        self.solver.invalidate();
        if let (Some((_, basis)), Some(normal_shapes)) = (&zone.algorithm_1, self.solver.normal_shapes()) {
            for k in 0..basis.shapes.ncols() {
                let source = basis.shapes.col_as_slice(k).chunks_exact(zone.n_components);
                for (t, point) in normal_shapes.col_as_slice_mut(k).iter_mut().zip(source) {
                    *t = point.iter().zip(&normal).map(|(a, n)| a * n).sum();
                }
            }
        }
    }

    /// Replaces `displacements` by those of the points under `forces` along the normal that is projected
    /// on, as [`Quasistatic::displacements`] has them, and `gaps` by `free_gaps` with them.
    pub(crate) fn displace(
        &self,
        forces: &[f64],
        free_gaps: &[f64],
        gaps: &mut [f64],
        displacements: &mut [f64],
    ) {
        displacements.fill(0.0);
        let columns = self.under_force.chunks_exact(displacements.len().max(1)).zip(forces);
        add_multiples(columns.map(|(c, force)| (c, *force)).filter(|(_, f)| *f != 0.0), displacements);
        let points = displacements.chunks_exact((displacements.len() / forces.len().max(1)).max(1));
        for ((gap, free), u) in gaps.iter_mut().zip(free_gaps).zip(points) {
            *gap = free + u.iter().zip(&self.normal).map(|(u, n)| u * n).sum::<f64>();
        }
    }

    /// Marks the points with which the next solution starts in `is_member`: they need a projection.
    pub(crate) fn add_start(&self, is_member: &mut [bool]) {
        if let PointSolver::ActiveSet(solver) = &self.solver {
            is_member.iter_mut().zip(solver.active()).for_each(|(is_member, active)| *is_member |= *active);
        }
    }

    /// Solves for the point forces `forces` \[N\] at gaps `gaps` \[m\] with penalty springs of
    /// compliance `springs` [m/N].
    ///
    /// # Errors
    /// [`EvaluationFailure`] of [`super::ActiveSet::solve`] and [`crate::quasistatic::broyden::Broyden::solve`].
    pub fn solve(
        &mut self,
        springs: &[f64],
        gaps: &[f64],
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        self.solver.solve(&self.normal_compliance, springs, gaps, forces)
    }

    /// To be called when the springs have changed.
    pub fn springs_changed(&mut self) {
        self.solver.invalidate();
    }

    /// Remembers what the solver starts from, and the normal that is projected on.
    pub fn save(&mut self) {
        self.saved_normal = self.normal;
        self.solver.save();
    }

    /// Returns to what was remembered; columns are functions of the normal and are projected again
    /// where they are needed.
    pub fn restore(&mut self, zone: &Quasistatic) {
        self.turn(zone, self.saved_normal);
        self.solver.restore();
    }
}

/// Modes of a compliance. The normal of an axisymmetric body is its axis, so that the axial block
/// is enough there and the Jacobian half as large.
fn basis_from_compliance(motion: RigidMotion, compliance: &Mat<f64>) -> Result<ModalBasis, ContactError> {
    if motion != RigidMotion::Axial {
        return ModalBasis::from_compliance(compliance);
    }
    let n_points = compliance.nrows() / 2;
    let axial = Mat::from_fn(n_points, n_points, |i, j| compliance[(2 * i + 1, 2 * j + 1)]);
    let basis = ModalBasis::from_compliance(&axial)?;
    let shapes = Mat::from_fn(2 * n_points, basis.n_coordinates(), |row, k| {
        if row % 2 == 1 { basis.shapes[(row / 2, k)] } else { 0.0 }
    });
    Ok(ModalBasis { shapes, stiffness: basis.stiffness })
}
