//! A run: free phases until a contact closes, impact phases until it has been open for a while
//! (\[A\] Fig. 2).

use std::time::Instant;

use ffr_dynamics::integration::{CrossingSearch, Integrator, Statistics, StepSettings};
use ffr_dynamics::system::model::stops::StopSite;
use ffr_dynamics::system::multibody::apart::Apart;

use crate::checks::linearity::LinearLimits;
use crate::checks::motion::MotionLimits;
use crate::checks::start::watched_pairs;
use crate::checks::watch::WatchedPair;
use crate::error::AdaptiveError;
use crate::impact::local_deformation::LocalDeformation;
use crate::model::{ContactFacts, RunModel};
use crate::record::{PhaseKind, PhaseRecord};
use crate::spec::{FREE_INTERVAL, RunSettings, Start};
use crate::state::ledger::{EnergyLedger, Imbalance};
use crate::state::observer::{Continue, Observer};
use crate::state::stop_hit::StopHit;
use crate::state::{ContactState, RunState};
use crate::touch::detection::{Clearance, Search};

/// Gap at the start, as a share of the body's size, below which bodies count as touching: round-off
/// of coordinates.
const TOUCHING: f64 = 1e-12;
/// Share of the largest step to which opening and closing times are located.
const EVENT_TOLERANCE: f64 = 1e-9;
/// Gap samples per step in event detection.
const EVENT_SAMPLES: usize = 4;
/// Default quiet time in steps of the impact phase: several periods of the highest mode pass
/// without contact.
const QUIET_STEPS: f64 = 10.0;

/// Shortest interval between two gap evaluations of a pair that is not in contact, as a share of a
/// step: overlaps that last longer are never missed.
const SHORTEST_LOOK: f64 = 1e-4;
/// Gap, as a share of the size of the pair, below which detection cannot tell it from a touch:
/// touches are located to a billionth of a step.
const NEAR: f64 = 1e-9;

mod contact_slot;
mod impact;
mod checks;
mod bands;
mod monitor;
mod output;
mod restart;
mod near;
mod states;
mod stops;
mod watch;
mod equilibrium;

use contact_slot::ContactSlot;
use impact::balance::Balance;
use impact::pace::Pace;
use output::Output;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunEnd {
    /// Time reached \[s\].
    pub time: f64,
    /// Whether the observer stopped it.
    pub is_interrupted: bool,
}

/// A run between steps: model, state, contacts, integrator, output.
pub struct Driver<'a> {
    model: &'a mut RunModel,
    settings: RunSettings,
    /// The data of a restart point; time, state vector, rates and step are filled in when one is
    /// written.
    run: RunState,
    /// Contacts in the order of the system's force elements.
    slots: Vec<ContactSlot>,
    /// Contacts that were not far from a touch in the last step.
    near: Vec<usize>,
    /// What is known of others without a look at each.
    apart: Apart,
    /// Contacts that get fine models when they touch.
    refinable: Vec<usize>,
    output: Output<'a>,
    integrator: Integrator,
    crossing: CrossingSearch,
    /// A state vector to work on.
    interpolated: Vec<f64>,
    /// Largest step of impact phases \[s\].
    impact_step: f64,
    /// Time between stored states where nothing rings and nobody has given it \[s\].
    usual_interval: f64,
    /// For each body the number of the group of bodies that joints connect.
    groups: Vec<usize>,
    /// Local deformation at the observed points, which contact zones add.
    local_deformation: LocalDeformation,
    /// When a penalty factor was lowered last in the present trial, and energy and momentum with
    /// the new one.
    lowered: Option<(f64, Balance)>,
    /// Potential of gravity at the start, from which it is counted \[J\].
    gravity_datum: f64,
    /// How far the energy ledger is open in the state noted last.
    imbalance: Imbalance,
    limits: MotionLimits,
    linear: LinearLimits,
    /// Stops of the joints, and what was seen of them at the last restart point.
    stops: Vec<StopSite>,
    marked_hits: Vec<StopHit>,
    work: PhaseWork,
    /// Pace of the running impact.
    pace: Pace,
    /// Contact whose fine model is being built.
    building: Option<usize>,
    /// The pairs of bodies with contacts, watched for overlaps independently of their contacts.
    watched: Vec<WatchedPair>,
}

/// What the work of the running phase is counted from.
struct PhaseWork {
    /// Start of the phase \[s\].
    start: f64,
    part: Part,
    /// Work of integrators that have been replaced.
    replaced: Statistics,
    /// Steps since the last restart point.
    unmarked: u32,
}

/// Counters and clocks at the start of what is reported as a phase: one of impact may have several, where contact lasts.
#[derive(Clone, Copy)]
struct Part {
    /// Its start \[s\].
    start: f64,
    /// Work in it before the run was taken up again.
    carried: PhaseRecord,
    /// Work before it, or before the run was taken up again in it.
    before: Statistics,
    clock: Instant,
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
    driver.finish_run(end)
}

/// Takes up in `state`, a restart point, the run of a model built from the same specification.
///
/// # Errors
/// [`AdaptiveError::Restart`] if the state does not belong to the model, otherwise as [`run`].
pub fn resume(
    model: &mut RunModel,
    settings: &RunSettings,
    state: &RunState,
    observer: &mut dyn Observer,
) -> Result<RunEnd, AdaptiveError> {
    let mut driver = Driver::new(model, settings.clone(), observer)?;
    let end = driver.run(Some(state));
    driver.finish_run(end)
}

/// Limits of linear deformation of the bodies of `model`.
fn linear_limits(model: &RunModel) -> Result<LinearLimits, AdaptiveError> {
    let system = model.system.model();
    let is_in_loop =
        |b: usize| system.loops.iter().any(|l| l.parent.body == Some(b) || l.child.body == Some(b));
    LinearLimits::new(&model.bodies, |b| {
        let joint = &system.bodies[b].joint;
        (joint.free_velocities().next().is_none() && !is_in_loop(b)).then_some(&joint.child)
    })
}

impl<'a> Driver<'a> {
    /// Adds up the time of searches and reports stresses and peaks, of runs that have failed as well; their
    /// own error goes first.
    fn finish_run(mut self, end: Result<RunEnd, AdaptiveError>) -> Result<RunEnd, AdaptiveError> {
        let searches = self.slots.iter().map(|slot| slot.nearest.elapsed().as_secs_f64());
        self.model.timings.search += searches.sum::<f64>();
        self.bound_peaks();
        let layout = self.model.layout(self.settings.end_time);
        let reported = self.model.report_stress(&self.run.stress, self.output.observer);
        let peaks = self.output.observer.peaks(&layout, &self.run.peaks.records);
        let end = end?;
        reported.and(peaks.map_err(AdaptiveError::from)).map(|()| end)
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
        let steps =
            StepSettings { is_vibration_exact: true, ..StepSettings::with_max_step(settings.free.max_step) };
        let method =
            settings.free.method.unwrap_or_else(|| restart::default_method(PhaseKind::Free, &model.system));
        let integrator =
            Integrator::new(method, steps, 0.0, &y, &model.system).map_err(AdaptiveError::Dynamics)?;
        let event_step = impact_step.min(settings.free.max_step);
        let crossing = crossing_search(y.len(), event_step);
        let gravity_datum = model.system.invariants(0.0, &y).gravity;
        let states = model.system.body_states(0.0, &y).to_vec();
        let limits = MotionLimits::new(model, &states, &settings);
        let mass = model.bodies.iter().map(|b| b.data.mass).filter(|m| m.is_finite()).sum();
        let floor = settings.free.velocity_floor.max(settings.impact.velocity_floor);
        let search = Search::new();
        let slots = model.contacts.iter();
        let slots = slots.map(|c| ContactSlot::new(c.refinement.is_some(), search.of_another_pair()));
        let stops = model.system.model().stops();
        // What lasts is shown over its period: states at whole periods may all be the same.
        let usual_interval = FREE_INTERVAL.min(model.system.model().quarter_period(settings.end_time));
        let run = RunState {
            hits: vec![StopHit::default(); stops.len()],
            last_output: f64::NEG_INFINITY,
            free_interval: settings.free_interval.unwrap_or(usual_interval),
            ledger: EnergyLedger::new(mass, floor, gravity_datum),
            contacts: vec![ContactState::default(); model.contacts.len()],
            stress: vec![None; model.n_stress_requests()],
            ..RunState::default()
        };
        let marked_hits = run.hits.clone();
        Ok(Self {
            run,
            near: Vec::with_capacity(slots.len()),
            apart: Apart::new(slots.len(), model.bodies.len()),
            refinable: (0..slots.len()).filter(|i| model.contacts[*i].refinement.is_some()).collect(),
            slots: slots.collect(),
            output: Output::new(observer),
            imbalance: Imbalance::default(),
            limits,
            linear: linear_limits(model)?,
            marked_hits,
            stops,
            groups: model.system.model().groups(),
            local_deformation: LocalDeformation::new(model.lasting_local_deformation()?),
            lowered: None,
            work: PhaseWork {
                start: 0.0,
                part: Part {
                    start: 0.0,
                    carried: PhaseRecord::default(),
                    before: Statistics::default(),
                    clock: Instant::now(),
                },
                replaced: Statistics::default(),
                unmarked: 0,
            },
            pace: Pace::new(impact_step),
            interpolated: y,
            building: None,
            watched: watched_pairs(model)?,
            model,
            settings,
            integrator,
            crossing,
            impact_step,
            usual_interval,
            gravity_datum,
        })
    }

    fn run(&mut self, from: Option<&RunState>) -> Result<RunEnd, AdaptiveError> {
        // An equilibrium is found again rather than stored: its zones and what sticks in them are no part of a restart point.
        let from = from.filter(|state| state.time > 0.0 || !self.settings.start.is_static());
        let mut warnings = if from.is_none() { self.check_start()? } else { Vec::new() };
        if from.is_none() && self.settings.start == Start::Elastic {
            warnings.extend(self.pressed_in_equilibrium()?);
        }
        self.output.observer.start(&self.model.layout(self.settings.end_time))?;
        self.warn(warnings)?;
        let mut kind = match from {
            Some(state) => {
                self.restore(state)?;
                state.phase.kind
            }
            None => {
                if self.settings.start.is_static() {
                    self.begin_in_equilibrium()?;
                }
                let kind = if self.is_any_closed()? { PhaseKind::Impact } else { PhaseKind::Free };
                self.note()?;
                if kind == PhaseKind::Free || !self.begins_with_overlap() {
                    self.send()?;
                }
                self.check_motion()?;
                self.warn_of_nonlinearity()?;
                self.note_gaps(self.integrator.time())?;
                self.run.next_output = self.run.free_interval;
                self.begin_phase(kind)?;
                kind
            }
        };
        let mut is_interrupted = false;
        while !self.is_over() && !is_interrupted {
            let outcome = match kind {
                PhaseKind::Free => self.free_phase(),
                PhaseKind::Impact | PhaseKind::Lasting => self.impact_phase(),
            };
            // A phase that fails is reported as far as it went.
            let reported = if kind == PhaseKind::Free { kind } else { self.pace.kind() };
            self.output.observer.phase(&self.phase_record(reported))?;
            is_interrupted = outcome?;
            self.warn_of_nonlinearity()?;
            self.run.n_phases += 1;
            kind = if kind == PhaseKind::Free { PhaseKind::Impact } else { PhaseKind::Free };
            if !self.is_over() && !is_interrupted {
                self.begin_phase(kind)?;
            }
        }
        if !is_interrupted
            && self.integrator.time() < self.settings.end_time
            && self.run.last_output < self.integrator.time()
        {
            self.store()?;
        }
        if !is_interrupted {
            self.report_pressed_stops()?;
            self.report_unended_impacts()?;
            self.check_end()?;
        }
        Ok(RunEnd { time: self.integrator.time(), is_interrupted })
    }

    /// Whether the run is over: time is up, the wanted number of impacts has ended, or the bodies
    /// are at rest.
    fn is_over(&self) -> bool {
        let is_pose = self.settings.start == Start::StaticOnly;
        is_pose || self.is_enough() || self.is_at_rest() || self.integrator.time() >= self.settings.end_time
    }

    /// Whether the wanted number of impacts has ended, those with stops of joints among them, and none
    /// of them may go on with another touch.
    fn is_enough(&self) -> bool {
        let time = self.integrator.time();
        let are_over =
            || self.run.contacts.iter().all(|c| c.impact.is_none_or(|impact| impact.is_over(time)));
        self.settings.stop_after_impacts.is_some_and(|n| self.run.n_rows() >= n && are_over())
    }

    /// The record of the running phase up to now.
    fn phase_record(&self, kind: PhaseKind) -> PhaseRecord {
        let Part { start, carried, before, clock } = self.work.part;
        let now = self.statistics();
        PhaseRecord {
            kind,
            start,
            end: self.integrator.time(),
            steps: carried.steps + now.steps - before.steps,
            rejected: carried.rejected + now.rejected - before.rejected,
            evaluations: carried.evaluations + now.evaluations - before.evaluations,
            wall_time: carried.wall_time + clock.elapsed().as_secs_f64(),
        }
    }

    /// From now on another phase is reported.
    fn begin_part(&mut self) {
        let (start, before) = (self.integrator.time(), self.statistics());
        self.work.part = Part { start, carried: PhaseRecord::default(), before, clock: Instant::now() };
    }

    /// Work done so far.
    fn statistics(&self) -> Statistics {
        let (earlier, now) = (self.work.replaced, self.integrator.statistics());
        Statistics {
            steps: earlier.steps + now.steps,
            rejected: earlier.rejected + now.rejected,
            evaluations: earlier.evaluations + now.evaluations,
            ..now
        }
    }

    /// Makes searches start anew: the next ones depend on motions and surfaces alone.
    fn forget_searches(&mut self) {
        for slot in &mut self.slots {
            slot.nearest.forget();
            slot.clearance = Clearance::UNKNOWN;
        }
    }

    /// Whether a contact is closed, or open by no more than round-off.
    fn is_any_closed(&mut self) -> Result<bool, AdaptiveError> {
        let (t, y, system) = (self.integrator.time(), self.integrator.state(), &mut self.model.system);
        system.body_states(t, y);
        let mut is_any = false;
        for (i, facts) in self.model.contacts.iter().enumerate() {
            is_any |= self.slots[i].gap_below(system, (i, facts), y, touching(facts))?.is_some();
        }
        Ok(is_any)
    }

    /// Integrates until a contact closes, the bodies are at rest or time is up; returns whether the
    /// observer stopped the run.
    fn free_phase(&mut self) -> Result<bool, AdaptiveError> {
        let end = self.settings.end_time;
        self.begin_watch();
        while self.integrator.time() < end && !self.is_at_rest() && !self.is_enough() {
            let step = self.free_step(end)?;
            // An impact that begins in the last instant has nothing to be resolved.
            let last = end - EVENT_TOLERANCE * self.impact_step;
            let closing = self.first_closing((step.start, step.end))?.filter(|time| *time < last);
            self.update_free_stress((step.start, closing.unwrap_or(step.end)));
            if let Some(time) = closing {
                self.repeat_until(step.start, time)?;
                if self.run.last_output < time {
                    self.store()?;
                }
                return Ok(false);
            }
            self.note_peaks();
            if let Err(error) = self.check_motion() {
                // The result is stored as far as it went; that the energy ledger is open as well is
                // no further information.
                return match self.store() {
                    Err(failed @ AdaptiveError::Observer(_)) => Err(failed),
                    _ => Err(error),
                };
            }
            self.warn_of_nonlinearity()?;
            self.note_rest();
            self.store_until(step.end)?;
            self.note_stops()?;
            self.report_hits()?;
            if self.output.observer.progress(step.end, step.end - step.start, PhaseKind::Free)
                == Continue::Interrupt
            {
                self.store()?;
                return Ok(true);
            }
            self.mark_restart_point_if_due()?;
        }
        if self.run.last_output < self.integrator.time() {
            self.store()?;
        }
        self.end_watch()?;
        Ok(false)
    }

    /// Takes the last step, which began at `start`, again as far as `end`: its later part met a
    /// contact, whose force reaches into every state that the step interpolates.
    fn repeat_until(&mut self, start: f64, end: f64) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.previous_state());
        self.integrator.restart(start, &self.interpolated);
        while self.integrator.time() < end {
            let step = self.free_step(end)?;
            self.note_peaks();
            self.store_until(step.end)?;
        }
        Ok(())
    }
}

/// Gap below which the bodies of a contact count as touching \[m\].
fn touching(facts: &ContactFacts) -> f64 {
    TOUCHING * facts.refinement.as_ref().map_or(facts.size, |refinement| refinement.detector.size())
}

/// Search for events in steps of `step` seconds at most, in states of `n` numbers.
fn crossing_search(n: usize, step: f64) -> CrossingSearch {
    CrossingSearch::new(n, EVENT_TOLERANCE * step, EVENT_SAMPLES)
}
