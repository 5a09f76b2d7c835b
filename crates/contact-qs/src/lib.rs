//! Contact between a reduced isogeometric body and a target, as force elements of the equations of
//! motion.
//!
//! The high-frequency deformation of the contact zone is quasistatic: it follows from the interface
//! compliance `G` and a small strictly convex problem for the point forces ([`quasistatic`]). SI
//! units. Equation numbers refer to `docs/theory.md`; \[A\] and \[B\] are the two papers named
//! there.

pub mod error;
pub mod solver_fault;
pub mod submodel;
pub mod points;
pub mod piecewise;
pub mod pressure;
pub mod law;
pub mod quasistatic;
pub mod contact_element;
pub mod plane;
mod sphere;
pub mod search;
pub mod hertz_contact;
pub mod surface_pair;
pub mod paper;

pub use contact_element::{ActiveContact, ContactElement, ContactFindings, ContactReport};
pub use error::ContactError;
pub use hertz_contact::HertzContact;
pub use law::Friction;
pub use paper::{VibratingContact, ZoneVibration};
pub use piecewise::{PieceEdge, PiecewiseSurface, SurfacePiece};
pub use plane::{Plane, PlaneContact, PlaneContactSettings};
pub use points::{DofLookup, InterfaceCompliance, PressureMean, SurfacePoint, contact_submodel};
pub use pressure::PressureRecovery;
pub use search::{Proximity, SearchWorkspace, SurfaceModel, minimum_distance};
pub use sphere::Sphere;
pub use submodel::ContactSubmodel;
pub use surface_pair::{SurfacePair, SurfacePairSettings, TargetFace, TargetSurface};
