//! The motion of a result, taken up from its file: models built again from the scenario that it
//! carries, states at the stored instants, and the quasistatic displacement of contact zones, which
//! no coordinate holds.

pub mod zones;
pub mod states;
pub mod local;
pub mod rebuilt;
