//! Finite element meshes of solids, and of sections in the plane.
//!
//! The crate knows meshes and their files, elements, surfaces, and what makes a mesh a space of
//! displacements ([`space`]); matrices, moments and stress are those that `iga-core` has of any
//! space. It knows no time, no reduction, no rigid-body motion and no contact.
//!
//! * SI units once a mesh has been read with its unit of length.
//! * Nodes of elements stand in the order of Abaqus and CalculiX ([`element::kind`]).
//! * Unknowns of solids are `3 node + direction`, of plane models `2 node + direction`; radial ones of
//!   nodes on the axis of an axisymmetric model are held.

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
