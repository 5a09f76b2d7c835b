//! What stands around a contact of any law: its mirror image and the damping of its forces, zones that vibrate.

pub mod sides;
pub mod vibrating_zone;
