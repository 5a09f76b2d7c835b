//! Volume, mass, centre and inertia, by the exact rules of the mass matrix.

use nalgebra::{Matrix3, Vector3};

use crate::jacobian::PointOf;
use crate::matrices::Materials;
use crate::mesh::Mesh;

/// Integrals over a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MassProperties {
    /// Volume \[m³\].
    pub volume: f64,
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\].
    pub centre: Vector3<f64>,
    /// Inertia about the centre of mass [kg m²].
    pub inertia: Matrix3<f64>,
}

impl MassProperties {
    /// Those of `mesh`.
    pub fn new(mesh: &Mesh, materials: &Materials) -> Self {
        let (mut volume, mut mass) = (0.0, 0.0);
        let (mut first, mut second) = (Vector3::zeros(), Matrix3::zeros());
        let (mut at, mut places) = (PointOf::default(), Vec::new());
        for (e, element) in mesh.elements().iter().enumerate() {
            mesh.places(element.nodes, &mut places);
            for point in element.kind.mass_rule() {
                at.evaluate(element.kind, &places, &point.xi);
                let (own, x) = (point.weight * at.determinant, Vector3::from(at.position));
                let weight = own * materials.of(e).density;
                volume += own;
                mass += weight;
                first += x * weight;
                second += x * x.transpose() * weight;
            }
        }
        let centre = first / mass;
        let about = second - centre * centre.transpose() * mass;
        let inertia = Matrix3::identity() * about.trace() - about;
        Self { volume, mass, centre, inertia }
    }
}
