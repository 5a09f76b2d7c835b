//! Convergence rates against theory (theory section E.4): displacement error p + 1, energy error p, eigenvalues 2 p.

use crate::bodies;
use crate::bodies::{at_unknowns, dot, multiply, slope};
use std::f64::consts::PI;

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use iga_core::elasticity::assembly::{AssembledMatrices, assemble};
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::mapping::PointMap;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Patch;
use iga_core::quadrature::GaussRule;
use iga_core::space::{GridBasis, PatchSpace, Space};

/// Distance of a measured rate from theory, as agreed for the whole project.
const RATE_TOLERANCE: f64 = 0.1;

fn material() -> Material {
    Material::new(1.0, 0.3, 1.0).unwrap()
}

/// A displacement field and its gradient.
type Field = fn(&[f64; 3]) -> ([f64; 3], [[f64; 3]; 3]);

/// Calls `visit` with weight (measure included), position, functions, values and physical gradients of every point of a
/// rule that is finer than the assembly's.
fn integrate(
    space: &PatchSpace,
    model: &Model,
    extra: usize,
    mut visit: impl FnMut(f64, &[f64; 3], &[u32], &[f64], &[[f64; 3]]),
) {
    let (mut basis, mut active, d) = (GridBasis::default(), Vec::new(), space.dimension());
    let rule = GaussRule::new(space.patches()[0].knots()[0].degree() + extra);
    for e in 0..space.n_elements() {
        let element = space.element(e);
        let mut grid = [vec![], vec![], vec![]];
        for (k, g) in grid.iter_mut().enumerate() {
            if k < d { rule.points_on(element.lower[k], element.upper[k], g) } else { g.push(0.0) }
        }
        space.evaluate_grid(e, grid.each_ref().map(Vec::as_slice), &mut basis);
        space.active_functions(e, &mut active);
        let nodes: Vec<_> = active.iter().map(|&a| space.control_points()[a as usize]).collect();
        for q in 0..basis.n_points {
            let (values, first) = (basis.values_at(q), basis.first_at(q));
            let map = PointMap::new(d, &nodes, values, first);
            let inverse = map.inverse();
            let index = iga_core::splines::tensor::multi_index(&[rule.len(); 3][..d], q);
            let mut weight = map.determinant * model.measure(&map.position);
            for (k, &i) in index.iter().enumerate().take(d) {
                weight *= 0.5 * (element.upper[k] - element.lower[k]) * rule.weights[i];
            }
            let gradients: Vec<[f64; 3]> = (0..active.len())
                .map(|a| [0, 1, 2].map(|i| (0..d).map(|k| first[k][a] * inverse[k][i]).sum()))
                .collect();
            visit(weight, &map.position, &active, values, &gradients);
        }
    }
}

/// Solves on the free unknowns; the others are zero.
fn solve(matrices: &AssembledMatrices, is_free: impl Fn(u32, u8) -> bool, load: &[f64]) -> Vec<f64> {
    let system = Restricted::new(&matrices.stiffness, matrices, is_free);
    system.solve(load)
}

/// A Cholesky factorisation of the free part of a matrix.
struct Restricted {
    free: Vec<usize>,
    factor: faer::sparse::linalg::solvers::Llt<u32, f64>,
}

impl Restricted {
    fn new(
        matrix: &SparseColMat<u32, f64>,
        matrices: &AssembledMatrices,
        is_free: impl Fn(u32, u8) -> bool,
    ) -> Self {
        let free: Vec<usize> =
            (0..matrices.dofs.len()).filter(|&i| is_free(matrices.dofs[i].0, matrices.dofs[i].1)).collect();
        let mut number = vec![u32::MAX; matrices.dofs.len()];
        for (k, &i) in free.iter().enumerate() {
            number[i] = k as u32;
        }
        let triplets: Vec<Triplet<u32, u32, f64>> = matrix
            .triplet_iter()
            .map(|t| Triplet::new(number[t.row], number[t.col], *t.val))
            .filter(|t| t.row != u32::MAX && t.col != u32::MAX)
            .collect();
        let reduced = SparseColMat::try_new_from_triplets(free.len(), free.len(), &triplets).unwrap();
        Self { factor: reduced.sp_cholesky(Side::Lower).unwrap(), free }
    }

    fn solve(&self, load: &[f64]) -> Vec<f64> {
        let right = faer::Col::from_fn(self.free.len(), |k| load[self.free[k]]);
        let solution = self.factor.solve(&right);
        let mut full = vec![0.0; load.len()];
        for (k, &i) in self.free.iter().enumerate() {
            full[i] = solution[k];
        }
        full
    }
}

fn is_on_boundary(patch: &Patch, node: u32) -> bool {
    let sizes = patch.net_size();
    let index = iga_core::splines::tensor::multi_index(&sizes, node as usize);
    sizes.iter().zip(index).any(|(&n, i)| i == 0 || i + 1 == n)
}

/// Relative errors of displacement (L2) and strain energy (its root) for a field that vanishes on the boundary. The load is
/// `∫ σ(u) : grad R dV`, the weak form of the body force that belongs to the field.
fn errors(patch: Patch, model: &Model, field: Field) -> (f64, f64) {
    let space = PatchSpace::new(vec![patch]).unwrap();
    let (n, patch) = (model.dimension(), &space.patches()[0]);
    let matrices = assemble(&space, model, &material()).unwrap();
    let state = |g: &[[f64; 3]; 3]| PointState::new(model, &material(), g, 0.0);
    let mut load = vec![0.0; n * space.n_functions()];
    integrate(&space, model, 3, |weight, x, active, _, gradients| {
        let s = state(&field(x).1).stress;
        let sigma = [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]];
        for (&a, g) in active.iter().zip(gradients) {
            for c in 0..n {
                load[n * a as usize + c] += weight * dot(&sigma[c], g);
            }
        }
    });
    let u = solve(&matrices, |node, _| !is_on_boundary(patch, node), &at_unknowns(&matrices.dofs, &load, n));
    let mut sums = [0.0; 4];
    integrate(&space, model, 3, |weight, x, active, values, gradients| {
        let (exact, mut gradient) = field(x);
        let mut difference = exact;
        let whole = state(&gradient);
        for (k, &a) in active.iter().enumerate() {
            for c in 0..n {
                let control = u[n * a as usize + c];
                difference[c] -= control * values[k];
                for j in 0..n {
                    gradient[c][j] -= control * gradients[k][j];
                }
            }
        }
        let rest = state(&gradient);
        sums[0] += weight * dot(&difference, &difference);
        sums[1] += weight * dot(&exact, &exact);
        sums[2] += weight * dot(&rest.strain, &rest.stress);
        sums[3] += weight * dot(&whole.strain, &whole.stress);
    });
    ((sums[0] / sums[1]).sqrt(), (sums[2] / sums[3]).sqrt())
}

/// `B (f_0, f_1, f_2)` with `B` the product of affine functions `c + n·x` that vanish on the faces, and its gradient.
fn bubble(faces: &[[f64; 4]], x: &[f64; 3], f: [f64; 3], slopes: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let (mut value, mut slope) = (1.0, [0.0; 3]);
    for face in faces {
        let l = face[3] + dot(&face[..3], x);
        for d in 0..3 {
            slope[d] = slope[d] * l + value * face[d];
        }
        value *= l;
    }
    let gradient = [0, 1, 2].map(|c| [0, 1, 2].map(|d| slope[d] * f[c] + value * slopes[c][d]));
    (f.map(|f| value * f), gradient)
}

const TRAPEZIUM: [[f64; 2]; 4] = [[0.0, 0.0], [1.5, 0.0], [0.2, 1.0], [1.2, 1.2]];

fn plane_field(x: &[f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let side = |a: [f64; 2], b: [f64; 2]| {
        let n = [a[1] - b[1], b[0] - a[0]];
        [n[0], n[1], 0.0, -n[0] * a[0] - n[1] * a[1]]
    };
    let c = TRAPEZIUM;
    let faces = [side(c[0], c[1]), side(c[1], c[3]), side(c[3], c[2]), side(c[2], c[0])];
    let (a, b) = (2.0 * x[0] + x[1], x[0] - 2.0 * x[1]);
    let f = [a.sin(), b.cos(), 0.0];
    bubble(&faces, x, f, [[2.0 * a.cos(), a.cos(), 0.0], [-b.sin(), 2.0 * b.sin(), 0.0], [0.0; 3]])
}

fn annulus_field(x: &[f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    // x y (r² - 1)(4 - r²): vanishes on the quarter annulus' four sides.
    let r2 = x[0] * x[0] + x[1] * x[1];
    let (ring, slope) = ((r2 - 1.0) * (4.0 - r2), 2.0 * (5.0 - 2.0 * r2));
    let value = x[0] * x[1] * ring;
    let gradient = [x[1] * ring + x[0] * x[1] * slope * x[0], x[0] * ring + x[0] * x[1] * slope * x[1], 0.0];
    ([value, -0.5 * value, 0.0], [gradient, gradient.map(|g| -0.5 * g), [0.0; 3]])
}

fn solid_field(x: &[f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let faces = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [-1.0, 0.0, -0.3, 1.0],
        [0.0, -1.0, -0.2, 1.0],
        [0.0, 0.0, -1.0, 1.0],
    ];
    let s = x[0] + x[1] - x[2];
    bubble(
        &faces,
        x,
        [s.sin(), s.cos(), 1.0],
        [[s.cos(), s.cos(), -s.cos()], [-s.sin(), -s.sin(), s.sin()], [0.0; 3]],
    )
}

/// Share by which the error on the finest mesh may differ from its record.
const RECORD_TOLERANCE: f64 = 0.01;

/// Checks the rates of both errors over the meshes and, on the finest mesh, their values.
fn assert_rates(
    name: &str,
    p: usize,
    meshes: &[usize],
    record: (f64, f64),
    errors: impl Fn(usize) -> (f64, f64),
) {
    let all: Vec<(f64, f64)> = meshes.iter().map(|&n| errors(n)).collect();
    let sizes: Vec<f64> = meshes.iter().map(|&n| 1.0 / n as f64).collect();
    let displacement = slope(&sizes, &all.iter().map(|e| e.0).collect::<Vec<_>>());
    let energy = slope(&sizes, &all.iter().map(|e| e.1).collect::<Vec<_>>());
    assert!(
        (displacement - (p as f64 + 1.0)).abs() <= RATE_TOLERANCE,
        "{name} p = {p}: {displacement}, {all:?}"
    );
    assert!((energy - p as f64).abs() <= RATE_TOLERANCE, "{name} p = {p}: {energy}, {all:?}");
    let finest = all[all.len() - 1];
    for (found, record) in [(finest.0, record.0), (finest.1, record.1)] {
        assert!(
            (found / record - 1.0).abs() <= RECORD_TOLERANCE,
            "{name} p = {p}: {found:e} against {record:e}"
        );
    }
}

#[test]
fn plane_errors_drop_with_order_p_plus_one_and_p() {
    let quad = bodies::quadrilateral(TRAPEZIUM);
    let annulus = bodies::quarter_annulus(1.0, 2.0, [0.0, 0.0]);
    let records = [(2.019e-3, 4.360e-2), (2.074e-5, 1.014e-3), (3.965e-7, 1.984e-5), (8.714e-9, 4.107e-7)];
    for (p, record) in (1..=4).zip(records) {
        assert_rates("trapezium", p, &[8, 16, 32], record, |n| {
            errors(bodies::uniform(&quad, p, &[n, n]), &Model::PlaneStrain { thickness: 0.5 }, plane_field)
        });
    }
    let records = [(1.611e-5, 7.588e-4), (1.825e-7, 8.148e-6), (1.010e-9, 3.991e-8)];
    for (p, record) in (2..=4).zip(records) {
        // Degree 4 reaches its asymptotic range later.
        let meshes = if p == 4 { [16, 24, 36] } else { [8, 16, 32] };
        assert_rates("annulus", p, &meshes, record, |n| {
            errors(
                bodies::uniform(&annulus, p, &[n, n]),
                &Model::PlaneStress { thickness: 0.5 },
                annulus_field,
            )
        });
    }
}

#[test]
fn solid_errors_drop_with_order_p_plus_one_and_p() {
    assert_rates("frustum", 2, &[8, 12, 16], (9.961e-5, 1.586e-3), |n| {
        errors(bodies::uniform(&bodies::frustum(), 2, &[n, n, n]), &Model::Solid, solid_field)
    });
}

/// Meshes on which the eigenvalue errors lie in their asymptotic range and above round-off, for degrees 1 to 4.
const EIGENVALUE_MESHES: [[usize; 3]; 4] = [[16, 24, 32], [8, 12, 16], [10, 14, 18], [10, 12, 14]];

fn assert_eigenvalue_rates(model: &Model, size: [f64; 2], exact: f64) {
    let quad = bodies::quadrilateral([[0.0, 0.0], [size[0], 0.0], [0.0, size[1]], size]);
    for (p, meshes) in (1..=4).zip(EIGENVALUE_MESHES) {
        let errors = meshes.map(|n| {
            let space = PatchSpace::new(vec![bodies::uniform(&quad, p, &[n, n])]).unwrap();
            (lowest_roller_eigenvalue(&space, model, size) / exact - 1.0).abs()
        });
        let rate = slope(&meshes.map(|n| 1.0 / n as f64), &errors);
        assert!((rate - 2.0 * p as f64).abs() <= RATE_TOLERANCE, "{model:?} p = {p}: {rate}, {errors:?}");
    }
}

#[test]
fn plane_eigenvalues_converge_with_order_two_p() {
    // Rectangle on rollers: the shear mode u = curl(sin(k x) sin(l y)), k = pi / a, l = pi / b, is exact and the lowest one,
    // omega² = mu / rho (k² + l²).
    let (k, l) = (PI, PI / 0.8);
    let exact = material().shear_modulus() * (k * k + l * l);
    assert_eigenvalue_rates(&Model::PlaneStrain { thickness: 1.0 }, [1.0, 0.8], exact);
}

#[test]
fn axisymmetric_eigenvalues_converge_with_order_two_p() {
    // Cylinder on rollers: the shear mode u_r = l J_1(k r) cos(l z), u_z = -k J_0(k r) sin(l z) with k the first root of
    // J_1 (Abramowitz & Stegun, table 9.5) over the radius and l = pi / height, omega² = mu / rho (k² + l²).
    let (k, l) = (3.831_705_970_207_512, PI / 0.8);
    let exact = material().shear_modulus() * (k * k + l * l);
    assert_eigenvalue_rates(&Model::Axisymmetric, [1.0, 0.8], exact);
}

/// Inverse iteration; normal displacements are held on all four sides.
fn lowest_roller_eigenvalue(space: &PatchSpace, model: &Model, size: [f64; 2]) -> f64 {
    let matrices = assemble(space, model, &material()).unwrap();
    let points = space.control_points();
    let is_free = |node: u32, c: u8| {
        let x = points[node as usize][c as usize];
        x > 1e-9 && x < size[c as usize] - 1e-9
    };
    let system = Restricted::new(&matrices.stiffness, &matrices, is_free);
    let mass = |u: &[f64]| {
        let mut product = vec![0.0; u.len()];
        for c in 0..2 {
            let mut part = vec![0.0; points.len()];
            let own = || matrices.dofs.iter().enumerate().filter(|(_, dof)| dof.1 == c);
            own().for_each(|(i, dof)| part[dof.0 as usize] = u[i]);
            let image = multiply(&matrices.mass, &part);
            own().for_each(|(i, dof)| product[i] = image[dof.0 as usize]);
        }
        product
    };
    let (mut u, mut eigenvalue) = (bodies::noise(matrices.dofs.len(), 7), 0.0);
    // The second eigenvalue is at least 1.4 times the first: sixty steps leave an error of 1.4^-120.
    for _ in 0..60 {
        let load = mass(&u);
        u = system.solve(&load);
        let norm = dot(&u, &mass(&u));
        eigenvalue = dot(&u, &load) / norm;
        u.iter_mut().for_each(|x| *x /= norm.sqrt());
    }
    eigenvalue
}
