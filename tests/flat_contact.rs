//! Contact of flat faces, edges, rims and corners with the defaults: closed forms of St-Venant, of the bouncing bar, of rigid impacts
//! with rotation, and identities.

#![expect(clippy::unwrap_used, reason = "a failure here fails the test")]
#![expect(clippy::print_stdout, reason = "the figures of docs/verification.md, shown with --nocapture")]

use std::path::Path;

use adaptive::model::start_poses;
use adaptive::predicted_touch::{TouchKind, touch_kind};
use adaptive::record::{ImpactRecord, Sample};
use adaptive::recording::Recording;
use adaptive::warning::WarningKind;
use fbimpact::scenario;
use fbimpact::simulate::simulate;
use nalgebra::{Rotation3, Vector3};

/// Radius \[m\], length \[m\], modulus \[Pa\] and density [kg/m³] of the rods.
const RADIUS: f64 = 1e-3;
const LENGTH: f64 = 0.2;
const YOUNG: f64 = 210e9;
const DENSITY: f64 = 7850.0;
/// Modes of a rod that is so thin that all of them are axial.
const MODES: usize = 60;

fn run(text: &str) -> Recording {
    let scenario = scenario::parse(Path::new("case.toml"), text.as_bytes(), &[]).unwrap();
    let mut recording = Recording::default();
    simulate(&scenario, &mut recording, 1).unwrap();
    recording
}

fn wave_speed() -> f64 {
    (YOUNG / DENSITY).sqrt()
}

/// Time of a wave through a rod and back \[s\].
fn round_trip() -> f64 {
    2.0 * LENGTH / wave_speed()
}

/// Force between a rod and what does not yield, at 1 m/s \[N\].
fn impedance() -> f64 {
    std::f64::consts::PI * RADIUS * RADIUS * (YOUNG * DENSITY).sqrt()
}

const STEEL: &str = r#"
    [materials.steel]
    youngs_modulus = 210e9
    poissons_ratio = 0.0
    density = 7850.0
"#;

/// A rod with its lower end at `z`.
fn rod(name: &str, z: f64, speed: f64) -> String {
    format!(
        r#"
        [bodies.{name}]
        model = "axisymmetric"
        material = "steel"
        geometry = {{ shape = "rod", radius = {RADIUS}, length = {LENGTH} }}
        position = [0.0, 0.0, {z:e}]
        velocity = [0.0, 0.0, {speed}]
        reduction = {{ modes = {MODES} }}
        discretisation = {{ degree = 3, elements = [1, 130] }}
    "#
    )
}

const FLOOR: &str = r#"
    [bodies.floor]
    model = "rigid"
    geometry = { shape = "plane" }
    normal = [0.0, 0.0, 1.0]
"#;

fn contact(body: &str, target: &str) -> String {
    format!("[contacts.c]\ncontact_body = \"{body}\"\ntarget_body = \"{target}\"\n")
}

/// First and last time at which the force is above `level`, on straight lines between samples \[s\].
fn above(recording: &Recording, level: f64) -> [f64; 2] {
    let force = |s: &Sample| s.contacts[0].normal_force;
    let crossing =
        |a: &Sample, b: &Sample| a.time + (level - force(a)) / (force(b) - force(a)) * (b.time - a.time);
    let pairs =
        || recording.samples.windows(2).filter(|w| (force(&w[0]) - level) * (force(&w[1]) - level) < 0.0);
    let (first, last) = (pairs().next().unwrap(), pairs().next_back().unwrap());
    [crossing(&first[0], &first[1]), crossing(&last[0], &last[1])]
}

/// Mean of the force from `from` to `to` \[N\].
fn mean_force(recording: &Recording, from: f64, to: f64) -> f64 {
    let inside = recording.samples.windows(2).filter(|w| w[0].time >= from && w[1].time <= to);
    let (mut sum, mut time) = (0.0, 0.0);
    for w in inside {
        let h = w[1].time - w[0].time;
        sum += 0.5 * h * (w[0].contacts[0].normal_force + w[1].contacts[0].normal_force);
        time += h;
    }
    sum / time
}

/// The ledger is closed to what the integrator's tolerance of 1e-6 a step leaves, and no momentum appears.
fn check_ledger(name: &str, recording: &Recording) {
    let drift = recording.energy_drift();
    println!("{name}: ledger {drift:.1e}");
    assert!(drift < 1e-5, "{name}: {drift:e}");
}

/// Product of the highest frequency kept of the first body and the time of a wave.
fn cycles(recording: &Recording) -> f64 {
    let frequencies = &recording.layout.bodies[0].eigenfrequencies;
    frequencies.last().unwrap() * round_trip()
}

/// Modes beyond the `n` axial ones would carry the share `2/(pi^2 n)` of the energy of a step of the velocity: half of it is the most that
/// can be missing in the velocity of separation.
fn most_lost(n: f64) -> f64 {
    1.0 / (std::f64::consts::PI.powi(2) * n)
}

/// What touches first of the bodies of `text`.
fn kind(text: &str) -> Option<TouchKind> {
    let scenario = scenario::parse(Path::new("case.toml"), text.as_bytes(), &[]).unwrap();
    let spec = &scenario.run;
    touch_kind(spec, &spec.contacts[0], &start_poses(spec).unwrap())
}

/// A solid of steel, `shape` its geometry, that stands at the height `z` turned by the rotation vector `turn` \[degrees\] and falls on the floor.
fn falling(shape: &str, z: f64, turn: [f64; 3], more: &str) -> String {
    format!(
        r#"
        [simulation]
        end_time = 1.0e-2
        {STEEL}
        [bodies.part]
        model = "solid"
        material = "steel"
        geometry = {{ {shape} }}
        position = [0.0, 0.0, {z}]
        orientation_deg = [{}, {}, {}]
        velocity = [0.0, 0.0, -10.0]
        {more}
        {FLOOR}
        {}
    "#,
        turn[0],
        turn[1],
        turn[2],
        contact("part", "floor")
    )
}

#[test]
fn what_touches_first_is_known_from_shapes_and_motions() {
    let (cube, cylinder) = (
        r#"shape = "box", size = [0.02, 0.02, 0.02]"#,
        r#"shape = "cylinder", radius = 0.01, length = 0.03"#,
    );
    let ball = r#"shape = "sphere", radius = 0.01"#;
    let cases = [
        ("box on its face", falling(cube, 0.02, [0.0; 3], ""), TouchKind::Flat),
        ("box on its edge", falling(cube, 0.02, [20.0, 0.0, 0.0], ""), TouchKind::Edge),
        ("box on its corner", falling(cube, 0.02, [20.0, 30.0, 0.0], ""), TouchKind::Edge),
        ("cylinder on its end", falling(cylinder, 0.01, [0.0; 3], ""), TouchKind::Flat),
        ("cylinder on its rim", falling(cylinder, 0.03, [0.0, 30.0, 0.0], ""), TouchKind::Edge),
        ("ball", falling(ball, 0.02, [0.0; 3], ""), TouchKind::Smooth),
        // Flat at the start, turned by some 20 degrees at the touch.
        (
            "box that turns",
            falling(cube, 0.02, [0.0; 3], "angular_velocity = [0.0, 500.0, 0.0]"),
            TouchKind::Edge,
        ),
    ];
    for (name, text, wanted) in cases {
        assert_eq!(kind(&text), Some(wanted), "{name}");
    }
    // The edge of a box has points along it, the face below it has none where a corner or another edge passes.
    let boxes = |turns: [[f64; 3]; 2], pair: [&str; 2]| {
        let cube = |name: &str, z: f64, turn: [f64; 3], speed: f64| {
            format!(
                "[bodies.{name}]\nmodel = \"solid\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"box\", size = [0.02, 0.02, 0.02] }}\n\
                 position = [0.0, 0.0, {z}]\norientation_deg = {turn:?}\nvelocity = [0.0, 0.0, {speed}]\n"
            )
        };
        let (upper, lower) = (cube("upper", 0.04, turns[0], -1.0), cube("lower", 0.0, turns[1], 0.0));
        format!("[simulation]\nend_time = 1.0\n{STEEL}{upper}{lower}{}", contact(pair[0], pair[1]))
    };
    let (flat, along, across) = ([0.0; 3], [30.0, 0.0, 0.0], [0.0, 30.0, 0.0]);
    let (down, up) = (["upper", "lower"], ["lower", "upper"]);
    assert_eq!(kind(&boxes([flat, flat], down)), Some(TouchKind::Flat));
    assert_eq!(kind(&boxes([along, flat], down)), Some(TouchKind::Edge));
    assert_eq!(kind(&boxes([along, flat], up)), Some(TouchKind::BetweenPoints));
    assert_eq!(kind(&boxes([along, across], down)), Some(TouchKind::BetweenPoints));
    // Jackets of four faces whose nets are singular where they meet.
    let crossed = |gap: f64| {
        let cylinder = |name: &str, radius: f64, half: f64, at: [f64; 3], turn: [f64; 3], speed: f64| {
            let length = 2.0 * half;
            format!(
                "[bodies.{name}]\nmodel = \"solid\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"cylinder\", radius = {radius}, length = {length} }}\n\
                 position = {at:?}\norientation_deg = {turn:?}\nvelocity = [0.0, 0.0, {speed}]\n"
            )
        };
        let small = cylinder("small", 0.01, 0.015, [-0.015, 0.0, 0.06 + gap], [0.0, 90.0, 0.0], -0.1);
        let big = cylinder("big", 0.05, 0.03, [0.0, 0.03, 0.0], [90.0, 0.0, 0.0], 0.0);
        format!("[simulation]\nend_time = 1.0e-2\n{STEEL}{small}{big}{}", contact("small", "big"))
    };
    for gap in [1e-4, 0.0] {
        assert_eq!(kind(&crossed(gap)), Some(TouchKind::Smooth), "crossed cylinders {gap} apart");
    }
    // Apart and touching, from above and below.
    for gap in [1e-3, 1e-8, 0.0] {
        let rods = format!("{STEEL}{}{}", rod("one", -LENGTH - gap, 1.0), rod("two", 0.0, 0.0));
        for (body, target) in [("one", "two"), ("two", "one")] {
            let text = format!("[simulation]\nend_time = 1.0e-2\n{rods}{}", contact(body, target));
            assert_eq!(kind(&text), Some(TouchKind::Flat), "{gap} {body}");
        }
    }
    // Bodies that do not meet say nothing.
    let apart = format!("{STEEL}{}{}", rod("one", -LENGTH - 1e-3, -1.0), rod("two", 0.0, 0.0));
    assert_eq!(kind(&format!("[simulation]\nend_time = 1.0e-4\n{apart}{}", contact("one", "two"))), None);
}

#[test]
fn equal_rods_exchange_their_velocities_by_a_rectangular_pulse_with_the_defaults() {
    let recording = run(include_str!("../scenarios/flat_rods.toml"));
    let (impact, n, plateau) = (recording.impacts[0], cycles(&recording), 0.5 * impedance());
    let [start, end] = above(&recording, 0.5 * plateau);
    let duration = (end - start) / round_trip() - 1.0;
    let middle = 0.5 * (start + end);
    let force =
        mean_force(&recording, middle - 0.25 * (end - start), middle + 0.25 * (end - start)) / plateau - 1.0;
    println!(
        "rods, f T = {n:.1}: force {force:+.2e}, duration {duration:+.2e}, restitution {:.5}",
        impact.restitution
    );
    // The ripple of the last mode over half of its periods in the mean, a tenth of one of them.
    assert!(force.abs() < 1e-2, "{force:e}");
    // Rise and fall are alike but for what rings: less than half a period of the last mode.
    assert!(duration.abs() < 0.5 / n, "{duration:e}");
    assert!((impact.restitution - 1.0).abs() < most_lost(n), "{}", impact.restitution);
    assert!(recording.warnings.is_empty(), "{:?}", recording.warnings);
    // The overshoot of a step that is cut off above f and rises within 1/(2 f).
    assert!(impact.peak_force < 1.1 * plateau, "{}", impact.peak_force);
    check_ledger("rods", &recording);
    let first = recording.samples[0].linear_momentum[2];
    // A thousand steps of sums over two bodies.
    assert!(recording.samples.iter().all(|s| (s.linear_momentum[2] / first - 1.0).abs() < 1e-12));
}

#[test]
fn a_rigid_mass_leaves_a_rod_as_st_venant_has_it() {
    for ratio in [0.25, 1.0, 4.0] {
        // A disc a thousand times stiffer, `ratio` times as heavy as the rod.
        let disc = format!(
            r#"
            [materials.hard]
            youngs_modulus = 210e12
            poissons_ratio = 0.0
            density = {}
            [bodies.disc]
            model = "axisymmetric"
            material = "hard"
            geometry = {{ shape = "rod", radius = {RADIUS}, length = 0.01 }}
            position = [0.0, 0.0, {}]
            velocity = [0.0, 0.0, 1.0]
            reduction = {{ modes = 2 }}
            discretisation = {{ degree = 3, elements = [1, 2] }}
        "#,
            DENSITY * ratio * LENGTH / 0.01,
            -0.01 - 1e-6
        );
        let world = "[simulation]\nend_time = 1.0e-4\n";
        let recording =
            run(&format!("{world}{STEEL}{disc}{}{}", rod("two", 0.0, 0.0), contact("disc", "two")));
        let frequencies = &recording.layout.bodies[1].eigenfrequencies;
        let n = frequencies.last().unwrap() * round_trip();
        let mass = DENSITY * LENGTH * std::f64::consts::PI * RADIUS * RADIUS;
        // The wave comes back after 2L/c and pulls the rod away.
        let wanted = ratio * mass * (1.0 - (-2.0 / ratio).exp());
        let impulse = recording.impacts[0].impulse / wanted - 1.0;
        println!("mass ratio {ratio}, f T = {n:.1}: impulse {impulse:+.2e}");
        // What the force is worth during 1/f at the end, by which an impact is late, and what rings.
        assert!(impulse.abs() < 1e-2, "{ratio}: {impulse:e}");
        check_ledger("mass on rod", &recording);
    }
}

#[test]
fn a_bar_bounces_on_its_flat_end_with_its_period() {
    // Doyen, Ern and Piperno 2011: the fall takes three times L/c, each impact two, and after two impacts all is as before.
    let fall = 1.5 * round_trip();
    let (gravity, height) = (1.0 / fall, 0.5 * fall);
    let settings = format!("[simulation]\nend_time = {}\ngravity = [0.0, 0.0, {}]\n", 11.0 * fall, -gravity);
    let bar = rod("bar", height, 0.0);
    let recording = run(&format!("{settings}{STEEL}{bar}{FLOOR}{}", contact("bar", "floor")));
    let (impacts, n) = (&recording.impacts, cycles(&recording));
    let period = (impacts[2].start - impacts[0].start) / (8.0 * round_trip()) - 1.0;
    println!("bar, f T = {n:.1}: period {period:+.2e}");
    // Each of the two impacts ends 1/f late; what rings takes less than its share of the velocity, and of the time of flight.
    assert!(period.abs() < 0.25 / n + most_lost(n), "{period:e}");
    // The bar starts at rest: what its fall gives it is the energy to compare with.
    let total = |s: &Sample| s.energies.total();
    let given = recording.samples.iter().map(|s| s.energies.kinetic).fold(0.0, f64::max);
    let start = total(&recording.samples[0]);
    let drift = recording.samples.iter().map(|s| (total(s) - start).abs() / given).fold(0.0, f64::max);
    println!("bar: ledger {drift:.1e}");
    assert!(drift < 1e-5, "{drift:e}");
}

/// A steel block of 20 mm, turned by the rotation vector `turn`, that falls flat on the floor at 0.1 m/s.
fn block(turn: [f64; 3], end_time: f64) -> (Recording, Vector3<f64>) {
    let rotation = Rotation3::from_scaled_axis(Vector3::from(turn));
    let corner = |k: usize| Vector3::from([0, 1, 2].map(|d| if k >> d & 1 == 1 { 0.01 } else { -0.01 }));
    let places: Vec<Vector3<f64>> = (0..8).map(|k| rotation * corner(k)).collect();
    let height = places.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let touching: Vec<_> = places.iter().filter(|p| p.z < height + 1e-9).collect();
    let lowest = touching.iter().copied().sum::<Vector3<f64>>() / touching.len() as f64;
    let text = format!(
        r#"
        [simulation]
        end_time = {end_time}
        [materials.steel]
        youngs_modulus = 210e9
        poissons_ratio = 0.3
        density = 7850.0
        [bodies.block]
        model = "solid"
        material = "steel"
        geometry = {{ shape = "box", size = [0.02, 0.02, 0.02] }}
        position = [0.0, 0.0, {}]
        orientation = [{}, {}, {}]
        velocity = [0.0, 0.0, -0.1]
        reduction = {{ modes = 20 }}
        discretisation = {{ degree = 2, elements = 2 }}
        {FLOOR}
        {}
    "#,
        1e-7 - lowest.z,
        turn[0],
        turn[1],
        turn[2],
        contact("block", "floor")
    );
    (run(&text), lowest)
}

/// Velocity of the centre of mass after a frictionless impact of the restitution `e` at the place of contact, over that before: the impulse
/// acts at `arm` from it.
fn rigid_rebound(arm: &Vector3<f64>, e: f64) -> f64 {
    // Inertia of a cube with edge a over its mass: a^2/6 about every axis.
    let inertia = 0.02_f64.powi(2) / 6.0;
    let lever = arm.cross(&Vector3::z());
    (1.0 + e) / (1.0 + lever.norm_squared() / inertia) - 1.0
}

fn check_frictionless(name: &str, recording: &Recording) {
    let (first, scale) = (&recording.samples[0], 0.02_f64.powi(3) * DENSITY * 0.1);
    for sample in &recording.samples {
        let sideways = [0, 1].map(|d| (sample.linear_momentum[d] - first.linear_momentum[d]).abs());
        let spin = (sample.angular_momentum[2] - first.angular_momentum[2]).abs() / 0.01;
        let sideways = sideways.into_iter().fold(0.0, f64::max) / scale;
        // A plane without friction pushes along its normal alone: round-off of a thousand evaluations. Angular momentum of a body that
        // turns is kept to the tolerance of the integrator, of the small angle by which it does so.
        assert!(sideways < 1e-12 && spin / scale < 1e-9, "{name}: {sideways:e}, {:e}", spin / scale);
    }
    check_ledger(name, recording);
}

fn momentum_balance(recording: &Recording) -> f64 {
    let (first, last) = (&recording.samples[0], recording.samples.last().unwrap());
    let impulse: f64 = recording.impacts.iter().map(|i: &ImpactRecord| i.impulse).sum();
    (last.linear_momentum[2] - first.linear_momentum[2]) / impulse - 1.0
}

#[test]
fn blocks_fall_on_edges_and_corners_and_turn_as_rigid_bodies_do() {
    for (name, turn) in [("edge", [0.0, 0.35, 0.0]), ("corner", [0.6, 0.35, 0.0])] {
        let (recording, arm) = block(turn, 1.5e-4);
        let velocity =
            recording.samples.last().unwrap().linear_momentum[2] / (0.02_f64.powi(3) * DENSITY * 0.1);
        let e = recording.impacts[0].restitution;
        let wanted = rigid_rebound(&arm, e);
        println!("block on its {name}: restitution {e:.4}, rebound {velocity:+.5}, closed {wanted:+.5}");
        // The force acts at an edge or a corner that moves by less than a thousandth of the body's size, and in its neighbourhood.
        assert!((velocity - wanted).abs() < 1e-2, "{name}: {velocity} {wanted}");
        // Little is left to vibrations by an impact that lasts longer than the lowest of them.
        assert!(e > 0.95 && e < 1.001, "{name}: {e}");
        // Impulses are sums over steps that are noted.
        assert!(momentum_balance(&recording).abs() < 1e-3);
        assert!(recording.warnings.iter().any(|w| w.kind == WarningKind::EdgeTouch), "{name}");
        check_frictionless(name, &recording);
    }
}

#[test]
fn a_block_falls_on_its_face() {
    let (recording, _) = block([0.0; 3], 3e-5);
    println!("block on its face: restitution {:.4}", recording.impacts[0].restitution);
    assert_eq!(recording.impacts.len(), 1);
    assert!(momentum_balance(&recording).abs() < 1e-3);
    assert!(recording.warnings.iter().all(|w| w.kind != WarningKind::EdgeTouch));
    // Twenty modes cannot follow a force that rises within their highest period's half.
    assert!(recording.warnings.iter().any(|w| w.kind == WarningKind::SlowRise));
    check_frictionless("face", &recording);
}

#[test]
fn blocks_that_meet_with_faces_and_edges_keep_their_momenta() {
    let cube = |name: &str, z: f64, turn: f64, speed: f64| {
        format!(
            "[bodies.{name}]\nmodel = \"solid\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"box\", size = [0.02, 0.02, 0.02] }}\n\
             position = [0.0, 0.0, {z}]\norientation = [{turn}, 0.0, 0.0]\nvelocity = [0.0, 0.0, {speed}]\n\
             reduction = {{ modes = 20 }}\ndiscretisation = {{ degree = 2, elements = 2 }}\n"
        )
    };
    for (name, turn) in [("face on face", 0.0_f64), ("edge on face", 0.35)] {
        let height = 0.01 * (1.0 + turn.cos() + turn.sin()) + 1e-7;
        let steel = STEEL.replace("poissons_ratio = 0.0", "poissons_ratio = 0.3");
        let bodies = format!("{}{}", cube("upper", height, turn, -0.1), cube("lower", 0.0, 0.0, 0.0));
        let recording =
            run(&format!("[simulation]\nend_time = 4.0e-5\n{steel}{bodies}{}", contact("upper", "lower")));
        assert_eq!(recording.impacts.len(), 1, "{name}");
        let first = &recording.samples[0];
        let scale = first.linear_momentum[2].abs();
        for sample in &recording.samples {
            let change = |now: &[f64; 3], start: &[f64; 3]| {
                now.iter().zip(start).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()))
            };
            let linear = change(&sample.linear_momentum, &first.linear_momentum) / scale;
            // Forces are equal and opposite, at the same points: round-off of a thousand evaluations. Angular momentum has the
            // tolerance of the integrator of the small angle by which the bodies turn.
            let angular = change(&sample.angular_momentum, &first.angular_momentum) / (scale * 0.01);
            assert!(linear < 1e-12 && angular < 1e-9, "{name}: {linear:e} {angular:e}");
        }
        check_ledger(name, &recording);
    }
}

/// `text` of a rod that [`rod`] makes, on a guide along its axis.
fn guided(text: &str, name: &str, z: f64, speed: f64) -> String {
    let keys = |line: &&str| {
        !line.trim_start().starts_with("position") && !line.trim_start().starts_with("velocity")
    };
    let free: Vec<&str> = text.lines().filter(keys).collect();
    format!(
        "{}\n[joints.guide]\ntype = \"axial\"\nparent = {{ body = \"ground\", point = [0.0, 0.0, {z:e}] }}\n\
         child = {{ body = \"{name}\", face = \"z-\" }}\nvelocity = {speed}\n",
        free.join("\n")
    )
}

#[test]
fn a_rod_on_a_guide_strikes_as_a_free_one_does() {
    let (gap, n) = (1e-6, MODES as f64);
    let second = rod("second", 0.0, 0.0);
    let first = rod("first", -LENGTH - gap, 1.0);
    let scenario = |first: &str| {
        run(&format!("[simulation]\nend_time = 9.0e-5\n{STEEL}{first}{second}{}", contact("first", "second")))
    };
    let free = scenario(&first);
    let held = scenario(&guided(&first, "first", -LENGTH - gap, 1.0));
    let (a, b) = (free.impacts[0], held.impacts[0]);
    println!(
        "rods, free and on a guide: impulse {:.8e} and {:.8e}, restitution {:.6}",
        a.impulse, b.impulse, b.restitution
    );
    // The guide takes no part: the same motion by other steps before the touch, to the tolerance of 1e-8 a step.
    assert!((b.impulse / a.impulse - 1.0).abs() < 1e-6 && (b.peak_force / a.peak_force - 1.0).abs() < 1e-6);
    assert!(1.0 - b.restitution < most_lost(n * 0.9), "{}", b.restitution);
    check_ledger("guided rod", &held);
}

#[test]
fn a_bar_on_a_hinge_strikes_the_floor_with_its_edge() {
    let text = format!(
        r#"
        [simulation]
        end_time = 1.0e-3
        # Energies between its long steps are those of Gauss collocation to 1e-4 only.
        free.integrator = "dormand-prince"
        {STEEL}
        [bodies.bar]
        model = "solid"
        material = "steel"
        geometry = {{ shape = "box", size = [0.2, 0.02, 0.02] }}
        reduction = {{ modes = 20 }}
        discretisation = {{ degree = 2, elements = [8, 1, 1] }}
        [joints.pivot]
        type = "revolute"
        parent = {{ body = "ground", point = [0.0, 0.0, 0.06] }}
        child = {{ body = "bar", face = "x-" }}
        axis = [0.0, 1.0, 0.0]
        angle_deg = 14.4
        angular_velocity = 5.0
        {FLOOR}
        {}
    "#,
        contact("bar", "floor")
    );
    let recording = run(&text);
    // What bends when an end is struck comes back and strikes again.
    assert!(recording.impacts.len() > 1, "{}", recording.impacts.len());
    let vertical = |s: &Sample| s.contacts[0].force[2] + s.joints[0].reaction_force[2];
    let pairs = || recording.samples.windows(2);
    let sum = |f: &dyn Fn(&Sample) -> f64| -> f64 {
        pairs().map(|w| 0.5 * (w[1].time - w[0].time) * (f(&w[0]) + f(&w[1]))).sum()
    };
    let (first, last) = (&recording.samples[0], recording.samples.last().unwrap());
    let change = last.linear_momentum[2] - first.linear_momentum[2];
    let impulse = sum(&vertical);
    let contact = sum(&|s| s.contacts[0].force[2]);
    println!(
        "bar on a hinge: {} impacts, momentum {change:.6}, impulse {impulse:.6} N s",
        recording.impacts.len()
    );
    // Trapezia over stored states of a force that changes within microseconds.
    assert!((impulse - change).abs() < 1e-2 * contact, "{impulse} {change} {contact}");
    assert!(recording.warnings.iter().any(|w| w.kind == WarningKind::EdgeTouch));
    check_ledger("bar on a hinge", &recording);
}

#[test]
fn a_rod_between_planes_meets_one_with_its_round_and_one_with_its_flat_end() {
    let (length, gap, speed) = (0.1, 5e-5, 0.3);
    let text = format!(
        r#"
        [simulation]
        end_time = 5.0e-4
        {STEEL}
        [bodies.rod]
        model = "axisymmetric"
        material = "steel"
        geometry = {{ shape = "rod-spherical-end", radius = 0.005, length = {length} }}
        position = [0.0, 0.0, 1.0e-6]
        velocity = [0.0, 0.0, -{speed}]
        reduction = {{ modes = 20 }}
        discretisation = {{ degree = 3, elements = [2, 40] }}
        {FLOOR}
        [bodies.ceiling]
        model = "rigid"
        geometry = {{ shape = "plane" }}
        normal = [0.0, 0.0, -1.0]
        position = [0.0, 0.0, {}]
        [contacts.below]
        contact_body = "rod"
        target_body = "floor"
        [contacts.above]
        contact_body = "rod"
        target_body = "ceiling"
    "#,
        length + gap
    );
    let recording = run(&text);
    let contacts: Vec<u32> = recording.impacts.iter().map(|i| i.contact).collect();
    assert!(contacts.starts_with(&[0, 1]), "{contacts:?}");
    // The round end has its own zone, as wide as its contact; the flat one the whole surface.
    let width = |contact: u32| {
        let i = contacts.iter().position(|c| *c == contact).unwrap() as u32;
        recording.trials.iter().rfind(|t| t.impact == i).unwrap().interval_widths[0]
    };
    assert!(width(0) < 1e-3 && width(1) > length, "{} {}", width(0), width(1));
    // Nothing holds the rod between the impacts: each turns its momentum round but for what rings.
    let momentum = |t: f64| {
        let at = recording.samples.iter().rfind(|s| s.time <= t).unwrap();
        at.linear_momentum[2]
    };
    let above = recording.impacts.iter().find(|i| i.contact == 1).unwrap();
    let change = momentum(above.end + 1e-6) - momentum(above.start - 1e-6);
    println!("rod between planes: impulse {:.6e}, change {change:.6e} N s", above.impulse);
    assert!((above.impulse + change).abs() < 1e-3 * above.impulse, "{} {change}", above.impulse);
    check_ledger("rod between planes", &recording);
}

#[test]
fn a_point_between_the_points_of_a_surface_is_not_passed_through_without_a_word() {
    // A block with one element a side over a thin pin: none of its corners and edge points meets the pin's end.
    let text = format!(
        r#"
        [simulation]
        end_time = 1.0e-4
        {STEEL}
        [bodies.block]
        model = "solid"
        material = "steel"
        geometry = {{ shape = "box", size = [0.02, 0.02, 0.02] }}
        position = [0.0, 0.0, 0.010001]
        velocity = [0.0, 0.0, -1.0]
        reduction = {{ modes = 6 }}
        discretisation = {{ degree = 2, elements = 1 }}
        [bodies.pin]
        model = "solid"
        material = "steel"
        geometry = {{ shape = "box", size = [0.001, 0.001, 0.01] }}
        position = [0.004, 0.003, -0.005]
        reduction = {{ modes = 6 }}
        discretisation = {{ degree = 2, elements = [1, 1, 4] }}
        {}
    "#,
        contact("block", "pin")
    );
    let scenario = scenario::parse(Path::new("case.toml"), text.as_bytes(), &[]).unwrap();
    let error = simulate(&scenario, &mut Recording::default(), 1).unwrap_err().to_string();
    assert!(error.contains("exchange contact_body and target_body"), "{error}");
}
