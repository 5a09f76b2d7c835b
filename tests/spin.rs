//! Stress of bodies that turn fast, in closed form, whatever they are made of and whatever turns them: the centrifugal force has its static answer.

use std::path::PathBuf;

use crate::blocks;
use crate::support::scenarios::{self, run, valid};
use crate::writers::{Form, gmsh};
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
const STRIP: &str = "model = \"plane-stress\"\nmaterial = \"steel\"\ngeometry = { shape = \"rectangle\", size = [0.2, 0.01] }";
const CUBOID: &str =
    "model = \"solid\"\nmaterial = \"steel\"\ngeometry = { shape = \"box\", size = [0.2, 0.01, 0.02] }";
const MESHED: &str = "model = \"mesh\"\nmaterial = \"steel\"\nfile = \"spun.msh\"\nunits = \"mm\"";
/// Turned by a shaft at its end.
const SHAFT: &str = "[joints.shaft]\ntype = \"revolute\"\naxis = [0, 0, 1]\nparent = { body = \"ground\" }\n\
    child = { body = \"b\", face = \"x-\" }\nmotion = { kind = \"spin-up\", rate = 300.0, duration = 0.05 }";

fn folder() -> PathBuf {
    scenarios::folder("spin")
}

/// Stress along x in the middle of the body `keys`, `rest` of the scenario, over the last tenth of a run of `end` \[Pa\]: least and largest.
fn in_the_middle(keys: &str, rest: &str, end: f64) -> [f64; 2] {
    let text = format!(
        "[simulation]\nend_time = {end}\n[bodies.b]\n{keys}\ndamping = {{ modal = 0.7 }}\n{rest}\n\
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
    ];
    for (what, keys, rest, end, expected) in cases {
        let stress = in_the_middle(keys, rest, end);
        println!("{what}: {stress:?} of {expected:e}");
        // Bars are as long as ten of their widths: their ends and their lateral contraction are of the order of its square, times Poisson's ratio.
        assert!(
            stress.iter().all(|s| (s / expected - 1.0).abs() < 5e-3),
            "{what}: {stress:?} for {expected:e}"
        );
    }
}
