//! How two bodies are going to meet: where, with what curvatures, along which line, how hard by
//! Hertz's theory. Knows surfaces and motions of bodies; knows no matrices, and no zones.

pub mod detection;
mod flight;
pub(crate) mod tolerances;
pub mod hertz;
pub mod parts;
pub mod sites;
pub mod overlap;
pub mod first;
pub(crate) mod wave;
