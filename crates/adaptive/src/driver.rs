//! A run: free phases until a contact closes, impact phases until it has been open for a while (\[A\] Fig. 2).

use std::time::Instant;

use ffr_dynamics::DynamicsError;
use ffr_dynamics::integration::{CrossingSearch, DenseOutput, Integrator, Statistics, StepSettings};
use ffr_dynamics::system::error_scale::ErrorScale;

use crate::error::AdaptiveError;
use crate::impact_watch::{ContactInstant, ImpactWatch};
use crate::model::RunModel;
use crate::record::{Continue, Observer, PhaseKind, PhaseRecord, Sample, TryRecord};
use crate::simulation::{fill_sample, normal_velocity, smallest_gap};
use crate::spec::RunSettings;

/// A body that touches within this part of its size at the start counts as touching: round-off of its coordinates.
const TOUCHING: f64 = 1e-12;
/// Share of the largest step to which opening and closing times are located.
const EVENT_TOLERANCE: f64 = 1e-9;
/// Intervals a step in which the gap is looked at.
const EVENT_SAMPLES: usize = 4;
/// Default quiet time in steps of the impact phase: several periods of the highest mode pass without contact.
const QUIET_STEPS: f64 = 10.0;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunEnd {
    /// Time reached \[s\].
    pub time: f64,
    /// Whether the observer stopped it.
    pub is_interrupted: bool,
}

/// State of a run between steps.
pub struct Driver<'a> {
    model: &'a mut RunModel,
    settings: RunSettings,
    observer: &'a mut dyn Observer,
    integrator: Integrator,
    /// Work of integrators that have been replaced.
    earlier: Statistics,
    crossing: CrossingSearch,
    watches: Vec<ImpactWatch>,
    sample: Sample,
    interpolated: Vec<f64>,
    impact_step: f64,
    /// Potential of gravity at the start, from which it is counted \[J\].
    gravity_datum: f64,
    n_phases: u32,
    n_impacts: u32,
    next_output: f64,
}

/// Runs `model` to the end time of `settings`, reporting to `observer`.
///
/// # Errors
/// [`AdaptiveError`]; what was reported before stays valid.
pub fn run(
    model: &mut RunModel,
    settings: &RunSettings,
    observer: &mut dyn Observer,
) -> Result<RunEnd, AdaptiveError> {
    let mut driver = Driver::new(model, settings.clone(), observer)?;
    let end = driver.run()?;
    driver.model.report_stress(driver.observer)?;
    Ok(end)
}

impl<'a> Driver<'a> {
    fn new(
        model: &'a mut RunModel,
        settings: RunSettings,
        observer: &'a mut dyn Observer,
    ) -> Result<Self, AdaptiveError> {
        let y = model.initial.clone();
        let highest = model.system.highest_frequency();
        let nyquist = if highest > 0.0 { 0.5 / highest } else { settings.free.max_step };
        let impact_step = settings.impact.max_step.min(nyquist);
        let steps = StepSettings::with_max_step(settings.free.max_step);
        let integrator = Integrator::new(settings.free.method, steps, 0.0, &y, &model.system)
            .map_err(AdaptiveError::Dynamics)?;
        let event_step = impact_step.min(settings.free.max_step);
        let crossing = CrossingSearch::new(y.len(), EVENT_TOLERANCE * event_step, EVENT_SAMPLES);
        let gravity_datum = model.system.invariants(0.0, &y).gravity;
        Ok(Self {
            watches: vec![ImpactWatch::default(); model.system.forces().len()],
            earlier: Statistics::default(),
            sample: Sample::default(),
            interpolated: y,
            n_phases: 0,
            n_impacts: 0,
            next_output: 0.0,
            model,
            settings,
            observer,
            integrator,
            crossing,
            impact_step,
            gravity_datum,
        })
    }

    fn run(&mut self) -> Result<RunEnd, AdaptiveError> {
        self.observer.start(&self.model.layout(self.settings.end_time))?;
        let mut kind = if self.is_touching() { PhaseKind::Impact } else { PhaseKind::Free };
        self.store()?;
        self.next_output = self.settings.free_interval;
        let mut is_interrupted = false;
        while self.integrator.time() < self.settings.end_time && !is_interrupted {
            let started = Instant::now();
            let (start, before) = (self.integrator.time(), self.statistics());
            self.enter(kind)?;
            is_interrupted = match kind {
                PhaseKind::Free => self.free_phase()?,
                PhaseKind::Impact => self.impact_phase(start)?,
            };
            let now = self.statistics();
            let record = PhaseRecord {
                kind,
                start,
                end: self.integrator.time(),
                steps: now.steps - before.steps,
                rejected: now.rejected - before.rejected,
                evaluations: now.evaluations - before.evaluations,
                wall_time: started.elapsed().as_secs_f64(),
            };
            self.observer.phase(&record)?;
            self.n_phases += 1;
            kind = if kind == PhaseKind::Free { PhaseKind::Impact } else { PhaseKind::Free };
        }
        Ok(RunEnd { time: self.integrator.time(), is_interrupted })
    }

    /// Work done so far.
    fn statistics(&self) -> Statistics {
        let (earlier, now) = (self.earlier, self.integrator.statistics());
        Statistics {
            steps: earlier.steps + now.steps,
            rejected: earlier.rejected + now.rejected,
            evaluations: earlier.evaluations + now.evaluations,
            ..now
        }
    }

    fn enter(&mut self, kind: PhaseKind) -> Result<(), AdaptiveError> {
        let (max_step, phase) = match kind {
            PhaseKind::Free => (self.settings.free.max_step, self.settings.free),
            PhaseKind::Impact => (self.impact_step, self.settings.impact),
        };
        if self.integrator.method() == phase.method {
            self.integrator.set_max_step(max_step).map_err(AdaptiveError::Dynamics)?;
        } else {
            self.earlier = self.statistics();
            let (t, y) = (self.integrator.time(), self.integrator.state().to_vec());
            let steps = StepSettings::with_max_step(max_step);
            self.integrator = Integrator::new(phase.method, steps, t, &y, &self.model.system)
                .map_err(AdaptiveError::Dynamics)?;
        }
        let scale = ErrorScale { relative: phase.tolerance, velocity_floor: phase.velocity_floor };
        self.model.system.set_error_scale(scale).map_err(AdaptiveError::Dynamics)
    }

    /// Whether a contact is closed, or open by no more than round-off.
    fn is_touching(&mut self) -> bool {
        let (t, y) = (self.integrator.time(), self.integrator.state());
        let system = &mut self.model.system;
        let contacts = self.model.contacts.iter().enumerate();
        contacts.into_iter().any(|(i, contact)| smallest_gap(system, t, y, i) <= TOUCHING * contact.size)
    }

    /// Integrates until a contact closes or time is up; returns whether the observer stopped the run.
    fn free_phase(&mut self) -> Result<bool, AdaptiveError> {
        let (end, n_contacts) = (self.settings.end_time, self.model.contacts.len());
        while self.integrator.time() < end {
            let step = self.integrator.step(&mut self.model.system, end).map_err(AdaptiveError::Dynamics)?;
            let system = &mut self.model.system;
            let closing = if n_contacts == 0 {
                None
            } else {
                let search = self.crossing.first_crossing(&self.integrator, |t, y| {
                    (0..n_contacts).map(|i| smallest_gap(system, t, y, i)).fold(f64::INFINITY, nan_min)
                });
                search.map_err(AdaptiveError::Dynamics)?
            };
            if let Some(crossing) = closing {
                self.repeat_until(step.start, crossing.before)?;
                if self.sample.time < crossing.before {
                    self.store()?;
                }
                return Ok(false);
            }
            self.store_until(step.end)?;
            if self.observer.progress(step.end, step.end - step.start, PhaseKind::Free) == Continue::Interrupt
            {
                self.store()?;
                return Ok(true);
            }
        }
        if self.sample.time < end {
            self.store()?;
        }
        Ok(false)
    }

    /// Takes the last step, which began at `start`, again as far as `end`: its later part met a contact, whose force reaches
    /// into every state that the step interpolates.
    fn repeat_until(&mut self, start: f64, end: f64) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.previous_state());
        self.integrator.restart(start, &self.interpolated);
        while self.integrator.time() < end {
            let step = self.integrator.step(&mut self.model.system, end).map_err(AdaptiveError::Dynamics)?;
            self.store_until(step.end)?;
        }
        Ok(())
    }

    /// Integrates until every contact has been open for the quiet time; returns whether the observer stopped the run.
    fn impact_phase(&mut self, start: f64) -> Result<bool, AdaptiveError> {
        let (started, before) = (Instant::now(), self.statistics());
        let quiet = self.settings.quiet_time.unwrap_or(QUIET_STEPS * self.impact_step);
        let mut last_force = start;
        let mut is_interrupted = false;
        self.watch(None)?;
        let mut most_active = vec![0u32; self.watches.len()];
        while self.integrator.time() < self.settings.end_time {
            let step = self
                .integrator
                .step(&mut self.model.system, self.settings.end_time)
                .map_err(AdaptiveError::Dynamics)?;
            self.store_step()?;
            self.watch(Some(step.end))?;
            for (most, contact) in most_active.iter_mut().zip(&self.sample.contacts) {
                *most = (*most).max(contact.active_points);
            }
            last_force = self.watches.iter().filter_map(ImpactWatch::last_touch).fold(last_force, f64::max);
            let progress = self.observer.progress(step.end, step.end - step.start, PhaseKind::Impact);
            is_interrupted = progress == Continue::Interrupt;
            if is_interrupted || (step.end - last_force >= quiet && self.is_separating()) {
                break;
            }
        }
        self.next_output = self.integrator.time() + self.settings.free_interval;
        let statistics = self.statistics();
        let reference = TryRecord {
            start,
            stop: self.integrator.time(),
            steps: statistics.steps - before.steps,
            rejected: statistics.rejected - before.rejected,
            wall_time: started.elapsed().as_secs_f64(),
            ..TryRecord::default()
        };
        self.finish_impacts(&most_active, &reference, is_interrupted)?;
        Ok(is_interrupted)
    }

    /// Whether every gap is open, and those of the contacts that touched in this phase are wider than before the last step.
    /// A contact that a body flies towards, away from another one, is left to the free phase.
    fn is_separating(&mut self) -> bool {
        let (system, watches) = (&mut self.model.system, &self.watches);
        let (start, end) = self.integrator.interval();
        let (before, now) = (self.integrator.previous_state(), self.integrator.state());
        watches.iter().enumerate().all(|(i, watch)| {
            let gap = smallest_gap(system, end, now, i);
            gap > 0.0 && (!watch.is_running() || gap > smallest_gap(system, start, before, i))
        })
    }

    /// Shows the present instant to the watches, and copies the state where a stress request asks for the peak force.
    fn watch(&mut self, step_end: Option<f64>) -> Result<(), AdaptiveError> {
        for i in 0..self.watches.len() {
            let (time, y) = (self.integrator.time(), self.integrator.state());
            let system = &mut self.model.system;
            let velocity = normal_velocity(system, time, y, i);
            let contact = &system.forces()[i].contact;
            let report = *contact.report();
            let normal = contact.normal(system.last_evaluation().0);
            let impulse = system.impulse(y, i);
            let now = ContactInstant { time, force: report.normal_force, impulse, normal, velocity };
            if report.is_rim_touched && report.normal_force > 0.0 {
                return Err(AdaptiveError::IntervalTooSmall {
                    contact: self.model.contacts[i].name.clone(),
                    time: now.time,
                    width: self.model.contacts[i].widths[0],
                });
            }
            let (touch, release) = match step_end {
                Some(_) => (self.change(i, 1.0)?, self.change(i, -1.0)?),
                None => (None, None),
            };
            self.watches[i].step(now, touch, release);
        }
        self.model.offer_to_stress(self.integrator.time());
        Ok(())
    }

    /// Time in the last step at which contact `i` closed (`sign` 1) or opened (−1).
    fn change(&mut self, i: usize, sign: f64) -> Result<Option<f64>, AdaptiveError> {
        let system = &mut self.model.system;
        let (start, end) = self.integrator.interval();
        let first = sign * smallest_gap(system, start, self.integrator.previous_state(), i);
        let last = sign * smallest_gap(system, end, self.integrator.state(), i);
        if !(first > 0.0 && last <= 0.0) {
            return Ok(None);
        }
        let found = self
            .crossing
            .first_crossing(&self.integrator, |t, y| sign * smallest_gap(system, t, y, i))
            .map_err(AdaptiveError::Dynamics)?;
        Ok(found.map(|c| c.time))
    }

    fn finish_impacts(
        &mut self,
        most_active: &[u32],
        reference: &TryRecord,
        is_interrupted: bool,
    ) -> Result<(), AdaptiveError> {
        for (i, watch) in self.watches.iter_mut().enumerate() {
            let Some(record) = watch.finish(i as u32) else { continue };
            let contact = &self.model.system.forces()[i].contact;
            let (penalty, n_points) = (contact.penalty(), contact.n_points());
            let sizes = self.model.try_sizes(i);
            let attempt = TryRecord {
                impact: self.n_impacts,
                number: 1,
                penalty_start: penalty,
                penalty_end: penalty,
                interval_widths: self.model.contacts[i].widths,
                utilisation: [f64::from(most_active[i]) / n_points as f64, 0.0],
                peak_force: record.peak_force,
                outcome: if is_interrupted { "interrupted" } else { "accepted" }.into(),
                reason: "refinement and penalty are given".into(),
                elements: sizes.elements,
                freedoms: sizes.freedoms,
                interface_freedoms: sizes.interface,
                ..reference.clone()
            };
            self.observer.impact(&record)?;
            self.observer.attempt(&attempt)?;
            self.n_impacts += 1;
        }
        Ok(())
    }

    /// Stores the states due up to time `t` of the last step.
    fn store_until(&mut self, t: f64) -> Result<(), AdaptiveError> {
        while self.next_output <= t {
            self.integrator.interpolate(self.next_output, &mut self.interpolated);
            self.evaluate(self.next_output)?;
            self.report(self.next_output)?;
            self.next_output += self.settings.free_interval;
        }
        Ok(())
    }

    /// Stores the present state.
    fn store(&mut self) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.state());
        self.evaluate(self.integrator.time())?;
        self.report(self.integrator.time())
    }

    /// Stores the state at the end of the step just accepted, which the forces were evaluated at last.
    fn store_step(&mut self) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.state());
        self.report(self.integrator.time())
    }

    /// Evaluates the forces in the state `interpolated` at time `t`.
    fn evaluate(&mut self, t: f64) -> Result<(), AdaptiveError> {
        let outcome = self.model.system.evaluate_forces(t, &self.interpolated);
        outcome.map_err(|r| AdaptiveError::Dynamics(DynamicsError::Integration { time: t, reason: r.reason }))
    }

    /// Reports the state `interpolated` at time `t`, which the forces were evaluated at last.
    fn report(&mut self, t: f64) -> Result<(), AdaptiveError> {
        let RunModel { system, observed, .. } = &mut *self.model;
        fill_sample(system, observed, t, &self.interpolated, &mut self.sample);
        self.sample.phase = self.n_phases;
        self.sample.energies.gravity -= self.gravity_datum;
        Ok(self.observer.sample(&self.sample)?)
    }
}

/// Minimum that keeps NaN.
fn nan_min(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}
