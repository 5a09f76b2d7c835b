//! `fbimpact modes --system` and reactions of joints against closed forms of beams and pendulums.

use crate::beam_file;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::beam_file::{BENDING, LENGTH, LINE_MASS, write_beam};
use adaptive::run::recording::Recording;
use assert_cmd::Command;
use fbimpact::scenario::{self, Scenario};
use fbimpact::simulate::{simulate, system_modes};
use serde_json::Value;

/// A beam from the file of another program, with every mode that it has.
const BEAM: &str = r#"
[simulation]
end_time = 1e-6
[bodies.beam]
model = "imported"
file = "beam.h5"
reduction = { method = "all" }
"#;

const CLAMP: &str = r#"
[joints.clamp]
type = "fixed"
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "beam", marker = "hinge" }
"#;

const HINGE: &str = r#"
[joints.hinge]
type = "revolute"
axis = [0.0, 0.0, 1.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "beam", marker = "hinge" }
"#;

/// The same beam once more, fixed to the tip of the first.
const SECOND: &str = r#"
[bodies.second]
model = "imported"
file = "beam.h5"
reduction = { method = "all" }
[joints.weld]
type = "fixed"
parent = { body = "beam", marker = "tip" }
child = { body = "second", marker = "hinge" }
"#;

/// A uniform rod of 0.9 m and 2 kg on a hinge at its end, hanging along -z.
const PENDULUM: &str = r#"
[simulation]
end_time = 0.4
gravity = [0.0, 0.0, -9.81]
[bodies.rod]
model = "rigid"
mass = 2.0
inertia = [0.135, 0.135, 1e-4]
centre_of_mass = [0.0, 0.0, -0.45]
[joints.hinge]
type = "revolute"
axis = [0.0, 1.0, 0.0]
angle = 0.872664625997164788
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "rod", point = [0.0, 0.0, 0.0] }
[output]
free_interval = 1e-2
"#;

/// Error of a frequency by cubic beam elements of length `h`, relative: at most `(β h)⁴ / 720`; `beta` is that of a beam of `length`.
fn element_error(beta: f64, length: f64) -> f64 {
    (beta / length * LENGTH / beam_file::ELEMENTS as f64).powi(4) / 720.0
}

fn files() -> &'static Path {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("system_modes");
        std::fs::create_dir_all(&directory).unwrap();
        write_beam(&directory.join("beam.h5"));
        directory
    })
}

fn parse(text: &str, set: &[&str]) -> Scenario {
    let overrides: Vec<_> = set.iter().map(|s| s.parse().unwrap()).collect();
    scenario::parse(&files().join("case.toml"), text.as_bytes(), &overrides).unwrap()
}

/// Frequencies of the system \[Hz\], rigid motions as zeros.
fn frequencies(text: &str, set: &[&str]) -> Vec<f64> {
    let (_, system) = system_modes(&parse(text, set), false, 1).unwrap();
    system.modes.iter().map(|m| m.frequency()).collect()
}

/// Bending frequency of a beam of `length` with the eigenvalue `beta` (times the length).
fn bending(beta: f64, length: f64) -> f64 {
    (beta / length).powi(2) * (BENDING / LINE_MASS).sqrt() / TAU
}

/// Asserts that the first frequencies are `rigid` zeros and the bending modes `betas`; longitudinal ones are far above.
fn assert_bending(found: &[f64], rigid: usize, betas: &[f64], length: f64) {
    assert!(found[..rigid].iter().all(|f| f.abs() <= 0.0) && found[rigid] > 0.0, "{rigid} zeros: {found:?}");
    for (found, beta) in found[rigid..].iter().zip(betas) {
        let expected = bending(*beta, length);
        assert!(
            (found / expected - 1.0).abs() < element_error(*beta, length) + 1e-9,
            "{found} Hz, {expected} Hz"
        );
    }
}

#[test]
fn beam_free_hinged_and_clamped() {
    assert_bending(&frequencies(BEAM, &[]), 3, &[4.730_040_745, 7.853_204_624, 10.995_607_84], LENGTH);
    let hinged = BEAM.to_owned() + HINGE;
    assert_bending(&frequencies(&hinged, &[]), 1, &[3.926_602_312, 7.068_582_746, 10.210_176_12], LENGTH);
    let clamped = BEAM.to_owned() + CLAMP;
    for frame in ["buckens", "tangent"] {
        let set = format!("bodies.beam.frame={frame}");
        let found = frequencies(&clamped, &[&set]);
        assert_bending(&found, 0, &[1.875_104_069, 4.694_091_133, 7.854_757_438], LENGTH);
    }
}

/// Tip of a clamped beam with the eigenvalue `beta`: displacement and slope of the mode of unit mass.
fn tip(beta: f64) -> (f64, f64) {
    let (ch, sh, c, s) = (beta.cosh(), beta.sinh(), beta.cos(), beta.sin());
    let sigma = (sh - s) / (ch + c);
    let (value, slope) = (ch - c - sigma * (sh - s), beta * (sh + s - sigma * (ch - c)));
    let scale = 1.0 / (LINE_MASS * LENGTH).sqrt();
    (scale * value, scale * slope / LENGTH)
}

#[test]
fn only_following_loads_leave_stiffness_out() {
    // The weight of a clamped beam does not depend on its pose: what differences find of its stiffness is round-off.
    let clamped = BEAM.to_owned() + CLAMP;
    for frame in ["buckens", "tangent"] {
        let set = [&format!("bodies.beam.frame={frame}"), "simulation.gravity=[0.0,-9.81,0.0]"];
        let (_, system) = system_modes(&parse(&clamped, &set), false, 1).unwrap();
        // Forces of 10 N by steps of a thousandth, beside 0.9 Hz: 1e-16 · 10 N / 1e-3 m / (3 kg · 30 s⁻²).
        assert!(system.asymmetry < 1e-12, "{frame}: {}", system.asymmetry);
    }
    // Beck's column: a force along the tip that turns with it has the skew part P/2 (φ_i φ_j' - φ_j φ_i'), largest between the first modes.
    let push = "\n[loads.push]\nbody = \"beam\"\nmarker = \"tip\"\nforce_x = -0.1\nfollowing = true\n";
    let (_, system) = system_modes(&parse(&(clamped + push), &[]), false, 1).unwrap();
    let betas = [1.875_104_069, 4.694_091_133];
    let ([(a, a_slope), (b, b_slope)], [f, g]) =
        (betas.map(tip), betas.map(|beta| TAU * bending(beta, LENGTH)));
    let expected = 0.05 * (a * b_slope - b * a_slope).abs() / (f * g);
    // The symmetric part moves modes and frequencies, by P over the load at which the column buckles.
    let shift = 0.1 / (BENDING * (0.5 * std::f64::consts::PI / LENGTH).powi(2));
    assert!((system.asymmetry / expected - 1.0).abs() < 2.0 * shift, "{} {expected}", system.asymmetry);
}

#[test]
fn two_beams_fixed_together_are_one_of_both_lengths() {
    let text = BEAM.to_owned() + SECOND;
    let (names, system) = system_modes(&parse(&text, &[]), false, 1).unwrap();
    let found: Vec<f64> = system.modes.iter().map(|m| m.frequency()).collect();
    assert_bending(&found, 3, &[4.730_040_745, 7.853_204_624, 10.995_607_84], 2.0 * LENGTH);
    assert_eq!(names, ["beam", "second"]);
    for mode in &system.modes[3..7] {
        // Symmetric and antisymmetric modes: half the energy each, to the digits of the vectors.
        assert!((mode.shares[0] - 0.5).abs() < 1e-6, "{mode:?}");
    }
    // Closed to ground by a loop instead of a tree's joint: clamped.
    let looped = BEAM.to_owned() + &CLAMP.replace("type = \"fixed\"", "type = \"fixed\"\ncloses_loop = true");
    let found = frequencies(&looped, &[]);
    assert_bending(&found, 0, &[1.875_104_069, 4.694_091_133, 7.854_757_438], LENGTH);
}

#[test]
fn clamp_in_static_start_carries_weight_and_its_moment() {
    let text = BEAM.to_owned() + CLAMP;
    // A thousandth of gravity: the beam is soft, and its sag turns it by 3e-4 rad. What that takes of its arm is the square.
    let set = ["simulation.gravity=[0.0,-9.81e-3,0.0]", "simulation.static_start=true"];
    let mut recording = Recording::default();
    simulate(&parse(&text, &set), &mut recording, 1).unwrap();
    assert_eq!(recording.layout.joints[0].name, "clamp");
    let weight = LINE_MASS * LENGTH * 9.81e-3;
    for sample in &recording.samples {
        let joint = &sample.joints[0];
        let (force, moment) = (joint.reaction_force, joint.reaction_moment);
        let error = [force[0], force[1] - weight, force[2]].map(f64::abs);
        assert!(error.iter().all(|e| *e < 1e-6 * weight), "{force:?}, {weight} N");
        let expected = 0.5 * weight * LENGTH;
        let error = [moment[0], moment[1], moment[2] - expected].map(f64::abs);
        assert!(error.iter().all(|e| *e < 1e-6 * expected), "{moment:?}, {expected} N m");
    }
}

#[test]
fn swinging_rod_pulls_at_its_hinge_as_the_closed_form_says() {
    let mut recording = Recording::default();
    simulate(&parse(PENDULUM, &[]), &mut recording, 1).unwrap();
    assert!(recording.samples.len() > 30);
    let (mass, arm, inertia) = (2.0, 0.45, 0.135 + 2.0 * 0.45 * 0.45);
    let start = 50f64.to_radians();
    let mut swing: (f64, f64) = (start, start);
    for sample in &recording.samples {
        let joint = &sample.joints[0];
        let angle = joint.positions[0];
        swing = (swing.0.min(angle), swing.1.max(angle));
        // Conservation of energy gives the rate, and so the pull.
        let squared_rate = 2.0 * mass * 9.81 * arm * (angle.cos() - start.cos()) / inertia;
        let pull = mass * (9.81 * angle.cos() + arm * squared_rate);
        let shear = mass * 9.81 * angle.sin() * (1.0 - mass * arm * arm / inertia);
        // The rod hangs along -z at zero and turns about y.
        let along = [angle.sin(), angle.cos()];
        let expected = [pull * along[0] - shear * along[1], pull * along[1] + shear * along[0]];
        let force = joint.reaction_force;
        let error = (force[0] - expected[0]).hypot(force[2] - expected[1]);
        // Energy drift of the integration: 1e-8 of it by default.
        assert!(error < 1e-6 * mass * 9.81, "{angle}: {force:?} {expected:?}");
        assert!(joint.reaction_moment.iter().all(|m| m.abs() < 1e-12), "{:?}", joint.reaction_moment);
    }
    assert!(swing.1 - swing.0 > 0.5, "it swings: {swing:?}");
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_fbimpact")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn info_and_collect_tell_the_largest_reactions() {
    let folder = files().join("collect");
    std::fs::create_dir_all(&folder).unwrap();
    let at = |name: &str| folder.join(name).display().to_string();
    std::fs::write(at("swing.toml"), PENDULUM).unwrap();
    let (code, _, err) = run(&["run", "-q", &at("swing.toml"), "-o", &at("swing.h5")]);
    assert_eq!(code, 0, "{err}");
    let (_, out, _) = run(&["info", &at("swing.h5"), "--json"]);
    let report: Value = serde_json::from_str(&out).unwrap();
    let peak = report["joints"]["hinge"]["peak_force"].as_f64().unwrap();
    // At the lowest point: m g + m s ω², with ω² from the height of the start, 50°.
    let lowest = 2.0 * 9.81 * (1.0 + 1.5 * (1.0 - 50f64.to_radians().cos()));
    assert!(peak > 2.0 * 9.81 && peak <= lowest * (1.0 + 1e-9), "{peak} N, {lowest} N");
    let (_, out, _) = run(&["info", &at("swing.h5")]);
    let row =
        out.lines().find(|line| line.trim_start().starts_with("hinge ") && line.contains(" force ")).unwrap();
    let shown: f64 = row.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((shown / peak - 1.0).abs() < 1e-5, "six digits: {out}");
    let (code, _, err) = run(&["collect", &at("swing.h5"), "-o", &at("table.csv")]);
    assert_eq!(code, 0, "{err}");
    let table = std::fs::read_to_string(at("table.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|l| l.split(',').collect()).collect();
    let column = rows[0].iter().position(|name| *name == "joints.hinge.peak_force").unwrap();
    assert!((rows[1][column].parse::<f64>().unwrap() / peak - 1.0).abs() < 1e-15, "{table}");
}

#[test]
fn program_prints_frequencies_participation_and_unstable_modes() {
    let path = files().join("pendulum.toml");
    std::fs::write(&path, PENDULUM).unwrap();
    let path = path.display().to_string();
    let hanging = ["modes", &path, "--system", "--json", "--set", "joints.hinge.angle=0.0"];
    let (code, out, err) = run(&hanging);
    assert_eq!(code, 0, "{err}");
    let report: Value = serde_json::from_str(&out).unwrap();
    let expected = (1.5 * 9.81 / 0.9_f64).sqrt() / TAU;
    let found = report["frequencies"][0].as_f64().unwrap();
    assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
    assert_eq!(report["modes"][0]["participation"]["rod"], 1.0);
    assert_eq!((&report["rigid_body_modes"], &report["coordinates"]), (&0.into(), &1.into()));
    assert!(report["acceleration"].as_f64().unwrap() < 1e-12, "{report}");

    let upright = ["modes", &path, "--system", "--set", "joints.hinge.angle=3.14159265358979"];
    let (code, out, err) = run(&upright);
    assert_eq!(code, 0, "{err}");
    assert!(
        out.contains("1 unstable modes") && out.contains("unstable") && out.contains("rod 100.0 %"),
        "{out}"
    );
    let (code, out, _) = run(&["modes", &path, "--system"]);
    assert!(code == 0 && out.contains("the pose is no equilibrium") && !out.contains("potential"), "{out}");

    for wrong in [&["modes", &path, "--static"][..], &["modes", &path, "--system", "--body", "rod"]] {
        assert_eq!(run(wrong).0, 2, "{wrong:?}");
    }
}
