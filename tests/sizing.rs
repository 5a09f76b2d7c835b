//! Scenarios that say nothing of mesh and modes: impacts as with the shipped sizes and as with everything doubled, and what a user
//! is told of the choice.

use crate::support::scenarios;
use std::path::Path;

use crate::support::impacts::assert_same;
use crate::support::scenarios::run;
use adaptive::run::recording::Recording;
use adaptive::sizing::mode_count::MOST_OF_JUMPS;
use adaptive::spec::{BodyKind, ReductionSpec, RunSpec};
use adaptive::store::ModelCache;
use fbimpact::scenario::Scenario;
use fbimpact::simulate::sizing::sized;
use fbimpact::simulate::{modes, simulate};
use result_files::stored::chosen_sizes::notes;

fn parse(text: &str) -> Scenario {
    scenarios::valid(Path::new("scenarios"), text, &[])
}

/// `text` without the keys and tables `discretisation` and `reduction`.
fn without_sizes(text: &str) -> String {
    let mut is_left_out = false;
    let keeps = |line: &&str| {
        let line = line.trim_start();
        if line.starts_with('[') {
            is_left_out = line.contains(".discretisation") || line.contains(".reduction");
        }
        !is_left_out && !line.starts_with("discretisation =") && !line.starts_with("reduction =")
    };
    text.lines().filter(keeps).collect::<Vec<_>>().join("\n")
}

/// Twice the elements, modes and elements of zones that `scenario` has.
fn doubled(scenario: &Scenario) -> Scenario {
    let mut scenario = scenario.clone();
    assert!(scenario.wishes.iter().all(|wish| !wish.elements && !wish.modes), "sized");
    for body in &mut scenario.run.bodies {
        let BodyKind::Elastic(elastic) = &mut body.kind else { continue };
        let mesh = &mut elastic.discretisation;
        mesh.elements.iter_mut().for_each(|n| *n *= 2);
        mesh.refine.iter_mut().for_each(|zone| zone.elements *= 2);
        if let ReductionSpec::CraigBampton { modes, .. } = &mut elastic.flexible.reduction {
            *modes *= 2;
        }
    }
    scenario
}

fn check(text: &str) {
    let free = parse(&without_sizes(text));
    let chosen = sized(&free, 1, &ModelCache::default()).unwrap().into_owned();
    notes(&chosen.source.resolved).iter().for_each(|n| println!("{}: {}", n.body, n.text));
    assert_eq!(parse(&chosen.source.resolved).bodies, chosen.bodies, "the result holds what was run");
    let found = run(&chosen);
    assert_same("as shipped", &found, &run(&parse(text)));
    assert_same("doubled", &found, &run(&doubled(&chosen)));
}

#[test]
fn impacts_of_sphere_rod_sphere_need_no_sizes() {
    check(include_str!("../scenarios/sphere_rod_sphere.toml"));
}

#[test]
fn the_impact_of_the_rod_needs_no_sizes() {
    check(include_str!("../scenarios/rod_on_plane.toml"));
}

/// A ball of 10 mm on one of 1 m, axisymmetric, of steel.
const MASSIVE: &str = r#"
    simulation = { end_time = 1.64e-4 }
    [materials.steel]
    youngs_modulus = 210e9
    poissons_ratio = 0.3
    density = 7850.0
    [bodies.ball]
    model = "axisymmetric"
    material = "steel"
    geometry = { shape = "sphere", radius = 0.01 }
    position = [0.0, 0.0, 0.01]
    velocity = [0.0, 0.0, -0.05]
    [bodies.anvil]
    model = "axisymmetric"
    material = "steel"
    geometry = { shape = "sphere", radius = 1.0 }
    position = [0.0, 0.0, -1.0]
    [contacts.impact]
    contact_body = "ball"
    target_body = "anvil"
"#;

#[test]
fn a_body_that_is_massive_beside_the_impact_has_few_modes() {
    let chosen = sized(&parse(MASSIVE), 1, &ModelCache::default()).unwrap().into_owned();
    let modes = |i: usize| chosen.run.bodies[i].elastic().and_then(|e| e.flexible.reduction.modes());
    // Hundreds of its modes lie below what the force contains; waves take next to nothing of the energy (N.11).
    assert!(modes(1).is_some_and(|n| n <= 20), "{:?}", modes(1));
    let more = parse(&format!("{MASSIVE}\n[bodies.anvil.reduction]\nmodes = 100"));
    assert_same("with 100 modes", &run(&chosen), &run(&more));
}

/// A thin disc under a thick one: waves run from the line of touch before the force has risen.
const DISCS: &str = r#"
    simulation = { end_time = 1.5e-5 }
    [materials.dense]
    youngs_modulus = 28e9
    poissons_ratio = 0.43
    density = 18e3
    [bodies.upper]
    model = "plane-stress"
    thickness = 1.0
    material = "dense"
    geometry = { shape = "disc", radius = 1.0e-3 }
    position = [0.0, 1.00001e-3, 0.0]
    velocity = [0.0, -0.2, 0.0]
    [bodies.lower]
    model = "plane-stress"
    thickness = 0.01
    material = "dense"
    geometry = { shape = "disc", radius = 1.2e-3 }
    position = [0.0, -1.2e-3, 0.0]
    [contacts.line]
    contact_body = "upper"
    target_body = "lower"
"#;

#[test]
fn a_force_that_waves_hold_along_a_line_has_as_many_modes_as_between_faces() {
    let chosen = sized(&parse(DISCS), 1, &ModelCache::default()).unwrap().into_owned();
    for body in &chosen.run.bodies {
        let modes = body.elastic().and_then(|e| e.flexible.reduction.modes());
        // Frequencies up to that of the rise have more than 300.
        assert!(modes.is_some_and(|n| n <= MOST_OF_JUMPS), "{modes:?}");
    }
    assert_same("twice", &run(&chosen), &run(&doubled(&chosen)));
}

/// A cylinder on its side.
const ROLLER: &str = r#"
    simulation = { end_time = 1e-4 }
    [bodies.roller]
    material = "steel"
    geometry = { shape = "cylinder", radius = 10e-3, length = 30e-3 }
    position = [0.0, 15.0e-3, 10.001e-3]
    orientation_deg = [90.0, 0.0, 0.0]
    velocity = [0.0, 0.0, -0.1]
    [bodies.floor]
    model = "rigid"
    geometry = { shape = "plane" }
    [contacts.line]
    contact_body = "roller"
    target_body = "floor"
"#;

#[test]
fn a_solid_along_a_line_has_the_modes_that_its_waves_carry() {
    let chosen = sized(&parse(ROLLER), 1, &ModelCache::default()).unwrap().into_owned();
    let modes = chosen.run.bodies[0].elastic().and_then(|e| e.flexible.reduction.modes());
    // Three times as many carry the spectrum of the force alone (N.9); half of those is between.
    assert!(modes.is_some_and(|n| n < 60), "{modes:?}");
}

const BAR: &str = r#"
    simulation = { end_time = 1e-6 }
    [materials.steel]
    youngs_modulus = 210e9
    poissons_ratio = 0.3
    density = 7850.0
    [bodies.bar]
    model = "plane-stress"
    thickness = 0.01
    material = "steel"
    geometry = { shape = "rectangle", size = [1.0, 0.01] }
"#;

#[test]
fn chosen_sizes_are_written_into_the_scenario_with_their_reason() {
    let bare = parse(BAR);
    let chosen = sized(&bare, 1, &ModelCache::default()).unwrap().into_owned();
    assert!(bare.wishes[0].elements && bare.wishes[0].modes);
    let bar = chosen.run.bodies[0].elastic().expect("flexible");
    let elements = &bar.discretisation.elements;
    assert!(elements[0] > 5 * elements[1], "{elements:?}");
    assert_eq!(
        bar.flexible.reduction,
        ReductionSpec::CraigBampton { modes: 20, fixed_interface_modes: None }
    );
    assert!(bar.flexible.static_answers);
    // The resolved text reads back to the same sizes, and tells why.
    let again = parse(&chosen.source.resolved);
    assert!(
        chosen.run.frequency_errors[0].is_some_and(|error| error < 1e-3),
        "{:?}",
        chosen.run.frequency_errors
    );
    let without_errors = RunSpec { frequency_errors: Vec::new(), ..chosen.run.clone() };
    assert_eq!((&again.run, &again.wishes), (&without_errors, &chosen.wishes));
    let told: Vec<String> = notes(&chosen.source.resolved).into_iter().map(|n| n.text).collect();
    assert!(told[0].contains("20 lowest frequencies are right to"), "{told:?}");
    assert!(told[1].ends_with("no contact acts on the body"), "{told:?}");
    let timings = simulate(&bare, &mut Recording::default(), 1).unwrap().timings;
    assert!(timings.sizes > timings.integration, "{timings:?}");
    let report = modes(&bare, None, 1).unwrap();
    assert_eq!(report.bodies[0].chosen, told);
    assert_eq!(report.bodies[0].frequencies.len(), 20);
    // Nothing is left to choose.
    assert!(matches!(sized(&again, 1, &ModelCache::default()).unwrap(), std::borrow::Cow::Borrowed(_)));
}

#[test]
fn keys_that_are_given_are_obeyed() {
    let with = |keys: &str| {
        let chosen =
            sized(&parse(&format!("{BAR}\n{keys}")), 1, &ModelCache::default()).unwrap().into_owned();
        let bar = chosen.run.bodies[0].elastic().expect("flexible");
        (bar.discretisation.clone(), bar.flexible.reduction)
    };
    let (mesh, reduction) = with("discretisation = { elements = [12, 1] }");
    assert_eq!((mesh.elements, reduction.modes()), (vec![12, 1], Some(20)));
    let (mesh, reduction) = with("reduction = { modes = 3 }");
    assert_eq!(reduction.modes(), Some(3));
    let (many, _) = with("reduction = { modes = 40 }");
    assert!(many.elements[0] > mesh.elements[0]);
    let (mesh, _) = with("discretisation = { degree = 2 }");
    let (cubic, _) = with("");
    assert_eq!(mesh.degrees, [2, 2]);
    assert!(mesh.elements[0] > cubic.elements[0], "lower degrees need more elements");
    let knots = "discretisation = { knots = [[0.5], []] }";
    let (mesh, _) = with(knots);
    assert_eq!(mesh.knots, Some(vec![vec![0.5], vec![]]));
    assert!(!parse(&format!("{BAR}\n{knots}")).wishes[0].elements);
    let all = "reduction = { method = \"all\" }";
    let (mesh, reduction) = with(all);
    assert_eq!(mesh.elements, cubic.elements);
    assert_eq!(reduction, ReductionSpec::All);
    assert!(!parse(&format!("{BAR}\n{all}")).wishes[0].modes);
}

/// Of a level finer than another meshes and modes are no coarser, and the middle one is that of a scenario without the key.
#[test]
fn accuracy_scales_mesh_and_modes() {
    let text = without_sizes(include_str!("../scenarios/rod_on_plane.toml"));
    let sizes = |line: &str| {
        let scenario = parse(&format!("{line}\n{text}"));
        let chosen = sized(&scenario, 1, &ModelCache::default()).unwrap().into_owned();
        let BodyKind::Elastic(rod) = &chosen.run.bodies[0].kind else { panic!("a rod") };
        let ReductionSpec::CraigBampton { modes, .. } = rod.flexible.reduction else { panic!("modes") };
        let zone = rod.discretisation.refine.iter().map(|zone| zone.elements).collect::<Vec<_>>();
        (modes, rod.discretisation.elements.clone(), zone)
    };
    let usual = sizes("");
    let [fast, normal, fine] =
        ["fast", "normal", "fine"].map(|level| sizes(&format!("accuracy = \"{level}\"")));
    assert_eq!(normal, usual);
    println!("{fast:?}, {normal:?}, {fine:?}");
    assert!(fast.0 < normal.0 && normal.0 < fine.0);
    assert!(fast.1.iter().zip(&fine.1).all(|(a, b)| a <= b) && fast.1 != fine.1);
}
