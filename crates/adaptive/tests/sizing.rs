//! Meshes that the program chooses: the lowest ten frequencies of every shape of the catalogue, from compact to slender.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

use adaptive::sizing::{SizeWish, Trial, mesh, mode_count};
use adaptive::spec::{DiscretisationSpec, ElasticSpec, ReductionSpec};
use iga_core::SplineError;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};

/// What a user may count on for the first ten frequencies.
const LIMIT: f64 = 3e-3;
const N_CHECKED: usize = 10;

fn body(shape: Result<Shape, SplineError>, model: Model) -> ElasticSpec {
    let shape = shape.unwrap();
    let degree = |d: usize| shape.patches.iter().map(|p| p.knots()[d].degree()).max().unwrap().max(3);
    let degrees: Vec<usize> = (0..shape.patches[0].dimension()).map(degree).collect();
    let elements = vec![1; degrees.len()];
    let mesh = DiscretisationSpec { degrees, elements, knots: None, refine: Vec::new() };
    let material = Material::new(210e9, 0.3, 7850.0).unwrap();
    ElasticSpec::new(shape, model, material, mesh, ReductionSpec::Modal { modes: 20 })
}

/// Largest relative error of the first ten frequencies of `elastic` with the elements chosen for `n_modes` modes, against a
/// mesh with twice the elements (half as many more in solids) and a degree more in every direction, whose own error is a
/// hundredth of the limit or less by the rate of smooth modes.
fn error(name: &str, elastic: &ElasticSpec, n_modes: usize) -> f64 {
    let wish = SizeWish { elements: true, modes: false };
    let trial = Trial::new(name, elastic, wish);
    let began = std::time::Instant::now();
    let (elements, estimate) = mesh::mesh(&trial, n_modes).unwrap();
    let seconds = began.elapsed().as_secs_f64();
    let chosen = trial.spectrum(&elements, N_CHECKED).unwrap().frequencies;
    let mut finer = elastic.clone();
    finer.discretisation.degrees.iter_mut().for_each(|p| *p += 1);
    let twice: Vec<usize> =
        elements.iter().map(|n| if elements.len() == 3 { n + n.div_ceil(2) } else { 2 * n }).collect();
    let reference = Trial::new(name, &finer, wish).spectrum(&twice, N_CHECKED).unwrap().frequencies;
    let errors = chosen.iter().zip(&reference).map(|(f, r)| (f / r - 1.0).abs());
    let error = errors.fold(0.0, f64::max);
    println!("{name}: {elements:?}, estimate {estimate:.1e}, error {error:.1e}, {seconds:.2} s");
    error
}

fn check(name: &str, shape: Result<Shape, SplineError>, model: Model) {
    let elastic = body(shape, model);
    let n_modes = mode_count::least(adaptive::elastic_body::rigid_motion(&model));
    let error = error(name, &elastic, n_modes);
    assert!(error < LIMIT, "{name}: {error:.2e}");
}

/// Length over thickness.
const PROPORTIONS: [f64; 4] = [1.0, 5.0, 30.0, 200.0];

#[test]
fn axisymmetric_shapes() {
    check("sphere", axisymmetric::sphere(0.01), Model::Axisymmetric);
    for p in PROPORTIONS {
        check(&format!("rod 1:{p}"), axisymmetric::rod(0.01, 0.02 * p), Model::Axisymmetric);
        check(&format!("plate {p}:1"), axisymmetric::rod(0.01 * p, 0.02), Model::Axisymmetric);
        let end = axisymmetric::rod_spherical_end(0.01, 0.02 * p);
        check(&format!("spherical end 1:{p}"), end, Model::Axisymmetric);
        let tube = axisymmetric::hollow_cylinder(0.01, 0.015, 0.03 * p);
        check(&format!("tube 1:{p}"), tube, Model::Axisymmetric);
        let wall = axisymmetric::hollow_cylinder(0.1, 0.1 + 0.1 / p, 0.1);
        check(&format!("wall 1:{p}"), wall, Model::Axisymmetric);
    }
}

#[test]
fn plane_shapes() {
    let stress = Model::PlaneStress { thickness: 0.01 };
    check("disc", plane::disc(0.01), stress);
    check("disc, plane strain", plane::disc(0.01), Model::PlaneStrain { thickness: 1.0 });
    for p in PROPORTIONS {
        check(&format!("rectangle 1:{p}"), plane::rectangle(0.01 * p, 0.01), stress);
        check(&format!("rectangle {p}:1"), plane::rectangle(0.01, 0.01 * p), stress);
    }
}

#[test]
fn slender_bars_vibrate_as_bernoulli_says() {
    let (size, length) = (0.01, 2.0);
    let bar = body(solid::cuboid([size, size, length]), Model::Solid);
    let trial = Trial::new("bar", &bar, SizeWish { elements: true, modes: false });
    let (elements, _) = mesh::mesh(&trial, 20).unwrap();
    assert!(elements[0] <= 4 && elements[1] <= 4 && elements[2] <= 100, "few across: {elements:?}");
    let found = trial.spectrum(&elements, 4).unwrap().frequencies;
    // Shear and rotary inertia lower the second pair by some (7.85 h / L)^2 / 12 (1 + E / (0.85 G)) / 2 = 3e-4, the first by a
    // third of it; the mesh may raise them by 1e-3 at most.
    let wave_speed = (210e9_f64 / 7850.0).sqrt();
    for (i, root) in [(0, 4.730_041), (1, 4.730_041), (2, 7.853_205), (3, 7.853_205_f64)] {
        let exact =
            root * root * wave_speed * size / 12f64.sqrt() / (std::f64::consts::TAU * length * length);
        assert!((found[i] / exact - 1.0).abs() < 1e-3, "mode {i}: {} and {exact}", found[i]);
    }
}

#[test]
#[ignore = "second tier: a minute"]
fn solid_bars() {
    for p in [30.0, 200.0] {
        check(&format!("box 1:1:{p}"), solid::cuboid([0.01, 0.01, 0.01 * p]), Model::Solid);
        check(&format!("cylinder 1:{p}"), solid::cylinder(0.005, 0.01 * p), Model::Solid);
        check(&format!("tube 1:{p}"), solid::hollow_cylinder(0.003, 0.005, 0.01 * p), Model::Solid);
    }
}

#[test]
#[ignore = "second tier: solid references of up to 100,000 unknowns"]
fn compact_and_flat_solids() {
    for p in [1.0, 5.0] {
        check(&format!("box 1:1:{p}"), solid::cuboid([0.01, 0.01, 0.01 * p]), Model::Solid);
        check(&format!("cylinder 1:{p}"), solid::cylinder(0.005, 0.01 * p), Model::Solid);
        check(&format!("tube 1:{p}"), solid::hollow_cylinder(0.003, 0.005, 0.01 * p), Model::Solid);
    }
    for net in SphereNet::ALL {
        check(&format!("ball {net:?}"), sphere::sphere(0.01, net), Model::Solid);
    }
    for p in [5.0, 30.0, 200.0] {
        check(&format!("box 1:{p}:{p}"), solid::cuboid([0.01, 0.01 * p, 0.01 * p]), Model::Solid);
        check(&format!("box 1:5:{p}"), solid::cuboid([0.01, 0.05, 0.01 * p]), Model::Solid);
        check(&format!("disc {p}:1"), solid::cylinder(0.005 * p, 0.01), Model::Solid);
        check(&format!("wall 1:{p}"), solid::hollow_cylinder(0.1, 0.1 + 0.1 / p, 0.1), Model::Solid);
    }
}
