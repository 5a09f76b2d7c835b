//! Truncated hierarchical splines over NURBS patches: local refinement that leaves the geometry as
//! it is.
//!
//! A [`SubdomainHierarchy`] says where each level of knots is used, a [`HierarchicalBasis`] which
//! functions of which level are active (theory Eq. H.3), [`Neighbours`] which of them are one
//! across faces that patches share (H.9), [`truncation`] what they look like on one element (H.4,
//! H.5), and a [`HierarchicalSpace`] makes them rational and puts them behind
//! [`crate::space::Space`], so that nothing downstream learns about levels. [`Prolongation`]
//! carries coefficients into a finer space. No module here knows contact or how big a refined box
//! should be.

pub mod index_box;
pub mod two_scale;
pub mod domain;
pub mod ties;
pub mod neighbours;
pub mod basis;
pub mod truncation;
pub mod growth;
pub mod space;
pub mod prolongation;

pub use basis::HierarchicalBasis;
pub use domain::SubdomainHierarchy;
pub use growth::elements_around;
pub use index_box::IndexBox;
pub use neighbours::{Neighbours, SharedFace};
pub use prolongation::Prolongation;
pub use space::HierarchicalSpace;
pub use ties::PatchTies;
pub use two_scale::TwoScale;
