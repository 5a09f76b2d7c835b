//! Exact shapes by name.
