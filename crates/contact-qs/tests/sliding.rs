//! Bodies in motion that slide, stick and reverse: momentum relations of \[B\] section 7, energy ledger, hysteresis.

use std::f64::consts::{PI, TAU};

use crate::common::{Random, surface_compliance};
use crate::free_motion::{body_state, free_system, state_vector};
use contact_qs::quasistatic::compliance::sparse_rows::SparseRows;
use contact_qs::quasistatic::{Method, PointState};
use contact_qs::{ActiveContact, ContactSubmodel, Friction, Plane, PlaneContact, PlaneContactSettings};
use faer::Mat;
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use ffr_dynamics::integration::{Integrator, StepSettings};
use ffr_dynamics::system::{ErrorScale, Multibody};
use nalgebra::{Matrix3, Vector3};

/// The disc of \[B\] section 7, a metre thick.
const RADIUS: f64 = 0.1;
const MASS: f64 = 7850.0 * PI * RADIUS * RADIUS;
const INERTIA: f64 = 0.5 * MASS * RADIUS * RADIUS;
const SPEED: f64 = 0.1;
const SPIN: f64 = TAU;

/// Points `spacing` apart on the lower arc of a disc, or on a square of a ball's underside, with a compliance of surface
/// type; `coupling`: between normal and tangent, as a share.
fn zone(motion: RigidMotion, n: usize, spacing: f64, coupling: f64) -> ContactSubmodel {
    let nc = motion.n_components();
    let across = if motion == RigidMotion::Planar { 1 } else { n };
    let place =
        |k: usize| [(k % n) as f64 - 0.5 * (n - 1) as f64, (k / n) as f64 - 0.5 * (across - 1) as f64];
    let points: Vec<[f64; 3]> = (0..n * across)
        .map(|k| {
            let [x, y] = place(k).map(|i| i * spacing);
            let depth = -(RADIUS * RADIUS - x * x - y * y).sqrt();
            if nc == 2 { [x, depth, 0.0] } else { [x, y, depth] }
        })
        .collect();
    let n_points = points.len();
    let row = surface_compliance(n_points, 1e-11);
    let size = 1e-11;
    let compliance = Mat::from_fn(nc * n_points, nc * n_points, |i, j| {
        let (p, q) = (i / nc, j / nc);
        let (a, b) = (place(p), place(q));
        let distance = (a[0] - b[0]).hypot(a[1] - b[1]);
        if i % nc == j % nc {
            if nc == 2 { row[(p, q)] } else { size * (-0.7 * distance).exp() }
        } else if nc == 2 {
            // A pressed point pulls its neighbours towards it.
            let side = (b[0] - a[0]).signum() * f64::from(u8::from(p != q));
            let sign = if i % nc == 0 { 1.0 } else { -1.0 };
            coupling * sign * side * row[(p, q)]
        } else {
            0.0
        }
    });
    ContactSubmodel {
        motion,
        areas: vec![spacing * if nc == 2 { 1.0 } else { spacing }; n_points],
        low: Mat::zeros(nc * n_points, 0),
        compliance: compliance.into(),
        interface: SparseRows::default(),
        rim: vec![0, n_points - 1],
        facing: Vec::new(),
        left_out: Vec::new(),
        points,
    }
}

fn settings(motion: RigidMotion, penalty: f64) -> PlaneContactSettings {
    let normal = if motion == RigidMotion::Planar { Vector3::y_axis() } else { Vector3::z_axis() };
    PlaneContactSettings {
        body: 0,
        plane: Plane { point: Vector3::zeros(), normal },
        penalty,
        method: Method::ActiveSet,
    }
}

/// A disc (or a ball with as much mass) above the plane.
fn system(contact: PlaneContact, motion: RigidMotion) -> Multibody<Box<Active<PlaneContact>>> {
    let inertia = match motion {
        RigidMotion::Planar => Matrix3::from_diagonal(&Vector3::new(0.5 * INERTIA, 0.5 * INERTIA, INERTIA)),
        _ => Matrix3::identity() * INERTIA,
    };
    let data = StandardInputData::rigid(motion, MASS, Vector3::zeros(), inertia).unwrap();
    let mut system =
        free_system(vec![("disc", data)], Vector3::zeros(), vec![Box::new(Active::new(contact))]);
    let scale = ErrorScale { relative: 1e-9, ..system.error_scale() };
    system.set_error_scale(scale).unwrap();
    system
}

/// What a run through an impact found.
struct Outcome {
    state: BodyState,
    energy_before: f64,
    energy_after: f64,
    dissipated: f64,
    /// Largest deviation of the energy ledger, as a share of the energy at the start.
    drift: f64,
    /// Largest fall of the dissipated work, as a share of the energy at the start.
    fall: f64,
    was_stuck: bool,
    was_sliding: bool,
    is_rim_touched: bool,
    duration: f64,
}

fn run(system: &mut Multibody<Box<Active<PlaneContact>>>, start: &BodyState, max_step: f64) -> Outcome {
    let y = state_vector(system, std::slice::from_ref(start));
    let before = system.invariants(0.0, &y).kinetic;
    let mut integrator = Integrator::explicit(StepSettings::with_max_step(max_step), 0.0, &y).unwrap();
    let mut out = Outcome {
        state: start.clone(),
        energy_before: before,
        energy_after: before,
        dissipated: 0.0,
        drift: 0.0,
        fall: 0.0,
        was_stuck: false,
        was_sliding: false,
        is_rim_touched: false,
        duration: 0.0,
    };
    let mut n_open = 0;
    while n_open < 5 && integrator.time() < 5e-3 {
        integrator.step(system, 1.0).unwrap();
        let y = integrator.state();
        let report = *system.forces()[0].report();
        let states = system.forces()[0].state().point_states();
        out.was_stuck |= states.contains(&PointState::Stick);
        out.was_sliding |= states.contains(&PointState::Slip);
        out.is_rim_touched |= report.is_rim_touched;
        if report.n_active > 0 {
            (n_open, out.duration) = (0, integrator.time());
        } else {
            n_open += usize::from(out.duration > 0.0);
        }
        let work = system.dissipated_work(y);
        out.fall = out.fall.max((out.dissipated - work) / before);
        out.dissipated = work;
        out.energy_after = system.invariants(0.0, y).kinetic;
        let stored = report.energies.elastic_high + report.energies.penalty;
        out.drift = out.drift.max(((out.energy_after + stored + work) / before - 1.0).abs());
    }
    out.state = body_state(system, integrator.state(), 0);
    out
}

fn disc(friction: Friction, coupling: f64, penalty: f64) -> Multibody<Box<Active<PlaneContact>>> {
    let motion = RigidMotion::Planar;
    let contact = PlaneContact::new(zone(motion, 61, 4e-5, coupling), settings(motion, penalty)).unwrap();
    system(contact.with_friction(friction).unwrap(), motion)
}

fn dropped(motion: RigidMotion, velocity: Vector3<f64>, spin: Vector3<f64>) -> BodyState {
    let mut state = BodyState::at_rest(0);
    let up = if motion == RigidMotion::Planar { Vector3::y() } else { Vector3::z() };
    state.position = up * (RADIUS + 1e-9);
    (state.velocity, state.angular_velocity_in_body) = (velocity, spin);
    state
}

#[test]
fn spinning_disc_leaves_with_the_velocities_of_gross_sliding() {
    let mu = 0.3;
    let mut system = disc(Friction::new(mu), 0.1, 1e17);
    let start = dropped(RigidMotion::Planar, Vector3::new(0.0, -SPEED, 0.0), Vector3::new(0.0, 0.0, SPIN));
    let out = run(&mut system, &start, 1e-6);
    let (v, spin) = (out.state.velocity, out.state.angular_velocity_in_body.z);
    assert!(out.was_sliding && !out.is_rim_touched, "touched for {} s", out.duration);
    // [B] Eq. 44: the impulse ratio is exact, restitution within what coupling takes or gives.
    assert!((v.x / (-mu * (v.y + SPEED)) - 1.0).abs() < 1e-6, "{v}");
    assert!((v.y / SPEED - 1.0).abs() < 1e-2 && (v.x / -0.06 - 1.0).abs() < 1e-2, "{v}");
    // [B] Eq. 45; the lever arm is the radius to within the penetration of micrometres, 1e-4.
    let expected = (MASS * RADIUS * v.x + INERTIA * SPIN) / INERTIA;
    assert!((spin / expected - 1.0).abs() < 1e-4, "{spin} {expected}");
    assert!((spin / (1.618 * PI) - 1.0).abs() < 1e-2, "{}", spin / PI);
    let lost = out.energy_before - out.energy_after;
    // The power has a kink where a point enters or leaves: second order, (1/80)² of the work, a share of 1/20 each.
    assert!((out.dissipated / lost - 1.0).abs() < 1e-5, "{} {lost}", out.dissipated);
    // Work of sliding: force along the mean slip speed, which falls linearly with the impulse.
    let mean = 0.5 * (SPIN * RADIUS + spin * RADIUS + v.x);
    assert!((out.dissipated / (-MASS * v.x * mean) - 1.0).abs() < 2e-2);
    assert!(out.drift < 1e-5 && out.fall <= 0.0, "{:e} {:e}", out.drift, out.fall);
    println_figures("gross sliding", &out);
}

#[expect(clippy::print_stdout, reason = "figures of a test, shown on demand")]
fn println_figures(name: &str, out: &Outcome) {
    println!(
        "{name}: {:.3e} s, v = ({:.6}, {:.6}, {:.6}) m/s, spin {:.6} pi, lost {:.6e} J, dissipated {:.6e} J, drift {:.1e}, fall {:.1e}",
        out.duration,
        out.state.velocity.x,
        out.state.velocity.y,
        out.state.velocity.z,
        out.state.angular_velocity_in_body.z / PI,
        out.energy_before - out.energy_after,
        out.dissipated,
        out.drift,
        out.fall
    );
}

#[test]
fn disc_that_falls_straight_sticks_and_loses_nothing() {
    for penalty in [1e17, f64::INFINITY] {
        let mut system = disc(Friction::new(0.3), 0.0, penalty);
        let start = dropped(RigidMotion::Planar, Vector3::new(0.0, -SPEED, 0.0), Vector3::zeros());
        let out = run(&mut system, &start, 1e-6);
        assert!(out.was_stuck);
        // Round-off of the symmetric zone.
        assert!(out.dissipated.abs() < 1e-12 * out.energy_before, "{}", out.dissipated);
        assert!((out.state.velocity.y / SPEED - 1.0).abs() < 1e-6 && out.state.velocity.x.abs() < 1e-9);
        println_figures("straight", &out);
    }
}

#[test]
fn friction_takes_energy_whatever_the_motion_and_its_work_is_the_energy_lost() {
    let mut random = Random::new(2);
    let (mut n_stuck, mut n_sliding) = (0, 0);
    for case in 0..8 {
        let is_plane = case % 7 != 6;
        let motion = if is_plane { RigidMotion::Planar } else { RigidMotion::Spatial };
        let mu = 0.5 * (1.0 + random.next());
        let slow = if case % 2 == 0 { 0.1 } else { 1.0 };
        let (v, w) = (0.1 * slow * random.next(), 2.0 * slow * random.next());
        let (mut system, start) = if is_plane {
            let start = dropped(motion, Vector3::new(v, -SPEED, 0.0), Vector3::new(0.0, 0.0, w));
            (disc(Friction::new(mu), 0.1, 1e17), start)
        } else {
            let contact = PlaneContact::new(zone(motion, 9, 3e-4, 0.0), settings(motion, 1e15)).unwrap();
            let spin = Vector3::new(w, random.next(), 20.0 * random.next());
            let start = dropped(motion, Vector3::new(v, 0.02, -SPEED), spin);
            (self::system(contact.with_friction(Friction::new(mu)).unwrap(), motion), start)
        };
        let max_step = 1e-6;
        let out = run(&mut system, &start, max_step);
        println_figures(&format!("case {case}, mu {mu:.2}"), &out);
        (n_stuck, n_sliding) = (n_stuck + u32::from(out.was_stuck), n_sliding + u32::from(out.was_sliding));
        assert!(out.duration > 0.0);
        assert!(out.energy_after <= out.energy_before * (1.0 + 1e-9), "{case}");
        // The integrand has kinks where points begin to slide, and jumps with their slip of the step where they are let go: half
        // of (1/80)² of the work, for some 20 points a share of 1/20 each. The power itself would jump where they come to
        // rest: 2.1e-4.
        assert!(out.drift < 1e-4, "{case}: {:e}", out.drift);
        // A point that turns back within a step gives back what it lost since the step began: second order, (1/80)² of the
        // work, shared by some 20 points.
        assert!(out.fall < 1e-5, "{case}: {:e}", out.fall);
        let lost = out.energy_before - out.energy_after;
        assert!((out.dissipated - lost).abs() < 1e-3 * out.energy_before);
        // Where there is something to lose: at worst the jumps of all points fall at the same end of their steps, which is one
        // step's share of the work, at twice the mean power.
        let share = 2.0 * max_step / out.duration;
        assert!(lost < 1e-2 * out.energy_before || (out.dissipated / lost - 1.0).abs() < share, "{case}");
    }
    assert!(n_stuck > 4 && n_sliding > 6, "{n_stuck} {n_sliding}");
}

#[test]
fn reversed_sliding_follows_the_bilinear_loop() {
    // One spring a point, no compliance: the loop has the area 4 μN (X - μN/k).
    let motion = RigidMotion::Planar;
    let flat = ContactSubmodel {
        points: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        areas: vec![1e-4; 2],
        low: Mat::zeros(4, 0),
        compliance: Mat::zeros(0, 0).into(),
        rim: Vec::new(),
        facing: Vec::new(),
        left_out: Vec::new(),
        ..zone(motion, 2, 1.0, 0.0)
    };
    let (penalty, mu, depth, amplitude) = (1e9, 0.4, 1e-3, 3e-3);
    let contact = PlaneContact::new(flat, settings(motion, penalty))
        .unwrap()
        .with_friction(Friction { coefficient: mu, stiffness_ratio: 0.5 })
        .unwrap();
    let mut contact = Active::new(contact);
    let mut state = BodyState::at_rest(0);
    state.position.y = -depth;
    let mut forces = [GeneralisedForce::zeros(0)];
    let normal = 2e-4 * penalty * depth;
    let stiffness = 0.5 * 2e-4 * penalty;
    const STEPS: u32 = 4000;
    let (mut work, mut loop_work) = (0.0, 0.0);
    let (mut last_power, mut last_force, mut last_x) = (0.0, 0.0, 0.0);
    // A quarter to get onto the loop, then once around.
    for step in 0..=STEPS / 4 + STEPS {
        let phase = TAU * f64::from(step) / f64::from(STEPS);
        (state.position.x, state.velocity.x) = (amplitude * phase.sin(), amplitude * TAU * phase.cos());
        contact.evaluate(Motion::new(0.0, std::slice::from_ref(&state)), &mut forces).unwrap();
        contact.save();
        let power = contact.energies().dissipated_power;
        let force = contact.report().friction_force.x;
        assert!(power >= 0.0 && force.abs() <= mu * normal * (1.0 + 1e-14));
        if step > STEPS / 4 {
            work += 0.5 * (power + last_power) / f64::from(STEPS);
            loop_work -= 0.5 * (force + last_force) * (state.position.x - last_x);
        }
        (last_power, last_force, last_x) = (power, force, state.position.x);
    }
    let expected = 4.0 * mu * normal * (amplitude - mu * normal / stiffness);
    // Corners of the loop and switches of the power within a step of a 4000th: each a share of 1e-3 at most.
    assert!((loop_work / expected - 1.0).abs() < 1e-3, "{loop_work} {expected}");
    assert!((work / expected - 1.0).abs() < 3e-3, "{work} {expected}");
}
