//! What stands around a contact of any law: damping of its forces, zones that vibrate.

pub mod damped_contact;
pub mod vibrating_zone;
