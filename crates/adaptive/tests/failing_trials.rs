//! Impacts that cannot be simulated: what is reported before, and what the error says.

use crate::impacts::{ALUMINIUM, STEEL, Trace, body, contact, law, spec, sphere, try_run};
use adaptive::AdaptiveError;
use adaptive::record::PhaseKind;
use adaptive::record::TrialOutcome;
use adaptive::run::recording::Recording;
use adaptive::spec::{
    ContactLaw, ContactSpec, IntervalSpec, PenaltySearch, RunSpec, StressInstant, StressSpec, SurfaceLaw,
    Target,
};
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use iga_core::nurbs::primitives::axisymmetric;

const RADIUS: f64 = 10e-3; // m
const SPEED: f64 = 0.1; // m/s
const GAP: f64 = 1e-6; // m

fn with_law(law: SurfaceLaw) -> ContactSpec {
    ContactSpec { law: ContactLaw::Surface(law), ..contact("impact", 0, Target::Body(1)) }
}

/// A steel sphere flies at an aluminium one.
fn pair(contact: ContactSpec) -> RunSpec {
    let bodies = vec![
        sphere("left", RADIUS, STEEL, (-RADIUS - GAP, SPEED)),
        sphere("right", RADIUS, ALUMINIUM, (RADIUS, 0.0)),
    ];
    spec(bodies, vec![contact], 1.5e-4)
}

fn failed(spec: &RunSpec) -> (Trace, AdaptiveError) {
    let mut trace = Trace::default();
    let error = try_run(spec, &mut trace).expect_err("an error");
    // The flight up to the impact is there, the states of the failing trial follow in order of time.
    assert!(trace.samples.windows(2).all(|w| w[0].time < w[1].time), "times rise");
    assert_eq!(trace.phases.last().map(|p| p.kind), Some(PhaseKind::Impact));
    let last = trace.trials.last().expect("a trial");
    assert_eq!(last.outcome, TrialOutcome::Failed);
    assert_eq!(last.reason, error.to_string());
    assert!(trace.trials.iter().rev().skip(1).all(|t| t.outcome == TrialOutcome::Rejected));
    assert!(error.to_string().contains("\"impact\""), "the pair is named: {error}");
    let number = format!("{}", trace.trials.len());
    assert!(error.to_string().contains(&number), "the number of trials is there: {error}");
    (trace, error)
}

/// A sphere against the end of a short thin rod, whose radius of 0.3 mm its contact radius reaches.
fn sphere_on_thin_rod(first: usize) -> RunSpec {
    let (radius, length, big) = (0.3e-3, 3e-3, 50e-3);
    let rod = axisymmetric::rod(radius, length).expect("a rod");
    let bodies = vec![
        sphere("sphere", big, STEEL, (-big - GAP, 30.0)),
        body("rod", rod, ALUMINIUM, [4, 40], 6, (0.0, 0.0)),
    ];
    spec(bodies, vec![contact("impact", first, Target::Body(1 - first))], 1e-5)
}

#[test]
fn run_that_fails_keeps_its_stress_lines() {
    let mut spec = sphere_on_thin_rod(1);
    spec.stress.push(StressSpec {
        name: "axis".into(),
        body: 1,
        ends: [[0.0, 0.0], [0.0, 1e-3]].map(|[r, z]| [r, z, 0.0]),
        samples: 3,
        at: StressInstant::PeakForce,
    });
    let (trace, _) = failed(&spec);
    let [record] = &trace.stresses[..] else { panic!("{} lines", trace.stresses.len()) };
    assert!(record.von_mises.iter().all(|s| s.is_finite()) && record.time > 0.0);
}

#[test]
fn contact_over_the_end_of_the_surface_is_an_error_that_says_where() {
    let (trace, error) = failed(&sphere_on_thin_rod(1));
    let AdaptiveError::IntervalAtEdge { time, trials, .. } = error else { panic!("{error}") };
    assert!(time > 0.0 && trials as usize == trace.trials.len());
    assert!(trace.samples.last().is_some_and(|s| s.contacts[0].normal_force > 0.0), "the trial is stored");
}

#[test]
fn contact_over_the_end_of_the_target_is_an_error_as_well() {
    let (_, error) = failed(&sphere_on_thin_rod(0));
    assert!(matches!(error, AdaptiveError::IntervalAtEdge { .. }), "{error}");
}

#[test]
fn interval_that_no_width_can_please_is_the_narrowest_that_holds_the_contact() {
    // 15 of 16 elements are less than 96 %, and 16 of 16 touch the edge.
    let mut law = law();
    law.interval.min_utilisation = 0.96;
    law.interval.target_utilisation = 0.97;
    let mut trace = Trace(Recording::default());
    try_run(&pair(with_law(law)), &mut trace).expect("no error");
    assert!(trace.trials.len() < 12, "{}", trace.trials.len());
    let last = trace.trials.last().expect("a trial");
    assert!(last.reason.contains("narrower intervals do not hold the contact"), "{}", last.reason);
    // One element more at either end than an interval whose edges were touched.
    assert!(last.utilisation[0] >= 12.0 / 16.0, "{:?}", last.utilisation);
}

#[test]
fn search_for_an_error_that_never_comes_names_the_highest_factor() {
    let law = SurfaceLaw { search: PenaltySearch::UntilError, penalty: Some(1e25), ..law() };
    let (trace, error) = failed(&pair(with_law(law)));
    assert!(matches!(error, AdaptiveError::Penalty { .. }), "{error}");
    assert!(error.to_string().contains("search until convergence"), "{error}");
    // 1e25, 1e26, 1e27, 1e28
    assert_eq!(trace.trials.len(), 4);
}

#[test]
fn given_factor_that_the_solver_cannot_use_is_an_error_with_a_remedy() {
    let method = Method::Broyden(BroydenSettings::default());
    let law = SurfaceLaw { search: PenaltySearch::Fixed, penalty: Some(1e27), method, ..law() };
    let (_, error) = failed(&pair(with_law(law)));
    assert!(matches!(error, AdaptiveError::Penalty { .. }), "{error}");
    assert!(error.to_string().contains("active-set"), "{error}");
}

#[test]
fn interrupt_in_a_trial_keeps_what_was_computed() {
    let stop = GAP / SPEED + 3e-5;
    let mut trace = Trace(Recording { stop_at: Some(stop), ..Recording::default() });
    let end = try_run(&pair(with_law(law())), &mut trace).expect("no error");
    assert!(end.is_interrupted && end.time >= stop);
    let last = trace.trials.last().expect("a trial");
    assert_eq!(last.outcome, TrialOutcome::Interrupted);
    assert!((last.stop - end.time).abs() < 1e-15);
    assert!((trace.last().time - end.time).abs() < 1e-15);
    assert!(trace.last().contacts[0].normal_force > 0.0);
    assert!(trace.samples.windows(2).all(|w| w[0].time < w[1].time));
    assert_eq!(trace.phases.len(), 2);
    assert!((trace.impacts[0].end - end.time).abs() < 1e-15);
}

/// Stopped while the fine model of trial `done + 1` is built.
fn stopped_in_a_build(done: usize, law: SurfaceLaw) -> Trace {
    let mut trace = Trace(Recording { stop_after_trials: Some(done), ..Recording::default() });
    let end = try_run(&pair(with_law(law)), &mut trace).expect("no error");
    assert!(end.is_interrupted);
    // The end of the flight: trials start anew from there.
    assert!((end.time - GAP / SPEED).abs() < 1e-12 && (trace.last().time - end.time).abs() < 1e-15);
    assert_eq!(trace.phases.len(), 2);
    assert!(trace.impacts.is_empty());
    let outcomes: Vec<&str> = trace.trials.iter().map(|t| t.outcome.identifier()).collect();
    assert_eq!(outcomes.last(), Some(&"interrupted"));
    assert_eq!((outcomes.len(), trace.trials[done].number as usize), (done + 1, done + 1));
    trace
}

#[test]
fn interrupt_while_a_fine_model_is_built_ends_the_run_there() {
    stopped_in_a_build(0, law());
    // Far too narrow, so that the second trial needs another model.
    let narrow = SurfaceLaw { interval: IntervalSpec { width: Some(3e-5), ..law().interval }, ..law() };
    let trace = stopped_in_a_build(1, narrow);
    assert_eq!(trace.trials[0].outcome, TrialOutcome::Rejected);
    assert!(trace.trials[0].peak_force > 0.0, "{:?}", trace.trials[0]);
}

#[test]
fn fine_model_that_cannot_be_built_leaves_a_failed_trial() {
    let mut law = law();
    // A compliance of 100,000 unknowns.
    law.interval.elements = Some(100_000);
    let mut trace = Trace::default();
    let error = try_run(&pair(with_law(law)), &mut trace).expect_err("an error");
    assert!(matches!(error, AdaptiveError::Subdivision { .. }), "{error}");
    assert_eq!(trace.trials.len(), 1);
    assert_eq!(
        (trace.trials[0].outcome.identifier(), &trace.trials[0].reason),
        ("failed", &error.to_string())
    );
    assert!((trace.last().time - GAP / SPEED).abs() < 1e-12, "the flight is there");
}
