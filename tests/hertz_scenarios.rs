//! Contacts by Hertz's law between surfaces of any curvature, from scenarios: peak forces, refusals, friction.

use std::path::Path;
use std::process::{Command, Output};

use result_files::stored::Stored;
use serde_json::Value;
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");
const MATERIAL: &str = "[materials.m]\nyoungs_modulus = 70e9\npoissons_ratio = 0.3\ndensity = 2700.0\n";

fn call(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(PROGRAM)
        .args(arguments)
        .current_dir(directory)
        .env("FBIMPACT_CACHE", "off")
        .output()
        .expect("the program starts")
}

/// The directory with the scenario `text`.
fn directory(text: &str) -> TempDir {
    let directory = tempfile::tempdir().expect("a temporary directory");
    std::fs::write(directory.path().join("a.toml"), format!("{text}\n{MATERIAL}")).expect("written");
    directory
}

/// First impact and energy ledger of the scenario `text`.
fn run(text: &str) -> (Value, Value) {
    let directory = directory(text);
    let output = call(directory.path(), &["run", "-q", "a.toml"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let info = call(directory.path(), &["info", "--json", "a.h5"]);
    let all: Value = serde_json::from_slice(&info.stdout).expect("JSON");
    (all["impacts"][0].clone(), all)
}

/// What `check` says against the scenario `text`.
fn refusal(text: &str) -> String {
    let directory = directory(text);
    let output = call(directory.path(), &["check", "a.toml"]);
    assert!(!output.status.success(), "accepted");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().expect("a number")
}

/// A rigid cylinder of 10 mm with its axis in the plane of x and y at `angle` from x, `height` over the origin, at `speed` downwards.
fn cylinder(name: &str, angle: f64, height: f64, speed: f64) -> String {
    let (half, quarter) = (0.5 * angle.to_radians(), std::f64::consts::FRAC_PI_4);
    let (s, c) = half.sin_cos();
    let r = quarter.cos();
    // First z to x, then the turn about z.
    let turn = [c * r, -s * r, c * r, s * r];
    let middle = [-0.03 * angle.to_radians().cos(), -0.03 * angle.to_radians().sin(), height];
    format!(
        "[bodies.{name}]\nmodel = \"rigid\"\nmaterial = \"m\"\nposition = {middle:?}\norientation = {turn:?}\n\
         velocity = [0.0, 0.0, {:?}]\ngeometry = {{ shape = \"cylinder\", radius = 0.01, length = 0.06 }}\n",
        -speed
    )
}

fn contact(extra: &str) -> String {
    format!("[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\nmodel = \"hertz\"\n{extra}\n")
}

const SIMULATION: &str = "[simulation]\nend_time = 0.4e-3\n";

/// Peak forces by elliptic integrals of Carlson, root search by bracketing, energy balance of two masses: an independent calculation.
#[test]
fn crossed_cylinders_meet_with_the_force_of_the_ellipse() {
    for (angle, peak) in [(90.0, 61.025_746), (45.0, 67.053_387), (20.0, 82.596_055)] {
        let bodies = [cylinder("a", angle, 0.02 + 1e-7, 0.1), cylinder("b", 0.0, 0.0, 0.0)].concat();
        let (impact, _) = run(&[SIMULATION, &bodies, &contact("")].concat());
        // The peak of the steps lies below that of the curve by the square of half a step over the impact, some hundred steps.
        let found = number(&impact, "peak_force");
        assert!((found / peak - 1.0).abs() < 1e-3, "{angle} degrees: {found} against {peak}");
        let e = number(&impact, "restitution");
        assert!((e - 1.0).abs() < 1e-5, "{e}");
    }
}

fn ellipsoid(model: &str, turn: [f64; 3], height: f64) -> String {
    format!(
        "[bodies.a]\nmodel = \"{model}\"\nmaterial = \"m\"\nposition = [0.0, 0.0, {height:?}]\norientation_deg = {turn:?}\n\
         velocity = [0.0, 0.0, -0.05]\ngeometry = {{ shape = \"ellipsoid\", semi_axes = [0.02, 0.015, 0.01] }}\n"
    )
}

const FLOOR: &str = "[bodies.b]\nmodel = \"rigid\"\nmaterial = \"m\"\ngeometry = { shape = \"plane\" }\n";

#[test]
fn ellipsoids_press_an_elastic_plane_with_the_force_of_the_ellipse() {
    let ends = [
        ([0.0, 90.0, 0.0], 0.02, 29.964_793),
        ([90.0, 0.0, 0.0], 0.015, 33.963_207),
        ([0.0; 3], 0.01, 39.432_765),
    ];
    for (turn, height, peak) in ends {
        let (impact, _) =
            run(&[SIMULATION, &ellipsoid("rigid", turn, height + 1e-7), FLOOR, &contact("")].concat());
        let found = number(&impact, "peak_force");
        assert!((found / peak - 1.0).abs() < 1e-3, "{height}: {found} against {peak}");
    }
}

#[test]
fn an_oblique_ellipsoid_with_friction_keeps_the_ledger() {
    let body = ellipsoid("rigid", [30.0, 20.0, 0.0], 0.03).replace("[0.0, 0.0, -0.05]", "[0.3, 0.1, -1.0]");
    let spin = body.replace("geometry", "angular_velocity = [50.0, 100.0, 20.0]\ngeometry");
    let text = [SIMULATION, &spin, FLOOR, &contact("friction = 0.3")].concat();
    let text = text.replace("end_time = 0.4e-3", "end_time = 30e-3");
    let (impact, all) = run(&text);
    assert!(number(&impact, "peak_force") > 0.0, "{all}");
}

#[test]
fn axial_bodies_meet_on_their_axis() {
    let ball = |name: &str, z: f64, speed: f64| {
        format!(
            "[bodies.{name}]\nmodel = \"rigid\"\nmotion = \"axial\"\nmaterial = \"m\"\nposition = [0.0, 0.0, {z:?}]\n\
             velocity = [0.0, 0.0, {speed:?}]\ngeometry = {{ shape = \"sphere\", radius = 0.01 }}\n"
        )
    };
    let text = [SIMULATION, &ball("a", 0.02 + 1e-7, -0.1), &ball("b", 0.0, 0.0), &contact("")].concat();
    let (axial, _) = run(&text);
    let (spatial, _) = run(&text.replace("motion = \"axial\"\n", ""));
    let forces = [&axial, &spatial].map(|impact| number(impact, "peak_force"));
    // The steps of the two are the same but for round-off in their choice.
    assert!((forces[0] / forces[1] - 1.0).abs() < 1e-5, "{forces:?}");
}

/// Peak forces between equal masses `mass` in a row that touch, the first of them moving with `speed`, where each two have a force `k δ^1.5`.
fn chain(n: usize, mass: f64, k: f64, speed: f64) -> Vec<f64> {
    let (mut x, mut v, mut peaks) = (vec![0.0; n], vec![0.0; n], vec![0.0; n - 1]);
    v[0] = speed;
    let force = |x: &[f64], i: usize| k * (x[i] - x[i + 1]).max(0.0).powf(1.5);
    // Leapfrog: 1e-4 of the time of a touch between steps leaves an error of 1e-6.
    let step = 5e-9;
    for _ in 0..40_000 {
        x.iter_mut().zip(&v).for_each(|(x, v)| *x += 0.5 * step * v);
        for i in 0..n - 1 {
            let f = force(&x, i);
            peaks[i] = f64::max(peaks[i], f);
            v[i] -= step * f / mass;
            v[i + 1] += step * f / mass;
        }
        x.iter_mut().zip(&v).for_each(|(x, v)| *x += 0.5 * step * v);
    }
    peaks
}

#[test]
fn rows_of_touching_balls_are_masses_on_springs() {
    let (radius, speed) = (5e-3_f64, 0.5);
    let mass = 2700.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let k = 4.0 / 3.0 * (70e9 / (2.0 * (1.0 - 0.09))) * (0.5 * radius).sqrt();
    // Gaps are round-off of positions: none, or one or the other way by a bit.
    for (n, spatial) in [(2, false), (3, false), (4, false), (6, false), (4, true)] {
        let motion = if spatial { "" } else { "motion = \"axial\"\n" };
        let mut text = "[simulation]\nend_time = 2e-4\n".to_owned();
        for i in 0..n {
            text += &format!(
                "[bodies.b{i}]\nmodel = \"rigid\"\n{motion}material = \"m\"\ngeometry = {{ shape = \"sphere\", radius = {radius} }}\n\
                 position = [0.0, 0.0, {:?}]\nvelocity = [0.0, 0.0, {:?}]\n",
                0.01 * i as f64,
                if i == 0 { speed } else { 0.0 }
            );
        }
        for i in 0..n - 1 {
            text += &format!(
                "[contacts.c{i}]\ncontact_body = \"b{i}\"\ntarget_body = \"b{}\"\nmodel = \"hertz\"\n",
                i + 1
            );
        }
        let (_, all) = run(&text);
        for (i, expected) in chain(n, mass, k, speed).into_iter().enumerate() {
            let impacts = all["impacts"].as_array().expect("impacts").iter();
            let of = impacts.filter(|impact| impact["contact"].as_str() == Some(&format!("c{i}")));
            let found = of.map(|impact| number(impact, "peak_force")).fold(0.0, f64::max);
            // Peaks are those of stored steps, a hundredth of a touch apart: 1e-3 of the force.
            assert!((found / expected - 1.0).abs() < 2e-3, "{n} balls, contact {i}: {found} {expected}");
        }
    }
}

/// How fast a small push runs along twenty balls in guides that `preload` presses together, from its largest force eight balls apart [m/s], and how fast
/// long waves do.
fn pushed(preload: f64) -> (f64, f64) {
    const N: usize = 20;
    let radius = 5e-3_f64;
    let mass = 2700.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let k = 4.0 / 3.0 * (70e9 / (2.0 * (1.0 - 0.09))) * (0.5 * radius).sqrt();
    let waves = 2.0 * radius * (1.5 * k.powf(2.0 / 3.0) * preload.cbrt() / mass).sqrt();
    let lasts = 20.0 * radius / waves;
    let mut text = format!("[simulation]\nend_time = {:e}\nstart = \"static\"\n", 3.0 * lasts);
    for i in 0..N {
        let at = radius * (2 * i + 1) as f64;
        text += &format!(
            "[bodies.b{i}]\nmodel = \"rigid\"\nmaterial = \"m\"\ngeometry = {{ shape = \"sphere\", radius = {radius} }}\n\
             [joints.g{i}]\ntype = \"prismatic\"\naxis = [0.0, 0.0, 1.0]\nparent = {{ body = \"ground\", point = [0.0, 0.0, {at:?}] }}\n\
             child = {{ body = \"b{i}\", point = [0.0, 0.0, 0.0] }}\n\
             [contacts.c{i}]\ncontact_body = \"b{i}\"\ntarget_body = \"{}\"\nmodel = \"hertz\"\n",
            if i == 0 { "floor".to_owned() } else { format!("b{}", i - 1) }
        );
    }
    let bump = |s: f64| 0.005 * (1.0 - (2.0 * std::f64::consts::PI * s).cos());
    let shares: Vec<f64> = (0..=60).map(|i| f64::from(i) / 60.0).collect();
    let times: Vec<f64> = shares.iter().map(|s| s * lasts).collect();
    let values: Vec<f64> = shares.iter().map(|s| -preload * (1.0 + bump(*s))).collect();
    text += &format!(
        "[bodies.floor]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\n[loads.p]\nbody = \"b{}\"\npoint = [0.0, 0.0, 0.0]\n\
         force_z = {{ kind = \"table\", times = {times:?}, values = {values:?} }}\n",
        N - 1
    );
    let directory = directory(&text);
    let output = call(directory.path(), &["run", "-qq", "a.toml"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let stored = Stored::open(&directory.path().join("a.h5")).expect("a result");
    let largest = |contact: &str| {
        let force = stored.values(&format!("contacts/{contact}/normal_force")).expect("stored");
        let k = (1..force.len() - 1).max_by(|a, b| force[*a].total_cmp(&force[*b])).expect("states");
        // Where the parabola through three states is highest.
        let [(a, fa), (b, fb), (c, fc)] = [k - 1, k, k + 1].map(|k| (stored.time[k], force[k]));
        let (rise, fall) = ((fb - fa) / (b - a), (fc - fb) / (c - b));
        0.5 * (a + b) + 0.5 * (c - a) * rise / (rise - fall)
    };
    (16.0 * radius / (largest("c8") - largest("c16")), waves)
}

#[test]
fn a_row_of_balls_carries_pushes_as_fast_as_the_sixth_root_of_its_preload() {
    let speeds = [5.0, 50.0, 500.0].map(pushed);
    for (found, waves) in speeds {
        // Pushes of ten balls' length run slower than long waves by their curvature, (k a)²/24 of the shortest that count, some 3 %.
        assert!(found < waves && found > 0.96 * waves, "{speeds:?}");
    }
    for (soft, firm) in speeds.iter().zip(&speeds[1..]) {
        // All times scale alike; the push is 1 % of the preload, of which speeds have a sixth, and states are a hundredth of it apart.
        assert!((firm.0 / soft.0 / 10.0_f64.powf(1.0 / 6.0) - 1.0).abs() < 2e-3, "{speeds:?}");
    }
}

#[test]
fn two_flexible_balls_yield_twice_as_much_beside_the_law_as_one() {
    let ball = |name: &str, is_flexible: bool, z: f64, speed: f64| {
        let model = if is_flexible {
            "\"axisymmetric\"\nreduction = { modes = 10 }"
        } else {
            "\"rigid\"\nmotion = \"axial\""
        };
        format!(
            "[bodies.{name}]\nmodel = {model}\nmaterial = \"m\"\ngeometry = {{ shape = \"sphere\", radius = 5e-3 }}\n\
             position = [0.0, 0.0, {z}]\nvelocity = [0.0, 0.0, {speed}]\n"
        )
    };
    let mass = 2700.0 * 4.0 / 3.0 * std::f64::consts::PI * 5e-3_f64.powi(3);
    let k = 4.0 / 3.0 * (70e9 / (2.0 * (1.0 - 0.09))) * 2.5e-3_f64.sqrt();
    for speed in [0.05, 0.5] {
        let rigid = k * (2.5 * 0.25 * mass * speed * speed / k).powf(0.6);
        let loss = |second: bool| {
            let text = format!(
                "[simulation]\nend_time = 1.2e-4\n{}{}{}",
                ball("a", true, 0.0, speed),
                ball("b", second, 10.001e-3, 0.0),
                contact("")
            );
            1.0 - number(&run(&text).0, "peak_force") / rigid
        };
        let ratio = loss(true) / loss(false);
        // Two compliances in a row with that of the law; their squares are some per cent of them.
        assert!((ratio - 2.0).abs() < 0.2, "{speed} m/s: {ratio}");
    }
}

#[test]
fn what_hertz_knows_nothing_of_is_refused() {
    let parallel =
        [SIMULATION, &cylinder("a", 0.0, 0.02 + 1e-7, 0.1), &cylinder("b", 0.0, 0.0, 0.0), &contact("")]
            .concat();
    let said = refusal(&parallel.replacen("length = 0.06", "length = 0.04", 1));
    assert!(said.contains("Hertz's law needs smooth surfaces") && said.contains("adaptive"), "{said}");
    let flat = [SIMULATION, &cylinder("a", 0.0, 0.01 + 1e-7, 0.1), FLOOR, &contact("")].concat();
    assert!(refusal(&flat).contains("Hertz's law needs smooth surfaces"), "{}", refusal(&flat));
    let bar = "[bodies.a]\nmodel = \"rigid\"\nmotion = \"planar\"\nmaterial = \"m\"\nposition = [0.0, 0.01, 0.0]\ngeometry = { shape = \"rectangle\", size = [0.01, 0.02] }\n";
    let said = refusal(&[SIMULATION, bar, LEVEL, &contact("")].concat());
    assert!(said.contains("has flat faces alone"), "{said}");
    // The corner of a bar that stands on it.
    let said = refusal(
        &[
            SIMULATION,
            &bar.replace(
                "[0.0, 0.01, 0.0]",
                "[0.0, 0.0113, 0.0]\norientation_deg = [0.0, 0.0, 20.0]\nvelocity = [0.0, -1.0, 0.0]",
            ),
            &disc("b", "rigid", -0.01, 0.0),
            &contact(""),
        ]
        .concat(),
    );
    assert!(said.contains("Hertz's law needs smooth surfaces"), "{said}");
}

const LEVEL: &str = "[bodies.b]\nmodel = \"rigid\"\nmaterial = \"m\"\ngeometry = { shape = \"plane\" }\nnormal = [0.0, 1.0, 0.0]\n";

/// A disc of 10 mm radius and 20 mm thickness with its middle at `height`, at `speed` downwards.
fn disc(name: &str, model: &str, height: f64, speed: f64) -> String {
    let motion = if model == "rigid" { "motion = \"planar\"\n" } else { "" };
    format!(
        "[bodies.{name}]\nmodel = \"{model}\"\n{motion}thickness = 0.02\nmaterial = \"m\"\nposition = [0.0, {height:?}, 0.0]\n\
         velocity = [0.0, {:?}, 0.0]\ngeometry = {{ shape = \"disc\", radius = 0.01 }}\n",
        -speed
    )
}

/// Largest force of discs that come nearer by `δ = P c/π (2 ln(4 R/a) - 1)`, `a² = 4 P c/π κ`, `c` the sum of their compliances [1/Pa]: the one
/// under which the contact stores the energy \[J\], `∫ δ dF` taken from `F δ`.
fn peak_of_discs(compliance: f64, curvature: f64, energy: f64) -> f64 {
    let thickness = 0.02;
    let approach = |force: f64| {
        let load = force * compliance / (thickness * std::f64::consts::PI);
        load * (2.0 * (0.04 / (4.0 * load / curvature).sqrt()).ln() - 1.0)
    };
    let stored = |force: f64| {
        let n = 2000;
        let sum: f64 = (0..n).map(|i| approach(force * (f64::from(i) + 0.5) / f64::from(n))).sum();
        force * approach(force) - sum * force / f64::from(n)
    };
    let (mut low, mut high) = (0.0, 1e7);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if stored(middle) < energy { low = middle } else { high = middle }
    }
    low
}

/// Rigid discs yield where they touch as plane strain has it, flexible ones as their model.
#[test]
fn discs_meet_with_the_force_of_the_line() {
    let (young, poisson, speed) = (70e9, 0.3_f64, 0.1);
    let strain = (1.0 - poisson * poisson) / young;
    let mass = 2700.0 * std::f64::consts::PI * 1e-4 * 0.02;
    let simulation = "[simulation]\nend_time = 0.2e-3\n";
    let few = "reduction = { modes = 1 }\ndiscretisation = { degree = 2, elements = 2 }\ngeometry";
    let stiff = disc("b", "plane-stress", 0.0, 0.0).replacen("geometry", few, 1);
    for (text, compliance, curvature, moved) in [
        (disc("b", "rigid", 0.0, 0.0), 2.0 * strain, 200.0, 0.5 * mass),
        (
            LEVEL.replace("0.0, 1.0, 0.0]\n", "0.0, 1.0, 0.0]\nposition = [0.0, 0.01, 0.0]\n"),
            2.0 * strain,
            100.0,
            mass,
        ),
    ] {
        let (impact, _) =
            run(&[simulation, &disc("a", "rigid", 0.02 + 1e-7, speed), &text, &contact("")].concat());
        let peak = peak_of_discs(compliance, curvature, 0.5 * moved * speed * speed);
        // The peak of the steps lies below that of the curve by the square of half a step over the impact, some hundred steps.
        let found = number(&impact, "peak_force");
        assert!((found / peak - 1.0).abs() < 1e-3, "{found} against {peak}");
        assert!((number(&impact, "restitution") - 1.0).abs() < 1e-5, "{impact}");
    }
    let (impact, _) =
        run(&[simulation, &disc("a", "rigid", 0.02 + 1e-7, speed), &stiff, &contact("")].concat());
    let peak = peak_of_discs(strain + 1.0 / young, 200.0, 0.25 * mass * speed * speed);
    // The one mode of the other disc yields besides and is hardly touched: less than a hundredth.
    let found = number(&impact, "peak_force");
    assert!((found / peak - 1.0).abs() < 0.02, "{found} against {peak}");
}

#[test]
fn modes_that_yield_beside_the_law_are_told() {
    let ball = |model: &str| {
        format!(
            "[simulation]\nend_time = 1e-7\n[bodies.a]\n{model}\nmaterial = \"m\"\nposition = [0.0, 0.0, 0.0100001]\n\
             velocity = [0.0, 0.0, -0.1]\ngeometry = {{ shape = \"sphere\", radius = 0.01 }}\n{FLOOR}{}",
            contact("")
        )
    };
    let flexible =
        "model = \"axisymmetric\"\nreduction = { modes = 4 }\ndiscretisation = { degree = 2, elements = 4 }";
    for (model, is_told) in [(flexible, true), ("model = \"rigid\"\nmotion = \"axial\"", false)] {
        let directory = directory(&ball(model));
        let output = call(directory.path(), &["run", "-q", "a.toml"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.contains("yields-twice") == is_told, "{said}");
    }
}
