//! Transfer of the elastic state between the coarse and the fine model of a body (\[A\]
//! section 4.4; theory section A.6).
//!
//! Both ways are linear maps of the elastic coordinates, the same for coordinates and rates. By
//! default they are mass-orthogonal projections; \[A\]'s own ways, least squares on control values
//! and element-wise interpolation at Gauss points, are there for comparison.

use faer::linalg::solvers::SolveLstsq;
use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::blocks::dense;
use ffr_dynamics::reduction::modal::ReducedBasis;
use iga_core::nurbs::patch::PointBasis;
use iga_core::quadrature::GaussRule;
use iga_core::space::{Space, SplineSpace};

use crate::body::fine::refined::FineBody;
use crate::body::splines::ElasticBody;
use crate::error::AdaptiveError;
use crate::spec::TransferMethod;

/// The two maps between the elastic coordinates of a body's models.
#[derive(Debug, Clone)]
pub struct StateTransfer {
    /// Fine coordinates from coarse ones, n_fine x n_coarse.
    pub to_fine: Mat<f64>,
    /// Coarse coordinates from fine ones, n_coarse x n_fine.
    pub to_coarse: Mat<f64>,
}

impl StateTransfer {
    /// The maps between a coarse model with its modes and a fine model with its low-frequency
    /// modes.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] if the projected modes are linearly dependent.
    pub fn new(
        method: TransferMethod,
        coarse: (&ElasticBody, &ReducedBasis),
        fine: (&FineBody, &ReducedBasis),
    ) -> Result<Self, AdaptiveError> {
        let fail = |source| AdaptiveError::Reduction { body: coarse.0.name.clone(), source };
        let coarse_shapes = coarse.1.shapes.as_ref();
        let prolonged = fine.0.prolong(&coarse.0.assembled, coarse_shapes);
        let fine_shapes = fine.1.shapes.as_ref();
        match method {
            TransferMethod::MassOrthogonal => {
                let body = &fine.0.assembled;
                let to_fine = mass_projection(body, fine_shapes, prolonged.as_ref()).map_err(fail)?;
                let to_coarse = mass_projection(body, prolonged.as_ref(), fine_shapes).map_err(fail)?;
                Ok(Self { to_fine, to_coarse })
            }
            TransferMethod::Printed => {
                let restricted = interpolated_at_gauss_points(coarse.0, fine.0, fine_shapes);
                let to_fine = fine_shapes.qr().solve_lstsq(&prolonged);
                let to_coarse = coarse_shapes.qr().solve_lstsq(&restricted);
                Ok(Self { to_fine, to_coarse })
            }
        }
    }

    /// Fine coordinates or rates.
    pub fn fine(&self, coarse: &[f64]) -> Vec<f64> {
        product(&self.to_fine, coarse)
    }

    /// Coarse coordinates or rates.
    pub fn coarse(&self, fine: &[f64]) -> Vec<f64> {
        product(&self.to_coarse, fine)
    }
}

fn product(a: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..a.nrows()).map(|i| x.iter().enumerate().map(|(j, x)| a[(i, j)] * x).sum()).collect()
}

/// Coordinates in `basis` of the fields `shapes`, best in kinetic energy: `(BᵀMB)⁻¹ BᵀM S`
/// (Eqs. A.28, A.29).
///
/// # Errors
/// [`DynamicsError::NotPositiveDefinite`] if the basis is linearly dependent.
pub fn mass_projection(
    body: &AssembledBody,
    basis: MatRef<'_, f64>,
    shapes: MatRef<'_, f64>,
) -> Result<Mat<f64>, DynamicsError> {
    let mass_basis = body.mass_product(basis);
    let mut gram = dense::product(basis.transpose(), mass_basis.as_ref());
    dense::symmetrise(&mut gram);
    let factor = dense::cholesky(gram, "mass of the modes")?;
    let mut coordinates = dense::product(mass_basis.transpose(), shapes);
    dense::solve_lower(factor.as_ref(), coordinates.as_mut());
    dense::solve_lower_transposed(factor.as_ref(), coordinates.as_mut());
    Ok(coordinates)
}

/// Displacements of the coarse unknowns that agree with the fine fields `shapes` (n_fine x k) at
/// the Gauss points of each coarse element, averaged over the elements (\[A\] (12) to (17)).
///
/// An element with tied functions has fewer of them than Gauss points: least squares there.
pub fn interpolated_at_gauss_points(
    coarse: &ElasticBody,
    fine: &FineBody,
    shapes: MatRef<'_, f64>,
) -> Mat<f64> {
    let n_components = fine.motion.n_components();
    let n_fields = shapes.ncols() * n_components;
    let n_nodes = coarse.space.n_functions();
    let (mut sums, mut counts) = (Mat::<f64>::zeros(n_nodes, n_fields), vec![0.0; n_nodes]);
    let (mut basis, mut active) = (PointBasis::default(), Vec::new());
    for e in 0..coarse.space.n_elements() {
        let points = gauss_points(coarse, e);
        coarse.space.active_functions(e, &mut active);
        let mut values = Mat::<f64>::zeros(points.len(), active.len());
        let mut fields = Mat::<f64>::zeros(points.len(), n_fields);
        for (i, xi) in points.iter().enumerate() {
            coarse.space.evaluate(e, xi, 0, &mut basis);
            basis.values.iter().enumerate().for_each(|(a, v)| values[(i, a)] = *v);
            for (node, value) in fine.space.functions_at(fine.space.find_element(0, xi), xi) {
                for c in 0..n_components {
                    let Some(row) = fine.lookup.number(node, c) else { continue };
                    for k in 0..shapes.ncols() {
                        fields[(i, k * n_components + c)] += value * shapes[(row, k)];
                    }
                }
            }
        }
        let local = values.qr().solve_lstsq(&fields);
        for (a, &node) in active.iter().enumerate() {
            counts[node as usize] += 1.0;
            for k in 0..n_fields {
                sums[(node as usize, k)] += local[(a, k)];
            }
        }
    }
    Mat::from_fn(coarse.assembled.n_unknowns(), shapes.ncols(), |i, k| {
        let dof = coarse.assembled.dofs[i];
        let node = dof.node as usize;
        sums[(node, k * n_components + dof.component as usize)] / counts[node]
    })
}

/// The `p + 1` Gauss points per direction of a coarse element.
fn gauss_points(coarse: &ElasticBody, e: usize) -> Vec<[f64; 3]> {
    let element = coarse.space.element(e);
    let mut points = vec![[0.0; 3]];
    for (d, knots) in coarse.shape.patches[element.patch].knots().iter().enumerate() {
        let rule = GaussRule::new(knots.degree() + 1);
        let (a, b) = (element.lower[d], element.upper[d]);
        let along = |xi: [f64; 3]| {
            let place = move |x: &f64| {
                let mut xi = xi;
                xi[d] = 0.5 * (a + b) + 0.5 * (b - a) * x;
                xi
            };
            rule.points.iter().map(place).collect::<Vec<_>>()
        };
        points = points.into_iter().flat_map(along).collect();
    }
    points
}
