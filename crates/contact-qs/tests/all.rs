//! All tests of the crate, in one executable: a file that is not named here is not run (`scripts/check_layers.py` looks).
#![expect(clippy::unwrap_used, reason = "a failure there fails the test")]

mod active_set;
mod allocations;
mod broyden;
mod common;
mod counting;
mod friction;
mod half_space;
mod hertz;
mod hertz_impact;
mod hertz_rolling;
mod hertz_steps;
mod hertz_surfaces;
mod massless_boundary;
mod pair;
mod pair_allocations;
mod pair_friction;
mod pair_hertz;
mod pair_sliding;
mod pair_solid;
mod pair_support;
mod plane;
mod points;
mod rates;
mod search;
mod search_allocations;
mod sliding;
mod spheres;
mod vibrating_zone;
#[path = "../../ffr-dynamics/tests/free_motion/mod.rs"]
mod free_motion;
