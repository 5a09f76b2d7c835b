//! Implicit methods on small equations, TR-BDF2 unless said otherwise: orders, stability, numerical damping, events.

#![expect(clippy::float_cmp, reason = "exact times and states are part of the claims")]

use crate::small_equations::{ECCENTRICITY, Given, PERIHELION, distance, kepler_rate, slope};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::integration::{
    CrossingSearch, DenseOutput, Integrator, KinematicBlock, Linearisation, Method, OdeSystem, StepSettings,
};

fn run(system: &mut impl OdeSystem, settings: StepSettings, y: &[f64], t_end: f64) -> Integrator {
    let mut integrator = Integrator::new(Method::TrBdf2, settings, 0.0, y, system).unwrap();
    integrator.run(system, t_end, |_, _| true).unwrap();
    integrator
}

fn van_der_pol(stiffness: f64) -> impl FnMut(f64, &[f64], &mut [f64]) {
    move |_, y, dydt| {
        dydt[0] = y[1];
        dydt[1] = stiffness * ((1.0 - y[0] * y[0]) * y[1]) - y[0];
    }
}

fn oscillator(omega: f64) -> impl FnMut(f64, &[f64], &mut [f64]) {
    move |_, y, dydt| dydt.copy_from_slice(&[y[1], -omega * omega * y[0]])
}

#[test]
fn global_error_drops_with_order_two() {
    let aphelion = [-(1.0 + ECCENTRICITY), 0.0, 0.0, -1.0 / PERIHELION[3]];
    let errors: Vec<(f64, f64)> = [800.0, 1600.0, 3200.0]
        .map(|n| {
            let h = std::f64::consts::PI / n;
            // The tolerance only steers Newton's method here: far below the error of the steps.
            let mut system = Given::new(4, 1e-10, kepler_rate);
            let run = run(&mut system, StepSettings::fixed(h), &PERIHELION, std::f64::consts::PI);
            assert_eq!(run.statistics().steps as f64, n);
            (h, distance(run.state(), &aphelion))
        })
        .to_vec();
    let measured = slope(&errors);
    assert!((measured - 2.0).abs() < 0.1, "order {measured}, errors {errors:?}");
}

#[test]
fn error_estimate_drops_with_order_three_and_has_the_size_of_the_error() {
    // One step of the given size from the same state: the estimate against the true error.
    let omega = std::f64::consts::TAU;
    let pairs: Vec<(f64, f64, f64)> = [0.005, 0.0025, 0.00125]
        .map(|h| {
            let mut system = Given::new(2, 1.0, oscillator(omega));
            let settings = StepSettings { initial_step: Some(h), max_step: h, ..StepSettings::default() };
            let mut integrator =
                Integrator::new(Method::TrBdf2, settings, 0.0, &[0.0, omega], &system).unwrap();
            let step = integrator.step(&mut system, 1.0).unwrap();
            assert_eq!(step.end, h);
            let exact = [(omega * h).sin(), omega * (omega * h).cos()];
            (h, step.error, distance(integrator.state(), &exact))
        })
        .to_vec();
    let estimates: Vec<_> = pairs.iter().map(|p| (p.0, p.1)).collect();
    let measured = slope(&estimates);
    assert!((measured - 3.0).abs() < 0.1, "order {measured}, {pairs:?}");
    // The third-order companion is what it is compared with: equal up to a term smaller by hω = 0.008, and the filter.
    let (_, estimate, error) = pairs[2];
    assert!((estimate / error - 1.0).abs() < 0.1, "{pairs:?}");
}

#[test]
fn interpolant_has_the_order_of_the_steps_and_meets_both_ends() {
    let omega = std::f64::consts::TAU;
    let mut errors = Vec::new();
    for n in [160.0_f64, 320.0, 640.0] {
        let mut system = Given::new(2, 1e-9, oscillator(omega));
        let mut integrator =
            Integrator::new(Method::TrBdf2, StepSettings::fixed(1.0 / n), 0.0, &[0.0, omega], &system)
                .unwrap();
        integrator.step(&mut system, 1.0).unwrap();
        let (start, end) = integrator.interval();
        let (mut worst, mut y) = (0.0_f64, [0.0; 2]);
        for i in 1..20 {
            let t = start + (end - start) * f64::from(i) / 20.0;
            integrator.interpolate(t, &mut y);
            worst = worst.max(distance(&y, &[(omega * t).sin(), omega * (omega * t).cos()]));
        }
        errors.push((1.0 / n, worst));
        integrator.interpolate(start, &mut y);
        assert_eq!(y, [0.0, omega]);
        assert_eq!(integrator.previous_state(), y);
        integrator.interpolate(end, &mut y);
        assert!(distance(&y, integrator.state()) < 1e-14);
    }
    // A local error of order three, as the step itself.
    let measured = slope(&errors);
    assert!((measured - 3.0).abs() < 0.1, "order {measured}, errors {errors:?}");
}

#[test]
fn interpolant_of_an_unresolved_mode_stays_within_its_amplitude() {
    let omega = 1e6;
    let mut system = Given::new(2, 1e9, oscillator(omega));
    let mut integrator =
        Integrator::new(Method::TrBdf2, StepSettings::fixed(1e-2), 0.0, &[1.0, 0.0], &system).unwrap();
    integrator.step(&mut system, 1.0).unwrap();
    let mut y = [0.0; 2];
    for i in 0..=50 {
        integrator.interpolate(2e-4 * f64::from(i), &mut y);
        // The cubic through 1, -1 and 0 with slope of order one at the end overshoots a little.
        assert!(y[0].abs() < 1.6, "{y:?}");
    }
}

#[test]
fn stiff_relaxation_follows_its_slow_solution_with_steps_far_beyond_the_fast_scale() {
    for lambda in [-1e2, -1e4, -1e8] {
        let rate = move |t: f64, y: &[f64], dydt: &mut [f64]| dydt[0] = lambda * (y[0] - t.cos()) - t.sin();
        let mut system = Given::new(1, 1e-5, rate);
        let run = run(&mut system, StepSettings::default(), &[2.0], 10.0);
        let statistics = run.statistics();
        // An initial layer of size one, then cos t with h³ / 50 = 1e-5: about 100 steps.
        assert!((run.state()[0] - 10.0_f64.cos()).abs() < 1e-4, "λ = {lambda}: {:?}", run.state());
        assert!(statistics.steps < 250, "λ = {lambda}: {statistics:?}");
    }
}

#[test]
fn unresolved_motion_is_gone_after_one_step() {
    // R(z) tends to zero like 1/z, faster than that of the trapezoidal rule, which tends to -1.
    let mut leftovers = Vec::new();
    for lambda in [-1e4, -1e6, -1e8] {
        let mut system = Given::new(1, 1e9, move |_: f64, y: &[f64], d: &mut [f64]| d[0] = lambda * y[0]);
        let mut integrator =
            Integrator::new(Method::TrBdf2, StepSettings::fixed(1.0), 0.0, &[1.0], &system).unwrap();
        integrator.step(&mut system, 10.0).unwrap();
        leftovers.push((-lambda, integrator.state()[0].abs()));
    }
    let measured = slope(&leftovers);
    assert!((measured + 1.0).abs() < 0.01, "{leftovers:?}");
}

#[test]
fn energy_of_an_oscillator_never_grows_and_its_loss_is_that_of_the_stability_function() {
    let omega = 50.0_f64;
    for h in [1e-3, 1e-2, 1e-1, 1.0, 10.0] {
        let mut system = Given::new(2, 1e-6, oscillator(omega));
        system.blocks = vec![KinematicBlock::Vector { position: 0, velocity: 1, len: 1 }];
        let mut integrator =
            Integrator::new(Method::TrBdf2, StepSettings::fixed(h), 0.0, &[1.0, 20.0], &system).unwrap();
        let energy = |y: &[f64]| 0.5 * (omega * y[0]).powi(2) + 0.5 * y[1] * y[1];
        let before = energy(integrator.state());
        integrator.step(&mut system, 1e9).unwrap();
        let kept = energy(integrator.state()) / before;
        // |R(iz)|² with R(z) = (1 + (1 - 2 d) z) / (1 - d z)²: both parts have the denominator 1 - d z.
        let (z, d) = (h * omega, 1.0 - std::f64::consts::FRAC_1_SQRT_2);
        let expected = (1.0 + ((1.0 - 2.0 * d) * z).powi(2)) / (1.0 + (d * z).powi(2)).powi(2);
        assert!(kept <= 1.0 && (kept - expected).abs() < 1e-9, "h = {h}: kept {kept}, expected {expected}");
    }
}

#[test]
fn stiff_van_der_pol_agrees_with_the_explicit_method_at_a_fraction_of_the_steps() {
    let t_end = 1.2; // through the first fast transition at t ≈ 0.81 (in units of the slow time)
    let scaled = |eps: f64| {
        move |_: f64, y: &[f64], d: &mut [f64]| {
            d[0] = y[1];
            d[1] = ((1.0 - y[0] * y[0]) * y[1] - y[0]) / eps;
        }
    };
    let start = [2.0, -0.66];
    let mut system = Given::new(2, 1e-9, scaled(1e-3));
    let mut reference =
        Integrator::new(Method::DormandPrince, StepSettings::default(), 0.0, &start, &system).unwrap();
    reference.run(&mut system, t_end, |_, _| true).unwrap();
    system.tolerance = 1e-4;
    let mut implicit =
        Integrator::new(Method::TrBdf2, StepSettings::default(), 0.0, &start, &system).unwrap();
    implicit.run(&mut system, t_end, |_, _| true).unwrap();
    // Error per step 1e-4 on a velocity that reaches 1e3 in the transition.
    assert!(distance(implicit.state(), reference.state()) < 1e-3, "{:?}", implicit.state());
    assert_eq!(implicit.method(), Method::TrBdf2);
    let statistics = implicit.statistics();
    assert!(statistics.factorisations < statistics.steps + statistics.rejected, "{statistics:?}");
}

#[test]
fn work_of_standard_problems_stays_as_recorded() {
    let mut system = Given::new(4, 1e-6, kepler_rate);
    let dense = run(&mut system, StepSettings::default(), &PERIHELION, std::f64::consts::TAU).statistics();
    system.blocks = vec![KinematicBlock::Vector { position: 0, velocity: 2, len: 2 }];
    let structured =
        run(&mut system, StepSettings::default(), &PERIHELION, std::f64::consts::TAU).statistics();
    let mut system = Given::new(2, 1e-4, van_der_pol(100.0));
    let stiff = run(&mut system, StepSettings::default(), &[2.0, 0.0], 200.0).statistics();
    let work = [dense, structured, stiff]
        .map(|s| [s.steps, s.rejected, s.evaluations, s.iterations, s.jacobians, s.factorisations]);
    assert_eq!(work, WORK);
}

/// Steps, rejections, evaluations, iterations, Jacobians, factorisations: Kepler dense and structured, van der Pol.
const WORK: [[u64; 6]; 3] =
    [[357, 0, 1359, 1353, 1, 147], [357, 0, 1359, 1353, 1, 147], [757, 68, 3759, 3686, 24, 569]];

#[test]
fn known_kinematics_give_the_solution_of_the_dense_matrix() {
    let mut system = Given::new(4, 1e-9, kepler_rate);
    let settings = StepSettings::fixed(0.01);
    let dense = run(&mut system, settings, &PERIHELION, 1.0);
    system.blocks = vec![KinematicBlock::Vector { position: 0, velocity: 2, len: 2 }];
    let structured = run(&mut system, settings, &PERIHELION, 1.0);
    // Both converge to a Newton tolerance of 3e-11 a stage, 200 stages.
    assert!(distance(dense.state(), structured.state()) < 1e-8);
    assert!(structured.statistics().evaluations < dense.statistics().evaluations + 10);
}

#[test]
fn turning_quaternion_with_quadrature_follows_the_closed_form() {
    // dQ/dt = ½ Q (0, ω), ω' = -3 (ω - ω_0 e_z), quadrature of ω_z.
    let rate = |_: f64, y: &[f64], d: &mut [f64]| {
        let (q, w) = (&y[0..4], &y[4..7]);
        d[0] = -0.5 * (q[1] * w[0] + q[2] * w[1] + q[3] * w[2]);
        d[1] = 0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]);
        d[2] = 0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]);
        d[3] = 0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]);
        d[4] = -3.0 * w[0];
        d[5] = -3.0 * w[1];
        d[6] = -3.0 * (w[2] - 10.0);
        d[7] = w[2];
    };
    let mut system = Given::new(8, 1e-7, rate);
    system.blocks = vec![KinematicBlock::Rotation { quaternion: 0, velocity: 4 }];
    let start = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let run = run(&mut system, StepSettings::default(), &start, 1.0);
    let angle = 10.0 - 10.0 / 3.0 * (1.0 - (-3.0_f64).exp());
    let y = run.state();
    let expected = [(0.5 * angle).cos(), 0.0, 0.0, (0.5 * angle).sin()];
    // 1e-7 per step, some hundred steps, errors of one sign.
    assert!(distance(&y[0..4], &expected) < 3e-5, "{y:?}");
    assert!((y[7] - angle).abs() < 3e-5);
    let statistics = run.statistics();
    // The matrix knows how the quaternion turns: at most two iterations per stage, and one Jacobian for all.
    assert!(statistics.iterations <= 4 * statistics.steps && statistics.jacobians == 1, "{statistics:?}");
}

#[test]
fn overlapping_kinematics_are_refused() {
    let mut system = Given::new(4, 1e-9, kepler_rate);
    system.blocks = vec![KinematicBlock::Vector { position: 0, velocity: 1, len: 2 }];
    let error =
        Integrator::new(Method::TrBdf2, StepSettings::default(), 0.0, &PERIHELION, &system).unwrap_err();
    assert!(error.to_string().contains(": 1 of 4 is named twice"), "{error}");
    system.blocks = vec![KinematicBlock::Plain { start: 2, len: 3 }];
    assert!(Integrator::new(Method::TrBdf2, StepSettings::default(), 0.0, &PERIHELION, &system).is_err());
}

#[test]
fn constant_coefficients_need_one_jacobian_and_one_iteration_a_stage() {
    let mut system = Given::new(2, 1e-6, oscillator(7.0));
    let run = run(&mut system, StepSettings::fixed(0.01), &[1.0, 0.0], 1.0);
    let s = run.statistics();
    assert_eq!((s.jacobians, s.factorisations, s.iterations), (1, 1, 2 * s.steps));
}

/// A rate that changes its sign with every evaluation: no implicit equation has a solution.
struct Flipping(f64);

impl OdeSystem for Flipping {
    fn dimension(&self) -> usize {
        1
    }

    fn rhs(&mut self, _t: f64, _y: &[f64], dydt: &mut [f64]) -> Result<(), EvaluationFailure> {
        self.0 = -self.0;
        dydt[0] = self.0;
        Ok(())
    }

    fn error_norm(&mut self, _y0: &[f64], _y1: &[f64], error: &[f64]) -> f64 {
        error[0].abs() / 1e-8
    }

    fn linearise(
        &mut self,
        _t: f64,
        _y: &[f64],
        derivative: &mut Linearisation,
    ) -> Result<(), EvaluationFailure> {
        derivative.velocity_column_mut(0).fill(0.0);
        Ok(())
    }
}

#[test]
fn newton_without_solution_shrinks_the_step_and_then_names_the_remedy() {
    let mut system = Flipping(1e9);
    let mut integrator =
        Integrator::new(Method::TrBdf2, StepSettings::with_max_step(0.3), 1.0, &[0.0], &system).unwrap();
    let error = integrator.step(&mut system, 3.0).unwrap_err();
    let DynamicsError::Integration { time, fault } = &error else { panic!("{error}") };
    assert_eq!(*time, 1.0);
    let text = fault.to_string();
    assert!(text.contains("Newton") && text.contains("force that jumps"), "{text}");
    let statistics = integrator.statistics();
    assert!(statistics.rejected > 10 && statistics.jacobians == 1, "{statistics:?}");
    assert_eq!(integrator.state(), [0.0]);
}

#[test]
fn crossing_is_found_along_the_interpolant() {
    let omega = std::f64::consts::TAU;
    let mut system = Given::new(2, 1e-7, oscillator(omega));
    let mut integrator =
        Integrator::new(Method::TrBdf2, StepSettings::default(), 0.0, &[0.0, omega], &system).unwrap();
    let mut search = CrossingSearch::new(2, 1e-12, 4);
    let mut found = None;
    while found.is_none() {
        integrator.step(&mut system, 1.0).unwrap();
        found = search.first_crossing(&integrator, |_, y| y[0] + 0.5).unwrap();
    }
    let crossing = found.unwrap();
    // sin 2πt = -1/2 at t = 7/12; 1e-7 per step, some hundred steps, over the slope 2π · 0.87.
    assert!((crossing.time - 7.0 / 12.0).abs() < 1e-5, "{crossing:?}");
    assert!(crossing.value <= 0.0 && crossing.time - crossing.before <= 1e-12, "{crossing:?}");
}

/// The method of order four at time zero.
fn order_four(system: &impl OdeSystem, settings: StepSettings, y: &[f64]) -> Integrator {
    Integrator::new(Method::Esdirk4, settings, 0.0, y, system).unwrap()
}

#[test]
fn global_error_of_the_other_method_drops_with_order_four() {
    let aphelion = [-(1.0 + ECCENTRICITY), 0.0, 0.0, -1.0 / PERIHELION[3]];
    let errors = [100.0, 200.0, 400.0].map(|n| {
        let h = std::f64::consts::PI / n;
        // The tolerance only steers Newton's method here: far below the error of the steps.
        let mut system = Given::new(4, 1e-12, kepler_rate);
        let mut integrator = order_four(&system, StepSettings::fixed(h), &PERIHELION);
        integrator.run(&mut system, std::f64::consts::PI, |_, _| true).unwrap();
        (h, distance(integrator.state(), &aphelion))
    });
    let measured = slope(&errors);
    assert!((measured - 4.0).abs() < 0.15, "order {measured}, errors {errors:?}");
}

#[test]
fn its_error_estimate_and_its_interpolant_have_order_four() {
    let omega = std::f64::consts::TAU;
    let (mut estimates, mut interpolated) = (Vec::new(), Vec::new());
    for h in [0.04, 0.02, 0.01] {
        let mut system = Given::new(2, 1.0, oscillator(omega));
        let settings = StepSettings { initial_step: Some(h), max_step: h, ..StepSettings::default() };
        let mut integrator = order_four(&system, settings, &[0.0, omega]);
        let step = integrator.step(&mut system, 1.0).unwrap();
        assert_eq!(step.end, h);
        estimates.push((h, step.error));
        let (mut worst, mut y) = (0.0_f64, [0.0; 2]);
        for i in 1..20 {
            let t = h * f64::from(i) / 20.0;
            integrator.interpolate(t, &mut y);
            worst = worst.max(distance(&y, &[(omega * t).sin(), omega * (omega * t).cos()]));
        }
        interpolated.push((h, worst));
        integrator.interpolate(h, &mut y);
        assert!(distance(&y, integrator.state()) < 1e-14);
    }
    for (errors, what) in [(&estimates, "estimate"), (&interpolated, "interpolant")] {
        let measured = slope(errors);
        assert!((measured - 4.0).abs() < 0.15, "{what}: order {measured}, {errors:?}");
    }
}

#[test]
fn its_interpolant_of_an_unresolved_mode_stays_within_the_amplitude() {
    for omega in [3e2, 1e3, 1e4, 1e6] {
        let mut system = Given::new(2, 1e9, oscillator(omega));
        let mut integrator = order_four(&system, StepSettings::fixed(1e-2), &[1.0, 0.0]);
        integrator.step(&mut system, 1.0).unwrap();
        let mut y = [0.0; 2];
        for i in 0..=50 {
            integrator.interpolate(2e-4 * f64::from(i), &mut y);
            assert!(y[0].abs() < 1.05, "{omega:e}: {y:?}");
        }
    }
}

#[test]
fn order_four_needs_fewer_evaluations_and_keeps_more_of_what_rings() {
    // A hundred periods, both methods with the same tolerance.
    let omega = std::f64::consts::TAU;
    let work = |method: Method| {
        let mut system = Given::new(2, 1e-5 * omega, oscillator(omega));
        let mut integrator =
            Integrator::new(method, StepSettings::default(), 0.0, &[0.0, omega], &system).unwrap();
        integrator.run(&mut system, 100.0, |_, _| true).unwrap();
        let y = integrator.state();
        (integrator.statistics().evaluations, 1.0 - y[0].hypot(y[1] / omega))
    };
    let ((few, kept), (many, lost)) = (work(Method::Esdirk4), work(Method::TrBdf2));
    assert!(few < many && kept > 0.0 && kept < 0.5 * lost, "{few} {kept:e}, {many} {lost:e}");
}
