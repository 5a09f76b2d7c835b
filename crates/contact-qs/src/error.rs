//! What can go wrong when a contact is set up.

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
    /// A motion in which no distance can be told.
    #[error("no distance can be found, {what}: {reason}")]
    Motion {
        /// Which part of the motion.
        what: &'static str,
        /// What is wrong with it, with the numbers.
        reason: String,
    },
    /// Data do not fit together.
    #[error("contact data do not fit: {reason}")]
    Inconsistent {
        /// Which, with the numbers.
        reason: String,
    },
}
