//! Results against closed forms and independent computations; docs/verification.md lists every case with its figures.

mod adaptive_impacts;
mod cylinder;
mod double_pendulum;
mod impacts_rod;
mod impacts_sphere;
mod multibody;
mod rods;
mod solvers_sphere;
mod spheres;
pub mod support;
