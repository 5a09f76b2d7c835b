//! Hertz's force, or that of a line contact, between two material points: a cheap preview of an
//! impact, from which the first fine model is sized.

use contact_qs::{Contact, ContactElement, ContactError, ContactReport, Meeting};
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

/// Stands in a system for a contact whose zones are not there: no force and no gap to look at, or
/// the force of a preview.
#[derive(Debug, Clone)]
pub struct StandIn {
    bodies: (usize, Option<usize>),
    impact: Option<PointImpact>,
}

/// The force of an impact's law along a fixed normal between two points that touch at the start.
///
/// The bodies keep their dynamic modes, so that waves and joints count; only the contact zone is
/// that of the law. Points stay where they are: good for the time of an impact.
#[derive(Debug, Clone)]
struct PointImpact {
    contact: HertzPoint,
    target: HertzPoint,
    normal: Vector3<f64>,
    /// Gap of the points where the surfaces touch \[m\].
    offset: f64,
    law: ImpactLaw,
}

impl StandIn {
    /// For a contact of the `bodies`, the contact body and the target, none of a plane, that is only
    /// watched.
    pub fn inactive(bodies: (usize, Option<usize>)) -> Self {
        Self { bodies, impact: None }
    }

    /// For a preview of a contact whose surfaces have the given gap in the motion `bodies`.
    pub fn preview(
        contact: HertzPoint,
        target: HertzPoint,
        normal: Vector3<f64>,
        law: ImpactLaw,
        bodies: &[BodyState],
        gap: f64,
    ) -> Self {
        let between = (contact.body.unwrap_or(0), target.body);
        let mut impact = PointImpact { contact, target, normal, offset: 0.0, law };
        impact.offset = impact.gap(bodies) - gap;
        Self { bodies: between, impact: Some(impact) }
    }
}

impl PointImpact {
    fn gap(&self, bodies: &[BodyState]) -> f64 {
        (self.contact.place(bodies) - self.target.place(bodies)).dot(&self.normal) - self.offset
    }
}

impl ForceElement for StandIn {
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
        let Some(impact) = &self.impact else { return Ok(()) };
        let approach = (-impact.gap(motion.bodies)).max(0.0);
        let (force, energy) = impact.law.force(approach);
        found.normal_force = force;
        found.force = impact.normal * force;
        found.n_active = usize::from(force > 0.0);
        found.energies.elastic_high = energy;
        let mut push = |p: &HertzPoint, f: Vector3<f64>| {
            if let Some(b) = p.body {
                p.point.add_force(&motion.bodies[b], &f, &mut forces[b]);
            }
        };
        if force > 0.0 {
            push(&impact.contact, found.force);
            push(&impact.target, -found.force);
        }
        Ok(())
    }
}

impl Contact for StandIn {
    fn kind(&self) -> &'static str {
        if self.impact.is_some() { "point-impact" } else { "inactive" }
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        self.bodies
    }

    fn penalty(&self) -> f64 {
        if self.impact.is_some() { f64::INFINITY } else { f64::NAN }
    }

    fn n_points(&self) -> usize {
        usize::from(self.impact.is_some())
    }

    fn point(&self, _: usize) -> Option<([f64; 3], f64)> {
        None
    }
}

impl ContactElement for StandIn {
    fn report<'a>(&self, found: &'a ContactReport) -> &'a ContactReport {
        found
    }

    fn meeting(&self, motion: Motion<'_>, (): &(), (): &mut ()) -> Meeting {
        let nothing = Meeting { gap: f64::INFINITY, normal: Vector3::zeros(), ..Meeting::UNKNOWN };
        self.impact.as_ref().map_or(nothing, |impact| {
            let place = impact.contact.place(motion.bodies);
            Meeting { gap: impact.gap(motion.bodies), normal: impact.normal, place }
        })
    }

    fn point_forces<'a>(&self, _: &'a (), _: &'a ContactReport) -> Option<&'a [f64]> {
        None
    }

    fn friction_forces(&self, (): &(), _: &ContactReport) -> Vec<Vector3<f64>> {
        Vec::new()
    }

    fn prescribe_friction(&self, _: Option<&[Vector3<f64>]>, (): &mut (), _: &ContactReport) {}

    fn set_penalty(&mut self, _: f64, _: &mut ()) -> Result<(), ContactError> {
        Err(ContactError::NoPenalty { kind: self.kind() })
    }

    fn compliance_weight(
        &self,
        _: (Motion<'_>, f64),
        _: &mut (),
        _: &mut (),
        _: &mut ContactReport,
    ) -> Result<Option<f64>, EvaluationFailure> {
        Ok(None)
    }

    fn interface_force(&self, _: usize, _: &ContactReport, _: &mut [f64]) -> bool {
        false
    }
}
