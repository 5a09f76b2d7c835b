//! From checked tables to the specification of the run: what one key alone cannot tell, such as
//! names that refer to others.

mod accuracy;
mod places;
mod curves;
mod built_bodies;
mod joints;
mod gears;
mod bodies;
mod loads;
mod contacts;
mod output;
mod resolution;
mod settings;

use std::collections::HashMap;

use adaptive::spec::{Area, Coupling, JointSpec, LoadSpec, Place, Resolution, RunSpec};
use ffr_dynamics::body::RigidMotion;

use super::check::Checker;
use super::section::Section;
use super::types::{Scenario, Source};
use built_bodies::BuiltBodies;
use joints::BuiltJoint;

pub use accuracy::peak_tolerance;
pub use contacts::facts::ContactFacts;
pub use joints::inboard_joint;

/// Builds the scenario; `None` if there are faults.
pub fn scenario(checker: &mut Checker, root: &Section, source: Source) -> Option<Scenario> {
    let names = || root.named("bodies").iter().map(|(name, _)| name.as_str());
    let n_before = checker.faults.len();
    let mut bodies = bodies::bodies(root);
    let n_of_bodies = checker.faults.len() - n_before;
    let joints = joints::joints(root, &bodies);
    // Of faults in one line those of joints come first.
    checker.faults.move_back(n_before, n_of_bodies);
    let loads = loads::loads(root, &bodies);
    let accuracy = accuracy::accuracy(root);
    let contacts = contacts::contacts(root, &bodies);
    let (simulation, output) = (root.table("simulation"), root.table("output"));
    let end_time = simulation.and_then(|section| section.number("end_time"));
    let requests = output.and_then(|section| output::output(root, section, &bodies, end_time));
    if root.named("bodies").is_empty() && root.given("bodies") {
        root.fault("bodies", "at least one body is needed");
    }
    let (loads, contacts) = (loads?, contacts?);
    if !bodies.is_complete() {
        return None;
    }
    check_gravity(simulation?, bodies.motions(names()));
    let contact_names: Vec<&str> = contacts.iter().map(|c| c.name.as_str()).collect();
    let (of_file, tolerance_factor) =
        resolution::resolution(root, &names().collect::<Vec<_>>(), &contact_names)?;
    let mut settings = settings::settings(simulation?, output?, accuracy)?;
    settings.tighten(tolerance_factor);
    let bands = root.table("uncertainty")?;
    (settings.uncertainty, settings.accuracy) = (bands.boolean("enabled")?, bands.number("accuracy"));
    if settings.accuracy.is_some() && !settings.uncertainty {
        bands.fault("accuracy", "has no meaning with enabled = false, for it is judged by bands");
    }
    let (title, requests) = (root.text("title")?.to_owned(), requests?);
    let joints = joints.into_iter().map(specified).collect::<Option<Vec<_>>>()?;
    take_from_joints(&mut bodies, &joints, &loads);
    let (bodies, wishes, file_bodies) = bodies.split(names());
    let moving = file_bodies.iter().zip(of_file.bodies).filter(|(body, _)| body.index.is_some());
    let resolution =
        Resolution { bodies: moving.map(|(_, factors)| factors).collect(), contacts: of_file.contacts };
    let (loops, tree): (Vec<_>, Vec<_>) = joints.into_iter().partition(|(_, closes_loop)| *closes_loop);
    let specs =
        |joints: Vec<(JointSpec, bool)>| joints.into_iter().map(|(joint, _)| joint).collect::<Vec<_>>();
    let joints = specs(tree);
    let gears = gears::gears(root, &joints);
    let run = RunSpec {
        bodies,
        joints,
        loops: specs(loops),
        gears,
        loads,
        contacts,
        points: requests.points,
        stress: requests.stress,
        settings,
        resolution,
        accuracy,
        frequency_errors: Vec::new(),
    };
    let (compression, arrays) = (requests.compression, requests.arrays);
    let of_bodies = file_bodies.iter().filter_map(|body| {
        Some((body.file.as_ref()?.path.clone(), format!("the file of body \"{}\"", body.name)))
    });
    let files = of_bodies.chain(std::mem::take(&mut checker.files)).collect();
    let scenario = Scenario {
        title,
        run,
        wishes,
        bodies: file_bodies,
        tolerance_factor,
        compression,
        arrays,
        doubts: Vec::new(),
        source,
        files,
    };
    checker.faults.is_empty().then_some(scenario)
}

/// A joint of the run, and whether it closes a loop.
fn specified(joint: BuiltJoint<'_>) -> Option<(JointSpec, bool)> {
    Some((joint.spec?, joint.link.closes_loop))
}

/// Lets frames follow the joints whose children their bodies are, and bodies be rigid where joints
/// and loads make them so.
fn take_from_joints(bodies: &mut BuiltBodies, joints: &[(JointSpec, bool)], loads: &[LoadSpec]) {
    let mut children: HashMap<usize, &Place> = HashMap::new();
    let mut held: HashMap<usize, Vec<&Place>> = HashMap::new();
    for (joint, _) in joints.iter().filter(|(_, closes_loop)| !closes_loop) {
        if let Some(body) = joint.child.body {
            children.entry(body).or_insert(&joint.child.place);
        }
    }
    let sides = joints.iter().flat_map(|(joint, _)| [&joint.parent, &joint.child]);
    for at in sides.chain(loads.iter().map(|load| &load.at)) {
        if let Some(body) = at.body {
            held.entry(body).or_default().push(&at.place);
        }
    }
    for (index, moving) in bodies.moving_mut().enumerate() {
        if let Some(place) = children.get(&index) {
            moving.follow(place);
        }
        let held = || held.get(&index).into_iter().flatten().copied();
        if let Some(flexible) = moving.spec.kind.flexible_mut() {
            flexible.rigid_areas = rigid_areas(held());
        }
    }
}

/// Parts that move like rigid bodies, each one once.
fn rigid_areas<'a>(places: impl Iterator<Item = &'a Place>) -> Vec<Area> {
    let mut areas = Vec::new();
    for place in places {
        match place {
            Place::Area(area) if area.coupling == Coupling::Rigid && !areas.contains(area) => {
                areas.push(area.clone());
            }
            _ => {}
        }
    }
    areas
}

/// Reports gravity that leads a body out of the space in which it moves.
fn check_gravity<'a>(simulation: &Section, motions: impl Iterator<Item = (&'a str, Option<RigidMotion>)>) {
    let Some(gravity) = simulation.vector::<3>("gravity") else { return };
    for (name, motion) in motions {
        if let Some(message) = bodies::leaves_model(motion, "gravity", &gravity) {
            simulation.fault("gravity", format!("{message}, which is the model of body \"{name}\""));
            return;
        }
    }
}
