//! Planes, spheres, cylinders, cones and tori through the nodes of a part of a mesh (docs/theory.md
//! Eqs. C.107, C.108, C.113).

use nalgebra::{DMatrix, DVector, Matrix3, SVector, SymmetricEigen, Vector3};

use super::LocalShape;

/// Ratio of singular values below which places do not tell unknowns apart.
const SINGULAR: f64 = 1e-10;
/// Steps of Gauss's and Newton's method at most: where places have no misfit it converges like Newton's.
const STEPS: usize = 30;
/// Step in units of the part's size, below which the method has converged.
const CONVERGED: f64 = 1e-13;
/// Distance of nodes from the surface, as a share of their heights over the plane that
/// touches it, up to which it is taken to be that of the part: curvature is then off by eight times
/// as much at most, and the force by a fifth of that. With nodes on a sphere, half its radius away,
/// the share is 3e-4; where curvature jumps between them, some percent.
pub const MISFIT: f64 = 2e-3;
/// Coefficients of the equation of a cyclide.
const CYCLIDE: usize = 14;

/// A surface of one of the simple shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primitive {
    shape: Shape,
    /// 1 if outside of the shape is outside of the body, else -1.
    sign: f64,
}

/// The shapes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// Through a point with a unit normal.
    Plane { point: Vector3<f64>, normal: Vector3<f64> },
    /// A sphere; of a curve a circle.
    Sphere { centre: Vector3<f64>, radius: f64 },
    /// About an axis through a point, where the radius is given, which grows by `slope` along it: a cylinder
    /// without it.
    Cone { point: Vector3<f64>, axis: Vector3<f64>, radius: f64, slope: f64 },
    /// About the axis through its centre: places as far from a circle as `tube`.
    Torus { point: Vector3<f64>, axis: Vector3<f64>, radius: f64, tube: f64 },
}

impl Shape {
    /// Distance of `x` from it, negative inside, and its gradient.
    fn distance(&self, x: &Vector3<f64>) -> (f64, Vector3<f64>) {
        match self {
            Self::Plane { point, normal } => ((x - point).dot(normal), *normal),
            Self::Sphere { centre, radius } => {
                let from = x - centre;
                (from.norm() - radius, from.try_normalize(0.0).unwrap_or_default())
            }
            Self::Cone { point, axis, radius, slope } => {
                let along = (x - point).dot(axis);
                let across = x - point - along * axis;
                let scale = 1.0 / 1.0_f64.hypot(*slope);
                let away = across.try_normalize(0.0).unwrap_or_default();
                (scale * (across.norm() - radius - slope * along), scale * (away - *slope * axis))
            }
            Self::Torus { point, axis, radius, tube } => {
                let along = (x - point).dot(axis);
                let across = x - point - along * axis;
                let away = across.try_normalize(0.0).unwrap_or_default();
                let from = across - *radius * away + along * axis;
                (from.norm() - tube, from.try_normalize(0.0).unwrap_or_default())
            }
        }
    }

    /// Rates of the distance of `x` with what [`Self::moved`] changes (theory Eqs. C.108, C.113).
    fn rates(&self, x: &Vector3<f64>) -> SVector<f64, 7> {
        let (distance, gradient) = self.distance(x);
        let (Self::Cone { point, axis, .. } | Self::Torus { point, axis, .. }) = self else {
            return SVector::zeros();
        };
        let [u, v] = tangents(axis);
        let along = (x - point).dot(axis);
        let across = x - point - along * axis;
        let out = across.try_normalize(0.0).unwrap_or_default();
        let (turn, size, last, lift) = match self {
            Self::Cone { slope, .. } => {
                let scale = 1.0 / 1.0_f64.hypot(*slope);
                let turn = -scale * (along + slope * across.norm());
                (turn, -scale, -scale * (along + scale * slope * distance), 0.0)
            }
            Self::Torus { radius, tube, .. } => {
                (along * radius / (distance + tube), -gradient.dot(&out), -1.0, -gradient.dot(axis))
            }
            _ => (0.0, 0.0, 0.0, 0.0),
        };
        let [p, q] = [out.dot(&u), out.dot(&v)];
        [-gradient.dot(&u), -gradient.dot(&v), turn * p, turn * q, size, last, lift].into()
    }

    /// The same moved across its axis, turned, and of another radius, another slope or tube, and moved along the axis.
    fn moved(self, step: &SVector<f64, 7>) -> Self {
        let change = |point: Vector3<f64>, axis: Vector3<f64>| {
            let [u, v] = tangents(&axis);
            let moved = point + step[0] * u + step[1] * v + step[6] * axis;
            (moved, (axis + step[2] * u + step[3] * v).normalize())
        };
        match self {
            Self::Cone { point, axis, radius, slope } => {
                let (point, axis) = change(point, axis);
                Self::Cone { point, axis, radius: radius + step[4], slope: slope + step[5] }
            }
            Self::Torus { point, axis, radius, tube } => {
                let (point, axis) = change(point, axis);
                Self::Torus { point, axis, radius: radius + step[4], tube: tube + step[5] }
            }
            other => other,
        }
    }

    /// The one nearby of the least mean square of distances, the first `n` unknowns free, by Gauss's and Newton's method.
    fn settled(mut self, places: &[[Vector3<f64>; 2]], n: usize) -> Option<Self> {
        for _ in 0..STEPS {
            let rows: Vec<_> = places.iter().map(|[x, _]| self.rates(x)).collect();
            let matrix = DMatrix::from_fn(places.len(), n, |i, j| rows[i][j]);
            let misfits = DVector::from_fn(places.len(), |i, _| -self.distance(&places[i][0]).0);
            let found = solved(matrix, &misfits)?;
            let step = SVector::from_fn(|j, _| found.get(j).copied().unwrap_or(0.0));
            self = self.moved(&step);
            if step.norm() <= CONVERGED {
                break;
            }
        }
        self.distance(&places[0][0]).0.is_finite().then_some(self)
    }

    /// The same in metres of one in units of `size` about `middle`.
    fn scaled(self, size: f64, middle: &Vector3<f64>) -> Self {
        let place = |x: Vector3<f64>| middle + size * x;
        match self {
            Self::Plane { point, normal } => Self::Plane { point: place(point), normal },
            Self::Sphere { centre, radius } => Self::Sphere { centre: place(centre), radius: size * radius },
            Self::Cone { point, axis, radius, slope } => {
                Self::Cone { point: place(point), axis, radius: size * radius, slope }
            }
            Self::Torus { point, axis, radius, tube } => {
                Self::Torus { point: place(point), axis, radius: size * radius, tube: size * tube }
            }
        }
    }
}

impl Primitive {
    /// The simplest surface that misses none of `places` by more than `misfit` \[m\], each given with an outward normal of
    /// the mesh there, which need not be exact. Coordinates beyond `dimension` are zero.
    pub fn through(places: &[[Vector3<f64>; 2]], dimension: usize, misfit: f64) -> Option<Self> {
        let middle = places.iter().map(|[x, _]| x).sum::<Vector3<f64>>() / places.len() as f64;
        let size = places.iter().map(|[x, _]| (x - middle).norm()).fold(0.0, f64::max);
        let local: Vec<[Vector3<f64>; 2]> = places.iter().map(|[x, n]| [(x - middle) / size, *n]).collect();
        let is_on = |shape: &Shape| local.iter().all(|[x, _]| shape.distance(x).0.abs() * size <= misfit);
        let flat = || plane(&local, dimension).into_iter().chain(sphere(&local, dimension));
        let round =
            || [false, true].into_iter().filter_map(|is_cone| cone(&local, is_cone)).chain(torus(&local));
        let solid = dimension == 3;
        let shape = flat().find(is_on).or_else(|| round().find(|shape| solid && is_on(shape)))?;
        let turned: f64 = local.iter().map(|[x, n]| shape.distance(x).1.dot(n)).sum();
        Some(Self { shape: shape.scaled(size, &middle), sign: turned.signum() })
    }

    /// Whether it is a plane.
    pub fn is_plane(&self) -> bool {
        matches!(self.shape, Shape::Plane { .. })
    }

    /// The place of it nearest to `x` \[m\].
    pub fn onto(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let (height, outward) = self.height(x);
        x - height * outward
    }

    /// Its shape at `x`; `along`: a direction for one that has no curvature, or the same in all directions.
    pub fn shape(&self, x: &Vector3<f64>, along: &Vector3<f64>) -> Option<LocalShape> {
        let normal = self.height(x).1;
        let tangent = || (along - along.dot(&normal) * normal).try_normalize(0.0);
        let (across, curved, other) = match self.shape {
            Shape::Plane { .. } => (tangent()?, 0.0, 0.0),
            Shape::Sphere { radius, .. } => (tangent()?, self.sign / radius, self.sign / radius),
            Shape::Cone { point, axis, slope, .. } => {
                let from = self.onto(x) - point;
                let away = from - from.dot(&axis) * axis;
                (
                    axis.cross(&normal).try_normalize(0.0)?,
                    self.sign / (away.norm() * 1.0_f64.hypot(slope)),
                    0.0,
                )
            }
            Shape::Torus { point, axis, tube, .. } => {
                let from = x - point;
                let out = (from - from.dot(&axis) * axis).try_normalize(0.0)?;
                let from_axis = (self.onto(x) - point).dot(&out);
                (axis.cross(&out).cross(&normal), self.sign / tube, normal.dot(&out) / from_axis)
            }
        };
        let (direction, curvatures) =
            if curved < other { (normal.cross(&across), [other, curved]) } else { (across, [curved, other]) };
        Some(LocalShape { curvatures, direction, tangents: [direction, normal.cross(&direction)], normal })
    }

    /// Height of `x` over it, towards the outside of the body, and the outward unit normal \[m\].
    pub fn height(&self, x: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (distance, gradient) = self.shape.distance(x);
        (self.sign * distance, self.sign * gradient)
    }
}

/// The plane, in the plane the line, of the least mean square of distances.
fn plane(places: &[[Vector3<f64>; 2]], dimension: usize) -> Option<Shape> {
    let spread: Matrix3<f64> = places.iter().map(|[x, _]| x * x.transpose()).sum();
    let SymmetricEigen { eigenvalues, eigenvectors } = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigenvalues[*a].total_cmp(&eigenvalues[*b]));
    let along: Vector3<f64> = eigenvectors.column(order[2]).into();
    let normal =
        if dimension == 2 { along.cross(&Vector3::z()) } else { eigenvectors.column(order[0]).into() };
    let is_told = dimension == 2 || eigenvalues[order[1]] > SINGULAR * eigenvalues[order[2]];
    is_told.then(|| Shape::Plane { point: Vector3::zeros(), normal })
}

/// The sphere `|x|² = 2 c·x + q` of the least mean square of this equation's error; none if there are no more places than unknowns.
fn sphere(places: &[[Vector3<f64>; 2]], dimension: usize) -> Option<Shape> {
    if places.len() <= dimension + 1 {
        return None;
    }
    let entry = |i: usize, j: usize| if j < dimension { 2.0 * places[i][0][j] } else { 1.0 };
    let squares = DVector::from_fn(places.len(), |i, _| places[i][0].norm_squared());
    let found = solved(DMatrix::from_fn(places.len(), dimension + 1, entry), &squares)?;
    let mut centre = Vector3::zeros();
    centre.iter_mut().zip(found.iter().take(dimension)).for_each(|(c, found)| *c = *found);
    Some(Shape::Sphere { centre, radius: (found[dimension] + centre.norm_squared()).max(0.0).sqrt() })
}

/// The cylinder, or the cone, of the least mean square of distances, from the direction in which normals change least; none if
/// there are no more places than it has unknowns (theory Eq. C.108).
fn cone(places: &[[Vector3<f64>; 2]], is_cone: bool) -> Option<Shape> {
    let n_unknowns = if is_cone { 6 } else { 5 };
    if places.len() <= n_unknowns {
        return None;
    }
    let mean = places.iter().map(|[_, n]| n).sum::<Vector3<f64>>() / places.len() as f64;
    let from = if is_cone { mean } else { Vector3::zeros() };
    let spread: Matrix3<f64> = places.iter().map(|[_, n]| (n - from) * (n - from).transpose()).sum();
    let SymmetricEigen { eigenvalues, eigenvectors } = spread.symmetric_eigen();
    let axis: Vector3<f64> = eigenvectors.column(eigenvalues.imin()).into();
    let across: Vec<[Vector3<f64>; 2]> = places.iter().map(|[x, n]| [x - x.dot(&axis) * axis, *n]).collect();
    // The circle of all places along the axis; coordinates across it are independent.
    let [u, v] = tangents(&axis);
    let in_plane = across.iter().map(|[x, n]| [Vector3::new(x.dot(&u), x.dot(&v), 0.0), *n]);
    let Shape::Sphere { centre, radius } = sphere(&in_plane.collect::<Vec<_>>(), 2)? else { return None };
    let first = Shape::Cone { point: centre[0] * u + centre[1] * v, axis, radius, slope: 0.0 };
    first.settled(places, n_unknowns)
}

/// The torus on which `places` lie: of the cyclide through them, whose equation is linear in its coefficients, settled (theory Eq. C.113).
fn torus(places: &[[Vector3<f64>; 2]]) -> Option<Shape> {
    let terms = |x: &Vector3<f64>| -> [f64; CYCLIDE] {
        let (square, [x, y, z]) = (x.norm_squared(), [x[0], x[1], x[2]]);
        let quadratic = [x * x, y * y, z * z, 2.0 * x * y, 2.0 * y * z, 2.0 * x * z];
        let [a, b, c, d, e, f] = quadratic;
        [square * square, square * x, square * y, square * z, a, b, c, d, e, f, x, y, z, 1.0]
    };
    let rows: Vec<_> = places.iter().map(|[x, _]| terms(x)).collect();
    if rows.len() < CYCLIDE {
        return None;
    }
    let svd = DMatrix::from_fn(rows.len(), CYCLIDE, |i, j| rows[i][j]).svd(false, true);
    // Of two cyclides through all places neither need be a torus.
    let is_one = svd.singular_values[CYCLIDE - 2] > SINGULAR * svd.singular_values[0];
    let all = svd.v_t?;
    let found = all.row(CYCLIDE - 1);
    if !is_one || found[0].abs() <= SINGULAR {
        return None;
    }
    let k = |i: usize| found[i] / found[0];
    let point = -0.25 * Vector3::new(k(1), k(2), k(3));
    let quadratic = Matrix3::new(k(4), k(7), k(9), k(7), k(5), k(8), k(9), k(8), k(6));
    let about =
        quadratic - 4.0 * point * point.transpose() - 2.0 * point.norm_squared() * Matrix3::identity();
    let SymmetricEigen { eigenvalues, eigenvectors } = about.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigenvalues[*a].total_cmp(&eigenvalues[*b]));
    let [low, middle, high] = order.map(|i| eigenvalues[i]);
    // The eigenvalue of the axis is the one apart.
    let (of_axis, apart, two) = if high - middle > middle - low {
        (order[2], high, low + middle)
    } else {
        (order[0], low, middle + high)
    };
    let square = 0.25 * (apart - 0.5 * two);
    let (radius, tube) = (square.sqrt(), (-0.25 * two - square).sqrt());
    let axis = eigenvectors.column(of_axis).into();
    let is_torus = radius.is_finite() && tube.is_finite();
    is_torus.then_some(Shape::Torus { point, axis, radius, tube })?.settled(places, 7)
}

/// Two unit vectors across `axis` and each other.
fn tangents(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let u = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
    [u, axis.cross(&u)]
}

/// The solution of least squares; none if the matrix does not tell the unknowns apart.
fn solved(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let svd = matrix.svd(true, true);
    let [least, most] = [svd.singular_values.min(), svd.singular_values.max()];
    (least > SINGULAR * most).then(|| svd.solve(right, 0.0).ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Places on a surface, turned and shifted, with their normals; `of` gives both in its own axes.
    fn places(of: impl Fn(f64, f64) -> [[f64; 3]; 2]) -> Vec<[Vector3<f64>; 2]> {
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1);
        let grid = (0..5).flat_map(|i| (0..4).map(move |j| [f64::from(i) / 4.0, f64::from(j) / 3.0]));
        let place = |[u, v]: [f64; 2]| {
            let [x, n] = of(u, v).map(Vector3::from);
            [turn * x + Vector3::new(0.02, -0.01, 0.05), turn * n.normalize()]
        };
        grid.map(place).collect()
    }

    /// A part of a cone, a cylinder without `slope`, seen from inside if `is_hollow`.
    fn round(slope: f64, is_hollow: bool) -> impl Fn(f64, f64) -> [[f64; 3]; 2] {
        move |u, v| {
            let (angle, z) = (0.8 * PI * u, 0.02 * v);
            let (radius, sign) = (0.024 + slope * z, if is_hollow { -1.0 } else { 1.0 });
            let (c, s) = (angle.cos(), angle.sin());
            [[radius * c, radius * s, z], [sign * c, sign * s, -sign * slope]]
        }
    }

    /// A part of a torus of the radii 0.03 and 0.008, not in rows and columns, which would lie on other cyclides, too.
    fn ring(u: f64, v: f64) -> [[f64; 3]; 2] {
        let (angle, tube) = (1.2 * u, 2.0 * v + 0.7 * u * u - 0.5);
        let n = [tube.cos() * angle.cos(), tube.cos() * angle.sin(), tube.sin()];
        [[0.03 * angle.cos() + 0.008 * n[0], 0.03 * angle.sin() + 0.008 * n[1], 0.008 * n[2]], n]
    }

    #[test]
    fn a_torus_is_curved_along_its_tube_and_about_its_axis() {
        // Inside of it, from where it is seen, is hollow: curvatures have the other sign.
        for sign in [1.0, -1.0] {
            let seen = |u, v| {
                let [x, n] = ring(u, v);
                [x, n.map(|n| sign * n)]
            };
            let places = places(seen);
            let found = Primitive::through(&places, 3, 1e-9).unwrap();
            for (k, [x, n]) in places.iter().enumerate() {
                let (u, v) = ((k / 4) as f64 / 4.0, (k % 4) as f64 / 3.0);
                let (angle, tube) = (1.2 * u, 2.0 * v + 0.7 * u * u - 0.5);
                let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1);
                let around = turn * Vector3::new(-angle.sin(), angle.cos(), 0.0);
                let shape = found.shape(x, &Vector3::x()).unwrap();
                let [along, about] =
                    [1.0 / 0.008, tube.cos() / (0.03 + 0.008 * tube.cos())].map(|k| sign * k);
                let wanted = [along.max(about), along.min(about)];
                // Places of 0.05 m are known to 1e-17 m, and their heights of 1 mm to 1e-14 of them.
                assert!(shape.curvatures.iter().zip(wanted).all(|(k, w)| (k - w).abs() < 1e-9 / 0.008));
                let direction = if along > about { n.cross(&around) } else { around };
                assert!(
                    (shape.direction.dot(&direction).abs() - 1.0).abs() < 1e-10
                        && (shape.normal - n).norm() < 1e-9
                );
            }
        }
    }

    #[test]
    fn shapes_are_told_by_places_on_them() {
        let sphere = |u: f64, v: f64| {
            let (angle, z) = (1.5 * u, 0.3 * v);
            let c: f64 = 1.0 - z * z;
            let n = [c.sqrt() * angle.cos(), c.sqrt() * angle.sin(), z];
            [n.map(|x| 0.03 * x), n]
        };
        let plane = |u: f64, v: f64| [[0.01 * u, 0.02 * v, 0.0], [0.0, 0.0, 1.0]];
        let round = [places(round(0.0, true)), places(round(0.3, false)), places(ring)];
        let all = [places(plane), places(sphere)].into_iter().chain(round).collect::<Vec<_>>();
        for (k, places) in all.iter().enumerate() {
            // Normals of sides are off by some degrees.
            let mut rough = places.clone();
            rough.iter_mut().enumerate().for_each(|(i, [_, n])| {
                *n = (*n
                    + 0.05 * Vector3::new((i as f64).sin(), (2.0 * i as f64).cos(), (3.0 * i as f64).sin()))
                .normalize();
            });
            let found = Primitive::through(&rough, 3, 1e-9).unwrap();
            let kind = match found.shape {
                Shape::Plane { .. } => 0,
                Shape::Sphere { radius, .. } => {
                    // Round-off of coordinates of 0.05 m over the sagitta.
                    assert!((radius - 0.03).abs() < 1e-12, "{radius}");
                    1
                }
                Shape::Cone { slope: 0.0, radius, .. } => {
                    assert!((radius - 0.024).abs() < 1e-12, "{radius}");
                    2
                }
                Shape::Cone { .. } => 3,
                Shape::Torus { radius, tube, .. } => {
                    // Of two radii that places 20 mm apart tell.
                    assert!((radius - 0.03).abs() < 1e-11 && (tube - 0.008).abs() < 1e-11, "{radius} {tube}");
                    4
                }
            };
            assert_eq!(kind, k);
            for [x, n] in places {
                let lifted = x + 1e-3 * n;
                let (height, outward) = found.height(&lifted);
                assert!((height - 1e-3).abs() < 1e-11, "{k}: {height}");
                assert!((outward - n).norm() < 1e-9, "{k}: {outward} {n}");
            }
        }
    }

    #[test]
    fn what_lies_on_none_of_them_has_none() {
        let wave = |u: f64, v: f64| {
            let x = 0.01 * u;
            [[x, 0.02 * v, 1e-4 * (300.0 * x).sin()], [0.0, 0.0, 1.0]]
        };
        assert_eq!(Primitive::through(&places(wave), 3, 1e-9), None);
        let saddle = |u: f64, v: f64| {
            let (x, y) = (u - 0.5, v - 0.5);
            [[x, y, 0.1 * x * y], [-0.1 * y, -0.1 * x, 1.0]]
        };
        assert_eq!(Primitive::through(&places(saddle), 3, 1e-9), None);
    }

    #[test]
    fn a_curve_lies_on_a_circle_or_a_line() {
        let arc = |k: u32| {
            let angle = 0.2 * f64::from(k);
            let n = Vector3::new(angle.cos(), angle.sin(), 0.0);
            [Vector3::new(0.1, 0.0, 0.0) + 0.02 * n, -n]
        };
        let found = Primitive::through(&(0..7).map(arc).collect::<Vec<_>>(), 2, 1e-9).unwrap();
        let (height, outward) = found.height(&Vector3::new(0.119, 0.0, 0.0));
        assert!(
            (height - 1e-3).abs() < 1e-12 && (outward + Vector3::x()).norm() < 1e-9,
            "{height} {outward}"
        );
        let line = |k: u32| [Vector3::new(0.1 * f64::from(k), 0.0, 0.0), Vector3::y()];
        let found = Primitive::through(&(0..7).map(line).collect::<Vec<_>>(), 2, 1e-9).unwrap();
        assert!((found.height(&Vector3::new(0.3, 0.2, 0.0)).0 - 0.2).abs() < 1e-15);
    }
}
