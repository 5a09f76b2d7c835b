//! Bodies that lie where they begin: whatever the width of the zone, the gap at the start, the pose and what the bodies are made of, they are carried and
//! do not fall.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use adaptive::run::recording::Recording;
use fe_mesh::ElementKind;
use nalgebra::Vector3;

use crate::balls::Ball;
use crate::support::scenarios;
use crate::writers::{Form, gmsh};

const GRAVITY: f64 = 9.81; // m/s²
const RADIUS: f64 = 20e-3; // m
const TIME: f64 = 6e-3; // s
const SHORT: f64 = 1.5e-3; // s

/// A ball of finite elements on a file that all tests read.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = scenarios::folder("lying");
        let ball = Ball { radius: 1e3 * RADIUS, across: [6, 2], layers: 2, growth: [1.2, 1.5] };
        std::fs::write(folder.join("ball.msh"), gmsh(&ball.mesh(ElementKind::Hex20), Form::Binary41))
            .expect("written");
        folder
    })
}

/// What lies on what.
#[derive(Debug, Clone, Copy)]
enum Pair {
    /// A disc of splines on a plane.
    Disc,
    /// A ball of splines about an axis.
    Ball,
    /// A ball of finite elements.
    Mesh,
    /// A disc of splines on a rigid disc.
    OnRigid,
}

/// The scenario: the way up is turned by `tilt`, the body by `turn` \[degrees\].
fn text(pair: Pair, time: f64, (width, gap): (Option<f64>, f64), (tilt, turn): (f64, f64)) -> String {
    let (sine, cosine) = tilt.to_radians().sin_cos();
    let up = if matches!(pair, Pair::Ball | Pair::Mesh) { [0.0, sine, cosine] } else { [sine, cosine, 0.0] };
    let times = |s: f64| up.map(|c| s * c);
    let body = match pair {
        Pair::Disc | Pair::OnRigid => format!(
            "model = \"plane-strain\"\nthickness = 20e-3\nmaterial = \"aluminium\"\n\
             geometry = {{ shape = \"disc\", radius = {RADIUS} }}\norientation_deg = [0.0, 0.0, {turn}]"
        ),
        Pair::Ball => format!(
            "model = \"axisymmetric\"\nmaterial = \"aluminium\"\ngeometry = {{ shape = \"sphere\", radius = {RADIUS} }}"
        ),
        Pair::Mesh => format!(
            "model = \"mesh\"\nfile = \"ball.msh\"\nunits = \"mm\"\nmaterial = \"aluminium\"\nreduction = {{ modes = 12 }}\n\
             orientation_deg = [{turn}, 0.0, 0.0]"
        ),
    };
    let floor = match pair {
        Pair::OnRigid => "model = \"rigid\"\nmotion = \"planar\"\nmaterial = \"steel\"\nthickness = 20e-3\n\
             geometry = { shape = \"disc\", radius = 30e-3 }"
            .to_owned(),
        _ => format!("model = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nnormal = {up:?}"),
    };
    let held = match pair {
        Pair::OnRigid => format!(
            "[joints.held]\ntype = \"fixed\"\nparent = {{ body = \"ground\", point = {:?} }}\n\
             child = {{ body = \"floor\", point = [0.0, 0.0] }}\n",
            times(-30e-3)
        ),
        _ => String::new(),
    };
    let width = width.map_or_else(String::new, |w| format!("interval = {{ width = {w} }}\n"));
    format!(
        "[simulation]\nend_time = {time}\ngravity = {:?}\n[bodies.body]\n{body}\nposition = {:?}\n[bodies.floor]\n{floor}\n{held}\
         [contacts.c]\ncontact_body = \"body\"\ntarget_body = \"floor\"\ninitial_overlap = 2e-9\n{width}",
        times(-GRAVITY),
        times(RADIUS + gap)
    )
}

/// The largest speed \[m/s\], and how far the body has been from where it began \[m\].
fn moved(text: &str) -> (f64, f64) {
    let recording: Recording = scenarios::run(&scenarios::valid(folder(), text, &[]));
    let bodies = recording.samples.iter().map(|sample| &sample.bodies[0]);
    let start = Vector3::from(recording.samples[0].bodies[0].centre_of_mass);
    bodies.fold((0.0, 0.0), |(speed, way), body| {
        let place = Vector3::from(body.centre_of_mass);
        (Vector3::from(body.velocity).norm().max(speed), (place - start).norm().max(way))
    })
}

/// How fast and how far a body swings that is laid down `gap` above what carries it: with F = k w^n and its weight at w = d the speed is largest there,
/// v² = 2 g (d n/(n + 1) + gap), and it turns before w = (n + 1)^(1/n) d + gap.
fn swing(pair: Pair, gap: f64) -> (f64, f64) {
    let stiffness = 70e9 / (1.0 - 0.33 * 0.33);
    let (n, deep) = match pair {
        // Nearly a straight line: w = F/(π E') (2 ln(4 R/a) - 1) with a² = 4 F R/(π E'), F the weight of a metre.
        Pair::Disc | Pair::OnRigid => {
            let force = 2700.0 * PI * RADIUS * RADIUS * GRAVITY;
            let half_width = (4.0 * force * RADIUS / (PI * stiffness)).sqrt();
            (1.0, force / (PI * stiffness) * (2.0 * (4.0 * RADIUS / half_width).ln() - 1.0))
        }
        // Hertz: w³ = 9 F²/(16 R E'²).
        Pair::Ball | Pair::Mesh => {
            let force = 2700.0 * 4.0 / 3.0 * PI * RADIUS.powi(3) * GRAVITY;
            (1.5, (9.0 * force * force / (16.0 * RADIUS * stiffness * stiffness)).cbrt())
        }
    };
    let gap = gap.max(0.0);
    ((2.0 * GRAVITY * (deep * n / (n + 1.0_f64) + gap)).sqrt(), (n + 1.0).powf(1.0 / n) * deep + 2.0 * gap)
}

fn check(pair: Pair, time: f64, zone: (Option<f64>, f64), pose: (f64, f64)) {
    let (speed, way) = moved(&text(pair, time, zone, pose));
    let (fastest, farthest) = swing(pair, zone.1);
    // Falling would be 15 mm/s and 11 um and more. Zones that are much wider than the contact, and springs, give way a little more than Hertz's solid does.
    assert!(speed < 1.1 * fastest, "{pair:?} {zone:?} {pose:?}: {speed:e} m/s, {fastest:e} expected");
    assert!(way < 1.2 * farthest, "{pair:?} {zone:?} {pose:?}: moved by {way:e} m, {farthest:e} expected");
}

#[test]
fn a_disc_lies_where_it_begins() {
    check(Pair::Disc, SHORT, (Some(1e-2), -1e-9), (37.0, 45.0));
}

#[test]
#[ignore = "second tier: half a minute"]
fn discs_lie_where_they_begin() {
    for (width, gap, pose) in [(Some(5e-3), 0.0, (0.0, 0.0)), (None, 1e-9, (90.0, 0.0))] {
        check(Pair::Disc, TIME, (width, gap), pose);
    }
}

#[test]
#[ignore = "second tier: minutes"]
fn bodies_lie_where_they_begin_whatever_the_zone() {
    for pair in [Pair::Disc, Pair::OnRigid, Pair::Ball, Pair::Mesh] {
        for width in [None, Some(1e-4), Some(1e-3), Some(1e-2)] {
            for (gap, pose) in [(-1e-9, (0.0, 0.0)), (0.0, (37.0, 45.0)), (1e-9, (90.0, 45.0))] {
                let pose = match pair {
                    // The axis of axisymmetric bodies is z of the world.
                    Pair::Ball => (0.0, 0.0),
                    // Its fine sides below: 8 degrees beside them, between two nodes, the surface of the mesh lies 14 um inside the sphere.
                    Pair::Mesh => (pose.0, -pose.0),
                    Pair::Disc | Pair::OnRigid => pose,
                };
                check(pair, TIME, (width, gap), pose);
            }
        }
    }
}
