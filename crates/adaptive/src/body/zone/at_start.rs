//! Contact zones that a body has from the start: where they lie, how wide they are, and what they
//! ask of its mesh.

use contact_qs::ContactError;
use contact_qs::surface_pair::TargetFace;
use iga_core::ParameterBox;
use iga_core::elasticity::Model;
use iga_core::nurbs::interface::FaceId;
use iga_core::nurbs::local::parameter_at_distance;
use iga_core::nurbs::{Face, Patch, Shape};
use iga_core::surface::CollocationPoint;
use nalgebra::Vector3;

use crate::body::splines::ElasticBody;
use crate::body::zone::{ContactZone, ZoneLimits};
use crate::error::{AdaptiveError, ContactModelFault};
use crate::spec::{ElasticSpec, RefinementSpec, SurfaceLaw};
use crate::surface::SurfacePlace;

/// Slack of comparisons between parameters, as a share of the patch's range: round-off of arc
/// lengths.
const PARAMETER_SLACK: f64 = 1e-9;

/// A refinement counts as made for a contact whose first point is nearer to its centre than this
/// part of its width.
const IN_THE_MIDDLE: f64 = 1e-3;

/// A contact that asks for a zone on a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneRequest<'a> {
    /// Name of the contact.
    pub contact: &'a str,
    /// Points, interval.
    pub law: &'a SurfaceLaw,
    /// Where.
    pub site: SurfacePlace,
}

/// The line along which a body is touched first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineOnBody {
    /// Half width of the contact at the peak force \[m\].
    pub half_width: f64,
    /// Full width of the zone that it needs \[m\].
    pub width: f64,
    /// Unit vector in the body's frame, across the line.
    pub across: Vector3<f64>,
    /// Outward direction in the body's frame in which the partner lies.
    pub outward: Vector3<f64>,
}

/// A zone that a contact has on a body from the start, and what Hertz's theory and the motions at
/// the start say of it, which not every body asks.
pub struct StartZone<'a> {
    /// What is asked for.
    pub request: ZoneRequest<'a>,
    /// Width that the first touch needs; none if that is not known \[m\].
    pub width: &'a dyn Fn() -> Option<f64>,
    /// The line along which the body is touched first; none if it is touched otherwise.
    pub line: &'a dyn Fn() -> Option<LineOnBody>,
}

/// A box of parameters on a face.
struct Interval {
    bounds: ParameterBox,
    slack: [f64; 3],
    /// Whether the end of the interval is an end of the patch, lower and upper, per direction.
    is_natural_end: [[bool; 2]; 3],
}

/// The refinement that a contact interval with a given number of elements asks of its body; `None`
/// if it asks for none.
///
/// # Errors
/// [`AdaptiveError::Contact`] if the number of elements is given without a width, or for a contact without refinement.
pub fn wanted_refinement(request: &ZoneRequest<'_>) -> Result<Option<RefinementSpec>, AdaptiveError> {
    let interval = &request.law.interval;
    let Some(elements) = interval.elements else { return Ok(None) };
    let fail = |settings| {
        let fault = ContactModelFault::Settings(settings);
        AdaptiveError::ContactModel { contact: request.contact.to_owned(), fault }
    };
    if !request.law.treatment.has_fine_zone() {
        return Err(fail(
            "model \"coarse\" is not refined, leave interval.elements out or choose another model",
        ));
    }
    let width = interval.width.ok_or_else(|| fail("interval.elements needs interval.width"))?;
    Ok(Some(RefinementSpec { centre: request.site.point, width, elements, ratio: DEFAULT_RATIO }))
}

/// Ratio of neighbouring elements outside an interval that asks for its own refinement.
const DEFAULT_RATIO: f64 = 1.5;

/// Halvings of the body's size in the search for an interval that touches no singular line.
const MAX_HALVINGS: usize = 20;

impl ZoneRequest<'_> {
    /// The width of the zone that a contact asks for on the body `name`, as far as `body` tells; none
    /// of a contact without one ([`crate::spec::Treatment::has_fine_zone`]) that is given none.
    ///
    /// # Errors
    /// [`AdaptiveError::ContactModel`] if one is needed and not known.
    pub fn width(&self, name: &str, body: &ElasticSpec) -> Result<Option<f64>, AdaptiveError> {
        let (given, point) = (self.law.interval.width, self.site.point);
        if !self.law.treatment.has_fine_zone() {
            return Ok(given);
        }
        let fault = || ContactModelFault::NotRefined { body: name.to_owned(), point };
        let unknown = || AdaptiveError::ContactModel { contact: self.contact.to_owned(), fault: fault() };
        given.or_else(|| refined_width(body, &point)).ok_or_else(unknown).map(Some)
    }

    /// Checks that the body `name` can have the zone that a contact asks for, as far as `body` tells.
    ///
    /// # Errors
    /// As [`ZoneRequest::width`]; [`AdaptiveError::Contact`] if the zone touches a singular line.
    pub fn check(&self, name: &str, body: &ElasticSpec) -> Result<(), AdaptiveError> {
        let width = self.width(name, body)?;
        width.map_or(Ok(()), |width| self.interval(&body.shape, &body.model, width).map(|_| ()))
    }

    /// The interval of the `width` given about the site on `shape`, with its face.
    fn interval(&self, shape: &Shape, model: &Model, width: f64) -> Result<(Face, Interval), AdaptiveError> {
        let SurfacePlace { face, xi, point } = self.site;
        let id = FaceId::all(&shape.patches)[face as usize];
        let face = Face::new(&shape.patches, id, *model == Model::Axisymmetric);
        let half_width = RefinementSpec::half_width(model, &point, width);
        let interval = Interval::about(&shape.patches, &face, &xi, half_width);
        match shape.singular_in(face.id.patch, &interval.bounds.lower, &interval.bounds.upper) {
            None => Ok((face, interval)),
            Some(set) => {
                let source = ContactError::Singular { name: set.name.clone() };
                Err(AdaptiveError::Contact { contact: self.contact.to_owned(), source })
            }
        }
    }

    /// The zone of `body` that a contact asks for.
    ///
    /// Its width is the one given, else that of the refinement in whose middle the site lies; of a
    /// contact without one ([`crate::spec::Treatment::has_fine_zone`]) the whole face about the site, as far as
    /// it is regular.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if no width is known, the zone is empty or touches a singular line.
    pub fn zone(&self, body: &ElasticBody) -> Result<ContactZone, AdaptiveError> {
        let fail = |source| AdaptiveError::Contact { contact: self.contact.to_owned(), source };
        let of = |width| self.interval(&body.shape, &body.spec.model, width).map(|found| (width, found));
        let (width, (face, interval)) = match self.width(&body.name, &body.spec)? {
            Some(width) => of(width)?,
            None => {
                let mut widths = (0..MAX_HALVINGS).map(|k| 2.0 * body.size() * 0.5_f64.powi(k as i32));
                let none = || fail(ContactError::Empty { width: 0.0 });
                widths.find_map(|width| of(width).ok()).ok_or_else(none)?
            }
        };
        let region = TargetFace { face, bounds: interval.bounds };
        let limits = ZoneLimits { region, slack: interval.slack, widths: [width, 0.0] };
        let on_rim = |points: &[CollocationPoint]| {
            let inner = interval.without_rim(body, &face, points);
            let is_outside = |p: &CollocationPoint| {
                inner.iter().zip(&p.xi).any(|([first, last], xi)| xi < first || xi > last)
            };
            points.iter().map(is_outside).collect()
        };
        ContactZone::new(&body.discretised(), &[limits], self.law.points, on_rim).map_err(fail)
    }
}

impl Interval {
    fn about(patches: &[Patch], face: &Face, centre: &[f64; 3], half_width: f64) -> Self {
        let patch = &patches[face.id.patch];
        let mut interval = Self {
            bounds: ParameterBox { lower: face.on_face(centre), upper: face.on_face(centre) },
            slack: [0.0; 3],
            is_natural_end: [[true; 2]; 3],
        };
        for d in face.directions() {
            let (first, last) = patch.knots()[d].domain();
            interval.slack[d] = PARAMETER_SLACK * (last - first);
            let ParameterBox { lower, upper } = &mut interval.bounds;
            lower[d] = parameter_at_distance(patch, lower, d, -half_width);
            upper[d] = parameter_at_distance(patch, upper, d, half_width);
            interval.is_natural_end[d] =
                [lower[d] <= first + interval.slack[d], upper[d] >= last - interval.slack[d]];
        }
        interval
    }

    /// Range of parameters without the rim: without the closed elements at ends of the interval
    /// that are no ends of the body's surface, and without the outermost of `points` there. Beyond
    /// the interval nothing is watched, so that contact must not reach its last point.
    fn without_rim(&self, body: &ElasticBody, face: &Face, points: &[CollocationPoint]) -> [[f64; 2]; 3] {
        let knots = body.shape.patches[face.id.patch].knots();
        let mut range = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
        for d in face.directions() {
            let element = |u: f64| knots[d].element(knots[d].find_element(u));
            let parameters = || points.iter().map(|p| p.xi[d]);
            if !self.is_natural_end[d][0] {
                let end = element(self.bounds.lower[d] + 2.0 * self.slack[d]).1;
                range[d][0] = end.max(parameters().fold(f64::INFINITY, f64::min)) + self.slack[d];
            }
            if !self.is_natural_end[d][1] {
                let start = element(self.bounds.upper[d] - 2.0 * self.slack[d]).0;
                range[d][1] = start.min(parameters().fold(f64::NEG_INFINITY, f64::max)) - self.slack[d];
            }
        }
        range
    }
}

/// Width of the refinement in whose middle `point` lies.
pub fn refined_width(body: &ElasticSpec, point: &[f64; 3]) -> Option<f64> {
    let near = body.discretisation.refine.iter().filter(|r| is_about(r, point));
    near.map(|r| r.width).max_by(f64::total_cmp)
}

/// Whether `point` lies in the middle of a refinement.
pub fn is_about(refinement: &RefinementSpec, point: &[f64; 3]) -> bool {
    let between = refinement.centre.iter().zip(point).map(|(a, b)| (a - b).powi(2));
    between.sum::<f64>().sqrt() < IN_THE_MIDDLE * refinement.width
}
