//! Penalty law.
