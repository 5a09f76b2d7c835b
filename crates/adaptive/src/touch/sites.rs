//! Surfaces of undeformed bodies, and where they are nearest.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use contact_qs::ContactError;
use contact_qs::search::{BodySurface, Detector, SearchWorkspace, SurfaceModel, SurfaceSite};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use crate::spec::{BodySpec, ContactSpec, Target};
use crate::surface::{self, Surface, SurfacePlace};
use crate::touch::parts::side::Moved;

/// First places of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sites {
    /// On the contact body.
    pub contact_body: SurfacePlace,
    /// On the target; none on a plane.
    pub target: Option<SurfacePlace>,
}

impl Sites {
    /// Those of `contact` that lie on body `index`.
    pub fn on(&self, contact: &ContactSpec, index: usize) -> impl Iterator<Item = SurfacePlace> + use<> {
        let sites = contact.bodies().zip([Some(self.contact_body), self.target]);
        sites.filter(move |(body, _)| *body == index).filter_map(|(_, site)| site)
    }
}

/// The surface of an undeformed body, and the same for searches.
#[derive(Clone)]
pub(crate) struct KnownSurface {
    pub surface: Arc<dyn Surface>,
    pub model: Arc<SurfaceModel>,
}

/// Surfaces of one shape by the motions of the bodies that have it.
type OfShape = Vec<(RigidMotion, KnownSurface)>;

/// Surfaces of undeformed bodies, one for all that share a shape or a mesh, by where that lies in
/// memory.
pub(crate) struct Surfaces<'a> {
    bodies: &'a [BodySpec],
    known: Mutex<HashMap<usize, OfShape>>,
}

impl<'a> Surfaces<'a> {
    /// Those of `bodies`, of which none is known yet.
    pub fn new(bodies: &'a [BodySpec]) -> Self {
        Self { bodies, known: Mutex::default() }
    }

    /// The same of bodies with the same shapes and meshes.
    pub fn with_bodies(self, bodies: &'a [BodySpec]) -> Self {
        Self { bodies, ..self }
    }

    /// The surface of body `body`; none of a body that has no surface to touch.
    pub fn of(&self, body: usize) -> Result<Option<KnownSurface>, ContactError> {
        let body = &self.bodies[body];
        let Some(address) = surface::address(&body.kind) else { return Ok(None) };
        let motion = body.kind.motion();
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let known = known.entry(address).or_default();
        if let Some((_, surface)) = known.iter().find(|(of, _)| *of == motion) {
            return Ok(Some(surface.clone()));
        }
        let Some(surface) = surface::of_body(&body.kind) else { return Ok(None) };
        let model = Arc::new(surface.search_model()?);
        let found = KnownSurface { surface, model };
        known.push((motion, found.clone()));
        Ok(Some(found))
    }
}

/// The first point of a surface in the motion `pose` to touch a plane of the given normal in space.
fn lowest(
    surface: &dyn Surface,
    pose: &BodyState,
    normal: &Vector3<f64>,
) -> Result<SurfacePlace, ContactError> {
    let in_body = pose.rotation.inverse_transform_vector(normal);
    let direction = surface.motion().components(in_body.as_ref());
    surface.lowest(&direction.into()).ok_or(ContactError::Empty { width: 0.0 })
}

/// The undeformed surface of a body.
pub(crate) type OfBody = (usize, KnownSurface);

/// The undeformed surfaces of a contact body and of its target.
pub(crate) struct Pair {
    own: OfBody,
    target: Target<OfBody>,
}

impl Pair {
    /// Those of `contact`; `None` if one of its bodies has none.
    ///
    /// # Errors
    /// [`ContactError`] if a surface cannot be searched.
    pub fn new(surfaces: &Surfaces<'_>, contact: &ContactSpec) -> Result<Option<Self>, ContactError> {
        let of = |body: usize| match surfaces.of(body) {
            Ok(known) => known.map(|known| (body, known)).ok_or(None),
            Err(error) => Err(Some(error)),
        };
        let pair = || Ok(Self { own: of(contact.body)?, target: contact.target.try_map(of)? });
        match pair() {
            Ok(pair) => Ok(Some(pair)),
            Err(None) => Ok(None),
            Err(Some(error)) => Err(error),
        }
    }

    /// The surfaces in the motions `poses`; none of a plane.
    pub fn in_motion<'a>(&'a self, poses: &'a [BodyState]) -> (Moved<'a>, Option<Moved<'a>>) {
        let moved = |(body, known): &'a OfBody| (known.surface.as_ref(), &poses[*body]);
        (moved(&self.own), self.target.as_ref().body().map(moved))
    }

    /// The same for searches.
    pub fn detector(&self) -> Detector {
        let of = |(body, known): &OfBody| BodySurface { body: *body, model: Arc::clone(&known.model) };
        Detector { own: of(&self.own), target: self.target.as_ref().map(of) }
    }

    /// Places where the bodies are nearest to each other, or lowest over a plane, in the motions
    /// `poses`.
    ///
    /// # Errors
    /// [`ContactError`] if they cannot be found.
    pub fn sites(&self, poses: &[BodyState]) -> Result<Sites, ContactError> {
        let (body, own) = &self.own;
        match &self.target {
            Target::Plane(plane) => {
                let contact_body = lowest(own.surface.as_ref(), &poses[*body], &plane.normal)?;
                Ok(Sites { contact_body, target: None })
            }
            Target::Body((_, other)) => {
                let nearest = self.detector().nearest(poses, &mut SearchWorkspace::new())?;
                let place =
                    |known: &KnownSurface, site: &SurfaceSite| known.surface.place(site.face, &site.xi);
                let [at, there] = &nearest.sites;
                Ok(Sites { contact_body: place(own, at), target: Some(place(other, there)) })
            }
        }
    }
}
