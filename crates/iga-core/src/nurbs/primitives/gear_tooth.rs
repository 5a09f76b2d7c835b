//! A tooth of a spur gear with involute flanks, on the sector of the rim under it.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::profile::{across, extruded};
use super::{joined, positive};
use crate::SplineError;
use crate::nurbs::{FaceId, Patch, Shape};
use crate::splines::knots::KnotVector;

/// Roll angle \[rad\] at which the involute begins if the root circle does not cut it higher up:
/// 1/800 of the base radius above the base circle, where its curvature is infinite. Below it the
/// flank goes on straight.
const FIRST_ROLL: f64 = 0.05;
/// Longest part of the roll angle \[rad\] that one quintic follows: the position deviates by a
/// sixth power of it, 1e-8 of the base radius, the curvature by the fourth, 1e-4.
const SPAN: f64 = 0.25;

/// One tooth of a spur gear about the z axis, symmetric about the x axis, with the sector of the
/// rim that belongs to it.
///
/// The flanks are involutes of the base circle `module teeth cos(pressure_angle) / 2` from the roll
/// angle 0.05 up, or from the root circle if that is higher up; below they are straight down to the
/// root circle, without a fillet. On the pitch circle, of the diameter `module teeth`, tooth and
/// gap are equally wide. Tip, root and bore are arcs about the axis (theory Eqs. S.13 to S.15).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearTooth {
    /// Pitch diameter over the number of teeth \[m\].
    pub module: f64,
    /// Number of teeth of the whole gear, six at least.
    pub teeth: usize,
    /// Pressure angle on the pitch circle \[rad\], below 45 degrees.
    pub pressure_angle: f64,
    /// Height of the tip over the pitch circle \[m\].
    pub addendum: f64,
    /// Depth of the root under the pitch circle \[m\].
    pub dedendum: f64,
    /// Inner radius of the rim \[m\].
    pub inner_radius: f64,
}

/// The flank with `y > 0` as a quintic spline, from the root circle outwards.
struct Flank {
    knots: KnotVector,
    points: Vec<[f64; 2]>,
    /// Parameter at which the flank crosses the pitch circle.
    pitch: f64,
}

/// The involute on the side `y > 0`.
struct Involute {
    base: f64,
    /// Half of the angle that the tooth takes of the base circle \[rad\].
    half: f64,
}

impl Involute {
    /// Position, slope and second derivative by the roll angle \[m\], \[m/rad\], \[m/rad²\] (theory
    /// Eq. S.13).
    fn at(&self, roll: f64) -> [[f64; 2]; 3] {
        let (sine, cosine) = (self.half - roll).sin_cos();
        let b = self.base;
        [
            [b * (cosine - roll * sine), b * (sine + roll * cosine)],
            [b * roll * cosine, b * roll * sine],
            [b * (cosine + roll * sine), b * (sine - roll * cosine)],
        ]
    }

    /// Roll angle at which the circle of the radius `radius` is met, zero inside of the base
    /// circle.
    fn roll(&self, radius: f64) -> f64 {
        ((radius / self.base).powi(2) - 1.0).max(0.0).sqrt()
    }

    /// Control points of the quintic spline with the involute's position and first two derivatives
    /// at `n` + 1 equally spaced roll angles; its interior knots are triple (theory Eq. S.14).
    fn spline(&self, [first, last]: [f64; 2], n: usize) -> Vec<[f64; 2]> {
        let h = (last - first) / n as f64;
        let mut points = Vec::with_capacity(3 * n + 3);
        for i in 0..n {
            let ends = [i, i + 1].map(|k| self.at(first + h * k as f64));
            let near = |end: usize, s: f64, second: f64| {
                let [p, d, c] = ends[end];
                [0, 1].map(|k| p[k] + s * h / 5.0 * d[k] + second * h * h / 20.0 * c[k])
            };
            let inner = [near(0, 2.0, 1.0), near(1, -2.0, 1.0)];
            let before_end = near(1, -1.0, 0.0);
            if i == 0 {
                points.extend([ends[0][0], near(0, 1.0, 0.0)]);
            }
            points.extend(inner);
            if i + 1 == n {
                points.extend([before_end, ends[1][0]]);
            } else {
                points.push([0, 1].map(|k| 2.0 * before_end[k] - inner[1][k]));
            }
        }
        points
    }
}

impl GearTooth {
    /// Radius of the pitch circle \[m\].
    pub fn pitch_radius(&self) -> f64 {
        0.5 * self.module * self.teeth as f64
    }

    /// Radius of the base circle \[m\].
    pub fn base_radius(&self) -> f64 {
        self.pitch_radius() * self.pressure_angle.cos()
    }

    /// Radius of curvature of the flank where it crosses the circle of the radius `radius` \[m\]:
    /// the length of the tangent to the base circle.
    pub fn flank_radius(&self, radius: f64) -> f64 {
        (radius.powi(2) - self.base_radius().powi(2)).max(0.0).sqrt()
    }

    /// The section in `(x, y)`. Patch 0 is the tooth (directions outwards, across), 1 to 3 the rim
    /// under it and on both sides (outwards, around).
    ///
    /// # Errors
    /// [`SplineError::Dimension`] for sizes that make no tooth.
    pub fn plane(&self) -> Result<Shape, SplineError> {
        let (patches, pitch) = self.patches()?;
        let markers = self.markers(&patches[0], pitch, 0.0);
        Ok(joined(patches, markers, faces()))
    }

    /// The tooth `0 <= z <= width`.
    ///
    /// # Errors
    /// As [`GearTooth::plane`].
    pub fn solid(&self, width: f64) -> Result<Shape, SplineError> {
        let width = positive("width", width)?;
        let (plane, pitch) = self.patches()?;
        let markers = self.markers(&plane[0], pitch, 0.5 * width);
        let patches = extruded(&plane, [0.0, width])?;
        let ends = [("z-", across(&patches, false)), ("z+", across(&patches, true))];
        let mut shape = joined(patches, markers, faces());
        shape.faces.extend(ends.map(|(name, ids)| (name.to_owned(), ids)));
        Ok(shape)
    }

    fn markers(&self, tooth: &Patch, pitch: f64, z: f64) -> [(&'static str, [f64; 3]); 5] {
        let flank = |end: f64| {
            let [x, y, _] = tooth.point(&[pitch, end, 0.0]);
            [x, y, z]
        };
        [
            ("centre", [self.pitch_radius(), 0.0, z]),
            ("tip", [self.pitch_radius() + self.addendum, 0.0, z]),
            ("bore", [self.inner_radius, 0.0, z]),
            ("first-flank", flank(0.0)),
            ("last-flank", flank(1.0)),
        ]
    }

    /// Plane patches, and the parameter of the pitch circle on the flanks.
    fn patches(&self) -> Result<(Vec<Patch>, f64), SplineError> {
        let flank = self.flank()?;
        let [root, tip] = [flank.points[0], flank.points[flank.points.len() - 1]];
        let [at_root, at_tip] = [root, tip].map(|[x, y]| y.atan2(x));
        let pitch_angle = PI / self.teeth as f64;
        if at_tip <= 0.0 {
            return Err(self.unfit(
                "addendum",
                self.addendum,
                "makes the tooth end in a point below its tip",
            ));
        }
        if at_root >= pitch_angle {
            return Err(self.unfit(
                "dedendum",
                self.dedendum,
                "makes neighbouring teeth meet above the root",
            ));
        }
        let radii = [self.inner_radius, self.pitch_radius() - self.dedendum];
        let patches = vec![
            tooth(&flank)?,
            rim(radii, [-at_root, at_root])?,
            rim(radii, [-pitch_angle, -at_root])?,
            rim(radii, [at_root, pitch_angle])?,
        ];
        Ok((patches, flank.pitch))
    }

    fn unfit(&self, name: &'static str, value: f64, reason: &'static str) -> SplineError {
        SplineError::Dimension { name, value, reason }
    }

    fn check(&self) -> Result<(), SplineError> {
        for (name, value) in [
            ("module", self.module),
            ("addendum", self.addendum),
            ("dedendum", self.dedendum),
            ("inner_radius", self.inner_radius),
        ] {
            positive(name, value)?;
        }
        if self.teeth < 6 {
            return Err(self.unfit("teeth", self.teeth as f64, "must be six at least"));
        }
        if !(self.pressure_angle > 0.0 && self.pressure_angle < FRAC_PI_4) {
            let reason = "must be positive and less than 45 degrees";
            return Err(self.unfit("pressure_angle", self.pressure_angle, reason));
        }
        if self.inner_radius < self.pitch_radius() - self.dedendum {
            return Ok(());
        }
        Err(self.unfit(
            "inner_radius",
            self.inner_radius,
            "must be smaller than the radius of the root circle",
        ))
    }

    fn flank(&self) -> Result<Flank, SplineError> {
        self.check()?;
        let (pitch, alpha) = (self.pitch_radius(), self.pressure_angle);
        let (root, tip) = (pitch - self.dedendum, pitch + self.addendum);
        let half = 0.5 * PI / self.teeth as f64 + alpha.tan() - alpha;
        let involute = Involute { base: self.base_radius(), half };
        let rolls = [involute.roll(root).max(FIRST_ROLL), involute.roll(tip)];
        let at_pitch = alpha.tan();
        if at_pitch <= rolls[0] {
            return Err(self.unfit(
                "pressure_angle",
                alpha,
                "is too small for an involute at the pitch circle",
            ));
        }
        let n = ((rolls[1] - rolls[0]) / SPAN).ceil() as usize;
        let curve = involute.spline(rolls, n);
        let straight = straight(&involute, rolls[0], root);
        // Parameters of the straight part and the involute by their lengths.
        let length = 0.5 * involute.base * (rolls[1].powi(2) - rolls[0].powi(2));
        let share = straight.map_or(0.0, |to| distance(to, curve[0]) / (distance(to, curve[0]) + length));
        let at = |roll: f64| share + (1.0 - share) * (roll - rolls[0]) / (rolls[1] - rolls[0]);
        let mut points = Vec::new();
        let mut knots = vec![0.0; 6];
        if let Some(to) = straight {
            let between = |i: usize| [0, 1].map(|k| to[k] + i as f64 / 5.0 * (curve[0][k] - to[k]));
            points.extend((0..5).map(between));
            knots.extend([share; 5]);
        }
        points.extend(curve);
        let step = (rolls[1] - rolls[0]) / n as f64;
        knots.extend((1..n).flat_map(|i| [at(rolls[0] + step * i as f64); 3]));
        knots.extend([1.0; 6]);
        Ok(Flank { knots: KnotVector::new(5, knots)?, points, pitch: at(at_pitch) })
    }
}

/// Where the tangent of the involute at the roll angle `roll` meets the root circle, if the
/// involute begins above it.
fn straight(involute: &Involute, roll: f64, root: f64) -> Option<[f64; 2]> {
    let [[x, y], ..] = involute.at(roll);
    if x.hypot(y) <= root * (1.0 + 1e-9) {
        return None;
    }
    let (sine, cosine) = (involute.half - roll).sin_cos();
    let along = x * cosine + y * sine;
    // The line passes the axis at the distance of the involute's radius of curvature, which is
    // small here.
    let beside = (y * cosine - x * sine).abs();
    let t = along - ((root - beside) * (root + beside)).sqrt();
    Some([x - t * cosine, y - t * sine])
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The tooth between its flanks: arcs at root and tip, in between with weights and middle points
/// that go over from one to the other.
fn tooth(flank: &Flank) -> Result<Patch, SplineError> {
    let last = flank.points.len() - 1;
    // Half the angle of an arc about the origin, as the cosine, and how far its middle control
    // point is beyond the chord.
    let arc = |[x, y]: [f64; 2]| (x / x.hypot(y), y * y / x);
    let [(c0, m0), (c1, m1)] = [arc(flank.points[0]), arc(flank.points[last])];
    let places = flank.knots.greville();
    let middle = |i: usize| {
        // Both go over linearly in the parameter, whose control points stand at the means of five
        // knots.
        let s = places[i];
        (flank.points[i][0] + (1.0 - s) * m0 + s * m1, (1.0 - s) * c0 + s * c1)
    };
    let mut points: Vec<_> = flank.points.iter().map(|[x, y]| [*x, -y, 0.0]).collect();
    points.extend((0..=last).map(|i| [middle(i).0, 0.0, 0.0]));
    points.extend(flank.points.iter().map(|[x, y]| [*x, *y, 0.0]));
    let mut weights = vec![1.0; last + 1];
    weights.extend((0..=last).map(|i| middle(i).1));
    weights.resize(3 * (last + 1), 1.0);
    Patch::new(vec![flank.knots.clone(), KnotVector::uniform(2, 1)?], points, weights)
}

/// A part of the rim between two angles, less than a quarter.
fn rim(radii: [f64; 2], [from, to]: [f64; 2]) -> Result<Patch, SplineError> {
    let half = 0.5 * (to - from);
    debug_assert!(half < FRAC_PI_4 && to - from < FRAC_PI_2);
    let arc = [(from, 1.0), (0.5 * (from + to), half.cos()), (to, 1.0)];
    let (mut points, mut weights) = (Vec::with_capacity(6), Vec::with_capacity(6));
    for (angle, weight) in arc {
        for r in radii {
            points.push([r * angle.cos() / weight, r * angle.sin() / weight, 0.0]);
            weights.push(weight);
        }
    }
    super::bezier(&[1, 2], points, weights)
}

/// Faces that plane and solid tooth have.
fn faces() -> [(&'static str, Vec<FaceId>); 7] {
    let end = |patch, direction, upper| FaceId { patch, direction, upper };
    [
        ("tip", vec![end(0, 0, true)]),
        ("first-flank", vec![end(0, 1, false)]),
        ("last-flank", vec![end(0, 1, true)]),
        ("root", vec![end(2, 0, true), end(3, 0, true)]),
        ("bore", (1..4).map(|patch| end(patch, 0, false)).collect()),
        ("first", vec![end(2, 1, false)]),
        ("last", vec![end(3, 1, true)]),
    ]
}
