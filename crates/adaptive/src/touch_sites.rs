//! Where the bodies of a contact are nearest at the start of a run.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use contact_qs::search::{SearchWorkspace, SurfaceModel, SurfaceSite, minimum_distance, plane_distance};
use contact_qs::{ContactError, DofLookup, Plane};
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::system::force::BodyState;
use nalgebra::{Unit, Vector3};

use crate::mesh_surface::{MeshSurface, SideSite};
use crate::spec::{BodyKind, BodySpec, ContactSpec, Geometry, RunSpec, Target};
use crate::zone_at_start::ContactSite;

/// A place on the surface of a body about which a contact has its zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TouchSite {
    /// On a face of a shape.
    Face(ContactSite),
    /// On a side of a mesh.
    Side(SideSite),
}

impl TouchSite {
    /// Undeformed position in the model's components \[m\].
    pub fn point(&self) -> &[f64; 3] {
        match self {
            Self::Face(site) => &site.point,
            Self::Side(site) => &site.point,
        }
    }
}

/// First places of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sites {
    /// On the contact body.
    pub contact_body: TouchSite,
    /// On the target; none on a plane.
    pub target: Option<TouchSite>,
}

/// The surface of an undeformed body, flexible or rigid.
pub(crate) enum Undeformed<'a> {
    Shape(Geometry<'a>),
    Mesh(Arc<MeshSurface>),
}

impl<'a> Undeformed<'a> {
    /// The surface of `body`; none of a body that has no surface to touch.
    pub fn new(body: &'a BodySpec) -> Option<Self> {
        match &body.kind {
            BodyKind::Meshed(meshed) => Some(Self::Mesh(MeshSurface::of(&meshed.mesh))),
            BodyKind::Elastic(_) | BodyKind::Rigid(_) | BodyKind::Imported(_) => {
                body.geometry().map(Self::Shape)
            }
        }
    }

    /// Its rigid motions.
    pub fn motion(&self) -> RigidMotion {
        match self {
            Self::Shape(body) => body.motion(),
            Self::Mesh(_) => RigidMotion::Spatial,
        }
    }

    /// Its surface for searches.
    pub fn model(&self) -> Result<SurfaceModel, ContactError> {
        match self {
            Self::Shape(body) => SurfaceModel::rigid(self.motion(), &body.shape.patches),
            Self::Mesh(surface) => {
                let none = Mat::<f64>::zeros(0, 0);
                SurfaceModel::of_pieces(self.motion(), &surface.pieces(), &DofLookup::new(&[]), none.as_ref())
            }
        }
    }

    fn site(&self, found: &SurfaceSite) -> TouchSite {
        match self {
            Self::Shape(body) => TouchSite::Face(ContactSite::new(body, found.face, found.xi)),
            Self::Mesh(surface) => TouchSite::Side(surface.site(found.element, [found.xi[0], found.xi[1]])),
        }
    }

    /// The first point to touch a plane of the given normal.
    fn lowest(&self, pose: &BodyState, normal: &Vector3<f64>) -> Result<TouchSite, ContactError> {
        let none = ContactError::Empty { width: 0.0 };
        match self {
            Self::Shape(body) => ContactSite::lowest(body, &pose.rotation.inverse_transform_vector(normal))
                .map(TouchSite::Face)
                .ok_or(none),
            Self::Mesh(surface) => {
                let plane = Plane { point: Vector3::zeros(), normal: Unit::new_normalize(*normal) };
                let pose = BodyState { elastic: Vec::new(), elastic_rates: Vec::new(), ..pose.clone() };
                let found = plane_distance(&self.model()?, &pose, &plane, &mut SearchWorkspace::new())?;
                let place = surface.site(found.site.element, [found.site.xi[0], found.site.xi[1]]);
                let towards = pose.rotation.inverse_transform_vector(normal);
                Ok(TouchSite::Side(surface.facing(&place, &-towards)))
            }
        }
    }
}

/// Surfaces of one shape by the motions of the bodies that have it.
type OfShape = Vec<(RigidMotion, Arc<SurfaceModel>)>;

/// Surfaces of undeformed bodies, one for all that share a shape or a mesh, by where that lies in memory.
#[derive(Default)]
pub(crate) struct Surfaces {
    known: RefCell<HashMap<usize, OfShape>>,
}

impl Surfaces {
    /// The surface of `body`; none of a body that has no surface to touch.
    pub fn of(&self, body: &BodySpec) -> Result<Option<Arc<SurfaceModel>>, ContactError> {
        let address = match &body.kind {
            BodyKind::Meshed(meshed) => Arc::as_ptr(&meshed.mesh).addr(),
            _ => match body.geometry() {
                Some(geometry) => std::ptr::from_ref(geometry.shape).addr(),
                None => return Ok(None),
            },
        };
        let motion = body.kind.motion();
        let mut known = self.known.borrow_mut();
        let known = known.entry(address).or_default();
        if let Some((_, surface)) = known.iter().find(|(of, _)| *of == motion) {
            return Ok(Some(Arc::clone(surface)));
        }
        let Some(undeformed) = Undeformed::new(body) else { return Ok(None) };
        let surface = Arc::new(undeformed.model()?);
        known.push((motion, Arc::clone(&surface)));
        Ok(Some(surface))
    }
}

/// Places at which a contact of surfaces is first, the undeformed bodies being nearest or lowest there in the motions `poses`; `None` if a body has
/// no surface to touch.
///
/// # Errors
/// [`ContactError`] if nearest places cannot be found.
pub fn sites(
    spec: &RunSpec,
    contact: &ContactSpec,
    poses: &[BodyState],
) -> Option<Result<Sites, ContactError>> {
    let own = Undeformed::new(&spec.bodies[contact.body])?;
    let other = match &contact.target {
        Target::Body(other) => *other,
        Target::Plane { normal, .. } => {
            let site = own.lowest(&poses[contact.body], normal);
            return Some(site.map(|contact_body| Sites { contact_body, target: None }));
        }
    };
    let target = Undeformed::new(&spec.bodies[other])?;
    Some(pair_sites([own, target], [&poses[contact.body], &poses[other]]))
}

/// The same without a reason where there is none.
pub fn first_sites(spec: &RunSpec, contact: &ContactSpec, poses: &[BodyState]) -> Option<Sites> {
    sites(spec, contact, poses)?.ok()
}

/// Nearest places of two undeformed bodies.
fn pair_sites(bodies: [Undeformed<'_>; 2], poses: [&BodyState; 2]) -> Result<Sites, ContactError> {
    let models = [bodies[0].model()?, bodies[1].model()?];
    let nearest = minimum_distance([&models[0], &models[1]], poses, &mut SearchWorkspace::new())?;
    let [own, target] = [0, 1].map(|i| bodies[i].site(&nearest.sites[i]));
    Ok(Sites { contact_body: own, target: Some(target) })
}
