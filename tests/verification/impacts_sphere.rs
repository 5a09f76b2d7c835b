//! An aluminium sphere on a rigid plane: example I of Rückwald, Held and Seifried (2021), section 5.

use std::sync::OnceLock;

use super::support::{Table, Trace, assert_below, assert_close, deviation, run, run_on};

// Hertz's half space (docs/theory.md Eqs. C.22, C.23): closed forms at 0.1 m/s.
const HERTZ_PEAK: f64 = 51.70; // N
const HERTZ_DURATION: f64 = 83.13e-6; // s
// The ball is finite: it is really 0.7 % stiffer than a half space, and 0.5 % shorter in contact.
const HERTZ_TOLERANCE: f64 = 1.5e-2;
// Limit of the mesh in two programs (52.06 N and 52.08 N).
const CONVERGED_PEAK: f64 = 52.07; // N
const CONVERGED_TOLERANCE: f64 = 1e-3;
// The trace itself is good for 0.02 %; the rest is points that come into contact one by one.
const TRACE_TOLERANCE: f64 = 5e-3;
const ENERGY_DRIFT: f64 = 1e-6;
// Impulse and momentum come from one integration; what is left is round-off over 500 steps.
const IMPULSE_TOLERANCE: f64 = 1e-9;
// Converged value here and in the finite element solution (527.8 MPa); Hertz gives 530 MPa.
const MISES: f64 = 528e6; // Pa
const MISES_TOLERANCE: f64 = 2e-2;
const MISES_DEPTH: f64 = 80e-6; // m
const MISES_DEPTH_TOLERANCE: f64 = 5e-6; // m

/// The scenario as shipped.
fn shipped_run() -> &'static Trace {
    static RUN: OnceLock<Trace> = OnceLock::new();
    RUN.get_or_init(|| run("sphere_on_plane", &[]))
}

#[test]
fn sphere_peak_force_and_duration_match_hertz() {
    let impact = shipped_run().impact();
    assert_close("peak force", impact.peak_force, HERTZ_PEAK, HERTZ_TOLERANCE);
    assert_close("duration", impact.end - impact.start, HERTZ_DURATION, HERTZ_TOLERANCE);
}

#[test]
fn sphere_force_follows_the_finite_element_trace() {
    let (trace, table) = (shipped_run(), Table::read("sphere_on_plane_fe"));
    let times = table.column("t");
    let force = deviation(&trace.times(), &trace.force(), &times, &table.column("force"));
    assert_below("force along the curve", force, TRACE_TOLERANCE);
    let velocity = trace.history(|s| s.linear_momentum[2]);
    let mass = -velocity[0] / 0.1;
    let velocity: Vec<f64> = velocity.iter().map(|p| p / mass).collect();
    let velocity = deviation(&trace.times(), &velocity, &times, &table.column("com_velocity"));
    assert_below("velocity of the centre of mass", velocity, TRACE_TOLERANCE);
}

#[test]
fn sphere_peak_force_is_converged_in_mesh() {
    // Half the element size changes the peak by less than 0.05 %.
    const HALVING: f64 = 5e-4;
    let fine = run("sphere_on_plane", &["bodies.ball.discretisation.refine[0].elements=64"]);
    assert_close(
        "peak, shipped mesh",
        shipped_run().impact().peak_force,
        CONVERGED_PEAK,
        CONVERGED_TOLERANCE,
    );
    assert_close("peak, fine mesh", fine.impact().peak_force, CONVERGED_PEAK, CONVERGED_TOLERANCE);
    assert_close(
        "shipped against fine",
        shipped_run().impact().peak_force,
        fine.impact().peak_force,
        HALVING,
    );
}

#[test]
fn sphere_rebounds_without_loss() {
    // Steps ten times as exact as shipped: the ledger is that of the contact, not that of the steps.
    let trace = run("sphere_on_plane", &["simulation.impact.rtol=1e-8"]);
    let impact = trace.impact();
    // Vibration keeps 2e-6 of the velocity; whatever goes beyond 1e-4 would be lost.
    assert_below("restitution short of one", (1.0 - impact.restitution).abs(), 1e-4);
    assert_below("energy drift", trace.energy_drift(), ENERGY_DRIFT);
    let momentum = |i: usize| trace.samples[i].linear_momentum[2];
    let change = momentum(trace.samples.len() - 1) - momentum(0);
    assert_close("impulse", impact.impulse, change, IMPULSE_TOLERANCE);
}

#[test]
fn sphere_stress_on_the_axis_is_that_of_hertz() {
    for points in ["greville", "gauss"] {
        let set = format!("contacts.impact.points={points}");
        let trace = run("sphere_on_plane", &[&set]);
        let record = &trace.stresses[0];
        let top = record.von_mises.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let (i, mises) = top.expect("points");
        let depth = record.points[i][2] - record.points[0][2];
        assert_close(&format!("{points}: von Mises stress"), *mises, MISES, MISES_TOLERANCE);
        println!("{points}: depth {:.1} um", depth * 1e6);
        assert!((depth - MISES_DEPTH).abs() <= MISES_DEPTH_TOLERANCE, "{points}: at {depth:e} m");
        // Hertz on the axis, nu 0.33: both lateral stresses are equal, no shear.
        let s = record.stress[i];
        assert_close(&format!("{points}: hoop over radial stress"), s[2] / s[0], 1.0, 1e-6);
        assert_close(&format!("{points}: time of the record"), record.time, trace.impact().peak_time, 1e-2);
    }
}

#[test]
fn sphere_run_does_the_work_it_is_known_to_need() {
    // A snapshot, +- 10 %: points that open and close move step ends a little from machine to machine.
    let phase = shipped_run().phases[0];
    println!("{} steps, {} rejected, {} evaluations", phase.steps, phase.rejected, phase.evaluations);
    assert_eq!(shipped_run().phases.len(), 1, "the end comes within the quiet time");
    assert_close("steps", phase.steps as f64, 286.0, 0.1);
    assert_close("evaluations", phase.evaluations as f64, 1772.0, 0.1);
}

#[test]
fn sphere_run_is_the_same_on_one_and_two_threads() {
    let two = run_on(2, "sphere_on_plane", &[]);
    assert!(shipped_run().samples == two.samples, "bitwise equal samples");
    assert!(shipped_run().stresses == two.stresses, "bitwise equal stresses");
}
