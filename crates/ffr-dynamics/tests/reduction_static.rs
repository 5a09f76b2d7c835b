//! Static answers beside free modes: orthonormality, exact statics, rank.

use crate::common::{block, cylinder, from_identity, gram, unknowns_at};
use faer::{Mat, MatRef};
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::reduction::{
    ElasticProblem, FixedInterfaceModes, ReducedBasis, TakenLoads, craig_bampton, with_static_answers,
};
use nalgebra::{UnitQuaternion, Vector3};

const N_LOW: usize = 6;

/// Forces on the unknowns by force and moment at a marker that holds the nodes chosen, moments on a lever of 0.01 m.
fn face_loads(body: &AssembledBody, chosen: impl Fn(&[f64; 3]) -> bool) -> Mat<f64> {
    let nodes: Vec<u32> =
        (0..body.nodes.len()).filter(|&n| chosen(&body.nodes[n])).map(|n| n as u32).collect();
    let place = Vector3::zeros();
    let marker = MarkerWeights::of_nodes(body, place, UnitQuaternion::identity(), &nodes).unwrap();
    let mut loads = marker.forces(body.motion, body.n_unknowns()).unwrap();
    let first_moment = if body.motion.count() == 6 { 3 } else { 2 };
    for j in first_moment..loads.ncols() {
        loads.col_mut(j).iter_mut().for_each(|f| *f *= 0.01);
    }
    loads
}

/// A solid, a plane and an axisymmetric body with the loads of a marker on one end.
fn cases() -> Vec<(AssembledBody, Mat<f64>)> {
    let solid = block(2, [6, 4, 4], [0.03, 0.021, 0.019]);
    let plane = block(3, [8, 4, 0], [0.03, 0.02, 0.0]);
    let round = cylinder(3, [4, 10], 0.01, 0.02);
    let ends = [
        face_loads(&solid, |p| p[0] > 0.0149),
        face_loads(&plane, |p| p[0] > 0.0149),
        face_loads(&round, |p| p[1] < 1e-9),
    ];
    [solid, plane, round].into_iter().zip(ends).collect()
}

fn low_modes(problem: &ElasticProblem<'_>) -> ReducedBasis {
    ReducedBasis::from_modes(problem.lowest_modes(N_LOW).unwrap(), problem.rigid().unwrap().clone())
}

fn completed(problem: &ElasticProblem<'_>, loads: MatRef<'_, f64>) -> ReducedBasis {
    with_static_answers(problem, low_modes(problem), loads, TakenLoads::ByRank).unwrap()
}

/// Largest deviation of `shapesᵀ M shapes` from the identity, and of `shapesᵀ K shapes` from `ω_i ω_j δ_ij` as a share of `ω_i ω_j`.
fn deviations(body: &AssembledBody, basis: &ReducedBasis) -> (f64, f64) {
    let mass = from_identity(&gram(&basis.shapes, &body.mass_product(basis.shapes.as_ref())));
    let mut energy = gram(&basis.shapes, &body.stiffness_product(basis.shapes.as_ref()));
    for j in 0..basis.n_modes() {
        for i in 0..basis.n_modes() {
            energy[(i, j)] /= basis.omega[i] * basis.omega[j];
        }
    }
    (mass, from_identity(&energy))
}

/// Largest deviation of the reduced body's static answer to `loads` from the full one's, in the energy norm, as a share.
fn static_error(problem: &ElasticProblem<'_>, basis: &ReducedBasis, loads: MatRef<'_, f64>) -> f64 {
    let mut exact = loads.to_owned();
    problem.apply_flexibility(exact.as_mut());
    let mut coordinates = gram(&basis.shapes, &loads.to_owned());
    for j in 0..loads.ncols() {
        basis.omega.iter().enumerate().for_each(|(i, w)| coordinates[(i, j)] /= w * w);
    }
    let off = &exact - &basis.shapes * &coordinates;
    let energy = |u: &Mat<f64>| gram(u, &problem.stiffness_product(u.as_ref()));
    let (off, whole) = (energy(&off), energy(&exact));
    (0..loads.ncols()).map(|j| (off[(j, j)].abs() / whole[(j, j)]).sqrt()).fold(0.0, f64::max)
}

#[test]
fn pseudo_modes_are_orthonormal_and_free_modes_stay_as_they_are() {
    for (body, loads) in cases() {
        let problem = ElasticProblem::free(&body, &[]).unwrap();
        let (free, basis) = (low_modes(&problem), completed(&problem, loads.as_ref()));
        assert_eq!(basis.n_modes(), N_LOW + loads.ncols(), "{}", body.name);
        assert_eq!((basis.n_low, basis.first_static()), (basis.n_modes(), N_LOW));
        assert!(basis.omega.is_sorted());
        for (a, b) in basis.omega.iter().zip(&free.omega) {
            assert!((a / b - 1.0).abs() < 1e-12, "{}: {a:e} {b:e}", body.name);
        }
        // What eigenmodes share with the answers goes to the answers, at most 1e-7 of a mode; its square is missing in the product.
        let along = gram(&free.shapes, &body.mass_product(basis.shapes.as_ref().subcols(0, N_LOW)));
        for j in 0..N_LOW {
            assert!((along[(j, j)].abs() - 1.0).abs() < 1e-11, "{}: {:e}", body.name, along[(j, j)]);
        }
        let (mass, stiffness) = deviations(&body, &basis);
        // What eigenmodes may share with the answers in mass, and round-off of stiffness products, 1e-16 times the stiffest entry over
        // the softest of these modes, 1e5 here.
        assert!(mass <= 1e-8 && stiffness < 1e-9, "{}: {mass:e} {stiffness:e}", body.name);
        let momentum = gram(&basis.rigid.modes, &body.mass_product(basis.shapes.as_ref()));
        assert!(momentum.norm_max() < 1e-10);
    }
}

#[test]
fn static_answer_of_the_reduced_body_is_that_of_the_full_one() {
    for (body, loads) in cases() {
        let problem = ElasticProblem::free(&body, &[]).unwrap();
        let without = static_error(&problem, &low_modes(&problem), loads.as_ref());
        let with = static_error(&problem, &completed(&problem, loads.as_ref()), loads.as_ref());
        // Solves in double precision; six free modes alone leave a good part of the local deformation out.
        assert!(with < 1e-9, "{}: {with:e}", body.name);
        assert!(without > 1e-2, "{}: {without:e}", body.name);
    }
}

#[test]
fn loads_that_bring_nothing_new_are_dropped() {
    for (body, loads) in cases() {
        let problem = ElasticProblem::free(&body, &[]).unwrap();
        let once = completed(&problem, loads.as_ref());
        // The same marker twice, a moved marker on the same face, and loads that balance the inertia of rigid motions.
        let rigid = &problem.rigid().unwrap().mass_modes;
        let n = loads.ncols();
        let scale = |j: usize| if j.is_multiple_of(2) { 1.0 } else { -3.0 };
        let more = Mat::from_fn(body.n_unknowns(), 2 * n + rigid.ncols(), |i, j| match j {
            j if j < n => loads[(i, j)],
            j if j < 2 * n => scale(j) * loads[(i, j - n)] + 0.5 * loads[(i, (j + 1) % n)],
            j => rigid[(i, j - 2 * n)],
        });
        let again = completed(&problem, more.as_ref());
        assert_eq!(again.n_modes(), once.n_modes(), "{}: {:?}", body.name, again.static_loads);
        for (a, b) in again.omega.iter().zip(&once.omega) {
            // The tolerance of the rank is a share of energies, and frequencies are its roots.
            assert!((a / b - 1.0).abs() < 1e-7, "{}: {a:e} {b:e}", body.name);
        }
        assert!(static_error(&problem, &again, loads.as_ref()) < 1e-4); // root of the rank tolerance
        // A decision taken for another model is kept to.
        let taken = TakenLoads::Given(&once.static_loads);
        let given = with_static_answers(&problem, low_modes(&problem), loads.as_ref(), taken).unwrap();
        assert_eq!((given.omega, given.static_loads), (once.omega.clone(), once.static_loads.clone()));
    }
}

#[test]
fn modes_that_are_not_the_bodys_own_are_mixed_with_the_answers() {
    let (body, loads) = cases().swap_remove(0);
    let interface = unknowns_at(&body, |p| p[2] > 0.0094 && p[0].abs() < 0.008 && p[1].abs() < 0.006);
    let model = craig_bampton(&body, &interface, N_LOW, FixedInterfaceModes::Checked).unwrap();
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let n = model.basis.n_modes();
    let basis = with_static_answers(&problem, model.basis, loads.as_ref(), TakenLoads::ByRank).unwrap();
    assert_eq!((basis.n_low, basis.n_modes()), (N_LOW, n + loads.ncols()));
    let (mass, stiffness) = deviations(&body, &basis);
    // As for Craig-Bampton modes: the highest eigenvalue of the reduced problem is 1e4 times the lowest.
    assert!(mass < 1e-9 && stiffness < 1e-8, "{mass:e} {stiffness:e}");
    assert!(static_error(&problem, &basis, loads.as_ref()) < 1e-8);
}

#[test]
fn unsuitable_loads_are_refused() {
    let (body, mut loads) = cases().swap_remove(1);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let refused = |loads: MatRef<'_, f64>| {
        let outcome = with_static_answers(&problem, low_modes(&problem), loads, TakenLoads::ByRank);
        outcome.unwrap_err().to_string()
    };
    assert!(refused(Mat::zeros(3, 1).as_ref()).contains("the loads: 3, must be"));
    loads[(0, 0)] = f64::NAN;
    assert!(refused(loads.as_ref()).contains("not finite"));
    let none = completed(&problem, Mat::zeros(body.n_unknowns(), 0).as_ref());
    assert_eq!(none.n_modes(), N_LOW);
}
