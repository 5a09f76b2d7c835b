//! Factors on the resolution of a scenario.

use adaptive::spec::{BodyFactors, ContactFactors};

/// Factors on modes, meshes, contact zones, integration and penalty factors.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolution {
    /// One entry a body, in the order of the scenario.
    pub bodies: Vec<BodyFactors>,
    /// One entry a contact, in the order of the scenario.
    pub contacts: Vec<ContactFactors>,
    /// Factor on the permitted error of a step.
    pub tolerance: f64,
}
