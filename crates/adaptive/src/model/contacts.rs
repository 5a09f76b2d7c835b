//! Contacts of a run: zones on bodies, interfaces, force elements.

use contact_qs::ContactError;
use contact_qs::contact_element::ContactElement;
use contact_qs::plane::{Plane, PlaneContact, PlaneContactSettings};
use contact_qs::points::{InterfaceCompliance, contact_submodel};
use contact_qs::{Sphere, SpherePlane, SphereSphere};
use ffr_dynamics::system::force::BodyState;
use nalgebra::Unit;

use super::{BodyModel, ContactFacts, ElasticModel};
use crate::contact_zone::{ContactZone, ZoneRequest, wanted_refinement};
use crate::elastic_body::{ElasticBody, Interface};
use crate::error::AdaptiveError;
use crate::simulation::TimedContact;
use crate::spec::{
    BodyKind, ContactLaw, ContactSpec, HertzSphere, ReductionSpec, RefinementSpec, RunSpec, SurfaceLaw,
    Target, Treatment,
};

/// A contact ready for the system.
pub struct BuiltContact {
    /// The force element.
    pub element: TimedContact,
    /// What does not change.
    pub facts: ContactFacts,
}

impl BuiltContact {
    /// Checks that the contact can work in the motion of its body at the start.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if it cannot.
    pub fn check_start(&self, state: &BodyState) -> Result<(), AdaptiveError> {
        let outcome = self.element.contact.check_orientation(&state.rotation);
        outcome.map_err(|source| AdaptiveError::Contact { contact: self.facts.name.clone(), source })
    }
}

/// The surface law of a contact with a plane, and its request at a body in the given motion.
fn plane_request<'a>(contact: &'a ContactSpec, pose: &BodyState) -> Option<ZoneRequest<'a>> {
    let (ContactLaw::Surface(law), Target::Plane { normal, .. }) = (&contact.law, contact.target) else {
        return None;
    };
    let normal = pose.rotation.inverse_transform_vector(&normal);
    Some(ZoneRequest { contact: &contact.name, law, normal })
}

/// Refinements that the contacts of body `index` ask for.
///
/// # Errors
/// See [`wanted_refinement`].
pub fn refinements(
    spec: &RunSpec,
    index: usize,
    pose: &BodyState,
) -> Result<Vec<RefinementSpec>, AdaptiveError> {
    let BodyKind::Elastic(body) = &spec.bodies[index].kind else { return Ok(Vec::new()) };
    let requests = spec.contacts.iter().filter(|c| c.body == index).filter_map(|c| plane_request(c, pose));
    let wanted = requests.map(|r| wanted_refinement(body, &r)).collect::<Result<Vec<_>, _>>()?;
    Ok(wanted.into_iter().flatten().collect())
}

/// The zone of every contact that has one.
///
/// # Errors
/// See [`ContactZone::new`]; [`AdaptiveError::Unsupported`] for surfaces of rigid bodies and for pairs of bodies.
pub fn requested_zones(
    spec: &RunSpec,
    full: &[Option<ElasticBody>],
    poses: &[BodyState],
) -> Result<Vec<Option<ContactZone>>, AdaptiveError> {
    let zone = |contact: &ContactSpec| {
        let ContactLaw::Surface(law) = &contact.law else { return Ok(None) };
        let unsupported = |reason: &str| AdaptiveError::Unsupported {
            subject: format!("contact \"{}\"", contact.name),
            reason: reason.into(),
        };
        if !matches!(law.treatment, Treatment::Quasistatic | Treatment::Dynamic) {
            return Err(unsupported("models other than quasistatic and dynamic are not supported yet"));
        }
        let Some(request) = plane_request(contact, &poses[contact.body]) else {
            return Err(unsupported(
                "contact between surfaces of two bodies is not supported yet, choose a rigid plane as target",
            ));
        };
        let Some(body) = &full[contact.body] else {
            return Err(unsupported(
                "the contact body is rigid and has no surface points, choose model \"hertz\"",
            ));
        };
        ContactZone::new(body, &request).map(Some)
    };
    spec.contacts.iter().map(zone).collect()
}

/// Interface of every body: the union of those of its contacts.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] if quasistatic and dynamic contacts meet on one body, or a reduction does not fit.
pub fn interfaces(spec: &RunSpec, zones: &[Option<ContactZone>]) -> Result<Vec<Interface>, AdaptiveError> {
    (0..spec.bodies.len()).map(|b| interface_of(spec, b, zones)).collect()
}

fn interface_of(
    spec: &RunSpec,
    index: usize,
    zones: &[Option<ContactZone>],
) -> Result<Interface, AdaptiveError> {
    let mine = || spec.contacts.iter().zip(zones).filter(|(c, zone)| c.body == index && zone.is_some());
    let is_quasistatic = |contact: &ContactSpec| matches!(&contact.law, ContactLaw::Surface(law) if law.treatment == Treatment::Quasistatic);
    let any_quasistatic = mine().any(|(c, _)| is_quasistatic(c));
    let unsupported = |reason: &str| AdaptiveError::Unsupported {
        subject: format!("body \"{}\"", spec.bodies[index].name),
        reason: reason.into(),
    };
    if any_quasistatic && mine().any(|(c, _)| !is_quasistatic(c)) {
        return Err(unsupported(
            "quasistatic and dynamic contacts on one body cannot be mixed, choose one model",
        ));
    }
    let reduction = spec.bodies[index].elastic().map(|e| e.reduction);
    if any_quasistatic && !matches!(reduction, Some(ReductionSpec::CraigBampton { .. })) {
        return Err(unsupported("quasistatic contact needs reduction.method = \"craig-bampton\""));
    }
    let mut unknowns: Vec<usize> =
        mine().filter_map(|(_, zone)| zone.as_ref()).flat_map(|z| z.unknowns.iter().copied()).collect();
    unknowns.sort_unstable();
    unknowns.dedup();
    Ok(Interface { unknowns, is_quasistatic: any_quasistatic })
}

/// The force element of a contact.
///
/// # Errors
/// [`AdaptiveError::Contact`] if its values make no contact.
pub fn build_contact(
    spec: &ContactSpec,
    zone: Option<&ContactZone>,
    bodies: &[BodyModel],
) -> Result<BuiltContact, AdaptiveError> {
    let fail = |source| AdaptiveError::Contact { contact: spec.name.clone(), source };
    let inconsistent = |reason: &str| fail(ContactError::Inconsistent { reason: reason.into() });
    let (element, widths, size): (Box<dyn ContactElement>, _, _) = match (&spec.law, spec.target) {
        (ContactLaw::Surface(law), Target::Plane { point, normal }) => {
            let plane = Plane { point, normal: Unit::new_normalize(normal) };
            let (Some(zone), Some(elastic)) = (zone, &bodies[spec.body].elastic) else {
                return Err(inconsistent("there is no contact zone"));
            };
            let contact = plane_contact(spec.body, law, plane, zone, elastic).map_err(fail)?;
            (Box::new(contact), [zone.width, 0.0], elastic.body.size())
        }
        (ContactLaw::Hertz { contact, plane: solid, .. }, Target::Plane { point, normal }) => {
            let plane = Plane { point, normal: Unit::new_normalize(normal) };
            let sphere = sphere(spec.body, contact, bodies)?;
            (Box::new(SpherePlane::new(sphere, plane, *solid).map_err(fail)?), [0.0; 2], contact.radius)
        }
        (ContactLaw::Hertz { contact, target: Some(other), .. }, Target::Body(target)) => {
            let pair = [sphere(spec.body, contact, bodies)?, sphere(target, other, bodies)?];
            (Box::new(SphereSphere::new(pair).map_err(fail)?), [0.0; 2], contact.radius)
        }
        _ => return Err(inconsistent("law and target do not fit each other")),
    };
    let facts = ContactFacts { name: spec.name.clone(), body: spec.body, widths, size };
    Ok(BuiltContact { element: TimedContact::new(element), facts })
}

fn sphere(body: usize, sphere: &HertzSphere, bodies: &[BodyModel]) -> Result<Sphere, AdaptiveError> {
    let centre = bodies[body].point(&sphere.centre)?;
    Ok(Sphere { body, centre, radius: sphere.radius, solid: sphere.solid })
}

fn plane_contact(
    body: usize,
    law: &SurfaceLaw,
    plane: Plane,
    zone: &ContactZone,
    elastic: &ElasticModel,
) -> Result<PlaneContact, ContactError> {
    let ElasticModel { body: full, reduced, interface } = elastic;
    let compliance = reduced
        .residual
        .as_ref()
        .map(|r| InterfaceCompliance { dofs: &interface.unknowns, compliance: r.compliance().as_ref() });
    let shapes = reduced.basis.shapes.as_ref();
    let submodel = contact_submodel(full.assembled.motion, &zone.points, &full.lookup, shapes, compliance)?;
    let penalty = law
        .penalty
        .ok_or_else(|| ContactError::Inconsistent { reason: "a penalty factor must be given".into() })?;
    let contact =
        PlaneContact::new(submodel, PlaneContactSettings { body, plane, penalty, method: law.method })?;
    match law.friction {
        Some(friction) => contact.with_friction(friction),
        None => Ok(contact),
    }
}
