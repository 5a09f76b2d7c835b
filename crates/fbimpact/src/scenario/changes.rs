//! What changes a document before it is checked: `--set`, materials that are known by name, copies of bodies, and contacts of
//! many bodies.

pub mod overrides;
pub(super) mod standard_materials;
mod arrangements;
mod copies;
mod pairs;
pub(super) mod expanded;
