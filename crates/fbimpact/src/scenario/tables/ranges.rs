//! Ranges that several tables share.

use super::super::keys::Range;

/// Lengths \[m\]: no body is larger than a thousand kilometres.
pub(super) const LENGTH: Range = Range::positive(1e6);
/// Coordinates \[m\].
pub(super) const COORDINATE: Range = Range::within(1e6);
/// Speeds [m/s] and rates [rad/s]; linear elasticity ends long before.
pub(super) const RATE: Range = Range::within(1e6);
/// Highest spline degree, that of `iga_core::splines::knots::MAX_DEGREE`.
pub(super) const MAX_DEGREE: u64 = iga_core::splines::knots::MAX_DEGREE as u64;
/// Angles of parts of a turn \[rad\].
pub(super) const TURN: Range = Range::open(0.0, std::f64::consts::TAU);
