//! Geometric nested dissection.
