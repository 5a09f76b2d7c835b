//! A beam on a hinge with a prescribed angle: the spin-up manoeuvre of Simo & Vu-Quoc (1986), and its reference.

use std::f64::consts::TAU;

use ffr_dynamics::body::StandardInputData;
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, ErrorScale, GROUND, JointKind, JointSpec, Multibody, SystemSpec,
    TimeFunction,
};

/// Final speed [rad/s] and time to reach it \[s\].
const SPEED: f64 = 6.0;
const SPIN_UP: f64 = 15.0;

/// A body on a hinge with prescribed angle.
pub fn prescribed(
    data: StandardInputData,
    hub: Marker,
    ground: Vec<Marker>,
    angle: impl Fn(f64) -> [f64; 3] + Send + Sync + 'static,
) -> Multibody {
    let at = |body: &str| Attachment::new(body, "hub");
    let mut joint = JointSpec::new("hub", JointKind::Revolute, at(GROUND), at("beam"));
    joint.coordinates =
        vec![CoordinateForce { motion: Some(TimeFunction::new(angle)), ..CoordinateForce::default() }];
    let body = BodySpec { name: "beam".to_string(), data, markers: vec![hub] };
    let spec = SystemSpec { bodies: vec![body], ground, joints: vec![joint], ..SystemSpec::default() };
    let mut system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
    system.set_error_scale(ErrorScale { relative: 1e-6, ..ErrorScale::default() }).unwrap();
    system
}

/// Angle of the spin-up manoeuvre and its derivatives.
pub fn spin_up(t: f64) -> [f64; 3] {
    let w = TAU / SPIN_UP;
    if t >= SPIN_UP {
        return [SPEED * (t - SPIN_UP / 2.0), SPEED, 0.0];
    }
    let angle = SPEED / SPIN_UP * (0.5 * t * t + ((w * t).cos() - 1.0) / (w * w));
    [angle, SPEED / SPIN_UP * (t - (w * t).sin() / w), SPEED / SPIN_UP * (1.0 - (w * t).cos())]
}

/// How a curve of time, extension and deflection of the tip compares with the reference.
#[derive(Debug, Clone, Copy)]
pub struct Comparison {
    /// Largest distance of the deflections \[m\].
    pub off: f64,
    /// Smallest deflection \[m\].
    pub extreme: f64,
    /// Mean extension after 16 s \[m\].
    pub extension: f64,
}

/// Compares with the geometrically exact beam of the reference, with linear interpolation between the steps.
pub fn compare(curve: &[[f64; 3]]) -> Comparison {
    let reference: Vec<Vec<f64>> = include_str!("../data/spinning_beam.csv")
        .lines()
        .filter(|l| !l.starts_with(['#', 't']))
        .map(|l| l.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    let (mut off, mut extreme): (f64, f64) = (0.0, 0.0);
    for row in &reference {
        let Some(i) = curve.iter().position(|p| p[0] >= row[0]).filter(|i| *i > 0) else { continue };
        let (a, b) = (curve[i - 1], curve[i]);
        let deflection = a[2] + (b[2] - a[2]) * (row[0] - a[0]) / (b[0] - a[0]);
        off = off.max((deflection - row[3]).abs());
        extreme = extreme.min(deflection);
    }
    let last: Vec<f64> = curve.iter().filter(|p| p[0] > 16.0).map(|p| p[1]).collect();
    Comparison { off, extreme, extension: last.iter().sum::<f64>() / last.len() as f64 }
}
