//! Implicit methods: Runge-Kutta with one iteration matrix, Gauss collocation, the linear systems of
//! their stages, and what makes their iterations end.

pub(super) mod collocation;
mod convergence;
mod jacobian;
mod held_derivative;
mod newton;
mod stage_matrix;
pub(super) mod gauss;
pub(super) mod tableau;
pub(super) mod esdirk;
