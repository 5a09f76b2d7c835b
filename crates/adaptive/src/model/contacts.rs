//! Contacts of a run: zones on bodies, interfaces, force elements.

use contact_qs::ContactError;
use contact_qs::contact_element::ActiveContact;
use contact_qs::{ContactSides, Detector, HertzContact, PressureRecovery};
use ffr_dynamics::force::active::Active;
use ffr_dynamics::force::{BodyState, Motion};
use nalgebra::Vector3;

use super::default_penalty::{self, Side};
use super::facts::spheres;
use super::{BodyModel, ContactFacts};
use crate::body::FullModel;
use crate::body::loads::StaticLoads;
use crate::body::reduced::Interface;
use crate::body::splines::refined_shape;
use crate::body::zone::ContactZone;
use crate::body::zone::at_start::{LineOnBody, StartZone, ZoneRequest, wanted_refinement};
use crate::body::zone::contact::{ContactSide, ZoneContact};
use crate::body::zone::of_rigid::zone_of_rigid;
use crate::body::zone::on_mesh::zone_on_mesh;
use crate::error::{AdaptiveError, ContactModelFault};
use crate::impact::AdaptiveContact;
use crate::prepared::{PlannedContact, Prepared};
use crate::sizing::SizeRequest;
use crate::sizing::zone::{predicted_line, predicted_zone};
use crate::spec::{
    ContactSpec, FlexibleSpec, InterfaceModes, ReductionSpec, RefinementSpec, SurfaceLaw, Target,
};
use crate::state::simulation::RunContact;
use crate::store::ModelCache;
use crate::surface::{MeshSurface, SurfacePlace};
use crate::touch::hertz::preview::StandIn;

/// The contacts that the program refines, with their indices.
///
/// # Errors
/// [`AdaptiveError`] if a body has no elastic surface.
pub fn adaptive_contacts(
    run: &Prepared<'_>,
    bodies: &[BodyModel],
    cache: &ModelCache,
) -> Result<Vec<(usize, AdaptiveContact)>, AdaptiveError> {
    let refined = || run.contacts().enumerate().filter_map(|(i, c)| Some((i, c.spec, c.at_touch()?)));
    let surface = |(i, body): (usize, &BodyModel)| {
        if refined().any(|(_, contact, _)| contact.acts_on(i)) { body.surface() } else { Ok(None) }
    };
    let surfaces = bodies.iter().enumerate().map(surface).collect::<Result<Vec<_>, AdaptiveError>>()?;
    let adaptive = |(i, contact, law): (usize, &ContactSpec, &SurfaceLaw)| {
        AdaptiveContact::new(contact, law, (bodies, &surfaces), cache).map(|adaptive| (i, adaptive))
    };
    refined().map(adaptive).collect()
}

/// Refinements that the contacts of body `index` ask for, if that is of splines.
///
/// # Errors
/// See [`wanted_refinement`].
pub fn refinements(run: &Prepared<'_>, index: usize) -> Result<Vec<RefinementSpec>, AdaptiveError> {
    let contacts = run.contacts().filter(|_| run.spec().bodies[index].kind.is_meshed_here());
    let wanted = contacts.flat_map(|contact| contact.requests(index)).map(|r| wanted_refinement(&r));
    Ok(wanted.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Checks that bodies of splines can have the smaller elements that they and their contacts ask for, as far as that does
/// not depend on elements that the program is to choose by `wishes`.
///
/// # Errors
/// As [`refinements`]; [`AdaptiveError::Geometry`] as of the body that is built.
pub fn check_refined(run: &Prepared<'_>, wishes: &[SizeRequest]) -> Result<(), AdaptiveError> {
    for (i, body) in run.spec().bodies.iter().enumerate() {
        let Some(elastic) = body.kind.elastic() else { continue };
        let mut wanted = elastic.discretisation.clone();
        wanted.refine.extend(refinements(run, i)?);
        let is_known = !wishes.get(i).is_some_and(|wish| wish.elements) || elastic.shape.patches.len() > 1;
        if is_known && !wanted.refine.is_empty() {
            let refined = refined_shape(&elastic.shape, &elastic.model, &wanted);
            refined.map_err(|source| AdaptiveError::Geometry { body: body.name.clone(), source })?;
        }
    }
    Ok(())
}

/// Zones of a contact.
pub struct Zones {
    /// On the contact body.
    contact_body: ContactZone,
    /// On the target; none on a plane, and on a rigid body that a flexible one touches.
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
pub fn zones(run: &Prepared<'_>, full: &[FullModel<'_>]) -> Result<Vec<Option<Zones>>, AdaptiveError> {
    let of = |planned: PlannedContact<'_>| {
        check_line(run, planned)?;
        let (contact, Some((_, sites))) = (planned.spec, planned.from_start()) else { return Ok(None) };
        let zone = |body: usize, site: SurfacePlace| {
            let full = match &full[body] {
                FullModel::Flexible(full) => full,
                FullModel::Rigid(rigid) => {
                    let fail = |source| AdaptiveError::Contact { contact: contact.name.clone(), source };
                    let shape = rigid.geometry().ok_or_else(|| no_surface(contact))?;
                    return zone_of_rigid(shape.shape, shape.model).map_err(fail);
                }
                FullModel::Imported(_) => return Err(no_surface(contact)),
            };
            let zone = start_zone(run, planned, body, site, |wanted| full.zone_at_start(wanted));
            let zone = zone.unwrap_or_else(|| Err(no_surface(contact)))?;
            let other = contact.bodies().find(|other| *other != body);
            let thickness = |body: usize| run.spec().bodies[body].kind.thickness();
            Ok(zone.over_both(thickness(body), other.and_then(thickness)))
        };
        let contact_body = zone(contact.body, sites.contact_body)?;
        // A rigid target of a flexible body has a surface and no points.
        let has_points = |other: &usize| is_rigid(&full[contact.body]) || !is_rigid(&full[*other]);
        let target = contact.target.body().filter(has_points).zip(sites.target);
        let target = target.map(|(other, site)| zone(other, site)).transpose()?;
        Ok(Some(Zones { contact_body, target }))
    };
    run.contacts().map(of).collect()
}

/// The error of `contact` for a body that has no surface.
fn no_surface(contact: &ContactSpec) -> AdaptiveError {
    let source = ContactError::Nothing { what: "a body has no surface to touch" };
    AdaptiveError::Contact { contact: contact.name.clone(), source }
}

/// What `make` makes of the zone that the contact `planned` is to have from the start on the body of
/// index `body`, about its place `site`; none by Hertz's law.
fn start_zone<T>(
    run: &Prepared<'_>,
    planned: PlannedContact<'_>,
    body: usize,
    site: SurfacePlace,
    make: impl FnOnce(&StartZone<'_>) -> T,
) -> Option<T> {
    let (first, contact) = (&run.touches, planned.spec);
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
    Some(make(&StartZone { request: planned.request(site)?, width: &width, line: &line }))
}

/// Refuses contacts along a line with a mesh for which no zones can be made that are strips along
/// the line: contacts that are refined at the touch, unless they may have the sides about it as they are, and contacts with
/// a partner of splines.
fn check_line(run: &Prepared<'_>, planned: PlannedContact<'_>) -> Result<(), AdaptiveError> {
    let contact = planned.spec;
    let Some(law) = contact.law.surface() else { return Ok(()) };
    let bodies = || contact.bodies().map(|body| &run.spec().bodies[body]);
    let mesh = bodies().find(|body| body.kind.brings_mesh());
    let Some(mesh) = mesh.filter(|_| law.treatment.has_fine_zone()) else { return Ok(()) };
    let Some(line) = predicted_line(&run.touches, contact) else { return Ok(()) };
    let fault = if planned.at_touch().is_some() {
        if law.leaves_zone_open() {
            return Ok(());
        }
        ContactModelFault::RefinedLine { body: mesh.name.clone(), width: 2.0 * line.half_width }
    } else if let Some(body) = bodies().find(|body| body.kind.is_meshed_here()) {
        ContactModelFault::LineOfSplines { body: body.name.clone() }
    } else {
        return Ok(());
    };
    Err(AdaptiveError::ContactModel { contact: contact.name.clone(), fault })
}

/// Checks that contacts with one model for the whole run find their zones, but on bodies whose elements
/// the program is to choose by `wishes`, and that those refined at the touch do not touch a mesh along a line.
///
/// # Errors
/// As [`zone_on_mesh`] and [`crate::body::zone::at_start::ZoneRequest::width`]; [`AdaptiveError::ContactModel`] for a line that no strip of sides follows.
pub fn check_zones(run: &Prepared<'_>, wishes: &[SizeRequest]) -> Result<(), AdaptiveError> {
    for planned in run.contacts() {
        check_line(run, planned)?;
        let (bodies, Some((_, sites))) = (planned.spec.bodies(), planned.from_start()) else { continue };
        for (body, site) in bodies.zip([Some(sites.contact_body), sites.target]) {
            let (spec, Some(site)) = (&run.spec().bodies[body], site) else { continue };
            let is_chosen = wishes.get(body).is_some_and(|wish| wish.elements);
            let is_known = |request: &ZoneRequest<'_>| !is_chosen || request.law.interval.width.is_some();
            if let Some((elastic, request)) = spec.kind.elastic().zip(planned.request(site).filter(is_known))
            {
                request.check(&spec.name, elastic)?;
            }
            if let Some(mesh) = spec.kind.meshed() {
                let surface = MeshSurface::of(&mesh.mesh);
                let wanted = |wanted: &StartZone<'_>| zone_on_mesh(&spec.name, &surface, wanted).map(|_| ());
                start_zone(run, planned, body, site, wanted).unwrap_or(Ok(()))?;
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
    run: &Prepared<'_>,
    zones: &[Option<Zones>],
    turns: &[Vec<Vector3<f64>>],
) -> Result<Vec<Interface>, AdaptiveError> {
    let spec = run.spec();
    let of_body = |b: usize| {
        let modes = interface_modes(run, b)?;
        let with_interface = |(c, _): &(PlannedContact<'_>, _)| added_modes(*c).is_some();
        let contacts = run.contacts().zip(zones).filter(with_interface);
        let zones = contacts.filter_map(|(c, zones)| zones.as_ref()?.on(c.spec, b));
        let mut unknowns: Vec<usize> = zones.flat_map(|zone| zone.unknowns.iter().copied()).collect();
        unknowns.sort_unstable();
        unknowns.dedup();
        let has_answers = spec.bodies[b].kind.flexible().is_some_and(FlexibleSpec::has_static_answers);
        let loads =
            if has_answers { StaticLoads::on_body(spec, b, &turns[b]) } else { StaticLoads::default() };
        Ok(Interface { unknowns, modes, loads })
    };
    (0..spec.bodies.len()).map(of_body).collect()
}

/// The modes that a contact adds to bodies by zones that it has from the start.
fn added_modes(contact: PlannedContact<'_>) -> Option<InterfaceModes> {
    contact.from_start()?.0.treatment.interface_modes()
}

/// The modes of the interface that the contacts of body `index` need in its reduction. Coarse and
/// adaptive contacts need none: low-frequency modes are enough for them.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] if contacts want different ones, or the reduction does not fit.
pub fn interface_modes(run: &Prepared<'_>, index: usize) -> Result<InterfaceModes, AdaptiveError> {
    let body = &run.spec().bodies[index];
    let unsupported = |what| Err(AdaptiveError::unsupported_body(&body.name, what));
    let Some(flexible) = body.kind.flexible().filter(|_| body.kind.has_elements()) else {
        return Ok(InterfaceModes::default());
    };
    let on_body = || run.contacts().filter(|contact| contact.spec.acts_on(index));
    let mut wanted = on_body().filter_map(added_modes);
    let Some(modes) = wanted.next() else { return Ok(InterfaceModes::default()) };
    if let Some(other) = wanted.find(|other| *other != modes) {
        return unsupported(format!(
            "{} and {} contacts on one body cannot be mixed, choose one model",
            modes.name(),
            other.name()
        ));
    }
    if modes.need_bounds() && !matches!(flexible.reduction, ReductionSpec::CraigBampton { .. }) {
        return unsupported(format!("{} contact needs reduction.method = \"craig-bampton\"", modes.name()));
    }
    if modes != InterfaceModes::Quasistatic && on_body().any(|contact| contact.at_touch().is_some()) {
        return unsupported(format!(
            "{} contact and one that the program refines cannot be mixed on one body, whose low-frequency modes alone may be dynamic; \
             choose one model",
            modes.name()
        ));
    }
    Ok(modes)
}

/// The force element of a contact and its facts.
///
/// # Errors
/// [`AdaptiveError::Contact`] if its values make no contact.
pub fn build_contact(
    run: &Prepared<'_>,
    planned: PlannedContact<'_>,
    zones: Option<&Zones>,
    bodies: &[BodyModel],
) -> Result<(RunContact, ContactFacts), AdaptiveError> {
    let spec = planned.spec;
    let fail = |source| AdaptiveError::Contact { contact: spec.name.clone(), source };
    // Of thousands of rigid bodies by Hertz's law none is measured.
    let of_body = || bodies[spec.body].size();
    let (element, size): (Box<dyn ActiveContact>, f64) = match (spec.law.surface(), zones) {
        (Some(law), Some(zones)) => (zone_contact(run, (spec, law), zones, bodies).map_err(fail)?, of_body()),
        (Some(_), None) => {
            (Box::new(Active::new(StandIn::inactive((spec.body, spec.target.body())))), of_body())
        }
        (None, _) => {
            let contact = hertz_contact(spec, bodies)?;
            let size = contact.size();
            (Box::new(Active::new(contact)), size)
        }
    };
    let width = zones.map(|zones| zones.contact_body.widths[0]);
    let facts = ContactFacts::new(run.spec(), spec, bodies, size, width)?;
    let recovery = zones.map(|zones| PressureRecovery::new(&zones.contact_body.points));
    let element = RunContact::new(element).with_pressures(recovery);
    Ok((element.with_damping(spec.damping).map_err(fail)?, facts))
}

/// The force element of a contact by Hertz's law.
fn hertz_contact(spec: &ContactSpec, bodies: &[BodyModel]) -> Result<HertzContact, AdaptiveError> {
    let Some(law) = spec.law.hertz() else { return Err(no_surface(spec)) };
    let fail = |source| AdaptiveError::Contact { contact: spec.name.clone(), source };
    let surface = |body: usize| {
        let none = || {
            let what = AdaptiveError::no_surface(&bodies[body].name);
            AdaptiveError::unsupported_contact(&spec.name, what)
        };
        bodies[body].surface()?.ok_or_else(none)
    };
    let solids = law.solids();
    let contact = match spheres(spec, bodies)? {
        Some((own, target)) => HertzContact::of_spheres(own, target, solids[1]),
        None => {
            let surfaces = Detector::of(spec.body, spec.target, surface)?;
            match [law.contact.thickness, law.target.thickness] {
                [None, None] => HertzContact::of_surfaces(surfaces, solids),
                thicknesses => HertzContact::of_plane_surfaces(surfaces, solids, thicknesses),
            }
        }
    };
    contact.and_then(|contact| contact.with_friction(law.friction)).map_err(fail)
}

/// Contact with one model for the whole run (theory section C.8), of rigid bodies that of the points of both (C.18).
fn zone_contact(
    run: &Prepared<'_>,
    (contact, law): (&ContactSpec, &SurfaceLaw),
    zones: &Zones,
    bodies: &[BodyModel],
) -> Result<Box<dyn ActiveContact>, ContactError> {
    let poses = &run.touches.poses;
    let (body, zone) = (contact.body, &zones.contact_body);
    let target = contact.target.body().zip(zones.target.as_ref());
    let flexible = |(body, zone)| Some(Side { body, model: bodies[body].flexible()?, zone });
    let Some(own) = flexible((body, zone)) else {
        return rigid_contact(run, (contact, law), (body, zone), target, bodies);
    };
    let other = target.and_then(flexible);
    let on_target = other.map(|side| side.of_contact(law)).or_else(|| {
        let body = contact.target.body()?;
        Some(bodies[body].rigid_surface()?.side(body, false))
    });
    let mut made = aligned(law, contact, &own.of_contact(law), on_target.as_ref(), poses)?;
    if law.penalty.is_none() {
        let sides: Vec<Side<'_>> = [Some(own), other].into_iter().flatten().collect();
        default_penalty::set(made.as_mut(), law, &sides, bodies, poses)?;
    }
    Ok(made)
}

/// The contact of the sides `own` and `other`, on a plane that keeps the symmetry of the model in the motions `poses`.
fn aligned(
    law: &SurfaceLaw,
    contact: &ContactSpec,
    own: &ContactSide<'_>,
    other: Option<&ContactSide<'_>>,
    poses: &[BodyState],
) -> Result<Box<dyn ActiveContact>, ContactError> {
    let made = ZoneContact::new(law, contact.target, own, other)?;
    if let ZoneContact::Plane(plane) = &made {
        plane.check_alignment(&poses[contact.body].rotation)?;
    }
    Ok(made.active())
}

/// Contact of two rigid bodies, or of one and a plane, with points on their whole surfaces.
fn rigid_contact(
    run: &Prepared<'_>,
    (contact, law): (&ContactSpec, &SurfaceLaw),
    own: (usize, &ContactZone),
    target: Option<(usize, &ContactZone)>,
    bodies: &[BodyModel],
) -> Result<Box<dyn ActiveContact>, ContactError> {
    let side = |(body, zone): (usize, _)| {
        let surface = bodies[body].rigid_surface();
        let surface = surface.ok_or(ContactError::Nothing { what: "a body has no surface to touch" })?;
        Ok::<_, ContactError>(ContactSide { zone, ..surface.side(body, true) })
    };
    let (side, other) = (side(own)?, target.map(side).transpose()?);
    let mut made = aligned(law, contact, &side, other.as_ref(), &run.touches.poses)?;
    if let Some(other) = &other {
        let mirrored = ZoneContact::new(law, Target::Body(own.0), other, Some(&side))?.active();
        made = Box::new(ContactSides::new(made, Some(mirrored), 0.0)?);
    }
    if law.penalty.is_none() {
        let meeting = made.meeting(Motion::new(0.0, &run.touches.poses));
        made.set_penalty(default_penalty::of_rigid(&run.touches, contact, own.1, &meeting))?;
    }
    Ok(made)
}
