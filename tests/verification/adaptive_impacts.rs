//! Impacts that the program refines by itself: sphere, rod and sphere, without any contact setting.

use std::sync::OnceLock;

use adaptive::record::{PhaseKind, TrialOutcome};

use super::support::{Trace, assert_below, assert_close, run};

/// The scenario as shipped.
fn shipped() -> &'static Trace {
    static RUN: OnceLock<Trace> = OnceLock::new();
    RUN.get_or_init(|| run("sphere_rod_sphere", &[]))
}

#[test]
fn two_separate_impacts_have_the_peaks_and_times_of_the_references() {
    // Two independent programs agree to 0.3 %: contact, from and to [s], peak [N].
    const IMPACTS: [(u32, f64, f64, f64); 2] = [(0, 0.0, 145.4e-6, 73.40), (1, 256.2e-6, 382.0e-6, 10.48)];
    // Bounds from the project.
    const PEAK: f64 = 5e-3;
    const TIME: f64 = 1e-6; // s
    let trace = shipped();
    assert_eq!((trace.impacts.len(), &trace.failure), (2, &None));
    for (impact, (contact, start, end, peak)) in trace.impacts.iter().zip(IMPACTS) {
        assert_eq!(impact.contact, contact);
        assert_close("peak force", impact.peak_force, peak, PEAK);
        assert_below("start", (impact.start - start).abs(), TIME);
        assert_below("end", (impact.end - end).abs(), TIME);
    }
}

#[test]
fn spheres_leave_with_the_velocities_of_the_references() {
    // A bound from the project; the spheres are free after the impacts, so that the last state counts.
    const VELOCITY: f64 = 1e-2;
    let last = shipped().samples.last().expect("samples");
    assert_close("left sphere", last.bodies[0].velocity[2], -0.0752, VELOCITY);
    assert_close("right sphere", last.bodies[2].velocity[2], 0.0211, VELOCITY);
}

#[test]
fn energy_and_momentum_are_kept_through_all_changes_of_the_model() {
    let trace = shipped();
    assert_below("energy drift", trace.energy_drift(), 1e-5);
    let start = trace.samples[0].linear_momentum[2];
    let change =
        trace.history(|s| (s.linear_momentum[2] / start - 1.0).abs()).into_iter().fold(0.0, f64::max);
    // Forces are equal and opposite up to round-off.
    assert_below("change of momentum", change, 1e-12);
    let directions: Vec<&str> = trace.transfers.iter().map(|t| t.direction.identifier()).collect();
    assert_eq!(directions, ["coarse to fine", "fine to coarse"].repeat(2));
    let energy = trace.samples[0].energies.total();
    let jumps = trace.transfers.iter().map(|t| (t.energy_after - t.energy_before).abs() / energy);
    assert_below("jump of a transfer", jumps.fold(0.0, f64::max), 1e-5);
}

#[test]
fn predictors_need_two_trials_at_first_and_one_later() {
    let trace = shipped();
    let accepted: Vec<_> = trace.trials.iter().filter(|t| t.outcome == TrialOutcome::Accepted).collect();
    assert_eq!(accepted.len(), 2, "{:#?}", trace.trials);
    for (trial, most) in accepted.iter().zip([2, 1]) {
        assert!(trial.number <= most, "{trial:?}");
        let used = trial.utilisation[0];
        assert!((0.6..=0.8).contains(&used), "{used}");
        // Seconds of work, measured while a trial runs.
        assert!(trial.wall_time > 0.0 && trial.cpu_time > 0.0, "{trial:?}");
    }
}

#[test]
fn fine_models_with_modes_of_their_own_give_the_same_peaks() {
    /// Claim 12 of docs/verification.md.
    const PEAK: f64 = 5e-3;
    /// Claim 2 of docs/verification.md.
    const JUMP: f64 = 1e-5;
    for transfer in ["projection", "printed"] {
        let set: Vec<String> = ["first", "second"]
            .iter()
            .flat_map(|c| [format!("contacts.{c}.modes=own"), format!("contacts.{c}.transfer={transfer}")])
            .collect();
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let own = run("sphere_rod_sphere", &set);
        assert_eq!((own.impacts.len(), &own.failure, own.transfers.len()), (2, &None, 4));
        for (a, b) in own.impacts.iter().zip(&shipped().impacts) {
            assert_close("peak force", a.peak_force, b.peak_force, PEAK);
        }
        let energy = own.samples[0].energies.total();
        for t in &own.transfers {
            assert_below("jump of energy", (t.energy_after - t.energy_before).abs() / energy, JUMP);
        }
    }
}

#[test]
fn states_of_impacts_are_stored_as_often_as_asked_for_and_events_stay_the_same() {
    let interval = 1e-6;
    // Without the cap for a phase, which leaves out steps that are shorter than the thousandth of the phase so far.
    let every = "output.phase_states=1e12";
    let full = &run("sphere_rod_sphere", &[every]);
    let thin = run("sphere_rod_sphere", &[every, &format!("output.impact_interval={interval}")]);
    // Where there is no restitution it is NaN, which equals nothing.
    assert_eq!(format!("{:?}", thin.impacts), format!("{:?}", full.impacts));
    for (i, phase) in thin.phases.iter().enumerate() {
        let times = |trace: &Trace| -> Vec<f64> {
            trace.samples.iter().filter(|s| s.phase as usize == i).map(|s| s.time).collect()
        };
        let (few, all) = (times(&thin), times(full));
        assert_eq!(few.last(), all.last(), "the end of phase {i}");
        if phase.kind != PhaseKind::Impact {
            assert_eq!(few, all);
            continue;
        }
        assert!(
            few.len() < all.len() / 2 && few.iter().all(|t| all.contains(t)),
            "{} of {}",
            few.len(),
            all.len()
        );
        let (_, but_last) = few.split_last().expect("states");
        assert!(but_last.windows(2).all(|w| w[1] - w[0] >= interval));
    }
}
