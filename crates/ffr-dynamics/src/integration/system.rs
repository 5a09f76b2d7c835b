//! What an integrator asks of a system of differential equations.

use crate::error::Rejection;

/// A first-order system `dy/dt = f(t, y)` with its own error norm and an inner state that can be saved and restored.
pub trait OdeSystem {
    /// Number of equations.
    fn dimension(&self) -> usize;

    /// Right-hand side. Must not allocate.
    ///
    /// # Errors
    /// [`Rejection`] where `f` cannot be evaluated; the step is then repeated with a smaller size.
    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), Rejection>;

    /// Scaled size of a local error `error` between the states `y0` and `y1`; a step is accepted when it is at most 1.
    fn error_norm(&self, y0: &[f64], y1: &[f64], error: &[f64]) -> f64;

    /// Restores invariants of the state reached at `t` after an accepted step (unit quaternions, closed loops); returns
    /// whether it changed `y`.
    fn project(&mut self, _t: f64, _y: &mut [f64]) -> bool {
        false
    }

    /// Remembers the inner state (contact solver) before a step.
    fn save(&mut self) {}

    /// Returns to the remembered inner state after a rejected step.
    fn restore(&mut self) {}
}
