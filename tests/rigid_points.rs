//! Rigid bodies on planes and on each other by points on their faces: weight, friction, tipping, impacts, and Hertz's law on flat faces.

use adaptive::record::Sample;
use adaptive::run::recording::Recording;
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use crate::support::fbimpact;
use crate::support::scenarios::{faults, folder, refusal, run_text, valid};

const GRAVITY: f64 = 9.81;
/// Steel [kg/m³].
const DENSITY: f64 = 7850.0;
/// Edges of the block that most scenes have \[m\].
const BLOCK: [f64; 3] = [0.1, 0.08, 0.06];

/// How a scene stands in space.
fn attitudes() -> [UnitQuaternion<f64>; 3] {
    let turn = |axis: Vector3<f64>, angle: f64| UnitQuaternion::from_scaled_axis(axis.normalize() * angle);
    [UnitQuaternion::identity(), turn(Vector3::y(), FRAC_PI_2), turn(Vector3::new(1.0, 2.0, 3.0), 0.7)]
}

fn list(v: Vector3<f64>) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

/// A scene that stands in space as `attitude` says.
struct Scene {
    text: String,
    attitude: UnitQuaternion<f64>,
}

impl Scene {
    /// Without bodies, in the gravity `(x, 0, z)`.
    fn new(end: f64, gravity: [f64; 2], more: &str, attitude: UnitQuaternion<f64>) -> Self {
        let gravity = list(attitude * Vector3::new(gravity[0], 0.0, gravity[1]));
        Self { text: format!("[simulation]\nend_time = {end:?}\ngravity = {gravity}\n{more}\n"), attitude }
    }

    /// The same with a floor at z = 0.
    fn on_floor(mut self) -> Self {
        let normal = list(self.attitude * Vector3::z());
        self.text += &format!(
            "[bodies.floor]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nnormal = {normal}\n"
        );
        self
    }

    /// With a rigid body of steel at `place`, turned by `tilt` about the y axis of the scene.
    fn body(mut self, name: &str, geometry: &str, place: [f64; 3], tilt: f64, more: &str) -> Self {
        let q = self.attitude * UnitQuaternion::from_scaled_axis(Vector3::y() * tilt);
        let place = list(self.attitude * Vector3::from(place));
        self.text += &format!(
            "[bodies.{name}]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = {{ {geometry} }}\nposition = {place}\n\
             orientation = [{:?}, {:?}, {:?}, {:?}]\n{more}\n",
            q.w, q.i, q.j, q.k
        );
        self
    }

    /// With a rigid block of steel about the origin that a joint holds.
    fn held(mut self, geometry: &str) -> Self {
        let q = self.attitude;
        self.text += &format!(
            "[bodies.held]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = {{ {geometry} }}\n\
             orientation = [{:?}, {:?}, {:?}, {:?}]\n[joints.hold]\ntype = \"fixed\"\nparent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\n\
             child = {{ body = \"held\", point = [0.0, 0.0, 0.0] }}\n",
            q.w, q.i, q.j, q.k
        );
        self
    }

    /// With a contact of points.
    fn contact(mut self, name: &str, bodies: [&str; 2], more: &str) -> Self {
        let [own, target] = bodies;
        self.text += &format!(
            "[contacts.{name}]\ncontact_body = \"{own}\"\ntarget_body = \"{target}\"\nmodel = \"coarse\"\n{more}\n"
        );
        self
    }

    fn run(&self) -> Recording {
        run_text(&self.text)
    }

    /// A vector of the result in the axes of the scene.
    fn seen(&self, v: [f64; 3]) -> Vector3<f64> {
        self.attitude.inverse_transform_vector(&v.into())
    }
}

fn cuboid(edges: [f64; 3]) -> String {
    format!("shape = \"box\", size = {edges:?}")
}

fn mass(edges: [f64; 3]) -> f64 {
    DENSITY * edges.iter().product::<f64>()
}

fn last(recording: &Recording) -> &Sample {
    recording.samples.last().unwrap()
}

/// Largest way that a body has moved \[m\].
fn moved(recording: &Recording, body: usize) -> f64 {
    let start = Vector3::from(recording.samples[0].bodies[body].centre_of_mass);
    let way = |sample: &Sample| (Vector3::from(sample.bodies[body].centre_of_mass) - start).norm();
    recording.samples.iter().map(way).fold(0.0, f64::max)
}

fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found} for {expected}");
}

const AT_REST: &str = "start = \"static\"";
/// Forces of an equilibrium are found to 1e-8 of all.
const BALANCED: f64 = 1e-6;

#[test]
fn what_stands_carries_its_weight_and_stays() {
    let [x, y, z] = BLOCK;
    let round = "shape = \"cylinder\", radius = 0.04, length = 0.1";
    let of_round = DENSITY * PI * 0.04_f64.powi(2) * 0.1;
    let shapes = [
        ("a block", cuboid([x, y, z]), 0.5 * z, mass(BLOCK)),
        ("on its side", cuboid([z, x, y]), 0.5 * y, mass(BLOCK)),
        ("on its end", cuboid([y, z, x]), 0.5 * x, mass(BLOCK)),
        ("a cylinder", round.into(), 0.05, of_round),
    ];
    for attitude in attitudes() {
        for (name, geometry, height, mass) in &shapes {
            let scene = Scene::new(5e-3, [0.0, -GRAVITY], AT_REST, attitude).on_floor();
            let scene = scene.body("a", geometry, [0.0, 0.0, *height], 0.0, "");
            let scene = scene.contact("c", ["a", "floor"], "friction = 0.3");
            let found = scene.run();
            for sample in [&found.samples[0], last(&found)] {
                close(name, sample.contacts[0].normal_force, mass * GRAVITY, BALANCED);
            }
            assert!(moved(&found, 0) < 1e-12, "{name}: {:e}", moved(&found, 0));
            assert!(found.warnings.is_empty(), "{name}: {:?}", found.warnings);
        }
        // A block on another one, in the middle and with its end over the edge.
        for aside in [0.0, 0.045] {
            let scene = Scene::new(1e-3, [0.0, -GRAVITY], AT_REST, attitude).held(&cuboid(BLOCK));
            let scene = scene.body("a", &cuboid(BLOCK), [aside, 0.0, z], 0.0, "");
            let found = scene.contact("c", ["a", "held"], "friction = 0.3").run();
            close("on a block", last(&found).contacts[0].normal_force, mass(BLOCK) * GRAVITY, BALANCED);
            assert!(moved(&found, 1) < 1e-12, "{aside}: {:e}", moved(&found, 1));
        }
    }
}

#[test]
fn the_lowest_of_three_blocks_bears_all() {
    let mut scene = Scene::new(2e-4, [0.0, -GRAVITY], AT_REST, UnitQuaternion::identity()).on_floor();
    let names = ["floor", "one", "two", "three"];
    for (i, pair) in names.windows(2).enumerate() {
        let place = [0.0, 0.0, (i as f64 + 0.5) * BLOCK[2]];
        scene = scene.body(pair[1], &cuboid(BLOCK), place, 0.0, "");
        scene = scene.contact(&format!("c{i}"), [pair[1], pair[0]], "friction = 0.3");
    }
    let found = scene.run();
    for (i, above) in [3.0, 2.0, 1.0].into_iter().enumerate() {
        let force = last(&found).contacts[i].normal_force;
        close("a block of the stack", force, above * mass(BLOCK) * GRAVITY, BALANCED);
        assert!(moved(&found, i) < 1e-12);
    }
}

/// A block on a slope of the angle `ratio` times that of friction 0.5.
fn on_slope(ratio: f64, start: &str, damping: &str) -> (Scene, f64) {
    let angle = 0.5_f64.atan() * ratio;
    let gravity = [-GRAVITY * angle.sin(), -GRAVITY * angle.cos()];
    let scene = Scene::new(0.1, gravity, start, attitudes()[2]).on_floor();
    let scene = scene.body("a", &cuboid(BLOCK), [0.0, 0.0, 0.5 * BLOCK[2]], 0.0, "");
    let scene = scene.contact("c", ["a", "floor"], &format!("friction = 0.5\n{damping}"));
    (scene, angle)
}

#[test]
fn a_block_on_a_slope_rests_or_slides_by_the_angle_of_friction() {
    let (scene, _) = on_slope(0.9, AT_REST, "");
    let way = moved(&scene.run(), 0);
    assert!(way < 1e-6, "{way:e}");
    // Set down without weight it bounces once; later half of the time.
    let (scene, angle) = on_slope(1.1, "", "damping = 1000.0");
    let found = scene.run();
    let samples = &found.samples;
    let half = samples.iter().find(|sample| sample.time >= 0.05).unwrap();
    let speed = |sample: &Sample| -scene.seen(sample.bodies[0].velocity).x;
    let acceleration = (speed(last(&found)) - speed(half)) / (last(&found).time - half.time);
    close("sliding", acceleration, GRAVITY * (angle.sin() - 0.5 * angle.cos()), 5e-3);
}

/// Angular velocity of a body that turns about an edge at the distance `arm` from its centre, which stands at the angle `lean` from
/// the vertical, from rest; `squared`: radius of inertia about the edge [rad/s].
fn tipped(arm: f64, lean: f64, squared: f64, time: f64) -> f64 {
    let (mut lean, mut rate) = (lean, 0.0);
    let n = 10_000;
    let step = time / f64::from(n);
    for _ in 0..n {
        // Midpoint rule.
        let (angle, middle) =
            (lean + 0.5 * step * rate, rate + 0.5 * step * GRAVITY * arm * lean.sin() / squared);
        rate += step * GRAVITY * arm * angle.sin() / squared;
        lean += step * middle;
    }
    rate
}

#[test]
fn a_block_tips_over_its_edge_as_a_rigid_body_does() {
    // On an edge of its own over a floor; on that of a block under it, which its face lies on.
    let (wide, high) = (0.1_f64, 0.2_f64);
    let (arm, tilt) = (0.5 * wide.hypot(high), 0.6);
    let lean = tilt - wide.atan2(high);
    let place = [arm * lean.sin(), 0.0, arm * lean.cos()];
    let more = "friction = 1.0\ndamping = 1000.0";
    let squared = arm * arm * 4.0 / 3.0;
    for attitude in [attitudes()[0], attitudes()[2]] {
        let scene = Scene::new(0.15, [0.0, -GRAVITY], "", attitude).on_floor();
        let scene = scene.body("a", &cuboid([wide, 0.08, high]), place, tilt, "");
        let scene = scene.contact("c", ["a", "floor"], more);
        let found = scene.run();
        // What the springs of the edge yield by, 1e-4 of the arm, and the first bounce.
        let rate = scene.seen(last(&found).bodies[0].angular_velocity).y;
        close("on its edge", rate, tipped(arm, lean, squared, 0.15), 5e-3);
    }
}

/// As it tips, its side turns to the floor at 6 degrees: the points that it has on the edge were pressed from then on, and brought energy.
#[test]
fn a_side_that_turns_to_the_floor_brings_no_energy() {
    let (wide, high, tilt) = (0.1_f64, 0.2_f64, 0.06_f64);
    let lean = tilt - wide.atan2(high);
    let arm = 0.5 * wide.hypot(high);
    // Over its edge, about which it turns.
    let place = [arm * lean.sin(), 0.0, arm * lean.cos()];
    let more = format!(
        "angular_velocity = [0.0, 2.0, 0.0]\nvelocity = [{:?}, 0.0, {:?}]",
        2.0 * arm * lean.cos(),
        -2.0 * arm * lean.sin()
    );
    let scene = Scene::new(0.05, [0.0, -GRAVITY], "", attitudes()[0]).on_floor();
    let scene = scene.body("a", &cuboid([wide, 0.08, high]), place, tilt, &more);
    let found = scene.contact("c", ["a", "floor"], "friction = 1.0").run();
    let turned = last(&found).bodies[0].rotation;
    assert!(2.0 * turned[2].atan2(turned[0]) > 0.11, "{turned:?}");
    // What steps are allowed to err by, each; they brought 1e-3 together.
    assert!(found.energy_drift() < 1e-6, "{:e}", found.energy_drift());
}

#[test]
fn springs_are_those_given_or_follow_from_weight_and_approach() {
    let [x, y, z] = BLOCK;
    let drop = |speed: f64, more: &str, start: &str| {
        let scene = Scene::new(2e-3, [0.0, -GRAVITY], start, UnitQuaternion::identity()).on_floor();
        let velocity = format!("velocity = [0.0, 0.0, {:?}]", -speed);
        let place = [0.0, 0.0, 0.5 * z + if speed > 0.0 { 1e-6 } else { 0.0 }];
        scene.body("a", &cuboid(BLOCK), place, 0.0, &velocity).contact("c", ["a", "floor"], more).run()
    };
    let deepest = |found: &Recording| {
        found.samples.iter().map(|sample| sample.contacts[0].penetration).fold(0.0, f64::max)
    };
    let shadow = 0.5 * (x * y + y * z + z * x);
    // Eq. C.100: a hundred-thousandth of the least extent on the mean shadow.
    let found = drop(0.0, "", AT_REST);
    close("at rest", deepest(&found), 1e-5 * z * shadow / (x * y), 1e-5);
    let found = drop(0.0, "penalty = { initial = 1.0e9 }", AT_REST);
    close("as given", deepest(&found), mass(BLOCK) * GRAVITY / (1e9 * x * y), 1e-6);
    // A thousandth in an impact; the weight, 3e-4 of the force, and stored instants beside the peak.
    let found = drop(1.0, "", "");
    close("in an impact", deepest(&found), 1e-3 * z * (shadow / (x * y)).sqrt(), 5e-3);
    let [impact] = &found.impacts[..] else { panic!("{} impacts", found.impacts.len()) };
    close("restitution", impact.restitution, 1.0, 1e-3);
}

#[test]
fn free_blocks_keep_their_momenta_and_exchange_their_roles() {
    let run = |roles: [&str; 2]| {
        // Steps that err by a tenth of what the ledger is allowed below.
        let scene = Scene::new(2e-3, [0.0, 0.0], "impact = { rtol = 1e-9 }", attitudes()[2]);
        let scene = scene.body("low", &cuboid([0.12, 0.12, 0.05]), [0.0; 3], 0.0, "");
        // On its lower edge, beside the middle.
        let place = [0.02, 0.01, 0.0689];
        let velocity = scene.attitude * Vector3::new(0.2, 0.0, -1.0);
        let velocity = format!("velocity = {}", list(velocity));
        let scene = scene.body("high", &cuboid(BLOCK), place, 0.3, &velocity);
        scene.contact("c", roles, "friction = 0.2").run()
    };
    let found = run(["high", "low"]);
    let (first, end) = (&found.samples[0], last(&found));
    let scale = mass(BLOCK);
    for (what, start, end) in [
        ("momentum", first.linear_momentum, end.linear_momentum),
        ("moment of momentum", first.angular_momentum, end.angular_momentum),
    ] {
        let change = (Vector3::from(start) - Vector3::from(end)).norm() / scale;
        assert!(change < 1e-10, "{what}: {change:e}");
    }
    assert!(found.energy_drift() < 1e-6, "{:e}", found.energy_drift());
    let parted = |recording: &Recording, body: usize| Vector3::from(last(recording).bodies[body].velocity);
    assert!((parted(&found, 1) - Vector3::from(first.bodies[1].velocity)).norm() > 0.1, "they have met");
    let mirrored = run(["low", "high"]);
    for body in [0, 1] {
        let change = (parted(&found, body) - parted(&mirrored, body)).norm();
        // The factor follows from the surface of the contact body: 1.5 times as stiff.
        assert!(change < 2e-2, "{body}: {change:e}");
    }
}

/// A ball of 20 mm that rolls over two flush plates at 0.5 m/s, from `start`.
fn over_a_seam(start: f64, end: f64) -> Recording {
    let plate = |name: &str, x: f64| {
        format!(
            "[bodies.{name}]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"box\", size = [0.2, 0.2, 0.02] }}\n\
             [joints.{name}]\ntype = \"fixed\"\nparent = {{ body = \"ground\", point = [{x:?}, 0.0, -0.01] }}\n\
             child = {{ body = \"{name}\", point = [0.0, 0.0, 0.0] }}\n\
             [contacts.{name}]\ncontact_body = \"ball\"\ntarget_body = \"{name}\"\nmodel = \"hertz\"\nfriction = 0.5\n"
        )
    };
    let (one, two) = (plate("first", -0.1), plate("second", 0.1));
    run_text(&format!(
        "[simulation]\nend_time = {end:?}\ngravity = [0.0, 0.0, -9.81]\n[bodies.ball]\nmodel = \"rigid\"\nmaterial = \"steel\"\n\
         geometry = {{ shape = \"sphere\", radius = 0.02 }}\nposition = [{start:?}, 0.0, 0.02]\nvelocity = [0.5, 0.0, 0.0]\n\
         angular_velocity = [0.0, 25.0, 0.0]\n{one}{two}"
    ))
}

#[test]
fn a_ball_rolls_on_the_face_of_a_box_and_over_a_seam() {
    // Far from the seam the second plate bears nothing.
    let found = over_a_seam(-0.01, 2e-3);
    assert!(found.samples.iter().all(|sample| sample.contacts[1].normal_force == 0.0));
    assert!(found.samples.iter().any(|sample| sample.contacts[0].normal_force > 0.0));
    // Over the seam it goes on as before: what falls between the plates is (0.1 mm)² / R.
    let found = over_a_seam(-2e-4, 1e-3);
    let ball = &last(&found).bodies[0];
    close("speed", ball.velocity[0], 0.5, 1e-4);
    let pressed = |i: usize| found.samples.iter().any(|sample| sample.contacts[i].normal_force > 0.0);
    assert!(pressed(0) && pressed(1));
}

#[test]
fn what_rigid_points_do_not_go_with_is_told() {
    let scene = |geometry: &str, more: &str| {
        let scene = Scene::new(1e-3, [0.0, -GRAVITY], "", UnitQuaternion::identity()).on_floor();
        scene.body("a", geometry, [0.0, 0.0, 0.1], 0.0, "").contact("c", ["a", "floor"], more).text
    };
    let block = scene(&cuboid(BLOCK), "");
    let adaptive = faults(&block.replace("\"coarse\"", "\"adaptive\""));
    assert!(adaptive.contains("contacts.c.model: must be \"coarse\" between rigid bodies"), "{adaptive}");
    let left_out = faults(&block.replace("model = \"coarse\"", ""));
    assert!(left_out.contains("must be \"coarse\""), "{left_out}");
    for key in ["points = \"gauss\"", "interval = { width = 0.01 }"] {
        let told = faults(&scene(&cuboid(BLOCK), key));
        assert!(told.contains("points all over its surface"), "{told}");
    }
    let hertz = faults(&block.replace("\"coarse\"", "\"hertz\""));
    assert!(hertz.contains("of rigid bodies \"coarse\""), "{hertz}");
    let massive = faults(&block.replace(
        &format!("material = \"steel\"\ngeometry = {{ {} }}", cuboid(BLOCK)),
        "mass = 1.0\ninertia = [1.0, 1.0, 1.0]",
    ));
    assert!(massive.contains("has no surface to touch"), "{massive}");
    let flying = block.replace("orientation", "velocity = [0.0, 0.0, -200.0]\norientation");
    let ball = flying.replace(&cuboid(BLOCK), "shape = \"sphere\", radius = 0.02");
    let told = refusal(&valid(Path::new("."), &ball, &[]));
    assert!(told.contains("choose model = \"hertz\""), "{told}");
}

#[test]
fn results_of_rigid_points_are_looked_at_again() {
    let (scene, _) = on_slope(0.9, AT_REST, "");
    let folder = folder("rigid_points");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    std::fs::write(path("slope.toml"), scene.text.replace("end_time = 0.1", "end_time = 1e-3")).unwrap();
    let (file, result) = (path("slope.toml"), path("slope.h5"));
    let shown = path("shown");
    for arguments in [
        vec!["check", "-q", &file],
        vec!["run", "-q", &file, "-o", &result],
        vec!["report", "-q", &result, "-o", &path("slope.html")],
        vec!["export", "-q", "--vtk", &shown, &result],
        vec!["info", &result],
    ] {
        let (code, _, said) = fbimpact(&arguments);
        assert!(code == 0 && !said.contains("left out"), "{arguments:?}: {said}");
    }
}
