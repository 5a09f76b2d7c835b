//! Joints, loads, rigid bodies, frames and Hertz contacts in the scenario: what is read from them, and faults that involve
//! several keys.

use std::path::Path;

use adaptive::spec::{
    Attachment, BodyKind, ContactLaw, Coupling, DampingSpec, Extent, FrameSpec, JointSpec, Place, TimeCurve,
};
use fbimpact::scenario::{self, Fault, Override, Scenario};
use ffr_dynamics::integration::Method;
use ffr_dynamics::system::joints::JointKind;
use nalgebra::{UnitQuaternion, Vector3};

/// Two rods in a chain, a sphere at the end, a free sphere, and bodies of flat models.
const CHAIN: &str = r#"
[simulation]
end_time = 1.0
[materials.m]
youngs_modulus = 2e11
poissons_ratio = 0.3
density = 8e3
[bodies.upper]
material = "m"
geometry = { shape = "cylinder", radius = 0.01, length = 1.0 }
frame = "tangent"
markers = { middle = { point = [0.0, 0.01, 0.5], radius = 2e-3 } }
[bodies.lower]
model = "rigid"
material = "m"
geometry = { shape = "box", size = [0.1, 0.2, 0.3] }
[bodies.ball]
model = "rigid"
material = "m"
geometry = { shape = "sphere", radius = 0.1 }
[bodies.other]
material = "m"
geometry = { shape = "sphere", radius = 0.1 }
position = [1.0, 0.0, 0.0]
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
[bodies.wheel]
model = "plane-stress"
material = "m"
geometry = { shape = "disc", radius = 0.1 }
[bodies.piston]
model = "rigid"
motion = "axial"
mass = 1.0
[joints.shoulder]
type = "revolute"
axis = [0.0, 2.0, 0.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "upper", marker = "start" }
angle_deg = 90.0
[joints.elbow]
type = "spherical"
parent = { body = "upper", marker = "end" }
child = { body = "lower", marker = "top" }
[joints.wrist]
type = "fixed"
parent = { body = "lower", marker = "bottom" }
child = { body = "ball", marker = "top" }
[contacts.pair]
contact_body = "ball"
target_body = "other"
model = "hertz"
[loads.push]
body = "upper"
marker = "middle"
force_x = 1.0
[output.points.p]
body = "ball"
marker = "bottom"
"#;

fn parse(set: &[&str]) -> Result<Scenario, Vec<Fault>> {
    let overrides: Vec<Override> = set.iter().map(|s| s.parse().expect("valid --set")).collect();
    scenario::parse(Path::new("case.toml"), CHAIN.as_bytes(), &overrides).map_err(|f| f.list().to_vec())
}

fn valid(set: &[&str]) -> Scenario {
    let first = parse(set).unwrap_or_else(|f| panic!("{set:?}: {f:#?}"));
    // Whatever is valid reads back to itself.
    let text = first.source.resolved.as_bytes();
    let mut again = scenario::parse(Path::new("r.toml"), text, &[])
        .unwrap_or_else(|f| panic!("{set:?}: {f}\n{}", first.source.resolved));
    again.source = first.source.clone();
    assert_eq!(first, again);
    first
}

/// Asks for a fault at `key` whose text has `words`.
fn assert_fault(set: &[&str], key: &str, words: &str) {
    let list = parse(set).expect_err(&format!("{set:?} is accepted"));
    let found = list.iter().any(|f| f.key == key && f.to_string().contains(words));
    assert!(found, "{set:?}: {key} with {words:?} in {list:#?}");
}

/// Rotation from the joint's axes to space, of a joint whose child has the orientation of space.
fn axes(joint: &JointSpec) -> UnitQuaternion<f64> {
    joint.child.rotation
}

/// The face that an attachment holds.
fn face(at: &Attachment) -> (&Extent, Coupling) {
    let Place::Area(area) = &at.place else { panic!("{at:?} is no part of a body") };
    (&area.extent, area.coupling)
}

/// Round-off of a few operations on numbers of order one.
const ROUND_OFF: f64 = 1e-14;

#[test]
fn joints_have_their_axis_as_z_and_start_where_they_are_told() {
    let scenario = valid(&[]);
    let shoulder = &scenario.run.joints[0];
    assert_eq!(
        (shoulder.kind, shoulder.parent.body, shoulder.child.body),
        (JointKind::Revolute, None, Some(0))
    );
    let z = axes(shoulder) * Vector3::z();
    assert!((z - Vector3::y()).norm() < ROUND_OFF);
    // The axis of space that is farthest from y, the first of two.
    assert!((axes(shoulder) * Vector3::x() - Vector3::x()).norm() < ROUND_OFF);
    assert!((shoulder.positions[0] - std::f64::consts::FRAC_PI_2).abs() < ROUND_OFF);
    assert_eq!(scenario.run.joints[1].positions, [1.0, 0.0, 0.0, 0.0]);
    let wrist = &scenario.run.joints[2];
    assert!(wrist.positions.is_empty() && wrist.coordinates.is_empty());
    assert_eq!(face(&shoulder.child), (&Extent::Face("start".into()), Coupling::Average));
}

#[test]
fn universal_joints_turn_about_both_axes_and_references_fix_the_first_cross_axis() {
    let set =
        ["joints.elbow.type=universal", "joints.elbow.axis=[0,0,3]", "joints.elbow.second_axis=[1,0,0]"];
    let q = axes(&valid(&set).run.joints[1]);
    assert!((q * Vector3::x() - Vector3::z()).norm() < ROUND_OFF);
    assert!((q * Vector3::y() - Vector3::x()).norm() < ROUND_OFF);
    let q = axes(&valid(&["joints.shoulder.reference=[0,1,-2]"]).run.joints[0]);
    assert!((q * Vector3::x() + Vector3::z()).norm() < ROUND_OFF);
}

#[test]
fn rotation_vectors_become_quaternions() {
    let scenario =
        valid(&["joints.elbow.coordinates=[0,0,3.141592653589793]", "joints.elbow.velocities=[1,2,3]"]);
    let elbow = &scenario.run.joints[1];
    for (found, expected) in elbow.positions.iter().zip([0.0, 0.0, 0.0, 1.0]) {
        assert!((found - expected).abs() < ROUND_OFF);
    }
    assert_eq!(elbow.velocities, [1.0, 2.0, 3.0]);
    let set = ["joints.elbow.type=free", "joints.elbow.coordinates=[1,2,3,0,0,0]"];
    assert_eq!(valid(&set).run.joints[1].positions, [1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn tangent_frames_follow_the_joint_unless_told_otherwise() {
    let frame = |set: &[&str]| valid(set).run.bodies[0].elastic().expect("flexible").flexible.frame.clone();
    let scenario = valid(&[]);
    assert_eq!(frame(&[]), FrameSpec::Tangent(scenario.run.joints[0].child.place.clone()));
    let middle = FrameSpec::Tangent(scenario.run.loads[0].at.place.clone());
    assert_eq!(frame(&["bodies.upper.frame_marker=middle"]), middle);
    let point = FrameSpec::Tangent(Place::Point([0.0, 0.0, 0.1]));
    assert_eq!(
        frame(&["bodies.upper.frame_point=[0,0,0.1]", "bodies.upper.geometric_stiffening=true"]),
        point
    );
    assert_eq!(frame(&["bodies.upper.frame=buckens"]), FrameSpec::Buckens);
}

#[test]
fn springs_drives_and_motions_stand_at_their_coordinates() {
    let scenario = valid(&[
        "joints.elbow.type=planar",
        "joints.elbow.axis=[0,0,1]",
        "joints.elbow.stiffness=[1,2,3]",
        "joints.elbow.rest=[0.1,0.2,0.3]",
        "joints.elbow.drives=[{coordinate=2,curve={kind=\"spin-up\",rate=1,duration=2}}]",
        "joints.elbow.motions=[{coordinate=0,curve={kind=\"table\",times=[0,1,2],values=[0,1,0]}}]",
        "joints.shoulder.damping=4",
        "joints.shoulder.drive=5",
    ]);
    let c = &scenario.run.joints[1].coordinates;
    assert_eq!(c.iter().map(|c| c.stiffness).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
    assert_eq!(c.iter().map(|c| c.rest).collect::<Vec<_>>(), [0.1, 0.2, 0.3]);
    assert_eq!(c[2].drive, Some(TimeCurve::SpinUp { rate: 1.0, duration: 2.0 }));
    let Some(TimeCurve::Table(spline)) = &c[0].motion else { panic!("a spline") };
    // Values at and between the points, flat in the middle of a symmetric table.
    assert!((spline.at(2.0)[0]).abs() < ROUND_OFF && (spline.at(1.0)[0] - 1.0).abs() < ROUND_OFF);
    assert!(spline.at(1.0)[1].abs() < ROUND_OFF);
    let shoulder = &scenario.run.joints[0].coordinates[0];
    assert_eq!(shoulder.drive, Some(TimeCurve::Polynomial { coefficients: vec![5.0] }));
    assert!((shoulder.damping - 4.0).abs() < ROUND_OFF);
}

#[test]
fn rigid_bodies_hertz_friction_damping_and_tolerances_are_read() {
    let scenario = valid(&[
        "simulation.static_start=true",
        "simulation.free.integrator=tr-bdf2",
        "bodies.upper.damping.modal=0.01",
        "contacts.slide.contact_body=wheel",
        "contacts.slide.target_body=floor",
        "contacts.slide.friction=0.3",
        "bodies.floor.normal=[0,1,0]",
    ]);
    let BodyKind::Rigid(lower) = &scenario.run.bodies[1].kind else { panic!("rigid") };
    let mass = 8e3 * 0.1 * 0.2 * 0.3;
    assert!((lower.mass / mass - 1.0).abs() < ROUND_OFF, "{}", lower.mass);
    assert!(matches!(scenario.run.contacts[0].law, ContactLaw::Hertz(_)));
    let ContactLaw::Surface(slide) = &scenario.run.contacts[1].law else { panic!("a surface") };
    let friction = slide.friction.expect("given");
    assert!((friction.coefficient - 0.3).abs() < ROUND_OFF);
    let settings = &scenario.run.settings;
    assert_eq!(settings.start, adaptive::spec::Start::Elastic);
    assert_eq!(settings.free.method, Some(Method::TrBdf2));
    let permitted = [
        settings.free.permitted_error(Method::TrBdf2),
        settings.impact.permitted_error(Method::DormandPrince),
    ];
    assert!((permitted[0] - 1e-5).abs() < ROUND_OFF && (permitted[1] - 1e-7).abs() < ROUND_OFF);
    let upper = scenario.run.bodies[0].elastic().expect("flexible");
    assert_eq!(upper.flexible.damping, DampingSpec::Modal(vec![0.01]));
}

#[test]
fn faults_of_joints_name_key_and_remedy() {
    for (set, key, words) in [
        ("joints.shoulder.axis=[0,0,0]", "joints.shoulder.axis", "zero vector"),
        ("joints.shoulder.reference=[0,1,0]", "joints.shoulder.reference", "parallel"),
        ("joints.shoulder.second_axis=[1,0,0]", "joints.shoulder.second_axis", "revolute"),
        ("joints.shoulder.type=revolut", "joints.shoulder.type", "did you mean \"revolute\""),
        ("joints.shoulder.child.body=uper", "joints.shoulder.child.body", "did you mean \"upper\""),
        ("joints.shoulder.parent.body=grund", "joints.shoulder.parent.body", "did you mean \"ground\""),
        ("joints.shoulder.child.marker=strat", "joints.shoulder.child.marker", "did you mean \"start\""),
        ("joints.shoulder.child.body=ground", "joints.shoulder.child.body", "child of no joint"),
        ("joints.shoulder.child.body=floor", "joints.shoulder.child.body", "name \"ground\" instead"),
        ("joints.shoulder.child.point=[0,0,0]", "joints.shoulder.child.point", "only one of"),
        ("joints.shoulder.parent.marker=top", "joints.shoulder.parent.marker", "no markers"),
        ("joints.shoulder.parent.point=[0,0]", "joints.shoulder.parent.point", "3 coordinates"),
        ("joints.shoulder.child.marker=centre", "joints.shoulder.child.marker", "carries no force"),
        ("joints.shoulder.child={body=\"upper\",point=[0,0,0]}", "joints.shoulder.child.point", "\"radius\""),
        ("joints.shoulder.child={body=\"upper\",face=\"x-\"}", "joints.shoulder.child.face", "known are"),
        ("joints.shoulder.child.radius=0.001", "joints.shoulder.child.radius", "a marker has its own"),
        ("joints.shoulder.parent.face=z-", "joints.shoulder.parent.face", "no markers"),
        ("joints.shoulder.parent.body=ball", "joints.shoulder.parent.body", "cycle"),
        ("joints.elbow.child.body=ball", "joints.wrist.child.body", "over-constrained"),
        ("joints.wrist.angle=1", "joints.wrist.angle", "neither fixed"),
        ("joints.wrist.axis=[1,0,0]", "joints.wrist.axis", "a fixed joint has none"),
        ("joints.shoulder.displacement=1", "joints.shoulder.displacement", "coordinates"),
        ("joints.shoulder.coordinates=[1]", "joints.shoulder.angle_deg", "not both"),
        ("joints.shoulder.velocities=[1,2]", "joints.shoulder.velocities", "2 entries"),
        ("joints.shoulder.motion=1", "joints.shoulder.angle_deg", "follows from \"motion\""),
        ("joints.shoulder.motions=[{coordinate=1,curve=1}]", "joints.shoulder.motions[0].coordinate", "< 1"),
        ("joints.elbow.drive=1", "joints.elbow.drive", "drives"),
        ("joints.elbow.motions=[{coordinate=0,curve=1}]", "joints.elbow.motions", "cannot be prescribed"),
        ("joints.elbow.stiffness=[1,1,2]", "joints.elbow.stiffness", "alike"),
        ("joints.elbow.rest=[0,0,1]", "joints.elbow.rest", "relaxed at 0"),
        ("joints.elbow.angle=1", "joints.elbow.angle", "coordinates"),
        ("joints.shoulder.child.body=wheel", "joints.shoulder.child.marker", "marker of shape \"disc\""),
        ("joints.elbow.parent.body=wheel", "joints.elbow.parent.marker", "unknown marker"),
        (
            "joints.shoulder.drive={kind=\"table\",times=[0,0],values=[1,2]}",
            "joints.shoulder.drive.times",
            "rise",
        ),
        (
            "joints.shoulder.drive={kind=\"table\",times=[0,1],values=[1]}",
            "joints.shoulder.drive.values",
            "1 values",
        ),
        (
            "joints.shoulder.drive={kind=\"table\",times=[0],values=[1]}",
            "joints.shoulder.drive.times",
            "two times",
        ),
        ("joints.shoulder.drive={kind=\"spinup\"}", "joints.shoulder.drive.kind", "did you mean \"spin-up\""),
    ] {
        assert_fault(&[set], key, words);
    }
    let itself = ["joints.elbow.child.body=upper", "joints.elbow.child.marker=start"];
    assert_fault(&itself, "joints.elbow.child.body", "must differ");
    assert_fault(&["joints.elbow.type=universal"], "joints.elbow.second_axis", "missing");
    let set =
        ["joints.elbow.type=universal", "joints.elbow.axis=[1,0,0]", "joints.elbow.second_axis=[1,1,0]"];
    assert_fault(&set, "joints.elbow.second_axis", "45.0");
    assert_fault(&["joints.elbow.type=prismatic"], "joints.elbow.axis", "missing");
    let set = ["joints.wrist.closes_loop=true", "joints.wrist.type=free"];
    assert_fault(&set, "joints.wrist.closes_loop", "holds nothing");
    let set = ["joints.shoulder.closes_loop=true"];
    assert_fault(&set, "joints.shoulder.angle_deg", "nor close a loop");
}

#[test]
fn flat_models_take_joints_of_their_plane_or_axis_only() {
    let wheel = |kind: &str, axis: &str| -> Vec<String> {
        vec![
            format!("joints.hub.type={kind}"),
            format!("joints.hub.axis={axis}"),
            "joints.hub.parent={body=\"ground\",point=[0,0,0]}".into(),
            "joints.hub.child={body=\"wheel\",point=[0,0],radius=0.01}".into(),
        ]
    };
    let refs = |list: &[String]| -> Vec<String> { list.to_vec() };
    let check = |set: Vec<String>, fault: Option<(&str, &str)>| {
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        match fault {
            None => drop(valid(&set)),
            Some((key, words)) => assert_fault(&set, key, words),
        }
    };
    check(refs(&wheel("revolute", "[0,0,-1]")), None);
    check(refs(&wheel("prismatic", "[1,1,0]")), None);
    check(refs(&wheel("planar", "[0,0,1]")), None);
    check(refs(&wheel("revolute", "[0,1,0]")), Some(("joints.hub.axis", "along z")));
    check(refs(&wheel("prismatic", "[0,1,1]")), Some(("joints.hub.axis", "in the plane")));
    check(refs(&wheel("cylindrical", "[0,0,1]")), Some(("joints.hub.type", "plane")));
    let mixed =
        [wheel("revolute", "[0,0,1]"), vec!["joints.hub.parent={body=\"lower\",marker=\"top\"}".into()]];
    check(mixed.concat(), Some(("joints.hub.parent.body", "is spatial, the child is plane")));
    let axial = |kind: &str| -> Vec<String> {
        vec![
            format!("joints.bore.type={kind}"),
            "joints.bore.parent={body=\"ground\",point=[0,0,0]}".into(),
            "joints.bore.child={body=\"piston\",point=[0,0]}".into(),
        ]
    };
    check(axial("axial"), None);
    check(axial("spherical"), Some(("joints.bore.type", "axisymmetric")));
}

#[test]
fn faults_of_bodies_loads_and_contacts_name_key_and_remedy() {
    for (set, key, words) in [
        ("bodies.upper.position=[0,0,0]", "bodies.upper.position", "child of joint \"shoulder\""),
        ("bodies.ball.velocity=[0,0,0]", "bodies.ball.velocity", "child of joint \"wrist\""),
        ("bodies.lower.mass=1", "bodies.lower.mass", "without \"geometry\" only"),
        ("bodies.lower.frame=tangent", "bodies.lower.frame", "flexible bodies only"),
        ("bodies.upper.mass=1", "bodies.upper.mass", "\"rigid\" only"),
        ("bodies.upper.normal=[0,0,1]", "bodies.upper.normal", "\"plane\" only"),
        ("bodies.upper.frame_marker=nowhere", "bodies.upper.frame_marker", "unknown marker"),
        ("bodies.other.frame_marker=top", "bodies.other.frame_marker", "\"tangent\" only"),
        ("bodies.other.frame=tangent", "bodies.other.frame_marker", "missing"),
        ("bodies.other.geometric_stiffening=true", "bodies.other.geometric_stiffening", "tangent"),
        ("bodies.upper.markers.start.point=[0,0,0]", "bodies.upper.markers.start", "already"),
        ("bodies.upper.markers.middle.point=[0,0]", "bodies.upper.markers.middle.point", "3 coordinates"),
        ("bodies.upper.damping.modal=-1", "bodies.upper.damping.modal", ">= 0"),
        ("bodies.upper.damping.ratio=0.1", "bodies.upper.damping.frequencies", "missing"),
        ("bodies.floor.motion=planar", "bodies.floor.motion", "unbounded and at rest"),
        ("bodies.floor.mass=1", "bodies.floor.mass", "without \"geometry\" only"),
        ("bodies.lower.motion=planar", "bodies.lower.geometry.shape", "motion \"planar\""),
        ("bodies.piston.inertia=[[1,1,0],[0,1,0],[0,0,1]]", "bodies.piston.inertia", "symmetric"),
        ("bodies.piston.inertia=[-1,1,1]", "bodies.piston.inertia", ">= 0"),
        ("bodies.piston.material=m", "bodies.piston.material", "with \"geometry\" only"),
        ("bodies.piston.motion=spatial", "bodies.piston.inertia", "missing"),
        ("bodies.piston.angular_velocity=[0,0,1]", "bodies.piston.angular_velocity", "zero"),
        ("bodies.new={model=\"rigid\"}", "bodies.new.geometry", "missing"),
        ("bodies.new={material=\"m\"}", "bodies.new.geometry", "missing"),
        (
            "bodies.new={model=\"rigid\",mass=1,inertia=[1,1,3]}",
            "bodies.new.inertia",
            "no distribution of mass",
        ),
        ("bodies.ground={model=\"rigid\",mass=1,inertia=[1,1,1]}", "bodies.ground", "name of space"),
        ("loads.push.body=uper", "loads.push.body", "did you mean \"upper\""),
        ("loads.push.body=floor", "loads.push.marker", "unbounded"),
        ("loads.push.marker=midle", "loads.push.marker", "did you mean \"middle\""),
        ("loads.pull={body=\"upper\",marker=\"end\"}", "loads.pull.force_z", "missing"),
        ("loads.pull={body=\"wheel\",face=\"rim\",force_z=1}", "loads.pull.force_z", "plane"),
        ("loads.pull={body=\"piston\",point=[0,0],moment_z=1}", "loads.pull.moment_z", "axisymmetric"),
        ("contacts.pair.penalty.initial=1e9", "contacts.pair.penalty", "hertz"),
        (
            "contacts.pair={contact_body=\"lower\",target_body=\"floor\",model=\"hertz\"}",
            "contacts.pair.contact_body",
            "flat faces",
        ),
        ("contacts.pair.contact_body=floor", "contacts.pair.contact_body", "exchange"),
        ("contacts.pair.model=quasistatic", "contacts.pair.contact_body", "flexible"),
        ("contacts.pair.friction=-0.1", "contacts.pair.friction", ">= 0"),
        ("output.points.p.body=floor", "output.points.p.marker", "unbounded"),
        ("simulation.static_start=1", "simulation.static_start", "true or false"),
    ] {
        assert_fault(&[set], key, words);
    }
    let set = [
        "contacts.pair.model=dynamic",
        "contacts.pair.contact_body=other",
        "contacts.pair.target_body=floor",
        "contacts.pair.solver=broyden",
        "contacts.pair.friction=0.1",
    ];
    assert_fault(&set, "contacts.pair.solver", "friction");
}

#[test]
fn planes_with_a_material_are_elastic_half_spaces_for_hertz() {
    let scenario = valid(&["bodies.floor.material=m", "contacts.pair.target_body=floor"]);
    assert_eq!((scenario.bodies[4].name.as_str(), scenario.bodies[4].index), ("floor", None));
    let ContactLaw::Hertz(law) = &scenario.run.contacts[0].law else { panic!("Hertz") };
    let [own, plane] = law.solids();
    assert_eq!(own, plane);
    assert!(scenario.run.contacts[0].spheres().is_some_and(|(_, other)| other.body().is_none()));
    assert!((plane.young - 2e11).abs() < 1.0);
}

#[test]
fn joints_take_the_keys_of_their_coordinates() {
    use JointKind::{Axial, Cylindrical, Fixed, Free, Planar, Prismatic, Revolute, Spherical, Universal};
    for kind in [Fixed, Revolute, Prismatic, Cylindrical, Universal, Spherical, Planar, Free, Axial] {
        let n = kind.n_velocities();
        let of_angles = |is_angle: bool| (0..n).filter(|&k| kind.is_angle(k) == is_angle).count();
        let single = [
            ("angle", of_angles(true)),
            ("angular_velocity", of_angles(true)),
            ("displacement", of_angles(false)),
            ("velocity", of_angles(false)),
            ("drive", n),
            ("motion", n),
        ];
        for (key, count) in single {
            let joint = format!("joints.other={{type=\"{}\",{key}=0.0}}", kind.name());
            let list = parse(&[&joint]).expect_err("parent and child are missing");
            let is_fault = list.iter().any(|f| f.key == format!("joints.other.{key}"));
            assert_eq!(is_fault, count != 1, "{key} of a {} joint: {list:#?}", kind.name());
        }
    }
}

#[test]
fn joints_on_ground_stand_where_the_child_lies_about_the_origin() {
    let parent = |set: &[&str], name: &str| {
        let scenario = valid(set);
        let joint = scenario.run.joints.iter().find(|joint| joint.name == name).expect("there");
        let Place::Point(point) = joint.parent.place else { panic!("a point of space") };
        Vector3::from(point)
    };
    let open = "joints.shoulder.parent={body=\"ground\"}";
    assert!(parent(&[open], "shoulder").norm() < ROUND_OFF, "the rod starts at its origin");
    let end = [open, "joints.shoulder.child.marker=end", "bodies.upper.orientation_deg=[90,0,0]"];
    let [held, elbow] = ["joints.elbow.parent.marker=start", "bodies.upper.frame=buckens"];
    let found = parent(&[&end[..], &[held, elbow]].concat(), "shoulder");
    assert!(
        (found + Vector3::new(0.0, 1.0, 0.0)).norm() < ROUND_OFF,
        "{found}: z of the rod, 1 m long, is -y of space"
    );
    let hub = "joints.hub={type=\"revolute\",axis=[0,0,1],parent={body=\"ground\"},\
               child={body=\"wheel\",point=[0.05,0],radius=0.01}}";
    let found = parent(&[hub, "bodies.wheel.orientation_deg=[0,0,90]"], "hub");
    assert!((found - Vector3::new(0.0, 0.05, 0.0)).norm() < ROUND_OFF, "{found}");
    // What closes a loop is held by other joints already.
    let second = "joints.second={type=\"spherical\",closes_loop=true,parent={body=\"ground\"},\
                  child={body=\"lower\",marker=\"bottom\"}}";
    assert_fault(&[second], "joints.second.parent.point", "missing");
}

/// A ball of the material `name`; `rest` follows.
fn ball_of(name: &str, rest: &str) -> String {
    format!(
        "[simulation]\nend_time = 1.0\n[bodies.ball]\nmodel = \"rigid\"\nmaterial = \"{name}\"\n\
         geometry = {{ shape = \"sphere\", radius = 0.1 }}\n{rest}"
    )
}

#[test]
fn standard_materials_need_no_table_and_give_way_to_one() {
    let mass = |text: &str, set: &[&str]| {
        let overrides: Vec<Override> = set.iter().map(|s| s.parse().expect("KEY=VALUE")).collect();
        let scenario = scenario::parse(Path::new("test.toml"), text.as_bytes(), &overrides);
        let scenario = scenario.unwrap_or_else(|e| panic!("{e}"));
        match &scenario.run.bodies[0].kind {
            BodyKind::Rigid(body) => (body.mass, scenario.source.resolved),
            other => panic!("{other:?}"),
        }
    };
    let volume = 4e-3 * std::f64::consts::PI / 3.0;
    let is = |found: f64, density: f64| assert!((found / (density * volume) - 1.0).abs() < 1e-12, "{found}");
    let (steel, resolved) = mass(&ball_of("steel", ""), &[]);
    is(steel, 7850.0);
    // The result file says what was used.
    assert!(resolved.contains("[materials.steel]") && resolved.contains("210000000000"), "{resolved}");
    is(mass(&ball_of("brass", ""), &[]).0, 8530.0);
    let own = "[materials.steel]\nyoungs_modulus = 2e11\npoissons_ratio = 0.3\ndensity = 8e3\n";
    is(mass(&ball_of("steel", own), &[]).0, 8000.0);
    let (changed, resolved) = mass(&ball_of("steel", ""), &["materials.steel.density=7700"]);
    is(changed, 7700.0);
    assert!(resolved.contains("210000000000"), "{resolved}");

    // A table of one's own must be complete, and other names are answered with those that exist.
    let fault = |text: &str| match scenario::parse(Path::new("test.toml"), text.as_bytes(), &[]) {
        Err(faults) => faults.to_string(),
        Ok(_) => panic!("valid: {text}"),
    };
    let incomplete = fault(&ball_of("steel", "[materials.steel]\ndensity = 8e3\n"));
    assert!(incomplete.contains("materials.steel.youngs_modulus"), "{incomplete}");
    let unknown = fault(&ball_of("stele", ""));
    assert!(unknown.contains("did you mean \"steel\""), "{unknown}");
}

#[test]
fn numbers_may_have_units() {
    let read = |text: &str| scenario::parse(Path::new("test.toml"), text.as_bytes(), &[]);
    let text = |end: &str, position: &str, size: &str, rest: &str| {
        format!(
            "[simulation]\nend_time = {end}\n[materials.m]\nyoungs_modulus = \"210 GPa\"\npoissons_ratio = 0.3\n\
             density = \"7.85 g/cm³\"\n[bodies.block]\nmaterial = \"m\"\n\
             geometry = {{ shape = \"box\", size = {size} }}\nposition = {position}\n{rest}"
        )
    };
    let [units, plain] = [
        text(
            "\"10 ms\"",
            "[\"1cm\", 0.0, \"-2 mm\"]",
            "[\"1 in\", 0.02, \"30 mm\"]",
            "velocity = [\"36 km/h\", 0.0, 0.0]\n",
        ),
        text("0.01", "[0.01, 0.0, -0.002]", "[0.0254, 0.02, 0.03]", "velocity = [10.0, 0.0, 0.0]\n"),
    ]
    .map(|text| read(&text).unwrap_or_else(|e| panic!("{e}")));
    // The products differ in the last digit: both are read to two digits less.
    let shown = |scenario: &Scenario| {
        let words = scenario.source.resolved.split_inclusive([' ', ',', '[', ']', '\n']);
        let rounded = |word: &str| {
            word.trim_end_matches([' ', ',', '[', ']', '\n']).parse::<f64>().map(|x| format!("{x:.13e} "))
        };
        words.map(|word| rounded(word).unwrap_or_else(|_| word.to_owned())).collect::<String>()
    };
    assert_eq!(shown(&units), shown(&plain));

    for (end, message) in [
        ("\"10 mm\"", "unknown unit \"mm\", known here are s, ms, µs, us, min"),
        ("\"ms\"", "must be a number > 0"),
        ("\"-1 ms\"", "must be a number > 0"),
    ] {
        let faults = read(&text(end, "[0.0, 0.0, 0.0]", "[1, 1, 1]", "")).expect_err("a fault").to_string();
        assert!(faults.contains("simulation.end_time") && faults.contains(message), "{faults}");
    }
    // Limits are those of the unit in which the number is given where that is degrees; the number is shown as it was given.
    let tooth = |angle: &str| {
        let text = format!(
            "[simulation]\nend_time = 1.0\n[bodies.tooth]\nmodel = \"rigid\"\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"gear-tooth\", module = 1e-3, teeth = 20, inner_radius = 5e-3, width = 0.01, {angle} }}\n"
        );
        read(&text).expect_err("a fault").to_string()
    };
    assert!(tooth("pressure_angle_deg = 50").contains("_deg = 50: must be a number > 0 and < 45 deg"));
    assert!(tooth("pressure_angle = \"50 deg\"").contains("= \"50 deg\": must be a number > 0 and < 45 deg"));
    let set = "bodies.block.geometry.size[0]=\"-1 mm\"".parse().expect("an override");
    let faults =
        scenario::parse(Path::new("test.toml"), text("1.0", "[0, 0, 0]", "[1, 1, 1]", "").as_bytes(), &[set]);
    assert!(faults.expect_err("a fault").to_string().contains("= \"-1 mm\": must be a number > 0"));
    let rest = "discretisation = { degree = 3, elements = \"8 mm\" }\nreduction = { modes = \"20 Hz\" }\n";
    assert!(read(&text("1.0", "[0.0, 0.0, 0.0]", "[1, 1, 1]", rest)).is_err());
}

#[test]
fn a_quantity_in_degrees_is_named_as_it_was_given() {
    for (given, key) in [
        ("orientation_deg = [0.0, 30.0, 0.0]", "bodies.wheel.orientation_deg"),
        ("orientation = [0.0, 0.5, 0.0]", "bodies.wheel.orientation"),
    ] {
        let text = CHAIN.replace("[bodies.wheel]", &format!("[bodies.wheel]\n{given}"));
        let faults = scenario::parse(Path::new("case.toml"), text.as_bytes(), &[]).err();
        let faults = faults.map_or_else(Vec::new, |f| f.list().to_vec());
        assert!(faults.iter().any(|f| f.key == key && f.message.contains("about z")), "{faults:?}");
    }
}
