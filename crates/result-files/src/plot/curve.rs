//! Curves of many points: thinned to what a picture can show, their bounds, their spectra.

pub(super) mod envelope;
pub mod spectrum;
pub mod thin;
