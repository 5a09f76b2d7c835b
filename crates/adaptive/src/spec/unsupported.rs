//! What this version cannot simulate, with what can be done instead.

use contact_qs::ContactError;
use thiserror::Error;

/// Unknowns on a rigid part beyond which the block that couples all of them is refused: 1e7
/// entries.
pub const MOST_RIGID_UNKNOWNS: usize = 4500;

/// Why a body, a contact or a request is refused. Texts are fragments that read after its name.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Unsupported {
    /// Stress with a contact that has no fine models.
    #[error("contact {contact} has no fine models")]
    NoFineModels {
        /// Index of the contact.
        contact: u32,
    },
    /// Stress in a zone that vibrates, or has modes of its own.
    #[error(
        "contact \"{contact}\" refines the body during the run in a way that stress is not supported for; choose {remedy} for the contact"
    )]
    StressInZone {
        /// Name of the contact.
        contact: String,
        /// Key and value to choose.
        remedy: &'static str,
    },
    /// Strain and stress of a part.
    #[error("strain and stress belong to a single point, this place has an extent; give a point")]
    GaugeOfArea,
    /// Strain and stress in a body without elements.
    #[error("strain and stress need a flexible body with a shape or a mesh")]
    GaugeWithoutElements,
    /// A joint or load at a point of a flexible body.
    #[error(
        "{user} is a point of a flexible body, which yields without bound under a force as elements shrink; give it an extent: a face, or a radius"
    )]
    PointOfFlexibleBody {
        /// Name of the marker.
        user: String,
    },
    /// A named place on a rigid body.
    #[error("a rigid body has no marker \"{marker}\", give a point")]
    RigidMarker {
        /// Name looked for.
        marker: String,
    },
    /// A named place on ground.
    #[error("places on ground are given by points")]
    PlaceOnGround,
    /// A point on a body from a file.
    #[error("places on a body from a file are named by markers of the file")]
    PlaceOnImported,
    /// A marker that a shape or file does not have.
    #[error("the {holder} has no marker \"{marker}\", it has {known}")]
    UnknownMarker {
        /// Shape or file.
        holder: &'static str,
        /// Name looked for.
        marker: String,
        /// Names that there are.
        known: String,
    },
    /// A surface that contact cannot be watched on.
    #[error(transparent)]
    Surface(ContactError),
    /// Contact points on a rigid body.
    #[error(
        "body \"{body}\" is not flexible and carries contact points of model \"coarse\" alone; exchange contact body and target, between two rigid bodies choose \"coarse\" (flat faces, edges, corners) or \"hertz\" (curved faces)"
    )]
    RigidContactBody {
        /// Name of the body.
        body: String,
    },
    /// Contact points of a rigid body where a smooth face touches.
    #[error(
        "smooth faces of rigid bodies touch where perhaps no contact point stands; choose model = \"hertz\", which follows the closest places, or where they touch along a line take one of them as flexible"
    )]
    SmoothByPoints,
    /// Hertz's law where it has no answer.
    #[error(
        "{what}, where Hertz's law needs smooth surfaces that are curved against each other in both directions; choose model = \"adaptive\", of rigid bodies \"coarse\""
    )]
    NoHertzPoint {
        /// What touches.
        what: &'static str,
    },
    /// Contact with a body that has no surface.
    #[error("body \"{body}\" has no surface to touch; give it a shape")]
    NoSurface {
        /// Name of the body.
        body: String,
    },
    /// Contacts on one body that want different things of its modes.
    #[error("{} and {} contacts on one body cannot be mixed, choose one model", models[0], models[1])]
    MixedContacts {
        /// Models of the contacts.
        models: [&'static str; 2],
    },
    /// A contact on one body beside one that is refined during the run.
    #[error(
        "{model} contact and one that the program refines cannot be mixed on one body, whose low-frequency modes alone may be dynamic; choose one model"
    )]
    MixedWithRefined {
        /// Model of the contact.
        model: &'static str,
    },
    /// A contact on a body without interface modes.
    #[error("{model} contact needs reduction.method = \"craig-bampton\"")]
    NoInterfaceModes {
        /// Model of the contact.
        model: &'static str,
    },
    /// Modes of its own for a contact with one model for the whole run.
    #[error("modes = \"own\" is for contacts that the program refines in the run, leave it out")]
    FineModesFromStart,
    /// Modes of its own for a body that other contacts need as it is.
    #[error(
        "body \"{body}\" takes part in contact \"{other}\" too, which keeps one model for the whole run; choose modes = \"prolonged\""
    )]
    FineModesShared {
        /// Name of the body.
        body: String,
        /// Name of the other contact.
        other: String,
    },
    /// Modes of its own for a body with modes of an interface.
    #[error(
        "it has modes of an interface, fine models with modes = \"own\" have free modes alone; choose modes = \"prolonged\" for its contacts"
    )]
    FineModesOfInterface,
    /// Modes of its own with geometric stiffening.
    #[error(
        "fine models with modes = \"own\" have no geometric stiffening; choose modes = \"prolonged\" for its contacts"
    )]
    FineModesStiffened,
    /// Geometric stiffening in another frame.
    #[error("geometric stiffening needs frame = \"tangent\", whose marker says where the body is held")]
    StiffeningWithoutTangent,
    /// Geometric stiffening of an axisymmetric body.
    #[error("an axisymmetric body does not turn and has no geometric stiffening, use a solid model")]
    StiffeningOfAxisymmetric,
    /// A rigid part with too many unknowns.
    #[error(
        "the rigid coupling of {part} holds {unknowns} unknowns, {most} are possible; choose coupling = \"average\" or fewer elements"
    )]
    RigidPart {
        /// The part.
        part: String,
        /// Its unknowns.
        unknowns: usize,
        /// Most that are possible.
        most: usize,
    },
    /// A rigid part where a mesh is divided.
    #[error(
        "a contact zone reaches the elements of a part that a joint or load holds with coupling = \"rigid\"; choose coupling = \"average\" or a smaller part"
    )]
    RigidPartAtTouch,
    /// Modes of its own for a body of finite elements.
    #[error(
        "a body of model \"mesh\" has no fine models with modes = \"own\"; choose modes = \"prolonged\" for its contacts"
    )]
    FineModesOfMesh,
    /// Division by Algorithm 3, or about several intervals, of a body of several patches.
    #[error("interval.division = \"printed\" is for bodies of one patch; leave it out")]
    PartsOfPatches,
    /// An interval on a singular line of the parametrisation.
    #[error(
        "a contact interval touches the singular {set} of the parametrisation; turn the body's frame or choose another net"
    )]
    SingularInterval {
        /// Name of the line or point.
        set: String,
    },
}
