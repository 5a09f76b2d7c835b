//! What changes a document before it is checked: `--set`, and materials that are known by name.

pub mod overrides;
pub(super) mod standard_materials;
