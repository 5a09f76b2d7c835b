//! What can stop a run, with the name of the body or contact concerned.

use contact_qs::ContactError;
use ffr_dynamics::DynamicsError;
use iga_core::SplineError;
use thiserror::Error;

use crate::penalty_search::PenaltyFailure;
use crate::record::ObserverError;
use crate::subdivision::SubdivisionError;

/// Errors of model building and of a run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AdaptiveError {
    /// A restart point that does not belong to the models.
    #[error("the run cannot be taken up again at {time:.9e} s: {reason}; start it anew")]
    Restart {
        /// Time of the restart point \[s\].
        time: f64,
        /// What differs.
        reason: String,
    },
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
    /// A contact interval for which the body's elements cannot be divided.
    #[error("body \"{body}\": {source}")]
    Subdivision {
        /// Name of the body.
        body: String,
        /// What is wrong.
        source: SubdivisionError,
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
    /// The bodies passed into each other between the contact points, and no force answered.
    #[error(
        "contact \"{contact}\": the bodies overlap by {overlap:.3e} m at t = {time:.6e} s and no contact point has touched; the points of an interval of {width:.3e} m lie too far apart, give it more elements or make it narrower"
    )]
    Unresolved {
        /// Name of the contact.
        contact: String,
        /// When \[s\].
        time: f64,
        /// Overlap of the surfaces \[m\].
        overlap: f64,
        /// Width of the interval \[m\].
        width: f64,
    },
    /// The contact reached the end of its surface, where no interval can grow.
    #[error(
        "contact \"{contact}\": contact reached the end of its surface at t = {time:.6e} s in try {tries} with an interval of {width:.3e} m; contact over an edge cannot be refined, move the bodies or choose model \"quasistatic\" with a refinement of your own"
    )]
    IntervalAtEdge {
        /// Name of the contact.
        contact: String,
        /// When \[s\].
        time: f64,
        /// Number of the try.
        tries: u32,
        /// Width of the interval \[m\].
        width: f64,
    },
    /// No model of an impact was acceptable.
    #[error(
        "contact \"{contact}\": no acceptable model of the impact at t = {time:.6e} s in {tries} tries, the last interval was {width:.3e} m wide; widen the limits interval.min_utilisation and interval.target_utilisation or give interval.width with model \"quasistatic\""
    )]
    NoAcceptableModel {
        /// Name of the contact.
        contact: String,
        /// Start of the impact \[s\].
        time: f64,
        /// Number of tries.
        tries: u32,
        /// Width of the last interval \[m\].
        width: f64,
    },
    /// No penalty factor was found.
    #[error("contact \"{contact}\", impact at t = {time:.6e} s, try {tries}: {failure}")]
    Penalty {
        /// Name of the contact.
        contact: String,
        /// Start of the impact \[s\].
        time: f64,
        /// Number of the try.
        tries: u32,
        /// Why.
        failure: PenaltyFailure,
    },
    /// The observer asked to stop while a model was built; runs end with it as interrupted, not as failed.
    #[error("stopped by the user")]
    Interrupted,
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
                | Self::Subdivision { .. }
                | Self::Reduction { .. }
                | Self::Contact { .. }
                | Self::Unsupported { .. }
                | Self::Restart { .. }
                | Self::Model(_)
        )
    }
}
