//! Modal truncation.
