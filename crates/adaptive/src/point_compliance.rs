//! Displacement of observed points by the forces on an interface (docs/theory.md Eq. A.33).

use contact_qs::points::DofLookup;
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::reduction::ResidualFlexibility;
use nalgebra::Vector3;

use crate::error::AdaptiveError;
use crate::simulation::ObservedPoint;

/// Displacement of an observed point by forces at the unknowns of an interface.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCompliance {
    /// Number of the point among those observed.
    pub point: usize,
    /// Index of the body.
    pub body: usize,
    /// Displacement in the body's frame by a unit of each force [m/N].
    pub rows: Vec<Vector3<f64>>,
}

/// Functions that are not zero at a point, with their values.
pub type Functions = Vec<(u32, f64)>;

/// Displacements of points, which `functions` belong to, by unit forces at the interface of `residual`: a row an unknown of the
/// interface, the components of one point after those of the other [m/N].
pub fn point_rows(
    functions: &[Functions],
    lookup: &DofLookup,
    motion: RigidMotion,
    residual: &ResidualFlexibility,
) -> Mat<f64> {
    let (n, interface) = (motion.n_components(), residual.interface());
    if functions.is_empty() {
        return Mat::zeros(interface.len(), 0);
    }
    let mut x = Mat::zeros(residual.n_unknowns(), n * functions.len());
    for (k, functions) in functions.iter().enumerate() {
        for c in 0..n {
            for &(node, value) in functions {
                if let Some(unknown) = lookup.number(node, c) {
                    x[(unknown, n * k + c)] += value;
                }
            }
        }
    }
    residual.apply(x.as_mut());
    Mat::from_fn(interface.len(), x.ncols(), |b, j| x[(interface[b], j)])
}

/// The rows of [`point_rows`] for `points`, which lie on `body`.
pub fn compliances(
    points: &[usize],
    body: usize,
    motion: RigidMotion,
    rows: &Mat<f64>,
) -> Vec<PointCompliance> {
    let n = motion.n_components();
    let row = |k: usize, b: usize| {
        let mut u = Vector3::zeros();
        (0..n).for_each(|c| u[motion.direction(c)] = rows[(b, n * k + c)]);
        u
    };
    let of = |(k, &point): (usize, &usize)| {
        let rows = (0..rows.nrows()).map(|b| row(k, b)).collect();
        PointCompliance { point, body, rows }
    };
    points.iter().enumerate().map(of).collect()
}

/// The points of `all` on `body`: their numbers, and their places in the components of a model with the motions `motion`.
pub fn points_on(all: &[ObservedPoint], body: usize, motion: RigidMotion) -> (Vec<usize>, Vec<[f64; 3]>) {
    let place = |p: &ObservedPoint| motion.components(p.point.position.as_ref());
    let on_body = all.iter().enumerate().filter(|(_, p)| p.body == body);
    on_body.map(|(i, p)| (i, place(p))).unzip()
}

/// Compliances of the points of `all` on a body, its number, motions and unknowns given, whose interface has the flexibility `residual` for the whole
/// run.
///
/// # Errors
/// [`AdaptiveError::Geometry`] if a point is not in the body.
pub fn of_body(
    all: &[ObservedPoint],
    (body, motion, lookup): (usize, RigidMotion, &DofLookup),
    functions_at: impl Fn(&[f64; 3]) -> Result<Functions, AdaptiveError>,
    residual: &ResidualFlexibility,
) -> Result<Vec<PointCompliance>, AdaptiveError> {
    let (points, places) = points_on(all, body, motion);
    if points.is_empty() {
        return Ok(Vec::new());
    }
    let functions: Vec<Functions> = places.iter().map(functions_at).collect::<Result<_, AdaptiveError>>()?;
    Ok(compliances(&points, body, motion, &point_rows(&functions, lookup, motion, residual)))
}
