//! From thousands of unknowns to a few: eigenmodes, Craig-Bampton, interface compliance.

pub mod ordering;
pub mod factor;
pub mod rigid;
pub mod eigen;
pub mod modal;
pub mod craig_bampton;
pub mod compliance;
