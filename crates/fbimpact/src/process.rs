//! The process itself: what it was built from, and what it does that gets no more memory.

pub mod allocation;
pub mod provenance;
