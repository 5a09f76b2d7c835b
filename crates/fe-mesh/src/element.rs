//! Finite elements and their sides, one by one: kinds, shape functions, quadrature rules,
//! Jacobians, sides cut into quadrilaterals.

pub mod kind;
pub mod rules;
pub mod shape;
pub mod jacobian;
pub mod side_pieces;
