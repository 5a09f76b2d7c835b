//! A flexible body before its reduction: a field with matrices, and how they are to be reduced.

pub mod mesh;
pub mod splines;

use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::SurfaceModel;
use faer::MatRef;
use ffr_dynamics::body::AssembledBody;
use iga_core::elasticity::{Material, Model};
use iga_core::extent::{Extent, longest_element};
use nalgebra::UnitQuaternion;

use super::field::Field;
use super::fine::FineModel;
use super::reduced::{Interface, ReducedBody, ReductionInput, geometric_stiffening, modes_key};
use crate::body::mesh::MeshedBody;
use crate::body::splines::ElasticBody;
use crate::body::zone::at_start::StartZone;
use crate::body::zone::{ContactZone, WholeRequest};
use crate::error::AdaptiveError;
use crate::record::ZoneSite;
use crate::spec::{Area, FlexibleSpec, FrameSpec, IntervalSpec};
use crate::store::ModelCache;
use crate::surface::{Surface, SurfacePlace};
use crate::touch::wave::Wave;

/// The longest of some elements of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LongestElement {
    /// Direction of the patch; none of elements that have no directions in common.
    pub direction: Option<usize>,
    /// Degree of the functions.
    pub degree: usize,
    /// Its side \[m\].
    pub length: f64,
    /// Of finite elements the mean of their sides by which they carry waves (Eq. P.20) \[m\].
    pub mean: Option<f64>,
}

/// Error of a frequency up to which waves are carried by a mesh: finite elements reach it where they
/// begin to follow a wave, at `kh = 2p + 1` (Ainsworth 2004), splines a little below two elements a wave.
pub const CARRIED: f64 = 1.0 / 3.0;

/// What decides how well a body carries waves.
pub struct CarriedWaves {
    material: Material,
    thickness: f64,
    is_axisymmetric: bool,
    elements: Vec<LongestElement>,
}

impl CarriedWaves {
    /// Of the shortest wave of `frequency` \[Hz\] the relative error of its frequency in the direction whose
    /// elements resolve it worst, with wave and elements (Eqs. P.7, P.20).
    pub fn error(&self, frequency: f64) -> Option<(f64, Wave, LongestElement)> {
        let wave = Wave::shortest(&self.material, self.thickness, self.is_axisymmetric, frequency);
        let of = |e: &LongestElement| {
            let error = match e.mean {
                Some(mean) => wave.error_on_finite_elements(mean, e.degree),
                None => wave.error(e.length, e.degree),
            };
            (error, wave, *e)
        };
        self.elements.iter().map(of).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The highest frequency up to `limit` \[Hz\] whose waves are carried.
    pub fn highest(&self, limit: f64) -> f64 {
        let is_carried = |frequency: f64| self.error(frequency).is_none_or(|(error, ..)| error <= CARRIED);
        if is_carried(limit) {
            return limit;
        }
        let [mut low, mut high] = [0.0, limit];
        // Errors grow with the frequency.
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (low + high);
            if is_carried(middle) { low = middle } else { high = middle }
        }
        low
    }
}

/// A flexible body with its matrices. What a new kind of elements has to say is required; what
/// follows from it is provided.
pub trait FieldBody: Field {
    /// Matrices.
    fn assembled(&self) -> &AssembledBody;

    /// How it is reduced, held, damped and framed.
    fn settings(&self) -> &FlexibleSpec;

    /// All data on which its matrices depend, as bytes: the key of stored models.
    fn definition(&self) -> Vec<u8>;

    /// Its material, the one with the slowest waves if there are several.
    fn slowest_material(&self) -> Option<&Material>;

    /// Size of the body \[m\].
    fn size(&self) -> f64;

    /// The longest elements of each direction, or of each kind.
    fn longest_elements(&self) -> Vec<LongestElement>;

    /// How well it carries waves; none without a material.
    fn carried_waves(&self) -> Option<CarriedWaves> {
        Some(CarriedWaves {
            material: *self.slowest_material()?,
            thickness: self.thickness(),
            is_axisymmetric: matches!(self.model(), Model::Axisymmetric),
            elements: self.longest_elements(),
        })
    }

    /// Least length of the body, the thickness of a wall; the diameter of an axisymmetric one
    /// counts if less \[m\].
    fn thickness(&self) -> f64;

    /// How far the surface rises between neighbouring contact points of its whole surface at most:
    /// the height of arcs over the chords of elements' sides, a quarter of it where a point stands
    /// in the middle \[m\].
    fn height_between_points(&self) -> f64;

    /// The keys by which a user gives the body smaller elements at a place, as words of a remedy.
    fn finer_there(&self) -> String;

    /// The keys by which a user gives the body a mesh for shorter waves, as words of a remedy.
    fn finer_mesh(&self) -> String;

    /// Its deformable surface, moving with `shapes`.
    ///
    /// # Errors
    /// [`ContactError`] if the body has no surface.
    fn surface(&self, shapes: MatRef<'_, f64>) -> Result<SurfaceModel, ContactError>;

    /// Its undeformed surface.
    fn undeformed(&self) -> &dyn Surface;

    /// The whole of it, or what is requested, as a contact zone on the body's own elements, with
    /// edges and corners.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] or [`AdaptiveError::Mesh`] if the surface has no area; `contact` is the contact's name.
    fn whole_zone(&self, request: &WholeRequest, contact: &str) -> Result<ContactZone, AdaptiveError>;

    /// The zone that a contact has on it from the start about a place.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`], [`AdaptiveError::ContactModel`] or [`AdaptiveError::Mesh`] if no width is known, or the zone is empty.
    fn zone_at_start(&self, request: &StartZone<'_>) -> Result<ContactZone, AdaptiveError>;

    /// The model refined about each of the places of `site`, over the widths of `size`
    /// \[m\], with the settings `interval` and so many times as many elements as the second says.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the body's name if it cannot be refined so far.
    fn refined(
        self: Arc<Self>,
        site: &ZoneSite,
        size: ([f64; 2], f64),
        interval: &IntervalSpec,
    ) -> Result<Box<dyn FineModel>, AdaptiveError>;

    /// Lengths of the element at a place of the surface, along the directions of its face; none of elements that
    /// are not refined about flat faces \[m\].
    fn element_at(&self, _place: &SurfacePlace) -> Option<[f64; 2]> {
        None
    }

    /// The body of splines, whose faces contact zones lie on; none of one of other elements.
    fn splines(&self) -> Option<&ElasticBody> {
        None
    }

    /// The body of finite elements, whose sides contact zones lie on; none of one of other
    /// elements.
    fn mesh(&self) -> Option<&MeshedBody> {
        None
    }

    /// Side of the longest element at a disc or ball that a joint or load holds \[m\]; none of a
    /// whole face, with whose edges functions end, and if there is no such part.
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
        let FlexibleSpec { reduction, damping, .. } = self.settings();
        let loads = self.load_columns(self.assembled(), &interface.loads)?;
        let key = modes_key(&self.definition(), *reduction, interface, &loads);
        let input = ReductionInput { body: self.assembled(), reduction: *reduction, damping, key };
        let reduced = input.reduce(interface, &loads, cache);
        reduced.map_err(|source| AdaptiveError::Reduction { body: self.name().to_owned(), source })
    }

    /// As [`FieldBody::reduce`], with modes from `cache` if they are there.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    fn reduce_with(&self, interface: &Interface, cache: &ModelCache) -> Result<ReducedBody, AdaptiveError> {
        let fail = |source| AdaptiveError::Reduction { body: self.name().to_owned(), source };
        let FlexibleSpec { frame, geometric_stiffening: is_stiffened, .. } = self.settings();
        let assembled = self.assembled();
        let mut reduced = self.reduce_in_mean_axes(interface, cache)?;
        let FrameSpec::Tangent(place) = frame else {
            if *is_stiffened {
                let what = "geometric stiffening needs frame = \"tangent\", whose marker says where the body is held".into();
                return Err(AdaptiveError::unsupported_body(self.name(), what));
            }
            return Ok(reduced);
        };
        let support = self.marker_weights(place, UnitQuaternion::identity())?;
        let marker = support.marker("frame", reduced.basis.shapes.as_ref()).map_err(fail)?;
        let frame = marker.tangent_frame(assembled.motion);
        let shapes = frame.shifted_shapes(assembled, reduced.basis.shapes.as_ref()).map_err(fail)?;
        reduced.data = reduced.data.in_tangent_frame(&frame).map_err(fail)?;
        if *is_stiffened {
            let stiffening = geometric_stiffening(self, assembled, shapes.as_ref(), &support)?;
            reduced.data = reduced.data.with_geometric_stiffening(&stiffening).map_err(fail)?;
        }
        reduced.framed = Some(shapes);
        Ok(reduced)
    }
}
