//! What is asked of a contact beside its force, of every kind of contact: right, refused, or told.

use adaptive::record::warning::WarningKind;
use adaptive::record::{ImpactRecord, PeakOf};
use adaptive::run::recording::Recording;
use adaptive::spec::Treatment;
use fbimpact::scenario::keys::Named;
use fbimpact::scenario::tables::{BodyModel, ContactModel};
use fbimpact::simulate::simulate;

use crate::refused_alike::{Partner, pair};
use crate::support::fbimpact;
use crate::support::scenarios::{folder, run, valid};

/// What a run records, or why it fails.
fn tried(text: &str, set: &[&str]) -> Result<Recording, String> {
    let scenario = valid(&folder("one_contact"), text, set);
    let mut recording = Recording::default();
    simulate(&scenario, &mut recording, 1).map(|_| recording).map_err(|error| error.to_string())
}

fn recorded(text: &str, set: &[&str]) -> Recording {
    run(&valid(&folder("one_contact"), text, set))
}

fn is_told(recording: &Recording, kind: WarningKind) -> bool {
    recording.warnings.iter().any(|warning| warning.kind == kind)
}

/// The last record of each impact: that of one that goes on comes again.
fn impacts(recording: &Recording) -> Vec<ImpactRecord> {
    let mut rows: Vec<ImpactRecord> = Vec::new();
    for record in &recording.impacts {
        rows.retain(|row| row.row != record.row);
        rows.push(*record);
    }
    rows
}

/// A ball of 10 mm that meets a floor with 0.1 m/s.
const BALL: &str = r#"
[simulation]
end_time = 1.2e-4
[materials.aluminium]
youngs_modulus = 72.8e9
poissons_ratio = 0.33
density = 2789.0
[bodies.ball]
model = "axisymmetric"
material = "aluminium"
geometry = { shape = "sphere", radius = 10.0e-3 }
position = [0.0, 0.0, 10.000001e-3]
velocity = [0.0, 0.0, -0.1]
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
[contacts.c]
contact_body = "ball"
target_body = "floor"
[output.stress.axis]
body = "ball"
from = [0.0, -10.0e-3]
to = [0.0, -9.5e-3]
samples = 11
at = "peak-force"
[output.points.pole]
body = "ball"
marker = "bottom"
stress = true
"#;

/// The impact of that ball by Hertz' theory.
struct HertzBall {
    force: f64,
    duration: f64,
    pressure: f64,
    /// Largest of von Mises on the axis.
    stress: f64,
}

impl HertzBall {
    /// m = 11.68 g, E* = 81.7 GPa; k = 4/3 E* √R, δ = (5 m v²/(4 k))^0.4, F = k δ^1.5, T = 2.9432 δ/v, a = √(R δ),
    /// p0 = 3 F/(2 π a²); von Mises' stress on the axis is at most 0.62 p0 (Johnson 3.45).
    fn new() -> Self {
        let (radius, speed) = (0.01_f64, 0.1_f64);
        let mass = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * 2789.0;
        let k = 4.0 / 3.0 * 72.8e9 / (1.0 - 0.33 * 0.33) * radius.sqrt();
        let depth = (1.25 * mass * speed * speed / k).powf(0.4);
        let (force, duration) = (k * depth.powf(1.5), 2.9432 * depth / speed);
        let pressure = 1.5 * force / (std::f64::consts::PI * radius * depth);
        // s = z/a: (1 + ν)(1 - s atan(1/s)) - 3/(2(1 + s²)) of the difference of the principal stresses.
        let difference = |s: f64| (1.33 * (1.0 - s * (1.0 / s).atan()) - 1.5 / (1.0 + s * s)).abs();
        let share = (1..300).map(|i| difference(0.01 * f64::from(i))).fold(0.0, f64::max);
        Self { force, duration, pressure, stress: pressure * share }
    }
}

/// Whether zones of a model have vibrations of their own, which cost many times as much.
fn vibrates(model: ContactModel) -> bool {
    model.is(Treatment::is_vibrating)
}

#[test]
fn what_comes_out_of_an_impact_is_right_or_told_whatever_its_model() {
    right_or_told(|model| !vibrates(model));
}

#[test]
#[ignore = "second tier: ten seconds"]
fn what_comes_out_of_an_impact_whose_zone_vibrates_is_right_or_told() {
    right_or_told(vibrates);
}

/// What comes out of an impact; a variant asks for its value by Hertz' theory and its limit.
#[derive(Debug, Clone, Copy)]
enum Output {
    Peak,
    Duration,
    Pressure,
    Stress,
    Balance,
}

impl Output {
    const ALL: [Self; 5] = [Self::Peak, Self::Duration, Self::Pressure, Self::Stress, Self::Balance];

    /// What `recording` has of it over what Hertz' theory has, less one; and what that may be.
    fn error(self, recording: &Recording) -> (f64, f64) {
        let HertzBall { force, duration, pressure, stress } = HertzBall::new();
        let impact = impacts(recording)[0];
        match self {
            Self::Peak => (impact.peak_force / force - 1.0, 0.01),
            Self::Duration => ((impact.end - impact.start) / duration - 1.0, 0.02),
            Self::Pressure => {
                let points = recording.samples.iter().flat_map(|sample| &sample.pressures[0]);
                let largest = points.map(|point| point.pressure).fold(0.0, f64::max);
                // Laws without points have none, and say so by an empty list.
                (if largest > 0.0 { largest / pressure - 1.0 } else { 0.0 }, 0.1)
            }
            Self::Stress => {
                let line = recording.stresses[0].von_mises.iter();
                (line.fold(0.0_f64, |most, s| most.max(*s)) / stress - 1.0, 0.05)
            }
            Self::Balance => (recording.energy_drift(), 1e-5),
        }
    }

    /// Warnings that tell a user of a wrong one.
    fn told_by(self) -> &'static [WarningKind] {
        match self {
            Self::Peak | Self::Duration | Self::Pressure => {
                &[WarningKind::CoarseZone, WarningKind::YieldsTwice]
            }
            Self::Stress => &[WarningKind::LocalStress, WarningKind::CoarseZone],
            Self::Balance => &[],
        }
    }
}

/// Every output under every model of a contact that is `chosen`: right, refused, or told.
fn right_or_told(chosen: impl Fn(ContactModel) -> bool) {
    for model in ContactModel::VALUES.iter().copied().filter(|&model| chosen(model)) {
        let name = model.name();
        let Ok(recording) = tried(BALL, &[&format!("contacts.c.model=\"{name}\"")]) else { continue };
        for output in Output::ALL {
            let (error, limit) = output.error(&recording);
            let is_told = output.told_by().iter().any(|kind| is_told(&recording, *kind));
            println!("{name}, {output:?}: {error:+.4}{}", if is_told { ", told" } else { "" });
            assert!(error.abs() < limit || is_told, "{name}, {output:?}: {error:+.4} without a word");
        }
        let warnings = recording.warnings.iter().filter(|warning| warning.kind == WarningKind::LocalStress);
        let told: Vec<&str> = warnings.map(|warning| warning.subject.as_str()).collect();
        let expected: &[&str] = match model {
            ContactModel::Hertz | ContactModel::Coarse => &["output.points.pole", "output.stress.axis"],
            ContactModel::Adaptive
            | ContactModel::Quasistatic
            | ContactModel::Massless
            | ContactModel::Damped
            | ContactModel::Dynamic => &[],
        };
        assert_eq!(told, expected, "{name}");
    }
}

/// Bodies that approach each other faster than waves are refused under every model of a contact.
#[test]
fn no_model_of_a_contact_takes_bodies_faster_than_waves() {
    for &model in ContactModel::VALUES {
        let zone = if model.is(Treatment::is_vibrating) {
            "interval = { width = 2e-3, elements = 4 }\n"
        } else {
            ""
        };
        let contact = format!("model = \"{}\"\n{zone}", model.name());
        let text = pair(BodyModel::Axisymmetric, Partner::Plane, &contact);
        let told = tried(&text.expect("a pair"), &["bodies.own.velocity=[0.0, 0.0, -6000.0]"]);
        let told = told.err().unwrap_or_default();
        assert!(told.contains("approach each other"), "{model:?}: {told}");
    }
}

/// Two bodies under Hertz's law, the one that moves being the target if `is_target`.
fn under_hertz(shape: &str, is_target: bool, speed: f64) -> String {
    let (own, other) = if is_target { ("floor", "ball") } else { ("ball", "floor") };
    format!(
        r#"
[simulation]
end_time = 6.0e-5
[materials.aluminium]
youngs_modulus = 72.8e9
poissons_ratio = 0.33
density = 2789.0
[bodies.ball]
model = "rigid"
material = "aluminium"
geometry = {shape}
position = [0.0, 0.0, 10.0003e-3]
velocity = [0.0, 0.0, -{speed:?}]
[bodies.floor]
model = "rigid"
material = "aluminium"
geometry = {{ shape = "ellipsoid", semi_axes = [0.3, 0.3, 0.3] }}
position = [0.0, 0.0, -0.3]
[contacts.c]
contact_body = "{own}"
target_body = "{other}"
model = "hertz"
"#
    )
}

/// What a run under Hertz's law is refused for does not depend on how a surface is written, nor on which body is the target.
#[test]
fn guards_hold_for_all_surfaces_under_hertz_law() {
    let shapes = [
        "{ shape = \"sphere\", radius = 10.0e-3 }",
        "{ shape = \"ellipsoid\", semi_axes = [10.0e-3, 10.0e-3, 10.0001e-3] }",
    ];
    // Slow; a contact wider than half the radius; faster than waves, 5.1 km/s.
    let speeds =
        [(1.0, None), (600.0, Some("over the radius of curvature")), (6000.0, Some("approach each other"))];
    for shape in shapes {
        for is_target in [false, true] {
            for (speed, refused) in speeds {
                let outcome = tried(&under_hertz(shape, is_target, speed), &[]);
                let what = format!("{shape}, {is_target}, {speed} m/s");
                match (outcome, refused) {
                    (Ok(_), None) => {}
                    (Err(error), Some(words)) => assert!(error.contains(words), "{what}: {error}"),
                    (Ok(_), Some(_)) => panic!("{what}: complete"),
                    (Err(error), None) => panic!("{what}: {error}"),
                }
            }
        }
    }
}

const PRESS: &str = r#"
[simulation]
end_time = 3e-4
[bodies.ball]
model = "axisymmetric"
material = "steel"
geometry = { shape = "sphere", radius = 0.01 }
[joints.press]
type = "axial"
parent = { body = "ground", point = [0.0, 0.0, 0.0100001] }
child = { body = "ball", point = [0.0, 0.0], radius = 0.004 }
motion = { kind = "polynomial", coefficients = [0.0, -0.01] }
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
[contacts.c]
contact_body = "ball"
target_body = "floor"
"#;

/// A press that goes on at the end of the run has a zone that fits the force it has reached: 2.9 µm at its end, and what it
/// passed on the way, with four elements of the zone at 0.6 µm. (The ball yields by some 1 % of that as a whole.)
#[test]
fn a_ball_that_is_pressed_till_the_end_obeys_hertz() {
    let k = 4.0 / 3.0 * 210e9 / (1.0 - 0.09) * 0.01_f64.sqrt();
    for model in [ContactModel::Adaptive, ContactModel::Quasistatic, ContactModel::Massless] {
        let recording = recorded(PRESS, &[&format!("contacts.c.model=\"{}\"", model.name())]);
        for time in [7e-5, 2e-4, 3e-4] {
            let force = 0.01 * (time - 1e-5);
            let force = k * f64::powf(force, 1.5);
            let at = |s: &&adaptive::record::Sample| (s.time - time).abs();
            let nearest = recording.samples.iter().min_by(|a, b| at(a).total_cmp(&at(b))).expect("a sample");
            // Instants are a fraction of a per cent of the time apart.
            let expected = force * ((nearest.time - 1e-5) / (time - 1e-5)).powf(1.5);
            let error = nearest.contacts[0].normal_force / expected - 1.0;
            println!("{}: {error:+.4} at {time:e} s", model.name());
            assert!(error.abs() < 0.015, "{}: {error:+.4} at {time:e} s", model.name());
        }
        // Steel yields under a quarter of this pressure.
        let is_known = recording.warnings.iter().all(|warning| warning.kind == WarningKind::Yields);
        assert!(is_known, "{:?}", recording.warnings);
    }
}

/// A ball that a damper brakes before it touches: Hertz's equation of motion, integrated apart, has a peak of 19.84 N and
/// lasts for 115.6 µs, whatever the model of the contact.
#[test]
fn a_zone_that_nobody_gave_fits_the_touch_and_not_the_start() {
    let text = BALL
        .split("[output.stress")
        .next()
        .expect("a part")
        .replace("end_time = 1.2e-4", "end_time = 4e-3\nstop_after_impacts = 1");
    let text = text
        .replace("72.8e9", "210e9")
        .replace("0.33", "0.3")
        .replace("2789.0", "7850.0")
        .replace("position = [0.0, 0.0, 10.000001e-3]\nvelocity = [0.0, 0.0, -0.1]\n", "")
        + "[joints.s]\ntype = \"axial\"\nparent = { body = \"ground\", point = [0.0, 0.0, 0.011] }\n\
           child = { body = \"ball\", point = [0.0, 0.0], radius = 0.004 }\nvelocity = -2.0\ndamping = 65.1\n";
    for model in [ContactModel::Adaptive, ContactModel::Quasistatic, ContactModel::Massless] {
        let recording = recorded(&text, &[&format!("contacts.c.model=\"{}\"", model.name())]);
        let impact = impacts(&recording)[0];
        let (peak, duration) =
            (impact.peak_force / 19.84 - 1.0, (impact.end - impact.start) / 115.6e-6 - 1.0);
        println!("{}: peak {peak:+.4}, duration {duration:+.4}", model.name());
        assert!(peak.abs() < 1e-2 && duration.abs() < 1e-2, "{}: {peak:+.4}, {duration:+.4}", model.name());
    }
}

const BAR: &str = r#"
[simulation]
end_time = 1.2e-4
[bodies.ball]
model = "plane-stress"
thickness = 0.01
material = "steel"
geometry = { shape = "disc", radius = 0.01 }
position = [-0.0100001, 0.0, 0.0]
velocity = [1.0, 0.0, 0.0]
[joints.j0]
type = "planar"
axis = [0.0, 0.0, 1.0]
reference = [1.0, 0.0, 0.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "b1", face = "x-" }
[contacts.c]
contact_body = "ball"
target_body = "b1"
"#;

/// A bar rebounds as a bar, whether it is one body or two that are joined.
#[test]
fn bodies_that_are_fixed_to_each_other_rebound_as_one() {
    let bar = |name: &str, length: f64| {
        format!(
            "[bodies.{name}]\nmodel = \"plane-stress\"\nthickness = 0.01\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"rectangle\", size = [{length:?}, 0.01] }}\n"
        )
    };
    let joint = "[joints.j]\ntype = \"fixed\"\nparent = { body = \"b1\", face = \"x+\" }\nchild = { body = \"b2\", face = \"x-\" }\n";
    let restitution = |text: &str| impacts(&recorded(text, &[]))[0].restitution;
    let whole = restitution(&(BAR.to_owned() + &bar("b1", 0.2)));
    let halves = restitution(&[BAR, &bar("b1", 0.1), &bar("b2", 0.1), joint].concat());
    println!("{whole} {halves}");
    // Of other elements and modes; by the motion of the half alone it was 17 % more.
    assert!((halves / whole - 1.0).abs() < 5e-3, "{whole} {halves}");
}

/// A row is that of the whole impact, whether the run goes on behind it or not; if it ends before, it has no ratio.
#[test]
fn a_run_that_ends_after_an_impact_has_its_whole_row() {
    let text = r#"
[simulation]
end_time = 1.6e-4
[bodies.a]
model = "plane-stress"
thickness = 0.005
material = "steel"
geometry = { shape = "disc", radius = 0.012 }
position = [0.0, 0.0120001, 0.0]
velocity = [0.0, -0.3, 0.0]
angular_velocity = [0.0, 0.0, 12.5]
[bodies.b]
model = "plane-stress"
thickness = 0.005
material = "aluminium"
geometry = { shape = "rectangle", size = [0.072, 0.012] }
position = [0.0, -0.006, 0.0]
[contacts.c]
contact_body = "a"
target_body = "b"
"#;
    let row = |set: &[&str]| impacts(&recorded(text, set))[0];
    let (long, stopped) = (row(&[]), row(&["simulation.stop_after_impacts=1"]));
    assert!(long.restitution > 0.8, "{long:?}");
    let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12; // the same steps
    assert!(
        same(long.restitution, stopped.restitution) && same(long.impulse, stopped.impulse),
        "{long:?} {stopped:?}"
    );
    // Between the first touch of it, which lasts for 27 µs, and the second.
    let short = row(&["simulation.end_time=3.2e-5"]);
    assert!(short.restitution.is_nan() && short.end < 3.2e-5, "{short:?}");
}

/// A mass that meets two stops 8 and 10 ms after the start, one for each direction: `v t`.
#[test]
fn hits_of_stops_begin_where_they_are_met() {
    let text = r#"
[simulation]
end_time = 0.05
[bodies.m]
model = "rigid"
mass = 1.0
inertia = [1e-3, 1e-3, 1e-3]
[joints.s]
type = "planar"
axis = [0.0, 0.0, 1.0]
reference = [1.0, 0.0, 0.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "m", point = [0.0, 0.0, 0.0] }
velocities = [1.0, 0.5, 0.0]
[[joints.s.stops]]
coordinate = 0
upper = 0.01
stiffness = 1e6
[[joints.s.stops]]
coordinate = 1
upper = 0.004
stiffness = 2e6
"#;
    let rows = impacts(&recorded(text, &[]));
    // Undamped: half a period of a mass on a spring.
    for (row, (start, stiffness, speed)) in rows.iter().zip([(8e-3, 2e6_f64, 0.5), (10e-3, 1e6, 1.0)]) {
        let duration = std::f64::consts::PI / stiffness.sqrt();
        let errors = [
            row.start / start,
            (row.end - row.start) / duration,
            row.approach_velocity / speed,
            row.restitution,
        ];
        // Steps follow the force of a hit to 1e-6 (TR-BDF2).
        errors.iter().for_each(|ratio| assert!((ratio - 1.0).abs() < 1e-4, "{errors:?}"));
    }
    assert_eq!(rows.len(), 2);
}

/// A ball between two plates, where ten steps are longer than the flight from one to the other.
#[test]
fn impacts_that_are_far_apart_end_their_phases() {
    let plate = |name: &str, z: f64, normal: f64| {
        format!(
            "[bodies.{name}]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nposition = [0.0, 0.0, {z:?}]\n\
             normal = [0.0, 0.0, {normal:?}]\n[contacts.{name}]\ncontact_body = \"ball\"\ntarget_body = \"{name}_\"\nmodel = \"hertz\"\n"
        )
        .replace(&format!("[bodies.{name}]"), &format!("[bodies.{name}_]"))
    };
    let text = "[simulation]\nend_time = 2e-2\n[bodies.ball]\nmodel = \"rigid\"\nmaterial = \"steel\"\n\
                geometry = { shape = \"sphere\", radius = 5e-3 }\nvelocity = [0.0, 0.0, 1.0]\n"
        .to_owned();
    let recording = recorded(&(text + &plate("below", -5.5e-3, 1.0) + &plate("above", 5.5e-3, -1.0)), &[]);
    let mut rows = impacts(&recording);
    rows.retain(|row| row.end < 2e-2); // the end of the run cuts the last one off
    assert!(rows.len() >= 15, "{} rows", rows.len());
    let peak = rows[0].peak_force;
    // Parabolas through steps of 1e-8.
    rows.iter().for_each(|row| assert!((row.peak_force / peak - 1.0).abs() < 1e-3, "{row:?}"));
    assert!(recording.phases.len() >= 2 * rows.len() - 1, "{} phases", recording.phases.len());
}

const DISC: &str = r#"
[simulation]
end_time = 1e-4
[bodies.d]
model = "plane-stress"
thickness = 0.01
material = "steel"
geometry = { shape = "disc", radius = 0.1 }
angular_velocity = [0.0, 0.0, 1000.0]
reduction = { modes = 20 }
[output]
free_interval = 5e-6
[output.points.centre]
body = "d"
marker = "centre"
stress = true
"#;

/// A disc that spins has the stress (3 + ν)/8 ρ ω² R² in its middle: at once with a static start, else it is told that it rings.
#[test]
fn a_spin_given_at_the_start_is_in_equilibrium_or_told() {
    let expected = 3.3 / 8.0 * 7850.0 * 1e6 * 0.01;
    let stresses = |recording: &Recording| -> Vec<f64> {
        recording.samples.iter().map(|sample| sample.points[0].state.stress[0]).collect()
    };
    let sudden = recorded(DISC, &[]);
    assert!(is_told(&sudden, WarningKind::SuddenSpin), "{:?}", sudden.warnings);
    let resting = recorded(DISC, &["simulation.static_start=true"]);
    assert!(!is_told(&resting, WarningKind::SuddenSpin));
    // 20 modes and one static answer; the mesh is right to a per mille.
    stresses(&resting).iter().for_each(|s| assert!((s / expected - 1.0).abs() < 1e-2, "{s:e} {expected:e}"));
}

/// `check` refuses what a run refuses, and `modes` tells what a run tells.
#[test]
fn what_a_run_refuses_or_tells_other_commands_do_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = |z: f64| {
        format!(
            r#"
[simulation]
end_time = 1e-4
[bodies.a]
model = "solid"
geometry = {{ shape = "box", size = [0.02, 0.02, 0.02] }}
discretisation = {{ elements = [2, 2, 2], degree = 2 }}
material = "steel"
reduction = {{ modes = 4 }}
[bodies.a.markers]
pin = {{ point = [0.0, 0.0, {z:?}], radius = 2e-3 }}
[joints.j]
type = "fixed"
parent = {{ body = "ground", point = [0.0, 0.0, 0.0] }}
child = {{ body = "a", marker = "pin" }}
"#
        )
    };
    let told = |command: &[&str], z: f64| {
        let path = folder.path().join("a.toml");
        std::fs::write(&path, text(z)).expect("written");
        let path = path.display().to_string();
        let (code, _, told) = fbimpact(&[command, &[path.as_str()]].concat());
        (code, told)
    };
    for command in [&["check"][..], &["run"], &["modes"], &["modes", "--system"]] {
        let (code, words) = told(command, 0.00975);
        assert!(code != 0 && words.contains("reaches beyond the body"), "{command:?}: {code} {words}");
    }
    for command in [&["run"][..], &["modes"], &["modes", "--system"]] {
        let (code, words) = told(command, 0.01);
        assert!(code == 0 && words.contains("coarse-place"), "{command:?}: {code} {words}");
    }
}

/// A disc of 10 mm pressed on a floor by a spring of `force` N on a slide, turned by `angle`; positive forces
/// press.
fn bolt(force: f64, angle: f64) -> String {
    let (c, s) = (angle.cos(), angle.sin());
    format!(
        "[simulation]\nend_time = 2e-7\nstatic_start = true\n\
[bodies.a]\nmodel = \"plane-strain\"\nthickness = 0.02\nmaterial = \"steel\"\ngeometry = {{ shape = \"disc\", radius = 10e-3 }}\n\
discretisation = {{ elements = [4, 4] }}\nreduction = {{ modes = 6 }}\n\
[joints.bolt]\ntype = \"prismatic\"\naxis = [{:?}, {c:?}, 0.0]\nparent = {{ body = \"ground\", point = [{:?}, {:?}, 0.0] }}\n\
child = {{ body = \"a\", point = [0.0, 0.0], radius = 3e-3 }}\nstiffness = 1e6\nrest = {:?}\n\
[bodies.floor]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nnormal = [{:?}, {c:?}, 0.0]\n\
[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"floor\"\n",
        -s,
        -s * 0.01,
        c * 0.01,
        -force / 1e6,
        -s
    )
}

#[test]
fn a_contact_that_is_pressed_at_a_start_in_equilibrium_is_told_in_any_pose() {
    // The equilibrium lifts the touched side of the disc by nanometres.
    for (force, angle) in [(1000.0, 0.0), (1000.0, 0.7), (1.0, 0.0)] {
        let recording = recorded(&bolt(force, angle), &[]);
        assert!(
            is_told(&recording, WarningKind::StaticContact),
            "{force} N at {angle}: {:?}",
            recording.warnings
        );
    }
    // Without a force nothing is told; a pull, which moves the touched side into the floor, is refused.
    assert!(!is_told(&recorded(&bolt(0.0, 0.7), &[]), WarningKind::StaticContact));
    assert!(tried(&bolt(-1000.0, 0.7), &[]).is_err_and(|error| error.contains("overlap")));
}

/// A steel ball of 10 mm against a rigid floor by Hertz's law, and the speed from which on it yields.
#[test]
fn pressure_and_stress_beyond_what_a_material_bears_are_told() {
    let text = "[simulation]\nend_time = 4e-4\n[bodies.a]\nmodel = \"rigid\"\nmaterial = \"steel\"\n\
geometry = { shape = \"sphere\", radius = 0.01 }\nposition = [0.0, 0.0, 0.0100001]\nvelocity = [0.0, 0.0, -1.0]\n\
[bodies.b]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\n\
[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\nmodel = \"hertz\"\n";
    let told = |set: &[&str]| {
        let recording = recorded(text, set);
        let found = recording.warnings.iter().find(|warning| warning.kind == WarningKind::Yields);
        found.map(|warning| (warning.value, warning.limit, warning.message.clone()))
    };
    let (pressure, limit, message) = told(&[]).expect("a warning");
    // p0 = 3/2 F/(π a²) with E* = 230.8 GPa, R = 10 mm, m = 32.9 g: a³ = 3 F R/(4 E*).
    let (modulus, radius, mass) = (210e9 / 0.91, 0.01_f64, 4.0 / 3.0 * std::f64::consts::PI * 1e-6 * 7850.0);
    let k = 4.0 / 3.0 * modulus * radius.sqrt();
    let depth = (1.25 * mass / k).powf(0.4);
    let expected = 1.5 * k * depth.powf(1.5) / (std::f64::consts::PI * radius * depth);
    // The end of the step that is nearest to the peak.
    assert!((pressure / expected - 1.0).abs() < 5e-3, "{pressure:e} for {expected:e}");
    assert!((limit - 1.6 * 355e6).abs() < 1.0 && message.contains("355 MPa"), "{limit} {message}");
    // At the speed that is told, and for a material that bears it, nothing is said.
    let speed = (limit / expected).powf(2.5);
    assert!(message.contains(&format!("some {speed:.1e} m/s")), "{message}");
    assert_eq!(told(&[&format!("bodies.a.velocity=[0.0, 0.0, {:?}]", -0.98 * speed)]), None);
    assert!(told(&[&format!("bodies.a.velocity=[0.0, 0.0, {:?}]", -1.02 * speed)]).is_some());
    assert_eq!(told(&["materials.steel.yield_strength=\"4 GPa\""]), None);
}

/// A clamped strip that is shaken: largest moment at the clamp.
#[test]
fn peaks_of_reactions_do_not_depend_on_when_states_are_stored() {
    let text = "[simulation]\nend_time = 0.02\n\
[bodies.beam]\nmodel = \"plane-stress\"\nthickness = 0.025\nmaterial = \"aluminium\"\n\
geometry = { shape = \"rectangle\", size = [0.3, 8e-3] }\ndamping = { modal = 0.01 }\nreduction = { modes = 4 }\n\
[joints.clamp]\ntype = \"fixed\"\nparent = { body = \"ground\" }\nchild = { body = \"beam\", face = \"start\", coupling = \"rigid\" }\n\
[loads.push]\nbody = \"beam\"\npoint = [0.05, 0.004]\nradius = 3e-3\n\
force_y = { kind = \"harmonic\", amplitude = 100.0, frequency = 300.0 }\n";
    let peak = |interval: f64| {
        let recording = recorded(text, &[&format!("output.free_interval={interval:?}")]);
        let moments = recording.peaks.iter().find(|peak| peak.of == PeakOf::ReactionMoment).expect("a joint");
        let stored =
            recording.samples.iter().map(|s| nalgebra::Vector3::from(s.joints[0].reaction_moment).norm());
        (moments.value, stored.fold(0.0, f64::max))
    };
    let ((rare, shown), (often, all)) = (peak(3e-3), peak(1e-5));
    println!("{rare} N m of all steps, {shown} stored; {often}, {all}");
    // A step of the fourth order resolves a period by thirty and more: its ends miss a top by (π/30)²/2 at most.
    assert!((rare / all - 1.0).abs() < 6e-3 && (often / all - 1.0).abs() < 6e-3, "{rare} {often} {all}");
    assert!(shown < 0.97 * all, "{shown} {all}");
}
