//! The solution between the two ends of a step.

/// A step's continuous extension.
pub trait DenseOutput {
    /// Start and end of the last accepted step \[s\]; equal before the first one.
    fn interval(&self) -> (f64, f64);

    /// Number of equations.
    fn dimension(&self) -> usize;

    /// Writes the state at time `t` into `out`.
    ///
    /// Times outside [`DenseOutput::interval`] extrapolate, with an accuracy that is lost quickly.
    ///
    /// # Panics
    /// If `out` is not as long as the state.
    fn interpolate(&self, t: f64, out: &mut [f64]);
}
