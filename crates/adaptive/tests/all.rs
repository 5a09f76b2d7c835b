//! All tests of the crate, in one executable: a file that is not named here is not run (`scripts/check_layers.py` looks).
#![expect(clippy::unwrap_used, reason = "a failure there fails the test")]
#![expect(clippy::print_stdout, reason = "figures of the documents, shown with --nocapture")]

mod area_markers;
mod bodies;
mod comparison_models;
mod driver;
mod failing_trials;
mod fine_model;
mod fine_modes;
mod geometric_stiffening;
mod impact_chains;
mod impacts;
mod markers;
mod mesh_zones;
mod patch_zones;
mod printed_search;
mod random_impacts;
mod random_pairs;
mod random_solid_impacts;
mod restart;
mod rod_impacts;
mod rotated_net;
mod sizing;
mod solid_sphere;
mod solids;
mod sphere_rod_sphere;
mod static_answers;
mod store;
mod surfaces;
mod transfer;
mod watch;
mod zone_points;
mod zone_stress;
mod zones;
#[expect(dead_code, reason = "other crates use the rest")]
#[path = "../../fe-mesh/tests/balls/mod.rs"]
mod balls;
#[expect(dead_code, reason = "other crates use the rest")]
#[path = "../../fe-mesh/tests/blocks/mod.rs"]
mod blocks;
#[expect(dead_code, reason = "other crates use the rest")]
#[path = "../../ffr-dynamics/tests/oracles/mod.rs"]
mod oracles;
