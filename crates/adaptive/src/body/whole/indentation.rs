//! The indentation right under a straight edge along a face that the elements of a body leave out
//! (docs/theory.md section C.19).

use std::f64::consts::{FRAC_PI_2, PI};

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use ffr_dynamics::body::AssembledBody;
use iga_core::elasticity::Model;
use nalgebra::Vector3;

use crate::body::field_body::FieldBody;
use crate::body::zone::{ContactZone, PointsAbout};
use crate::surface::ALONG;

/// Share of the body's least extent beyond which displacements about the edge are those of the half-plane.
const WITHIN: f64 = 0.5;
/// A half-plane under a unit line load [m per N/m].
struct HalfPlane {
    /// A place on the line \[m\].
    origin: Vector3<f64>,
    /// Unit vectors across the line and into the body.
    axes: [Vector3<f64>; 2],
    /// Elastic modulus \[Pa\] and Poisson's ratio of the plane.
    modulus: f64,
    poisson: f64,
    /// Length at which the logarithm is zero: the least extent of the body \[m\].
    length: f64,
}

impl HalfPlane {
    /// That of the material of `body`; none without one.
    fn new(body: &dyn FieldBody, origin: Vector3<f64>, axes: [Vector3<f64>; 2]) -> Option<Self> {
        let (lambda, shear) = body.model().lame(body.slowest_material()?);
        // Of the stress in the plane, whatever is across it.
        let poisson = lambda / (lambda + 2.0 * shear);
        Some(Self { origin, axes, modulus: 2.0 * shear * (1.0 + poisson), poisson, length: body.thickness() })
    }

    /// Ways of `x` across the line and into the body \[m\].
    fn ways(&self, x: &[f64; 3]) -> [f64; 2] {
        let from = Vector3::from(*x) - self.origin;
        self.axes.map(|axis| from.dot(&axis))
    }

    /// Distance of `x` from the line \[m\].
    fn distance(&self, x: &[f64; 3]) -> f64 {
        let [aside, depth] = self.ways(x);
        aside.hypot(depth)
    }

    /// Displacement at `x` (theory section C.19).
    fn displacement(&self, x: &[f64; 3]) -> Vector3<f64> {
        let [aside, depth] = self.ways(x);
        // Nodes of sides that are not plane to the last digit do not lie above the face.
        let angle = aside.atan2(depth).clamp(-FRAC_PI_2, FRAC_PI_2);
        let log = (aside.hypot(depth) / self.length).ln();
        let (sin, cos) = angle.sin_cos();
        let (once, twice) = (1.0 / (PI * self.modulus), 2.0 / (PI * self.modulus));
        let turn = once * (1.0 - self.poisson) * angle;
        let radial = -twice * cos * log - turn * sin;
        let around = sin * (twice * log + once * (1.0 + self.poisson)) - turn * cos;
        self.axes[0] * (radial * sin + around * cos) + self.axes[1] * (radial * cos - around * sin)
    }

    /// Depth of the middle of the face under a load that is spread evenly by `half` to both sides (theory section C.19).
    fn depth(&self, half: f64) -> f64 {
        (2.0 * ((self.length / half).ln() + 1.0) - (1.0 + self.poisson)) / (PI * self.modulus)
    }
}

/// A line along which a face of a body is pressed, in the components of its model.
pub struct PressedLine {
    /// Its middle \[m\].
    pub middle: Vector3<f64>,
    /// From there to its end, out of the plane of a plane model \[m\].
    pub half: Vector3<f64>,
    /// Unit vector into the body.
    pub inwards: Vector3<f64>,
    /// Half of the width over which the face is pressed \[m\].
    pub spread: f64,
}

/// A point on such a line: its functions with their values, and the length of the line that is its own \[m\].
pub type LinePoint<'a> = (&'a [(u32, f64)], f64);

impl PressedLine {
    /// That along which the edge, the line or, in the plane, the corner of the target presses `body` `about` a place, across a face with the
    /// outward normal `outward`; none where it presses at a point, and near an axis of symmetry.
    pub fn new(body: &dyn FieldBody, about: &PointsAbout, outward: &[f64; 3]) -> Option<Self> {
        let (half, meets) = (pressed_half(body, about)?, about.meets?);
        let (middle, inwards) = (about.place.point.into(), -Vector3::from(*outward));
        (meets.spread > 0.0).then_some(Self { middle, half, inwards, spread: meets.spread })
    }

    /// Compliances of the indentation that the elements of `body` leave out at `points` [m/N] (Eq. C.101); none without a material.
    pub fn left_out(&self, body: &dyn FieldBody, points: &[LinePoint<'_>]) -> Option<Vec<f64>> {
        let across = self.inwards.cross(&self.half).try_normalize(0.0)?;
        let plane = HalfPlane::new(body, self.middle, [across, self.inwards])?;
        let nodes = points.iter().flat_map(|(functions, _)| functions.iter().map(|f| f.0));
        let patch = Patch::new(body.assembled(), nodes, |x| plane.distance(x) <= WITHIN * plane.length);
        let rows: Vec<Vec<(usize, f64)>> =
            points.iter().map(|p| patch.row(body, p.0, &self.inwards)).collect();
        let mut load = Mat::<f64>::zeros(patch.unknowns.len(), 1);
        for (row, (_, length)) in rows.iter().zip(points) {
            row.iter().for_each(|(k, value)| load[(*k, 0)] += length * value);
        }
        let found = patch.displacements(body.assembled(), load, |x| plane.displacement(x))?;
        let depths = rows.iter().map(|row| row.iter().map(|(k, value)| value * found[(*k, 0)]).sum::<f64>());
        let whole = plane.depth(self.spread);
        Some(depths.zip(points).map(|(depth, (_, length))| (whole - depth).max(0.0) / length).collect())
    }
}

/// From the middle to the end of the line that is pressed `about` a place of `body`.
fn pressed_half(body: &dyn FieldBody, about: &PointsAbout) -> Option<Vector3<f64>> {
    let (model, place) = (body.model(), about.place.point);
    if model.dimension() == 3 {
        return about.edge().map(|edge| edge.half);
    }
    let normals = body.undeformed().normals_at(&place);
    let is_smooth = normals.iter().all(|normal| normal.dot(&normals[0]) > ALONG);
    let is_near_axis = *model == Model::Axisymmetric && place[0] <= WITHIN * body.thickness();
    (is_smooth && !is_near_axis).then(|| 0.5 * model.measure(&place) * Vector3::z())
}

/// Width over which a face of `body` is pressed `about` a place \[m\]; none where it is pressed at a point.
pub fn pressed_width(body: &dyn FieldBody, about: &PointsAbout) -> Option<f64> {
    pressed_half(body, about).and_then(|_| Some(2.0 * about.meets?.spread))
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

    /// Adds what the elements of `body`, on whose surface the zone lies, leave out of the indentation `about` its place.
    pub fn add_left_out(&mut self, body: &dyn FieldBody, about: &PointsAbout) {
        let facing = self.meeting.first().and_then(|(i, _)| self.points[*i].facing);
        let Some(line) = facing.and_then(|facing| PressedLine::new(body, about, &facing)) else { return };
        let lengths = self.lengths_of_meeting(&line.half);
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
    /// The unknowns of the nodes `of` and those coupled with them that lie `within`.
    fn new(
        assembled: &AssembledBody,
        of: impl Iterator<Item = u32>,
        within: impl Fn(&[f64; 3]) -> bool,
    ) -> Self {
        let mut is_first = vec![false; assembled.nodes.len()];
        of.for_each(|node| is_first[node as usize] = true);
        let mut is_in = is_first.clone();
        let node = |k: usize| assembled.dofs[k].node as usize;
        let (symbolic, n) = (assembled.stiffness.symbolic(), assembled.dofs.len());
        for j in 0..n {
            for &i in symbolic.row_idx_of_col_raw(j) {
                let pair = [node(j), node(i as usize)];
                for (from, to) in [(pair[0], pair[1]), (pair[1], pair[0])] {
                    is_in[to] |= is_first[from] && within(&assembled.nodes[to]);
                }
            }
        }
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
    use nalgebra::{Matrix2, Vector2};

    use super::*;

    const STEP: f64 = 1e-6;

    fn plane() -> HalfPlane {
        let axes = [Vector3::x(), -Vector3::y()];
        HalfPlane { origin: Vector3::zeros(), axes, modulus: 2.0, poisson: 0.4, length: 1.0 }
    }

    /// Stress in the plane at `x`, from differences of the displacements (steps of 1e-6: 1e-9 of the truncation, 1e-10 of round-off).
    fn stress(plane: &HalfPlane, x: [f64; 3]) -> Matrix2<f64> {
        let at = |d: usize, step: f64| {
            let mut x = x;
            x[d] += step;
            plane.displacement(&x).xy()
        };
        let gradient = |d: usize| (at(d, STEP) - at(d, -STEP)) / (2.0 * STEP);
        let gradient = Matrix2::from_columns(&[gradient(0), gradient(1)]);
        let strain = 0.5 * (gradient + gradient.transpose());
        let (e, nu) = (plane.modulus, plane.poisson);
        e / (1.0 - nu * nu) * ((1.0 - nu) * strain + nu * strain.trace() * Matrix2::identity())
    }

    #[test]
    fn the_half_plane_has_boussinesqs_stress() {
        let plane = plane();
        let mut sum = Vector2::zeros();
        let n = 200;
        for k in 0..n {
            let angle = PI * ((f64::from(k) + 0.5) / f64::from(n) - 0.5);
            let (r, out) = (0.3, Vector2::new(angle.sin(), -angle.cos()));
            let found = stress(&plane, [r * out.x, r * out.y, 0.0]);
            // Nothing but 2 cos(angle) / (pi r) of pressure along the radius.
            let right = -2.0 * angle.cos() / (PI * r) * out * out.transpose();
            assert!((found - right).norm() < 1e-8, "{angle}: {found} {right}");
            sum += found * out * (r * PI / f64::from(n));
        }
        // A unit of load, by the rule of rectangles on a period.
        assert!((sum - Vector2::new(0.0, 1.0)).norm() < 1e-4, "{sum}");
    }

    #[test]
    fn an_even_load_indents_as_the_sum_of_its_parts() {
        let (plane, half, n) = (plane(), 0.01, 2000);
        let parts = (0..n).map(|k| {
            let x = half * (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0);
            -plane.displacement(&[x, 0.0, 0.0]).y / f64::from(n)
        });
        // The logarithm in the parts next to the middle: their share of the load times ln 2.
        assert!((parts.sum::<f64>() / plane.depth(half) - 1.0).abs() < 1.0 / f64::from(n));
    }
}
