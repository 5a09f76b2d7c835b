//! All tests of the crate, in one executable: a file that is not named here is not run (`scripts/check_layers.py` looks).
#![expect(clippy::unwrap_used, reason = "a failure there fails the test")]
#![expect(clippy::print_stdout, reason = "figures of the documents, shown with --nocapture")]

mod bands;
mod beam_file;
mod bearings;
mod benchmarks;
mod body_file;
mod cache;
mod cantilever;
mod cli;
mod compare;
mod contact_events;
mod converge;
mod copies;
mod crossing_edges;
mod damaged;
mod decks;
mod determinism;
mod doubled;
mod equilibrium;
mod drop;
mod export;
mod export_setup;
mod expressions;
mod faults;
mod flat_contact;
mod flat_meshes;
mod foreign_files;
mod fuzzing;
mod gear_tooth;
mod gears;
mod grazing;
mod guards;
mod held_damping;
mod hertz_scenarios;
mod import_body;
mod imported_bodies;
mod joint_answers;
mod joint_travel;
mod joint_velocities;
mod lasting;
mod key_examples;
mod limits;
mod linear_limits;
mod line_contact;
mod line_on_mesh;
mod long;
mod lower_continuity;
mod lying;
mod many_bodies;
mod mesh_contact;
mod mesh_stress;
mod meshed;
mod meshed_rods;
mod moving_contact;
mod narrow_tools;
mod one_body;
mod one_contact;
mod outputs;
mod own_part;
mod plane_meshes;
mod plane_supports;
mod plausibility;
mod plot;
mod point_stress;
mod probe;
mod reader_memory;
mod rest;
mod restitution;
mod results;
mod recorded_quantities;
mod refused_alike;
mod report;
mod resume;
mod rigid_points;
mod rigid_targets;
mod scenario;
mod scenario_bodies;
mod scenario_contacts;
mod scenario_faults;
mod setup;
mod several_touches;
mod shape_impacts;
mod shapes;
mod sizing;
mod solid_file;
mod spin;
mod spline_bodies;
mod support;
mod sweep;
mod system_modes;
mod touches;
mod traces;
mod travelling;
mod verification;
mod versions;
mod whole_surfaces;
#[path = "../crates/fe-mesh/tests/balls/mod.rs"]
mod balls;
#[expect(dead_code, reason = "other crates use the rest")]
#[path = "../crates/fe-mesh/tests/blocks/mod.rs"]
mod blocks;
#[expect(dead_code, reason = "other crates use the rest")]
#[path = "../crates/fe-mesh/tests/writers/mod.rs"]
mod writers;
#[expect(dead_code, reason = "other crates use the rest")]
#[path = "../crates/ffr-dynamics/tests/oracles/mod.rs"]
mod oracles;
