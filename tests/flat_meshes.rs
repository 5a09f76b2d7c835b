//! Boxes of finite elements that fall on a flat face.

use crate::support::scenarios;
use std::fmt::Write as _;
use std::path::Path;

use fbimpact::scenario::Scenario;

/// Size \[m\] and elements of the box along each axis.
const SIZE: [f64; 3] = [0.02, 0.02, 0.01];
const ELEMENTS: [usize; 3] = [2, 2, 1];

/// A box about the origin in hexahedra with eight nodes, in metres, as an input file of Abaqus.
fn bricks() -> String {
    let mut text = "*NODE\n".to_owned();
    let counts = ELEMENTS.map(|n| n + 1);
    let number = |i: usize, j: usize, k: usize| 1 + i + counts[0] * (j + counts[1] * k);
    let all =
        |n: [usize; 3]| (0..n[0] * n[1] * n[2]).map(move |a| [a % n[0], a / n[0] % n[1], a / (n[0] * n[1])]);
    for at in all(counts) {
        let x: [f64; 3] = std::array::from_fn(|d| SIZE[d] * (at[d] as f64 / ELEMENTS[d] as f64 - 0.5));
        writeln!(text, "{}, {:e}, {:e}, {:e}", number(at[0], at[1], at[2]), x[0], x[1], x[2]).unwrap();
    }
    text += "*ELEMENT, TYPE=C3D8, ELSET=BOX\n";
    for (e, [i, j, k]) in all(ELEMENTS).enumerate() {
        let ring =
            |k: usize| [number(i, j, k), number(i + 1, j, k), number(i + 1, j + 1, k), number(i, j + 1, k)];
        let nodes: Vec<String> = ring(k).into_iter().chain(ring(k + 1)).map(|n| n.to_string()).collect();
        writeln!(text, "{}, {}", e + 1, nodes.join(", ")).unwrap();
    }
    text
}

/// The box 1 um above a floor, 1 m/s fast; `contact` are further keys of the contact.
fn scenario(folder: &Path, contact: &str) -> Scenario {
    std::fs::write(folder.join("box.inp"), bricks()).unwrap();
    let text = format!(
        r#"
        [simulation]
        end_time = 2e-5
        [bodies.a]
        model = "mesh"
        file = "box.inp"
        units = "m"
        material = "steel"
        position = [0.0, 0.0, 0.005001]
        velocity = [0.0, 0.0, -1.0]
        reduction = {{ modes = 20 }}
        [bodies.floor]
        model = "rigid"
        geometry = {{ shape = "plane" }}
        [contacts.c]
        contact_body = "a"
        target_body = "floor"
        {contact}
        "#
    );
    scenarios::valid(folder, &text, &[])
}

#[test]
fn the_default_contact_is_refused_with_a_remedy_that_works() {
    let folder = scenarios::folder("flat_meshes");
    let refusal = scenarios::refusal(&scenario(&folder, ""));
    assert!(
        refusal.contains("a mesh, touches with a flat face") && refusal.contains("quasistatic"),
        "{refusal}"
    );

    // Twice the diagonal of the face is 57 mm.
    let found = scenarios::run(&scenario(&folder, "model = \"quasistatic\"\ninterval = { width = 0.057 }"));
    let [impact] = &found.impacts[..] else { panic!("{} impacts", found.impacts.len()) };
    let mass = 7850.0 * SIZE.iter().product::<f64>();
    let velocity = |i: usize| found.samples[i].bodies[0].velocity[2];
    let gained = mass * (velocity(found.samples.len() - 1) - velocity(0));
    // Momentum by the plane's force alone; a body that turns back has more than the one that stays.
    assert!((impact.impulse / gained - 1.0).abs() < 1e-6, "{} {gained}", impact.impulse);
    assert!(gained > mass, "{gained} {mass}");
    assert!(found.energy_drift() < 1e-4, "{:e}", found.energy_drift());
}
