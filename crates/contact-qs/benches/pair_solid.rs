//! Evaluations of a pair of solid balls: some 300 points per side, a thousand interface degrees of freedom, a hundred points in contact.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up shall stop")]

#[path = "../tests/common/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod common;
#[path = "../tests/pair_support/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod pair_support;

use contact_qs::{ActiveContact, Friction, SurfacePair};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{GeneralisedForce, Motion};
use pair_support::caps::{self, N_MODES, RADIUS};

const WIDTH: f64 = 1.5e-4;
const APPROACH: f64 = 2e-6;

fn main() {
    let mut pair = Active::new(caps::caps(WIDTH, 18, 1e18));
    let mut forces = vec![GeneralisedForce::zeros(N_MODES); 2];
    pair.evaluate(Motion::new(0.0, &caps::pressed(APPROACH)), &mut forces).unwrap();
    let report = pair.report();
    eprintln!(
        "{} points, {} in contact, {} interface degrees of freedom, {:.1} N, {} passes from nothing, rim {}",
        pair.facts().n_points(),
        report.n_active,
        pair.element().surface().n_interface(),
        report.normal_force,
        pair.found().n_passes(),
        report.is_rim_touched
    );
    divan::main();
}

/// Approach, sliding and turning that go up and down a little, as the stages of a time step do.
fn evaluate(bencher: divan::Bencher<'_, '_>, pair: SurfacePair, approach: f64, slide: f64) {
    let mut pair = Active::new(pair);
    let mut bodies = caps::pressed(approach);
    let mut forces = vec![GeneralisedForce::zeros(N_MODES); 2];
    let (mut stage, mut passes) = (0_u32, 0);
    bencher.counter(pair.facts().n_points()).bench_local(|| {
        stage += 1;
        bodies[0].position.z = 2.0 * RADIUS - approach - 5e-9 * f64::from(stage % 7);
        bodies[0].position.x = slide * (0.05 * f64::from(stage)).sin();
        bodies[0].velocity.x = slide * 5e4;
        forces.iter_mut().for_each(GeneralisedForce::clear);
        pair.save();
        pair.evaluate(Motion::new(0.0, &bodies), &mut forces).unwrap();
        passes += pair.found().n_passes();
        pair.report().normal_force
    });
    eprintln!("{:.2} passes an evaluation", passes as f64 / f64::from(stage));
}

#[divan::bench]
fn in_contact(bencher: divan::Bencher<'_, '_>) {
    evaluate(bencher, caps::caps(WIDTH, 18, 1e18), APPROACH, 0.0);
}

#[divan::bench]
fn sliding(bencher: divan::Bencher<'_, '_>) {
    evaluate(bencher, caps::caps(WIDTH, 18, 1e18), APPROACH, 2e-6);
}

/// The balls rub along each other.
#[divan::bench]
fn rubbing(bencher: divan::Bencher<'_, '_>) {
    let pair = caps::caps(WIDTH, 18, 1e18).with_friction(Friction::new(0.3)).unwrap();
    evaluate(bencher, pair, APPROACH, 2e-6);
}

#[divan::bench]
fn apart(bencher: divan::Bencher<'_, '_>) {
    evaluate(bencher, caps::caps(WIDTH, 18, 1e18), -APPROACH, 0.0);
}

#[divan::bench]
fn smallest_gap(bencher: divan::Bencher<'_, '_>) {
    let mut pair = Active::new(caps::caps(WIDTH, 18, 1e18));
    let bodies = caps::pressed(-1e-5);
    bencher.bench_local(|| pair.meeting(Motion::new(0.0, &bodies)).gap);
}

#[divan::bench]
fn smallest_gap_in_contact(bencher: divan::Bencher<'_, '_>) {
    let mut pair = Active::new(caps::caps(WIDTH, 18, 1e18));
    let bodies = caps::pressed(APPROACH);
    pair.evaluate(Motion::new(0.0, &bodies), &mut vec![GeneralisedForce::zeros(N_MODES); 2]).unwrap();
    bencher.bench_local(|| pair.meeting(Motion::new(0.0, &bodies)).gap);
}

#[divan::bench]
fn compliance_from_nothing(bencher: divan::Bencher<'_, '_>) {
    let mut pair = Active::new(caps::caps(WIDTH, 18, 1e18));
    let bodies = caps::pressed(APPROACH);
    bencher.bench_local(|| pair.compliance_weight(Motion::new(0.0, &bodies), f64::INFINITY).unwrap());
}

#[divan::bench]
fn save_and_restore(bencher: divan::Bencher<'_, '_>) {
    let mut pair = Active::new(caps::caps(WIDTH, 18, 1e18));
    bencher.bench_local(|| {
        pair.save();
        pair.restore();
    });
}
