//! What can stop a run, with the name of the body or contact concerned.

use contact_qs::ContactError;
use fe_mesh::fault::MeshFault;
use ffr_dynamics::DynamicsError;
use ffr_dynamics::error::{EvaluationFailure, IntegrationFault};
use iga_core::SplineError;
use thiserror::Error;

use crate::adaptivity::penalty_search::PenaltyFailure;
use crate::adaptivity::subdivision::SubdivisionError;
use crate::record::finding::{BodyQuantity, Components, ContactQuantity, LedgerCause};

/// An error of an observer, such as a full disk; ends the run.
#[derive(Debug, Error)]
#[error(transparent)]
pub struct ObserverError(Box<dyn std::error::Error + Send + Sync>);

impl ObserverError {
    /// The error that `cause` is for an observer.
    pub fn new(cause: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self(cause.into())
    }
}

/// Errors of model building and of a run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AdaptiveError {
    /// A restart point that does not belong to the models.
    #[error("the run cannot be taken up again at {time:.9e} s: {fault}; start it anew")]
    Restart {
        /// Time of the restart point \[s\].
        time: f64,
        /// What differs.
        fault: RestartFault,
    },
    /// A start in equilibrium that is none.
    #[error("no static equilibrium: {0}")]
    Equilibrium(String),
    /// A body's geometry, mesh or matrices.
    #[error("body \"{body}\": {source}")]
    Geometry {
        /// Name of the body.
        body: String,
        /// What is wrong.
        source: SplineError,
    },
    /// A body's finite element mesh.
    #[error("body \"{body}\": {source}")]
    Mesh {
        /// Name of the body.
        body: String,
        /// What is wrong.
        source: MeshFault,
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
    /// A contact for which there is no model.
    #[error("contact \"{contact}\": {fault}")]
    ContactModel {
        /// Name of the contact.
        contact: String,
        /// Why.
        fault: ContactModelFault,
    },
    /// Something that this version cannot simulate.
    #[error("{subject}: {what}")]
    Unsupported {
        /// Body, contact or request, with its name.
        subject: String,
        /// What cannot be done, and what can.
        what: String,
    },
    /// The bodies, joints and loads as a system.
    #[error(transparent)]
    Model(DynamicsError),
    /// The time integration.
    #[error(transparent)]
    Dynamics(DynamicsError),
    /// Bodies that overlap at the start.
    #[error(
        "contact \"{contact}\": the bodies overlap by {depth:.6e} m at the start, {allowed:.3e} m are allowed; the deepest point is at {place} m; move body \"{body}\" by {shift} m, or allow the overlap with contacts.{contact}.initial_overlap"
    )]
    InitialOverlap {
        /// Name of the contact.
        contact: String,
        /// Name of the contact body.
        body: String,
        /// Overlap \[m\].
        depth: f64,
        /// Deepest point in space \[m\].
        place: Components,
        /// Displacement of the contact body that removes the overlap, in space \[m\].
        shift: Components,
        /// Overlap that is allowed \[m\].
        allowed: f64,
    },
    /// A body that lies on the wrong side of a plane at the start.
    #[error(
        "contact \"{contact}\": body \"{body}\" lies behind the plane, its nearest point {distance:.3e} m from it; move the body by {shift} m or turn the normal of the plane, which points to the side of the body"
    )]
    BehindPlane {
        /// Name of the contact.
        contact: String,
        /// Name of the body.
        body: String,
        /// Distance of its nearest point \[m\].
        distance: f64,
        /// Displacement of the body that removes the overlap, in space \[m\].
        shift: Components,
    },
    /// Two spheres with one centre at the start.
    #[error(
        "contact \"{contact}\": the centres of the spheres \"{}\" and \"{}\" coincide at the start, so that their force has no direction; move one of them by {distance:.6e} m",
        bodies[0], bodies[1]
    )]
    CentresCoincide {
        /// Name of the contact.
        contact: String,
        /// Names of the bodies.
        bodies: [String; 2],
        /// Distance at which the spheres touch \[m\].
        distance: f64,
    },
    /// The energy ledger does not close.
    #[error(
        "the energy ledger is open by {energy:.3e} J at t = {time:.6e} s, {share:.2e} of the largest energy of {scale:.3e} J, where simulation.energy_tolerance allows {tolerance:.1e}; {cause}"
    )]
    LedgerOpen {
        /// When \[s\].
        time: f64,
        /// Energy that is not accounted for \[J\].
        energy: f64,
        /// Largest energy of the run \[J\].
        scale: f64,
        /// The one as a share of the other.
        share: f64,
        /// Share that is allowed.
        tolerance: f64,
        /// What may be the cause, and what to change.
        cause: LedgerCause,
    },
    /// A body whose motion the equations do not describe.
    #[error(
        "body \"{body}\": {quantity} is {value:.3e} {} at t = {time:.6e} s, beyond {limit:.3e} {}; {}",
        quantity.unit(), quantity.unit(), quantity.remedy()
    )]
    ImplausibleBody {
        /// Name of the body.
        body: String,
        /// When \[s\].
        time: f64,
        /// Which quantity.
        quantity: BodyQuantity,
        /// Its value, in its unit.
        value: f64,
        /// Its limit, in its unit.
        limit: f64,
    },
    /// A contact in which elastic contact does not describe the motion of the bodies.
    #[error(
        "contact \"{contact}\": {quantity} is {value:.3e} {} at t = {time:.6e} s, beyond {limit:.3e} {}; {}",
        quantity.unit(), quantity.unit(), quantity.remedy()
    )]
    ImplausibleContact {
        /// Name of the contact.
        contact: String,
        /// When \[s\].
        time: f64,
        /// Which quantity.
        quantity: ContactQuantity,
        /// Its value, in its unit.
        value: f64,
        /// Its limit, in its unit.
        limit: f64,
    },
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
    /// The bodies passed into each other between the points of their whole surfaces, and no force
    /// answered.
    #[error(
        "contact \"{contact}\": the bodies overlap by {overlap:.3e} m at t = {time:.6e} s and no point of the surface of \"{body}\" has touched: its elements, of up to {length:.3e} m, are longer than what touches them; raise bodies.{body}.discretisation.elements, or exchange contact_body and target_body if it is an edge or a corner of the target that touches"
    )]
    UnresolvedSurface {
        /// Name of the contact.
        contact: String,
        /// Name of the contact body.
        body: String,
        /// When \[s\].
        time: f64,
        /// Overlap of the surfaces \[m\].
        overlap: f64,
        /// Length of the longest element of the contact body \[m\].
        length: f64,
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
    /// Bodies lie in each other where their contact does not know of it.
    #[error(
        "contact \"{contact}\": body \"{}\" lies {depth:.3e} m deep in {} at t = {time:.6e} s, at {place} m, and the contact knows of {known:.3e} m: no force keeps them apart there; {remedy}", .bodies[0], .bodies[1]
    )]
    PassedThrough {
        /// Name of the contact.
        contact: String,
        /// Name of the contact body, and the target in words.
        bodies: Box<[String; 2]>,
        /// When \[s\].
        time: f64,
        /// Depth of the deepest place \[m\].
        depth: f64,
        /// The deepest place, in space \[m\].
        place: Components,
        /// Overlap that the contact sees \[m\].
        known: f64,
        /// What to change.
        remedy: Box<str>,
    },
    /// The contact reached the end of its surface, where no interval can grow.
    #[error(
        "contact \"{contact}\": contact reached the end of its surface at t = {time:.6e} s in trial {trials} with an interval of {width:.3e} m; an interval that the program refines ends before edges, and contact on the whole surfaces, which has the elements of the bodies, is for quasistatic contacts of splines whose elements are no longer than the interval: raise discretisation.elements, refine at the place with discretisation.refine, or give the body a rounded end"
    )]
    IntervalAtEdge {
        /// Name of the contact.
        contact: String,
        /// When \[s\].
        time: f64,
        /// Number of the trial.
        trials: u32,
        /// Width of the interval \[m\].
        width: f64,
    },
    /// No model of an impact was acceptable.
    #[error(
        "contact \"{contact}\": no acceptable model of the impact at t = {time:.6e} s in {trials} trials, the last interval was {width:.3e} m wide; give contacts.{contact}.interval.width near it and model \"quasistatic\", which keeps that width"
    )]
    NoAcceptableModel {
        /// Name of the contact.
        contact: String,
        /// Start of the impact \[s\].
        time: f64,
        /// Number of trials.
        trials: u32,
        /// Width of the last interval \[m\].
        width: f64,
    },
    /// No penalty factor was found.
    #[error("contact \"{contact}\", impact at t = {time:.6e} s, trial {trials}: {failure}{}", because(refusal.as_ref()))]
    Penalty {
        /// Name of the contact.
        contact: String,
        /// Start of the impact \[s\].
        time: f64,
        /// Number of the trial.
        trials: u32,
        /// Why.
        failure: PenaltyFailure,
        /// What the contact solver could not do, if it failed.
        refusal: Option<EvaluationFailure>,
    },
    /// The observer asked to stop while a model was built; runs end with it as interrupted, not as
    /// failed.
    #[error("stopped by the user")]
    Interrupted,
    /// The observer failed.
    #[error(transparent)]
    Observer(#[from] ObserverError),
}

/// The end of a sentence that names `refusal`.
fn because(refusal: Option<&EvaluationFailure>) -> String {
    refusal.map_or_else(String::new, |refusal| format!(": {refusal}"))
}

/// Why a restart point does not belong to the models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RestartFault {
    /// Models of other sizes.
    #[error("the models have other numbers of coordinates, contacts or requests")]
    OtherNumbers,
    /// Models of the same sizes whose coordinates mean something else.
    #[error("the models have other coordinates, as built on another machine or by another version")]
    OtherCoordinates,
}

/// Why a contact has no model.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ContactModelFault {
    /// Settings that do not go together, and what to change.
    #[error("{0}")]
    Settings(&'static str),
    /// A mesh on which the extent of the contact cannot be predicted.
    #[error(
        "Hertz's theory does not say how far it reaches on body \"{body}\": the surfaces are flat on each other, or nothing yields; give interval.width"
    )]
    NoWidthOnMesh {
        /// Name of the body.
        body: String,
    },
    /// A whole surface with more unknowns than memory holds the compliance of.
    #[error(
        "body \"{body}\" touches with a flat face, an edge or a corner, and contact on its whole surface has {unknowns} unknowns, which need about {gigabytes:.0} GB (at most {most:.0} GB); make its elements larger away from the touch, or give model = \"quasistatic\" with an interval.width of at least twice the diagonal of what touches"
    )]
    LargeSurface {
        /// Name of the body.
        body: String,
        /// Unknowns of its surface.
        unknowns: usize,
        /// Memory needed \[GB\].
        gigabytes: f64,
        /// Memory permitted \[GB\].
        most: f64,
    },
    /// A mesh that is touched along a line by sides that are too long for it.
    #[error(
        "body \"{body}\", a mesh, is touched along a line, where contact is {width:.3e} m wide; its sides are {length:.3e} m long across the line, {most:.3e} m at most leave no contact between their points: mesh a strip along the line with such sides, which may be long along it, or give both bodies a shape of splines (geometry.shape), which the program refines"
    )]
    LineOnMesh {
        /// Name of the body.
        body: String,
        /// Width of the contact \[m\].
        width: f64,
        /// Longest side across the line \[m\].
        length: f64,
        /// Longest one that is taken \[m\].
        most: f64,
    },
    /// A line on a mesh in a contact that the program refines.
    #[error(
        "body \"{body}\", a mesh, is touched along a line, where contact is {width:.3e} m wide, and the program divides elements about points alone: give model = \"quasistatic\" and mesh a strip along the line with sides that are half as long across it (they may be long along it), or give both bodies a shape of splines (geometry.shape), which the program refines"
    )]
    RefinedLine {
        /// Name of the body.
        body: String,
        /// Width of the contact \[m\].
        width: f64,
    },
    /// A line on a mesh whose partner is of splines.
    #[error(
        "body \"{body}\", of splines, touches a mesh along a line, for which its own elements are not refined: mesh it as well, take it as rigid, or give both bodies a shape of splines (geometry.shape), which the program refines"
    )]
    LineOfSplines {
        /// Name of the body.
        body: String,
    },
    /// A body whose elements are as coarse at the contact as elsewhere.
    #[error(
        "body \"{body}\" is not refined at its first point of contact ({:.6e}, {:.6e}, {:.6e}) m; give interval.width or refine there",
        point[0], point[1], point[2]
    )]
    NotRefined {
        /// Name of the body.
        body: String,
        /// The first point of contact in the body's frame \[m\].
        point: [f64; 3],
    },
    /// A touch with a curved edge of the target that no contact points see.
    #[error(
        "a curved edge of its target lies along a face of the contact body, where no contact points stand; the points of an edge stand on its own body: {}",
        if *.is_rigid { "make the target elastic (leave out model = \"rigid\") and the contact body, and this one the target" } else { "exchange contact_body and target_body" }
    )]
    BetweenPoints {
        /// Whether the target is rigid, which carries no points.
        is_rigid: bool,
    },
    /// A touch with an edge or a flat face of zones that vibrate.
    #[error(
        "its bodies touch with {what}: contact on their whole surfaces is quasistatic, and zones that vibrate lie on smooth faces; choose model \"adaptive\" or \"quasistatic\", or give the body a rounded edge"
    )]
    NotSmooth {
        /// What touches.
        what: &'static str,
    },
    /// Edges or flat faces that touch, under a law without springs.
    #[error(
        "its bodies touch with {what}: whole surfaces have more contact points than functions, between which a law without penetration has no unique pressure; choose model \"adaptive\" or \"quasistatic\" with a penalty factor"
    )]
    ExactWhole {
        /// What touches.
        what: &'static str,
    },
    /// A stored zone or stored forces that do not belong to the models.
    #[error("{0}")]
    Stored(String),
}

impl AdaptiveError {
    /// Forces that cannot be evaluated at time `time`, where no other step is tried.
    pub(crate) fn refused(time: f64, refusal: EvaluationFailure) -> Self {
        Self::Dynamics(DynamicsError::Integration { time, fault: IntegrationFault::Refused(refusal) })
    }

    /// Something that cannot be done with body `body`.
    pub(crate) fn unsupported_body(body: &str, what: String) -> Self {
        Self::Unsupported { subject: format!("body \"{body}\""), what }
    }

    /// Something that cannot be done with contact `contact`.
    pub(crate) fn unsupported_contact(contact: &str, what: String) -> Self {
        Self::Unsupported { subject: format!("contact \"{contact}\""), what }
    }

    /// Why a body takes no part in contacts.
    pub(crate) fn no_surface(body: &str) -> String {
        format!("body \"{body}\" has no surface to touch; give it a shape")
    }

    /// Why a place is not known: `holder` has the markers `known`.
    pub(crate) fn no_marker(holder: &str, marker: &str, known: &str) -> String {
        format!("the {holder} has no marker \"{marker}\", it has {known}")
    }

    /// The body whose elements cannot be divided as a contact zone asks: no memory holds the pieces, or they are folded.
    pub(crate) fn undivided_body(&self) -> Option<&str> {
        match self {
            Self::Subdivision { body, source: SubdivisionError::TooLarge { .. } }
            | Self::Mesh { body, source: MeshFault::TooFine { .. } }
            | Self::Geometry { body, source: SplineError::Folded { .. } } => Some(body),
            _ => None,
        }
    }

    /// Whether the error arose while models were built, before any time was simulated.
    pub fn is_model_error(&self) -> bool {
        matches!(
            self,
            Self::Geometry { .. }
                | Self::Mesh { .. }
                | Self::Subdivision { .. }
                | Self::Reduction { .. }
                | Self::Contact { .. }
                | Self::ContactModel { .. }
                | Self::Unsupported { .. }
                | Self::Restart { .. }
                | Self::InitialOverlap { .. }
                | Self::BehindPlane { .. }
                | Self::CentresCoincide { .. }
                | Self::Model(_)
        )
    }
}
