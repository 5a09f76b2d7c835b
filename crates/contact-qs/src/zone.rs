//! The contact zone of a body: its points with their areas, shapes and compliance, and the pressure
//! that forces at them stand for.

pub mod submodel;
pub mod points;
pub mod pressure;
