//! One flexible body by itself: its equations of motion in its floating frame, their derivatives,
//! what it keeps, and the modes that it has when nothing holds it.

pub(super) mod deformation;
pub(super) mod equations;
mod derivative;
pub(super) mod free_modes;
pub(super) mod uncoupled_modes;
pub mod invariants;
