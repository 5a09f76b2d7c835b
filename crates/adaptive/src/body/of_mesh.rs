//! Flexible bodies of finite elements, and their meshes divided about a contact.

use std::borrow::Cow;
use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::{SurfaceModel, SurfaceSite};
use faer::{Mat, MatRef};
use ffr_dynamics::body::AssembledBody;
use iga_core::elasticity::Material;
use nalgebra::{UnitQuaternion, Vector3};

use super::field::Field;
use super::field_body::{FieldBody, ReductionSettings};
use super::fine::FineModel;
use crate::contact_zone::ContactZone;
use crate::error::AdaptiveError;
use crate::fine_elements::{FineElements, WantedZone, usual_elements};
use crate::interval::IntervalGrid;
use crate::local_surface::SurfaceView;
use crate::mesh_surface::{MeshSurface, SideSite};
use crate::meshed::MeshedBody;
use crate::record::ZoneSite;
use crate::spec::{Accuracy, IntervalSpec, MeshedSpec, PointRule};
use crate::store::{Bytes, meshed_definition};
use crate::touch_sites::TouchSite;
use crate::unsupported::Unsupported;

impl FieldBody for MeshedBody {
    fn as_field(&self) -> &dyn Field {
        self
    }

    fn assembled(&self) -> &AssembledBody {
        &self.assembled
    }

    fn settings(&self) -> ReductionSettings<'_> {
        let MeshedSpec { reduction, damping, frame, geometric_stiffening, .. } = &self.spec;
        ReductionSettings { basis: *reduction, damping, frame, is_stiffened: *geometric_stiffening }
    }

    fn definition(&self) -> Vec<u8> {
        meshed_definition(&self.spec)
    }

    fn slowest_material(&self) -> Option<&Material> {
        self.spec.slowest_material()
    }

    fn size(&self) -> f64 {
        self.spec.mesh.size()
    }

    fn surface(&self, shapes: MatRef<'_, f64>) -> Result<SurfaceModel, ContactError> {
        let pieces = MeshSurface::of(&self.spec.mesh).pieces();
        SurfaceModel::of_pieces(self.motion(), &pieces, &self.lookup, shapes)
    }

    fn n_faces(&self) -> usize {
        self.spec.mesh.surface().len()
    }

    fn refined(
        self: Arc<Self>,
        site: &ZoneSite,
        interval: &IntervalSpec,
    ) -> Result<Box<dyn FineModel>, AdaptiveError> {
        if site.is_whole() {
            return Err(AdaptiveError::unsupported_body(&self.name, Unsupported::WholeMesh));
        }
        let [u, v, _] = site.centre;
        let place = MeshSurface::of(&self.spec.mesh).site(site.face as usize, [u, v]);
        let usual = || interval.elements_or(usual_elements(&self.spec.mesh));
        let is_usual = interval.elements.is_none() && interval.accuracy == Accuracy::default();
        let elements = (!is_usual).then(usual);
        let wanted = WantedZone { site: place, widths: site.widths, elements };
        Ok(Box::new(FineElements::build(&self, &wanted)?))
    }

    fn face_number(&self, found: &SurfaceSite) -> u32 {
        found.element as u32
    }

    fn zone_site(&self, site: &TouchSite, width: f64) -> ZoneSite {
        let TouchSite::Side(SideSite { side, eta, .. }) = *site else { return ZoneSite::default() };
        ZoneSite { face: side as u32, centre: [eta[0], eta[1], 0.0], widths: [width; 2], meets: None }
    }

    fn zone_places(&self, sites: [&ZoneSite; 2]) -> Option<[[f64; 3]; 2]> {
        let surface = MeshSurface::of(&self.spec.mesh);
        Some(sites.map(|s| surface.site(s.face as usize, [s.centre[0], s.centre[1]]).point))
    }

    fn view_at(&self, rotation: &UnitQuaternion<f64>, found: &SurfaceSite) -> Option<SurfaceView> {
        let side = MeshSurface::of(&self.spec.mesh).site(found.element, [found.xi[0], found.xi[1]]);
        SurfaceView::of_mesh(&self.spec, rotation, &side)
    }

    fn mesh(&self) -> Option<&MeshedBody> {
        Some(self)
    }
}

impl FineModel for FineElements {
    fn field(&self) -> &dyn Field {
        self
    }

    fn zone(&self, _rule: PointRule, _contact: &str) -> Result<ContactZone, AdaptiveError> {
        self.contact_zone()
    }

    fn grid(&self) -> IntervalGrid {
        self.rows()
    }

    fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        self.rows_of(zone)
    }

    fn assemble(&self) -> Result<Cow<'_, AssembledBody>, AdaptiveError> {
        self.assembled().map(Cow::Owned)
    }

    fn prolong(&self, shapes: MatRef<'_, f64>) -> Mat<f64> {
        self.prolonged(shapes)
    }

    fn definition(&self) -> Bytes {
        self.zone_definition()
    }

    fn outward(&self) -> Option<Vector3<f64>> {
        self.normal()
    }

    fn mesh(&self) -> Option<&FineElements> {
        Some(self)
    }
}
