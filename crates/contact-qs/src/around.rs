//! What stands around a contact of any law: its mirror image, damping of its forces, zones that vibrate.

pub mod mutual;
pub mod damped_contact;
pub mod vibrating_zone;
