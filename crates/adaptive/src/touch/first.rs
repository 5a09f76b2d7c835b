//! Where and how the contacts of a run touch first, before anything is built: one answer for plans,
//! sizes, checks, costs and pictures.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use contact_qs::ContactError;
use contact_qs::search::SurfaceSite;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use crate::record::TouchedPart;
use crate::spec::{ContactSpec, RunSpec};
use crate::surface::{POLE, Surface, SurfacePlace};
use crate::touch::flight::touch_in_flight;
use crate::touch::hertz::local_surface::SurfaceView;
use crate::touch::hertz::{HertzLaw, LocalSurface, across_line};
use crate::touch::parts::side::{Moved, Side};
use crate::touch::parts::{NO_ELLIPSE, Touch, TouchKind, pressed_parts};
use crate::touch::sites::{Pair, Sites, Surfaces};
use crate::touch::tolerances::{PARALLEL_AT_START, TOUCHED_SURFACE};

/// The first touch of a contact.
#[derive(Debug, Clone)]
pub struct FirstTouch {
    /// Motions of the bodies just before it; those at the start if it is not known.
    pub poses: Vec<BodyState>,
    /// Its places on the bodies; if it is not known, where they are nearest at the start.
    pub sites: Sites,
    /// The parts of the surfaces of contact body and target that may press there, of a touch that is
    /// known.
    pub parts: [Option<TouchedPart>; 2],
    /// What touches; none if it is not known: of bodies that move on joints or under loads, and of
    /// those that do not meet.
    pub kind: Option<TouchKind>,
}

/// The first touches of the contacts of a run, each looked for once.
pub struct FirstTouches<'a> {
    /// Bodies and contacts.
    pub spec: &'a RunSpec,
    /// Motions of the bodies at the start.
    pub poses: Vec<BodyState>,
    surfaces: Surfaces<'a>,
    known: Mutex<HashMap<String, Found>>,
    measured: Mutex<HashMap<(TypeId, usize), Measured>>,
}

/// What has been measured of a body.
type Measured = Box<dyn Any + Send + Sync>;

/// Longest way through a body \[m\].
#[derive(Clone, Copy)]
struct Size(f64);

/// What was found of a contact; none if one of its bodies has no surface.
type Found = Option<Result<Arc<FirstTouch>, ContactError>>;

impl<'a> FirstTouches<'a> {
    /// Those of the contacts of `spec` with the motions `poses` at the start.
    pub fn new(spec: &'a RunSpec, poses: Vec<BodyState>) -> Self {
        Self {
            spec,
            poses,
            surfaces: Surfaces::new(&spec.bodies),
            known: Mutex::default(),
            measured: Mutex::default(),
        }
    }

    /// The same touches of the same bodies and contacts, whose sizes alone are those of `spec` now.
    #[must_use]
    pub fn with_sizes(self, spec: &'a RunSpec) -> Self {
        Self { spec, surfaces: self.surfaces.with_bodies(&spec.bodies), ..self }
    }

    /// What `measure` finds of body `body`: once for all contacts and all that ask for a `T`. It may not depend on elements or modes, which
    /// [`FirstTouches::with_sizes`] changes.
    pub fn measured<T: Any + Clone + Send + Sync>(&self, body: usize, measure: impl FnOnce() -> T) -> T {
        let measured = || self.measured.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (TypeId::of::<T>(), body);
        if let Some(found) = measured().get(&key).and_then(|found| found.downcast_ref::<T>()) {
            return found.clone();
        }
        // Not while the lock is held: what measures may take up other work that asks here.
        let found = measure();
        measured().insert(key, Box::new(found.clone()));
        found
    }

    /// The surface of body `body`; none of a body that has no surface to touch.
    pub fn surface(&self, body: usize) -> Option<Arc<dyn Surface>> {
        self.surfaces.of(body).ok().flatten().map(|known| known.surface)
    }

    /// Longest way through body `body` \[m\]; zero without a surface.
    pub fn size(&self, body: usize) -> f64 {
        self.measured(body, || Size(self.surface(body).map_or(0.0, |surface| surface.length()))).0
    }

    /// Where the bodies of `contact` are nearest at the start; `None` if one of them has no
    /// surface.
    ///
    /// # Errors
    /// [`ContactError`] if these places cannot be found.
    pub fn at_start(&self, contact: &ContactSpec) -> Option<Result<Sites, ContactError>> {
        let pair = Pair::new(&self.surfaces, contact).transpose()?;
        Some(pair.and_then(|pair| pair.sites(&self.poses)))
    }

    /// The first touch of `contact`; `None` if one of its bodies has no surface.
    ///
    /// # Errors
    /// [`ContactError`] if nearest places cannot be found.
    fn find(&self, contact: &ContactSpec) -> Found {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known.get(&contact.name) {
            return known.clone();
        }
        known.entry(contact.name.clone()).or_insert(self.look(contact)).clone()
    }

    /// The same, without the reason where there is none.
    pub fn of(&self, contact: &ContactSpec) -> Option<Arc<FirstTouch>> {
        self.find(contact)?.ok()
    }

    /// What touches first in `contact`; `None` if it is not known.
    pub fn kind(&self, contact: &ContactSpec) -> Option<TouchKind> {
        self.of(contact)?.kind
    }

    fn look(&self, contact: &ContactSpec) -> Found {
        let pair = match Pair::new(&self.surfaces, contact) {
            Ok(pair) => pair?,
            Err(error) => return Some(Err(error)),
        };
        let flight = touch_in_flight(self.spec, pair.detector(), contact, &self.poses);
        let Some((poses, nearest)) = flight else {
            let at_start = |sites| {
                Arc::new(FirstTouch { poses: self.poses.clone(), sites, parts: [None; 2], kind: None })
            };
            return Some(pair.sites(&self.poses).map(at_start));
        };
        let (own, other) = pair.in_motion(&poses);
        let Touch { nearest, kind, normal, .. } = Touch::at(own, other, &nearest, PARALLEL_AT_START);
        let place = |moved: Moved<'_>, site: &SurfaceSite, outward: &Vector3<f64>| {
            Side::new(moved).facing(outward).facing_place(site)
        };
        let sites = Sites {
            contact_body: place(own, &nearest.contact, &-normal),
            target: other.zip(nearest.target.as_ref()).map(|(other, site)| place(other, site, &normal)),
        };
        let at = [Some(sites.contact_body.point), sites.target.map(|site| site.point)];
        let sizes = [Some(own), other].into_iter().flatten().map(|(surface, _)| surface.length());
        let depth = TOUCHED_SURFACE * sizes.fold(f64::INFINITY, f64::min);
        let parts = pressed_parts([Some(own), other], at, &normal, depth);
        Some(Ok(Arc::new(FirstTouch { poses, sites, parts, kind: Some(kind) })))
    }

    /// The reason for which Hertz's law, if `contact` has it, does not hold for its first touch;
    /// `None` if it holds, or if the touch is not known.
    pub fn no_hertz_point(&self, contact: &ContactSpec) -> Option<&'static str> {
        if contact.law.hertz().is_none() || contact.spheres().is_some() {
            return None;
        }
        let touch = self.of(contact)?;
        let kind = touch.kind?;
        if let Some(reason) = kind.no_hertz_point() {
            // What another contact holds does not fly on as far as an edge.
            let is_held = |other: &ContactSpec| {
                other.name != contact.name && other.bodies().any(|b| contact.acts_on(b))
            };
            let may_miss = kind == TouchKind::Edge && self.spec.contacts.iter().any(is_held);
            return (!may_miss).then_some(reason);
        }
        let pair = Pair::new(&self.surfaces, contact).ok()??;
        let (own, other) = pair.in_motion(&touch.poses);
        let view = |(surface, pose): Moved<'_>, place: &SurfacePlace| {
            SurfaceView::new(surface, 1.0, &pose.rotation, place)
        };
        let own_view = view(own, &touch.sites.contact_body)?;
        if own.0.motion() == RigidMotion::Axial && own_view.point[0].abs() > POLE * own.0.reach() {
            return Some("bodies touch along a ring");
        }
        let other = match (other, &touch.sites.target) {
            (Some(other), Some(site)) => view(other, site)?.surface,
            _ => LocalSurface::plane(1.0),
        };
        let surfaces = [own_view.surface, other];
        let has_law = if own.0.motion() == RigidMotion::Planar {
            across_line(&surfaces, self.size(contact.body)).is_some()
        } else {
            HertzLaw::new(&surfaces).is_some()
        };
        (!has_law).then_some(NO_ELLIPSE)
    }
}
