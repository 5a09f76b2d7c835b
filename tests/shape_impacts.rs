//! Shapes of the catalogue as a user meets them: impacts with default keys against Hertz' law, as rigid targets, frequencies of rings and
//! beams, and sizes that do not fit.

use crate::support::scenarios;

use std::f64::consts::{PI, TAU};
use std::path::Path;

use adaptive::model::start_poses;
use adaptive::touch::first::FirstTouches;
use adaptive::touch::hertz::{LocalSurface, hertz_impact};
use adaptive::touch::parts::TouchKind;
use fbimpact::scenario;
use nalgebra::{UnitQuaternion, Vector3};

/// Aluminium \[Pa\], \[kg/m³\].
const YOUNG: f64 = 70e9;
const POISSON: f64 = 0.3;
const DENSITY: f64 = 2700.0;
/// Speed of approach \[m/s\].
const SPEED: f64 = 0.01;
/// Deviation of the force from Hertz' law: contacts are a hundredth of the bodies wide, and the law for half spaces errs by about half the
/// ratio of the two.
const HERTZ: f64 = 0.01;

/// Hammer, piston: radius, length, crown, fillet.
const HAMMER: &str =
    "shape = \"rounded-cylinder\", radius = 0.01, length = 0.02, crown_radius = 0.02, fillet_radius = 0.001";
const CAPSULE: &str = "shape = \"capsule\", radius = 0.01, length = 0.025";
const RING: &str = "shape = \"torus\", radius = 0.02, tube_radius = 0.01";

/// A part called "part" and what it meets, "tool", with default keys of contact, mesh and modes.
fn world(part: &str, tool: &str) -> String {
    format!(
        "[simulation]\nend_time = 6e-4\n[materials.aluminium]\nyoungs_modulus = 70e9\npoissons_ratio = 0.3\ndensity = 2700.0\n\
         [bodies.part]\nmaterial = \"aluminium\"\n{part}\n[bodies.tool]\nmodel = \"rigid\"\n{tool}\n\
         [contacts.c]\ncontact_body = \"part\"\ntarget_body = \"tool\"\n"
    )
}

fn falling(model: &str, geometry: &str, height: f64, more: &str) -> String {
    format!(
        "model = \"{model}\"\ngeometry = {{ {geometry} }}\nposition = [0.0, 0.0, {height:e}]\nvelocity = [0.0, 0.0, -{SPEED}]\n{more}"
    )
}

const PLANE: &str = "geometry = { shape = \"plane\" }";

/// Peak force of the only impact, energy drift checked \[N\].
fn peak(text: &str) -> f64 {
    let found = scenarios::run_on(&scenarios::valid(Path::new("."), text, &[]), 2);
    let drift = found.energy_drift();
    // As for the other impacts of docs/verification.md: the tolerance of the steps over their number.
    assert!(drift < 1e-5, "ledger {drift:e}");
    let [impact] = &found.impacts[..] else { panic!("{} impacts", found.impacts.len()) };
    impact.peak_force
}

/// Peak of Hertz' impact of a surface of the curvatures `own` on a rigid one, their first directions alike \[N\].
fn hertz(own: [f64; 2], tool: [f64; 2], inverse_mass: f64) -> f64 {
    let compliance = (1.0 - POISSON * POISSON) / YOUNG;
    let surface = |curvatures, compliance| LocalSurface { curvatures, direction: Vector3::x(), compliance };
    hertz_impact(&[surface(own, compliance), surface(tool, 0.0)], inverse_mass, SPEED).unwrap().peak_force
}

fn compare(name: &str, found: f64, expected: f64, tolerance: f64) {
    println!("{name}: {found:.4}, expected {expected:.4}, {:+.2} %", 100.0 * (found / expected - 1.0));
    assert!((found / expected - 1.0).abs() < tolerance, "{name}: {found} instead of {expected}");
}

/// Mass of the hammer by the volume of its parts (cap, torus of the fillet by slices, cylinder), independent of its net \[kg\].
fn hammer_mass() -> f64 {
    let (r, l, c, f) = (0.01_f64, 0.02_f64, 0.02_f64, 0.001_f64);
    let centre = c - ((c - f).powi(2) - (r - f).powi(2)).sqrt();
    let touch = c * (1.0 - (1.0 - ((r - f) / (c - f)).powi(2)).sqrt());
    let cap = PI * touch * touch * (c - touch / 3.0);
    // Slices of the fillet by Simpson's rule in the angle, whose fourth power of a thousandth is round-off.
    let n = 1000;
    let start = ((r - f) / (c - f)).asin();
    let slice = |i: usize| {
        let t = start + (0.5 * PI - start) * i as f64 / n as f64;
        let weight = if i == 0 || i == n {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        };
        weight * PI * (r - f + f * t.sin()).powi(2) * f * t.sin()
    };
    let fillet: f64 = (0..=n).map(slice).sum::<f64>() * (0.5 * PI - start) / (3.0 * n as f64);
    DENSITY * (cap + fillet + PI * r * r * (l - centre))
}

fn capsule_mass() -> f64 {
    DENSITY * PI * 1e-4 * (0.005 + 4.0 / 3.0 * 0.01)
}

#[test]
fn round_ends_press_a_plane_as_hertz_says_with_the_radius_of_the_crown() {
    let found = peak(&world(&falling("axisymmetric", HAMMER, 1e-6, ""), PLANE));
    compare("hammer", found, hertz([50.0; 2], [0.0; 2], 1.0 / hammer_mass()), HERTZ);
    let found = peak(&world(&falling("axisymmetric", CAPSULE, 1e-6, ""), PLANE));
    compare("capsule", found, hertz([100.0; 2], [0.0; 2], 1.0 / capsule_mass()), HERTZ);
}

#[test]
fn a_capsule_falls_on_a_free_rigid_one_as_hertz_says() {
    let tool = format!(
        "motion = \"axial\"\nmaterial = \"aluminium\"\ngeometry = {{ {CAPSULE} }}\nposition = [0.0, 0.0, -0.025]"
    );
    let found = peak(&world(&falling("axisymmetric", CAPSULE, 1e-6, ""), &tool));
    compare("capsules", found, hertz([100.0; 2], [100.0; 2], 2.0 / capsule_mass()), HERTZ);
}

/// Poses in which each shape meets a ball with a smooth part of its surface: geometry, position of the ball's centre above it.
const TARGETS: [(&str, [f64; 3]); 9] = [
    ("shape = \"torus\", radius = 0.02, tube_radius = 0.01", [0.02, 0.0, 0.015001]),
    ("shape = \"capsule\", radius = 0.01, length = 0.025", [0.0, 0.0, 0.030001]),
    ("shape = \"cone\", radius = 0.02, end_radius = 0.01, length = 0.02", [0.001, 0.002, 0.025001]),
    (
        "shape = \"tube-sector\", inner_radius = 0.02, outer_radius = 0.04, length = 0.02, angle_deg = 90",
        [0.03, 0.0, 0.025001],
    ),
    (
        "shape = \"rounded-cylinder\", radius = 0.02, length = 0.02, crown_radius = 0.1, fillet_radius = 0.002",
        [0.001, 0.0, 0.025001],
    ),
    ("shape = \"rounded-box\", size = [0.02, 0.03, 0.04], fillet_radius = 0.002", [0.001, 0.002, 0.025001]),
    (
        "shape = \"plate-with-hole\", size = [0.1, 0.04], hole_radius = 0.005, thickness = 0.01",
        [0.03, 0.002, 0.010001],
    ),
    (
        "shape = \"l-beam\", width = 0.03, height = 0.05, thickness = 0.01, length = 0.1",
        [0.005, 0.02, 0.105001],
    ),
    (
        "shape = \"t-beam\", width = 0.05, height = 0.05, flange_thickness = 0.01, web_thickness = 0.012, length = 0.1",
        [0.001, -0.02, 0.105001],
    ),
];

#[test]
fn every_shape_is_a_rigid_target_that_a_ball_touches_smoothly() {
    let ball = "shape = \"sphere\", radius = 0.005";
    for (geometry, at) in TARGETS {
        let part = format!(
            "geometry = {{ {ball} }}\nposition = {at:?}\nvelocity = [0.0, 0.0, -{SPEED}]\nreduction = {{ modes = 3 }}\n\
             discretisation = {{ degree = 2, elements = 2 }}"
        );
        let tool = format!("material = \"aluminium\"\ngeometry = {{ {geometry} }}");
        let scenario = scenarios::valid(Path::new("."), &world(&part, &tool), &[]);
        let spec = &scenario.run;
        let kind = FirstTouches::new(spec, start_poses(spec).unwrap()).kind(&spec.contacts[0]);
        assert_eq!(kind, Some(TouchKind::Smooth), "{geometry}");
    }
}

#[test]
#[ignore = "second tier: minutes"]
fn solid_shapes_press_a_plane_as_hertz_says() {
    let found = peak(&world(&falling("solid", HAMMER, 1e-6, ""), PLANE));
    compare("solid hammer", found, hertz([50.0; 2], [0.0; 2], 1.0 / hammer_mass()), HERTZ);
    // On its side: the outermost circle and the section are curved.
    let mass = DENSITY * 2.0 * PI * PI * 0.02 * 1e-4;
    let found = peak(&world(&falling("solid", RING, 0.030_001, "orientation_deg = [0, 90, 0]"), PLANE));
    compare("torus on its side", found, hertz([100.0, 1.0 / 0.03], [0.0; 2], 1.0 / mass), HERTZ);
}

/// A plane touches the ellipsoid where its net, that of a cube, has a corner and is singular. Mesh and modes are given, which saves minutes of choosing them.
#[test]
#[ignore = "second tier: minutes"]
fn an_ellipsoid_presses_a_plane_with_a_corner_of_its_net_as_hertz_says() {
    let axes = Vector3::new(0.008, 0.01, 0.014);
    let u = Vector3::new(1.0, 1.0, 1.0).normalize();
    let place = axes.component_mul(&u);
    let normal = u.component_div(&axes).normalize();
    let height = place.dot(&normal);
    // A tangent t of the unit ball becomes one of length sqrt(t · D² t), along which the surface bends by the height.
    let (a, b) = (Vector3::new(1.0, -1.0, 0.0).normalize(), Vector3::new(1.0, 1.0, -2.0).normalize());
    let form = |s: &Vector3<f64>, t: &Vector3<f64>| axes.component_mul(s).dot(&axes.component_mul(t));
    let (mean, half) = (0.5 * (form(&a, &a) + form(&b, &b)), 0.5 * (form(&a, &a) - form(&b, &b)));
    let apart = half.hypot(form(&a, &b));
    let mass = 4.0 / 3.0 * PI * DENSITY * axes.product();
    let squares = axes.component_mul(&axes);
    let inertia = (Vector3::repeat(squares.sum()) - squares) * (mass / 5.0);
    let lever = place.cross(&normal);
    let inverse_mass = 1.0 / mass + lever.component_mul(&lever).component_div(&inertia).sum();
    let turn = UnitQuaternion::rotation_between(&normal, &-Vector3::z()).expect("not opposite").into_inner();
    let more = format!(
        "orientation = [{}, {}, {}, {}]\ndiscretisation = {{ elements = 4, degree = 4 }}\nreduction = {{ modes = 8 }}",
        turn.w, turn.i, turn.j, turn.k
    );
    let shape = "shape = \"ellipsoid\", semi_axes = [0.008, 0.01, 0.014]";
    let found = peak(&world(&falling("solid", shape, height + 5e-7, &more), PLANE));
    let expected = hertz([height / (mean - apart), height / (mean + apart)], [0.0; 2], inverse_mass);
    compare("ellipsoid", found, expected, HERTZ);
}

/// Eigenfrequencies of a free steel body \[Hz\].
fn frequencies(geometry: &str, modes: usize, elements: [usize; 3]) -> Vec<f64> {
    let text = format!(
        "[simulation]\nend_time = 1e-6\n[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7850.0\n\
         [bodies.part]\nmaterial = \"steel\"\ngeometry = {{ {geometry} }}\nreduction = {{ modes = {modes} }}\n\
         discretisation = {{ degree = 3, elements = {elements:?} }}\n"
    );
    let found = scenarios::run_on(&scenarios::valid(Path::new("."), &text, &[]), 2);
    found.layout.bodies[0].eigenfrequencies.clone()
}

fn has(name: &str, frequencies: &[f64], expected: f64, tolerance: f64) {
    let nearest = |a: &f64, b: &f64| (a - expected).abs().total_cmp(&(b - expected).abs());
    let found = frequencies.iter().copied().min_by(nearest).unwrap();
    compare(name, found, expected, tolerance);
}

/// Hoppe: a ring of radius `R` and circular section of radius `r` bends in its plane with `n` waves around at
/// `n (n² - 1)/sqrt(n² + 1)` times `c r / (2 R²)`. Shear and rotary inertia, left out there, are of the order `n² (r/R)²`: 0.6 % for `n = 2`.
#[test]
fn a_thin_ring_bends_in_its_plane_as_closed_forms_say() {
    let (radius, tube) = (0.1, 0.004);
    let geometry = format!("shape = \"torus\", radius = {radius}, tube_radius = {tube}");
    let found = frequencies(&geometry, 6, [1, 1, 8]);
    let speed = (210e9_f64 / 7850.0).sqrt();
    let expected = 6.0 / 5.0_f64.sqrt() * speed * tube / (2.0 * radius * radius) / TAU;
    has("ring", &found, expected, 4.0 * (tube / radius).powi(2));
}

/// A free L-beam with equal legs bends in its plane of symmetry without twist: `4.730² / (2π L²) sqrt(E I / ρ A)`, lowered by the share
/// `(49.5 + 12.3 E/κG) (i/L)² / 2` for rotary inertia and shear, `i` being the radius of inertia: 49.5 and 12.3 are Rayleigh's quotients
/// of the first mode of a free bar, slopes over displacements and shear forces over moments. `κ` lies between 5/12 (all shear in one leg)
/// and 5/6: half of what that leaves open is the tolerance.
#[test]
fn a_slender_l_beam_bends_in_its_plane_of_symmetry_as_a_bar() {
    let (w, t, length) = (0.03_f64, 0.005_f64, 0.6);
    let geometry =
        format!("shape = \"l-beam\", width = {w}, height = {w}, thickness = {t}, length = {length}");
    let found = frequencies(&geometry, 6, [2, 2, 10]);
    // Second moments about the outer edge, moved to the centroid; the one across the plane of symmetry is their difference.
    let area = t * (2.0 * w - t);
    let centroid = (0.5 * t * w * w + 0.5 * (w - t) * t * t) / area;
    let direct = (t * w.powi(3) + (w - t) * t.powi(3)) / 3.0 - area * centroid * centroid;
    let mixed = 0.25 * (t * t * w * w + t * t * (w * w - t * t)) - area * centroid * centroid;
    let inertia = direct + mixed; // the mixed moment of an L is negative
    let stiffness = (210e9 * inertia / (7850.0 * area)).sqrt();
    let expected = 4.730_04_f64.powi(2) / (TAU * length * length) * stiffness;
    let slenderness = inertia / area / (length * length);
    let lowered = |shear: f64| 0.5 * (49.5 + 12.3 * shear) * slenderness;
    let [stiff, soft] = [6.0 / 5.0, 12.0 / 5.0].map(|over_kappa| lowered(2.0 * (1.0 + POISSON) * over_kappa));
    has("L-beam", &found, expected * (1.0 - 0.5 * (stiff + soft)), 0.5 * (soft - stiff));
}

#[test]
fn sizes_that_do_not_fit_are_faults_at_their_key() {
    for (geometry, key) in [
        ("shape = \"capsule\", radius = 0.01, length = 0.02", "length"),
        ("shape = \"torus\", radius = 0.01, tube_radius = 0.02", "radius"),
        ("shape = \"rounded-box\", size = [1.0, 1.0, 0.1], fillet_radius = 0.05", "fillet_radius"),
        ("shape = \"rounded-cylinder\", radius = 0.01, length = 0.1, crown_radius = 0.009", "crown_radius"),
        ("shape = \"rounded-cylinder\", radius = 0.01, length = 0.1, fillet_radius = 0.01", "radius"),
        (
            "shape = \"plate-with-hole\", size = [1.0, 0.1], hole_radius = 0.05, thickness = 0.1",
            "hole_radius",
        ),
        ("shape = \"plate-with-hole\", size = [1.0, 0.1], hole_radius = 0.01", "thickness"),
        ("shape = \"l-beam\", width = 1.0, height = 0.1, thickness = 0.1, length = 1.0", "thickness"),
        (
            "shape = \"t-beam\", width = 0.1, height = 1.0, flange_thickness = 0.1, web_thickness = 0.1, length = 1.0",
            "web_thickness",
        ),
        ("shape = \"hollow-cylinder\", inner_radius = 1.0, outer_radius = 1.0, length = 1.0", "inner_radius"),
    ] {
        let part =
            format!("geometry = {{ {geometry} }}\nposition = [0.0, 0.0, 1.0]\nvelocity = [0.0, 0.0, -1.0]");
        let faults = scenario::parse(Path::new("t.toml"), world(&part, PLANE).as_bytes(), &[]).unwrap_err();
        let [fault] = faults.list() else { panic!("{geometry}: {faults}") };
        assert_eq!(fault.key, format!("bodies.part.geometry.{key}"), "{fault}");
        assert!(fault.line().is_some(), "{fault}");
    }
}
