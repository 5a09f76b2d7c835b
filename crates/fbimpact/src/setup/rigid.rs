//! Rigid bodies: mass, centre of mass and inertia as given or from the exact shape.

use adaptive::spec::RigidSpec;
use iga_core::SplineError;
use iga_core::elasticity::Model;
use iga_core::mass_properties::MassProperties;
use iga_core::nurbs::Shape;
use nalgebra::{Matrix3, Vector3};

use super::geometry;
use crate::scenario::{RigidBody, RigidMass};

/// A rigid body and its shape, if it has one.
///
/// # Errors
/// [`SplineError`] of a shape that cannot be built.
pub fn rigid_body(body: &RigidBody) -> Result<(RigidSpec, Option<(Shape, Model)>), SplineError> {
    let motion = body.motion;
    match &body.mass {
        RigidMass::Given { mass, centre, inertia } => {
            let (mass, centre_of_mass) = (*mass, Vector3::from(*centre));
            let inertia = matrix(inertia, 1.0);
            Ok((RigidSpec { motion, mass, centre_of_mass, inertia }, None))
        }
        RigidMass::Shape { model, geometry, material } => {
            // Every net of a sphere is exact; that of degree 4 has the mildest weights to integrate.
            let shape = geometry::shape(geometry, *model, 4)?;
            let model = geometry::model(*model);
            let properties = MassProperties::of(&shape, &model)?;
            let spec = RigidSpec {
                motion,
                mass: material.density * properties.volume,
                centre_of_mass: Vector3::from(properties.centre()),
                inertia: matrix(&properties.central_inertia(), material.density),
            };
            Ok((spec, Some((shape, model))))
        }
    }
}

fn matrix(rows: &[[f64; 3]; 3], factor: f64) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| factor * rows[i][j])
}
