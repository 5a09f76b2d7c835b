//! Gradients and stresses of the modes of a body at points all over it (docs/theory.md Eq. P.15).

use contact_qs::points::DofLookup;
use faer::MatRef;
use iga_core::SplineError;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::{MaterialField, Model};
use iga_core::recovery::RecoveryWorkspace;
use iga_core::space::{GridBasis, Integrand, Space};
use nalgebra::{Matrix3, Vector3};

use crate::elastic_body::ElasticBody;
use crate::error::AdaptiveError;
use crate::imported::ImportedModel;
use crate::spec::MeshedSpec;

/// What the modes do at a point of a body.
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
    /// Calls `take` with every point; the masses of all points are those of a quadrature of the body.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] or [`AdaptiveError::Mesh`] if the body cannot be evaluated.
    fn for_each_point(&self, take: &mut dyn FnMut(GradientsAt)) -> Result<(), AdaptiveError>;
}

/// A body of splines with modes.
pub struct SplineFields<'a> {
    /// The body.
    pub body: &'a ElasticBody,
    /// Modes at its unknowns.
    pub shapes: MatRef<'a, f64>,
}

/// A body of finite elements with modes.
pub struct MeshFields<'a> {
    /// Name of the body.
    pub name: &'a str,
    /// The body.
    pub spec: &'a MeshedSpec,
    /// Numbers of its unknowns.
    pub lookup: &'a DofLookup,
    /// Modes at its unknowns.
    pub shapes: MatRef<'a, f64>,
}

impl ModeFields for SplineFields<'_> {
    fn for_each_point(&self, take: &mut dyn FnMut(GradientsAt)) -> Result<(), AdaptiveError> {
        let (body, spec) = (self.body, &self.body.spec);
        let fields = SpaceFields {
            space: &body.space,
            model: &spec.model,
            materials: &spec.material,
            lookup: &body.lookup,
            shapes: self.shapes,
        };
        fields.for_each(take).map_err(|source| AdaptiveError::Geometry { body: body.name.clone(), source })
    }
}

impl ModeFields for MeshFields<'_> {
    fn for_each_point(&self, take: &mut dyn FnMut(GradientsAt)) -> Result<(), AdaptiveError> {
        let body = || self.name.to_owned();
        let materials =
            self.spec.materials().map_err(|source| AdaptiveError::Mesh { body: body(), source })?;
        let (space, lookup, shapes) = (&self.spec.space(), self.lookup, self.shapes);
        let fields = SpaceFields { space, model: &Model::Solid, materials: &materials, lookup, shapes };
        fields.for_each(take).map_err(|source| AdaptiveError::Geometry { body: body(), source })
    }
}

/// Modes of any space.
struct SpaceFields<'a> {
    space: &'a dyn Space,
    model: &'a Model,
    materials: &'a dyn MaterialField,
    lookup: &'a DofLookup,
    shapes: MatRef<'a, f64>,
}

impl SpaceFields<'_> {
    fn for_each(&self, take: &mut dyn FnMut(GradientsAt)) -> Result<(), SplineError> {
        let (space, model) = (self.space, self.model);
        let (mut work, mut rule) = (RecoveryWorkspace::default(), GridBasis::default());
        for e in 0..space.n_elements() {
            let material = self.materials.on(e);
            let density = material.density();
            space.tabulate(e, Integrand::Sample, &mut rule);
            for (xi, weight) in rule.parameters.iter().zip(&rule.weights) {
                let functions = work.functions(space, e, xi)?;
                let mass = density * weight * work.determinant(space, e, xi)?;
                let slopes = functions.iter().map(|f| (f.number, f.gradient));
                let gradients = gradients(slopes, self.lookup, self.shapes, model.dimension());
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

/// Gradients of all modes from those of the functions; components that are held do not move.
fn gradients(
    slopes: impl Iterator<Item = (u32, [f64; 3])>,
    lookup: &DofLookup,
    shapes: MatRef<'_, f64>,
    n_components: usize,
) -> Vec<Matrix3<f64>> {
    let mut sums = vec![Matrix3::zeros(); shapes.ncols()];
    for (function, slope) in slopes {
        for c in 0..n_components {
            let Some(row) = lookup.number(function, c) else { continue };
            for (j, sum) in sums.iter_mut().enumerate() {
                let value = shapes[(row, j)];
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
