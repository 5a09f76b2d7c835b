//! Unit quaternions as generalised positions.
