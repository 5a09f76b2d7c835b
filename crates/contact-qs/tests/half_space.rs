//! Contact of an elastic half space of rings with a rigid sphere: Hertz's solution in numbers, and a whole impact.

use crate::hertz_impact::HertzImpact;
use contact_qs::law::hertz::{HertzPair, Solid};
use contact_qs::law::penalty::{DEFAULT_STIFFNESS_RATIO, compliance_weight};
use contact_qs::quasistatic::broyden::BroydenSettings;
use contact_qs::quasistatic::compliance::sparse_rows::SparseRows;
use contact_qs::quasistatic::{ActiveSet, Method, Problem};
use contact_qs::{ContactSubmodel, Plane, PlaneContact, PlaneContactSettings};
use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

const ALUMINIUM: Solid = Solid { young: 7.28e10, poisson: 0.33 };
const RADIUS: f64 = 0.01;
/// Rings reach a little beyond the contact radius of the impact, 1.7e-4 m.
const WIDTH: f64 = 2e-4;

/// Complete elliptic integrals `K(k)`, `E(k)` by the arithmetic-geometric mean.
fn elliptic(k: f64) -> (f64, f64) {
    let (mut a, mut b, mut sum, mut power) = (1.0, (1.0 - k * k).sqrt(), 0.5 * k * k, 0.5);
    // Converges quadratically: six steps reach round-off for every k < 1 - 1e-10.
    for _ in 0..8 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        power *= 2.0;
        sum += power * c * c;
    }
    let first = FRAC_PI_2 / a;
    (first, first * (1.0 - sum))
}

/// Deflection at distance `r` under unit pressure on a disc of radius `a`, times `E/(1-ν²)` (Johnson 3.29).
fn disc(r: f64, a: f64) -> f64 {
    if a == 0.0 {
        0.0
    } else if r <= a {
        4.0 * a / PI * elliptic(r / a).1
    } else {
        let (first, second) = elliptic(a / r);
        4.0 * r / PI * (second - (1.0 - (a / r).powi(2)) * first)
    }
}

/// `n` rings: mean radii, areas, compliance (symmetrised collocation).
fn rings(n: usize) -> (Vec<f64>, Vec<f64>, Mat<f64>) {
    let edge = |i: usize| WIDTH * i as f64 / n as f64;
    let centre: Vec<f64> = (0..n).map(|i| 0.5 * (edge(i) + edge(i + 1))).collect();
    let area: Vec<f64> = (0..n).map(|i| PI * (edge(i + 1).powi(2) - edge(i).powi(2))).collect();
    let raw = Mat::from_fn(n, n, |i, j| {
        ALUMINIUM.compliance() * (disc(centre[i], edge(j + 1)) - disc(centre[i], edge(j))) / area[j]
    });
    let compliance = Mat::from_fn(n, n, |i, j| 0.5 * (raw[(i, j)] + raw[(j, i)]));
    (centre, area, compliance)
}

fn pair() -> HertzPair {
    HertzPair::new([ALUMINIUM, Solid::RIGID], [RADIUS, f64::INFINITY])
}

#[test]
fn exact_constraint_converges_to_hertz_force_and_pressure() {
    let approach = 2.5e-6;
    let mut errors = Vec::new();
    for n in [20, 40, 80] {
        let (centre, area, compliance) = rings(n);
        let gaps: Vec<f64> = centre.iter().map(|r| r * r / (2.0 * RADIUS) - approach).collect();
        let mut forces = vec![0.0; n];
        ActiveSet::new(n)
            .solve(&Problem { compliance: &compliance, springs: &vec![0.0; n], gaps: &gaps }, &mut forces)
            .unwrap();
        errors.push((forces.iter().sum::<f64>() / pair().force(approach) - 1.0).abs());
        if n == 80 {
            // The innermost ring is left out: making the compliance symmetric changes it by some per cent, for its area
            // is a third of its neighbour's.
            for i in 1..n / 2 {
                let expected = pair().pressure(approach, centre[i]);
                // Constant pressures on rings of 1/63 of the contact radius, away from its edge: measured 9e-4.
                assert!((forces[i] / area[i] / expected - 1.0).abs() < 2e-3, "{i}");
            }
        }
    }
    // Rings of constant pressure: at least first order, with the edge between two rings.
    assert!(errors[2] < 2e-3 && errors[2] < 0.5 * errors[0], "{errors:?}");
}

/// Rigid translation of a sphere with a quasistatic half-space zone.
fn contact(n: usize, penalty: Option<f64>, method: Method) -> PlaneContact {
    let (centre, areas, a) = rings(n);
    let areas_for_penalty = areas.clone();
    let submodel = ContactSubmodel {
        motion: RigidMotion::Axial,
        points: centre.iter().map(|&r| [r, 0.0, r * r / (2.0 * RADIUS) - RADIUS]).collect(),
        areas,
        low: Mat::zeros(2 * n, 0),
        compliance: Mat::from_fn(2 * n, 2 * n, |i, j| {
            if i % 2 == 1 && j % 2 == 1 { a[(i / 2, j / 2)] } else { 0.0 }
        })
        .into(),
        interface: SparseRows::default(),
        rim: vec![n - 1],
        facing: Vec::new(),
        left_out: Vec::new(),
    };
    let penalty = penalty
        .unwrap_or_else(|| DEFAULT_STIFFNESS_RATIO / compliance_weight(&a, &areas_for_penalty, |_| 0.0, 0.0));
    let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
    PlaneContact::new(submodel, PlaneContactSettings { body: 0, plane, penalty, method }).unwrap()
}

struct Impact {
    peak_force: f64,
    duration: f64,
    restitution: f64,
    energy_drift: f64,
    impulse: f64,
}

/// Classical Runge-Kutta steps of the sphere's translation from first touch to separation.
fn fly(contact: &mut Active<PlaneContact>, mass: f64, speed: f64) -> Impact {
    let h = 2e-8;
    let (mut z, mut v, mut t) = (RADIUS, -speed, 0.0);
    let mut force_at = |z: f64| {
        let state = BodyState {
            position: Vector3::new(0.0, 0.0, z),
            rotation: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            angular_velocity_in_body: Vector3::zeros(),
            elastic: Vec::new(),
            elastic_rates: Vec::new(),
        };
        let mut forces = vec![GeneralisedForce::zeros(0)];
        contact.evaluate(Motion::new(0.0, &[state]), &mut forces).unwrap();
        let energies = contact.energies();
        (forces[0].force.z, energies.elastic_high + energies.penalty)
    };
    let start = 0.5 * mass * speed * speed;
    let mut result =
        Impact { peak_force: 0.0, duration: 0.0, restitution: 0.0, energy_drift: 0.0, impulse: 0.0 };
    for _ in 0..20_000 {
        let a1 = force_at(z).0 / mass;
        let a2 = force_at(z + 0.5 * h * v).0 / mass;
        let a3 = force_at(z + 0.5 * h * v + 0.25 * h * h * a1).0 / mass;
        let a4 = force_at(z + h * v + 0.5 * h * h * a2).0 / mass;
        z += h * v + h * h / 6.0 * (a1 + a2 + a3);
        let gained = h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        v += gained;
        t += h;
        result.impulse += mass * gained;
        let (force, potential) = force_at(z);
        let energy = 0.5 * mass * v * v + potential;
        result.energy_drift = f64::max(result.energy_drift, (energy / start - 1.0).abs());
        result.peak_force = f64::max(result.peak_force, force);
        if v > 0.0 && force == 0.0 {
            result.duration = t;
            result.restitution = v / speed;
            return result;
        }
    }
    panic!("the sphere must part from the plane");
}

#[test]
fn impact_of_a_sphere_matches_hertz_and_keeps_its_energy() {
    let mass = 2789.0 * 4.0 / 3.0 * PI * RADIUS.powi(3);
    let hertz = HertzImpact::new(pair(), [mass, f64::INFINITY], 0.1);
    let mut contact = Active::new(contact(40, None, Method::ActiveSet));
    let impact = fly(&mut contact, mass, 0.1);
    // 40 rings: discretisation error below 1 %.
    assert!((impact.peak_force / hertz.peak_force() - 1.0).abs() < 1e-2, "{}", impact.peak_force);
    assert!((impact.duration / hertz.duration() - 1.0).abs() < 1e-2, "{}", impact.duration);
    // The force has a potential: only the error of the integration is left, at the kinks where rings touch.
    assert!(impact.energy_drift < 1e-6, "{}", impact.energy_drift);
    assert!((impact.restitution - 1.0).abs() < 1e-6, "{}", impact.restitution);
    let change = mass * 0.1 * (1.0 + impact.restitution);
    assert!((impact.impulse / change - 1.0).abs() < 1e-12); // the same sum twice
}

#[test]
fn algorithm_1_and_the_exact_constraint_give_the_same_impact() {
    let mass = 2789.0 * 4.0 / 3.0 * PI * RADIUS.powi(3);
    let mut active_set = Active::new(contact(20, None, Method::ActiveSet));
    let reference = fly(&mut active_set, mass, 0.1);
    let mut exact = Active::new(contact(20, Some(f64::INFINITY), Method::ActiveSet));
    // Springs of 1/40 of the surface's compliance or none: 0.2 %.
    let limit = fly(&mut exact, mass, 0.1);
    assert!((limit.peak_force / reference.peak_force - 1.0).abs() < 5e-3, "{}", limit.peak_force);
    let mut broyden = Active::new(contact(20, None, Method::Broyden(BroydenSettings::default())));
    let repeated = fly(&mut broyden, mass, 0.1);
    // ε = 1e-15 m of 1e-6 m.
    assert!((repeated.peak_force / reference.peak_force - 1.0).abs() < 1e-6, "{}", repeated.peak_force);
}
