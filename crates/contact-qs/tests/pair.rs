//! The surface pair: action and reaction, momenta, gradient of its potential, state.

use crate::pair_support::*;
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use contact_qs::{ActiveContact, ContactError, Friction, SurfacePair, SurfacePairSettings, TargetSurface};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::FailureKind;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, Motion};
use iga_core::hierarchical::{HierarchicalSpace, IndexBox, SubdomainHierarchy};
use iga_core::space::{PatchSpace, Space};
use nalgebra::{UnitQuaternion, Vector3};

/// Has `check` judge random pairs of all kinds, some of each with several points in contact.
fn each_pair(check: impl Fn(&mut Active<SurfacePair>, RigidMotion, &[BodyState], &str)) {
    for (motion, (quasistatic, penalty)) in MOTIONS.into_iter().flat_map(|motion| CASES.map(|c| (motion, c)))
    {
        let mut most = 0;
        for seed in 1..8 {
            let mut pair = Active::new(random_pair(motion, quasistatic, penalty, Method::ActiveSet, seed));
            let bodies = random_bodies(pair.element(), motion, DEPTH, seed);
            check(&mut pair, motion, &bodies, &format!("{motion:?} {quasistatic:?} {penalty:e} {seed}"));
            most = most.max(pair.report().n_active);
        }
        assert!(most > 1);
    }
}

#[test]
fn forces_are_equal_and_opposite_and_keep_the_angular_momentum() {
    each_pair(|pair, motion, bodies, case| {
        let (forces, energy) = evaluate(pair, bodies);
        let gap = pair.meeting(Motion::new(0.0, bodies)).gap;
        let gaps = pair.state().gaps();
        assert!(energy > 0.0 && pair.report().n_active > 0, "{case} {gaps:?} {gap}");
        assert_eq!(forces[2].force, -forces[0].force);
        assert_eq!(forces[1].force, Vector3::zeros());
        let moment = moment(bodies, &forces);
        if motion != RigidMotion::Axial {
            // Round-off of arms of half a metre and of projections, which end at some eps of them.
            let scale = pair.report().normal_force * 0.5;
            assert!(moment.norm() < 50.0 * f64::EPSILON * scale, "{motion:?} {}", moment.norm() / scale);
        }
    });
}

/// Directions and axes of the motions of a model.
fn dofs(motion: RigidMotion) -> (&'static [usize], &'static [usize]) {
    match motion {
        RigidMotion::Axial => (&[2], &[]),
        RigidMotion::Planar => (&[0, 1], &[2]),
        RigidMotion::Spatial => (&[0, 1, 2], &[0, 1, 2]),
    }
}

/// Largest difference of forces and slopes of the potential, as a share of the contact force.
fn gradient_error(pair: &mut Active<SurfacePair>, motion: RigidMotion, bodies: &[BodyState]) -> f64 {
    let (forces, energy) = evaluate(pair, bodies);
    assert!(energy > 0.0);
    let scale = forces[2].force.norm();
    // Central differences: error about (h/depth)² = 3e-9; energies known to some 1e-12 of F depth leave 2e-8 of F.
    let h = 1e-7;
    let (directions, axes) = dofs(motion);
    let mut worst = 0.0_f64;
    for body in [0, 2] {
        for &d in directions {
            let gradient = slope(pair, bodies, h, |b, step| b[body].position[d] += step);
            worst = worst.max((forces[body].force[d] + gradient).abs());
        }
        for &d in axes {
            let gradient = slope(pair, bodies, h, |b, step| {
                let mut axis = Vector3::zeros();
                axis[d] = step;
                b[body].rotation *= UnitQuaternion::from_scaled_axis(axis);
            });
            worst = worst.max((forces[body].torque_in_body[d] + gradient).abs());
        }
        for k in 0..N_MODES {
            let gradient = slope(pair, bodies, h, |b, step| b[body].elastic[k] += step);
            worst = worst.max((forces[body].elastic[k] + gradient).abs());
        }
    }
    worst / scale
}

#[test]
fn force_is_minus_the_gradient_of_the_potential() {
    each_pair(|pair, motion, bodies, case| {
        let error = gradient_error(pair, motion, bodies);
        // Tilted normals and quasistatic displacements left out of lever arms would show at 1e-2.
        assert!(error < 3e-7, "{case}: {error:e}");
    });
}

#[test]
fn algorithm_1_finds_the_same_forces() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar] {
        let method = Method::Broyden(BroydenSettings::default());
        let mut pair = Active::new(random_pair(motion, [true, true], 1e10, Method::ActiveSet, 3));
        let mut other = Active::new(random_pair(motion, [true, true], 1e10, method, 3));
        let bodies = random_bodies(pair.element(), motion, DEPTH, 3);
        evaluate(&mut pair, &bodies);
        evaluate(&mut other, &bodies);
        let (a, b) = (pair.report().normal_force, other.report().normal_force);
        // ε = 1e-15 m of 2e-3 m, amplified by the condition of the springs.
        assert!((a - b).abs() < 1e-8 * a, "{a} {b}");
        assert!(matches!(other.set_penalty(f64::INFINITY), Err(ContactError::ExactConstraint { .. })));
    }
}

#[test]
fn save_and_restore_are_exact_to_the_bit() {
    for motion in MOTIONS {
        for method in [Method::ActiveSet, Method::Broyden(BroydenSettings::default())] {
            if motion == RigidMotion::Spatial && method != Method::ActiveSet {
                continue;
            }
            let mut pair = Active::new(random_pair(motion, [true, true], 1e10, method, 5));
            let bodies = random_bodies(pair.element(), motion, DEPTH, 5);
            evaluate(&mut pair, &bodies);
            pair.save();
            let mut moved = bodies.clone();
            moved[2].elastic[0] += 2e-4;
            let first = evaluate(&mut pair, &moved);
            let mut away = bodies.clone();
            // Planar bodies move in their plane alone.
            let up = if motion == RigidMotion::Planar { Vector3::y() } else { Vector3::z() };
            away[2].position += 1e-3 * up;
            away[0].elastic[1] -= 1e-3;
            evaluate(&mut pair, &away);
            pair.restore();
            let second = evaluate(&mut pair, &moved);
            assert_eq!(first.1.to_bits(), second.1.to_bits());
            for (a, b) in first.0.iter().zip(&second.0) {
                assert_eq!(a.force, b.force);
                assert_eq!(a.torque_in_body, b.torque_in_body);
                assert_eq!(a.elastic, b.elastic);
            }
        }
    }
}

#[test]
fn smallest_gap_is_the_distance_at_any_range() {
    for motion in MOTIONS {
        let mut pair = Active::new(random_pair(motion, [true, true], 1e10, Method::ActiveSet, 3));
        let mut bodies = random_bodies(pair.element(), motion, 0.0, 3);
        // Where the loop of random_bodies has ended.
        assert!(pair.meeting(Motion::new(0.0, &bodies)).gap.abs() < 1e-12);
        let normal = pair.meeting(Motion::new(0.0, &bodies)).normal;
        assert!((normal.norm() - 1.0).abs() < 1e-14);
        for distance in [1e-6, 1e-3, 0.1, 2.0] {
            let mut apart = bodies.clone();
            apart[2].position += normal * distance;
            let gap = pair.meeting(Motion::new(0.0, &apart)).gap;
            // Another point may be nearer than the one followed, but not by more than the extent of the zone.
            assert!(gap > 0.2 * distance && gap <= distance * (1.0 + 1e-6), "{motion:?} {distance} {gap}");
        }
        bodies[2].position -= normal * 1e-4;
        let gap = pair.meeting(Motion::new(0.0, &bodies)).gap;
        assert!((-1.5e-4..-0.99e-4).contains(&gap), "{motion:?} {gap}");
        bodies[2].elastic[0] = f64::NAN;
        assert!(pair.meeting(Motion::new(0.0, &bodies)).gap.is_nan());
        let mut f = forces(3, N_MODES);
        assert_eq!(
            pair.evaluate(Motion::new(0.0, &bodies), &mut f).unwrap_err().kind(),
            FailureKind::NotFinite
        );
        // A target that has lost its place is seen by a pair whose points were far from it, too.
        let mut apart = random_bodies(pair.element(), motion, -0.1, 3);
        pair.evaluate(Motion::new(0.0, &apart), &mut f).unwrap();
        apart[0].elastic[0] = f64::NAN;
        assert!(pair.meeting(Motion::new(0.0, &apart)).gap.is_nan());
        assert_eq!(
            pair.evaluate(Motion::new(0.0, &apart), &mut f).unwrap_err().kind(),
            FailureKind::NotFinite
        );
    }
}

#[test]
fn penalty_factor_may_change_and_misfits_are_refused() {
    let motion = RigidMotion::Axial;
    let mut pair = Active::new(random_pair(motion, [true, true], 1e9, Method::ActiveSet, 3));
    let bodies = random_bodies(pair.element(), motion, DEPTH, 3);
    let mut last = 0.0;
    for penalty in [1e9, 1e10, 1e11, f64::INFINITY] {
        pair.set_penalty(penalty).unwrap();
        evaluate(&mut pair, &bodies);
        assert!(pair.report().normal_force > last);
        last = pair.report().normal_force;
        let mut fresh = Active::new(random_pair(motion, [true, true], penalty, Method::ActiveSet, 3));
        evaluate(&mut fresh, &bodies);
        // Warm and cold starts meet within the tolerance of the iteration.
        assert!((fresh.report().normal_force / last - 1.0).abs() < 1e-8);
    }
    assert!(matches!(pair.set_penalty(0.0), Err(ContactError::Penalty { .. })));
    assert!(pair.compliance_weight(Motion::new(0.0, &bodies), f64::INFINITY).unwrap().unwrap() > 0.0);
    assert!(matches!(
        random_pair(motion, [true, true], 1e9, Method::ActiveSet, 3).with_friction(Friction::new(-0.3)),
        Err(ContactError::Friction { .. })
    ));
    let modal = Method::Broyden(BroydenSettings::default());
    let pair = random_pair(motion, [true, true], 1e9, modal, 3);
    assert!(matches!(pair.with_friction(Friction::new(0.3)), Err(ContactError::FrictionSolver)));
    let settings = SurfacePairSettings {
        contact_body: 1,
        target_body: Some(1),
        penalty: 1e9,
        method: Method::ActiveSet,
    };
    let with_itself =
        SurfacePair::new(random_points(motion, true, 1), random_target(motion, true, 2), settings);
    assert!(with_itself.is_err());
    let other = SurfacePairSettings { target_body: Some(0), ..settings };
    let mixed =
        SurfacePair::new(random_points(RigidMotion::Planar, true, 1), random_target(motion, true, 2), other);
    assert!(mixed.is_err());
    let springless = SurfacePair::new(
        random_points(motion, false, 1),
        random_target(motion, false, 2),
        SurfacePairSettings { penalty: f64::INFINITY, ..other },
    );
    assert!(matches!(springless, Err(ContactError::ExactConstraint { .. })));
}

#[test]
fn hierarchical_targets_are_the_same_surface() {
    let motion = RigidMotion::Axial;
    let shape = round(motion, RADIUS);
    let (face, top) = highest(&shape, motion, &[0.0, 1.0, 0.0]);
    let patch = &shape.patches[0];
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    // All of the pole's corner, three parts per direction: elements of two levels on the face.
    hierarchy.refine([3, 3, 1], &[IndexBox { lower: [0, 2, 0], upper: [4, 6, 1] }]).unwrap();
    let fine = HierarchicalSpace::new(patch, hierarchy).unwrap();
    let plain = PatchSpace::new(shape.patches.clone()).unwrap();
    assert!(fine.n_functions() > plain.n_functions() + 10);
    let parts = [part(&shape, face, &top.xi, 0.9)];
    let pair = |space: &dyn Space| {
        let target = TargetSurface::rigid(motion, space, &shape.patches, &parts).unwrap();
        let settings = SurfacePairSettings {
            contact_body: 2,
            target_body: None,
            penalty: 1e9,
            method: Method::ActiveSet,
        };
        Active::new(SurfacePair::new(random_points(motion, false, 3), target, settings).unwrap())
    };
    let (mut on_fine, mut on_plain) = (pair(&fine), pair(&plain));
    let mut bodies = vec![BodyState::at_rest(N_MODES); 3];
    for z in [0.14, 0.149, 0.16, 0.3] {
        bodies[2].position.z = z;
        let (a, b) =
            (on_fine.meeting(Motion::new(0.0, &bodies)).gap, on_plain.meeting(Motion::new(0.0, &bodies)).gap);
        // Round-off of the fits.
        assert!((a - b).abs() < 1e-15, "{z}: {a} {b}");
    }
}

#[test]
fn points_beyond_the_end_of_the_target_are_open() {
    let motion = RigidMotion::Axial;
    let shape = round(motion, RADIUS);
    let (face, top) = highest(&shape, motion, &[0.0, 1.0, 0.0]);
    let space = PatchSpace::new(shape.patches.clone()).unwrap();
    // The target ends at some 3 mm from the axis, the points reach 20 mm.
    let parts = [part(&shape, face, &top.xi, 0.02)];
    let target = TargetSurface::rigid(motion, &space, &shape.patches, &parts).unwrap();
    let settings =
        SurfacePairSettings { contact_body: 2, target_body: None, penalty: 1e9, method: Method::ActiveSet };
    let mut pair = Active::new(SurfacePair::new(random_points(motion, false, 3), target, settings).unwrap());
    let mut bodies = vec![BodyState::at_rest(N_MODES); 3];
    bodies[2].position.z = 0.14;
    evaluate(&mut pair, &bodies);
    let beyond = pair
        .state()
        .gaps()
        .iter()
        .zip(pair.point_forces().unwrap())
        .filter(|(g, f)| **g > 0.0 && **f <= 0.0)
        .count();
    assert!(beyond > 0 && pair.state().gaps().iter().all(|g| g.is_finite()));
    assert_eq!(beyond + pair.report().n_active, pair.facts().n_points());
}

#[test]
fn forces_of_several_pairs_on_a_body_add_up() {
    let motion = RigidMotion::Spatial;
    // One target for two contact bodies: pairs know nothing of each other.
    let mut first = Active::new(random_pair(motion, [true, true], 1e10, Method::ActiveSet, 3));
    let bodies = random_bodies(first.element(), motion, DEPTH, 3);
    let settings = SurfacePairSettings {
        contact_body: 1,
        target_body: Some(0),
        penalty: 1e10,
        method: Method::ActiveSet,
    };
    let second =
        SurfacePair::new(random_points(motion, true, 3), random_target(motion, true, 103), settings).unwrap();
    let mut second = Active::new(second);
    let mut bodies = bodies;
    bodies[1] = bodies[2].clone();
    let (mut together, mut alone) = (forces(3, N_MODES), forces(3, N_MODES));
    first.evaluate(Motion::new(0.0, &bodies), &mut alone).unwrap();
    first.evaluate(Motion::new(0.0, &bodies), &mut together).unwrap();
    second.evaluate(Motion::new(0.0, &bodies), &mut together).unwrap();
    // The second is the first under another number: warm and cold starts agree to the tolerance asked of random pairs
    // and the default one.
    let scale = alone[2].force.norm();
    assert!((together[1].force - alone[2].force).norm() < 1e-6 * scale);
    assert!((together[0].force - 2.0 * alone[0].force).norm() < 1e-6 * scale);
    assert!((together[0].torque_in_body - 2.0 * alone[0].torque_in_body).norm() < 1e-6 * scale);
}

#[test]
fn places_of_a_step_given_up_say_nothing_of_the_rim() {
    for motion in MOTIONS {
        let mut pair = Active::new(random_pair(motion, [false, false], 1e9, Method::ActiveSet, 1));
        let mut open = random_bodies(pair.element(), motion, DEPTH, 1);
        let (_, up) = upwards(motion);
        let up = open[0].rotation * up;
        open[2].position += up * 1.1 * DEPTH;
        evaluate(&mut pair, &open);
        assert!(pair.report().n_active == 0 && !pair.report().is_rim_touched, "{motion:?}");
        pair.save();
        // As far as the wildest stage of an explicit method: through the target and out at its side.
        let mut wild = open.clone();
        wild[2].position -= up * RADIUS;
        evaluate(&mut pair, &wild);
        pair.restore();
        evaluate(&mut pair, &open);
        assert!(!pair.report().is_rim_touched, "{motion:?}");
    }
}
