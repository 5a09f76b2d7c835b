//! One evaluation of a pair of axisymmetric spheres: 33 points, quasistatic compliance of both bodies.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up shall stop")]

#[path = "../tests/common/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod common;
#[path = "../tests/pair_support/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod pair_support;

use contact_qs::quasistatic::Method;
use contact_qs::{ActiveContact, SurfacePair, SurfacePairSettings};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use pair_support::elastic::{ALUMINIUM, ElasticSphere, STEEL};

const N_MODES: usize = 20;
const RADIUS: f64 = 0.01;

fn main() {
    divan::main();
}

fn pair() -> SurfacePair {
    let shape = |radius| iga_core::nurbs::primitives::axisymmetric::sphere(radius).unwrap();
    let zone = (4e-4, 31);
    let small = ElasticSphere::new(&shape(RADIUS), ALUMINIUM, 2789.0, -1.0, zone, N_MODES);
    let large = ElasticSphere::new(&shape(2.0 * RADIUS), STEEL, 7850.0, 1.0, zone, N_MODES);
    let settings = SurfacePairSettings {
        contact_body: 0,
        target_body: Some(1),
        penalty: 1e17,
        method: Method::ActiveSet,
    };
    SurfacePair::new(small.submodel(), large.target(), settings).unwrap()
}

fn bodies() -> Vec<BodyState> {
    vec![BodyState::at_rest(N_MODES); 2]
}

/// Approaches that go up and down a little, as the stages of a time step do.
fn evaluate(bencher: divan::Bencher<'_, '_>, approach: f64) {
    let (mut pair, mut bodies) = (Active::new(pair()), bodies());
    let mut forces = vec![GeneralisedForce::zeros(N_MODES); 2];
    let mut stage = 0_u32;
    bencher.counter(pair.facts().n_points()).bench_local(move || {
        stage += 1;
        bodies[0].position.z = 3.0 * RADIUS - approach - 1e-8 * f64::from(stage % 7);
        forces.iter_mut().for_each(GeneralisedForce::clear);
        pair.evaluate(Motion::new(0.0, &bodies), &mut forces).unwrap();
        pair.report().normal_force
    });
}

#[divan::bench]
fn in_contact(bencher: divan::Bencher<'_, '_>) {
    evaluate(bencher, 4e-6);
}

#[divan::bench]
fn apart(bencher: divan::Bencher<'_, '_>) {
    evaluate(bencher, -4e-6);
}

#[divan::bench]
fn save_and_restore(bencher: divan::Bencher<'_, '_>) {
    let mut pair = Active::new(pair());
    bencher.bench_local(move || {
        pair.save();
        pair.restore();
    });
}

#[divan::bench]
fn smallest_gap(bencher: divan::Bencher<'_, '_>) {
    let (mut pair, mut bodies) = (Active::new(pair()), bodies());
    bodies[0].position.z = 3.1 * RADIUS;
    bencher.bench_local(move || pair.meeting(Motion::new(0.0, &bodies)).gap);
}
