//! What can go wrong in reduction and dynamics.

use std::fmt;
use std::sync::Arc;

use faer::sparse::CreationError;
use thiserror::Error;

use crate::data_error::DataError;
use crate::memory::gigabytes as gb;

/// Errors of reduction, equations of motion and time integration. Texts are fragments that read
/// after "body ...: ".
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DynamicsError {
    /// A sparse factorisation met a pivot that is not positive.
    #[error("{matrix} is not positive definite (pivot {pivot} of {size}): {}", of_matrix(matrix))]
    NotPositiveDefinite {
        /// Which matrix.
        matrix: &'static str,
        /// Index of the pivot.
        pivot: usize,
        /// Number of unknowns.
        size: usize,
    },
    /// A matrix that has no factorisation or no eigenvalues.
    #[error("factorisation of {matrix} failed: {fault}; {}", of_matrix(matrix))]
    Factorisation {
        /// Which matrix.
        matrix: &'static str,
        /// Why.
        fault: MatrixFault,
    },
    /// A sparse matrix for which the library has no room.
    #[error("matrix \"{matrix}\" cannot be assembled: {source}")]
    Assembly {
        /// Name of the matrix.
        matrix: String,
        /// What the library answered.
        source: CreationError,
    },
    /// A factor for which the machine has no memory.
    #[error(
        "the Cholesky factor of {unknowns} unknowns would take {} GB; one factor may take {} GB of the {} GB that are free, besides it there are modes, compliance and the other body (--memory); use fewer elements or a lower degree, in contact zones a smaller interval.elements",
        gb(*gigabytes), gb(*room), gb(*free)
    )]
    FactorTooLarge {
        /// Number of unknowns.
        unknowns: usize,
        /// Memory of the factor at least \[GB\].
        gigabytes: f64,
        /// Free memory \[GB\].
        free: f64,
        /// The part of the free memory that one factor may take \[GB\].
        room: f64,
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
    #[error("eigensolver found {found} of {expected} modes below {frequency:.6e} Hz: {fault}")]
    Eigenmodes {
        /// Modes found.
        found: usize,
        /// Modes that the inertia count shows.
        expected: usize,
        /// The frequency up to which modes were counted \[Hz\].
        frequency: f64,
        /// What was seen and what to do.
        fault: EigenFault,
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
        fault: String,
    },
    /// A gear that cannot be.
    #[error("gear \"{gear}\": {fault}")]
    Gear {
        /// Name of the gear.
        gear: String,
        /// What is wrong with it.
        fault: String,
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

/// The likely reason in the body for which `matrix` cannot be factorised, with a remedy.
fn of_matrix(matrix: &str) -> &'static str {
    if matrix.contains("mass") || matrix.contains("inertia") {
        "a part of the body has no mass, its numbers are in other units, or its modes are nearly the same; check density and mesh, or ask for fewer modes"
    } else if matrix.contains("compliance") || matrix.contains("projected") || matrix.contains("flexibility")
    {
        "its modes are nearly the same, or the body is thousands of times as long as thick; ask for fewer modes, or take a thicker body"
    } else {
        "elements are folded or far longer than thick, a part hangs on nothing, or materials differ too much in stiffness; check mesh and materials of the body"
    }
}

/// Why a matrix has no factorisation or no eigenvalues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MatrixFault {
    /// Entries that are not finite.
    #[error("it holds entries that are not finite")]
    NotFinite,
    /// A singular matrix.
    #[error("it is singular")]
    Singular,
    /// A spectrum that the iteration does not resolve.
    #[error("the eigenvalue iteration does not converge")]
    NoConvergence,
    /// Shifts that all meet an eigenvalue of a leading block.
    #[error("a frequency of the body repeats wherever modes are counted, ask for more or fewer of them")]
    NoRegularShift,
    /// A product that is not finite.
    #[error("frequencies are not finite")]
    LanczosVector,
}

/// Why modes were not found.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum EigenFault {
    /// Fewer modes than the inertia count shows.
    #[error("the count does not agree, try another number of modes")]
    Count,
    /// Residuals that do not fall.
    #[error(
        "residual {residual:.1e} after {blocks} blocks, limit {limit:.0e}; elements that are folded or far longer than thick keep modes from being found, mesh the body anew, or ask for fewer modes"
    )]
    NotConverged {
        /// Largest relative residual.
        residual: f64,
        /// Blocks of the Krylov space.
        blocks: usize,
        /// Residual allowed.
        limit: f64,
    },
    /// Frequencies so close behind the last mode that they cannot be counted apart.
    #[error("no gap behind the modes within {candidates} more, ask for more or fewer")]
    NoGap {
        /// Frequencies looked at.
        candidates: usize,
    },
    /// Modes that are none of the body.
    #[error(
        "residual {residual:.1e}, limit {limit:.0e}; elements that are folded or far longer than thick spoil the modes, mesh the body anew, or ask for fewer modes"
    )]
    Residual {
        /// Largest relative residual.
        residual: f64,
        /// Residual allowed.
        limit: f64,
    },
    /// A Craig-Bampton basis that does not have the frequencies of the body.
    #[error(
        "{modes} fixed-interface modes leave a frequency error of {error:.1e}, limit {limit:.0e}; ask for another number of modes, or give the body a finer mesh"
    )]
    FixedInterface {
        /// Number of fixed-interface modes.
        modes: usize,
        /// Relative error of the frequencies.
        error: f64,
        /// Error allowed.
        limit: f64,
    },
}

/// Why there is no static start.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StaticStartFault {
    /// Constraints: joints that the deformation would open, gears whose forces the search does not
    /// know.
    #[error("there are loop-closing joints or gears, whose forces it does not know")]
    LoopClosing,
    /// Forces with coordinates of their own.
    #[error("there are contact zones that vibrate, which have no equilibrium of their own")]
    Vibrating,
    /// Forces that cannot be evaluated.
    #[error(transparent)]
    Refused(#[from] EvaluationFailure),
    /// Bodies so soft that the corrections do not converge.
    #[error(
        "elastic coordinates do not converge in {corrections} corrections: loads deform the bodies too far, or nothing holds them; lower the loads, hold the bodies, or set static_start = false"
    )]
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
    #[error(
        "component {component} of the starting state is not finite; positions, velocities or initial joint coordinates are too large"
    )]
    State {
        /// Number of the component, from 0.
        component: usize,
    },
    /// Rates at the start that are not finite.
    #[error(
        "rate {component} of the starting state is not finite; forces, velocities or one over a mass are too large at the start"
    )]
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
    /// The bodies lie as the contact's model does not allow, for instance with axes apart, or move
    /// as friction does not.
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

/// Why a right-hand side cannot be evaluated, with its numbers; an enumeration of each crate.
pub trait EvaluationFault: std::error::Error + Send + Sync + 'static {
    /// What kind of failure it is: decides what the run tries next.
    fn kind(&self) -> FailureKind;
}

/// A right-hand side that cannot be evaluated at the present state; the integrator answers with a
/// smaller step.
#[derive(Debug, Clone)]
pub struct EvaluationFailure(Arc<dyn EvaluationFault>);

impl EvaluationFailure {
    /// What kind of failure it is: decides what the run tries next.
    pub fn kind(&self) -> FailureKind {
        self.0.kind()
    }
}

impl<F: EvaluationFault> From<F> for EvaluationFailure {
    fn from(fault: F) -> Self {
        Self(Arc::new(fault))
    }
}

impl PartialEq for EvaluationFailure {
    /// Equal faults with equal numbers have equal texts.
    fn eq(&self, other: &Self) -> bool {
        self.kind() == other.kind() && self.to_string() == other.to_string()
    }
}

impl fmt::Display for EvaluationFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for EvaluationFailure {}

/// Why the equations of motion have no solution at a state.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MotionFault {
    /// Coordinates without inertia.
    #[error(
        "inertia of the {coordinates} of body \"{body}\" is not positive definite: it has too little mass or inertia about a free direction, or is deformed beyond what its modes describe; check its density, mass and inertia, and the size of the loads"
    )]
    Inertia {
        /// Which coordinates, in the plural.
        coordinates: &'static str,
        /// Name of the body.
        body: String,
    },
    /// A frame without inertia.
    #[error(
        "inertia of the deformed body is not positive definite in direction {direction}: it is deformed beyond what its modes describe, lower the loads or make it stiffer"
    )]
    FrameInertia {
        /// Number of the direction, translations first.
        direction: usize,
    },
    /// A constraint without a finite force.
    #[error(
        "loop joint \"{joint}\" has no finite force: it repeats or contradicts what other joints hold already; free one of its directions (joints.{joint}.type), or leave it out"
    )]
    LoopForce {
        /// Name of the joint.
        joint: String,
    },
    /// A gear without a finite force.
    #[error(
        "gear \"{gear}\" has no finite force: it repeats or contradicts what joints and other gears hold already, or what it moves has no inertia; leave it out, or give its bodies mass"
    )]
    GearForce {
        /// Name of the gear.
        gear: String,
    },
    /// Friction that loads its own bearing by as much as it comes from, or more (Painlevé).
    #[error(
        "joint \"{joint}\" jams: sliding, the friction of its bearing adds {gain:.3} of the load that it comes from, limit 1, so that there are no \
         accelerations or several; use a smaller coefficient of friction, a longer bearing, or forces and masses nearer to it"
    )]
    Jam {
        /// Name of the joint.
        joint: String,
        /// Load by friction over the load that it comes from.
        gain: f64,
    },
    /// Loads of bearings that are not found.
    #[error(
        "loads of the bearings do not converge: they are off by {error:.1e} of {size:.1e} N or N m, check forces and motion for what is not finite"
    )]
    BearingLoads {
        /// Largest residual [N or N m].
        error: f64,
        /// Largest load [N or N m].
        size: f64,
    },
}

impl EvaluationFault for MotionFault {
    fn kind(&self) -> FailureKind {
        match self {
            Self::Inertia { .. } | Self::FrameInertia { .. } => FailureKind::Singular,
            Self::LoopForce { .. } | Self::GearForce { .. } => FailureKind::NotFinite,
            Self::Jam { .. } => FailureKind::OutOfModel,
            Self::BearingLoads { .. } => FailureKind::IterationLimit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_solver_sees_comes_with_what_can_be_changed() {
        let pivot = |matrix| DynamicsError::NotPositiveDefinite { matrix, pivot: 969, size: 2592 };
        for (matrix, word) in [
            ("K", "check mesh and materials"),
            ("the mass matrix", "check density"),
            ("the flexibility", "fewer modes"),
        ] {
            let failed = DynamicsError::Factorisation { matrix, fault: MatrixFault::NoRegularShift };
            for text in [pivot(matrix).to_string(), failed.to_string()] {
                assert!(text.contains(word), "{text}");
            }
        }
    }
}
