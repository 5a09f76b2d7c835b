//! Blocks of vectors: dense products and solves, products with sparse matrices, start vectors.

pub mod dense;
pub mod product;
pub(super) mod random;
