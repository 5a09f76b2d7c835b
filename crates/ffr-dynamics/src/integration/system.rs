//! What an integrator asks of a system of differential equations.

use faer::c64;

use super::linearisation::{KinematicBlock, Linearisation};
use super::oscillator::Oscillators;
use crate::error::EvaluationFailure;

/// A first-order system `dy/dt = f(t, y)` with its own error norm and an inner state that can be
/// saved and restored.
pub trait OdeSystem {
    /// Number of equations.
    fn dimension(&self) -> usize;

    /// Right-hand side. Must not allocate.
    ///
    /// # Errors
    /// [`EvaluationFailure`] where `f` cannot be evaluated; the step is then repeated with a smaller size.
    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), EvaluationFailure>;

    /// Scaled size of a local error `error` between the states `y0` and `y1`; a step is accepted
    /// when it is at most 1.
    fn error_norm(&mut self, y0: &[f64], y1: &[f64], error: &[f64]) -> f64;

    /// Restores invariants of the state reached at `t` after an accepted step (unit quaternions,
    /// closed loops); returns whether it changed `y`.
    fn project(&mut self, _t: f64, _y: &mut [f64]) -> bool {
        false
    }

    /// Adds to the quadratures of `y`, the state reached by a step that is about to be accepted and
    /// that was evaluated last, what they gain at its end, and changes its `rate` to that at the
    /// start of the next step.
    fn finish_quadratures(&mut self, _y: &mut [f64], _rate: &mut [f64]) {}

    /// The next time after `t` at which the right-hand side is not smooth in time; steps end there.
    fn next_break(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// Longest step from time `t` that resolves what is given over time \[s\]; error estimates from
    /// derivatives of the motion are blind to it.
    fn longest_step(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// The share of a step of size `h` from time `t` and the state `y0` to `y1` after which the right-hand side
    /// has another form (a stop is reached); `None` if it keeps its form. The step is repeated to
    /// end just behind that.
    fn change_of_form(&self, _t: f64, _y0: &[f64], _y1: &[f64], _h: f64) -> Option<f64> {
        None
    }

    /// Remembers the inner state (contact solver) before a step.
    fn save(&mut self) {}

    /// Returns to the remembered inner state after a rejected step.
    fn restore(&mut self) {}

    /// Whether evaluations leave traces (contact solvers). Implicit methods then end a step with an
    /// evaluation at its end.
    fn has_memory(&self) -> bool {
        false
    }

    /// [`OdeSystem::error_norm`] for implicit methods, which damp what they don't resolve and may count it for less.
    fn damped_error_norm(&mut self, y0: &[f64], y1: &[f64], error: &[f64]) -> f64 {
        self.error_norm(y0, y1, error)
    }

    /// Components whose free vibration is known; asked at the start of each step. Explicit methods
    /// need not resolve it then.
    ///
    /// What the right-hand side has besides is a perturbation, whose size and pace decide the step.
    fn oscillators(&self) -> Oscillators<'_> {
        Oscillators::default()
    }

    /// Sets `forces`, one per oscillator, to what given forces supply at time `t` in the state `y`
    /// per velocity of the oscillator \[W/(1/s)\]; returns the place in the state of the quadrature
    /// of the power supplied, none if nothing acts on oscillators. Asked at both ends of a step.
    /// Must not allocate.
    fn supply(&mut self, _t: f64, _y: &[f64], _forces: &mut [f64]) -> Option<usize> {
        None
    }

    /// What the state's components are to each other; empty if unknown. Components in no block are
    /// quadratures.
    ///
    /// Implicit methods ask once, when they are made. With the blocks known they solve for
    /// velocities alone.
    fn kinematics(&self) -> Vec<KinematicBlock> {
        Vec::new()
    }

    /// Fills those columns of the derivative that are known better or cheaper than by differences
    /// of the right-hand side.
    ///
    /// A column is complete or left alone. Approximations cost Newton iterations, not accuracy.
    /// Must not allocate.
    ///
    /// # Errors
    /// [`EvaluationFailure`] where the derivative does not exist; all columns are then found by differences.
    fn linearise(
        &mut self,
        _t: f64,
        _y: &[f64],
        _derivative: &mut Linearisation,
    ) -> Result<(), EvaluationFailure> {
        Ok(())
    }

    /// Holds what the right-hand side is near the state evaluated last, for
    /// [`OdeSystem::solve_held`]; returns whether that is known. Must not allocate.
    fn hold(&mut self) -> bool {
        false
    }

    /// Factorises `1 - w A_v - w² A_s` of the state held, for `w` the weight `weight` of pair
    /// `pair` of stages; returns whether that is possible. `A_s` and `A_v` are the derivatives of
    /// the rates of all unknowns of [`OdeSystem::linearise`] with positions and unknowns.
    /// Approximations cost iterations, not accuracy. Must not allocate.
    fn factorise_held(&mut self, _pair: usize, _weight: c64) -> bool {
        false
    }

    /// Replaces `x` by the solution of `(1 - w A_v - w² A_s) x' = x + scale A_s motion` with the
    /// factors of pair `pair`. Must not allocate.
    fn solve_held(&mut self, _pair: usize, _x: &mut [c64], _scale: c64, _motion: &[f64]) {}
}
