//! From scenarios to the specification of a run: masses, places and axes in the bodies' own frames.

use std::f64::consts::PI;
use std::path::Path;

use adaptive::spec::{
    BodyKind, ContactLaw, Coupling, DampingSpec, Extent, FrameSpec, Place, RunSpec, TimeCurve,
};
use contact_qs::law::Solid;
use fbimpact::scenario::{self, Override};
use nalgebra::{Matrix3, Vector3};

const TEXT: &str = r#"
[simulation]
end_time = 1.0
static_start = true
free = { integrator = "tr-bdf2" }
[materials.m]
youngs_modulus = 2e11
poissons_ratio = 0.3
density = 8e3
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
material = "m"
[bodies.arm]
material = "m"
geometry = { shape = "cylinder", radius = 0.01, length = 1.0 }
orientation_deg = [0, 90, 0]
frame = "tangent"
geometric_stiffening = true
damping = { modal = [0.1, 0.2] }
markers = { side = { point = [0.01, 0.0, 0.5], radius = 2e-3, coupling = "rigid" } }
[bodies.ball]
model = "rigid"
material = "m"
geometry = { shape = "sphere", radius = 0.1 }
orientation_deg = [0, 0, 30]
markers = { spot = { point = [0.05, 0.0, 0.0] } }
[bodies.block]
model = "rigid"
mass = 2.0
centre_of_mass = [0.1, 0.2, 0.3]
inertia = [[2.0, 0.1, 0.0], [0.1, 3.0, 0.0], [0.0, 0.0, 4.0]]
[bodies.wheel]
model = "rigid"
motion = "planar"
thickness = 0.5
material = "m"
geometry = { shape = "disc", radius = 0.1 }
[joints.hinge]
type = "revolute"
axis = [0.0, 1.0, 0.0]
parent = { body = "ground", point = [0.1, 0.2, 0.3] }
child = { body = "arm", marker = "start" }
angle_deg = 45
[joints.knee]
type = "universal"
axis = [1.0, 0.0, 0.0]
second_axis = [0.0, 0.0, 1.0]
parent = { body = "arm", marker = "side" }
child = { body = "ball", marker = "spot" }
[joints.loop]
type = "spherical"
parent = { body = "block", point = [0.0, 0.0, 0.0] }
child = { body = "ball", marker = "top" }
closes_loop = true
[loads.push]
body = "ball"
marker = "left"
moment_y = { kind = "polynomial", coefficients = [1.0, 2.0] }
following = true
[contacts.pair]
contact_body = "ball"
target_body = "floor"
model = "hertz"
[output.points.p]
body = "ball"
marker = "spot"
"#;

fn spec(set: &[&str]) -> RunSpec {
    let set: Vec<Override> = set.iter().map(|s| s.parse().expect("valid --set")).collect();
    scenario::parse(Path::new("t.toml"), TEXT.as_bytes(), &set).unwrap_or_else(|f| panic!("{f}")).run
}

/// Round-off of a few operations on numbers of order one.
const ROUND_OFF: f64 = 1e-13;

#[test]
fn rigid_bodies_have_the_mass_of_their_shape_or_the_given_one() {
    let spec = spec(&[]);
    let rigid = |i: usize| match &spec.bodies[i].kind {
        BodyKind::Rigid(rigid) => rigid,
        BodyKind::Elastic(_) | BodyKind::Imported(_) | BodyKind::Meshed(_) => panic!("rigid"),
    };
    let (ball, block, wheel) = (rigid(1), rigid(2), rigid(3));
    let mass = 8e3 * 4.0 / 3.0 * PI * 1e-3;
    assert!((ball.mass / mass - 1.0).abs() < ROUND_OFF);
    assert!((ball.inertia - Matrix3::identity() * (0.4 * mass * 0.01)).norm() < ROUND_OFF * mass);
    assert!(ball.centre_of_mass.norm() < ROUND_OFF);
    assert!((block.mass - 2.0).abs() < ROUND_OFF && (block.inertia[(0, 1)] - 0.1).abs() < ROUND_OFF);
    assert!((block.centre_of_mass - Vector3::new(0.1, 0.2, 0.3)).norm() < ROUND_OFF);
    let mass = 8e3 * PI * 0.01 * 0.5;
    assert!((wheel.mass / mass - 1.0).abs() < ROUND_OFF);
    assert!((wheel.inertia[(2, 2)] / (0.5 * mass * 0.01) - 1.0).abs() < ROUND_OFF);
}

#[test]
fn axes_of_both_attachments_coincide_in_space() {
    let spec = spec(&[]);
    let in_space = |a: &adaptive::spec::Attachment| match a.body {
        Some(body) => spec.bodies[body].motion.rotation * a.rotation,
        None => a.rotation,
    };
    assert_eq!((spec.joints.len(), spec.loops.len()), (2, 1));
    for joint in spec.joints.iter().chain(&spec.loops) {
        assert!(in_space(&joint.parent).angle_to(&in_space(&joint.child)) < 1e-7, "{}", joint.name);
    }
    let (hinge, knee) = (&spec.joints[0], &spec.joints[1]);
    assert!((in_space(&hinge.child) * Vector3::z() - Vector3::y()).norm() < ROUND_OFF);
    // The arm's z axis points along x in space, so that the hinge turns about its own y axis.
    assert!((hinge.child.rotation * Vector3::z() - Vector3::y()).norm() < ROUND_OFF);
    assert!((in_space(&knee.parent) * Vector3::x() - Vector3::x()).norm() < ROUND_OFF);
    assert!((in_space(&knee.parent) * Vector3::y() - Vector3::z()).norm() < ROUND_OFF);
    assert!((hinge.positions[0] - PI / 4.0).abs() < ROUND_OFF);
}

#[test]
fn places_are_resolved_whether_they_come_from_the_shape_or_the_user() {
    let spec = spec(&[]);
    assert_eq!(spec.joints[0].parent.place, Place::Point([0.1, 0.2, 0.3]));
    let Place::Area(side) = &spec.joints[1].parent.place else { panic!("a part of a flexible body") };
    let point = [0.01, 0.0, 0.5];
    assert_eq!((&side.extent, side.centre), (&Extent::Around { point, radius: 2e-3 }, point));
    assert_eq!(side.coupling, Coupling::Rigid);
    assert_eq!(spec.joints[1].child.place, Place::Point([0.05, 0.0, 0.0]));
    assert_eq!(spec.loops[0].child.place, Place::Point([0.0, 0.0, 0.1]));
    assert_eq!(spec.points[0].place, Place::Point([0.05, 0.0, 0.0]));
    // The plane is no body of the run, so that numbers shift by one.
    assert_eq!((spec.points[0].body, spec.bodies.len()), (1, 4));
    let arm = spec.bodies[0].elastic().expect("flexible");
    // The start of a bar is its end face where a joint holds it, and rigid parts stiffen the body.
    let Place::Area(start) = &spec.joints[0].child.place else { panic!("a part of a flexible body") };
    assert_eq!((&start.extent, start.coupling), (&Extent::Face("start".into()), Coupling::Average));
    assert!(start.centre.iter().all(|x| x.abs() < ROUND_OFF));
    assert_eq!(arm.flexible.frame, FrameSpec::Tangent(Place::Area(start.clone())));
    assert_eq!(arm.flexible.rigid_areas, std::slice::from_ref(side));
    assert!(arm.flexible.geometric_stiffening && arm.shape.markers.contains_key("side"));
    assert_eq!(arm.flexible.damping, DampingSpec::Modal(vec![0.1, 0.2]));
}

#[test]
fn loads_contacts_and_settings_are_handed_on() {
    let spec = spec(&[]);
    let load = &spec.loads[0];
    assert!(load.is_following && load.components.iter().filter(|c| c.is_some()).count() == 1);
    assert_eq!(load.components[4], Some(TimeCurve::Polynomial { coefficients: vec![1.0, 2.0] }));
    assert!(load.at.rotation.angle() < ROUND_OFF, "following axes are those of the body");
    let steel = Solid { young: 2e11, poisson: 0.3 };
    let ContactLaw::Hertz(law) = &spec.contacts[0].law else { panic!("Hertz") };
    let (contact, other) = spec.contacts[0].spheres().expect("a sphere on a plane");
    assert_eq!(law.solids(), [steel; 2]);
    assert!((contact.radius - 0.1).abs() < ROUND_OFF && contact.centre == Place::Point([0.0; 3]));
    assert!(other.body().is_none());
    assert_eq!(spec.settings.start, adaptive::spec::Start::Elastic);
    assert_eq!(spec.settings.free.method, Some(ffr_dynamics::integration::Method::TrBdf2));
    assert_eq!(spec.settings.impact.method, Some(ffr_dynamics::integration::Method::DormandPrince));
}
