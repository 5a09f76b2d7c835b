//! Finite element meshes of solids.
//!
//! The crate knows meshes and their files, elements, surfaces, and what makes a mesh a space of
//! displacements ([`space`]); matrices, moments and stress are those that `iga-core` has of any
//! space. It knows no time, no reduction, no rigid-body motion and no contact.
//!
//! * SI units once a mesh has been read with its unit of length.
//! * Nodes of elements stand in the order of Abaqus and CalculiX ([`element::kind`]).
//! * Unknowns are `3 node + direction`.

pub mod fault;
pub mod element;
pub mod mesh;
pub mod refined;
pub mod space;
pub mod locate;
pub mod part;
pub mod surface;
pub mod stress;
pub mod read;

pub use element::kind::{ElementKind, SideKind};
pub use fault::MeshError;
pub use mesh::Mesh;
pub use space::MeshSpace;
