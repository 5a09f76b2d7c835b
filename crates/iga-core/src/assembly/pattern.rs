//! Sparsity pattern of a space.
