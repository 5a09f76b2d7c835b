//! Hertz contact of a sphere with a fixed plane or with a sphere on another body, as a force element.

use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::system::force::{BodyState, ForceElement, GeneralisedForce, Motion};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{ContactElement, ContactReport};
use crate::law::{HertzPair, Solid};
use crate::plane::Plane;
use crate::sphere::{Sphere, check_solid, hertz_pair, hertz_report};

/// Hertz contact of a sphere (docs/theory.md Eqs. F.19, F.20): a force along the line through its centre and, on another sphere,
/// its opposite, so that linear and angular momentum stay. Energy is booked as `elastic_high`: it is the quasistatic elastic
/// energy of the contact zone.
#[derive(Debug, Clone)]
pub struct SphereContact {
    sphere: Sphere,
    target: Target,
    pair: HertzPair,
}

#[derive(Debug, Clone)]
enum Target {
    Plane(Plane),
    Sphere(Sphere),
}

impl SphereContact {
    /// Contact of `sphere` with `plane`, a half space of `solid` ([`Solid::RIGID`] for a rigid one).
    ///
    /// # Errors
    /// [`ContactError::Data`] if a value is not positive or both partners are rigid.
    pub fn with_plane(sphere: Sphere, plane: Plane, solid: Solid) -> Result<Self, ContactError> {
        sphere.validate()?;
        check_solid(solid)?;
        let pair = hertz_pair([sphere.solid, solid], [sphere.radius, f64::INFINITY])?;
        Ok(Self { sphere, target: Target::Plane(plane), pair })
    }

    /// Contact of `sphere`, on the contact body, with the sphere `target`.
    ///
    /// # Errors
    /// [`ContactError::Data`] if a value is not positive, both spheres are rigid, or both belong to one body.
    pub fn with_sphere(sphere: Sphere, target: Sphere) -> Result<Self, ContactError> {
        sphere.validate()?;
        target.validate()?;
        if sphere.body == target.body {
            return Err(ContactError::OneBody { body: sphere.body });
        }
        let pair = hertz_pair([sphere.solid, target.solid], [sphere.radius, target.radius])?;
        Ok(Self { sphere, target: Target::Sphere(target), pair })
    }

    /// Modulus and radius of the pair.
    pub fn pair(&self) -> HertzPair {
        self.pair
    }

    /// Gap and unit normal towards the sphere; NaN where the centres of two spheres coincide.
    fn approach(&self, bodies: &[BodyState]) -> (f64, Vector3<f64>) {
        let sphere = &self.sphere;
        let centre = sphere.centre.position(&bodies[sphere.body]);
        match &self.target {
            Target::Plane(plane) => {
                let gap = (centre - plane.point).dot(&plane.normal) - sphere.radius;
                (gap, plane.normal.into_inner())
            }
            Target::Sphere(other) => {
                let line = centre - other.centre.position(&bodies[other.body]);
                let distance = line.norm();
                let normal = line / distance;
                if normal.x.is_finite() {
                    (distance - sphere.radius - other.radius, normal)
                } else {
                    (f64::NAN, Vector3::repeat(f64::NAN))
                }
            }
        }
    }
}

impl ForceElement for SphereContact {
    type State = ();
    type Workspace = ();
    type Found = ContactReport;

    fn start(&self) -> ((), (), ContactReport) {
        Default::default()
    }

    fn evaluate(
        &self,
        motion: Motion<'_>,
        (): &mut (),
        (): &mut (),
        found: &mut ContactReport,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let (gap, normal) = self.approach(motion.bodies);
        *found = hertz_report(self.pair, gap, normal, motion.time)?;
        if found.n_active > 0 {
            let mut push = |sphere: &Sphere, force: Vector3<f64>| {
                sphere.centre.add_force(&motion.bodies[sphere.body], &force, &mut forces[sphere.body]);
            };
            push(&self.sphere, found.force);
            if let Target::Sphere(other) = &self.target {
                push(other, -found.force);
            }
        }
        Ok(())
    }
}

impl ContactElement for SphereContact {
    fn kind(&self) -> &'static str {
        match self.target {
            Target::Plane(_) => "sphere-plane",
            Target::Sphere(_) => "sphere-sphere",
        }
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        let target = match &self.target {
            Target::Plane(_) => None,
            Target::Sphere(other) => Some(other.body),
        };
        (self.sphere.body, target)
    }

    fn smallest_gap(&self, motion: Motion<'_>, (): &(), (): &mut ()) -> f64 {
        self.approach(motion.bodies).0
    }

    fn normal(&self, motion: Motion<'_>, (): &(), (): &mut ()) -> Vector3<f64> {
        self.approach(motion.bodies).1
    }

    fn place(&self, motion: Motion<'_>, (): &(), (): &mut ()) -> Vector3<f64> {
        let (gap, normal) = self.approach(motion.bodies);
        let sphere = &self.sphere;
        // In the middle of the overlap.
        sphere.centre.position(&motion.bodies[sphere.body]) - normal * (sphere.radius + 0.5 * gap.min(0.0))
    }

    fn penalty(&self) -> f64 {
        f64::INFINITY
    }

    fn n_points(&self) -> usize {
        1
    }
}
