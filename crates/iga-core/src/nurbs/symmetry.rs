//! Rotations that leave a shape as it is, so that its parametrisation may be turned without changing the body.

use super::jet::{cross, dot, norm};

/// Angle between a point and the nearest regular direction up to which the parametrisation serves as it is: singular lines are
/// 45° away from these directions.
const NEAR: f64 = 20.0;

/// Rotations about the origin that leave a shape as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Symmetry {
    /// Axis of the rotations; `None`: all axes.
    axis: Option<[f64; 3]>,
    /// Unit vectors from the origin, or from the axis, around which the parametrisation is regular and smooth.
    regular: Vec<[f64; 3]>,
}

impl Symmetry {
    /// A ball centred at the origin, regular around the given directions.
    pub fn ball(regular: &[[f64; 3]]) -> Self {
        Self { axis: None, regular: regular.to_vec() }
    }

    /// A body of revolution about the z axis, regular around the given directions.
    pub fn about_z(regular: &[[f64; 3]]) -> Self {
        Self { axis: Some([0.0, 0.0, 1.0]), regular: regular.to_vec() }
    }

    /// Axis of the rotations; `None`: all axes.
    pub fn axis(&self) -> Option<&[f64; 3]> {
        self.axis.as_ref()
    }

    /// Unit vectors from the origin, or from the axis, around which the parametrisation is regular and smooth.
    pub fn regular(&self) -> &[[f64; 3]] {
        &self.regular
    }

    /// Whether the shape may be turned about any axis.
    pub fn is_ball(&self) -> bool {
        self.axis.is_none()
    }

    /// The rotation (rows) that brings the nearest regular direction to the surface point `point` with outward normal `normal`.
    ///
    /// `None` if the parametrisation is regular around the point as it is, or turning it does not help, as on the flat ends of
    /// a cylinder.
    pub fn rotation_to(&self, point: &[f64; 3], normal: &[f64; 3]) -> Option<[[f64; 3]; 3]> {
        let (direction, towards) = self.nearest_regular(point, normal)?;
        let cosine = dot(&direction, &towards);
        (cosine < NEAR.to_radians().cos()).then(|| rotation(&direction, &towards))
    }

    /// The rotation (rows) that brings a regular direction to the surface point `point` with outward normal `normal`, so that the parametrisation is the same
    /// about all places as far as the symmetry goes: of a ball the first direction wherever the point is, of a body of revolution as
    /// [`Symmetry::rotation_to`].
    pub fn rotation_of_first_to(&self, point: &[f64; 3], normal: &[f64; 3]) -> Option<[[f64; 3]; 3]> {
        if !self.is_ball() {
            return self.rotation_to(point, normal);
        }
        let (_, towards) = self.nearest_regular(point, normal)?;
        self.regular.first().map(|first| rotation(first, &towards))
    }

    /// The regular direction nearest to a surface point, and the direction of that; `None` where turning does not help.
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

    /// The same symmetry after a rotation (rows) of the shape about the origin.
    #[must_use]
    pub fn rotated(&self, rotation: &[[f64; 3]; 3]) -> Self {
        let turn = |p: &[f64; 3]| rotation.map(|row| dot(&row, p));
        Self { axis: self.axis.as_ref().map(turn), regular: self.regular.iter().map(turn).collect() }
    }
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

/// The rotation that takes unit vector `from` to `to` by the shortest way; about an axis across, if they are opposite.
fn rotation(from: &[f64; 3], to: &[f64; 3]) -> [[f64; 3]; 3] {
    let normal = cross(from, to);
    let sine = norm(&normal);
    if sine >= PARALLEL {
        return rotation_about(&normal.map(|v| v / sine), sine.atan2(dot(from, to)));
    }
    let least = (0..3).min_by(|a, b| from[*a].abs().total_cmp(&from[*b].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let across = cross(from, &axis);
    let size = norm(&across);
    let angle = if dot(from, to) < 0.0 { std::f64::consts::PI } else { 0.0 };
    rotation_about(&across.map(|v| v / size), angle)
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
        assert_eq!(ball.rotation_to(&[9.9, 0.5, 0.4], &[1.0, 0.0, 0.0]), None);
        assert!(ball.rotation_to(&[0.0, 1.0, 0.0], &[0.0, 1.0, 0.0]).is_some(), "the pole");
        let cylinder = Symmetry::about_z(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(cylinder.rotation_to(&[0.7, 0.7, 0.0], &[0.0, 0.0, -1.0]), None, "a flat end");
        assert_eq!(cylinder.rotation_to(&[0.0, 0.0, 1.0], &[1.0, 0.0, 0.0]), None, "on the axis");
    }

    proptest! {
        #[test]
        fn the_first_direction_of_a_ball_is_brought_everywhere(p in prop::array::uniform3(-1.0f64..1.0)) {
            prop_assume!(norm(&p) > 1e-3);
            let ball = Symmetry::ball(&AXES);
            for p in [p, [2.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [-2.0, 1e-12, 0.0], [-2.0, 1e-7, -1e-7]] {
                let Some(r) = ball.rotation_of_first_to(&p, &p) else { panic!("a ball is turned") };
                let there = apply(&r, &AXES[0]);
                // Where the way is opposite to the direction its plane is round-off: the angle that this leaves is a hundredth of a millionth.
                for c in 0..3 {
                    prop_assert!((there[c] - p[c] / norm(&p)).abs() < 2e-8, "{there:?} {p:?}");
                }
            }
        }

        #[test]
        fn a_turn_brings_a_regular_direction_to_the_point(
            p in prop::array::uniform3(-1.0f64..1.0), about_z in any::<bool>()
        ) {
            prop_assume!(norm(&[p[0], p[1], 0.0]) > 1e-3);
            let symmetry = if about_z { Symmetry::about_z(&AXES[..2]) } else { Symmetry::ball(&AXES) };
            let normal = if about_z { [p[0], p[1], 0.0] } else { p };
            let Some(r) = symmetry.rotation_to(&p, &normal) else { return Ok(()) };
            // A rotation: its inverse is its transpose.
            for a in 0..3 {
                for b in 0..3 {
                    let unit = if a == b { 1.0 } else { 0.0 };
                    prop_assert!((dot(&r[a], &r[b]) - unit).abs() < 1e-14);
                }
            }
            let turned = symmetry.rotated(&r);
            prop_assert_eq!(turned.rotation_to(&p, &normal), None);
            if about_z {
                let top = apply(&r, &[0.0, 0.0, 1.0]);
                prop_assert!((top[2] - 1.0).abs() < 1e-14, "the axis stays");
            }
        }
    }
}
