//! Detection of contact: how near are two moving, deformed bodies, where, and when do they touch
//! first?
//!
//! [`SurfaceModel`] is built once per body; [`minimum_distance()`] finds the signed gap of two of them (\[A\] (7)),
//! [`plane_distance()`] that of a body and a plane; [`safe_time`] and [`first_touch`] make sure that no step jumps over a
//! contact (docs/theory.md section C.7). It knows no contact law and no integrator.
//!
//! Trees of boxes descended with the best distance so far as the limit, and times of impact by
//! conservative advancement, are common in collision libraries for polyhedra; here the leaves are
//! the exact curved pieces, so the critical points come with their spline parameters and converge
//! to round-off.

mod bezier;
pub(crate) mod boxes;
mod surface_model;
mod deformed;
mod local_shape;
mod signed_distance;
mod query;
mod penetration;
mod minimum_distance;
mod critical_pair;
mod advancement;
mod detector;

pub use advancement::{
    Touch, TouchSettings, closing_speed_bound, first_touch, safe_time, surface_speed_bound,
};
pub use critical_pair::followed_overlap;
pub use deformed::Site;
pub use detector::{BodySurface, Detector, PlaneProximity, plane_distance};
pub use local_shape::LocalShape;
pub use minimum_distance::{Proximity, minimum_distance, reaches_into};
pub use query::way_between;
pub use query::{SearchReport, SearchWorkspace};
pub use surface_model::{SurfaceModel, SurfaceSite};
