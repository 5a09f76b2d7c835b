//! Friction of bearings by the load that joints transmit, against closed forms (docs/theory.md Eq. M.17 to M.20).

use crate::dynamics_support::{run, with_tolerance};
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::integration::{Integrator, Method, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, Bearing, BodySpec, CoordinateForce, GROUND, GearSpec, JointKind, JointSpec, Multibody,
    SystemSpec, TimeFunction,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const MASS: f64 = 2.0;
/// About the centre of mass, about any axis.
const INERTIA: f64 = 0.03;
const G: f64 = 9.81;
/// What a chain of some tens of operations on doubles may lose.
const ROUNDING: f64 = 1e-13;

const BEARING: Bearing =
    Bearing { coefficient: 0.3, radius: 0.02, length: f64::INFINITY, collar: 0.0, velocity: 1e-3 };

/// A rigid body on a joint to ground, its centre of mass at `centre` from the joint's place.
fn system(
    kind: JointKind,
    bearing: Bearing,
    centre: Vector3<f64>,
    gravity: Vector3<f64>,
    drive: Option<f64>,
) -> Multibody {
    let steiner = Matrix3::identity() * centre.norm_squared() - centre * centre.transpose();
    let inertia = Matrix3::identity() * INERTIA + steiner * MASS;
    let data = StandardInputData::rigid(RigidMotion::Spatial, MASS, centre, inertia).unwrap();
    let marker = || vec![Marker::rigid("a", Vector3::zeros(), UnitQuaternion::identity())];
    let at = |body: &str| Attachment::new(body, "a");
    let drive = drive.map(TimeFunction::constant);
    let coordinates = vec![CoordinateForce { drive, ..CoordinateForce::default() }; kind.n_velocities()];
    let joint = JointSpec {
        coordinates,
        bearing: Some(bearing),
        ..JointSpec::new("bearing", kind, at(GROUND), at("body"))
    };
    let bodies = vec![BodySpec { name: "body".into(), data, markers: marker() }];
    let spec = SystemSpec { bodies, ground: marker(), joints: vec![joint], gravity, ..SystemSpec::default() };
    with_tolerance(Multibody::new(spec, Vec::new()).unwrap())
}

/// Rates of the joint's velocities at `positions` and `velocities`.
fn acceleration(
    system: &mut Multibody,
    positions: &[f64],
    velocities: &[f64],
) -> Result<Vec<f64>, ffr_dynamics::error::EvaluationFailure> {
    let mut y = system.rest();
    system.set_joint(&mut y, 0, positions, velocities).unwrap();
    let mut rates = vec![0.0; y.len()];
    system.rhs(0.0, &y, &mut rates)?;
    Ok(rates[system.model().bodies[0].layout.velocities()].to_vec())
}

/// Gravity on a slope of the inclination `angle`, along z down the slope and against x, its normal.
fn on_slope(angle: f64) -> Vector3<f64> {
    Vector3::new(-G * angle.cos(), 0.0, G * angle.sin())
}

#[test]
fn a_block_slides_down_a_slope_as_coulomb_says() {
    let (angle, speed, time): (f64, f64, f64) = (0.5, 0.7, 0.4);
    let mu = BEARING.coefficient;
    for method in [Method::DormandPrince, Method::Gauss] {
        let mut block = system(JointKind::Prismatic, BEARING, Vector3::zeros(), on_slope(angle), None);
        let exact = G * (angle.sin() - mu * angle.cos() * speed / speed.hypot(BEARING.velocity));
        let found = acceleration(&mut block, &[0.0], &[speed]).unwrap()[0];
        assert!((found - exact).abs() < ROUNDING * G, "{found} {exact}");
        // u²/2v² of the friction is missing, some 1e-6: a = g (sin - μ cos) is exceeded by less.
        let a = G * (angle.sin() - mu * angle.cos());
        let mut y = block.rest();
        block.set_joint(&mut y, 0, &[0.0], &[speed]).unwrap();
        let (y, error) = run(&mut block, method, &y, time);
        let end = block.joint_coordinates(time, &y, 0);
        let missing = 0.5 * mu * G * (BEARING.velocity / speed).powi(2);
        let excess = end.velocities[0] - speed - a * time;
        let limit = error * (speed + a * time);
        assert!(excess > -limit && excess < missing * time + limit, "{method:?} {excess:e}");
        // Energy: weight has gone into motion and friction.
        let energy = block.invariants(time, &y).energy() + block.dissipated_work(&y);
        let start = 0.5 * MASS * speed * speed;
        assert!((energy - start).abs() < 2.0 * error * start.max(block.dissipated_work(&y)), "{energy}");
    }
}

#[test]
fn below_the_angle_of_friction_a_block_stays_but_for_its_creep() {
    let angle: f64 = 0.2;
    let ratio = angle.tan() / BEARING.coefficient;
    let mut block = system(JointKind::Prismatic, BEARING, Vector3::zeros(), on_slope(angle), None);
    let y = block.rest();
    // The time in which the velocity settles is u/(μ g).
    let time = 100.0 * BEARING.velocity / (BEARING.coefficient * G);
    let (y, error) = run(&mut block, Method::DormandPrince, &y, time);
    let creep = block.joint_coordinates(time, &y, 0).velocities[0];
    let exact = BEARING.velocity * ratio / (1.0 - ratio * ratio).sqrt();
    assert!((creep / exact - 1.0).abs() < error, "{creep} {exact}");
}

/// A block that slides on a level guide of the length ℓ with its centre of mass at the height h above it, pulled along the guide with the
/// force `pull`: its supports carry `|m g/2 ± m a h/ℓ|`.
fn tall_block(height: f64, length: f64, pull: f64, coefficient: f64) -> Multibody {
    let bearing = Bearing { coefficient, radius: 0.0, length, ..BEARING };
    let (centre, gravity) = (Vector3::x() * height, Vector3::x() * -G);
    system(JointKind::Prismatic, bearing, centre, gravity, Some(pull))
}

#[test]
fn a_tall_block_presses_its_guide_by_its_own_deceleration() {
    let (height, length, mu, speed): (f64, f64, f64, f64) = (0.3, 0.25, 0.3, 0.5);
    let sigma = mu * speed / speed.hypot(BEARING.velocity);
    let lever = 2.0 * height / length;
    for pull in [0.0, 3.0, 40.0, -60.0] {
        // m a = pull - σ N with N = m max(g, 2 h |a|/ℓ): one of three lines.
        let by_weight = pull / MASS - sigma * G;
        let exact = if lever * by_weight.abs() <= G {
            by_weight
        } else if pull > 0.0 {
            pull / MASS / (1.0 + sigma * lever)
        } else {
            pull / MASS / (1.0 - sigma * lever)
        };
        let mut block = tall_block(height, length, pull, mu);
        let found = acceleration(&mut block, &[0.2], &[speed]).unwrap()[0];
        assert!((found - exact).abs() < ROUNDING * exact.abs().max(G), "{pull}: {found} {exact}");
    }
}

#[test]
fn a_guide_whose_friction_loads_itself_jams_and_says_so() {
    // The load of friction alone is σ 2 h/ℓ of the load: beyond 1 a sliding block has no deceleration, or two (Painlevé).
    let (height, length, mu) = (0.3, 0.25, 0.6);
    let lever = 2.0 * height / length;
    let mut block = tall_block(height, length, 0.0, mu);
    let limit = 1.0 / (mu * lever);
    let slow = BEARING.velocity * limit / (1.0 - limit * limit).sqrt();
    assert!(acceleration(&mut block, &[0.0], &[0.99 * slow]).is_ok());
    let speed: f64 = 0.5;
    let message = acceleration(&mut block, &[0.0], &[speed]).unwrap_err().to_string();
    let gain = mu * lever * speed / speed.hypot(BEARING.velocity);
    assert!(message.contains("\"bearing\" jams") && message.contains(&format!("{gain:.3}")), "{message}");
    // A run ends with it: no step is short enough.
    let mut y = block.rest();
    block.set_joint(&mut y, 0, &[0.0], &[speed]).unwrap();
    let error = match Integrator::new(Method::DormandPrince, StepSettings::default(), 0.0, &y, &block) {
        Ok(mut integrator) => integrator.run(&mut block, 0.1, |_, _| true).unwrap_err(),
        Err(error) => error,
    };
    assert!(error.to_string().contains("jams"), "{error}");
    // At rest it holds: a push beyond its axis that would move it without friction only makes it creep.
    let mut held = tall_block(height, length, 0.3 * mu * MASS * G, mu);
    let y = held.rest();
    let (y, _) = run(&mut held, Method::DormandPrince, &y, 0.5);
    assert!(held.joint_coordinates(0.0, &y, 0).velocities[0] < BEARING.velocity);
}

/// A pendulum about z, its centre of mass at the distance `arm`, weight against y.
fn pendulum(bearing: Bearing, arm: f64) -> Multibody {
    system(JointKind::Revolute, bearing, Vector3::x() * arm, Vector3::y() * -G, None)
}

#[test]
fn friction_of_a_hinge_goes_with_the_pull_of_the_pendulum() {
    let arm = 0.4;
    let inertia = INERTIA + MASS * arm * arm;
    for (angle, rate) in [(-1.5, 3.0), (0.4, -2.5), (2.8, 12.0), (-0.7, 1e-2)] {
        let bearing = Bearing { coefficient: 0.8, radius: 0.05, ..BEARING };
        let slip: f64 = bearing.radius * rate;
        let share = bearing.coefficient * bearing.radius * slip / slip.hypot(bearing.velocity);
        let (sin, cos) = f64::sin_cos(angle);
        let pull = |a: f64| MASS * f64::hypot(-arm * rate * rate + G * sin, arm * a + G * cos);
        let rest = |a: f64| inertia * a + MASS * G * arm * cos + share * pull(a);
        // It grows with the acceleration, for the friction circle is smaller than the arm.
        let (mut low, mut high) = (-1e4, 1e4);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if rest(middle) < 0.0 { low = middle } else { high = middle }
        }
        let mut swing = pendulum(bearing, arm);
        let found = acceleration(&mut swing, &[angle], &[rate]).unwrap()[0];
        let size = pull(low) * arm / inertia;
        assert!((found - low).abs() < ROUNDING * size, "{found} {low}");
    }
}

#[test]
fn a_pendulum_loses_twice_the_angle_of_its_friction_circle_in_every_swing() {
    let (arm, start): (f64, f64) = (0.4, 0.02);
    let inertia = INERTIA + MASS * arm * arm;
    let omega = (MASS * G * arm / inertia).sqrt();
    // The transition is at a thousandth of the largest velocity.
    let ratio = 1e-3;
    let radius = 0.005;
    let bearing = Bearing { coefficient: 0.02, radius, velocity: ratio * radius * omega * start, ..BEARING };
    let circle = bearing.coefficient * bearing.radius / arm; // the weight hangs beside the axis by so much
    for method in [Method::DormandPrince, Method::Gauss] {
        let mut swing = pendulum(bearing, arm);
        let mut y = swing.rest();
        let hanging = -0.5 * std::f64::consts::PI;
        swing.set_joint(&mut y, 0, &[hanging + start], &[0.0]).unwrap();
        let swings = 4;
        // Friction moves the rest position and leaves the period as it is; the circle lengthens it by the square of the angle over 16.
        let time = f64::from(swings) * std::f64::consts::PI / omega * (1.0 + start * start / 16.0);
        let before = swing.invariants(0.0, &y).energy();
        let (y, error) = run(&mut swing, method, &y, time);
        let angle = swing.joint_coordinates(time, &y, 0).positions[0] - hanging;
        let loss = 2.0 * f64::from(swings) * circle;
        // The pull is the weight but for the square of the angle; friction is missing where the pendulum turns back.
        let order = start * start + ratio * ratio * (1.0 / ratio).ln();
        let limit = order * loss + error * start * omega * time;
        assert!((start - angle - loss).abs() < limit, "{method:?} {} {loss} {limit:e}", start - angle);
        let after = swing.invariants(time, &y).energy() + swing.dissipated_work(&y);
        let swinging = 0.5 * MASS * G * arm * start * start;
        assert!((after - before).abs() < 2.0 * error * swinging, "{:e} {error:e}", after - before);
    }
}

#[test]
fn a_collar_and_two_supports_rub_by_what_they_carry() {
    // About a vertical axis: the weight rests on the collar, the centre of mass beside the axis tilts the pin in its supports.
    let (arm, rate) = (0.1, 4.0);
    let bearing = Bearing { length: 0.08, collar: 0.03, ..BEARING };
    let mut wheel = system(JointKind::Revolute, bearing, Vector3::x() * arm, Vector3::z() * -G, None);
    let slip = bearing.radius * rate;
    let sigma = bearing.coefficient * slip / slip.hypot(bearing.velocity);
    let inertia = INERTIA + MASS * arm * arm;
    // Each support carries half of the force across, m (−ω² arm, a arm), and ± m g arm/ℓ along x, as the moment about y asks for.
    let rest = |a: f64| {
        let across = [-0.5 * MASS * rate * rate * arm, 0.5 * MASS * a * arm];
        let couple = MASS * G * arm / bearing.length;
        let supports = f64::hypot(across[0] + couple, across[1]) + f64::hypot(across[0] - couple, across[1]);
        inertia * a + sigma * (bearing.radius * supports + bearing.collar * MASS * G)
    };
    let (mut low, mut high) = (-1e3, 1e3);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if rest(middle) < 0.0 { low = middle } else { high = middle }
    }
    let found = acceleration(&mut wheel, &[0.0], &[rate]).unwrap()[0];
    assert!((found - low).abs() < ROUNDING * G / arm, "{found} {low}");
}

#[test]
fn a_sleeve_brakes_along_its_helix() {
    // With I = m r² mass and inertia resist sliding alike: the helix keeps its lead and the speed along it falls by μ g.
    let radius = (INERTIA / MASS).sqrt();
    let bearing = Bearing { radius, velocity: 1e-6, ..BEARING };
    let mut sleeve = system(JointKind::Cylindrical, bearing, Vector3::zeros(), Vector3::x() * -G, None);
    let mut y = sleeve.rest();
    let (along, about) = (0.6, 0.8 / radius);
    sleeve.set_joint(&mut y, 0, &[0.0, 0.0], &[along, about]).unwrap();
    let time = 0.2;
    let (y, error) = run(&mut sleeve, Method::DormandPrince, &y, time);
    let end = sleeve.joint_coordinates(time, &y, 0).velocities;
    let left = 1.0 - BEARING.coefficient * G * time;
    // u²/2v² of the friction is missing, some 1e-12.
    assert!((end[0] - left * along).abs() < error, "{end:?} {left}");
    assert!((end[1] * radius - left * 0.8).abs() < error, "{end:?} {left}");
    let lost = 0.5 * MASS * (1.0 - left * left);
    assert!((sleeve.dissipated_work(&y) - lost).abs() < 2.0 * error * lost);
}

#[test]
fn a_ball_brakes_about_the_axis_that_it_turns_about() {
    let bearing = Bearing { velocity: 1e-6, ..BEARING };
    let mut ball = system(JointKind::Spherical, bearing, Vector3::zeros(), Vector3::y() * -G, None);
    let axis = Vector3::new(2.0, -1.0, 0.5).normalize();
    let mut y = ball.rest();
    let (speed, time) = (9.0, 0.3);
    ball.set_joint(&mut y, 0, &[1.0, 0.0, 0.0, 0.0], (axis * speed).as_slice()).unwrap();
    let (y, error) = run(&mut ball, Method::DormandPrince, &y, time);
    let end = Vector3::from_column_slice(&ball.joint_coordinates(time, &y, 0).velocities[..3]);
    let left = speed - bearing.coefficient * bearing.radius * MASS * G / INERTIA * time;
    assert!((end - axis * left).norm() < error * speed, "{end} {left}");
}

#[test]
fn a_screw_that_friction_holds_does_not_run_down() {
    // A sleeve with a gear between angle and displacement: the nut's own bearing is pressed by a load across, not by the thread. It runs down
    // as long as the weight's pull along the thread exceeds the friction along it.
    let (radius, lead, across) = (0.02, 0.004, 30.0);
    let bearing = Bearing { coefficient: 0.5, radius, velocity: 1e-5, ..BEARING };
    let nut = |weight: f64| {
        let gravity = Vector3::new(-across / MASS, 0.0, -weight / MASS);
        let data = StandardInputData::rigid(
            RigidMotion::Spatial,
            MASS,
            Vector3::zeros(),
            Matrix3::identity() * INERTIA,
        );
        let marker = || vec![Marker::rigid("a", Vector3::zeros(), UnitQuaternion::identity())];
        let at = |body: &str| Attachment::new(body, "a");
        let joint = JointSpec {
            bearing: Some(bearing),
            ..JointSpec::new("thread", JointKind::Cylindrical, at(GROUND), at("nut"))
        };
        let gear = GearSpec {
            name: "lead".into(),
            first: ("thread".into(), 1),
            second: ("thread".into(), 0),
            ratio: lead,
            offset: 0.0,
        };
        let bodies = vec![BodySpec { name: "nut".into(), data: data.unwrap(), markers: marker() }];
        let spec = SystemSpec {
            bodies,
            ground: marker(),
            joints: vec![joint],
            gears: vec![gear],
            gravity,
            ..SystemSpec::default()
        };
        with_tolerance(Multibody::new(spec, Vec::new()).unwrap())
    };
    // Work for a turn of one radian: weight × lead against μ N √(r² + lead²).
    let friction = bearing.coefficient * across * radius.hypot(lead);
    for (weight, runs) in [(0.8 * friction / lead, false), (1.2 * friction / lead, true)] {
        let mut system = nut(weight);
        let y = system.rest();
        let time = 0.5;
        let (y, error) = run(&mut system, Method::DormandPrince, &y, time);
        let end = system.joint_coordinates(time, &y, 0).velocities;
        // The gear takes away what the weight alone would give, to round-off of it.
        assert!((end[0] - lead * end[1]).abs() < ROUNDING * weight / MASS * time, "{end:?}");
        let slip = f64::hypot(end[0], radius * end[1]);
        if !runs {
            // Settled at a rate of some μ N r²/u (1 - 0.64)^1.5 over the inertia, 4e3/s.
            let exact = bearing.velocity * 0.8 / (1.0_f64 - 0.64).sqrt();
            assert!((slip / exact - 1.0).abs() < error, "{slip} {exact}");
            continue;
        }
        let whole = (weight * lead - friction) / (INERTIA + MASS * lead * lead);
        // Friction is smaller until the velocity has passed the transition: less than the time for that, some 10 u, is gained.
        let gained = -end[1] - whole * time;
        let limit = friction / (INERTIA + MASS * lead * lead) * 10.0 * bearing.velocity / (radius * whole);
        assert!(gained > -error * end[1].abs() && gained < limit, "{gained:e} {limit:e}");
        let energy = system.invariants(time, &y).energy() + system.dissipated_work(&y);
        assert!(energy.abs() < 2.0 * error * system.dissipated_work(&y), "{energy:e}");
    }
}

#[test]
fn friction_is_a_function_of_the_state_to_the_last_bit() {
    let mut swing = pendulum(Bearing { coefficient: 0.8, radius: 0.05, ..BEARING }, 0.4);
    let first = acceleration(&mut swing, &[0.3], &[2.0]).unwrap();
    acceleration(&mut swing, &[-1.0], &[-7.0]).unwrap();
    let again = acceleration(&mut swing, &[0.3], &[2.0]).unwrap();
    assert_eq!(first[0].to_bits(), again[0].to_bits());
}

#[test]
fn impossible_bearings_are_refused_by_name() {
    let refused = |kind: JointKind, bearing: Bearing, closes_loop: bool| {
        let body = |name: &str| {
            let inertia = Matrix3::identity();
            let data =
                StandardInputData::rigid(RigidMotion::Spatial, 1.0, Vector3::zeros(), inertia).unwrap();
            let markers = vec![Marker::rigid("a", Vector3::zeros(), UnitQuaternion::identity())];
            BodySpec { name: name.into(), data, markers }
        };
        let at = |body: &str| Attachment::new(body, "a");
        let joint =
            JointSpec { bearing: Some(bearing), ..JointSpec::new("knee", kind, at(GROUND), at("body")) };
        let ground = body("any").markers;
        let mut spec = SystemSpec { bodies: vec![body("body")], ground, ..SystemSpec::default() };
        if closes_loop {
            spec.loops.push(joint)
        } else {
            spec.joints.push(joint)
        }
        let made = Multibody::<Box<dyn ffr_dynamics::force::active::ActiveForce>>::new(spec, Vec::new());
        made.err().map(|error| error.to_string()).unwrap_or_default()
    };
    for kind in [JointKind::Planar, JointKind::Universal, JointKind::Fixed, JointKind::Free, JointKind::Axial]
    {
        let message = refused(kind, BEARING, false);
        assert!(message.contains("knee") && message.contains("has no bearing"), "{message}");
    }
    let faulty = [
        Bearing { coefficient: -0.1, ..BEARING },
        Bearing { radius: 0.0, ..BEARING },
        Bearing { length: 0.0, ..BEARING },
        Bearing { collar: f64::NAN, ..BEARING },
        Bearing { velocity: 0.0, ..BEARING },
    ];
    for bearing in faulty {
        let message = refused(JointKind::Revolute, bearing, false);
        assert!(message.contains("knee") && message.contains("must be >= 0"), "{message}");
    }
    assert!(refused(JointKind::Revolute, BEARING, true).contains("loop-closing"));
    assert_eq!(refused(JointKind::Prismatic, Bearing { radius: 0.0, ..BEARING }, false), "");
}
