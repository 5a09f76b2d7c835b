//! The sparse factor against a dense one, under any order and on any number of threads (Eqs. R.3, R.4).

use crate::common;
use std::sync::Arc;

use faer::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::reduction::{CholeskyFactor, ElasticProblem, Pencil, SymbolicFactor};

type Sparse = SparseColMat<u32, f64>;

/// Lower triangle of a diagonally dominant matrix with the edges given.
fn dominant(n: u32, edges: &[(u32, u32)]) -> Sparse {
    let mut degree = vec![1.5; n as usize];
    let mut entries = Vec::new();
    for (k, &(a, b)) in edges.iter().enumerate() {
        let value = -0.5 - 0.4 * (k as f64).sin();
        entries.push(Triplet::new(a.max(b), a.min(b), value));
        degree[a as usize] += value.abs();
        degree[b as usize] += value.abs();
    }
    entries.extend(degree.iter().enumerate().map(|(i, &d)| Triplet::new(i as u32, i as u32, d)));
    SparseColMat::try_new_from_triplets(n as usize, n as usize, &entries).expect("entries within the matrix")
}

/// Numbers in a random order.
fn shuffled(n: u32) -> Vec<u32> {
    let mut order: Vec<u32> = (0..n).collect();
    let mut state = 0x9e37_79b9_u64;
    for i in (1..n as usize).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        order.swap(i, (state >> 33) as usize % (i + 1));
    }
    order
}

fn factor(matrix: &Sparse, order: Vec<u32>, n_last: usize) -> CholeskyFactor {
    let symbolic = Arc::new(SymbolicFactor::new(matrix.symbolic(), order, n_last).expect("a permutation"));
    symbolic.cholesky(matrix.as_ref(), "a test").expect("a definite matrix")
}

/// Compares all of the factor with a dense one, and a solve.
fn check(matrix: &Sparse, order: Vec<u32>, n_last: usize) {
    let n = matrix.nrows();
    let last: Vec<usize> = order[n - n_last..].iter().map(|&i| i as usize).collect();
    let sparse = factor(matrix, order, n_last);
    let order = sparse.symbolic().order();
    assert!(sparse.symbolic().ends_with(&last));
    let mut position = vec![0; n];
    order.iter().enumerate().for_each(|(p, &i)| position[i as usize] = p);
    let mut dense = Mat::<f64>::zeros(n, n);
    for j in 0..n {
        for (i, &value) in matrix.as_ref().row_idx_of_col(j).zip(matrix.as_ref().val_of_col(j)) {
            dense[(position[i], position[j])] = value;
            dense[(position[j], position[i])] = value;
        }
    }
    let expected = Llt::new(dense.as_ref(), Side::Lower).expect("a definite matrix");
    // Round-off of sums of n products, diagonally dominant or with a condition of about 1e6 in the relative sense.
    let tolerance = 1e-9 * expected.L().norm_max();
    assert!((expected.L() - &sparse.trailing_block(n)).norm_max() < tolerance);

    let x = Mat::from_fn(n, 11, |i, j| ((3 * i + 5 * j) % 7) as f64 - 3.0);
    let mut b = Mat::zeros(n, 11);
    ffr_dynamics::reduction::blocks::product::symmetric_product(matrix.as_ref(), x.as_ref(), b.as_mut());
    sparse.solve_in_place(b.as_mut());
    assert!((&b - &x).norm_max() < 1e-7);
}

#[test]
fn factor_is_that_of_a_dense_matrix_under_any_order() {
    let path: Vec<(u32, u32)> = (0..299).map(|i| (i, i + 1)).collect();
    let star: Vec<(u32, u32)> = (1..200).map(|i| (0, i)).collect();
    let grid: Vec<(u32, u32)> = (0..400)
        .flat_map(|i| [(i % 20 < 19).then_some((i, i + 1)), (i < 380).then_some((i, i + 20))])
        .flatten()
        .collect();
    // Two parts that know nothing of each other, and unknowns alone.
    let apart: Vec<(u32, u32)> = path.iter().copied().filter(|&(a, _)| a != 100 && a < 250).collect();
    let full: Vec<(u32, u32)> = (0..150).flat_map(|a| (0..a).map(move |b| (a, b))).collect();
    for (n, edges) in [(300, &path), (200, &star), (400, &grid), (300, &apart), (150, &full), (1, &vec![])] {
        let matrix = dominant(n, edges);
        for order in [(0..n).collect(), (0..n).rev().collect(), shuffled(n)] {
            for n_last in [0, 1, n as usize / 3, n as usize] {
                check(&matrix, Vec::clone(&order), n_last);
            }
        }
    }
}

#[test]
fn factor_of_a_solid_is_that_of_a_dense_matrix() {
    let body = common::block(2, [8, 4, 3], [1.0, 0.6, 0.5]);
    let interface = common::unknowns_at(&body, |p| p[2] > 0.249);
    let pencil = Pencil::new(&body, &interface).unwrap();
    // Stiffness and mass are of one size at this shift.
    let matrix = pencil.combination(1e9, &vec![false; body.n_unknowns()]);
    check(&matrix, pencil.symbolic().order().to_vec(), interface.len());
    check(&matrix, shuffled(body.n_unknowns() as u32), 0);
}

/// What `work` gives with one, two and three threads.
fn on_threads<R: Send>(work: impl Fn() -> R + Sync) -> Vec<R> {
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
    [1, 2, 3].map(|n| pool(n).install(&work)).into()
}

fn bits(x: &Mat<f64>) -> Vec<u64> {
    x.col_iter().flat_map(|c| c.iter().map(|v| v.to_bits()).collect::<Vec<_>>()).collect()
}

#[test]
fn factors_and_solves_are_the_same_bits_on_any_number_of_threads() {
    // 8,232 unknowns: separators of 1,176 unknowns, so that subtrees, tiles and panels all are shared between threads.
    let body = common::block(2, [12; 3], [0.02, 0.021, 0.05]);
    let n = body.n_unknowns();
    let free = vec![false; n];
    let load = || Mat::from_fn(n, 20, |i, j| ((i * (j + 3)) as f64).sin());

    let double = on_threads(|| {
        let pencil = Pencil::new(&body, &[]).unwrap();
        let factor = pencil.cholesky(1e11, &free).unwrap();
        let mut x = load();
        factor.solve_in_place(x.as_mut());
        let inertia = pencil.inertia(2e11, &free).unwrap();
        (bits(&factor.trailing_block(1500)), bits(&x), inertia.negative, inertia.growth.to_bits())
    });
    let single = on_threads(|| {
        let problem = ElasticProblem::free(&body, &[]).unwrap();
        let mut x = load();
        problem.apply_flexibility(x.as_mut());
        let count = problem.pencil().inertia_single(2e11, &free).unwrap().expect("a good count");
        (bits(&x), count.negative, count.growth.to_bits(), count.contraction.map(f64::to_bits))
    });
    for k in 1..3 {
        assert!(double[k] == double[0], "double precision, {} threads", k + 1);
        assert!(single[k] == single[0], "single precision, {} threads", k + 1);
    }
    assert_eq!(single[0].1, double[0].2);
}

#[test]
fn the_first_pivot_that_fails_is_named_whoever_finds_it() {
    let body = common::block(2, [12; 3], [0.02, 0.021, 0.05]);
    let pencil = Pencil::new(&body, &[]).unwrap();
    let order = pencil.symbolic().order();
    let n = order.len();
    let mut matrix = pencil.combination(1e11, &vec![false; n]);
    // Early in one half of the body and in the other, and in the separator.
    let spoilt = [n / 5, 2 * n / 3, n - 10];
    for (k, &position) in spoilt.iter().enumerate().rev() {
        let unknown = order[position] as usize;
        let diagonal = matrix.symbolic().col_range(unknown).start;
        matrix.val_mut()[diagonal] *= -1.0;
        for found in on_threads(|| pencil.symbolic().cholesky(matrix.as_ref(), "K").map(|_| ())) {
            match found {
                // All leading blocks without the unknown are definite: its own pivot is the first to fail.
                Err(DynamicsError::NotPositiveDefinite { pivot, size, .. }) => {
                    assert_eq!((pivot, size), (order[spoilt[k]] as usize, n));
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn what_is_not_a_number_is_no_pivot() {
    let mut matrix = dominant(40, &[(0, 1), (1, 2)]);
    let place = matrix.symbolic().col_range(1).start;
    matrix.val_mut()[place] = f64::NAN;
    let symbolic = Arc::new(SymbolicFactor::new(matrix.symbolic(), (0..40).collect(), 0).unwrap());
    let found = symbolic.cholesky(matrix.as_ref(), "K").map(|_| ());
    assert!(matches!(found, Err(DynamicsError::NotPositiveDefinite { pivot: 1, .. })), "{found:?}");
}

#[test]
fn more_entries_than_32_bits_count_are_counted() {
    // A star whose hub is eliminated first: all others become neighbours of each other.
    let n = 120_000;
    let edges: Vec<(u32, u32)> = (1..n).map(|i| (0, i)).collect();
    let entries = f64::from(n) * f64::from(n - 1) / 2.0;
    assert!(entries > f64::from(u32::MAX));
    match SymbolicFactor::new(dominant(n, &edges).symbolic(), (0..n).collect(), 0) {
        Ok(symbolic) => assert!(symbolic.n_entries() as f64 > entries),
        Err(DynamicsError::FactorTooLarge { unknowns, gigabytes, .. }) => {
            assert_eq!(unknowns, n as usize);
            assert!(gigabytes > 4e-9 * entries, "{gigabytes}");
        }
        Err(other) => panic!("{other}"),
    }
}
