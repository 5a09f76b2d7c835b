//! The exact constraint on the compliance of a zone is the model with a massless boundary of Monjaraz-Tec, Gross and Krack (2022):
//! MacNeal's matrices, Signorini's law and the static balance of the boundary, solved here as they are written (docs/theory.md Eq. A.34, A.35).

use crate::common::Random;
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::compliance::sparse_rows::SparseRows;
use contact_qs::{ContactSubmodel, Plane, PlaneContact, PlaneContactSettings};
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use nalgebra::{DMatrix, DVector, SymmetricEigen, UnitQuaternion, Vector3};

/// Points on the boundary, free modes.
const POINTS: usize = 6;
const MODES: usize = 3;

/// Residual flexibility of the points along the normal and modes there; sizes of a steel ball, in m/N and 1/√kg.
fn boundary(seed: u64) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut random = Random::new(seed);
    let half = DMatrix::from_fn(POINTS, POINTS, |_, _| random.next());
    let flexibility = (&half * half.transpose() + DMatrix::identity(POINTS, POINTS)) * 1e-9;
    (flexibility, DMatrix::from_fn(POINTS, MODES, |_, _| random.next()))
}

/// Forces and positions of the boundary by the static balance `K_bb u_b + K_bi q = λ` with `0 ≤ gap ⟂ λ ≥ 0`: every set of points in contact
/// is tried, one fits.
fn signorini(
    stiffness: &DMatrix<f64>,
    by_modes: &DMatrix<f64>,
    gaps: &DVector<f64>,
    q: &DVector<f64>,
) -> (DVector<f64>, DVector<f64>) {
    let mut found = None;
    for set in 0..1_usize << POINTS {
        let touches = |i: usize| set >> i & 1 == 1;
        // Touching points are where the plane is, the others carry nothing.
        let mut matrix = stiffness.clone();
        let mut right = -(by_modes * q);
        for i in (0..POINTS).filter(|&i| touches(i)) {
            matrix.row_mut(i).fill(0.0);
            matrix[(i, i)] = stiffness[(i, i)];
            right[i] = -gaps[i] * stiffness[(i, i)];
        }
        let place = matrix.lu().solve(&right).unwrap();
        let forces = stiffness * &place + by_modes * q;
        let fits = (0..POINTS).all(|i| if touches(i) { forces[i] >= 0.0 } else { gaps[i] + place[i] > 0.0 });
        if fits {
            assert!(found.is_none(), "the complementarity problem has one solution");
            found = Some((forces, place));
        }
    }
    found.unwrap()
}

#[test]
fn the_exact_constraint_is_signorinis_law_on_macneals_massless_boundary() {
    let mut touching = [0; POINTS + 1];
    for seed in 0..12 {
        let (flexibility, modes) = boundary(seed);
        let stiffness = flexibility.clone().try_inverse().unwrap();
        let by_modes = -(&stiffness * &modes);
        let mut random = Random::new(100 + seed);
        let heights: Vec<f64> = (0..POINTS).map(|_| 2e-6 * random.next()).collect();
        let q = DVector::from_fn(MODES, |_, _| 1e-6 * random.next());
        // Axisymmetric: rows are the radial, then the axial component of a point.
        let axial = |i: usize| i % 2 == 1;
        let submodel = ContactSubmodel {
            motion: RigidMotion::Axial,
            points: heights.iter().map(|z| [1e-3, 0.0, *z]).collect(),
            areas: vec![1e-8; POINTS],
            low: Mat::from_fn(2 * POINTS, MODES, |i, j| if axial(i) { modes[(i / 2, j)] } else { 0.0 }),
            compliance: Mat::from_fn(2 * POINTS, 2 * POINTS, |i, j| {
                if axial(i) && axial(j) { flexibility[(i / 2, j / 2)] } else { 0.0 }
            })
            .into(),
            interface: SparseRows::default(),
            rim: Vec::new(),
            facing: Vec::new(),
            left_out: Vec::new(),
        };
        let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
        let settings =
            PlaneContactSettings { body: 0, plane, penalty: f64::INFINITY, method: Method::ActiveSet };
        let mut contact = Active::new(PlaneContact::new(submodel, settings).unwrap());
        let mut state = BodyState::at_rest(MODES);
        state.rotation = UnitQuaternion::identity();
        state.elastic = q.as_slice().to_vec();
        let mut sums = vec![GeneralisedForce::zeros(MODES)];
        contact.evaluate(Motion::new(0.0, std::slice::from_ref(&state)), &mut sums).unwrap();

        let (forces, place) = signorini(&stiffness, &by_modes, &DVector::from_vec(heights), &q);
        touching[forces.iter().filter(|f| **f > 0.0).count()] += 1;
        // Round-off of gaps of 1e-6 m over compliances of 1e-9 m/N, some 1e3 N, and of the inverse.
        let limit = 1e-11 * 1e3;
        assert!((sums[0].force.z - forces.sum()).abs() < limit, "{}", sums[0].force.z);
        // The dynamic equations: what the boundary exerts on the modes, with K_ii's share Φᵀ K_bb Φ q of MacNeal's matrices.
        let on_modes = -(by_modes.transpose() * &place + modes.transpose() * &stiffness * &modes * &q);
        for (found, exact) in sums[0].elastic.iter().zip(on_modes.iter()) {
            assert!((found - exact).abs() < limit, "{found} {exact}");
        }
    }
    assert!(touching.iter().filter(|n| **n > 0).count() >= 3, "several sets: {touching:?}");
}

/// A bar of unit length, mass and speed of waves in `n` linear elements, consistent mass: stiffness and mass, the node that touches first.
fn bar(n: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let (mut stiffness, mut mass) = (DMatrix::zeros(n + 1, n + 1), DMatrix::zeros(n + 1, n + 1));
    let h = 1.0 / n as f64;
    for e in 0..n {
        for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let is_same = a == b;
            stiffness[(e + a, e + b)] += if is_same { 1.0 } else { -1.0 } / h;
            mass[(e + a, e + b)] += if is_same { 2.0 } else { 1.0 } * h / 6.0;
        }
    }
    (stiffness, mass)
}

/// Rigid mass that is left when the boundary of Craig and Bampton's matrices, its constraint modes made orthogonal to `n_modes` modes of the
/// bar held there, loses its mass.
fn mass_left(n: usize, n_modes: usize) -> f64 {
    let (stiffness, mass) = bar(n);
    let (inner_k, inner_m) = (stiffness.view((1, 1), (n, n)), mass.view((1, 1), (n, n)));
    let factor = inner_m.clone_owned().cholesky().unwrap();
    let l = factor.l();
    let whitened = l.solve_lower_triangular(&inner_k.clone_owned()).unwrap();
    let whitened = l.solve_lower_triangular(&whitened.transpose()).unwrap();
    let eigen = SymmetricEigen::new(0.5 * (&whitened + whitened.transpose()));
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    // A free bar's constraint mode is its rigid motion.
    let rigid = DVector::repeat(n, 1.0);
    let moved = mass.view((1, 0), (n, 1)) + inner_m * rigid;
    order[..n_modes]
        .iter()
        .map(|&k| {
            let mode =
                l.transpose().solve_upper_triangular(&eigen.eigenvectors.column(k).into_owned()).unwrap();
            mode.dot(&moved.column(0)).powi(2)
        })
        .sum()
}

#[test]
fn a_massless_boundary_of_craig_and_bampton_takes_mass_from_the_body() {
    // The modes of a bar held at one end have the effective masses 8/((2j-1)π)²; what is beyond the last one kept is lost.
    for n_modes in [1_u32, 5, 20] {
        let kept: f64 =
            (1..=n_modes).map(|j| 8.0 / (f64::from(2 * j - 1) * std::f64::consts::PI).powi(2)).sum();
        let found = mass_left(400, n_modes as usize);
        // Linear elements: each mode errs by (k h)²/24 of its mass, which falls as k²: by 8 h²/24 of the whole.
        let limit = f64::from(n_modes) * 8.0 / 24.0 / 400.0_f64.powi(2);
        assert!((found - kept).abs() < limit, "{n_modes}: {found} {kept}");
    }
    // The rest of the sum is 2/(π² n) but for its relative 1/(12 n²).
    let lost = 1.0 - mass_left(400, 20);
    assert!((lost * 20.0 * std::f64::consts::PI.powi(2) / 2.0 - 1.0).abs() < 0.01, "{lost}");
}
