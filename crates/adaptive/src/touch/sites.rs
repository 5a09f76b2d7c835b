//! Surfaces of undeformed bodies, and where they are nearest.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::{SearchWorkspace, SurfaceModel, minimum_distance};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use crate::spec::{BodySpec, ContactSpec, Target};
use crate::surface::{self, Surface, SurfacePlace};

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
    known: RefCell<HashMap<usize, OfShape>>,
}

impl<'a> Surfaces<'a> {
    /// Those of `bodies`, of which none is known yet.
    pub fn new(bodies: &'a [BodySpec]) -> Self {
        Self { bodies, known: RefCell::default() }
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
        let mut known = self.known.borrow_mut();
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

/// Nearest places of two undeformed bodies in the motions `poses`.
fn pair_sites(surfaces: [&KnownSurface; 2], poses: [&BodyState; 2]) -> Result<Sites, ContactError> {
    let models = surfaces.map(|known| known.model.as_ref());
    let nearest = minimum_distance(models, poses, &mut SearchWorkspace::new())?;
    let [own, target] = [0, 1].map(|i| {
        let site = &nearest.sites[i];
        surfaces[i].surface.place(site.face, &site.xi)
    });
    Ok(Sites { contact_body: own, target: Some(target) })
}

/// Places where the undeformed bodies of a contact are nearest to each other, or lowest over a
/// plane, in the motions `poses`; `own` and `target` are their numbers and surfaces.
///
/// # Errors
/// [`ContactError`] if they cannot be found.
pub(super) fn nearest_sites(
    contact: &ContactSpec,
    (body, own): &(usize, KnownSurface),
    target: Option<&(usize, KnownSurface)>,
    poses: &[BodyState],
) -> Result<Sites, ContactError> {
    match (contact.target, target) {
        (Target::Plane { normal, .. }, _) => {
            let contact_body = lowest(own.surface.as_ref(), &poses[*body], &normal)?;
            Ok(Sites { contact_body, target: None })
        }
        (Target::Body(_), Some((other, target))) => {
            pair_sites([own, target], [&poses[*body], &poses[*other]])
        }
        (Target::Body(_), None) => Err(ContactError::Nothing { what: "a body has no surface to touch" }),
    }
}
