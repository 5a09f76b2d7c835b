//! The driver of a run: builds models, switches between phases, reports every step to an observer.

pub mod record;
