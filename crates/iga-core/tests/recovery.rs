//! Displacement and stress at parameter points: on the axis, on singular lines and elsewhere.

use crate::bodies;
use crate::bodies::{linear_field, noise};
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::recovery::RecoveryWorkspace;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Patch;
use iga_core::space::{PatchSpace, Space, SplineSpace};

fn steel() -> Material {
    Material::new(210e9, 0.3, 7850.0).unwrap()
}

#[test]
fn displacement_of_a_linear_field_follows_the_position() {
    let patch = bodies::uniform(&bodies::cylinder(0.3, 1.0), 3, &[2, 3, 2]);
    let space = PatchSpace::new(vec![patch.clone()]).unwrap();
    let gradient = [[1.0, 2.0, -1.0], [0.5, 0.0, 3.0], [-2.0, 1.0, 1.0]];
    let u = linear_field(space.control_points(), 3, gradient, [0.1, 0.2, 0.3]);
    let mut workspace = RecoveryWorkspace::default();
    for xi in noise(30, 9).chunks(3) {
        let xi = [0, 1, 2].map(|d| 0.5 + 0.5 * xi[d]);
        let found = workspace.displacement(&space, 3, &u, space.find_element(0, &xi), &xi);
        let expected = linear_field(&[patch.point(&xi)], 3, gradient, [0.1, 0.2, 0.3]);
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-13)); // round-off
    }
}

/// Rectangle `0 <= r <= 1, 0 <= z <= 2` of degree 2, and the exact control values of `u_r = r (1 + z)`, `u_z = -r²`.
fn field_on_the_axis() -> (PatchSpace, Vec<f64>) {
    let quad = bodies::quadrilateral([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0], [1.0, 2.0]]);
    let patch = bodies::uniform(&quad, 2, &[3, 2]);
    // The field is quadratic: interpolating it like a geometry is exact.
    let at = |i: usize, j: usize| {
        let (r, z) = (i as f64 * 0.5, j as f64);
        // Control values of the one-element patch by polar forms: r² has (0, 0, 1), r has (0, 1/2, 1), z has (0, 1, 2).
        [r * (1.0 + z), if i == 2 { -1.0 } else { 0.0 }, 0.0]
    };
    let coarse = bodies::uniform(&quad, 2, &[1, 1]);
    let net = (0..9).map(|k| at(k % 3, k / 3)).collect();
    let field = Patch::new(coarse.knots().to_vec(), net, vec![1.0; 9]).unwrap();
    let field = bodies::uniform(&field, 2, &[3, 2]);
    let u = field.control_points().iter().flat_map(|p| [p[0], p[1]]).collect();
    (PatchSpace::new(vec![patch]).unwrap(), u)
}

#[test]
fn hoop_strain_on_the_axis_is_the_radial_slope() {
    let (space, u) = field_on_the_axis();
    let mut workspace = RecoveryWorkspace::default();
    for v in [0.0, 0.2, 0.5, 0.8, 1.0] {
        for r in [0.0, 1e-12, 1e-6, 0.1, 0.7, 1.0] {
            let xi = [r, v, 0.0];
            let e = space.find_element(0, &xi);
            let state = workspace.stress(&space, &Model::Axisymmetric, &steel(), &u, e, &xi).unwrap();
            let z = 2.0 * v;
            // rr, zz, θθ, and rz: du_r/dz + du_z/dr = r - 2 r.
            let expected = [1.0 + z, 0.0, 1.0 + z, -r, 0.0, 0.0];
            // u_r / r amplifies round-off by the element's size over the radius, at most 1e7 (AXIS_LIMIT).
            let tolerance = 1e-13 + 1e-15 / r.max(1e-7);
            for (found, expected) in state.strain.iter().zip(&expected) {
                assert!((found - expected).abs() < tolerance, "r = {r}, z = {z}: {:?}", state.strain);
            }
        }
    }
}

#[test]
fn stress_at_singular_corners_is_that_beside_them() {
    let space = PatchSpace::new(vec![bodies::uniform(&bodies::disc(1.0), 3, &[4, 4])]).unwrap();
    let gradient = [[1e-3, 2e-3, 0.0], [0.0, -1e-3, 0.0], [0.0; 3]];
    let u = linear_field(space.control_points(), 2, gradient, [0.0; 3]);
    let model = Model::PlaneStress { thickness: 1.0 };
    let mut workspace = RecoveryWorkspace::default();
    let mut at = |xi: [f64; 3]| {
        workspace.stress(&space, &model, &steel(), &u, space.find_element(0, &xi), &xi).unwrap().von_mises()
    };
    let inside = at([0.4, 0.6, 0.0]);
    for corner in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]] {
        // Round-off, amplified by 1 / SINGULAR_STEP.
        assert!((at(corner) / inside - 1.0).abs() < 1e-9, "{corner:?}");
    }
}

/// States by units, summed, are the state, for every model, on elements, on the axis and at singular corners.
#[test]
fn states_by_units_sum_up_to_the_state() {
    let (plane, axis) = (bodies::disc(1.0), field_on_the_axis().0);
    let disc = PatchSpace::new(vec![bodies::uniform(&plane, 3, &[3, 4])]).unwrap();
    let solid = PatchSpace::new(vec![bodies::uniform(&bodies::cylinder(0.3, 1.0), 3, &[2, 3, 2])]).unwrap();
    let thickness = 0.01;
    let cases: [(&PatchSpace, Model); 4] = [
        (&solid, Model::Solid),
        (&axis, Model::Axisymmetric),
        (&disc, Model::PlaneStrain { thickness }),
        (&disc, Model::PlaneStress { thickness }),
    ];
    let mut workspace = RecoveryWorkspace::default();
    for (space, model) in cases {
        let n = model.dimension();
        let u = noise(n * space.n_functions(), 3);
        let mut places: Vec<[f64; 3]> = noise(30, 5)
            .chunks(3)
            .map(|x| [0, 1, 2].map(|d| if d < n { 0.5 + 0.5 * x[d] } else { 0.0 }))
            .collect();
        places.extend([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.4, 0.0]]);
        for xi in places {
            let e = space.find_element(0, &xi);
            let whole = workspace.stress(space, &model, &steel(), &u, e, &xi).unwrap();
            // Several fields at several points of the element, one of them this field at this point.
            let (fields, at) = ([noise(u.len(), 8), u.clone()], [space.element(e).centre(), xi]);
            let all = workspace.stresses(space, (&model, &steel()), &fields, e, &at).unwrap();
            let size = whole.stress.iter().fold(0.0f64, |most, s| most.max(s.abs()));
            // Sums in another order: round-off.
            assert!(all[1][1].stress.iter().zip(&whole.stress).all(|(a, b)| (a - b).abs() <= 1e-11 * size));
            let (mut sum, mut scale) = (PointState::default(), PointState::default());
            for (function, states) in workspace.unit_states(space, &model, &steel(), e, &xi).unwrap() {
                for (c, state) in states.iter().enumerate() {
                    sum.add_scaled(state, u[function as usize * n + c]);
                    let sizes =
                        PointState { strain: state.strain.map(f64::abs), stress: state.stress.map(f64::abs) };
                    scale.add_scaled(&sizes, 1.0);
                }
            }
            // Round-off of some hundred terms of the size of their sum of magnitudes.
            let is_near = |a: &[f64; 6], b: &[f64; 6], s: &[f64; 6]| {
                let largest = s.iter().fold(0.0f64, |m, s| m.max(*s));
                a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-13 * largest)
            };
            assert!(
                is_near(&sum.strain, &whole.strain, &scale.strain),
                "{model:?} {xi:?}: {sum:?} {whole:?}"
            );
            assert!(
                is_near(&sum.stress, &whole.stress, &scale.stress),
                "{model:?} {xi:?}: {sum:?} {whole:?}"
            );
        }
    }
}
