//! When simplified Newton iterations end (Hairer & Wanner, *Solving Ordinary Differential Equations
//! II*, IV.8).

use crate::integration::stepping::Failure;

/// Error that the iterations may leave, as a share of the error permitted in a step (same source).
const TOLERANCE: f64 = 0.03;
/// Iterations after which the step counts as failed (same source).
pub(super) const MAX_ITERATIONS: u32 = 7;
/// Convergence rate above which the next step begins with a new derivative.
const SLOW_RATE: f64 = 0.2;

/// The convergence rate that the last iterations have shown.
#[derive(Debug, Clone, Copy)]
pub(super) struct Convergence {
    /// Factor from the last correction to the error left.
    error_factor: f64,
    /// Slowest convergence rate in the present step.
    rate: f64,
}

/// Iterations of one nonlinear system.
#[derive(Debug, Clone, Copy)]
pub(super) struct Iterations {
    count: u32,
    previous: f64,
    error_factor: f64,
}

impl Convergence {
    pub fn new() -> Self {
        Self { error_factor: 1.0, rate: 0.0 }
    }

    /// Begins a step.
    pub fn begin_step(&mut self) {
        self.rate = 0.0;
    }

    /// Begins the iterations of a system.
    pub fn begin(&self) -> Iterations {
        // Before its first iterations the last system's convergence is the best guess.
        let error_factor = self.error_factor.max(f64::EPSILON).powf(0.8);
        Iterations { count: 0, previous: 0.0, error_factor }
    }

    /// Whether the iterations are over after a correction of norm `size`.
    ///
    /// # Errors
    /// [`Failure`] if they do not converge, or the norm is not finite.
    pub fn is_reached(&mut self, iterations: &mut Iterations, size: f64) -> Result<bool, Failure> {
        if !size.is_finite() {
            return Err(Failure::NotFinite);
        }
        iterations.count += 1;
        let count = iterations.count;
        if count > 1 {
            let rate = size / iterations.previous;
            self.rate = self.rate.max(rate);
            let left = (MAX_ITERATIONS - count) as i32;
            let is_hopeless = rate >= 1.0 || size * rate.powi(left) / (1.0 - rate) > TOLERANCE;
            if is_hopeless && size > TOLERANCE {
                return Err(Failure::Diverged { iterations: count, rate });
            }
            iterations.error_factor = if rate < 1.0 { rate / (1.0 - rate) } else { 1.0 };
        }
        iterations.previous = size;
        if iterations.error_factor * size <= TOLERANCE {
            self.error_factor = iterations.error_factor;
            return Ok(true);
        }
        if count == MAX_ITERATIONS {
            return Err(Failure::Diverged { iterations: count, rate: self.rate });
        }
        Ok(false)
    }

    /// Whether the derivative serves the next step as well.
    pub fn keeps_derivative(&self) -> bool {
        self.rate <= SLOW_RATE
    }
}
