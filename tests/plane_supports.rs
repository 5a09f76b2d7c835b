//! Joints of type `generic` on plane bodies: a beam on a pin and a roller, a pendulum whose support slides, against closed forms; what is refused.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::Path;

use crate::support::scenarios;

const LENGTH: f64 = 0.4;
const HEIGHT: f64 = 8e-3;
const THICKNESS: f64 = 5e-3;
/// Steel of the scenarios: E \[Pa\], E/G, density [kg/m³].
const STEEL: [f64; 3] = [210e9, 2.6, 7800.0];

/// The beam in 80 elements of eight nodes, with the sets `start` and `end`.
fn mesh() -> String {
    let (mut text, n) = ("*NODE\n".to_owned(), 80);
    let label = |i: usize, j: usize| 3 * i + j + 1;
    for i in 0..=2 * n {
        for j in (0..3).filter(|j| i % 2 == 0 || *j != 1) {
            let (x, y) = (LENGTH * (i as f64 / (2 * n) as f64 - 0.5), HEIGHT * (0.5 * j as f64 - 0.5));
            writeln!(text, "{}, {x:e}, {y:e}", label(i, j)).unwrap();
        }
    }
    text += "*ELEMENT, TYPE=CPS8, ELSET=beam\n";
    for e in 0..n {
        let i = 2 * e;
        let corners = [label(i, 0), label(i + 2, 0), label(i + 2, 2), label(i, 2)];
        let middles = [label(i + 1, 0), label(i + 2, 1), label(i + 1, 2), label(i, 1)];
        let nodes = [corners, middles].concat().iter().map(usize::to_string).collect::<Vec<_>>();
        writeln!(text, "{}, {}", e + 1, nodes.join(", ")).unwrap();
    }
    let last = label(2 * n, 0);
    text + &format!("*NSET, NSET=start\n1, 2, 3\n*NSET, NSET=end\n{last}, {}, {}\n", last + 1, last + 2)
}

/// The beam, of elements or splines, on a pin at its start and on a roller at its end, whose plane is inclined by `angle`.
fn beam(is_mesh: bool, angle: f64) -> String {
    let made_of = if is_mesh {
        "file = \"beam.inp\"\nunits = \"m\"".to_owned()
    } else {
        format!(
            "geometry = {{ shape = \"rectangle\", size = [{LENGTH}, {HEIGHT}] }}\ndiscretisation = {{ degree = 3, elements = [16, 1] }}"
        )
    };
    let along = [angle.cos(), angle.sin(), 0.0];
    format!(
        "[simulation]\nend_time = 1e-6\n[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7800.0\n\
         [bodies.beam]\nmodel = \"plane-stress\"\nthickness = {THICKNESS}\nmaterial = \"steel\"\nreduction = {{ modes = 12 }}\n{made_of}\n\
         [joints.pin]\ntype = \"revolute\"\naxis = [0.0, 0.0, 1.0]\nparent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\n\
         child = {{ body = \"beam\", face = \"start\" }}\n\
         [joints.roller]\ntype = \"generic\"\nlocked = [\"y\"]\naxis = [0.0, 0.0, 1.0]\nreference = {along:?}\ncloses_loop = true\n\
         parent = {{ body = \"ground\", point = [{LENGTH}, 0.0, 0.0] }}\nchild = {{ body = \"beam\", face = \"end\" }}\n"
    )
}

#[test]
fn beam_on_pin_and_roller_has_its_frequencies_and_reactions() {
    let folder = scenarios::folder("plane_supports");
    std::fs::write(folder.join("beam.inp"), mesh()).unwrap();
    let [modulus, shear, density] = STEEL;
    let gyration = HEIGHT / 12.0_f64.sqrt();
    for is_mesh in [true, false] {
        let found = scenarios::system_frequencies(&scenarios::valid(&folder, &beam(is_mesh, 0.0), &[]));
        for (n, found) in (1..=3).map(f64::from).zip(&found) {
            // Timoshenko's beam with sin(n π x / L): a ω⁴ − b ω² + ω₀² = 0.
            let k = n * PI / LENGTH;
            let by_shear = shear * 6.0 / 5.0; // E/(κ G)
            let (a, b) = (
                density * by_shear / modulus * gyration * gyration,
                1.0 + (k * gyration).powi(2) * (1.0 + by_shear),
            );
            let bernoulli = k * k * gyration * (modulus / density).sqrt();
            let square = (b - (b * b - 4.0 * a * bernoulli * bernoulli).sqrt()) / (2.0 * a);
            let wanted = square.sqrt() / TAU;
            println!("{n}: {found:.4} Hz, {wanted:.4} Hz, {:.2e}", found / wanted - 1.0);
            // Elements of 80 leave 8e-4 of the third, splines of 16 a third of that.
            assert!((found / wanted - 1.0).abs() < 1e-3, "{found} Hz, {wanted} Hz");
        }
        let weight = density * LENGTH * HEIGHT * THICKNESS * 9.81;
        let angle = 30.0_f64.to_radians();
        let set = ["simulation.gravity=[0.0,-9.81,0.0]", "simulation.start=static-only"];
        let held = scenarios::run(&scenarios::valid(&folder, &beam(is_mesh, angle), &set));
        let joints = &held.samples[0].joints;
        // Moments about the pin; what the roller gives is normal to its plane.
        let normal = 0.5 * weight / angle.cos();
        let roller = [-normal * angle.sin(), normal * angle.cos()];
        for (joint, wanted) in joints.iter().zip([[-roller[0], weight - roller[1]], roller]) {
            let error = (joint.reaction_force[0] - wanted[0]).hypot(joint.reaction_force[1] - wanted[1]);
            println!("{:?} {wanted:?} {:.1e}", joint.reaction_force, error / weight);
            // The sag of 2e-5 m is 6e-5 of the length, its square what it does to the arms.
            assert!(error < 1e-6 * weight, "{:?}, {wanted:?} N", joint.reaction_force);
            assert!(joint.reaction_moment.iter().all(|m| m.abs() < 1e-9), "{:?}", joint.reaction_moment);
        }
    }
}

/// The weight of a beam that is held at one end has no moment about its centre of mass.
#[test]
fn face_with_an_arm_holds_at_the_point_that_is_given() {
    let text = beam(false, 0.0);
    let (text, _) = text.split_once("[joints.pin]").unwrap();
    let joint = |keys: &str| {
        format!(
            "{text}[joints.clamp]\ntype = \"fixed\"\nparent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\n\
             child = {{ body = \"beam\", face = \"start\", coupling = \"rigid\", {keys} }}\n"
        )
    };
    let set = ["simulation.gravity=[0.0,-9.81,0.0]", "simulation.start=static-only"];
    let [_, _, density] = STEEL;
    let weight = density * LENGTH * HEIGHT * THICKNESS * 9.81;
    for x in [0.0, -0.1] {
        let held =
            scenarios::run(&scenarios::valid(Path::new("."), &joint(&format!("point = [{x}, 0.0]")), &set));
        let moment = held.samples[0].joints[0].reaction_moment[2];
        // The beam sags by 4e-4 m, turned by 1.3e-3: its square is what the arm loses.
        assert!((moment + weight * x).abs() < 1e-5 * weight * LENGTH, "{x}: {moment} N m, {weight} N");
    }
    let message = scenarios::faults(&joint("point = [0.0, 0.0], radius = 1e-3"));
    assert!(message.contains("radius") && message.contains("alone"), "{message}");
    let message = scenarios::faults(&joint("marker = \"centre\""));
    assert!(message.contains("only one of"), "{message}");
}

/// A rod of 0.2 m that hangs from a support which slides along x.
fn pendulum(is_rigid: bool) -> String {
    let (model, place) = if is_rigid {
        ("model = \"rigid\"\nmotion = \"planar\"", "point = [0.0, 0.1]")
    } else {
        (
            "model = \"plane-stress\"\nreduction = { modes = 4 }\ndiscretisation = { degree = 3, elements = [2, 8] }",
            "face = \"y+\"",
        )
    };
    format!(
        "[simulation]\nend_time = 0.5\ngravity = [0.0, -9.81, 0.0]\n[bodies.rod]\n{model}\nmaterial = \"steel\"\nthickness = 5e-3\n\
         geometry = {{ shape = \"rectangle\", size = [2e-2, 0.2] }}\n\
         [joints.slide]\ntype = \"generic\"\nlocked = [\"y\"]\nparent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\n\
         child = {{ body = \"rod\", {place} }}\n"
    )
}

#[test]
fn pendulum_on_a_sliding_support_keeps_its_centre_of_mass_in_line() {
    let (arm, inertia) = (0.1, (0.2 * 0.2 + 0.02 * 0.02) / 12.0);
    for is_rigid in [true, false] {
        let found =
            scenarios::system_frequencies(&scenarios::valid(Path::new("."), &pendulum(is_rigid), &[]));
        // Nothing pulls along x: it turns about its centre of mass.
        let wanted = (9.81_f64 * arm / inertia).sqrt() / TAU;
        println!("{found:?} {wanted}");
        assert!(found[0].abs() <= 0.0 && (found[1] / wanted - 1.0).abs() < 1e-6, "{found:?}, {wanted} Hz");
    }
    let run = scenarios::run(&scenarios::valid(
        Path::new("."),
        &pendulum(true),
        &["joints.slide.coordinates=[0.0,1.0]"],
    ));
    let start = 1.0_f64;
    let mut least = start;
    for sample in &run.samples {
        let joint = &sample.joints[0];
        let (x, angle, rate) = (joint.positions[0], joint.positions[1], joint.velocities[1]);
        least = least.min(angle);
        assert!((x + arm * (angle.sin() - start.sin())).abs() < 1e-7 * arm, "{x} {angle}");
        let square = 2.0 * 9.81 * arm * (angle.cos() - start.cos()) / (inertia + (arm * angle.sin()).powi(2));
        // Of the largest rate, what the integration leaves at its tolerance.
        let error = (rate * rate - square).abs() * inertia / (2.0 * 9.81 * arm * (1.0 - start.cos()));
        assert!(error < 1e-6, "{angle}: {rate}, {error:e}");
    }
    assert!(least < -0.9, "it swings: {least}");
}

#[test]
fn directions_that_bodies_do_not_have_are_no_freedom() {
    let of = |locked: &str, more: &str| {
        let text = pendulum(true).replace("locked = [\"y\"]", &format!("locked = {locked}{more}"));
        scenarios::parse(Path::new("."), &text, &[]).map_err(|all| all[0].message.clone())
    };
    assert!(of("[\"y\", \"z\", \"rx\"]", "").is_ok(), "the plane holds them, too");
    for (locked, wanted) in
        [("[]", "\"planar\""), ("[\"z\"]", "\"planar\""), ("[\"x\", \"y\", \"rz\"]", "\"fixed\"")]
    {
        let message = of(locked, "").map(|_| ()).expect_err("refused");
        assert!(message.contains(&format!("choose type {wanted}")), "{locked}: {message}");
    }
    let message = of("[\"y\"]", "\naxis = [0.0, 1.0, 0.0]").map(|_| ()).expect_err("refused");
    assert!(message.contains("must be along z for bodies that are plane"), "{message}");
    let round = pendulum(true).replace("planar", "axial").replace("thickness = 5e-3\n", "");
    let round =
        round.replace("shape = \"rectangle\", size = [2e-2, 0.2]", "shape = \"sphere\", radius = 0.1");
    let round =
        round.replace("locked = [\"y\"]", "locked = [\"x\", \"y\"]").replace("[0.0, 0.1]", "[0.0, 0.0]");
    let all = scenarios::faults(&round.replace("-9.81, 0.0]", "0.0, -9.81]"));
    assert!(all.contains("choose type \"axial\""), "{all}");
}
