//! What can go wrong when a contact is set up.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::DataError;
use ffr_dynamics::error::EvaluationFailure;
use iga_core::SplineError;
use thiserror::Error;

/// Errors of contact set-up. Texts are fragments that read after "contact ...: ".
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ContactError {
    /// The contact zone reaches a singular point or line of the parametrisation.
    #[error(
        "the contact zone touches the {name} of the parametrisation, where surface functions are singular; turn the body so that contact falls elsewhere"
    )]
    Singular {
        /// Name of the singular set.
        name: String,
    },
    /// No surface point lies in the contact zone.
    #[error(
        "no contact point lies within {width:.3e} m of the contact centre, widen the interval or refine the mesh"
    )]
    Empty {
        /// Width of the zone \[m\].
        width: f64,
    },
    /// A penalty factor that is not positive.
    #[error("penalty factor is {value:e} N/m^3, must be > 0 (infinite for the exact constraint)")]
    Penalty {
        /// The value given [N/m³].
        value: f64,
    },
    /// Contact points whose compliance is nothing but round-off, so that no penalty factor follows
    /// from it.
    #[error(
        "no contact point yields: what the modes of the bodies leave of the compliance there is lost in its round-off, as on a body that is thousands of times as wide as thick; take a thicker one or a smaller piece of it"
    )]
    NoCompliance,
    /// Friction values that make no law.
    #[error(
        "friction coefficient is {coefficient}, must be >= 0; tangential stiffness ratio is {stiffness_ratio}, must be > 0"
    )]
    Friction {
        /// Coefficient given.
        coefficient: f64,
        /// Ratio given.
        stiffness_ratio: f64,
    },
    /// Damping that is none.
    #[error("damping is {value:e} s/m, must be >= 0")]
    Damping {
        /// Value given.
        value: f64,
    },
    /// Friction was asked of a solver that cannot find it.
    #[error("friction needs the active-set solver, Algorithm 1 knows normal forces alone")]
    FrictionSolver,
    /// The exact constraint was asked of a method that needs penalty springs.
    #[error("{method} needs a finite penalty factor, choose one or the active-set solver")]
    ExactConstraint {
        /// Which method.
        method: &'static str,
    },
    /// The plane cannot be met by a body with the motions of its model.
    #[error(
        "the plane's normal in the body's frame is ({:.3e}, {:.3e}, {:.3e}), {requirement}",
        normal[0],
        normal[1],
        normal[2]
    )]
    Normal {
        /// Unit normal in the body's frame.
        normal: [f64; 3],
        /// What the model requires.
        requirement: &'static str,
    },
    /// A motion in which no distance can be computed.
    #[error("no distance can be found, {0}")]
    Motion(String),
    /// Bodies of different kinds of model.
    #[error("a body of {first:?} model cannot touch one of {second:?} model, use the same model for both")]
    MixedModels {
        /// Model of the contact body.
        first: RigidMotion,
        /// Model of the target.
        second: RigidMotion,
    },
    /// A body in contact with itself.
    #[error("body {body} cannot be in contact with itself, name two bodies")]
    OneBody {
        /// Number of the body.
        body: usize,
    },
    /// A body that the contact does not know.
    #[error("body {body} takes no part in the contact")]
    ForeignBody {
        /// Number of the body.
        body: usize,
    },
    /// Two partners that do not yield.
    #[error("both partners of a Hertz contact are rigid, one needs a finite Young's modulus")]
    RigidPair,
    /// A penalty factor for a contact law that has none.
    #[error("a {kind} contact has no penalty factor")]
    NoPenalty {
        /// Kind of contact.
        kind: &'static str,
    },
    /// A contact without points, or a surface without faces.
    #[error("{what}")]
    Nothing {
        /// What there is not.
        what: &'static str,
    },
    /// A place of the surface that no element holds.
    #[error("no element of the target holds the parameters {parameters:?}")]
    NoElement {
        /// Parameters of the place.
        parameters: [f64; 2],
    },
    /// A face whose parameters enclose nothing.
    #[error("a target face from {lower:?} to {upper:?} has no extent")]
    EmptyFace {
        /// Lower parameters.
        lower: [f64; 2],
        /// Upper parameters.
        upper: [f64; 2],
    },
    /// A surface that cannot be made of patches.
    #[error("surface of a rigid body: {0}")]
    Surface(#[from] SplineError),
    /// A function at a contact point whose unknown has no compliance.
    #[error(
        "a function of value {value:.3e} at a contact point belongs to unknown {unknown}, which is not in the interface"
    )]
    OutsideInterface {
        /// Value of the function.
        value: f64,
        /// Number of the unknown.
        unknown: usize,
    },
    /// A penalty factor, or the compliance that it follows from, cannot be found at the present
    /// pose.
    #[error("the contact cannot be evaluated: {0}")]
    Evaluation(#[from] EvaluationFailure),
    /// Data do not fit together.
    #[error("contact data do not fit: {0}")]
    Data(#[from] DataError),
}
