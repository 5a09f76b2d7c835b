//! Boxes of finite elements that touch with faces, edges and corners: hexahedra of eight nodes are splines of degree one on the same net, so that both
//! have to give the same impact.

use crate::support::scenarios;
use std::fmt::Write as _;
use std::path::Path;

use adaptive::model::start_poses;
use adaptive::record::ImpactRecord;
use adaptive::run::recording::Recording;
use adaptive::touch::first::FirstTouches;
use adaptive::touch::parts::TouchKind;

/// A box about its middle.
#[derive(Clone, Copy)]
struct Bricks {
    /// Lengths \[m\].
    size: [f64; 3],
    /// Elements along them.
    elements: [usize; 3],
}

const CUBE: Bricks = Bricks { size: [0.02; 3], elements: [3; 3] };
const BLOCK: Bricks = Bricks { size: [0.05, 0.05, 0.02], elements: [5, 5, 2] };

impl Bricks {
    /// Hexahedra with eight nodes, in metres, as an input file of Abaqus.
    fn mesh(&self) -> String {
        let mut text = "*NODE\n".to_owned();
        let counts = self.elements.map(|n| n + 1);
        let number = |i: usize, j: usize, k: usize| 1 + i + counts[0] * (j + counts[1] * k);
        let all = |n: [usize; 3]| {
            (0..n[0] * n[1] * n[2]).map(move |a| [a % n[0], a / n[0] % n[1], a / (n[0] * n[1])])
        };
        for at in all(counts) {
            let x: [f64; 3] =
                std::array::from_fn(|d| self.size[d] * (at[d] as f64 / self.elements[d] as f64 - 0.5));
            writeln!(text, "{}, {:e}, {:e}, {:e}", number(at[0], at[1], at[2]), x[0], x[1], x[2]).unwrap();
        }
        text += "*ELEMENT, TYPE=C3D8, ELSET=BOX\n";
        for (e, [i, j, k]) in all(self.elements).enumerate() {
            let ring = |k: usize| {
                [number(i, j, k), number(i + 1, j, k), number(i + 1, j + 1, k), number(i, j + 1, k)]
            };
            let nodes: Vec<String> = ring(k).into_iter().chain(ring(k + 1)).map(|n| n.to_string()).collect();
            writeln!(text, "{}, {}", e + 1, nodes.join(", ")).unwrap();
        }
        text
    }

    /// The body `name` of steel, of finite elements or of splines, with further `keys`.
    fn body(&self, folder: &Path, name: &str, is_mesh: bool, keys: &str) -> String {
        let made_of = if is_mesh {
            std::fs::write(folder.join(format!("{name}.inp")), self.mesh()).unwrap();
            format!("model = \"mesh\"\nfile = \"{name}.inp\"\nunits = \"m\"")
        } else {
            let Self { size, elements } = self;
            format!(
                "geometry = {{ shape = \"box\", size = {size:?} }}\n\
                 discretisation = {{ degree = 1, elements = {elements:?} }}"
            )
        };
        format!("[bodies.{name}]\nmaterial = \"steel\"\nreduction = {{ modes = 20 }}\n{made_of}\n{keys}\n")
    }
}

const FLOOR: &str = "[bodies.floor]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\n";

/// Turn of the cube about x and y as a rotation vector \[degrees\], and what touches.
const LYING: [(&str, [f64; 2], TouchKind); 3] = [
    ("face", [0.0, 0.0], TouchKind::Flat),
    ("edge", [45.0, 0.0], TouchKind::Edge),
    ("corner", [30.0, 20.0], TouchKind::Edge),
];

/// The cube of finite elements or of splines, turned and 1 um above what is at `z = 0`, 0.5 m/s fast.
fn falling(folder: &Path, is_mesh: bool, [x, y]: [f64; 2]) -> String {
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::new(
        x.to_radians(),
        y.to_radians(),
        0.0,
    ));
    let corners = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(|s| 0.01 * (2.0 * f64::from(s) - 1.0)));
    let lowest = corners.map(|c| (turn * nalgebra::Vector3::from(c)).z).fold(f64::INFINITY, f64::min);
    let keys = format!(
        "position = [0.001, 0.0007, {:e}]\norientation_deg = [{x}, {y}, 0.0]\nvelocity = [0.0, 0.0, -0.5]",
        1e-6 - lowest
    );
    CUBE.body(folder, "cube", is_mesh, &keys)
}

/// The run of a scenario, and what it says touches first.
fn run(folder: &Path, bodies: &str, target: &str) -> (Recording, Option<TouchKind>) {
    let text = format!(
        "[simulation]\nend_time = 6e-5\n{bodies}\n[contacts.c]\ncontact_body = \"cube\"\ntarget_body = \"{target}\"\n"
    );
    let scenario = scenarios::valid(folder, &text, &[]);
    let spec = &scenario.run;
    let kind = FirstTouches::new(spec, start_poses(spec).unwrap()).kind(&spec.contacts[0]);
    (scenarios::run(&scenario), kind)
}

/// Checks that two runs have the same first impact.
fn check_same(what: &str, [a, b]: [&ImpactRecord; 2]) {
    println!("{what}: {:.8e} {:.8e} N, {:.8e} {:.8e} N s", a.peak_force, b.peak_force, a.impulse, b.impulse);
    // The same model but for round-off, after which steps are chosen anew: some hundred of them, each right to 1e-8 of the motion, and ten times that for
    // other processors. Stiff springs make more of it in single forces.
    let error = |x: f64, y: f64| (x / y - 1.0).abs();
    assert!(error(a.impulse, b.impulse) < 1e-5, "{what}: impulse {:e} {:e}", a.impulse, b.impulse);
    assert!(error(a.peak_force, b.peak_force) < 1e-4, "{what}: peak {:e} {:e}", a.peak_force, b.peak_force);
    assert!((a.restitution - b.restitution).abs() < 1e-4, "{what}: {} {}", a.restitution, b.restitution);
}

#[test]
fn faces_edges_and_corners_of_bricks_meet_a_floor_as_those_of_splines_do() {
    let folder = scenarios::folder("flat_meshes");
    for (what, turn, kind) in LYING {
        let on_floor =
            |is_mesh| run(&folder, &format!("{}{FLOOR}", falling(&folder, is_mesh, turn)), "floor");
        let [(meshed, of_mesh), (splines, of_splines)] = [true, false].map(on_floor);
        assert_eq!([of_mesh, of_splines], [Some(kind); 2], "{what}");
        check_same(what, [&meshed.impacts[0], &splines.impacts[0]]);
        // Momentum by the floor's force alone; the ledger as of contact on whole surfaces elsewhere.
        let impulse: f64 = meshed.impacts.iter().map(|impact| impact.impulse).sum();
        let (first, last) = (&meshed.samples[0], meshed.samples.last().unwrap());
        let gained = last.linear_momentum[2] - first.linear_momentum[2];
        assert!((impulse / gained - 1.0).abs() < 1e-6, "{what}: {impulse:e} {gained:e}");
        assert!(meshed.energy_drift() < 1e-5, "{what}: {:e}", meshed.energy_drift());
    }
}

/// As long as the edge that is touched first presses, the other end of the face comes down: the zone about the edge reaches its end, and is laid anew.
#[test]
fn zones_that_prove_too_small_grow() {
    let folder = scenarios::folder("growing_zones");
    let on_floor = |is_mesh| {
        let bodies = falling(&folder, is_mesh, [0.25, 0.0]).replace("-0.5]", "-5.0]");
        run(&folder, &format!("{bodies}{FLOOR}"), "floor").0
    };
    let [meshed, splines] = [true, false].map(on_floor);
    check_same("tilted face", [&meshed.impacts[0], &splines.impacts[0]]);
    let grown: Vec<_> = meshed.trials.iter().filter(|trial| trial.reason.contains("reaches")).collect();
    assert!(!grown.is_empty(), "{:?}", meshed.trials);
    assert!(grown.iter().all(|trial| trial.stop < meshed.trials.last().unwrap().stop), "{:?}", meshed.trials);
}

/// A fork on two feet: the zone about the first one to touch has no node of the other, and its rim does not press.
#[test]
fn what_lands_beside_a_zone_makes_it_grow() {
    let folder = scenarios::folder("fork");
    let bar = Bricks { size: [0.06, 0.01, 0.03], elements: [6, 1, 3] };
    let mesh = bar.mesh();
    // Without the two elements in the middle of the lowest row.
    let is_foot = |line: &&str| !line.starts_with("3, ") && !line.starts_with("4, ");
    let (nodes, elements) = mesh.split_once("*ELEMENT").unwrap();
    let elements: Vec<&str> = elements.lines().filter(is_foot).collect();
    std::fs::write(folder.join("fork.inp"), format!("{nodes}*ELEMENT{}\n", elements.join("\n"))).unwrap();
    let tilt = 0.1_f64.to_radians();
    let height = 0.015 * tilt.cos() + 0.03 * tilt.sin() + 1e-6;
    let fork = format!(
        "[bodies.cube]\nmaterial = \"steel\"\nreduction = {{ modes = 20 }}\nmodel = \"mesh\"\nfile = \"fork.inp\"\nunits = \"m\"\n\
         position = [0.0, 0.0, {height:e}]\norientation_deg = [0.0, 0.1, 0.0]\nvelocity = [0.0, 0.0, -5.0]\n"
    );
    let (found, _) = run(&folder, &format!("{fork}{FLOOR}"), "floor");
    let grown = found.trials.iter().filter(|trial| trial.reason.contains("reaches")).count();
    assert!(grown > 0, "{:?}", found.trials);
    let (first, last) = (&found.samples[0], found.samples.last().unwrap());
    let gained = last.linear_momentum[2] - first.linear_momentum[2];
    let impulse: f64 = found.impacts.iter().map(|impact| impact.impulse).sum();
    assert!((impulse / gained - 1.0).abs() < 1e-6, "{impulse:e} {gained:e}");
}

/// A cube falls on its corner, turns and lands elsewhere: each landing has a zone of its own and one row, and momentum is that of the impulses and
/// of the weight.
#[test]
fn a_cube_that_tips_lands_several_times() {
    let folder = scenarios::folder("landings");
    let text = format!(
        "[simulation]\nend_time = 0.5\nstop_after_impacts = 3\ngravity = [0.0, 0.0, -9.81]\n[output]\nfree_interval = 5e-3\n{}{FLOOR}\n[contacts.c]\n\
         contact_body = \"cube\"\ntarget_body = \"floor\"\n",
        falling(&folder, true, [30.0, 20.0])
    );
    let found = scenarios::run(&scenarios::valid(&folder, &text, &[]));
    assert_eq!(found.impacts.len(), 3);
    // Apart from each other by flights, which chatter of one touch is not.
    assert!(found.impacts.windows(2).all(|two| two[1].start - two[0].end > 1e-3));
    let (first, last) = (&found.samples[0], found.samples.last().unwrap());
    let weight = 7850.0 * CUBE.size[0].powi(3) * 9.81;
    let gained = last.linear_momentum[2] - first.linear_momentum[2] + weight * (last.time - first.time);
    let impulse: f64 = found.impacts.iter().map(|impact| impact.impulse).sum();
    // Steps are right to 1e-8 of the motion, and some ten thousand of them are made.
    assert!(found.energy_drift() < 1e-4, "{:e}", found.energy_drift());
    // Impulses are integrals by the steps, each right to 1e-8.
    assert!((impulse / gained - 1.0).abs() < 1e-6, "{impulse:e} {gained:e}");
}

/// A corner needs the compliance of a few nodes, a face that of its own.
#[test]
fn zones_lie_about_the_touch() {
    let folder = scenarios::folder("zones_about_touches");
    let unknowns = |turn: [f64; 2]| {
        let (found, _) = run(&folder, &format!("{}{FLOOR}", falling(&folder, true, turn)), "floor");
        found.trials.last().unwrap().interface_dofs
    };
    // Of 56 nodes on the surface: a face has 16 and those of the row above it, an edge those of the six sides along it and of one at either end, a
    // corner those of its three sides.
    assert_eq!(LYING.map(|(_, turn, _)| unknowns(turn)), [3 * 28, 3 * 14, 3 * 7]);
}

#[test]
fn a_box_of_bricks_meets_another_as_those_of_splines_do() {
    meet_each_other_alike(&LYING[2..], &[[true, true]]);
}

#[test]
#[ignore = "second tier: ten seconds"]
fn boxes_of_bricks_and_of_splines_meet_each_other_alike() {
    meet_each_other_alike(&LYING, &[[true, false], [false, true], [true, true]]);
}

fn meet_each_other_alike(lying: &[(&str, [f64; 2], TouchKind)], mixed: &[[bool; 2]]) {
    let folder = scenarios::folder("flat_mesh_pairs");
    // An edge along a face touches everywhere at once: about which of its places points stand closer is round-off, and coarse elements show it.
    for &(what, turn, _) in lying.iter().filter(|(what, ..)| *what != "edge") {
        let pair = |[cube, block]: [bool; 2]| {
            let bodies = [
                falling(&folder, cube, turn),
                BLOCK.body(&folder, "block", block, "position = [0.0, 0.0, -0.01]"),
            ];
            run(&folder, &bodies.concat(), "block").0
        };
        let splines = pair([false, false]);
        for &kinds in mixed {
            let found = pair(kinds);
            check_same(&format!("{what} {kinds:?}"), [&found.impacts[0], &splines.impacts[0]]);
            assert!(found.energy_drift() < 1e-5, "{what} {kinds:?}: {:e}", found.energy_drift());
        }
    }
}

#[test]
fn a_width_given_keeps_the_contact_on_the_sides_of_the_face() {
    let folder = scenarios::folder("flat_mesh_width");
    let text = format!(
        "[simulation]\nend_time = 2e-5\n{}{FLOOR}\n[contacts.c]\ncontact_body = \"cube\"\ntarget_body = \"floor\"\n\
         model = \"quasistatic\"\ninterval = {{ width = 0.057 }}\n",
        falling(&folder, true, [0.0; 2])
    );
    // Twice the diagonal of the face is 57 mm.
    let found = scenarios::run(&scenarios::valid(&folder, &text, &[]));
    let [impact] = &found.impacts[..] else { panic!("{} impacts", found.impacts.len()) };
    let (first, last) = (&found.samples[0], found.samples.last().unwrap());
    let gained = last.linear_momentum[2] - first.linear_momentum[2];
    // Momentum by the plane's force alone; a body that turns back has more than the one that stays.
    assert!((impact.impulse / gained - 1.0).abs() < 1e-6, "{} {gained}", impact.impulse);
    assert!(gained > 0.5 * 7850.0 * CUBE.size.iter().product::<f64>(), "{gained}");
    assert!(found.energy_drift() < 1e-4, "{:e}", found.energy_drift());
}

#[test]
fn a_tool_between_the_points_of_a_mesh_is_not_passed_through_without_a_word() {
    // One element a side over a thin pin: none of its corners meets the pin's end.
    let folder = scenarios::folder("pin_between_points");
    let block = Bricks { size: [0.02; 3], elements: [1; 3] };
    let block =
        block.body(&folder, "block", true, "position = [0.0, 0.0, 0.010001]\nvelocity = [0.0, 0.0, -1.0]");
    let pin = "[bodies.pin]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = { shape = \"box\", size = [1e-3, 1e-3, 0.01] }\n\
        position = [0.004, 0.003, -0.005]\n[contacts.c]\ncontact_body = \"block\"\ntarget_body = \"pin\"\n";
    let text = format!("[simulation]\nend_time = 1.0e-4\n{}{pin}", block.replace("modes = 20", "modes = 6"));
    let error = scenarios::refusal(&scenarios::valid(&folder, &text, &[]));
    assert!(error.contains("exchange contact_body and target_body"), "{error}");
}
