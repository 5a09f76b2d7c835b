//! Static answers to joints and loads in scenarios: with contacts of every model, in the table of modes.

use std::path::Path;

use assert_cmd::Command;
use fbimpact::scenario::{self, Scenario};
use fbimpact::simulate::{BodyModes, modes};

const DISC: &str = include_str!("../scenarios/rotating_disc.toml");
const BALL: &str = include_str!("../scenarios/sphere_on_plane.toml");

fn valid(text: &str, set: &[&str]) -> Scenario {
    let set: Vec<_> = set.iter().map(|s| s.parse().unwrap()).collect();
    scenario::parse(Path::new("case.toml"), text.as_bytes(), &set).unwrap_or_else(|faults| panic!("{faults}"))
}

fn first_body(text: &str, set: &[&str]) -> BodyModes {
    modes(&valid(text, set), None, 1).unwrap().bodies.swap_remove(0)
}

/// The disc on a hinge through its centre, above the plane.
fn hinged_disc() -> String {
    let loose = |line: &&str| {
        !["position =", "velocity =", "angular_velocity ="].iter().any(|key| line.starts_with(key))
    };
    let text: Vec<&str> = DISC.lines().filter(loose).collect();
    text.join("\n")
        + r#"
[joints.pin]
type = "revolute"
axis = [0.0, 0.0, 1.0]
parent = { body = "ground", point = [0.0, 0.10001, 0.0] }
child = { body = "disc", point = [0.0, 0.0], radius = 0.02 }
"#
}

#[test]
fn joints_are_answered_beside_contacts_of_every_model() {
    answered(&hinged_disc(), (10, 2, "pin (child)"));
}

#[test]
fn loads_are_answered_beside_contacts_of_every_model() {
    let pushed = BALL.to_owned()
        + "\n[loads.push]\nbody = \"ball\"\npoint = [0.0, 10.0e-3]\nradius = 1.0e-3\nforce_z = -1.0\n";
    answered(&pushed, (6, 1, "push"));
}

fn answered(text: &str, (n_modes, n_answers, to): (usize, usize, &str)) {
    for model in ["quasistatic", "damped", "dynamic", "coarse"] {
        let body = first_body(text, &[&format!("contacts.impact.model={model}")]);
        let counts = &body.coordinates;
        assert_eq!(counts.free_modes, n_modes, "{model}");
        assert_eq!(counts.interface_modes > 0, ["damped", "dynamic"].contains(&model), "{model}");
        let answers: Vec<_> = counts.static_answers.iter().map(|a| (a.to.as_str(), a.count)).collect();
        assert_eq!(answers, [(to, n_answers)], "{model}");
        assert_eq!(body.frequencies.len(), n_modes + counts.interface_modes + n_answers);
        assert!(body.frequencies.is_sorted());
    }
}

#[test]
fn driven_directions_add_and_the_switch_takes_all_away() {
    let text = hinged_disc();
    let count = |set: &[&str]| {
        let answers = first_body(&text, set).coordinates.static_answers;
        answers.iter().map(|a| a.count).sum::<usize>()
    };
    assert_eq!(count(&["joints.pin.damping=1.0"]), 3);
    assert_eq!(count(&["bodies.disc.reduction.static_answers=false"]), 0);
    assert_eq!(
        count(&["bodies.disc.reduction={method=\"modal\",modes=4}", "contacts.impact.model=coarse"]),
        2
    );
}

#[test]
fn table_of_modes_says_what_coordinates_come_from() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("joint_answers.toml");
    std::fs::write(&file, hinged_disc()).unwrap();
    let output = |json: bool| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        command.arg("modes").arg(&file).args(json.then_some("--json"));
        String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
    };
    let text = output(false);
    assert!(text.contains("  10 free modes, 2 static answers of pin (child)\n"), "{text}");
    assert_eq!(text.matches("Hz  static answer\n").count(), 2, "{text}");
    let report: serde_json::Value = serde_json::from_str(&output(true)).unwrap();
    let counts = &report["bodies"][0]["coordinates"];
    assert_eq!(counts["free_modes"], 10);
    assert_eq!(counts["static_answers"][0], serde_json::json!({ "to": "pin (child)", "count": 2 }));
}
