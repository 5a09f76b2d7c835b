//! A sphere on a body.
//!
//! The force acts along the line through the centre, so that it may be applied at the centre: no
//! moment about it. The sphere follows the body's point that carries its centre; its own
//! deformation is the approach `δ` of Hertz's law.

use ffr_dynamics::data_error::DataError;
use ffr_dynamics::force::BodyState;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use nalgebra::Vector3;

use crate::law::{HertzPair, Solid};
use crate::{ContactError, Target};

/// A sphere that belongs to a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Sphere {
    /// Index of the body in the lists given to
    /// [`ffr_dynamics::force::ForceElement::evaluate`].
    pub body: usize,
    /// Its centre; any point of the body, which need not be the frame's origin.
    pub centre: FlexiblePoint,
    /// Radius \[m\].
    pub radius: f64,
    /// Elastic constants.
    pub solid: Solid,
}

impl Sphere {
    /// Gap to `target` in the motions `bodies` \[m\], unit normal towards the sphere, and the
    /// points where both are nearest; none where centres coincide.
    pub fn nearest(
        &self,
        target: Target<&Sphere>,
        bodies: &[BodyState],
    ) -> Option<(f64, Vector3<f64>, [Vector3<f64>; 2])> {
        let centre = self.centre.position(&bodies[self.body]);
        match target {
            Target::Plane(plane) => {
                let normal = plane.normal.into_inner();
                let gap = (centre - plane.point).dot(&normal) - self.radius;
                let point = centre - normal * self.radius;
                Some((gap, normal, [point, point - normal * gap]))
            }
            Target::Body(other) => {
                let to = other.centre.position(&bodies[other.body]);
                let line = centre - to;
                let distance = line.norm();
                let normal = line / distance;
                let points = [centre - normal * self.radius, to + normal * other.radius];
                normal.x.is_finite().then_some((distance - self.radius - other.radius, normal, points))
            }
        }
    }

    /// Checks that radius and constants are positive and the centre finite.
    ///
    /// # Errors
    /// [`ContactError::Data`] with the value.
    pub(crate) fn validate(&self) -> Result<(), ContactError> {
        if !(self.radius > 0.0 && self.radius.is_finite()) {
            let what = "the radius of a sphere [m]".into();
            return Err(DataError::OutOfRange { what, value: self.radius, range: "> 0 and finite" }.into());
        }
        if !self.centre.position.iter().all(|x| x.is_finite()) {
            return Err(DataError::NotFinite { what: "the centre of a sphere".into() }.into());
        }
        check_solid(self.solid)
    }
}

/// Checks elastic constants; an infinite modulus stands for a rigid partner.
pub(crate) fn check_solid(solid: Solid) -> Result<(), ContactError> {
    let has_poisson = (-1.0..=0.5).contains(&solid.poisson);
    if solid.young > 0.0 && has_poisson {
        return Ok(());
    }
    Err(if has_poisson {
        DataError::OutOfRange { what: "Young's modulus [Pa]".into(), value: solid.young, range: "> 0" }
    } else {
        let range = "between -1 and 0.5";
        DataError::OutOfRange { what: "Poisson's ratio".into(), value: solid.poisson, range }
    }
    .into())
}

/// Pair of `solids` and `radii`, refused if both partners are rigid.
pub(crate) fn hertz_pair(solids: [Solid; 2], radii: [f64; 2]) -> Result<HertzPair, ContactError> {
    let pair = HertzPair::new(solids, radii);
    if pair.stiffness().is_finite() {
        return Ok(pair);
    }
    Err(ContactError::RigidPair)
}
