//! An aluminium rod with a spherical end on a rigid plane: example II of Rückwald, Held and Seifried (2021), section 6.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::support::{Table, Trace, assert_below, assert_close, deviation, interpolate, run};

// Claim 10 of docs/verification.md.
const TRACE_TOLERANCE: f64 = 1e-2;
const CONTACT_END: f64 = 538.5e-6; // s, finite elements
const CONTACT_END_TOLERANCE: f64 = 3e-6; // s
const REBOUND: f64 = 0.2973; // m/s, finite elements
const LENGTH: f64 = 1.0; // m
const WAVE_SPEED: f64 = 5109.0; // m/s, sqrt(E / rho)
const V0: f64 = 0.3; // m/s
/// Section behind the spherical end at which the wave field is plane again: five radii \[m\].
const NEAR: f64 = 0.05;

/// The scenario as shipped, with two more observed points: near the contact and in the middle.
fn shipped_run() -> &'static Trace {
    static RUN: OnceLock<Trace> = OnceLock::new();
    RUN.get_or_init(|| {
        run(
            "rod_on_plane",
            &[
                "output.points.near.body=rod",
                &format!("output.points.near.point=[0.0,{NEAR}]"),
                "output.points.middle.body=rod",
                "output.points.middle.point=[0.0,0.5]",
            ],
        )
    })
}

/// Axial velocity of an observed point in every stored state [m/s].
fn velocity(trace: &Trace, name: &str) -> Vec<f64> {
    let i = trace.layout.points.iter().position(|p| p.name == name).expect("observed point");
    trace.history(|s| s.points[i].velocity[2])
}

#[test]
fn rod_force_and_velocities_follow_the_finite_element_trace() {
    let (trace, table) = (shipped_run(), Table::read("rod_on_plane_fe"));
    let (times, reference) = (trace.times(), table.column("t"));
    let force = deviation(&times, &trace.force(), &reference, &table.column("force"));
    assert_below("force along the curve", force, TRACE_TOLERANCE);
    for (point, column) in [("far_end", "far_velocity"), ("middle", "mid_velocity")] {
        let v = deviation(&times, &velocity(trace, point), &reference, &table.column(column));
        assert_below(&format!("velocity, {point}"), v, TRACE_TOLERANCE);
    }
    assert_close("peak force", trace.impact().peak_force, 1340.97, TRACE_TOLERANCE);
}

#[test]
fn rod_contact_ends_and_rebounds_as_in_the_finite_element_solution() {
    let trace = shipped_run();
    let impact = trace.impact();
    println!("contact ends at {:.3} us", impact.end * 1e6);
    assert!((impact.end - CONTACT_END).abs() <= CONTACT_END_TOLERANCE, "ends at {:e} s", impact.end);
    assert_close("rebound of the centre of mass", impact.separation_velocity, REBOUND, 1e-2);
    assert_below("energy drift", trace.energy_drift(), 1e-6);
    let momentum = |i: usize| trace.samples[i].linear_momentum[2];
    let change = momentum(trace.samples.len() - 1) - momentum(0);
    assert_close("impulse", impact.impulse, change, 1e-9);
}

/// In a thin rod the contact force sends out the velocity wave `f(t) = F(t) / (A rho c)`, which both ends reflect. The n-th
/// arrival is the delay at which the wave `f(t - delay)` fits best, by least squares, what the waves before it leave of the
/// recorded velocity. A fit of the whole wave instead of its front, which has no beginning: the force grows as t^1.5.
#[test]
fn rod_waves_arrive_at_multiples_of_the_travel_time() {
    let trace = shipped_run();
    let (times, force) = (trace.times(), trace.force());
    let impedance = PI * 0.01f64.powi(2) * (72.8e9f64 * 2789.0).sqrt();
    let f = |t: f64| if t <= 0.0 { 0.0 } else { interpolate(&times, &force, t) / impedance };
    let travel = LENGTH / WAVE_SPEED;
    let (far, near) = (velocity(trace, "far_end"), velocity(trace, "near"));
    let at = |v: &[f64], t: f64| interpolate(&times, v, t) + V0;
    let near_time = NEAR / WAVE_SPEED;
    // Multiple, window in travel times, what earlier waves leave there, and how the wave shows.
    type Wave<'a> = Box<dyn Fn(f64) -> f64 + 'a>;
    let cases: [(f64, [f64; 2], Wave, Wave); 3] = [
        (1.0, [0.8, 2.9], Box::new(|t| at(&far, t)), Box::new(|t| 2.0 * f(t))),
        (
            2.0,
            [1.6, 2.9],
            Box::new(|t| at(&near, t) - f(t - near_time)),
            Box::new(|t| f(t + near_time) + f(t - near_time)),
        ),
        (3.0, [2.7, 4.0], Box::new(|t| at(&far, t) - 2.0 * f(t - travel)), Box::new(|t| 2.0 * f(t))),
    ];
    for (multiple, window, rest, wave) in cases {
        let misfit = |delay: f64| -> f64 {
            let n = 400;
            let time = |i: usize| travel * (window[0] + (window[1] - window[0]) * i as f64 / n as f64);
            (0..=n).map(|i| (rest(time(i)) - wave(time(i) - delay)).powi(2)).sum()
        };
        // 0.02 % steps, ten times finer than what is claimed.
        let delays = (-300..=300).map(|k| multiple * travel * (1.0 + 2e-4 * f64::from(k)));
        let best = delays.min_by(|a, b| misfit(*a).total_cmp(&misfit(*b))).expect("delays");
        assert_close(&format!("arrival {multiple}"), best, multiple * travel, 1e-2);
    }
}

#[test]
fn rod_run_does_the_work_it_is_known_to_need() {
    // A snapshot, +- 10 %, as for the sphere. The free flight takes five steps of these.
    let phases = &shipped_run().phases;
    assert_eq!(phases.len(), 2, "impact, then free flight");
    let count = |f: fn(&adaptive::record::PhaseRecord) -> u64| phases.iter().map(f).sum::<u64>() as f64;
    assert_close("steps", count(|p| p.steps), 820.0, 0.1);
    assert_close("evaluations", count(|p| p.evaluations), 4947.0, 0.1);
}
