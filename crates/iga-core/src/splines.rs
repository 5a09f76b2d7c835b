//! Splines of one variable, and nets of several: knots, B-spline and Bernstein polynomials, indices
//! and boxes of parameters.

pub mod knots;
pub mod bernstein;
pub mod basis;
pub mod parameter_box;
pub mod tensor;
