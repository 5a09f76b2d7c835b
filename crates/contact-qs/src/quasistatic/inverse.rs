//! Forces of large sets that change by few points, from one inverse.
//!
//! With `P = (A_uu + D_uu)⁻¹` of a set `u`, the forces of a set `a ⊂ u` follow from the points
//! `r = u \ a` alone: `λ_u = P(v - g⁰_a)`, with those `v_r` for which `λ_r` vanishes,
//! `P_rr v_r = (P g⁰_a)_r` (docs/theory.md Eq. C.95). That factorises `r` in place of `a`; `v_r = A_ra λ_a`
//! is what the open points are displaced by. Components of forces along any direction are held as those of points are, stiffly or by
//! springs (F.36).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::{MatMut, MatRef, Par};

use super::factors::Cholesky;
use super::problem::add_multiples;

/// Points from which on an inverse pays: smaller sets are factorised within the time that a product with
/// their matrix takes to come from memory.
const LARGE: usize = 256;
/// Factorisations of subsets of `u` after which `P`, which takes three of them, is made, and of the points left
/// out by which one has paid, so that the next is made at once.
const WORTH: usize = 3;
/// Smallest pivot, over its diagonal entry, of sets that are inverted: the forces lose six of sixteen
/// digits at most.
const WELL_CONDITIONED: f64 = 1e-6;

/// A combination of the forces that is held: it vanishes, or is that of a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    /// Points of `u` by number, with their factors.
    pub forces: [(usize, f64); 2],
    /// One over the stiffness of the spring.
    pub compliance: f64,
}

/// The inverse of the matrix of a set of points, and what its subsets need.
#[derive(Default)]
pub(super) struct SetInverse {
    /// `u`, ascending, and the place of each point in it; `usize::MAX`: not in it.
    points: Vec<usize>,
    places: Vec<usize>,
    /// Factorisations of subsets of `u` since it grew or the matrix changed.
    n_factorised: usize,
    /// Sets solved by the matrix in use, and whether the last one paid.
    n_solved: usize,
    has_paid: bool,
    /// `P`, column by column, symmetric; empty: not made.
    matrix: Vec<f64>,
    /// Whether a matrix of these points was not worth its inverse: too near to a singular one.
    is_refused: bool,
    /// What is held, by places in `u`, ascending, and that which `factor` belongs to: the points `r` where that is points.
    held: Vec<Held>,
    factored: Vec<Held>,
    factor: Vec<f64>,
    /// One value per point of `u`, and one per point of `r`.
    answer: Vec<f64>,
    displacements: Vec<f64>,
    cholesky: Option<Cholesky>,
}

impl SetInverse {
    /// Forgets the matrices, not the points.
    pub fn invalidate(&mut self) {
        if !self.matrix.is_empty() {
            self.has_paid = self.n_solved >= WORTH;
        }
        self.matrix.clear();
        self.factored.clear();
        (self.n_factorised, self.n_solved) = (0, 0);
    }

    /// Forgets the points as well.
    pub fn forget(&mut self) {
        self.invalidate();
        self.points.iter().for_each(|&i| self.places[i] = usize::MAX);
        self.points.clear();
        (self.has_paid, self.is_refused) = (false, false);
    }

    /// Whether a set has been solved by the matrix in use.
    #[cfg(test)]
    pub fn has_served(&self) -> bool {
        self.n_solved > 0
    }

    /// Notes a factorisation of the set `members` among `n_points` points.
    pub fn note(&mut self, members: &[usize], n_points: usize) {
        if members.len() < LARGE {
            return;
        }
        self.places.resize(n_points, usize::MAX);
        if members.iter().all(|&i| self.places[i] != usize::MAX) {
            self.n_factorised += 1;
            return;
        }
        members.iter().for_each(|&i| self.places[i] = 0);
        self.points.clear();
        self.points.extend((0..n_points).filter(|&i| self.places[i] != usize::MAX));
        self.points.iter().enumerate().for_each(|(k, &i)| self.places[i] = k);
        self.invalidate();
        (self.n_factorised, self.has_paid, self.is_refused) = (1, false, false);
    }

    /// Whether the forces of the set `members` are to be found by the inverse, made or not.
    pub fn serves(&self, members: &[usize]) -> bool {
        let (n, m) = (self.points.len(), members.len());
        m >= LARGE
            && n <= 2 * m
            && (self.has_paid || self.n_factorised >= WORTH)
            && !self.is_refused
            && members.iter().all(|&i| self.places[i] != usize::MAX)
    }

    /// Makes the inverse of the matrix of `u`, whose entries `matrix` gives, if there is none; whether
    /// there is one now. `buffer` holds the matrix meanwhile.
    pub fn make(&mut self, matrix: impl Fn(usize, usize) -> f64, buffer: &mut [f64]) -> bool {
        let n = self.points.len();
        if self.matrix.len() == n * n {
            return true;
        }
        let buffer = &mut buffer[..n * n];
        for (column, &j) in buffer.chunks_exact_mut(n).zip(&self.points) {
            column.iter_mut().zip(&self.points).for_each(|(entry, &i)| *entry = matrix(i, j));
        }
        let diagonal: Vec<f64> = (0..n).map(|k| buffer[k * n + k]).collect();
        let is_definite = self.cholesky.insert(Cholesky::new(n)).factorise(buffer, n);
        let is_well = |(k, d): (usize, &f64)| buffer[k * n + k].powi(2) > WELL_CONDITIONED * d;
        if !is_definite || !diagonal.iter().enumerate().all(is_well) {
            self.is_refused = true;
            return false;
        }
        self.matrix.resize(n * n, 0.0);
        // No more than half of the points are left out.
        self.factor.resize((n / 2).pow(2), 0.0);
        self.answer.resize(n, 0.0);
        for list in [&mut self.held, &mut self.factored] {
            list.reserve(n);
        }
        self.displacements.reserve(n);
        let mut memory = MemBuffer::new(llt::inverse::inverse_scratch::<f64>(n, Par::Seq));
        let factor = MatRef::from_column_major_slice(buffer, n, n);
        let mut out = MatMut::from_column_major_slice_mut(&mut self.matrix, n, n);
        llt::inverse::inverse(out.as_mut(), factor, Par::Seq, MemStack::new(&mut memory));
        for j in 0..n {
            for i in j + 1..n {
                self.matrix[i * n + j] = self.matrix[j * n + i];
            }
        }
        true
    }

    /// Forces `x` of the points that `is_active` marks with `(A_aa + D_aa) x_a = rhs_a`, in the order of the points: passes
    /// each with its number to `found`. What the other points of `u` are displaced by, `A_ra x_a`, can be asked for
    /// afterwards. Returns whether `P_rr` was factorised; none if it is singular.
    pub fn solve(
        &mut self,
        is_active: &[bool],
        rhs: impl Fn(usize) -> f64,
        mut found: impl FnMut(usize, f64),
    ) -> Option<bool> {
        let alone = |i: usize| Held { forces: [(i, 1.0), (i, 0.0)], compliance: 0.0 };
        let held = |i: usize| (!is_active[i]).then(|| alone(i));
        let of_active = |i: usize, force: f64| {
            if is_active[i] {
                found(i, force)
            }
        };
        self.solve_with(held, |i| if is_active[i] { rhs(i) } else { 0.0 }, of_active)
    }

    /// Passes every point of `u` with its force under the right-hand side `rhs`, while what `held` says of a point stays held, to
    /// `found`. Returns whether the matrix of what is held was factorised; none, and nothing passed, where that is singular or more
    /// than half as many as points of `u`.
    pub fn solve_with(
        &mut self,
        held: impl Fn(usize) -> Option<Held>,
        rhs: impl Fn(usize) -> f64,
        mut found: impl FnMut(usize, f64),
    ) -> Option<bool> {
        self.held.clear();
        let place = |(i, factor): (usize, f64)| (self.places[i], factor);
        let all = self.points.iter().filter_map(|&i| held(i));
        self.held.extend(all.map(|one| Held { forces: one.forces.map(place), ..one }));
        if 2 * self.held.len() > self.points.len() {
            return None;
        }
        let is_new = self.solve_held(rhs)?;
        self.points.iter().zip(&self.answer).for_each(|(&i, force)| found(i, *force));
        Some(is_new)
    }

    /// Leaves the forces of all points under `rhs` with what is held in `answer`, and what holds it in `displacements`. Returns whether
    /// the matrix of what is held was factorised; none if it is singular.
    fn solve_held(&mut self, rhs: impl Fn(usize) -> f64) -> Option<bool> {
        let (n, r) = (self.points.len(), self.held.len());
        let is_new = self.held != self.factored;
        if is_new {
            self.factorise()?;
            self.n_solved += 1;
        }
        self.answer.fill(0.0);
        let columns = self.matrix.chunks_exact(n).zip(&self.points).map(|(column, &i)| (column, rhs(i)));
        add_multiples(columns.filter(|(_, factor)| *factor != 0.0), &mut self.answer);
        self.displacements.clear();
        let answer = &self.answer;
        let left = |one: &Held| -one.forces.iter().map(|(k, factor)| factor * answer[*k]).sum::<f64>();
        self.displacements.extend(self.held.iter().map(left));
        if r > 0 {
            self.cholesky.as_mut()?.solve(&self.factor, &mut self.displacements);
            let held = self.held.iter().zip(&self.displacements);
            let loads = held.flat_map(|(one, v)| one.forces.map(|(k, factor)| (k, factor * v)));
            let columns = loads.filter(|(_, load)| *load != 0.0);
            add_multiples(
                columns.map(|(k, load)| (&self.matrix[k * n..(k + 1) * n], load)),
                &mut self.answer,
            );
        }
        Some(is_new)
    }

    /// Displacement of the point `i` outside the set of the last solution; none if it is not in `u`.
    pub fn displacement(&self, i: usize) -> Option<f64> {
        let place = self.places.get(i).filter(|place| **place != usize::MAX)?;
        let found = self.held.binary_search_by_key(place, |one| one.forces[0].0);
        found.ok().map(|k| self.displacements[k])
    }

    /// Cholesky factor of the matrix of what is held: `P_rr` of points.
    fn factorise(&mut self) -> Option<()> {
        let (n, r) = (self.points.len(), self.held.len());
        self.factored.clear();
        if r > 0 {
            let factor = &mut self.factor[..r * r];
            for (place, (column, of)) in factor.chunks_exact_mut(r).zip(&self.held).enumerate() {
                for (entry, to) in column[place..].iter_mut().zip(&self.held[place..]) {
                    *entry = 0.0;
                    for (j, x) in of.forces {
                        let row = &self.matrix[j * n..(j + 1) * n];
                        *entry +=
                            x * (to.forces[0].1 * row[to.forces[0].0] + to.forces[1].1 * row[to.forces[1].0]);
                    }
                }
                column[place] += of.compliance;
            }
            self.cholesky.as_mut()?.factorise(factor, r).then_some(())?;
        }
        self.factored.extend_from_slice(&self.held);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix next to a singular one has no inverse, and is not tried again until other points come.
    #[test]
    fn ill_conditioned_sets_are_refused() {
        let (n, mut inverse) = (LARGE, SetInverse::default());
        let members: Vec<usize> = (0..n).collect();
        let matrix = |i: usize, j: usize| 1.0 + if i == j { 1e-9 } else { 0.0 };
        (0..WORTH).for_each(|_| inverse.note(&members, n + 1));
        assert!(inverse.serves(&members) && !inverse.make(matrix, &mut vec![0.0; n * n]));
        inverse.invalidate();
        (0..WORTH).for_each(|_| inverse.note(&members, n + 1));
        assert!(!inverse.serves(&members));
        inverse.note(&(0..=n).collect::<Vec<_>>(), n + 1);
        (1..WORTH).for_each(|_| inverse.note(&members, n + 1));
        assert!(inverse.serves(&members));
    }
}
