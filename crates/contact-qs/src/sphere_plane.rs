//! Hertz contact of a sphere with a fixed plane, as a force element.

use ffr_dynamics::error::Rejection;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{ContactElement, ContactReport};
use crate::law::{HertzPair, Solid};
use crate::plane::Plane;
use crate::sphere::{Sphere, check_solid, hertz_pair, hertz_report};

/// Hertz contact of a sphere with a fixed plane (docs/theory.md Eqs. F.19, F.20). Energy is booked as `elastic_high`: it is
/// the quasistatic elastic energy of the contact zone.
#[derive(Debug, Clone)]
pub struct SpherePlane {
    sphere: Sphere,
    plane: Plane,
    pair: HertzPair,
    report: ContactReport,
}

impl SpherePlane {
    /// Contact of `sphere` with `plane`, a half space of `solid` ([`Solid::RIGID`] for a rigid one).
    ///
    /// # Errors
    /// [`ContactError::Inconsistent`] if a value is not positive or both partners are rigid.
    pub fn new(sphere: Sphere, plane: Plane, solid: Solid) -> Result<Self, ContactError> {
        sphere.validate()?;
        check_solid(solid)?;
        let pair = hertz_pair([sphere.solid, solid], [sphere.radius, f64::INFINITY])?;
        Ok(Self { sphere, plane, pair, report: ContactReport::default() })
    }

    /// Modulus and radius of the pair.
    pub fn pair(&self) -> HertzPair {
        self.pair
    }

    fn gap(&self, state: &BodyState) -> f64 {
        (self.sphere.centre.position(state) - self.plane.point).dot(&self.plane.normal) - self.sphere.radius
    }
}

impl ForceElement for SpherePlane {
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), Rejection> {
        let state = &bodies[self.sphere.body];
        self.report = hertz_report(self.pair, self.gap(state), self.plane.normal.into_inner(), t)?;
        if self.report.n_active > 0 {
            self.sphere.centre.add_force(state, &self.report.force, &mut forces[self.sphere.body]);
        }
        Ok(())
    }

    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.report.n_active == 0
    }

    fn save(&mut self) {}

    fn restore(&mut self) {}
}

impl ContactElement for SpherePlane {
    fn kind(&self) -> &'static str {
        "sphere-plane"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.sphere.body, None)
    }

    fn smallest_gap(&self, bodies: &[BodyState]) -> f64 {
        self.gap(&bodies[self.sphere.body])
    }

    fn normal(&self, _bodies: &[BodyState]) -> Vector3<f64> {
        self.plane.normal.into_inner()
    }

    fn report(&self) -> &ContactReport {
        &self.report
    }

    fn penalty(&self) -> f64 {
        f64::INFINITY
    }

    fn n_points(&self) -> usize {
        1
    }
}
