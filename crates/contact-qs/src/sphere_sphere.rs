//! Hertz contact of two spheres on two bodies, as a force element.

use ffr_dynamics::error::Rejection;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{ContactElement, ContactReport};
use crate::law::HertzPair;
use crate::sphere::{Sphere, hertz_pair, hertz_report};

/// Hertz contact of two spheres (docs/theory.md Eqs. F.19, F.20): equal and opposite forces along the line through the
/// centres, so that linear and angular momentum stay. Energy is booked as `elastic_high`: it is the quasistatic elastic
/// energy of the contact zone.
#[derive(Debug, Clone)]
pub struct SphereSphere {
    spheres: [Sphere; 2],
    pair: HertzPair,
    report: ContactReport,
}

impl SphereSphere {
    /// Contact of the first sphere, the contact body, with the second.
    ///
    /// # Errors
    /// [`ContactError::Inconsistent`] if a value is not positive, both spheres are rigid, or both belong to one body.
    pub fn new(spheres: [Sphere; 2]) -> Result<Self, ContactError> {
        let [a, b] = &spheres;
        a.validate()?;
        b.validate()?;
        if a.body == b.body {
            let reason = format!("both spheres of a contact belong to body {}, name two bodies", a.body);
            return Err(ContactError::Inconsistent { reason });
        }
        let pair = hertz_pair([a.solid, b.solid], [a.radius, b.radius])?;
        Ok(Self { spheres, pair, report: ContactReport::default() })
    }

    /// Modulus and radius of the pair.
    pub fn pair(&self) -> HertzPair {
        self.pair
    }

    /// Gap and unit vector from the second centre to the first; NaN where the centres coincide.
    fn approach(&self, bodies: &[BodyState]) -> (f64, Vector3<f64>) {
        let [a, b] = &self.spheres;
        let line = a.centre.position(&bodies[a.body]) - b.centre.position(&bodies[b.body]);
        let distance = line.norm();
        let normal = line / distance;
        if normal.x.is_finite() {
            (distance - a.radius - b.radius, normal)
        } else {
            (f64::NAN, Vector3::repeat(f64::NAN))
        }
    }
}

impl ForceElement for SphereSphere {
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), Rejection> {
        let (gap, normal) = self.approach(bodies);
        self.report = hertz_report(self.pair, gap, normal, t)?;
        if self.report.n_active > 0 {
            for (sphere, sign) in self.spheres.iter().zip([1.0, -1.0]) {
                let force = self.report.force * sign;
                sphere.centre.add_force(&bodies[sphere.body], &force, &mut forces[sphere.body]);
            }
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

impl ContactElement for SphereSphere {
    fn kind(&self) -> &'static str {
        "sphere-sphere"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.spheres[0].body, Some(self.spheres[1].body))
    }

    fn smallest_gap(&self, bodies: &[BodyState]) -> f64 {
        self.approach(bodies).0
    }

    fn normal(&self, bodies: &[BodyState]) -> Vector3<f64> {
        self.approach(bodies).1
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
