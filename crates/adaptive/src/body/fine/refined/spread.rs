//! A contact zone that spreads over several faces of a body: which parts of which faces lie in it
//! (theory Eqs. A.8, A.9).

use iga_core::ParameterBox;
use iga_core::elasticity::Model;
use iga_core::hierarchical::{Neighbours, PatchTies};
use iga_core::nurbs::Face;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::{FaceId, Patch};
use iga_core::surface::BodySurface;
use nalgebra::Vector3;

use super::measures::reach;
use crate::adaptivity::interval::IntervalEnd;
use crate::adaptivity::wanted_interval::WantedInterval;
use crate::body::splines::ElasticBody;

/// Places a direction at which a face is looked at for parts of a zone.
const SAMPLES: usize = 64;
/// Cosine of the angle between normals on both sides of an edge up to which the surface goes on: 8
/// degrees, as where bodies touch (C.61).
const SMOOTH: f64 = 0.99;
/// Rounds of a search whose window doubles: more than from an element to a body.
const ROUNDS: usize = 40;

/// Coordinates along the surface about the middle of a zone, in units of half its widths: along the
/// first tangent of the touched face and across it, in the plane that touches the face there (A.8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneFrame {
    centre: Vector3<f64>,
    /// Unit vectors along and across the first tangent; zero in a direction that the face does not
    /// have.
    axes: [Vector3<f64>; 2],
    /// Half the widths along the axes \[m\].
    half: [f64; 2],
    extents: Extents,
    /// Coordinates at the ends of the zone.
    range: [[f64; 2]; 2],
    /// The kind of each end of the zone, unless an edge of the surface lies before it.
    pub ends: [[IntervalEnd; 2]; 2],
}

/// Widths of an area of contact in all directions, from those in two that need not be perpendicular
/// (A.8).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extents {
    /// Directions half way between the two, and across that.
    axes: [Vector3<f64>; 2],
    /// Mean of their squares, and what is to be added for each unit of both components \[m²\].
    squares: [f64; 2],
    least: f64,
}

impl Extents {
    fn new(tangents: &[Vector3<f64>; 2], widths: [f64; 2]) -> Self {
        let [between, across] = [tangents[0] + tangents[1], tangents[0] - tangents[1]];
        let axes = [between, across].map(|v| v.try_normalize(0.0).unwrap_or_default());
        let [e, f] = widths.map(|w| w * w);
        let product = tangents[0].dot(&axes[0]) * tangents[0].dot(&axes[1]);
        let is_curve = tangents[1].norm() < 0.5;
        let squares = if is_curve { [e, 0.0] } else { [0.5 * (e + f), 0.5 * (e - f) / product] };
        let least = if is_curve { widths[0] } else { widths[0].min(widths[1]) };
        Self { axes, squares, least }
    }

    fn along(&self, direction: &Vector3<f64>) -> f64 {
        let [a, b] = self.axes.map(|axis| axis.dot(direction));
        // Directions that enclose a small angle tell little of others.
        (self.squares[0] + self.squares[1] * a * b).max(self.least * self.least).sqrt()
    }
}

impl ZoneFrame {
    /// The frame of the zone `wanted` of `body`.
    fn new(body: &ElasticBody, wanted: &WantedInterval) -> Self {
        let patch = &body.shape.patches[wanted.face.id.patch];
        let at = wanted.face.at(patch, &wanted.centre, &mut PointBasis::default());
        let tangents = at.tangents.map(|t| Vector3::from(t).try_normalize(0.0).unwrap_or_default());
        let extents = Extents::new(&tangents, wanted.widths);
        let across = tangents[1] - tangents[0] * tangents[0].dot(&tangents[1]);
        let axes = [tangents[0], across.try_normalize(0.0).unwrap_or_default()];
        let widths = [wanted.widths[0], extents.along(&axes[1])];
        let half = widths.map(|width| reach(body, &at.point, width)[1]);
        let (mut range, mut ends) = ([[-1.0, 1.0]; 2], [[IntervalEnd::Open; 2]; 2]);
        if half[0] > 0.5 * wanted.widths[0] {
            // From the axis on, which lies where the radius falls.
            let side = usize::from(tangents[0].x < 0.0);
            range[0][side] *= at.point[0] / half[0];
            ends[0][side] = IntervalEnd::Axis;
        }
        Self { centre: Vector3::from(at.point), axes, half, extents, range, ends }
    }

    /// Width of the zone along a direction \[m\].
    pub fn width_along(&self, tangent: &Vector3<f64>) -> f64 {
        self.extents.along(&tangent.try_normalize(0.0).unwrap_or_default())
    }

    /// The coordinates of a place: between -1 and 1 in the zone.
    pub fn coordinates(&self, point: &[f64; 3]) -> [f64; 2] {
        let from = Vector3::from(*point) - self.centre;
        // A curve has one direction, and no width in the other.
        std::array::from_fn(|d| if self.half[d] > 0.0 { self.axes[d].dot(&from) / self.half[d] } else { 0.0 })
    }

    /// The row of a place in each direction of a zone of so many rows.
    pub fn rows(&self, point: &[f64; 3], n: [usize; 2]) -> [usize; 2] {
        let s = self.coordinates(point);
        std::array::from_fn(|d| {
            let [first, last] = self.range[d];
            let share = (s[d] - first) / (last - first);
            ((share * n[d] as f64).max(0.0) as usize).min(n[d] - 1)
        })
    }

    fn contains(&self, point: &[f64; 3]) -> bool {
        self.coordinates(point).iter().all(|s| s.abs() <= 1.0)
    }
}

/// The part of a zone on one face.
#[derive(Debug, Clone, PartialEq)]
pub struct SpreadPart {
    /// The face.
    pub face: Face,
    /// The least box of its parameters that holds the part.
    pub bounds: ParameterBox,
    /// The place of the face that is nearest to the middle of the zone.
    pub nearest: [f64; 3],
    /// Ends of the face in the zone at which the surface ends with an edge: directions, and whether
    /// it is the upper end.
    pub edges: Vec<(usize, bool)>,
}

/// A zone on several faces.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Its coordinates.
    pub frame: ZoneFrame,
    /// Its parts, that of the touched face first.
    pub parts: Vec<SpreadPart>,
}

/// How the outer faces of a body go on in one another.
pub struct Surroundings<'a> {
    body: &'a ElasticBody,
    patches: &'a [Patch],
    neighbours: Neighbours,
    outer: Vec<Face>,
}

impl<'a> Surroundings<'a> {
    /// The neighbours and outer faces of `body`.
    pub fn new(body: &'a ElasticBody) -> Self {
        let patches = &body.shape.patches[..];
        let ties: Vec<PatchTies> = patches.iter().map(PatchTies::detect).collect();
        let neighbours = Neighbours::detect(patches, &ties);
        Self {
            body,
            patches,
            neighbours,
            outer: Face::outer(patches, body.spec.model == Model::Axisymmetric),
        }
    }

    /// The face of another patch in which `face` goes on beyond its lower or upper end in direction
    /// `d`, found by going around that edge from patch to patch; none where it ends with an edge of
    /// its patch.
    fn next(&self, face: &FaceId, (d, upper): (usize, bool)) -> Option<&Face> {
        let (mut held, mut to) = (*face, FaceId { direction: d, upper, ..*face });
        for _ in 0..self.patches.len() {
            let shared = self.neighbours.shared_face(&to)?;
            let (direction, is_reversed) = shared.direction(held.direction)?;
            to = FaceId { patch: shared.other.patch, direction, upper: held.upper != is_reversed };
            held = shared.other;
            if let Some(found) = self.outer.iter().find(|f| f.id == to) {
                return Some(found);
            }
        }
        None
    }

    /// The face in which `face` goes on smoothly beyond an end, at the places of both that are
    /// nearest to `point`.
    pub fn smooth_next(&self, face: &Face, end: (usize, bool), point: &[f64; 3]) -> Option<&Face> {
        let next = self.next(&face.id, end)?;
        let normal = |face: &Face| Some(Vector3::from(self.nearest(face, point)?.1));
        (normal(face)?.dot(&normal(next)?) > SMOOTH).then_some(next)
    }

    /// Parameters and normal of the place of a face that is nearest to `point`.
    fn nearest(&self, face: &Face, point: &[f64; 3]) -> Option<([f64; 3], [f64; 3])> {
        let found = BodySurface::of_faces(self.patches, vec![*face]).closest(self.patches, point)?;
        Some((found.xi, found.normal))
    }

    /// The zone `wanted` with its parts on all faces that it reaches.
    pub fn spread(&self, wanted: &WantedInterval) -> Spread {
        let frame = ZoneFrame::new(self.body, wanted);
        let centre: [f64; 3] = frame.centre.into();
        let mut parts: Vec<SpreadPart> = Vec::new();
        let mut waiting = vec![(wanted.face, wanted.face.on_face(&wanted.centre))];
        let mut seen = vec![wanted.face.id];
        while let Some((face, nearest)) = waiting.pop() {
            let Some(bounds) = self.part(&face, &nearest, &frame, wanted) else { continue };
            let mut edges = Vec::new();
            let (first, last) = self.patches[face.id.patch].domain();
            for d in face.directions() {
                let at_end = [bounds.lower[d] <= first[d], bounds.upper[d] >= last[d]];
                for upper in [false, true].into_iter().filter(|u| at_end[usize::from(*u)]) {
                    match self.smooth_next(&face, (d, upper), &centre) {
                        None => edges.push((d, upper)),
                        Some(next) if seen.contains(&next.id) => {}
                        Some(next) => {
                            seen.push(next.id);
                            waiting.extend(self.nearest(next, &centre).map(|(xi, _)| (*next, xi)));
                        }
                    }
                }
            }
            parts.push(SpreadPart { face, bounds, nearest, edges });
        }
        Spread { frame, parts }
    }

    /// The least box of parameters of `face` that holds all of it in the zone; none if nothing is.
    /// `nearest` is its place nearest to the middle.
    ///
    /// Found by samples of a window, which grows until the zone ends in it, and then shrinks to the
    /// zone.
    fn part(
        &self,
        face: &Face,
        nearest: &[f64; 3],
        frame: &ZoneFrame,
        wanted: &WantedInterval,
    ) -> Option<ParameterBox> {
        let patch = &self.patches[face.id.patch];
        let (first, last) = patch.domain();
        let first_derivatives = patch.jet(nearest, 1, &mut PointBasis::default()).first;
        let reach: f64 = wanted.widths.iter().take(face.directions().count()).sum();
        let mut window = ParameterBox { lower: *nearest, upper: *nearest };
        let within = |window: &mut ParameterBox, d: usize, by: f64| {
            window.lower[d] = (window.lower[d] - by).max(first[d]);
            window.upper[d] = (window.upper[d] + by).min(last[d]);
        };
        for d in face.directions() {
            let speed = norm(&first_derivatives[d]);
            within(&mut window, d, if speed > 0.0 { reach / speed } else { last[d] - first[d] });
        }
        let mut found = None;
        for _ in 0..ROUNDS {
            let bounds = samples(patch, face, nearest, &window, frame)?;
            // Within a cell of the samples there may be more of it.
            let mut next = bounds;
            let mut is_cut = false;
            for d in face.directions() {
                let cell = (window.upper[d] - window.lower[d]) / SAMPLES as f64;
                within(&mut next, d, cell);
                is_cut |= (bounds.lower[d] <= window.lower[d] && window.lower[d] > first[d])
                    || (bounds.upper[d] >= window.upper[d] && window.upper[d] < last[d]);
            }
            if is_cut {
                for d in face.directions() {
                    let by = 0.5 * (window.upper[d] - window.lower[d]);
                    within(&mut window, d, by);
                }
                continue;
            }
            if found.is_some() {
                return Some(next);
            }
            (found, window) = (Some(next), next);
        }
        found
    }
}

/// The least box of the samples of `window` on a face that lie in the zone, and of the place
/// nearest to its middle.
fn samples(
    patch: &Patch,
    face: &Face,
    nearest: &[f64; 3],
    window: &ParameterBox,
    frame: &ZoneFrame,
) -> Option<ParameterBox> {
    let is_there = frame.contains(&patch.point(nearest));
    let mut found = is_there.then_some(ParameterBox { lower: *nearest, upper: *nearest });
    let mut directions = face.directions();
    let (a, b) = (directions.next(), directions.next());
    let steps = |d: Option<usize>| if d.is_some() { SAMPLES } else { 0 };
    let mut scratch = PointBasis::default();
    for j in 0..=steps(b) {
        for i in 0..=steps(a) {
            let mut xi = face.on_face(&window.lower);
            for (d, k) in [(a, i), (b, j)] {
                let Some(d) = d else { continue };
                // Ends are those of the window to the last bit.
                xi[d] = match k {
                    SAMPLES => window.upper[d],
                    _ => window.lower[d] + (window.upper[d] - window.lower[d]) * (k as f64 / SAMPLES as f64),
                };
            }
            if frame.contains(&patch.jet(&xi, 0, &mut scratch).point) {
                let bounds = found.get_or_insert(ParameterBox { lower: xi, upper: xi });
                for d in face.directions() {
                    bounds.lower[d] = bounds.lower[d].min(xi[d]);
                    bounds.upper[d] = bounds.upper[d].max(xi[d]);
                }
            }
        }
    }
    found
}
