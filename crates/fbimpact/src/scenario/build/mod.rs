//! From checked tables to the validated scenario: what one key alone cannot tell, such as names that refer to others.

mod places;
mod curves;
mod joints;
mod geometry;
mod discretisation;
mod rigid;
mod imported;
mod bodies;
mod body_parts;
mod loads;
mod contact_facts;
mod contacts;
mod contact_checks;
mod output;
mod resolution;

use std::path::Path;

use super::check::Checker;
use super::model::{Body, Integration, Integrator, Scenario, Simulation, Source};
use super::section::Section;

pub use contact_facts::ContactFacts;
pub use joints::hanging_joint;

/// Default tolerance of the explicit method, at which its energy drift cannot be seen.
const DORMAND_PRINCE_TOLERANCE: f64 = 1e-8;
/// Default tolerance of the implicit method: a method of order 2 needs many steps for less.
const IMPLICIT_TOLERANCE: f64 = 1e-5;

/// Builds the scenario; `None` if there are faults.
pub fn scenario(checker: &mut Checker, root: &Section, directory: &Path, source: Source) -> Option<Scenario> {
    let simulation = root.table("simulation").and_then(simulation);
    let (joints, has_all_joints) = joints::joints(checker, root);
    let bodies = bodies::bodies(checker, body_parts::Context { root, joints: &joints, directory });
    let loads = loads::loads(checker, root);
    let contacts = contacts::contacts(checker, root);
    let end_time = simulation.as_ref().map(|s| s.end_time);
    let output = root.table("output").and_then(|section| output::output(checker, root, section, end_time));
    if root.named("bodies").is_empty() && root.given("bodies") {
        checker.fault_in(root, "bodies", "at least one body is needed".into());
    }
    let (simulation, bodies, loads, contacts) = (simulation?, bodies?, loads?, contacts?);
    check_gravity(checker, root, &simulation, &bodies);
    let resolution = resolution::resolution(checker, root, &bodies, &contacts)?;
    let title = root.text("title")?.to_owned();
    let scenario =
        Scenario { title, simulation, bodies, joints, loads, contacts, resolution, output: output?, source };
    (has_all_joints && checker.faults.is_empty()).then_some(scenario)
}

fn simulation(section: &Section) -> Option<Simulation> {
    Some(Simulation {
        end_time: section.number("end_time")?,
        gravity: section.vector("gravity")?,
        static_start: section.boolean("static_start")?,
        quiet_time: section.number("quiet_time"),
        energy_tolerance: section.number("energy_tolerance")?,
        free: integration(section.table("free")?)?,
        impact: integration(section.table("impact")?)?,
    })
}

fn integration(section: &Section) -> Option<Integration> {
    let (integrator, rtol) = match section.text("integrator")? {
        "tr-bdf2" => (Integrator::TrBdf2, IMPLICIT_TOLERANCE),
        "esdirk4" => (Integrator::Esdirk4, IMPLICIT_TOLERANCE),
        _ => (Integrator::DormandPrince, DORMAND_PRINCE_TOLERANCE),
    };
    Some(Integration {
        integrator,
        max_step: section.number("max_step"),
        rtol: if section.item("rtol").is_some() { section.number("rtol")? } else { rtol },
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
