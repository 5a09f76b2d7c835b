//! Steps from one inverse for all components, where sets are large and change by few points (docs/theory.md Eq. F.36).

use super::{PointState, Tangential, TangentialProblem, pair};
use crate::quasistatic::inverse::Held;

impl Tangential {
    /// Amplitudes of the free directions that cancel `residual`, in `solution`, from the inverse for all components of the loaded
    /// points: what is not free is held (Eq. F.36). False where that does not pay.
    pub(super) fn solve_by_inverse(&mut self, problem: &TangentialProblem<'_>, residual: &[f64]) -> bool {
        let n_t = self.n_t;
        let loaded = self.states.iter().enumerate().filter(|(_, state)| **state != PointState::Open);
        self.components.clear();
        self.components.extend(loaded.flat_map(|(i, _)| n_t * i..n_t * (i + 1)));
        if !self.inverse.serves(&self.components) {
            self.inverse.note(&self.components, n_t * self.states.len());
            return false;
        }
        let spring = |k: usize, l: usize| if k == l { problem.springs[k / n_t] } else { 0.0 };
        // The factor gives its place to that of all components.
        self.factored.clear();
        if !self.inverse.make(|k, l| problem.compliance.entry(k, l) + spring(k, l), &mut self.factor) {
            return false;
        }
        let Self { inverse, states, directions, stretches, answer, .. } = self;
        // The first component of a point stands for what is along the force, the second for what is across it.
        let held = |k: usize| {
            let (i, is_across) = (k / n_t, k % n_t == 1);
            let ([x, y], first) = (directions[i], n_t * i);
            let [a, b] = if is_across { [-y, x] } else { [x, y] };
            let compliance = match states[i] {
                PointState::Open => 0.0,
                PointState::Stick => return None,
                PointState::Slip if !is_across => 0.0,
                PointState::Slip if stretches[i] > 0.0 => 1.0 / stretches[i],
                PointState::Slip => return None,
            };
            let second = if n_t == 2 { (first + 1, b) } else { (first, 0.0) };
            Some(Held { forces: [(first, a), second], compliance })
        };
        let is_loaded = |k: usize| states[k / n_t] != PointState::Open;
        let rhs = |k: usize| if is_loaded(k) { -residual[k] } else { 0.0 };
        if inverse.solve_with(held, rhs, |k, force| answer[k] = force).is_none() {
            return false;
        }
        for (x, free) in self.solution.iter_mut().zip(&self.free) {
            let force = pair(&self.answer, free.point, n_t);
            *x = force[0] * free.direction[0] + force[1] * free.direction[1];
        }
        true
    }
}
