//! The driver of a run: builds models, switches between phases, reports every step to an observer.
//!
//! [`spec`] says what a run is made from, [`model`] builds it, [`driver`] runs it, [`record`] is what comes out. The crate
//! knows no file format and no terminal.

pub mod lattice;
pub mod rotated_net;
pub mod subdivision;
pub mod unsupported;
pub mod error;
pub mod spec;
pub mod warning;
pub mod record;
pub mod stop_hit;
pub mod run_state;
pub mod observer;
pub mod work;
pub mod recording;
pub mod marker_loads;
pub mod part_motion;
pub mod elastic_body;
pub mod body;
pub mod gauge;
pub mod surface;
pub mod rigid_surface;
pub mod body_model;
mod body_damping;
pub mod wanted_interval;
mod whole_surface;
pub mod point_compliance;
pub mod contact_zone;
pub mod zone_at_start;
pub mod touch_sites;
mod touch_side;
mod line_touch;
pub mod predicted_touch;
pub mod zone_contact;
pub mod zone_on_mesh;
pub mod local_deformation;
pub mod stress;
pub mod simulation;
pub mod imported;
pub mod smooth_fit;
pub mod meshed;
pub mod mode_gradients;
pub mod store;
pub mod mesh_touch;
mod system;
pub mod model;
pub mod impact_monitor;
pub mod plausibility;
pub mod driver;
pub mod detection;
pub mod preview;
pub mod adaptive_contact;
pub mod local_surface;
pub mod interval;
pub mod penalty_search;
pub mod predict;
pub mod fine_model;
pub mod fine_elements;
pub mod paper;
pub mod sizing;
mod wave;

#[cfg(test)]
#[expect(dead_code, reason = "tests of contact-qs use the rest")]
#[path = "../../contact-qs/tests/hertz_impact/mod.rs"]
mod hertz_impact;

pub use error::AdaptiveError;
