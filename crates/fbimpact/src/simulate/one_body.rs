//! A scenario with what the model of one body depends on, and nothing else to build.

use std::sync::Arc;

use adaptive::sizing::SizeRequest;
use adaptive::spec::{BodyKind, BodySpec, ContactSpec, DampingSpec, RigidSpec, RunSpec, Start};
use nalgebra::{Matrix3, Vector3};

use crate::scenario::Scenario;

/// `scenario` without the sizes that it leaves to the program for bodies that have nothing to do
/// with body `body` of the file.
pub fn asked(scenario: &Scenario, body: usize) -> Scenario {
    let involved = involved(&scenario.run, scenario.bodies[body].index);
    let mut asked = scenario.clone();
    for (wish, involved) in asked.wishes.iter_mut().zip(involved) {
        if !involved {
            *wish = SizeRequest::default();
        }
    }
    asked
}

/// `scenario` with body `body` of the file, its contacts and the bodies that take part in them. All
/// others are rigid, of unit mass: of them the body sees where joints hold it, not what they weigh.
/// Nothing is recorded.
pub fn alone(scenario: &Scenario, body: usize) -> Scenario {
    let index = scenario.bodies[body].index;
    let involved = involved(&scenario.run, index);
    let mut alone = scenario.clone();
    let run = &mut alone.run;
    let kept: Vec<bool> = run.contacts.iter().map(|contact| is_of(contact, &scenario.run, index)).collect();
    let mut flags = kept.iter();
    run.contacts.retain(|_| flags.next() == Some(&true));
    let mut flags = kept.iter();
    run.resolution.contacts.retain(|_| flags.next() == Some(&true));
    for (body, involved) in run.bodies.iter_mut().zip(involved) {
        if !involved {
            make_rigid(body);
        }
        // Damping of one body depends on the modes of all.
        if let Some(flexible) = body.kind.flexible_mut() {
            flexible.damping = DampingSpec::None;
        }
    }
    run.points.clear();
    run.stress.clear();
    run.settings.start = Start::Given;
    alone
}

/// Which bodies the model of body `body` of the run depends on: itself, and those that it touches.
fn involved(run: &RunSpec, body: Option<usize>) -> Vec<bool> {
    let mut involved: Vec<bool> = (0..run.bodies.len()).map(|i| Some(i) == body).collect();
    for contact in run.contacts.iter().filter(|contact| is_of(contact, run, body)) {
        contact.bodies().for_each(|body| involved[body] = true);
    }
    involved
}

/// Whether `contact` matters to body `body` of the run: what a rigid one meets changes nothing of
/// it.
fn is_of(contact: &ContactSpec, run: &RunSpec, body: Option<usize>) -> bool {
    body.is_some_and(|body| !run.bodies[body].kind.is_rigid() && contact.acts_on(body))
}

/// A rigid body of unit mass in the place of `body`; one from a file stays, for joints take hold of
/// its markers.
fn make_rigid(body: &mut BodySpec) {
    if !body.kind.has_elements() {
        return;
    }
    let shape = body.kind.geometry().map(|of| (Arc::clone(of.shape), *of.model));
    let (motion, mass) = (body.kind.motion(), 1.0);
    let (centre_of_mass, inertia) = (Vector3::zeros(), Matrix3::identity());
    body.kind = BodyKind::Rigid(RigidSpec { motion, mass, centre_of_mass, inertia, density: None, shape });
}
