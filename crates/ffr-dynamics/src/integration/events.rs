//! Zeros of functions along the dense output.
