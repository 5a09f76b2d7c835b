//! Basis evaluation, refinement and closest points.

use divan::{Bencher, black_box};
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, solid, sphere};
use iga_core::nurbs::{Patch, Prolongation};
use iga_core::splines::basis::basis_derivatives;
use iga_core::splines::knots::KnotVector;
use iga_core::surface::BodySurface;

fn main() {
    divan::main();
}

fn half_disc() -> Patch {
    let shape = axisymmetric::sphere(0.01).and_then(|s| s.refined(&[4, 3], &[24, 24], &[]));
    shape.expect("the sizes are valid").patches.remove(0)
}

fn cylinder(elements: usize) -> Patch {
    let shape = solid::cylinder(0.01, 0.02).and_then(|s| s.refined(&[3; 3], &[elements; 3], &[]));
    shape.expect("the sizes are valid").patches.remove(0)
}

#[divan::bench(args = [2, 3, 4])]
fn bsplines_with_two_derivatives(bencher: Bencher, degree: usize) {
    let knots = KnotVector::uniform(degree, 16).expect("the degree is supported");
    let mut out = [0.0; 30];
    bencher.bench_local(|| basis_derivatives(&knots, 7, black_box(0.46), 2, black_box(&mut out)));
}

#[divan::bench(args = [0, 1, 2])]
fn half_disc_degree_4_3_derivatives(bencher: Bencher, n_derivatives: usize) {
    let patch = half_disc();
    let mut basis = PointBasis::default();
    let xi = [0.46, 0.61, 0.0];
    let e = patch.find_element(&xi);
    bencher.bench_local(|| patch.evaluate(e, black_box(&xi), n_derivatives, black_box(&mut basis)));
}

#[divan::bench(args = [0, 1, 2])]
fn cylinder_degree_3_derivatives(bencher: Bencher, n_derivatives: usize) {
    let patch = cylinder(4);
    let mut basis = PointBasis::default();
    let xi = [0.46, 0.61, 0.32];
    let e = patch.find_element(&xi);
    bencher.bench_local(|| patch.evaluate(e, black_box(&xi), n_derivatives, black_box(&mut basis)));
}

/// From the seed to 16³ elements of degree 3; doubling the elements per direction makes eight times the work.
#[divan::bench(args = [8, 16, 32], sample_count = 10)]
fn refine_cylinder(bencher: Bencher, elements: usize) {
    bencher.bench_local(|| cylinder(black_box(elements)));
}

#[divan::bench]
fn prolongation_of_256_elements(bencher: Bencher) {
    let coarse = KnotVector::uniform(3, 128).expect("the degree is supported");
    let fine = KnotVector::uniform(3, 256).expect("the degree is supported");
    bencher.bench_local(|| Prolongation::new(black_box(&coarse), black_box(&fine)));
}

#[divan::bench]
fn closest_point_on_a_ball_cold(bencher: Bencher) {
    let ball = sphere::sphere(0.01, SphereNet::Cube).and_then(|s| s.refined(&[4; 3], &[8; 3], &[]));
    let ball = ball.expect("the sizes are valid");
    let surface = BodySurface::new(&ball.patches, false);
    let target = [0.012, 0.003, -0.001];
    bencher.bench_local(|| surface.closest(&ball.patches, black_box(&target)));
}

#[divan::bench]
fn closest_point_on_a_ball_warm(bencher: Bencher) {
    let ball = sphere::sphere(0.01, SphereNet::Cube).and_then(|s| s.refined(&[4; 3], &[8; 3], &[]));
    let ball = ball.expect("the sizes are valid");
    let surface = BodySurface::new(&ball.patches, false);
    let target = [0.012, 0.003, -0.001];
    let found = surface.closest(&ball.patches, &target).expect("a ball has faces");
    let near = found.xi.map(|u| 0.98 * u + 0.01);
    bencher.bench_local(|| surface.closest_from(&ball.patches, found.face, black_box(&target), &near));
}
