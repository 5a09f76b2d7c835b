//! Commands that prepare a run: scenarios to start from, checks, eigenfrequencies, sizes of meshes.

mod digits;
pub mod check;
pub mod mesh_size;
pub mod modes;
pub mod tied;
pub mod part;
pub mod new;
pub mod system_modes;
