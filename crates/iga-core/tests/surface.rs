//! Surfaces of bodies: which faces are outside, normals, curvatures, areas, contact points.

use std::f64::consts::PI;

use iga_core::nurbs::Face;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};
use iga_core::nurbs::{RefinementWindow, Shape};
use iga_core::space::{PatchSpace, Space};
use iga_core::surface::{
    BodySurface, CollocationPoint, gauss_points, greville_points, lobatto_points, tributary_areas,
};

const R: f64 = 0.01;
const L: f64 = 0.03;

struct Case {
    name: &'static str,
    shape: Shape,
    axisymmetric: bool,
    n_faces: usize,
    area: f64,
}

fn cases() -> Vec<Case> {
    let case = |name, shape, axisymmetric, n_faces, area| Case { name, shape, axisymmetric, n_faces, area };
    let ball = 4.0 * PI * R * R;
    let jacket = 2.0 * PI * R * L;
    let mut all = vec![
        case("half-disc", axisymmetric::sphere(R).unwrap(), true, 2, ball),
        case("rod", axisymmetric::rod(R, L).unwrap(), true, 3, jacket + 2.0 * PI * R * R),
        case(
            "rod with spherical end",
            axisymmetric::rod_spherical_end(R, L).unwrap(),
            true,
            3,
            0.5 * ball + 2.0 * PI * R * (L - R) + PI * R * R,
        ),
        case(
            "tube",
            axisymmetric::hollow_cylinder(0.5 * R, R, L).unwrap(),
            true,
            4,
            1.5 * jacket + 1.5 * PI * R * R,
        ),
        case("rectangle", plane::rectangle(R, L).unwrap(), false, 4, 2.0 * (R + L)),
        case("disc", plane::disc(R).unwrap(), false, 4, 2.0 * PI * R),
        case("box", solid::cuboid([R, L, 0.02]).unwrap(), false, 6, 2.0 * (R * L + (R + L) * 0.02)),
        case("cylinder", solid::cylinder(R, L).unwrap(), false, 6, jacket + 2.0 * PI * R * R),
        case(
            "solid tube",
            solid::hollow_cylinder(0.5 * R, R, L).unwrap(),
            false,
            4,
            1.5 * jacket + 1.5 * PI * R * R,
        ),
    ];
    for (net, n_faces) in [(SphereNet::Cube, 6), (SphereNet::Spindle, 4), (SphereNet::Shells, 6)] {
        all.push(case("ball", sphere::sphere(R, net).unwrap(), false, n_faces, ball));
    }
    all
}

/// The case's shape with elements enough for the quadrature, and its space.
fn space(case: &Case, elements: usize) -> (Shape, PatchSpace, Vec<Face>) {
    let n = case.shape.patches[0].dimension();
    let fine = case.shape.refined(&[4; 3][..n], &[elements; 3][..n], &[]).unwrap();
    let faces = Face::outer(&fine.patches, case.axisymmetric);
    (fine.clone(), PatchSpace::new(fine.patches).unwrap(), faces)
}

fn total(points: &[CollocationPoint]) -> f64 {
    points.iter().map(|p| p.area).sum()
}

#[test]
fn outer_faces_are_found_and_their_areas_match_closed_forms() {
    for case in cases() {
        assert_eq!(Face::outer(&case.shape.patches, case.axisymmetric).len(), case.n_faces, "{}", case.name);
        let (fine, space, faces) = space(&case, 4);
        assert_eq!(faces.len(), case.n_faces, "{}", case.name);
        let gauss = gauss_points(&space, &fine.patches, &faces, Some(8));
        // Eight Gauss points on a sixteenth of a turn or so: far below 1e-10 relative; poles converge like smooth faces.
        assert!((total(&gauss) / case.area - 1.0).abs() < 1e-10, "{}: {}", case.name, total(&gauss));
        let greville = greville_points(&space, &fine.patches, &faces);
        // Eight or nine points per direction here, too.
        assert!((total(&greville) / case.area - 1.0).abs() < 1e-10, "{}: {}", case.name, total(&greville));
        assert!(greville.iter().all(|p| p.area > 0.0), "{}", case.name);
    }
}

#[test]
fn lobatto_points_stand_on_every_corner_and_cover_the_surface() {
    for case in cases() {
        let (fine, space, faces) = space(&case, 4);
        let points = lobatto_points(&space, &fine.patches, &faces, (&[], 0));
        let error = (total(&points) / case.area - 1.0).abs();
        // Rules of four and five points on a sixteenth of a turn, or a quarter of the solid tube.
        assert!(error < 1e-3, "{}: {error:e}", case.name);
        assert!(points.iter().all(|p| p.area > 0.0 && p.function.is_none()), "{}", case.name);
    }
    let cuboid = Shape::clone(&cases().into_iter().find(|c| c.name == "box").unwrap().shape);
    let fine = cuboid.refined(&[2; 3], &[2; 3], &[]).unwrap();
    let space = PatchSpace::new(fine.patches.clone()).unwrap();
    let points = lobatto_points(&space, &fine.patches, &Face::outer(&fine.patches, false), (&[], 0));
    // Three points per element and direction, those in common once: five by five on each of six faces.
    assert_eq!(points.len(), 6 * 25);
    let corner = points
        .iter()
        .map(|p| p.point)
        .max_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()))
        .unwrap();
    let here: Vec<&CollocationPoint> =
        points.iter().filter(|p| p.point.map(f64::to_bits) == corner.map(f64::to_bits)).collect();
    assert_eq!(here.len(), 3, "one point of each face that meets at the corner");
    let normals: f64 = here.iter().map(|p| p.normal.iter().sum::<f64>()).sum();
    assert!((normals - 3.0).abs() < 1e-12);
}

#[test]
fn lobatto_points_stand_at_a_place_and_ever_closer_about_it() {
    let case = cases().into_iter().find(|c| c.name == "box").unwrap();
    let fine = case.shape.refined(&[2; 3], &[2; 3], &[]).unwrap();
    let space = PatchSpace::new(fine.patches.clone()).unwrap();
    let faces = Face::outer(&fine.patches, false);
    let face = faces[0];
    let [u, v] = [0, 1].map(|i| face.directions().nth(i).unwrap());
    for (at, others) in [([0.3, 0.1], 4), ([0.5, 0.1], 3), ([0.5, 0.0], 2), ([0.0, 0.0], 2)] {
        let mut xi = [face.parameter; 3];
        (xi[u], xi[v]) = (at[0], at[1]);
        let points = lobatto_points(&space, &fine.patches, &faces, (&[(face.id, xi)], 5));
        assert!((total(&points) / case.area - 1.0).abs() < 1e-12, "{at:?}");
        let on_face: Vec<&CollocationPoint> = points.iter().filter(|p| p.face == face.id).collect();
        assert_eq!(
            on_face.iter().filter(|p| p.xi.map(f64::to_bits) == xi.map(f64::to_bits)).count(),
            1,
            "{at:?}"
        );
        // Half of the smallest part, a thirty-second of what lies between the place and an end of its element, in both directions.
        let near = on_face.iter().filter(|p| {
            let away = [u, v].map(|d| (p.xi[d] - xi[d]).abs());
            away.iter().any(|a| *a > 0.0) && away.iter().all(|a| *a <= 0.5 / 64.0 + 1e-12)
        });
        assert!(near.count() >= others, "{at:?}");
    }
}

#[test]
fn lobatto_points_load_functions_as_a_uniform_pressure_does() {
    for case in cases().into_iter().filter(|c| ["rod", "box", "rectangle"].contains(&c.name)) {
        for degree in 1..=4 {
            let n = case.shape.patches[0].dimension();
            let fine = case.shape.refined(&[degree; 3][..n], &[3; 3][..n], &[]).unwrap();
            let space = PatchSpace::new(fine.patches.clone()).unwrap();
            for face in Face::outer(&fine.patches, case.axisymmetric) {
                let wanted = tributary_areas(&space, &fine.patches, &face);
                let mut found: std::collections::BTreeMap<u32, f64> = Default::default();
                // On the parts towards a place as on whole elements: in the midst of one, on an end, in a corner.
                let mut place = [0.4, 1.0 / 3.0, 0.0];
                place[face.id.direction] = face.parameter;
                for p in lobatto_points(&space, &fine.patches, &[face], (&[(face.id, place)], 5)) {
                    for (function, value) in space.functions_at(p.element, &p.xi) {
                        *found.entry(function).or_default() += value * p.area;
                    }
                }
                let area: f64 = wanted.values().sum();
                for (function, w) in &wanted {
                    let is = found.get(function).copied().unwrap_or(0.0);
                    // Both are exact but for radii at ends of elements, which are taken 1e-9 of their half within (Eq. C.56).
                    assert!((is - w).abs() < 1e-9 * area, "{} degree {degree}: {is} {w}", case.name);
                }
            }
        }
    }
}

#[test]
fn normals_point_outwards() {
    for case in cases() {
        let centre = case.shape.markers["centre"];
        let mut scratch = PointBasis::default();
        for face in Face::outer(&case.shape.patches, case.axisymmetric) {
            let patch = &case.shape.patches[face.id.patch];
            for (u, v) in [(0.3, 0.4), (0.6, 0.1), (0.9, 0.7)] {
                let at = face.at(patch, &[u, v, 0.5 * (u + v)], &mut scratch);
                let length: f64 = at.normal.iter().map(|c| c * c).sum();
                assert!((length - 1.0).abs() < 1e-14);
                for t in &at.tangents {
                    let slope: f64 = (0..3).map(|c| t[c] * at.normal[c]).sum();
                    assert!(slope.abs() < 1e-15);
                }
                let mut inside = face.on_face(&[u, v, 0.5 * (u + v)]);
                inside[patch.dimension()..].fill(0.0);
                inside[face.id.direction] += if face.id.upper { -1e-4 } else { 1e-4 };
                let x = patch.point(&inside);
                let out: f64 = (0..3).map(|c| (at.point[c] - x[c]) * at.normal[c]).sum();
                assert!(out > 0.0, "{} {face:?} {centre:?}", case.name);
            }
        }
    }
}

#[test]
fn curvatures_match_closed_forms() {
    let mut scratch = PointBasis::default();
    let mut check = |shape: &Shape, axisymmetric: bool, face: usize, expected: [f64; 2]| {
        let face = Face::outer(&shape.patches, axisymmetric)[face];
        for (u, v) in [(0.3, 0.4), (0.6, 0.1), (0.0, 0.5)] {
            let patch = &shape.patches[face.id.patch];
            let mut xi = face.on_face(&[u, v, 0.7 * v]);
            xi[patch.dimension()..].fill(0.0);
            let found = face.curvatures(&patch.jet(&xi, 2, &mut scratch)).unwrap();
            for (a, b) in found.iter().zip(&expected) {
                // Second derivatives lose a few digits; equal curvatures split by the square root of round-off.
                assert!((a - b).abs() < 1e-5 / R, "{found:?} {expected:?}");
            }
        }
    };
    let k = 1.0 / R;
    for net in SphereNet::ALL {
        let ball = sphere::sphere(R, net).unwrap();
        for face in 0..4 {
            check(&ball, false, face, [k, k]);
        }
    }
    check(&axisymmetric::sphere(R).unwrap(), true, 0, [k, k]);
    check(&plane::disc(R).unwrap(), false, 2, [k, 0.0]);
    check(&plane::rectangle(R, L).unwrap(), false, 0, [0.0, 0.0]);
    let tube = solid::hollow_cylinder(0.5 * R, R, L).unwrap();
    check(&tube, false, 0, [0.0, -2.0 * k]); // the bore is concave
    check(&tube, false, 1, [k, 0.0]);
    let tube = axisymmetric::hollow_cylinder(0.5 * R, R, L).unwrap();
    check(&tube, true, 0, [0.0, -2.0 * k]);
    check(&tube, true, 1, [k, 0.0]);
}

#[test]
fn tributary_areas_are_those_of_the_tied_functions() {
    for case in cases() {
        let (fine, space, faces) = space(&case, 3);
        for face in &faces {
            let areas = tributary_areas(&space, &fine.patches, face);
            assert!(areas.values().all(|&a| a > 0.0));
            assert!(areas.keys().all(|&i| (i as usize) < space.n_functions()));
        }
        let points = greville_points(&space, &fine.patches, &faces);
        let mut functions: Vec<_> = points.iter().filter_map(|p| p.function).collect();
        assert_eq!(functions.len(), points.len());
        functions.sort_unstable();
        let n = functions.len();
        functions.dedup();
        // Points share a function at sharp edges only: none on balls but where the nets meet at edges and poles.
        if case.name == "ball" || case.name == "half-disc" {
            assert_eq!(functions.len(), n, "{}", case.name);
        }
    }
}

#[test]
fn a_closed_seam_gives_no_double_points() {
    let tube = solid::hollow_cylinder(0.5 * R, R, L).unwrap().refined(&[2, 3, 2], &[1, 8, 2], &[]).unwrap();
    let space = PatchSpace::new(tube.patches.clone()).unwrap();
    let outer = Face::outer(&tube.patches, false)[1];
    let points = greville_points(&space, &tube.patches, &[outer]);
    let around = tube.patches[0].knots()[1].n_functions() - 1;
    let along = tube.patches[0].knots()[2].n_functions();
    assert_eq!(points.len(), around * along);
    // Turning by 90 degrees maps the net onto itself, so the seam's areas are those of the other quarter points.
    let near = |x: f64, y: f64| {
        let at = |p: &&CollocationPoint| (p.point[0] - x).abs() + (p.point[1] - y).abs() < 1e-12;
        points.iter().filter(at).map(|p| p.area).collect::<Vec<_>>()
    };
    let (seam, quarter) = (near(R, 0.0), near(0.0, R));
    assert_eq!((seam.len(), quarter.len()), (along, along));
    // Seven or eight Gauss points on an eighth of a turn.
    assert!(seam.iter().zip(&quarter).all(|(a, b)| (a / b - 1.0).abs() < 1e-10), "{seam:?} {quarter:?}");
}

#[test]
fn greville_points_near_a_contact_pole_are_dense_and_ordered() {
    let window = RefinementWindow {
        centre: [0.0, -R, 0.0],
        half_width: [3e-4, 3e-4, 0.0],
        elements: [10, 10, 0],
        ratio: 1.5,
    };
    let shape = axisymmetric::sphere(R).unwrap().refined(&[4, 3], &[8, 8], &[window]).unwrap();
    let space = PatchSpace::new(shape.patches.clone()).unwrap();
    let faces = Face::outer(&shape.patches, true);
    let points = greville_points(&space, &shape.patches, &faces[..1]);
    assert_eq!(points.len(), shape.patches[0].knots()[0].n_functions());
    assert!(points.windows(2).all(|w| w[1].point[0] > w[0].point[0]));
    assert!((points[0].point[1] + R).abs() < 1e-16 && points[0].point[0].abs() < 1e-16);
    assert!(points.iter().filter(|p| p.point[0] < 3e-4).count() >= 10);
    assert!((total(&points) / (2.0 * PI * R * R) - 1.0).abs() < 1e-9);
}

#[test]
fn the_first_point_to_touch_a_plane_is_the_support_point() {
    for case in cases() {
        let surface = BodySurface::new(&case.shape.patches, case.axisymmetric);
        let last = if case.shape.patches[0].dimension() == 3 { 2 } else { 1 };
        let mut n = [0.0; 3];
        n[last] = 1.0;
        let lowest = surface.lowest(&case.shape.patches, &n).unwrap();
        let expected = case.shape.markers["bottom"][last];
        assert!((lowest.measure - expected).abs() < 1e-15, "{} {lowest:?}", case.name);
        let mut below = lowest.point;
        below[last] -= 0.004;
        let closest = surface.closest(&case.shape.patches, &below).unwrap();
        assert!((closest.measure - 0.004).abs() < 1e-15, "{} {closest:?}", case.name);
        let again = surface.closest_from(&case.shape.patches, closest.face, &below, &closest.xi);
        assert!((again.measure - closest.measure).abs() < 1e-16);
    }
}

#[test]
fn greville_points_of_one_level_are_those_of_the_patch_and_areas_sum_up_on_several() {
    use iga_core::hierarchical::{HierarchicalSpace, IndexBox, SubdomainHierarchy};
    let shape = axisymmetric::sphere(0.01).unwrap().refined(&[3, 3], &[4, 4], &[]).unwrap();
    let patches = &shape.patches;
    let faces = Face::outer(patches, true);
    let space = PatchSpace::new(patches.clone()).unwrap();
    let plain = HierarchicalSpace::plain(&patches[0]).unwrap();
    let (mut a, mut b) = (greville_points(&space, patches, &faces), greville_points(&plain, patches, &faces));
    assert_eq!(a.len(), b.len());
    let key = |p: &CollocationPoint| p.point[1];
    a.sort_by(|p, q| key(p).total_cmp(&key(q)));
    b.sort_by(|p, q| key(p).total_cmp(&key(q)));
    for (p, q) in a.iter().zip(&b) {
        assert!((0..2).all(|c| (p.point[c] - q.point[c]).abs() < 1e-14) && (p.area - q.area).abs() < 1e-15);
    }
    let mut levels = SubdomainHierarchy::new(patches[0].knots());
    levels.refine([3, 2, 1], &[IndexBox { lower: [0, 0, 0], upper: [2, 2, 1] }]).unwrap();
    let local = HierarchicalSpace::new(&patches[0], levels).unwrap();
    let points = greville_points(&local, patches, &faces);
    let area: f64 = points.iter().map(|p| p.area).sum();
    let exact = 4.0 * std::f64::consts::PI * 0.01 * 0.01;
    // Gauss rules of degree p + 4 on four coarse elements per quarter circle.
    assert!((area / exact - 1.0).abs() < 1e-9, "{area} and {exact}");
    assert!(points.len() > a.len() && points.iter().all(|p| p.area > 0.0));
}
