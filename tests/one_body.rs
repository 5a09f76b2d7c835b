//! `fbimpact modes --body`: one body is built as the whole scenario would have it, nothing else is, and what is built is kept.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use fbimpact::scenario;
use fbimpact::simulate::modes;

const SCENARIO: &str = r#"
[simulation]
end_time = 1e-3
gravity = [0, 0, -9.81]
[bodies.arm]
material = "steel"
geometry = { shape = "cylinder", radius = "10 mm", length = "200 mm" }
discretisation = { degree = 2, elements = [1, 1, 4] }
reduction = { method = "modal", modes = 6 }
damping = { modal = 0.02 }
orientation_deg = [0, 90, 0]
[bodies.second]
material = "steel"
geometry = { shape = "cylinder", radius = "8 mm", length = "100 mm" }
discretisation = { degree = 2, elements = [1, 1, 3] }
reduction = { method = "modal", modes = 4 }
orientation_deg = [0, 90, 0]
[bodies.heavy]
model = "rigid"
material = "steel"
geometry = { shape = "sphere", radius = "30 mm" }
[joints.shoulder]
type = "revolute"
axis = [0, 1, 0]
parent = { body = "ground", point = [0, 0, 0] }
child = { body = "arm", marker = "start" }
[joints.elbow]
type = "revolute"
axis = [0, 1, 0]
parent = { body = "arm", marker = "end" }
child = { body = "second", marker = "start" }
[joints.wrist]
type = "fixed"
parent = { body = "second", marker = "end" }
child = { body = "heavy", point = [0, 0, 0] }
[output.points.tip]
body = "second"
marker = "end"
"#;

#[test]
fn one_body_is_the_same_alone_as_among_the_others() {
    let scenario = scenario::parse(Path::new("s.toml"), SCENARIO.as_bytes(), &[]).expect("a scenario");
    let all = modes(&scenario, None, 1).expect("models");
    assert_eq!(all.bodies.len(), 3);
    for (i, body) in all.bodies.iter().enumerate() {
        let alone = modes(&scenario, Some(i), 1).expect("a model");
        assert_eq!(alone.bodies, std::slice::from_ref(body));
    }
    assert!(all.bodies[0].coordinates.static_answers.len() == 2, "{:?}", all.bodies[0].coordinates);
}

#[test]
fn a_rigid_body_waits_for_no_other_and_what_is_built_is_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    // So many elements take minutes.
    let large = SCENARIO.replace("[1, 1, 4]", "[8, 8, 160]").replace("[1, 1, 3]", "[6, 6, 12]");
    std::fs::write(folder.path().join("s.toml"), large).expect("written");
    let seconds = |body: &str| {
        let begin = Instant::now();
        let output = Command::new(env!("CARGO_BIN_EXE_fbimpact"))
            .args(["modes", "s.toml", "--body", body, "--cache-dir", "kept"])
            .current_dir(folder.path())
            .output()
            .expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        begin.elapsed().as_secs_f64()
    };
    assert!(seconds("heavy") < 5.0);
    seconds("second");
    let kept = std::fs::read_dir(folder.path().join("kept")).expect("a folder").count();
    assert!(kept > 0, "the model of the second arm");
}
