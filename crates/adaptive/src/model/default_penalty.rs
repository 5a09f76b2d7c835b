//! The penalty factor of a contact with one model for the whole run, where the scenario gives none
//! (docs/theory.md Eqs. A.25, P.16, P.17).

use std::f64::consts::PI;

use contact_qs::zone::points::{InterfaceCompliance, contact_submodel};
use contact_qs::{ActiveContact, ContactError};
use ffr_dynamics::force::{BodyState, Motion};
use nalgebra::Vector3;

use super::BodyModel;
use crate::body::splines::ElasticBody;
use crate::body::zone::ContactZone;
use crate::body::zone::contact::ContactSide;
use crate::spec::SurfaceLaw;
use crate::system::body::FlexibleModel;
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
