//! Step size control.
