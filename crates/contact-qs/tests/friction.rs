//! Friction in the plane contact: Coulomb's law at every point, the balance of power, history.

use crate::common::Random;
use contact_qs::quasistatic::broyden::BroydenSettings;
use contact_qs::quasistatic::compliance::sparse_rows::SparseRows;
use contact_qs::quasistatic::{Method, PointState};
use contact_qs::{
    ActiveContact, ContactError, ContactSubmodel, Friction, Plane, PlaneContact, PlaneContactSettings,
};
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

const N_POINTS: usize = 6;
const N_MODES: usize = 3;
const MU: f64 = 0.3;
const PENALTY: f64 = 1e9;
const MOTIONS: [RigidMotion; 3] = [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial];

/// A random zone some centimetres below the origin with a soft compliance, so that all terms matter.
fn submodel(motion: RigidMotion, quasistatic: bool, seed: u64) -> ContactSubmodel {
    let mut random = Random::new(seed);
    let nc = motion.n_components();
    let n_rows = N_POINTS * nc;
    // Coupled components, the diagonal stronger as on a surface.
    let soft = random.semidefinite(n_rows, n_rows, 2e-6);
    let compliance = Mat::from_fn(n_rows, n_rows, |i, j| soft[(i, j)] + if i == j { 3e-5 } else { 0.0 });
    let mut points = Vec::new();
    for _ in 0..N_POINTS {
        let mut point = [0.0; 3];
        (0..nc).for_each(|c| point[motion.direction(c)] = 0.005 * random.next());
        point[motion.direction(nc - 1)] -= 0.05;
        points.push(point);
    }
    ContactSubmodel {
        motion,
        points,
        areas: (0..N_POINTS).map(|_| 1e-4 * (1.5 + random.next())).collect(),
        low: random.matrix(n_rows, N_MODES),
        compliance: if quasistatic { compliance } else { Mat::zeros(0, 0) }.into(),
        interface: SparseRows::default(),
        rim: Vec::new(),
        facing: Vec::new(),
        left_out: Vec::new(),
    }
}

fn normal_of(motion: RigidMotion) -> Vector3<f64> {
    match motion {
        RigidMotion::Axial => Vector3::z(),
        RigidMotion::Planar => Vector3::new(0.3, 0.9, 0.0).normalize(),
        RigidMotion::Spatial => Vector3::new(0.3, -0.2, 0.9).normalize(),
    }
}

fn contact(motion: RigidMotion, quasistatic: bool, seed: u64) -> PlaneContact {
    let plane =
        Plane { point: Vector3::new(0.1, 0.2, 0.3), normal: UnitVector3::new_normalize(normal_of(motion)) };
    let settings = PlaneContactSettings { body: 0, plane, penalty: PENALTY, method: Method::ActiveSet };
    let contact = PlaneContact::new(submodel(motion, quasistatic, seed), settings).unwrap();
    contact.with_friction(Friction { coefficient: MU, stiffness_ratio: 0.7 }).unwrap()
}

/// A moving body pressed into the plane by about `depth`.
fn pressed(
    contact: &Active<PlaneContact>,
    motion: RigidMotion,
    depth: f64,
    random: &mut Random,
) -> BodyState {
    let mut state = BodyState::at_rest(N_MODES);
    let vector = |random: &mut Random| Vector3::new(random.next(), random.next(), random.next());
    state.position = Vector3::new(0.1, 0.2, 0.3);
    let (velocity, spin) = (vector(random), vector(random));
    match motion {
        RigidMotion::Axial => state.velocity.z = velocity.z,
        RigidMotion::Planar => {
            state.rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.7);
            state.velocity = Vector3::new(velocity.x, velocity.y, 0.0);
            state.angular_velocity_in_body.z = 10.0 * spin.z;
        }
        RigidMotion::Spatial => {
            state.rotation = UnitQuaternion::from_euler_angles(0.4, -0.3, 0.9);
            (state.velocity, state.angular_velocity_in_body) = (velocity, 10.0 * spin);
        }
    }
    state.elastic = vec![1e-3, -2e-3, 1.5e-3];
    state.elastic_rates = (0..N_MODES).map(|_| random.next()).collect();
    state.position -= normal_of(motion) * (contact.element().smallest_gap_at(&state) + depth);
    state
}

/// The state `dt` later, at constant velocities.
fn moved(state: &BodyState, dt: f64) -> BodyState {
    let mut later = state.clone();
    later.position += state.velocity * dt;
    later.rotation *= UnitQuaternion::from_scaled_axis(state.angular_velocity_in_body * dt);
    later.elastic.iter_mut().zip(&state.elastic_rates).for_each(|(q, rate)| *q += rate * dt);
    later
}

fn evaluate(contact: &mut Active<PlaneContact>, state: &BodyState) -> (GeneralisedForce, f64) {
    let mut forces = vec![GeneralisedForce::zeros(N_MODES)];
    contact.evaluate(Motion::new(0.0, std::slice::from_ref(state)), &mut forces).unwrap();
    let energies = contact.energies();
    (forces.remove(0), energies.elastic_high + energies.penalty)
}

fn size(pair: &[f64]) -> f64 {
    pair.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn power_of_the_forces_goes_into_stored_energy_and_slip_alone() {
    let (mut n_mixed, mut n_stuck, mut n_slid) = (0, 0, 0);
    for motion in MOTIONS {
        for (quasistatic, seed) in (0..24).map(|k| (k % 4 != 3, k)) {
            let mut contact = Active::new(contact(motion, quasistatic, 100 + seed));
            let mut random = Random::new(seed);
            let start = pressed(&contact, motion, 8e-3, &mut random);
            // The references are set in the middle of the contact; then the body moves on for a while, a short one sticks.
            evaluate(&mut contact, &start);
            contact.save();
            let dt = if seed % 2 == 0 { 2e-3 } else { 1e-5 };
            let state = moved(&start, dt);
            let (force, stored) = evaluate(&mut contact, &state);
            let states = contact.state().point_states().to_vec();
            let energies = contact.energies();
            let lost = energies.dissipated_power;
            n_mixed += usize::from(states.contains(&PointState::Slip) && states.contains(&PointState::Stick));
            n_stuck +=
                usize::from(!states.contains(&PointState::Slip) && states.contains(&PointState::Stick));
            let mut power =
                force.force.dot(&state.velocity) + force.torque_in_body.dot(&state.angular_velocity_in_body);
            power += force.elastic.iter().zip(&state.elastic_rates).map(|(f, v)| f * v).sum::<f64>();
            let h = 1e-8;
            // Back to the start, so that each is projected anew: turns by as little use a projection again.
            contact.restore();
            let (_, after) = evaluate(&mut contact, &moved(&state, h));
            let after_states = contact.state().point_states().to_vec();
            let work_after = contact.energies().slid;
            contact.restore();
            let (_, before) = evaluate(&mut contact, &moved(&state, -h));
            let work_before = contact.energies().slid;
            if after_states != states || contact.state().point_states() != states {
                continue; // a corner of the law within the difference quotient
            }
            let growth = (after - before) / (2.0 * h);
            // Central differences: h² beside a time scale of 1e-4 s; round-off 1e2 eps of the energy, over h.
            let tolerance = 1e-7 * (power.abs() + growth.abs()) + 1e2 * f64::EPSILON * stored / h;
            assert!(
                (power + growth + lost).abs() < tolerance,
                "{motion:?} {seed}: {power} {growth} {lost} {states:?}"
            );
            let rise = (work_after - work_before) / (2.0 * h);
            assert!((rise - energies.slid_rate).abs() < tolerance, "{motion:?} {seed}: {rise} {energies:?}");
            n_slid += usize::from(energies.slid > 0.0);
        }
    }
    assert!(n_mixed > 10 && n_stuck > 5 && n_slid > 10, "{n_mixed} {n_stuck} {n_slid}");
}

#[test]
fn every_point_obeys_coulombs_law() {
    let mut n_sliding = 0;
    for motion in MOTIONS {
        let n_t = motion.n_components() - 1;
        for (quasistatic, seed) in (0..16).map(|k| (k % 4 != 3, k)) {
            let mut contact = Active::new(contact(motion, quasistatic, 300 + seed));
            let mut random = Random::new(seed);
            let start = pressed(&contact, motion, 8e-3, &mut random);
            evaluate(&mut contact, &start);
            evaluate(&mut contact, &moved(&start, 3e-3 * random.next()));
            let (normal, tangential) = (contact.point_forces().unwrap(), contact.state().tangential_forces());
            let largest = normal.iter().copied().fold(0.0, f64::max);
            for (i, state) in contact.state().point_states().iter().enumerate() {
                let force = size(&tangential[n_t * i..n_t * (i + 1)]);
                // Alternations converge to 1e-12 of the largest force.
                match state {
                    PointState::Open => assert!(force == 0.0 && normal[i] == 0.0),
                    PointState::Stick => assert!(force <= MU * normal[i] + 1e-11 * largest),
                    PointState::Slip => assert!((force - MU * normal[i]).abs() < 1e-11 * largest),
                }
                n_sliding += usize::from(*state == PointState::Slip);
            }
            let report = contact.report();
            if motion != RigidMotion::Axial {
                assert!(report.friction_force.norm() <= MU * report.normal_force * (1.0 + 1e-11));
                assert!(report.friction_force.dot(&normal_of(motion)).abs() < 1e-12 * report.normal_force);
            }
        }
    }
    assert!(n_sliding > 30);
}

#[test]
fn updated_references_change_no_force() {
    let mut n_sliding = 0;
    for (motion, seed) in MOTIONS.into_iter().flat_map(|m| (0..8).map(move |k| (m, k))) {
        let mut contact = Active::new(contact(motion, seed % 3 != 0, 40 + seed));
        let start = pressed(&contact, motion, 8e-3, &mut Random::new(seed));
        evaluate(&mut contact, &start);
        let state = moved(&start, 1e-3);
        let (before, stored) = evaluate(&mut contact, &state);
        n_sliding += contact.report().n_sliding;
        contact.save();
        let (after, stored_after) = evaluate(&mut contact, &state);
        // The solver's tolerance: 1e-12 in the alternations, condition of the zone about 1e2.
        let scale = contact.report().normal_force;
        assert!((before.force - after.force).norm() <= 1e-10 * scale, "{motion:?} {seed}");
        assert!((before.torque_in_body - after.torque_in_body).norm() <= 1e-10 * scale);
        assert!((stored - stored_after).abs() <= 1e-10 * stored);
    }
    assert!(n_sliding > 10, "{n_sliding}");
}

#[test]
fn friction_is_carried_to_a_contact_without_a_past() {
    for motion in MOTIONS {
        for (quasistatic, seed) in (0..12).map(|k| (k % 4 != 3, k)) {
            let new = || Active::new(contact(motion, quasistatic, 100 + seed));
            let (mut old, mut random) = (new(), Random::new(seed));
            let state = pressed(&old, motion, 1e-3, &mut random);
            evaluate(&mut old, &state);
            old.save();
            let state = moved(&state, 1e-4);
            let (there, _) = evaluate(&mut old, &state);
            old.save();
            let wanted = old.friction_forces();
            let mut young = new();
            evaluate(&mut young, &state);
            young.prescribe_friction(Some(&wanted));
            evaluate(&mut young, &state);
            young.prescribe_friction(None);
            evaluate(&mut young, &state);
            young.save();
            let (here, _) = evaluate(&mut young, &state);
            let name = format!("{motion:?} {quasistatic} {seed}");
            // Alternations end at 1e-12 of the largest force, some digits of which the sum loses.
            assert!((here.force - there.force).norm() <= 1e-9 * there.force.norm(), "{name}");
            let next = moved(&state, 1e-4);
            let (after, from_then_on) = (evaluate(&mut old, &next).0, evaluate(&mut young, &next).0);
            // Points at their bounds may have slipped by what sticking ones have not.
            let difference = (after.force - from_then_on.force).norm();
            assert!(difference <= 1e-6 * after.force.norm(), "{name}: {:e}", difference / after.force.norm());
        }
    }
}

/// Within a step the force is a function of the position: whatever was evaluated before, and with one derivative at all
/// increments as long as no point changes its state.
#[test]
fn within_a_step_forces_depend_on_the_position_alone() {
    let mut n_derivatives = 0;
    for (motion, seed) in MOTIONS.into_iter().flat_map(|m| (0..12).map(move |k| (m, k))) {
        let mut contact = Active::new(contact(motion, seed % 4 != 3, 500 + seed));
        let start = pressed(&contact, motion, 8e-3, &mut Random::new(seed));
        evaluate(&mut contact, &start);
        contact.save();
        let here = moved(&start, 1e-3);
        let (first, _) = evaluate(&mut contact, &here);
        let states = contact.state().point_states().to_vec();
        let by = |h: f64| BodyState { position: here.position + normal_of(motion) * h, ..here.clone() };
        let mut turned = here.clone();
        if motion != RigidMotion::Axial {
            turned.rotation *= UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 4e-9);
        }
        let name = format!("{motion:?} {seed}");
        // Alternations end at 1e-12 of the largest force; a projection serves turns of up to 1e-8.
        let ways = [
            (moved(&start, -4e-3), 1e-9),
            (moved(&start, 3e-3), 1e-9),
            (by(0.1), 1e-9),
            (by(-2e-3), 1e-9),
            (turned, 1e-7),
        ];
        for (k, (way, tolerance)) in ways.into_iter().enumerate() {
            evaluate(&mut contact, &way);
            let (again, _) = evaluate(&mut contact, &here);
            let difference = (again.force - first.force).norm() / first.force.norm();
            assert!(difference <= tolerance, "{name} {k}: {difference:e}");
        }
        let mut is_same = true;
        let slopes = [1e-5, 1e-7, 1e-9].map(|h| {
            let [after, before] = [h, -h].map(|h| {
                let force = evaluate(&mut contact, &by(h)).0.force;
                is_same &= contact.state().point_states() == states;
                force
            });
            (after - before) / (2.0 * h)
        });
        if is_same {
            n_derivatives += 1;
            // Round-off of 1e-12 of a force of 8 mm over 1 nm; curvature of the directions over 10 µm.
            let worst = slopes[1..].iter().map(|s| (s - slopes[0]).norm()).fold(0.0, f64::max);
            assert!(worst <= 1e-3 * slopes[0].norm(), "{name}: {slopes:?}");
        }
    }
    assert!(n_derivatives > 20, "{n_derivatives}");
}

#[test]
fn rejected_steps_leave_no_trace() {
    for motion in MOTIONS {
        let mut contact = Active::new(contact(motion, true, 9));
        let start = pressed(&contact, motion, 8e-3, &mut Random::new(5));
        evaluate(&mut contact, &start);
        evaluate(&mut contact, &moved(&start, 1e-3));
        contact.save();
        let here = moved(&start, 1.5e-3);
        let (first, _) = evaluate(&mut contact, &here);
        evaluate(&mut contact, &moved(&start, -4e-3));
        contact.restore();
        contact.save(); // must not take the rejected evaluation for an accepted one
        let (second, _) = evaluate(&mut contact, &here);
        assert_eq!(
            (first.force, first.torque_in_body, first.elastic),
            (second.force, second.torque_in_body, second.elastic)
        );
        contact.forget();
        evaluate(&mut contact, &here);
        assert!(contact.report().n_sliding < N_POINTS);
    }
}

#[test]
fn force_vanishes_where_the_contact_opens() {
    let motion = RigidMotion::Planar;
    let mut contact = Active::new(contact(motion, true, 11));
    let start = pressed(&contact, motion, 4e-3, &mut Random::new(6));
    evaluate(&mut contact, &start);
    let mut apart = start.clone();
    apart.position += normal_of(motion) * 4.1e-3;
    let (force, stored) = evaluate(&mut contact, &apart);
    assert_eq!((force.force.norm(), stored, contact.report().n_sliding), (0.0, 0.0, 0));
    contact.save();
    // Back elsewhere: the old place is forgotten, the point sticks where it comes down.
    apart.position += Vector3::z().cross(&normal_of(motion)) * 0.1;
    evaluate(&mut contact, &apart);
    contact.save();
    apart.position -= normal_of(motion) * 2e-3;
    evaluate(&mut contact, &apart);
    let report = contact.report();
    assert!(report.normal_force > 0.0);
    assert!(report.friction_force.norm() < 0.9 * MU * report.normal_force, "{report:?}");
}

#[test]
fn sliding_force_is_against_the_motion() {
    for motion in [RigidMotion::Planar, RigidMotion::Spatial] {
        for quasistatic in [true, false] {
            let mut contact = Active::new(contact(motion, quasistatic, 13));
            let start = pressed(&contact, motion, 4e-3, &mut Random::new(8));
            evaluate(&mut contact, &start);
            let along = Vector3::z().cross(&normal_of(motion)).normalize();
            let mut there = start.clone();
            there.position += along; // a metre: everything slides
            there.velocity = along;
            there.angular_velocity_in_body.fill(0.0);
            there.elastic_rates.fill(0.0);
            evaluate(&mut contact, &there);
            let report = *contact.report();
            let expected = -MU * report.normal_force;
            // Deformations of millimetres turn the slips of a metre a little where there are two directions.
            assert!((report.friction_force.dot(&along) / expected - 1.0).abs() < 1e-4);
            assert_eq!(report.n_sliding, report.n_active);
            let power = report.energies.dissipated_power;
            assert!((power / -expected - 1.0).abs() < 1e-4, "{power} {expected}");
        }
    }
}

#[test]
fn values_that_make_no_law_and_algorithm_1_are_refused() {
    let plane = Plane { point: Vector3::zeros(), normal: Vector3::y_axis() };
    let build = |method| {
        let settings = PlaneContactSettings { body: 0, plane, penalty: PENALTY, method };
        PlaneContact::new(submodel(RigidMotion::Planar, true, 1), settings).unwrap()
    };
    for (coefficient, ratio) in [(-0.1, 1.0), (f64::NAN, 1.0), (0.3, 0.0), (0.3, f64::INFINITY)] {
        let law = Friction { coefficient, stiffness_ratio: ratio };
        let outcome = build(Method::ActiveSet).with_friction(law);
        assert!(matches!(outcome, Err(ContactError::Friction { .. })));
    }
    let outcome = build(Method::Broyden(BroydenSettings::default())).with_friction(Friction::new(0.3));
    assert!(matches!(outcome, Err(ContactError::FrictionSolver)));
    assert!(build(Method::ActiveSet).with_friction(Friction::new(0.0)).is_ok());
}
