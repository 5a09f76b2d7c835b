//! What \[A\] describes and a run does otherwise unless it is asked: Algorithm 1 in place of the
//! compliance of the zone, and zones that vibrate, with damping or without. What asks for them
//! stands in ARCHITECTURE.md.

pub mod conditioned_lu;
mod sherman_morrison;
pub mod modal_basis;
pub mod broyden;
pub mod vibrating_zone;

pub use broyden::{Broyden, BroydenSettings};
pub use modal_basis::ModalBasis;
pub use vibrating_zone::{VibratingContact, ZoneVibration};
