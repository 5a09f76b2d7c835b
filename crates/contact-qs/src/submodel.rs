//! A body's contact zone as dense data: points, areas, low-frequency shapes and compliance.

use faer::Mat;
use ffr_dynamics::body::RigidMotion;

/// Everything that contact needs from a reduced body.
///
/// Rows of `low` and rows and columns of `compliance` are ordered `n_components * point + component`, in the components of
/// the body model (`motion.direction(c)` gives each one's direction in space).
#[derive(Debug, Clone)]
pub struct ContactSubmodel {
    /// Rigid motions of the body model.
    pub motion: RigidMotion,
    /// Undeformed contact points in the body's frame, as points in space [m].
    pub points: Vec<[f64; 3]>,
    /// Tributary areas `w_i` [m²]; axisymmetric models carry `2πr`.
    pub areas: Vec<f64>,
    /// Shapes of the dynamic elastic coordinates at the points, `n_components n_points × n_q`.
    pub low: Mat<f64>,
    /// Quasistatic compliance `N_b G N_bᵀ` of the points [m/N]; zero-sized when all modes are dynamic.
    pub compliance: Mat<f64>,
    /// Indices of the points that stand on the rim of the contact zone: contact there means that the zone is too small.
    pub rim: Vec<usize>,
}
