//! Contacts of a run: zones on bodies, interfaces, force elements.

use contact_qs::ContactError;
use contact_qs::contact_element::ActiveContact;
use contact_qs::plane::Plane;
use contact_qs::{HertzContact, PressureRecovery};
use ffr_dynamics::force::BodyState;
use ffr_dynamics::force::active::Active;
use nalgebra::{Unit, Vector3};

use super::default_penalty::{self, Side};
use super::facts::sphere;
use super::plan::{ContactPlan, request, requests};
use super::{BodyModel, ContactModel};
use crate::body::FullModel;
use crate::body::loads::StaticLoads;
use crate::body::reduced::{Interface, InterfaceModes};
use crate::body::zone::ContactZone;
use crate::body::zone::at_start::{LineOnBody, StartZone, wanted_refinement};
use crate::body::zone::contact::ZoneContact;
use crate::body::zone::on_mesh::zone_on_mesh;
use crate::error::{AdaptiveError, ContactModelFault};
use crate::impact::AdaptiveContact;
use crate::sizing::zone::{predicted_line, predicted_zone};
use crate::spec::unsupported::Unsupported;
use crate::spec::{
    ContactLaw, ContactSpec, FlexibleSpec, HertzSpec, ReductionSpec, RefinementSpec, RunSpec, SurfaceLaw,
    Target, Treatment,
};
use crate::state::simulation::RunContact;
use crate::store::ModelCache;
use crate::surface::{MeshSurface, SurfacePlace};
use crate::touch::detection::InactiveContact;
use crate::touch::first::FirstTouches;

/// A contact ready for the system.
pub struct BuiltContact {
    /// The force element.
    pub element: RunContact,
    /// The parts of it that do not change in the run.
    pub model: ContactModel,
}

impl BuiltContact {
    /// Checks that the contact can work in the motion of its body at the start.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if it cannot.
    pub fn check_start(&self, state: &BodyState) -> Result<(), AdaptiveError> {
        let outcome = self.element.contact.check_orientation(&state.rotation);
        outcome.map_err(|source| AdaptiveError::Contact { contact: self.model.name.clone(), source })
    }
}

/// The contacts that the program refines, with their indices.
///
/// # Errors
/// [`AdaptiveError`] if a body has no elastic surface.
pub fn adaptive_contacts(
    spec: &RunSpec,
    plans: &[ContactPlan],
    bodies: &[BodyModel],
    cache: &ModelCache,
) -> Result<Vec<(usize, AdaptiveContact)>, AdaptiveError> {
    let is_refined = |i: usize| plans[i] == ContactPlan::AtTouch;
    let takes_part = |i: usize| {
        let mut contacts = spec.contacts.iter().enumerate();
        contacts.any(|(k, c)| is_refined(k) && c.acts_on(i))
    };
    let surface = |(i, body): (usize, &BodyModel)| if takes_part(i) { body.surface() } else { Ok(None) };
    let surfaces = bodies.iter().enumerate().map(surface).collect::<Result<Vec<_>, AdaptiveError>>()?;
    let refined = spec.contacts.iter().enumerate().filter(|(i, _)| is_refined(*i));
    let adaptive = |(i, contact): (usize, &ContactSpec)| {
        let adaptive = AdaptiveContact::new(contact, contact.law.surface()?, (bodies, &surfaces), cache);
        Some(adaptive.map(|adaptive| (i, adaptive)))
    };
    refined.filter_map(adaptive).collect()
}

/// Refinements that the contacts of body `index` ask for.
///
/// # Errors
/// See [`wanted_refinement`].
pub fn refinements(
    spec: &RunSpec,
    plans: &[ContactPlan],
    index: usize,
) -> Result<Vec<RefinementSpec>, AdaptiveError> {
    let wanted =
        requests(spec, plans, index).map(|r| wanted_refinement(&r)).collect::<Result<Vec<_>, _>>()?;
    Ok(wanted.into_iter().flatten().collect())
}

/// Zones of a contact.
pub struct Zones {
    /// On the contact body.
    contact_body: ContactZone,
    /// On the target; none on a plane and on a rigid body.
    target: Option<ContactZone>,
}

impl Zones {
    /// The zone that `contact` has on body `index`.
    fn on(&self, contact: &ContactSpec, index: usize) -> Option<&ContactZone> {
        if contact.body == index {
            Some(&self.contact_body)
        } else {
            self.target.as_ref().filter(|_| contact.acts_on(index))
        }
    }
}

/// The zones of every contact that has some from the start.
///
/// # Errors
/// See [`crate::body::zone::at_start::ZoneRequest::zone`].
pub fn zones(
    first: &FirstTouches<'_>,
    plans: &[ContactPlan],
    full: &[FullModel<'_>],
) -> Result<Vec<Option<Zones>>, AdaptiveError> {
    let of = |(contact, plan): (&ContactSpec, &ContactPlan)| {
        check_line(first, contact, plan)?;
        let (Some(law), ContactPlan::FromStart(sites)) = (contact.law.surface(), plan) else {
            return Ok(None);
        };
        let zone = |body: usize, site: SurfacePlace| {
            let FullModel::Flexible(full) = &full[body] else { return Err(no_surface(contact)) };
            let zone = start_zone(first, contact, law, body, site, |wanted| full.zone_at_start(wanted))?;
            let other = contact.bodies().find(|other| *other != body);
            let thickness = |body: usize| first.spec.bodies[body].kind.thickness();
            Ok(zone.over_both(thickness(body), other.and_then(thickness)))
        };
        let own = zone(contact.body, sites.contact_body)?;
        let target = match (contact.target, sites.target) {
            (Target::Body(other), _) if is_rigid(&full[other]) => None,
            (Target::Body(other), Some(site)) => Some(zone(other, site)?),
            _ => None,
        };
        Ok(Some(Zones { contact_body: own, target }))
    };
    first.spec.contacts.iter().zip(plans).map(of).collect()
}

/// The error of `contact` for a body that has no surface.
fn no_surface(contact: &ContactSpec) -> AdaptiveError {
    let source = ContactError::Nothing { what: "a body has no surface to touch" };
    AdaptiveError::Contact { contact: contact.name.clone(), source }
}

/// Calls `make` with the zone that `contact` is to have from the start on the body of index `body`,
/// about its place `site`.
fn start_zone<T>(
    first: &FirstTouches<'_>,
    contact: &ContactSpec,
    law: &SurfaceLaw,
    body: usize,
    site: SurfacePlace,
    make: impl FnOnce(&StartZone<'_>) -> T,
) -> T {
    let touch = first.of(contact);
    let pose = touch.as_ref().map_or(&first.poses[body], |touch| &touch.poses[body]);
    let in_body = |v: &Vector3<f64>| pose.rotation.inverse_transform_vector(v);
    let line = || {
        let line = predicted_line(first, contact)?;
        let outward = if body == contact.body { -line.normal } else { line.normal };
        let (across, outward) = (in_body(&line.across), in_body(&outward));
        Some(LineOnBody { half_width: line.half_width, width: line.width, across, outward })
    };
    let width = || predicted_zone(first, contact).map(|zone| zone.width);
    make(&StartZone { request: request(contact, law, site), width: &width, line: &line })
}

/// Refuses contacts along a line with a mesh for which no zones can be made that are strips along
/// the line: contacts that are refined at the touch, and contacts with a partner of splines.
fn check_line(
    first: &FirstTouches<'_>,
    contact: &ContactSpec,
    plan: &ContactPlan,
) -> Result<(), AdaptiveError> {
    let spec = first.spec;
    let Some(law) = contact.law.surface() else { return Ok(()) };
    let bodies = || contact.bodies().map(|body| &spec.bodies[body]);
    let mesh = bodies().find(|body| body.kind.brings_mesh());
    let Some(mesh) = mesh.filter(|_| law.treatment != Treatment::Coarse) else { return Ok(()) };
    let Some(line) = predicted_line(first, contact) else { return Ok(()) };
    if *plan == ContactPlan::AtTouch {
        let fault = ContactModelFault::RefinedLine { body: mesh.name.clone(), width: 2.0 * line.half_width };
        return Err(AdaptiveError::ContactModel { contact: contact.name.clone(), fault });
    }
    match bodies().find(|body| body.kind.is_meshed_here()) {
        Some(body) => {
            let (contact, fault) =
                (contact.name.clone(), ContactModelFault::LineOfSplines { body: body.name.clone() });
            Err(AdaptiveError::ContactModel { contact, fault })
        }
        None => Ok(()),
    }
}

/// Checks the contacts of meshes: that those with one model for the whole run find their zones, and
/// that those refined at the touch do not touch along a line.
///
/// # Errors
/// As [`zone_on_mesh`]; [`AdaptiveError::ContactModel`] for a line that no strip of sides follows.
pub fn check_mesh_zones(first: &FirstTouches<'_>, plans: &[ContactPlan]) -> Result<(), AdaptiveError> {
    let spec = first.spec;
    for (contact, plan) in spec.contacts.iter().zip(plans) {
        check_line(first, contact, plan)?;
        let (Some(law), ContactPlan::FromStart(sites)) = (contact.law.surface(), plan) else { continue };
        for (body, site) in contact.bodies().zip([Some(sites.contact_body), sites.target]) {
            let Some(site) = site else { continue };
            if let Some(mesh) = spec.bodies[body].kind.meshed() {
                let (name, surface) = (&spec.bodies[body].name, MeshSurface::of(&mesh.mesh));
                let wanted = |wanted: &StartZone<'_>| zone_on_mesh(name, &surface, wanted).map(|_| ());
                start_zone(first, contact, law, body, site, wanted)?;
            }
        }
    }
    Ok(())
}

fn is_rigid(body: &FullModel<'_>) -> bool {
    matches!(body, FullModel::Rigid(_))
}

/// The interface and the loads for which every body is reduced: the union of the interfaces of its
/// contacts, and the loads of its joints and of its `turns`.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] if contacts on one body want different things of its modes, or a reduction does not fit.
pub fn interfaces(
    spec: &RunSpec,
    zones: &[Option<Zones>],
    turns: &[Vec<Vector3<f64>>],
) -> Result<Vec<Interface>, AdaptiveError> {
    let of_body = |b: usize| {
        let mut interface = interface_of(spec, b, zones)?;
        interface.unknowns.sort_unstable();
        interface.unknowns.dedup();
        if spec.bodies[b].kind.flexible().is_some_and(FlexibleSpec::has_static_answers) {
            interface.loads = StaticLoads::on_body(spec, b, &turns[b]);
        }
        Ok(interface)
    };
    (0..spec.bodies.len()).map(of_body).collect()
}

/// The interface that the contacts of body `index` need in its reduction. Coarse and adaptive
/// contacts need none: low-frequency modes are enough for them.
fn interface_of(spec: &RunSpec, index: usize, zones: &[Option<Zones>]) -> Result<Interface, AdaptiveError> {
    let body = &spec.bodies[index];
    let mut modes: Option<InterfaceModes> = None;
    let mut unknowns = Vec::new();
    let unsupported = |what| Err(AdaptiveError::unsupported_body(&body.name, what));
    for (contact, zones) in spec.contacts.iter().zip(zones) {
        let (Some(zones), Some(law)) = (zones, contact.law.surface()) else { continue };
        let Some(zone) = zones.on(contact, index) else { continue };
        let wanted = match law.treatment {
            Treatment::Quasistatic => InterfaceModes::Quasistatic,
            Treatment::Damped => InterfaceModes::Damped,
            Treatment::Dynamic => InterfaceModes::Dynamic,
            Treatment::Adaptive | Treatment::Coarse => continue,
        };
        if let Some(other) = modes.filter(|m| *m != wanted) {
            return unsupported(Unsupported::MixedContacts { models: [other.name(), wanted.name()] });
        }
        modes = Some(wanted);
        unknowns.extend(&zone.unknowns);
    }
    let modes = modes.unwrap_or_default();
    let needs_bounds = modes != InterfaceModes::Dynamic;
    let flexible = body.kind.flexible().filter(|_| body.kind.has_elements());
    if needs_bounds && !matches!(flexible.map(|f| f.reduction), Some(ReductionSpec::CraigBampton { .. })) {
        return unsupported(Unsupported::NoInterfaceModes { model: modes.name() });
    }
    let has_others = !unknowns.is_empty() && modes != InterfaceModes::Quasistatic;
    let is_refined = |c: &ContactSpec, zones: &Option<Zones>| {
        zones.is_none() && c.law.surface().is_some() && c.acts_on(index)
    };
    if has_others && spec.contacts.iter().zip(zones).any(|(c, z)| is_refined(c, z)) {
        return unsupported(Unsupported::MixedWithRefined { model: modes.name() });
    }
    Ok(Interface { unknowns, modes, loads: StaticLoads::default() })
}

/// The force element of a contact, `poses` being the motions at the start.
///
/// # Errors
/// [`AdaptiveError::Contact`] if its values make no contact.
pub fn build_contact(
    run: &RunSpec,
    spec: &ContactSpec,
    plan: &ContactPlan,
    zones: Option<&Zones>,
    bodies: &[BodyModel],
    poses: &[BodyState],
) -> Result<BuiltContact, AdaptiveError> {
    let fail = |source| AdaptiveError::Contact { contact: spec.name.clone(), source };
    let without_model = |fault| AdaptiveError::ContactModel { contact: spec.name.clone(), fault };
    let flexible = |body: usize| bodies[body].flexible();
    let size = flexible(spec.body).map_or(0.0, |e| e.body.size());
    let (element, width, size): (Box<dyn ActiveContact>, _, _) = match (&spec.law, spec.target, zones) {
        (ContactLaw::Surface(_), target, _) if *plan == ContactPlan::AtTouch => {
            (Box::new(Active::new(InactiveContact::new(spec.body, target.body()))), 0.0, size)
        }
        (ContactLaw::Surface(law), target, Some(zones)) => {
            let side = |body: usize, zone| Some(Side { body, model: flexible(body)?, zone });
            let own = side(spec.body, &zones.contact_body);
            let own =
                own.ok_or_else(|| without_model(ContactModelFault::Settings("the contact body is rigid")))?;
            let other = target.body().zip(zones.target.as_ref()).and_then(|(body, zone)| side(body, zone));
            let contact = zone_contact(law, target, own, other, bodies, poses).map_err(fail)?;
            (contact, zones.contact_body.widths[0], size)
        }
        (ContactLaw::Hertz(law), ..) => {
            let contact = hertz_contact(spec, law, bodies)?;
            let size = contact.size();
            (Box::new(Active::new(contact)), 0.0, size)
        }
        _ => {
            let fault = ContactModelFault::Settings("law and target do not fit each other");
            return Err(without_model(fault));
        }
    };
    let model = ContactModel::new(run, spec, bodies, size, zones.map(|_| width))?;
    let recovery = zones.map(|zones| PressureRecovery::new(&zones.contact_body.points));
    Ok(BuiltContact { element: RunContact::new(element).with_pressures(recovery), model })
}

/// The force element of a contact by Hertz's law.
fn hertz_contact(
    spec: &ContactSpec,
    law: &HertzSpec,
    bodies: &[BodyModel],
) -> Result<HertzContact, AdaptiveError> {
    let fail = |source| AdaptiveError::Contact { contact: spec.name.clone(), source };
    let plane = |point, normal| Plane { point, normal: Unit::new_normalize(normal) };
    let surface = |body: usize| {
        let none = || {
            let what = Unsupported::NoSurface { body: bodies[body].name.clone() };
            AdaptiveError::unsupported_contact(&spec.name, what)
        };
        bodies[body].surface()?.ok_or_else(none)
    };
    let [own, other] = law.solids();
    let contact = match (law.spheres(spec.target), spec.target) {
        (Some((ball, _)), Target::Plane { point, normal }) => {
            HertzContact::with_plane(sphere(spec.body, ball, bodies)?, plane(point, normal), other)
        }
        (Some((ball, Some(facing))), Target::Body(target)) => {
            HertzContact::with_sphere(sphere(spec.body, ball, bodies)?, sphere(target, facing, bodies)?)
        }
        (_, Target::Plane { point, normal }) => {
            let plane = plane(point, normal);
            HertzContact::of_surface_and_plane(spec.body, surface(spec.body)?, plane, [own, other])
        }
        (_, Target::Body(target)) => {
            let models = [surface(spec.body)?, surface(target)?];
            HertzContact::of_surfaces([spec.body, target], models, [own, other])
        }
    };
    contact.and_then(|contact| contact.with_friction(law.friction)).map_err(fail)
}

/// Contact with one model for the whole run (theory section C.8), the `bodies` being in the motions
/// `poses` at the start.
fn zone_contact(
    law: &SurfaceLaw,
    target: Target,
    own: Side<'_>,
    other: Option<Side<'_>>,
    bodies: &[BodyModel],
    poses: &[BodyState],
) -> Result<Box<dyn ActiveContact>, ContactError> {
    let rigid = target.body().and_then(|body| Some((body, bodies[body].rigid_surface()?)));
    let on_target = match (&other, rigid) {
        (Some(side), _) => Some(side.of_contact(law)),
        (None, rigid) => rigid.map(|(body, surface)| surface.side(body, false)),
    };
    let mut contact = ZoneContact::new(law, target, &own.of_contact(law), on_target.as_ref())?.active();
    if law.penalty.is_none() {
        let sides: Vec<Side<'_>> = [Some(own), other].into_iter().flatten().collect();
        default_penalty::set(contact.as_mut(), law, &sides, bodies, poses)?;
    }
    Ok(contact)
}
