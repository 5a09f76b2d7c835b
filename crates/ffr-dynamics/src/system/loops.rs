//! Joints that close loops, and gears, as constraints on a tree of bodies.

pub(super) mod rows;
pub(super) mod closure;
