//! Contact laws: the penalty law of a surface point and Hertz's closed forms for spheres.

pub mod penalty;
pub mod hertz;

pub use hertz::{HertzImpact, HertzPair, Solid};
