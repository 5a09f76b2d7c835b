//! What is refused or told whatever the model of a contact, the surface or the command.

use adaptive::record::warning::WarningKind;
use adaptive::spec::Treatment;
use fbimpact::scenario::keys::Named;
use fbimpact::scenario::tables::{BodyModel, ContactModel};

use super::{recorded, tried};
use crate::refused_alike::{Partner, pair};
use crate::support::fbimpact;

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
