//! Normal and tangential forces at once, in the unknowns of the surfaces.
//!
//! Points may be many times as many as the unknowns of the surfaces that they stand on. The forces that they give to these,
//! `r = Bᵀ f`, displace them by `B G r`, and each point answers to gap and slip for itself, by its springs and Coulomb's law
//! (docs/theory.md Eqs. F.3, F.34): `r = Bᵀ f(c + B G r)` is solved by Newton's method on `r` (F.35), with the factors of an
//! earlier matrix as long as they help. The forces are those of F.4 and F.5.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::kept_factor::KeptFactor;
use crate::quasistatic::compliance::Surfaces;
use crate::quasistatic::members::Members;
use crate::quasistatic::problem::add_multiples;
use crate::quasistatic::tangential::PointState;

/// Components of the points over the unknowns from which on these are worth it: equations without symmetry, for all directions at once,
/// and in place of the points under load alone all that a step has asked for.
const FEWER: usize = 2;
/// Steps after which it is given up.
const MAX_STEPS: usize = 30;
/// Factorisations of many unknowns within a step of the motion above which points by themselves are quicker,
const MANY: usize = 100;
const MOST_FACTORS: usize = 4;
/// and the least number of steps of the motion for which they are taken then; twice as many each time, up to the largest.
const RESTS: [usize; 2] = [8, 128];
/// What is left of a step's linear system: four digits a step.
const STEP_TOLERANCE: f64 = 1e-4;
/// Error that is accepted where it does not fall any more, over the largest force: round-off of stiff springs.
const ROUND_OFF: f64 = 1e-10;
/// Gain of a step below which the error does not fall any more.
const GAIN: f64 = 0.1;

/// The law of the points, by their numbers.
#[derive(Clone, Copy)]
pub(super) struct Law<'a> {
    /// Friction coefficient over the lengths of (F.24).
    pub coefficient: f64,
    pub lengths: &'a [f64],
    /// Compliances of the springs along the normal and across it [m/N].
    pub springs: [&'a [f64]; 2],
}

/// A point's answer to its gap and slip.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Answer {
    pub state: PointState,
    /// Forces along normal and tangents.
    pub forces: [f64; 3],
    /// Their slopes with the sign changed, `-∂f_a/∂c_b`.
    slopes: [[f64; 3]; 3],
    /// Slip increment.
    pub increment: [f64; 2],
    /// Whether it is held beyond its bound.
    is_held: bool,
}

impl Law<'_> {
    /// Answer of point `i` to the gap and slip `c`. A point whose slip has turned against that of the answer `before` is held, whatever
    /// its bound: it may stick between the two.
    fn answer(&self, i: usize, c: [f64; 3], before: &Answer) -> Answer {
        let mut answer = Answer::default();
        if c[0] >= 0.0 {
            return answer;
        }
        let [normal, tangential] = self.springs.map(|springs| springs[i]);
        let (ratio, slip) = (self.coefficient / self.lengths[i], [c[1], c[2]]);
        answer.forces[0] = -c[0] / normal;
        answer.slopes[0][0] = 1.0 / normal;
        let (bound, size) = (ratio * answer.forces[0], slip[0].hypot(slip[1]));
        if bound <= 0.0 {
            return answer;
        }
        let way = [1, 2].map(|a| before.forces[a] * slip[a - 1]);
        answer.is_held = before.state == PointState::Slip && way[0] + way[1] >= 0.0;
        if size <= bound * tangential || answer.is_held {
            answer.is_held = size > bound * tangential;
            answer.state = PointState::Stick;
            for (a, slip) in (1..).zip(slip) {
                answer.forces[a] = -slip / tangential;
                answer.slopes[a][a] = 1.0 / tangential;
            }
            return answer;
        }
        answer.state = PointState::Slip;
        let unit = slip.map(|s| s / size);
        for a in 0..2 {
            answer.forces[a + 1] = -bound * unit[a];
            answer.increment[a] = slip[a] - tangential * bound * unit[a];
            answer.slopes[a + 1][0] = -ratio * unit[a] / normal;
            for b in 0..2 {
                let across = f64::from(u8::from(a == b)) - unit[a] * unit[b];
                answer.slopes[a + 1][b + 1] = bound / size * across;
            }
        }
        answer
    }
}

/// Points in use with their answers, on the unknowns that they stand on.
struct System {
    n_d: usize,
    points: Vec<usize>,
    answers: Vec<Answer>,
    /// `B`, `n_d` rows for each point in use, in places of the unknowns.
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
    /// Numbers of the unknowns in use.
    unknowns: Members,
    /// `G` of these unknowns, column by column.
    core: Vec<f64>,
    /// Displacements of these unknowns.
    displaced: Vec<f64>,
}

impl System {
    fn row(&self, slot: usize, d: usize) -> &[(usize, f64)] {
        let row = self.n_d * slot + d;
        &self.entries[self.starts[row]..self.starts[row + 1]]
    }

    /// Displaces the unknowns by the forces `x` on them.
    fn displace(&mut self, x: &[f64]) {
        let m = x.len();
        let displaced = &mut self.displaced[..m];
        displaced.fill(0.0);
        let columns = self.core.chunks_exact(m.max(1)).zip(x).filter(|(_, x)| **x != 0.0);
        add_multiples(columns.map(|(column, x)| (column, *x)), displaced);
    }

    /// Displacements of a point in use along its directions.
    fn of_point(&self, slot: usize) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for (d, sum) in sums.iter_mut().enumerate().take(self.n_d) {
            *sum = self.row(slot, d).iter().map(|&(k, value)| value * self.displaced[k]).sum();
        }
        sums
    }

    /// Adds the forces `forces` of a point in use to those on the unknowns, `out`.
    fn spread(&self, slot: usize, forces: &[f64; 3], out: &mut [f64]) {
        for (d, force) in forces.iter().enumerate().take(self.n_d).filter(|(_, force)| **force != 0.0) {
            self.row(slot, d).iter().for_each(|&(k, value)| out[k] += value * force);
        }
    }

    /// Slots of the points under load.
    fn pressed(&self) -> impl Iterator<Item = usize> + use<'_> {
        (0..self.points.len()).filter(|slot| self.answers[*slot].forces[0] > 0.0)
    }

    /// `out = (1 + Bᵀ S B G) x` with the slopes `S` of the last answers.
    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.displace(x);
        out.copy_from_slice(x);
        for slot in self.pressed() {
            self.spread(slot, &product(&self.answers[slot].slopes, self.of_point(slot)), out);
        }
    }

    /// Writes that matrix to `out`, column by column; `stiffness` is room for `Bᵀ S B`.
    fn write_matrix(&self, stiffness: &mut [f64], out: &mut [f64]) {
        let m = self.unknowns.list().len();
        stiffness.fill(0.0);
        for slot in self.pressed() {
            let slopes = &self.answers[slot].slopes;
            for (a, b) in (0..self.n_d).flat_map(|a| (0..self.n_d).map(move |b| (a, b))) {
                if slopes[a][b] == 0.0 {
                    continue;
                }
                for &(j, value) in self.row(slot, b) {
                    let (column, factor) = (&mut stiffness[j * m..(j + 1) * m], slopes[a][b] * value);
                    self.row(slot, a).iter().for_each(|&(i, value)| column[i] += value * factor);
                }
            }
        }
        out.fill(0.0);
        out.iter_mut().step_by(m + 1).for_each(|entry| *entry = 1.0);
        let [left, right] =
            [&*stiffness, &self.core[..m * m]].map(|matrix| MatRef::from_column_major_slice(matrix, m, m));
        matmul(MatMut::from_column_major_slice_mut(out, m, m), Accum::Add, left, right, 1.0, Par::Seq);
    }
}

fn product(matrix: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
}

/// Newton's method on the forces of the unknowns.
pub(super) struct SurfaceNewton {
    system: System,
    factor: KeptFactor,
    /// Forces on all unknowns, with which the next solution starts.
    shares: Vec<f64>,
    saved: Vec<f64>,
    /// Those on the unknowns in use, and what they lack.
    x: Vec<f64>,
    step: Vec<f64>,
    stiffness: Vec<f64>,
    /// Whether the unknowns in use and the factors are those of an earlier step, and how many of them have their compliances.
    is_old: bool,
    n_gathered: usize,
    /// Factorisations since then.
    n_factors: usize,
    /// Steps of the motion that it rests for still, and those of the last rest.
    rest: [usize; 2],
    saved_rest: [usize; 2],
}

impl SurfaceNewton {
    /// For `n_points` points with `n_t` tangents on `surfaces`.
    pub fn new(n_points: usize, n_t: usize, surfaces: &impl Surfaces) -> Self {
        let (n, n_d) = (surfaces.n_unknowns(), n_t + 1);
        let mut n_entries = 0;
        for (i, d) in (0..n_points).flat_map(|i| (0..n_d).map(move |d| (i, d))) {
            surfaces.row(i, d, &mut |_, _| n_entries += 1);
        }
        let system = System {
            n_d,
            points: Vec::with_capacity(n_points),
            answers: Vec::with_capacity(n_points),
            starts: Vec::with_capacity(n_d * n_points + 1),
            entries: Vec::with_capacity(n_entries),
            unknowns: Members::new(n),
            core: vec![0.0; n * n],
            displaced: vec![0.0; n],
        };
        Self {
            system,
            factor: KeptFactor::new(n),
            shares: vec![0.0; n],
            saved: vec![0.0; n],
            x: vec![0.0; n],
            step: vec![0.0; n],
            stiffness: vec![0.0; n * n],
            is_old: false,
            n_gathered: 0,
            n_factors: 0,
            rest: [0; 2],
            saved_rest: [0; 2],
        }
    }

    /// Has the unknowns gathered and the matrix factorised anew when points are taken next, so that solutions after [`Self::restore`]
    /// are the same in every bit.
    pub fn save(&mut self) {
        self.saved.copy_from_slice(&self.shares);
        self.rest[0] = self.rest[0].saturating_sub(1);
        self.saved_rest = self.rest;
        self.is_old = true;
    }

    pub fn restore(&mut self) {
        self.shares.copy_from_slice(&self.saved);
        self.rest = self.saved_rest;
        self.is_old = true;
    }

    /// Takes those of `n_points` points that `is_member` tells, with their rows on `surfaces`. Unknowns in use stay so. False if these are not clearly
    /// fewer than the components of the points, or other ways are quicker at present.
    pub fn take(
        &mut self,
        surfaces: &impl Surfaces,
        is_member: impl Fn(usize) -> bool,
        n_points: usize,
    ) -> bool {
        let System { n_d, points, starts, entries, unknowns, core, .. } = &mut self.system;
        if std::mem::take(&mut self.is_old) {
            unknowns.clear();
            (self.n_gathered, self.n_factors) = (0, 0);
        }
        if self.rest[0] > 0 {
            return false;
        }
        points.clear();
        points.extend((0..n_points).filter(|i| is_member(*i)));
        starts.clear();
        starts.push(0);
        entries.clear();
        for (&i, d) in points.iter().flat_map(|i| (0..*n_d).map(move |d| (i, d))) {
            surfaces.row(i, d, &mut |b, value| entries.push((unknowns.add(b), value)));
            starts.push(entries.len());
        }
        let m = unknowns.list().len();
        if FEWER * m > starts.len() - 1 {
            return false;
        }
        if m == self.n_gathered {
            return true;
        }
        self.n_gathered = m;
        self.factor.forget();
        for (column, &j) in core.chunks_exact_mut(m).zip(unknowns.list()) {
            column.iter_mut().zip(unknowns.list()).for_each(|(entry, &i)| *entry = surfaces.compliance(i, j));
        }
        true
    }

    /// Answers of the points to the gaps and slips that the forces `x` leave, and what these lack in `step`; returns the largest of
    /// that and of the forces.
    fn evaluate(&mut self, law: Law<'_>, gaps: &[f64], slips: &[f64]) -> [f64; 2] {
        let (m, system) = (self.system.unknowns.list().len(), &mut self.system);
        let (x, step) = (&self.x[..m], &mut self.step[..m]);
        system.displace(x);
        step.iter_mut().zip(x).for_each(|(s, x)| *s = -x);
        let (n_t, mut largest) = (system.n_d - 1, 0.0_f64);
        for slot in 0..system.points.len() {
            let (i, mut c) = (system.points[slot], system.of_point(slot));
            c[0] += gaps[i];
            (0..n_t).for_each(|a| c[a + 1] += slips[n_t * i + a]);
            let answer = law.answer(i, c, &system.answers[slot]);
            system.answers[slot] = answer;
            largest = largest.max(answer.forces[0]);
            system.spread(slot, &answer.forces, step);
        }
        [step.iter().fold(0.0, |most, s| most.max(s.abs())), largest]
    }

    /// Replaces `step` by the solution of the linear system of the last answers with that right-hand side.
    fn solve_linear(&mut self, tolerance: f64) {
        let Self { system, factor, step, stiffness, n_factors, .. } = self;
        let m = system.unknowns.list().len();
        let step = &mut step[..m];
        if !factor.is_made() || !factor.solve_near(|x, out| system.apply(x, out), tolerance, step) {
            *n_factors += usize::from(m > MANY);
            factor.factorise(m, |out| system.write_matrix(&mut stiffness[..m * m], out));
            factor.solve(step);
        }
    }

    /// Solves for the forces of the points taken at gaps `gaps` and slips `slips` without those, to `tolerance` of the largest; returns
    /// the number of steps, none if that does not converge.
    pub fn solve(&mut self, law: Law<'_>, gaps: &[f64], slips: &[f64], tolerance: f64) -> Option<usize> {
        for (x, b) in self.x.iter_mut().zip(self.system.unknowns.list()) {
            *x = self.shares[*b];
        }
        self.system.answers.clear();
        self.system.answers.resize(self.system.points.len(), Answer::default());
        let mut last = f64::INFINITY;
        for n_steps in 0..MAX_STEPS {
            let [error, largest] = self.evaluate(law, gaps, slips);
            if !error.is_finite() || self.n_factors > MOST_FACTORS {
                break;
            }
            let is_right = !self.system.answers.iter().any(|answer| answer.is_held);
            let is_stalled = error <= ROUND_OFF * largest && error >= GAIN * last;
            if is_right && (error <= tolerance * largest || is_stalled) {
                self.shares.fill(0.0);
                for (x, b) in self.x.iter().zip(self.system.unknowns.list()) {
                    self.shares[*b] = *x;
                }
                return Some(n_steps);
            }
            last = error;
            self.solve_linear(STEP_TOLERANCE);
            self.x.iter_mut().zip(&self.step[..self.system.unknowns.list().len()]).for_each(|(x, s)| *x += s);
        }
        self.rest = [(2 * self.rest[1]).clamp(RESTS[0], RESTS[1]); 2];
        None
    }

    /// Points taken, with their answers.
    pub fn answers(&self) -> impl Iterator<Item = (usize, &Answer)> {
        self.system.points.iter().copied().zip(&self.system.answers)
    }

    /// Passes each point taken, its rates of forces, and of gap and slip with those that the forces bring, to `found` when gaps and slips
    /// change at `gap_rates` and `slip_rates` without these, at the answers of the last solution.
    pub fn rates(
        &mut self,
        (gap_rates, slip_rates): (&[f64], &[f64]),
        tolerance: f64,
        mut found: impl FnMut(usize, [f64; 3], [f64; 3]),
    ) {
        let (m, n_t) = (self.system.unknowns.list().len(), self.system.n_d - 1);
        let free = |i: usize| {
            let mut c = [gap_rates[i], 0.0, 0.0];
            (0..n_t).for_each(|a| c[a + 1] = slip_rates[n_t * i + a]);
            c
        };
        let step = &mut self.step[..m];
        step.fill(0.0);
        let system = &self.system;
        for slot in system.pressed() {
            let forces = product(&system.answers[slot].slopes, free(system.points[slot]));
            system.spread(slot, &forces.map(|f| -f), step);
        }
        self.solve_linear(tolerance);
        let system = &mut self.system;
        system.displace(&self.step[..m]);
        for (slot, &i) in system.points.iter().enumerate() {
            let (moved, free) = (system.of_point(slot), free(i));
            let rates: [f64; 3] = std::array::from_fn(|d| free[d] + moved[d]);
            found(i, product(&system.answers[slot].slopes, rates).map(|f| -f), rates);
        }
    }

    /// Replaces gaps and slips of the points taken by their displacements under normal and tangential forces, those of others by zero.
    pub fn deflect(
        &mut self,
        (normal, tangential): (&[f64], &[f64]),
        (gaps, slips): (&mut [f64], &mut [f64]),
    ) {
        let (m, n_t, system) = (self.system.unknowns.list().len(), self.system.n_d - 1, &mut self.system);
        let shares = &mut self.step[..m];
        [&mut *gaps, &mut *slips, &mut *shares].into_iter().for_each(|values| values.fill(0.0));
        for (slot, &i) in system.points.iter().enumerate() {
            let mut forces = [normal[i], 0.0, 0.0];
            forces[1..=n_t].copy_from_slice(&tangential[n_t * i..n_t * (i + 1)]);
            system.spread(slot, &forces, shares);
        }
        system.displace(shares);
        for (slot, &i) in system.points.iter().enumerate() {
            let moved = system.of_point(slot);
            gaps[i] = moved[0];
            slips[n_t * i..n_t * (i + 1)].copy_from_slice(&moved[1..=n_t]);
        }
    }

    /// Starts the next solution from no forces.
    pub fn clear(&mut self) {
        self.shares.fill(0.0);
    }
}
