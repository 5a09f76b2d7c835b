//! Eigenfrequencies of free spheres against Lamb's closed form.

use std::f64::consts::TAU;

use ffr_dynamics::reduction::problem::ElasticProblem;

use super::support::{Table, assert_below, assert_close, built, parsed, shipped};

// Claim 6 of docs/verification.md; the mesh of the scenario is good for 6e-5.
const AXISYMMETRIC: f64 = 5e-4;
// Claim 7 of docs/verification.md; about 2500 degrees of freedom in each net.
const SOLID: f64 = 1e-3;
// Claim 8 of docs/verification.md; rigid motions of the discretised ball are exact, so that only round-off is left.
const RIGID: f64 = 1e-3;

#[test]
fn axisymmetric_aluminium_sphere_has_the_spheroidal_modes_of_lamb() {
    let table = Table::read("lamb_sphere_alu");
    let families = table.text("family");
    let all = table.column("frequency");
    let expected: Vec<f64> =
        families.iter().zip(all).filter(|(family, _)| **family == "S").map(|(_, f)| f).take(6).collect();
    let model = built(&shipped("sphere_on_plane", &[]));
    let omega = &model.bodies[0].flexible().expect("flexible").reduced.basis.omega;
    assert_eq!((expected.len(), omega.len()), (6, 6));
    for (i, (w, f)) in omega.iter().zip(expected).enumerate() {
        assert_close(&format!("mode {}", i + 1), w / TAU, f, AXISYMMETRIC);
    }
}

/// The steel ball of the reference table in the net `net`.
fn solid_sphere_has_the_multiplets_of_lamb(net: &str, degree: usize, elements: usize) {
    let table = Table::read("lamb_sphere_steel");
    let (f, count) = (table.column("frequency"), table.column("multiplicity"));
    let expected: Vec<f64> =
        f.iter().zip(count).flat_map(|(&f, n)| std::iter::repeat_n(f, n as usize)).take(27).collect();
    let model = built(&parsed(&format!(
        r#"
        simulation = {{ end_time = 1.0 }}
        materials.steel = {{ youngs_modulus = 210.0e9, poissons_ratio = 0.3, density = 7850.0 }}
        [bodies.ball]
        material = "steel"
        geometry = {{ shape = "sphere", radius = 10.0e-3, net = "{net}" }}
        discretisation = {{ degree = {degree}, elements = {elements} }}
        reduction = {{ method = "modal", modes = 27 }}
        "#
    )));
    let elastic = model.bodies[0].flexible().expect("flexible");
    let (basis, body) = (&elastic.reduced.basis, elastic.body.assembled());
    let worst = basis.omega.iter().zip(&expected).map(|(w, f)| (w / TAU / f - 1.0).abs());
    assert_eq!(basis.omega.len(), expected.len());
    assert_below(&format!("{net}: largest error of 27 frequencies"), worst.fold(0.0, f64::max), SOLID);
    // Rigid modes are removed from the basis; their Rayleigh quotients show what they would have come out as.
    assert_eq!(basis.rigid.count(), 6);
    let problem = ElasticProblem::free(body, &[]).expect("a free body");
    let force = problem.stiffness_product(basis.rigid.modes.as_ref());
    for k in 0..6 {
        let quotient = basis.rigid.modes.col(k).transpose() * force.col(k);
        let frequency = quotient.abs().sqrt() / TAU; // round-off may be negative
        assert_below(&format!("{net}: rigid mode {k}"), frequency / expected[0], RIGID);
    }
    // Six eigenvalues and no more lie below the first elastic one: nothing is lost and nothing spurious came in.
    let below = problem
        .pencil()
        .inertia((0.99 * basis.omega[0]).powi(2), problem.clamped_unknowns())
        .expect("memory suffices");
    assert_eq!(below.negative, 6, "{net}: eigenvalues below the first elastic one");
    let lowest = problem
        .pencil()
        .inertia((RIGID * basis.omega[0]).powi(2), problem.clamped_unknowns())
        .expect("memory suffices");
    assert_eq!(lowest.negative, 6, "{net}: rigid modes below 1e-3 of the first elastic one");
}

#[test]
fn solid_sphere_in_the_cube_net_has_the_multiplets_of_lamb() {
    solid_sphere_has_the_multiplets_of_lamb("cube", 7, 2);
}

#[test]
#[ignore = "second tier: ten seconds; two other nets are in the first"]
fn solid_sphere_in_the_spindle_net_has_the_multiplets_of_lamb() {
    // The weights of its meridians change more than those of the other nets: more elements for the same accuracy.
    solid_sphere_has_the_multiplets_of_lamb("spindle", 5, 9);
}

#[test]
fn solid_sphere_in_the_shells_net_has_the_multiplets_of_lamb() {
    solid_sphere_has_the_multiplets_of_lamb("shells", 5, 1);
}
