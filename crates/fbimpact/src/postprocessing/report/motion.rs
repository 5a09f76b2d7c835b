//! The bodies of a result in motion: shapes once, coordinates over time.

use adaptive::spec::Target;
use adaptive::store::ModelCache;
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use iga_core::elasticity::kinematics::von_mises;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::encode::{Array, Blob};
use super::frames;
use super::nearest::Nearest;
use super::reduce::{Shapes, Sizes};
use super::surface::Surface;
use crate::error::AppError;
use crate::postprocessing::replay::states::{Pose, States};
use crate::postprocessing::vtk::bodies::assemble::{PointShapes, View};
use crate::postprocessing::vtk::bodies::splines::Cells;
use crate::postprocessing::vtk::bodies::{Bodies, Drawn, Shown};

/// Sections around the axis of a body that is revolved.
const AROUND: usize = 48;
/// Impacts whose peaks are shown with the stress of their contact zones.
const STILLS: usize = 40;
/// Unknowns of the models of the contact zones of an impact, up to which they are built again unasked: a second
/// or two and half a gigabyte for a solid body.
const ZONE_UNKNOWNS: u64 = 20_000;
/// Bits of positions.
const POSITION_BITS: u32 = 16;
/// Bits of coordinates.
const COORDINATE_BITS: u32 = 16;
/// Shapes that are added at a time.
const STEP: usize = 2;
/// The error of a number of shapes is found at each of so many states first, and at all of them if
/// it is small there.
const LOOK: usize = 16;

/// How fine motion is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// Part of the largest value that the shapes left out may be wrong by.
    pub tolerance: f64,
    /// Bits of displacements.
    pub displacement_bits: u32,
    /// Bits of stresses; none: they are left out.
    pub stress_bits: Option<u32>,
    /// Whether bodies deform.
    pub has_shapes: bool,
}

/// From fine to coarse: what is taken if all before is too large.
pub const FINENESS: [Fineness; 5] = [
    Fineness { tolerance: 9e-4, displacement_bits: 14, stress_bits: Some(13), has_shapes: true },
    Fineness { tolerance: 3e-3, displacement_bits: 12, stress_bits: Some(11), has_shapes: true },
    Fineness { tolerance: 1e-2, displacement_bits: 10, stress_bits: Some(9), has_shapes: true },
    Fineness { tolerance: 1e-2, displacement_bits: 10, stress_bits: None, has_shapes: true },
    Fineness { tolerance: 1.0, displacement_bits: 10, stress_bits: None, has_shapes: false },
];

/// The surface of a body with its shapes and its motion at the chosen states.
struct MovingBody {
    name: String,
    surface: Surface,
    points: Vec<f64>,
    is_revolved: bool,
    shapes: Shapes,
    sizes: Sizes,
    poses: Vec<Pose>,
    /// Position and rotation as quaternion, seven numbers a state.
    frames: Vec<f64>,
    speed: f64,
    stills: Vec<Still>,
}

/// Von Mises stress with the deformation of the contact zones at the peak of an impact.
struct Still {
    frame: usize,
    at_vertices: Vec<f64>,
    largest: f64,
}

/// The bodies of a result at the chosen states.
pub struct Motion {
    bodies: Vec<MovingBody>,
    /// Numbers of the chosen states.
    pub instants: Vec<usize>,
    /// Stored states.
    pub n_stored: usize,
    /// What the bodies are shown without, a sentence each.
    pub left_out: Vec<String>,
    head: Value,
}

impl Motion {
    /// Builds the bodies called `wanted`, or all with a shape, again from `states`, and the models of contact zones
    /// at the peaks, large ones if `has_large_zones`.
    ///
    /// # Errors
    /// Those of [`Bodies::build`] and [`Bodies::at`].
    pub fn new(
        states: &States,
        (wanted, has_large_zones): (&[String], bool),
        build: (usize, &ModelCache),
    ) -> Result<Self, AppError> {
        let mut bodies = Bodies::build(states, wanted, Cells::Linear(1), build)?;
        let mut left_out: Vec<String> = bodies.left_out().iter().map(ToString::to_string).collect();
        let (phases, spans) = states.phases()?;
        let peaks = states.peaks()?;
        let peaks: Vec<usize> = peaks.iter().map(|t| nearest(&states.time, *t)).collect();
        let instants = frames::chosen(&phases[..states.time.len()], &peaks, frames::MOST);
        let mut moving = bodies
            .shown
            .iter()
            .map(|shown| MovingBody::new(&bodies, shown, &instants))
            .collect::<Result<Vec<_>, AppError>>()?;
        let zones = states.zone_unknowns()?;
        let is_large = |(_, n): &(&usize, &u64)| !has_large_zones && **n > ZONE_UNKNOWNS;
        let (large, small): (Vec<_>, Vec<_>) = peaks.iter().zip(&zones).partition(is_large);
        if let Some((_, most)) = large.iter().max_by_key(|(_, n)| **n) {
            left_out.push(format!(
                "the stress of contact zones is left out at {} of {} peaks, as their models have up to {most} unknowns; --contact-stress builds them again",
                large.len(),
                peaks.len()
            ));
        }
        let mut shown_peaks: Vec<usize> = small.iter().map(|(i, _)| **i).collect();
        shown_peaks.sort_unstable();
        shown_peaks.dedup();
        for &i in shown_peaks.iter().take(STILLS) {
            let frame = instants.binary_search(&i).unwrap_or(0);
            for (body, drawn) in moving.iter_mut().zip(bodies.at(states.time[i], i)?) {
                body.add_still(&drawn, frame)?;
            }
        }
        let kind = |i: usize| {
            let row = spans.get(phases[i] as usize);
            row.is_some_and(|row| row.kind.as_str() != "free")
        };
        let head = json!({
            "time": instants.iter().map(|i| states.time[*i]).collect::<Vec<f64>>(),
            "in_impact": instants.iter().map(|i| u8::from(kind(*i))).collect::<Vec<u8>>(),
            "stored": states.time.len(),
            "peaks": peaks.iter().map(|i| instants.binary_search(i).unwrap_or(0)).collect::<Vec<usize>>(),
            "planes": planes(states),
        });
        Ok(Self { bodies: moving, instants, n_stored: states.time.len(), left_out, head })
    }

    /// The bodies as JSON with the blobs that it refers to, their names begin with `prefix`.
    pub fn encoded(&self, prefix: &str, fineness: &Fineness) -> (Value, Vec<Blob>) {
        let encode = |(i, body): (usize, &MovingBody)| body.encoded(format!("{prefix}-{i}"), fineness);
        let all: Vec<(Value, Blob)> = self.bodies.par_iter().enumerate().map(encode).collect();
        let (bodies, blobs): (Vec<Value>, Vec<Blob>) = all.into_iter().unzip();
        let mut head = self.head.clone();
        head["bodies"] = bodies.into();
        (head, blobs)
    }
}

/// Planes at rest that contacts meet: a point \[m\] and the normal.
fn planes(states: &States) -> Vec<Value> {
    let contacts = states.scenario.run.contacts.iter();
    let mut all: Vec<Value> = contacts
        .filter_map(|contact| {
            let Target::Plane(plane) = contact.target else { return None };
            Some(json!({ "point": plane.point.as_slice(), "normal": plane.normal.as_slice() }))
        })
        .collect();
    all.dedup();
    all
}

fn nearest(time: &[f64], t: f64) -> usize {
    let after = time.partition_point(|x| *x < t).min(time.len().saturating_sub(1));
    let before = after.saturating_sub(1);
    if (t - time[before]).abs() <= (time[after] - t).abs() { before } else { after }
}

/// The frame of a body at rest at the origin, in which fields are those of the body's axes.
fn at_origin() -> Pose {
    let none = Vector3::zeros();
    Pose { position: none, rotation: Matrix3::identity(), velocity: none, angular_velocity: none }
}

const UNDEFORMED: View = View { scale: 0.0, revolve: None };

impl MovingBody {
    fn new(bodies: &Bodies, shown: &Shown, instants: &[usize]) -> Result<Self, AppError> {
        let r = shown.motion.eigenfrequencies.len();
        let none = vec![0.0; r];
        let rest = bodies.displaced(shown, &none, &none);
        let is_revolved = rest.motion() == RigidMotion::Axial;
        let grid = rest.grid(&at_origin(), UNDEFORMED)?;
        let surface = Surface::new(&grid, is_revolved);
        let points = surface.at_vertices(&grid.points).into_iter().flatten().collect();
        let (seen, of_seen) = surface.gathered();
        let columns = bodies.shapes(shown, &seen)?;
        let displacement: Vec<_> = columns.iter().map(|c| of_seen.at_vertices(&c.displacement)).collect();
        let has_stress = |c: &&PointShapes| !c.stress.is_empty();
        let stress: Vec<_> =
            columns.iter().filter(has_stress).map(|c| of_seen.at_vertices(&c.stress)).collect();
        let motion = &shown.motion;
        let shapes = Shapes {
            displacement: Mat::from_fn(3 * surface.len(), r, |i, k| displacement[k][i / 3][i % 3]),
            stress: Mat::from_fn(6 * stress.first().map_or(0, Vec::len), r, |i, k| stress[k][i / 6][i % 6]),
            coordinates: Mat::from_fn(r, instants.len(), |k, t| motion.elastic(instants[t])[k]),
            rates: Mat::from_fn(r, instants.len(), |k, t| motion.rates(instants[t])[k]),
        };
        let poses: Vec<Pose> = instants.iter().map(|i| motion.pose(*i)).collect();
        let frame = |(i, pose): (&usize, &Pose)| {
            let p = &pose.position;
            let q = motion.rotation(*i);
            [p.x, p.y, p.z, q.w, q.i, q.j, q.k]
        };
        let frames = instants.iter().zip(&poses).flat_map(frame).collect();
        let sizes = shapes.sizes();
        let name = shown.name.clone();
        let mut body = Self {
            name,
            surface,
            points,
            is_revolved,
            shapes,
            sizes,
            poses,
            frames,
            speed: 0.0,
            stills: Vec::new(),
        };
        body.speed = body.largest_speed();
        Ok(body)
    }

    /// Largest speed of the vertices, with that of the frame \[m/s\]; a bound, as the rate of the
    /// displacement counts in full.
    fn largest_speed(&self) -> f64 {
        let rigid = |pose: &Pose| {
            let velocity = pose.rotation.transpose() * pose.velocity;
            let spin = pose.rotation.transpose() * pose.angular_velocity;
            let speed = |x: &[f64; 3]| (velocity + spin.cross(&Vector3::from(*x))).norm();
            self.points.as_chunks::<3>().0.iter().map(speed).fold(0.0, f64::max)
        };
        self.poses.par_iter().map(rigid).reduce(|| 0.0, f64::max) + self.sizes.rate
    }

    /// Takes up the stress at the vertices as `drawn` has it, if it is on a fine model or with what
    /// a contact zone adds.
    fn add_still(&mut self, drawn: &Drawn<'_>, frame: usize) -> Result<(), AppError> {
        let grid = drawn.grid(&at_origin(), UNDEFORMED)?;
        if grid.stress.is_empty() {
            return Ok(());
        }
        let largest = grid.von_mises.iter().fold(0.0_f64, |most, s| most.max(s[0]));
        let at_vertices: Vec<f64> = if drawn.mesh.is_none() {
            self.surface.at_vertices(&grid.stress).iter().map(von_mises).collect()
        } else {
            let near = Nearest::new(&grid.points);
            let vertices = self.points.as_chunks::<3>().0;
            let at = |x: &[f64; 3]| near.find(x).and_then(|i| grid.von_mises.get(i)).map_or(0.0, |s| s[0]);
            vertices.par_iter().map(at).collect()
        };
        let difference = |(v, s): (usize, &f64)| (self.modal_stress(v, frame) - s).abs();
        let change = at_vertices.iter().enumerate().map(difference).fold(0.0, f64::max);
        if drawn.mesh.is_some() || change > 1e-6 * largest {
            self.stills.push(Still { frame, at_vertices, largest });
        }
        Ok(())
    }

    fn modal_stress(&self, vertex: usize, frame: usize) -> f64 {
        let column = self.shapes.coordinates.col(frame);
        let row = |c: usize| self.shapes.stress.row(6 * vertex + c);
        von_mises(&std::array::from_fn(|c| row(c).iter().zip(column.iter()).map(|(s, q)| s * q).sum()))
    }

    fn encoded(&self, name: String, fineness: &Fineness) -> (Value, Blob) {
        let mut blob = Blob::new(name);
        let x = blob.quantised(&self.points, 3, POSITION_BITS);
        let parts = blob.naturals(&self.surface.parts, self.surface.corners);
        let pose = blob.floats(&self.frames, 7);
        let velocity = |pose: &Pose| {
            let (v, w) = (pose.velocity, pose.angular_velocity);
            [v.x, v.y, v.z, w.x, w.y, w.z]
        };
        let velocity: Vec<f64> = self.poses.iter().flat_map(velocity).collect();
        let velocity = blob.floats(&velocity, 6);
        let largest = json!({ "displacement": self.sizes.displacement, "rate": self.sizes.rate,
            "von_mises": self.sizes.von_mises, "speed": self.speed });
        let mut body = json!({
            "name": self.name, "vertices": self.surface.len(), "around": if self.is_revolved { AROUND } else { 0 },
            "corners": self.surface.corners, "x": x, "parts": parts, "pose": pose, "velocity": velocity,
            "largest": largest, "shapes": [], "stills": [],
        });
        if fineness.has_shapes && self.shapes.displacement.ncols() > 0 {
            self.add_shapes(&mut body, &mut blob, fineness);
        }
        if fineness.stress_bits.is_some() {
            let still = |still: &Still| json!({ "frame": still.frame, "largest": still.largest, "von_mises": blob.bytes(&still.at_vertices) });
            body["stills"] = self.stills.iter().map(still).collect();
        }
        (body, blob)
    }

    /// Adds as many shapes as the tolerance needs, with the error that is left.
    fn add_shapes(&self, body: &mut Value, blob: &mut Blob, fineness: &Fineness) {
        let mut wanted = self.shapes.clone();
        if fineness.stress_bits.is_none() {
            wanted.stress = Mat::zeros(0, wanted.stress.ncols());
        }
        // An elastic rate is small beside what shows.
        let sizes = Sizes { rate: self.speed, ..self.sizes };
        let ordered = wanted.ordered(&sizes, self.speed);
        let r = ordered.displacement.ncols();
        let few = wanted.every(LOOK);
        let is_enough = |errors: Sizes| errors.part_of(&sizes) <= fineness.tolerance;
        let trial = |k: usize| {
            let mut trial = blob.clone();
            let (arrays, rounded) = coded(&ordered.first(k), &mut trial, fineness);
            (arrays, trial, rounded)
        };
        // Most numbers of shapes are too small at a few states already; errors fall with their number.
        let counts: Vec<usize> = (STEP..r).step_by(STEP).chain([r]).collect();
        let is_too_small = |k: &usize| !is_enough(trial(*k).2.every(LOOK).deviation(&few));
        let first = counts[..counts.len() - 1].partition_point(is_too_small);
        let mut tried = counts[first..].iter().map(|k| {
            let (arrays, trial, rounded) = trial(*k);
            (arrays, trial, rounded.deviation(&wanted), *k == r)
        });
        let found = tried.find(|(_, _, errors, is_last)| *is_last || is_enough(*errors));
        let Some((stored, rounded, errors, _)) = found else { return };
        *blob = rounded;
        body["shapes"] = stored.shapes.into();
        body["coordinates"] = json!(stored.coordinates);
        body["rates"] = json!(stored.rates);
        let part = |error: f64, whole: f64| if whole > 0.0 { error / whole } else { 0.0 };
        body["errors"] = json!({
            "displacement": part(errors.displacement, sizes.displacement),
            "speed": part(errors.rate, sizes.rate),
            "von_mises": fineness.stress_bits.map(|_| part(errors.von_mises, sizes.von_mises)),
        });
    }
}

/// Arrays of shapes and coordinates.
struct Stored {
    shapes: Vec<Value>,
    coordinates: Vec<Array>,
    rates: Vec<Array>,
}

/// Shapes and coordinates in `blob`, and as a reader gets them.
fn coded(shapes: &Shapes, blob: &mut Blob, fineness: &Fineness) -> (Stored, Shapes) {
    let mut rounded = shapes.clone();
    let column = |m: &Mat<f64>, k: usize| -> Vec<f64> { m.col(k).iter().copied().collect() };
    let row = |m: &Mat<f64>, k: usize| -> Vec<f64> { m.row(k).iter().copied().collect() };
    let mut stored = Stored { shapes: Vec::new(), coordinates: Vec::new(), rates: Vec::new() };
    for k in 0..shapes.displacement.ncols() {
        let u = column(&shapes.displacement, k);
        let array = blob.quantised(&u, 3, fineness.displacement_bits);
        write_column(&mut rounded.displacement, k, &array.rounded(&u));
        let stress = fineness.stress_bits.filter(|_| shapes.stress.nrows() > 0).map(|bits| {
            let s = column(&shapes.stress, k);
            let array = blob.quantised(&s, 6, bits);
            write_column(&mut rounded.stress, k, &array.rounded(&s));
            array
        });
        stored.shapes.push(json!({ "displacement": array, "stress": stress }));
    }
    for k in 0..shapes.coordinates.nrows() {
        let lists = [
            (&shapes.coordinates, &mut rounded.coordinates, &mut stored.coordinates),
            (&shapes.rates, &mut rounded.rates, &mut stored.rates),
        ];
        for (exact, rounded, arrays) in lists {
            let values = row(exact, k);
            let array = blob.quantised(&values, 1, COORDINATE_BITS);
            let read = array.rounded(&values);
            (0..read.len()).for_each(|t| rounded[(k, t)] = read[t]);
            arrays.push(array);
        }
    }
    (stored, rounded)
}

fn write_column(matrix: &mut Mat<f64>, k: usize, values: &[f64]) {
    values.iter().enumerate().for_each(|(i, x)| matrix[(i, k)] = *x);
}
