//! Flexible bodies of finite elements, and their meshes divided about a contact.

use std::borrow::Cow;
use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::SurfaceModel;
use faer::{Mat, MatRef};
use ffr_dynamics::body::AssembledBody;
use iga_core::elasticity::{Material, Model};
use nalgebra::{Matrix3, Vector3};

use crate::adaptivity::interval::{IntervalGrid, finer_elements};
use crate::body::field::Field;
use crate::body::field_body::{FieldBody, LongestElement};
use crate::body::fine::FineModel;
use crate::body::fine::divided::{FineElements, WantedZone};
use crate::body::mesh::MeshedBody;
use crate::body::zone::at_start::StartZone;
use crate::body::zone::on_mesh::zone_on_mesh;
use crate::body::zone::{ContactZone, WholeRequest};
use crate::error::AdaptiveError;
use crate::record::{ZoneSite, ZoneSize};
use crate::spec::{Accuracy, FlexibleSpec, IntervalSpec, PointRule};
use crate::store::{Bytes, meshed_definition};
use crate::surface::Surface;

impl MeshedBody {
    fn wanted_zone(
        &self,
        site: &ZoneSite,
        (widths, finer): ([f64; 2], f64),
        interval: &IntervalSpec,
    ) -> WantedZone {
        let is_usual =
            interval.elements.is_none() && interval.accuracy == Accuracy::default() && finer <= 1.0;
        let elements = |usual| finer_elements(interval.elements_or(usual), finer);
        let sites = site.places().map(|(face, centre)| self.surface.place(face, &centre)).collect();
        let wanted = WantedZone { sites, widths, elements: None, across: site.across };
        let elements = (!is_usual).then(|| elements(wanted.usual_elements(&self.surface)));
        WantedZone { elements, ..wanted }
    }

    /// Unknowns of the interface that the zone at `site` would have with elements divided for it, as `interval` says;
    /// infinite along a line where the shape of the part is not known. None of a whole surface has divided elements.
    pub fn interface_at(&self, site: &ZoneSite, interval: &IntervalSpec) -> f64 {
        let ZoneSize::Interval { widths, finer } = site.size else { return 0.0 };
        self.wanted_zone(site, (widths, finer), interval).interface(&self.surface)
    }
}

impl FieldBody for MeshedBody {
    fn assembled(&self) -> &AssembledBody {
        &self.assembled
    }

    fn settings(&self) -> &FlexibleSpec {
        &self.spec.flexible
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

    /// One entry for the linear and one for the quadratic elements: the longest edge between
    /// corners, and the mean over the elements of the power of their longest edges by which they err,
    /// each with the cube of its edge, in the plane the square, for its volume (Eq. P.20).
    fn longest_elements(&self) -> Vec<LongestElement> {
        let mesh = &self.spec.mesh;
        let dimension = mesh.model().dimension() as i32;
        let longest = |degree: usize| {
            let [mut length, mut volume, mut error] = [0.0_f64; 3];
            let elements = mesh.elements().iter().filter(|e| (e.kind.is_quadratic() as usize + 1) == degree);
            for e in elements {
                let place = |k: u8| Vector3::from(mesh.nodes()[e.nodes[k as usize] as usize]);
                let edges = e.kind.edges().iter().map(|[a, b]| (place(*a) - place(*b)).norm());
                let edge = edges.fold(0.0, f64::max);
                length = length.max(edge);
                volume += edge.powi(dimension);
                error += edge.powi(dimension + 2 * degree as i32);
            }
            let mean = Some((error / volume).powf(0.5 / degree as f64));
            (volume > 0.0).then_some(LongestElement { direction: None, degree, length, mean })
        };
        [1, 2].into_iter().filter_map(longest).collect()
    }

    /// Along the principal axes of its nodes: that of a straight part, more than that of a bent
    /// one. Of an axisymmetric one the diameter or the length.
    fn thickness(&self) -> f64 {
        if *self.spec.mesh.model() == Model::Axisymmetric {
            let radius = self.spec.mesh.nodes().iter().map(|x| x[0]).fold(0.0, f64::max);
            return (2.0 * radius).min(self.undeformed().extent_along(&Vector3::y()));
        }
        let places = || self.spec.mesh.nodes().iter().map(|x| Vector3::from(*x));
        let mean = places().sum::<Vector3<f64>>() / self.spec.mesh.nodes().len() as f64;
        let spread: Matrix3<f64> = places().map(|x| (x - mean) * (x - mean).transpose()).sum();
        let axes = spread.symmetric_eigen().eigenvectors;
        let extent = |d: usize| self.undeformed().extent_along(&axes.column(d).into_owned());
        (0..3).map(extent).fold(f64::INFINITY, f64::min)
    }

    /// Linear sides are their own chords.
    fn height_between_points(&self) -> f64 {
        self.surface.highest_edge() * 0.25
    }

    fn finer_there(&self) -> String {
        "make the elements of the mesh smaller".into()
    }

    fn finer_mesh(&self) -> String {
        let is_linear = self.spec.mesh.elements().iter().any(|e| !e.kind.is_quadratic());
        format!("mesh it with smaller {}elements", if is_linear { "or quadratic " } else { "" })
    }

    fn surface(&self, shapes: MatRef<'_, f64>) -> Result<SurfaceModel, ContactError> {
        let pieces = self.surface.pieces();
        SurfaceModel::of_pieces(self.motion(), &pieces, &self.lookup, shapes)
    }

    fn undeformed(&self) -> &dyn Surface {
        self.surface.as_ref()
    }

    fn whole_zone(&self, request: &WholeRequest, _contact: &str) -> Result<ContactZone, AdaptiveError> {
        let zone = ContactZone::whole_mesh(&self.surface, request);
        zone.map_err(|source| AdaptiveError::Mesh { body: self.name.clone(), source })
    }

    fn zone_at_start(&self, request: &StartZone<'_>) -> Result<ContactZone, AdaptiveError> {
        zone_on_mesh(&self.name, &self.surface, request)
    }

    fn refined(
        self: Arc<Self>,
        site: &ZoneSite,
        size: ([f64; 2], f64),
        interval: &IntervalSpec,
    ) -> Result<Box<dyn FineModel>, AdaptiveError> {
        let wanted = self.wanted_zone(site, size, interval);
        Ok(Box::new(FineElements::build(&self, wanted)?))
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

    fn most_outwards(&self) -> Option<f64> {
        self.most_outwards()
    }

    fn move_out(&self, zone: &mut ContactZone, offset: f64) {
        self.move_out(zone, offset);
    }

    fn mesh(&self) -> Option<&FineElements> {
        Some(self)
    }
}
