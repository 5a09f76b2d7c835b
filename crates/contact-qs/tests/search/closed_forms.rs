//! Distances that are known in closed form.

use contact_qs::search::plane_distance;
use contact_qs::{DofLookup, Plane, SearchWorkspace, SurfaceModel, minimum_distance};
use ffr_dynamics::body::Dof;
use ffr_dynamics::body::RigidMotion::{Axial, Planar, Spatial};
use ffr_dynamics::force::BodyState;
use iga_core::ParameterBox;
use iga_core::hierarchical::{HierarchicalSpace, PatchTies, SubdomainHierarchy};
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};
use iga_core::space::{PatchSpace, Space};
use nalgebra::{UnitQuaternion, Vector3};

use super::bodies::{at, c_shape, random_direction, random_rotation, refined, rigid};
use crate::common::Random;

/// Round-off of coordinates and nets of bodies of size one; the gap itself is second order in errors of the parameters.
const ROUND_OFF: f64 = 1e-13;

fn gap(models: [&SurfaceModel; 2], states: [&BodyState; 2], ws: &mut SearchWorkspace) -> f64 {
    minimum_distance(models, states, ws).unwrap().gap
}

#[test]
fn spheres_of_every_net_have_the_gap_of_their_centres_in_any_pose() {
    let mut random = Random::new(1);
    for net in SphereNet::ALL {
        let models = [1.0, 0.4].map(|r| rigid(Spatial, &sphere::sphere(r, net).unwrap(), 3));
        let mut ws = SearchWorkspace::new();
        for k in 0..40 {
            let direction = random_direction(&mut random);
            // Apart, overlapping, and near touching from both sides.
            let exact = [0.7, 0.01, 1e-6, 1e-10, -1e-10, -1e-6, -0.01, -0.1][k % 8];
            let centre = Vector3::new(3.0, -2.0, 1.0);
            let first = BodyState { rotation: random_rotation(&mut random), ..at(centre.into()) };
            let second = centre - direction * (1.4 + exact);
            let second = BodyState { rotation: random_rotation(&mut random), ..at(second.into()) };
            let found = minimum_distance([&models[0], &models[1]], [&first, &second], &mut ws).unwrap();
            assert!((found.gap - exact).abs() < 20.0 * ROUND_OFF, "{net:?} {exact:e} {found:?}");
            // The direction between points that far apart carries their round-off.
            let turn = 1e-7 + 1e-14 / exact.abs();
            assert!((found.normal - direction).norm() < turn, "{net:?} {exact:e} {found:?}");
            let between = found.normal.dot(&(found.sites[0].point - found.sites[1].point));
            assert!((between - exact).abs() < 20.0 * ROUND_OFF);
        }
    }
}

#[test]
fn depth_is_found_inside_fine_meshes_whose_middle_pieces_cross_nothing() {
    let models = [1.0, 0.8].map(|r| rigid(Spatial, &sphere::sphere(r, SphereNet::Cube).unwrap(), 12));
    let ring = rigid(Axial, &axisymmetric::sphere(0.8).unwrap(), 200);
    let rod = rigid(Axial, &axisymmetric::rod(1.0, 1.0).unwrap(), 200);
    let mut random = Random::new(6);
    for depth in [1e-3, 0.03, 0.15] {
        let axial = [at([0.0, 0.0, 1.8 - depth]), at([0.0; 3])];
        let found = gap([&ring, &rod], [&axial[0], &axial[1]], &mut SearchWorkspace::new());
        assert!((found + depth).abs() < 20.0 * ROUND_OFF, "{depth} {found}");
        // Beside the middle of the coarse mesh's lines.
        let direction = random_direction(&mut random);
        let states = [at([0.0; 3]), at((direction * (1.8 - depth)).into())];
        let found = gap([&models[0], &models[1]], [&states[0], &states[1]], &mut SearchWorkspace::new());
        assert!((found + depth).abs() < 20.0 * ROUND_OFF, "{depth} {found}");
    }
}

#[test]
fn axisymmetric_sphere_touches_the_flat_end_of_a_rod_at_the_axis() {
    let (ball, rod) = (axisymmetric::sphere(0.01).unwrap(), axisymmetric::rod(0.005, 0.3).unwrap());
    let (ball, rod) = (rigid(Axial, &ball, 8), rigid(Axial, &rod, 10));
    let mut ws = SearchWorkspace::new();
    for exact in [0.1, 1e-6, 1e-9, 0.0, -1e-9, -1e-6, -1e-4] {
        let states = [at([0.0, 0.0, 1.0 + 0.3 + 0.01 + exact]), at([0.0, 0.0, 1.0])];
        let found = minimum_distance([&ball, &rod], [&states[0], &states[1]], &mut ws).unwrap();
        // Coordinates of size one.
        assert!((found.gap - exact).abs() < 1e-15, "{exact:e} {found:?}");
        // The parabola is flat within a round-off of 1e-17 m over some 1e-9 m.
        assert!(found.sites.iter().all(|s| s.point.x.abs() < 1e-7), "{found:?}");
        if exact != 0.0 {
            assert!((found.normal - Vector3::z()).norm() < 1e-6, "{exact:e} {found:?}");
        }
    }
}

#[test]
fn a_small_overlap_is_found_from_beside_the_axis() {
    // From the last answer the distance falls along a valley to the circle in which the surfaces cross; with steps that grow by a factor the search for
    // the nearest pair is long, and where it stops early it must not be taken for a gap.
    let (ball, plate) = (axisymmetric::sphere(5e-3).unwrap(), axisymmetric::rod(0.1, 5e-3).unwrap());
    let (ball, plate) = (rigid(Axial, &ball, 10), rigid(Axial, &plate, 40));
    let mut ws = SearchWorkspace::new();
    for k in 1..400 {
        let exact = -1e-8 * f64::from(k);
        let states = [at([0.0, 0.0, 10e-3 + exact]), at([0.0; 3])];
        let found = gap([&ball, &plate], [&states[0], &states[1]], &mut ws);
        assert!((found - exact).abs() < 1e-16, "{exact:e} {found:e}");
    }
}

/// Bodies of plane models meet in their plane and of axisymmetric ones on their axis, wherever both
/// lie in space: round-off out of it changes nothing, more of it is a fault and no gap.
#[test]
fn bodies_meet_in_the_plane_and_on_the_axis_that_they_share() {
    let discs = [1.0, 0.4].map(|r| rigid(Planar, &plane::disc(r).unwrap(), 8));
    let rings = [1.0, 0.4].map(|r| rigid(Axial, &axisymmetric::sphere(r).unwrap(), 8));
    let ways = [Vector3::new(0.6, 0.8, 0.0), Vector3::z()];
    let outs = [[Vector3::z(), -Vector3::z()], [Vector3::x(), Vector3::new(0.6, -0.8, 0.0)]];
    for ((models, way), outs) in [&discs, &rings].into_iter().zip(ways).zip(outs) {
        for exact in [0.3, 1e-6, -1e-6, -0.01] {
            let place = Vector3::new(0.3, -0.2, 0.7);
            let states =
                |out: Vector3<f64>| [at(place.into()), at((place + way * (1.4 + exact) + out).into())];
            let gap_at = |out: Vector3<f64>| {
                let states = states(out);
                let mut ws = SearchWorkspace::new();
                minimum_distance([&models[0], &models[1]], [&states[0], &states[1]], &mut ws)
            };
            for out in outs {
                for size in [0.0, 1e-15, 1e-12, 0.9e-9] {
                    let found = gap_at(out * size).unwrap();
                    assert!((found.gap - exact).abs() < 20.0 * ROUND_OFF, "{size:e} {exact:e} {found:?}");
                    assert!((found.normal + way).norm() < 1e-6, "{size:e} {exact:e} {found:?}");
                }
                for size in [1.1e-9, 1e-3, 0.5] {
                    let fault = gap_at(out * size).unwrap_err().to_string();
                    assert!(fault.contains("must share one"), "{size:e} {fault}");
                }
            }
        }
    }
}

/// Overlapping bodies are searched where the descent for the distance is stationary in the deepest
/// place: there it begins, from the last answer, or from a corner of pieces that lies there.
#[test]
fn every_overlap_is_found_from_anywhere() {
    let turns = [0.0, 0.1, 0.7].map(|t| UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.8, -0.4) * t));
    let aside = [0.0, 1e-6, 1e-4, 1e-3];
    let ball = |r: f64, n| rigid(Spatial, &sphere::sphere(r, SphereNet::Cube).unwrap(), n);
    let disc = |r: f64, n| rigid(Planar, &plane::disc(r).unwrap(), n);
    let axial = |r: f64, n| rigid(Axial, &axisymmetric::sphere(r).unwrap(), n);
    let mut cases = Vec::new();
    for elements in [8, 16, 32] {
        cases.push([ball(5e-3, elements), ball(8e-3, elements)]);
        cases.push([disc(5e-3, elements), disc(8e-3, elements)]);
        cases.push([axial(5e-3, elements), axial(8e-3, elements)]);
    }
    for models in &cases {
        let motion = models[0].motion();
        let mut ws = SearchWorkspace::new();
        for (turn, aside) in turns.iter().flat_map(|turn| aside.map(|aside| (turn, aside))) {
            let (rotation, way) = match motion {
                Axial => (UnitQuaternion::identity(), Vector3::z()),
                Planar => {
                    let angle = UnitQuaternion::from_scaled_axis(Vector3::z() * turn.angle());
                    (angle, Vector3::new(aside, 13e-3, 0.0).normalize())
                }
                Spatial => (*turn, Vector3::new(aside, 13e-3, 0.3 * aside).normalize()),
            };
            for k in 0..40 {
                let depth = 1e-8 * 1.25_f64.powi(k);
                let state = BodyState { rotation, ..at((way * (13e-3 - depth)).into()) };
                for is_fresh in [true, false] {
                    if is_fresh {
                        ws.forget();
                    }
                    let found = gap([&models[0], &models[1]], [&state, &at([0.0; 3])], &mut ws);
                    // The depth is least certain where nets turn against each other; a thousandth
                    // of it is far above, and what is not found is off by all of it.
                    assert!(
                        (found + depth).abs() < 1e-3 * depth + 1e-13,
                        "{motion:?} {} pieces, {aside} {} {is_fresh}: {depth:e} {found:e}",
                        models[0].n_pieces(),
                        turn.angle()
                    );
                }
            }
        }
    }
}

/// A C with both tips in a bar, which tilts: the deepest place changes from one tip to the other,
/// where the search from the last answer does not begin. The bar is lifted by a mode.
#[test]
fn the_deeper_of_two_overlaps_is_found() {
    let c = rigid(Planar, &c_shape(1.0, 1.2), 3);
    let space = PatchSpace::new(refined(&plane::rectangle(4.0, 0.2).unwrap(), 5)).unwrap();
    let dof = |k: usize| Dof { node: (k / 2) as u32, component: (k % 2) as u8 };
    let dofs: Vec<Dof> = (0..2 * space.n_functions()).map(dof).collect();
    let lift = faer::Mat::from_fn(dofs.len(), 1, |k, _| (k % 2) as f64);
    let bar =
        SurfaceModel::new(Planar, space.patches(), &space, &DofLookup::new(&dofs), lift.as_ref()).unwrap();
    let top = space.control_points().iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
    let tip = 1.2 * std::f64::consts::FRAC_1_SQRT_2;
    let mut ws = SearchWorkspace::new();
    for lifted in [0.05, -0.05, 0.0] {
        for k in 0..20 {
            let tilt = f64::from(k) * if k % 2 == 0 { 1e-4 } else { -1e-4 };
            // The opening looks down.
            let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, tilt - std::f64::consts::FRAC_PI_2);
            let height = top + lifted + tip - 5e-3;
            let states = [
                BodyState { rotation: turn, ..at([0.3, height, 0.0]) },
                BodyState { elastic: vec![lifted], elastic_rates: vec![0.0], ..at([0.0; 3]) },
            ];
            let corners = [tip, -tip].map(|y| height + (turn * Vector3::new(tip, y, 0.0)).y);
            let exact = corners[0].min(corners[1]) - top - lifted;
            for is_fresh in [false, true] {
                if is_fresh {
                    ws.forget();
                }
                let found = gap([&c, &bar], [&states[0], &states[1]], &mut ws);
                assert!(
                    (found - exact).abs() < 10.0 * ROUND_OFF,
                    "{tilt} {lifted} {is_fresh}: {found} {exact}"
                );
                let found = gap([&bar, &c], [&states[1], &states[0]], &mut SearchWorkspace::new());
                assert!((found - exact).abs() < 10.0 * ROUND_OFF, "{tilt} {lifted}: {found} {exact}");
            }
        }
    }
}

#[test]
fn hierarchical_ball_that_swells_keeps_its_closed_form() {
    let patch = refined(&axisymmetric::sphere(1.0).unwrap(), 6).remove(0);
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    let ties = PatchTies::detect(&patch);
    let region = ParameterBox { lower: [0.45, 0.9, 0.0], upper: [0.55, 1.0, 0.0] };
    let boxes = hierarchy.elements_around(&[region], [2, 2, 0], &ties).unwrap();
    hierarchy.refine([3, 2, 1], &boxes).unwrap();
    let space = HierarchicalSpace::new(&patch, hierarchy).unwrap();
    assert!(space.n_elements() > patch.n_elements());
    // The one mode moves every control point outwards in proportion: the radius grows by the coordinate.
    let dof = |k: usize| Dof { node: (k / 2) as u32, component: (k % 2) as u8 };
    let dofs: Vec<Dof> = (0..2 * space.n_functions()).map(dof).collect();
    let shapes = faer::Mat::from_fn(dofs.len(), 1, |k, _| space.control_points()[k / 2][k % 2]);
    let patches = [patch];
    let ball = SurfaceModel::new(Axial, &patches, &space, &DofLookup::new(&dofs), shapes.as_ref()).unwrap();
    let ring = rigid(Axial, &axisymmetric::hollow_cylinder(0.6, 0.9, 0.5).unwrap(), 4);
    let mut ws = SearchWorkspace::new();
    for q in [-0.1, 0.0, 1e-3, 0.05] {
        let state = BodyState { elastic: vec![q], elastic_rates: vec![0.0], ..at([0.0, 0.0, 1.4]) };
        let exact = f64::hypot(0.6, 0.9) - (1.0 + q);
        let found = gap([&ball, &ring], [&state, &at([0.0; 3])], &mut ws);
        assert!((found - exact).abs() < 10.0 * ROUND_OFF, "{q}: {found} {exact}");
        // The bodies change their roles.
        let swapped = gap([&ring, &ball], [&at([0.0; 3]), &state], &mut SearchWorkspace::new());
        assert!((swapped - exact).abs() < 10.0 * ROUND_OFF, "{q}: {swapped} {exact}");
    }
}

#[test]
fn ball_on_a_hollow_cylinder_touches_its_inner_edge() {
    let (ball, ring) = (axisymmetric::sphere(1.0).unwrap(), axisymmetric::hollow_cylinder(0.6, 0.9, 0.5));
    let (ball, ring) = (rigid(Axial, &ball, 6), rigid(Axial, &ring.unwrap(), 4));
    let mut ws = SearchWorkspace::new();
    for height in [2.0, 1.0, 0.8 + 1e-9, 0.8 - 1e-9, 0.799] {
        let states = [at([0.0, 0.0, 0.5 + height]), at([0.0; 3])];
        let exact = f64::hypot(0.6, height) - 1.0;
        let found = gap([&ball, &ring], [&states[0], &states[1]], &mut ws);
        assert!((found - exact).abs() < 10.0 * ROUND_OFF, "{height}: {found} {exact}");
    }
}

#[test]
fn ball_in_the_bore_of_a_solid_ring_is_apart_until_it_reaches_the_wall() {
    let ring = rigid(Spatial, &solid::hollow_cylinder(1.0, 1.3, 2.0).unwrap(), 2);
    let ball = rigid(Spatial, &sphere::sphere(0.3, SphereNet::Cube).unwrap(), 2);
    let mut random = Random::new(5);
    let mut ws = SearchWorkspace::new();
    for _ in 0..40 {
        let angle = 3.0 * random.next();
        let offset = 0.35 + 0.355 * random.next().abs();
        let z = 1.0 + 0.3 * random.next();
        let turn = random_rotation(&mut random);
        let here = Vector3::new(offset * angle.cos(), offset * angle.sin(), z);
        let ball_state = BodyState { rotation: random_rotation(&mut random), ..at((turn * here).into()) };
        let ring_state = BodyState { rotation: turn, ..at([0.0; 3]) };
        let found = gap([&ball, &ring], [&ball_state, &ring_state], &mut ws);
        assert!((found - (0.7 - offset)).abs() < 20.0 * ROUND_OFF, "{found} {}", 0.7 - offset);
    }
}

#[test]
fn disc_in_a_plane_c_finds_the_arc_or_the_tips() {
    let (c, disc) = (rigid(Planar, &c_shape(1.0, 1.2), 2), rigid(Planar, &plane::disc(0.25).unwrap(), 2));
    let mut random = Random::new(8);
    let mut ws = SearchWorkspace::new();
    let tip = std::f64::consts::FRAC_1_SQRT_2;
    for _ in 0..200 {
        let (r, angle) = (0.74 * random.next().abs(), 3.0 * random.next());
        let centre = Vector3::new(r * angle.cos(), r * angle.sin(), 0.0);
        // Within the opening only the tips' inner corners are near.
        let is_open = angle.abs() < std::f64::consts::FRAC_PI_4;
        let corners = [1.0, -1.0].map(|s| (centre - Vector3::new(tip, s * tip, 0.0)).norm()).into_iter();
        let corner = corners.fold(f64::INFINITY, f64::min);
        let exact = if is_open { corner - 0.25 } else { 1.0 - r - 0.25 };
        let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, 3.0 * random.next());
        let states = [at((turn * centre).into()), BodyState { rotation: turn, ..at([0.0; 3]) }];
        let found = gap([&disc, &c], [&states[0], &states[1]], &mut ws);
        assert!((found - exact).abs() < 10.0 * ROUND_OFF, "{centre:?} {found} {exact}");
    }
}

#[test]
fn parallel_faces_have_their_distance_in_any_turn() {
    let (a, b) = (solid::cuboid([1.0, 1.0, 0.2]).unwrap(), solid::cuboid([0.8, 0.5, 0.3]).unwrap());
    let (a, b) = (rigid(Spatial, &a, 6), rigid(Spatial, &b, 6));
    let top = a.size(); // far away first
    let mut ws = SearchWorkspace::new();
    let mut random = Random::new(2);
    for exact in [top, 0.3, 1e-3, 1e-9, -1e-9, -1e-3] {
        // Boxes are centred or start at a corner, whatever the primitive does: measured with planes.
        let face = |model: &SurfaceModel, up: Vector3<f64>| {
            let plane = Plane { point: Vector3::zeros(), normal: nalgebra::Unit::new_normalize(up) };
            plane_distance(model, &at([0.0; 3]), &plane, &mut SearchWorkspace::new()).unwrap().gap
        };
        let (high, low) = (-face(&a, -Vector3::z()), face(&b, Vector3::z()));
        let whole = random_rotation(&mut random);
        let yaw = UnitQuaternion::from_euler_angles(0.0, 0.0, random.next());
        let lower = BodyState { rotation: whole, ..at([0.0; 3]) };
        let place = whole * Vector3::new(0.05, 0.02, high - low + exact);
        let upper = BodyState { rotation: whole * yaw, ..at(place.into()) };
        let found = gap([&b, &a], [&upper, &lower], &mut ws);
        assert!((found - exact).abs() < 10.0 * ROUND_OFF, "{exact:e} {found:e}");
        assert!(ws.report().n_newton < 50, "{exact:e} {:?}", ws.report());
    }
}

#[test]
fn plane_gap_is_the_height_of_the_lowest_point() {
    let mut random = Random::new(11);
    let mut ws = SearchWorkspace::new();
    let ball = rigid(Spatial, &sphere::sphere(0.5, SphereNet::Cube).unwrap(), 2);
    for _ in 0..30 {
        let n = random_direction(&mut random);
        let plane = Plane { point: Vector3::new(1.0, 2.0, 3.0), normal: nalgebra::Unit::new_normalize(n) };
        let height = 2.0 * random.next();
        let state = BodyState {
            rotation: random_rotation(&mut random),
            ..at((plane.point + n * height + n.cross(&Vector3::x())).into())
        };
        let found = plane_distance(&ball, &state, &plane, &mut ws).unwrap();
        assert!((found.gap - (height - 0.5)).abs() < 10.0 * ROUND_OFF);
        let at_site = plane.normal.dot(&(found.site.point - plane.point));
        assert!((at_site - found.gap).abs() < 10.0 * ROUND_OFF);
    }
}
