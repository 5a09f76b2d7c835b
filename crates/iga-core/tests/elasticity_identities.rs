//! Identities that stiffness and mass satisfy for every model: rigid motions, patch test, strain energy, total mass.

use crate::bodies;
use crate::bodies::{at_unknowns, dot, largest, linear_field, multiply, noise};
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::mapping::PointMap;
use iga_core::elasticity::recovery::RecoveryWorkspace;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Patch;
use iga_core::quadrature::GaussRule;
use iga_core::space::{GridBasis, PatchSpace, Space, SplineSpace};

const THICKNESS: f64 = 0.02;
const PLANE: [Model; 2] =
    [Model::PlaneStrain { thickness: THICKNESS }, Model::PlaneStress { thickness: THICKNESS }];

/// Round-off of sums of some thousand terms.
const ROUND_OFF: f64 = 1e-12;

fn aluminium() -> Material {
    Material::new(72.8e9, 0.33, 2789.0).unwrap()
}

fn space(patch: Patch) -> PatchSpace {
    PatchSpace::new(vec![patch]).unwrap()
}

/// A rational patch for every model; the axisymmetric ones away from the axis and on it.
fn cases() -> Vec<(Model, PatchSpace)> {
    let annulus = bodies::quarter_annulus(1.0, 2.0, [0.3, -0.2]);
    let ring = bodies::quarter_annulus(0.2, 0.5, [1.0, 0.0]);
    let shell = bodies::quarter_annulus(0.5, 1.0, [0.0, 0.0]);
    let mut cases = Vec::new();
    for model in PLANE {
        cases.push((model, space(bodies::uniform(&annulus, 2, &[3, 4]))));
        cases.push((model, space(bodies::uniform(&bodies::disc(0.1), 3, &[3, 3]))));
    }
    cases.push((Model::Axisymmetric, space(bodies::uniform(&ring, 2, &[3, 3]))));
    cases.push((Model::Axisymmetric, space(bodies::uniform(&shell, 3, &[3, 4]))));
    cases.push((Model::Solid, space(bodies::uniform(&bodies::cylinder(0.01, 0.02), 2, &[3, 3, 2]))));
    cases.push((Model::Solid, space(bodies::uniform(&bodies::brick([1.0, 2.0, 3.0], 0.2), 3, &[2, 2, 2]))));
    cases
}

#[test]
fn rigid_motions_cause_no_force() {
    for (model, space) in cases() {
        let matrices = assemble(&space, &model, &aluminium()).unwrap();
        let n = model.dimension();
        let none = [[0.0; 3]; 3];
        let mut motions = Vec::new();
        match model {
            Model::Axisymmetric => motions.push((none, [0.0, 1.0, 0.0])),
            _ => {
                for c in 0..n {
                    let mut shift = [0.0; 3];
                    shift[c] = 1.0;
                    motions.push((none, shift));
                }
                for (i, j) in [(0, 1), (1, 2), (2, 0)].into_iter().filter(|&(i, j)| i.max(j) < n) {
                    let mut spin = none;
                    (spin[i][j], spin[j][i]) = (-1.0, 1.0);
                    motions.push((spin, [0.0; 3]));
                }
            }
        }
        for (spin, shift) in motions {
            let u = linear_field(space.control_points(), n, spin, shift);
            let u = at_unknowns(&matrices.dofs, &u, n);
            let force = largest(&multiply(&matrices.stiffness, &u));
            let scale = largest(matrices.stiffness.val()) * largest(&u);
            assert!(force <= ROUND_OFF * scale, "{model:?}: {force:e} of {scale:e}");
        }
    }
}

/// Largest force inside and on the boundary for a displacement that is linear in the position.
fn linear_field_forces(model: &Model, space: &PatchSpace) -> (f64, f64) {
    let (n, patch) = (model.dimension(), &space.patches()[0]);
    let gradient = if *model == Model::Axisymmetric {
        [[2e-3, 0.0, 0.0], [0.0, -3e-3, 0.0], [0.0; 3]]
    } else {
        [[1e-3, 2e-3, -1e-3], [3e-3, -2e-3, 2e-3], [1e-3, 4e-3, 3e-3]]
    };
    let matrices = assemble(space, model, &aluminium()).unwrap();
    let u = at_unknowns(&matrices.dofs, &linear_field(space.control_points(), n, gradient, [0.0; 3]), n);
    let force = multiply(&matrices.stiffness, &u);
    let sizes = patch.net_size();
    let is_inside = |node: u32| {
        let index = iga_core::splines::tensor::multi_index(&sizes, node as usize);
        sizes.iter().zip(index).all(|(&n, i)| i > 0 && i + 1 < n)
    };
    let (mut inside, mut outside) = (0.0f64, 0.0f64);
    for (&(node, _), f) in matrices.dofs.iter().zip(&force) {
        let side = if is_inside(node) { &mut inside } else { &mut outside };
        *side = side.max(f.abs());
    }
    (inside, outside)
}

#[test]
fn linear_displacements_balance_inside_polynomial_patches() {
    // Gauss points integrate det J grad R exactly here: degree 2 p - 1 in the plane and p + 2 <= 2 p - 1 for p = 3 in the
    // trilinear bodies; axisymmetric integrals of a bilinear patch have degree p + 2 too.
    let quad = bodies::quadrilateral([[0.2, 0.0], [1.3, 0.1], [0.1, 0.9], [1.0, 1.2]]);
    let mut cases: Vec<(Model, PatchSpace)> = Vec::new();
    for p in 1..=4 {
        cases.extend(PLANE.map(|m| (m, space(bodies::uniform(&quad, p, &[3, 2])))));
    }
    cases.push((Model::Axisymmetric, space(bodies::uniform(&quad, 3, &[3, 2]))));
    cases.push((Model::Solid, space(bodies::uniform(&bodies::brick([1.0; 3], 0.3), 3, &[3, 2, 2]))));
    for (model, space) in cases {
        let (inside, outside) = linear_field_forces(&model, &space);
        assert!(inside <= ROUND_OFF * outside, "{model:?}: {inside:e} of {outside:e}");
    }
}

#[test]
fn linear_displacements_balance_inside_rational_patches_up_to_quadrature() {
    // det J grad R is rational. The error of p Gauss points holds the p-th derivatives of R, of size h^-p: against the
    // forces outside it falls at least with h^p, faster where neighbouring elements cancel.
    let annulus = bodies::quarter_annulus(1.0, 2.0, [0.0, 0.0]);
    let cylinder = bodies::cylinder(0.01, 0.02);
    for model in [PLANE[0], PLANE[1], Model::Axisymmetric, Model::Solid] {
        let ratios: Vec<f64> = [2, 4, 8]
            .iter()
            .map(|&n| {
                let patch = match model {
                    Model::Solid => bodies::uniform(&cylinder, 2, &[n, n, 2]),
                    _ => bodies::uniform(&annulus, 2, &[n, n]),
                };
                let (inside, outside) = linear_field_forces(&model, &space(patch));
                inside / outside
            })
            .collect();
        assert!(ratios[2] < 1e-3 && ratios[2] < ratios[1] / 4.0, "{model:?}: {ratios:?}");
    }
}

#[test]
fn linear_displacements_give_constant_stress() {
    for (model, space) in cases() {
        let n = model.dimension();
        let gradient = if model == Model::Axisymmetric {
            [[2e-3, 0.0, 0.0], [0.0, -3e-3, 0.0], [0.0; 3]]
        } else {
            [[1e-3, 2e-3, -1e-3], [3e-3, -2e-3, 2e-3], [1e-3, 4e-3, 3e-3]]
        };
        let u = linear_field(space.control_points(), n, gradient, [0.0; 3]);
        let expected = iga_core::elasticity::kinematics::PointState::new(
            &model,
            &aluminium(),
            &gradient,
            gradient[0][0],
        );
        let mut workspace = RecoveryWorkspace::default();
        let places = noise(30, 5);
        for xi in places.chunks(3) {
            let xi = [0, 1, 2].map(|d| if d < n { 0.5 + 0.5 * xi[d] } else { 0.0 });
            for xi in [xi, [0.0, xi[1], xi[2]], [xi[0], 0.0, 0.0], [0.0; 3]] {
                let e = space.find_element(0, &xi);
                let state = workspace.stress(&space, &model, &aluminium(), &u, e, &xi).unwrap();
                for (s, t) in state.stress.iter().zip(&expected.stress) {
                    // Beside singular corners the inverse Jacobian amplifies round-off by up to 1 / SINGULAR_STEP.
                    assert!((s - t).abs() < 1e-9 * 72.8e9 * 1e-3, "{model:?} at {xi:?}: {s} against {t}");
                }
            }
        }
    }
}

/// The symmetric matrix of which `lower` is the lower triangle.
fn dense(lower: &faer::sparse::SparseColMat<u32, f64>) -> nalgebra::DMatrix<f64> {
    let mut full = nalgebra::DMatrix::zeros(lower.nrows(), lower.ncols());
    for t in lower.triplet_iter() {
        (full[(t.row, t.col)], full[(t.col, t.row)]) = (*t.val, *t.val);
    }
    full
}

#[test]
fn coarsest_meshes_have_no_motions_without_energy_or_mass() {
    let quad = bodies::quadrilateral([[0.0, 0.0], [1.0, 0.1], [0.1, 0.9], [1.0, 1.2]]);
    let brick = bodies::brick([1.0; 3], 0.3);
    let mut cases = Vec::new();
    for p in 1..=4 {
        for n in 1..=3 {
            for (model, n_rigid) in [(PLANE[0], 3), (PLANE[1], 3), (Model::Axisymmetric, 1)] {
                cases.push((model, n_rigid, bodies::uniform(&quad, p, &[n, 2])));
            }
            if p <= 3 && n <= 2 {
                cases.push((Model::Solid, 6, bodies::uniform(&brick, p, &[n, 2, 1])));
            }
        }
    }
    for (model, n_rigid, patch) in cases {
        let name =
            format!("{model:?} {:?} elements, {} functions", patch.element_counts(), patch.n_functions());
        let matrices = assemble(&space(patch), &model, &aluminium()).unwrap();
        let mut stiffness: Vec<f64> =
            dense(&matrices.stiffness).symmetric_eigenvalues().iter().copied().collect();
        stiffness.sort_by(f64::total_cmp);
        let largest = stiffness[stiffness.len() - 1];
        // Elastic motions lie above 1e-6 of the stiffest one on these meshes, round-off at 1e-15.
        let n_zero = stiffness.iter().filter(|&&v| v < 1e-9 * largest).count();
        assert_eq!(n_zero, n_rigid, "{name}");
        let mass = dense(&matrices.mass).symmetric_eigenvalues();
        assert!(mass.min() > 1e-9 * mass.max(), "{name}: mass {:e} of {:e}", mass.min(), mass.max());
    }
}

/// Strain energy from stresses at the Gauss points: knows nothing of the assembly's products.
fn strain_energy(space: &PatchSpace, model: &Model, u: &[f64]) -> f64 {
    let (mut workspace, mut basis, mut active) =
        (RecoveryWorkspace::default(), GridBasis::default(), Vec::new());
    let mut energy = 0.0;
    for e in 0..space.n_elements() {
        let (element, counts) = (space.element(e), space.gauss_counts(e));
        space.active_functions(e, &mut active);
        let nodes: Vec<_> = active.iter().map(|&a| space.control_points()[a as usize]).collect();
        for q in 0..counts.iter().product() {
            let index = iga_core::splines::tensor::multi_index(&counts, q);
            let (mut xi, mut weight) = ([0.0; 3], 1.0);
            for d in 0..space.dimension() {
                let rule = GaussRule::new(counts[d]);
                let half = 0.5 * (element.upper[d] - element.lower[d]);
                xi[d] = element.lower[d] + half * (1.0 + rule.points[index[d]]);
                weight *= half * rule.weights[index[d]];
            }
            space.evaluate_grid(e, xi.each_ref().map(std::slice::from_ref), &mut basis);
            let map = PointMap::new(space.dimension(), &nodes, basis.values_at(0), basis.first_at(0));
            let state = workspace.stress(space, model, &aluminium(), u, e, &xi).unwrap();
            energy += 0.5
                * weight
                * map.determinant
                * model.measure(&map.position)
                * dot(&state.strain, &state.stress);
        }
    }
    energy
}

#[test]
fn stiffness_is_hessian_of_strain_energy() {
    for (model, space) in cases() {
        let n = model.dimension();
        let matrices = assemble(&space, &model, &aluminium()).unwrap();
        let (mut v, mut w) = (noise(n * space.n_functions(), 1), noise(n * space.n_functions(), 2));
        let free: std::collections::HashSet<(u32, u8)> = matrices.dofs.iter().copied().collect();
        for i in 0..v.len() {
            if !free.contains(&((i / n) as u32, (i % n) as u8)) {
                (v[i], w[i]) = (0.0, 0.0); // held on the axis
            }
        }
        let plus: Vec<f64> = v.iter().zip(&w).map(|(a, b)| a + b).collect();
        let minus: Vec<f64> = v.iter().zip(&w).map(|(a, b)| a - b).collect();
        // The energy is quadratic: the central difference has no error but round-off.
        let difference = 0.5 * (strain_energy(&space, &model, &plus) - strain_energy(&space, &model, &minus));
        let [v, w] = [v, w].map(|x| at_unknowns(&matrices.dofs, &x, n));
        let form = dot(&v, &multiply(&matrices.stiffness, &w));
        let scale = dot(&v, &multiply(&matrices.stiffness, &v));
        assert!((form - difference).abs() < ROUND_OFF * scale, "{model:?}: {form} against {difference}");
    }
}

#[test]
fn mass_matrix_sums_to_the_mass() {
    use std::f64::consts::PI;
    let rho = 2789.0;
    let annulus = bodies::quarter_annulus(1.0, 2.0, [0.0, 0.0]);
    let block = bodies::brick([1.0, 2.0, 3.0], 0.0);
    // (model, patch, volume, tolerance): boxes to round-off; arcs by Gauss points, error below (h / r)^(2 p) / (2 p)!.
    let cases = [
        (Model::Solid, bodies::uniform(&block, 3, &[2, 2, 2]), 6.0, ROUND_OFF),
        (PLANE[1], bodies::uniform(&annulus, 3, &[2, 8]), 0.75 * PI * THICKNESS, 1e-9),
        (Model::Axisymmetric, bodies::uniform(&annulus, 3, &[2, 8]), 2.0 * PI * 7.0 / 3.0, 1e-9),
        (Model::Solid, bodies::uniform(&bodies::cylinder(0.5, 2.0), 3, &[8, 8, 2]), 0.5 * PI, 1e-8),
    ];
    for (model, patch, volume, tolerance) in cases {
        let space = space(patch);
        let matrices = assemble(&space, &model, &aluminium()).unwrap();
        let ones = vec![1.0; space.n_functions()];
        let mass = dot(&ones, &multiply(&matrices.mass, &ones));
        let error = mass / (rho * volume) - 1.0;
        assert!(error.abs() < tolerance, "{model:?}: {error:e}");
    }
}

#[test]
fn unknowns_are_sorted_and_radial_ones_on_the_axis_are_left_out() {
    let space = space(bodies::uniform(&bodies::quarter_annulus(0.5, 1.0, [0.0, 0.0]), 3, &[3, 4]));
    let matrices = assemble(&space, &Model::Axisymmetric, &aluminium()).unwrap();
    assert!(matrices.dofs.windows(2).all(|w| w[0] < w[1]));
    let on_axis = space.control_points().iter().filter(|p| p[0].abs() < 1e-12).count();
    assert_eq!(on_axis, 6);
    assert_eq!(matrices.dofs.len(), 2 * space.n_functions() - on_axis);
    assert_eq!(matrices.stiffness.ncols(), matrices.dofs.len());
    assert_eq!(matrices.mass.ncols(), space.n_functions());
}

#[test]
fn every_number_of_threads_gives_the_same_bits() {
    for (model, patch) in [
        (Model::Solid, bodies::uniform(&bodies::cylinder(0.01, 0.02), 3, &[5, 5, 4])),
        (Model::Axisymmetric, bodies::uniform(&bodies::quarter_annulus(0.5, 1.0, [0.0, 0.0]), 3, &[40, 40])),
    ] {
        let space = space(patch);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| assemble(&space, &model, &aluminium()).unwrap())
        };
        let one = run(1);
        for threads in [2, 3] {
            let other = run(threads);
            let bits = |m: &faer::sparse::SparseColMat<u32, f64>| -> Vec<u64> {
                m.val().iter().map(|v| v.to_bits()).collect()
            };
            assert!(bits(&one.stiffness) == bits(&other.stiffness) && bits(&one.mass) == bits(&other.mass));
        }
    }
}

#[test]
fn folded_and_misplaced_geometry_is_refused() {
    let folded = space(bodies::quadrilateral([[1.0, 0.0], [0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]));
    let error = assemble(&folded, &PLANE[0], &aluminium()).unwrap_err();
    assert!(error.to_string().contains("folded"), "{error}");
    let across = space(bodies::quadrilateral([[-1.0, 0.0], [1.0, 0.0], [-1.0, 1.0], [1.0, 1.0]]));
    let error = assemble(&across, &Model::Axisymmetric, &aluminium()).unwrap_err();
    assert!(error.to_string().contains("radius"), "{error}");
}
