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
        /// Width of the zone [m].
        width: f64,
    },
    /// Data do not fit together.
    #[error("contact data do not fit: {reason}")]
    Inconsistent {
        /// Which, with the numbers.
        reason: String,
    },
}
