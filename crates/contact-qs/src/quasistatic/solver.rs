//! One body's quasistatic contact zone, and its solver, chosen by settings, on the contact normal.

use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::check_square;
use ffr_dynamics::error::EvaluationFailure;
use nalgebra::Vector3;
use rayon::prelude::*;

use super::active_set::SolveReport;
use super::point_solver::{Method, PointSolver};
use super::problem::{OPEN, add_product, depth, dot};
use crate::ContactError;
use crate::quasistatic::broyden::BroydenSettings;
use crate::quasistatic::compliance::sparse_rows::SparseRows;
use crate::quasistatic::compliance::{Surfaces, Yielding, ZoneCompliance};
use crate::quasistatic::modal_basis::ModalBasis;

/// Compliance of a contact zone, with its modes where Algorithm 1 shall solve it.
///
/// Rows and columns of the compliance are ordered `n_components * point + component`.
pub struct Quasistatic {
    n_components: usize,
    n_points: usize,
    yielding: Yielding,
    /// Algorithm 1 and the modes it works with, rows of the shapes as those of the compliance.
    algorithm_1: Option<(BroydenSettings, ModalBasis)>,
}

/// Solver of a zone: the compliance projected on the contact normal, and what the solver starts
/// from.
///
/// A projection serves normals about the one that it was made for: to first order in the turn, the
/// answers along the normal and the tangents to forces along the normal are all that it takes (docs/theory.md Eq. C.96).
pub struct ZoneSolver {
    /// Normal in the model's components that the projections belong to, zero before the first one, and
    /// tangents across it.
    normal: [f64; 3],
    tangents: [[f64; 3]; 2],
    saved_normal: [f64; 3],
    /// Components of the normal in use along the tangents; zero: it is that of the projections.
    turn: [f64; 2],
    /// Points whose columns are projected.
    is_projected: Vec<bool>,
    normal_compliance: Mat<f64>,
    /// `T_k`: displacements of all points along each tangent under a unit force along the normal at one. Single precision
    /// is enough: they count by the turn, and by their share in lever arms.
    tangential: Vec<Mat<f32>>,
    /// Displacements of all points, or of the unknowns under them, under such a force, in the model's components.
    under_force: Vec<f64>,
    /// `T_k λ` and `T_kᵀ λ` of the forces that they were last found for, with which an iteration on a turned normal starts.
    answers: Vec<[Vec<f64>; 2]>,
    saved_answers: Vec<[Vec<f64>; 2]>,
    /// Gaps with the first-order part of the compliance.
    turned_gaps: Vec<f64>,
    pub(super) solver: PointSolver,
}

/// Change of a component of the unit normal up to which a projection is used again as it is. The gaps err by
/// this share of what the zone yields then, as those of pairs may.
const SAME_NORMAL: f64 = 1e-8;
/// The same up to which a projection is used to first order in the turn: the second one is [`SAME_NORMAL`].
const TURNED: f64 = 1e-4;
/// Change of the gaps by a further pass, over the deepest one, that ends an iteration on a turned normal; each gains the
/// digits of the turn.
const TURN_TOLERANCE: f64 = 1e-9;
/// By how much a pass may gain less than the turn.
const TURN_MARGIN: f64 = 10.0;
/// Passes at most: three gain ten digits.
const MAX_TURN_PASSES: usize = 5;

/// Points from which on each tangent has a thread: reading their matrices takes a millisecond.
const SHARED: usize = 1500;
/// Points over those that are open but may be pressed from which on the displacements of these alone are products.
const FEW_OPEN: usize = 4;

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
        Self::of_points(method, motion, (compliance.into(), &SparseRows::new(0)), n_points)
    }

    /// The same of `n_points` points that yield by `compliance`, with the rows `functions`.
    pub(crate) fn of_points(
        method: Method,
        motion: RigidMotion,
        (compliance, functions): (ZoneCompliance, &SparseRows),
        n_points: usize,
    ) -> Result<Self, ContactError> {
        // Algorithm 1 works with the modes of the points.
        let yielding = Yielding::new(compliance, functions, matches!(method, Method::Broyden(_)));
        let algorithm_1 = match method {
            Method::ActiveSet => None,
            Method::Broyden(settings) => Some((settings, basis_from_compliance(motion, yielding.matrix())?)),
        };
        Ok(Self { n_components: motion.n_components(), n_points, yielding, algorithm_1 })
    }

    /// Number of points.
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// The surface under the points, seen along unit vectors in the model's components.
    pub(crate) fn surface(&self, directions: [[f64; 3]; 3]) -> ZoneSurface<'_> {
        ZoneSurface { yielding: &self.yielding, n_components: self.n_components, directions }
    }

    /// Replaces `half` by the answer of the compliance to a unit force on point `j` along `direction`.
    pub(crate) fn load(&self, j: usize, direction: &[f64; 3], half: &mut [f64]) {
        let components = (0..self.n_components).filter(|c| direction[*c] != 0.0);
        self.yielding.load(components.map(|c| (self.n_components * j + c, direction[c])), half);
    }

    /// Displacement of point `i` along `direction`, of which `half` is the answer of the compliance.
    pub(crate) fn answer(&self, i: usize, direction: &[f64; 3], half: &[f64]) -> f64 {
        let nc = self.n_components;
        (0..nc).map(|c| self.yielding.displacement(nc * i + c, half) * direction[c]).sum()
    }

    /// Room for [`Self::displacements`].
    pub(crate) fn buffers(&self) -> [Vec<f64>; 2] {
        [(); 2].map(|()| vec![0.0; self.yielding.matrix().nrows()])
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
        let n_t = self.n_components - 1;
        let answers = vec![[vec![0.0; n_points], vec![0.0; n_points]]; n_t];
        ZoneSolver {
            normal: [0.0; 3],
            tangents: [[0.0; 3]; 2],
            saved_normal: [0.0; 3],
            turn: [0.0; 2],
            is_projected: vec![false; n_points],
            normal_compliance: Mat::zeros(n_points, n_points),
            tangential: vec![Mat::zeros(n_points, n_points); n_t],
            under_force: vec![0.0; self.yielding.matrix().nrows()],
            saved_answers: answers.clone(),
            answers,
            turned_gaps: vec![0.0; n_points],
            solver,
        }
    }

    /// Replaces `out` by the quasistatic displacements of the points, `n_components` rows per point
    /// \[m\], under `loads`, the components of the point forces in the same order \[N\].
    pub(crate) fn displacements(&self, loads: &[f64], buffers: &mut [Vec<f64>; 2], out: &mut [f64]) {
        self.yielding.displacements(loads, buffers, out);
    }
}

/// The surface under the points of a zone.
pub(crate) struct ZoneSurface<'a> {
    yielding: &'a Yielding,
    n_components: usize,
    directions: [[f64; 3]; 3],
}

impl Surfaces for ZoneSurface<'_> {
    fn n_unknowns(&self) -> usize {
        self.yielding.matrix().nrows()
    }

    fn row(&self, i: usize, d: usize, entry: &mut dyn FnMut(usize, f64)) {
        let nc = self.n_components;
        (0..nc).for_each(|c| self.yielding.row(nc * i + c, self.directions[d][c], entry));
    }

    fn compliance(&self, i: usize, j: usize) -> f64 {
        self.yielding.matrix()[(i, j)]
    }
}

impl ZoneSolver {
    /// Normal compliance `A` of the last projection, `n_points × n_points` [m/N].
    pub fn normal_compliance(&self) -> &Mat<f64> {
        &self.normal_compliance
    }

    /// Projects compliance or shapes of `zone`, for which the solver was made, on the unit normal
    /// `normal`, given in the model's components (Eq. C.2). Does nothing when the normal has changed
    /// by round-off alone.
    pub fn project(&mut self, zone: &Quasistatic, normal: [f64; 3]) {
        self.project_members(zone, normal, &[], false);
    }

    /// Projects the compliance as [`Self::project`] does, but for the points alone that `is_member`
    /// marks, all if it is empty. Columns of other points are not valid afterwards, and these points
    /// must stay open. The factor of the solver outlives points that come to those of the same normal,
    /// and with `is_turned` normals that have turned so little that first order is enough.
    pub(crate) fn project_members(
        &mut self,
        zone: &Quasistatic,
        normal: [f64; 3],
        is_member: &[bool],
        is_turned: bool,
    ) {
        self.turn = [0.0; 2];
        if !is_same(&[normal], &[self.normal]) {
            let turn = self.tangents.map(|tangent| dot(&tangent, &normal));
            let is_near = dot(&self.normal, &normal) > 0.5 && turn.iter().all(|c| c.abs() <= TURNED);
            if is_turned && is_near {
                self.turn = turn;
            } else {
                self.turn_to(zone, normal);
            }
        }
        for j in 0..self.is_projected.len() {
            if self.is_projected[j] || !is_member.get(j).is_none_or(|is_member| *is_member) {
                continue;
            }
            self.is_projected[j] = true;
            let (normal, tangents) = (self.normal, self.tangents);
            zone.load(j, &normal, &mut self.under_force);
            let under_force = &self.under_force;
            let along = |direction: [f64; 3]| {
                (0..zone.n_points).map(move |i| zone.answer(i, &direction, under_force))
            };
            let column = self.normal_compliance.col_as_slice_mut(j);
            column.iter_mut().zip(along(normal)).for_each(|(entry, u)| *entry = u);
            for (matrix, tangent) in self.tangential.iter_mut().zip(tangents) {
                matrix
                    .col_as_slice_mut(j)
                    .iter_mut()
                    .zip(along(tangent))
                    .for_each(|(entry, u)| *entry = u as f32);
            }
        }
    }

    /// Takes the normal in all its bits: nothing is projected on another one yet but the modes of
    /// Algorithm 1.
    fn turn_to(&mut self, zone: &Quasistatic, normal: [f64; 3]) {
        self.turn = [0.0; 2];
        if self.normal.map(f64::to_bits) == normal.map(f64::to_bits) {
            return;
        }
        self.normal = normal;
        self.tangents = match zone.n_components {
            2 => [[-normal[1], normal[0], 0.0], [0.0; 3]],
            _ => across(normal),
        };
        self.is_projected.fill(false);
        self.answers.as_flattened_mut().iter_mut().for_each(|answer| answer.fill(0.0));
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

    /// Replaces the answers `T_k λ` and `T_kᵀ λ` by those to `forces`: one pass over the matrices. Returns the largest
    /// change of the first-order part of the gaps.
    fn answer(&mut self, forces: &[f64]) -> f64 {
        let add = |gaps: &mut [f64], answers: &[[Vec<f64>; 2]], sign: f64| {
            for ([along, back], turn) in answers.iter().zip(self.turn) {
                let sums = along.iter().zip(back).map(|(a, b)| a + b);
                gaps.iter_mut().zip(sums).for_each(|(gap, sum)| *gap += sign * turn * sum);
            }
        };
        self.turned_gaps.fill(0.0);
        add(&mut self.turned_gaps, &self.answers, -1.0);
        let (is_projected, is_open) = (&self.is_projected, forces.iter().all(|force| *force == 0.0));
        let answer = |(matrix, [along, back]): (&Mat<f32>, &mut [Vec<f64>; 2])| {
            along.fill(0.0);
            back.fill(0.0);
            for (j, _) in
                is_projected.iter().enumerate().filter(|(_, is_projected)| **is_projected && !is_open)
            {
                back[j] = add_and_dot(matrix.col_as_slice(j), forces[j], along, forces);
            }
        };
        match forces.len() {
            SHARED.. => self.tangential.par_iter().zip(&mut self.answers).for_each(answer),
            _ => self.tangential.iter().zip(&mut self.answers).for_each(answer),
        }
        add(&mut self.turned_gaps, &self.answers, 1.0);
        self.turned_gaps.iter().fold(0.0, |most, change| most.max(change.abs()))
    }

    /// Whether the normal in use is another than that of the projections.
    fn is_turned(&self) -> bool {
        self.turn.iter().any(|c| *c != 0.0)
    }

    /// The part of the gap of point `i` that is of first order in the turn, under the forces last answered to.
    fn first_order(&self, i: usize) -> f64 {
        self.answers.iter().zip(self.turn).map(|([along, back], turn)| turn * (along[i] + back[i])).sum()
    }

    /// Replaces `along` by the displacements of the points along the normal that is projected on, under `forces`. Where few
    /// points are open the others are displaced as far as (C.8) says.
    fn displace_along(&self, springs: &[f64], forces: &[f64], free_gaps: &[f64], along: &mut [f64]) {
        along.fill(0.0);
        let is_open = |i: usize| forces[i] == 0.0 && free_gaps[i] < 0.5 * OPEN;
        let n_open = (0..along.len()).filter(|&i| is_open(i)).count();
        if FEW_OPEN * n_open > along.len() || self.solver.needs_springs() {
            return add_product(&self.normal_compliance, forces, along);
        }
        for (i, u) in along.iter_mut().enumerate() {
            let loaded = || forces.iter().enumerate().filter(|(_, force)| **force != 0.0);
            *u = match (is_open(i), self.is_projected[i]) {
                (false, _) if forces[i] == 0.0 => 0.0,
                (false, _) => -free_gaps[i] - springs[i] * forces[i] - self.first_order(i),
                // The compliance is symmetric: a row is a column.
                (true, true) => dot(self.normal_compliance.col_as_slice(i), forces),
                (true, false) => loaded().map(|(j, force)| self.normal_compliance[(i, j)] * force).sum(),
            };
        }
    }

    /// Replaces `displacements` by those of the points under `forces`, the last solution with `springs`, along the normal in
    /// use, as [`Quasistatic::displacements`] has them, and `gaps` by `free_gaps` with them; points that nothing can press
    /// may be left where they are.
    pub(crate) fn displace(
        &mut self,
        (springs, forces): (&[f64], &[f64]),
        free_gaps: &[f64],
        gaps: &mut [f64],
        displacements: &mut [f64],
    ) {
        self.displace_along(springs, forces, free_gaps, gaps);
        if !self.is_turned() {
            self.answer(forces);
        }
        let nc = self.answers.len() + 1;
        let normal: [f64; 3] = std::array::from_fn(|c| {
            let turned: f64 =
                self.tangents.iter().zip(self.turn).map(|(tangent, turn)| turn * tangent[c]).sum();
            self.normal[c] + turned
        });
        for (i, (gap, free)) in gaps.iter_mut().zip(free_gaps).enumerate() {
            let along = *gap + self.first_order(i);
            *gap = free + along;
            for (c, u) in displacements[nc * i..][..nc].iter_mut().enumerate() {
                let across = self.answers.iter().zip(&self.tangents).map(|([t, _], e)| t[i] * e[c]);
                *u = normal[c] * along + across.sum::<f64>();
            }
        }
    }

    /// By how much gaps of points that are not projected may be off for the turn \[m\].
    pub(crate) fn doubt(&self) -> f64 {
        let most = |answer: &[f64]| answer.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        self.answers.iter().zip(self.turn).map(|([along, _], turn)| turn.abs() * most(along)).sum()
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
    /// On a turned normal the first-order part of the compliance acts on the forces of the pass before: each pass
    /// gains the digits of the turn, with the factor of the normal that is projected on.
    ///
    /// # Errors
    /// [`EvaluationFailure`] of [`super::ActiveSet::solve`] and [`crate::quasistatic::broyden::Broyden::solve`].
    pub fn solve(
        &mut self,
        springs: &[f64],
        gaps: &[f64],
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        if !self.is_turned() {
            return self.solver.solve(&self.normal_compliance, springs, gaps, forces);
        }
        let gain = TURN_MARGIN * self.turn[0].hypot(self.turn[1]);
        let enough = TURN_TOLERANCE * depth(gaps);
        let (mut total, mut is_last) = (SolveReport::default(), false);
        for _ in 0..MAX_TURN_PASSES {
            for (i, gap) in gaps.iter().enumerate() {
                self.turned_gaps[i] = gap + self.first_order(i);
            }
            total.add(self.solver.solve(&self.normal_compliance, springs, &self.turned_gaps, forces)?);
            if is_last {
                break;
            }
            let change = self.answer(forces);
            if change <= enough {
                break;
            }
            is_last = gain * change <= enough;
        }
        Ok(total)
    }

    /// To be called when the springs have changed.
    pub fn springs_changed(&mut self) {
        self.solver.invalidate();
    }

    /// Remembers what the solver starts from, and the normal that is projected on.
    pub fn save(&mut self) {
        self.saved_normal = self.normal;
        for (saved, answer) in
            self.saved_answers.as_flattened_mut().iter_mut().zip(self.answers.as_flattened())
        {
            saved.copy_from_slice(answer);
        }
        self.solver.save();
    }

    /// Returns to what was remembered; columns are functions of the normal and are projected again
    /// where they are needed.
    pub fn restore(&mut self, zone: &Quasistatic) {
        self.turn_to(zone, self.saved_normal);
        for (answer, saved) in
            self.answers.as_flattened_mut().iter_mut().zip(self.saved_answers.as_flattened())
        {
            answer.copy_from_slice(saved);
        }
        self.solver.restore();
    }
}

/// Adds `factor` times `column` to `sum` and returns the scalar product of `column` and `x`.
fn add_and_dot(column: &[f32], factor: f64, sum: &mut [f64], x: &[f64]) -> f64 {
    let n = column.len();
    let (columns, rest) = column.as_chunks::<8>();
    let ((sums, sum_rest), (xs, x_rest)) = (sum[..n].as_chunks_mut::<8>(), x[..n].as_chunks::<8>());
    let mut products = [0.0; 8];
    for ((c, s), x) in columns.iter().zip(sums).zip(xs) {
        for k in 0..8 {
            let entry = f64::from(c[k]);
            s[k] += factor * entry;
            products[k] += entry * x[k];
        }
    }
    let mut product = products.iter().sum();
    for ((c, s), x) in rest.iter().zip(sum_rest).zip(x_rest) {
        *s += factor * f64::from(*c);
        product += f64::from(*c) * x;
    }
    product
}

/// Two unit vectors across the unit vector `normal` and each other.
fn across(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let least = (0..3).min_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(0);
    let n = Vector3::from(normal);
    let first = n.cross(&Vector3::ith(least, 1.0)).normalize();
    [first.into(), n.cross(&first).into()]
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Normals turned by up to 1e-4 against a projection on each: forces, gaps and displacements differ by the square of the
    /// turn, and the sum of the moments is the gradient of the potential.
    #[test]
    fn turned_normals_need_no_projection_of_their_own() {
        let mut seed = 11_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for (motion, nc) in [(RigidMotion::Spatial, 3), (RigidMotion::Planar, 2)] {
            let n = 8;
            let v = Mat::from_fn(nc * n, nc * n, |_, _| random());
            let zone = Quasistatic::new(Method::ActiveSet, motion, &v * v.transpose()).unwrap();
            let gaps: Vec<f64> = (0..n).map(|i| if i == 3 { 1.0 } else { random() - 1.1 }).collect();
            let springs = vec![2.0; n];
            let normal = |turn: [f64; 2]| {
                let n = Vector3::new(turn[0] * f64::from(u8::from(nc == 3)), 0.6 + turn[1], 0.8);
                let n = if nc == 2 { Vector3::new(n.y, n.z, 0.0) } else { n };
                <[f64; 3]>::from(n.normalize())
            };
            let solve = |solver: &mut ZoneSolver, normal, is_turned| {
                solver.project_members(&zone, normal, &vec![true; n], is_turned);
                let [mut forces, mut found] = [(); 2].map(|()| vec![0.0; n]);
                solver.solve(&springs, &gaps, &mut forces).unwrap();
                let mut displacements = vec![0.0; nc * n];
                solver.displace((&springs, &forces), &gaps, &mut found, &mut displacements);
                let sum = |terms: &[f64]| terms.iter().zip(&forces).map(|(a, b)| a * b).sum::<f64>();
                // The least value of Eq. C.5 with its sign changed.
                let potential = -0.5 * sum(&gaps);
                (forces, found, displacements, potential)
            };
            let mut solver = zone.solver();
            solve(&mut solver, normal([0.0; 2]), true);
            for turn in [[2e-5, -3e-5], [5e-5, 4e-5], [-3e-9, 0.0]] {
                let turned = solve(&mut solver, normal(turn), true);
                let exact = solve(&mut zone.solver(), normal(turn), false);
                let off =
                    |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                // Gaps of order one: the square of the turn for forces, and tolerances of 1e-9.
                assert!(off(&turned.0, &exact.0) < 2e-8 && off(&turned.1, &exact.1) < 2e-8);
                assert!(off(&turned.2, &exact.2) < 1e-3);
            }
            assert!(solver.doubt() < 1e-3);
            // Central differences of the potential about a turned normal against the moment of the forces.
            let (base, step) = ([2e-5, -3e-5], 1e-5);
            let potential =
                |solver: &mut ZoneSolver, d: f64| solve(solver, normal([base[0], base[1] + d]), true).3;
            let slope = (potential(&mut solver, step) - potential(&mut solver, -step)) / (2.0 * step);
            let (forces, _, displacements, _) = solve(&mut solver, normal(base), true);
            let turned = Vector3::from(normal([base[0], base[1] + step]))
                - Vector3::from(normal([base[0], base[1] - step]));
            let power: f64 = displacements
                .chunks_exact(nc)
                .zip(&forces)
                .map(|(u, force)| {
                    force * u.iter().zip(turned.iter()).map(|(u, d)| u * d).sum::<f64>() / (2.0 * step)
                })
                .sum();
            // The turn is one of first order; differences of tolerances of 1e-9 over 2e-5.
            assert!((slope + power).abs() < 1e-3 * power.abs(), "{slope} {power}");
        }
    }
}
