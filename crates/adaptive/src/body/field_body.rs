//! A flexible body before its reduction: a field with matrices, and how they are to be reduced.

use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::{SurfaceModel, SurfaceSite};
use faer::MatRef;
use ffr_dynamics::body::AssembledBody;
use iga_core::elasticity::Material;
use iga_core::extent::{Extent, longest_element};
use nalgebra::UnitQuaternion;

use super::field::Field;
use super::fine::FineModel;
use super::reduced::{Interface, ReducedBody, ReductionInput, geometric_stiffening, modes_key};
use crate::elastic_body::ElasticBody;
use crate::error::AdaptiveError;
use crate::local_surface::SurfaceView;
use crate::meshed::MeshedBody;
use crate::record::ZoneSite;
use crate::spec::{Area, DampingSpec, FrameSpec, IntervalSpec, ReductionSpec};
use crate::store::ModelCache;
use crate::touch_sites::TouchSite;
use crate::unsupported::Unsupported;

/// How a body is to be reduced.
#[derive(Debug, Clone, Copy)]
pub struct ReductionSettings<'a> {
    /// Reduced basis.
    pub basis: ReductionSpec,
    /// Damping of the elastic coordinates.
    pub damping: &'a DampingSpec,
    /// Reference frame.
    pub frame: &'a FrameSpec,
    /// Whether inertia forces stiffen the body.
    pub is_stiffened: bool,
}

/// A flexible body with its matrices. What a new kind of elements has to say is required; what follows from it is provided.
pub trait FieldBody: Field {
    /// Itself as a field.
    fn as_field(&self) -> &dyn Field;

    /// Matrices.
    fn assembled(&self) -> &AssembledBody;

    /// How it is to be reduced.
    fn settings(&self) -> ReductionSettings<'_>;

    /// What its matrices are made from, as bytes.
    fn definition(&self) -> Vec<u8>;

    /// Its material, the one with the slowest waves if there are several.
    fn slowest_material(&self) -> Option<&Material>;

    /// Size of the body \[m\].
    fn size(&self) -> f64;

    /// Its deformable surface, moving with `shapes`.
    ///
    /// # Errors
    /// [`ContactError`] if the body has no surface.
    fn surface(&self, shapes: MatRef<'_, f64>) -> Result<SurfaceModel, ContactError>;

    /// Number of faces or sides that a [`ZoneSite`] can name.
    fn n_faces(&self) -> usize;

    /// The number by which a [`ZoneSite`] names the face or side that a search has found.
    fn face_number(&self, found: &SurfaceSite) -> u32;

    /// A zone of the width `width` \[m\] about `site`, a place of this body.
    fn zone_site(&self, site: &TouchSite, width: f64) -> ZoneSite;

    /// Undeformed places of two zones \[m\]; none if their directions are not the same.
    fn zone_places(&self, sites: [&ZoneSite; 2]) -> Option<[[f64; 3]; 2]>;

    /// The surface at a place that a search has found, the body's frame turned by `rotation`; none where it has no curvatures.
    fn view_at(&self, rotation: &UnitQuaternion<f64>, found: &SurfaceSite) -> Option<SurfaceView>;

    /// The model refined about `site` with the settings `interval`, or its own elements with their whole surface if that is what `site` says.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the body's name if it cannot be refined so far.
    fn refined(
        self: Arc<Self>,
        site: &ZoneSite,
        interval: &IntervalSpec,
    ) -> Result<Box<dyn FineModel>, AdaptiveError>;

    /// The body of splines, whose faces contact zones lie on; none of one of other elements.
    fn splines(&self) -> Option<&ElasticBody> {
        None
    }

    /// The body of finite elements, whose sides contact zones lie on; none of one of other elements.
    fn mesh(&self) -> Option<&MeshedBody> {
        None
    }

    /// Side of the longest element at a disc or ball that a joint or load holds \[m\]; none of a whole face, with whose edges functions end, and
    /// if there is no such part.
    fn longest_element_at(&self, area: &Area) -> Option<f64> {
        if matches!(area.extent, Extent::Face(_)) {
            return None;
        }
        Some(longest_element(self.space(), &self.points_of(&area.extent).ok()?))
    }

    /// Reduces the body for the given interface.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    fn reduce(&self, interface: &Interface) -> Result<ReducedBody, AdaptiveError> {
        self.reduce_with(interface, &ModelCache::default())
    }

    /// The same in the mean-axis frame and without stiffening, whatever the settings say.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    fn reduce_in_mean_axes(
        &self,
        interface: &Interface,
        cache: &ModelCache,
    ) -> Result<ReducedBody, AdaptiveError> {
        let ReductionSettings { basis, damping, .. } = self.settings();
        let loads = self.load_columns(self.assembled(), &interface.loads)?;
        let key = modes_key(&self.definition(), basis, interface, &loads);
        let input = ReductionInput { body: self.assembled(), reduction: basis, damping, key };
        let reduced = input.reduce(interface, &loads, cache);
        reduced.map_err(|source| AdaptiveError::Reduction { body: self.name().to_owned(), source })
    }

    /// As [`FieldBody::reduce`], with modes from `cache` if they are there.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    fn reduce_with(&self, interface: &Interface, cache: &ModelCache) -> Result<ReducedBody, AdaptiveError> {
        let fail = |source| AdaptiveError::Reduction { body: self.name().to_owned(), source };
        let ReductionSettings { frame, is_stiffened, .. } = self.settings();
        let assembled = self.assembled();
        let mut reduced = self.reduce_in_mean_axes(interface, cache)?;
        let FrameSpec::Tangent(place) = frame else {
            if is_stiffened {
                let what = Unsupported::StiffeningWithoutTangent;
                return Err(AdaptiveError::unsupported_body(self.name(), what));
            }
            return Ok(reduced);
        };
        let support = self.marker_weights(place, UnitQuaternion::identity())?;
        let marker = support.marker("frame", reduced.basis.shapes.as_ref()).map_err(fail)?;
        let frame = marker.tangent_frame(assembled.motion);
        let shapes = frame.shifted_shapes(assembled, reduced.basis.shapes.as_ref()).map_err(fail)?;
        reduced.data = reduced.data.in_tangent_frame(&frame).map_err(fail)?;
        if is_stiffened {
            let stiffening = geometric_stiffening(self.as_field(), assembled, shapes.as_ref(), &support)?;
            reduced.data = reduced.data.with_geometric_stiffening(&stiffening).map_err(fail)?;
        }
        reduced.framed = Some(shapes);
        Ok(reduced)
    }
}
