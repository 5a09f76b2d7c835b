//! A run as it goes on: the [`driver`] that steps through its phases, and a [`recording`] of it in
//! memory. Knows everything below; nothing knows it.
pub mod driver;
pub mod recording;
