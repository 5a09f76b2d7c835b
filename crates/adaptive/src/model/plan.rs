//! Which contacts have one model for the whole run, and about which places of the bodies.

use contact_qs::ContactError;
use contact_qs::search::{SearchWorkspace, SurfaceModel, minimum_distance};
use ffr_dynamics::system::force::BodyState;
use nalgebra::Vector3;

use crate::elastic_body::rigid_motion;
use crate::error::AdaptiveError;
use crate::spec::{ContactLaw, ContactSpec, ElasticSpec, RunSpec, SurfaceLaw, Target, Treatment};
use crate::unsupported::Unsupported;
use crate::zone_at_start::{ContactSite, ZoneRequest, refined_width};

/// When a contact gets its model.
///
/// Adaptive contacts are refined by the program at each touch. Quasistatic, damped and dynamic pairs are too, with the width
/// and penalty factor given, unless both bodies are refined by their own discretisation at the places where they are nearest
/// at the start and no interval is given: then that refinement is the model of the whole run, as it always is of coarse
/// contacts and of those with a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactPlan {
    /// It needs none: Hertz's law.
    Point,
    /// At each touch.
    AtTouch,
    /// Before the run.
    FromStart(Sites),
}

/// First places of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sites {
    /// On the contact body.
    pub contact_body: ContactSite,
    /// On the target; none on a plane.
    pub target: Option<ContactSite>,
}

/// The plan of every contact, `poses` being the motions at the start.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] for rigid bodies where elastic ones are needed, [`AdaptiveError::Contact`] if nearest places
/// cannot be found.
pub fn plans(spec: &RunSpec, poses: &[BodyState]) -> Result<Vec<ContactPlan>, AdaptiveError> {
    spec.contacts.iter().map(|contact| plan(spec, contact, poses)).collect()
}

fn plan(spec: &RunSpec, contact: &ContactSpec, poses: &[BodyState]) -> Result<ContactPlan, AdaptiveError> {
    let ContactLaw::Surface(law) = &contact.law else { return Ok(ContactPlan::Point) };
    if law.treatment == Treatment::Adaptive {
        return Ok(ContactPlan::AtTouch);
    }
    let own = elastic(spec, contact, contact.body)?;
    let other = match &contact.target {
        Target::Body(other) => *other,
        Target::Plane { normal, .. } => {
            return plane_site(contact, own, &poses[contact.body], normal).map(ContactPlan::FromStart);
        }
    };
    let bodies = [own, elastic(spec, contact, other)?];
    let may_be_refined = law.interval.width.is_none()
        && law.interval.elements.is_none()
        && bodies.iter().all(|b| !b.discretisation.refine.is_empty());
    let is_coarse = law.treatment == Treatment::Coarse;
    if !is_coarse && !may_be_refined {
        return Ok(ContactPlan::AtTouch);
    }
    let sites = pair_sites(contact, bodies, [&poses[contact.body], &poses[other]])?;
    let is_refined = bodies.iter().zip(sites).all(|(b, s)| refined_width(b, &s.point).is_some());
    if !is_coarse && !is_refined {
        return Ok(ContactPlan::AtTouch);
    }
    Ok(ContactPlan::FromStart(Sites { contact_body: sites[0], target: Some(sites[1]) }))
}

/// Places at which a contact of surfaces is first, the undeformed bodies being nearest or lowest there in the motions `poses`;
/// `None` if it has none.
pub fn first_sites(spec: &RunSpec, contact: &ContactSpec, poses: &[BodyState]) -> Option<Sites> {
    let own = spec.bodies[contact.body].elastic()?;
    let other = match &contact.target {
        Target::Body(other) => *other,
        Target::Plane { normal, .. } => return plane_site(contact, own, &poses[contact.body], normal).ok(),
    };
    let bodies = [own, spec.bodies[other].elastic()?];
    let [own, target] = pair_sites(contact, bodies, [&poses[contact.body], &poses[other]]).ok()?;
    Some(Sites { contact_body: own, target: Some(target) })
}

/// The elastic body `index` of a contact.
fn elastic<'a>(
    spec: &'a RunSpec,
    contact: &ContactSpec,
    index: usize,
) -> Result<&'a ElasticSpec, AdaptiveError> {
    let body = &spec.bodies[index];
    body.elastic().ok_or_else(|| {
        let what = Unsupported::RigidSurface { body: body.name.clone() };
        AdaptiveError::unsupported_contact(&contact.name, what)
    })
}

fn failure(contact: &ContactSpec, source: ContactError) -> AdaptiveError {
    AdaptiveError::Contact { contact: contact.name.clone(), source }
}

/// The first point of a body to touch a plane of the given normal.
fn plane_site(
    contact: &ContactSpec,
    body: &ElasticSpec,
    pose: &BodyState,
    normal: &Vector3<f64>,
) -> Result<Sites, AdaptiveError> {
    let own = ContactSite::lowest(body, &pose.rotation.inverse_transform_vector(normal));
    let own = own.ok_or_else(|| failure(contact, ContactError::Empty { width: 0.0 }))?;
    Ok(Sites { contact_body: own, target: None })
}

/// Nearest places of two undeformed bodies.
fn pair_sites(
    contact: &ContactSpec,
    bodies: [&ElasticSpec; 2],
    poses: [&BodyState; 2],
) -> Result<[ContactSite; 2], AdaptiveError> {
    let fail = |source| failure(contact, source);
    let surface = |body: &ElasticSpec| SurfaceModel::rigid(rigid_motion(&body.model), &body.shape.patches);
    let models = [surface(bodies[0]).map_err(fail)?, surface(bodies[1]).map_err(fail)?];
    let mut workspace = SearchWorkspace::new();
    let nearest = minimum_distance([&models[0], &models[1]], poses, &mut workspace).map_err(fail)?;
    Ok([0, 1].map(|i| ContactSite::new(bodies[i], nearest.sites[i].face, nearest.sites[i].xi)))
}

/// The zones that the contacts with a plan from the start ask of body `index`.
pub fn requests<'a>(
    spec: &'a RunSpec,
    plans: &'a [ContactPlan],
    index: usize,
) -> impl Iterator<Item = ZoneRequest<'a>> {
    let sites = spec.contacts.iter().zip(plans).filter_map(|(contact, plan)| match (plan, &contact.law) {
        (ContactPlan::FromStart(sites), ContactLaw::Surface(law)) => Some((contact, law, sites)),
        _ => None,
    });
    sites.flat_map(move |(contact, law, sites)| {
        let own = (contact.body == index).then_some(sites.contact_body);
        let target = sites.target.filter(|_| contact.target == Target::Body(index));
        own.into_iter().chain(target).map(move |site| request(contact, law, site))
    })
}

/// What `contact` asks of a body at `site`.
pub fn request<'a>(contact: &'a ContactSpec, law: &'a SurfaceLaw, site: ContactSite) -> ZoneRequest<'a> {
    ZoneRequest { contact: &contact.name, law, site }
}
