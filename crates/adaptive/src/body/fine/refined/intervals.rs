//! Contact intervals as a fine model has them: which elements they hold, and the rows by which
//! their use is judged (theory section A.1, Eq. A.9).

use contact_qs::surface_pair::TargetFace;
use iga_core::ParameterBox;
use iga_core::elasticity::Model;
use iga_core::hierarchical::HierarchicalSpace;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::{Face, FaceId, Patch};
use iga_core::splines::knots::KnotVector;
use nalgebra::Vector3;

use super::spread::{Spread, Surroundings, ZoneFrame};
use super::{RefinementPlan, Region, WantedInterval};
use crate::adaptivity::interval::{IntervalEnd, IntervalGrid};
use crate::body::splines::ElasticBody;
use crate::body::zone::ZoneLimits;

/// Slack of comparisons between parameters, as a share of an element of the finest level: far above
/// what round-off does to elements that are not refused, far below a distance between points.
const PARAMETER_SLACK: f64 = 1e-2;
/// Height over length of a line that counts as straight: round-off of its net.
const STRAIGHT: f64 = 1e-9;

/// A contact interval as the fine model has it: its ends lie on knots.
#[derive(Debug, Clone, PartialEq)]
pub struct FineInterval {
    /// Its parts on the faces that it lies on, that of the touched one first.
    pub parts: Vec<IntervalPart>,
    /// What lies at the ends, one entry per direction along the touched face.
    pub ends: Vec<[IntervalEnd; 2]>,
    /// Rows of contact elements per direction along the touched face; 1 in directions that the face
    /// does not have.
    pub n_elements: [usize; 2],
    /// Widths that were asked for \[m\].
    pub widths: [f64; 2],
    /// What rows are counted by if there are several parts, whose elements lie in no common rows.
    frame: Option<ZoneFrame>,
}

/// The part of an interval on one face.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalPart {
    /// The face.
    pub face: Face,
    /// Lower and upper parameters.
    pub region: ParameterBox,
    /// Contact elements per direction along the face; 1 in directions that the face does not have.
    pub n_elements: [usize; 2],
    /// Number of its first element among those of the finest level, along the face.
    first: [usize; 2],
    slack: [f64; 3],
    /// Ends at which the surface ends with an edge, and the direction and side of the interval on
    /// which they lie.
    edges: Vec<Edge>,
}

/// An end of a part where the surface ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Edge {
    /// Direction of the face, counted along it.
    along: usize,
    upper: bool,
    /// Direction of the interval, and whether the end is on its upper side.
    row: (usize, bool),
}

/// The contact intervals of a fine model.
pub(super) fn fine_intervals(
    coarse: &ElasticBody,
    space: &HierarchicalSpace,
    wanted: &[WantedInterval],
    plan: &RefinementPlan,
    elements: usize,
) -> Vec<FineInterval> {
    if !plan.spreads.is_empty() {
        let mut regions = &plan.regions[..];
        let of = |(wanted, spread): (&WantedInterval, &Spread)| {
            let own;
            (own, regions) = regions.split_at(spread.parts.len());
            spread_interval(coarse, space, wanted, (spread, own), elements)
        };
        return wanted.iter().zip(&plan.spreads).map(of).collect();
    }
    let surroundings = (coarse.shape.patches.len() > 1).then(|| Surroundings::new(coarse));
    let make = |(w, region): (&WantedInterval, &Region)| {
        let patch = &coarse.shape.patches[region.patch];
        let part = IntervalPart::new(w.face, region.bounds, finest_knots(space, region.patch));
        let ends = w.face.directions().map(|d| {
            let mut ends = interval_ends(coarse, patch, &w.face, &part.region, (d, part.slack[d]));
            for (upper, end) in ends.iter_mut().enumerate().filter(|(_, end)| **end == IntervalEnd::FaceEnd) {
                // A wider interval goes on in the next patch.
                let point = patch.point(&w.face.on_face(&w.centre));
                let next =
                    surroundings.as_ref().and_then(|s| s.smooth_next(&w.face, (d, upper == 1), &point));
                if next.is_some() {
                    *end = IntervalEnd::Open;
                }
            }
            if ends == [IntervalEnd::FaceEnd; 2] && is_straight(patch, &w.face, (&w.centre, d)) {
                ends = [IntervalEnd::LineEnd; 2];
            }
            ends
        });
        let ends = ends.collect();
        FineInterval { n_elements: part.n_elements, parts: vec![part], ends, widths: w.widths, frame: None }
    };
    wanted.iter().zip(&plan.regions).map(make).collect()
}

/// The interval of a zone on several faces.
fn spread_interval(
    coarse: &ElasticBody,
    space: &HierarchicalSpace,
    wanted: &WantedInterval,
    (spread, regions): (&Spread, &[Region]),
    elements: usize,
) -> FineInterval {
    let n = wanted.face.directions().count();
    let mut ends: Vec<[IntervalEnd; 2]> = spread.frame.ends[..n].to_vec();
    let mut parts = Vec::new();
    for (part, region) in spread.parts.iter().zip(regions) {
        let knots = finest_knots(space, region.patch);
        let mut fine = IntervalPart::new(part.face, on_knots(region.bounds, knots), knots);
        for (along, d) in part.face.directions().enumerate() {
            for upper in [false, true].into_iter().filter(|u| part.edges.contains(&(d, *u))) {
                // The side of the interval on which the middle of the end lies.
                let ParameterBox { lower, upper: high } = &region.bounds;
                let mut middle: [f64; 3] = std::array::from_fn(|c| 0.5 * (lower[c] + high[c]));
                middle[d] = if upper { high[d] } else { lower[d] };
                let patch = &coarse.shape.patches[region.patch];
                let [s, t] = spread.frame.coordinates(&patch.point(&part.face.on_face(&middle)));
                let row = if s.abs() >= t.abs() { (0, s > 0.0) } else { (1, t > 0.0) };
                if ends[row.0][usize::from(row.1)] == IntervalEnd::Open {
                    ends[row.0][usize::from(row.1)] = IntervalEnd::FaceEnd;
                }
                fine.edges.push(Edge { along, upper, row });
            }
        }
        parts.push(fine);
    }
    let mut n_elements = [1; 2];
    n_elements[..n].fill(elements);
    FineInterval { parts, ends, n_elements, widths: wanted.widths, frame: Some(spread.frame) }
}

/// Knots of the finest level of a patch.
pub(super) fn finest_knots(space: &HierarchicalSpace, patch: usize) -> &[KnotVector] {
    let levels = space.basis(patch).hierarchy().levels();
    levels[levels.len() - 1].knots()
}

/// The box of whole elements of the finest level that holds `bounds`.
fn on_knots(bounds: ParameterBox, knots: &[KnotVector]) -> ParameterBox {
    let mut grown = bounds;
    for (d, k) in knots.iter().enumerate() {
        let (a, b) = k.element(k.find_element(bounds.lower[d]));
        // An end on a knot but for round-off stays there.
        grown.lower[d] = if b - bounds.lower[d] <= PARAMETER_SLACK * (b - a) { b } else { a };
        let (a, b) = k.element(k.find_element(bounds.upper[d]));
        grown.upper[d] = if bounds.upper[d] - a <= PARAMETER_SLACK * (b - a) { a } else { b };
    }
    grown
}

impl IntervalPart {
    fn new(face: Face, region: ParameterBox, knots: &[KnotVector]) -> Self {
        let (mut slack, mut n_elements, mut first) = ([0.0; 3], [1; 2], [0; 2]);
        for (i, d) in face.directions().enumerate() {
            slack[d] = PARAMETER_SLACK * least_element(&knots[d], &region, d);
            first[i] = knots[d].find_element(region.lower[d] + slack[d]);
            n_elements[i] = knots[d].find_element(region.upper[d] - slack[d]) + 1 - first[i];
        }
        Self { face, region, n_elements, first, slack, edges: Vec::new() }
    }

    /// Contact element that holds parameters of the face.
    fn element(&self, knots: &[KnotVector], xi: &[f64; 3]) -> [usize; 2] {
        let mut index = [0; 2];
        for (i, d) in self.face.directions().enumerate() {
            // Points on a knot belong to the element above it, whatever round-off says.
            let e = knots[d].find_element(xi[d] + self.slack[d]);
            index[i] = e.saturating_sub(self.first[i]).min(self.n_elements[i] - 1);
        }
        index
    }

    /// The side of the interval on which an element of the part lies at an edge of the body.
    fn edge_row(&self, element: [usize; 2]) -> Option<(usize, bool)> {
        let is_at = |edge: &&Edge| {
            element[edge.along] == if edge.upper { self.n_elements[edge.along] - 1 } else { 0 }
        };
        self.edges.iter().find(is_at).map(|edge| edge.row)
    }
}

impl FineInterval {
    /// The rows by which the use of the interval is judged.
    pub fn grid(&self) -> IntervalGrid {
        let n = self.ends.len();
        IntervalGrid {
            widths: std::array::from_fn(|d| if d < n { self.widths[d] } else { 0.0 }),
            ends: self.ends.clone(),
            n_elements: self.n_elements,
        }
    }

    /// Where the contact zone of the interval ends, face by face.
    pub(super) fn limits(&self) -> impl Iterator<Item = ZoneLimits> {
        self.parts.iter().map(|part| {
            let region = TargetFace { face: part.face, bounds: part.region };
            ZoneLimits { region, slack: part.slack, widths: self.widths }
        })
    }

    /// Whether it holds the parameters `xi` of a face.
    pub(super) fn holds(&self, face: FaceId, xi: &[f64; 3]) -> bool {
        self.limits().any(|limits| limits.region.face.id == face && limits.contains(xi))
    }

    /// How far from its middle a place lies, as a share of it: 1 at its ends. Zero of one that is alone.
    pub(super) fn share(&self, point: &[f64; 3]) -> f64 {
        let far = |frame: &ZoneFrame| frame.coordinates(point).iter().fold(0.0_f64, |m, s| m.max(s.abs()));
        self.frame.as_ref().map_or(0.0, far)
    }

    /// Row of the place `point` with the parameters `xi` of part `part` in each direction.
    pub(super) fn rows(
        &self,
        part: usize,
        knots: &[KnotVector],
        (xi, point): (&[f64; 3], &[f64; 3]),
    ) -> [usize; 2] {
        let element = self.parts[part].element(knots, xi);
        let Some(frame) = &self.frame else { return element };
        let mut rows = frame.rows(point, self.n_elements);
        if let Some((d, upper)) = self.parts[part].edge_row(element) {
            rows[d] = if upper { self.n_elements[d] - 1 } else { 0 };
        }
        rows
    }

    /// Whether rows lie at an end beyond which nothing is watched.
    pub(super) fn is_edge(&self, rows: [usize; 2]) -> bool {
        self.ends.iter().enumerate().any(|(i, ends)| {
            let at = [rows[i] == 0, rows[i] + 1 == self.n_elements[i]];
            (0..2).any(|side| at[side] && matches!(ends[side], IntervalEnd::Open | IntervalEnd::FaceEnd))
        })
    }
}

/// Smallest of the elements that meet `region` in direction `d`.
fn least_element(knots: &KnotVector, region: &ParameterBox, d: usize) -> f64 {
    let (lower, upper) = (region.lower[d], region.upper[d]);
    let sizes = (knots.find_element(lower)..=knots.find_element(upper)).map(|e| {
        let (a, b) = knots.element(e);
        b - a
    });
    sizes.fold(f64::INFINITY, f64::min)
}

/// Whether the line of a solid body's `face` through `centre` in direction `d` is straight, but for
/// round-off.
fn is_straight(patch: &Patch, face: &Face, (centre, d): (&[f64; 3], usize)) -> bool {
    let (first, last) = patch.knots()[d].domain();
    let points = [0.0, 0.3, 0.5, 0.8, 1.0].map(|share| {
        let mut xi = face.on_face(centre);
        xi[d] = first + share * (last - first);
        Vector3::from(patch.point(&xi))
    });
    let along = points[4] - points[0];
    let height = |p: &Vector3<f64>| (p - points[0]).cross(&along).norm();
    patch.dimension() == 3 && points.iter().all(|p| height(p) <= STRAIGHT * along.norm_squared())
}

/// What lies at both ends of an interval in direction `d`, along which parameters have a `slack`.
fn interval_ends(
    coarse: &ElasticBody,
    patch: &Patch,
    face: &Face,
    region: &ParameterBox,
    (d, slack): (usize, f64),
) -> [IntervalEnd; 2] {
    let (first, last) = patch.knots()[d].domain();
    let corners = [&region.lower, &region.upper].map(|corner| patch.point(&face.on_face(corner)));
    let extent = norm(&std::array::from_fn(|c| corners[1][c] - corners[0][c]));
    [(region.lower, first), (region.upper, last)].map(|(corner, end)| {
        let is_axis = coarse.spec.model == Model::Axisymmetric
            && patch.point(&face.on_face(&corner))[0].abs() < PARAMETER_SLACK * extent;
        match ((corner[d] - end).abs() <= slack, is_axis) {
            (false, _) => IntervalEnd::Open,
            (true, true) => IntervalEnd::Axis,
            (true, false) => IntervalEnd::FaceEnd,
        }
    })
}
