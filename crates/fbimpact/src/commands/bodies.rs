//! Commands that take bodies from other programs and give them to others.

pub mod export;
pub mod splines;
pub mod import;
