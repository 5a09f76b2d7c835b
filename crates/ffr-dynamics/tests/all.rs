//! All tests of the crate, in one executable: a file that is not named here is not run (`scripts/check_layers.py` looks).
#![expect(clippy::unwrap_used, reason = "a failure there fails the test")]

mod bearing_friction;
mod common;
mod dynamics_allocation;
mod dynamics_damping;
mod dynamics_inertia;
mod dynamics_integration;
mod dynamics_interaction;
mod dynamics_motion;
mod dynamics_support;
mod exact_vibration;
mod free_motion;
mod gauss;
mod gears;
mod general_mass;
mod geometric_stiffening;
mod held_damping;
mod integrator_protocol;
mod joint_travel;
mod marker_weights;
mod multibody_equations;
mod multibody_internal_coordinates;
mod multibody_motion;
mod multibody_reactions;
mod multibody_tr_bdf2;
mod multibody_vibration;
mod oracles;
mod reduction_factor;
mod reduction_interface;
mod reduction_modes;
mod reduction_rounded;
mod reduction_static;
mod small_equations;
mod spinning;
mod tr_bdf2;
mod tr_bdf2_bodies;
