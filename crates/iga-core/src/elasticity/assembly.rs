//! Sparse stiffness and mass matrices (theory section E.3).
//!
//! Elements are worked off in batches. Phase one, in parallel over elements: Gram products of the
//! basis and its gradients. Phase two, in parallel over columns: each column adds up its
//! contributions in the order of the elements, so that the matrices are the same to the last bit
//! whatever the number of threads.

mod pattern;
mod element;
mod mass;
mod stiffness;
mod batches;
mod combined;
mod assemble;
mod geometric;

pub use assemble::{AssembledMatrices, assemble, unknowns};
pub use geometric::geometric_stiffness;
