//! Rotations, and points and frames that move with flexible bodies.

pub mod rotation;
pub mod exponential;
pub mod marker;
pub mod marker_frame;
pub mod marker_weights;

pub use exponential::RotationVectorRates;
pub use marker::FlexiblePoint;
pub use marker_frame::{Marker, MarkerMotion};
pub use marker_weights::MarkerWeights;
