//! Restitution where it has a meaning, and nothing where it has none, as a user sees them.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");

fn output(directory: &Path, arguments: &[&str]) -> String {
    let output =
        Command::new(PROGRAM).args(arguments).current_dir(directory).output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Runs `scenario` in a new directory.
fn run(scenario: &str) -> TempDir {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let steel = "[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7850.0\n";
    std::fs::write(directory.path().join("a.toml"), format!("{scenario}\n{steel}")).expect("written");
    output(directory.path(), &["run", "-q", "a.toml"]);
    directory
}

fn impacts(directory: &TempDir) -> Vec<Value> {
    let text = output(directory.path(), &["info", "--json", "a.h5"]);
    let all: Value = serde_json::from_str(&text).expect("JSON");
    all["impacts"].as_array().expect("a list").clone()
}

fn ball(name: &str, z: f64, speed: f64) -> String {
    format!(
        "[bodies.{name}]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = 0.01 }}\n\
         position = [0.0, 0.0, {z:?}]\nvelocity = [0.0, 0.0, {speed:?}]\n"
    )
}

fn contact(name: &str, body: &str, target: &str) -> String {
    format!("[contacts.{name}]\ncontact_body = \"{body}\"\ntarget_body = \"{target}\"\nmodel = \"hertz\"\n")
}

const FLOOR: &str = "[bodies.floor]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\n";

/// An elastic ball falls 1 mm and bounces twice, two other balls hit each other beside it: nothing is lost.
#[test]
fn elastic_bounces_under_gravity_have_restitution_one() {
    let simulation = "[simulation]\nend_time = 0.05\ngravity = [0.0, 0.0, -9.81]\n";
    let directory = run(&[simulation, &ball("a", 0.011, 0.0), FLOOR, &contact("c", "a", "floor")].concat());
    let impacts = impacts(&directory);
    assert!(impacts.len() >= 2, "{impacts:?}");
    for (n, impact) in impacts.iter().enumerate() {
        assert_eq!(impact["impact"], n + 1, "impacts count from 1");
        let e = impact["restitution"].as_f64().expect("a number");
        // Some 1e2 steps with a relative error of 1e-8 each.
        assert!((e - 1.0).abs() < 1e-6, "{e}");
    }
    // Way fallen and speed.
    let speed = impacts[0]["approach_velocity"].as_f64().expect("a number");
    assert!((speed / (2.0_f64 * 9.81 * 1e-3).sqrt() - 1.0).abs() < 1e-6, "{speed}");
}

/// Balls that touch each other pass the impact on: the velocities of those between are the work of two contacts.
#[test]
fn chains_and_bodies_at_rest_have_no_restitution() {
    let bodies = ["a", "b", "c"].map(|n| ball(n, 0.02 * f64::from(n.as_bytes()[0] - b'a'), 0.0));
    let chain = [
        "[simulation]\nend_time = 3e-4\n",
        &bodies.concat(),
        &ball("d", 0.0601, -1.0),
        &contact("ab", "b", "a"),
        &contact("bc", "c", "b"),
        &contact("cd", "d", "c"),
    ];
    let rest = [
        "[simulation]\nend_time = 0.01\ngravity = [0.0, 0.0, -9.81]\n",
        &ball("a", 0.01, 0.0),
        FLOOR,
        &contact("c", "a", "floor"),
    ];
    for scenario in [chain.concat(), rest.concat()] {
        let directory = run(&scenario);
        let impacts = impacts(&directory);
        assert!(!impacts.is_empty());
        for impact in &impacts {
            assert!(impact["restitution"].is_null(), "{impact}");
            assert!(impact["peak_force"].as_f64().is_some_and(|f| f > 0.0));
        }
        let table = output(directory.path(), &["info", "a.h5"]);
        let lines: Vec<&str> = table.lines().skip_while(|l| !l.starts_with("impact  contact")).collect();
        let (head, row) = (lines.first().expect("a heading"), lines.get(1).expect("a row"));
        let before =
            head.chars().count() - head.split("restitution").last().map_or(0, |rest| rest.chars().count());
        let cell: String = row.chars().take(before).collect();
        assert!(row.starts_with("1 ") && cell.ends_with(" -"), "{row}");
        output(directory.path(), &["collect", "a.h5", "-o", "a.csv", "--long"]);
        let csv = std::fs::read_to_string(directory.path().join("a.csv")).expect("a table");
        assert!(csv.lines().skip(1).all(|line| line.ends_with(',')), "{csv}");
    }
}
