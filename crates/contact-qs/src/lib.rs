//! Contact between a reduced isogeometric body and a target, as force elements of the equations of
//! motion.
//!
//! The high-frequency deformation of the contact zone is quasistatic: it follows from the interface
//! compliance `G` and a small strictly convex problem for the point forces ([`quasistatic`]). SI
//! units. Equation numbers refer to `docs/theory.md`; \[A\] and \[B\] are the two papers named
//! there.

pub mod error;
pub mod solver_fault;
pub mod piecewise;
pub mod law;
pub mod quasistatic;
pub mod contact_element;
pub mod around;
pub mod zone;
pub mod plane;
pub mod search;
pub mod hertz_contact;
pub mod surface_pair;

pub use around::sides::ContactSides;
pub use around::vibrating_zone::{VibratingContact, ZoneVibration};
pub use contact_element::{ActiveContact, Contact, ContactElement, ContactReport, Meeting, Plane, Target};
pub use error::ContactError;
pub use hertz_contact::HertzContact;
pub use hertz_contact::sphere::Sphere;
pub use law::Friction;
pub use piecewise::{PieceEdge, PiecewiseSurface, SurfacePiece};
pub use plane::{PlaneContact, PlaneContactSettings};
pub use quasistatic::compliance::ZoneCompliance;
pub use search::{BodySurface, Detector, Proximity, SearchWorkspace, SurfaceModel, minimum_distance};
pub use surface_pair::{SurfacePair, SurfacePairSettings, TargetFace, TargetSurface};
pub use zone::points::{DofLookup, InterfaceCompliance, PressureMean, SurfacePoint, contact_submodel};
pub use zone::pressure::PressureRecovery;
pub use zone::submodel::ContactSubmodel;
