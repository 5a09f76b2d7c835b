//! Exact shapes of bodies.

use iga_core::SplineError;
use iga_core::elasticity::Model;
use iga_core::knots::KnotVector;
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{axisymmetric, plane, solid, sphere};
use iga_core::nurbs::{Patch, Shape};

use crate::scenario::{self, ElasticModel, Geometry};

/// The model of the library.
pub fn model(model: ElasticModel) -> Model {
    match model {
        ElasticModel::Solid => Model::Solid,
        ElasticModel::Axisymmetric => Model::Axisymmetric,
        ElasticModel::PlaneStrain { thickness } => Model::PlaneStrain { thickness },
        ElasticModel::PlaneStress { thickness } => Model::PlaneStress { thickness },
    }
}

/// The exact shape; `degree` decides on the net of a ball where none is named.
///
/// # Errors
/// [`SplineError`] for impossible lengths and nets.
pub fn shape(geometry: &Geometry, model: ElasticModel, degree: usize) -> Result<Shape, SplineError> {
    let is_axisymmetric = model == ElasticModel::Axisymmetric;
    match geometry {
        Geometry::Sphere { radius, .. } if is_axisymmetric => axisymmetric::sphere(*radius),
        Geometry::Sphere { radius, net } => {
            sphere::sphere(*radius, net.map_or(SphereNet::for_degree(degree), sphere_net))
        }
        Geometry::Rod { radius, length } => axisymmetric::rod(*radius, *length),
        Geometry::RodSphericalEnd { radius, length } => axisymmetric::rod_spherical_end(*radius, *length),
        Geometry::Cylinder { radius, length } => solid::cylinder(*radius, *length),
        Geometry::HollowCylinder { inner_radius, outer_radius, length } if is_axisymmetric => {
            axisymmetric::hollow_cylinder(*inner_radius, *outer_radius, *length)
        }
        Geometry::HollowCylinder { inner_radius, outer_radius, length } => {
            solid::hollow_cylinder(*inner_radius, *outer_radius, *length)
        }
        Geometry::Box { size } => solid::cuboid(*size),
        Geometry::Rectangle { size } => plane::rectangle(size[0], size[1]),
        Geometry::Disc { radius } => plane::disc(*radius),
        Geometry::Nurbs(net) => {
            let knots = net.degrees.iter().zip(&net.knots).map(|(&p, k)| KnotVector::new(p, k.clone()));
            let knots = knots.collect::<Result<Vec<_>, _>>()?;
            let patch = Patch::new(knots, net.control_points.clone(), net.weights.clone())?;
            let shape = Shape::from_patches(vec![patch])?;
            shape.check_orientation()?;
            Ok(shape)
        }
    }
}

/// The wanted degrees, raised to those of the exact geometry where they are lower.
pub fn raised(degrees: &[usize], shape: &Shape) -> Vec<usize> {
    let own = |d: usize| shape.patches.iter().map(|p| p.knots()[d].degree()).max().unwrap_or(1);
    degrees.iter().enumerate().map(|(d, &p)| p.max(own(d))).collect()
}

fn sphere_net(net: scenario::SphereNet) -> SphereNet {
    match net {
        scenario::SphereNet::Cube => SphereNet::Cube,
        scenario::SphereNet::Spindle => SphereNet::Spindle,
        scenario::SphereNet::Shells => SphereNet::Shells,
    }
}
