//! Scenarios with nothing but geometry, material and motion: their impacts are those of a run with everything doubled.
//!
//! Everything: modes, elements and elements of contact zones are doubled, penalty factors ten times as high and permitted errors of
//! steps a tenth, as `fbimpact converge` varies them.
//! Solids are not among them: a ball of 1 cm on a plane has a zone of 25,000 degrees of freedom, the doubled one does not fit into 5 GB.

use std::path::Path;

use crate::support::impacts::assert_same;
use crate::support::scenarios::{run, valid};

const DOUBLED: &str = "resolution={modes=2,mesh=2,zone=2,penalty=10.0,tolerance=0.1}";

const STEEL: &str = r#"
[materials.steel]
youngs_modulus = 210e9
poissons_ratio = 0.3
density = 7850.0
"#;

/// A rigid plane under the body `ball`, with its contact.
fn floor(normal: &str) -> String {
    format!(
        r#"
        [bodies.floor]
        model = "rigid"
        geometry = {{ shape = "plane" }}
        normal = {normal}
        [contacts.impact]
        contact_body = "ball"
        target_body = "floor"
        "#
    )
}

/// The contact of `ball` and `beam`.
const PAIR: &str = r#"
[contacts.impact]
contact_body = "ball"
target_body = "beam"
"#;

/// Asserts that as many impacts as expected are simulated, and that they are those of the doubled run.
fn check(name: &str, text: &str, n_impacts: usize) {
    let text = format!("{STEEL}{text}");
    let found = run(&valid(Path::new(""), &text, &[]));
    assert_eq!(found.impacts.len(), n_impacts, "{name}");
    assert_same(name, &found, &run(&valid(Path::new(""), &text, &[DOUBLED])));
}

#[test]
fn ball_on_a_plane() {
    let ball = r#"
        [simulation]
        end_time = 1.5e-4
        [bodies.ball]
        model = "axisymmetric"
        material = "steel"
        geometry = { shape = "sphere", radius = 0.01 }
        position = [0.0, 0.0, 0.010001]
        velocity = [0.0, 0.0, -0.2]
    "#;
    check("ball on a plane", &format!("{ball}{}", floor("[0.0, 0.0, 1.0]")), 1);
}

#[test]
fn rod_with_a_round_end_on_a_plane() {
    let rod = r#"
        [simulation]
        end_time = 3e-4
        [bodies.ball]
        model = "axisymmetric"
        material = "steel"
        geometry = { shape = "rod-spherical-end", radius = 0.01, length = 0.3 }
        position = [0.0, 0.0, 1e-7]
        velocity = [0.0, 0.0, -0.3]
    "#;
    check("rod on a plane", &format!("{rod}{}", floor("[0.0, 0.0, 1.0]")), 1);
}

#[test]
fn ball_on_a_rod() {
    let bodies = r#"
        [simulation]
        end_time = 3e-4
        [bodies.ball]
        model = "axisymmetric"
        material = "steel"
        geometry = { shape = "sphere", radius = 0.01 }
        position = [0.0, 0.0, -0.0100001]
        velocity = [0.0, 0.0, 0.2]
        [bodies.beam]
        model = "axisymmetric"
        material = "steel"
        geometry = { shape = "rod", radius = 0.01, length = 0.5 }
    "#;
    check("ball on a rod", &format!("{bodies}{PAIR}"), 1);
}

#[test]
fn disc_on_a_plane() {
    let disc = r#"
        [simulation]
        end_time = 4e-4
        [bodies.ball]
        model = "plane-stress"
        thickness = 0.01
        material = "steel"
        geometry = { shape = "disc", radius = 0.02 }
        position = [0.0, 0.020001, 0.0]
        velocity = [0.0, -0.2, 0.0]
    "#;
    check("disc on a plane", &format!("{disc}{}", floor("[0.0, 1.0, 0.0]")), 1);
}

#[test]
#[ignore = "second tier: minutes"]
fn disc_on_a_beam() {
    let bodies = r#"
        [simulation]
        end_time = 5e-4
        [bodies.ball]
        model = "plane-stress"
        thickness = 0.01
        material = "steel"
        geometry = { shape = "disc", radius = 0.01 }
        position = [0.0, 0.015001, 0.0]
        velocity = [0.0, -0.2, 0.0]
        [bodies.beam]
        model = "plane-stress"
        thickness = 0.01
        material = "steel"
        geometry = { shape = "rectangle", size = [0.3, 0.01] }
    "#;
    check("disc on a beam", &format!("{bodies}{PAIR}"), 1);
}
