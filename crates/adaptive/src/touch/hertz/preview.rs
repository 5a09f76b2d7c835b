//! Hertz's force, or that of a line contact, between two material points: a cheap preview of an
//! impact, from which the first fine model is sized.

use contact_qs::{ContactElement, ContactReport};
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::{BodyState, ForceElement, GeneralisedForce, Motion};
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use nalgebra::Vector3;

use crate::touch::hertz::ImpactLaw;

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
/// The bodies keep their dynamic modes, so that waves and joints count; only the contact zone is
/// that of the law. Points stay where they are: good for the time of an impact.
#[derive(Debug, Clone)]
pub struct PointImpact {
    contact: HertzPoint,
    target: HertzPoint,
    normal: Vector3<f64>,
    /// Gap of the points where the surfaces touch \[m\].
    offset: f64,
    law: ImpactLaw,
}

impl PointImpact {
    /// A contact whose surfaces have the given gap in the motion `bodies`.
    pub fn new(
        contact: HertzPoint,
        target: HertzPoint,
        normal: Vector3<f64>,
        law: ImpactLaw,
        bodies: &[BodyState],
        gap: f64,
    ) -> Self {
        let mut impact = Self { contact, target, normal, offset: 0.0, law };
        impact.offset = impact.gap(bodies) - gap;
        impact
    }

    fn gap(&self, bodies: &[BodyState]) -> f64 {
        (self.contact.place(bodies) - self.target.place(bodies)).dot(&self.normal) - self.offset
    }
}

impl ForceElement for PointImpact {
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
        let approach = (-self.gap(motion.bodies)).max(0.0);
        let (force, energy) = self.law.force(approach);
        found.normal_force = force;
        found.force = self.normal * force;
        found.n_active = usize::from(force > 0.0);
        found.energies.elastic_high = energy;
        let mut push = |p: &HertzPoint, f: Vector3<f64>| {
            if let Some(b) = p.body {
                p.point.add_force(&motion.bodies[b], &f, &mut forces[b]);
            }
        };
        if force > 0.0 {
            push(&self.contact, found.force);
            push(&self.target, -found.force);
        }
        Ok(())
    }
}

impl ContactElement for PointImpact {
    fn kind(&self) -> &'static str {
        "point-impact"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.contact.body.unwrap_or(0), self.target.body)
    }

    fn smallest_gap(&self, motion: Motion<'_>, (): &(), (): &mut ()) -> f64 {
        self.gap(motion.bodies)
    }

    fn normal(&self, _: Motion<'_>, (): &(), (): &mut ()) -> Vector3<f64> {
        self.normal
    }

    fn place(&self, motion: Motion<'_>, (): &(), (): &mut ()) -> Vector3<f64> {
        self.contact.place(motion.bodies)
    }

    fn penalty(&self) -> f64 {
        f64::INFINITY
    }

    fn n_points(&self) -> usize {
        1
    }
}
