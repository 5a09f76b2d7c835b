//! Parts of steel that meet with flat faces and edges, as texts of a scenario, and what holds of all their runs.

use adaptive::run::recording::Recording;

pub use super::scenarios::run_text as run;

/// Radius \[m\], length \[m\], modulus \[Pa\] and density [kg/m³] of the rods.
pub const RADIUS: f64 = 1e-3;
pub const LENGTH: f64 = 0.2;
pub const YOUNG: f64 = 210e9;
pub const DENSITY: f64 = 7850.0;
/// Modes of a rod that is so thin that all of them are axial.
pub const MODES: usize = 60;

pub const STEEL: &str = r#"
    [materials.steel]
    youngs_modulus = 210e9
    poissons_ratio = 0.0
    density = 7850.0
"#;

/// A rod with its lower end at `z`.
pub fn rod(name: &str, z: f64, speed: f64) -> String {
    format!(
        r#"
        [bodies.{name}]
        model = "axisymmetric"
        material = "steel"
        geometry = {{ shape = "rod", radius = {RADIUS}, length = {LENGTH} }}
        position = [0.0, 0.0, {z:e}]
        velocity = [0.0, 0.0, {speed}]
        reduction = {{ modes = {MODES} }}
        discretisation = {{ degree = 3, elements = [1, 130] }}
    "#
    )
}

pub const FLOOR: &str = r#"
    [bodies.floor]
    model = "rigid"
    geometry = { shape = "plane" }
    normal = [0.0, 0.0, 1.0]
"#;

pub fn contact(body: &str, target: &str) -> String {
    format!("[contacts.c]\ncontact_body = \"{body}\"\ntarget_body = \"{target}\"\n")
}

/// The ledger is closed to what the integrator's tolerance of 1e-6 per step leaves, and no momentum appears.
pub fn check_ledger(name: &str, recording: &Recording) {
    let drift = recording.energy_drift();
    println!("{name}: ledger {drift:.1e}");
    assert!(drift < 1e-5, "{name}: {drift:e}");
}

/// Modes beyond the `n` axial ones would carry the share `2/(pi^2 n)` of the energy of a step of the velocity: half of it is the most that
/// can be missing in the velocity of separation.
pub fn most_lost(n: f64) -> f64 {
    1.0 / (std::f64::consts::PI.powi(2) * n)
}
