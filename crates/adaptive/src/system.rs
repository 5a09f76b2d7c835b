//! The bodies of a run, flexible, rigid ([`rigid_surface`]) or from files ([`imported`]), as one
//! [`body::BodyModel`]; joined to a multibody system by markers, joints and loads ([`joints`]), and
//! where it starts ([`start`]). Knows no contacts.

pub mod imported;
pub mod mode_gradients;
pub mod rigid_surface;
pub mod body;
pub mod frequency_errors;
pub mod joints;
pub mod start;
pub(crate) mod whole_surface;
