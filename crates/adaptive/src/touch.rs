//! How two bodies are going to meet: where, with what curvatures, along which line, how hard by
//! Hertz's theory. Knows surfaces and motions of bodies; knows no matrices, and no zones.
pub mod detection;
pub mod first;
mod flight;
pub mod hertz;
pub(crate) mod line;
pub mod local_surface;
pub mod overlap;
pub mod parts;
pub mod preview;
pub(crate) mod side;
pub mod sites;
pub(crate) mod tolerances;
pub(crate) mod wave;
