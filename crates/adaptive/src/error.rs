//! What can stop a run, with the name of the body or contact concerned.

use contact_qs::ContactError;
use ffr_dynamics::DynamicsError;
use iga_core::SplineError;
use thiserror::Error;

use crate::record::ObserverError;

/// Errors of model building and of a run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AdaptiveError {
    /// A body's geometry, mesh or matrices.
    #[error("body \"{body}\": {source}")]
    Geometry {
        /// Name of the body.
        body: String,
        /// What is wrong.
        source: SplineError,
    },
    /// A body's reduction.
    #[error("body \"{body}\": {source}")]
    Reduction {
        /// Name of the body.
        body: String,
        /// What is wrong.
        source: DynamicsError,
    },
    /// A contact's points or data.
    #[error("contact \"{contact}\": {source}")]
    Contact {
        /// Name of the contact.
        contact: String,
        /// What is wrong.
        source: ContactError,
    },
    /// Something that this version cannot simulate.
    #[error("{subject}: {reason}")]
    Unsupported {
        /// Body or contact, with its name.
        subject: String,
        /// What cannot be done, and what can.
        reason: String,
    },
    /// The bodies, joints and loads as a system.
    #[error(transparent)]
    Model(DynamicsError),
    /// The time integration.
    #[error(transparent)]
    Dynamics(DynamicsError),
    /// The contact grew out of its interval, so that part of the surface was not watched.
    #[error(
        "contact \"{contact}\": contact reached the rim of its interval at t = {time:.6e} s; widen the interval (now {width:.3e} m)"
    )]
    IntervalTooSmall {
        /// Name of the contact.
        contact: String,
        /// When \[s\].
        time: f64,
        /// Width of the interval \[m\].
        width: f64,
    },
    /// The observer failed.
    #[error(transparent)]
    Observer(#[from] ObserverError),
}

impl AdaptiveError {
    /// Whether the error arose while models were built, before any time was simulated.
    pub fn is_model_error(&self) -> bool {
        matches!(
            self,
            Self::Geometry { .. }
                | Self::Reduction { .. }
                | Self::Contact { .. }
                | Self::Unsupported { .. }
                | Self::Model(_)
        )
    }
}
