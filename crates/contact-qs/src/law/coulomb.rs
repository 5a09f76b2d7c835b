//! Coulomb's law of friction with a regularised stick.
//!
//! `|τ| <= μ λ`; a point sticks, held by a tangential penalty spring, or slides against its
//! friction force (docs/theory.md Eqs. F.1 to F.3; \[B\] section 7).

use crate::ContactError;

/// Friction of a pair of surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Coefficient `μ`, the same for stick and slip.
    pub coefficient: f64,
    /// Tangential penalty factor as a share of the normal one. With the exact normal constraint the
    /// stick is exact too.
    pub stiffness_ratio: f64,
}

impl Friction {
    /// Friction with coefficient `coefficient` and a tangential penalty factor equal to the normal
    /// one.
    pub fn new(coefficient: f64) -> Self {
        Self { coefficient, stiffness_ratio: 1.0 }
    }

    /// Checks the values.
    ///
    /// # Errors
    /// [`ContactError::Friction`] if the coefficient is negative or the ratio not positive, or one is not finite.
    pub fn check(&self) -> Result<(), ContactError> {
        let Self { coefficient, stiffness_ratio } = *self;
        if coefficient >= 0.0
            && coefficient.is_finite()
            && stiffness_ratio > 0.0
            && stiffness_ratio.is_finite()
        {
            Ok(())
        } else {
            Err(ContactError::Friction { coefficient, stiffness_ratio })
        }
    }
}
