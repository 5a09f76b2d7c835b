//! Detection of contact: distances in closed form and by brute force, signs, certificates, first touching times.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "../common/mod.rs"]
mod common;

mod bodies;
mod closed_forms;
mod general;
mod touching;
