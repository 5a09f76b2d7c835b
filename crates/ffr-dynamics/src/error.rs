//! What can go wrong in reduction and dynamics.

use std::fmt;

use thiserror::Error;

use crate::data_error::DataError;
use crate::joint_fault::JointFault;

/// Errors of reduction, equations of motion and time integration. Texts are fragments that read after "body ...: ".
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DynamicsError {
    /// A sparse factorisation met a pivot that is not positive.
    #[error("{matrix} is not positive definite: pivot {pivot} of {size} fails")]
    NotPositiveDefinite {
        /// Which matrix.
        matrix: &'static str,
        /// Index of the pivot.
        pivot: usize,
        /// Number of unknowns.
        size: usize,
    },
    /// The solver library refused the problem.
    #[error("factorisation of {matrix} failed: {reason}")]
    Factorisation {
        /// Which matrix.
        matrix: &'static str,
        /// The library's reason.
        reason: String,
    },
    /// A factor for which the machine has no memory.
    #[error(
        "the Cholesky factor of {unknowns} unknowns would take {gigabytes:.1} GB, {free:.1} GB are free; use fewer elements or a lower degree, in contact zones a smaller interval.elements"
    )]
    FactorTooLarge {
        /// Number of unknowns.
        unknowns: usize,
        /// Memory of the factor at least \[GB\].
        gigabytes: f64,
        /// Free memory \[GB\].
        free: f64,
    },
    /// More modes were asked for than the model has degrees of freedom.
    #[error("{wanted} modes asked for, the model has only {available}")]
    TooManyModes {
        /// Number asked for.
        wanted: usize,
        /// Number there is.
        available: usize,
    },
    /// The eigensolver did not reach its tolerance, or lost modes that the inertia count shows.
    #[error("eigensolver found {found} of {expected} modes below {frequency:.6e} Hz: {reason}")]
    Eigenmodes {
        /// Modes found.
        found: usize,
        /// Modes that the inertia count shows.
        expected: usize,
        /// The frequency up to which modes were counted \[Hz\].
        frequency: f64,
        /// What to do or what was seen.
        reason: String,
    },
    /// Input data do not fit together.
    #[error("model data do not fit: {0}")]
    Data(#[from] DataError),
    /// Two bodies, joints or markers of one body have the same name.
    #[error("two {what} are called \"{name}\", names must differ")]
    DuplicateName {
        /// What, in the plural.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A joint or load is attached to a body that there is not.
    #[error("\"{user}\" is attached to the unknown body \"{body}\", there are: {known}")]
    UnknownBody {
        /// Name of the joint or load.
        user: String,
        /// Name of the body looked for.
        body: String,
        /// The bodies there are.
        known: String,
    },
    /// A joint or load is attached to a marker that its body does not have.
    #[error("\"{user}\" is attached to the unknown marker \"{marker}\" of \"{body}\", which has: {known}")]
    UnknownMarker {
        /// Name of the joint or load.
        user: String,
        /// Name of the body.
        body: String,
        /// Name of the marker looked for.
        marker: String,
        /// The markers there are.
        known: String,
    },
    /// Joints of the tree lead around in a circle.
    #[error("joints form a cycle: {path}; turn a joint around or make one of them loop-closing")]
    JointCycle {
        /// Joints and bodies along the cycle.
        path: String,
    },
    /// A body is the child of two joints of the tree.
    #[error(
        "body \"{body}\" is over-constrained: it is the child of the joints \"{first}\" and \"{second}\"; make one of them loop-closing"
    )]
    OverConstrained {
        /// Name of the body.
        body: String,
        /// First joint.
        first: String,
        /// Second joint.
        second: String,
    },
    /// A joint that cannot be.
    #[error("joint \"{joint}\": {fault}")]
    Joint {
        /// Name of the joint.
        joint: String,
        /// Why.
        fault: Box<JointFault>,
    },
    /// A load on ground.
    #[error("load \"{load}\" acts on ground, name a body")]
    LoadOnGround {
        /// Name of the load.
        load: String,
    },
    /// A static start that does not exist or is not found.
    #[error("no static start: {0}")]
    StaticStart(StaticStartFault),
    /// The time integration cannot go on.
    #[error("integration stopped at t = {time:.9e} s: {fault}")]
    Integration {
        /// Time reached \[s\].
        time: f64,
        /// Why, with the numbers and what to change.
        fault: IntegrationFault,
    },
}

/// Why there is no static start.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StaticStartFault {
    /// Joints that the deformation would open.
    #[error("loop-closing joints would open")]
    LoopClosing,
    /// Forces that cannot be evaluated.
    #[error(transparent)]
    Refused(#[from] EvaluationFailure),
    /// Bodies so soft that the corrections do not converge.
    #[error("elastic coordinates do not converge in {corrections} corrections")]
    NotConverged {
        /// Number of corrections.
        corrections: usize,
    },
}

/// Why the time integration cannot go on.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum IntegrationFault {
    /// An end time that is no finite number.
    #[error("the end time is {end} s, must be finite")]
    EndTime {
        /// The end time \[s\].
        end: f64,
    },
    /// A state to start from that is not finite.
    #[error("component {component} of the starting state is not finite")]
    State {
        /// Number of the component, from 0.
        component: usize,
    },
    /// Rates at the start that are not finite.
    #[error("rate {component} of the starting state is not finite")]
    Rate {
        /// Number of the component, from 0.
        component: usize,
    },
    /// Forces that cannot be evaluated at the start.
    #[error("no forces at the starting state: {0}")]
    NoForces(EvaluationFailure),
    /// Forces that cannot be evaluated where no smaller step helps.
    #[error(transparent)]
    Refused(EvaluationFailure),
    /// A step that failed in a way that the settings do not answer with a smaller one.
    #[error("{0}")]
    Critical(Rejection),
    /// Steps that were rejected until they were too short.
    #[error("step fell to {step:.3e} s, last rejection: {rejection}; {remedy}")]
    StepTooShort {
        /// The next step that would have been tried \[s\].
        step: f64,
        /// Why the last one was rejected.
        rejection: Rejection,
        /// What to change.
        remedy: &'static str,
    },
    /// A function whose zero is looked for is no number.
    #[error("the watched function is not a number, check the state and its inputs")]
    WatchedFunction,
}

/// Why a step was rejected.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Rejection {
    /// Forces that cannot be evaluated on the way.
    #[error(transparent)]
    Refused(EvaluationFailure),
    /// Newton's method did not converge.
    #[error("Newton's method gave up after {iterations} iterations with convergence rate {rate:.3}")]
    Diverged {
        /// Number of iterations.
        iterations: u32,
        /// Rate of convergence seen last.
        rate: f64,
    },
    /// An iteration matrix that cannot be factorised.
    #[error("the iteration matrix is singular or not finite")]
    Singular,
    /// A solution that is not finite.
    #[error("the solution is not finite")]
    NotFinite,
    /// An error beyond the tolerance.
    #[error("error norm {norm:.3e}, limit 1")]
    Error {
        /// Norm of the error, 1 at the tolerance.
        norm: f64,
    },
}

/// What kept a right-hand side from being evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FailureKind {
    /// A matrix is singular, or not positive definite (code 1 of \[A\] Algorithm 1).
    Singular,
    /// A value is not finite (code 2 of \[A\] Algorithm 1).
    NotFinite,
    /// An iteration has not converged (code -1 of \[A\] Algorithm 1).
    IterationLimit,
    /// The bodies lie as the contact's model does not allow, for instance with axes apart.
    OutOfModel,
}

impl FailureKind {
    /// Whether \[A\] Algorithm 1 calls it a critical error (a positive code).
    pub fn is_critical(self) -> bool {
        matches!(self, Self::Singular | Self::NotFinite)
    }

    /// Whether softer contacts may mend it.
    pub fn may_depend_on_penalty(self) -> bool {
        self != Self::OutOfModel
    }
}

impl fmt::Display for FailureKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Singular => "singular matrix",
            Self::NotFinite => "value not finite",
            Self::IterationLimit => "iteration limit",
            Self::OutOfModel => "pose outside of the model",
        })
    }
}

/// A right-hand side that cannot be evaluated at the state tried; the integrator answers with a smaller step.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{reason}")]
pub struct EvaluationFailure {
    /// What went wrong: decides what the run tries next.
    pub kind: FailureKind,
    /// Text for the log, with the numbers.
    pub reason: String,
}

impl EvaluationFailure {
    /// A singular matrix.
    pub fn singular(reason: impl Into<String>) -> Self {
        Self { kind: FailureKind::Singular, reason: reason.into() }
    }

    /// A value that is not finite.
    pub fn not_finite(reason: impl Into<String>) -> Self {
        Self { kind: FailureKind::NotFinite, reason: reason.into() }
    }

    /// An iteration that has not converged.
    pub fn iteration_limit(reason: impl Into<String>) -> Self {
        Self { kind: FailureKind::IterationLimit, reason: reason.into() }
    }

    /// A pose that the model does not allow.
    pub fn out_of_model(reason: impl Into<String>) -> Self {
        Self { kind: FailureKind::OutOfModel, reason: reason.into() }
    }
}
