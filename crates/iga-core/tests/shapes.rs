//! Named shapes: closed-form sizes, exact surfaces, orientation, and where the parametrisation is singular.

use std::f64::consts::PI;

use crate::measures::gauss;
use iga_core::SplineError;
use iga_core::nurbs::Face;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};
use iga_core::nurbs::shape::singular_sets;
use iga_core::nurbs::{Patch, Shape};
use iga_core::splines::knots::KnotVector;

/// Area or volume by Gauss points on every element; axisymmetric patches carry `2 pi r`.
fn measure(shape: &Shape, axisymmetric: bool, n: usize) -> f64 {
    let rule = gauss(n);
    let mut scratch = PointBasis::default();
    let mut sum = 0.0;
    for patch in &shape.patches {
        let d = patch.dimension();
        for e in 0..patch.n_elements() {
            let (lower, upper) = patch.element(e);
            for q in 0..n.pow(d as u32) {
                let (mut xi, mut weight) = ([0.0; 3], 1.0);
                for k in 0..d {
                    let (s, w) = rule[q / n.pow(k as u32) % n];
                    xi[k] = lower[k] + s * (upper[k] - lower[k]);
                    weight *= w * (upper[k] - lower[k]);
                }
                let jet = patch.jet_on(e, &xi, 1, &mut scratch);
                let around = if axisymmetric { 2.0 * PI * jet.point[0] } else { 1.0 };
                sum += weight * around * jet.determinant(d);
            }
        }
    }
    sum
}

fn shapes() -> Vec<(&'static str, Shape, bool, f64)> {
    let (r, l) = (0.01, 0.07);
    let ball = 4.0 / 3.0 * PI * r * r * r;
    vec![
        ("axisymmetric sphere", axisymmetric::sphere(r).unwrap(), true, ball),
        ("rod", axisymmetric::rod(r, l).unwrap(), true, PI * r * r * l),
        (
            "rod with spherical end",
            axisymmetric::rod_spherical_end(r, l).unwrap(),
            true,
            0.5 * ball + PI * r * r * (l - r),
        ),
        (
            "axisymmetric hollow cylinder",
            axisymmetric::hollow_cylinder(0.5 * r, r, l).unwrap(),
            true,
            0.75 * PI * r * r * l,
        ),
        ("spheroid", axisymmetric::spheroid(r, 3.0 * r).unwrap(), true, 3.0 * ball),
        ("rectangle", plane::rectangle(r, l).unwrap(), false, r * l),
        ("disc", plane::disc(r).unwrap(), false, PI * r * r),
        ("box", solid::cuboid([r, l, 0.03]).unwrap(), false, r * l * 0.03),
        ("cylinder", solid::cylinder(r, l).unwrap(), false, PI * r * r * l),
        ("hollow cylinder", solid::hollow_cylinder(0.5 * r, r, l).unwrap(), false, 0.75 * PI * r * r * l),
        ("cube-net sphere", sphere::sphere(r, SphereNet::Cube).unwrap(), false, ball),
        ("spindle-net sphere", sphere::sphere(r, SphereNet::Spindle).unwrap(), false, ball),
        ("seven-patch sphere", sphere::sphere(r, SphereNet::Shells).unwrap(), false, ball),
        ("ellipsoid", sphere::ellipsoid([r, 2.0 * r, 3.0 * r]).unwrap(), false, 6.0 * ball),
    ]
}

#[test]
fn sizes_match_closed_forms() {
    for (name, shape, axisymmetric, exact) in shapes() {
        // Rational integrands: 24 points per direction integrate them to round-off.
        let size = measure(&shape, axisymmetric, 24);
        assert!((size / exact - 1.0).abs() < 1e-12, "{name}: {size} instead of {exact}");
    }
}

/// A closed grid of `n + 1` values per direction on the unit box.
fn grid(dimension: usize, n: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..(n + 1).pow(dimension as u32)).map(move |q| {
        let mut xi = [0.0; 3];
        for (d, u) in xi.iter_mut().enumerate().take(dimension) {
            *u = (q / (n + 1).pow(d as u32) % (n + 1)) as f64 / n as f64;
        }
        xi
    })
}

#[test]
fn determinants_are_positive_off_the_declared_singular_sets() {
    for (name, shape, _, _) in shapes() {
        shape.check_orientation().unwrap_or_else(|e| panic!("{name}: {e}"));
        for (index, patch) in shape.patches.iter().enumerate() {
            let n = patch.dimension();
            let mut scratch = PointBasis::default();
            let largest =
                grid(n, 4).map(|xi| patch.jet(&xi, 1, &mut scratch).determinant(n)).fold(0.0, f64::max);
            for xi in grid(n, 20) {
                let det = patch.jet(&xi, 1, &mut scratch).determinant(n) / largest;
                if shape.singular_in(index, &xi, &xi).is_some() {
                    assert!(det.abs() < 1e-12, "{name}: {det} at {xi:?}"); // round-off of the product
                } else {
                    // Near the sets the determinant falls like a power of the distance, here 1/20.
                    assert!(det > 1e-5, "{name}: {det} at {xi:?}");
                }
            }
        }
    }
}

#[test]
fn declared_singular_sets_are_those_that_exist() {
    for (name, shape, _, _) in shapes() {
        let found: Vec<_> = shape.patches.iter().enumerate().flat_map(|(i, p)| singular_sets(i, p)).collect();
        for d in &shape.singular {
            let exists = found.iter().any(|s| d.patch == s.patch && d.parameters == s.parameters);
            assert!(exists, "{name}: {d:?} is regular");
        }
        assert_eq!(found.len(), shape.singular.len(), "{name}");
    }
}

/// Largest deviation of `|x|` from the radius over one face.
fn roundness(patch: &Patch, direction: usize, value: f64, radius: f64) -> f64 {
    let deviation = |mut xi: [f64; 3]| {
        xi[direction] = value;
        let p = patch.point(&xi);
        ((p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt() / radius - 1.0).abs()
    };
    grid(patch.dimension(), 20).map(deviation).fold(0.0, f64::max)
}

// A point is a quotient of two sums of 25 products of size one.
const ROUND_OFF: f64 = 2e-15;

#[test]
fn spherical_surfaces_are_exact() {
    let r = 0.01;
    let half_disc = axisymmetric::sphere(r).unwrap();
    let cube = sphere::sphere(r, SphereNet::Cube).unwrap();
    let spindle = sphere::sphere(r, SphereNet::Spindle).unwrap();
    for side in [0.0, 1.0] {
        assert!(roundness(&half_disc.patches[0], 1, side, r) < ROUND_OFF);
        for d in 0..3 {
            assert!(roundness(&cube.patches[0], d, side, r) < ROUND_OFF);
            assert!(roundness(&spindle.patches[0], d, side, r) < ROUND_OFF);
        }
    }
    for shell in &sphere::sphere(r, SphereNet::Shells).unwrap().patches[1..] {
        assert!(roundness(shell, 2, 1.0, r) < ROUND_OFF);
    }
    let end = &axisymmetric::rod_spherical_end(r, 1.0).unwrap().patches[0];
    for i in 0..=20 {
        let p = end.point(&[f64::from(i) / 20.0, 0.0, 0.0]);
        assert!(((p[0].powi(2) + (p[1] - r).powi(2)).sqrt() / r - 1.0).abs() < ROUND_OFF);
    }
}

#[test]
fn refinement_keeps_volumes_and_orientation() {
    for (name, shape, axisymmetric, exact) in shapes().into_iter().take(6) {
        let mut fine = shape.clone();
        for patch in &mut fine.patches {
            for d in 0..patch.dimension() {
                let finer = patch.knots()[d].elevated(2).unwrap().with_knots(&[0.1, 0.2, 0.6]).unwrap();
                *patch = patch.refine_to(d, &finer).unwrap();
            }
        }
        fine.check_orientation().unwrap();
        let size = measure(&fine, axisymmetric, 12);
        assert!((size / exact - 1.0).abs() < 1e-12, "{name}: {size} instead of {exact}");
    }
}

#[test]
fn impossible_sizes_are_refused_by_name() {
    let bad = [0.0, -1.0, f64::NAN, f64::INFINITY];
    for v in bad {
        for result in [
            axisymmetric::sphere(v),
            axisymmetric::spheroid(v, 1.0),
            axisymmetric::spheroid(1.0, v),
            axisymmetric::rod(v, 1.0),
            axisymmetric::rod(1.0, v),
            axisymmetric::rod_spherical_end(v, 1.0),
            axisymmetric::rod_spherical_end(1.0, v),
            axisymmetric::hollow_cylinder(v, 1.0, 1.0),
            plane::rectangle(1.0, v),
            plane::disc(v),
            solid::cuboid([1.0, v, 1.0]),
            solid::cylinder(v, 1.0),
            solid::hollow_cylinder(0.5, v, 1.0),
            sphere::sphere(v, SphereNet::Cube),
        ] {
            assert!(matches!(result, Err(SplineError::Dimension { .. })), "{v}");
        }
    }
    let text = solid::hollow_cylinder(1.0, 1.0, 1.0).unwrap_err().to_string();
    assert!(text.contains("inner_radius = 1"), "{text}");
    let text = axisymmetric::rod_spherical_end(0.2, 0.1).unwrap_err().to_string();
    assert!(text.contains("length = 0.1"), "{text}");
}

#[test]
fn nets_of_users_are_checked_for_folds() {
    let square = |x: f64| {
        let points = vec![[0.0; 3], [x, 0.0, 0.0], [0.0, 1.0, 0.0], [x, 1.0, 0.0]];
        Patch::new(vec![KnotVector::uniform(1, 1).unwrap(); 2], points, vec![1.0; 4]).unwrap()
    };
    assert!(Shape::from_patches(vec![square(1.0)]).unwrap().singular.is_empty());
    assert!(matches!(Shape::from_patches(vec![square(-1.0)]), Err(SplineError::Folded { .. })));
}

#[test]
fn contact_windows_name_the_singular_set_they_touch() {
    let ball = sphere::sphere(0.01, SphereNet::Spindle).unwrap();
    assert_eq!(ball.singular_in(0, &[0.4, 0.0, 0.3], &[0.6, 0.0, 0.7]), None);
    let pole = ball.singular_in(0, &[0.4, 0.0, 0.9], &[0.6, 0.0, 1.0]).unwrap();
    assert_eq!(pole.name, "pole y = +r");
    let meridian = ball.singular_in(0, &[0.0, 0.0, 0.3], &[0.6, 0.0, 0.7]).unwrap();
    assert_eq!(meridian.name, "meridian at 225° from the z axis");
    let half = axisymmetric::sphere(0.01).unwrap();
    assert_eq!(half.singular_in(0, &[0.0, 0.0, 0.0], &[0.99, 0.0, 0.0]), None);
    assert_eq!(half.singular_in(0, &[0.0, 0.0, 0.0], &[1.0, 0.0, 0.0]).unwrap().name, "equator");
}

#[test]
fn the_printed_rod_net_is_singular_on_its_jacket() {
    // Why the upper middle control point was moved: with the net as printed in [B] (38) the whole jacket is singular.
    let (r, l, s) = (0.01, 0.07, std::f64::consts::FRAC_1_SQRT_2);
    let points = [[0.0, 0.0], [r, 0.0], [r, r], [0.0, l], [r, l], [r, l]].map(|[x, z]| [x, z, 0.0]).to_vec();
    let knots = vec![KnotVector::uniform(2, 1).unwrap(), KnotVector::uniform(1, 1).unwrap()];
    let printed = Patch::new(knots, points, vec![1.0, s, 1.0, 1.0, 1.0, 1.0]).unwrap();
    let sets = singular_sets(0, &printed);
    assert!(sets.iter().any(|s| s.parameters == [Some(1.0), None, None]), "{sets:?}");
    // The changed net: cells of the lower block, whose height is 2 r, open towards the jacket in proportion to η, from the
    // junction at η = 0; above they are rectangles.
    let rod = axisymmetric::rod_spherical_end(r, l).unwrap();
    let middle = 2.0 * r / l;
    for eta in [0.0, 0.3 * middle, 0.9 * middle] {
        let jet = rod.patches[0].jet(&[1.0, eta, 0.0], 1, &mut PointBasis::default());
        let share = eta / middle;
        // dr/dξ = share r, dz/dη = (2 r - r) / middle, and dr/dη = 0 on the jacket
        assert!((jet.determinant(2) - share * r * (r / middle)).abs() < 1e-15 * r);
    }
    let jet = rod.patches[0].jet(&[1.0, 0.5 + 0.5 * middle, 0.0], 1, &mut PointBasis::default());
    assert!((jet.determinant(2) - r * l).abs() < 1e-14 * r);
}

#[test]
fn the_default_ball_follows_the_degree() {
    assert_eq!(SphereNet::for_degree(2), SphereNet::Spindle);
    assert_eq!(SphereNet::for_degree(3), SphereNet::Spindle);
    assert_eq!(SphereNet::for_degree(4), SphereNet::Cube);
    for degree in 2..=5 {
        let net = SphereNet::for_degree(degree);
        let own = sphere::sphere(0.01, net).unwrap();
        let degrees: Vec<usize> = own.patches[0].knots().iter().map(|k| k.degree().max(degree)).collect();
        let ball = own.refined(&degrees, &[4; 3], &[]).unwrap();
        // Contact along x and z, joints at the top: regular in either net.
        for marker in ["left", "right", "top", "bottom"] {
            let (patch, xi) = ball.locate(&ball.markers[marker]).unwrap();
            let near =
                |s: f64| [0, 1, 2].map(|d| if (0.01..0.99).contains(&xi[d]) { xi[d] + s } else { xi[d] });
            assert_eq!(ball.singular_in(patch, &near(-0.3), &near(0.3)), None, "{net:?} {marker}");
        }
    }
}

#[test]
fn a_turned_ball_is_the_same_ball() {
    let ball = sphere::sphere(0.01, SphereNet::Cube).unwrap();
    let (c, s) = (0.6, 0.8);
    let turned = ball.rotated(&[[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).unwrap();
    turned.check_orientation().unwrap();
    assert!((measure(&turned, false, 24) / measure(&ball, false, 24) - 1.0).abs() < 1e-13);
    assert!((turned.markers["right"][1] - 0.01 * s).abs() < 1e-17);
    let (patch, xi) = turned.locate(&turned.markers["right"]).unwrap();
    let at = turned.patches[patch].point(&xi);
    assert!((at[0] - 0.01 * c).abs() < 1e-15);
}

#[test]
fn surfaces_of_ellipsoids_obey_their_equation_and_have_their_curvatures() {
    let axes = [0.02, 0.015, 0.01];
    let body = sphere::ellipsoid(axes).unwrap();
    assert!((body.markers["right"][0] / axes[0] - 1.0).abs() < 1e-15);
    let patch = &body.patches[0];
    for face in Face::outer(&body.patches, false) {
        for share in grid(2, 7) {
            let mut xi = face.on_face(&[0.0; 3]);
            for (d, s) in face.directions().zip(share) {
                xi[d] = s;
            }
            let point = patch.point(&xi);
            let sum: f64 = point.iter().zip(axes).map(|(x, a)| (x / a).powi(2)).sum();
            assert!((sum - 1.0).abs() < 1e-13, "{point:?}");
        }
        // At the end of axis c the curvatures are c/a² and c/b², the larger one along the shorter of a and b.
        let c = face.id.direction;
        let [a, b] = [(c + 1) % 3, (c + 2) % 3];
        let jet = patch.jet(&face.on_face(&[0.5; 3]), 2, &mut PointBasis::default());
        assert!((jet.point[c].abs() / axes[c] - 1.0).abs() < 1e-13);
        let short = if axes[a] < axes[b] { a } else { b };
        let exact = [short, a + b - short].map(|d| axes[c] / axes[d].powi(2));
        let found = face.curvatures(&jet).unwrap();
        // Second derivatives lose some digits.
        found
            .iter()
            .zip(exact)
            .for_each(|(k, e)| assert!((k / e - 1.0).abs() < 1e-11, "{found:?} {exact:?}"));
        let direction = face.first_direction(&jet).unwrap();
        assert!((direction[short].abs() - 1.0).abs() < 1e-12, "{direction:?}");
    }
    assert!(sphere::ellipsoid([0.02, 0.0, 0.01]).is_err());
    let (a, c) = (0.02, 0.01);
    let half = axisymmetric::spheroid(a, c).unwrap();
    for face in &half.faces["surface"] {
        for i in 0..=20 {
            let mut xi = [f64::from(i) / 20.0, 0.0, 0.0];
            xi[face.direction] = if face.upper { 1.0 } else { 0.0 };
            let [r, z, _] = half.patches[0].point(&xi);
            assert!(((r / a).powi(2) + (z / c).powi(2) - 1.0).abs() < 1e-14, "{r} {z}");
        }
    }
    assert_eq!(half.markers["top"].map(f64::to_bits), [0.0, c, 0.0].map(f64::to_bits));
}
