//! What is known of a run before any model is built, made once and handed on: motions at the start,
//! first touches, and when each contact gets its zones, about which places of the bodies.

use contact_qs::ContactError;
use iga_core::space::PatchSpace;

use crate::body::mesh::part_of;
use crate::body::zone::at_start::{ZoneRequest, refined_width};
use crate::error::{AdaptiveError, ContactModelFault};
use crate::spec::{BodyKind, BodySpec, ContactSpec, ElasticSpec, Extent, Place, RunSpec, SurfaceLaw};
use crate::surface::{self, SurfacePlace};
use crate::system::start;
use crate::touch::first::FirstTouches;
use crate::touch::parts::{TouchKind, TouchZone};
use crate::touch::sites::Sites;

/// When a contact gets its zones.
///
/// Adaptive contacts are refined by the program at each touch. Quasistatic, damped and dynamic
/// pairs are too, with the width and penalty factor given, unless both bodies, as far as they are
/// flexible, are refined by their own discretisation at the places where they are nearest at the
/// start and no interval is given: then that refinement is the model of the whole run, as it always
/// is of coarse contacts, of rigid bodies and of those with a plane, unless these are quasistatic and nobody has given
/// a zone.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Plan {
    /// It has none: Hertz's law.
    Point,
    /// They are built at each touch.
    AtTouch,
    /// They are built before the run.
    FromStart(Sites),
}

/// A run before anything is built.
pub struct Prepared<'a> {
    /// Motions at the start, and first touches.
    pub touches: FirstTouches<'a>,
    plans: Vec<Plan>,
}

impl<'a> Prepared<'a> {
    /// What is known of `spec`.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] for bodies that cannot take their part, [`AdaptiveError::Contact`] if nearest places cannot be found,
    /// [`AdaptiveError::Geometry`] or [`AdaptiveError::Mesh`] for places that leave their body; those of the motions at the start.
    pub fn new(spec: &'a RunSpec) -> Result<Self, AdaptiveError> {
        check_places(spec)?;
        Self::planned(FirstTouches::new(spec, start::poses(spec)?))
    }

    fn planned(touches: FirstTouches<'a>) -> Result<Self, AdaptiveError> {
        let contacts = touches.spec.contacts.iter();
        let plans = contacts.map(|contact| plan(&touches, contact)).collect::<Result<_, _>>()?;
        Ok(Self { touches, plans })
    }

    /// The same of the same bodies and contacts, whose meshes and modes alone are those of `spec` now.
    ///
    /// # Errors
    /// As [`Prepared::new`], for contacts.
    pub fn with_sizes(self, spec: &'a RunSpec) -> Result<Self, AdaptiveError> {
        Self::planned(self.touches.with_sizes(spec))
    }

    /// The same with the factors of `spec` applied to the sizes, which changes no plan.
    #[must_use]
    pub fn refined(self, spec: &'a RunSpec) -> Self {
        Self { touches: self.touches.with_sizes(spec), ..self }
    }

    /// Bodies and contacts.
    pub fn spec(&self) -> &'a RunSpec {
        self.touches.spec
    }

    /// The contacts.
    pub fn contacts(&self) -> impl ExactSizeIterator<Item = PlannedContact<'_>> {
        let planned = |(spec, plan)| PlannedContact { spec, plan };
        self.spec().contacts.iter().zip(&self.plans).map(planned)
    }
}

/// A contact of which is known when it gets its zones.
#[derive(Clone, Copy)]
pub struct PlannedContact<'p> {
    /// The contact.
    pub spec: &'p ContactSpec,
    plan: &'p Plan,
}

impl<'p> PlannedContact<'p> {
    /// The law of a contact that gets zones at each touch; none of others.
    pub fn at_touch(self) -> Option<&'p SurfaceLaw> {
        self.spec.law.surface().filter(|_| *self.plan == Plan::AtTouch)
    }

    /// The law of a contact that has zones from the start, and about which places; none of others.
    pub fn from_start(self) -> Option<(&'p SurfaceLaw, &'p Sites)> {
        match self.plan {
            Plan::FromStart(sites) => Some((self.spec.law.surface()?, sites)),
            Plan::Point | Plan::AtTouch => None,
        }
    }

    /// The zones that it asks of body `index` from the start.
    pub fn requests(self, index: usize) -> impl Iterator<Item = ZoneRequest<'p>> {
        let sites = self.from_start().into_iter().flat_map(move |(_, sites)| sites.on(self.spec, index));
        sites.filter_map(move |site| self.request(site))
    }

    /// The zone that it needs on a body at `site`; none by Hertz's law.
    pub fn request(self, site: SurfacePlace) -> Option<ZoneRequest<'p>> {
        Some(ZoneRequest { contact: &self.spec.name, law: self.spec.law.surface()?, site })
    }
}

fn plan(touches: &FirstTouches<'_>, contact: &ContactSpec) -> Result<Plan, AdaptiveError> {
    let spec = touches.spec;
    let Some(law) = contact.law.surface() else {
        let refused = |what| {
            AdaptiveError::unsupported_contact(
                &contact.name,
                format!(
                    "{what}, where Hertz's law needs smooth surfaces that are curved against each other in both directions; choose model = \
                     \"adaptive\", of rigid bodies \"coarse\""
                ),
            )
        };
        return touches.no_hertz_point(contact).map_or(Ok(Plan::Point), |what| Err(refused(what)));
    };
    check_surfaces(spec, contact, law)?;
    if contact.bodies().all(|body| spec.bodies[body].kind.is_rigid()) {
        if matches!(touches.kind(contact), Some(TouchKind::Smooth | TouchKind::Line)) {
            return Err(AdaptiveError::unsupported_contact(&contact.name, "smooth faces of rigid bodies touch where perhaps no contact point \
             stands; choose model = \"hertz\", which follows the closest places, or where they touch along a line take one of them as \
             flexible".into()));
        }
        return find_sites(touches, contact).map(Plan::FromStart);
    }
    if let Some(kind) = open_touch(touches, contact, law) {
        let without_model = |fault| Err(AdaptiveError::ContactModel { contact: contact.name.clone(), fault });
        match kind.zone() {
            TouchZone::Interval => {}
            TouchZone::Whole if law.is_exact() => {
                return without_model(ContactModelFault::ExactWhole { what: kind.parts() });
            }
            TouchZone::Whole => return Ok(Plan::AtTouch),
            TouchZone::Unseen => {
                let is_rigid = contact.target.body().is_some_and(|other| spec.bodies[other].kind.is_rigid());
                return without_model(ContactModelFault::BetweenPoints { is_rigid });
            }
        }
    }
    if law.treatment.is_searched() {
        return Ok(Plan::AtTouch);
    }
    // A rigid target needs no elements.
    let bodies: Vec<&ElasticSpec> = contact.bodies().filter_map(|body| spec.bodies[body].elastic()).collect();
    let is_refined = bodies.iter().all(|b| !b.discretisation.refine.is_empty());
    let has_mesh = contact.bodies().any(|body| spec.bodies[body].kind.brings_mesh());
    let is_left_open = !law.treatment.is_vibrating() && law.interval.width.is_none() && !is_refined;
    // A mesh is not refined: it keeps its zone, and so does its partner. So do bodies on a plane whose
    // zone is given, or part of their modes.
    if has_mesh || contact.target.body().is_none() && !is_left_open {
        return find_sites(touches, contact).map(Plan::FromStart);
    }
    let may_be_refined = is_refined && law.interval.width.is_none() && law.interval.elements.is_none();
    let is_coarse = !law.treatment.has_fine_zone();
    if !is_coarse && !may_be_refined {
        return Ok(Plan::AtTouch);
    }
    let sites = find_sites(touches, contact)?;
    let found = [Some(sites.contact_body), sites.target].into_iter().flatten();
    let is_refined = bodies.iter().zip(found).all(|(b, s)| refined_width(b, &s.point).is_some());
    if !is_coarse && !is_refined {
        return Ok(Plan::AtTouch);
    }
    Ok(Plan::FromStart(sites))
}

/// Whether flat faces, edges or corners touch first in `contact`, so that its zones are the whole
/// surfaces then.
pub fn is_whole(touches: &FirstTouches<'_>, contact: &ContactSpec, law: &SurfaceLaw) -> bool {
    open_touch(touches, contact, law).is_some_and(|kind| kind.zone() == TouchZone::Whole)
}

/// What touches first in a contact whose zone nobody has given and that is quasistatic, or refined
/// by the program.
fn open_touch(touches: &FirstTouches<'_>, contact: &ContactSpec, law: &SurfaceLaw) -> Option<TouchKind> {
    let is_left_open = law.interval.width.is_none();
    if is_left_open && law.treatment.is_static() { touches.kind(contact) } else { None }
}

/// Places about which a contact has zones from the start: where the bodies are nearest then.
fn find_sites(touches: &FirstTouches<'_>, contact: &ContactSpec) -> Result<Sites, AdaptiveError> {
    let none = Err(ContactError::Nothing { what: "a body has no surface to touch" });
    let sites = touches.at_start(contact).unwrap_or(none);
    sites.map_err(|source| AdaptiveError::Contact { contact: contact.name.clone(), source })
}

/// Checks that the contact body can carry points under `law`, and that all have a surface: a rigid one does in a contact without
/// a fine zone and without flexible bodies.
fn check_surfaces(spec: &RunSpec, contact: &ContactSpec, law: &SurfaceLaw) -> Result<(), AdaptiveError> {
    let refused = |what| Err(AdaptiveError::unsupported_contact(&contact.name, what));
    let has_elements = |body: usize| spec.bodies[body].kind.has_elements();
    let wants_elements = law.treatment.has_fine_zone() || contact.bodies().any(has_elements);
    if wants_elements && !has_elements(contact.body) {
        return refused(format!(
            "body \"{}\" is not flexible and carries contact points of model \"coarse\" alone; exchange contact body and target, between \
             two rigid bodies choose \"coarse\" (flat faces, edges, corners) or \"hertz\" (curved faces)",
            spec.bodies[contact.body].name
        ));
    }
    let without = contact.bodies().find(|body| surface::address(&spec.bodies[*body].kind).is_none());
    without.map_or(Ok(()), |body| refused(AdaptiveError::no_surface(&spec.bodies[body].name)))
}

/// Checks that the parts of bodies that joints and loads hold, that move like rigid ones or are observed
/// are parts of them.
///
/// # Errors
/// [`AdaptiveError::Geometry`] or [`AdaptiveError::Mesh`] with the name of the body.
fn check_places(spec: &RunSpec) -> Result<(), AdaptiveError> {
    let joints = spec.joints.iter().chain(&spec.loops).flat_map(|joint| [&joint.parent, &joint.child]);
    let attached = joints.chain(spec.loads.iter().map(|load| &load.at));
    let attached = attached.filter_map(|at| Some((at.body?, &at.place)));
    let places = attached.chain(spec.points.iter().map(|point| (point.body, &point.place)));
    let held = places.filter_map(|(body, place)| match place {
        Place::Area(area) => Some((body, area)),
        Place::Point(_) | Place::Marker(_) => None,
    });
    let bodies = spec.bodies.iter().enumerate().filter_map(|(b, body)| Some((b, body.kind.flexible()?)));
    let rigid = bodies.flat_map(|(b, flexible)| flexible.rigid_areas.iter().map(move |area| (b, area)));
    held.chain(rigid).try_for_each(|(b, area)| {
        let BodySpec { name, kind, .. } = &spec.bodies[b];
        check_extent(name, kind, &area.extent)
    })
}

/// Checks that `extent` is a part of the body `name`.
fn check_extent(name: &str, kind: &BodyKind, extent: &Extent) -> Result<(), AdaptiveError> {
    if let Some(meshed) = kind.meshed() {
        let found = part_of(&meshed.mesh, extent);
        return found.map(|_| ()).map_err(|source| AdaptiveError::Mesh { body: name.into(), source });
    }
    let Some(elastic) = kind.elastic() else { return Ok(()) };
    let space = PatchSpace::new(elastic.shape.patches.clone());
    let found = space.and_then(|space| extent.points(&elastic.shape, &space, &elastic.model));
    found.map(|_| ()).map_err(|source| AdaptiveError::Geometry { body: name.into(), source })
}
