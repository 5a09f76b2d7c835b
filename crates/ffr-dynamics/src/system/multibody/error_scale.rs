//! Size of a local error: in energy, not in components (docs/theory.md Eq. T.7, T.8).
//!
//! An error of the state is turned into a velocity: the root mean square, over the body's mass, of
//! the velocity error that carries the error's energy. It is compared with a velocity of the motion
//! itself. Modes count by their energy, so that a high mode whose amplitude of 1e-9 rings does not
//! decide the step, and no amplitude needs an absolute tolerance of its own. What starts from rest
//! is measured against the velocity floor.

use crate::data_error::DataError;
use crate::error::DynamicsError;

/// Tolerances of the error norm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorScale {
    /// Permitted error a step, as a share of the motion's velocity.
    pub relative: f64,
    /// Motion slower than this is resolved as if it were this fast, > 0 [m/s].
    pub velocity_floor: f64,
}

impl Default for ErrorScale {
    fn default() -> Self {
        Self { relative: 1e-8, velocity_floor: 1e-6 }
    }
}

impl ErrorScale {
    /// The tolerances themselves.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if one is not positive.
    pub(super) fn checked(self) -> Result<Self, DynamicsError> {
        let is_positive = |x: f64| x > 0.0 && x.is_finite();
        if is_positive(self.relative) && is_positive(self.velocity_floor) {
            return Ok(self);
        }
        let (what, value) = if is_positive(self.relative) {
            ("the velocity floor [m/s]", self.velocity_floor)
        } else {
            ("the tolerance", self.relative)
        };
        Err(DataError::OutOfRange { what: what.into(), value, range: "> 0 and finite" }.into())
    }
}
