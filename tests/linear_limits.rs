//! Where linear bodies and linear contacts end, as a user is told of it; and hits of stops, which are events as impacts are.

use std::path::Path;

use crate::support::fbimpact;

/// Runs the scenario `text`: exit code, complaint, and what `info --json` says of the result.
fn run(text: &str) -> (i32, String, serde_json::Value) {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let (code, _, complaint) = fbimpact(&["run", "--no-cache", &path("s.toml"), "-o", &path("s.h5")]);
    let info = if Path::new(&path("s.h5")).exists() {
        let (code, text, error) = fbimpact(&["info", "--json", &path("s.h5")]);
        assert_eq!(code, 0, "{error}");
        serde_json::from_str(&text).unwrap()
    } else {
        serde_json::Value::Null
    };
    (code, complaint, info)
}

/// Warnings of a kind: subject, message and remedy.
fn warned(info: &serde_json::Value, kind: &str) -> Vec<String> {
    let of_kind = info["warnings"].as_array().unwrap().iter().filter(|w| w["identifier"] == kind);
    let text =
        |w: &serde_json::Value| ["subject", "message", "remedy"].map(|k| w[k].as_str().unwrap()).join("; ");
    of_kind.map(text).collect()
}

/// A crank of 0.15 m at 150 rad/s drives a slider by a steel coupler of 0.3 m and 6 mm, `end` seconds long.
fn slider_crank(diameter: f64, end: f64) -> String {
    format!(
        "[simulation]\nend_time = {end:?}\n\
[bodies.crank]\nmodel = \"rigid\"\nmass = 0.5\ninertia = [1e-3, 1e-3, 1e-3]\n\
[bodies.coupler]\nmaterial = \"steel\"\ngeometry = {{ shape = \"cylinder\", radius = {:?}, length = 0.3 }}\n\
orientation_deg = [0.0, 90.0, 0.0]\n\
[bodies.slider]\nmodel = \"rigid\"\nmass = 0.033\ninertia = [1e-4, 1e-4, 1e-4]\n\
[joints.main]\ntype = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nparent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\n\
child = {{ body = \"crank\", point = [0.0, 0.0, 0.0] }}\nmotion = {{ kind = \"polynomial\", coefficients = [0.0, 150.0] }}\n\
[joints.pin]\ntype = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nparent = {{ body = \"crank\", point = [0.15, 0.0, 0.0] }}\n\
child = {{ body = \"coupler\", face = \"start\" }}\n\
[joints.wrist]\ntype = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nparent = {{ body = \"coupler\", face = \"end\" }}\n\
child = {{ body = \"slider\", point = [0.0, 0.0, 0.0] }}\n\
[joints.way]\ntype = \"prismatic\"\naxis = [1.0, 0.0, 0.0]\nparent = {{ body = \"ground\", point = [0.45, 0.0, 0.0] }}\n\
child = {{ body = \"slider\", point = [0.0, 0.0, 0.0] }}\ncloses_loop = true\n\
[output]\nfree_interval = 1e-4\n",
        0.5 * diameter
    )
}

#[test]
fn a_coupler_under_a_fifth_of_its_buckling_load_is_warned_with_its_name() {
    let (code, complaint, info) = run(&slider_crank(6e-3, 0.01));
    assert_eq!(code, 0, "{complaint}");
    let told = warned(&info, "axial-load");
    assert_eq!(told.len(), 1, "{info:#}");
    assert!(told[0].contains("body \"coupler\"") && told[0].contains("joined by `fixed`"), "{}", told[0]);
}

#[test]
fn a_stout_coupler_is_not_warned() {
    // Four times the diameter: loads grow with its mass by less than sixteen, the buckling load by 256.
    let (code, complaint, info) = run(&slider_crank(24e-3, 0.01));
    assert_eq!(code, 0, "{complaint}");
    assert!(warned(&info, "axial-load").is_empty() && warned(&info, "large-turn").is_empty(), "{info:#}");
}

#[test]
fn a_strip_that_sags_by_its_length_is_warned() {
    let text = "[simulation]\nend_time = 0.1\ngravity = [0.0, -9.81, 0.0]\nstatic_start = true\n\
[bodies.strip]\nmodel = \"plane-stress\"\nthickness = 0.02\nmaterial = \"steel\"\n\
geometry = { shape = \"rectangle\", size = [0.8, 5e-4] }\n\
[joints.root]\ntype = \"fixed\"\nparent = { body = \"ground\", point = [0.0, 0.0, 0.0] }\nchild = { body = \"strip\", face = \"x-\" }\n";
    let (code, complaint, info) = run(text);
    assert_eq!(code, 0, "{complaint}");
    let told = warned(&info, "large-turn");
    assert_eq!(told.len(), 1, "{info:#}");
    assert!(told[0].contains("body \"strip\"") && told[0].contains("docs/limits.md"), "{}", told[0]);
}

/// A steel ball of 10 mm by Hertz' law against a rigid plane.
fn ball(speed: f64) -> String {
    format!(
        "[simulation]\nend_time = 1e-4\n[bodies.a]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\n\
geometry = {{ shape = \"sphere\", radius = 0.01 }}\nposition = [0.0, 0.0, 0.01001]\nvelocity = [0.0, 0.0, {:?}]\n\
[bodies.b]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\n[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\n",
        -speed
    )
}

#[test]
fn pressures_beyond_every_yield_point_are_told_and_end_a_run_far_beyond() {
    let (code, complaint, info) = run(&ball(1.0));
    assert_eq!(code, 0, "{complaint}");
    assert!(warned(&info, "large-contact-strain").is_empty(), "{info:#}");
    // Hertz: a/R = 0.27 at 100 m/s, 0.67 at 1000 m/s.
    let (code, complaint, info) = run(&ball(100.0));
    assert_eq!(code, 0, "{complaint}");
    let told = warned(&info, "large-contact-strain");
    assert_eq!(told.len(), 1, "{info:#}");
    assert!(told[0].contains("contact pressure") && told[0].contains("yield"), "{}", told[0]);
    let (code, complaint, _) = run(&ball(1000.0));
    assert_eq!(code, 5, "{complaint}");
    assert!(complaint.contains("contact \"c\""), "{complaint}");
}

/// A gear pair with backlash that rattles; `output` as given.
fn rattle(output: &str) -> String {
    format!(
        "[simulation]\nend_time = 0.2\n[bodies]\nwheel1 = {{ model = \"rigid\", mass = 1.0, inertia = [1e-3, 1e-3, 2e-3] }}\n\
wheel2 = {{ model = \"rigid\", mass = 2.0, inertia = [4e-3, 4e-3, 8e-3] }}\n\
driven = {{ model = \"rigid\", mass = 0.1, inertia = [1e-5, 1e-5, 1e-5] }}\n\
[joints.shaft1]\ntype = \"revolute\"\naxis = [0.0, 0.0, 1.0]\nparent = {{ body = \"ground\" }}\n\
child = {{ body = \"wheel1\", point = [0.0, 0.0, 0.0] }}\nmotion = {{ kind = \"harmonic\", amplitude = 0.01, frequency = 20.0 }}\n\
[joints.idler]\ntype = \"revolute\"\naxis = [0.0, 0.0, 1.0]\nparent = {{ body = \"ground\", point = [0.1, 0.0, 0.0] }}\n\
child = {{ body = \"driven\", point = [0.0, 0.0, 0.0] }}\n[gears.mesh]\nfirst = \"shaft1\"\nsecond = \"idler\"\nratio = -0.5\n\
[joints.play]\ntype = \"revolute\"\naxis = [0.0, 0.0, 1.0]\nparent = {{ body = \"driven\", point = [0.0, 0.0, 0.0] }}\n\
child = {{ body = \"wheel2\", point = [0.0, 0.0, 0.0] }}\n\
stop = {{ lower = -0.001, upper = 0.001, stiffness = 1e5, damping = 0.3 }}\nfriction = 0.05\n{output}"
    )
}

#[test]
fn hits_of_a_stop_are_impacts_whatever_the_interval() {
    let peaks = |output: &str| -> Vec<(f64, f64)> {
        let (code, complaint, info) = run(&rattle(output));
        assert_eq!(code, 0, "{complaint}");
        let rows = info["impacts"].as_array().unwrap().clone();
        assert!(rows.iter().all(|r| r["contact"] == "stop of play"), "{info:#}");
        rows.iter().map(|r| (r["peak_force"].as_f64().unwrap(), r["impulse"].as_f64().unwrap())).collect()
    };
    let (coarse, fine) = (peaks(""), peaks("[output]\nfree_interval = 1e-5\n"));
    assert!(coarse.len() > 1 && coarse.len() == fine.len(), "{coarse:?} {fine:?}");
    let largest = |rows: &[(f64, f64)]| rows.iter().map(|r| r.0).fold(0.0, f64::max);
    // 18.06 N m of the same run stored every 10 us; the course of a step between four instants: half a per cent.
    assert!((largest(&coarse) / 18.06 - 1.0).abs() < 5e-3, "{coarse:?}");
    for (a, b) in coarse.iter().zip(&fine) {
        assert!((a.0 / b.0 - 1.0).abs() < 5e-3 && (a.1 / b.1 - 1.0).abs() < 5e-3, "{a:?} {b:?}");
    }
}
