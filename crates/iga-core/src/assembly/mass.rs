//! Consistent mass matrix.
