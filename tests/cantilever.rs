//! A solid bar held on its faces against CalculiX: the same frequencies with every mesh, number of modes, source of the body and command, and
//! its reactions.

use crate::solid_file;
use crate::support::scenarios;
use std::path::PathBuf;

use crate::support::bar::{ALUMINIUM, CLAMP, CLAMPED_BRICKS, HINGE, HINGED_BRICKS, OTHER_HINGE};
use crate::support::scenarios::{run, system_frequencies};
use assert_cmd::Command;
use fbimpact::scenario::Scenario;
use fbimpact::simulate::{modes, system_modes};
use serde_json::Value;

const WORLD: &str = r#"
[simulation]
end_time = 1e-6
gravity = [0.0, 0.0, -9.81]
static_start = true
"#;

const BEAM: &str = r#"
[bodies.beam]
material = "aluminium"
geometry = { shape = "box", size = [0.3, 0.03, 0.01] }
frame = "tangent"
"#;

/// The same from a file, with the modes of a body that nothing strikes.
const IMPORTED: &str = r#"
[bodies.beam]
model = "imported"
file = "bar.h5"
frame = "tangent"
reduction = { method = "modal", modes = 20 }
"#;

/// CalculiX 2.20 with the models of `scripts/solid_beam_calculix.py`, 80 × 8 × 6 elements C3D20, first frequencies \[Hz\]. From
/// 60 × 6 × 4 elements on they change by 2e-6, the torsion at 1449 Hz by 5e-4.
const CLAMPED: [f64; 5] = [91.3254, 272.0422, 569.8472, 1448.969, 1584.449];
/// The mean rotation about y left free at one end.
const HINGED: [f64; 4] = [0.0, 272.0422, 399.7511, 1288.398];
/// And at both.
const TWO_HINGES: [f64; 4] = [256.1401, 1019.795, 1636.428, 2276.874];
/// Every point of the face held (100 × 16 × 8 elements). The stress at its edges is singular: halved elements still take 3e-4.
const HELD: [f64; 2] = [91.8562, 272.8351];
/// The face turning about y as a rigid one.
const HELD_HINGE: [f64; 3] = [0.0, 272.8797, 399.7673];

/// Frequencies of meshes that the program chooses are right to this.
const CHOSEN: f64 = 1e-3;

/// Without weight, for which a hinged bar across it has no equilibrium, and on a mesh that is known to do.
const LEVEL: [&str; 3] = [
    "simulation.gravity=[0.0,0.0,0.0]",
    "simulation.static_start=false",
    "bodies.beam.discretisation={degree=3,elements=[20,3,2]}",
];

fn parsed(text: &str, set: &[&str]) -> Scenario {
    scenarios::valid(&folder(), text, set)
}

fn folder() -> PathBuf {
    scenarios::folder("cantilever")
}

/// Frequencies of the system \[Hz\].
fn frequencies(parts: &[&str], set: &[&str]) -> Vec<f64> {
    let text: String = [WORLD, ALUMINIUM].iter().chain(parts).copied().collect();
    system_frequencies(&parsed(&text, set))
}

fn assert_close(what: &str, found: &[f64], expected: &[f64], limit: f64) {
    println!("{what}: {:?}", &found[..expected.len()]);
    for (f, e) in found.iter().zip(expected) {
        // A hinged bar that lies across its weight moves with it: no vibration, or one far below the first of the bar.
        let is_right = if *e > 0.0 { (f / e - 1.0).abs() < limit } else { *f < 1e-2 };
        assert!(is_right, "{what}: {found:?}, {expected:?}");
    }
}

#[test]
fn clamped_bar_has_the_frequencies_of_calculix_whatever_the_mesh_and_the_modes() {
    let default = frequencies(&[BEAM, CLAMP], &[]);
    assert_close("clamped", &default, &CLAMPED, CHOSEN);
    let rough = frequencies(&[BEAM, CLAMP], &[&of_elements("[20,3,2]")]);
    assert_close("rough", &rough, &default[..3], CHOSEN);
    assert_close("rough", &rough, &CLAMPED[..3], CHOSEN);
}

fn of_elements(n: &str) -> String {
    format!("bodies.beam.discretisation={{degree=3,elements={n}}}")
}

#[test]
#[ignore = "second tier: ten seconds"]
fn clamped_bar_has_them_with_finer_meshes_more_modes_and_a_rigid_face() {
    let default = frequencies(&[BEAM, CLAMP], &[]);
    // Twice the free modes that the program chooses; six static answers stand beside them.
    let doubled = format!("bodies.beam.reduction.modes={}", 2 * (default.len() - 6));
    for set in [of_elements("[60,6,4]"), doubled] {
        let found = frequencies(&[BEAM, CLAMP], &[&set]);
        assert_close(&set, &found, &default[..3], CHOSEN);
        assert_close(&set, &found, &CLAMPED[..3], CHOSEN);
    }
    let rigid = frequencies(&[BEAM, CLAMP], &["joints.clamp.child.coupling=rigid"]);
    // What elements and those of the reference miss of the edges.
    assert_close("rigid face", &rigid, &HELD, 2.0 * CHOSEN);
}

#[test]
fn hinged_bar_has_the_frequencies_of_calculix() {
    assert_close("hinged", &frequencies(&[BEAM, HINGE], &LEVEL), &HINGED, CHOSEN);
    let both = frequencies(&[BEAM, HINGE, OTHER_HINGE], &LEVEL);
    assert_close("two hinges", &both, &TWO_HINGES, CHOSEN);
    let rigid = frequencies(&[BEAM, HINGE], &[&LEVEL[..], &["joints.clamp.child.coupling=rigid"]].concat());
    assert_close("rigid hinge", &rigid, &HELD_HINGE, 2.0 * CHOSEN);
    // Hanging it is a pendulum: m g ℓ/2 over m (ℓ²/3 + h²/12), bending takes (1 Hz / 400 Hz)² of it.
    let hanging = frequencies(&[BEAM, HINGE], &["simulation.gravity=[9.81,0.0,0.0]", LEVEL[2]]);
    let expected = (9.81 * 0.15 / (0.03 + 0.01f64.powi(2) / 12.0)).sqrt() / std::f64::consts::TAU;
    assert_close("pendulum", &hanging, &[expected, HINGED[1], HINGED[2]], CHOSEN);
    assert!((hanging[0] / expected - 1.0).abs() < 1e-5, "{} {expected}", hanging[0]);
}

#[test]
fn bar_of_another_program_has_its_frequencies() {
    solid_file::write_bar(&folder().join("bar.h5"), [20, 3, 2]);
    let at = |joint: &str| {
        joint.replace("face = \"x-\"", "marker = \"foot\"").replace("face = \"x+\"", "marker = \"tip\"")
    };
    // CalculiX with the same bricks: equal to the digits that it prints, and to what the modes left out move the lowest ones.
    let same = 1e-6;
    let level = &LEVEL[..2];
    let found = frequencies(&[IMPORTED, &at(CLAMP)], level);
    assert_close("clamped", &found, &CLAMPED_BRICKS, same);
    let hinged = [0.0, 272.0491, 399.8365];
    assert_close("hinged", &frequencies(&[IMPORTED, &at(HINGE)], level), &hinged, same);
    let both = frequencies(&[IMPORTED, &at(HINGE), &at(OTHER_HINGE)], level);
    assert_close("two hinges", &both, &HINGED_BRICKS, same);
    // And the bar of splines, unreduced, in a file: the same body.
    let program = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        let output = command.current_dir(folder()).args(arguments).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    };
    let text = format!(
        "{WORLD}{ALUMINIUM}{BEAM}discretisation = {{ degree = 3, elements = [20, 3, 2] }}\nreduction = {{ method = \"modal\", modes = 20 }}\n{CLAMP}"
    );
    std::fs::write(folder().join("spline.toml"), text).unwrap();
    program(&["export-body", "spline.toml", "--body", "beam", "--full", "-o", "spline.h5"]);
    let text =
        format!("{WORLD}{}{}", IMPORTED.replace("bar.h5", "spline.h5"), at(CLAMP).replace("foot", "x-"));
    std::fs::write(folder().join("file.toml"), text).unwrap();
    let printed = |file: &str| -> Vec<f64> {
        let report: Value = serde_json::from_str(&program(&["modes", file, "--system", "--json"])).unwrap();
        report["frequencies"].as_array().unwrap().iter().map(|f| f.as_f64().unwrap()).collect()
    };
    let (spline, file) = (printed("spline.toml"), printed("file.toml"));
    assert_close("splines", &spline, &CLAMPED[..3], CHOSEN);
    // Modes are right to 1e-9 or so.
    assert_close("from a file", &file, &spline[..10], 1e-8);
}

/// Asserts that the clamp bears the weight of the bar and its moment, whatever the place of the frame.
fn assert_reaction(what: &str, text: &str, set: &[&str]) {
    let record = run(&parsed(text, set));
    let joint = &record.samples[0].joints[0];
    let weight = 2700.0 * 0.3 * 0.03 * 0.01 * 9.81;
    // On the bar: up, and about y against the weight at half the length. The mass is exact; the tip sags by 1e-4 of the length, which takes
    // the square of it from the arm.
    let (force, moment) = ([0.0, 0.0, weight], [0.0, -0.15 * weight, 0.0]);
    for c in 0..3 {
        assert!(
            (joint.reaction_force[c] - force[c]).abs() < 1e-6 * weight,
            "{what}: {:?}",
            joint.reaction_force
        );
        let error = (joint.reaction_moment[c] - moment[c]).abs();
        assert!(error < 1e-6 * 0.15 * weight, "{what}: {:?}, {moment:?}", joint.reaction_moment);
    }
}

#[test]
fn reaction_of_the_clamp_is_weight_and_its_moment() {
    let text = format!("{WORLD}{ALUMINIUM}{BEAM}{CLAMP}");
    assert_reaction("average", &text, &[]);
    assert_reaction("rigid", &text, &["joints.clamp.child.coupling=rigid", LEVEL[2]]);
    solid_file::write_bar(&folder().join("reaction.h5"), [10, 2, 1]);
    let file = IMPORTED.replace("bar.h5", "reaction.h5");
    assert_reaction(
        "file",
        &format!("{WORLD}{file}{}", CLAMP.replace("face = \"x-\"", "marker = \"foot\"")),
        &[],
    );
}

#[test]
fn chosen_sizes_are_those_of_every_command() {
    let free = ["joints.clamp.type=free", "simulation.static_start=false"];
    let scenario = parsed(&format!("{WORLD}{ALUMINIUM}{BEAM}{CLAMP}"), &free);
    let body = modes(&scenario, None, 1).unwrap().bodies.swap_remove(0);
    let (_, system) = system_modes(&scenario, false, 1).unwrap();
    // As many coordinates as the body has, and six of its motion.
    assert_eq!(system.modes.len(), body.frequencies.len() + 6);
}
