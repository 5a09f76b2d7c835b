//! Static equilibrium: of bodies, joints, loops and contacts, against closed forms, and that runs from it stay there.

use std::f64::consts::PI;

use adaptive::record::Sample;
use adaptive::record::warning::WarningKind;
use adaptive::run::recording::Recording;
use nalgebra::Vector3;

use crate::support::fbimpact;
use crate::support::scenarios::{faults, folder, refusal, run, valid};

/// Share of all forces that may be left; contact forces are solved to a hundredth of it.
const BALANCED: f64 = 1e-8;

fn settled(text: &str) -> Sample {
    let recording = run(&valid(&folder("equilibrium"), text, &["simulation.start=\"static-only\""]));
    assert_eq!(recording.samples.len(), 1, "one state");
    recording.samples[0].clone()
}

fn continued(text: &str) -> Recording {
    run(&valid(&folder("equilibrium"), text, &["simulation.start=\"static\""]))
}

/// Largest change of a contact force in a run, as a share of it.
fn unrest(recording: &Recording, contact: usize) -> f64 {
    let forces = recording.samples.iter().map(|sample| sample.contacts[contact].normal_force);
    let (least, most) = forces.fold((f64::INFINITY, 0.0_f64), |(a, b), force| (a.min(force), b.max(force)));
    (most - least) / most
}

const FLOOR: &str = "[bodies.floor]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\n";
const MEETS_FLOOR: &str = "[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"floor\"\n";

/// A steel ball of 10 mm, a micrometre above the floor, in gravity.
fn ball() -> String {
    format!(
        "[simulation]\nend_time = 2e-5\ngravity = [0.0, 0.0, -9.81]\n\
[bodies.a]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = 10e-3 }}\n\
position = [0.0, 0.0, 10.001e-3]\n{FLOOR}{MEETS_FLOOR}"
    )
}

#[test]
fn a_ball_set_down_yields_as_hertz_says_and_stays_at_rest() {
    let state = settled(&ball());
    let (radius, young, poisson, density) = (10e-3_f64, 210e9, 0.3, 7850.0);
    let weight = 4.0 / 3.0 * PI * radius.powi(3) * density * 9.81;
    // What is left of all forces, weight and contact, and rounding of the sphere's volume on its mesh.
    let force = state.contacts[0].normal_force;
    assert!((force / weight - 1.0).abs() < 1e-6, "{force} for {weight}");
    let stiffness = 4.0 / 3.0 * young / (1.0 - poisson * poisson) * radius.sqrt();
    let approach = (weight / stiffness).powf(2.0 / 3.0);
    let found = radius - state.bodies[0].centre_of_mass[2];
    // A ball is not a half space: its weight is spread over it, which is of the order a/R = 2e-3, and the zone
    // has some tens of elements.
    assert!((found / approach - 1.0).abs() < 0.01, "{found:e} for {approach:e}");
    // Rest is stored as often as is asked for.
    let recording = continued(&(ball() + "[output]\nfree_interval = 1e-6\n"));
    assert!(unrest(&recording, 0) < 100.0 * BALANCED, "{:e}", unrest(&recording, 0));
    assert!(recording.samples.len() > 10 && recording.energy_drift() < 1e-6);
}

/// A disc of 10 mm pressed on a floor by a spring of `force` N on a slide, turned by `angle`.
fn bolt(force: f64, angle: f64) -> String {
    let (c, s) = (angle.cos(), angle.sin());
    format!(
        "[simulation]\nend_time = 5e-6\n\
[bodies.a]\nmodel = \"plane-strain\"\nthickness = 0.02\nmaterial = \"steel\"\ngeometry = {{ shape = \"disc\", radius = 10e-3 }}\n\
discretisation = {{ elements = [4, 4] }}\nreduction = {{ modes = 6 }}\n\
[joints.bolt]\ntype = \"prismatic\"\naxis = [{:?}, {c:?}, 0.0]\nparent = {{ body = \"ground\", point = [{:?}, {:?}, 0.0] }}\n\
child = {{ body = \"a\", point = [0.0, 0.0], radius = 3e-3 }}\nstiffness = 1e6\nrest = {:?}\n\
[bodies.floor]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nnormal = [{:?}, {c:?}, 0.0]\n{MEETS_FLOOR}",
        -s,
        -s * 0.01,
        c * 0.01,
        -force / 1e6,
        -s
    )
}

#[test]
fn a_spring_presses_at_once_with_what_it_settles_at() {
    for (force, angle) in [(1000.0, 0.0), (1000.0, 0.7), (1.0, 0.0)] {
        let recording = continued(&bolt(force, angle));
        let first = &recording.samples[0];
        let pressed = Vector3::from(first.contacts[0].force).norm();
        let held = Vector3::from(first.joints[0].reaction_force).norm();
        assert!(
            (pressed / held - 1.0).abs() < 10.0 * BALANCED,
            "{pressed} N on the floor, {held} N by the spring"
        );
        // The spring gives way by what disc and floor yield, a thousandth of its own travel.
        assert!((pressed / force - 1.0).abs() < 2e-3, "{pressed} of {force} N");
        assert!(
            unrest(&recording, 0) < 100.0 * BALANCED,
            "{force} N at {angle}: {:e}",
            unrest(&recording, 0)
        );
        let told = |kind| recording.warnings.iter().any(|warning| warning.kind == kind);
        assert!(
            !told(WarningKind::StaticContact) && !told(WarningKind::NeverClosed),
            "{:?}",
            recording.warnings
        );
    }
}

/// The roller of NAFEMS CGS-1 on its block at a tenth of the load, where linear elasticity holds.
const ROLLER: &str = r#"
[simulation]
end_time = 1e-3
[materials.roller]
youngs_modulus = 210e9
poissons_ratio = 0.3
density = 7850.0
[materials.block]
youngs_modulus = 70e9
poissons_ratio = 0.3
density = 2700.0
[bodies.roller]
model = "plane-strain"
thickness = 1e-3
material = "roller"
geometry = { shape = "disc", radius = 50e-3 }
[bodies.block]
model = "plane-strain"
thickness = 1e-3
material = "block"
geometry = { shape = "rectangle", size = [200e-3, 200e-3] }
[joints.base]
type = "fixed"
parent = { body = "ground", point = [0.0, -200e-3, 0.0] }
child = { body = "block", face = "y-" }
[joints.guide]
type = "prismatic"
axis = [0.0, 1.0, 0.0]
parent = { body = "ground", point = [0.0, 50e-3, 0.0] }
child = { body = "roller", point = [0.0, 0.0], radius = 10e-3 }
[loads.press]
body = "roller"
point = [0.0, 0.0]
radius = 10e-3
force_y = -3500.0
[contacts.c]
contact_body = "roller"
target_body = "block"
"#;

#[test]
fn a_roller_on_a_block_has_the_pressure_of_hertz() {
    let state = settled(ROLLER);
    // 1/E* of both, half width and pressure of a line of 3.5 kN/mm (Johnson 4.43, 4.45): 1.965 mm, 1133.8 MPa.
    let (load, radius) = (3500.0 / 1e-3, 50e-3);
    let modulus = 1.0 / (0.91 / 210e9 + 0.91 / 70e9);
    let width = (4.0 * load * radius / (PI * modulus)).sqrt();
    let peak = 2.0 * load / (PI * width);
    // p² = p0² (1 - x²/a²) is a straight line over x².
    let points = state.pressures[0].iter().filter(|point| point.pressure > 0.3 * peak);
    let (mut n, mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for point in points {
        let (x, y) = (point.position[0].powi(2), point.pressure.powi(2));
        (n, sx, sy, sxx, sxy) = (n + 1.0, sx + x, sy + y, sxx + x * x, sxy + x * y);
    }
    let slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    let at_middle = (sy - slope * sx) / n;
    let (found, half) = (at_middle.sqrt(), (-at_middle / slope).sqrt());
    assert!((found / peak - 1.0).abs() < 0.01, "{found:e} for {peak:e}");
    // A fifth of an element of the zone, of which some twelve press.
    assert!((half / width - 1.0).abs() < 0.02, "{half:e} for {width:e}");
}

#[test]
fn of_a_stack_each_ball_carries_those_above_it() {
    const N: usize = 5;
    let mut text = "[simulation]\nend_time = 2e-5\ngravity = [0.0, 0.0, -9.81]\n".to_owned() + FLOOR;
    let contact = |name: &str, target: &str| {
        format!("[contacts.{name}]\ncontact_body = \"{name}\"\ntarget_body = \"{target}\"\n")
    };
    for i in 0..N {
        let below = if i == 0 { "floor".to_owned() } else { format!("b{}", i - 1) };
        text += &format!(
            "[bodies.b{i}]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = 10e-3 }}\n\
             position = [0.0, 0.0, {}]\n",
            0.01 + 0.02 * i as f64
        );
        text += &contact(&format!("b{i}"), &below);
    }
    let state = settled(&text);
    let weight = state.contacts[N - 1].normal_force;
    let expected = 4.0 / 3.0 * PI * 10e-3_f64.powi(3) * 7850.0 * 9.81;
    // Rounding of the sphere's volume on its mesh, and what is left of all forces: the zones are of those that each carries at last.
    assert!((weight / expected - 1.0).abs() < 1e-6, "{weight} {expected}");
    for (i, contact) in state.contacts.iter().enumerate() {
        let above = (N - i) as f64;
        assert!(
            (contact.normal_force / (above * weight) - 1.0).abs() < 1e-6,
            "{i}: {}",
            contact.normal_force
        );
    }
}

#[test]
fn what_is_not_held_is_named() {
    let falls = format!(
        "{}\n[bodies.b]\nmodel = \"rigid\"\nmass = 0.5\ninertia = [1e-4, 1e-4, 1e-4]\nposition = [0.1, 0.0, 0.0]\n",
        ball()
    );
    let text = refusal(&valid(&folder("equilibrium"), &falls, &["simulation.start=\"static\""]));
    // 0.5 kg in gravity.
    assert!(
        text.contains("body \"b\" is not held") && text.contains("4.905") && text.contains("along"),
        "{text}"
    );
    let both = format!(
        "{}\n",
        ball().replace("[simulation]", "[simulation]\nstart = \"static\"\nstatic_start = true")
    );
    assert!(faults(&both).contains("static_start"), "{}", faults(&both));
}

#[test]
fn a_body_that_moves_keeps_its_pose_while_others_settle() {
    let text = format!(
        "{}\n[bodies.b]\nmodel = \"rigid\"\nmass = 0.5\ninertia = [1e-4, 1e-4, 1e-4]\nposition = [0.1, 0.0, 0.0]\nvelocity = [3.0, 0.0, 1.0]\n",
        ball()
    );
    let first = &continued(&text).samples[0];
    let is_same = |a: [f64; 3], b: [f64; 3]| (Vector3::from(a) - Vector3::from(b)).norm() < 1e-15;
    assert!(
        is_same(first.bodies[1].position, [0.1, 0.0, 0.0])
            && is_same(first.bodies[1].velocity, [3.0, 0.0, 1.0])
    );
    assert!(first.contacts[0].normal_force > 0.0);
}

/// A rigid ball by Hertz's law, pressed on the floor and pushed along it.
fn pushed(friction: f64) -> String {
    format!(
        "[simulation]\nend_time = 2e-5\n\
[bodies.a]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = 10e-3 }}\n\
[joints.guide]\ntype = \"generic\"\nlocked = [\"y\", \"rx\", \"ry\", \"rz\"]\nparent = {{ body = \"ground\", point = [0.0, 0.0, 10e-3] }}\n\
child = {{ body = \"a\", point = [0.0, 0.0, 0.0] }}\n\
[loads.press]\nbody = \"a\"\npoint = [0.0, 0.0, 0.0]\nforce_z = -100.0\nforce_x = 10.0\n\
{FLOOR}{MEETS_FLOOR}model = \"hertz\"\nfriction = {friction:?}\n"
    )
}

#[test]
fn friction_holds_what_it_can_and_goes_on_holding_it() {
    let recording = continued(&pushed(0.3));
    for sample in &recording.samples {
        let [x, y, _] = sample.contacts[0].friction_force;
        assert!((x / -10.0 - 1.0).abs() < 100.0 * BALANCED && y.abs() < 1e-6, "{x} {y}");
    }
    assert!(unrest(&recording, 0) < 100.0 * BALANCED);
    // With less friction than that nothing holds it.
    let slides = refusal(&valid(&folder("equilibrium"), &pushed(0.05), &["simulation.start=\"static\""]));
    assert!(slides.contains("body \"a\" is not held"), "{slides}");
}

/// Rods of a kilogram as a chain between two places of the ground a metre apart, straight down at the start where one end is let
/// down to.
fn chain(is_closed: bool) -> String {
    let rod = |name: &str| {
        format!("[bodies.{name}]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1e-4, 2e-2, 2e-2]\n")
    };
    let hinge = |name: &str, parent: &str, child: &str| {
        format!(
            "[joints.{name}]\ntype = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nparent = {parent}\nchild = {child}\n"
        )
    };
    let end = |body: &str, x: f64| format!("{{ body = \"{body}\", point = [{x:?}, 0.0, 0.0] }}");
    let mut text = "[simulation]\nend_time = 0.02\ngravity = [0.0, 0.0, -9.81]\n".to_owned();
    text += &["a", "b", "d"].map(rod).concat();
    text += &hinge("ja", &end("ground", 0.0), &end("a", -0.25));
    text += &hinge("jb", &end("a", 0.25), &end("b", -0.25)).replace("child =", "angle = 0.6\nchild =");
    text += &hinge("jd", &end("b", 0.25), &end("d", -0.25)).replace("child =", "angle = 0.6\nchild =");
    if is_closed {
        text += &hinge("close", &end("ground", 1.0), &end("d", 0.25))
            .replace("child =", "closes_loop = true\nchild =");
    }
    text
}

#[test]
fn chains_hang_and_stay() {
    for is_closed in [false, true] {
        let recording = continued(&chain(is_closed));
        let (first, last) = (&recording.samples[0], recording.samples.last().unwrap());
        for (a, b) in first.bodies.iter().zip(&last.bodies) {
            let moved = (Vector3::from(a.centre_of_mass) - Vector3::from(b.centre_of_mass)).norm();
            // In 20 ms what is left of all forces moves a body by BALANCED g t²/2, 2e-11 m, in an unstable pose more.
            assert!(moved < 1e-9, "closed {is_closed}: {moved:e} m");
        }
        let lowest = first.bodies.iter().map(|body| body.centre_of_mass[2]).fold(0.0, f64::min);
        if is_closed {
            // Of four bars, three of half a metre over a metre: symmetric, the middle one level, the others at 60 degrees.
            assert!((lowest + 0.25 * 3.0_f64.sqrt()).abs() < 1e-7, "{lowest}");
        } else {
            assert!((lowest + 1.25).abs() < 1e-7, "{lowest}");
        }
    }
}

#[test]
fn a_tilted_block_comes_to_lie() {
    let state = settled(
        "[simulation]\nend_time = 1e-4\ngravity = [0.0, -9.81, 0.0]\n\
[bodies.a]\nmodel = \"plane-strain\"\nthickness = 0.02\nmaterial = \"steel\"\ngeometry = { shape = \"rectangle\", size = [20e-3, 10e-3] }\n\
discretisation = { elements = [4, 2] }\nreduction = { modes = 6 }\norientation = [0.0, 0.0, 0.05]\nposition = [0.0, 5.6e-3, 0.0]\n\
[bodies.floor]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\nnormal = [0.0, 1.0, 0.0]\n\
[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"floor\"\n",
    );
    let weight = 20e-3 * 10e-3 * 0.02 * 7850.0 * 9.81;
    let force = state.contacts[0].normal_force;
    assert!((force / weight - 1.0).abs() < 1e-5, "{force} for {weight}");
    // Level: a face that yields by some 1e-11 m holds the angle.
    assert!(state.bodies[0].rotation[3].abs() < 1e-8, "{:?}", state.bodies[0].rotation);
    assert!((state.bodies[0].centre_of_mass[1] - 5e-3).abs() < 1e-9);
}

#[test]
fn an_equilibrium_that_does_not_hold_is_told() {
    let told = |angle: f64| {
        let text = format!(
            "[simulation]\nend_time = 1e-3\ngravity = [0.0, 0.0, -9.81]\n\
[bodies.rod]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1e-4, 2e-2, 2e-2]\n\
[joints.hinge]\ntype = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nangle = {angle:?}\nparent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\n\
child = {{ body = \"rod\", point = [-0.25, 0.0, 0.0] }}\n"
        );
        let recording = continued(&text);
        recording.warnings.into_iter().find(|warning| warning.kind == WarningKind::Unstable)
    };
    // Turned up by a quarter about y, x points along -z; down it is stable. ω² = -m g l/(J + m l²).
    let warning = told(-PI / 2.0).expect("upright");
    let squared = -9.81 * 0.25 / (2e-2 + 0.0625);
    assert!((warning.value / squared - 1.0).abs() < 1e-6, "{} for {squared}", warning.value);
    assert!(told(PI / 2.0).is_none());
}

#[test]
fn the_command_prints_what_acts_and_keeps_the_state() {
    let folder = folder("equilibrium_command");
    let file = folder.join("ball.toml");
    std::fs::write(&file, ball()).unwrap();
    let (file, output) = (file.to_str().unwrap(), folder.join("ball.h5"));
    let output = output.to_str().unwrap();
    let (code, text, words) = fbimpact(&["static", file, "-o", output, "--force", "--no-cache"]);
    assert!(
        code == 0 && text.contains("normal force [N]") && text.contains("3.22572"),
        "{code} {text} {words}"
    );
    let (code, text, _) = fbimpact(&["static", file, "-o", output, "--force", "--no-cache", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(
        code == 0
            && json["contacts"]["c"]["normal_force"].as_f64().is_some_and(|f| (f - 0.32257).abs() < 1e-4),
        "{text}"
    );
    // It is a result like others.
    for command in
        [&["info", output][..], &["report", output, "-o", folder.join("r.html").to_str().unwrap(), "--force"]]
    {
        let (code, _, words) = fbimpact(command);
        assert!(code == 0, "{command:?}: {words}");
    }
}
