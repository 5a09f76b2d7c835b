//! The indentation right under a straight edge along a face, and of an edge that presses one, that the elements of a body leave out
//! (docs/theory.md sections C.19, C.27).

use std::collections::{BTreeMap, HashMap, HashSet};
use std::f64::consts::FRAC_PI_2;

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use ffr_dynamics::body::AssembledBody;
use iga_core::elasticity::Model;
use nalgebra::Vector3;

use crate::body::field_body::FieldBody;
use crate::body::zone::{ContactZone, MetEdge, PointsAbout};
use crate::surface::ALONG;
use crate::touch::tolerances::{OPENING, ROUND_OFF};

/// Share of the body's least extent beyond which displacements about the edge are those of the half-plane, with
/// a margin for round-off of places: nodes of regular meshes lie just there.
const WITHIN: f64 = 0.5 + 1e-6;
/// Gauss points of two on a unit length.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_13, 0.788_675_134_594_812_9];
/// Values of functions that are round-off.
const NO_VALUE: f64 = 1e-12;

/// A wedge under a unit line load on its edge [m per N/m], a half-plane if it is half a turn wide.
struct Wedge {
    /// A place on the line \[m\].
    origin: Vector3<f64>,
    /// Unit vectors across the line: from its middle plane, and along that into the body.
    axes: [Vector3<f64>; 2],
    /// Angle of its faces and of the load from the latter \[rad\].
    half_angle: f64,
    load: f64,
    /// Elastic modulus \[Pa\] and Poisson's ratio of the plane.
    modulus: f64,
    poisson: f64,
    /// Length at which the logarithm is zero: the least extent of the body \[m\].
    length: f64,
}

impl Wedge {
    /// That of `body` under `edge`, where the outward normals of its faces are `faces`, loaded along `inwards`; none without a material, and of
    /// a corner.
    fn new(
        body: &dyn FieldBody,
        edge: &MetEdge,
        faces: &[Vector3<f64>],
        inwards: &Vector3<f64>,
    ) -> Option<Self> {
        let along = edge.half.try_normalize(0.0)?;
        let across_line = |v: Vector3<f64>| (v - v.dot(&along) * along).try_normalize(0.0);
        let (into, half_angle) = match faces {
            [_] => (*inwards, FRAC_PI_2),
            [a, b] => {
                let into = across_line(-(a + b))?;
                (into, FRAC_PI_2 - across_line(*a)?.dot(&-into).clamp(-1.0, 1.0).acos())
            }
            _ => return None,
        };
        let across = into.cross(&along).try_normalize(0.0)?;
        let (lambda, shear) = body.model().lame(body.slowest_material()?);
        // Of the stress in the plane, whatever is across it.
        let poisson = lambda / (lambda + 2.0 * shear);
        Some(Self {
            origin: edge.middle,
            axes: [across, into],
            half_angle,
            load: inwards.dot(&across).atan2(inwards.dot(&into)),
            modulus: 2.0 * shear * (1.0 + poisson),
            poisson,
            length: body.thickness(),
        })
    }

    /// Angles of the parts of the load along and across the middle plane, with their stress along a radius in their direction, times it.
    fn parts(&self) -> [(f64, f64); 2] {
        let (sin, cos) = self.load.sin_cos();
        let twice = (2.0 * self.half_angle).sin();
        let stress = |part: f64, sign: f64| part / (self.half_angle + sign * 0.5 * twice);
        [(0.0, stress(cos, 1.0)), (FRAC_PI_2, stress(sin, -1.0))]
    }

    /// Displacement at the distance `r` under `angle` (theory Eq. C.115).
    fn polar(&self, r: f64, angle: f64) -> Vector3<f64> {
        let log = (r / self.length).ln();
        let [mut radial, mut around] = [0.0; 2];
        for (turn, stress) in self.parts() {
            let (sin, cos) = (angle - turn).sin_cos();
            let (once, bend) = (0.5 * stress / self.modulus, (1.0 - self.poisson) * (angle - turn));
            radial -= once * (2.0 * cos * log + bend * sin);
            around += once * (sin * (2.0 * log + 1.0 + self.poisson) - bend * cos);
        }
        let (sin, cos) = angle.sin_cos();
        self.axes[0] * (radial * sin + around * cos) + self.axes[1] * (radial * cos - around * sin)
    }

    /// Displacement at `x`.
    fn displacement(&self, x: &[f64; 3]) -> Vector3<f64> {
        let from = Vector3::from(*x) - self.origin;
        let [aside, depth] = self.axes.map(|axis| from.dot(&axis));
        // Nodes of sides that are not plane to the last digit do not lie above the face.
        let angle = aside.atan2(depth).clamp(-self.half_angle, self.half_angle);
        self.polar(aside.hypot(depth), angle)
    }

    /// Unit vector at `angle` from the middle plane.
    fn way(&self, angle: f64) -> Vector3<f64> {
        self.axes[0] * angle.sin() + self.axes[1] * angle.cos()
    }

    /// Angles of its faces, with the sine of the angle by which each opens against a plane across the load.
    fn faces(&self) -> [(f64, f64); 2] {
        [1.0, -1.0].map(|face| (face * self.half_angle, (self.half_angle - face * self.load).sin()))
    }

    /// Depth under a load that is spread by `half` to both sides (theory Eq. C.116).
    fn depth(&self, half: f64) -> f64 {
        let (inwards, [(_, along), (_, across)]) = (self.way(self.load), self.parts());
        let spread = (along * self.load.cos() + across * self.load.sin()) / self.modulus;
        let at = |(angle, opening): (f64, f64)| {
            self.polar(half / opening, angle).dot(&inwards) + spread * opening * opening
        };
        self.faces().map(at).iter().sum::<f64>() / 2.0
    }

    /// Ways from the line to places that have the mean displacement of its faces as far as `half` to both sides: Gauss points.
    fn strip(&self, half: f64) -> Vec<Vector3<f64>> {
        let of_face =
            |(angle, opening): (f64, f64)| GAUSS.map(|share| share * half / opening * self.way(angle));
        self.faces().into_iter().flat_map(of_face).collect()
    }
}

/// A line along which a face or an edge of a body is pressed, in the components of its model.
pub struct PressedLine {
    /// The line; out of the plane of a plane model.
    pub edge: MetEdge,
    /// Unit vector into the body.
    inwards: Vector3<f64>,
    /// What the body is about it.
    wedge: Wedge,
}

/// A point on such a line: its functions with their values, and the length of the line that is its own \[m\].
pub type LinePoint<'a> = (&'a [(u32, f64)], f64);

impl PressedLine {
    /// That along which the edge, the line or, in the plane, the corner of one body presses another, of `body` `about` a place, where what
    /// touches has the outward normal `outward`; none where it presses at a point, with a face beside an edge, near an axis of symmetry, and without a
    /// material.
    pub fn new(body: &dyn FieldBody, about: &PointsAbout, outward: &[f64; 3]) -> Option<Self> {
        let (edge, outward) = (pressed_edge(body, about)?, Vector3::from(*outward));
        let faces = if edge.outward.is_some() {
            body.undeformed().parts_at(&about.place.point)
        } else {
            vec![outward]
        };
        let leans = |face: &Vector3<f64>| face.dot(&outward) < OPENING.cos();
        let is_face = faces.len() == 1 && faces[0].dot(&outward) > ALONG;
        if edge.spread <= 0.0 || !(is_face || faces.iter().all(leans)) {
            return None;
        }
        let wedge = Wedge::new(body, &edge, &faces, &-outward)?;
        Some(Self { edge, inwards: -outward, wedge })
    }

    /// Compliances of the indentation that the elements of `body` leave out at `points` [m/N] (Eq. C.101).
    pub fn left_out(&self, body: &dyn FieldBody, points: &[LinePoint<'_>]) -> Option<Vec<f64>> {
        let wedge = &self.wedge;
        let functions: Vec<&[(u32, f64)]> = points.iter().map(|p| p.0).collect();
        let patch =
            Patch::new(body.assembled(), &functions, |x| self.edge.distance(x) <= WITHIN * wedge.length);
        let rows: Vec<Vec<(usize, f64)>> =
            points.iter().map(|p| patch.row(body, p.0, &self.inwards)).collect();
        let mut load = Mat::<f64>::zeros(patch.unknowns.len(), 1);
        for (row, (_, length)) in rows.iter().zip(points) {
            row.iter().for_each(|(k, value)| load[(*k, 0)] += length * value);
        }
        let found = patch.displacements(body.assembled(), load, |x| wedge.displacement(x))?;
        let depths = rows.iter().map(|row| row.iter().map(|(k, value)| value * found[(*k, 0)]).sum::<f64>());
        let whole = wedge.depth(self.edge.spread);
        Some(depths.zip(points).map(|(depth, (_, length))| (whole - depth).max(0.0) / length).collect())
    }
}

/// The line that is pressed `about` a place of `body`.
fn pressed_edge(body: &dyn FieldBody, about: &PointsAbout) -> Option<MetEdge> {
    let (model, place, meets) = (body.model(), about.place.point, about.meets?);
    if model.dimension() == 3 {
        return about.edge();
    }
    let own = meets.own_outward().map(Vector3::from);
    let is_smooth = own.is_some() || body.undeformed().parts_at(&place).len() == 1;
    let is_near_axis = *model == Model::Axisymmetric && place[0] <= WITHIN * body.thickness();
    let half = 0.5 * model.measure(&place) * Vector3::z();
    (is_smooth && !is_near_axis).then(|| MetEdge {
        middle: place.into(),
        half,
        spread: meets.spread,
        outward: own,
    })
}

/// Width over which `body` is pressed `about` a place \[m\]; none where it is pressed at a point.
pub fn pressed_width(body: &dyn FieldBody, about: &PointsAbout) -> Option<f64> {
    pressed_edge(body, about).map(|edge| 2.0 * edge.spread)
}

impl ContactZone {
    /// Lengths of the line `half` of which is given that belong to its points on it, in the shares of their areas \[m\].
    pub fn lengths_of_meeting(&self, half: &Vector3<f64>) -> Vec<f64> {
        let areas = self.meeting.iter().map(|(i, _)| self.points[*i].area);
        let total: f64 = areas.clone().sum();
        areas.map(|area| 2.0 * half.norm() * area / total).collect()
    }

    /// Adds to what is left out at the points on its line.
    pub fn leave_out(&mut self, left_out: &[f64]) {
        self.left_out.resize(self.points.len(), 0.0);
        for ((i, _), more) in self.meeting.iter().zip(left_out) {
            self.left_out[*i] += more;
        }
    }

    /// Lets points on an own edge, `line`, yield by the mean of the strip over which that is pressed, which fine elements resolve.
    fn press_over_strip(&mut self, body: &dyn FieldBody, line: &PressedLine) -> Option<()> {
        let strip = line.wedge.strip(line.edge.spread);
        let mean = |(i, _): &(usize, f64)| {
            let (mut sum, middle) = (BTreeMap::new(), Vector3::from(self.points[*i].position));
            for way in &strip {
                for (node, value) in body.functions_at(&(middle + way).into()).ok()? {
                    *sum.entry(node).or_insert(0.0) += value / strip.len() as f64;
                }
            }
            Some(sum.into_iter().filter(|f: &(u32, f64)| f.1.abs() > NO_VALUE).collect())
        };
        let functions: Option<Vec<Vec<(u32, f64)>>> = self.meeting.iter().map(mean).collect();
        for ((i, _), functions) in self.meeting.iter().zip(functions?) {
            let numbers = |f: &(u32, f64)| (0..3).filter_map(|c| body.lookup().number(f.0, c)).collect();
            self.unknowns.extend(functions.iter().flat_map::<Vec<usize>, _>(numbers));
            self.points[*i].functions = functions;
        }
        self.unknowns.sort_unstable();
        self.unknowns.dedup();
        Some(())
    }

    /// Adds what the elements of `body`, on whose surface the zone lies, leave out of the indentation `about` its place; points on an own edge
    /// there are turned to the target.
    pub fn add_left_out(&mut self, body: &dyn FieldBody, about: &PointsAbout) {
        let own = about.meets.and_then(|meets| meets.own_outward());
        for (i, _) in &self.meeting {
            self.points[*i].facing = own.or(self.points[*i].facing);
        }
        let facing = self.meeting.first().and_then(|(i, _)| self.points[*i].facing);
        let Some(line) = facing.and_then(|facing| PressedLine::new(body, about, &facing)) else { return };
        if own.is_some() {
            self.press_over_strip(body, &line);
        }
        let lengths = self.lengths_of_meeting(&line.edge.half);
        let functions = self.meeting.iter().map(|(i, _)| self.points[*i].functions.as_slice());
        let points: Vec<LinePoint<'_>> = functions.zip(lengths).collect();
        let left_out = line.left_out(body, &points);
        self.leave_out(&left_out.unwrap_or_default());
    }
}

/// The part of a body about an edge.
struct Patch {
    /// Its unknowns.
    unknowns: Vec<usize>,
    /// The number of each unknown of the body among them.
    number: Vec<Option<usize>>,
}

impl Patch {
    /// The unknowns of the elements that hold the points whose `functions` are given, and those coupled with them that lie `within`.
    fn new(
        assembled: &AssembledBody,
        functions: &[&[(u32, f64)]],
        within: impl Fn(&[f64; 3]) -> bool,
    ) -> Self {
        let node = |k: usize| assembled.dofs[k].node as usize;
        let (symbolic, n) = (assembled.stiffness.symbolic(), assembled.dofs.len());
        let coupled = || {
            let pairs = (0..n).flat_map(|j| {
                symbolic.row_idx_of_col_raw(j).iter().map(move |&i| [node(j), node(i as usize)])
            });
            pairs.flat_map(|[a, b]| [[a, b], [b, a]])
        };
        // Of a point between elements round-off chooses one; all of them hold the functions that are not zero there.
        let nodes_of = |point: &[(u32, f64)]| -> Vec<usize> {
            point.iter().filter(|f| f.1.abs() > ROUND_OFF).map(|f| f.0 as usize).collect()
        };
        let nodes: Vec<Vec<usize>> = functions.iter().map(|point| nodes_of(point)).collect();
        let mut partners: HashMap<usize, HashSet<usize>> =
            nodes.iter().flatten().map(|node| (*node, HashSet::new())).collect();
        coupled().for_each(|[from, to]| {
            if let Some(partners) = partners.get_mut(&from) {
                partners.insert(to);
            }
        });
        let mut is_first = vec![false; assembled.nodes.len()];
        for point in &nodes {
            let Some((first, others)) = point.split_first() else { continue };
            let is_shared = |node: &&usize| others.iter().all(|other| partners[other].contains(node));
            partners[first].iter().filter(is_shared).for_each(|node| is_first[*node] = true);
        }
        let mut is_in = is_first.clone();
        coupled().for_each(|[from, to]| is_in[to] |= is_first[from] && within(&assembled.nodes[to]));
        let unknowns: Vec<usize> = (0..n).filter(|&k| is_in[node(k)]).collect();
        let mut number = vec![None; n];
        unknowns.iter().enumerate().for_each(|(k, &n)| number[n] = Some(k));
        Self { unknowns, number }
    }

    /// What of its unknowns the displacement along `direction` by `functions` of `body` consists of.
    fn row(
        &self,
        body: &dyn FieldBody,
        functions: &[(u32, f64)],
        direction: &Vector3<f64>,
    ) -> Vec<(usize, f64)> {
        let components = functions.iter().flat_map(|&(node, value)| (0..3).map(move |c| (node, c, value)));
        let of = |(node, c, value): (u32, usize, f64)| {
            Some((self.number[body.lookup().number(node, c)?]?, value * direction[c]))
        };
        components.filter_map(of).collect()
    }

    /// Displacements of its unknowns under `load` where those about it are held `at`.
    fn displacements(
        &self,
        assembled: &AssembledBody,
        load: Mat<f64>,
        at: impl Fn(&[f64; 3]) -> Vector3<f64>,
    ) -> Option<Mat<f64>> {
        let (n, mut rhs) = (self.unknowns.len(), load);
        let held = |k: usize| {
            let dof = &assembled.dofs[k];
            at(&assembled.nodes[dof.node as usize])[dof.component as usize]
        };
        let (matrix, mut entries) = (&assembled.stiffness, Vec::new());
        for j in 0..self.number.len() {
            for (&i, &value) in matrix.row_idx_of_col_raw(j).iter().zip(matrix.val_of_col(j)) {
                let i = i as usize;
                match (self.number[i], self.number[j]) {
                    (Some(a), Some(b)) => entries.push(Triplet::new(a.max(b), a.min(b), value)),
                    (Some(a), None) => rhs[(a, 0)] -= value * held(j),
                    (None, Some(b)) => rhs[(b, 0)] -= value * held(i),
                    (None, None) => {}
                }
            }
        }
        let stiffness = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &entries).ok()?;
        Some(stiffness.sp_cholesky(Side::Lower).ok()?.solve(&rhs))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::{Matrix2, Vector2};

    use super::*;

    const STEP: f64 = 1e-6;

    fn wedge(half_angle: f64, load: f64) -> Wedge {
        let axes = [Vector3::x(), -Vector3::y()];
        Wedge { origin: Vector3::zeros(), axes, half_angle, load, modulus: 2.0, poisson: 0.4, length: 1.0 }
    }

    /// Stress in the plane at `x`, from differences of the displacements (steps of 1e-6: 1e-9 of the truncation, 1e-10 of round-off).
    fn stress(wedge: &Wedge, x: [f64; 3]) -> Matrix2<f64> {
        let at = |d: usize, step: f64| {
            let mut x = x;
            x[d] += step;
            wedge.displacement(&x).xy()
        };
        let gradient = |d: usize| (at(d, STEP) - at(d, -STEP)) / (2.0 * STEP);
        let gradient = Matrix2::from_columns(&[gradient(0), gradient(1)]);
        let strain = 0.5 * (gradient + gradient.transpose());
        let (e, nu) = (wedge.modulus, wedge.poisson);
        e / (1.0 - nu * nu) * ((1.0 - nu) * strain + nu * strain.trace() * Matrix2::identity())
    }

    #[test]
    fn wedges_have_the_stress_of_michell_and_half_planes_that_of_flamant() {
        for (half_angle, load) in [(FRAC_PI_2, 0.0), (0.25 * PI, 0.0), (0.25 * PI, 0.3), (0.4, -0.2)] {
            let wedge = wedge(half_angle, load);
            let mut sum = Vector2::zeros();
            let n = 400;
            for k in 0..n {
                let angle = half_angle * (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0);
                let (r, out) = (0.3, Vector2::new(angle.sin(), -angle.cos()));
                let found = stress(&wedge, [r * out.x, r * out.y, 0.0]);
                // Nothing but a pressure along the radius, free faces among it.
                let along = load.cos() * angle.cos() / (half_angle + 0.5 * (2.0 * half_angle).sin());
                let across = load.sin() * angle.sin() / (half_angle - 0.5 * (2.0 * half_angle).sin());
                let right = -(along + across) / r * out * out.transpose();
                assert!((found - right).norm() < 1e-7, "{half_angle} {angle}: {found} {right}");
                sum += found * out * (r * 2.0 * half_angle / f64::from(n));
            }
            // A unit of load, by the rule of rectangles.
            assert!((sum + Vector2::new(load.sin(), -load.cos())).norm() < 1e-4, "{half_angle}: {sum}");
        }
    }

    #[test]
    fn an_even_load_indents_as_the_sum_of_its_parts() {
        let (plane, half, n) = (wedge(FRAC_PI_2, 0.0), 0.01, 2000);
        let parts = (0..n).map(|k| {
            let x = half * (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0);
            -plane.displacement(&[x, 0.0, 0.0]).y / f64::from(n)
        });
        // The logarithm in the parts next to the middle: their share of the load times ln 2.
        assert!((parts.sum::<f64>() / plane.depth(half) - 1.0).abs() < 1.0 / f64::from(n));
    }

    #[test]
    fn a_wedge_with_a_flat_tip_is_as_deep_as_elements_resolve_it() {
        // Depths, times the modulus, of the middle of an even load on a flat tip of the width 1/30, and their mean: 8,000 to 16,000 triangles of six
        // nodes in the wedge of radius one that is held there as this one is, 12 of them on half of the tip; Poisson's ratio 3/7.
        for (degrees, middle, mean) in
            [(30.0, 3.6798, 3.5835), (45.0, 3.0763, 2.9638), (60.0, 2.8497, 2.7296), (75.0, 2.7890, 2.6663)]
        {
            let wedge = Wedge { modulus: 1.0, poisson: 3.0 / 7.0, ..wedge(f64::to_radians(degrees), 0.0) };
            let found = wedge.depth(1.0 / 60.0);
            assert!(mean < found && found < middle, "{degrees}: {found}");
        }
    }
}
