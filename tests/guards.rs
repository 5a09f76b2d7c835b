//! What a run tells of bodies beyond their limits, for every kind of body: the table of docs/limits.md as a test.

use crate::blocks;
use crate::solid_file;
use crate::support::bar::{ALUMINIUM, CLAMP, FROM_A_FILE, OF_ELEMENTS, OF_SPLINES};
use crate::support::fbimpact;
use crate::writers::{Form, gmsh};
use fe_mesh::ElementKind;
use iga_core::files::write_gismo;
use iga_core::nurbs::Patch;
use iga_core::splines::knots::KnotVector;
use std::path::Path;

/// The bar of 0.3 × 0.03 × 0.01 m, a kind of body each, and its ends.
const BARS: [(&str, &str, [&str; 2]); 4] = [
    ("splines of one patch", OF_SPLINES, ["face = \"x-\"", "face = \"x+\""]),
    (
        "splines of two patches",
        r#"
[bodies.beam]
material = "aluminium"
geometry = { shape = "nurbs", file = "bar.xml", units = "mm" }
discretisation = { degree = 3, elements = [10, 3, 2] }
reduction = { modes = 10 }
"#,
        ["face = \"0:xi-\"", "face = \"1:xi+\""],
    ),
    ("finite elements", OF_ELEMENTS, ["face = \"x-\"", "face = \"x+\""]),
    ("a body from a file", FROM_A_FILE, ["marker = \"foot\"", "marker = \"tip\""]),
];

/// What tells of it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Told {
    /// A warning of this kind.
    Warning(&'static str),
    /// The error that ends the run.
    Error,
}

/// The part of the bar from `x` to `x + 0.15` m.
fn half(x: f64) -> Patch {
    let line = || KnotVector::uniform(1, 1).expect("knots");
    let mut points = Vec::new();
    for z in [-0.005, 0.005] {
        for y in [-0.015, 0.015] {
            points.extend([x, x + 0.15].map(|x| [x, y, z]));
        }
    }
    Patch::new(vec![line(), line(), line()], points, vec![1.0; 8]).expect("a box")
}

fn write_bars(folder: &Path) {
    let bar = |[x, y, z]: [f64; 3]| [300.0 * x, 30.0 * (y - 0.5), 10.0 * (z - 0.5)];
    let mesh = blocks::block(ElementKind::Hex20, [20, 3, 2], bar);
    std::fs::write(folder.join("bar.msh"), gmsh(&mesh, Form::Binary41)).unwrap();
    std::fs::write(folder.join("bar.xml"), write_gismo(&[half(0.0), half(0.15)], 1e-3)).unwrap();
    solid_file::write_bar(&folder.join("bar.h5"), [20, 3, 2]);
}

/// What a bar bears, clamped at one end and with a force at the other along x and z \[N\], or free and turning about y [rad/s].
#[derive(Debug, Clone, Copy)]
enum Bears {
    Force([f64; 2]),
    Spin(f64),
}

/// What is told of `bar` with its ends: the kinds of warnings, and whether the run failed.
fn told(folder: &Path, (bar, [foot, tip]): (&str, [&str; 2]), bears: Bears) -> (Vec<String>, bool) {
    let (end, rest) = match bears {
        Bears::Force([x, z]) => {
            let load = format!("[loads.push]\nbody = \"beam\"\n{tip}\nforce_x = {x:?}\nforce_z = {z:?}\n");
            (6e-3, CLAMP.replace("face = \"x-\"", foot) + &load)
        }
        Bears::Spin(spin) => (1e-6, format!("[bodies.beam]\nangular_velocity = [0.0, {spin:?}, 0.0]\n")),
    };
    let text = match bears {
        Bears::Force(_) => format!("{bar}{rest}"),
        // Keys of one table stand together.
        Bears::Spin(_) => bar.replace("[bodies.beam]\n", &rest),
    };
    let text = format!("[simulation]\nend_time = {end:?}\n{ALUMINIUM}{text}");
    std::fs::write(folder.join("case.toml"), text).unwrap();
    let path = |name: &str| folder.join(name).display().to_string();
    let (code, _, complaint) =
        fbimpact(&["run", "--no-cache", "--force", &path("case.toml"), "-o", &path("case.h5")]);
    let (_, text, _) = fbimpact(&["info", "--json", &path("case.h5")]);
    let info: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let warnings = info["warnings"].as_array().map_or(&[][..], |w| w);
    let kinds = warnings.iter().filter_map(|w| w["identifier"].as_str().map(str::to_owned)).collect();
    assert!(code == 0 || complaint.contains("body \"beam\""), "{bears:?}, {code}: {complaint}");
    (kinds, code != 0)
}

#[test]
fn every_kind_of_body_is_told_of_where_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    write_bars(folder.path());
    // A force that comes at once deforms twice as much as one at rest: slope of the tip 5.1e-4 /N of one across, strain 9.5e-8 /N of one along; 4.8 kN buckle it; its lowest frequency, free, is 3,700 rad/s.
    let rows = [
        (Told::Warning("large-turn"), Bears::Force([0.0, 600.0]), [true; 4]),
        // A file has no field between its nodes.
        (Told::Warning("large-strain"), Bears::Force([2.1e5, 0.0]), [true, true, true, false]),
        (Told::Warning("axial-load"), Bears::Force([-400.0, 0.0]), [true, true, true, false]),
        (Told::Warning("fast-spin"), Bears::Spin(1.1e3), [true; 4]),
        (Told::Error, Bears::Force([1e9, 0.0]), [true; 4]),
    ];
    let mut wrong = Vec::new();
    for (what, bears, wanted) in rows {
        for ((kind, bar, ends), is_told) in BARS.into_iter().zip(wanted) {
            let (warnings, has_failed) = told(folder.path(), (bar, ends), bears);
            let found = match what {
                Told::Warning(kind) => warnings.iter().any(|w| w == kind),
                Told::Error => has_failed,
            };
            println!("{kind}, {what:?}: {found}, {warnings:?}");
            if found != is_told {
                wrong.push((kind, what));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn a_tenth_of_what_ends_a_body_is_silent() {
    let folder = tempfile::tempdir().unwrap();
    write_bars(folder.path());
    for (kind, bar, ends) in BARS {
        for bears in [Bears::Force([-40.0, 60.0]), Bears::Spin(1.1e2)] {
            let (warnings, has_failed) = told(folder.path(), (bar, ends), bears);
            assert!(warnings.is_empty() && !has_failed, "{kind}, {bears:?}: {warnings:?}");
        }
    }
}
