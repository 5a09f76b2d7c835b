//! Points and frames that move with flexible bodies.

pub mod marker;
pub mod marker_frame;
pub mod marker_weights;

pub use marker::FlexiblePoint;
pub use marker_frame::{Marker, MarkerMotion};
pub use marker_weights::MarkerWeights;
