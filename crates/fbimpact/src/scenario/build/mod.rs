//! From checked tables to the validated scenario: what one key alone cannot tell, such as names that refer to others.

mod bodies;
mod contacts;
mod geometry;
mod output;

use std::path::Path;

use super::check::Checker;
use super::model::{Body, Integration, Integrator, Place, Scenario, Simulation, Source};
use super::section::{Checked, Section};
use super::tables::ShapeFacts;

/// Builds the scenario; `None` if there are faults.
pub fn scenario(checker: &mut Checker, root: &Section, directory: &Path, source: Source) -> Option<Scenario> {
    let simulation = root.table("simulation").and_then(simulation);
    let bodies = bodies::bodies(checker, root, directory);
    let contacts = contacts::contacts(checker, root);
    let end_time = simulation.as_ref().map(|s| s.end_time);
    let output = root.table("output").and_then(|section| output::output(checker, root, section, end_time));
    if root.named("bodies").is_empty() && root.given("bodies") {
        checker.fault_in(root, "bodies", "at least one body is needed".into());
    }
    let (simulation, bodies, contacts) = (simulation?, bodies?, contacts?);
    check_gravity(checker, root, &simulation, &bodies);
    let title = root.text("title")?.to_owned();
    let scenario = Scenario { title, simulation, bodies, contacts, output: output?, source };
    checker.faults.is_empty().then_some(scenario)
}

fn simulation(section: &Section) -> Option<Simulation> {
    Some(Simulation {
        end_time: section.number("end_time")?,
        gravity: section.vector("gravity")?,
        quiet_time: section.number("quiet_time"),
        free: integration(section.table("free")?)?,
        impact: integration(section.table("impact")?)?,
    })
}

fn integration(section: &Section) -> Option<Integration> {
    section.text("integrator")?;
    Some(Integration {
        integrator: Integrator::DormandPrince,
        max_step: section.number("max_step"),
        rtol: section.number("rtol")?,
        velocity_floor: section.number("velocity_floor")?,
    })
}

fn check_gravity(checker: &mut Checker, root: &Section, simulation: &Simulation, bodies: &[Body]) {
    let Some(section) = root.table("simulation") else { return };
    for body in bodies {
        if let Some(message) = bodies::leaves_model(body, "gravity", &simulation.gravity) {
            let message = format!("{message}, which is the model of body \"{}\"", body.name);
            checker.fault_in(section, "gravity", message);
            return;
        }
    }
}

/// Model and shape of body `name`, as far as they are known.
fn model_and_shape<'a>(root: &'a Section, name: &str) -> Option<(&'a str, &'a str)> {
    let (_, body) = root.named("bodies").iter().find(|(n, _)| n == name)?;
    Some((body.text("model")?, body.table("geometry")?.text("shape")?))
}

/// Index of the body that key `key` of `section` names; an unknown one is a fault.
fn body_index(checker: &mut Checker, root: &Section, section: &Section, key: &str) -> Option<usize> {
    let known: Vec<&str> = root.named("bodies").iter().map(|(n, _)| n.as_str()).collect();
    let name = section.text(key)?;
    let index = known.iter().position(|n| *n == name);
    if index.is_none() {
        checker.unknown_name(section, key, "body", &known);
    }
    index
}

/// The place that exactly one of the keys `marker` and `point` gives.
fn marker_or_point(checker: &mut Checker, section: &Section, model: &str, shape: &str) -> Option<Place> {
    match (section.item("marker"), section.item("point")) {
        (Some(_), Some(_)) => {
            checker.fault_in(
                section,
                "point",
                "either \"marker\" or \"point\" can be given, not both".into(),
            );
            None
        }
        (None, None) => {
            let message = "required key is missing: either \"marker\" or \"point\"".into();
            checker.fault(&section.origin, section.path_of("marker"), None, message);
            None
        }
        (Some(_), None) => place(checker, section, "marker", model, shape),
        (None, Some(_)) => place(checker, section, "point", model, shape),
    }
}

/// The marker or point of key `key` on a body of the given model and shape.
fn place(checker: &mut Checker, section: &Section, key: &str, model: &str, shape: &str) -> Option<Place> {
    match &section.item(key)?.value {
        Checked::Text(name) => {
            let markers = ShapeFacts::find(shape).and_then(|s| s.markers(model));
            if let Some(known) = markers
                && !known.contains(&name.as_str())
            {
                checker.unknown_name(section, key, &format!("marker of shape \"{shape}\""), known);
                return None;
            }
            Some(Place::Marker(name.clone()))
        }
        Checked::Numbers(x) => {
            let dimension = dimension(model);
            if x.len() != dimension {
                let message = format!("a point of a body with model \"{model}\" has {dimension} coordinates");
                checker.fault_in(section, key, message);
                return None;
            }
            Some(Place::Point(padded(x)))
        }
        _ => None,
    }
}

/// Number of coordinates and parametric directions of a model.
fn dimension(model: &str) -> usize {
    if matches!(model, "solid" | "rigid") { 3 } else { 2 }
}

/// A point with two or three coordinates as one with three.
fn padded(x: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| x.get(i).copied().unwrap_or(0.0))
}
