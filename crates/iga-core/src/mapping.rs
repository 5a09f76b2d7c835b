//! From parameters to space: Jacobians and physical gradients.
