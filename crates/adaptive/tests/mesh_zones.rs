//! Fine models of bodies of finite elements: what they keep of the mesh, and the smooth surface that contact sees in place of its sides.

use crate::blocks;
use std::f64::consts::TAU;
use std::sync::Arc;

use crate::balls::Ball;
use adaptive::body::field::Field;
use adaptive::body::field_body::FieldBody;
use adaptive::body::fine::divided::{FineElements, WantedZone};
use adaptive::body::mesh::MeshedBody;
use adaptive::body::reduced::Interface;
use adaptive::body::zone::{ContactZone, PointsAbout, WholeRequest};
use adaptive::record::{TargetPlace, TouchedPart};
use adaptive::sizing::impact_time::{ForceTime, TimeScale};
use adaptive::sizing::of_mesh;
use adaptive::spec::{Accuracy, FlexibleSpec, MeshedSpec, ReductionSpec};
use adaptive::store::ModelCache;
use adaptive::surface::smooth_fit::SmoothFit;
use adaptive::surface::{MeshSurface, Surface, SurfacePlace};
use adaptive::touch::detection::Nearest;
use adaptive::touch::parts::Touch;
use contact_qs::search::SurfaceSite;
use fe_mesh::element::rules::MassRule;
use fe_mesh::{ElementKind, Mesh};
use ffr_dynamics::force::BodyState;
use ffr_dynamics::reduction::problem::ElasticProblem;
use iga_core::elasticity::Material;
use iga_core::nurbs::jet::{difference, norm};
use nalgebra::Vector3;

/// Ten elements across.
const TEN: Ball = Ball { radius: 10.0, across: [6, 6], layers: 2, growth: [1.0, 1.0] };

fn spec(mesh: Mesh) -> MeshedSpec {
    MeshedSpec {
        mesh: Arc::new(mesh),
        material: Some(Material::new(72.8e9, 0.33, 2789.0).unwrap()),
        groups: Vec::new(),
        mass_rule: MassRule::Exact,
        flexible: FlexibleSpec {
            static_answers: false,
            ..FlexibleSpec::new(ReductionSpec::Modal { modes: 8 })
        },
    }
}

fn site(mesh: &Arc<Mesh>, point: [f64; 3]) -> (Arc<MeshSurface>, SurfacePlace) {
    let surface = MeshSurface::of(mesh);
    let site = surface.nearest(&point).unwrap().place;
    (surface, site)
}

#[test]
fn no_modes_are_chosen_that_a_mesh_does_not_carry() {
    let cube = |n: usize, modes: usize| {
        let mesh = blocks::block(ElementKind::Tet10, [n; 3], |x| x.map(|x| 0.01 * x));
        let mut spec = spec(Mesh::new(mesh, 1.0).unwrap());
        spec.flexible.reduction = ReductionSpec::Modal { modes };
        spec
    };
    let force = ForceTime {
        contact: "c".into(),
        scale: TimeScale::Flat,
        duration: 7e-6,
        speed: 0.1,
        frequency: 1.5e6,
    };
    let chosen = |n: usize| {
        of_mesh::modes("cube", &cube(n, 0), Accuracy::default(), Some(&force), &ModelCache::default())
            .unwrap()
    };
    let [coarse, fine] = [2, 4].map(chosen);
    let carried = coarse.carried.expect("the coarse mesh carries less than is asked for");
    assert!(
        coarse.modes < fine.modes && coarse.highest.is_some_and(|highest| highest <= carried),
        "{coarse:?} {fine:?}"
    );
    assert!(coarse.to_string().contains("its mesh carries waves up to"), "{coarse}");
    let frequencies = |n: usize| {
        let body = MeshedBody::build("cube", cube(n, coarse.modes)).unwrap();
        (body.reduce(&Interface::default()).unwrap().basis.omega, body.carried_waves().unwrap())
    };
    let ((found, waves), (finer, _)) = (frequencies(2), frequencies(4));
    // The estimate of the highest mode is no less than what a mesh of half the sides shows; by the longest
    // edges of six tetrahedra in a cube, its diagonal, less than ten times as much.
    let error = found[coarse.modes - 1] / finer[coarse.modes - 1] - 1.0;
    let estimate = waves.error(found[coarse.modes - 1] / TAU).unwrap().0;
    println!("{} modes, error {error:.4}, estimate {estimate:.4}, carried {carried:.3e} Hz", coarse.modes);
    assert!(error < estimate && estimate < 10.0 * error, "{error} {estimate}");
}

#[test]
fn modes_of_a_mesh_are_modes_of_its_pieces_with_the_same_frequencies() {
    // Straight-sided, so that both meshes are integrated exactly.
    let mesh = blocks::block(ElementKind::Tet10, [3, 2, 1], |x| [0.03 * x[0], 0.02 * x[1], 0.02 * x[2]]);
    let spec = spec(Mesh::new(mesh, 1.0).unwrap());
    let (_, at) = site(&spec.mesh, [0.015, 0.0104, 0.02]);
    let wanted = WantedZone { sites: vec![at], widths: [8e-3, 4e-3], elements: None, across: [0.0; 3] };
    let body = Arc::new(MeshedBody::build("block", spec).unwrap());
    let fine = FineElements::build(&body, wanted).unwrap();
    let basis = body.reduce(&Interface::default()).unwrap().basis;
    let assembled = fine.assembled().unwrap();
    let shapes = fine.prolonged(basis.shapes.as_ref());
    let problem = ElasticProblem::free(&assembled, &[]).unwrap();
    let energies = shapes.transpose() * problem.stiffness_product(shapes.as_ref());
    for (i, omega) in basis.omega.iter().enumerate() {
        for (j, other) in basis.omega.iter().enumerate() {
            let wanted = if i == j { omega * omega } else { 0.0 };
            // The eigensolver leaves 1e-10 of the largest of a few eigenvalues.
            assert!(
                (energies[(i, j)] - wanted).abs() < 1e-8 * omega * other,
                "{i} {j}: {}",
                energies[(i, j)]
            );
        }
    }
    // Sides of the zone and their ring are of the finest level, with free nodes: at least six across the narrower width.
    let zone = fine.contact_zone().unwrap();
    let near = zone.points.iter().filter(|p| (p.position[1] - at.point[1]).abs() < 2e-3);
    let near: Vec<_> = near.filter(|p| (p.position[0] - at.point[0]).abs() < 0.4e-3).collect();
    assert!(near.len() > 6, "{}", near.len());
    assert!(zone.points.iter().any(|p| p.on_rim) && zone.points.iter().any(|p| !p.on_rim));
    assert!(zone.unknowns.iter().all(|&u| u < fine.n_unknowns()));
}

#[test]
fn zones_at_both_ends_of_a_ball_lie_on_spheres_as_far_outside_as_its_sides() {
    let spec = spec(Mesh::new(TEN.mesh(ElementKind::Tet10), 1e-3).unwrap());
    let sites = [-1.0, 1.0].map(|z| site(&spec.mesh, [0.3e-3, 0.2e-3, z * 10e-3]));
    let body = Arc::new(MeshedBody::build("ball", spec).unwrap());
    let places = sites.iter().map(|(_, place)| *place).collect();
    let fine = FineElements::build(
        &body,
        WantedZone { sites: places, widths: [1e-3; 2], elements: None, across: [0.0; 3] },
    );
    let fine = fine.unwrap();
    let zone = fine.contact_zone().unwrap();
    // What lies in another body at the start is moved inwards there.
    let mut inwards = zone.clone();
    fine.move_out(&mut inwards, -1e-6);
    assert!(fine.most_outwards().is_some_and(|most| most.abs() < f64::MIN_POSITIVE));
    for (before, after) in zone.points.iter().zip(&inwards.points) {
        let moved = difference(&after.position, &before.position);
        // Along the normal at the place, where the smooth surface leans by 0.05 at most.
        let height = moved[2] * before.position[2].signum();
        assert!((norm(&moved) - 1e-6).abs() < 1e-15 && (height + 1e-6).abs() < 2e-9, "{moved:?}");
    }
    let is_inner = |rows: &[usize; 2]| rows.iter().all(|row| (1..15).contains(row));
    for (surface, site) in &sites {
        let shape = surface.shape_at(site).unwrap();
        let fit = SmoothFit::new(surface, (site, &shape), 0.5e-3, |_| false).unwrap();
        let own =
            zone.points.iter().zip(fine.rows_of(&zone)).filter(|(p, _)| p.position[2] * site.point[2] > 0.0);
        let from = |x: [f64; 3]| Vector3::from(x) - Vector3::from(site.point);
        let heights: Vec<_> =
            own.map(|(p, rows)| (shape.normal.dot(&from(p.position)), rows, p.position)).collect();
        // The outmost point is as far outside as the sides at the place.
        let outmost = heights.iter().map(|(height, ..)| *height).fold(f64::NEG_INFINITY, f64::max);
        assert!(outmost.abs() < 1e-15, "{outmost:e}");
        // All lie on the surface through the nodes, but for a shift along the normal: round-off of places. It is the error of sides of 6 mm,
        // L^4/512 R^3 at most.
        let beyond = |x: [f64; 3], shift: f64| fit.above(&(Vector3::from(x) + shift * shape.normal).into());
        // Against the normal there the one at the place leans by 0.05 at most: each step leaves 1e-3 of the error.
        let shift = (0..6).fold(0.0, |shift, _| shift + beyond(heights[0].2, shift));
        assert!(
            heights.iter().all(|(.., x)| beyond(*x, shift).abs() < 1e-15) && shift.abs() < 2.6e-6,
            "{shift:e}"
        );
        // Rows are those about this place.
        let inner = heights.iter().filter(|(.., rows, _)| is_inner(rows)).map(|(.., x)| from(*x).norm());
        assert!(inner.fold(0.0, f64::max) < 0.5 * 14.0 / 16.0 * 1.42e-3);
        assert!(heights.iter().any(|(.., rows, _)| *rows == [7, 7] || *rows == [8, 8]));
    }
}

#[test]
fn a_part_of_a_surface_holds_the_sides_that_are_touched_however_they_bend() {
    let mesh = Arc::new(Mesh::new(TEN.mesh(ElementKind::Tet10), 1e-3).unwrap());
    let (surface, place) = site(&mesh, [1.1e-3, 0.7e-3, 10e-3]);
    let outward = surface.normal(&place).into();
    let target = TargetPlace { normal: [0.0, 0.0, -1.0], ..TargetPlace::default() };
    // A side of 2 mm bends away by 50 um.
    for (depth, meets) in [(1e-6, None), (1e-6, Some(target)), (1e-4, None), (1e-4, Some(target))] {
        let part = Some(TouchedPart { origin: place.point, outward, depth, radius: 1e-4 });
        let request = WholeRequest { about: Some(PointsAbout { place, meets }), part };
        let zone = ContactZone::whole_mesh(&surface, &request).unwrap();
        let is_held = |n: u32| surface.unknowns_at(n).all(|u| zone.unknowns.binary_search(&u).is_ok());
        assert!(zone.points.iter().all(|p| p.area > 0.0 && p.functions.iter().all(|f| is_held(f.0))));
        assert!(zone.points.iter().any(|p| norm(&difference(&p.position, &place.point)) < 1e-12));
        assert_eq!(zone.meeting.len(), usize::from(meets.is_some()));
    }
    // Of a target nothing but the part is known: nodes of its side lie deeper than 1 um.
    let part = Some(TouchedPart { origin: place.point, outward, depth: 1e-6, radius: f64::INFINITY });
    let zone = ContactZone::whole_mesh(&surface, &WholeRequest { about: None, part }).unwrap();
    let nodes = &surface.sides()[place.face as usize].nodes;
    assert!(
        nodes.iter().flat_map(|n| surface.unknowns_at(*n)).all(|u| zone.unknowns.binary_search(&u).is_ok())
    );
}

#[test]
fn a_line_in_a_bore_has_a_strip_from_edge_to_edge_on_the_cylinder() {
    // Half of an eye of 24 and 34 mm, 8 mm thick, the line in the midst of it.
    let eye = |[x, y, z]: [f64; 3]| {
        let (angle, radius) = ((0.5 + x) * 0.5 * TAU, 34.0 - 10.0 * y);
        [radius * angle.cos(), radius * angle.sin(), 8.0 * z]
    };
    for (kind, off) in [(ElementKind::Hex20, 0.0), (ElementKind::Tet10, 0.3e-3)] {
        let spec = spec(Mesh::new(blocks::block(kind, [5, 2, 2], eye), 1e-3).unwrap());
        let (surface, at) = site(&spec.mesh, [-24e-3, off, 4e-3]);
        let shape = surface.shape_at(&at).unwrap();
        // Sides of 15 mm on the radius of 24 mm have other curvatures; the rest is round-off of places of 34 mm.
        let [along, across] = shape.curvatures;
        assert!(along.abs() < 1e-9 && (across * 24e-3 + 1.0).abs() < 1e-10, "{along:e} {across}");
        let widths = [2.0 * surface.length(), 3e-3];
        let wanted = WantedZone { sites: vec![at], widths, elements: None, across: [0.0; 3] };
        let estimate = wanted.interface(&surface);
        // A strip that bends away by more than twenty degrees, and a line over a surface of no known shape, keep the sides.
        assert!(
            WantedZone { widths: [widths[0], 20e-3], ..wanted.clone() }.interface(&surface).is_infinite()
        );
        let fine = FineElements::build(&Arc::new(MeshedBody::build("eye", spec).unwrap()), wanted).unwrap();
        let zone = fine.contact_zone().unwrap();
        let unknowns = zone.unknowns.len() as f64;
        // Tetrahedra are counted by halving them: it is known that they are few.
        let (low, high) =
            if kind == ElementKind::Tet10 { (0.0, 0.0) } else { (unknowns / 1.6, unknowns / 0.6) };
        assert!((low..=high).contains(&estimate), "{kind:?}: {unknowns} for {estimate}");
        assert_eq!(fine.rows().n_elements, [1, 16]);
        let ends = zone.points.iter().map(|p| p.position[2]);
        let (low, high) = ends.fold((f64::INFINITY, 0.0_f64), |(a, b), z| (a.min(z), b.max(z)));
        assert!(low < 0.5e-3 && high > 7.5e-3, "{low} {high}");
        // On the cylinder, shifted along the normal at the place: the sides err by 1/512 L^4/R^3 at most, 7 um.
        let height = |x: &[f64; 3], shift: f64| {
            let [x, y] = [0, 1].map(|d| x[d] + shift * shape.normal[d]);
            24e-3 - x.hypot(y)
        };
        let first = &zone.points[0].position;
        let shift = (0..6).fold(0.0, |shift, _| shift - height(first, shift));
        let errors = zone.points.iter().map(|p| height(&p.position, shift).abs());
        assert!(errors.fold(0.0, f64::max) < 1e-13 && shift.abs() < 8e-6, "{kind:?}: {shift:e}");
    }
    let wave = |[x, y, z]: [f64; 3]| [34.0 * x, 8.0 * y, 10.0 * z + (4.0 * x).cos()];
    let mesh = Arc::new(Mesh::new(blocks::block(ElementKind::Hex20, [5, 2, 2], wave), 1e-3).unwrap());
    let (surface, at) = site(&mesh, [17e-3, 4e-3, 10e-3]);
    let along = usize::from(surface.shape_at(&at).unwrap().tangents[1][1].abs() > 0.9);
    let mut widths = [3e-3; 2];
    widths[along] = 2.0 * surface.length();
    let wanted = WantedZone { sites: vec![at], widths, elements: None, across: [0.0; 3] };
    assert!(wanted.interface(&surface).is_infinite());
}

#[test]
fn zones_of_tetrahedra_have_the_elements_that_their_ellipse_asks_for() {
    let ball = Arc::new(Mesh::new(TEN.mesh(ElementKind::Tet10), 1e-3).unwrap());
    let plate = |[x, y, z]: [f64; 3]| [20.0 * x, 20.0 * y, 5.0 * z];
    let plate = Arc::new(Mesh::new(blocks::block(ElementKind::Tet10, [3, 3, 1], plate), 1e-3).unwrap());
    let on_plate = [10.7e-3, 9.1e-3, 5e-3];
    let pieces = |mesh: &Arc<Mesh>, point: [f64; 3], widths: [f64; 2], elements: Option<usize>| {
        let (surface, at) = site(mesh, point);
        let wanted = WantedZone { sites: vec![at], widths, elements, across: [1.0, 0.0, 0.0] };
        let estimate = wanted.interface(&surface);
        let spec = MeshedSpec { mesh: Arc::clone(mesh), ..spec(Mesh::clone(mesh)) };
        let fine = FineElements::build(&Arc::new(MeshedBody::build("part", spec).unwrap()), wanted).unwrap();
        let divided = fine.divided();
        assert_eq!(fine.n_unknowns(), 3 * divided.nodes().len(), "nothing is tied");
        // Edges of sides on the ellipse, in units of the lengths of which five, or as many as asked for, lie across it.
        let m = elements.unwrap_or(5) as f64;
        let share = |x: &Vector3<f64>, by: f64| (by * x[0] / widths[0]).hypot(by * x[1] / widths[1]);
        let mut lengths = Vec::new();
        for side in MeshSurface::of(divided).sides() {
            let corner = |k: usize| Vector3::from(divided.nodes()[side.nodes[k] as usize]);
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let from = 0.5 * (corner(a) + corner(b)) - Vector3::from(at.point);
                if from[2].abs() < 1e-3 && share(&from, 2.0) < 1.0 {
                    lengths.push(share(&(corner(b) - corner(a)), m));
                }
            }
        }
        let longest = lengths.iter().fold(0.0_f64, |most, length| most.max(*length));
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        // All are halved that are longer: a right angle with equal legs has a mean of 0.8 at most, and the half of that on the way.
        // Where two lengths differ by ten, edges that lean are halved in both directions.
        assert!(longest < 1.0 + 1e-12 && mean > 0.4 && mean < 0.81, "{widths:?}: {longest} {mean}");
        // One row of the ring more or less is a third of them.
        let ratio = fine.contact_zone().unwrap().unknowns.len() as f64 / estimate;
        assert!((0.5..2.0).contains(&ratio), "{widths:?}: {ratio} of {estimate}");
        divided.elements().len() - mesh.elements().len()
    };
    let whole = [0.3e-3, 0.2e-3, 10e-3];
    let [few, many] = [None, Some(10)].map(|elements| pieces(&ball, whole, [0.6e-3; 2], elements));
    assert!(many > 2 * few, "{few} {many}");
    // An ellipse that is ten times as long as wide has less than half as many more; halved widths add as many each time.
    let [round, long, narrow, finer] =
        [[0.5e-3, 0.5e-3], [0.5e-3, 5e-3], [0.25e-3, 2.5e-3], [0.125e-3, 1.25e-3]]
            .map(|widths| pieces(&plate, on_plate, widths, None));
    assert!(long < 3 * round / 2 && 2 * finer < 3 * narrow, "{round} {long} {narrow} {finer}");
}

#[test]
fn a_line_on_a_plane_has_a_strip_along_it_whatever_its_direction() {
    let plate = |[x, y, z]: [f64; 3]| [20.0 * x, 20.0 * y, 5.0 * z];
    let mut counts = Vec::new();
    for (angle, width) in [(0.0, 40e-6), (0.6, 40e-6), (0.6, 20e-6)] {
        let spec = spec(Mesh::new(blocks::block(ElementKind::Tet10, [3, 3, 1], plate), 1e-3).unwrap());
        let (surface, at) = site(&spec.mesh, [10.7e-3, 9.1e-3, 5e-3]);
        let across = [f64::cos(angle), f64::sin(angle), 0.0];
        let widths = [width, 2.0 * surface.length()];
        let wanted = WantedZone { sites: vec![at], widths, elements: None, across };
        // A line 500 times as long as its zone is wide keeps its sides if nobody asks; one of 20 times is divided.
        let wide = WantedZone { widths: [1e-3, widths[1]], ..wanted.clone() };
        assert!(
            wanted.interface(&surface).is_infinite() && wide.interface(&surface) == 0.0,
            "{angle} {width:e}"
        );
        let fine = FineElements::build(&Arc::new(MeshedBody::build("plate", spec).unwrap()), wanted).unwrap();
        let zone = fine.contact_zone().unwrap();
        // Along the whole line, a few times 20 um across it: the strip and a ring of sides.
        let from = |p: &[f64; 3]| [p[0] - at.point[0], p[1] - at.point[1]];
        let places: Vec<[f64; 2]> = zone.points.iter().map(|p| from(&p.position)).collect();
        let most =
            |way: [f64; 2]| places.iter().map(|x| (x[0] * way[0] + x[1] * way[1]).abs()).fold(0.0, f64::max);
        let [x, y, _] = across;
        assert!(most([x, y]) < 3.0 * width && most([-y, x]) > 8e-3, "{} {}", most([x, y]), most([-y, x]));
        assert_eq!(fine.rows().n_elements, [16, 1]);
        counts.push(zone.points.len());
    }
    // Half the width has twice as many points where pieces are halved in both directions along the surface; here less.
    assert!(10 * counts[2] < 18 * counts[1], "{counts:?}");
}

#[test]
fn contact_of_a_coarse_ball_sees_a_sphere() {
    for kind in [ElementKind::Hex20, ElementKind::Tet10] {
        let mesh = Arc::new(Mesh::new(TEN.mesh(kind), 1e-3).unwrap());
        // A node, and a place with nothing of its own.
        for direction in [[0.0, 0.0, -1.0], [0.17, -0.11, -0.97924_f64]] {
            let (surface, at) = site(&mesh, direction.map(|x| 10e-3 * x));
            let shape = surface.shape_at(&at).unwrap();
            let fit = SmoothFit::new(&surface, (&at, &shape), 1e-3, |_| false).unwrap();
            let normal = shape.normal;
            let height = |along: f64| {
                let x = Vector3::from(at.point) + along * shape.tangents[0];
                let x: [f64; 3] = (x + fit.above(&x.into()) * normal).into();
                x.iter().map(|c| c * c).sum::<f64>().sqrt()
            };
            // Nodes reach half the radius R away. The sphere's term of sixth order is 1/8 of (1/2)^4 of the one of second order there, of which polynomials of
            // degree four leave 1/32, 2.4e-4; curvature in the middle errs by some ten times as much. Sides err by 2e-2, or have a cusp.
            for along in [-0.5e-3, -0.2e-3, 0.2e-3, 0.5e-3] {
                let sag = along * along / 20e-3;
                let lean = 0.5 * (height(along) - height(-along));
                let error = height(along) - height(0.0) - lean;
                assert!(error.abs() < 8e-3 * sag, "{kind:?}: {error:e} of {sag:e}");
                // The normal of the side at the place is not that of the sphere, and the frame leans by as much.
                assert!(lean.abs() < 0.01 * along.abs(), "{kind:?}: {lean:e}");
            }
        }
    }
}

#[test]
fn curvatures_of_a_coarse_surface_are_those_of_circles() {
    // A ring with an elliptic tube, sides of 20 by 40 degrees: no simple shape. A paraboloid through the nodes beside the
    // one at the place, 60 degrees away, is curved by 1.38 and 1.11 times as much.
    let (ring, half, other) = (10.0, 4.0, 4.2);
    let tube = |[x, y, z]: [f64; 3]| {
        let (around, along, depth) =
            ((x - 0.5) * 0.5 * TAU / 3.0, (y - 0.5) * 200.0_f64.to_radians(), 0.5 + 0.5 * z);
        let away = ring + half * depth * along.cos();
        [away * around.cos(), away * around.sin(), other * depth * along.sin()]
    };
    for kind in [ElementKind::Hex20, ElementKind::Tet10] {
        let mesh = Arc::new(Mesh::new(blocks::block(kind, [3, 5, 1], tube), 1e-3).unwrap());
        let (surface, at) = site(&mesh, [14.001e-3, 0.0, 0.0]);
        let [along, around] = surface.shape_at(&at).unwrap().curvatures.map(|k| 1e-3 * k);
        let [wanted, other] = [half / (other * other), 1.0 / (ring + half)];
        assert!(
            (along / wanted - 1.0).abs() < 0.06 && (around / other - 1.0).abs() < 0.06,
            "{kind:?}: {along} {around}"
        );
    }
}

#[test]
fn a_fillet_of_one_side_between_faces_is_seen_as_the_cylinder_that_it_is() {
    // Two plates at a right angle, their outer edge rounded with 3 mm, a side of 45 degrees each.
    let bent = |[x, y, z]: [f64; 3]| {
        let (x, depth) = (6.0 * x, 2.0 * (1.0 - z));
        let angle = 0.125 * TAU * (x - 2.0).clamp(0.0, 2.0);
        let (s, c) = angle.sin_cos();
        let beyond = (x - 4.0).max(0.0);
        [4.0 * x.min(2.0) + (3.0 - depth) * s, 15.0 * y, (3.0 - depth) * c - 4.0 * beyond]
    };
    for kind in [ElementKind::Hex20, ElementKind::Tet10] {
        let mesh = Arc::new(Mesh::new(blocks::block(kind, [6, 3, 1], bent), 1e-3).unwrap());
        let (sin, cos) = (0.1875 * TAU).sin_cos();
        let (surface, at) = site(&mesh, [8.0 + 3.0 * sin, 7.4, 3.0 * cos].map(|x| 1e-3 * x));
        let shape = surface.shape_at(&at).unwrap();
        let [across, along] = shape.curvatures;
        // Round-off of places of 10 mm over the height of 0.2 mm of a side.
        assert!(
            (3e-3 * across - 1.0).abs() < 1e-9 && along.abs() < 1e-6,
            "{kind:?}: {across} {along} at {at:?}"
        );
        let is_within = |x: &[f64; 3]| norm(&difference(x, &at.point)) <= 0.3e-3;
        let fit = SmoothFit::new(&surface, (&at, &shape), 0.3e-3, is_within).unwrap();
        for angle in [0.1825, 0.1875, 0.19] {
            let (sin, cos) = (angle * TAU).sin_cos();
            let on = [8.0 + 3.0 * sin, 7.5, 3.0 * cos].map(|x| 1e-3 * x);
            assert!(fit.above(&on).abs() < 1e-14, "{kind:?} {angle}: {:e}", fit.above(&on));
        }
    }
}

#[test]
fn coarse_parts_touch_where_their_shapes_are_nearest() {
    let mesh = Arc::new(Mesh::new(TEN.mesh(ElementKind::Tet10), 1e-3).unwrap());
    let (surface, radius, gap) = (MeshSurface::of(&mesh), 10e-3, 1e-4);
    let here = BodyState::at_rest(0);
    let mut farthest: f64 = 0.0;
    for direction in [[0.3, -0.5, 0.8], [-0.9, 0.2, 0.1], [0.1, 0.7, -0.4], [0.5, 0.6, 0.7]] {
        let normal = Vector3::from(direction).normalize();
        let site = |direction: &Vector3<f64>, pose: &BodyState| {
            let place = surface.lowest(direction).unwrap();
            SurfaceSite { face: place.face, xi: place.xi, point: pose.position + Vector3::from(place.point) }
        };
        let mut there = BodyState::at_rest(0);
        there.position = -(2.0 * radius + gap) * normal;
        let contact = site(&normal, &here);
        // On a plane, and on the same ball behind it.
        for target in [None, Some(site(&-normal, &there))] {
            let other: Option<(&dyn Surface, _)> = target.map(|_| (&*surface as &dyn Surface, &there));
            let nearest = Nearest { gap, contact, target, normal };
            let touch = Touch::at((&*surface, &here), other, &nearest, 1e-6);
            let aside = |point: &Vector3<f64>| (point - point.dot(&normal) * normal).norm();
            // Steps end below 1e-6 of a side of 6 mm, and the side is 1e-5 m below the place and leans by 1e-2 at most.
            let found = [Some(touch.nearest.contact), touch.nearest.target];
            assert!(found.iter().flatten().all(|site| aside(&site.point) < 1.1e-7), "{:?}", touch.nearest);
            farthest = farthest.max(aside(&contact.point));
        }
    }
    assert!(farthest > 3e-5, "the sides touch there, too: {farthest:e}");
}

#[test]
fn no_smooth_surface_is_laid_over_a_place_where_curvature_jumps() {
    // A plane that goes over into a cylinder beside the place, as at a fillet.
    let bent = |[x, y, z]: [f64; 3]| {
        let over = (x - 0.55).max(0.0);
        [x, y, z - 0.8 * over * over * z]
    };
    let mesh = Arc::new(Mesh::new(blocks::block(ElementKind::Hex20, [7, 7, 2], bent), 1.0).unwrap());
    let (surface, at) = site(&mesh, [0.5, 0.5, 1.0]);
    let shape = surface.shape_at(&at).unwrap();
    assert!(SmoothFit::new(&surface, (&at, &shape), 0.05, |_| true).is_none());
    // The plane itself is one.
    let flat = Arc::new(Mesh::new(blocks::block(ElementKind::Hex20, [7, 7, 2], |x| x), 1.0).unwrap());
    let (surface, at) = site(&flat, [0.5, 0.5, 1.0]);
    let shape = surface.shape_at(&at).unwrap();
    let fit = SmoothFit::new(&surface, (&at, &shape), 0.05, |_| true);
    assert!(fit.is_none_or(|fit| fit.above(&[0.52, 0.47, 1.0]).abs() < 1e-12));
}
