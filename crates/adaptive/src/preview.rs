//! Hertz's force, or that of a line contact, between two material points: a cheap preview of an impact, from which the first
//! fine model is sized.

use contact_qs::{ContactElement, ContactReport};
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
use nalgebra::Vector3;

use crate::predict::ImpactLaw;

/// A point of a body, or of space.
#[derive(Debug, Clone)]
pub struct HertzPoint {
    /// Index of the body; none for a fixed point.
    pub body: Option<usize>,
    /// The point in the body's frame, or in space.
    pub point: FlexiblePoint,
}

impl HertzPoint {
    fn place(&self, bodies: &[BodyState]) -> Vector3<f64> {
        self.body.map_or(self.point.position, |b| self.point.position(&bodies[b]))
    }
}

/// The force of an impact's law along a fixed normal between two points that touch at the start.
///
/// The bodies keep their dynamic modes, so that waves and joints count; only the contact zone is that of the law. Points stay
/// where they are: good for the time of an impact.
#[derive(Debug, Clone)]
pub struct PointImpact {
    contact: HertzPoint,
    target: HertzPoint,
    normal: Vector3<f64>,
    /// Gap of the points where the surfaces touch \[m\].
    offset: f64,
    law: ImpactLaw,
    report: ContactReport,
}

impl PointImpact {
    /// A contact that opens and closes at the gap that the points have in the motion `bodies`.
    pub fn new(
        contact: HertzPoint,
        target: HertzPoint,
        normal: Vector3<f64>,
        law: ImpactLaw,
        bodies: &[BodyState],
    ) -> Self {
        let mut impact = Self { contact, target, normal, offset: 0.0, law, report: ContactReport::default() };
        impact.offset = impact.gap(bodies);
        impact
    }

    fn gap(&self, bodies: &[BodyState]) -> f64 {
        (self.contact.place(bodies) - self.target.place(bodies)).dot(&self.normal) - self.offset
    }
}

impl ForceElement for PointImpact {
    fn apply(
        &mut self,
        _: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let approach = (-self.gap(bodies)).max(0.0);
        let (force, energy) = self.law.force(approach);
        self.report.normal_force = force;
        self.report.force = self.normal * force;
        self.report.n_active = usize::from(force > 0.0);
        self.report.energies.elastic_high = energy;
        let mut push = |p: &HertzPoint, f: Vector3<f64>| {
            if let Some(b) = p.body {
                p.point.add_force(&bodies[b], &f, &mut forces[b]);
            }
        };
        if force > 0.0 {
            push(&self.contact, self.report.force);
            push(&self.target, -self.report.force);
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
}

impl ContactElement for PointImpact {
    fn kind(&self) -> &'static str {
        "point-impact"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.contact.body.unwrap_or(0), self.target.body)
    }

    fn smallest_gap(&self, bodies: &[BodyState]) -> f64 {
        self.gap(bodies)
    }

    fn normal(&self, _: &[BodyState]) -> Vector3<f64> {
        self.normal
    }

    fn place(&self, bodies: &[BodyState]) -> Vector3<f64> {
        self.contact.place(bodies)
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
