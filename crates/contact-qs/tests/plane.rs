//! The plane contact: gradient of its potential, resultants, reports, state.

use crate::common::Random;
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use contact_qs::quasistatic::compliance::sparse_rows::SparseRows;
use contact_qs::{ActiveContact, ContactError, ContactSubmodel, Plane, PlaneContact, PlaneContactSettings};
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::FailureKind;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

const N_POINTS: usize = 6;
const N_MODES: usize = 3;
const N_INTERFACE: usize = 10;

/// A random zone some centimetres below the origin with a soft compliance, so that all terms matter.
fn submodel(motion: RigidMotion, quasistatic: bool) -> ContactSubmodel {
    let mut random = Random::new(11);
    let nc = motion.n_components();
    let n_rows = N_POINTS * nc;
    let g = random.semidefinite(N_INTERFACE, N_INTERFACE, 1e-5);
    let mut interface = SparseRows::new(N_INTERFACE);
    let mut dense = Mat::zeros(n_rows, N_INTERFACE);
    for row in 0..n_rows {
        for b in 0..N_INTERFACE {
            dense[(row, b)] = random.next();
        }
        interface.push((0..N_INTERFACE).map(|b| (b, dense[(row, b)])));
    }
    let compliance = &dense * &g * dense.transpose();
    let mut points = Vec::new();
    for _ in 0..N_POINTS {
        let mut point = [0.0; 3];
        (0..nc).for_each(|c| point[motion.direction(c)] = 0.01 * random.next());
        point[motion.direction(nc - 1)] -= 0.05;
        points.push(point);
    }
    ContactSubmodel {
        motion,
        points,
        areas: (0..N_POINTS).map(|_| 1e-4 * (1.5 + random.next())).collect(),
        low: random.matrix(n_rows, N_MODES),
        compliance: if quasistatic {
            Mat::from_fn(n_rows, n_rows, |i, j| 0.5 * (compliance[(i, j)] + compliance[(j, i)]))
        } else {
            Mat::zeros(0, 0)
        }
        .into(),
        interface,
        rim: vec![0, N_POINTS - 1],
        facing: Vec::new(),
        left_out: Vec::new(),
    }
}

fn contact(motion: RigidMotion, quasistatic: bool, penalty: f64) -> PlaneContact {
    // A normal tilted in space that the model can meet.
    let normal = match motion {
        RigidMotion::Axial => Vector3::z(),
        RigidMotion::Planar => Vector3::new(0.3, 0.9, 0.0),
        RigidMotion::Spatial => Vector3::new(0.3, -0.2, 0.9),
    };
    let plane = Plane { point: Vector3::new(0.1, 0.2, 0.3), normal: UnitVector3::new_normalize(normal) };
    let settings = PlaneContactSettings { body: 1, plane, penalty, method: Method::ActiveSet };
    PlaneContact::new(submodel(motion, quasistatic), settings).unwrap()
}

/// A body turned away from its rest and pressed into the plane by about `depth`.
fn pressed(contact: &Active<PlaneContact>, motion: RigidMotion, depth: f64) -> BodyState {
    let mut state = BodyState::at_rest(N_MODES);
    state.position = Vector3::new(0.1, 0.2, 0.3);
    state.rotation = match motion {
        RigidMotion::Axial => UnitQuaternion::identity(),
        RigidMotion::Planar => UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.7),
        RigidMotion::Spatial => UnitQuaternion::from_euler_angles(0.4, -0.3, 0.9),
    };
    state.elastic = vec![1e-3, -2e-3, 1.5e-3];
    let normal = match motion {
        RigidMotion::Axial => Vector3::z(),
        RigidMotion::Planar => Vector3::new(0.3, 0.9, 0.0).normalize(),
        RigidMotion::Spatial => Vector3::new(0.3, -0.2, 0.9).normalize(),
    };
    state.position -= normal * (contact.element().smallest_gap_at(&state) + depth);
    state
}

/// Force at `state` on body 1 of two, and the potential.
fn evaluate(contact: &mut Active<PlaneContact>, state: &BodyState) -> (GeneralisedForce, f64) {
    let mut forces = vec![GeneralisedForce::zeros(N_MODES), GeneralisedForce::zeros(N_MODES)];
    contact.evaluate(Motion::new(0.0, &[BodyState::at_rest(N_MODES), state.clone()]), &mut forces).unwrap();
    assert_eq!(forces[0].force, Vector3::zeros(), "the other body is left alone");
    let energies = contact.energies();
    (forces.remove(1), energies.elastic_high + energies.penalty)
}

/// Central difference of the potential along a change of the state.
fn slope(
    contact: &mut Active<PlaneContact>,
    state: &BodyState,
    h: f64,
    shift: impl Fn(&mut BodyState, f64),
) -> f64 {
    let mut at = |step: f64| {
        let mut moved = state.clone();
        shift(&mut moved, step);
        evaluate(contact, &moved).1
    };
    (at(h) - at(-h)) / (2.0 * h)
}

#[test]
fn force_is_minus_the_gradient_of_the_potential() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        for (quasistatic, penalty) in [(true, 1e9), (true, f64::INFINITY), (false, 1e9)] {
            let mut contact = Active::new(contact(motion, quasistatic, penalty));
            let state = pressed(&contact, motion, 1.5e-2);
            let (force, energy) = evaluate(&mut contact, &state);
            assert!(contact.report().n_active > 1 && energy > 0.0);
            let scale = force.force.norm();
            // Central differences: error about (h/depth)², round-off eps E / h.
            let (h, tolerance) = (1e-7, 1e-6);
            let case = format!("{motion:?} {quasistatic} {penalty:e}");
            let directions: &[usize] = if motion == RigidMotion::Axial { &[2] } else { &[0, 1, 2] };
            for &d in directions {
                let gradient = slope(&mut contact, &state, h, |s, step| s.position[d] += step);
                assert!((force.force[d] + gradient).abs() < tolerance * scale, "{case} force {d}");
            }
            let axes: &[usize] = match motion {
                RigidMotion::Axial => &[],
                RigidMotion::Planar => &[2],
                RigidMotion::Spatial => &[0, 1, 2],
            };
            for &d in axes {
                let gradient = slope(&mut contact, &state, h, |s, step| {
                    let mut axis = Vector3::zeros();
                    axis[d] = step;
                    s.rotation *= UnitQuaternion::from_scaled_axis(axis);
                });
                assert!((force.torque_in_body[d] + gradient).abs() < tolerance * scale, "{case} torque {d}");
            }
            for k in 0..N_MODES {
                let gradient = slope(&mut contact, &state, h, |s, step| s.elastic[k] += step);
                assert!((force.elastic[k] + gradient).abs() < tolerance * scale, "{case} mode {k}");
            }
        }
    }
}

#[test]
fn resultant_is_the_sum_of_the_point_forces_and_acts_in_their_centre() {
    let mut contact = Active::new(contact(RigidMotion::Spatial, true, 1e9));
    let state = pressed(&contact, RigidMotion::Spatial, 5e-3);
    let (force, _) = evaluate(&mut contact, &state);
    let normal = Vector3::new(0.3, -0.2, 0.9).normalize();
    let total: f64 = contact.point_forces().unwrap().iter().sum();
    assert!((force.force - normal * total).norm() < 1e-14 * total);
    assert_eq!(contact.resultant(), force.force);
    // A force along the normal has no moment about it.
    let normal_b = state.rotation.inverse_transform_vector(&normal);
    assert!(
        force.torque_in_body.dot(&normal_b).abs() < 1e-14 * force.torque_in_body.norm().max(total * 0.05)
    );
    // The moment is that of the interface forces about the origin, lever arms deformed: compare to first order.
    let report = *contact.report();
    assert!((report.normal_force - total).abs() < 1e-15 * total);
    assert!(report.force == force.force && report.is_rim_touched);
}

#[test]
fn faces_that_are_turned_away_press_nothing() {
    let (motion, penalty) = (RigidMotion::Spatial, 1e12);
    for quasistatic in [true, false] {
        let whole = contact(motion, quasistatic, penalty);
        // Held at all points alike: what a deep press does.
        let state = pressed(&Active::new(contact(motion, quasistatic, penalty)), motion, 0.05);
        let plane = Vector3::new(0.3, -0.2, 0.9).normalize();
        let towards: [f64; 3] = state.rotation.inverse_transform_vector(&-plane).into();
        let mut zone = whole.submodel().clone();
        // Turned to the plane, away from it, and across: a side face of the end that touches.
        let across: [f64; 3] = Vector3::from(towards).cross(&Vector3::x()).normalize().into();
        zone.facing = vec![towards, towards.map(|x| -x), across, towards, towards, across];
        let settings = PlaneContactSettings {
            body: 1,
            plane: Plane { point: Vector3::new(0.1, 0.2, 0.3), normal: UnitVector3::new_normalize(plane) },
            penalty,
            method: Method::ActiveSet,
        };
        let mut faced = Active::new(PlaneContact::new(zone, settings).unwrap());
        let (force, _) = evaluate(&mut faced, &state);
        let loads = faced.point_forces().unwrap().to_vec();
        assert!([1, 2, 5].iter().all(|&i| loads[i] <= 0.0), "{loads:?}");
        assert!([0, 3, 4].iter().any(|&i| loads[i] > 0.0), "{loads:?}");
        // The resultant is that of the points alone that are turned to the plane.
        assert!((force.force - plane * loads.iter().sum::<f64>()).norm() < 1e-13 * force.force.norm());
    }
}

#[test]
fn gap_forces_and_penetration_belong_together() {
    let motion = RigidMotion::Spatial;
    let mut contact = Active::new(contact(motion, true, 1e9));
    let state = pressed(&contact, motion, 5e-3);
    let (_, potential) = evaluate(&mut contact, &state);
    let areas = contact.element().submodel().areas.clone();
    let mut penalty_energy = 0.0;
    for ((gap, force), area) in contact.found().gaps().iter().zip(contact.point_forces().unwrap()).zip(&areas)
    {
        let pressed_in = (-gap).max(0.0);
        // Round-off of the solver: n eps.
        assert!((force - area * 1e9 * pressed_in).abs() < 1e-10 * contact.report().normal_force);
        penalty_energy += 0.5 * 1e9 * area * pressed_in * pressed_in;
    }
    let energies = contact.energies();
    assert!((energies.penalty - penalty_energy).abs() < 1e-10 * potential);
    assert!(energies.elastic_high > 0.0 && energies.dissipated_power == 0.0);
    let report = contact.report();
    assert!(report.penetration > 0.0 && report.penetration < 5e-3);
    let area: f64 =
        areas.iter().zip(contact.point_forces().unwrap()).filter(|(_, f)| **f > 0.0).map(|(a, _)| a).sum();
    assert!((report.contact_area - area).abs() < 1e-18);
}

#[test]
fn interface_forces_do_the_work_of_the_point_forces() {
    let motion = RigidMotion::Spatial;
    let mut contact = Active::new(contact(motion, true, f64::INFINITY));
    let state = pressed(&contact, motion, 5e-3);
    evaluate(&mut contact, &state);
    let mut f_b = vec![0.0; N_INTERFACE];
    assert!(contact.interface_force(1, &mut f_b));
    // ½ f_bᵀ G f_b is the quasistatic elastic energy; G is the first matrix that the submodel draws.
    let g = Random::new(11).semidefinite(N_INTERFACE, N_INTERFACE, 1e-5);
    let mut energy = 0.0;
    for i in 0..N_INTERFACE {
        for j in 0..N_INTERFACE {
            energy += 0.5 * f_b[i] * g[(i, j)] * f_b[j];
        }
    }
    let elastic = contact.energies().elastic_high;
    assert!((energy - elastic).abs() < 1e-10 * elastic); // round-off, gaps cancel to 1e-3 of positions
}

#[test]
fn rings_of_an_axisymmetric_body_push_along_the_axis_alone() {
    for sign in [1.0, -1.0] {
        let mut contact = Active::new(contact(RigidMotion::Axial, true, 1e9));
        let mut state = pressed(&contact, RigidMotion::Axial, 5e-3);
        if sign < 0.0 {
            // Upside down: the other side of the zone meets the plane.
            state.rotation = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            state.position.z -= contact.element().smallest_gap_at(&state) + 5e-3;
        }
        let (force, _) = evaluate(&mut contact, &state);
        let total: f64 = contact.point_forces().unwrap().iter().sum();
        assert!(total > 0.0);
        assert_eq!((force.force, force.torque_in_body), (Vector3::new(0.0, 0.0, total), Vector3::zeros()));
        let low = &contact.element().submodel().low;
        for k in 0..N_MODES {
            let expected: f64 = contact
                .point_forces()
                .unwrap()
                .iter()
                .enumerate()
                .map(|(i, f)| sign * f * low[(2 * i + 1, k)])
                .sum();
            assert!((force.elastic[k] - expected).abs() < 1e-13 * total); // round-off of the sum
        }
    }
}

#[test]
fn both_solvers_give_the_same_forces_on_a_turned_body() {
    let motion = RigidMotion::Spatial;
    let mut exact = Active::new(contact(motion, true, 1e9));
    let state = pressed(&exact, motion, 5e-3);
    let (reference, _) = evaluate(&mut exact, &state);
    let settings = PlaneContactSettings {
        body: 1,
        plane: Plane {
            point: Vector3::new(0.1, 0.2, 0.3),
            normal: UnitVector3::new_normalize(Vector3::new(0.3, -0.2, 0.9)),
        },
        penalty: 1e9,
        method: Method::Broyden(BroydenSettings::default()),
    };
    let mut broyden = Active::new(PlaneContact::new(submodel(motion, true), settings).unwrap());
    let (force, _) = evaluate(&mut broyden, &state);
    assert!(!broyden.report().solver.hit_iteration_limit);
    // ε = 1e-15 m beside displacements of 5e-3 m.
    assert!((force.force - reference.force).norm() < 1e-10 * reference.force.norm());
    assert!((force.torque_in_body - reference.torque_in_body).norm() < 1e-10 * reference.force.norm());
    assert!(matches!(broyden.set_penalty(f64::INFINITY), Err(ContactError::ExactConstraint { .. })));
}

#[test]
fn smallest_gap_is_zero_where_the_force_begins() {
    let motion = RigidMotion::Spatial;
    let mut contact = Active::new(contact(motion, true, 1e9));
    for (depth, touches) in [(-1e-9, false), (1e-9, true)] {
        let state = pressed(&contact, motion, depth);
        assert!((contact.element().smallest_gap_at(&state) + depth).abs() < 1e-15); // round-off of positions of 0.3 m
        let (force, _) = evaluate(&mut contact, &state);
        assert_eq!(force.force.norm() > 0.0, touches);
        assert_eq!(contact.report().n_active, usize::from(touches));
        assert!(touches || contact.report().penetration == 0.0);
    }
}

#[test]
fn penalty_can_change_during_a_run() {
    let motion = RigidMotion::Planar;
    let mut contact = Active::new(contact(motion, true, 1e7));
    let state = pressed(&contact, motion, 5e-3);
    let (soft, _) = evaluate(&mut contact, &state);
    contact.set_penalty(1e12).unwrap();
    let (stiff, _) = evaluate(&mut contact, &state);
    contact.set_penalty(f64::INFINITY).unwrap();
    let (exact, _) = evaluate(&mut contact, &state);
    assert!(soft.force.norm() < 0.9 * stiff.force.norm());
    // The springs carry 1e-8 / (A_ii w_i c_p): about 1e-4 at most.
    assert!((stiff.force - exact.force).norm() < 1e-3 * exact.force.norm());
    assert!(contact.set_penalty(-1.0).is_err() && contact.set_penalty(f64::NAN).is_err());
    assert!(contact.facts().penalty().is_infinite(), "a refused factor changes nothing");
}

#[test]
fn restored_contact_repeats_bit_for_bit() {
    for method in [Method::ActiveSet, Method::Broyden(BroydenSettings::default())] {
        let motion = RigidMotion::Spatial;
        let plane = Plane { point: Vector3::new(0.1, 0.2, 0.3), normal: Vector3::z_axis() };
        let settings = PlaneContactSettings { body: 1, plane, penalty: 1e9, method };
        let mut contact = Active::new(PlaneContact::new(submodel(motion, true), settings).unwrap());
        let mut state = BodyState::at_rest(N_MODES);
        let mut at = |contact: &mut Active<PlaneContact>, depth: f64| {
            state.position.z -= contact.element().smallest_gap_at(&state) + depth;
            let (force, energy) = evaluate(contact, &state);
            // Kept factors are no state: how often one was computed may differ.
            let solver = contact.report().solver;
            (
                force.force,
                force.torque_in_body,
                force.elastic,
                energy,
                (solver.hit_iteration_limit, solver.iterations),
            )
        };
        at(&mut contact, 1e-3);
        contact.save();
        let first = at(&mut contact, 2e-3);
        at(&mut contact, 9e-3);
        contact.restore();
        assert_eq!(first, at(&mut contact, 2e-3));
    }
}

#[test]
fn a_small_turn_keeps_projection_and_factor() {
    let motion = RigidMotion::Spatial;
    let new = || Active::new(contact(motion, true, 1e9));
    let mut kept = new();
    let state = pressed(&kept, motion, 5e-3);
    let turned = |angle: f64| {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle);
        BodyState { rotation: state.rotation * turn, ..state.clone() }
    };
    let (before, _) = evaluate(&mut kept, &state);
    kept.save();
    // The compliance errs by as much as the normal, to first order by the square of the turn, the forces by that times its
    // condition, some ten.
    for (angle, n_factors, limit) in [(5e-9, 0, 1e-7), (9e-5, 0, 1e-7), (2e-4, 1, 1e-12)] {
        let (force, _) = evaluate(&mut kept, &turned(angle));
        assert_eq!(kept.report().solver.factorisations, n_factors, "{angle:e}");
        let (fresh, _) = evaluate(&mut new(), &turned(angle));
        let error = (force.force - fresh.force).norm() / fresh.force.norm();
        assert!(error <= limit, "{error:e} after {angle:e}");
    }
    // What is projected on is part of the state.
    kept.restore();
    assert_eq!(evaluate(&mut kept, &state).0.force, before.force);
}

#[test]
fn normals_that_a_model_cannot_meet_are_refused() {
    let tilted = UnitQuaternion::from_euler_angles(0.01, 0.0, 0.0);
    for motion in [RigidMotion::Axial, RigidMotion::Planar] {
        let mut contact = Active::new(contact(motion, true, 1e9));
        assert!(contact.element().check_alignment(&UnitQuaternion::identity()).is_ok());
        assert!(matches!(contact.element().check_alignment(&tilted), Err(ContactError::Normal { .. })));
        let mut state = BodyState::at_rest(N_MODES);
        state.rotation = tilted;
        let mut forces = vec![GeneralisedForce::zeros(N_MODES); 2];
        assert!(
            contact
                .evaluate(Motion::new(0.0, &[BodyState::at_rest(N_MODES), state.clone()]), &mut forces)
                .is_err()
        );
        assert!(contact.element().smallest_gap_at(&state).is_nan());
    }
}

#[test]
fn state_that_is_not_a_number_is_rejected_with_code_2() {
    let mut contact = Active::new(contact(RigidMotion::Spatial, true, 1e9));
    let mut state = pressed(&contact, RigidMotion::Spatial, 1e-3);
    state.elastic[1] = f64::NAN;
    let mut forces = vec![GeneralisedForce::zeros(N_MODES); 2];
    let error = contact
        .evaluate(Motion::new(0.0, &[BodyState::at_rest(N_MODES), state.clone()]), &mut forces)
        .unwrap_err();
    assert_eq!(error.kind(), FailureKind::NotFinite);
    assert!(contact.element().smallest_gap_at(&state).is_nan());
}
