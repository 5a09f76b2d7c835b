//! Bodies joined to a multibody system: markers, joints, loads ([`joints`]), and where it starts ([`start`]).

pub mod joints;
pub mod start;
