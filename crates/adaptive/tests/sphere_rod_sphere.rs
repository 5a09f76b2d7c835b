//! Steel sphere, aluminium rod, gap of 1 um, steel sphere (\[A\] section 5): refined by the program.

use crate::rod_impacts::{finished, sphere_rod_sphere};
use adaptive::record::PhaseKind;
use adaptive::record::TrialOutcome;
use adaptive::spec::PenaltySearch;

fn near(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value:e}, expected {expected:e}");
}

#[test]
fn two_separate_impacts_are_found_refined_and_simulated() {
    let trace = finished(&sphere_rod_sphere(PenaltySearch::CONVERGED));
    let kinds: Vec<PhaseKind> = trace.phases.iter().map(|p| p.kind).collect();
    assert_eq!(kinds, [PhaseKind::Impact, PhaseKind::Free, PhaseKind::Impact, PhaseKind::Free]);
    let [first, second] = trace.impacts[..] else { panic!("two impacts: {:?}", trace.impacts) };
    assert_eq!((first.contact, second.contact), (0, 1));
    // Two independent programs agree to 0.3 % on 73.40 N and 10.48 N; times to a microsecond.
    near(first.peak_force, 73.40, 5e-3);
    near(second.peak_force, 10.48, 5e-3);
    for (time, expected) in
        [(first.start, 0.0), (first.end, 145.4e-6), (second.start, 256.2e-6), (second.end, 382.0e-6)]
    {
        assert!((time - expected).abs() < 1e-6, "{time:e} {expected:e}");
    }
    let last = trace.samples.last().expect("a sample");
    near(last.bodies[0].velocity[2], -0.0752, 1e-2);
    near(last.bodies[2].velocity[2], 0.0211, 1e-2);
    let start = &trace.samples[0];
    let energy = start.energies.total();
    for sample in &trace.samples {
        // The limit asked for; the error control of 1e-8 per step keeps below a tenth of it.
        near(sample.energies.total(), energy, 1e-6);
        // Equal and opposite forces, summed up in about 5000 steps.
        near(sample.linear_momentum[2], start.linear_momentum[2], 1e-12);
    }
    assert!(trace.samples.windows(2).all(|w| w[0].time < w[1].time), "times rise");
}

#[test]
fn predictors_need_one_trial_an_impact() {
    let trace = finished(&sphere_rod_sphere(PenaltySearch::CONVERGED));
    let trials: Vec<(u32, u32, &str)> =
        trace.trials.iter().map(|t| (t.impact, t.number, t.outcome.identifier())).collect();
    assert_eq!(trials, [(0, 1, "accepted"), (1, 1, "accepted")], "{:?}", trace.trials);
    for accepted in trace.trials.iter().filter(|t| t.outcome == TrialOutcome::Accepted) {
        assert!((0.6..=0.8).contains(&accepted.utilisation[0]), "{accepted:?}");
        assert!(accepted.steps > 0 && accepted.interface_dofs > 0 && accepted.wall_time > 0.0);
    }
}

#[test]
fn transfers_keep_energy_and_momentum() {
    let trace = finished(&sphere_rod_sphere(PenaltySearch::CONVERGED));
    let directions: Vec<&str> = trace.transfers.iter().map(|t| t.direction.identifier()).collect();
    assert_eq!(directions, ["coarse to fine", "fine to coarse"].repeat(2));
    for transfer in &trace.transfers {
        // The modes are the same on both sides, and the contact is open.
        let jump = (transfer.energy_after - transfer.energy_before).abs();
        assert!(jump < 1e-10 * transfer.energy_before, "{transfer:?}");
        assert!(transfer.momentum_change < 1e-14 * trace.samples[0].linear_momentum[2], "{transfer:?}");
    }
}
