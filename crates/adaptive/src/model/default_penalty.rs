//! The penalty factor of a contact with one model for the whole run, where the scenario gives none
//! (docs/theory.md Eqs. A.25, P.16, P.17, C.100).

use std::f64::consts::PI;

use contact_qs::zone::points::{InterfaceCompliance, contact_submodel};
use contact_qs::{ActiveContact, ContactError, Meeting};
use ffr_dynamics::force::{BodyState, Motion};
use nalgebra::Vector3;

use super::BodyModel;
use crate::body::splines::ElasticBody;
use crate::body::zone::ContactZone;
use crate::body::zone::contact::ContactSide;
use crate::spec::{ContactSpec, SurfaceLaw};
use crate::system::body::FlexibleModel;
use crate::touch::first::FirstTouches;
use crate::touch::hertz::local_surface::plane_compliance;

/// The zone that a contact has from the start on one of its bodies.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    /// Index of the body.
    pub body: usize,
    /// Its model.
    pub model: &'a FlexibleModel,
    /// Its zone.
    pub zone: &'a ContactZone,
}

/// Gives `contact`, whose zones are `sides`, the first penalty factor of `law` in the motions `poses` of the
/// undeformed bodies. Its zones lie where the bodies are going to touch.
///
/// The compliance is that of the quasistatic zone; where all modes are dynamic, that of the modes;
/// of bodies without modes that of a half space under each point's area.
///
/// # Errors
/// [`ContactError`] if there is no compliance, or points have no normals.
pub fn set(
    contact: &mut dyn ActiveContact,
    law: &SurfaceLaw,
    sides: &[Side<'_>],
    bodies: &[BodyModel],
    poses: &[BodyState],
) -> Result<(), ContactError> {
    let at_rest = |(pose, body): (&BodyState, &BodyModel)| {
        let n = body.data.modal_stiffness.len();
        BodyState { elastic: vec![0.0; n], elastic_rates: vec![0.0; n], ..pose.clone() }
    };
    let poses: Vec<BodyState> = poses.iter().zip(bodies).map(at_rest).collect();
    let motion = Motion::new(0.0, &poses);
    let weight = contact.compliance_weight(motion, f64::INFINITY)?;
    let normal = contact.meeting(motion).normal;
    let weight = match weight {
        Some(weight) => weight,
        None => {
            let weights = sides.iter().map(|side| {
                let local = poses[side.body].rotation.inverse_transform_vector(&normal);
                side.weight(&local)
            });
            weights.sum::<Result<f64, ContactError>>()?
        }
    };
    contact.set_penalty(law.first_penalty(Some(weight))?)
}

/// Penetration under weight, as a share of the least extent of the bodies: that of a corner, on which a body stands that bears a 144th of
/// a face, is a thousandth of it then, and 0.1 m of size sink by 1e-6 m.
const AT_REST: f64 = 1e-5;
/// The same in the first impact.
const IN_IMPACT: f64 = 1e-3;
/// What bodies are held against each other by where nothing tells it [m/s²].
const USUAL_WEIGHT: f64 = 9.81;

/// The penalty factor of a contact of rigid bodies, whose contact body has the points of `zone` and which are nearest at `meeting` at
/// the start, from what presses them together (Eq. C.100) [N/m³].
pub fn of_rigid(
    touches: &FirstTouches<'_>,
    contact: &ContactSpec,
    zone: &ContactZone,
    meeting: &Meeting,
) -> f64 {
    let (spec, touch) = (touches.spec, touches.of(contact));
    let gravity = spec.settings.gravity;
    let extents = contact.bodies().filter_map(|body| touches.surface(body)).map(|surface| {
        let axes = (0..surface.motion().n_components()).map(|c| Vector3::ith(c, 1.0));
        axes.map(|axis| surface.extent_along(&axis)).fold(f64::INFINITY, f64::min)
    });
    let least = extents.fold(f64::INFINITY, f64::min);
    // Mean shadow of a convex body (Cauchy).
    let area = 0.25 * zone.points.iter().map(|point| point.area).sum::<f64>();
    let moving: Vec<usize> = contact.bodies().filter(|body| !spec.is_held(*body)).collect();
    let mass = |body: &usize| spec.bodies[*body].kind.rigid().map_or(0.0, |rigid| rigid.mass);
    // The body above weighs on the contact.
    let above = if meeting.normal.dot(&gravity) > 0.0 { moving.last() } else { moving.first() };
    let weight = if gravity.norm() > 0.0 { gravity.norm() } else { USUAL_WEIGHT };
    let at_rest = mass(above.unwrap_or(&contact.body)) * weight / (AT_REST * least);
    // Bodies whose touch is known are just before it.
    let known = touch.as_ref().filter(|touch| touch.kind.is_some());
    let poses = known.map_or(&touches.poses, |touch| &touch.poses);
    let fall = if known.is_some() { 0.0 } else { 2.0 * gravity.norm() * meeting.gap.max(0.0) };
    let velocity = |body: usize| {
        let pose = &poses[body];
        pose.velocity
            + (pose.rotation * pose.angular_velocity_in_body).cross(&(meeting.place - pose.position))
    };
    let relative = velocity(contact.body) - contact.target.body().map_or_else(Vector3::zeros, velocity);
    let squared = relative.dot(&meeting.normal).min(0.0).powi(2) + fall;
    let inverse_mass: f64 = moving.iter().map(|body| 1.0 / mass(body)).sum();
    let in_impact = squared / (inverse_mass * (IN_IMPACT * least).powi(2));
    // Of bodies that nothing moves, or whose places are no numbers, the weight alone.
    at_rest.max(if in_impact.is_finite() { in_impact } else { 0.0 }) / area
}

impl<'a> Side<'a> {
    /// What the contact is built from; with a compliance of the interface if it is quasistatic.
    pub fn of_contact(&self, law: &SurfaceLaw) -> ContactSide<'a> {
        let FlexibleModel { body: full, reduced, interface, .. } = self.model;
        let residual = reduced.residual.as_ref().filter(|_| law.treatment.is_static());
        let compliance = residual
            .map(|r| InterfaceCompliance { dofs: &interface.unknowns, compliance: r.compliance().as_ref() });
        ContactSide {
            body: self.body,
            motion: full.motion(),
            lookup: full.lookup(),
            splines: full.splines().map(ElasticBody::discretised),
            zone: self.zone,
            shapes: reduced.shapes(),
            compliance,
            meets: None,
        }
    }

    /// `max_i(A_ii w_i)` of the body's modes along `normal`, in its frame (Eq. P.16); of a half
    /// space if it has none (Eq. P.17) [m³/N].
    fn weight(&self, normal: &Vector3<f64>) -> Result<f64, ContactError> {
        let (motion, lookup) = (self.model.motion(), self.model.lookup());
        let basis = &self.model.reduced.basis;
        let submodel = contact_submodel(motion, &self.zone.points, lookup, basis.shapes.as_ref(), None)?;
        let nc = motion.n_components();
        let modal = |i: usize| -> f64 {
            let along = |j: usize| -> f64 {
                (0..nc).map(|c| normal[motion.direction(c)] * submodel.low[(nc * i + c, j)]).sum()
            };
            basis.omega.iter().enumerate().map(|(j, omega)| (along(j) / omega).powi(2)).sum()
        };
        let areas = || submodel.areas.iter().copied();
        let largest = areas().enumerate().map(|(i, w)| modal(i) * w).fold(0.0, f64::max);
        if largest > 0.0 {
            return Ok(largest);
        }
        let compliance = self.model.body.slowest_material().map_or(0.0, plane_compliance);
        Ok(areas().map(|w| half_space_weight(w, compliance)).fold(0.0, f64::max))
    }
}

/// Mean displacement of a circle of the area `area` on a half space of compliance
/// `compliance = (1 - ν²)/E` under a unit pressure on it, `16 a/(3π E*)` with `π a² = w` (Johnson
/// 3.29; Eq. P.17) [m³/N].
fn half_space_weight(area: f64, compliance: f64) -> f64 {
    16.0 / (3.0 * PI) * (area / PI).sqrt() * compliance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_space_yields_in_proportion_to_the_radius_of_the_load() {
        // a = 1 m, E* = 1 Pa.
        assert!((half_space_weight(PI, 1.0) - 16.0 / (3.0 * PI)).abs() < 1e-15);
        assert!((half_space_weight(4.0 * PI, 1.0) / half_space_weight(PI, 1.0) - 2.0).abs() < 1e-15);
    }
}
