//! Integrators: a one-step method, and where it stands.

use super::dense_output::DenseOutput;
use super::dormand_prince::{self, DormandPrince};
use super::implicit::esdirk::{self, Esdirk};
use super::implicit::gauss::{self, Gauss};
use super::implicit::tableau::{ESDIRK4, TR_BDF2};
use super::one_step::{OneStepMethod, advance};
use super::step_control::{Statistics, StepSettings};
use super::stepping::{Step, Stepping};
use super::system::OdeSystem;
use crate::error::{DynamicsError, EvaluationFailure};

/// Integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Dormand-Prince 5(4): explicit, order five (docs/theory.md Eq. T.1 to T.5), free vibrations
    /// being exact (T.9 to T.12).
    #[default]
    DormandPrince,
    /// TR-BDF2: implicit, L-stable, order two (Eq. T.13 to T.16).
    TrBdf2,
    /// ESDIRK4(3)6L\[2\]SA: implicit, L-stable, order four (Eq. T.18, T.19).
    Esdirk4,
    /// Gauss collocation with four stages: implicit, symmetric, order eight (Eq. T.26 to T.31).
    Gauss,
}

impl Method {
    /// Whether it damps what it does not resolve.
    pub fn is_dissipative(self) -> bool {
        match self {
            Self::TrBdf2 | Self::Esdirk4 => true,
            Self::DormandPrince | Self::Gauss => false,
        }
    }

    /// Error allowed in a step, as a share of the motion's velocity, unless another is wanted: with
    /// the explicit method one at which its energy drift cannot be seen, with the implicit ones
    /// more. Gauss collocation keeps the energy by itself; low orders need many steps for less.
    pub fn default_tolerance(self) -> f64 {
        match self {
            Self::DormandPrince => 1e-8,
            Self::TrBdf2 | Self::Esdirk4 | Self::Gauss => 1e-5,
        }
    }
}

/// An integration of a system: state and statistics of a one-step method.
#[derive(Debug)]
pub struct Integrator {
    method: Method,
    stepping: Stepping,
    stages: Stages,
}

/// What the methods need for a step.
#[derive(Debug)]
enum Stages {
    DormandPrince(Box<DormandPrince>),
    Esdirk(Box<Esdirk>),
    Gauss(Box<Gauss>),
}

macro_rules! each {
    ($stages:expr, $inner:ident => $call:expr) => {
        match $stages {
            Stages::DormandPrince($inner) => $call,
            Stages::Esdirk($inner) => $call,
            Stages::Gauss($inner) => $call,
        }
    };
}

impl Integrator {
    /// An integrator of `system` with `method` at time `t` in the state `y`.
    ///
    /// It keeps the system's [`OdeSystem::kinematics`]; all steps must be taken with that system.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if a step of the settings is not positive or the system's kinematics do not fit.
    ///
    /// # Panics
    /// If the length of `y` differs from the system's dimension.
    pub fn new<S: OdeSystem + ?Sized>(
        method: Method,
        settings: StepSettings,
        t: f64,
        y: &[f64],
        system: &S,
    ) -> Result<Self, DynamicsError> {
        assert_eq!(system.dimension(), y.len(), "the state has the system's number of equations");
        let (stages, order, remedy) = match method {
            Method::DormandPrince => {
                let mut explicit = Self::explicit(settings, t, y)?;
                if let (Stages::DormandPrince(stages), true) =
                    (&mut explicit.stages, settings.is_vibration_exact)
                {
                    stages.make_room(system.oscillators());
                }
                return Ok(explicit);
            }
            Method::TrBdf2 | Method::Esdirk4 => {
                let tableau = if method == Method::TrBdf2 { &TR_BDF2 } else { &ESDIRK4 };
                let stages = Stages::Esdirk(Box::new(Esdirk::new(tableau, system)?));
                (stages, tableau.order, esdirk::REMEDY)
            }
            Method::Gauss => (Stages::Gauss(Box::new(Gauss::new(system)?)), gauss::ORDER, gauss::REMEDY),
        };
        Ok(Self { method, stepping: Stepping::new(settings, order, remedy, t, y)?, stages })
    }

    /// An integrator with [`Method::DormandPrince`], which needs to know nothing of its system
    /// before the first step.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if a step of the settings is not positive.
    pub fn explicit(settings: StepSettings, t: f64, y: &[f64]) -> Result<Self, DynamicsError> {
        Ok(Self {
            method: Method::DormandPrince,
            stepping: Stepping::new(settings, dormand_prince::ORDER, dormand_prince::REMEDY, t, y)?,
            stages: Stages::DormandPrince(Box::new(DormandPrince::new(y.len()))),
        })
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Time reached \[s\].
    pub fn time(&self) -> f64 {
        self.stepping.t
    }

    /// State reached.
    pub fn state(&self) -> &[f64] {
        &self.stepping.y
    }

    /// State before the last accepted step (at the start of [`DenseOutput::interval`]).
    pub fn previous_state(&self) -> &[f64] {
        &self.stepping.previous
    }

    /// Work done since the integrator was made; restarts do not reset it.
    pub fn statistics(&self) -> Statistics {
        self.stepping.statistics
    }

    /// Last refusal of the right-hand side, in whatever step; `None` if there never was one.
    pub fn last_refusal(&self) -> Option<&EvaluationFailure> {
        self.stepping.last_refusal.as_ref()
    }

    /// Step proposed next, 0 if none is known yet \[s\].
    pub fn proposed_step(&self) -> f64 {
        self.stepping.h
    }

    /// Changes the largest step, for instance at the start of an impact \[s\].
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if it is not positive.
    pub fn set_max_step(&mut self, max_step: f64) -> Result<(), DynamicsError> {
        self.stepping.set_max_step(max_step)
    }

    /// Whether critical errors of the right-hand side end a step; see
    /// [`StepSettings::stops_at_errors`].
    pub fn stop_at_errors(&mut self, stops: bool) {
        self.stepping.settings.stops_at_errors = stops;
    }

    /// Says that the right-hand side has changed at the present time (a force switched on, another
    /// penalty).
    pub fn invalidate(&mut self) {
        self.stepping.is_rate_valid = false;
        each!(&mut self.stages, s => s.invalidate());
    }

    /// Goes on from another time and state with the step size proposed so far.
    ///
    /// The dense output of the last step is lost. The system's inner state is not touched: to go
    /// back into the last step, call [`OdeSystem::restore`] as well, which takes it to the step's
    /// start. For a state of another size make a new integrator.
    ///
    /// # Panics
    /// If the length of `y` differs from the dimension.
    pub fn restart(&mut self, t: f64, y: &[f64]) {
        self.stepping.restart(t, y);
        self.invalidate();
    }

    /// Takes one step that ends at `t_end` at the latest, and exactly there if it comes near.
    ///
    /// [`OdeSystem::save`] is called before the first attempt, [`OdeSystem::restore`] after each failed one and after differences
    /// of the right-hand side. After the step the inner state of a system with memory belongs to
    /// the step's end. At `t_end` already, nothing happens.
    ///
    /// # Errors
    /// [`DynamicsError::Integration`] when the step has shrunk until it no longer moves the clock, or the state is not
    /// finite, or the right-hand side refuses the state reached. The integrator stays at the last
    /// accepted state.
    ///
    /// # Panics
    /// If the system has another number of equations than the integrator.
    pub fn step<S: OdeSystem + ?Sized>(&mut self, system: &mut S, t_end: f64) -> Result<Step, DynamicsError> {
        each!(&mut self.stages, s => advance(&mut **s, &mut self.stepping, system, t_end))
    }

    /// Steps until `t_end`, calling `observe` after each accepted step, which answers whether to go
    /// on; returns the time reached.
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
        self.stepping.interval
    }

    fn dimension(&self) -> usize {
        self.stepping.y.len()
    }

    fn interpolate(&self, t: f64, out: &mut [f64]) {
        assert_eq!(out.len(), self.stepping.y.len(), "the output is as long as the state");
        let (start, end) = self.stepping.interval;
        if end <= start {
            out.copy_from_slice(&self.stepping.y);
            return;
        }
        each!(&self.stages, s => s.interpolate(&self.stepping.previous, (t - start) / (end - start), out));
    }
}
