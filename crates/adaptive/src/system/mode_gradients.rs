//! Gradients and stresses of the modes of a body at points all over it (docs/theory.md Eq. P.13).

use contact_qs::zone::points::DofLookup;
use faer::{Mat, MatRef};
use iga_core::SplineError;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::recovery::RecoveryWorkspace;
use iga_core::space::{GridBasis, Integrand};
use nalgebra::{Matrix3, Vector3};

use crate::body::field::Field;
use crate::error::AdaptiveError;
use crate::system::imported::ImportedModel;

/// Gradients and stresses of the modes at a point of a body.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GradientsAt {
    /// Mass about the point \[kg\].
    pub mass: f64,
    /// Density there [kg/m³].
    pub density: f64,
    /// `∂φ_i/∂x_j` of each mode.
    pub gradients: Vec<Matrix3<f64>>,
    /// Stress of each mode; empty where it is not known.
    pub stresses: Vec<Matrix3<f64>>,
}

/// Gives the points of a body one after another.
pub trait ModeFields {
    /// Calls `take` with every point; the masses of all points are those of a quadrature of the
    /// body.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] or [`AdaptiveError::Mesh`] if the body cannot be evaluated.
    fn for_each_point(&self, take: &mut dyn FnMut(GradientsAt)) -> Result<(), AdaptiveError>;
}

/// A flexible body with modes.
pub struct FieldModes<'a> {
    /// Its displacements.
    pub field: &'a dyn Field,
    /// Modes at its unknowns.
    pub shapes: MatRef<'a, f64>,
}

impl ModeFields for FieldModes<'_> {
    fn for_each_point(&self, take: &mut dyn FnMut(GradientsAt)) -> Result<(), AdaptiveError> {
        self.for_each(take).map_err(|source| self.field.geometry_fault(source))
    }
}

impl FieldModes<'_> {
    fn for_each(&self, take: &mut dyn FnMut(GradientsAt)) -> Result<(), SplineError> {
        let (space, model, lookup) = (self.field.space(), self.field.model(), self.field.lookup());
        let (mut work, mut rule) = (RecoveryWorkspace::default(), GridBasis::default());
        // All modes of an unknown side by side, as they are read.
        let by_unknown = self.shapes.transpose().to_owned();
        for e in 0..space.n_elements() {
            let material = self.field.materials().on(e);
            let density = material.density();
            space.tabulate(e, Integrand::Sample, &mut rule);
            for (xi, weight) in rule.parameters.iter().zip(&rule.weights) {
                let functions = work.functions(space, e, xi)?;
                let mass = density * weight * work.determinant(space, e, xi)?;
                let slopes = functions.iter().map(|f| (f.number, f.gradient));
                let gradients = gradients(slopes, lookup, &by_unknown, model.dimension());
                let stress = |g: &Matrix3<f64>| {
                    let rows = std::array::from_fn(|i| std::array::from_fn(|j| g[(i, j)]));
                    tensor(&PointState::new(model, material, &rows, g[(0, 0)]).stress)
                };
                let stresses = gradients.iter().map(stress).collect();
                take(GradientsAt { mass, density, gradients, stresses });
            }
        }
        Ok(())
    }
}

impl ModeFields for &ImportedModel {
    /// The markers, each as a part of the body that turns with it; its stress is not known.
    fn for_each_point(&self, take: &mut dyn FnMut(GradientsAt)) -> Result<(), AdaptiveError> {
        let mass = self.data.mass / self.markers().len().max(1) as f64;
        for marker in self.markers() {
            let turn = |j: usize| Vector3::from_fn(|c, _| marker.rotation_row(c)[j]).cross_matrix();
            let gradients = (0..marker.n_modes()).map(turn).collect();
            take(GradientsAt { mass, density: 1.0, gradients, stresses: Vec::new() });
        }
        Ok(())
    }
}

/// Gradients of all modes, rows of `by_unknown`, from those of the functions; components that are held do not move.
fn gradients(
    slopes: impl Iterator<Item = (u32, [f64; 3])>,
    lookup: &DofLookup,
    by_unknown: &Mat<f64>,
    n_components: usize,
) -> Vec<Matrix3<f64>> {
    let mut sums = vec![Matrix3::zeros(); by_unknown.nrows()];
    for (function, slope) in slopes {
        for c in 0..n_components {
            let Some(row) = lookup.number(function, c) else { continue };
            for (sum, value) in sums.iter_mut().zip(by_unknown.col_as_slice(row)) {
                slope.iter().enumerate().for_each(|(k, s)| sum[(c, k)] += value * s);
            }
        }
    }
    sums
}

/// The tensor of six stresses xx, yy, zz, xy, yz, zx.
fn tensor(s: &[f64; 6]) -> Matrix3<f64> {
    Matrix3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2])
}
