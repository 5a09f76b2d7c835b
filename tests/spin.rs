//! Stress of bodies that turn fast, in closed form, whatever they are made of and whatever turns them: the centrifugal force has its static answer.

use std::path::PathBuf;

use crate::blocks;
use crate::support::scenarios::{self, run, valid};
use crate::writers::{Form, gmsh};
use adaptive::record::warning::WarningKind;
use fe_mesh::ElementKind;

/// Density of steel [kg/m³].
const RHO: f64 = 7850.0;
/// Rate of turn [rad/s].
const RATE: f64 = 300.0;
/// Length of the bars \[m\].
const LENGTH: f64 = 0.2;

const FREE: &str = "angular_velocity = [0.0, 0.0, 300.0]";
const DISC: &str =
    "model = \"plane-stress\"\nmaterial = \"steel\"\ngeometry = { shape = \"disc\", radius = 0.1 }";
const STRIP: &str =
    "model = \"plane-stress\"\nmaterial = \"bar\"\ngeometry = { shape = \"rectangle\", size = [0.2, 0.01] }";
const CUBOID: &str =
    "model = \"solid\"\nmaterial = \"bar\"\ngeometry = { shape = \"box\", size = [0.2, 0.01, 0.02] }";
const MESHED: &str = "model = \"mesh\"\nmaterial = \"bar\"\nfile = \"spun.msh\"\nunits = \"mm\"";
/// Turned by a shaft at its end.
const SHAFT: &str = "[joints.shaft]\ntype = \"revolute\"\naxis = [0, 0, 1]\nparent = { body = \"ground\" }\n\
    child = { body = \"b\", face = \"x-\" }\nmotion = { kind = \"spin-up\", rate = 300.0, duration = 0.05 }";

/// The same, welded to a hub that is turned.
const HUB: &str = "[bodies.hub]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1e-3, 1e-3, 1e-3]\n\
    [joints.shaft]\ntype = \"revolute\"\naxis = [0, 0, 1]\nparent = { body = \"ground\" }\n\
    child = { body = \"hub\", point = [0, 0, 0] }\nmotion = { kind = \"spin-up\", rate = 300.0, duration = 0.05 }\n\
    [joints.weld]\ntype = \"fixed\"\nparent = { body = \"hub\", point = [0, 0, 0] }\nchild = { body = \"b\", face = \"x-\" }";

fn folder() -> PathBuf {
    scenarios::folder("spin")
}

/// Stress along x in the middle of the body `keys`, `rest` of the scenario, over the last tenth of a run of `end` \[Pa\]: least and largest.
fn in_the_middle(keys: &str, rest: &str, end: f64) -> [f64; 2] {
    let text = format!(
        "[simulation]\nend_time = {end}\n[materials.bar]\nyoungs_modulus = 210e9\npoissons_ratio = 0.0\ndensity = 7850.0\n\
         [bodies.b]\n{keys}\ndamping = {{ modal = 0.7 }}\n{rest}\n\
         [output.points.p]\nbody = \"b\"\npoint = {}\nstress = true\n",
        if keys.contains("plane") { "[0.0, 0.0]" } else { "[0.0, 0.0, 0.0]" }
    );
    let found = run(&valid(&folder(), &text, &[]));
    let last = found.samples.iter().filter(|s| s.time >= 0.9 * end).map(|s| s.points[0].state.stress[0]);
    last.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], s| [least.min(s), most.max(s)])
}

#[test]
fn bodies_that_turn_have_the_stress_of_their_centrifugal_force() {
    let bar = |[x, y, z]: [f64; 3]| [200.0 * (x - 0.5), 10.0 * (y - 0.5), 20.0 * (z - 0.5)];
    let mesh = gmsh(&blocks::block(ElementKind::Hex20, [40, 2, 2], bar), Form::Binary41);
    std::fs::write(folder().join("spun.msh"), mesh).unwrap();
    let load = RHO * RATE * RATE;
    // About its middle, in the middle; about its end, in the middle.
    let (free, driven) = (load * LENGTH.powi(2) / 8.0, load * LENGTH.powi(2) * 3.0 / 8.0);
    let cases = [
        ("disc", DISC, FREE, 0.01, (3.0 + 0.3) / 8.0 * load * 0.1_f64.powi(2)),
        ("strip", STRIP, FREE, 0.02, free),
        ("box", CUBOID, FREE, 0.02, free),
        ("mesh", MESHED, FREE, 0.02, free),
        ("box on a shaft", CUBOID, SHAFT, 0.06, driven),
        ("box on a hub", CUBOID, HUB, 0.06, driven),
    ];
    for (what, keys, rest, end, expected) in cases {
        let stress = in_the_middle(keys, rest, end);
        println!("{what}: {stress:?} of {expected:e}");
        // Without lateral contraction bars obey bar theory; straight lines in 40 elements follow its parabola of stress to (2/3)/40², 4e-4.
        assert!(
            stress.iter().all(|s| (s / expected - 1.0).abs() < 5e-3),
            "{what}: {stress:?} for {expected:e}"
        );
    }
}

/// The disc turned by a constant moment from rest, as long as it is told.
const DRIVEN: &str = "[joints.j]\ntype = \"revolute\"\naxis = [0, 0, 1]\nparent = { body = \"ground\", point = [0, 0, 0] }\n\
    child = { body = \"b\", point = [0, 0], radius = 0.01 }\n";

#[test]
fn a_spin_that_nobody_foresaw_is_told() {
    let told = |rest: &str| {
        let text = format!(
            "[simulation]\nend_time = 4e-3\n[bodies.b]\n{DISC}\nthickness = 0.01\ndamping = {{ modal = 1.0 }}\n{DRIVEN}{rest}\n"
        );
        let found = run(&valid(&folder(), &text, &[]));
        found.warnings.iter().any(|w| w.kind == WarningKind::SpinStress)
    };
    // Up to 500 rad/s: a strain of 4.7e-5 with half the diagonal of the disc's box.
    assert!(told("drive = 1541.3"));
    assert!(!told("drive = 154.13"), "50 rad/s strain it by less than 1e-6");
    assert!(
        !told("motion = { kind = \"spin-up\", rate = 500.0, duration = 4e-3 }"),
        "a spin that is prescribed is answered"
    );
}

#[test]
fn stress_along_a_line_is_stored_at_a_time_without_impact() {
    let line = "[output.stress.radius]\nbody = \"b\"\nfrom = [0.0, 0.0]\nto = [0.1, 0.0]\nsamples = 3\n";
    let text = |at: &str| {
        format!(
            "[simulation]\nend_time = 0.01\n[bodies.b]\n{DISC}\n{FREE}\ndamping = {{ modal = 0.7 }}\n\
             [output.points.p]\nbody = \"b\"\npoint = [0.05, 0.0]\nstress = true\n[output]\nfree_interval = 1e-3\n{line}{at}"
        )
    };
    let found = run(&valid(&folder(), &text("at = 3e-3\n"), &[]));
    let [record] = &found.stresses[..] else { panic!("{}", found.stresses.len()) };
    let sample = found.samples.iter().find(|s| (s.time - 3e-3).abs() < 1e-9).expect("a stored state");
    // The same state on the same basis.
    let (line, point) = (record.stress[1], sample.points[0].state.stress);
    assert!((record.time - 3e-3).abs() < 1e-12);
    assert!(line.iter().zip(point).all(|(a, b)| (a - b).abs() < 1e-9 * point[0].abs()), "{line:?} {point:?}");
    // The largest force of a body that nothing touches has no instant.
    assert!(run(&valid(&folder(), &text(""), &[])).stresses.is_empty());
}
