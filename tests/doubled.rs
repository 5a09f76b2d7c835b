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

/// How bodies of revolution and plane ones are described, and the way along which they move.
type Kind = (&'static str, fn(f64) -> [f64; 3]);
const ROUND: Kind = ("model = \"axisymmetric\"", |z| [0.0, 0.0, z]);
const PLANE: Kind = ("model = \"plane-stress\"\nthickness = 0.01", |y| [0.0, y, 0.0]);

/// A body of steel at a place of its way \[m\] with a speed [m/s].
fn body(name: &str, (model, way): Kind, geometry: &str, place: f64, speed: f64) -> String {
    let (place, speed) = (way(place), way(speed));
    format!(
        "[bodies.{name}]\n{model}\nmaterial = \"steel\"\ngeometry = {{ {geometry} }}\nposition = {place:?}\nvelocity = {speed:?}\n"
    )
}

/// Asserts that one impact is simulated until `end_time`, and that it is that of the doubled run.
fn check(name: &str, end_time: f64, parts: &[String]) {
    let text = format!("[simulation]\nend_time = {end_time:?}\n{STEEL}{}", parts.concat());
    let found = run(&valid(Path::new(""), &text, &[]));
    assert_eq!(found.impacts.len(), 1, "{name}");
    assert_same(name, &found, &run(&valid(Path::new(""), &text, &[DOUBLED])));
}

#[test]
fn ball_on_a_plane() {
    let ball = body("ball", ROUND, r#"shape = "sphere", radius = 0.01"#, 0.010001, -0.2);
    check("ball on a plane", 1.5e-4, &[ball, floor("[0.0, 0.0, 1.0]")]);
}

#[test]
fn rod_with_a_round_end_on_a_plane() {
    let rod = body("ball", ROUND, r#"shape = "rod-spherical-end", radius = 0.01, length = 0.3"#, 1e-7, -0.3);
    check("rod on a plane", 3e-4, &[rod, floor("[0.0, 0.0, 1.0]")]);
}

#[test]
fn ball_on_a_rod() {
    let ball = body("ball", ROUND, r#"shape = "sphere", radius = 0.01"#, -0.0100001, 0.2);
    let rod = body("beam", ROUND, r#"shape = "rod", radius = 0.01, length = 0.5"#, 0.0, 0.0);
    check("ball on a rod", 3e-4, &[ball, rod, PAIR.to_owned()]);
}

#[test]
fn disc_on_a_plane() {
    let disc = body("ball", PLANE, r#"shape = "disc", radius = 0.02"#, 0.020001, -0.2);
    check("disc on a plane", 4e-4, &[disc, floor("[0.0, 1.0, 0.0]")]);
}

#[test]
#[ignore = "second tier: minutes"]
fn disc_on_a_beam() {
    let disc = body("ball", PLANE, r#"shape = "disc", radius = 0.01"#, 0.015001, -0.2);
    let beam = body("beam", PLANE, r#"shape = "rectangle", size = [0.3, 0.01]"#, 0.0, 0.0);
    check("disc on a beam", 5e-4, &[disc, beam, PAIR.to_owned()]);
}
