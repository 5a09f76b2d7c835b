//! Ordering and factorisation, eigenmodes, compliance on a box of uniform cubic or quadratic B-splines.

#[path = "../tests/common/mod.rs"]
mod common;

use divan::Bencher;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::{ElasticProblem, Pencil, ReducedBasis, ResidualFlexibility};

/// Degree and elements per direction: 5,184 unknowns; 20,577 unknowns with 19³ control points.
const SIZES: [(usize, usize); 3] = [(2, 10), (2, 17), (3, 16)];

fn main() {
    divan::main();
}

fn body(size: (usize, usize)) -> (AssembledBody, Vec<usize>) {
    let body = common::block(size.0, [size.1; 3], [0.02, 0.021, 0.04]);
    let near = |x: &f64| x.abs() < 0.004;
    let interface = common::unknowns_at(&body, |p| p[2] > 0.0199 && near(&p[0]) && near(&p[1]));
    (body, interface)
}

#[divan::bench(args = SIZES, sample_count = 1, sample_size = 1)]
fn ordering_and_analysis(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    bencher.bench_local(|| Pencil::new(&body, &interface).expect("a sound body"));
}

#[divan::bench(args = SIZES, sample_count = 1, sample_size = 1)]
fn factorisation(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    bencher.bench_local(|| problem.pencil().cholesky(0.0, problem.held()).expect("supported"));
}

#[divan::bench(args = SIZES, sample_count = 1, sample_size = 1)]
fn inertia_count(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    bencher.bench_local(|| problem.inertia(1e11).expect("enough memory"));
}

#[divan::bench(args = SIZES, sample_count = 1, sample_size = 1)]
fn thirty_checked_modes(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    bencher.bench_local(|| problem.lowest_modes(30).expect("modes"));
}

#[divan::bench(args = SIZES, sample_count = 1, sample_size = 1)]
fn compliance(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    let modes = problem.lowest_modes(6).expect("modes");
    let low = ReducedBasis::from_modes(modes, problem.rigid().expect("a free body").clone());
    bencher.bench_local(|| ResidualFlexibility::new(&problem, &interface, &low).expect("compliance"));
}
