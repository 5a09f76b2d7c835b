//! Sparse Cholesky and LDLT with reuse.
