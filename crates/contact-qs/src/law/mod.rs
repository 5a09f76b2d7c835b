//! Contact laws: the penalty law of a surface point, Coulomb's friction, and Hertz's closed forms for spheres.

pub mod penalty;
pub mod coulomb;
pub mod hertz;

pub use coulomb::Friction;
pub use hertz::{HertzPair, Solid};
