//! What `check` says of contacts: bodies that fly away from each other and never meet.

use adaptive::model::PlacedTouch;
use adaptive::prepared::Prepared;
use adaptive::spec::{ContactSpec, JointSpec, RunSpec};
use adaptive::touch::first::FirstTouches;
use ffr_dynamics::force::BodyState;
use ffr_dynamics::system::JointKind;
use nalgebra::Vector3;

use super::joints::place;
use crate::commands::prepare::digits::short;

/// A sentence on every contact whose bodies lie behind each other as they move: nothing acts on them that could turn
/// them back, and where they are nearest they move apart.
pub fn behind(run: &Prepared<'_>) -> Vec<String> {
    let spec = run.spec();
    let mut touched = vec![0_usize; spec.bodies.len()];
    spec.contacts.iter().flat_map(ContactSpec::bodies).for_each(|body| touched[body] += 1);
    let is_alone = |contact: &&ContactSpec| contact.bodies().all(|body| touched[body] == 1);
    spec.contacts.iter().filter(is_alone).filter_map(|contact| behind_in(&run.touches, contact)).collect()
}

fn behind_in(start: &FirstTouches<'_>, contact: &ContactSpec) -> Option<String> {
    let run = start.spec;
    let other = contact.target.body();
    let bodies: Vec<usize> = [Some(contact.body), other].into_iter().flatten().collect();
    if !bodies.iter().all(|body| moves_straight(run, &start.poses[*body], *body))
        || contact.initial_overlap > 0.0
    {
        return None;
    }
    let touch = PlacedTouch::new(start, contact)?;
    // Gravity pulls two free bodies alike.
    let motion = |body: Option<usize>| match body.filter(|body| !is_fixed(run, *body)) {
        Some(body) => (start.poses[body].velocity, run.settings.gravity),
        None => (Vector3::zeros(), Vector3::zeros()),
    };
    let ((own, fall), (of_target, fall_of_target)) = (motion(Some(contact.body)), motion(other));
    let speed = (own - of_target).dot(&touch.normal);
    let is_apart = speed > 0.0 && (fall - fall_of_target).dot(&touch.normal) >= 0.0;
    is_apart.then(|| {
        let size = touch.on_body.norm().max(touch.on_target.norm());
        format!(
            "contact \"{}\": its bodies never meet: they are nearest at {} m and {} m, {} m apart, and move away from each other there at {} m/s; \
             turn a velocity round, or see whether a joint has moved one of them",
            contact.name,
            place(&touch.on_body, size),
            place(&touch.on_target, size),
            short((touch.on_body - touch.on_target).norm()),
            short(speed)
        )
    })
}

/// Whether body `body` stands on ground, as far as it does not deform.
fn is_fixed(run: &RunSpec, body: usize) -> bool {
    let holds = |joint: &JointSpec| {
        joint.kind == JointKind::Fixed && joint.child.body == Some(body) && joint.parent.body.is_none()
    };
    run.joints.iter().any(holds)
}

/// Whether it does, or flies without a turn.
fn moves_straight(run: &RunSpec, pose: &BodyState, body: usize) -> bool {
    let of_body = |joint: &&JointSpec| [joint.parent.body, joint.child.body].contains(&Some(body));
    let joints = run.joints.iter().chain(&run.loops).filter(of_body).count();
    let has_load = run.loads.iter().any(|load| load.at.body == Some(body));
    let turns = pose.angular_velocity_in_body.norm() > 0.0;
    joints == usize::from(is_fixed(run, body)) && !has_load && !turns
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scenario;

    #[test]
    fn bodies_that_fly_apart_are_told_unless_something_turns_them_back() {
        let told = |speed: f64, more: &str| {
            let ball = "material = \"steel\"\ngeometry = { shape = \"sphere\", radius = 0.1 }";
            let text = format!(
                "simulation = {{ end_time = 1.0 }}\n[bodies.still]\nmodel = \"rigid\"\n{ball}\n[bodies.ball]\n{ball}\nposition = [0.0, 0.0, 0.3]\n\
                 velocity = [0.0, 0.0, {speed}]\n[contacts.hit]\ncontact_body = \"ball\"\ntarget_body = \"still\"\nmodel = \"quasistatic\"\n{more}"
            );
            let scenario = scenario::parse(Path::new("t.toml"), text.as_bytes(), &[]);
            let scenario = scenario.unwrap_or_else(|e| panic!("{e}"));
            behind(&Prepared::new(&scenario.run).expect("a start"))
        };
        let alone = told(2.0, "");
        assert!(
            alone.len() == 1 && alone[0].contains("0.1 m apart") && alone[0].contains("at 2 m/s"),
            "{alone:?}"
        );
        assert!(told(-2.0, "").is_empty());
        let wall = "[bodies.wall]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\nposition = [0.0, 0.0, 1.0]\nnormal = [0.0, 0.0, -1.0]\n\
                    [contacts.back]\ncontact_body = \"ball\"\ntarget_body = \"wall\"\nmodel = \"quasistatic\"\n";
        assert!(told(2.0, wall).is_empty());
        let held = "[joints.hold]\ntype = \"fixed\"\nparent = { body = \"ground\", point = [0.0, 0.0, 0.0] }\nchild = { body = \"still\", point = [0.0, 0.0, 0.0] }\n";
        assert_eq!(told(2.0, held).len(), 1);
    }
}
