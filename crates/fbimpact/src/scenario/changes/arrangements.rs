//! Where the copies of a body stand and how they move.

use std::collections::HashMap;
use std::f64::consts::TAU;

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use crate::scenario::section::Section;
use crate::scenario::tables::{Arrangement, MOST_COPIES};

/// Places that are tried for a copy before the box counts as full.
const MOST_TRIES: usize = 10_000;

/// Orientation, velocity and angular velocity.
type Motion = (UnitQuaternion<f64>, [Vector3<f64>; 2]);

/// What a copy has of its own.
#[derive(Debug, Clone)]
pub struct Pose {
    position: Vector3<f64>,
    /// None if it is that of the body.
    motion: Option<Motion>,
}

impl Pose {
    fn at(position: Vector3<f64>) -> Self {
        Self { position, motion: None }
    }

    /// The keys of a body that the pose gives.
    pub fn keys(&self) -> Vec<(&'static str, Vec<f64>)> {
        let vector = |v: &Vector3<f64>| v.iter().copied().collect();
        let mut keys = vec![("position", vector(&self.position))];
        if let Some((rotation, [velocity, angular_velocity])) = &self.motion {
            keys.push(("orientation", vec![rotation.w, rotation.i, rotation.j, rotation.k]));
            keys.push(("velocity", vector(velocity)));
            keys.push(("angular_velocity", vector(angular_velocity)));
        }
        keys
    }
}

/// Poses of the copies of the body whose keys are in `section`; `None` if something of them is at fault.
pub fn poses(section: &Section) -> Option<Vec<Pose>> {
    let position = Vector3::from(section.vector::<3>("position")?);
    let copies = section.table("copies")?;
    let vector = |key: &str| copies.vector::<3>(key).map(Vector3::from);
    let refuse = |key: &str, message: String| copies.refuse(key, message);
    match copies.choice::<Arrangement>("arrangement")? {
        Arrangement::Row => {
            let (count, step) = (copies.integer("count")?, vector("step")?);
            Some((0..count).map(|i| Pose::at(position + step * i as f64)).collect())
        }
        Arrangement::Grid => {
            let (spacing, counts) = (vector("spacing")?, copies.counts("counts")?);
            let [nx, ny, nz] = match counts[..] {
                [n] => [n; 3],
                [nx, ny] => [nx, ny, 1],
                _ => counts.try_into().ok()?,
            };
            if nx * ny * nz > MOST_COPIES as usize {
                return refuse("counts", format!("must make no more than {MOST_COPIES} copies in all"));
            }
            let at = |i: usize| {
                let counted = Vector3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
                Pose::at(position + spacing.component_mul(&counted))
            };
            Some((0..nx * ny * nz).map(at).collect())
        }
        Arrangement::Ring => {
            let (count, centre) = (copies.integer("count")?, vector("centre")?);
            let Some(axis) = Unit::try_new(vector("axis")?, 0.0) else {
                return refuse("axis", "must not be zero".into());
            };
            let (turned, (rotation, vectors)) = (copies.boolean("turned")?, motion(section)?);
            let at = |i: usize| {
                let turn = UnitQuaternion::from_axis_angle(&axis, TAU * i as f64 / count as f64);
                let motion = turned.then(|| (turn * rotation, vectors.map(|v| turn * v)));
                Pose { position: centre + turn * (position - centre), motion }
            };
            Some((0..count).map(at).collect())
        }
        Arrangement::Random => {
            let (count, [from, to]) = (copies.integer("count")?, [vector("from")?, vector("to")?]);
            let (distance, turned) = (copies.number("distance")?, copies.boolean("turned")?);
            let (mut draw, motion) = (Draw(copies.integer("seed")? as u64), motion(section)?);
            let places = apart(count, distance, || {
                from + (to - from).component_mul(&Vector3::from_fn(|_, _| draw.number()))
            });
            if places.len() < count {
                let message = format!(
                    "{} of {count} copies fit into the box with this distance, {MOST_TRIES} attempts found no free place for the next; enlarge \
                     the box, or take fewer copies",
                    places.len()
                );
                return refuse("distance", message);
            }
            let mut at = |place| Pose {
                position: position + place,
                motion: turned.then(|| (draw.rotation(), motion.1)),
            };
            Some(places.into_iter().map(&mut at).collect())
        }
    }
}

/// Motion of the body itself.
fn motion(section: &Section) -> Option<Motion> {
    // A quaternion that has not unit length is told of where the body is built.
    let rotation = match *section.numbers("orientation")? {
        [w, i, j, k] => UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 0.0)?,
        [x, y, z] => UnitQuaternion::from_scaled_axis(Vector3::new(x, y, z)),
        _ => return None,
    };
    let vector = |key: &str| section.vector::<3>(key).map(Vector3::from);
    Some((rotation, [vector("velocity")?, vector("angular_velocity")?]))
}

/// Random sequential addition: `count` places that are `distance` apart, each the first of those drawn that is; fewer where
/// they do not fit.
fn apart(count: usize, distance: f64, mut draw: impl FnMut() -> Vector3<f64>) -> Vec<Vector3<f64>> {
    // By the cells of a grid, of which those around a cell hold all that are near.
    let mut cells: HashMap<[i64; 3], Vec<Vector3<f64>>> = HashMap::new();
    let cell =
        |place: &Vector3<f64>| [0, 1, 2].map(|i| (place[i] / distance).floor().clamp(-1e15, 1e15) as i64);
    let mut places = Vec::with_capacity(count);
    while places.len() < count {
        let is_free = |place: &Vector3<f64>| {
            let [x, y, z] = cell(place);
            let around = (0..27).map(|i| [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]);
            let mut near = around.filter_map(|key| cells.get(&key)).flatten();
            near.all(|other| (other - place).norm() >= distance)
        };
        let Some(place) = (0..MOST_TRIES).map(|_| draw()).find(is_free) else { break };
        cells.entry(cell(&place)).or_default().push(place);
        places.push(place);
    }
    places
}

/// Random numbers that are the same everywhere: SplitMix64 (Steele, Lea and Flood 2014).
struct Draw(u64);

impl Draw {
    /// A number of at least 0 and below 1.
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A rotation of the uniform distribution (Shoemake 1992).
    fn rotation(&mut self) -> UnitQuaternion<f64> {
        let (u, a, b) = (self.number(), TAU * self.number(), TAU * self.number());
        let (r, s) = ((1.0 - u).sqrt(), u.sqrt());
        UnitQuaternion::new_normalize(Quaternion::new(s * b.cos(), r * a.sin(), r * a.cos(), s * b.sin()))
    }
}
