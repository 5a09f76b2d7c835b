//! Time of one contact evaluation with 20, 100 and 400 points.

use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use contact_qs::quasistatic::compliance::sparse_rows::SparseRows;
use contact_qs::{ActiveContact, ContactSubmodel, Friction, Plane, PlaneContact, PlaneContactSettings};
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use nalgebra::{UnitQuaternion, Vector3};

const N_MODES: usize = 20;

fn main() {
    divan::main();
}

/// A square patch of points on a body of 10 mm radius of curvature; compliance falls off with the distance.
fn contact(n: usize, motion: RigidMotion, method: Method) -> PlaneContact {
    let side = (n as f64).sqrt().ceil() as usize;
    // Plane models have their points in a row.
    let side = if motion == RigidMotion::Planar { n } else { side };
    let spacing = 4e-4 / side as f64;
    let across = if motion == RigidMotion::Planar { 0.0 } else { 2e-4 };
    let place = |i: usize| [(i % side) as f64 * spacing - 2e-4, (i / side) as f64 * spacing - across];
    let nc = motion.n_components();
    let distance = |i: usize, j: usize| (place(i)[0] - place(j)[0]).hypot(place(i)[1] - place(j)[1]);
    let submodel = ContactSubmodel {
        motion,
        points: (0..n)
            .map(|i| {
                let [x, y] = place(i);
                let height = (x * x + y * y) / 0.02;
                if motion == RigidMotion::Planar { [x, height, 0.0] } else { [x, y, height] }
            })
            .collect(),
        areas: vec![spacing * spacing; n],
        low: Mat::from_fn(nc * n, N_MODES, |i, j| ((i * j) % 7) as f64),
        compliance: Mat::from_fn(nc * n, nc * n, |i, j| {
            if i % nc == j % nc { 4e-12 / (distance(i / nc, j / nc) + 0.3 * spacing) } else { 0.0 }
        })
        .into(),
        interface: SparseRows::default(),
        rim: Vec::new(),
        facing: Vec::new(),
        left_out: Vec::new(),
    };
    let normal = if motion == RigidMotion::Planar { Vector3::y_axis() } else { Vector3::z_axis() };
    let plane = Plane { point: Vector3::zeros(), normal };
    PlaneContact::new(submodel, PlaneContactSettings { body: 0, plane, penalty: 1e17, method }).expect("fits")
}

/// Evaluates contact at depths that go up and down a little, as the stages of a time step do.
fn evaluate(bencher: divan::Bencher<'_, '_>, contact: PlaneContact, turn: f64) {
    let mut contact = Active::new(contact);
    let mut forces = [GeneralisedForce::zeros(N_MODES)];
    let mut bodies = [BodyState {
        position: Vector3::zeros(),
        rotation: UnitQuaternion::identity(),
        velocity: Vector3::zeros(),
        angular_velocity_in_body: Vector3::zeros(),
        elastic: vec![0.0; N_MODES],
        elastic_rates: vec![0.0; N_MODES],
    }];
    let mut stage = 0_u32;
    bencher.bench_local(move || {
        stage += 1;
        bodies[0].position.z = -2e-6 - 1e-8 * f64::from(stage % 7);
        bodies[0].rotation = UnitQuaternion::from_euler_angles(turn * f64::from(stage % 5), 0.0, 0.0);
        forces[0].clear();
        contact.evaluate(Motion::new(0.0, &bodies), &mut forces).expect("converges");
        contact.report().normal_force
    });
}

#[divan::bench(args = [20, 100, 400])]
fn axial_active_set(bencher: divan::Bencher<'_, '_>, n: usize) {
    evaluate(bencher, contact(n, RigidMotion::Axial, Method::ActiveSet), 0.0);
}

#[divan::bench(args = [20, 100, 400])]
fn spatial_active_set(bencher: divan::Bencher<'_, '_>, n: usize) {
    evaluate(bencher, contact(n, RigidMotion::Spatial, Method::ActiveSet), 0.0);
}

#[divan::bench(args = [20, 100, 400])]
fn turning_active_set(bencher: divan::Bencher<'_, '_>, n: usize) {
    evaluate(bencher, contact(n, RigidMotion::Spatial, Method::ActiveSet), 1e-6);
}

/// A body that slides while it turns, pressed in as before.
fn sliding(bencher: divan::Bencher<'_, '_>, motion: RigidMotion, n: usize) {
    let contact = contact(n, motion, Method::ActiveSet).with_friction(Friction::new(0.3)).expect("a law");
    let mut contact = Active::new(contact);
    let up = usize::from(motion == RigidMotion::Spatial) + 1;
    let mut forces = [GeneralisedForce::zeros(N_MODES)];
    let mut body = BodyState::at_rest(N_MODES);
    body.velocity.x = 0.6;
    let mut stage = 0_u32;
    bencher.bench_local(move || {
        stage += 1;
        body.position[up] = -2e-6 - 1e-8 * f64::from(stage % 7);
        body.position.x += 1e-7;
        body.rotation = UnitQuaternion::from_euler_angles(0.0, 0.0, 1e-6 * f64::from(stage % 5));
        forces[0].clear();
        contact.evaluate(Motion::new(0.0, std::slice::from_ref(&body)), &mut forces).expect("converges");
        contact.save();
        contact.report().energies.dissipated_power
    });
}

#[divan::bench(args = [20, 60])]
fn sliding_planar(bencher: divan::Bencher<'_, '_>, n: usize) {
    sliding(bencher, RigidMotion::Planar, n);
}

#[divan::bench(args = [20, 100])]
fn sliding_spatial(bencher: divan::Bencher<'_, '_>, n: usize) {
    sliding(bencher, RigidMotion::Spatial, n);
}

// With 100 points here Broyden's updates end in a singular Jacobian (error 1 of the listing).
#[divan::bench(args = [20])]
fn axial_algorithm_1(bencher: divan::Bencher<'_, '_>, n: usize) {
    evaluate(bencher, contact(n, RigidMotion::Axial, Method::Broyden(BroydenSettings::default())), 0.0);
}
