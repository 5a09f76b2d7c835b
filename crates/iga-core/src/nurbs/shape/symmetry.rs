//! Rotations that leave a shape as it is, so that its parametrisation may be turned without
//! changing the body. An ellipsoid is a stretched ball: what turns the ball leaves it as it is too,
//! as a linear map that keeps volumes, not lengths (theory Eq. A.16).

use crate::nurbs::jet::{cross, dot, norm};

/// Angle between a point and the nearest regular direction up to which the parametrisation serves
/// as it is: singular lines are 45° away from these directions.
const NEAR: f64 = 20.0;

/// Maps (rows) about the origin that leave a shape as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Symmetry {
    /// Axis of the rotations; `None`: all axes.
    axis: Option<[f64; 3]>,
    /// Unit vectors from the origin, or from the axis, around which the parametrisation is regular
    /// and smooth; of an ellipsoid in its ball.
    regular: Vec<[f64; 3]>,
    /// Semi-axes of an ellipsoid, by which its ball is stretched; `None` where the maps are
    /// rotations.
    stretch: Option<[f64; 3]>,
}

impl Symmetry {
    /// A ball centred at the origin, regular around the given directions.
    pub fn ball(regular: &[[f64; 3]]) -> Self {
        Self { axis: None, regular: regular.to_vec(), stretch: None }
    }

    /// An ellipsoid centred at the origin with `semi_axes` along the axes, the image of a ball that
    /// is regular around the given directions, which are along the axes, as the parametrisation is
    /// there.
    pub fn ellipsoid(semi_axes: [f64; 3], regular: &[[f64; 3]]) -> Self {
        Self { stretch: Some(semi_axes), ..Self::ball(regular) }
    }

    /// A body of revolution about the z axis, regular around the given directions.
    pub fn about_z(regular: &[[f64; 3]]) -> Self {
        Self { axis: Some([0.0, 0.0, 1.0]), regular: regular.to_vec(), stretch: None }
    }

    /// Axis of the rotations; `None`: all axes.
    pub fn axis(&self) -> Option<&[f64; 3]> {
        self.axis.as_ref()
    }

    /// Unit vectors from the origin, or from the axis, around which the parametrisation is regular
    /// and smooth.
    pub fn regular(&self) -> &[[f64; 3]] {
        &self.regular
    }

    /// Whether the shape may be turned about any axis.
    pub fn is_ball(&self) -> bool {
        self.axis.is_none() && self.stretch.is_none()
    }

    /// Semi-axes of an ellipsoid, whose maps are not rotations.
    pub fn stretch(&self) -> Option<&[f64; 3]> {
        self.stretch.as_ref()
    }

    /// The map (rows) that brings the nearest regular direction to the surface point `point` with
    /// outward normal `normal`: a rotation, of an ellipsoid `D Q D⁻¹` with one of its ball
    /// (Eq. A.16), after which the parametrisation at the point follows the principal curvatures.
    ///
    /// `None` if the parametrisation is regular around the point as it is, or turning it does not
    /// help, as on the flat ends of a cylinder.
    pub fn map_to(&self, point: &[f64; 3], normal: &[f64; 3]) -> Option<[[f64; 3]; 3]> {
        let Some(semi_axes) = &self.stretch else {
            let (direction, towards) = self.nearest_regular(point, normal)?;
            return is_far(&direction, &towards).then(|| rotation(&direction, &towards));
        };
        let in_ball = std::array::from_fn(|c| point[c] / semi_axes[c]);
        let (direction, towards) = self.nearest_regular(&in_ball, &in_ball)?;
        if !is_far(&direction, &towards) {
            return None;
        }
        let first = rotation(&direction, &towards);
        let turned = first.map(|row| dot(&row, &another_axis(&direction)));
        let angle = angle_about(&towards, &turned, &principal_direction(&towards, semi_axes));
        Some(self.stretched(&product(&rotation_about(&towards, angle), &first), 1))
    }

    /// The inverse of a map of this symmetry.
    pub fn inverse(&self, map: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let transposed = std::array::from_fn(|r| std::array::from_fn(|c| map[c][r]));
        self.stretched(&transposed, 2)
    }

    /// `Dⁿ M D⁻ⁿ` with the stretch `D` of an ellipsoid; the matrix itself of other shapes.
    fn stretched(&self, matrix: &[[f64; 3]; 3], power: i32) -> [[f64; 3]; 3] {
        let Some(d) = &self.stretch else { return *matrix };
        std::array::from_fn(|r| std::array::from_fn(|c| matrix[r][c] * (d[r] / d[c]).powi(power)))
    }

    /// The rotation (rows) of a ball that brings its first regular direction to the surface point
    /// `point`, wherever that is, so that the parametrisation is the same about all places; `None`
    /// of other shapes.
    pub fn rotation_of_first_to(&self, point: &[f64; 3]) -> Option<[[f64; 3]; 3]> {
        if !self.is_ball() {
            return None;
        }
        let (_, towards) = self.nearest_regular(point, point)?;
        self.regular.first().map(|first| rotation(first, &towards))
    }

    /// The regular direction nearest to a surface point, and the direction of that; `None` where
    /// turning does not help.
    fn nearest_regular(&self, point: &[f64; 3], normal: &[f64; 3]) -> Option<([f64; 3], [f64; 3])> {
        let is_end = self.axis.is_some_and(|a| dot(&a, normal).abs() > 0.5 * norm(normal));
        let along = self.axis.map_or(0.0, |a| dot(&a, point));
        let away: [f64; 3] = std::array::from_fn(|c| point[c] - self.axis.map_or(0.0, |a| along * a[c]));
        let distance = norm(&away);
        if is_end || distance.is_nan() || distance <= 0.0 {
            return None;
        }
        let towards = away.map(|v| v / distance);
        let nearest = self.regular.iter().max_by(|a, b| dot(a, &towards).total_cmp(&dot(b, &towards)))?;
        Some((*nearest, towards))
    }

    /// The same symmetry after a map (rows) of the shape about the origin: a rotation, of an
    /// ellipsoid one of its own, after others it has none that is known.
    #[must_use]
    pub fn rotated(&self, map: &[[f64; 3]; 3]) -> Option<Self> {
        let rotation = self.stretched(map, -1);
        let gram = |a: usize, b: usize| dot(&rotation[a], &rotation[b]) - if a == b { 1.0 } else { 0.0 };
        if (0..9).any(|k| gram(k / 3, k % 3).abs() > ROTATION) {
            return None;
        }
        let turn = |p: &[f64; 3]| rotation.map(|row| dot(&row, p));
        Some(Self {
            axis: self.axis.as_ref().map(turn),
            regular: self.regular.iter().map(turn).collect(),
            stretch: self.stretch,
        })
    }
}

/// Deviation from orthonormality of a matrix that counts as a rotation: round-off of products and
/// of ratios of semi-axes.
const ROTATION: f64 = 1e-9;

/// Whether a place `towards` is further from `direction` than the parametrisation serves.
fn is_far(direction: &[f64; 3], towards: &[f64; 3]) -> bool {
    dot(direction, towards) < NEAR.to_radians().cos()
}

/// The axis after that along which the regular direction `direction` of an ellipsoid's ball is: the
/// net follows the axes there.
fn another_axis(direction: &[f64; 3]) -> [f64; 3] {
    let largest = (0..3).max_by(|a, b| direction[*a].abs().total_cmp(&direction[*b].abs())).unwrap_or(0);
    std::array::from_fn(|c| if c == (largest + 1) % 3 { 1.0 } else { 0.0 })
}

/// A unit vector at right angles to the unit vector `v`.
fn perpendicular(v: &[f64; 3]) -> [f64; 3] {
    let least = (0..3).min_by(|a, b| v[*a].abs().total_cmp(&v[*b].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let across = cross(v, &axis);
    let size = norm(&across);
    across.map(|x| x / size)
}

/// Direction in the unit ball, tangential at the unit vector `place`, of a principal curvature of
/// the ellipsoid: there `t · D² t`, the first fundamental form of the ellipsoid, is largest; its
/// second one is the same in all directions of the ball.
fn principal_direction(place: &[f64; 3], semi_axes: &[f64; 3]) -> [f64; 3] {
    let a = perpendicular(place);
    let b = cross(place, &a);
    let form =
        |s: &[f64; 3], t: &[f64; 3]| (0..3).map(|c| semi_axes[c] * semi_axes[c] * s[c] * t[c]).sum::<f64>();
    let angle = 0.5 * (2.0 * form(&a, &b)).atan2(form(&a, &a) - form(&b, &b));
    let (sine, cosine) = angle.sin_cos();
    std::array::from_fn(|c| cosine * a[c] + sine * b[c])
}

/// Angle about the unit vector `axis` by which `from` must be turned to point along `to`, both seen
/// along the axis; zero if one vanishes.
pub fn angle_about(axis: &[f64; 3], from: &[f64; 3], to: &[f64; 3]) -> f64 {
    let along = dot(from, to) - dot(from, axis) * dot(to, axis);
    dot(&cross(from, to), axis).atan2(along)
}

/// Rotation (rows) by `angle` about the unit vector `axis`: Rodrigues' formula.
pub fn rotation_about(axis: &[f64; 3], angle: f64) -> [[f64; 3]; 3] {
    let (sine, cosine) = angle.sin_cos();
    let cross = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    let unit = |r: usize, c: usize| if r == c { cosine } else { 0.0 };
    std::array::from_fn(|r| {
        std::array::from_fn(|c| unit(r, c) + sine * cross[r][c] + (1.0 - cosine) * axis[r] * axis[c])
    })
}

/// The product of two rotations (rows).
pub fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| std::array::from_fn(|c| (0..3).map(|k| row[k] * b[k][c]).sum()))
}

/// Sine of an angle below which two unit vectors have no plane that round-off does not make.
const PARALLEL: f64 = 1e-8;

/// The rotation that takes unit vector `from` to `to` by the shortest way; about an axis across, if
/// they are opposite.
fn rotation(from: &[f64; 3], to: &[f64; 3]) -> [[f64; 3]; 3] {
    let normal = cross(from, to);
    let sine = norm(&normal);
    if sine >= PARALLEL {
        return rotation_about(&normal.map(|v| v / sine), sine.atan2(dot(from, to)));
    }
    let angle = if dot(from, to) < 0.0 { std::f64::consts::PI } else { 0.0 };
    rotation_about(&perpendicular(from), angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const AXES: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];

    fn apply(r: &[[f64; 3]; 3], p: &[f64; 3]) -> [f64; 3] {
        r.map(|row| dot(&row, p))
    }

    #[test]
    fn near_a_regular_direction_nothing_is_turned() {
        let ball = Symmetry::ball(&AXES);
        assert_eq!(ball.map_to(&[9.9, 0.5, 0.4], &[1.0, 0.0, 0.0]), None);
        assert!(ball.map_to(&[0.0, 1.0, 0.0], &[0.0, 1.0, 0.0]).is_some(), "the pole");
        let cylinder = Symmetry::about_z(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(cylinder.map_to(&[0.7, 0.7, 0.0], &[0.0, 0.0, -1.0]), None, "a flat end");
        assert_eq!(cylinder.map_to(&[0.0, 0.0, 1.0], &[1.0, 0.0, 0.0]), None, "on the axis");
    }

    proptest! {
        #[test]
        fn the_first_direction_of_a_ball_is_brought_everywhere(p in prop::array::uniform3(-1.0f64..1.0)) {
            prop_assume!(norm(&p) > 1e-3);
            let ball = Symmetry::ball(&AXES);
            for p in [p, [2.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [-2.0, 1e-12, 0.0], [-2.0, 1e-7, -1e-7]] {
                let Some(r) = ball.rotation_of_first_to(&p) else { panic!("a ball is turned") };
                let there = apply(&r, &AXES[0]);
                // Where the way is opposite to the direction its plane is round-off: the angle that
                // this leaves is a hundredth of a millionth.
                for c in 0..3 {
                    prop_assert!((there[c] - p[c] / norm(&p)).abs() < 2e-8, "{there:?} {p:?}");
                }
            }
        }

        #[test]
        fn maps_of_an_ellipsoid_leave_it_and_bring_its_net_along_the_principal_curvatures(
            p in prop::array::uniform3(-1.0f64..1.0), semi_axes in prop::array::uniform3(0.1f64..3.0)
        ) {
            prop_assume!(norm(&p) > 1e-3);
            let u = p.map(|c| c / norm(&p));
            let point = std::array::from_fn(|c| semi_axes[c] * u[c]);
            let symmetry = Symmetry::ellipsoid(semi_axes, &AXES);
            // Tangents of the net at the ends of the axes: the other two axes.
            let tangents = |place: &[f64; 3]| {
                let a = (0..3).find(|c| place[*c].abs() > 1e-6).expect("an end of an axis");
                [1, 2].map(|d| std::array::from_fn(|c| if c == (a + d) % 3 { semi_axes[c] } else { 0.0 }))
            };
            let Some(m) = symmetry.map_to(&point, &point) else { return Ok(()) };
            let back = symmetry.inverse(&m);
            let start = apply(&back, &point);
            let level = |x: &[f64; 3]| (0..3).map(|c| (x[c] / semi_axes[c]).powi(2)).sum::<f64>();
            // Round-off of some ten operations times the square of the largest ratio of the
            // semi-axes, thirty: 1e-12; ten of it are allowed.
            let round_off = 1e-11;
            let units = product(&m, &back);
            for (k, entry) in units.as_flattened().iter().enumerate() {
                let unit = if k % 4 == 0 { 1.0 } else { 0.0 };
                prop_assert!((entry - unit).abs() < round_off);
            }
            for x in [[0.3, 0.4, -0.7], [1.0, 2.0, 0.5]] {
                prop_assert!((level(&apply(&m, &x)) / level(&x) - 1.0).abs() < round_off);
            }
            prop_assert!((dot(&m[0], &cross(&m[1], &m[2])) - 1.0).abs() < round_off, "volumes");
            let end = (0..3).filter(|c| start[*c].abs() > 1e-9 * semi_axes[*c]).count();
            prop_assert_eq!(end, 1, "an end of an axis: {:?}", start);
            // Principal directions are at right angles in the ellipsoid.
            let [a, b] = tangents(&start).map(|t| apply(&m, &t));
            prop_assert!(dot(&a, &b).abs() < round_off * norm(&a) * norm(&b), "{:?} {:?}", a, b);
            prop_assert!(symmetry.rotated(&m).is_some());
            prop_assert_eq!(symmetry.rotated(&rotation_about(&[0.0, 0.0, 1.0], 1.0)).is_some(), (semi_axes[0] - semi_axes[1]).abs() < 1e-9);
        }

        #[test]
        fn a_turn_brings_a_regular_direction_to_the_point(
            p in prop::array::uniform3(-1.0f64..1.0), about_z in any::<bool>()
        ) {
            prop_assume!(norm(&[p[0], p[1], 0.0]) > 1e-3);
            let symmetry = if about_z { Symmetry::about_z(&AXES[..2]) } else { Symmetry::ball(&AXES) };
            let normal = if about_z { [p[0], p[1], 0.0] } else { p };
            let Some(r) = symmetry.map_to(&p, &normal) else { return Ok(()) };
            // A rotation: its inverse is its transpose.
            for a in 0..3 {
                for b in 0..3 {
                    let unit = if a == b { 1.0 } else { 0.0 };
                    prop_assert!((dot(&r[a], &r[b]) - unit).abs() < 1e-14);
                }
            }
            let turned = symmetry.rotated(&r).expect("a rotation");
            prop_assert_eq!(turned.map_to(&p, &normal), None);
            if about_z {
                let top = apply(&r, &[0.0, 0.0, 1.0]);
                prop_assert!((top[2] - 1.0).abs() < 1e-14, "the axis stays");
            }
        }
    }
}
