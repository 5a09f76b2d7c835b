//! Friction of a Hertz contact: springs of all depths between two material points, with stick and
//! slip (docs/theory.md Eqs. C.86 to C.89).
//!
//! Within a step the references stay, so that forces are functions of time and state; what the last
//! evaluation found is accepted at the end of the step (docs/decisions/0005-friction.md).

use ffr_dynamics::force::{BodyState, Motion};
use nalgebra::Vector3;

use super::geometry::{Curved, Touch, tangents};
use super::levels::{Depths, Returned, returned};
use crate::contact_element::ContactReport;
use crate::law::Solid;
use crate::quasistatic::sliding_work::SlidingWork;

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

/// Stiffness of the springs of a touch, which it keeps: of all together over `k`'s of the levels,
/// along both tangents [N/m^1.5].
type SpringStiffness = [f64; 2];

/// From what slip counts.
#[derive(Debug, Clone)]
struct Reference {
    /// Material points of the contact body and of the target that were in one place, undeformed, in
    /// their frames.
    points: [Vector3<f64>; 2],
    /// Their mode shapes.
    shapes: [Vec<Vector3<f64>>; 2],
    /// Tangents in the frame of the target.
    tangents_in_target: [Vector3<f64>; 2],
    /// None where the bodies were apart.
    stiffness: Option<SpringStiffness>,
    /// Stretches of the springs along the tangents \[m\].
    stretches: Vec<[f64; 2]>,
}

impl Reference {
    fn new(n: usize, shapes: &[Vec<Vector3<f64>>; 2]) -> Self {
        Self {
            points: [Vector3::zeros(); 2],
            shapes: shapes.clone(),
            tangents_in_target: [Vector3::zeros(); 2],
            stiffness: None,
            stretches: vec![[0.0; 2]; n],
        }
    }

    fn copy_from(&mut self, other: &Self) {
        (self.points, self.stiffness) = (other.points, other.stiffness);
        self.tangents_in_target = other.tangents_in_target;
        for (own, others) in self.shapes.iter_mut().zip(&other.shapes) {
            own.copy_from_slice(others);
        }
        self.stretches.copy_from_slice(&other.stretches);
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

    /// Mode shapes of the points between which slip is measured.
    pub(super) fn shapes(&self) -> &[Vec<Vector3<f64>>; 2] {
        &self.reference.shapes
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
struct Frame<'a>(Option<&'a BodyState>);

impl Frame<'_> {
    fn vector(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.0.map_or(*v, |state| state.rotation.inverse_transform_vector(v))
    }

    fn in_space(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.0.map_or(*v, |state| state.rotation * v)
    }

    fn origin(&self) -> Vector3<f64> {
        self.0.map_or_else(Vector3::zeros, |state| state.position)
    }

    fn displacement(&self, shapes: &[Vector3<f64>]) -> Vector3<f64> {
        self.0.map_or_else(Vector3::zeros, |state| combined(shapes, &state.elastic))
    }

    /// Velocity, in space, of a point of the body at `arm` from its origin, in its frame, with the
    /// mode shapes `shapes`.
    fn velocity(&self, arm: &Vector3<f64>, shapes: &[Vector3<f64>]) -> Vector3<f64> {
        self.0.map_or_else(Vector3::zeros, |state| {
            let local = state.angular_velocity_in_body.cross(arm) + combined(shapes, &state.elastic_rates);
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
        // Material points in the middle between the nearest places.
        let middle = (touch.points[0] + touch.points[1]) * 0.5;
        for (side, frame) in frames.iter().enumerate() {
            found.next.points[side] =
                frame.vector(&(middle - frame.origin())) - frame.displacement(&shapes[side]);
            found.next.shapes[side].copy_from_slice(&shapes[side]);
        }
        let normal_in_target = frames[1].vector(&touch.normal);
        found.next.stiffness = pressed.curved.map(|curved| {
            let k = curved.ellipse.stiffness();
            curved.ellipse.tangential_ratios(pressed.solids).map(|ratio| ratio * k)
        });
        let directions = pressed.curved.map_or_else(|| tangents(&touch.normal), |curved| curved.axes);
        found.next.tangents_in_target = directions.map(|t| frames[1].vector(&t));
        if !state.is_known {
            found.next.stretches.fill([0.0; 2]);
            state.reference.copy_from(&found.next);
            state.reference.stiffness = None;
            state.is_known = true;
        }
        let reference = &state.reference;
        let (slip, rate) = self.slip(&frames, reference, found);
        // Springs and tangents of a touch stay those of its beginning.
        if reference.stiffness.is_some() && pressed.curved.is_some() {
            found.next.stiffness = reference.stiffness;
            found.next.tangents_in_target = turned(&reference.tangents_in_target, &normal_in_target);
        }
        let used = if reference.stiffness.is_some() {
            reference.tangents_in_target
        } else {
            found.next.tangents_in_target
        };
        let along = |v: &Vector3<f64>| used.each_ref().map(|t| t.dot(v));
        let force = self.springs(pressed, &frames, [along(&slip), along(&rate)], reference, found);
        found.force = frames[1].in_space(&(used[0] * force[0] + used[1] * force[1]));
        found.is_known = true;
    }

    /// Way of the contact body's point over the target since the reference and its rate, in the
    /// target's frame; notes where it is.
    fn slip(
        &self,
        [own, target]: &[Frame<'_>; 2],
        reference: &Reference,
        found: &mut SlidingFound,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let [own_shapes, target_shapes] = &reference.shapes;
        let own_arm = reference.points[0] + own.displacement(own_shapes);
        found.point = own.origin() + own.in_space(&own_arm);
        let arm = target.vector(&(found.point - target.origin()));
        let slip = arm - target.displacement(target_shapes) - reference.points[1];
        let rate = own.velocity(&own_arm, own_shapes) - target.velocity(&arm, target_shapes);
        (slip, target.vector(&rate))
    }

    /// Sum of the springs' forces along the tangents; notes energy, work and stretches.
    fn springs(
        &self,
        pressed: &Pressed<'_>,
        frames: &[Frame<'_>; 2],
        [slip, slip_rate]: [[f64; 2]; 2],
        reference: &Reference,
        found: &mut SlidingFound,
    ) -> [f64; 2] {
        (found.energy, found.work, found.is_sliding) = (0.0, SlidingWork::default(), false);
        found.next.stretches.fill([0.0; 2]);
        let (Some(curved), Some(stiffness)) = (pressed.curved, found.next.stiffness) else { return [0.0; 2] };
        let approach = -pressed.touch.gap;
        let closing = {
            let velocity = |side: usize| {
                let arm = frames[side].vector(&(pressed.touch.points[side] - frames[side].origin()));
                frames[side].velocity(&arm, &found.next.shapes[side])
            };
            (velocity(1) - velocity(0)).dot(&pressed.touch.normal)
        };
        let bound = self.coefficient * curved.ellipse.stiffness();
        let (mut sum, mut all_slide, mut any) = ([0.0; 2], true, false);
        for (level, share) in self.depths.at(approach).enumerate() {
            let compliance = stiffness.map(|k| 1.0 / (k * share.stiffness));
            let stretch = [0, 1].map(|a| reference.stretches[level][a] + slip[a]);
            let spring = returned(stretch, compliance, bound * share.force);
            for a in 0..2 {
                sum[a] += spring.force[a];
                found.energy += 0.5 * compliance[a] * spring.force[a].powi(2);
                found.next.stretches[level][a] = -compliance[a] * spring.force[a];
            }
            (all_slide, any) = (all_slide && spring.slip > 0.0, true);
            let bounds = (bound * share.force, bound * share.rate * closing);
            found.work = found.work.plus(work(&spring, compliance, slip_rate, bounds));
        }
        found.is_sliding = all_slide && any;
        sum
    }
}

/// Work that a spring loses to sliding, its bound being `bound` and growing by `bound_rate`
/// (Eqs. C.89, F.15).
fn work(
    spring: &Returned,
    compliance: [f64; 2],
    stretch_rate: [f64; 2],
    (bound, bound_rate): (f64, f64),
) -> SlidingWork {
    let Returned { force, slip } = *spring;
    if slip <= 0.0 || bound <= 0.0 {
        return SlidingWork::default();
    }
    let over = |v: [f64; 2]| -> f64 { (0..2).map(|a| force[a] * v[a] / (compliance[a] + slip)).sum() };
    let slip_rate = -(bound * bound_rate + over(stretch_rate)) / over(force);
    // The slid way `γ b` and its rate.
    let (way, way_rate) = (slip * bound, slip_rate * bound + slip * bound_rate);
    SlidingWork { power: bound * way_rate, slid: bound * way, slid_rate: bound_rate * way + bound * way_rate }
}

/// The tangents `before`, brought into the plane across `normal` without a turn about it.
fn turned(before: &[Vector3<f64>; 2], normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let first = before[0] - normal * normal.dot(&before[0]);
    let first = first.try_normalize(0.0).unwrap_or(before[0]);
    let second = normal.cross(&first);
    if second.dot(&before[1]) < 0.0 { [first, -second] } else { [first, second] }
}
