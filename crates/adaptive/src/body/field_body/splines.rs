//! Flexible bodies of splines, and what becomes of them in a contact: splines refined about it, or
//! their own with the whole surface.

use std::borrow::Cow;
use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::SurfaceModel;
use faer::{Mat, MatRef};
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::BodyTurn;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Face;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::shape::lengths::ways_through;
use iga_core::nurbs::{FaceId, Patch};
use nalgebra::Vector3;

use crate::adaptivity::interval::{IntervalGrid, finer_elements};
use crate::adaptivity::wanted_interval::WantedInterval;
use crate::body::field::Field;
use crate::body::field_body::{FieldBody, LongestElement};
use crate::body::fine::FineModel;
use crate::body::fine::refined::{ELEMENTS, FineMesh, FineSettings, zone_definition};
use crate::body::splines::{Discretised, ElasticBody};
use crate::body::zone::at_start::StartZone;
use crate::body::zone::{ContactZone, WholeRequest};
use crate::error::AdaptiveError;
use crate::record::ZoneSite;
use crate::spec::{FlexibleSpec, IntervalSpec, PointRule};
use crate::store::{Bytes, body_definition};
use crate::surface::{Surface, SurfacePlace};

impl FieldBody for ElasticBody {
    fn assembled(&self) -> &AssembledBody {
        &self.assembled
    }

    fn settings(&self) -> &FlexibleSpec {
        &self.spec.flexible
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

    fn longest_elements(&self) -> Vec<LongestElement> {
        let patches = self.shape.patches.iter();
        patches.flat_map(|patch| (0..patch.dimension()).map(|d| longest_element(patch, d))).collect()
    }

    /// The shortest way through the body along its parameter lines; of axisymmetric models the
    /// diameter or the length \[m\].
    fn thickness(&self) -> f64 {
        if self.spec.model == Model::Axisymmetric {
            let bounds = |c: usize| {
                let places = self.assembled.nodes.iter().map(|x| x[c]);
                places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
            };
            let ((_, radius), (bottom, top)) = (bounds(0), bounds(1));
            return (2.0 * radius).min(top - bottom);
        }
        ways_through(&self.spec.shape).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// From degree 2 on a point stands in the middle.
    fn height_between_points(&self) -> f64 {
        let heights = self.shape.patches.iter().flat_map(|patch| {
            (0..patch.dimension()).map(move |d| {
                let height = largest_over_sides(patch, d, |[a, middle, b]| {
                    (0..3).map(|c| (middle[c] - 0.5 * (a[c] + b[c])).powi(2)).sum::<f64>().sqrt()
                });
                if patch.knots()[d].degree() > 1 { 0.25 * height } else { height }
            })
        });
        heights.fold(0.0, f64::max)
    }

    fn finer_there(&self) -> String {
        format!("refine bodies.{}.discretisation", self.name)
    }

    fn finer_mesh(&self) -> String {
        format!("leave bodies.{}.discretisation.elements to the program, raise them or the degree", self.name)
    }

    fn surface(&self, shapes: MatRef<'_, f64>) -> Result<SurfaceModel, ContactError> {
        SurfaceModel::new(self.motion(), &self.shape.patches, &self.space, &self.lookup, shapes)
    }

    fn undeformed(&self) -> &dyn Surface {
        self.surface.as_ref()
    }

    fn whole_zone(&self, request: &WholeRequest, contact: &str) -> Result<ContactZone, AdaptiveError> {
        let zone = ContactZone::whole(&self.discretised(), request.about.as_ref());
        zone.map_err(|source| AdaptiveError::Contact { contact: contact.to_owned(), source })
    }

    fn zone_at_start(&self, request: &StartZone<'_>) -> Result<ContactZone, AdaptiveError> {
        request.request.zone(self)
    }

    fn refined(
        self: Arc<Self>,
        site: &ZoneSite,
        (widths, finer): ([f64; 2], f64),
        interval: &IntervalSpec,
    ) -> Result<Box<dyn FineModel>, AdaptiveError> {
        let (patches, axisymmetric) = (&self.shape.patches, self.spec.model == Model::Axisymmetric);
        let ids = FaceId::all(patches);
        let about = |(face, centre): (u32, [f64; 3])| {
            let face = Face::new(patches, ids[face as usize], axisymmetric);
            WantedInterval { face, centre, widths }
        };
        let wanted: Vec<WantedInterval> = site.places().map(about).collect();
        let elements = finer_elements(interval.elements_or(ELEMENTS), finer);
        let settings = FineSettings { division: interval.division, elements, growth: None };
        let mesh = Arc::new(FineMesh::build(&self, &wanted, &settings)?);
        Ok(Box::new(RefinedSplines { body: self, mesh, wanted, settings }))
    }

    fn element_at(&self, place: &SurfacePlace) -> Option<[f64; 2]> {
        let patches = &self.shape.patches;
        let id = *FaceId::all(patches).get(place.face as usize)?;
        let (patch, face) =
            (&patches[id.patch], Face::new(patches, id, self.spec.model == Model::Axisymmetric));
        let tangents = face.at(patch, &place.xi, &mut PointBasis::default()).tangents;
        let mut lengths = [0.0; 2];
        for ((length, d), tangent) in lengths.iter_mut().zip(face.directions()).zip(tangents) {
            let knots = &patch.knots()[d];
            let (from, to) = knots.element(knots.find_element(place.xi[d]));
            *length = (to - from) * Vector3::from(tangent).norm();
        }
        Some(lengths)
    }

    fn splines(&self) -> Option<&ElasticBody> {
        Some(self)
    }
}

/// Splines refined about intervals.
struct RefinedSplines {
    body: Arc<ElasticBody>,
    mesh: Arc<FineMesh>,
    wanted: Vec<WantedInterval>,
    /// How levels were made.
    settings: FineSettings,
}

impl FineModel for RefinedSplines {
    fn field(&self) -> &dyn Field {
        self.mesh.as_ref()
    }

    fn zone(&self, rule: PointRule, contact: &str) -> Result<ContactZone, AdaptiveError> {
        self.mesh
            .whole_zone(rule)
            .map_err(|source| AdaptiveError::Contact { contact: contact.to_owned(), source })
    }

    fn grid(&self) -> IntervalGrid {
        self.mesh.intervals[0].grid()
    }

    fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        self.mesh.contact_elements(zone)
    }

    fn assemble(&self) -> Result<Cow<'_, AssembledBody>, AdaptiveError> {
        self.mesh.assemble_unturned(&self.body).map(Cow::Owned)
    }

    fn prolong(&self, shapes: MatRef<'_, f64>) -> Mat<f64> {
        self.mesh.prolong(&self.body.assembled, shapes)
    }

    fn definition(&self) -> Bytes {
        let unturned = self.mesh.rotated.as_ref().filter(|_| self.turn().is_some());
        let turned = unturned.map(|rotated| vec![rotated.net.turn.wanted]);
        zone_definition(&self.body, turned.as_ref().unwrap_or(&self.wanted), &self.settings)
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

fn longest_element(patch: &Patch, direction: usize) -> LongestElement {
    let length = largest_over_sides(patch, direction, |[a, _, b]| {
        a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    });
    LongestElement {
        direction: Some(direction),
        degree: patch.knots()[direction].degree(),
        length,
        mean: None,
    }
}

/// The largest value of `of` the first, middle and last point of the sides of elements along
/// `direction`.
fn largest_over_sides(patch: &Patch, direction: usize, of: impl Fn([[f64; 3]; 3]) -> f64) -> f64 {
    let breaks: Vec<Vec<f64>> = patch.knots().iter().map(|k| k.breaks()).collect();
    let counts = std::array::from_fn::<usize, 3, _>(|d| breaks.get(d).map_or(1, Vec::len));
    let mut largest = 0.0_f64;
    for i in (0..counts[0] * counts[1] * counts[2])
        .map(|k| [k % counts[0], k / counts[0] % counts[1], k / (counts[0] * counts[1])])
        .filter(|i| i[direction] + 1 < counts[direction])
    {
        let mut xi = [0.0; 3];
        breaks.iter().enumerate().for_each(|(d, list)| xi[d] = list[i[d]]);
        let (from, to) = (xi[direction], breaks[direction][i[direction] + 1]);
        let at = |parameter: f64| {
            let mut xi = xi;
            xi[direction] = parameter;
            patch.point(&xi)
        };
        largest = largest.max(of([at(from), at(0.5 * (from + to)), at(to)]));
    }
    largest
}
