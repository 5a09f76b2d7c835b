//! Geometric stiffness: what uniform stress gives, what rigid motions give, independence of threads.

use crate::bodies;
use crate::bodies::{dot, largest, linear_field, multiply, noise};
use iga_core::elasticity::assembly::{assemble, geometric_stiffness};
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Patch;
use iga_core::space::{PatchSpace, Space};

/// Round-off of sums of some thousand terms.
const ROUND_OFF: f64 = 1e-12;
const THICKNESS: f64 = 0.02;
const MODELS: [Model; 3] =
    [Model::PlaneStrain { thickness: THICKNESS }, Model::PlaneStress { thickness: THICKNESS }, Model::Solid];

fn material() -> Material {
    Material::new(72.8e9, 0.33, 2789.0).unwrap()
}

fn space(model: &Model) -> PatchSpace {
    let patch: Patch = match model {
        Model::Solid => bodies::uniform(&bodies::brick([1.0, 2.0, 3.0], 0.2), 3, &[3, 2, 2]),
        _ => bodies::uniform(
            &bodies::quadrilateral([[0.2, 0.0], [1.3, 0.1], [0.1, 0.9], [1.0, 1.2]]),
            3,
            &[5, 4],
        ),
    };
    PatchSpace::new(vec![patch]).unwrap()
}

const GRADIENT: [[f64; 3]; 3] = [[1e-3, 2e-3, -1e-3], [3e-3, -2e-3, 2e-3], [1e-3, 4e-3, 3e-3]];

#[test]
fn uniform_stress_gives_its_product_with_linear_fields() {
    for model in MODELS {
        let (space, n) = (space(&model), model.dimension());
        let u = linear_field(space.control_points(), n, GRADIENT, [0.1; 3]);
        let matrix = geometric_stiffness(&space, &model, &material(), &[u]).unwrap().remove(0);
        let mut gradient = GRADIENT;
        if n == 2 {
            gradient =
                [[GRADIENT[0][0], GRADIENT[0][1], 0.0], [GRADIENT[1][0], GRADIENT[1][1], 0.0], [0.0; 3]];
        }
        let s = PointState::new(&model, &material(), &gradient, 0.0).stress;
        let stress = [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]];
        let mass = assemble(&space, &model, &material()).unwrap().mass;
        let one = vec![1.0; space.n_functions()];
        let volume = dot(&one, &multiply(&mass, &one)) / material().density();
        let scalar =
            |a: [f64; 3]| space.control_points().iter().map(|p| dot(&a[..n], &p[..n])).collect::<Vec<_>>();
        for (a, b) in [([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), ([1.0, -2.0, 0.5], [0.3, 1.0, 2.0])] {
            let found = dot(&scalar(a), &multiply(&matrix, &scalar(b)));
            let expected: f64 = volume
                * (0..n)
                    .flat_map(|i| (0..n).map(move |j| (i, j)))
                    .map(|(i, j)| a[i] * stress[i][j] * b[j])
                    .sum::<f64>();
            let scale = volume * largest(&s);
            assert!((found - expected).abs() < 10.0 * ROUND_OFF * scale, "{model:?}: {found} {expected}");
        }
        // A body moved as a whole gains no energy.
        assert!(largest(&multiply(&matrix, &one)) < ROUND_OFF * largest(matrix.val()));
    }
}

#[test]
fn rigid_motions_cause_no_geometric_stiffness() {
    for model in MODELS {
        let (space, n) = (space(&model), model.dimension());
        let spin = [[0.0, -1e-3, 2e-3], [1e-3, 0.0, -3e-3], [-2e-3, 3e-3, 0.0]];
        let fields = [spin, GRADIENT].map(|g| linear_field(space.control_points(), n, g, [0.5, 0.2, 0.1]));
        let matrices = geometric_stiffness(&space, &model, &material(), &fields).unwrap();
        assert!(largest(matrices[0].val()) < ROUND_OFF * largest(matrices[1].val()), "{model:?}");
    }
}

#[test]
fn geometric_stiffness_is_linear_in_the_field_and_independent_of_threads() {
    let model = Model::Solid;
    let space = space(&model);
    let [u, v] = [7, 9].map(|seed| noise(3 * space.n_functions(), seed));
    let sum: Vec<f64> = u.iter().zip(&v).map(|(a, b)| 2.0 * a - b).collect();
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let fields = [u.clone(), v.clone(), sum.clone()];
        pool.install(|| geometric_stiffness(&space, &model, &material(), &fields).unwrap())
    };
    let (one, three) = (by(1), by(3));
    for (a, b) in one.iter().zip(&three) {
        assert!(a.val().iter().zip(b.val()).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
    let scale = largest(one[2].val());
    for ((a, b), c) in one[0].val().iter().zip(one[1].val()).zip(one[2].val()) {
        assert!((2.0 * a - b - c).abs() < ROUND_OFF * scale);
    }
}
