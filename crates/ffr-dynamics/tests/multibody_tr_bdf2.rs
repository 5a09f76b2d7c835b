//! TR-BDF2 on multibody systems and tangent frames: derivatives, agreement with the explicit method, energy, closed loops.

use crate::common;
use crate::dynamics_support::{Random, Sample, block, rotation_of_gradient};
use crate::free_motion::{body_state, free_system, state_vector};
use crate::oracles::modal_truncation;
use ffr_dynamics::body::{AssembledBody, ModalDamping, RigidMotion, StandardInputData};
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, Findings, ForceElement, ForceEnergies, GeneralisedForce, Motion};
use ffr_dynamics::integration::{Integrator, Linearisation, Method, OdeSystem, Statistics, StepSettings};
use ffr_dynamics::kinematics::{FlexiblePoint, Marker};
use ffr_dynamics::reduction::ReducedBasis;
use ffr_dynamics::system::{
    Attachment, BodySpec, ErrorScale, GROUND, JointKind, JointSpec, Multibody, SystemSpec,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Turns the z axis of a marker into y.
fn hinge_axis() -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::x() * -std::f64::consts::FRAC_PI_2)
}

fn scale(relative: f64) -> ErrorScale {
    ErrorScale { relative, ..ErrorScale::default() }
}

fn run<S: OdeSystem>(method: Method, system: &mut S, y: &[f64], t_end: f64) -> (Vec<f64>, Statistics) {
    let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, y, system).unwrap();
    integrator.run(system, t_end, |_, _| true).unwrap();
    (integrator.state().to_vec(), integrator.statistics())
}

/// A flexible block, its markers at two corners, in its Buckens frame or in the tangent frame of the first.
fn block_body(sample: &Sample, name: &str, is_tangent: bool) -> BodySpec {
    let marker = |name: &str, a: usize| sample.marker(name, a, hinge_axis(), |j| sample.nodal_rotation(a, j));
    in_frame(
        BodySpec {
            name: name.to_string(),
            data: sample.data.clone(),
            markers: vec![marker("hinge", 0), marker("tip", 11)],
        },
        is_tangent,
    )
}

/// The body in the tangent frame of its first marker, if asked for.
fn in_frame(mut body: BodySpec, is_tangent: bool) -> BodySpec {
    if is_tangent {
        let frame = body.markers[0].tangent_frame(RigidMotion::Spatial);
        body.data = body.data.in_tangent_frame(&frame).unwrap();
        body.markers = body.markers.iter().map(|m| m.in_tangent_frame(&frame).unwrap()).collect();
    }
    body
}

/// A chain of bodies with joints of the kinds given, from ground on.
fn chain(bodies: Vec<BodySpec>, kinds: &[JointKind], gravity: Vector3<f64>) -> SystemSpec {
    let joints = kinds.iter().enumerate().map(|(i, kind)| {
        let parent = if i == 0 {
            Attachment::new(GROUND, "pivot")
        } else {
            Attachment::new(&bodies[i - 1].name, "tip")
        };
        JointSpec::new(&format!("joint {i}"), *kind, parent, Attachment::new(&bodies[i].name, "hinge"))
    });
    SystemSpec {
        joints: joints.collect(),
        ground: vec![Marker::rigid("pivot", Vector3::zeros(), hinge_axis())],
        bodies,
        gravity,
        ..SystemSpec::default()
    }
}

fn build(spec: SystemSpec, relative: f64) -> Multibody {
    let mut system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
    system.set_error_scale(scale(relative)).unwrap();
    system
}

/// Largest deviation of column `j` from central differences of the rates `rows` along component `i`, against the column.
fn deviation<S: OdeSystem>(system: &mut S, y: &[f64], i: usize, rows: &[usize], column: &[f64]) -> f64 {
    let mut rates = |step: f64| {
        let (mut moved, mut rates) = (y.to_vec(), vec![0.0; y.len()]);
        moved[i] += step;
        system.rhs(0.0, &moved, &mut rates).unwrap();
        rates
    };
    let (forth, back) = (rates(1e-6), rates(-1e-6));
    let size = column.iter().map(|c| c.abs()).fold(0.0, f64::max);
    let pairs = column.iter().zip(rows).map(|(c, &row)| (c - (forth[row] - back[row]) / 2e-6).abs());
    pairs.fold(0.0, f64::max) / size
}

#[test]
fn derivatives_of_a_body_in_a_tangent_frame_agree_with_differences() {
    let sample = block(RigidMotion::Spatial, 6);
    let mut data = block_body(&sample, "block", true).data;
    data.modal_damping =
        ModalDamping::PerMode(data.modal_stiffness.iter().map(|k| 0.02 * k.sqrt()).collect());
    let mut start = Random(7).state(&data);
    start.elastic.fill(0.0);
    start.elastic_rates.fill(0.0);
    let mut system: Multibody = free_system(vec![("block", data)], Vector3::zeros(), vec![]);
    let y = state_vector(&system, &[start]);
    let layout = system.model().bodies[0].layout;
    let rows: Vec<usize> = layout.elastic_rates().chain(layout.velocities()).collect();
    let mut derivative = Linearisation::new(rows.len());
    system.linearise(0.0, &y, &mut derivative).unwrap();
    for j in 0..6 {
        // Left out by intent: what the deformation changes in the inertia, quadratic in the angular velocity of 20 rad/s,
        // against stiffness terms of 1e7 1/s². Rates enter linearly: differences are exact but for round-off.
        let column = derivative.position_column(j).to_vec();
        let by_position = deviation(&mut system, &y, layout.elastic().start + j, &rows, &column);
        let column = derivative.velocity_column(j).to_vec();
        let by_rate = deviation(&mut system, &y, layout.elastic_rates().start + j, &rows, &column);
        assert!(by_position < 1e-3 && by_rate < 1e-6, "{j}: {by_position:e} {by_rate:e}");
    }
}

/// Ties a point of the second body to its place and velocity.
struct Tie {
    point: FlexiblePoint,
    place: Vector3<f64>,
    velocity: Vector3<f64>,
}

#[derive(Default)]
struct Nothing;

impl Findings for Nothing {
    fn energies(&self) -> ForceEnergies {
        ForceEnergies::default()
    }

    fn resultant(&self) -> Vector3<f64> {
        Vector3::zeros()
    }
}

impl Tie {
    /// Force per displacement and per velocity, as stiff as the block.
    const PER: [f64; 2] = [-1e8, -5e2];
}

impl ForceElement for Tie {
    type State = ();
    type Workspace = ();
    type Found = Nothing;

    fn start(&self) -> ((), (), Nothing) {
        Default::default()
    }

    fn evaluate(
        &self,
        Motion { bodies, .. }: Motion<'_>,
        (): &mut (),
        (): &mut (),
        _: &mut Nothing,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let moved = self.point.position(&bodies[1]) - self.place;
        let faster = self.point.velocity(&bodies[1]) - self.velocity;
        let force = moved * Self::PER[0] + faster * Self::PER[1];
        self.point.add_force(&bodies[1], &force, &mut forces[1]);
        Ok(())
    }

    fn rates(
        &self,
        (Motion { bodies, .. }, by_velocity): (Motion<'_>, bool),
        (): &mut (),
        (): &mut (),
        _: &Nothing,
        rates: &mut [GeneralisedForce],
    ) -> bool {
        let rate = self.point.velocity(&bodies[1]) * Self::PER[usize::from(by_velocity)];
        self.point.add_force(&bodies[1], &rate, &mut rates[1]);
        true
    }
}

/// The second body of a chain alone, or tied to a place at which it stands: it moves along the coordinates of the first as well.
#[test]
fn derivatives_of_a_tree_agree_with_differences() {
    let sample = block(RigidMotion::Spatial, 5);
    for (is_tangent, is_tied) in [(true, false), (false, false), (true, true), (false, true)] {
        let bodies =
            vec![block_body(&sample, "first", is_tangent), block_body(&sample, "second", is_tangent)];
        let point = bodies[1].markers[1].point();
        let chain = chain(bodies, &[JointKind::Revolute, JointKind::Spherical], Vector3::zeros());
        let mut system = build(chain.clone(), 1e-6);
        let mut y = system.rest();
        system.set_joint(&mut y, 0, &[0.4], &[3.0]).unwrap();
        system.set_joint(&mut y, 1, &[0.9, 0.1, 0.3, -0.2], &[1.0, -4.0, 2.0]).unwrap();
        if is_tied {
            let state = &system.body_states(0.0, &y)[1];
            let (place, velocity) = (point.position(state), point.velocity(state));
            let tie: Box<dyn ActiveForce> = Box::new(Active::new(Tie { point, place, velocity }));
            system = Multibody::new(chain, vec![tie]).unwrap();
            y = [y, vec![0.0; 3]].concat();
        }
        let layouts: Vec<_> = system.model().bodies.iter().map(|b| b.layout).collect();
        let rows: Vec<usize> = layouts.iter().flat_map(|l| l.elastic_rates().chain(l.velocities())).collect();
        let mut derivative = Linearisation::new(rows.len());
        system.linearise(0.0, &y, &mut derivative).unwrap();
        for layout in &layouts {
            for (j, unknown) in layout.rates_elastic().enumerate() {
                // Levers and inertia change with the deformation by terms of the order of the squared angular velocity of
                // 5 rad/s, against stiffness terms of 1e7 1/s².
                let column = derivative.position_column(unknown).to_vec();
                let off = deviation(&mut system, &y, layout.elastic().start + j, &rows, &column);
                assert!(off < 1e-4, "{is_tangent} {is_tied} {unknown}: {off:e}");
                // What a body gives to those that hang on it by turning, some 10 1/s, is left out beside 500 1/s of the damper.
                let column = derivative.velocity_column(unknown).to_vec();
                let off = deviation(&mut system, &y, layout.elastic_rates().start + j, &rows, &column);
                assert!(!is_tied || off < 3e-2, "{is_tangent} {unknown}: {off:e} by velocities");
            }
        }
    }
}

#[test]
fn free_body_in_a_tangent_frame_agrees_with_the_explicit_method() {
    let sample = block(RigidMotion::Spatial, 8);
    let mut counts = Vec::new();
    for is_tangent in [true, false] {
        let body = block_body(&sample, "block", is_tangent);
        let tip = body.markers[1].clone();
        let mut system: Multibody = free_system(vec![("block", body.data)], GRAVITY, vec![]);
        let mut start = BodyState::at_rest(8);
        start.angular_velocity_in_body = Vector3::new(100.0, 50.0, -80.0);
        start.elastic[0] = 1e-4;
        let y = state_vector(&system, &[start]);
        system.set_error_scale(scale(1e-10)).unwrap();
        let (reference, _) = run(Method::DormandPrince, &mut system, &y, 1e-2);
        let reference = tip.place(&body_state(&mut system, &reference, 0));
        let before = system.invariants(0.0, &y).energy();
        system.set_error_scale(scale(1e-6)).unwrap();
        let (end, statistics) = run(Method::TrBdf2, &mut system, &y, 1e-2);
        let error = (tip.place(&body_state(&mut system, &end, 0)) - reference).norm();
        let loss = (before - system.invariants(0.0, &end).energy()) / before;
        // Errors of a step may add up; 0.2 m is the length. Rotation, which is not damped, may gain energy within them.
        let bound = 1e-6 * statistics.steps as f64;
        assert!(error < bound * 0.2, "{is_tangent}: {error:e} after {} steps", statistics.steps);
        assert!(loss.abs() < bound, "{is_tangent}: {loss:e}");
        counts.push(statistics.steps as f64);
    }
    // The size of an error does not depend on the frame, so that the steps are as many within some per cent.
    assert!((counts[0] / counts[1] - 1.0).abs() < 0.2, "{counts:?}");
}

/// Steel bar of 1 m x 20 mm x 20 mm along x with markers at its end faces.
struct Bar {
    body: AssembledBody,
    basis: ReducedBasis,
}

impl Bar {
    const LENGTH: f64 = 1.0;
    const WIDTH: f64 = 0.02;

    fn new(n_modes: usize) -> Self {
        let body = common::block(2, [8, 1, 1], [Self::LENGTH, Self::WIDTH, Self::WIDTH]);
        let basis = modal_truncation(&body, n_modes).unwrap();
        Self { body, basis }
    }

    /// Centre of an end face, with the mean displacement and rotation of its control points.
    fn marker(&self, name: &str, x: f64) -> Marker {
        let centre = Vector3::x() * x;
        let face: Vec<usize> =
            (0..self.body.nodes.len()).filter(|a| (self.body.nodes[*a][0] - x).abs() < 1e-9).collect();
        let second: Vec<usize> = (0..self.body.nodes.len())
            .filter(|a| {
                let d = (self.body.nodes[*a][0] - x).abs();
                d > 1e-9 && d < 0.6 * Self::LENGTH / 8.0
            })
            .collect();
        let shape = |a: usize, j: usize| Vector3::from_fn(|c, _| self.basis.shapes[(3 * a + c, j)]);
        let n = self.basis.n_modes();
        let (mut displacements, mut rotations) = (Vec::new(), Vec::new());
        for j in 0..n {
            let mean = face.iter().map(|a| shape(*a, j)).sum::<Vector3<f64>>() / face.len() as f64;
            let (mut moment, mut product) = (Matrix3::zeros(), Matrix3::zeros());
            for a in face.iter().chain(&second) {
                let d = Vector3::from_column_slice(&self.body.nodes[*a]) - centre;
                moment += d * d.transpose();
                product += (shape(*a, j) - mean) * d.transpose();
            }
            displacements.push(mean);
            rotations.push(rotation_of_gradient(&(product * moment.try_inverse().unwrap())));
        }
        Marker::flexible(name, centre, hinge_axis(), &displacements, &rotations).unwrap()
    }

    fn pendulum(&self, is_tangent: bool) -> SystemSpec {
        let stiffness: Vec<f64> = self.basis.omega.iter().map(|w| w * w).collect();
        let data = StandardInputData::new(&self.body, self.basis.shapes.as_ref(), &stiffness).unwrap();
        let markers = vec![self.marker("hinge", -0.5 * Self::LENGTH), self.marker("tip", 0.5 * Self::LENGTH)];
        let body = in_frame(BodySpec { name: "bar".to_string(), data, markers }, is_tangent);
        chain(vec![body], &[JointKind::Revolute], GRAVITY)
    }
}

/// Steps of the pendulum at the tolerances 1e-5 and 1e-6; the explicit method needs 3 370 at 1e-8, for the stability of its
/// eight modes.
const PENDULUM_STEPS: [u64; 2] = [675, 1621];

#[test]
fn flexible_pendulum_agrees_with_the_explicit_method() {
    let bar = Bar::new(8);
    let t_end = 0.2;
    for is_tangent in [true, false] {
        let mut system = build(bar.pendulum(is_tangent), 1e-9);
        let y = system.rest();
        let tip = system.marker("bar", "tip").unwrap().1.clone();
        let (reference, _) = run(Method::DormandPrince, &mut system, &y, t_end);
        let reference_tip = tip.place(&system.body_states(t_end, &reference)[0]);
        let kinetic = system.invariants(t_end, &reference).kinetic;
        let before = system.invariants(0.0, &y).energy();
        for (relative, steps) in [1e-5, 1e-6].into_iter().zip(PENDULUM_STEPS) {
            system.set_error_scale(scale(relative)).unwrap();
            let (end, s) = run(Method::TrBdf2, &mut system, &y, t_end);
            let error = (tip.place(&system.body_states(t_end, &end)[0]) - reference_tip).norm();
            let loss = (before - system.invariants(t_end, &end).energy()) / kinetic;
            // Demanded are 1e-4 of the length and a loss of 1e-3; found are 1.3e-6 and 4e-7.
            assert!(error < 1e-5 * Bar::LENGTH, "{is_tangent} {relative}: {error:e}");
            assert!((0.0..1e-6).contains(&loss), "{is_tangent} {relative}: {loss:e}");
            // A nearly linear motion: one derivative, one iteration per stage; round-off may move a few steps.
            assert!(s.jacobians <= 2 && s.iterations <= 2 * (s.steps + s.rejected) + 20, "{s:?}");
            assert!(s.steps.abs_diff(steps) < steps / 10, "{is_tangent} {relative}: {s:?}");
        }
    }
}

#[test]
fn stiff_modes_of_a_joined_body_do_not_decide_the_step() {
    // Sixteen modes instead of eight reach frequencies ten times as high; the first motion excites all of them.
    let steps = [4, 16].map(|n_modes| {
        let mut system = build(Bar::new(n_modes).pendulum(true), 1e-4);
        let y = system.rest();
        run(Method::TrBdf2, &mut system, &y, 0.5).1.steps
    });
    assert!(steps[1] < 2 * steps[0], "{steps:?}");
}

#[test]
fn a_stiff_body_on_a_softer_one_is_followed_by_the_standard_of_the_softer_one() {
    let sample = block(RigidMotion::Spatial, 6);
    let stiff = || {
        let mut body = block_body(&sample, "stiff", false);
        body.data.modal_stiffness.iter_mut().for_each(|k| *k *= 1e4); // a hundred times the frequencies
        body
    };
    let size = |bodies: Vec<BodySpec>| {
        let kinds = vec![JointKind::Revolute; bodies.len()];
        let mut system = build(chain(bodies, &kinds, Vector3::zeros()), 1e-5);
        let y = system.rest();
        let layout = system.model().bodies.last().unwrap().layout;
        let mut error = vec![0.0; y.len()];
        error[layout.elastic().start] = 1.0;
        system.damped_error_norm(&y, &y, &error)
    };
    let (alone, joined) = (size(vec![stiff()]), size(vec![block_body(&sample, "soft", false), stiff()]));
    // A displacement counts by the rate, which is that of the softer body: a hundredth.
    assert!((100.0 * joined / alone - 1.0).abs() < 1e-6, "{alone} {joined}");
}

#[test]
fn closed_ring_of_flexible_bodies_keeps_its_loop() {
    let sample = block(RigidMotion::Spatial, 5);
    let names = ["first", "second", "third"];
    for is_tangent in [true, false] {
        let joint = |i: usize| {
            let (parent, child) =
                (Attachment::new(names[i], "tip"), Attachment::new(names[(i + 1) % 3], "hinge"));
            JointSpec::new(&format!("joint {i}"), JointKind::Spherical, parent, child)
        };
        let spec = SystemSpec {
            bodies: names.map(|name| block_body(&sample, name, is_tangent)).to_vec(),
            joints: vec![joint(0), joint(1)],
            loops: vec![joint(2)],
            ..SystemSpec::default()
        };
        let mut system = build(spec, 1e-5);
        let mut y = system.rest();
        let third = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.2, std::f64::consts::TAU / 3.0));
        for i in 1..3 {
            let q = [third.w, third.i, third.j, third.k];
            system.set_joint(&mut y, i, &q, &[3.0, -4.0, 2.0]).unwrap();
        }
        system.assemble(0.0, &mut y).unwrap();
        let before = system.invariants(0.0, &y);
        let settings = StepSettings::default();
        let mut integrator = Integrator::new(Method::TrBdf2, settings, 0.0, &y, &system).unwrap();
        let mut drift: f64 = 0.0;
        let step = |system: &mut Multibody, at: &Integrator| {
            drift = drift.max(system.loop_residual(at.time(), at.state()));
            true
        };
        integrator.run(&mut system, 0.05, step).unwrap();
        let (after, s) = (system.invariants(0.05, integrator.state()), integrator.statistics());
        let change = (before.energy() - after.energy()) / before.kinetic;
        assert!(drift < 1e-10, "{drift:e}");
        assert!(change.abs() < 1e-5 * s.steps as f64, "{change:e} in {} steps", s.steps);
    }
}
