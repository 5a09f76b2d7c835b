//! Which contacts have one model for the whole run, and about which places of the bodies.

use contact_qs::ContactError;

use crate::body::zone::at_start::{ZoneRequest, refined_width};
use crate::error::{AdaptiveError, ContactModelFault};
use crate::spec::unsupported::Unsupported;
use crate::spec::{ContactLaw, ContactSpec, ElasticSpec, RunSpec, SurfaceLaw, Treatment};
use crate::surface::{self, SurfacePlace};
use crate::touch::first::FirstTouches;
use crate::touch::parts::{TouchKind, TouchZone};
use crate::touch::sites::Sites;

/// When a contact gets its model.
///
/// Adaptive contacts are refined by the program at each touch. Quasistatic, damped and dynamic
/// pairs are too, with the width and penalty factor given, unless both bodies, as far as they are
/// flexible, are refined by their own discretisation at the places where they are nearest at the
/// start and no interval is given: then that refinement is the model of the whole run, as it always
/// is of coarse contacts and of those with a plane, unless these are quasistatic and nobody has given
/// a zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactPlan {
    /// No zone is built: Hertz's law.
    Point,
    /// Zones are built at each touch.
    AtTouch,
    /// Zones are built before the run.
    FromStart(Sites),
}

/// The plan of every contact.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] for bodies that cannot take their part, [`AdaptiveError::Contact`] if nearest places
/// cannot be found.
pub fn plans(touches: &FirstTouches<'_>) -> Result<Vec<ContactPlan>, AdaptiveError> {
    touches.spec.contacts.iter().map(|contact| plan(touches, contact)).collect()
}

fn plan(touches: &FirstTouches<'_>, contact: &ContactSpec) -> Result<ContactPlan, AdaptiveError> {
    let spec = touches.spec;
    let law = match &contact.law {
        ContactLaw::Surface(law) => law,
        ContactLaw::Hertz(law) => {
            let what = touches.no_hertz_point(contact, law);
            let refused =
                |what| AdaptiveError::unsupported_contact(&contact.name, Unsupported::NoHertzPoint { what });
            return what.map_or(Ok(ContactPlan::Point), |what| Err(refused(what)));
        }
    };
    check_surfaces(spec, contact)?;
    if let Some(kind) = open_touch(touches, contact, law) {
        let without_model = |fault| Err(AdaptiveError::ContactModel { contact: contact.name.clone(), fault });
        match kind.zone() {
            TouchZone::Interval => {}
            TouchZone::Whole if law.is_exact() => {
                return without_model(ContactModelFault::ExactWhole { what: kind.parts() });
            }
            TouchZone::Whole => return Ok(ContactPlan::AtTouch),
            TouchZone::Unseen => {
                let is_rigid = contact.target.body().is_some_and(|other| spec.bodies[other].kind.is_rigid());
                return without_model(ContactModelFault::BetweenPoints { is_rigid });
            }
        }
    }
    if law.treatment == Treatment::Adaptive {
        return Ok(ContactPlan::AtTouch);
    }
    // A rigid target needs no elements.
    let bodies: Vec<&ElasticSpec> = contact.bodies().filter_map(|body| spec.bodies[body].elastic()).collect();
    let is_refined = bodies.iter().all(|b| !b.discretisation.refine.is_empty());
    let has_mesh = contact.bodies().any(|body| spec.bodies[body].kind.brings_mesh());
    let is_left_open = !law.treatment.is_vibrating() && law.interval.width.is_none() && !is_refined;
    // A mesh is not refined: it keeps its zone, and so does its partner. So do bodies on a plane whose
    // zone is given, or part of their modes.
    if has_mesh || contact.target.body().is_none() && !is_left_open {
        return find_sites(touches, contact).map(ContactPlan::FromStart);
    }
    let may_be_refined = is_refined && law.interval.width.is_none() && law.interval.elements.is_none();
    let is_coarse = law.treatment == Treatment::Coarse;
    if !is_coarse && !may_be_refined {
        return Ok(ContactPlan::AtTouch);
    }
    let sites = find_sites(touches, contact)?;
    let found = [Some(sites.contact_body), sites.target].into_iter().flatten();
    let is_refined = bodies.iter().zip(found).all(|(b, s)| refined_width(b, &s.point).is_some());
    if !is_coarse && !is_refined {
        return Ok(ContactPlan::AtTouch);
    }
    Ok(ContactPlan::FromStart(sites))
}

/// Whether flat faces, edges or corners touch first in `contact`, so that its zones are the whole
/// surfaces then.
pub fn is_whole(touches: &FirstTouches<'_>, contact: &ContactSpec) -> bool {
    let kind = contact.law.surface().and_then(|law| open_touch(touches, contact, law));
    kind.is_some_and(|kind| kind.zone() == TouchZone::Whole)
}

/// What touches first in a contact whose zone nobody has given and that is quasistatic, or refined
/// by the program.
fn open_touch(touches: &FirstTouches<'_>, contact: &ContactSpec, law: &SurfaceLaw) -> Option<TouchKind> {
    let is_left_open = law.interval.width.is_none();
    let is_quasistatic = matches!(law.treatment, Treatment::Adaptive | Treatment::Quasistatic);
    if is_left_open && is_quasistatic { touches.kind(contact) } else { None }
}

/// Places about which a contact has zones from the start: where the bodies are nearest then.
fn find_sites(touches: &FirstTouches<'_>, contact: &ContactSpec) -> Result<Sites, AdaptiveError> {
    let none = Err(ContactError::Nothing { what: "a body has no surface to touch" });
    let sites = touches.at_start(contact).unwrap_or(none);
    sites.map_err(|source| AdaptiveError::Contact { contact: contact.name.clone(), source })
}

/// Checks that the contact body is flexible, and that the target has a surface.
fn check_surfaces(spec: &RunSpec, contact: &ContactSpec) -> Result<(), AdaptiveError> {
    let refused = |what| Err(AdaptiveError::unsupported_contact(&contact.name, what));
    let own = &spec.bodies[contact.body];
    if !own.kind.has_elements() {
        return refused(Unsupported::RigidContactBody { body: own.name.clone() });
    }
    let Some(other) = contact.target.body() else { return Ok(()) };
    let target = &spec.bodies[other];
    if surface::address(&target.kind).is_none() {
        return refused(Unsupported::NoSurface { body: target.name.clone() });
    }
    Ok(())
}

/// The zones that the contacts with a plan from the start ask of body `index`, if that is of
/// splines.
pub fn requests<'a>(
    spec: &'a RunSpec,
    plans: &'a [ContactPlan],
    index: usize,
) -> impl Iterator<Item = ZoneRequest<'a>> {
    let is_meshed_here = spec.bodies[index].kind.is_meshed_here();
    let contacts = spec.contacts.iter().zip(plans).filter(move |_| is_meshed_here);
    let sites = contacts.filter_map(|(contact, plan)| match plan {
        ContactPlan::FromStart(sites) => Some((contact, contact.law.surface()?, sites)),
        ContactPlan::Point | ContactPlan::AtTouch => None,
    });
    sites.flat_map(move |(contact, law, sites)| {
        sites.on(contact, index).map(move |site| request(contact, law, site))
    })
}

/// The zone that `contact` needs on a body at `site`.
pub fn request<'a>(contact: &'a ContactSpec, law: &'a SurfaceLaw, site: SurfacePlace) -> ZoneRequest<'a> {
    ZoneRequest { contact: &contact.name, law, site }
}
