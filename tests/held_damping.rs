//! Damping ratios of bodies as joints hold them, splines, meshes and bodies from files: what the equations of motion have, by the eigenvalues
//! of their derivative, and what a free decay shows (docs/theory.md Eq. F.29 to F.33).

use std::f64::consts::TAU;

use crate::beam_file::write_beam;
use crate::blocks;
use crate::solid_file;
use crate::support::bar::{ALUMINIUM, CLAMP, FROM_A_FILE, HINGE, OF_ELEMENTS, OF_SPLINES, OTHER_HINGE};
use crate::support::scenarios;
use crate::writers::{Form, gmsh};
use adaptive::model::RunModel;
use fbimpact::simulate::system_modes;
use fe_mesh::ElementKind;
use ffr_dynamics::integration::OdeSystem;
use nalgebra::DMatrix;

const WORLD: &str = "[simulation]\nend_time = 1e-6\n";

/// The bar of splines, of finite elements and from the file of another program, all of ten free modes.
const BARS: [(&str, &str); 3] = [("splines", OF_SPLINES), ("mesh", OF_ELEMENTS), ("file", FROM_A_FILE)];

/// Damping, and the ratio that it asks for at a frequency \[Hz\].
type Law = (&'static str, fn(f64) -> f64);

const LAWS: [Law; 3] = [
    ("damping = { modal = 0.02 }\n", |_| 0.02),
    ("damping = { loss_factor = 0.03 }\n", |_| 0.015),
    // (F.26), (F.27) with 2 % at 80 and 600 Hz.
    ("damping = { frequencies = [80.0, 600.0], ratio = 0.02 }\n", |f| 0.02 / 680.0 * (80.0 * 600.0 / f + f)),
];

fn folder() -> std::path::PathBuf {
    let folder = scenarios::folder("held_damping");
    let bar = |[x, y, z]: [f64; 3]| [300.0 * x, 30.0 * (y - 0.5), 10.0 * (z - 0.5)];
    let mesh = blocks::block(ElementKind::Hex20, [20, 3, 2], bar);
    std::fs::write(folder.join("bar.msh"), gmsh(&mesh, Form::Binary41)).unwrap();
    solid_file::write_bar(&folder.join("bar.h5"), [20, 3, 2]);
    write_beam(&folder.join("beam.h5"));
    folder
}

/// Frequencies \[Hz\] and damping ratios of the vibrations of the equations of motion about the start, by differences of the right-hand
/// side: nothing of it knows how the damping was made.
fn vibrations(folder: &std::path::Path, text: &str) -> Vec<(f64, f64)> {
    let scenario = scenarios::valid(folder, text, &[]);
    let mut model = RunModel::build(&scenario.run).unwrap();
    let y = model.initial.clone();
    let n = model.system.model().n_states();
    let mut rates = vec![0.0; y.len()];
    let mut jacobian = DMatrix::<f64>::zeros(n, n);
    for j in 0..n {
        // Linear but for terms of the second order, which central differences do not see.
        let step = 1e-6;
        for sign in [1.0, -1.0] {
            let mut moved = y.clone();
            moved[j] += sign * step;
            model.system.rhs(0.0, &moved, &mut rates).unwrap();
            (0..n).for_each(|i| jacobian[(i, j)] += sign * rates[i] / (2.0 * step));
        }
    }
    let values = jacobian.complex_eigenvalues();
    let mut found: Vec<(f64, f64)> =
        values.iter().filter(|s| s.im > 1.0).map(|s| (s.norm() / TAU, -s.re / s.norm())).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

#[test]
fn ratios_hold_for_every_kind_of_body_on_one_and_two_joints() {
    ratios_hold(&LAWS[..1]);
}

#[test]
#[ignore = "second tier: half a dozen seconds"]
fn ratios_of_other_laws_hold_for_every_kind_of_body_on_one_and_two_joints() {
    ratios_hold(&LAWS[1..]);
}

fn ratios_hold(laws: &[Law]) {
    let folder = folder();
    for (kind, bar) in BARS {
        let at = |joint: &str| match kind {
            "file" => joint
                .replace("face = \"x-\"", "marker = \"foot\"")
                .replace("face = \"x+\"", "marker = \"tip\""),
            _ => joint.to_owned(),
        };
        let held = [
            ("clamp", at(CLAMP)),
            ("hinge", at(HINGE)),
            ("two hinges", at(HINGE) + &at(OTHER_HINGE)),
            ("clamp and hinge", at(CLAMP) + &at(OTHER_HINGE)),
        ];
        for (place, joints) in &held {
            for (damping, law) in laws {
                let text = format!("{WORLD}{ALUMINIUM}{bar}{damping}{joints}");
                let what = format!("{kind}, {place}, {damping}");
                let scenario = scenarios::valid(&folder, &text, &[]);
                let (_, system) = system_modes(&scenario, false, 1).unwrap();
                let listed = system.modes.iter().filter(|m| m.frequency() > 1.0).take(3);
                for mode in listed {
                    let (f, found) = (mode.frequency(), mode.damping_ratio().unwrap());
                    // Modes of the eigensolver; loops stand open by nothing.
                    assert!((found / law(f) - 1.0).abs() < 1e-6, "{what}: {found} at {f} Hz");
                }
                if place.contains("two") || place.contains("and") {
                    continue; // loops have no coordinates of their own to take eigenvalues of
                }
                for (f, found) in vibrations(&folder, &text).into_iter().take(3) {
                    println!("{what}: {f:.3} Hz {found:.6}, {:.6} asked", law(f));
                    // Modes are not coupled; differences of steps of 1e-6 m kg^(1/2) and round-off of 1e11/s² leave less than this.
                    assert!((found / law(f) - 1.0).abs() < 1e-3, "{what}: {found} at {f} Hz");
                }
            }
        }
    }
}

/// Logarithmic decrement of the tip: of the first mode, in which it sags, after higher ones have gone.
#[test]
fn free_decay_of_a_cantilever_has_the_ratio() {
    let folder = folder();
    let (_, bar) = BARS[0];
    for method in ["dormand-prince", "gauss"] {
        let text = format!(
            "[simulation]\nend_time = 0.1\ngravity = [0.0, 0.0, -9.81]\nfree = {{ integrator = \"{method}\" }}\n{ALUMINIUM}{bar}{}{CLAMP}\
             [output]\nfree_interval = 1e-4\n[output.points.tip]\nbody = \"beam\"\npoint = [0.15, 0.0, 0.0]\n",
            LAWS[0].0
        );
        let record = scenarios::run(&scenarios::valid(&folder, &text, &[]));
        let course: Vec<(f64, f64)> =
            record.samples.iter().map(|s| (s.time, s.points[0].position[2])).collect();
        let swing = |from: f64, to: f64| {
            let part = course.iter().filter(|(t, _)| *t >= from && *t < to).map(|(_, z)| *z);
            part.clone().fold(f64::MIN, f64::max) - part.fold(f64::MAX, f64::min)
        };
        // Six periods of 10.95 ms apart.
        let period = 1.0 / 91.33;
        let ratio =
            (swing(0.01, 0.01 + period) / swing(0.01 + 6.0 * period, 0.01 + 7.0 * period)).ln() / (6.0 * TAU);
        println!("{method}: {ratio:.5}");
        // Samples of 0.1 ms miss the turning points by (2 pi 0.05/10.95)^2/2 = 4e-4 of the swing, alike in both windows.
        assert!((ratio / 0.02 - 1.0).abs() < 0.01, "{method}: {ratio}");
    }
}
