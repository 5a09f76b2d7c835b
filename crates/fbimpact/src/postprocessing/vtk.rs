//! Moving deformed bodies, and scenarios before their run, for ParaView and whatever else reads VTK
//! files.
//!
//! Bodies are rebuilt from the scenario that a result carries, moved and deformed by its
//! coordinates, and written element by element: as rational Bézier cells, which are the body's
//! exact shape, or as plain linear ones. Files are written here because no crate writes the weights
//! of rational cells (`docs/decisions/0011-vtk-files.md`).

pub mod grid;
pub mod bodies;
pub mod pressure;
pub mod setup;
pub mod times;
pub mod paraview;
