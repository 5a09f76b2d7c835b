//! Craig-Bampton and the residual flexibility of an interface.

use crate::common::{block, cylinder, from_identity, gram, unknowns_at};
use crate::oracles::modal_compliance;
use faer::Mat;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::{
    ElasticProblem, FixedInterfaceModes, ReducedBasis, ResidualFlexibility, ResidualModes, craig_bampton,
};

const N_LOW: usize = 6;

fn bodies() -> Vec<(AssembledBody, Vec<usize>)> {
    // Three different edges: a double frequency must not be cut behind the sixth mode.
    let solid = block(2, [5, 4, 4], [0.03, 0.021, 0.019]);
    let top = unknowns_at(&solid, |p| p[2] > 0.0094 && p[0].abs() < 0.008 && p[1].abs() < 0.006);
    let round = cylinder(3, [8, 10], 0.01, 0.02);
    let foot = unknowns_at(&round, |p| p[1] < 1e-9 && p[0] < 0.004);
    vec![(solid, top), (round, foot)]
}

fn low_modes(problem: &ElasticProblem<'_>) -> ReducedBasis {
    let modes = problem.lowest_modes(N_LOW).expect("modes");
    ReducedBasis::from_modes(modes, problem.rigid().expect("a free body").clone())
}

#[test]
fn compliance_from_the_trailing_block_equals_inertia_relief_solutions() {
    for (body, interface) in bodies() {
        let problem = ElasticProblem::free(&body, &interface).unwrap();
        let low = low_modes(&problem);
        let flexibility = ResidualFlexibility::new(&problem, &interface, &low).unwrap();
        let g = flexibility.compliance();
        let n_b = interface.len();
        let mut unit = Mat::from_fn(body.n_unknowns(), n_b, |i, j| if i == interface[j] { 1.0 } else { 0.0 });
        flexibility.apply(unit.as_mut());
        let direct = Mat::from_fn(n_b, n_b, |i, j| unit[(interface[i], j)]);
        // Round-off of the factorisation, condition number about 1e5.
        assert!((g - &direct).norm_max() < 1e-9 * direct.norm_max());
    }
}

#[test]
fn both_routes_to_the_compliance_agree() {
    for (body, interface) in bodies() {
        let problem = ElasticProblem::free(&body, &interface).unwrap();
        let available = body.n_unknowns() - interface.len();
        let all = craig_bampton(&body, &interface, N_LOW, FixedInterfaceModes::Exactly(available)).unwrap();
        let route_1 = modal_compliance(&all.basis, &interface);
        let low = low_modes(&problem);
        let route_2 = ResidualFlexibility::new(&problem, &interface, &low).unwrap();
        let difference = (&route_1 - route_2.compliance()).norm_max() / route_1.norm_max();
        // All fixed-interface modes: the basis is complete, only the residual of the low modes (1e-6 squared) and round-off
        // remain.
        assert!(difference < 1e-8, "{}: {difference:e}", body.name);
    }
}

#[test]
fn compliance_converges_with_the_number_of_fixed_interface_modes() {
    for (body, interface) in bodies() {
        let problem = ElasticProblem::free(&body, &interface).unwrap();
        let exact = ResidualFlexibility::new(&problem, &interface, &low_modes(&problem)).unwrap();
        let error = |n: usize| {
            let model = craig_bampton(&body, &interface, N_LOW, FixedInterfaceModes::Exactly(n)).unwrap();
            let g = modal_compliance(&model.basis, &interface);
            (&g - exact.compliance()).norm_max() / exact.compliance().norm_max()
        };
        let (coarse, medium, fine) = (error(N_LOW + body.motion.count()), error(30), error(80));
        // Residual flexibility of the modes left out: what counts is the trend, the complete basis is tested above.
        assert!(medium < coarse && fine < 0.1 * coarse, "{}: {coarse:e} {medium:e} {fine:e}", body.name);
    }
}

#[test]
fn craig_bampton_retains_the_frequencies_of_the_full_model() {
    for (body, interface) in bodies() {
        let model = craig_bampton(&body, &interface, N_LOW, FixedInterfaceModes::Checked).unwrap();
        assert!(model.frequency_error < 1e-3, "{:e}", model.frequency_error);
        assert_eq!(model.basis.n_low, N_LOW);
        let r = body.motion.count();
        assert_eq!(model.basis.n_modes(), interface.len() + model.n_fixed_interface - r);
        // Rounding of the reduced problem: its highest eigenvalue is about 1e4 times the lowest.
        let product = body.mass_product(model.basis.shapes.as_ref());
        assert!(from_identity(&gram(&model.basis.shapes, &product)) < 1e-11);
        assert!(gram(&model.basis.rigid.modes, &product).norm_max() < 1e-11);
        let energy = gram(&model.basis.shapes, &body.stiffness_product(model.basis.shapes.as_ref()));
        for i in 0..model.basis.n_modes() {
            assert!((energy[(i, i)].sqrt() / model.basis.omega[i] - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn complete_craig_bampton_basis_reproduces_the_spectrum() {
    let (body, interface) = bodies().swap_remove(1);
    let full = ElasticProblem::free(&body, &[]).unwrap().all_modes().unwrap();
    let available = body.n_unknowns() - interface.len();
    let model = craig_bampton(&body, &interface, N_LOW, FixedInterfaceModes::Exactly(available)).unwrap();
    assert_eq!(model.basis.n_modes(), full.omega.len());
    for (i, (a, b)) in model.basis.omega.iter().zip(&full.omega).enumerate() {
        assert!((a / b - 1.0).abs() < 1e-8, "mode {i}: {a} {b}");
    }
}

#[test]
fn quasistatic_displacement_is_free_of_rigid_and_low_parts() {
    for (body, interface) in bodies() {
        let problem = ElasticProblem::free(&body, &interface).unwrap();
        let low = low_modes(&problem);
        let flexibility = ResidualFlexibility::new(&problem, &interface, &low).unwrap();
        let forces: Vec<f64> = (0..interface.len()).map(|i| 1.0 + (i % 3) as f64).collect();
        let u = flexibility.displacement(&forces);
        let u = Mat::from_fn(u.len(), 1, |i, _| u[i]);
        let product = body.mass_product(u.as_ref());
        let size = gram(&u, &product)[(0, 0)].sqrt();
        assert!(gram(&low.rigid.modes, &product).norm_max() < 1e-10 * size);
        // The residual of the low modes.
        assert!(gram(&low.shapes, &product).norm_max() < 1e-6 * size);
        // Its values at the interface are G f, its energy is f^T G f / 2.
        let work: f64 = interface.iter().zip(&forces).map(|(&i, f)| f * u[(i, 0)]).sum();
        let energy = gram(&u, &body.stiffness_product(u.as_ref()))[(0, 0)];
        assert!((energy / work - 1.0).abs() < 1e-9);
    }
}

#[test]
fn an_interface_that_leaves_nothing_to_hold_the_body_by_answers_alike() {
    for (body, interface) in bodies() {
        let all: Vec<usize> = (0..body.n_unknowns()).collect();
        let of = |interface: &[usize]| {
            let problem = ElasticProblem::free(&body, interface).unwrap();
            ResidualFlexibility::new(&problem, interface, &low_modes(&problem)).unwrap()
        };
        let (part, whole) = (of(&interface), of(&all));
        let scale = part.compliance().norm_max();
        // Round-off over the condition of the stiffness, and the residual of the low modes.
        let is_same = |x: f64, y: f64| (x - y).abs() < 1e-8 * scale;
        for (j, &b) in interface.iter().enumerate() {
            for (i, &a) in interface.iter().enumerate() {
                assert!(is_same(part.compliance()[(i, j)], whole.compliance()[(a, b)]), "{i} {j}");
            }
        }
        // Unknowns that hold the body, too.
        for j in all {
            let mut force = vec![0.0; body.n_unknowns()];
            force[j] = 1.0;
            for (i, u) in whole.displacement(&force).into_iter().enumerate() {
                assert!(is_same(u, whole.compliance()[(i, j)]), "{i} {j}: {u}");
            }
        }
    }
}

#[test]
fn residual_modes_are_what_the_residual_flexibility_stands_for() {
    for (body, interface) in bodies() {
        let problem = ElasticProblem::free(&body, &interface).unwrap();
        let flexibility = ResidualFlexibility::new(&problem, &interface, &low_modes(&problem)).unwrap();
        let modes = ResidualModes::new(&flexibility, &body).unwrap();
        let n_b = interface.len();
        let scaled = Mat::from_fn(n_b, n_b, |i, j| modes.interface_shapes[(i, j)] / modes.omega[j]);
        let g = &scaled * scaled.transpose();
        // Route 1 of the compliance; round-off of a Cholesky factor.
        let difference = (&g - flexibility.compliance()).norm_max() / g.norm_max();
        assert!(difference < 1e-11, "{}: {difference:e}", body.name);
        assert!(modes.omega.is_sorted());
        // Rayleigh and Ritz: what is mass-orthogonal to the lowest modes has no frequency below the next one's. It comes near to it, for
        // the static answer to a smooth load is much like the lowest modes that are left.
        let next = ElasticProblem::free(&body, &[]).unwrap().lowest_modes(N_LOW + 1).unwrap().omega[N_LOW];
        assert!(modes.omega[0] > next * (1.0 - 1e-9), "{}: {} {next}", body.name, modes.omega[0]);
        assert!(modes.omega[0] < 2.0 * next, "{}: {} {next}", body.name, modes.omega[0]);
    }
}

#[test]
fn residual_modes_vibrate_as_those_of_a_complete_craig_bampton_basis_under_loads_at_the_interface() {
    // Response to interface forces of the frequency w: sum of phi phi^T / (omega^2 - w^2). Both know the static answer; the first
    // moment of the mass as well, which the second derivative at w = 0 shows.
    for (body, interface) in bodies() {
        let available = body.n_unknowns() - interface.len();
        let all =
            craig_bampton(&body, &interface, N_LOW, FixedInterfaceModes::Exactly(available)).unwrap().basis;
        let problem = ElasticProblem::free(&body, &interface).unwrap();
        let flexibility = ResidualFlexibility::new(&problem, &interface, &low_modes(&problem)).unwrap();
        let modes = ResidualModes::new(&flexibility, &body).unwrap();
        let n_b = interface.len();
        let exact = Mat::from_fn(n_b, all.n_modes() - N_LOW, |i, j| {
            all.shapes[(interface[i], N_LOW + j)] / all.omega[N_LOW + j].powi(2)
        });
        let reduced = Mat::from_fn(n_b, n_b, |i, j| modes.interface_shapes[(i, j)] / modes.omega[j].powi(2));
        let (a, b) = (&exact * exact.transpose(), &reduced * reduced.transpose());
        // Round-off as above, and the residual of the low modes.
        assert!((&a - &b).norm_max() < 1e-6 * a.norm_max(), "{}", body.name);
    }
}

#[test]
fn interface_that_does_not_hold_the_body_is_refused() {
    let body = block(2, [3, 3, 3], [1.0, 1.0, 1.0]);
    let point = unknowns_at(&body, |p| p.iter().all(|x| *x > 0.49));
    let error = craig_bampton(&body, &point, 2, FixedInterfaceModes::Exactly(4)).unwrap_err();
    assert!(error.to_string().contains("rigid motions free"), "{error}");
}
