//! One type for all integrators, so that a driver can hold whichever the scenario asks for.

use super::dense_output::DenseOutput;
use super::dormand_prince::DormandPrince;
use super::esdirk::Esdirk;
use super::step_control::{Statistics, StepSettings};
use super::stepping::Step;
use super::system::OdeSystem;
use crate::error::{DynamicsError, EvaluationFailure};

/// Integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Explicit, order five ([`DormandPrince`]).
    #[default]
    DormandPrince,
    /// Implicit, L-stable, order two ([`Esdirk::tr_bdf2`]).
    TrBdf2,
    /// Implicit, L-stable, order four ([`Esdirk::of_order_four`]).
    Esdirk4,
}

impl Method {
    /// Whether it is implicit, and damps what it does not resolve.
    pub fn is_implicit(self) -> bool {
        self != Self::DormandPrince
    }

    /// Error allowed in a step, as a share of the motion's velocity, unless another is wanted: with the explicit method one at which
    /// its energy drift cannot be seen, with the implicit ones more, for low orders need many steps for less.
    pub fn default_tolerance(self) -> f64 {
        if self.is_implicit() { 1e-5 } else { 1e-8 }
    }
}

/// An integrator of either kind; all calls mean the same for both.
#[derive(Debug)]
pub enum Integrator {
    /// Explicit.
    DormandPrince(Box<DormandPrince>),
    /// Implicit.
    Esdirk(Box<Esdirk>),
}

macro_rules! either {
    ($integrator:expr, $inner:ident => $call:expr) => {
        match $integrator {
            Integrator::DormandPrince($inner) => $call,
            Integrator::Esdirk($inner) => $call,
        }
    };
}

impl Integrator {
    /// An integrator of `system` with `method` at time `t` in the state `y`.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if a step of the settings is not positive or the system's kinematics do not fit.
    pub fn new<S: OdeSystem + ?Sized>(
        method: Method,
        settings: StepSettings,
        t: f64,
        y: &[f64],
        system: &S,
    ) -> Result<Self, DynamicsError> {
        Ok(match method {
            Method::DormandPrince => {
                let mut explicit = DormandPrince::new(settings, t, y)?;
                explicit.make_room(system.oscillators());
                Self::DormandPrince(Box::new(explicit))
            }
            Method::TrBdf2 => Self::Esdirk(Box::new(Esdirk::tr_bdf2(settings, t, y, system)?)),
            Method::Esdirk4 => Self::Esdirk(Box::new(Esdirk::of_order_four(settings, t, y, system)?)),
        })
    }

    /// The method.
    pub fn method(&self) -> Method {
        match self {
            Self::DormandPrince(_) => Method::DormandPrince,
            Self::Esdirk(i) if i.is_tr_bdf2() => Method::TrBdf2,
            Self::Esdirk(_) => Method::Esdirk4,
        }
    }

    /// Time reached \[s\].
    pub fn time(&self) -> f64 {
        either!(self, i => i.time())
    }

    /// State reached.
    pub fn state(&self) -> &[f64] {
        either!(self, i => i.state())
    }

    /// State before the last accepted step.
    pub fn previous_state(&self) -> &[f64] {
        either!(self, i => i.previous_state())
    }

    /// Work done since the integrator was made.
    pub fn statistics(&self) -> Statistics {
        either!(self, i => i.statistics())
    }

    /// Last refusal of the right-hand side; `None` if there never was one.
    pub fn last_refusal(&self) -> Option<&EvaluationFailure> {
        either!(self, i => i.last_refusal())
    }

    /// Step proposed next, 0 if none is known yet \[s\].
    pub fn proposed_step(&self) -> f64 {
        either!(self, i => i.proposed_step())
    }

    /// Changes the largest step \[s\].
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if it is not positive.
    pub fn set_max_step(&mut self, max_step: f64) -> Result<(), DynamicsError> {
        either!(self, i => i.set_max_step(max_step))
    }

    /// Whether critical errors of the right-hand side end a step; see [`StepSettings::stops_at_errors`].
    pub fn stop_at_errors(&mut self, stops: bool) {
        either!(self, i => i.stop_at_errors(stops));
    }

    /// Says that the right-hand side has changed at the present time.
    pub fn invalidate(&mut self) {
        either!(self, i => i.invalidate());
    }

    /// Goes on from another time and state; see [`DormandPrince::restart`].
    ///
    /// # Panics
    /// If the length of `y` differs from the dimension.
    pub fn restart(&mut self, t: f64, y: &[f64]) {
        either!(self, i => i.restart(t, y));
    }

    /// Takes one step that ends at `t_end` at the latest; see [`DormandPrince::step`] and [`Esdirk::step`].
    ///
    /// # Errors
    /// [`DynamicsError::Integration`] when no step is possible.
    ///
    /// # Panics
    /// If the system has another number of equations than the integrator.
    pub fn step<S: OdeSystem + ?Sized>(&mut self, system: &mut S, t_end: f64) -> Result<Step, DynamicsError> {
        either!(self, i => i.step(system, t_end))
    }

    /// Steps until `t_end`, calling `observe` after each accepted step, which answers whether to go on; returns the time reached.
    ///
    /// # Errors
    /// As [`Integrator::step`].
    pub fn run<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_end: f64,
        mut observe: impl FnMut(&mut S, &Self) -> bool,
    ) -> Result<f64, DynamicsError> {
        while self.time() < t_end {
            self.step(system, t_end)?;
            if !observe(system, self) {
                break;
            }
        }
        Ok(self.time())
    }
}

impl DenseOutput for Integrator {
    fn interval(&self) -> (f64, f64) {
        either!(self, i => i.interval())
    }

    fn dimension(&self) -> usize {
        either!(self, i => i.dimension())
    }

    fn interpolate(&self, t: f64, out: &mut [f64]) {
        either!(self, i => i.interpolate(t, out));
    }
}
