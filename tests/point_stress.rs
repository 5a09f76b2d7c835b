//! Histories of stress and strain at points: beams, bars and waves in them, in closed form; what of them is stored.

use crate::blocks;
use crate::support::scenarios;
use std::path::PathBuf;

use crate::support::bar::ALUMINIUM;
use crate::support::scenarios::{parse, run, valid};
use crate::writers::{Form, gmsh};
use adaptive::run::recording::Recording;
use fe_mesh::ElementKind;

fn recorded(text: &str, set: &[&str]) -> Recording {
    run(&valid(&folder(), text, set))
}

fn folder() -> PathBuf {
    scenarios::folder("point_stress")
}

const RHO: f64 = 7850.0;
const YOUNG: f64 = 210e9;

/// A rod of 1 mm and 0.2 m whose lower end is pushed by a smooth pulse. Without lateral contraction it is a bar to theory.
const PULSE: &str = r#"
[simulation]
end_time = 30e-6

[materials.steel]
youngs_modulus = 210e9
poissons_ratio = 0.0
density = 7850.0

[bodies.rod]
model = "axisymmetric"
material = "steel"
geometry = { shape = "rod", radius = 1e-3, length = 0.2 }
discretisation = { degree = 4, elements = [1, 100] }
reduction = { modes = 60 }

[loads.push]
body = "rod"
face = "z-"
force_z = { kind = "harmonic", amplitude = 50.0, frequency = 50e3, phase_deg = -90, offset = 50.0 }

[output]
free_interval = 1e-7
points.middle = { body = "rod", point = [0.0, 0.08], stress = true, strain = true }
points.outside = { body = "rod", point = [1e-3, 0.05], stress = true }
"#;

/// A wave that travels one way has the stress `-ρ c v` at every point and instant.
#[test]
fn a_wave_along_a_bar_has_the_stress_rho_c_v() {
    let trace = recorded(PULSE, &[]);
    let (area, c) = (std::f64::consts::PI * 1e-6, (YOUNG / RHO).sqrt());
    let pushed =
        |t: f64| if t > 0.0 { 50.0 * (1.0 - (2.0 * std::f64::consts::PI * 50e3 * t).cos()) } else { 0.0 };
    let mut worst = [0.0_f64; 3];
    for sample in &trace.samples {
        for (point, z) in sample.points.iter().zip([0.08, 0.05]) {
            let stress = point.state.stress[1];
            let expected = -pushed(sample.time - z / c) / area;
            worst[0] = worst[0].max((stress + RHO * c * point.velocity[2]).abs());
            worst[1] = worst[1].max((stress - expected).abs());
        }
        let first = &sample.points[0].state;
        worst[2] = worst[2].max((first.strain[1] - first.stress[1] / YOUNG).abs() * YOUNG);
    }
    let peak = 100.0 / area;
    println!(
        "of the peak: {:.1e} from rho c v, {:.1e} from the pulse, {:.1e} from Hooke",
        worst[0] / peak,
        worst[1] / peak,
        worst[2] / peak
    );
    // The force has a kink in its slope at the start, whose Fourier coefficients fall with the square of the mode's number: what 60 modes leave of
    // the pulse of half the rod's length is some (15 π)^-2, 5e-4; the terms beyond add up to a few of it.
    assert!(worst[0] < 2e-3 * peak && worst[1] < 2e-3 * peak);
    assert!(worst[2] < 1e-12 * peak); // round-off
}

/// A cantilever of 0.3 × 0.03 × 0.01 m under a force at its end.
const CANTILEVER: &str = r#"
[simulation]
end_time = 1e-6
static_start = true

[bodies.beam]
material = "aluminium"
geometry = { shape = "box", size = [0.3, 0.03, 0.01] }
discretisation = { degree = 3, elements = [20, 3, 2] }
frame = "tangent"

[joints.clamp]
type = "fixed"
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "beam", face = "x-" }

[loads.tip]
body = "beam"
face = "x+"
force_z = -20.0

[output]
points.near_root = { body = "beam", point = [-0.12, 0.0, 0.005], stress = true, strain = true }
points.middle = { body = "beam", point = [0.0, 0.01, 0.005], stress = true }
points.neutral = { body = "beam", point = [0.0, 0.0, 0.0], stress = true }
"#;

const MESHED: &str = r#"
[bodies.beam]
model = "mesh"
file = "bar.msh"
units = "mm"
material = "aluminium"
frame = "tangent"
"#;

/// Saint-Venant's solution: bending stress `F (L - x) z / I` wherever the ends are far, and the shear `3 F / 2 A` of a narrow section on the neutral
/// axis, here of a wide one, which Poisson's ratio lowers at the middle (Timoshenko and Goodier, section 124).
#[test]
fn stress_of_a_cantilever_is_that_of_beam_theory() {
    let second_moment = 0.03 * 0.01_f64.powi(3) / 12.0;
    let bending = |x: f64, z: f64| 20.0 * (0.3 - x) * z / second_moment;
    let bar = |[x, y, z]: [f64; 3]| [300.0 * (x - 0.5), 30.0 * (y - 0.5), 10.0 * (z - 0.5)];
    let mesh = gmsh(&blocks::block(ElementKind::Hex20, [20, 3, 2], bar), Form::Binary41);
    std::fs::write(folder().join("bar.msh"), mesh).unwrap();
    let meshed = CANTILEVER.replace(
        &CANTILEVER[CANTILEVER.find("[bodies").unwrap()..CANTILEVER.find("[joints").unwrap()],
        MESHED,
    );
    for (what, text) in [("splines", CANTILEVER.to_owned()), ("mesh", meshed)] {
        let trace = recorded(&format!("{ALUMINIUM}{text}"), &[]);
        let points = &trace.samples[0].points;
        let [root, middle, neutral] = [0, 1, 2].map(|i| points[i].state);
        let errors =
            [root.stress[0] / bending(0.03, 0.005) - 1.0, middle.stress[0] / bending(0.15, 0.005) - 1.0];
        println!(
            "{what}: root off by {:.1e}, middle by {:.1e}; neutral axis {:?}",
            errors[0], errors[1], neutral.stress
        );
        // Bending stress is linear in x and z, which splines of degree 3 have exactly and the averages at nodes of 20-node elements restore. Three
        // heights from the clamp, which holds the mean of its face alone, the end effect is some e^-5 of the stress there.
        let limits = [1e-2, 1e-3];
        assert!(errors.iter().zip(limits).all(|(e, limit)| e.abs() < limit), "{what}: {errors:?}");
        let strain = root.stress[0] / 70e9;
        assert!(
            (root.strain[0] / strain - 1.0).abs() < 2e-2,
            "free surfaces: {:e} {strain:e}",
            root.strain[0]
        );
        // Hooke's law for the angle, up to round-off of the bending above and below, which cancels on the neutral axis.
        let modulus = 70e9 / (2.0 * 1.33);
        let misfit = (neutral.strain[5] * modulus - neutral.stress[5]).abs();
        assert!(misfit < 1e-12 * bending(0.15, 0.005), "{what}: {neutral:?}");
        assert!(neutral.stress[0].abs() < 1e-3 * bending(0.15, 0.005));
        // The shear force is -F on the face towards +x.
        let shear = neutral.stress[5] / (-1.5 * 20.0 / (0.03 * 0.01));
        assert!(shear > 0.6 && shear < 1.0, "{what}: {shear}");
    }
}

#[test]
fn stress_where_there_is_none_is_refused() {
    let faults = |text: &str| {
        let text = format!("{ALUMINIUM}{text}");
        parse(&folder(), &text, &[]).unwrap_err().iter().map(|f| format!("{f}\n")).collect::<String>()
    };
    let rigid = CANTILEVER
        .replace("frame = \"tangent\"", "")
        .replace("discretisation = { degree = 3, elements = [20, 3, 2] }", "model = \"rigid\"");
    let text = faults(&rigid);
    assert!(
        text.contains("output.points.near_root.stress") && text.contains("a rigid body has no stress"),
        "{text}"
    );
    let area = CANTILEVER.replace("point = [0.0, 0.0, 0.0], stress", "marker = \"patch\", stress");
    let area =
        area.replace("[joints.clamp]", "[bodies.beam.markers]\npatch = { face = \"x+\" }\n\n[joints.clamp]");
    let text = faults(&area);
    assert!(text.contains("output.points.neutral.stress") && text.contains("has an extent"), "{text}");
}
