//! A run: free phases until a contact closes, impact phases until it has been open for a while (\[A\] Fig. 2).

use std::time::Instant;

use contact_qs::search::{TouchSettings, first_touch, safe_time};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::integration::{CrossingSearch, DenseOutput, Integrator, Statistics, Step, StepSettings};

use crate::adaptive_contact::FineContact;
use crate::dent::Dents;
use crate::error::AdaptiveError;
use crate::impact_watch::ImpactWatch;
use crate::model::RunModel;
use crate::penalty_search::PenaltySearch;
use crate::plausibility::ledger::{EnergyLedger, Opening};
use crate::plausibility::motion::MotionLimits;
use crate::record::{Continue, Energies, Observer, PhaseKind, PhaseRecord, RestartPoint, Sample};
use crate::simulation::{fill_sample, smallest_gap};
use crate::spec::RunSettings;

/// A body that touches within this part of its size at the start counts as touching: round-off of its coordinates.
const TOUCHING: f64 = 1e-12;
/// Share of the largest step to which opening and closing times are located.
const EVENT_TOLERANCE: f64 = 1e-9;
/// Intervals a step in which the gap is looked at.
const EVENT_SAMPLES: usize = 4;
/// Default quiet time in steps of the impact phase: several periods of the highest mode pass without contact.
const QUIET_STEPS: f64 = 10.0;

/// Shortest interval between two looks at a pair that is not in contact, as a share of a step: overlaps that last longer
/// are never missed.
const SHORTEST_LOOK: f64 = 1e-4;
/// Pairs nearer than this part of their size touch as far as detection can tell: a touch is located to a billionth of a step.
const NEAR: f64 = 1e-9;

mod doubts;
mod impact;
mod judgement;
mod refine;
mod restart;
mod watch;

use doubts::Doubts;
use refine::Ledger;

use impact::Pending;

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
    /// For each body the number of the group of bodies that hang together by joints.
    groups: Vec<usize>,
    /// What contact zones add to the observed points.
    dents: Dents,
    /// Fine models in use, one entry a contact.
    fine: Vec<Option<FineContact>>,
    /// Searches of contacts that joined the running impact in an earlier try, one entry a contact.
    searches: Vec<Option<PenaltySearch>>,
    /// Peak forces that previews gave, one entry a contact \[N\].
    previews: Vec<Option<f64>>,
    /// When a penalty factor was lowered last in the present try, and the ledger with the new one.
    lowered: Option<(f64, Ledger)>,
    /// States and changes of the model that wait for the attempt to be accepted.
    pending: Vec<Pending>,
    is_buffering: bool,
    sample: Sample,
    interpolated: Vec<f64>,
    impact_step: f64,
    /// Potential of gravity at the start, from which it is counted \[J\].
    gravity_datum: f64,
    /// Time until which the surfaces of each refined contact are known to be apart, in free phases \[s\].
    apart_until: Vec<f64>,
    numerical: NumericalDamping,
    /// The ledger up to the state noted last, and how far it is open there.
    ledger: EnergyLedger,
    opening: Opening,
    limits: MotionLimits,
    doubts: Doubts,
    phase_start: f64,
    /// Work in the running phase before the run was taken up again.
    carried: PhaseRecord,
    /// Work before that phase, or before the run was taken up again in it.
    before_phase: Statistics,
    phase_clock: Instant,
    /// Steps since the last restart point.
    unmarked: u32,
    n_phases: u32,
    n_impacts: u32,
    /// Fine models built so far.
    n_refined: u64,
    /// Contact whose fine model is being built.
    building: Option<usize>,
    next_output: f64,
    /// Time of the state stored last \[s\].
    last_output: f64,
    /// Whether the state noted last waits to be stored.
    is_noted: bool,
}

/// Energy that the implicit integrator removed.
#[derive(Debug, Clone, Copy, Default)]
struct NumericalDamping {
    removed: f64,
    /// Total energy of the state reported last.
    total: Option<f64>,
}

impl NumericalDamping {
    /// Enters what was removed since the state reported last; `is_implicit`: the implicit integrator led from there to here.
    fn book(&mut self, energies: &mut Energies, is_implicit: bool) {
        energies.numerical = self.removed;
        let total = energies.total();
        if let Some(before) = self.total.filter(|_| is_implicit) {
            self.removed += before - total;
            energies.numerical = self.removed;
        }
        self.total = Some(energies.total());
    }
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
    let end = driver.run(None);
    driver.ended(end)
}

/// Takes up at `point` the run of a model built from the same specification.
///
/// # Errors
/// [`AdaptiveError::Restart`] if the point does not belong to the model, otherwise as [`run`].
pub fn resume(
    model: &mut RunModel,
    settings: &RunSettings,
    point: &RestartPoint,
    observer: &mut dyn Observer,
) -> Result<RunEnd, AdaptiveError> {
    let mut driver = Driver::new(model, settings.clone(), observer)?;
    let end = driver.run(Some(point));
    driver.ended(end)
}

impl<'a> Driver<'a> {
    /// Reports stresses, of runs that have failed as well; their own error goes first.
    fn ended(self, end: Result<RunEnd, AdaptiveError>) -> Result<RunEnd, AdaptiveError> {
        let reported = self.model.report_stress(self.observer);
        let end = end?;
        reported.map(|()| end)
    }

    fn new(
        model: &'a mut RunModel,
        settings: RunSettings,
        observer: &'a mut dyn Observer,
    ) -> Result<Self, AdaptiveError> {
        let y = model.initial.clone();
        let highest = model.system.highest_frequency();
        let resolving = if highest > 0.0 { settings.step_share / highest } else { settings.free.max_step };
        let impact_step = settings.impact.max_step.min(resolving);
        let steps = StepSettings::with_max_step(settings.free.max_step);
        let integrator = Integrator::new(settings.free.method, steps, 0.0, &y, &model.system)
            .map_err(AdaptiveError::Dynamics)?;
        let event_step = impact_step.min(settings.free.max_step);
        let crossing = crossing_search(y.len(), event_step);
        let gravity_datum = model.system.invariants(0.0, &y).gravity;
        let states = model.system.body_states(0.0, &y).to_vec();
        let limits = MotionLimits::new(model, &states, &settings);
        let n_refined = model.adaptive.len();
        let mass = model.bodies.iter().map(|b| b.data.mass).filter(|m| m.is_finite()).sum();
        let floor = settings.free.velocity_floor.max(settings.impact.velocity_floor);
        Ok(Self {
            ledger: EnergyLedger::new(mass, floor, gravity_datum),
            opening: Opening::default(),
            limits,
            doubts: Doubts::new(model.contacts.len()),
            groups: model.system.model().groups(),
            watches: vec![ImpactWatch::default(); model.system.forces().len()],
            dents: Dents::new(model.lasting_dents()?),
            fine: model.contacts.iter().map(|_| None).collect(),
            searches: vec![None; model.contacts.len()],
            lowered: None,
            previews: vec![None; model.contacts.len()],
            pending: Vec::new(),
            is_buffering: false,
            phase_start: 0.0,
            carried: PhaseRecord::default(),
            before_phase: Statistics::default(),
            phase_clock: Instant::now(),
            unmarked: 0,
            earlier: Statistics::default(),
            sample: Sample::default(),
            interpolated: y,
            n_phases: 0,
            n_impacts: 0,
            n_refined: 0,
            building: None,
            next_output: 0.0,
            last_output: f64::NEG_INFINITY,
            is_noted: false,
            model,
            settings,
            observer,
            integrator,
            crossing,
            impact_step,
            gravity_datum,
            apart_until: vec![f64::NEG_INFINITY; n_refined],
            numerical: NumericalDamping::default(),
        })
    }

    fn run(&mut self, from: Option<&RestartPoint>) -> Result<RunEnd, AdaptiveError> {
        let doubts = if from.is_none() { self.doubt_start()? } else { Vec::new() };
        self.observer.start(&self.model.layout(self.settings.end_time))?;
        self.warn(doubts)?;
        let mut kind = match from {
            Some(point) => {
                self.restore(point)?;
                point.phase.kind
            }
            None => {
                let kind = if self.is_touching()? { PhaseKind::Impact } else { PhaseKind::Free };
                self.store()?;
                self.note_gaps(self.integrator.time())?;
                self.next_output = self.settings.free_interval;
                self.enter(kind)?;
                kind
            }
        };
        let mut is_interrupted = false;
        while self.integrator.time() < self.settings.end_time && !is_interrupted {
            let outcome = match kind {
                PhaseKind::Free => self.free_phase(),
                PhaseKind::Impact => self.impact_phase(),
            };
            // A phase that fails is reported as far as it went.
            self.observer.phase(&self.phase_record(kind))?;
            is_interrupted = outcome?;
            self.n_phases += 1;
            kind = if kind == PhaseKind::Free { PhaseKind::Impact } else { PhaseKind::Free };
            if self.integrator.time() < self.settings.end_time && !is_interrupted {
                self.enter(kind)?;
            }
        }
        if !is_interrupted {
            self.doubt_end()?;
        }
        Ok(RunEnd { time: self.integrator.time(), is_interrupted })
    }

    /// The running phase as far as it went.
    fn phase_record(&self, kind: PhaseKind) -> PhaseRecord {
        let (carried, before, now) = (&self.carried, self.before_phase, self.statistics());
        PhaseRecord {
            kind,
            start: self.phase_start,
            end: self.integrator.time(),
            steps: carried.steps + now.steps - before.steps,
            rejected: carried.rejected + now.rejected - before.rejected,
            evaluations: carried.evaluations + now.evaluations - before.evaluations,
            wall_time: carried.wall_time + self.phase_clock.elapsed().as_secs_f64(),
        }
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

    /// Whether a contact is closed, or open by no more than round-off.
    fn is_touching(&mut self) -> Result<bool, AdaptiveError> {
        let (t, y) = (self.integrator.time(), self.integrator.state());
        let system = &mut self.model.system;
        let mut contacts = self.model.contacts.iter().enumerate();
        if contacts.any(|(i, contact)| smallest_gap(system, t, y, i) <= TOUCHING * contact.size) {
            return Ok(true);
        }
        system.body_states(t, y);
        let states = system.last_evaluation().0;
        for (_, contact) in &self.model.adaptive {
            if contact.nearest(states)?.gap <= TOUCHING * contact.detector.size() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Integrates until a contact closes or time is up; returns whether the observer stopped the run.
    fn free_phase(&mut self) -> Result<bool, AdaptiveError> {
        let (end, n_contacts) = (self.settings.end_time, self.model.contacts.len());
        self.apart_until.fill(f64::NEG_INFINITY);
        while self.integrator.time() < end {
            let step = self.integrator.step(&mut self.model.system, end).map_err(AdaptiveError::Dynamics)?;
            let closing = self.first_closing(n_contacts, step)?;
            if let Some(time) = closing {
                self.repeat_until(step.start, time)?;
                if self.last_output < time {
                    self.store()?;
                }
                return Ok(false);
            }
            if let Err(error) = self.check_motion() {
                // Shown as far as it went; an open ledger is no news then.
                return match self.store() {
                    Err(failed @ AdaptiveError::Observer(_)) => Err(failed),
                    _ => Err(error),
                };
            }
            self.store_until(step.end)?;
            if self.observer.progress(step.end, step.end - step.start, PhaseKind::Free) == Continue::Interrupt
            {
                self.store()?;
                return Ok(true);
            }
            self.mark_now_and_then()?;
        }
        if self.last_output < end {
            self.store()?;
        }
        Ok(false)
    }

    /// Last time in the step before any contact closes; `None` if none does.
    fn first_closing(&mut self, n_contacts: usize, step: Step) -> Result<Option<f64>, AdaptiveError> {
        let mut earliest = None;
        if self.model.adaptive.len() < n_contacts {
            let system = &mut self.model.system;
            let search = self.crossing.first_crossing(&self.integrator, |t, y| {
                (0..n_contacts).map(|i| smallest_gap(system, t, y, i)).fold(f64::INFINITY, nan_min)
            });
            earliest = search.map_err(AdaptiveError::Dynamics)?.map(|c| c.before);
        }
        let all: Vec<usize> = (0..self.model.adaptive.len()).collect();
        let horizon = self.settings.free.max_step;
        let touch = self.first_touch(&all, (step.start, step.end), horizon)?.map(|(_, time)| time);
        Ok(match (earliest, touch) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        })
    }

    /// The first of the refined contacts `which` (places in the list) to touch in the last step, by the index of the
    /// contact, and the last time before. A look holds for `horizon` at most: while no contact force acts, the bound of the speed
    /// hardly grows, and most steps need no look at all.
    fn first_touch(
        &mut self,
        which: &[usize],
        (start, end): (f64, f64),
        horizon: f64,
    ) -> Result<Option<(usize, f64)>, AdaptiveError> {
        let mut earliest: Option<(usize, f64)> = None;
        let mut y = vec![0.0; if which.is_empty() { 0 } else { self.interpolated.len() }];
        for &k in which {
            let (index, contact) = &self.model.adaptive[k];
            let detector = &contact.detector;
            let until = earliest.map_or(end, |(_, t)| t);
            let apart = &mut self.apart_until[k];
            // What a free phase knew does not hold where contact forces act.
            if horizon > 0.0 && until <= *apart {
                continue;
            }
            let settings = TouchSettings {
                gap: TOUCHING * detector.size(),
                time: EVENT_TOLERANCE * self.impact_step.min(end - start),
                shortest: SHORTEST_LOOK * (end - start),
                acceleration: self.settings.gravity.norm(),
            };
            let (integrator, system) = (&self.integrator, &mut self.model.system);
            let touch = first_touch([start, until], &settings, |t| {
                integrator.interpolate(t, &mut y);
                system.body_states(t, &y);
                let states = system.last_evaluation().0;
                let (gap, speed) = (detector.nearest(states)?.gap, detector.closing_speed_bound(states));
                *apart = t + safe_time(gap, speed, settings.acceleration).min(horizon);
                Ok((gap, speed))
            });
            let touch =
                touch.map_err(|source| AdaptiveError::Contact { contact: contact.name.clone(), source })?;
            if let Some(touch) = touch.filter(|t| t.time > start || t.gap > settings.gap) {
                earliest = Some((*index, touch.time));
            }
        }
        Ok(earliest)
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

    /// Stores the states due up to time `t` of the last step.
    fn store_until(&mut self, t: f64) -> Result<(), AdaptiveError> {
        while self.next_output <= t {
            self.integrator.interpolate(self.next_output, &mut self.interpolated);
            self.evaluate(self.next_output)?;
            self.report(self.next_output)?;
            self.note_gaps(self.next_output)?;
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

    /// Notes the state at the end of the step of an impact just accepted, which the forces were evaluated at last, and stores it
    /// if that is due.
    fn store_step(&mut self) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.state());
        let t = self.integrator.time();
        self.fill(t);
        if t >= self.last_output + self.settings.impact_interval {
            self.send()?;
        }
        self.check_ledger()
    }

    /// Stores the state noted last, if that has not been done.
    fn store_noted(&mut self) -> Result<(), AdaptiveError> {
        if self.is_noted { self.send() } else { Ok(()) }
    }

    /// Evaluates forces and accelerations in the state `interpolated` at time `t`.
    fn evaluate(&mut self, t: f64) -> Result<(), AdaptiveError> {
        let outcome = self.model.system.evaluate_accelerations(t, &self.interpolated);
        outcome.map_err(|r| AdaptiveError::Dynamics(DynamicsError::Integration { time: t, reason: r.reason }))
    }

    /// Reports the state `interpolated` at time `t`, which the forces were evaluated at last.
    fn report(&mut self, t: f64) -> Result<(), AdaptiveError> {
        // Outside of impacts no contact force acts; what acts at the start of the run has no past.
        self.dents.begin(t, self.model.observed.points.len());
        self.fill(t);
        self.send()?;
        self.check_ledger()
    }

    /// Notes the state `interpolated` at time `t`, which the forces were evaluated at last.
    fn fill(&mut self, t: f64) {
        let RunModel { system, observed, .. } = &mut *self.model;
        fill_sample(system, observed, t, &self.interpolated, &mut self.sample);
        self.measure_dents(t);
        let RunModel { system, observed, .. } = &*self.model;
        self.dents.add_to(&mut self.sample.points, &observed.points, system);
        self.sample.phase = self.n_phases;
        self.sample.energies.gravity -= self.gravity_datum;
        let is_implicit = self.integrator.method().is_implicit();
        self.numerical.book(&mut self.sample.energies, is_implicit);
        self.opening = self.ledger.enter(&self.sample.energies);
        self.is_noted = true;
    }

    /// Takes the dents at observed points at time `t`, which the forces were evaluated at last.
    fn measure_dents(&mut self, t: f64) {
        let RunModel { system, observed, contacts, .. } = &*self.model;
        if !observed.points.is_empty() {
            self.dents.take(t, system, &self.fine, |i| contacts[i].loads_interface);
        }
    }

    /// Reports the state noted last.
    fn send(&mut self) -> Result<(), AdaptiveError> {
        (self.last_output, self.is_noted) = (self.sample.time, false);
        if self.is_buffering {
            self.pending.push(Pending::Sample(Box::new(self.sample.clone())));
            return Ok(());
        }
        Ok(self.observer.sample(&self.sample)?)
    }

    /// Reports what waited for an attempt to be accepted.
    fn flush(&mut self) -> Result<(), AdaptiveError> {
        self.is_buffering = false;
        for pending in self.pending.drain(..) {
            match pending {
                Pending::Sample(sample) => self.observer.sample(&sample)?,
                Pending::Transfer(record) => self.observer.transfer(&record)?,
            }
        }
        Ok(())
    }
}

/// Search for events in steps of `step` seconds at most, in states of `n` numbers.
fn crossing_search(n: usize, step: f64) -> CrossingSearch {
    CrossingSearch::new(n, EVENT_TOLERANCE * step, EVENT_SAMPLES)
}

/// Minimum that keeps NaN.
fn nan_min(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}
