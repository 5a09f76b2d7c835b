//! What `check` says of joints: where they are in space, and where their sides are apart or turned.

use std::path::Path;

use adaptive::model::{Arrangement, PlacedJoint, coordinate_names};
use adaptive::spec::{Attachment, Coupling, GearSpec, JointSpec, Place, RunSpec};
use ffr_dynamics::system::JointKind;
use nalgebra::Vector3;

use crate::commands::prepare::digits::short;
use crate::scenario::Scenario;

/// Lengths below this part of the scene count as none: round-off of places, and what loops may be
/// open by.
const CLOSED: f64 = 1e-9;

/// Logs a line for each joint of `scenario` in the file `path`; what cannot be placed is an error
/// of the checks that follow.
pub fn report(path: &Path, scenario: &Scenario) {
    let path = path.display();
    let run = &scenario.run;
    if run.joints.is_empty() && run.loops.is_empty() {
        return;
    }
    for gear in &run.gears {
        tracing::info!("{path}: {}", gear_line(gear, &run.joints));
    }
    let Ok(given) = Arrangement::as_given(run) else { return };
    let closed = Arrangement::new(run);
    let shown = closed.as_ref().unwrap_or(&given);
    let size = extent(shown);
    for (joint, before) in shown.joints.iter().zip(&given.joints) {
        tracing::info!("{path}: {}", line(joint, size, |body| &run.bodies[body].name));
        for told in [moved(run, shown, joint, size), averaged(run, joint)].into_iter().flatten() {
            tracing::info!("{path}: {told}");
        }
        if !joint.closes_loop {
            continue;
        }
        if let Some(open) = opening(before, size) {
            match &closed {
                Ok(_) => tracing::info!(
                    "{path}: joint \"{}\" closes a loop: with the coordinates given its sides are {open}; the bodies are moved until they meet",
                    joint.name
                ),
                Err(_) => tracing::warn!(
                    "{path}: joint \"{}\" closes a loop: with the coordinates given its sides are {open}, the parent's at {}, the child's at {}",
                    joint.name,
                    place(&before.parent.point, size),
                    place(&before.child.point, size)
                ),
            }
        }
    }
}

/// Where a joint puts a body that has axes of its own from a file.
fn moved(run: &RunSpec, shown: &Arrangement, joint: &PlacedJoint, size: f64) -> Option<String> {
    let body = joint.child.body.filter(|&body| !joint.closes_loop && run.bodies[body].kind.brings_mesh())?;
    let pose = &shown.poses[body];
    let angle = pose.rotation.angle();
    let turned =
        if angle > CLOSED { format!(" and turned by {:.4}°", angle.to_degrees()) } else { String::new() };
    let is_moved = pose.position.norm() > CLOSED * size || !turned.is_empty();
    is_moved.then(|| {
        format!(
            "joint \"{}\" moves body \"{}\": the origin of its file is at {} m{turned}",
            joint.name,
            run.bodies[body].name,
            place(&pose.position, size)
        )
    })
}

/// What else a place that is held by its mean might be meant for.
fn averaged(run: &RunSpec, joint: &PlacedJoint) -> Option<String> {
    let spec = run.joints.iter().chain(&run.loops).find(|spec| spec.name == joint.name)?;
    let is_mean = |side: &&Attachment| {
        matches!(&side.place, Place::Area(area) if area.coupling == Coupling::Average)
            && side.body.is_some_and(|body| !run.bodies[body].kind.is_rigid())
    };
    let side =
        [&spec.child, &spec.parent].into_iter().find(is_mean).filter(|_| joint.kind == JointKind::Fixed)?;
    Some(format!(
        "joint \"{}\" holds body \"{}\" by the mean motion of its place, whose points move among each other, as a fit that yields does; a clamp that \
         holds every one of them is coupling = \"rigid\" beside the place: stiffer, with higher frequencies and larger forces",
        joint.name, run.bodies[side.body?].name
    ))
}

/// A gear in words.
fn gear_line(gear: &GearSpec, joints: &[JointSpec]) -> String {
    let coordinate = |(joint, k): (usize, usize)| {
        let (names, _) = coordinate_names(joints[joint].kind);
        let name = names.get(k).map_or("coordinate", |(name, _)| name.as_str());
        format!("{name} of joint \"{}\"", joints[joint].name)
    };
    let offset = gear.offset(joints);
    let constant = if offset == 0.0 { String::new() } else { format!("{} + ", short(offset)) };
    format!(
        "gear \"{}\": {} = {constant}{} times {}",
        gear.name,
        coordinate(gear.second),
        short(gear.ratio),
        coordinate(gear.first)
    )
}

/// A joint in words.
fn line<'a>(joint: &PlacedJoint, size: f64, name: impl Fn(usize) -> &'a str) -> String {
    let body = |of: Option<usize>| of.map_or("ground", &name);
    let mut text = format!(
        "joint \"{}\", {} between {} and {}: at {} m",
        joint.name,
        joint.kind.name(),
        body(joint.parent.body),
        body(joint.child.body),
        place(&joint.parent.point, size)
    );
    for direction in joint.directions() {
        text += &format!(", axis {}", place(&direction, 1.0));
    }
    if joint.distance() > CLOSED * size {
        text += &format!(", its child {:.6e} m away", joint.distance());
    }
    if joint.angle() > CLOSED {
        text += &format!(", turned by {:.4}°", joint.angle().to_degrees());
    }
    text
}

/// How far a joint is open in what it holds; none where it is closed.
fn opening(joint: &PlacedJoint, size: f64) -> Option<String> {
    let (distance, angle) = (joint.held_distance(), joint.held_angle());
    let mut parts = Vec::new();
    if distance > CLOSED * size {
        parts.push(format!("{distance:.6e} m apart"));
    }
    if angle > CLOSED {
        parts.push(format!("turned by {:.4}°", angle.to_degrees()));
    }
    (!parts.is_empty()).then(|| parts.join(" and "))
}

/// A vector with the digits that count beside `size`.
pub fn place(vector: &Vector3<f64>, size: f64) -> String {
    let round = |x: f64| if x.abs() < CLOSED * size { 0.0 } else { x };
    let text: Vec<String> = vector.iter().map(|x| short(round(*x))).collect();
    format!("({})", text.join(", "))
}

/// Largest distance of a place from the origin of space, at least one that is no zero \[m\].
fn extent(arrangement: &Arrangement) -> f64 {
    let sides = arrangement.joints.iter().flat_map(|j| [j.parent.point, j.child.point]);
    let places = sides.chain(arrangement.poses.iter().map(|pose| pose.position));
    places.map(|p| p.norm()).fold(f64::MIN_POSITIVE, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario;

    const RIGID: &str = "model = \"rigid\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n";

    fn arrangement(loop_at: &str) -> (Arrangement, f64) {
        let text = format!(
            "simulation = {{ end_time = 1.0 }}\n[bodies.a]\n{RIGID}[bodies.b]\n{RIGID}\
             [joints.first]\ntype = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nangle_deg = 30.0\n\
             parent = {{ body = \"ground\", point = [0.5, 0.0, 0.0] }}\nchild = {{ body = \"a\", point = [0.0, 0.0, 0.0] }}\n\
             [joints.slide]\ntype = \"prismatic\"\naxis = [0.0, 0.0, 1.0]\ndisplacement = 0.25\n\
             parent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\nchild = {{ body = \"b\", point = [0.0, 0.0, 0.0] }}\n\
             [joints.close]\ntype = \"spherical\"\ncloses_loop = true\n\
             parent = {{ body = \"a\", point = {loop_at} }}\nchild = {{ body = \"b\", point = [0.0, 0.0, 0.0] }}\n"
        );
        let scenario = scenario::parse(Path::new("t.toml"), text.as_bytes(), &[]).expect("a scenario");
        let given = Arrangement::as_given(&scenario.run).expect("places");
        let size = extent(&given);
        (given, size)
    }

    #[test]
    fn lines_say_place_axis_and_what_coordinates_do() {
        let (given, size) = arrangement("[0.0, 0.0, 0.0]");
        let name = |i: usize| ["a", "b"][i];
        assert_eq!(
            line(&given.joints[0], size, name),
            "joint \"first\", revolute between ground and a: at (0.5, 0, 0) m, axis (0, 1, 0), turned by 30.0000°"
        );
        assert_eq!(
            line(&given.joints[1], size, name),
            "joint \"slide\", prismatic between ground and b: at (0, 0, 0) m, axis (0, 0, 1), its child 2.500000e-1 m away"
        );
        assert_eq!(opening(&given.joints[0], size), None);
        assert_eq!(opening(&given.joints[1], size), None);
    }

    #[test]
    fn loops_that_are_open_are_measured() {
        // The parent's side is at (0.5, 0, 0) + R_y(30°) (-0.5, 0, 0), the child's at (0, 0, 0.25).
        let (given, size) = arrangement("[-0.5, 0.0, 0.0]");
        let (c, s) = (30.0_f64.to_radians().cos(), 30.0_f64.to_radians().sin());
        let wanted = (0.5 - 0.5 * c).hypot(0.5 * s - 0.25);
        assert!((given.joints[2].held_distance() - wanted).abs() < 1e-15);
        assert_eq!(opening(&given.joints[2], size), Some(format!("{wanted:.6e} m apart")));
    }
}
