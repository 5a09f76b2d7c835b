//! Ordering and factorisation, eigenmodes, compliance on a box of uniform cubic or quadratic B-splines.

#[path = "../tests/common/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod common;

use divan::Bencher;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::{ElasticProblem, Pencil, ReducedBasis, ResidualFlexibility};

/// Degree and elements per direction: 5,184 unknowns; 20,577 unknowns with 19³ control points. `REDUCTION_FINE=1` adds 52,728 unknowns.
const SIZES: [(usize, usize); 4] = [(2, 10), (2, 17), (3, 16), (2, 24)];

fn sizes() -> impl Iterator<Item = (usize, usize)> {
    let n = if std::env::var_os("REDUCTION_FINE").is_some() { 4 } else { 3 };
    SIZES.into_iter().take(n)
}

fn main() {
    divan::main();
}

fn body(size: (usize, usize)) -> (AssembledBody, Vec<usize>) {
    let body = common::block(size.0, [size.1; 3], [0.02, 0.021, 0.04]);
    let near = |x: &f64| x.abs() < 0.004;
    let interface = common::unknowns_at(&body, |p| p[2] > 0.0199 && near(&p[0]) && near(&p[1]));
    (body, interface)
}

#[divan::bench(args = sizes(), sample_count = 1, sample_size = 1)]
fn ordering_and_analysis(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    bencher.bench_local(|| Pencil::new(&body, &interface).expect("a sound body"));
}

#[divan::bench(args = sizes(), sample_count = 1, sample_size = 1)]
fn factorisation(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    bencher.bench_local(|| problem.pencil().cholesky(0.0, problem.held()).expect("supported"));
}

#[divan::bench(args = sizes(), sample_count = 1, sample_size = 1)]
fn eight_solves(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    let factor = problem.factor().expect("supported");
    let load = faer::Mat::from_fn(body.n_unknowns(), 8, |i, j| ((i * (j + 3)) as f64).sin());
    bencher.with_inputs(|| load.clone()).bench_local_refs(|x| factor.solve_in_place(x.as_mut()));
}

/// In single precision first, as the eigensolver does.
#[divan::bench(args = sizes(), sample_count = 1, sample_size = 1)]
fn single_precision_count(bencher: Bencher, size: (usize, usize)) {
    let (body, _) = body(size);
    let problem = ElasticProblem::free(&body, &[]).expect("a sound body");
    bencher.bench_local(|| {
        problem.pencil().inertia_single(1e11, problem.clamped_unknowns()).expect("enough memory")
    });
}

#[divan::bench(args = sizes(), sample_count = 1, sample_size = 1)]
fn inertia_count(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    bencher
        .bench_local(|| problem.pencil().inertia(1e11, problem.clamped_unknowns()).expect("enough memory"));
}

#[divan::bench(args = sizes(), sample_count = 1, sample_size = 1)]
fn thirty_checked_modes(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    bencher.bench_local(|| problem.lowest_modes(30).expect("modes"));
}

#[divan::bench(args = sizes(), sample_count = 1, sample_size = 1)]
fn compliance(bencher: Bencher, size: (usize, usize)) {
    let (body, interface) = body(size);
    let problem = ElasticProblem::free(&body, &interface).expect("a sound body");
    let modes = problem.lowest_modes(6).expect("modes");
    let low = ReducedBasis::from_modes(modes, problem.rigid().expect("a free body").clone());
    bencher.bench_local(|| ResidualFlexibility::new(&problem, &interface, &low).expect("compliance"));
}
