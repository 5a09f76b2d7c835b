//! Stress that was asked for.

/// Stress along a line at one instant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StressRecord {
    /// Name of the request in the scenario.
    pub name: String,
    /// Instant \[s\].
    pub time: f64,
    /// Undeformed points in the body's frame \[m\].
    pub points: Vec<[f64; 3]>,
    /// Stress components per point: xx yy zz xy yz zx, or rr zz θθ rz 0 0 for axisymmetric models
    /// \[Pa\].
    pub stress: Vec<[f64; 6]>,
    /// Von Mises stress per point \[Pa\].
    pub von_mises: Vec<f64>,
}
