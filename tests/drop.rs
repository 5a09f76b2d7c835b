//! `fbimpact drop` and `fbimpact new --mesh`, run as a user would.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

use fe_mesh::element::kind::ElementKind;
use serde_json::Value;

use crate::{blocks, plane_meshes, writers};

const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");
/// A rigid egg above a plane, with Hertz's law: a run takes some hundredths of a second.
const EGG: &str = r#"
[simulation]
end_time = 2e-3
stop_after_impacts = 1
impact.rtol = 1e-8
gravity = [0.0, 0.0, -9.81]
[bodies.egg]
model = "rigid"
material = "steel"
geometry = { shape = "ellipsoid", semi_axes = [8e-3, 10e-3, 14e-3] }
position = [0.0, 0.0, 0.1]
orientation_deg = [10.0, 0.0, 0.0]
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
position = [0.0, 0.0, 5e-3]
[contacts.impact]
model = "hertz"
contact_body = "egg"
target_body = "floor"
"#;

fn fbimpact(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(PROGRAM)
        .args(arguments)
        .current_dir(folder)
        .env("FBIMPACT_CACHE", "off")
        .output()
        .expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

fn falls(folder: &Path) -> Vec<Value> {
    let text = std::fs::read(folder.join("egg.drop/drop.json")).expect("readable");
    let json: Value = serde_json::from_slice(&text).expect("JSON");
    json["falls"].as_array().expect("a list").clone()
}

#[test]
fn an_egg_falls_on_all_sides_the_hardest_is_first_and_nothing_is_run_twice() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("egg.toml"), EGG).expect("written");
    let arguments = [
        "drop",
        "egg.toml",
        "--height",
        "0.05",
        "--toward",
        "faces",
        "--at",
        "tip=0,0,14e-3",
        "--no-reports",
    ];
    let (code, out, err) = fbimpact(at, &arguments);
    assert_eq!(code, 0, "{err}");
    let rows = falls(at);
    assert!(rows.len() == 6 && out.lines().nth(1).is_some_and(|line| line.starts_with("face-x")), "{out}");
    let peak = |name: &str| {
        let row = rows.iter().find(|row| row["orientation"] == name).expect("a row");
        row["peak_force"].as_f64().expect("a number")
    };
    assert!(rows.windows(2).all(|w| w[0]["peak_force"].as_f64() >= w[1]["peak_force"].as_f64()), "{rows:#?}");
    for axis in ["x", "y", "z"] {
        let (low, high) = (peak(&format!("face-{axis}-")), peak(&format!("face-{axis}+")));
        // The same fall seen in a mirror: what the integration leaves at the tolerance given.
        assert!((low / high - 1.0).abs() < 1e-6, "{axis}: {low} {high}");
    }
    // Impulse of a fall of 50 mm, there and back without a loss, and gravity over some 60 µs of it (1e-3 of the speed).
    let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * 8e-3 * 10e-3 * 14e-3;
    let expected = 2.0 * mass * (2.0 * 9.81 * 0.05_f64).sqrt();
    for row in &rows {
        assert!((row["impulse"].as_f64().expect("a number") / expected - 1.0).abs() < 2e-3, "{row}");
        // The speed of the fall, 1 m/s, is turned round within 60 µs: 3e4 m/s² on average.
        assert!(row["observed"]["points.tip.peak_acceleration"]["value"].as_f64() > Some(1e3), "{row}");
    }
    // The same run by itself.
    let set = std::fs::read_to_string(at.join("egg.drop/face-x-.set")).expect("readable");
    let mut single = vec!["run", "egg.toml", "-q", "-o", "single.h5"];
    single.extend(set.lines().flat_map(|line| ["--set", line]));
    assert_eq!(fbimpact(at, &single).0, 0);
    let (_, json, _) = fbimpact(at, &["metric", "single.h5", "peak=max(impacts.peak_force)"]);
    let single =
        serde_json::from_str::<Value>(&json).expect("JSON")["peak"]["value"].as_f64().expect("a number");
    assert!((single / peak("face-x-") - 1.0).abs() < 1e-12, "{single}");

    let page = std::fs::read_to_string(at.join("egg.drop/report.html")).expect("a page");
    assert!(page.contains("<polygon") && page.contains("face-y+") && page.contains("peak_acceleration"));
    let table = std::fs::read_to_string(at.join("egg.drop/table.csv")).expect("a table");
    assert_eq!(table.lines().count(), 7);
    let (code, again, err) = fbimpact(at, &arguments);
    assert!(code == 0 && again == out && err.matches("finished earlier").count() == 6, "{err}");
    let (code, out, err) =
        fbimpact(at, &["drop", "egg.toml", "--height", "0.05", "--toward", "3", "--no-reports"]);
    assert!(code == 0 && out.matches("direction-").count() == 3, "{out}{err}");
}

#[test]
fn what_cannot_fall_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("written");
    write("egg.toml", EGG);
    write(
        "alone.toml",
        &EGG.replace(
            "[contacts.impact]\nmodel = \"hertz\"\ncontact_body = \"egg\"\ntarget_body = \"floor\"\n",
            "",
        ),
    );
    write("cut.msh", "$MeshFormat\n4.1 0 8\n");
    write("part.step", "ISO-10303-21;\n");
    std::fs::create_dir(at.join("full.drop")).expect("a folder");
    write("full.drop/a", "");
    for (arguments, code, words) in [
        (&["egg.toml"][..], 2, "--height"),
        (&["egg.toml", "--height=-1"], 2, "number > 0"),
        (&["egg.toml", "--height", "1", "--toward", "sides"], 2, "faces, edges and corners"),
        (&["egg.toml", "--height", "1", "--at", "1,2"], 2, "X,Y,Z"),
        (&["egg.toml", "--height", "1", "--at", "a/b=0,0,0"], 3, "a name must have"),
        (&["alone.toml", "--height", "1"], 2, "must have one contact"),
        (&["no.toml", "--height", "1"], 6, "no.toml"),
        (&["no.msh", "--height", "1", "--units", "mm"], 6, "no.msh"),
        (&["cut.msh", "--height", "1"], 2, "--units mm"),
        (&["cut.msh", "--height", "1", "--units", "mm"], 3, "cut.msh"),
        (&["egg.toml", "--height", "1", "-o", "full.drop"], 6, "holds files"),
    ] {
        let (found, _, err) = fbimpact(at, &[&["drop"], arguments].concat());
        assert!(found == code && err.contains(words), "{arguments:?}: {found} {err}");
    }
    let missing = Command::new(PROGRAM)
        .args(["new", "part", "--mesh", "part.step"])
        .current_dir(at)
        .env("PATH", at)
        .output()
        .expect("the program starts");
    let err = String::from_utf8_lossy(&missing.stderr);
    assert!(missing.status.code() == Some(6) && err.contains("pip install gmsh"), "{err}");
    assert!(!at.join("part.geo").exists() && !at.join("part.toml").exists());
}

#[test]
fn a_mesh_is_described_and_lies_above_the_floor() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    // A brick of 20 by 30 by 40 mm about a place beside the origin.
    let mesh =
        blocks::block(ElementKind::Hex8, [2, 2, 2], |[x, y, z]| [20.0 * x + 5.0, 30.0 * y, 40.0 * z - 50.0]);
    std::fs::create_dir(at.join("meshes")).expect("a folder");
    std::fs::write(at.join("meshes/brick.msh"), writers::gmsh(&mesh, writers::Form::Text41))
        .expect("written");
    let (code, out, err) = fbimpact(
        at,
        &["new", "case", "--mesh", "meshes/brick.msh", "--units", "mm", "--material", "aluminium"],
    );
    assert_eq!(code, 0, "{err}");
    // 2700 kg/m³ times 24e-6 m³.
    assert!(
        out.contains("0.0648 kg")
            && out.contains("0.015, 0.015, -0.03 m")
            && out.contains("0.005 to 0.025, 0 to 0.03, -0.05 to -0.01 m"),
        "{out}"
    );
    let text: toml::Table =
        std::fs::read_to_string(at.join("case.toml")).expect("written").parse().expect("TOML");
    let part = &text["bodies"]["part"];
    assert_eq!(part["file"].as_str(), Some("meshes/brick.msh"));
    let gap = part["position"][2].as_float().expect("a number") - 0.05;
    let diagonal = (20e-3_f64.powi(2) + 30e-3_f64.powi(2) + 40e-3_f64.powi(2)).sqrt();
    // The last digits of a coordinate of 50 mm.
    assert!((gap - 1e-4 * diagonal).abs() < 1e-15, "{gap}");
    let (code, _, err) = fbimpact(at, &["check", "case.toml"]);
    assert!(code == 0 && err.contains("valid"), "{err}");
    let (code, _, err) = fbimpact(at, &["new", "case", "--mesh", "meshes/brick.msh", "--units", "mm"]);
    assert!(code == 6 && err.contains("exists"), "{err}");
    assert_eq!(fbimpact(at, &["new", "case", "--mesh", "meshes/brick.msh", "--template", "drop"]).0, 2);
}

/// A rectangle of 30 by 20 mm, of one quadrilateral or half of a round one.
fn section(folder: &Path, kind: &str) {
    let deck = format!(
        "*NODE\n1, 0., 0.\n2, 15., 0.\n3, 30., 0.\n4, 0., 20.\n5, 15., 20.\n6, 30., 20.\n*ELEMENT, TYPE={kind}4, ELSET=all\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n"
    );
    std::fs::write(folder.join("section.inp"), deck).expect("written");
}

#[test]
fn sections_fall_in_their_plane_and_round_ones_on_their_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let drop = |model: &str, more: &[&str]| {
        let arguments =
            ["drop", "section.inp", "--units", "mm", "--height", "0.01", "--section", model, "--no-reports"];
        let set = ["--set", "bodies.part.reduction={modes=4}"];
        fbimpact(at, &[&arguments[..], &set, more].concat())
    };
    let rows = || {
        let text = std::fs::read(at.join("section.drop/drop.json")).expect("readable");
        let json: Value = serde_json::from_slice(&text).expect("JSON");
        json["falls"].as_array().expect("a list").clone()
    };
    let impulse = |row: &Value| row["impulse"].as_f64().expect("a number");
    section(at, "CPS");
    let (code, out, err) = drop("plane-stress", &["--toward", "faces,edges,corners"]);
    assert!(code == 0 && rows().len() == 8, "{out}{err}");
    // The rectangle is the same turned by half a turn about its middle: so are the falls.
    let of = |name: &str| rows().into_iter().find(|row| row["orientation"] == name).expect("a row");
    for [a, b] in [["corner-x-y-", "corner-x+y+"], ["corner-x+y-", "corner-x-y+"]] {
        let ratio = impulse(&of(a)) / impulse(&of(b));
        assert!((ratio - 1.0).abs() < 1e-6, "{a} {ratio}");
    }
    // It stops at least: a metre thick, 4.71 kg.
    let stopped = 4.71 * (2.0 * 9.81 * 0.01_f64).sqrt();
    assert!(rows().iter().all(|row| impulse(row) > 0.99 * stopped && impulse(row) < 2.01 * stopped), "{out}");
    section(at, "CAX");
    std::fs::remove_dir_all(at.join("section.drop")).expect("removed");
    let (code, out, err) = drop("axisymmetric", &[]);
    assert!(code == 0 && rows().len() == 2, "{out}{err}");
    // The same fall seen in a mirror, with the floor above and gravity upwards.
    let ratio = impulse(&of("face-z-")) / impulse(&of("face-z+"));
    assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    for (more, words) in [
        (&["--toward", "5"][..], "falls along its axis alone"),
        (&["--toward", "edges"], "has none of these"),
        (&["--on", "steel"], "MATERIAL:THICKNESS"),
    ] {
        let (code, _, err) = drop("axisymmetric", more);
        assert!(code == 2 && err.contains(words), "{more:?}: {code} {err}");
    }
    std::fs::write(at.join("egg.toml"), EGG).expect("written");
    let (code, _, err) = fbimpact(at, &["drop", "egg.toml", "--height", "1", "--on", "rigid"]);
    assert!(code == 2 && err.contains("--on is for meshes and shapes"), "{err}");
}

/// A ball on a layer that is much thicker than the touch is wide, at Hertz' peak $k^{2/5} (\tfrac54 m v^2)^{3/5}$, $k = \tfrac43 E^* \sqrt R$.
#[test]
fn a_layer_yields_as_a_half_space_where_it_is_thick() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("half.inp"), plane_meshes::round("CAX6", true, plane_meshes::RINGS))
        .expect("written");
    let arguments = ["drop", "half.inp", "--units", "mm", "--height", "0.01", "--section", "axisymmetric"];
    let more = ["--on", "aluminium:0.02", "--no-reports"];
    let (code, _, err) = fbimpact(at, &[&arguments[..], &more].concat());
    assert_eq!(code, 0, "{err}");
    let text = std::fs::read(at.join("half.drop/drop.json")).expect("readable");
    let json: Value = serde_json::from_slice(&text).expect("JSON");
    let found = json["falls"][0]["peak_force"].as_f64().expect("a number");
    let (radius, speed) = (10e-3_f64, (2.0 * 9.80665 * 0.01_f64).sqrt());
    let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let modulus = 1.0 / (0.91 / 210e9 + 0.91 / 70e9);
    let stiffness = 4.0 / 3.0 * modulus * radius.sqrt();
    let peak = stiffness.powf(0.4) * (1.25 * mass * speed * speed).powf(0.6);
    println!("{found} N, {peak} N");
    // A touch of 0.4 mm on a layer of 20 mm, which is some a/t = 2 % stiffer than a half space.
    assert!(found > peak && found < 1.025 * peak, "{found} N, {peak} N");
    // The layer lies there whole: no orientation from below.
    assert_eq!(json["falls"].as_array().expect("a list").len(), 1);
}
