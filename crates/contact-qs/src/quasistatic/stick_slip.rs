//! Normal and tangential forces together: the two convex problems by alternation.
//!
//! Coulomb's law with the slip since the references were last updated is not the minimum of one
//! function, since the bounds `μ λ` depend on the normal forces. With given normal forces the
//! tangential ones minimise a convex function ([`super::tangential`]), and with given tangential
//! forces the normal ones do (docs/theory.md Eqs. F.4, F.5). The two are solved alternately, with
//! Aitken's relaxation, until the friction forces stand still. The alternations contract like `μ`
//! times the coupling `A_TN/A_NN`: some 0.1 for steel at `μ = 0.3`, none at all where `ν = 1/2`.
//! Rates of the forces follow the same way on the sets found ([`rates`]).

use crate::law::Friction;
use crate::solver_fault::SolverFault;
use ffr_dynamics::error::EvaluationFailure;

use super::active_set::SolveReport;
use super::problem::depth;
use super::solver::{Quasistatic, ZoneSolver, is_same};
use super::tangential::{Blocks, PointState, Tangential, TangentialProblem};

mod relaxation;
mod kept_factor;
pub(crate) mod rates;
mod surface_newton;

use crate::quasistatic::compliance::Surfaces;
use relaxation::Relaxation;
use surface_newton::{Law, SurfaceNewton};

/// Displacement by which normal and friction forces may miss each other, as a share of the deepest penetration: round-off.
pub(crate) const TOLERANCE: f64 = 1e-12;
/// Limit of the alternations: enough for a contraction of 0.75 without relaxation.
const MAX_ALTERNATIONS: usize = 100;

/// Tolerance of the slips, as a share of the tolerance of the alternations,
const INNER: f64 = 0.3;
/// and of the last change in them, if that is more: an alternation gains a digit, and slips two digits finer than it moves the gaps
/// are exact for it.
const GAIN: f64 = 0.01;

/// Solver of the normal problem (Eq. F.4).
pub(crate) trait NormalSolver {
    /// Solves for the normal point forces `forces` at gaps `gaps` with springs of compliance
    /// `springs`.
    fn solve_normal(
        &mut self,
        springs: &[f64],
        gaps: &[f64],
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure>;

    /// Replaces `rhs`, one value per point, by the solution of `(A_aa + D_aa) x_a = rhs_a` on the
    /// last active set, zero outside it; false if the solver is not the active-set solver.
    fn solve_on_set(&mut self, rhs: &mut [f64]) -> bool;
}

impl NormalSolver for ZoneSolver {
    fn solve_normal(
        &mut self,
        springs: &[f64],
        gaps: &[f64],
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        self.solve(springs, gaps, forces)
    }

    fn solve_on_set(&mut self, rhs: &mut [f64]) -> bool {
        self.solver.solve_on_set(rhs)
    }
}

/// Tangential half of a contact zone. Components are ordered `n_t * point + component`.
pub(crate) struct StickSlip {
    law: Friction,
    /// For each point, the size of the friction force per size of its components: the tangents in
    /// use need not be unit vectors (Eq. F.24).
    lengths: Vec<f64>,
    n_t: usize,
    n_points: usize,
    /// `A_TT` and `A_TN` of the points that they have been projected for.
    pub blocks: Blocks,
    /// Normal and tangents that the projections belong to; NaN before the first one.
    directions: [[f64; 3]; 3],
    saved_directions: [[f64; 3]; 3],
    springs: Vec<f64>,
    solver: Tangential,
    forces: Vec<f64>,
    saved_forces: Vec<f64>,
    bounds: Vec<f64>,
    shifted: Vec<f64>,
    /// Displacements along the normals under the tangential forces, and under those of the last alternation.
    shift: Vec<f64>,
    next_shift: Vec<f64>,
    offsets: Vec<f64>,
    next: Vec<f64>,
    /// Rates of the tangential forces, of the slip increments and of the normal forces on the sets of the last solution,
    /// and whether their matrix is that of it.
    rates: Vec<f64>,
    slip_rates: Vec<f64>,
    normal_rates: Vec<f64>,
    has_rates: bool,
    /// Of the alternations of a solution, and of those of rates.
    relaxation: [Relaxation; 2],
    /// Tangential forces that are given, not found.
    prescribed: Option<Vec<f64>>,
    /// Solver in the unknowns of the surfaces, made when it is first needed, and whether it has taken the points, and not failed since:
    /// then the last solution is its.
    newton: Option<Box<SurfaceNewton>>,
    is_taken: bool,
}

impl StickSlip {
    /// Zone of `n_points` points with `n_t` tangential components each;
    /// `has_compliance`: whether the zone is quasistatic.
    pub fn new(law: Friction, n_points: usize, n_t: usize, has_compliance: bool) -> Self {
        let n = n_t * n_points;
        Self {
            law,
            lengths: vec![1.0; n_points],
            n_t,
            n_points,
            blocks: Blocks::new(n_points, n_t, has_compliance),
            directions: [[f64::NAN; 3]; 3],
            saved_directions: [[f64::NAN; 3]; 3],
            springs: vec![0.0; n_points],
            solver: Tangential::new(n_points, n_t),
            forces: vec![0.0; n],
            saved_forces: vec![0.0; n],
            bounds: vec![0.0; n_points],
            shifted: vec![0.0; n_points],
            shift: vec![0.0; n_points],
            next_shift: vec![0.0; n_points],
            offsets: vec![0.0; n],
            next: vec![0.0; n],
            rates: vec![0.0; n],
            slip_rates: vec![0.0; n],
            normal_rates: vec![0.0; n_points],
            has_rates: false,
            relaxation: [n_points, n].map(Relaxation::new),
            prescribed: None,
            newton: None,
            is_taken: false,
        }
    }

    /// Tangential point forces of the last solution \[N\].
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// States of the points in the last solution.
    pub fn states(&self) -> &[PointState] {
        self.solver.states()
    }

    /// Slip increments since the references were last updated in the last solution \[m\].
    pub fn increments(&self) -> &[f64] {
        self.solver.increments()
    }

    /// Sets the compliances of the tangential springs by those of the normal ones.
    pub fn set_springs(&mut self, normal: &[f64]) {
        let ratio = 1.0 / self.law.stiffness_ratio;
        self.springs.iter_mut().zip(normal).for_each(|(s, n)| *s = n * ratio);
        self.solver.invalidate();
    }

    /// Sets the size of the friction force of point `i` per size of its components (Eq. F.24); one
    /// unless it is set.
    pub fn set_length(&mut self, i: usize, length: f64) {
        self.lengths[i] = length;
    }

    /// Sets the bounds of the tangential components under the normal forces `normal` (Eq. F.24).
    fn set_bounds(&mut self, normal: &[f64]) {
        let points = self.bounds.iter_mut().zip(normal).zip(&self.lengths);
        points.for_each(|((bound, force), length)| *bound = self.law.coefficient * force / length);
    }

    /// Compliance of the tangential spring of point `i` [m/N].
    pub fn spring(&self, i: usize) -> f64 {
        self.springs[i]
    }

    /// Energy of the tangential springs `Σ ½ D_T τ²` \[J\].
    pub fn spring_energy(&self) -> f64 {
        let terms = self.forces.iter().enumerate();
        terms.map(|(k, f)| 0.5 * self.springs[k / self.n_t] * f * f).sum()
    }

    pub fn save(&mut self) {
        self.has_rates = false;
        if let Some(newton) = &mut self.newton {
            newton.save();
        }
        self.solver.save();
        self.saved_directions = self.directions;
        self.saved_forces.copy_from_slice(&self.forces);
        self.next.copy_from_slice(&self.forces);
    }

    pub fn restore(&mut self) {
        self.has_rates = false;
        if let Some(newton) = &mut self.newton {
            newton.restore();
        }
        let bits = |d: &[[f64; 3]; 3]| d.map(|v| v.map(f64::to_bits));
        if bits(&self.directions) != bits(&self.saved_directions) {
            self.turn(self.saved_directions);
        }
        self.solver.restore();
        self.forces.copy_from_slice(&self.saved_forces);
        self.next.copy_from_slice(&self.saved_forces);
    }

    /// Projects the compliance of `zone` on the normal and the tangents `directions`, given in the model's components, for the points
    /// that `is_member` marks, all if it is empty (Eq. F.4). A projection is used again as that of the normal is
    /// ([`ZoneSolver::project`]), and grows by points that come. `half` is room for what answers to a load.
    pub fn project(
        &mut self,
        zone: &Quasistatic,
        directions: [[f64; 3]; 3],
        is_member: &[bool],
        half: &mut [f64],
    ) {
        if !is_same(&directions, &self.directions) {
            self.turn(directions);
        }
        let (directions, n_t, blocks) = (self.directions, self.n_t, &mut self.blocks);
        for j in 0..self.n_points {
            if blocks.members.contains(j) || !is_member.get(j).is_none_or(|is_member| *is_member) {
                continue;
            }
            let place = blocks.members.add(j);
            for d in 0..=n_t {
                zone.load(j, &directions[d], half);
                for slot in 0..=place {
                    let i = blocks.members.list()[slot];
                    for (e, direction) in directions.iter().enumerate().take(n_t + 1) {
                        let entry = zone.answer(i, direction, half);
                        match (e, d) {
                            (0, 0) => {}
                            (0, _) => blocks.set_coupling(j, d - 1, i, entry),
                            (_, 0) => blocks.set_coupling(i, e - 1, j, entry),
                            _ => blocks.set_tangential((i, e - 1), (j, d - 1), entry),
                        }
                    }
                }
            }
        }
    }

    /// Takes these directions: nothing is projected on them yet.
    fn turn(&mut self, directions: [[f64; 3]; 3]) {
        self.blocks.members.clear();
        self.directions = directions;
        self.solver.invalidate();
    }

    /// To be called when compliances have been set.
    pub fn finish_blocks(&mut self) {
        self.solver.invalidate();
    }

    /// Sets the slip increment of every open point along each tangent.
    pub fn set_open_increments(&mut self, increment: impl Fn(usize, usize) -> f64) {
        self.solver.set_open_increments(increment);
    }

    /// Replaces `gaps` and `slips` by the displacements of the points along the normals and the tangents under the normal forces
    /// `normal` and the last tangential ones. `of_normal` replaces its argument by those along the normals under the normal forces, for
    /// points that are not taken.
    pub fn deflect(
        &mut self,
        of_normal: impl FnOnce(&mut [f64]),
        normal: &[f64],
        gaps: &mut [f64],
        slips: &mut [f64],
    ) {
        if let Some(newton) = self.newton.as_mut().filter(|_| self.is_taken) {
            return newton.deflect((normal, &self.forces), (gaps, slips));
        }
        of_normal(gaps);
        self.blocks.add_to_gaps(&self.forces, gaps);
        self.blocks.displace(0, (normal, &self.forces), slips);
    }

    /// The same at the last solution, for slips `free` without those displacements: of points under load they follow from F.5.
    /// `of_normal` is told the gaps that the normal forces were found at.
    pub fn deflect_solved(
        &mut self,
        of_normal: impl FnOnce(&[f64], &mut [f64]),
        (free, normal): (&[f64], &[f64]),
        gaps: &mut [f64],
        slips: &mut [f64],
    ) {
        if self.is_taken {
            return self.deflect(|_| (), normal, gaps, slips);
        }
        of_normal(&self.shifted, gaps);
        gaps.iter_mut().zip(&self.shift).for_each(|(gap, shift)| *gap += shift);
        let is_open = |i: &usize| self.solver.states()[*i] == PointState::Open;
        let members = self.blocks.members.list();
        let first = members.iter().position(is_open).unwrap_or(members.len());
        self.blocks.displace(first, (normal, &self.forces), slips);
        let increments = self.solver.increments();
        for k in (0..slips.len()).filter(|k| self.solver.states()[k / self.n_t] != PointState::Open) {
            slips[k] = increments[k] - self.springs[k / self.n_t] * self.forces[k] - free[k];
        }
    }

    /// From now on the tangential forces are those `wanted`, as far as the bounds allow, whatever the slips are; none: by how much
    /// these are to change so that the forces stay as they are (Eq. A.41) \[m\].
    pub fn prescribe(&mut self, wanted: Option<Vec<f64>>) -> Vec<f64> {
        self.prescribed = wanted;
        let of_point = self.bounds.iter().flat_map(|bound| std::iter::repeat_n(*bound, self.n_t));
        let shifts = self.solver.increments().iter().zip(of_point);
        shifts.map(|(slip, bound)| if bound > 0.0 { -slip } else { 0.0 }).collect()
    }

    /// Sets the forces to zero, for a start from nothing.
    pub fn clear_forces(&mut self) {
        self.forces.fill(0.0);
    }

    /// Takes the points that `is_member` tells with their rows on `surfaces`, in whose unknowns [`StickSlip::solve_taken`] and
    /// displacements work, without projections. False where springs are missing, friction forces are given, or the
    /// components of the points are less than twice as many as these unknowns.
    pub fn take(
        &mut self,
        surfaces: &impl Surfaces,
        is_member: impl Fn(usize) -> bool,
        springs: &[f64],
    ) -> bool {
        let has_springs = (0..self.n_points).all(|i| !is_member(i) || springs[i].min(self.springs[i]) > 0.0);
        let (n, n_t) = (self.n_points, self.n_t);
        let newton = &mut self.newton;
        self.is_taken = self.prescribed.is_none() && has_springs && {
            let newton = newton.get_or_insert_with(|| Box::new(SurfaceNewton::new(n, n_t, surfaces)));
            newton.take(surfaces, is_member, n)
        };
        self.is_taken
    }

    /// Solves as [`StickSlip::solve`] does, for the points taken; the others stay open (Eq. F.34). `tolerance`: of the forces,
    /// over the largest normal one. None, and nothing solved, where none are taken, and where the steps do not converge.
    pub fn solve_taken(
        &mut self,
        tolerance: f64,
        springs: &[f64],
        (gaps, slips): (&[f64], &[f64]),
        normal_forces: &mut [f64],
    ) -> Option<SolveReport> {
        let (n_t, newton) = (self.n_t, self.newton.as_mut().filter(|_| self.is_taken)?);
        let law = Law {
            coefficient: self.law.coefficient,
            lengths: &self.lengths,
            springs: [springs, &self.springs],
        };
        let iterations = newton.solve(law, gaps, slips, tolerance);
        self.is_taken = iterations.is_some();
        let iterations = iterations?;
        normal_forces.fill(0.0);
        self.forces.fill(0.0);
        self.solver.open_all();
        for (i, answer) in newton.answers().filter(|(_, answer)| answer.forces[0] > 0.0) {
            normal_forces[i] = answer.forces[0];
            self.forces[n_t * i..n_t * (i + 1)].copy_from_slice(&answer.forces[1..=n_t]);
            self.solver.note(i, answer.state, &answer.increment);
        }
        self.next.copy_from_slice(&self.forces);
        self.set_bounds(normal_forces);
        Some(SolveReport { iterations, ..SolveReport::default() })
    }

    /// Marks the points under load in the last solution.
    pub fn add_start(&self, is_member: &mut [bool]) {
        let states = is_member.iter_mut().zip(self.solver.states());
        states.for_each(|(is_member, state)| *is_member |= *state != PointState::Open);
    }

    /// Solves for normal point forces `normal_forces` and the tangential ones at gaps `gaps` and
    /// slips `slips` since the references were last updated, both without quasistatic displacement
    /// \[m\], until these are those of the forces to `tolerance` of the deepest penetration. Slip increments of open points are left as
    /// they are.
    ///
    /// # Errors
    /// Those of [`ZoneSolver::solve`] and [`Tangential::solve`]; the iteration limit if the
    /// alternations don't converge.
    pub fn solve(
        &mut self,
        tolerance: f64,
        zone: &mut impl NormalSolver,
        springs: &[f64],
        (gaps, slips): (&[f64], &[f64]),
        normal_forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        self.is_taken = false;
        let deepest = depth(gaps);
        if deepest <= 0.0 {
            if let Some(newton) = &mut self.newton {
                newton.clear();
            }
            self.forces.fill(0.0);
            normal_forces.fill(0.0);
            self.bounds.fill(0.0);
            self.shift.fill(0.0);
            self.shifted.copy_from_slice(gaps);
            self.solve_tangential(slips, 0.0)?;
            return zone.solve_normal(springs, gaps, normal_forces);
        }
        let tolerance = tolerance * deepest;
        let (mut sum, mut inner) = (SolveReport::default(), tolerance);
        self.relaxation[0].restart();
        self.shift.fill(0.0);
        self.blocks.add_to_gaps(&self.forces, &mut self.shift);
        for _ in 0..MAX_ALTERNATIONS {
            self.shifted.iter_mut().zip(gaps).zip(&self.shift).for_each(|((x, gap), shift)| *x = gap + shift);
            sum.add(zone.solve_normal(springs, &self.shifted, normal_forces)?);
            self.set_bounds(normal_forces);
            self.offsets.copy_from_slice(slips);
            self.blocks.add_to_slips(normal_forces, &mut self.offsets);
            let offsets = std::mem::take(&mut self.offsets);
            let outcome = self.solve_tangential(&offsets, inner);
            self.offsets = offsets;
            sum.iterations += outcome?;
            self.next_shift.fill(0.0);
            self.blocks.add_to_gaps(&self.next, &mut self.next_shift);
            let relaxation = &mut self.relaxation[0];
            if relaxation.step(&mut self.shift, &self.next_shift, tolerance) && inner <= tolerance {
                self.forces.copy_from_slice(&self.next);
                return Ok(sum);
            }
            inner = (GAIN * relaxation.change()).max(INNER * tolerance);
        }
        Err(not_converged(self.law.coefficient))
    }

    /// Tangential forces under the present bounds, in `next`, with slips right to `tolerance` \[m\].
    fn solve_tangential(&mut self, slips: &[f64], tolerance: f64) -> Result<usize, EvaluationFailure> {
        self.has_rates = false;
        let problem = TangentialProblem {
            compliance: &self.blocks,
            springs: &self.springs,
            slips,
            bounds: &self.bounds,
        };
        match &self.prescribed {
            Some(wanted) => {
                self.solver.take(&problem, wanted, &mut self.next);
                Ok(0)
            }
            None if !self.blocks.yields() => {
                self.solver.return_to_bounds(&problem, &mut self.next)?;
                Ok(0)
            }
            None => self.solver.solve(&problem, tolerance, &mut self.next),
        }
    }

    /// Tangential forces where all modes are dynamic: every point for itself.
    ///
    /// # Errors
    /// If a slip is not finite.
    pub fn solve_points(&mut self, slips: &[f64], normal_forces: &[f64]) -> Result<(), EvaluationFailure> {
        self.set_bounds(normal_forces);
        self.solve_tangential(slips, 0.0)?;
        self.forces.copy_from_slice(&self.next);
        Ok(())
    }

    /// Bounds of the tangential components of the points in the last solution \[N\].
    pub fn bounds(&self) -> &[f64] {
        &self.bounds
    }

    /// Whether point `i` slid when the state was last saved.
    pub fn slid_before(&self, i: usize) -> bool {
        self.solver.saved_states()[i] == PointState::Slip
    }

    /// Largest friction force of a point that is pressed by the force `normal` \[N\].
    pub fn largest(&self, normal: f64) -> f64 {
        self.law.coefficient * normal
    }
}

fn not_converged(coefficient: f64) -> EvaluationFailure {
    SolverFault::Alternation { alternations: MAX_ALTERNATIONS, coefficient }.into()
}

#[cfg(test)]
mod tests;
