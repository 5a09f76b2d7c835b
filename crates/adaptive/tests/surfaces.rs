//! What surfaces answer, the same whatever bodies are made of: normals, edges, flat faces, straight lines.

use std::sync::Arc;

use crate::balls::Ball;
use crate::blocks;
use adaptive::body::splines::ElasticBody;
use adaptive::body::zone::{ContactZone, PointsAbout, WholeRequest};
use adaptive::record::TouchedPart;
use adaptive::spec::{DiscretisationSpec, ElasticSpec, ReductionSpec};
use adaptive::surface::{MeshSurface, SplineSurface, Surface};
use fe_mesh::{ElementKind, Mesh};
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::round::Round;
use iga_core::nurbs::primitives::solid;
use nalgebra::Vector3;

/// Half lengths of a box \[m\].
const BOX: [f64; 3] = [0.015, 0.01, 0.006];
/// Radius and half length of a cylinder along z, from the origin, and half of the angle of a part of it \[m, rad\].
const RADIUS: f64 = 0.01;
const HALF: f64 = 0.02;
const ARC: f64 = 0.6;

fn mesh(kind: ElementKind, counts: [usize; 3], place: impl Fn([f64; 3]) -> [f64; 3]) -> Arc<dyn Surface> {
    let mesh = Mesh::new(blocks::block(kind, counts, place), 1.0).unwrap();
    MeshSurface::of(&Arc::new(mesh))
}

/// The box of every kind, about the origin.
fn boxes() -> Vec<(String, Arc<dyn Surface>)> {
    let shape = Arc::new(solid::cuboid(BOX.map(|half| 2.0 * half)).unwrap());
    let mut all: Vec<(String, Arc<dyn Surface>)> =
        vec![("splines".into(), SplineSurface::of(&shape, &Model::Solid))];
    for kind in ElementKind::SOLID {
        let place = |x: [f64; 3]| std::array::from_fn(|d| BOX[d] * (2.0 * x[d] - 1.0));
        all.push((format!("{kind:?}"), mesh(kind, [3, 2, 2], place)));
    }
    all
}

#[test]
fn boxes_have_faces_edges_and_corners() {
    // Faces of a block of one size, each by its axis; on sides of elements and at a node.
    let inside = [[0.2, 0.3], [0.0, 0.0], [-0.41, 0.77]];
    for (kind, surface) in boxes() {
        for (d, sign) in [0, 1, 2].into_iter().flat_map(|d| [(d, 1.0), (d, -1.0)]) {
            let outward: Vector3<f64> = sign * Vector3::ith(d, 1.0);
            for [u, v] in inside {
                let mut at = [0.0; 3];
                (at[d], at[(d + 1) % 3], at[(d + 2) % 3]) =
                    (sign * BOX[d], u * BOX[(d + 1) % 3], v * BOX[(d + 2) % 3]);
                let normals = surface.normals_at(&at);
                // Places are found to 1e-9 of the body.
                assert!(
                    normals.len() == 1 && (normals[0] - outward).norm() < 1e-8,
                    "{kind} {at:?} {normals:?}"
                );
                assert!(surface.has_flat_face(&at, &outward, 1e-6), "{kind} {at:?}");
                // Leaning by 1e-4 it is not flat to 1e-6.
                let leaning = (outward + 1e-4 * Vector3::<f64>::ith((d + 1) % 3, 1.0)).normalize();
                assert!(!surface.has_flat_face(&at, &leaning, 1e-6), "{kind} {at:?}");
                assert!(surface.along_edges(&at, 1e-3).is_empty(), "{kind} {at:?}");
            }
            // The lowest place against a plane below the face lies on it, with the face's own normal.
            let lowest = surface.turned_to(&surface.lowest(&-outward).unwrap(), &outward);
            assert!((surface.normal(&lowest) - outward).norm() < 1e-8, "{kind}");
            assert!((lowest.point[d] - sign * BOX[d]).abs() < 1e-9, "{kind}");
        }
        let edge = [BOX[0], BOX[1], 0.1 * BOX[2]];
        assert_eq!(surface.normals_at(&edge).len(), 2, "{kind}");
        // Both ways by a millimetre, along z.
        let mut along: Vec<f64> = surface.along_edges(&edge, 1e-3).iter().map(|x| x.z - edge[2]).collect();
        along.sort_by(f64::total_cmp);
        assert!(along.len() >= 2 && (along[0] + 1e-3).abs() < 1e-9, "{kind} {along:?}");
        assert!((along[along.len() - 1] - 1e-3).abs() < 1e-9, "{kind} {along:?}");
        let corner = [BOX[0], -BOX[1], BOX[2]];
        assert_eq!(surface.normals_at(&corner).len(), 3, "{kind}");
        // A place of a corner is turned to whichever side is wanted.
        let place = surface.nearest(&corner).unwrap().place;
        for outward in [Vector3::x(), -Vector3::y(), Vector3::z()] {
            let turned = surface.turned_to(&place, &outward);
            assert!((surface.normal(&turned) - outward).norm() < 1e-8, "{kind} {outward:?}");
            assert!((Vector3::from(turned.point) - Vector3::from(corner)).norm() < 1e-9, "{kind}");
        }
        // Planes have no line that is told.
        let curved = |line: &adaptive::surface::StraightLine| {
            surface.shape_at(&line.middle).is_some_and(|shape| shape.curvatures[0].abs() > 1e-3)
        };
        assert!(!surface.lines_through(&[0.1 * BOX[0], BOX[1], 0.3 * BOX[2]]).iter().any(curved), "{kind}");
    }
}

/// Cylinders along z: of splines a whole one, of elements a part of a tube, whose outer side it is.
fn cylinders() -> Vec<(String, Arc<dyn Surface>)> {
    let shape = Arc::new(solid::cylinder(RADIUS, 2.0 * HALF).unwrap());
    let mut all: Vec<(String, Arc<dyn Surface>)> =
        vec![("splines".into(), SplineSurface::of(&shape, &Model::Solid))];
    for kind in ElementKind::SOLID {
        let place = |x: [f64; 3]| {
            let (angle, radius) = (ARC * (2.0 * x[1] - 1.0), RADIUS * (0.7 + 0.3 * x[0]));
            [radius * angle.cos(), radius * angle.sin(), 2.0 * HALF * x[2]]
        };
        all.push((format!("{kind:?}"), mesh(kind, [1, 6, 3], place)));
    }
    all
}

#[test]
fn a_face_is_flat_as_far_as_it_is_plane() {
    let (radius, fillet) = (RADIUS, 0.3 * RADIUS);
    let round = |crown_radius| Round::RoundedCylinder {
        radius,
        length: 2.0 * HALF,
        crown_radius,
        fillet_radius: Some(fillet),
    };
    let faces = |round: Round| {
        let of = |shape: Shape, model| SplineSurface::of(&Arc::new(shape), &model) as Arc<dyn Surface>;
        let axial = of(round.axisymmetric().unwrap(), Model::Axisymmetric);
        [(axial, -Vector3::y()), (of(round.solid().unwrap(), Model::Solid), -Vector3::z())]
    };
    for (surface, down) in faces(round(None)) {
        let at = [0.5 * RADIUS, 0.0, 0.0];
        assert!(surface.has_flat_face(&at, &down, 1e-6));
        assert!(!surface.has_flat_face(&at, &(down + 1e-4 * Vector3::<f64>::x()).normalize(), 1e-6));
        // On the fillet, a tenth of its angle on: no part of the end has this normal, nor this height.
        let (sine, cosine) = 0.15_f64.sin_cos();
        let mut there = [RADIUS - fillet + fillet * sine, 0.0, 0.0];
        there[if down.y < 0.0 { 1 } else { 2 }] = fillet * (1.0 - cosine);
        assert!(!surface.has_flat_face(&there, &(cosine * down + sine * Vector3::<f64>::x()), 1e-6));
        assert!(!surface.has_flat_face(&there, &down, 1e-6));
    }
    for (surface, down) in faces(round(Some(10.0 * RADIUS))) {
        assert!(!surface.has_flat_face(&[0.0; 3], &down, 1e-6));
    }
}

#[test]
fn flat_faces_are_known_to_their_rims() {
    let farthest = |places: &[[f64; 3]], axis: &Vector3<f64>| {
        places.iter().map(|x| Vector3::from(*x).dot(axis)).fold(f64::NEG_INFINITY, f64::max)
    };
    for (kind, surface) in boxes() {
        let places = surface.flat_face(&[0.2 * BOX[0], 0.3 * BOX[1], BOX[2]], &Vector3::z(), 1e-6);
        for (d, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let found = farthest(&places, &(sign * Vector3::ith(d, 1.0)));
            assert!((found - BOX[d]).abs() < 1e-12, "{kind} {d} {found}");
        }
        assert!(places.iter().all(|x| (x[2] - BOX[2]).abs() < 1e-12), "{kind}");
    }
    // An end whose rim goes on in a fillet: as far as it is plane. Steps of a sixteenth of a right angle leave out 0.5 % at most.
    for fillet in [0.0, 0.3 * RADIUS] {
        let shape = match fillet > 0.0 {
            false => solid::cylinder(RADIUS, 2.0 * HALF).unwrap(),
            true => Round::RoundedCylinder {
                radius: RADIUS,
                length: 2.0 * HALF,
                crown_radius: None,
                fillet_radius: Some(fillet),
            }
            .solid()
            .unwrap(),
        };
        let surface = SplineSurface::of(&Arc::new(shape), &Model::Solid);
        let places = surface.flat_face(&[0.1 * RADIUS, 0.0, 0.0], &-Vector3::z(), 1e-6);
        for k in 0..32 {
            let (sine, cosine) = (0.2 * f64::from(k)).sin_cos();
            let found = farthest(&places, &Vector3::new(cosine, sine, 0.0)) / (RADIUS - fillet);
            assert!((0.995..1.0 + 1e-9).contains(&found), "{fillet} {k} {found}");
        }
    }
}

#[test]
fn cylinders_have_lines_from_end_to_end_and_are_not_flat() {
    for (kind, surface) in cylinders() {
        // On nodes, between them, and near an end.
        for (angle, z) in [(0.0, 0.0), (0.09, 0.3 * HALF), (-0.31, 0.9 * HALF)] {
            let outward = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0);
            let at = surface.nearest(&(RADIUS * outward + (HALF + z) * Vector3::z()).into()).unwrap().place;
            let lines = surface.lines_through(&at.point);
            let is_along = |line: &&adaptive::surface::StraightLine| {
                let ends = [line.points[0].z, line.points[4].z];
                let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                // Ends are found to four parts in a million of the body.
                low.abs() < 2e-7 && (high - 2.0 * HALF).abs() < 2e-7
            };
            let [line] = lines.iter().filter(is_along).collect::<Vec<_>>()[..] else {
                panic!("{kind} {angle} {z}: {lines:?}");
            };
            // The middle is the place of the same angle, but for the line's turn: its ends lie beside the surface by 1.6e-7 m at most, s²/2R of a turn
            // by s. Strips of linear sides are plane, and any line in them is one.
            let (middle, strip) = (Vector3::from(line.middle.point), RADIUS * 2.0 * ARC / 6.0);
            let turn = (2.0 * RADIUS * 1.6e-7).sqrt();
            let near = if ["Tet4", "Hex8", "Wedge6", "Pyramid5"].contains(&&kind[..]) { strip } else { turn };
            assert!((middle - (Vector3::from(at.point) - z * Vector3::z())).norm() < near, "{kind} {middle}");
            let normal = surface.normal(&at);
            assert!(!surface.has_flat_face(&at.point, &normal, 1e-6), "{kind} {angle} {z}");
            assert_eq!(surface.normals_at(&at.point).len(), 1, "{kind} {angle} {z}");
        }
        // The ends are flat, and meet the round face in an edge that is followed around.
        let rim = surface.nearest(&[RADIUS, 0.0, 2.0 * HALF]).unwrap().place;
        assert_eq!(surface.normals_at(&rim.point).len(), 2, "{kind}");
        assert!(surface.has_flat_face(&rim.point, &Vector3::z(), 1e-6), "{kind}");
        let places = surface.along_edges(&rim.point, 2e-3);
        let around =
            |x: &Vector3<f64>| (x.z - 2.0 * HALF).abs() < 1e-9 && (x.xy().norm() / RADIUS - 1.0).abs() < 0.01;
        // Chords of linear sides lie 0.5 % inside.
        assert!(places.len() >= 2 && places.iter().all(around), "{kind} {places:?}");
    }
}

/// Every place of an edge between two parts has the normals of both, on curved sides too, and the piece of the side that holds
/// it: a place that is found on one of them alone, or on another piece, would make crossing edges a touch with a
/// smooth part.
#[test]
fn places_all_along_an_edge_have_both_normals() {
    for kind in ElementKind::SOLID {
        let place = |x: [f64; 3]| {
            let (angle, radius) = (2.0 * ARC * (2.0 * x[1] - 1.0), RADIUS * (0.4 + 0.6 * x[0]));
            [radius * angle.cos(), radius * angle.sin(), HALF * (x[2] + 0.3 * x[0] * x[1])]
        };
        let mesh = Arc::new(Mesh::new(blocks::block(kind, [1, 5, 2], place), 1.0).unwrap());
        let surface = MeshSurface::of(&mesh);
        let pieces = surface.pieces();
        for (i, side) in surface.sides().iter().enumerate() {
            let creases = side.neighbours.iter().enumerate().filter(|(_, n)| n.is_some_and(|n| !n.is_smooth));
            for (edge, share) in
                creases.flat_map(|(edge, _)| (1..60).map(move |k| (edge, f64::from(k) / 60.0)))
            {
                let eta = side.kind.on_edge(edge, share);
                let at = surface.at(i, &eta).position;
                assert_eq!(surface.normals_at(&at).len(), 2, "{kind:?} {i} {edge} {share}");
                let (piece, s) = pieces.place_of(i as u32, eta).unwrap();
                let found = pieces.pieces[piece as usize].parameters(s);
                // Of a search that allows a millionth.
                let off = (found[0] - eta[0]).hypot(found[1] - eta[1]);
                assert!(off < 1e-5, "{kind:?} {i} {eta:?} {found:?}");
            }
        }
    }
}

#[test]
fn balls_have_one_normal_everywhere_and_neither_lines_nor_faces() {
    let ball = Ball { radius: 10.0, across: [6, 6], layers: 2, growth: [1.0, 1.0] };
    for kind in [ElementKind::Hex20, ElementKind::Hex8, ElementKind::Tet10] {
        let surface = MeshSurface::of(&Arc::new(Mesh::new(ball.mesh(kind), 1e-3).unwrap()));
        for direction in [[0.0, 0.0, -1.0], [0.17, -0.11, -0.979], [0.6, 0.64, 0.48]] {
            let direction: Vector3<f64> = Vector3::from(direction).normalize();
            let at = surface.nearest(&(0.01_f64 * direction).into()).unwrap().place;
            let normals = surface.normals_at(&at.point);
            // Sides as long as a fifth of the diameter turn by a fifth of a radian and more.
            assert!(normals.len() == 1 && normals[0].angle(&direction) < 0.3, "{kind:?} {normals:?}");
            let normal = surface.normal(&at);
            assert!(!surface.has_flat_face(&at.point, &normal, 1e-4), "{kind:?} {direction}");
            assert!(surface.lines_through(&at.point).is_empty(), "{kind:?} {direction}");
            assert!(surface.along_edges(&at.point, 1e-3).is_empty(), "{kind:?} {direction}");
        }
    }
}

/// Contact points of whole surfaces by place and area, in an order of their own.
fn sorted(zone: &ContactZone) -> Vec<([f64; 3], f64)> {
    let mut points: Vec<_> = zone.points.iter().map(|p| (p.position, p.area)).collect();
    let key = |x: &[f64; 3]| x.map(|c| (c * 1e9).round() as i64);
    points.sort_by(|a, b| key(&a.0).cmp(&key(&b.0)).then(a.1.total_cmp(&b.1)));
    points
}

#[test]
fn whole_surfaces_of_bricks_have_the_points_of_splines() {
    let steel = Material::new(210e9, 0.3, 7850.0).unwrap();
    let counts = [3, 2, 2];
    for (kind, degree) in [(ElementKind::Hex8, 1), (ElementKind::Hex27, 2)] {
        let shape = solid::cuboid(BOX.map(|half| 2.0 * half)).unwrap();
        // Knots of quadratic splines would have to be double to have the places of elements; points do not depend on them.
        let discretisation = DiscretisationSpec {
            degrees: vec![degree; 3],
            elements: counts.to_vec(),
            knots: None,
            refine: Vec::new(),
        };
        let reduction = ReductionSpec::Modal { modes: 1 };
        let splines = ElasticSpec::new(shape, Model::Solid, steel, discretisation, reduction);
        let splines = ElasticBody::build("splines", splines).unwrap();
        let place = |x: [f64; 3]| std::array::from_fn(|d| BOX[d] * (2.0 * x[d] - 1.0));
        let mesh = MeshSurface::of(&Arc::new(Mesh::new(blocks::block(kind, counts, place), 1.0).unwrap()));
        // Without a place, in the midst of an edge, on a face and at a corner.
        let edge = [BOX[0], BOX[1], 0.13 * BOX[2]];
        let face = [0.2 * BOX[0], -BOX[1], 0.31 * BOX[2]];
        let corner = [BOX[0], -BOX[1], BOX[2]];
        for at in [None, Some(edge), Some(face), Some(corner)] {
            let about = |surface: &dyn Surface| {
                let place = at.map(|at| surface.nearest(&at).unwrap().place);
                place.map(|place| PointsAbout { place, meets: None })
            };
            let of_splines =
                ContactZone::whole(&splines.discretised(), about(splines.surface.as_ref()).as_ref()).unwrap();
            let of_mesh =
                ContactZone::whole_mesh(&mesh, &WholeRequest { about: about(mesh.as_ref()), part: None })
                    .unwrap();
            let (a, b) = (sorted(&of_splines), sorted(&of_mesh));
            let is_in = |list: &[([f64; 3], f64)], p: &([f64; 3], f64)| {
                let apart = |q: &[f64; 3]| (Vector3::from(p.0) - Vector3::from(*q)).norm();
                // Places of a search are found to 1e-9 of the body; areas divide there.
                list.iter().any(|q| apart(&q.0) < 1e-9 && (p.1 - q.1).abs() < 1e-12)
            };
            let alone: Vec<_> =
                a.iter().filter(|p| !is_in(&b, p)).chain(b.iter().filter(|p| !is_in(&a, p))).collect();
            assert!(
                a.len() == b.len() && alone.is_empty(),
                "{kind:?} {at:?} {} {}: {alone:?}",
                a.len(),
                b.len()
            );
            let total: f64 = b.iter().map(|p| p.1).sum();
            let area = 8.0 * (BOX[0] * BOX[1] + BOX[1] * BOX[2] + BOX[2] * BOX[0]);
            assert!((total / area - 1.0).abs() < 1e-12, "{kind:?} {at:?}: {total} {area}");
        }
    }
}

#[test]
fn the_part_that_may_press_at_a_touch_has_all_sides_that_come_near() {
    let place = |x: [f64; 3]| std::array::from_fn(|d| BOX[d] * (2.0 * x[d] - 1.0));
    for kind in ElementKind::SOLID {
        let mesh = MeshSurface::of(&Arc::new(Mesh::new(blocks::block(kind, [6, 4, 3], place), 1.0).unwrap()));
        let whole = ContactZone::whole_mesh(&mesh, &WholeRequest::default()).unwrap();
        let corner = TouchedPart {
            origin: BOX,
            outward: Vector3::from(BOX).normalize().into(),
            depth: 1e-4,
            radius: BOX[0],
        };
        let face = TouchedPart {
            origin: [0.0, 0.0, -BOX[2]],
            outward: [0.0, 0.0, -1.0],
            depth: 1e-4,
            radius: 4.0 * BOX[0],
        };
        for (part, all) in [(corner, false), (face, true)] {
            let zone =
                ContactZone::whole_mesh(&mesh, &WholeRequest { about: None, part: Some(part) }).unwrap();
            let depth = |x: &[f64; 3]| {
                Vector3::from(part.outward).dot(&(Vector3::from(part.origin) - Vector3::from(*x)))
            };
            let near = |x: &[f64; 3]| depth(x) <= part.depth;
            // Points near the touch are those of the whole surface, with the same areas; the rim of the part lies deeper.
            let of =
                |zone: &ContactZone| sorted(zone).into_iter().filter(|(x, _)| near(x)).collect::<Vec<_>>();
            let (kept, known) = (of(&zone), of(&whole));
            assert_eq!(kept.len(), known.len(), "{kind:?}");
            for ((x, a), (y, b)) in kept.iter().zip(&known) {
                assert!(
                    x.map(f64::to_bits) == y.map(f64::to_bits) && (a / b - 1.0).abs() < 1e-12,
                    "{kind:?}: {x:?} {a:e}, {y:?} {b:e}"
                );
            }
            assert!(zone.points.iter().all(|p| !(p.on_rim && near(&p.position))), "{kind:?}");
            assert!(zone.points.iter().any(|p| p.on_rim), "{kind:?}");
            assert_eq!(kept.len() > 20, all, "{kind:?}");
            assert!(zone.unknowns.len() < 3 * whole.unknowns.len() / 4, "{kind:?}: {}", zone.unknowns.len());
        }
    }
}
