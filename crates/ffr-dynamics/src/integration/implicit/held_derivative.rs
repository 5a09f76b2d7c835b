//! The derivative of a right-hand side that an implicit method holds over several steps, and when
//! it is formed anew.

use super::jacobian::{Differences, Structure};
use crate::error::DynamicsError;
use crate::integration::linearisation::Linearisation;
use crate::integration::stepping::{Failure, Stepping};
use crate::integration::system::OdeSystem;

/// Derivative at the start of some step.
#[derive(Debug)]
pub(super) struct HeldDerivative {
    pub structure: Structure,
    pub derivative: Linearisation,
    differences: Differences,
    /// Whether it may be used in the next step.
    is_valid: bool,
    /// Whether it was formed at the start of the present step.
    is_fresh: bool,
}

impl HeldDerivative {
    /// None yet, of `system`.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the system's kinematics do not fit the state.
    pub fn new<S: OdeSystem + ?Sized>(system: &S) -> Result<Self, DynamicsError> {
        let structure = Structure::of(system)?;
        Ok(Self {
            derivative: Linearisation::new(structure.unknowns.len()),
            differences: Differences::new(system.dimension()),
            structure,
            is_valid: false,
            is_fresh: false,
        })
    }

    /// Forms it at the start of the step if the one at hand does not serve; returns whether it is
    /// another one.
    pub fn renew<S: OdeSystem + ?Sized>(&mut self, stepping: &mut Stepping, system: &mut S) -> bool {
        if self.is_valid {
            return false;
        }
        let at = (stepping.t, stepping.y.as_slice());
        let Self { differences, structure, derivative, .. } = self;
        differences.linearise(system, structure, at, derivative, &mut stepping.statistics);
        (self.is_valid, self.is_fresh) = (true, true);
        true
    }

    /// Ends a step; `is_kept`: the derivative serves the next one as well.
    pub fn end_step(&mut self, is_kept: bool) {
        (self.is_valid, self.is_fresh) = (is_kept, false);
    }

    /// Whether a derivative of its own may help the step that ended in `failure`; it is then formed
    /// in the next attempt.
    pub fn renews_for(&mut self, failure: &Failure) -> bool {
        let is_stale = failure.may_be_of_the_derivative() && !self.is_fresh;
        if is_stale {
            self.is_valid = false;
        }
        is_stale
    }

    /// Forgets it.
    pub fn invalidate(&mut self) {
        (self.is_valid, self.is_fresh) = (false, false);
    }
}
