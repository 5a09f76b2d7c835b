//! Surfaces of bodies: collocation points with their areas, functions on faces, closest points.
//!
//! Outer faces ([`crate::nurbs::face`]) are found from the geometry alone: what collapses, lies on
//! the axis, or touches another face is not outside. Where basis functions matter, they come from a [`crate::space::Space`], so
//! that every kind of space serves (theory section S.5).

pub mod extraction;
pub mod collocation;
pub mod closest_point;

pub use closest_point::{BodySurface, FacePoint};
pub use collocation::{
    CollocationPoint, gauss_points, greville_points, lobatto_points, lobatto_towards, tributary_areas,
};
pub use extraction::{ElementSide, Extraction};
