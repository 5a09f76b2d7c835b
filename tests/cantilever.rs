//! A solid cantilever that is clamped on its face: the same frequencies with every mesh, number of modes and command, and its reaction.

#![expect(clippy::unwrap_used, reason = "a failure here fails the test")]

use std::path::Path;

use adaptive::recording::Recording;
use fbimpact::scenario::{self, Scenario};
use fbimpact::simulate::{modes, simulate, system_modes};

const BEAM: &str = r#"
[simulation]
end_time = 1e-6
gravity = [0.0, 0.0, -9.81]
static_start = true
[materials.aluminium]
youngs_modulus = 70.0e9
poissons_ratio = 0.33
density = 2700.0
[bodies.beam]
material = "aluminium"
geometry = { shape = "box", size = [0.3, 0.03, 0.01] }
frame = "tangent"
[joints.clamp]
type = "fixed"
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "beam", face = "x-" }
"#;

fn valid(set: &[&str]) -> Scenario {
    let set: Vec<_> = set.iter().map(|s| s.parse().unwrap()).collect();
    scenario::parse(Path::new("beam.toml"), BEAM.as_bytes(), &set).unwrap_or_else(|faults| panic!("{faults}"))
}

/// First frequency \[Hz\].
fn first(set: &[&str]) -> f64 {
    let (_, system) = system_modes(&valid(set), false, 1).unwrap();
    system.modes[0].squared_frequency.sqrt() / std::f64::consts::TAU
}

#[test]
fn first_frequency_is_that_of_the_beam_whatever_the_mesh_and_the_modes() {
    let default = first(&[]);
    // Euler and Bernoulli, (1.8751²/2π) √(EI/(ρA))/ℓ² = 91.39 Hz; shear and rotary inertia take some (h/ℓ)² = 1e-3 of it, the face that may
    // warp between its mean motions some h/ℓ times a tenth.
    assert!((default / 91.39 - 1.0).abs() < 5e-3, "{default}");
    let elements = |n: &str| format!("bodies.beam.discretisation={{degree=3,elements={n}}}");
    for set in
        [vec![elements("[20,3,2]")], vec![elements("[20,3,2]"), "bodies.beam.reduction.modes=40".to_owned()]]
    {
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        // Frequencies of meshes that the program chooses are right to 1e-3.
        assert!((first(&set) / default - 1.0).abs() < 1e-3, "{set:?}");
    }
    let rigid = first(&["joints.clamp.child.coupling=rigid"]);
    // A face that cannot warp holds better, by little.
    assert!(default < rigid && rigid < 1.02 * default, "{default} {rigid}");
}

#[test]
fn reaction_of_the_clamp_is_weight_and_its_moment() {
    let mut run = Recording::default();
    simulate(&valid(&[]), &mut run, 1).unwrap();
    let joint = &run.samples[0].joints[0];
    let weight = 2700.0 * 0.3 * 0.03 * 0.01 * 9.81;
    // On the beam: up, and about y against the weight at half the length. The mass is exact; the centre of mass sags by 1e-4 of the length.
    assert!((joint.reaction_force[2] / weight - 1.0).abs() < 1e-6, "{:?}", joint.reaction_force);
    assert!(
        (joint.reaction_moment[1].abs() / (0.15 * weight) - 1.0).abs() < 1e-6,
        "{:?}",
        joint.reaction_moment
    );
}

#[test]
fn chosen_sizes_are_those_of_every_command() {
    let free = ["joints.clamp.type=free", "simulation.static_start=false"];
    let body = modes(&valid(&free), None, 1).unwrap().bodies.swap_remove(0);
    let (_, system) = system_modes(&valid(&free), false, 1).unwrap();
    // As many coordinates as the body has, and six of its motion.
    assert_eq!(system.modes.len(), body.frequencies.len() + 6);
}
