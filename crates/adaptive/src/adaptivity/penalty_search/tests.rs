//! What a search does next, outcome after outcome.

use super::super::overlap::MOST_OVERLAP_OF_WAVES;
use super::*;

/// As printed in \[A\] section 4.1: trials of 30 contact steps.
const PRINTED: PenaltyStrategy = PenaltyStrategy::ErrorDriven { trial_steps: 30 };
use approx::assert_relative_eq;

/// Runs a search on a solver that fails above `limit` and gives a peak force `force(c_p)`.
fn run(search: &mut PenaltySearch, limit: f64, force: impl Fn(f64) -> f64) -> (PenaltyAction, Vec<f64>) {
    let (mut action, mut log) = (search.restart(), Vec::new());
    for _ in 0..100 {
        let (penalty, trial) = match action {
            PenaltyAction::Run { penalty, contact_steps } => (penalty, contact_steps.is_some()),
            PenaltyAction::Resume { penalty } => (penalty, false),
            done => return (done, log),
        };
        log.push(penalty);
        let outcome = match (penalty > limit, trial) {
            (true, _) => RunOutcome::SolverError,
            (false, true) => RunOutcome::TrialPassed,
            (false, false) => RunOutcome::Completed { peak_force: force(penalty), overlap: None },
        };
        action = search.next(outcome);
    }
    (action, log)
}

fn accepted(action: PenaltyAction) -> f64 {
    match action {
        PenaltyAction::Accept { penalty, .. } => penalty,
        other => panic!("not accepted: {other:?}"),
    }
}

#[test]
fn the_printed_search_raises_by_ten_and_lowers_the_multiplier() {
    let mut search = PenaltySearch::new(PRINTED, 1e15);
    assert_eq!(search.restart(), PenaltyAction::Run { penalty: 1e15, contact_steps: Some(30) });
    let (action, log) = run(&mut search, 5.5e16, |_| 70.0);
    assert_relative_eq!(accepted(action), 5e16, max_relative = 1e-14);
    let expected = [1e15, 1e16, 1e17, 9e16, 8e16, 7e16, 6e16, 5e16];
    assert_eq!(log.len(), expected.len());
    for (found, wanted) in log.iter().zip(expected) {
        assert_relative_eq!(*found, wanted, max_relative = 1e-14);
    }
}

#[test]
fn after_an_error_the_impact_goes_on_and_may_fail_again() {
    let mut search = PenaltySearch::new(PRINTED, 2e17);
    search.restart();
    let first = search.next(RunOutcome::SolverError);
    assert_eq!(first, PenaltyAction::Resume { penalty: 1e17 });
    let PenaltyAction::Resume { penalty } = search.next(RunOutcome::SolverError) else {
        panic!("the impact must go on")
    };
    assert_relative_eq!(penalty, 9e16, max_relative = 1e-14);
    let done = search.next(RunOutcome::Completed { peak_force: 3.0, overlap: None });
    assert!(matches!(done, PenaltyAction::Accept { is_last_run: true, .. }));
}

#[test]
fn a_converged_force_is_accepted_in_two_runs() {
    let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e17);
    let (action, log) = run(&mut search, f64::INFINITY, |c| 70.0 * (1.0 - 1e14 / c));
    assert_eq!(log.len(), 2);
    assert_relative_eq!(accepted(action), 1e18, max_relative = 1e-14);
}

#[test]
fn a_share_of_penetration_that_bounds_the_change_needs_no_second_run() {
    // Half the share beside a fifth of a percent; between flat faces springs ring, and the share says nothing.
    for (share, pressing, is_enough) in
        [(3.9e-3, Pressing::Body, true), (4.1e-3, Pressing::Body, false), (1e-4, Pressing::Waves, false)]
    {
        let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e17);
        search.restart();
        let overlap = Some(Overlap { share, pressing });
        let next = search.next(RunOutcome::Completed { peak_force: 70.0, overlap });
        assert_eq!(matches!(next, PenaltyAction::Accept { is_last_run: true, .. }), is_enough, "{share}");
    }
}

/// Peak `K δⁿ` of a body that brings one unit of energy onto a contact whose force at a given approach `δ` springs of share
/// `s (δ/δ₀)^m` lower by `n s (δ/δ₀)^m` (Eq. A.44), over that with rigid springs.
fn peak_with_springs(n: f64, m: f64, share: f64) -> f64 {
    let force = |x: f64| x.powf(n) * (1.0 - n * share * x.powf(m));
    // Approach relative to that with rigid springs, by the midpoint rule on its way and by bisection.
    let energy =
        |end: f64| (0..4000).map(|k| force(end * (f64::from(k) + 0.5) / 4000.0)).sum::<f64>() * end / 4000.0;
    let (mut low, mut high) = (1.0, 1.1);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if energy(middle) < 1.0 / (n + 1.0) { low = middle } else { high = middle }
    }
    force(low)
}

#[test]
fn peaks_change_by_less_than_half_the_share() {
    let share = 1e-3;
    // Springs in series with a linear contact, under lines, spheres and cones: pressures rise with the powers `m + 1` of the approach.
    for (n, m, wanted) in [(1.0, 0.0, 0.5), (1.0, -0.5, 1.0 / 3.0), (1.5, -0.5, 0.375), (2.0, -0.999, 0.001)]
    {
        let change = (1.0 - peak_with_springs(n, m, share)) / share;
        // Terms of second order in the share, and the rule's error at the root-like start.
        assert!((change - wanted).abs() < 5e-3, "{n} {m} {change}");
        let overlap = Overlap { share, pressing: Pressing::Body };
        assert!(overlap.peak_change().is_some_and(|most| change * share < most + 5e-3 * share));
    }
}

#[test]
fn a_force_that_still_changes_asks_for_more() {
    let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e15);
    let (action, log) = run(&mut search, f64::INFINITY, |c| 70.0 * (1.0 - 1e14 / c));
    assert_eq!(log.len(), 4); // changes 9 %, 0.9 %, 0.09 %
    assert_relative_eq!(accepted(action), 1e18, max_relative = 1e-14);
}

#[test]
fn an_error_on_the_way_up_returns_to_the_completed_run() {
    let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e15);
    let (action, _) = run(&mut search, 2e15, |c| 70.0 * (1.0 - 1e14 / c));
    assert_eq!(action, PenaltyAction::Accept { penalty: 1e15, is_last_run: false });
}

#[test]
fn errors_are_answered_in_the_running_impact_as_printed() {
    let given = PenaltySearch::new(PenaltyStrategy::Fixed, 1e18);
    let printed = PenaltySearch::new(PRINTED, 1e18);
    let converged = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e18);
    assert!(printed.is_resuming(), "from the first error on");
    assert!(!given.is_resuming() && !given.accepted().is_resuming());
    // A run on the way up is compared with the one before, so that it keeps its factor.
    assert!(!converged.is_resuming() && converged.accepted().is_resuming());
}

#[test]
fn an_accepted_factor_takes_one_run() {
    let mut search = PenaltySearch::from_accepted(PenaltyStrategy::CONVERGED, 1e18);
    let (action, log) = run(&mut search, f64::INFINITY, |_| 10.0);
    assert_eq!(log.len(), 1);
    assert_relative_eq!(accepted(action), 1e18);
    let mut printed = PenaltySearch::from_accepted(PRINTED, 1e18);
    assert_eq!(printed.restart(), PenaltyAction::Run { penalty: 1e18, contact_steps: None });
    assert_relative_eq!(accepted(run(&mut printed, 8.5e17, |_| 10.0).0), 8e17);
}

#[test]
fn a_fixed_factor_is_run_once_and_never_changed() {
    let mut search = PenaltySearch::new(PenaltyStrategy::Fixed, 3.3e16);
    assert_relative_eq!(accepted(run(&mut search, f64::INFINITY, |_| 1.0).0), 3.3e16);
    let mut failing = PenaltySearch::new(PenaltyStrategy::Fixed, 3.3e16);
    assert!(matches!(run(&mut failing, 1.0, |_| 1.0).0, PenaltyAction::Fail(_)));
}

#[test]
fn searches_that_cannot_end_fail_with_their_numbers() {
    let mut endless = PenaltySearch::new(PRINTED, 1e15);
    let (action, _) = run(&mut endless, f64::INFINITY, |_| 1.0);
    let PenaltyAction::Fail(failure) = action else { panic!("must fail: {action:?}") };
    assert!(failure.to_string().contains("1.000e28"), "{failure}");
    let mut hopeless = PenaltySearch::new(PRINTED, 1e15);
    let (action, _) = run(&mut hopeless, 0.0, |_| 1.0);
    assert!(matches!(action, PenaltyAction::Fail(PenaltyFailure::TooLow { .. })), "{action:?}");
    let mut drifting = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e15);
    let (action, _) = run(&mut drifting, f64::INFINITY, |c| c);
    let PenaltyAction::Fail(failure) = action else { panic!("must fail: {action:?}") };
    assert!(failure.to_string().contains("90.000 %"), "{failure}");
}

#[test]
fn a_changed_model_restarts_the_comparison() {
    let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e15);
    search.restart();
    search.next(RunOutcome::Completed { peak_force: 10.0, overlap: None });
    assert!(matches!(search.restart(), PenaltyAction::Run { .. }));
    let next = search.next(RunOutcome::Completed { peak_force: 10.0, overlap: None });
    assert!(matches!(next, PenaltyAction::Run { .. }), "a run on another model is no evidence: {next:?}");
}

#[test]
fn bodies_that_lie_in_each_other_are_no_result() {
    let error = RunOutcome::SolverError;
    let completed = |share, pressing| RunOutcome::Completed {
        peak_force: 1.0,
        overlap: Some(Overlap { share, pressing }),
    };
    // Springs in series: of 20 % penetration 80 % is deformation, which stays.
    // 1.1 (0.2/0.8)/(0.1/0.9) = 2.475, rounded up to a tenth of a decade.
    let missing = 10_f64.powf(0.4);
    for (strategy, pressing, rise) in [
        (PenaltyStrategy::CONVERGED, Pressing::Body, 10.0),
        (PenaltyStrategy::UntilStiff, Pressing::Body, 10.0),
        (PenaltyStrategy::UntilStiff, Pressing::Waves, missing),
    ] {
        let soft = completed(2.0 * MOST_OVERLAP_OF_WAVES, pressing);
        let stiff = completed(0.9 * Overlap { share: 0.0, pressing }.most(), pressing);
        // The force is the same each time: only the overlap asks for more.
        let mut search = PenaltySearch::new(strategy, 1e13);
        search.restart();
        for penalty in [rise * 1e13, rise * rise * 1e13] {
            let next = search.next(soft);
            assert!(
                matches!(next, PenaltyAction::Run { penalty: p, .. } if (p / penalty - 1.0).abs() < 1e-12),
                "{next:?}"
            );
        }
        let done = search.next(stiff);
        assert!(matches!(done, PenaltyAction::Accept { is_last_run: true, .. }), "{done:?}");
        // A factor that an earlier impact found.
        let mut known = PenaltySearch::from_accepted(strategy, 1e13);
        known.restart();
        assert!(matches!(known.next(soft), PenaltyAction::Run { .. }));
        // Nothing higher can be solved.
        let failed = known.next(error);
        assert!(matches!(failed, PenaltyAction::Fail(PenaltyFailure::TooSoft { .. })), "{failed:?}");
    }
    let soft = completed(2.0 * MOST_OVERLAP_OF_WAVES, Pressing::Waves);
    // Nothing higher is tried.
    let mut highest = PenaltySearch::new(PenaltyStrategy::UntilStiff, PenaltyRange::default().upper);
    highest.restart();
    assert!(matches!(highest.next(soft), PenaltyAction::Fail(PenaltyFailure::TooSoft { .. })));
    // Lowered until the solver found forces.
    let mut lowered = PenaltySearch::new(PRINTED, 1e13);
    lowered.restart();
    lowered.next(error);
    assert!(matches!(lowered.next(soft), PenaltyAction::Fail(PenaltyFailure::TooSoft { .. })));
    // The user's own factor.
    let mut given = PenaltySearch::new(PenaltyStrategy::Fixed, 1e13);
    assert!(matches!(given.next(soft), PenaltyAction::Accept { .. }));
}

#[test]
fn factors_round_to_integer_multipliers() {
    let factor = |v| PenaltyFactor::from_value(v);
    assert_eq!(factor(5e16), Some(PenaltyFactor { multiplier: 5, exponent: 16 }));
    assert_eq!(factor(9.7e16), Some(PenaltyFactor { multiplier: 1, exponent: 17 }));
    assert_eq!((factor(0.0), factor(f64::NAN), factor(f64::INFINITY)), (None, None, None));
}
