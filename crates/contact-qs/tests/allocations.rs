//! A contact evaluation must not allocate.

use crate::common::surface_compliance;
use crate::counting::allocations;
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use contact_qs::quasistatic::compliance::sparse_rows::SparseRows;
use contact_qs::{ActiveContact, ContactSubmodel, Friction, Plane, PlaneContact, PlaneContactSettings};
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use nalgebra::{UnitQuaternion, Vector3};

/// Evaluations that are counted.
const N_STEPS: u32 = 20;

#[test]
fn evaluations_do_not_allocate() {
    let n = 60;
    let a = surface_compliance(n, 1e-8);
    // Normal and tangential directions alike, uncoupled.
    let compliance = Mat::from_fn(3 * n, 3 * n, |i, j| if i % 3 == j % 3 { a[(i / 3, j / 3)] } else { 0.0 });
    for (compliance, method, friction) in [
        (compliance.clone(), Method::ActiveSet, None),
        (compliance.clone(), Method::ActiveSet, Some(Friction::new(0.3))),
        (compliance, Method::Broyden(BroydenSettings::default()), None),
        (Mat::zeros(0, 0), Method::ActiveSet, None),
        (Mat::zeros(0, 0), Method::ActiveSet, Some(Friction::new(0.3))),
    ] {
        let is_quasistatic = compliance.nrows() > 0;
        let submodel = ContactSubmodel {
            motion: RigidMotion::Spatial,
            points: (0..n).map(|i| [1e-5 * i as f64, 0.0, 1e-9 * (i as f64 - 30.0).powi(2)]).collect(),
            areas: vec![1e-9; n],
            low: Mat::from_fn(3 * n, 4, |i, j| 0.1 * ((i + j) % 3) as f64),
            compliance: compliance.into(),
            interface: SparseRows::default(),
            rim: Vec::new(),
            facing: Vec::new(),
            left_out: Vec::new(),
        };
        let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
        let settings = PlaneContactSettings { body: 0, plane, penalty: 1e17, method };
        let mut contact = PlaneContact::new(submodel, settings).unwrap();
        if let Some(friction) = friction {
            contact = contact.with_friction(friction).unwrap();
        }
        let mut contact = Active::new(contact);
        let mut forces = [GeneralisedForce::zeros(4)];
        let mut bodies = [BodyState {
            position: Vector3::new(0.0, 0.0, -1e-7),
            rotation: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            angular_velocity_in_body: Vector3::zeros(),
            elastic: vec![0.0; 4],
            elastic_rates: vec![0.0; 4],
        }];
        let (mut smallest, mut has_slid) = (0.0, false);
        contact.evaluate(Motion::new(0.0, &bodies), &mut forces).unwrap(); // libraries may set up thread-local buffers once
        let before = allocations();
        for step in 0..N_STEPS {
            // Sinking and turning: sets, projections and factors change.
            bodies[0].position.z = -2e-8 * f64::from(step);
            bodies[0].position.x = 1e-8 * f64::from(step);
            bodies[0].velocity.x = 0.1;
            bodies[0].rotation = UnitQuaternion::from_euler_angles(0.0, 1e-5 * f64::from(step), 0.0);
            contact.save();
            contact.evaluate(Motion::new(0.0, &bodies), &mut forces).unwrap();
            has_slid |= contact.report().n_sliding > 0;
            contact.restore();
            smallest = contact.element().smallest_gap_at(&bodies[0]);
        }
        let count = allocations() - before;
        assert!(contact.report().n_active > 1 && smallest < 0.0, "{method:?} must be in contact");
        assert_eq!(has_slid, friction.is_some());
        // Algorithm 1 factorises a matrix in every step, and so does friction. Each matrix product of the library may take a buffer for packing, and a recursion
        // down to blocks of some columns has fewer products than the matrix has rows.
        let is_factorised = matches!(method, Method::Broyden(_)) || (has_slid && is_quasistatic);
        let most = if is_factorised { N_STEPS as usize * n } else { 0 };
        assert!(count <= most, "{method:?}: {count}");
    }
}
