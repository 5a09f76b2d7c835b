//! The search for the penalty factor as printed ([A] Fig. 3) with the solver as printed (Algorithm 1), on [A] section 5.

use crate::impacts::{ALUMINIUM, STEEL, Trace, body, contact, finished, law, spec, sphere};
use adaptive::record::{TransferDirection, TrialOutcome};
use adaptive::spec::{ContactLaw, ContactSpec, PenaltySearch, RunSpec, SurfaceLaw, Target};
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use iga_core::nurbs::primitives::axisymmetric;

const RADIUS: f64 = 10e-3; // m
const LENGTH: f64 = 1.0; // m
/// First penalty factor [N/m^3].
const INITIAL: f64 = 1e15;

fn sphere_rod_sphere(end: f64) -> RunSpec {
    let rod = axisymmetric::rod(RADIUS, LENGTH).expect("a rod");
    let bodies = vec![
        sphere("left", RADIUS, STEEL, (-RADIUS, 0.1)),
        body("rod", rod, ALUMINIUM, [4, 200], 20, (0.0, 0.0)),
        sphere("right", RADIUS, STEEL, (LENGTH + RADIUS + 1e-6, 0.0)),
    ];
    let printed = SurfaceLaw {
        search: PenaltySearch::UntilError,
        penalty: Some(INITIAL),
        method: Method::Broyden(BroydenSettings::default()),
        ..law()
    };
    let pair = |name, body| ContactSpec {
        law: ContactLaw::Surface(printed.clone()),
        ..contact(name, body, Target::Body(1))
    };
    let mut spec = spec(bodies, vec![pair("first", 0), pair("second", 2)], end);
    // Lowering a factor takes energy out of the penalty springs, and is booked; how often it happens depends on the round-off at which the solver
    // fails (9.1e-4 and 1.1e-3 of the energy were seen with zones that differ in depth). The springs never hold more than 1/40 of the energy of the
    // contact (A.25), which is what a run may lose so before it has failed; what is not booked is asked for below.
    spec.settings.energy_tolerance = 1.0 / 40.0;
    spec
}

/// The penalty factors of contact `i` in the samples, repetitions left out.
fn factors(trace: &Trace, i: usize) -> Vec<f64> {
    let mut factors: Vec<f64> =
        trace.samples.iter().map(|s| s.contacts[i].penalty).filter(|p| p.is_finite()).collect();
    factors.dedup();
    factors
}

/// The first impact raises by tens in trials of 30 steps with contact, then lowers in the running impact.
fn check_first_search(trace: &Trace) {
    for t in &trace.trials {
        println!(
            "{} {:?} {:.4e} -> {:.4e} {} steps {:.2} s: {}",
            t.impact, t.outcome, t.penalty_start, t.penalty_end, t.steps, t.wall_time, t.reason
        );
    }
    println!("factors {:?}", factors(trace, 0));
    let first: Vec<_> = trace.trials.iter().filter(|t| t.impact == 0).collect();
    let (last, raised) = first.split_last().expect("tries");
    assert!(raised.len() >= 2, "the factor is raised");
    for (n, t) in raised.iter().enumerate() {
        let expected = INITIAL * 10f64.powi(n as i32);
        assert!((t.penalty_start / expected - 1.0).abs() < 1e-12, "{t:?}");
        assert!((t.penalty_start / t.penalty_end - 1.0).abs() < 1e-12);
        assert_eq!(t.outcome, TrialOutcome::Rejected);
        assert!(t.reason.contains("trial passed"), "{}", t.reason);
    }
    // The trial in which the error occurs goes on from the failing step: one trial that starts high and ends low.
    assert_eq!(last.outcome, TrialOutcome::Accepted);
    assert!((last.penalty_start / raised[raised.len() - 1].penalty_start - 10.0).abs() < 1e-9, "{last:?}");
    assert!(last.penalty_end < last.penalty_start, "{last:?}");
    let used = factors(trace, 0);
    assert!(used.windows(2).all(|w| w[1] < w[0]), "only lower: {used:?}");
    for factor in &used {
        let multiplier = factor / 10f64.powi(factor.log10().floor() as i32);
        assert!((multiplier - multiplier.round()).abs() < 1e-9, "{factor:e}");
    }
    let lowered = trace.transfers.iter().filter(|t| t.direction == TransferDirection::Penalty).count();
    assert!(lowered >= 1);
}

/// Largest change of the total energy beside the jumps booked for changes of the penalty factor, relative.
fn unaccounted(trace: &Trace) -> f64 {
    let start = trace.samples[0].energies.total();
    let jumps = |time: f64| -> f64 {
        trace.transfers.iter().filter(|t| t.time < time).map(|t| t.energy_after - t.energy_before).sum()
    };
    let drift = trace.samples.iter().map(|s| (s.energies.total() - start - jumps(s.time)).abs() / start);
    drift.fold(0.0, f64::max)
}

#[test]
fn printed_search_raises_in_trials_and_lowers_in_the_running_impact() {
    let trace = finished(&sphere_rod_sphere(8e-6));
    check_first_search(&trace);
    // Claim 1 of docs/verification.md.
    assert!(unaccounted(&trace) < 1e-5, "{:e}", unaccounted(&trace));
}

#[test]
fn printed_search_ends_within_a_factor_of_ten_of_the_printed_factors() {
    let trace = finished(&sphere_rod_sphere(4.5e-4));
    check_first_search(&trace);
    println!("unaccounted {:.1e}, drift {:.1e}", unaccounted(&trace), trace.energy_drift());
    for impact in &trace.impacts {
        println!("{impact:?}");
    }
    assert!(unaccounted(&trace) < 1e-5, "{:e}", unaccounted(&trace));
    assert_eq!(trace.impacts.len(), 2);
    // [A] section 5: 5e16 and 1e17 N/m (per area: N/m^3).
    for (impact, printed) in [5e16, 1e17].into_iter().enumerate() {
        let end = trace.trials.iter().rfind(|t| t.impact as usize == impact).expect("a trial").penalty_end;
        assert!(end / printed < 10.0 && printed / end < 10.0, "impact {impact}: {end:e} beside {printed:e}");
    }
    // The second impact knows the ratio of stiffnesses and is simulated once.
    assert_eq!(trace.trials.iter().filter(|t| t.impact == 1).count(), 1);
    // Formulation section 8: 73.39 N, 10.47 N, found with the default search as well.
    assert!((trace.impacts[0].peak_force / 73.39 - 1.0).abs() < 5e-3);
    assert!((trace.impacts[1].peak_force / 10.47 - 1.0).abs() < 5e-3);
}
