//! The indentation right under a straight edge along a face that the elements of a body leave out
//! (docs/theory.md section C.26).

use std::f64::consts::{FRAC_PI_2, PI};

use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use ffr_dynamics::body::AssembledBody;
use iga_core::elasticity::Model;
use nalgebra::Vector3;

use super::{ContactZone, PointsAbout};
use crate::body::field_body::FieldBody;
use crate::surface::ALONG;

/// Share of the body's least extent beyond which displacements about the edge are those of the half-plane.
const WITHIN: f64 = 0.5;
/// Half of the width over which an edge presses, as a share of the body's least extent: that of one rounded by some hundredth of it.
const SPREAD: f64 = 1.0 / 300.0;

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

    /// Displacement at `x` (Eq. C.113).
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

    /// Depth of the middle of the face under a load that is spread evenly by `half` to both sides (Eq. C.114).
    fn depth(&self, half: f64) -> f64 {
        (2.0 * ((self.length / half).ln() + 1.0) - (1.0 + self.poisson)) / (PI * self.modulus)
    }
}

/// Compliances of the indentation that the elements of `body` leave out at the points of `zone` that meet the straight edge or, in the plane,
/// the corner of the target `about` their place [m/N] (Eq. C.112); empty where these lie on no one face of the body.
pub fn left_out(body: &dyn FieldBody, zone: &ContactZone, about: &PointsAbout) -> Vec<f64> {
    found(body, zone, about).unwrap_or_default()
}

/// From the middle to the end of the line along which the edge or, in the plane, the corner of the target `about` a place presses a face of
/// `body`, in the components of its model \[m\]; none where it presses at a point, and near an axis of symmetry.
fn pressed_line(body: &dyn FieldBody, about: &PointsAbout) -> Option<Vector3<f64>> {
    let (model, place) = (body.model(), about.place.point);
    if model.dimension() == 3 {
        return about.edge().map(|edge| edge.half);
    }
    let normals = body.undeformed().normals_at(&place);
    let is_smooth = normals.iter().all(|normal| normal.dot(&normals[0]) > ALONG);
    let is_near_axis = *model == Model::Axisymmetric && place[0] <= WITHIN * body.thickness();
    // Out of the plane.
    (about.meets.is_some() && is_smooth && !is_near_axis).then(|| 0.5 * model.measure(&place) * Vector3::z())
}

/// Half of the width over which that edge or corner presses the face (Eq. C.98) \[m\]; none where it presses at a point.
pub fn spread(body: &dyn FieldBody, about: &PointsAbout) -> Option<f64> {
    pressed_line(body, about).map(|_| SPREAD * body.thickness())
}

fn found(body: &dyn FieldBody, zone: &ContactZone, about: &PointsAbout) -> Option<Vec<f64>> {
    let origin = Vector3::from(about.place.point);
    let points = || zone.meeting.iter().map(|(i, _)| &zone.points[*i]);
    let inwards = -Vector3::from(points().next()?.facing?);
    let half = pressed_line(body, about)?;
    let plane = HalfPlane::new(body, origin, [inwards.cross(&half).try_normalize(0.0)?, inwards])?;
    let (whole, length) = (plane.depth(SPREAD * plane.length), 2.0 * half.norm());
    let total: f64 = points().map(|p| p.area).sum();
    let lengths: Vec<f64> = points().map(|p| length * p.area / total).collect();
    let patch = Patch::new(body.assembled(), points().flat_map(|p| p.functions.iter().map(|f| f.0)), |x| {
        plane.distance(x) <= WITHIN * plane.length
    });
    let rows: Vec<Vec<(usize, f64)>> = points().map(|p| patch.row(body, &p.functions, &inwards)).collect();
    let mut load = Mat::<f64>::zeros(patch.unknowns.len(), 1);
    for (row, length) in rows.iter().zip(&lengths) {
        row.iter().for_each(|(k, value)| load[(*k, 0)] += length * value);
    }
    let found = patch.displacements(body.assembled(), load, |x| plane.displacement(x))?;
    let depths = rows.iter().map(|row| row.iter().map(|(k, value)| value * found[(*k, 0)]).sum::<f64>());
    Some(depths.zip(&lengths).map(|(depth, length)| (whole - depth).max(0.0) / length).collect())
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
