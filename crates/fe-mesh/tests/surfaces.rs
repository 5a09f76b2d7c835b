//! Surfaces of meshes: what meets at edges, where they are smooth, sides without area.

use crate::blocks;
use std::f64::consts::PI;

use crate::balls::Ball;
use fe_mesh::element::jacobian::norm;
use fe_mesh::fault::MeshFault;
use fe_mesh::locate::SidePoint;
use fe_mesh::surface::Surface;
use fe_mesh::{ElementKind, Mesh, SideKind};

const BALL: Ball = Ball { radius: 1.0, across: [6, 4], layers: 2, growth: [1.2, 1.3] };

fn area(mesh: &Mesh, rule: impl Fn(SideKind) -> Vec<fe_mesh::element::rules::RulePoint<2>>) -> f64 {
    let (mut at, mut places, mut sum) = (SidePoint::default(), Vec::new(), 0.0);
    for side in Surface::new(mesh).sides() {
        mesh.places(&side.nodes, &mut places);
        for point in rule(side.kind) {
            at.evaluate(side.kind, &places, &point.xi);
            sum += point.weight * norm(&at.area);
        }
    }
    sum
}

#[test]
fn neighbours_are_mutual_and_share_their_edge() {
    for kind in [ElementKind::Hex20, ElementKind::Tet10] {
        let mesh = Mesh::new(BALL.mesh(kind), 1.0).unwrap();
        let surface = Surface::new(&mesh);
        for (i, side) in surface.sides().iter().enumerate() {
            let n = side.n_edges();
            for (e, neighbour) in side.neighbours.iter().enumerate().take(n) {
                let neighbour = neighbour.unwrap();
                let other = &surface.sides()[neighbour.side as usize];
                let back = other.neighbours[neighbour.edge as usize].unwrap();
                assert_eq!((back.side as usize, back.edge as usize), (i, e));
                let (there, m) = (neighbour.edge as usize, other.n_edges());
                // Against each other, with the node in the middle.
                assert_eq!(side.nodes[e], other.nodes[(there + 1) % m]);
                assert_eq!(side.nodes[n + e], other.nodes[m + there]);
                assert!(neighbour.is_smooth, "a ball has no edge");
            }
        }
    }
}

#[test]
fn edges_of_a_block_are_creases_and_its_sides_are_connected() {
    for kind in [ElementKind::Hex20, ElementKind::Tet10, ElementKind::Wedge15, ElementKind::Hex8] {
        let mesh = Mesh::new(blocks::block(kind, [3, 2, 2], |x| x), 1.0).unwrap();
        let surface = Surface::new(&mesh);
        for name in ["x-", "z+"] {
            let group = mesh.face_group(name).unwrap();
            let numbers: Vec<u32> =
                group.iter().map(|f| mesh.surface().iter().position(|s| s == f).unwrap() as u32).collect();
            assert_eq!(surface.smooth_part(numbers[0] as usize, |_| true), numbers, "{kind:?} {name}");
        }
    }
}

#[test]
fn areas_of_contact_points_sum_to_the_surface() {
    for kind in [ElementKind::Hex20, ElementKind::Tet10, ElementKind::Wedge15, ElementKind::Hex8] {
        let mesh = Mesh::new(blocks::block(kind, [3, 2, 2], |x| x), 1.0).unwrap();
        // Flat sides: round-off.
        assert!((area(&mesh, SideKind::contact_rule) - 6.0).abs() < 1e-13, "{kind:?}");
    }
    for kind in [ElementKind::Hex20, ElementKind::Tet10] {
        let mesh = Mesh::new(BALL.mesh(kind), 1.0).unwrap();
        let [few, many] = [area(&mesh, SideKind::contact_rule), area(&mesh, SideKind::rule)];
        // Of sides that turn by angles θ up to 0.5 the geometry and both rules leave terms of θ⁴/120.
        assert!(
            (few / (4.0 * PI) - 1.0).abs() < 5e-4 && (many / few - 1.0).abs() < 5e-4,
            "{kind:?} {few} {many}"
        );
    }
}

/// Nodal forces `Σ w N_A` of a pressure of one along z at the points of `rule` on the sides of group "z+".
fn forces(mesh: &Mesh, rule: impl Fn(SideKind) -> Vec<fe_mesh::element::rules::RulePoint<2>>) -> Vec<f64> {
    let (mut at, mut places) = (SidePoint::default(), Vec::new());
    let mut forces = vec![0.0; mesh.nodes().len()];
    for &face in mesh.face_group("z+").expect("a group") {
        let (kind, nodes) = mesh.face(face);
        mesh.places(&nodes, &mut places);
        for point in rule(kind) {
            at.evaluate(kind, &places, &point.xi);
            for (&node, value) in nodes.iter().zip(&at.functions.values) {
                forces[node as usize] += point.weight * value * norm(&at.area);
            }
        }
    }
    forces
}

/// What a patch test asks of contact points: under a constant pressure the nodal forces are those of the elements, so that a column on a plane
/// is compressed evenly.
#[test]
fn a_constant_pressure_at_contact_points_loads_the_nodes_as_its_integral_does() {
    for kind in ElementKind::SOLID {
        let shear = |[x, y, z]: [f64; 3]| [x + 0.3 * y, y - 0.1 * x, z];
        let mesh = Mesh::new(blocks::block(kind, [2, 3, 1], shear), 1.0).unwrap();
        let [few, many] = [forces(&mesh, SideKind::contact_rule), forces(&mesh, SideKind::rule)];
        let away = few.iter().zip(&many).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        // Both rules are exact: round-off of some twenty terms.
        assert!(away < 1e-15, "{kind:?} {away:e}");
        let corner = many.iter().fold(f64::INFINITY, |m, f| m.min(*f));
        assert!(
            kind != ElementKind::Hex20 || corner < -1e-3,
            "corners of eight-node sides have negative areas"
        );
    }
}

#[test]
fn a_side_without_area_at_a_corner_is_refused_with_its_element() {
    // A corner of the top that stands between its neighbours.
    let between = |x: [f64; 3]| if x[2] > x[0] + x[1] { [0.5, 0.5, 1.0] } else { x };
    let mesh = Mesh::new(blocks::block(ElementKind::Hex8, [1, 1, 1], between), 1.0).unwrap();
    let surface = Surface::new(&mesh);
    let faults: Vec<MeshFault> =
        (0..surface.sides().len()).filter_map(|i| surface.check_side(&mesh, i).err()).collect();
    assert!(matches!(faults[..], [MeshFault::FlatSide { element: 1, .. }, ..]), "{faults:?}");
}
