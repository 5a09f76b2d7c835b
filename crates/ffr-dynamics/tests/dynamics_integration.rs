//! Dormand-Prince 5(4): orders, error control, projection, events.

#![expect(clippy::float_cmp, reason = "exact times and states are part of the claims")]

use crate::small_equations::{ECCENTRICITY, Given, PERIHELION, distance, kepler_rate, norm, slope};
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::integration::{CrossingSearch, DenseOutput, Integrator, OdeSystem, Slope, StepSettings};

fn kepler_run(settings: StepSettings, tolerance: f64, t_end: f64) -> Integrator {
    let mut integrator = Integrator::explicit(settings, 0.0, &PERIHELION).unwrap();
    integrator.run(&mut Given::new(4, tolerance, kepler_rate), t_end, |_, _| true).unwrap();
    integrator
}

/// A linear oscillator that turns once in a second in closed form.
struct Oscillator;

impl OdeSystem for Oscillator {
    fn dimension(&self) -> usize {
        2
    }

    fn rhs(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), EvaluationFailure> {
        let omega = std::f64::consts::TAU;
        dydt.copy_from_slice(&[omega * y[1], -omega * y[0]]);
        Ok(())
    }

    fn error_norm(&mut self, _y0: &[f64], _y1: &[f64], error: &[f64]) -> f64 {
        norm(error) / 1e-9
    }
}

#[test]
fn global_error_drops_with_order_five() {
    // Half a period: the exact state at aphelion is the reference.
    let aphelion = [-(1.0 + ECCENTRICITY), 0.0, 0.0, -1.0 / PERIHELION[3]];
    let errors: Vec<(f64, f64)> = [128.0, 256.0, 512.0]
        .map(|n| {
            let h = std::f64::consts::PI / n;
            let run = kepler_run(StepSettings::fixed(h), 1.0, std::f64::consts::PI);
            assert_eq!(run.statistics().steps as f64, n);
            (h, distance(run.state(), &aphelion))
        })
        .to_vec();
    let measured = slope(&errors);
    assert!((measured - 5.0).abs() < 0.1, "order {measured}, errors {errors:?}");
}

#[test]
fn dense_output_has_order_four_and_is_continuously_differentiable() {
    let mut errors = Vec::new();
    for n in [40.0_f64, 80.0, 160.0] {
        let mut integrator = Integrator::explicit(StepSettings::fixed(1.0 / n), 0.0, &[0.0, 1.0]).unwrap();
        let (mut worst, mut y) = (0.0_f64, [0.0; 2]);
        integrator.step(&mut Oscillator, 1.0).unwrap();
        let (start, end) = integrator.interval();
        for i in 1..20 {
            let t = start + (end - start) * f64::from(i) / 20.0;
            integrator.interpolate(t, &mut y);
            let angle = std::f64::consts::TAU * t;
            worst = worst.max(distance(&y, &[angle.sin(), angle.cos()]));
        }
        errors.push((1.0 / n, worst));
        integrator.interpolate(start, &mut y);
        assert_eq!(y, [0.0, 1.0]);
        integrator.interpolate(end, &mut y);
        assert!(distance(&y, integrator.state()) < 1e-15);
    }
    // An interpolant of order four has a local error of order five.
    let measured = slope(&errors);
    assert!((measured - 5.0).abs() < 0.1, "order {measured}, errors {errors:?}");
}

#[test]
fn error_is_proportional_to_the_tolerance() {
    let period = std::f64::consts::TAU;
    let errors: Vec<(f64, f64)> = [1e-6, 1e-8, 1e-10]
        .map(|tolerance| {
            let run = kepler_run(StepSettings::default(), tolerance, period);
            (tolerance, distance(run.state(), &PERIHELION))
        })
        .to_vec();
    // Control of the error per step: global error ~ tolerance^(5/6) at worst, tolerance^1 with equal shares.
    let measured = slope(&errors);
    assert!((0.75..1.1).contains(&measured), "slope {measured}, errors {errors:?}");
}

#[test]
fn work_of_a_standard_problem_stays_as_recorded() {
    let run = kepler_run(StepSettings::default(), 1e-8, std::f64::consts::TAU);
    let statistics = run.statistics();
    // Six evaluations per step (the seventh is the next step's first), two for the start.
    assert_eq!(statistics.evaluations, 6 * (statistics.steps + statistics.rejected) + 2);
    assert_eq!((statistics.steps, statistics.rejected), WORK);
}

/// Accepted and rejected steps of one orbit at the tolerance 1e-8.
const WORK: (u64, u64) = (80, 0);

#[test]
fn largest_step_is_respected() {
    let mut integrator = Integrator::explicit(StepSettings::with_max_step(0.01), 0.0, &PERIHELION).unwrap();
    let mut largest: f64 = 0.0;
    integrator
        .run(&mut Given::new(4, 1e-3, kepler_rate), 1.0, |_, i| {
            largest = largest.max(i.interval().1 - i.interval().0);
            true
        })
        .unwrap();
    assert!(largest <= 0.01 * (1.0 + 2e-6)); // a remainder of a millionth of a step is merged into the last one
    assert!(integrator.set_max_step(-1.0).is_err());
}

/// Oscillator whose state is put back on the unit circle after each step.
struct Projected {
    evaluations: u32,
}

impl OdeSystem for Projected {
    fn dimension(&self) -> usize {
        2
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), EvaluationFailure> {
        self.evaluations += 1;
        Oscillator.rhs(t, y, dydt)
    }

    fn error_norm(&mut self, y0: &[f64], y1: &[f64], error: &[f64]) -> f64 {
        Oscillator.error_norm(y0, y1, error)
    }

    fn project(&mut self, _t: f64, y: &mut [f64]) -> bool {
        let length = norm(y);
        y.iter_mut().for_each(|v| *v /= length);
        true
    }
}

#[test]
fn projection_costs_a_new_first_stage_and_keeps_the_invariant() {
    let mut system = Projected { evaluations: 0 };
    let mut integrator = Integrator::explicit(StepSettings::fixed(0.02), 0.0, &[0.0, 1.0]).unwrap();
    integrator.run(&mut system, 1.0, |_, i| (norm(i.state()) - 1.0).abs() < 1e-15).unwrap();
    assert_eq!(integrator.time(), 1.0);
    assert_eq!(system.evaluations, 7 * 50);
    assert!(distance(integrator.state(), &[0.0, 1.0]) < 1e-5); // fifth order: about 2π (2π h)⁵ / 720
}

#[test]
fn crossing_is_found_within_its_tolerance() {
    let mut integrator = Integrator::explicit(StepSettings::with_max_step(0.05), 0.0, &[0.0, 1.0]).unwrap();
    let mut search = CrossingSearch::new(2, 1e-12, 4);
    let mut found = None;
    let mut evaluations = 0;
    while found.is_none() {
        integrator.step(&mut Oscillator, 1.0).unwrap();
        evaluations = 0;
        found = search
            .first_crossing(&integrator, |_, y| {
                evaluations += 1;
                y[0] + 0.5
            })
            .unwrap();
    }
    let crossing = found.unwrap();
    // sin 2πt = -1/2 at t = 7/12; the dense output is accurate to 1e-8 at the tolerance 1e-9 of the steps.
    assert!((crossing.time - 7.0 / 12.0).abs() < 1e-8, "{crossing:?}");
    assert!(crossing.value <= 0.0 && crossing.time - crossing.before <= 1e-12, "{crossing:?}");
    assert!((search.state()[0] + 0.5 - crossing.value).abs() < 1e-15);
    assert!(evaluations < 25, "{evaluations} evaluations");
}

/// A straight line in time as dense output, to look at the search alone.
struct Clock(f64, f64);

impl DenseOutput for Clock {
    fn interval(&self) -> (f64, f64) {
        (self.0, self.1)
    }

    fn dimension(&self) -> usize {
        1
    }

    fn interpolate(&self, t: f64, out: &mut [f64]) {
        out[0] = t;
    }
}

#[test]
fn double_zero_between_two_samples_is_seen_wherever_it_lies() {
    let mut search = CrossingSearch::new(1, 1e-10, 4);
    for i in 0..200 {
        // A dip 4 % of a step wide, with its bottom anywhere.
        let (bottom, half_width) = (0.021 + 0.958 * f64::from(i) / 199.0, 0.02);
        let dip = |t: f64| (t - bottom).powi(2) - half_width * half_width;
        let crossing = search.first_crossing(&Clock(0.0, 1.0), |_, y| dip(y[0])).unwrap();
        let crossing = crossing.unwrap_or_else(|| panic!("dip at {bottom} not seen"));
        assert!((crossing.time - (bottom - half_width)).abs() < 1e-9, "dip at {bottom}: {crossing:?}");
    }
}

#[test]
fn crossings_from_below_and_touching_starts_do_not_count() {
    let mut search = CrossingSearch::new(1, 1e-10, 3);
    let mut first = |f: &dyn Fn(f64) -> f64| {
        search.first_crossing(&Clock(0.0, 1.0), |_, y| f(y[0])).unwrap().map(|c| c.time)
    };
    assert_eq!(first(&|t| t - 0.5), None);
    assert_eq!(first(&|t| -t), None);
    assert_eq!(first(&|t| 2.0 - t), None);
    // Negative at the start, positive, then through zero: only the last counts.
    let time = first(&|t| (t - 0.2) * (0.7 - t)).unwrap();
    assert!((time - 0.7).abs() < 1e-9);
    assert!(search.first_crossing(&Clock(0.0, 1.0), |_, _| f64::NAN).is_err());
}

#[test]
fn instants_of_every_search_have_their_numbers() {
    let mut search = CrossingSearch::new(1, 1e-10, 4);
    let n = search.n_instants();
    let mut times = vec![None; n];
    // Falling, rising, through zero and with a dip: the same number is the same time whatever the function.
    let functions: [fn(f64) -> f64; 5] =
        [|t| 1.0 - 0.9 * t, |t| 0.1 + t, |t| t - 0.1, |t| 0.5 - t, |t| (t - 0.6).powi(2) - 0.01];
    for f in functions {
        let own = search.first_crossing_of((0.0, 1.0), Slope::UNKNOWN, |t, instant, _| {
            if let Some(known) = instant.map(|i| times[i].get_or_insert(t)) {
                assert_eq!(known.to_bits(), t.to_bits());
            }
            f(t)
        });
        let usual = search.first_crossing(&Clock(0.0, 1.0), |_, y| f(y[0]));
        assert_eq!(own.unwrap(), usual.unwrap());
    }
    assert_eq!(times.iter().flatten().count(), n, "{times:?}");
}

#[test]
fn a_known_slope_saves_looks_and_misses_nothing() {
    let mut search = CrossingSearch::new(1, 1e-10, 4);
    for i in 0..200 {
        // A dip between two samples of one and the same function, of the slope 2 at most, from below zero to above.
        let (bottom, height) = (0.021 + 0.958 * f64::from(i) / 199.0, 1e-3 * f64::from(i - 100));
        let dip = |t: f64| (t - bottom).powi(2) + height;
        let mut count = |slope: Slope| {
            let mut looks = 0;
            let found = search.first_crossing_of((0.0, 1.0), slope, |t, _, _| {
                looks += 1;
                dip(t)
            });
            (found.unwrap(), looks)
        };
        let (all, many) = count(Slope::UNKNOWN);
        let (known, few) = count(Slope { fastest: 2.0, jump: 0.0 });
        assert_eq!(all, known, "{bottom} {height}");
        assert!(few <= many && (height < 0.05 || few <= 20), "{bottom} {height}: {few} of {many}");
        // What may jump by as much as there is left is looked for.
        assert_eq!(count(Slope { fastest: 2.0, jump: 2.0 }), (all, many));
    }
}
