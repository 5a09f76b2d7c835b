//! Contact laws.

pub mod hertz;
pub mod penalty;
