//! An evaluation of a surface pair must not allocate.

use crate::counting::allocations;
use crate::pair_support::{N_MODES, forces, random_bodies, random_pair};
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use contact_qs::{ActiveContact, Friction};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::Motion;
use ffr_dynamics::force::active::{Active, ActiveForce};

#[test]
fn evaluations_of_pairs_do_not_allocate() {
    let broyden = Method::Broyden(BroydenSettings::default());
    for (motion, quasistatic, method, friction) in [
        (RigidMotion::Axial, [true, true], Method::ActiveSet, 0.0),
        (RigidMotion::Axial, [true, true], broyden, 0.0),
        (RigidMotion::Planar, [false, true], Method::ActiveSet, 0.0),
        (RigidMotion::Spatial, [true, true], Method::ActiveSet, 0.0),
        (RigidMotion::Spatial, [false, false], Method::ActiveSet, 0.0),
        (RigidMotion::Planar, [true, true], Method::ActiveSet, 0.3),
        (RigidMotion::Spatial, [true, true], Method::ActiveSet, 0.3),
        (RigidMotion::Spatial, [false, false], Method::ActiveSet, 0.3),
    ] {
        let pair = random_pair(motion, quasistatic, 1e10, method, 3);
        let mut pair = Active::new(pair.with_friction(Friction::new(friction)).unwrap());
        let mut bodies = random_bodies(pair.element(), motion, 2e-3, 3);
        bodies[2].velocity.x = 0.1;
        let mut out = forces(3, N_MODES);
        // Libraries may set up thread-local buffers once.
        pair.evaluate(Motion::new(0.0, &bodies), &mut out).unwrap();
        let mut smallest = pair.meeting(Motion::new(0.0, &bodies)).gap;
        let before = allocations();
        for step in 0..10 {
            // Sliding and turning: projections, sets and factors change.
            // Planar bodies move in their plane alone.
            bodies[2].position[if motion == RigidMotion::Planar { 1 } else { 2 }] +=
                1e-5 * f64::from(step % 3 - 1);
            bodies[0].elastic[0] += 1e-5 * f64::from(step % 2);
            pair.save();
            pair.evaluate(Motion::new(0.0, &bodies), &mut out).unwrap();
            pair.restore();
            smallest = smallest.min(pair.meeting(Motion::new(0.0, &bodies)).gap);
        }
        let count = allocations() - before;
        assert!(pair.report().n_active > 0 && smallest < 0.0, "{motion:?} must be in contact");
        assert_eq!(count, 0, "{motion:?} {quasistatic:?} {method:?}");
    }
}
