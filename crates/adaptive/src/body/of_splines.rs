//! Flexible bodies of splines, and what becomes of them in a contact: splines refined about it, or their own with the whole surface.

use std::borrow::Cow;
use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::{SurfaceModel, SurfaceSite};
use faer::{Mat, MatRef};
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::BodyTurn;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::FaceId;
use iga_core::surface::Face;
use nalgebra::UnitQuaternion;

use super::field::Field;
use super::field_body::{FieldBody, ReductionSettings};
use super::fine::FineModel;
use crate::contact_zone::{ContactZone, PointsAbout};
use crate::elastic_body::{Discretised, ElasticBody};
use crate::error::AdaptiveError;
use crate::fine_model::{ELEMENTS, FineMesh, FineSettings, zone_definition};
use crate::interval::IntervalGrid;
use crate::local_surface::{SurfaceView, plane_compliance};
use crate::record::{TargetPlace, ZoneSite};
use crate::spec::{ElasticSpec, IntervalSpec, PointRule};
use crate::store::{Bytes, body_definition};
use crate::touch_sites::TouchSite;
use crate::wanted_interval::WantedInterval;
use crate::zone_at_start::ContactSite;

impl FieldBody for ElasticBody {
    fn as_field(&self) -> &dyn Field {
        self
    }

    fn assembled(&self) -> &AssembledBody {
        &self.assembled
    }

    fn settings(&self) -> ReductionSettings<'_> {
        let ElasticSpec { reduction, damping, frame, geometric_stiffening, .. } = &self.spec;
        ReductionSettings { basis: *reduction, damping, frame, is_stiffened: *geometric_stiffening }
    }

    fn definition(&self) -> Vec<u8> {
        body_definition(&self.spec)
    }

    fn slowest_material(&self) -> Option<&Material> {
        Some(&self.spec.material)
    }

    fn size(&self) -> f64 {
        self.space.size()
    }

    fn surface(&self, shapes: MatRef<'_, f64>) -> Result<SurfaceModel, ContactError> {
        SurfaceModel::new(self.motion(), &self.shape.patches, &self.space, &self.lookup, shapes)
    }

    fn n_faces(&self) -> usize {
        FaceId::all(&self.shape.patches).len()
    }

    fn refined(
        self: Arc<Self>,
        site: &ZoneSite,
        interval: &IntervalSpec,
    ) -> Result<Box<dyn FineModel>, AdaptiveError> {
        let faces = FaceId::all(&self.shape.patches);
        if site.is_whole() {
            let about = site.place().and_then(|(face, xi)| {
                Some(PointsAbout { face: *faces.get(face as usize)?, xi, meets: site.meets })
            });
            return Ok(Box::new(WholeSurface { body: self, about }));
        }
        let (id, patches) = (faces[site.face as usize], &self.shape.patches);
        let face = Face::new(patches, id, self.spec.model == Model::Axisymmetric);
        let wanted = WantedInterval { face, centre: site.centre, widths: site.widths };
        let elements = interval.elements_or(ELEMENTS);
        let settings = FineSettings { division: interval.division, elements, growth: None };
        let mesh = Arc::new(FineMesh::build(&self, &[wanted], &settings)?);
        Ok(Box::new(RefinedSplines { body: self, mesh, wanted, settings }))
    }

    fn face_number(&self, found: &SurfaceSite) -> u32 {
        FaceId::all(&self.shape.patches).iter().position(|f| *f == found.face).unwrap_or_default() as u32
    }

    fn zone_site(&self, site: &TouchSite, width: f64) -> ZoneSite {
        let TouchSite::Face(ContactSite { face, xi, .. }) = *site else { return ZoneSite::default() };
        let number = FaceId::all(&self.shape.patches).iter().position(|f| *f == face).unwrap_or_default();
        ZoneSite { face: number as u32, centre: xi, widths: [width; 2], meets: None }
    }

    /// Faces have directions of their own.
    fn zone_places(&self, sites: [&ZoneSite; 2]) -> Option<[[f64; 3]; 2]> {
        let faces = FaceId::all(&self.shape.patches);
        let face = faces.get(sites[0].face as usize).filter(|_| sites[0].face == sites[1].face)?;
        let patch = &self.shape.patches[face.patch];
        Some(sites.map(|site| patch.point(&site.centre)))
    }

    fn view_at(&self, rotation: &UnitQuaternion<f64>, found: &SurfaceSite) -> Option<SurfaceView> {
        let body = (self.spec.geometry(), plane_compliance(&self.spec.material));
        SurfaceView::new(body, rotation, found.face, &found.xi)
    }

    fn splines(&self) -> Option<&ElasticBody> {
        Some(self)
    }
}

/// Splines refined about an interval.
struct RefinedSplines {
    body: Arc<ElasticBody>,
    mesh: Arc<FineMesh>,
    wanted: WantedInterval,
    /// How levels were made.
    settings: FineSettings,
}

impl FineModel for RefinedSplines {
    fn field(&self) -> &dyn Field {
        self.mesh.as_ref()
    }

    fn zone(&self, rule: PointRule, contact: &str) -> Result<ContactZone, AdaptiveError> {
        let zone = self.mesh.zone(0, rule);
        zone.map_err(|source| AdaptiveError::Contact { contact: contact.to_owned(), source })
    }

    fn grid(&self) -> IntervalGrid {
        self.mesh.intervals[0].grid()
    }

    fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        self.mesh.contact_elements(0, zone)
    }

    fn assemble(&self) -> Result<Cow<'_, AssembledBody>, AdaptiveError> {
        self.mesh.assemble_unturned(&self.body).map(Cow::Owned)
    }

    fn prolong(&self, shapes: MatRef<'_, f64>) -> Mat<f64> {
        self.mesh.prolong(&self.body.assembled, shapes)
    }

    fn definition(&self) -> Bytes {
        let unturned = self.mesh.rotated.as_ref().filter(|_| self.turn().is_some());
        let wanted = unturned.map_or(self.wanted, |rotated| rotated.net.turn.wanted);
        zone_definition(&self.body, Some((&wanted, &self.settings)))
    }

    fn turn(&self) -> Option<BodyTurn> {
        self.mesh.turn(&self.body)
    }

    fn faces(&self) -> Option<Discretised<'_>> {
        Some(self.mesh.discretised())
    }

    fn splines(&self) -> Option<&Arc<FineMesh>> {
        Some(&self.mesh)
    }
}

/// A body of splines itself: its zone is its whole surface (theory C.9), with points at a place on it if there is one.
struct WholeSurface {
    body: Arc<ElasticBody>,
    about: Option<PointsAbout>,
}

impl FineModel for WholeSurface {
    fn field(&self) -> &dyn Field {
        self.body.as_ref()
    }

    fn zone(&self, _rule: PointRule, contact: &str) -> Result<ContactZone, AdaptiveError> {
        let zone = ContactZone::whole(&self.body.discretised(), self.about.as_ref());
        zone.map_err(|source| AdaptiveError::Contact { contact: contact.to_owned(), source })
    }

    fn grid(&self) -> IntervalGrid {
        IntervalGrid { widths: [self.body.size(), 0.0], ends: Vec::new(), n_elements: [1; 2] }
    }

    fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        vec![[0; 2]; zone.points.len()]
    }

    fn assemble(&self) -> Result<Cow<'_, AssembledBody>, AdaptiveError> {
        Ok(Cow::Borrowed(&self.body.assembled))
    }

    fn prolong(&self, shapes: MatRef<'_, f64>) -> Mat<f64> {
        shapes.to_owned()
    }

    fn definition(&self) -> Bytes {
        zone_definition(&self.body, None)
    }

    fn meets(&self) -> Option<&TargetPlace> {
        self.about.as_ref()?.meets.as_ref()
    }

    fn is_own(&self) -> bool {
        true
    }

    fn faces(&self) -> Option<Discretised<'_>> {
        Some(self.body.discretised())
    }
}
