//! Finite element meshes of solids.
//!
//! The crate knows meshes and their files, elements, surfaces, and what makes a mesh a space of
//! displacements ([`space`]); matrices, moments and stress are those that `iga-core` has of any
//! space. It knows no time, no reduction, no rigid-body motion and no contact.
//!
//! * SI units once a mesh has been read with its unit of length.
//! * Nodes of elements stand in the order of Abaqus and CalculiX ([`kind`]).
//! * Unknowns are `3 node + direction`.

pub mod fault;
pub mod kind;
pub mod shape;
pub mod rules;
pub mod raw;
pub mod jacobian;
pub mod boundary;
pub mod mesh;
pub mod check;
pub mod refined;
pub mod space;
pub mod locate;
pub mod part;
pub mod side_pieces;
pub mod surface;
pub mod stress;
pub mod read;

pub use fault::MeshError;
pub use kind::{ElementKind, SideKind};
pub use mesh::Mesh;
pub use space::MeshSpace;
