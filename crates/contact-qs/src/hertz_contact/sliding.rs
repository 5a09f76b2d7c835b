//! Friction of a Hertz contact: springs of all depths between two material points, with stick and
//! slip (docs/theory.md Eqs. C.86 to C.89).
//!
//! Within a step the references stay, so that forces are functions of time and state; what the last
//! evaluation found is accepted at the end of the step (docs/decisions/0005-friction.md).

use ffr_dynamics::force::{BodyState, Motion};
use nalgebra::{Isometry3, Point3, Vector3};

use super::geometry::{Curved, Touch, tangents};
use super::levels::{Depths, Returned, returned};
use crate::contact_element::ContactReport;
use crate::law::sliding_work::SlidingWork;
use crate::law::{Solid, TouchLaw};

/// Friction with its springs.
#[derive(Debug, Clone)]
pub(super) struct Sliding {
    coefficient: f64,
    depths: Depths,
}

/// What is pressed, and how.
pub(super) struct Pressed<'a> {
    pub touch: &'a Touch,
    /// None where the bodies are apart.
    pub curved: Option<&'a Curved>,
    pub solids: &'a [Solid; 2],
}

/// Stiffness of the springs of a touch, which it keeps: the law whose levels have them, and what they are along both
/// tangents over its normal stiffness.
type SpringStiffness = (TouchLaw, [f64; 2]);

/// From what slip counts.
#[derive(Debug, Clone)]
struct Reference {
    /// Material points of the contact body and of the target that were in one place, undeformed, in
    /// their frames.
    points: [Vector3<f64>; 2],
    /// Their mode shapes.
    shapes: [Vec<Vector3<f64>>; 2],
    /// Elastic coordinates that the bodies had.
    elastic: [Vec<f64>; 2],
    /// Where the contact body was in the frame of the target.
    pose: Isometry3<f64>,
    /// Tangents in the frame of the target.
    tangents_in_target: [Vector3<f64>; 2],
    /// None where the bodies were apart.
    stiffness: Option<SpringStiffness>,
    /// How far the bodies lay in each other, negative where they were apart \[m\].
    approach: f64,
    /// When that was \[s\].
    time: f64,
    /// Speed of the contact body over the target, in the frame of the target [m/s].
    rate: Vector3<f64>,
    /// What the springs held at most \[N\].
    bounds: Vec<f64>,
    /// Stretches of the springs along the tangents \[m\].
    stretches: Vec<[f64; 2]>,
}

impl Reference {
    fn new(n: usize, shapes: &[Vec<Vector3<f64>>; 2]) -> Self {
        Self {
            points: [Vector3::zeros(); 2],
            shapes: shapes.clone(),
            elastic: shapes.each_ref().map(|shapes| vec![0.0; shapes.len()]),
            pose: Isometry3::identity(),
            tangents_in_target: [Vector3::zeros(); 2],
            stiffness: None,
            approach: 0.0,
            time: 0.0,
            rate: Vector3::zeros(),
            bounds: vec![0.0; n],
            stretches: vec![[0.0; 2]; n],
        }
    }

    fn copy_from(&mut self, other: &Self) {
        (self.points, self.pose, self.stiffness) = (other.points, other.pose, other.stiffness);
        (self.tangents_in_target, self.approach) = (other.tangents_in_target, other.approach);
        (self.time, self.rate) = (other.time, other.rate);
        for (own, others) in self.shapes.iter_mut().zip(&other.shapes) {
            own.copy_from_slice(others);
        }
        for (own, others) in self.elastic.iter_mut().zip(&other.elastic) {
            own.copy_from_slice(others);
        }
        self.bounds.copy_from_slice(&other.bounds);
        self.stretches.copy_from_slice(&other.stretches);
    }

    /// Notes the material points at `middle`, with the mode shapes `shapes`, and how the bodies
    /// stand.
    fn stand(&mut self, frames: &[Frame<'_>; 2], middle: &Vector3<f64>, shapes: &[Vec<Vector3<f64>>; 2]) {
        for (side, frame) in frames.iter().enumerate() {
            frame.note_elastic(&mut self.elastic[side]);
            self.shapes[side].copy_from_slice(&shapes[side]);
            self.points[side] = frame.arm(middle) - combined(&shapes[side], &self.elastic[side]);
        }
        self.pose = frames[1].pose().inv_mul(&frames[0].pose());
    }

    /// How far the contact body's material point of `self` lay from that of the target when the
    /// bodies stood as in `standing`, in the frame of the target \[m\].
    fn apart(&self, standing: &Self) -> Vector3<f64> {
        let place = |side: usize| {
            Point3::from(self.points[side] + combined(&self.shapes[side], &standing.elastic[side]))
        };
        standing.pose * place(0) - place(1)
    }
}

/// State of the friction: from what slip counts; nothing before the first evaluation.
#[derive(Debug, Clone)]
pub struct SlidingState {
    reference: Reference,
    is_known: bool,
}

impl SlidingState {
    pub(super) fn new(n: usize, shapes: &[Vec<Vector3<f64>>; 2]) -> Self {
        Self { reference: Reference::new(n, shapes), is_known: false }
    }

    pub(super) fn accept(&mut self, found: &SlidingFound) {
        if found.is_known {
            self.reference.copy_from(&found.next);
            self.is_known = true;
        }
    }
}

/// What an evaluation of the friction finds.
#[derive(Debug, Clone)]
pub(super) struct SlidingFound {
    /// Force on the contact body, and where it acts on both, in space.
    pub force: Vector3<f64>,
    pub point: Vector3<f64>,
    energy: f64,
    work: SlidingWork,
    is_sliding: bool,
    /// From what slip will count if the step ends here.
    next: Reference,
    is_known: bool,
}

impl Default for SlidingFound {
    fn default() -> Self {
        Self::new(0, &[Vec::new(), Vec::new()])
    }
}

impl SlidingFound {
    pub fn new(n: usize, shapes: &[Vec<Vector3<f64>>; 2]) -> Self {
        Self {
            force: Vector3::zeros(),
            point: Vector3::zeros(),
            energy: 0.0,
            work: SlidingWork::default(),
            is_sliding: false,
            next: Reference::new(n, shapes),
            is_known: false,
        }
    }

    pub fn discard(&mut self) {
        self.is_known = false;
    }
}

/// Enters force, energy and lost work in `report`.
pub(super) fn record(found: &SlidingFound, report: &mut ContactReport) {
    report.friction_force = found.force;
    report.force += found.force;
    report.n_sliding = usize::from(found.is_sliding);
    report.energies.elastic_high += found.energy;
    found.work.enter(&mut report.energies);
}

/// A body, or space itself under a plane, as a frame.
pub(super) struct Frame<'a>(pub Option<&'a BodyState>);

impl Frame<'_> {
    pub fn is_at_rest(&self) -> bool {
        self.0.is_none_or(BodyState::is_at_rest)
    }

    fn vector(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.0.map_or(*v, |state| state.rotation.inverse_transform_vector(v))
    }

    fn in_space(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.0.map_or(*v, |state| state.rotation * v)
    }

    /// From the origin to `place`, in the frame.
    fn arm(&self, place: &Vector3<f64>) -> Vector3<f64> {
        self.0.map_or(*place, |state| state.rotation.inverse_transform_vector(&(place - state.position)))
    }

    fn pose(&self) -> Isometry3<f64> {
        self.0.map_or_else(Isometry3::identity, |state| {
            Isometry3::from_parts(state.position.into(), state.rotation)
        })
    }

    fn note_elastic(&self, elastic: &mut [f64]) {
        let Some(state) = self.0 else { return };
        for (own, q) in elastic.iter_mut().zip(&state.elastic) {
            *own = *q;
        }
    }

    /// Velocity, in space, of the body's material point at `place` of space with the mode shapes
    /// `shapes`.
    pub fn velocity(&self, place: &Vector3<f64>, shapes: &[Vector3<f64>]) -> Vector3<f64> {
        self.0.map_or_else(Vector3::zeros, |state| {
            let arm = self.arm(place);
            let local = state.angular_velocity_in_body.cross(&arm) + combined(shapes, &state.elastic_rates);
            state.velocity + state.rotation * local
        })
    }
}

fn combined(shapes: &[Vector3<f64>], coordinates: &[f64]) -> Vector3<f64> {
    shapes.iter().zip(coordinates).fold(Vector3::zeros(), |sum, (shape, q)| sum + shape * *q)
}

impl Sliding {
    pub fn new(coefficient: f64, size: f64) -> Self {
        Self { coefficient, depths: Depths::new(size) }
    }

    pub fn n_levels(&self) -> usize {
        self.depths.n_levels()
    }

    /// Forces of the springs at `motion` of the `bodies`, of which a plane is none; `shapes`: mode
    /// shapes where they are nearest.
    pub fn evaluate(
        &self,
        (motion, bodies): (Motion<'_>, [Option<usize>; 2]),
        pressed: &Pressed<'_>,
        shapes: &[Vec<Vector3<f64>>; 2],
        (state, found): (&mut SlidingState, &mut SlidingFound),
    ) {
        let frames = bodies.map(|body| Frame(body.map(|body| &motion.bodies[body])));
        let touch = pressed.touch;
        found.point = (touch.points[0] + touch.points[1]) * 0.5;
        found.next.stand(&frames, &found.point, shapes);
        (found.next.approach, found.next.time) = (-touch.gap, motion.time);
        let velocity = |side: usize| frames[side].velocity(&found.point, &shapes[side]);
        found.next.rate = frames[1].vector(&(velocity(0) - velocity(1)));
        let normal_in_target = frames[1].vector(&touch.normal);
        found.next.stiffness =
            pressed.curved.map(|curved| (curved.law, curved.law.tangential_ratios(pressed.solids)));
        let directions = pressed.curved.map_or_else(|| tangents(&touch.normal), |curved| curved.axes);
        found.next.tangents_in_target = directions.map(|t| frames[1].vector(&t));
        if !state.is_known {
            found.next.stretches.fill([0.0; 2]);
            found.next.bounds.fill(0.0);
            state.reference.copy_from(&found.next);
            state.reference.stiffness = None;
            state.is_known = true;
        }
        let reference = &state.reference;
        // Springs and tangents of a touch stay those of its beginning.
        let mut before = found.next.tangents_in_target;
        if reference.stiffness.is_some() && pressed.curved.is_some() {
            found.next.stiffness = reference.stiffness;
            before = reference.tangents_in_target;
            found.next.tangents_in_target = turned(&before, &normal_in_target);
        }
        let now = found.next.tangents_in_target;
        let path = Path {
            time: motion.time - reference.time,
            slip: slip(reference, &found.next, [&before, &now]),
            rate: now.map(|t| t.dot(&found.next.rate)),
            first_rate: before.map(|t| t.dot(&reference.rate)),
        };
        let force = self.springs(pressed, &frames, &path, reference, found);
        found.force = frames[1].in_space(&(now[0] * force[0] + now[1] * force[1]));
        found.is_known = true;
    }

    /// Sum of the springs' forces along the tangents; notes energy, work and stretches.
    fn springs(
        &self,
        pressed: &Pressed<'_>,
        frames: &[Frame<'_>; 2],
        path: &Path,
        reference: &Reference,
        found: &mut SlidingFound,
    ) -> [f64; 2] {
        (found.energy, found.work, found.is_sliding) = (0.0, SlidingWork::default(), false);
        found.next.stretches.fill([0.0; 2]);
        found.next.bounds.fill(0.0);
        let (Some(curved), Some((law, ratios))) = (pressed.curved, found.next.stiffness) else {
            return [0.0; 2];
        };
        let approach = -pressed.touch.gap;
        let closing = {
            let velocity =
                |side: usize| frames[side].velocity(&pressed.touch.points[side], &found.next.shapes[side]);
            (velocity(1) - velocity(0)).dot(&pressed.touch.normal)
        };
        let (mut sum, mut all_slide, mut any) = ([0.0; 2], true, false);
        let whole = self.depths.shares(law, f64::INFINITY).map(|share| share.rate);
        for (level, (share, stiffness)) in self.depths.shares(curved.law, approach).zip(whole).enumerate() {
            let compliance = ratios.map(|ratio| 1.0 / (ratio * stiffness));
            let bounds = (self.coefficient * share.force, self.coefficient * share.rate * closing);
            let part = since_reached(share.depth, [reference.approach, approach], closing);
            let held = Held { stretch: reference.stretches[level], bound: reference.bounds[level] };
            let spring = held.pulled([path.way(part), path.way_at_stage(part)], compliance, bounds);
            for a in 0..2 {
                sum[a] += spring.force[a];
                found.energy += 0.5 * compliance[a] * spring.force[a].powi(2);
                found.next.stretches[level][a] = -compliance[a] * spring.force[a];
            }
            found.next.bounds[level] = bounds.0;
            (all_slide, any) = (all_slide && spring.is_sliding, true);
            found.work = found.work.plus(spring.work);
        }
        found.is_sliding = all_slide && any;
        sum
    }
}

/// Way of the contact body over the target along the tangents, which were `tangents[0]` and are
/// `tangents[1]`, from `then` until `now` \[m\]: mean of what has parted since the points that
/// touched then, and what parted then those that touch now (Eq. C.88).
fn slip(then: &Reference, now: &Reference, tangents: [&[Vector3<f64>; 2]; 2]) -> [f64; 2] {
    let (parted, met) = (then.apart(now), now.apart(then));
    [0, 1].map(|a| 0.5 * (tangents[1][a].dot(&parted) - tangents[0][a].dot(&met)))
}

/// Part of the slip since the last update of the references, when the approach was `then`, that
/// came after it reached `depth`, if both grew in proportion until `now`; and its rate where it
/// grows by `closing`.
fn since_reached(depth: f64, [then, now]: [f64; 2], closing: f64) -> (f64, f64) {
    if depth <= then || now <= depth {
        return (1.0, 0.0);
    }
    let way = now - then;
    ((now - depth) / way, closing * (depth - then) / (way * way))
}

/// Share of a step at which the first stage of its slide lies, `1 - 1/√2`: with it the rule of two
/// stages is of second order and forgets at once what long slides leave behind.
const STAGE: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// What the slide of the first stage counts at the end of the step.
const STAGE_WEIGHT: f64 = (1.0 - STAGE) / STAGE;

/// Slip along the tangents since the last update of the references.
struct Path {
    /// Time since then \[s\].
    time: f64,
    slip: [f64; 2],
    rate: [f64; 2],
    /// Its rate then.
    first_rate: [f64; 2],
}

/// A way or a force along the tangents, and its rate [m, m/s; N, N/s].
type Way = ([f64; 2], [f64; 2]);

impl Path {
    /// The part `part` of the slip, which has a rate.
    fn way(&self, part: (f64, f64)) -> Way {
        share(part, (self.slip, self.rate))
    }

    /// The part `part` of what the first stage slips: its share of the time, at the rate that a
    /// path of second order has there (Eq. C.88).
    fn way_at_stage(&self, part: (f64, f64)) -> Way {
        let [time, one] = if self.time > 0.0 { [self.time, 1.0] } else { [0.0; 2] };
        let blend = |first: f64, all: f64| STAGE * ((1.0 - 2.0 * STAGE) * first + 2.0 * STAGE * all);
        let way = [0, 1].map(|a| blend(self.first_rate[a] * time, self.slip[a]));
        let rate = [0, 1].map(|a| blend(self.first_rate[a] * one, self.rate[a]));
        share(part, (way, rate))
    }
}

fn share((part, part_rate): (f64, f64), (way, rate): Way) -> Way {
    (way.map(|w| part * w), [0, 1].map(|a| part * rate[a] + part_rate * way[a]))
}

/// A spring at the last update of the references.
struct Held {
    stretch: [f64; 2],
    bound: f64,
}

/// A spring now.
struct Pulled {
    force: [f64; 2],
    work: SlidingWork,
    is_sliding: bool,
}

impl Held {
    /// Force and lost work of the spring after the way `way`, `at_stage` at the first stage, its
    /// bound being `bound.0` and growing by `bound.1` (Eqs. C.88, C.89).
    fn pulled(&self, [way, at_stage]: [Way; 2], compliance: [f64; 2], bound: (f64, f64)) -> Pulled {
        let from = |w: [f64; 2]| [0, 1].map(|a| self.stretch[a] + w[a]);
        let middle = (self.bound + STAGE * (bound.0 - self.bound), STAGE * bound.1);
        let stage = Slide::new((from(at_stage.0), at_stage.1), compliance, middle);
        let whole = Slide::new((from(way.0), way.1), compliance, bound);
        let force = if stage.is_sliding {
            let weigh = |way: [f64; 2], slid: [f64; 2]| [0, 1].map(|a| way[a] - STAGE_WEIGHT * slid[a]);
            let left = (from(weigh(way.0, stage.way.0)), weigh(way.1, stage.way.1));
            aligned(whole.force, Slide::new(left, compliance, bound).force)
        } else {
            whole.force
        };
        let slid = [0, 1].map(|a| self.stretch[a] + way.0[a] + compliance[a] * force.0[a]);
        let slid_rate = [0, 1].map(|a| way.1[a] + compliance[a] * force.1[a]);
        let has_slid = stage.is_sliding || whole.is_sliding;
        let work = if has_slid { work(force, (slid, slid_rate)) } else { SlidingWork::default() };
        Pulled { force: force.0, work, is_sliding: whole.is_sliding }
    }
}

/// Lost power `-τ·ẇ`, and work `-τ·w`, of the force `force` over the slid way `way` (Eq. C.89).
fn work(force: Way, way: Way) -> SlidingWork {
    let power = -dot(force.0, way.1);
    SlidingWork { power, slid: -dot(force.0, way.0), slid_rate: power - dot(force.1, way.0) }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The force `force`, turned as far as the part of `towards` across it says; each with its rate.
fn aligned(force: Way, towards: Way) -> Way {
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let square = dot(force.0, force.0);
    let across = cross(force.0, towards.0);
    if square <= 0.0 || across == 0.0 {
        return force;
    }
    let tangent = across / square;
    let across_rate = cross(force.1, towards.0) + cross(force.0, towards.1);
    let tangent_rate = (across_rate - 2.0 * tangent * dot(force.0, force.1)) / square;
    let cosine = 1.0 / tangent.hypot(1.0);
    let (sine, angle_rate) = (cosine * tangent, tangent_rate * cosine * cosine);
    let turned = |v: [f64; 2]| [cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1]];
    let (now, rate) = (turned(force.0), turned(force.1));
    (now, [rate[0] - angle_rate * now[1], rate[1] + angle_rate * now[0]])
}

/// A spring that is stretched from where it sticks, by the implicit rule of Euler.
struct Slide {
    /// Force along both tangents and its rate.
    force: Way,
    /// Slid way `-γ τ` and its rate.
    way: Way,
    is_sliding: bool,
}

impl Slide {
    fn new((stretch, rate): Way, compliance: [f64; 2], (bound, bound_rate): (f64, f64)) -> Self {
        let Returned { force, slip } = returned(stretch, compliance, bound);
        if slip <= 0.0 || bound <= 0.0 {
            let held = if bound <= 0.0 { [0.0; 2] } else { [0, 1].map(|a| -rate[a] / compliance[a]) };
            return Self { force: (force, held), way: ([0.0; 2], [0.0; 2]), is_sliding: false };
        }
        let over = |v: [f64; 2]| -> f64 { (0..2).map(|a| force[a] * v[a] / (compliance[a] + slip)).sum() };
        let slip_rate = -(bound * bound_rate + over(rate)) / over(force);
        let force_rate = [0, 1].map(|a| -(rate[a] + slip_rate * force[a]) / (compliance[a] + slip));
        let way = force.map(|f| -slip * f);
        let way_rate = [0, 1].map(|a| -slip_rate * force[a] - slip * force_rate[a]);
        Self { force: (force, force_rate), way: (way, way_rate), is_sliding: true }
    }
}

/// The tangents `before`, brought into the plane across `normal` by the least turn, which is none
/// about it: a way back brings them back.
fn turned(before: &[Vector3<f64>; 2], normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let across = before[0].cross(&before[1]);
    let hand = if across.dot(normal) < 0.0 { -1.0 } else { 1.0 };
    let from = across * hand;
    let first = before[0] - (from + normal) * (normal.dot(&before[0]) / (1.0 + from.dot(normal)));
    let first = first.try_normalize(0.0).unwrap_or(before[0]);
    [first, normal.cross(&first) * hand]
}
