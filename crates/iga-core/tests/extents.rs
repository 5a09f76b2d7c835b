//! Named faces, discs and balls: areas, volumes and centroids against closed forms, whatever the mesh.

use std::f64::consts::PI;

use iga_core::SplineError;
use iga_core::elasticity::Model;
use iga_core::extent::Extent;
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{axisymmetric, plane, solid, sphere};
use iga_core::space::PatchSpace;

const R: f64 = 0.02;
const INNER: f64 = 0.012;
const L: f64 = 0.05;
const T: f64 = 0.004;
const AXIAL: Model = Model::Axisymmetric;
const FLAT: Model = Model::PlaneStress { thickness: T };

/// Round-off of sums of some ten thousand terms.
const ROUND_OFF: f64 = 1e-12;
/// Weights of conics make integrands rational: Gauss points of the elements of a mesh with two elements an arc leave this.
const RATIONAL: f64 = 1e-6;

fn face(name: &str) -> Extent {
    Extent::Face(name.into())
}

fn around(point: [f64; 3], radius: f64) -> Extent {
    Extent::Around { point, radius }
}

/// Area (volume) and centroid on a mesh of `elements` elements per direction.
fn measured(extent: &Extent, shape: &Shape, model: &Model, elements: usize) -> (f64, [f64; 3]) {
    let n = model.dimension();
    let degrees: Vec<usize> =
        (0..n).map(|d| shape.patches.iter().map(|p| p.knots()[d].degree()).max().unwrap_or(1)).collect();
    let fine = shape.refined(&degrees, &vec![elements; n], &[]).unwrap();
    let space = PatchSpace::new(fine.patches).unwrap();
    let points = extent.points(shape, &space, model).unwrap_or_else(|e| panic!("{extent:?}: {e}"));
    let total: f64 = points.iter().map(|p| p.weight).sum();
    (total, [0, 1, 2].map(|c| points.iter().map(|p| p.weight * p.point[c]).sum::<f64>() / total))
}

/// Model, shape, and its faces with areas and places (of axisymmetric faces the height).
type Case = (Model, Shape, Vec<(&'static str, f64, [f64; 3])>);

fn bodies_of_revolution() -> Vec<Case> {
    let (disc, jacket) = (PI * R * R, 2.0 * PI * R * L);
    let ring = PI * (R * R - INNER * INNER);
    let bore = 2.0 * PI * INNER * L;
    let at = |z: f64| [0.0, z, 0.0];
    vec![
        (AXIAL, axisymmetric::sphere(R).unwrap(), vec![("surface", 4.0 * PI * R * R, at(0.0))]),
        (
            AXIAL,
            axisymmetric::rod(R, L).unwrap(),
            vec![
                ("z-", disc, at(0.0)),
                ("z+", disc, at(L)),
                ("jacket", jacket, at(0.5 * L)),
                ("start", disc, at(0.0)),
                ("end", disc, at(L)),
            ],
        ),
        (
            AXIAL,
            axisymmetric::rod_spherical_end(R, L).unwrap(),
            vec![
                ("z-", 2.0 * PI * R * R, at(0.5 * R)), // half a sphere, Archimedes
                ("z+", disc, at(L)),
                ("jacket", 2.0 * PI * R * (L - R), at(0.5 * (L + R))),
                ("start", 2.0 * PI * R * R, at(0.5 * R)),
                ("end", disc, at(L)),
            ],
        ),
        (
            AXIAL,
            axisymmetric::hollow_cylinder(INNER, R, L).unwrap(),
            vec![
                ("z-", ring, at(0.0)),
                ("z+", ring, at(L)),
                ("inner", bore, at(0.5 * L)),
                ("outer", jacket, at(0.5 * L)),
                ("start", ring, at(0.0)),
                ("end", ring, at(L)),
            ],
        ),
    ]
}

fn solids() -> Vec<Case> {
    let (disc, jacket) = (PI * R * R, 2.0 * PI * R * L);
    let ring = PI * (R * R - INNER * INNER);
    let bore = 2.0 * PI * INNER * L;
    let at = |z: f64| [0.0, 0.0, z];
    let [a, b, c] = [0.03, 0.02, 0.01];
    let mut cases: Vec<Case> = SphereNet::ALL
        .iter()
        .map(|net| {
            let faces = vec![("surface", 4.0 * PI * R * R, at(0.0))];
            (Model::Solid, sphere::sphere(R, *net).unwrap(), faces)
        })
        .collect();
    let box_faces = vec![
        ("x-", b * c, [-0.5 * a, 0.0, 0.0]),
        ("x+", b * c, [0.5 * a, 0.0, 0.0]),
        ("y-", a * c, [0.0, -0.5 * b, 0.0]),
        ("y+", a * c, [0.0, 0.5 * b, 0.0]),
        ("z-", a * b, at(-0.5 * c)),
        ("z+", a * b, at(0.5 * c)),
        ("start", a * b, at(-0.5 * c)),
        ("end", a * b, at(0.5 * c)),
    ];
    cases.push((Model::Solid, solid::cuboid([a, b, c]).unwrap(), box_faces));
    let ends = |area: f64| {
        vec![("z-", area, at(0.0)), ("z+", area, at(L)), ("start", area, at(0.0)), ("end", area, at(L))]
    };
    let mut faces = ends(disc);
    faces.push(("jacket", jacket, at(0.5 * L)));
    cases.push((Model::Solid, solid::cylinder(R, L).unwrap(), faces));
    let mut faces = ends(ring);
    faces.extend([("inner", bore, at(0.5 * L)), ("outer", jacket, at(0.5 * L))]);
    cases.push((Model::Solid, solid::hollow_cylinder(INNER, R, L).unwrap(), faces));
    cases
}

fn plane_bodies() -> Vec<Case> {
    let [a, b] = [0.03, 0.02];
    let edges = vec![
        ("x-", b * T, [-0.5 * a, 0.0, 0.0]),
        ("x+", b * T, [0.5 * a, 0.0, 0.0]),
        ("y-", a * T, [0.0, -0.5 * b, 0.0]),
        ("y+", a * T, [0.0, 0.5 * b, 0.0]),
        ("start", b * T, [-0.5 * a, 0.0, 0.0]),
        ("end", b * T, [0.5 * a, 0.0, 0.0]),
    ];
    vec![
        (FLAT, plane::rectangle(a, b).unwrap(), edges),
        (FLAT, plane::disc(R).unwrap(), vec![("rim", 2.0 * PI * R * T, [0.0; 3])]),
    ]
}

#[test]
fn faces_of_every_shape_have_their_area_and_place() {
    for (model, shape, faces) in bodies_of_revolution().into_iter().chain(solids()).chain(plane_bodies()) {
        let mut named: Vec<&str> = faces.iter().map(|(name, ..)| *name).collect();
        named.sort_unstable();
        assert_eq!(shape.faces.keys().map(String::as_str).collect::<Vec<_>>(), named);
        for (name, area, place) in faces {
            let centre = face(name).centre(&shape, &model).unwrap();
            for (c, x) in place.iter().enumerate() {
                assert!((centre[c] - x).abs() < ROUND_OFF * L, "{name}: {centre:?} {place:?}");
            }
            for elements in [2, 5] {
                let (found, middle) = measured(&face(name), &shape, &model, elements);
                assert!((found / area - 1.0).abs() < RATIONAL, "{name}: {found:e} {area:e}");
                let first = usize::from(model == AXIAL);
                let off = (first..3).map(|c| (middle[c] - place[c]).abs()).fold(0.0, f64::max);
                assert!(off < RATIONAL * L, "{name}: {middle:?} {place:?}");
            }
        }
    }
}

#[test]
fn discs_have_the_area_that_their_projection_has_on_the_surface() {
    let a = 0.15 * R;
    // A cap of a sphere cut off by a cylinder of radius a: Archimedes.
    let cap = 2.0 * PI * R * (R - (R * R - a * a).sqrt());
    for net in SphereNet::ALL {
        let ball = sphere::sphere(R, net).unwrap();
        // Regular places, and one on singular lines of two of the nets.
        let s = 1.0 / 3f64.sqrt();
        for n in [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [s, s, s], [0.6, 0.0, 0.8]] {
            for elements in [1, 3, 20] {
                let (found, _) = measured(&around(n.map(|x| x * R), a), &ball, &Model::Solid, elements);
                // The rule integrates 1/cos, a smooth function of (a/R)² = 0.02, to round-off of the search, 1e-12.
                assert!((found / cap - 1.0).abs() < 1e-9, "{net:?} {n:?} {elements}: {found:e} {cap:e}");
            }
        }
    }
    let disc = PI * a * a;
    let block = solid::cuboid([0.3, 0.03, 0.01]).unwrap();
    let rod = axisymmetric::rod(R, L).unwrap();
    let flat = plane::rectangle(0.1, 0.05).unwrap();
    for (extent, shape, model, area) in [
        (around([0.1, 0.004, 0.005], a), &block, Model::Solid, disc),
        (around([0.0, L, 0.0], a), &rod, AXIAL, disc),
        (around([R, 0.5 * L, 0.0], a), &rod, AXIAL, 2.0 * PI * R * 2.0 * a),
        (around([0.5 * R, 0.0, 0.0], a), &rod, AXIAL, 2.0 * PI * 0.5 * R * 2.0 * a),
        (around([0.02, -0.025, 0.0], a), &flat, FLAT, 2.0 * a * T),
    ] {
        for elements in [1, 7, 30] {
            let (found, _) = measured(&extent, shape, &model, elements);
            assert!((found / area - 1.0).abs() < ROUND_OFF, "{extent:?} {elements}: {found:e} {area:e}");
        }
    }
    // A disc may be as wide as the face.
    let (found, _) = measured(&around([0.0, 0.0, L], R), &solid::cylinder(R, L).unwrap(), &Model::Solid, 4);
    assert!((found / (PI * R * R) - 1.0).abs() < ROUND_OFF);
}

#[test]
fn balls_have_their_volume() {
    let a = 0.3 * R;
    let ball = 4.0 / 3.0 * PI * a.powi(3);
    let axial = axisymmetric::rod(R, L).unwrap();
    let ring = 2.0 * PI * 0.5 * R * PI * a * a; // Pappus
    let hub = PI * a * a * T;
    for (point, shape, model, volume) in [
        ([0.3 * R, 0.1 * R, 0.4 * L], solid::cylinder(R, L).unwrap(), Model::Solid, ball),
        ([0.0; 3], sphere::sphere(R, SphereNet::Shells).unwrap(), Model::Solid, ball),
        ([0.0, 0.5 * L, 0.0], axial.clone(), AXIAL, ball),
        ([0.5 * R, 0.5 * L, 0.0], axial, AXIAL, ring),
        ([0.0; 3], plane::disc(R).unwrap(), FLAT, hub),
    ] {
        for elements in [1, 4] {
            let (found, _) = measured(&around(point, a), &shape, &model, elements);
            // Half a disc turned about the axis: Gauss points of the sine, two parts of 90° with four each.
            assert!((found / volume - 1.0).abs() < 1e-6, "{point:?} {elements}: {found:e} {volume:e}");
        }
    }
}

#[test]
fn parts_that_do_not_exist_are_refused_with_a_remedy() {
    let block = solid::cuboid([0.3, 0.03, 0.01]).unwrap();
    let space = PatchSpace::new(block.patches.clone()).unwrap();
    let refused = |extent: &Extent| extent.points(&block, &space, &Model::Solid).unwrap_err();
    let unknown = refused(&face("x"));
    assert!(matches!(&unknown, SplineError::UnknownFace { known, .. } if known.len() == 8), "{unknown}");
    assert!(unknown.to_string().contains("x+, x-, y+, y-, z+, z-"), "{unknown}");
    for (point, radius, words) in [
        ([0.1, 0.014, 0.005], 2e-3, "beyond the body"),
        ([0.1, 0.0, 0.003], 2.5e-3, "beyond the body"),
        ([0.15, 0.0, 0.005], 1e-3, "beyond the body"), // on an edge
        ([0.1, 0.0, 0.02], 1e-3, "not in the body"),
        ([0.1, 0.0, 0.0], 0.0, "positive"),
        ([0.1, 0.0, 0.0], f64::NAN, "positive"),
    ] {
        let error = refused(&around(point, radius)).to_string();
        assert!(error.contains(words), "{point:?}: {error}");
    }
    let beyond_axis = around([0.3 * R, 0.5 * L, 0.0], 0.5 * R);
    let rod = axisymmetric::rod(R, L).unwrap();
    let space = PatchSpace::new(rod.patches.clone()).unwrap();
    assert!(beyond_axis.points(&rod, &space, &AXIAL).is_err());
}

#[test]
fn a_centre_beside_the_surface_means_the_disc_about_the_nearest_place() {
    let block = solid::cuboid([0.3, 0.03, 0.01]).unwrap();
    let radius = 2e-3;
    for beside in [-0.09, -5e-6, 0.0, 5e-6, 0.09] {
        let (area, centre) =
            measured(&around([0.1, 0.0, 0.005 + beside * radius], radius), &block, &Model::Solid, 4);
        // Gauss points in rings about the centre of a plane disc: round-off.
        assert!((area / (PI * radius * radius) - 1.0).abs() < ROUND_OFF, "{beside}: {area:e}");
        let places = centre.iter().zip([0.1, 0.0, 0.005]);
        assert!(places.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) < ROUND_OFF, "{beside}: {centre:?}");
    }
}

#[test]
fn the_longest_element_under_a_place_is_that_of_the_mesh() {
    let block = solid::cuboid([0.03, 0.02, 0.01]).unwrap();
    let fine = block.refined(&[1; 3], &[3, 4, 5], &[]).unwrap();
    let space = PatchSpace::new(fine.patches).unwrap();
    let longest = |extent: Extent| extent.longest_element(&block, &space, &Model::Solid).unwrap();
    for extent in [around([0.0, 0.0, 0.005], 1e-3), around([0.0; 3], 1e-3)] {
        assert!((longest(extent).unwrap() - 0.01).abs() < ROUND_OFF);
    }
    assert_eq!(longest(face("z+")), None);
}
