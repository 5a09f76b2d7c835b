//! Patch tests of the catalogue: every shape reproduces a constant strain, and what holds it in balance acts on its surface alone, across ties too.

use crate::bodies::{at_unknowns, largest, linear_field, multiply, noise};
use crate::gear_tooth;
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::recovery::RecoveryWorkspace;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Face;
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::round::{self, Round};
use iga_core::nurbs::primitives::rounded_box::rounded_box;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, profile, solid, sphere};
use iga_core::space::{PatchSpace, Space, SplineSpace};
use iga_core::splines::knots::KnotVector;

const YOUNG: f64 = 72.8e9;
const THICKNESS: f64 = 0.02;
/// Imbalance of elements that turn by 45 degrees at most: two Gauss points leave the third power of that angle over 24.
const TURNED: f64 = 2e-2;

fn aluminium() -> Material {
    Material::new(YOUNG, 0.33, 2789.0).unwrap()
}

/// How well the balance holds inside.
#[derive(Clone, Copy, PartialEq)]
enum Balance {
    /// Straight elements, whose integrals are exact: round-off.
    Exact,
    /// Rational elements: the error of `p` Gauss points.
    Quadrature,
}
use Balance::{Exact, Quadrature};

type Case = (&'static str, Model, Shape, Balance);

/// Bodies of revolution as meridians.
fn sections() -> Vec<Case> {
    let cylinder = Round::RoundedCylinder {
        radius: 1.0,
        length: 3.0,
        crown_radius: Some(2.0),
        fillet_radius: Some(0.2),
    };
    let list = [
        ("sphere", axisymmetric::sphere(1.0), Quadrature),
        ("ellipsoid", axisymmetric::spheroid(1.0, 2.0), Quadrature),
        ("rod", axisymmetric::rod(1.0, 2.0), Exact),
        ("rod with spherical end", axisymmetric::rod_spherical_end(1.0, 3.0), Quadrature),
        ("hollow cylinder", axisymmetric::hollow_cylinder(0.5, 1.0, 2.0), Exact),
        ("cone", Round::Cone { radius: 1.0, end_radius: 0.5, length: 2.0 }.axisymmetric(), Exact),
        ("capsule", Round::Capsule { radius: 1.0, length: 5.0 }.axisymmetric(), Quadrature),
        ("rounded cylinder", cylinder.axisymmetric(), Quadrature),
        ("torus", round::axisymmetric_torus(1.0, 0.4), Quadrature),
    ];
    list.into_iter()
        .map(|(name, shape, balance)| (name, Model::Axisymmetric, shape.unwrap(), balance))
        .collect()
}

fn plane_shapes() -> Vec<Case> {
    let list = [
        ("rectangle", plane::rectangle(1.0, 2.0), Exact),
        ("disc", plane::disc(1.0), Quadrature),
        ("plate with a hole", profile::plate_with_hole([6.0, 2.0], 0.5), Quadrature),
        ("gear tooth", gear_tooth::teeth()[0].plane(), Quadrature),
    ];
    let models = [Model::PlaneStrain { thickness: THICKNESS }, Model::PlaneStress { thickness: THICKNESS }];
    let each = |(name, shape, balance): (&'static str, Result<Shape, _>, Balance)| {
        let shape = shape.unwrap();
        models.map(|model| (name, model, shape.clone(), balance))
    };
    list.into_iter().flat_map(each).collect()
}

fn solids() -> Vec<Case> {
    let rounded =
        Round::RoundedCylinder { radius: 1.0, length: 1.3, crown_radius: None, fillet_radius: Some(0.5) };
    let list = [
        ("cube-net sphere", sphere::sphere(1.0, SphereNet::Cube), Quadrature),
        ("spindle-net sphere", sphere::sphere(1.0, SphereNet::Spindle), Quadrature),
        ("seven-patch sphere", sphere::sphere(1.0, SphereNet::Shells), Quadrature),
        ("ellipsoid", sphere::ellipsoid([2.0, 1.5, 1.0]), Quadrature),
        ("cylinder", solid::cylinder(1.0, 2.0), Quadrature),
        ("hollow cylinder", solid::hollow_cylinder(0.5, 1.0, 2.0), Quadrature),
        ("tube sector", profile::tube_sector(0.5, 1.0, 0.7, 1.0), Quadrature),
        ("cone", Round::Cone { radius: 1.0, end_radius: 0.5, length: 2.0 }.solid(), Quadrature),
        ("capsule", Round::Capsule { radius: 1.0, length: 5.0 }.solid(), Quadrature),
        ("rounded cylinder", rounded.solid(), Quadrature),
        ("torus", round::torus(1.0, 0.4), Quadrature),
        ("rounded box", rounded_box([1.0, 2.0, 3.0], 0.2), Quadrature),
        ("plate with a hole", profile::solid_plate_with_hole([2.0, 2.4], 0.5, 0.3), Quadrature),
        ("L-beam", profile::l_beam(1.0, 2.0, 0.2, 10.0), Exact),
        ("T-beam", profile::t_beam(1.0, 2.0, 0.2, 0.3, 10.0), Exact),
        ("box", solid::cuboid([1.0, 2.0, 3.0]), Exact),
        ("gear tooth", gear_tooth::teeth()[0].solid(0.7), Quadrature),
    ];
    list.into_iter().map(|(name, shape, balance)| (name, Model::Solid, shape.unwrap(), balance)).collect()
}

fn gradient(model: &Model) -> [[f64; 3]; 3] {
    match model {
        Model::Axisymmetric => [[2e-3, 0.0, 0.0], [0.0, -3e-3, 0.0], [0.0; 3]],
        _ => [[1e-3, 2e-3, -1e-3], [3e-3, -2e-3, 2e-3], [1e-3, 4e-3, 3e-3]],
    }
}

/// The shape in `n` elements per direction and patch, of its degree or 2, whichever is higher.
fn space(shape: &Shape, n: usize) -> PatchSpace {
    let dimension = shape.patches[0].dimension();
    let degrees = shape.patches.iter().flat_map(|patch| patch.knots().iter().map(KnotVector::degree));
    let degree = degrees.fold(2, usize::max);
    let refined = shape.refined(&[degree; 3][..dimension], &[n; 3][..dimension], &[]).unwrap();
    PatchSpace::new(refined.patches).unwrap()
}

/// Functions that do not vanish on the surface.
fn on_surface(space: &PatchSpace, is_axisymmetric: bool) -> Vec<bool> {
    let mut is_outer = vec![false; space.n_functions()];
    for face in Face::outer(space.patches(), is_axisymmetric) {
        let id = face.id;
        let sizes = space.patches()[id.patch].net_size();
        for (local, &function) in space.functions(id.patch).iter().enumerate() {
            let index = iga_core::splines::tensor::multi_index(&sizes, local)[id.direction];
            let end = if id.upper { sizes[id.direction] - 1 } else { 0 };
            is_outer[function as usize] |= index == end;
        }
    }
    is_outer
}

/// Largest force inside over the largest one on the surface under a constant strain, and how many functions inside belong to several patches.
fn imbalance(model: &Model, space: &PatchSpace) -> (f64, usize) {
    let n = model.dimension();
    let matrices = assemble(space, model, &aluminium()).unwrap();
    let field = linear_field(space.control_points(), n, gradient(model), [0.0; 3]);
    let force = multiply(&matrices.stiffness, &at_unknowns(&matrices.dofs, &field, n));
    let is_outer = on_surface(space, *model == Model::Axisymmetric);
    let mut uses = vec![0; space.n_functions()];
    for patch in 0..space.patches().len() {
        let mut own = space.functions(patch).to_vec();
        own.sort_unstable();
        own.dedup();
        own.iter().for_each(|&f| uses[f as usize] += 1);
    }
    let n_tied = uses.iter().zip(&is_outer).filter(|(uses, outer)| **uses > 1 && !**outer).count();
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    for (&(node, _), f) in matrices.dofs.iter().zip(&force) {
        if is_outer[node as usize] { outside.push(*f) } else { inside.push(*f) }
    }
    (largest(&inside) / largest(&outside), n_tied)
}

fn check_strain(name: &str, model: &Model, space: &PatchSpace) {
    let (n, gradient) = (model.dimension(), gradient(model));
    let field = linear_field(space.control_points(), n, gradient, [0.0; 3]);
    let expected = PointState::new(model, &aluminium(), &gradient, gradient[0][0]);
    let mut workspace = RecoveryWorkspace::default();
    for patch in 0..space.patches().len() {
        for xi in noise(12, 3 + patch as u64).chunks(3) {
            let xi = [0, 1, 2].map(|d| if d < n { 0.5 + 0.5 * xi[d] } else { 0.0 });
            // Inside, and on each end of each direction, where patches are tied.
            let ends = (0..2 * n).map(|k| {
                let mut at = xi;
                at[k / 2] = (k % 2) as f64;
                at
            });
            for xi in std::iter::once(xi).chain(ends) {
                let e = space.find_element(patch, &xi);
                let state = workspace.stress(space, model, &aluminium(), &field, e, &xi).unwrap();
                for (s, t) in state.stress.iter().zip(&expected.stress) {
                    // Beside singular places the inverse Jacobian amplifies round-off by up to 1 / SINGULAR_STEP.
                    assert!(
                        (s - t).abs() < 1e-9 * YOUNG * 1e-3,
                        "{name}, {model:?}: {s}, {t} at {xi:?} of {patch}"
                    );
                }
            }
        }
    }
}

fn check(cases: Vec<Case>, n: usize) {
    for (name, model, shape, balance) in cases {
        let coarse = space(&shape, n);
        check_strain(name, &model, &coarse);
        let (first, n_tied) = imbalance(&model, &coarse);
        assert!(n_tied > 0 || shape.patches.len() == 1, "{name}: no tied functions inside");
        if balance == Exact {
            // Round-off of sums of some thousand terms.
            assert!(first < 1e-12, "{name}, {model:?}: {first:e}");
            continue;
        }
        let (second, _) = imbalance(&model, &space(&shape, 2 * n));
        assert!(first < TURNED && second < first, "{name}, {model:?}: {first:e}, {second:e}");
    }
}

#[test]
fn axisymmetric_shapes_pass_the_patch_test() {
    check(sections(), 3);
}

#[test]
fn plane_shapes_pass_the_patch_test() {
    check(plane_shapes(), 3);
}

#[test]
fn solids_pass_the_patch_test() {
    check(solids(), 2);
}
