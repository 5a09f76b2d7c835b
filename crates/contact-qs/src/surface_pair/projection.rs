//! Closest points on a displaced target surface (docs/theory.md Eqs. C.38, C.39).

mod edges;
pub(super) mod meeting_point;
pub(super) mod normal_walk;
pub(super) mod proximity_cache;
mod seams;
pub(super) mod warm_start;
mod whole_surface;

use std::ops::Range;

use ffr_dynamics::body::RigidMotion;
use iga_core::nurbs::jet::{cross, difference, dot, norm};
use iga_core::nurbs::locate::box_newton::{Sample, minimize};

use super::target::TargetSurface;
use super::target::bezier::{self, MAX_ORDER, Table};
use normal_walk::{Foot, NormalJet, foot};
use proximity_cache::square;

/// Newton steps from a known start before the safeguarded search takes over.
const MAX_STEPS: usize = 6;
/// Sine of the angle between the tangents below which the net counts as singular. The normal is
/// then evaluated further inside, by the square root of this number times the ranges of the face's
/// parameters, where the tangents are accurate.
const SINGULAR: f64 = 1e-6;
/// Samples of each cell for searches without a start, in each direction.
const SAMPLES: [f64; 2] = [0.25, 0.75];

/// A place on the surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfacePlace {
    /// Index of the face.
    pub face: u32,
    /// Parameters along it.
    pub xi: [f64; 2],
}

/// The displaced surface at one place.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SurfaceJet {
    pub element: u32,
    pub point: [f64; 3],
    pub tangents: [[f64; 3]; 2],
    /// Second derivatives 00, 11, 01.
    pub second: [[f64; 3]; 3],
}

/// Closest point of the surface.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Projection {
    pub place: SurfacePlace,
    pub element: u32,
    pub point: [f64; 3],
    /// Outward unit normal of the displaced surface.
    pub normal: [f64; 3],
    /// Distance along the normal, negative inside \[m\].
    pub gap: f64,
    /// Whether the closest point is an end of the target with the point lying beyond it: no contact
    /// there.
    pub is_beyond: bool,
    /// Whether the closest point of a point below the surface is near an edge that contact must not
    /// reach.
    pub is_at_edge: bool,
    /// Whether it lies on the plane of a meeting point ([`super::MeetingPoint`]): `point` is the
    /// vector along this plane from its place then.
    pub is_on_plane: bool,
}

impl Projection {
    /// Unilateral distance: a point beyond the end of the target is outside \[m\].
    pub fn distance(&self, point: &[f64; 3]) -> f64 {
        if self.is_beyond { norm(&difference(point, &self.point)) } else { self.gap }
    }
}

/// Functions of the element last evaluated, with derivatives `1, ∂_0, ∂_1, ∂_00, ∂_11, ∂_01`.
#[derive(Debug, Clone)]
pub(super) struct Functions {
    rows: Vec<[f64; 6]>,
    n: usize,
    tables: [Table; 2],
}

impl Functions {
    pub fn new(surface: &TargetSurface) -> Self {
        Self { rows: vec![[0.0; 6]; surface.n_functions], n: 0, tables: [[[0.0; MAX_ORDER]; 3]; 2] }
    }

    /// Values of the functions, in the order of the element's nodes.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.rows[..self.n].iter().map(|r| r[0])
    }

    /// Derivative of each function along parameter `a`.
    pub fn slopes(&self, a: usize) -> impl Iterator<Item = f64> + '_ {
        self.rows[..self.n].iter().map(move |r| r[1 + a])
    }

    /// Evaluates the functions at `place`; returns the element (Eq. C.37).
    fn evaluate(&mut self, surface: &TargetSurface, place: &SurfacePlace) -> u32 {
        let grid = &surface.faces[place.face as usize];
        let index = grid.element(&place.xi);
        let element = &surface.elements[index];
        let [p, q] = grid.degrees;
        let (n0, n1) = (p + 1, q + 1);
        let mut scales = [0.0; 2];
        for (a, scale) in scales.iter_mut().enumerate().take(surface.n_parameters) {
            let width = element.upper[a] - element.lower[a];
            *scale = 1.0 / width;
            bezier::table(grid.degrees[a], (place.xi[a] - element.lower[a]) / width, &mut self.tables[a]);
        }
        let [s, t] = scales;
        let factors = [1.0, s, t, s * s, t * t, s * t];
        self.n = element.nodes.len();
        if surface.n_parameters == 1 {
            self.sum_curve(&element.coefficients, n0 * n1, s);
            return index as u32;
        }
        let [along, across] = &self.tables;
        let mut totals = [0.0; 6];
        for (row, coefficients) in self.rows.iter_mut().zip(element.coefficients.chunks_exact(n0 * n1)) {
            *row = [0.0; 6];
            for (l, line) in coefficients.chunks_exact(n0).enumerate() {
                let mut sums = [0.0; 3];
                for (k, c) in line.iter().enumerate() {
                    (0..3).for_each(|d| sums[d] += c * along[d][k]);
                }
                let b = [across[0][l], across[1][l], across[2][l]];
                row[0] += sums[0] * b[0];
                row[1] += sums[1] * b[0];
                row[2] += sums[0] * b[1];
                row[3] += sums[2] * b[0];
                row[4] += sums[0] * b[2];
                row[5] += sums[1] * b[1];
            }
            for d in 0..6 {
                row[d] *= factors[d];
                totals[d] += row[d];
            }
        }
        self.divide(&totals);
        index as u32
    }

    /// The functions of a curve, of `order` coefficients each, from the first table; `scale`:
    /// derivative of its parameter. Derivatives across it stay zero.
    fn sum_curve(&mut self, coefficients: &[f64], order: usize, scale: f64) {
        let [value, slope, bend] = &self.tables[0];
        let mut totals = [0.0; 3];
        for (row, line) in self.rows.iter_mut().zip(coefficients.chunks_exact(order)) {
            let mut sums = [0.0; 3];
            for (((c, b0), b1), b2) in line.iter().zip(value).zip(slope).zip(bend) {
                sums[0] += c * b0;
                sums[1] += c * b1;
                sums[2] += c * b2;
            }
            (row[0], row[1], row[3]) = (sums[0], scale * sums[1], scale * scale * sums[2]);
            totals[0] += row[0];
            totals[1] += row[1];
            totals[2] += row[3];
        }
        let inverse = 1.0 / totals[0];
        for row in &mut self.rows[..self.n] {
            row[0] *= inverse;
            row[1] = (row[1] - row[0] * totals[1]) * inverse;
            row[3] = (row[3] - 2.0 * row[1] * totals[1] - row[0] * totals[2]) * inverse;
        }
    }

    /// Quotients by the sum of all functions, whose derivatives are `totals`.
    fn divide(&mut self, totals: &[f64; 6]) {
        let inverse = 1.0 / totals[0];
        for row in &mut self.rows[..self.n] {
            row[0] *= inverse;
            row[1] = (row[1] - row[0] * totals[1]) * inverse;
            row[2] = (row[2] - row[0] * totals[2]) * inverse;
            row[3] = (row[3] - 2.0 * row[1] * totals[1] - row[0] * totals[3]) * inverse;
            row[4] = (row[4] - 2.0 * row[2] * totals[2] - row[0] * totals[4]) * inverse;
            row[5] = (row[5] - row[1] * totals[2] - row[2] * totals[1] - row[0] * totals[5]) * inverse;
        }
    }
}

/// A surface with its nodes displaced to `nodes`.
#[derive(Clone, Copy)]
pub(super) struct Displaced<'a> {
    pub surface: &'a TargetSurface,
    pub nodes: &'a [[f64; 3]],
    /// Continuous normals at the nodes; none of splines.
    pub normals: &'a [[f64; 3]],
    /// Distance in parameters by which a projection may leave a piece before it goes on to the next
    /// one.
    pub slack: f64,
}

impl Displaced<'_> {
    /// The surface at `place`, its functions there in `functions`.
    pub fn jet(&self, place: &SurfacePlace, functions: &mut Functions) -> SurfaceJet {
        let element = functions.evaluate(self.surface, place);
        self.jet_of(element, functions)
    }

    /// The surface where `functions` were last evaluated, in `element`.
    pub fn jet_of(&self, element: u32, functions: &Functions) -> SurfaceJet {
        let index = element;
        let mut jet = SurfaceJet { element, ..SurfaceJet::default() };
        let nodes = &self.surface.elements[index as usize].nodes;
        if self.surface.n_parameters == 1 {
            for (&node, row) in nodes.iter().zip(&functions.rows) {
                let x = &self.nodes[node as usize];
                add(&mut jet.point, row[0], x);
                add(&mut jet.tangents[0], row[1], x);
                add(&mut jet.second[0], row[3], x);
            }
            return jet;
        }
        for (&node, row) in nodes.iter().zip(&functions.rows) {
            let x = &self.nodes[node as usize];
            add(&mut jet.point, row[0], x);
            jet.tangents.iter_mut().zip(&row[1..3]).for_each(|(t, r)| add(t, *r, x));
            jet.second.iter_mut().zip(&row[3..]).for_each(|(t, r)| add(t, *r, x));
        }
        jet
    }

    /// Closest point to `point`, from a known place nearby.
    pub fn closest_from(
        &self,
        start: &SurfacePlace,
        point: &[f64; 3],
        functions: &mut Functions,
    ) -> Projection {
        if let Some(smoothing) = &self.surface.smoothing {
            let jet = |face: u32, xi: [f64; 2]| self.normal_jet(&SurfacePlace { face, xi }, functions);
            return match foot((start.face, start.xi), point, jet, (&smoothing.neighbours, self.slack)) {
                Some(found) => self.at_foot(&found, point, functions),
                // Far from the surface the normals of several places may pass through the point.
                None => self.safeguarded(start, point, functions),
            };
        }
        let mut place = *start;
        let mut last = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let jet = self.jet(&place, functions);
            let step = self.newton(&place, &jet, point);
            let Some((step, residual)) = step else { break };
            let round_off = self.round_off(&place, &jet, point);
            let is_stalled = residual > 0.5 * last;
            // The residual is a sum of some ten terms and may stay a little above the round-off of
            // positions.
            if residual <= 2.0 * round_off || (is_stalled && residual <= 32.0 * round_off) {
                return self.complete(place, &jet, point, functions);
            }
            // If a step does not reduce the residual, the safeguarded search takes over.
            if residual.is_nan() || is_stalled {
                break;
            }
            last = residual;
            let grid = &self.surface.faces[place.face as usize];
            (0..self.surface.n_parameters).for_each(|a| {
                let [low, high] = grid.range(a);
                place.xi[a] = (place.xi[a] + step[a]).clamp(low, high);
            });
        }
        self.safeguarded(start, point, functions)
    }

    /// Surface and continuous normal at `place`.
    fn normal_jet(&self, place: &SurfacePlace, functions: &mut Functions) -> NormalJet {
        let element = functions.evaluate(self.surface, place);
        let mut jet = NormalJet::default();
        let nodes = &self.surface.elements[element as usize].nodes;
        for (&node, row) in nodes.iter().zip(&functions.rows) {
            let (x, n) = (&self.nodes[node as usize], &self.normals[node as usize]);
            add(&mut jet.point, row[0], x);
            add(&mut jet.normal, row[0], n);
            for a in 0..2 {
                add(&mut jet.tangents[a], row[1 + a], x);
                add(&mut jet.slopes[a], row[1 + a], n);
            }
        }
        if self.surface.n_parameters == 1 {
            jet.tangents[1] = [0.0, 0.0, 1.0];
        }
        jet
    }

    /// Normal and gap of `point`, whose projection along continuous normals ended at `found`
    /// (Eq. C.53).
    fn at_foot(&self, found: &Foot, point: &[f64; 3], functions: &mut Functions) -> Projection {
        let place = SurfacePlace { face: found.piece, xi: found.xi };
        let jet = self.normal_jet(&place, functions);
        let length = norm(&jet.normal);
        let normal = jet.normal.map(|n| n / length);
        let gap = dot(&difference(point, &jet.point), &normal);
        Projection {
            place,
            element: found.piece,
            point: jet.point,
            normal,
            gap,
            is_beyond: found.is_beyond,
            ..Projection::default()
        }
    }

    /// Round-off of the tangential residual: that of positions, and that of tangents, which are
    /// differences of positions of an element, on the distance of the point.
    fn round_off(&self, place: &SurfacePlace, jet: &SurfaceJet, point: &[f64; 3]) -> f64 {
        let element = &self.surface.elements[jet.element as usize];
        let degrees = self.surface.faces[place.face as usize].degrees;
        let (size, distance) = (norm(&jet.point), norm(&difference(&jet.point, point)));
        let mut relative = 0.0_f64;
        for (a, degree) in degrees.iter().enumerate().take(self.surface.n_parameters) {
            let length = norm(&jet.tangents[a]) * (element.upper[a] - element.lower[a]);
            relative = relative.max(*degree as f64 * size / length);
        }
        f64::EPSILON * (norm(point) + size + distance * relative)
    }

    /// Newton's step on the free parameters and the length of the tangential residual there; none
    /// unless the Hessian is positive definite (Eq. C.38).
    fn newton(&self, place: &SurfacePlace, jet: &SurfaceJet, point: &[f64; 3]) -> Option<([f64; 2], f64)> {
        let grid = &self.surface.faces[place.face as usize];
        let r = difference(&jet.point, point);
        let (mut g, mut h, mut is_free) = ([0.0; 2], [1.0, 1.0, 0.0], [false; 2]);
        let mut residual = 0.0_f64;
        for a in 0..self.surface.n_parameters {
            g[a] = dot(&r, &jet.tangents[a]);
            let [low, high] = grid.range(a);
            is_free[a] = !(place.xi[a] <= low && g[a] > 0.0 || place.xi[a] >= high && g[a] < 0.0);
            if is_free[a] {
                h[a] = dot(&jet.tangents[a], &jet.tangents[a]) + dot(&r, &jet.second[a]);
                residual = residual.hypot(g[a] / norm(&jet.tangents[a]));
            } else {
                g[a] = 0.0;
            }
        }
        if is_free == [true; 2] {
            h[2] = dot(&jet.tangents[0], &jet.tangents[1]) + dot(&r, &jet.second[2]);
        }
        let determinant = h[0] * h[1] - h[2] * h[2];
        if !(h[0] > 0.0 && determinant > 0.0) {
            return None;
        }
        Some((
            [-(h[1] * g[0] - h[2] * g[1]) / determinant, -(h[0] * g[1] - h[2] * g[0]) / determinant],
            residual,
        ))
    }

    /// Closest point by projected Newton steps with a line search, which converges from any start
    /// (Eq. S.21).
    fn safeguarded(&self, start: &SurfacePlace, point: &[f64; 3], functions: &mut Functions) -> Projection {
        let grid = &self.surface.faces[start.face as usize];
        let (mut lower, mut upper) = ([0.0; 2], [0.0; 2]);
        for a in 0..self.surface.n_parameters {
            [lower[a], upper[a]] = grid.range(a);
        }
        let objective = |xi: &[f64; 2]| {
            let jet = self.jet(&SurfacePlace { face: start.face, xi: *xi }, functions);
            let second = |a: usize, b: usize| jet.second[if a == b { a } else { 2 }];
            let noise =
                f64::EPSILON * norm(&difference(&jet.point, point)) * (norm(&jet.point) + norm(point));
            Sample { noise, ..Sample::half_square(&jet.point, &jet.tangents, second, point) }
        };
        let (xi, _) = minimize(objective, &start.xi, &lower, &upper);
        let mut place = SurfacePlace { face: start.face, xi };
        let mut jet = self.jet(&place, functions);
        // The objective is flat to the root of eps; the gradient is not.
        for _ in 0..2 {
            let Some((step, residual)) = self.newton(&place, &jet, point) else { break };
            let mut next = place;
            for a in 0..self.surface.n_parameters {
                next.xi[a] = (place.xi[a] + step[a]).clamp(lower[a], upper[a]);
            }
            let there = self.jet(&next, functions);
            let is_better = self.newton(&next, &there, point).is_some_and(|(_, after)| after < residual);
            if !is_better {
                break;
            }
            (place, jet) = (next, there);
        }
        jet = self.jet(&place, functions);
        self.complete(place, &jet, point, functions)
    }

    /// Outward unit normal of the displaced surface at `place`; where the net is singular, as at
    /// poles, the limit of the normals nearby.
    ///
    /// The functions are left as they are at `place`.
    fn normal(&self, place: &SurfacePlace, jet: &SurfaceJet, functions: &mut Functions) -> [f64; 3] {
        let grid = &self.surface.faces[place.face as usize];
        let unit = |jet: &SurfaceJet| {
            let [t, s] = &jet.tangents;
            let across = if self.surface.n_parameters == 1 { [t[1], -t[0], 0.0] } else { cross(t, s) };
            let length = norm(&across);
            (across.map(|x| grid.orientation / length * x), length / (norm(t) * norm(s)))
        };
        let (normal, sine) = unit(jet);
        // Asked this way round, a NaN counts as singular.
        if self.surface.n_parameters == 1 || sine > SINGULAR {
            return normal;
        }
        let near = unit(&self.jet(&self.further_inside(place), functions)).0;
        functions.evaluate(self.surface, place);
        near
    }

    /// The projection of the point of the surface at `place` itself: gap zero.
    pub fn at(&self, place: &SurfacePlace, functions: &mut Functions) -> Projection {
        let jet = self.jet(place, functions);
        self.complete(*place, &jet, &jet.point, functions)
    }

    /// Normal and gap at a closest point (Eq. C.39).
    ///
    /// On the axis of an axisymmetric model the surface goes on beyond its end as its mirror image:
    /// there is nothing beyond, and the normal is the axis, whatever slope the displaced functions
    /// have there.
    fn complete(
        &self,
        place: SurfacePlace,
        jet: &SurfaceJet,
        point: &[f64; 3],
        functions: &mut Functions,
    ) -> Projection {
        let grid = &self.surface.faces[place.face as usize];
        let mut normal = self.normal(&place, jet, functions);
        let r = difference(point, &jet.point);
        let overhang = self.surface.overhang();
        let is_on_axis =
            self.surface.motion == RigidMotion::Axial && jet.point[0].abs() <= self.surface.round_off();
        if is_on_axis && normal[1].is_finite() {
            normal = [0.0, normal[1].signum(), 0.0];
        }
        let mut is_beyond = false;
        for a in 0..if is_on_axis { 0 } else { self.surface.n_parameters } {
            let along = dot(&r, &jet.tangents[a]) / norm(&jet.tangents[a]);
            let [low, high] = grid.range(a);
            is_beyond |= place.xi[a] <= low && along < -overhang || place.xi[a] >= high && along > overhang;
        }
        is_beyond |= self.is_beyond_smooth_corner(&place, jet, &r, functions);
        Projection {
            place,
            element: jet.element,
            point: jet.point,
            normal,
            gap: dot(&r, &normal),
            is_beyond,
            ..Projection::default()
        }
    }

    /// Whether a point that is `r` away from the corner `place` lies beyond it where the rim has no corner, as at the four of a disc whose
    /// net is that of a square: both tangents lie along the rim there, and only a place inside tells where the surface ends.
    fn is_beyond_smooth_corner(
        &self,
        place: &SurfacePlace,
        jet: &SurfaceJet,
        r: &[f64; 3],
        functions: &mut Functions,
    ) -> bool {
        let grid = &self.surface.faces[place.face as usize];
        let is_end = |a: usize| {
            // A distance that hardly depends on a parameter tells the root of its round-off.
            let ([low, high], xi) = (grid.range(a), place.xi[a]);
            (xi - low).min(high - xi) <= SINGULAR * (high - low)
        };
        let [t, s] = &jet.tangents;
        let is_smooth = || norm(&cross(t, s)) <= SINGULAR * norm(t) * norm(s) && norm(t).min(norm(s)) > 0.0;
        if self.surface.n_parameters < 2 || !is_end(0) || !is_end(1) || !is_smooth() {
            return false;
        }
        let outwards = difference(&jet.point, &self.jet(&self.further_inside(place), functions).point);
        functions.evaluate(self.surface, place);
        dot(r, &outwards) > self.surface.overhang() * norm(&outwards)
    }

    /// A place beside `place` further inside its face, where tangents of a singular net are accurate.
    fn further_inside(&self, place: &SurfacePlace) -> SurfacePlace {
        let grid = &self.surface.faces[place.face as usize];
        let mut inside = *place;
        for (a, xi) in inside.xi.iter_mut().enumerate() {
            let [low, high] = grid.range(a);
            *xi += SINGULAR.sqrt() * (0.5 * (low + high) - *xi);
        }
        inside
    }
}

fn add(sum: &mut [f64; 3], factor: f64, x: &[f64; 3]) {
    sum.iter_mut().zip(x).for_each(|(s, x)| *s += factor * x);
}

/// Places spread over a surface, from which searches without a start begin.
#[derive(Debug, Clone)]
pub(super) struct Samples {
    places: Vec<SurfacePlace>,
    points: Vec<[f64; 3]>,
    /// Element of each place and where its function values start.
    elements: Vec<(u32, usize)>,
    values: Vec<f64>,
    /// The first place of each face, and the number of places; the mean place of those of each face.
    first: Vec<usize>,
    middles: Vec<[f64; 3]>,
}

impl Samples {
    pub fn new(surface: &TargetSurface) -> Self {
        let (mut places, mut first) = (Vec::new(), vec![0]);
        for (face, grid) in surface.faces.iter().enumerate() {
            let shares: [&[f64]; 2] = [&SAMPLES, if surface.n_parameters == 2 { &SAMPLES } else { &[0.5] }];
            let along = |a: usize| {
                let cells = grid.breaks[a].windows(2);
                cells.flat_map(move |u| shares[a].iter().map(move |s| u[0] + s * (u[1] - u[0])))
            };
            for v in along(1) {
                places.extend(along(0).map(|u| SurfacePlace { face: face as u32, xi: [u, v] }));
            }
            first.push(places.len());
        }
        let mut functions = Functions::new(surface);
        let (mut elements, mut values) = (Vec::new(), Vec::new());
        for place in &places {
            elements.push((functions.evaluate(surface, place), values.len()));
            values.extend(functions.values());
        }
        let (points, middles) = (vec![[0.0; 3]; places.len()], vec![[0.0; 3]; surface.faces.len()]);
        Self { places, points, elements, values, first, middles }
    }

    /// Moves the samples with the surface unless that has been done, as `is_done` tells.
    pub fn update_once(&mut self, displaced: Displaced<'_>, is_done: &mut bool) {
        if !*is_done {
            self.update(displaced);
            *is_done = true;
        }
    }

    /// Moves the samples with the surface.
    pub fn update(&mut self, displaced: Displaced<'_>) {
        for (&(element, start), point) in self.elements.iter().zip(&mut self.points) {
            let nodes = &displaced.surface.elements[element as usize].nodes;
            *point = [0.0; 3];
            for (&node, &value) in nodes.iter().zip(&self.values[start..]) {
                add(point, value, &displaced.nodes[node as usize]);
            }
        }
        for (middle, places) in self.middles.iter_mut().zip(self.first.windows(2)) {
            *middle = [0.0; 3];
            let share = 1.0 / (places[1] - places[0]) as f64;
            self.points[places[0]..places[1]].iter().for_each(|point| add(middle, share, point));
        }
    }

    /// Mean of the places of face `face`.
    pub fn middle(&self, face: usize) -> &[f64; 3] {
        &self.middles[face]
    }

    /// Place of the sample next to `point`.
    pub fn nearest(&self, point: &[f64; 3]) -> SurfacePlace {
        self.nearest_among(0..self.places.len(), point)
    }

    /// Place of the sample of face `face` next to `point`.
    pub fn nearest_on(&self, face: usize, point: &[f64; 3]) -> SurfacePlace {
        self.nearest_among(self.first[face]..self.first[face + 1], point)
    }

    /// Place of the sample next to `point` among those with the numbers `range`.
    fn nearest_among(&self, range: Range<usize>, point: &[f64; 3]) -> SurfacePlace {
        let (mut best, mut least) = (range.start, f64::INFINITY);
        for k in range {
            let distance = square(point, &self.points[k]);
            if distance < least {
                (best, least) = (k, distance);
            }
        }
        self.places[best]
    }
}
