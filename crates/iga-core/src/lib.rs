//! Splines, NURBS geometry and isogeometric linear elasticity.
//!
//! The crate knows knots, patches, elements, materials, sparse matrices and the files in which
//! other programs keep splines. It knows no time, no rigid-body motion and no contact.
//!
//! # Conventions, fixed once for the whole workspace
//!
//! * SI units, radians.
//! * A patch has 1, 2 or 3 parametric directions. Parametric points are `[f64; 3]`, physical points
//!   are `[f64; 3]`; entries beyond the dimension are zero.
//! * Two-dimensional models live in the components 0 and 1 of a physical point: `(x, y)` for plane
//!   strain and plane stress, `(r, z)` for axisymmetric models.
//! * In a tensor-product net the first parametric direction runs fastest: `i + n_0 (j + n_1 k)`.
//! * Local functions of an element are stacked in the order of [`space::Space::active_functions`].
//!
//! Equation numbers refer to `docs/theory.md`.

pub mod error;
pub mod quadrature;
pub mod splines;
pub mod nurbs;
pub mod space;
pub mod hierarchical;
pub mod surface;
pub mod elasticity;
pub mod extent;
pub mod files;

pub use error::SplineError;
pub use splines::parameter_box::ParameterBox;
