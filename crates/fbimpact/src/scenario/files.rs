//! What a scenario takes from files, and control nets that stand in their place.

mod columns;
pub(super) mod curves;
pub(super) mod curve_doubts;
pub(super) mod spline_nets;
pub(super) mod bodies;
