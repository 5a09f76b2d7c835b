//! Patches cut along lines of lower continuity and where they close on themselves: the same body in more patches, whose faces are those of before.

use iga_core::elasticity::Model;
use iga_core::elasticity::mass_properties::MassProperties;
use iga_core::nurbs::Face;
use iga_core::nurbs::joining::join;
use iga_core::nurbs::primitives::{SphereNet, plane, profile, solid, sphere};
use iga_core::nurbs::{FaceId, Patch, Shape};
use iga_core::splines::knots::KnotVector;

fn cut(shape: &Shape) -> Shape {
    let joined = join(&shape.patches, &[]).expect("a body").shape;
    joined.cut().expect("the same geometry")
}

/// Checks that `found` is the body `shape`, has `n` patches, all of them neighbours of others but where `shape` ends, and no line of lower continuity.
fn check(name: &str, shape: &Shape, model: &Model, n: usize) -> Shape {
    let joined = join(&shape.patches, &[]).expect("a body").shape;
    let found = cut(shape);
    assert_eq!(found.patches.len(), n, "{name}");
    let [a, b] = [&joined, &found].map(|s| MassProperties::of(s, model).expect("regular").volume);
    // The same polynomials: round-off of the knots that were inserted.
    assert!((a / b - 1.0).abs() < 1e-13, "{name}: {a} {b}");
    for patch in &found.patches {
        for knots in patch.knots() {
            let inner = &knots.breaks()[1..knots.n_elements()];
            assert!(inner.iter().all(|u| knots.multiplicity(*u) < knots.degree()), "{name}");
        }
    }
    // A patch whose neighbour it is itself has a face less that is outer and none that is another's.
    let outer: usize = joined.faces.values().map(Vec::len).sum();
    let named: Vec<FaceId> = found.faces.values().flatten().copied().collect();
    assert!(named.len() >= outer, "{name}");
    let mut faces: Vec<FaceId> = Face::outer(&found.patches, false).iter().map(|f| f.id).collect();
    let mut named = if joined.faces.contains_key("surface") { found.faces["surface"].clone() } else { named };
    faces.sort_unstable();
    named.sort_unstable();
    assert_eq!(faces, named, "{name}");
    assert_eq!(joined.faces.keys().collect::<Vec<_>>(), found.faces.keys().collect::<Vec<_>>(), "{name}");
    assert!(join(&found.patches, &[]).is_ok(), "{name}: its parts make a body");
    found
}

#[test]
fn circles_of_quarter_arcs_are_four_patches() {
    let tube = solid::hollow_cylinder(0.5, 1.0, 2.0).expect("a tube");
    let found = check("tube", &tube, &Model::Solid, 4);
    assert_eq!(found.parts, [1, 4, 1]);
    assert_eq!(found.faces["xi+"].len(), 4);
    // Parts have the arcs, from 0 to 1 each.
    for (k, patch) in found.patches.iter().enumerate() {
        let middle = patch.point(&[1.0, 0.5, 0.5]);
        let angle = std::f64::consts::FRAC_PI_4 * (2 * k + 1) as f64;
        assert!((middle[0] - angle.cos()).abs() + (middle[1] - angle.sin()).abs() < 1e-14, "{k}: {middle:?}");
    }
    let sector = profile::tube_sector(0.5, 1.0, 2.0, 3.0).expect("a sector");
    check("sector", &sector, &Model::Solid, 2);
}

#[test]
fn what_has_no_such_line_stays_as_it_is() {
    for (name, shape) in [
        ("box", solid::cuboid([1.0, 2.0, 3.0])),
        ("ball", sphere::sphere(1.0, SphereNet::Cube)),
        ("spindle", sphere::sphere(1.0, SphereNet::Spindle)),
        ("ball of seven patches", sphere::sphere(1.0, SphereNet::Shells)),
        ("disc", plane::disc(1.0)),
    ] {
        let shape = shape.expect("a shape");
        let joined = join(&shape.patches, &[]).expect("a body").shape;
        assert_eq!(cut(&shape), joined, "{name}");
    }
}

/// A ring without a line of lower continuity but its seam: a smooth closed net of `n` points, as far as a clamped one has it, in the plane.
fn smooth_ring(n: usize) -> Patch {
    let around = KnotVector::uniform(2, n).expect("knots");
    let out = KnotVector::uniform(1, 1).expect("knots");
    let size = around.n_functions();
    let point = |i: usize, r: f64| {
        let angle = std::f64::consts::TAU * (i % (size - 1)) as f64 / (size - 1) as f64;
        [r * angle.cos(), r * angle.sin(), 0.0]
    };
    let points: Vec<[f64; 3]> =
        [2.0, 1.0].iter().flat_map(|&r| (0..size).map(move |i| point(i, r))).collect();
    let weights = vec![1.0; points.len()];
    Patch::new(vec![around, out], points, weights).expect("a ring")
}

#[test]
fn a_patch_that_closes_on_itself_is_two() {
    let model = Model::PlaneStrain { thickness: 1.0 };
    // At the knot nearest the middle; a closed patch of one element has none and is cut in its middle.
    for n in [2, 4, 5, 9] {
        let shape = Shape::from_patches(vec![smooth_ring(n)]).expect("a ring");
        let found = check("ring", &shape, &model, 2);
        assert_eq!(found.parts, [2, 1, 1]);
    }
}

#[test]
fn neighbours_are_cut_where_their_common_direction_is() {
    // Two boxes side by side, the first with a double knot along the common face; the second has it, too, backwards.
    let linear = KnotVector::uniform(1, 1).expect("knots");
    let cuboid = |x: f64| {
        let corner = |i: usize| [x + (i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64];
        let patch =
            Patch::new(vec![linear.clone(); 3], (0..8).map(corner).collect(), vec![1.0; 8]).expect("a box");
        let fine = KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.25, 0.25, 1.0, 1.0, 1.0]).expect("knots");
        patch
            .refine_to(1, &KnotVector::new(1, vec![0.0, 0.0, 0.25, 1.0, 1.0]).expect("knots"))
            .and_then(|p| p.refine_to(1, &fine))
            .expect("finer")
    };
    let turned = cuboid(1.0).reversed(1).and_then(|p| p.reversed(2)).expect("turned");
    let joined = join(&[cuboid(0.0), turned], &[]).expect("a body").shape;
    let found = joined.cut().expect("cut");
    assert_eq!((found.patches.len(), found.parts), (4, [1, 2, 1]));
    assert_eq!(found.faces["0:eta-"].len() + found.faces["1:zeta+"].len(), 1 + 2);
    assert!(join(&found.patches, &[]).is_ok(), "parts fit each other");
    // Divided alike.
    assert!(found.refined(&[2; 3], &[1, 3, 2], &[]).is_ok());
}
