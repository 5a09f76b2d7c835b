//! The contact zone of a body: its points with their areas, shapes and compliance, and the pressure
//! that forces at them stand for.

pub mod sparse_rows;
pub mod compliance;
pub mod submodel;
pub mod points;
pub mod pressure;
