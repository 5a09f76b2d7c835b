//! What all integrators promise alike: refusals and errors of the right-hand side, numbers that are not finite, end times, restarts.

#![expect(clippy::float_cmp, reason = "exact times and states are part of the claims")]

use crate::small_equations::{Given, PERIHELION, distance, kepler_rate};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::error::{EvaluationFailure, EvaluationFault, FailureKind, IntegrationFault, Rejection};
use ffr_dynamics::integration::{DenseOutput, Integrator, Method, OdeSystem, StepSettings};

const METHODS: [Method; 4] = [Method::DormandPrince, Method::TrBdf2, Method::Esdirk4, Method::Gauss];

fn integrator(method: Method, settings: StepSettings, y: &[f64], system: &impl OdeSystem) -> Integrator {
    Integrator::new(method, settings, 0.0, y, system).unwrap()
}

/// A fault of any kind.
#[derive(Debug, thiserror::Error)]
#[error("solver stopped after 45 iterations")]
struct Refusal(FailureKind);

impl EvaluationFault for Refusal {
    fn kind(&self) -> FailureKind {
        self.0
    }
}

/// `y' = 1`, refused beyond `t = limit` as often as `refusals` says; counts the calls of the protocol.
struct Refusing {
    inner: i32,
    saved: i32,
    saves: u32,
    restores: u64,
    refusals: u32,
    limit: f64,
    /// Time and state of the last evaluation.
    last: (f64, f64),
    kind: FailureKind,
}

impl OdeSystem for Refusing {
    fn dimension(&self) -> usize {
        1
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), EvaluationFailure> {
        self.inner += 1;
        self.last = (t, y[0]);
        if t > self.limit && self.refusals > 0 {
            self.refusals -= 1;
            return Err(Refusal(self.kind).into());
        }
        dydt[0] = 1.0;
        Ok(())
    }

    fn error_norm(&mut self, _y0: &[f64], _y1: &[f64], error: &[f64]) -> f64 {
        error[0].abs()
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn save(&mut self) {
        self.saved = self.inner;
        self.saves += 1;
    }

    fn restore(&mut self) {
        assert!(self.saves > 0, "nothing was saved");
        self.inner = self.saved;
        self.restores += 1;
    }
}

fn refusing(limit: f64, refusals: u32) -> Refusing {
    Refusing {
        inner: 0,
        saved: 0,
        saves: 0,
        restores: 0,
        refusals,
        limit,
        last: (0.0, 0.0),
        kind: FailureKind::IterationLimit,
    }
}

const LONG_FIRST_STEP: StepSettings = StepSettings {
    initial_step: Some(1.0),
    max_step: 1.0,
    is_fixed: false,
    stops_at_errors: false,
    is_vibration_exact: false,
};

#[test]
fn refusal_shrinks_the_step_and_the_inner_state_ends_with_the_step() {
    // Evaluations of the step from the saved state: the explicit stages without the first, which is known; the implicit
    // stages, solved at once for a constant rate, and the end.
    for (method, evaluations) in
        [(Method::DormandPrince, 6), (Method::TrBdf2, 3), (Method::Esdirk4, 6), (Method::Gauss, 5)]
    {
        let mut system = refusing(0.0, 3);
        let mut integrator = integrator(method, LONG_FIRST_STEP, &[0.0], &system);
        let step = integrator.step(&mut system, 10.0).unwrap();
        assert_eq!(step.rejected, 3);
        let statistics = integrator.statistics();
        assert_eq!((statistics.rejected, statistics.refused), (3, 3));
        assert_eq!(integrator.last_refusal().map(|r| r.kind()), Some(FailureKind::IterationLimit));
        // Back to the start after each attempt, and after differences of the right-hand side.
        assert_eq!((system.saves, system.restores), (1, 3 + statistics.jacobians), "{method:?}");
        assert_eq!(system.inner, evaluations, "{method:?}");
        assert_eq!(system.last, (step.end, integrator.state()[0]), "the inner state belongs to the end");
        assert!((integrator.state()[0] - step.end).abs() < 1e-15);
    }
}

#[test]
fn critical_errors_end_a_step_at_once_where_that_is_asked_for() {
    for method in METHODS {
        for (kind, stops, ends) in [
            (FailureKind::Singular, true, true),
            (FailureKind::NotFinite, true, true),
            (FailureKind::IterationLimit, true, false),
            (FailureKind::Singular, false, false),
        ] {
            let mut system = Refusing { kind, ..refusing(0.0, 2) };
            let mut integrator = integrator(method, LONG_FIRST_STEP, &[0.0], &system);
            integrator.stop_at_errors(stops);
            let outcome = integrator.step(&mut system, 10.0);
            assert_eq!(outcome.is_err(), ends, "{method:?} {kind} {stops}");
            assert_eq!(integrator.last_refusal().map(|r| r.kind()), Some(kind));
            if ends {
                assert_eq!(integrator.statistics().refused, 1);
                assert_eq!((integrator.time(), system.inner), (0.0, 0), "back at the start, state restored");
                // Another factor, say: the step can be taken now.
                system.refusals = 0;
                assert!(integrator.step(&mut system, 10.0).is_ok());
            }
        }
    }
}

#[test]
fn endless_refusal_ends_with_time_and_reason() {
    for method in METHODS {
        let mut system = refusing(0.5, u32::MAX);
        let settings = StepSettings::with_max_step(0.1);
        let mut integrator = Integrator::new(method, settings, 0.5, &[0.0], &system).unwrap();
        let error = integrator.step(&mut system, 1.0).unwrap_err();
        let DynamicsError::Integration { time, fault } = &error else { panic!("{error}") };
        assert_eq!(*time, 0.5);
        let IntegrationFault::StepTooShort { rejection: Rejection::Refused(refusal), .. } = fault else {
            panic!("{error}")
        };
        assert!(refusal.to_string().contains("45 iterations"), "{refusal}");
        assert!(error.to_string().contains("45 iterations") && error.to_string().contains("step fell to"));
        assert_eq!((integrator.time(), integrator.state()), (0.5, &[0.0][..]));
    }
}

#[test]
fn critical_errors_are_named_as_such_with_fixed_steps_too() {
    for method in METHODS {
        for (stops, words) in [(true, "solver stopped"), (false, "step fell to")] {
            let mut system = Refusing { kind: FailureKind::Singular, ..refusing(0.0, u32::MAX) };
            let mut integrator = integrator(method, StepSettings::fixed(0.1), &[0.0], &system);
            integrator.stop_at_errors(stops);
            let error = integrator.step(&mut system, 1.0).unwrap_err();
            let DynamicsError::Integration { fault, .. } = &error else { panic!("{error}") };
            assert_eq!(matches!(fault, IntegrationFault::Critical(_)), stops, "{method:?}: {fault}");
            assert!(fault.to_string().starts_with(words), "{method:?}: {fault}");
        }
    }
}

#[test]
fn nan_never_reaches_an_accepted_state() {
    // Explodes in finite time: y' = y².
    let rate = |_: f64, y: &[f64], d: &mut [f64]| d[0] = if y[0] > 1e3 { f64::NAN } else { y[0] * y[0] };
    let mut system = Given::new(1, 1e-6, rate);
    // The implicit methods may be late by their errors.
    for (method, latest) in [Method::DormandPrince, Method::TrBdf2, Method::Esdirk4, Method::Gauss]
        .map(|method| (method, if method == Method::DormandPrince { 1.0 } else { 1.0 + 1e-3 }))
    {
        let mut exploding = integrator(method, StepSettings::default(), &[1.0], &system);
        let mut finite = true;
        let error = exploding
            .run(&mut system, 2.0, |_, i| {
                finite &= i.state()[0].is_finite();
                true
            })
            .unwrap_err();
        assert!(finite && error.to_string().contains("not finite"), "{error}");
        assert!(exploding.time() < latest, "{method:?} {}", exploding.time());
        for start in [f64::NAN, 2e3] {
            let mut integrator = integrator(method, StepSettings::default(), &[start], &system);
            assert!(integrator.step(&mut system, 2.0).is_err());
        }
        let mut integrator = integrator(method, StepSettings::default(), &[0.0], &system);
        for t_end in [f64::INFINITY, f64::NAN] {
            assert!(integrator.step(&mut system, t_end).is_err());
        }
        assert!(integrator.set_max_step(-1.0).is_err());
    }
}

#[test]
fn steps_end_exactly_at_the_end_time_and_keep_their_size_afterwards() {
    for (method, tolerance) in [
        (Method::DormandPrince, 1e-8),
        (Method::TrBdf2, 1e-6),
        (Method::Esdirk4, 1e-6),
        (Method::Gauss, 1e-8),
    ] {
        let mut system = Given::new(4, tolerance, kepler_rate);
        let mut integrator = integrator(method, StepSettings::default(), &PERIHELION, &system);
        integrator.run(&mut system, 0.7, |_, _| true).unwrap();
        assert_eq!(integrator.time(), 0.7);
        let proposed = integrator.proposed_step();
        let steps = integrator.statistics().steps;
        integrator.step(&mut system, 0.7 + 1e-5 * proposed).unwrap();
        assert_eq!(integrator.time(), 0.7 + 1e-5 * proposed);
        assert!(integrator.proposed_step() >= proposed, "{method:?}");
        // At the end time already: nothing happens.
        integrator.step(&mut system, 0.7).unwrap();
        assert_eq!(integrator.statistics().steps, steps + 1);
    }
}

#[test]
fn restart_in_the_middle_of_a_step_repeats_the_rest_of_the_solution() {
    // The dense output is one order below the explicit solution, two below that of Gauss; in the implicit methods it has errors like the step.
    for (method, tolerance, limit) in [
        (Method::DormandPrince, 1e-10, 1e-8),
        (Method::TrBdf2, 1e-8, 1e-7),
        (Method::Esdirk4, 1e-8, 1e-7),
        (Method::Gauss, 1e-10, 1e-8),
    ] {
        let mut system = Given::new(4, tolerance, kepler_rate);
        let mut integrator = integrator(method, StepSettings::default(), &PERIHELION, &system);
        integrator.run(&mut system, std::f64::consts::PI, |_, _| true).unwrap();
        let (start, end) = integrator.interval();
        let (middle, mut y) = (0.5 * (start + end), vec![0.0; 4]);
        integrator.interpolate(middle, &mut y);
        let reference = integrator.state().to_vec();
        integrator.restart(middle, &y);
        assert_eq!(integrator.interval(), (middle, middle));
        integrator.run(&mut system, std::f64::consts::PI, |_, _| true).unwrap();
        let error = distance(integrator.state(), &reference);
        assert!(error < limit, "{method:?} {error:e}");
    }
}
