//! The pace of an impact: explicit steps that follow every vibration, or, where a contact lasts, implicit ones at the pace of the motion
//! (docs/theory.md section A.10).

use ffr_dynamics::integration::{Method, Step};
use nalgebra::Vector3;
use std::f64::consts::TAU;

use crate::error::AdaptiveError;
use crate::impact::FineContact;
use crate::record::PhaseKind;
use crate::run::driver::Driver;

/// Contact lasts when force has acted for so many times as long as it took to its largest value, after which it would have ceased
/// three times in an impact of two bodies,
const RISES: f64 = 6.0;
/// or for so many periods of the slowest vibration of its bodies.
const PERIODS: f64 = 100.0;
/// Evaluations in a step of an impact.
const EVALUATIONS: f64 = 6.0;
/// Implicit steps by which it is seen whether they take fewer evaluations than those of impacts.
const BLOCK: u64 = 10;
/// Steps of an impact in the first implicit one; a rejected one is cut.
const FIRST: f64 = 10.0;
/// Steps of impacts in a half of an implicit one in which something opens or closes, up to which they take it.
const FEW: f64 = 10.0;
/// Steps of impacts after which implicit ones are tried again, twice as many each time, to a limit: a block of them and its derivative
/// cost as much as some thirty.
const WAIT: f64 = 100.0;
const LONGEST_WAIT: f64 = 3200.0;
/// Coordinates of a system whose derivative, a dense one, costs more than what it saves: of a thousand rigid balls it takes a minute.
const LARGE: usize = 600;
/// What modes may hold that ring, as a share of the largest energy of deformation, for a method that damps them: it changes no force by
/// more than the hundredth part of its largest value.
const QUIET: f64 = 1e-4;

/// Elements of its zone by which contact with friction rolls on in an implicit step, and from which on such a step is taken back: what
/// comes to press in it sticks from its end on.
const ROLLED: f64 = 0.5;
const ROLLED_FAR: f64 = 1.0;

/// At which pace the running trial goes on.
pub(crate) struct Pace {
    kind: PhaseKind,
    /// When the other pace may be tried next, and how long after the time when it does not pay \[s\].
    next: f64,
    wait: f64,
    /// Where the next step ends at the latest \[s\].
    goal: f64,
    /// Step of the impact when this pace began \[s\].
    step: f64,
    /// Time, steps and evaluations at the start of the present block of steps.
    block: (f64, u64, u64),
    /// Where contacts with friction press at the last step, in the frames of their bodies; none of others \[m\].
    middles: Vec<Option<Vector3<f64>>>,
    /// Longest step in which they roll on by no more than a part of an element \[s\].
    rolling: f64,
    /// Largest energy of modes in motion since the pace was looked at last \[J\].
    ringing: f64,
}

impl Pace {
    /// That of a trial that begins, with steps of `step` at most \[s\].
    pub fn new(step: f64) -> Self {
        Self {
            kind: PhaseKind::Impact,
            next: 0.0,
            wait: WAIT * step,
            goal: f64::INFINITY,
            step,
            block: (0.0, 0, 0),
            middles: Vec::new(),
            rolling: f64::INFINITY,
            ringing: 0.0,
        }
    }

    /// Kind of the phase that runs at this pace.
    pub fn kind(&self) -> PhaseKind {
        self.kind
    }

    /// A step has been accepted.
    pub fn passed(&mut self) {
        self.goal = f64::INFINITY;
    }

    /// Time at which the next step, which begins at `time`, is to end at the latest \[s\].
    pub fn goal(&self, time: f64) -> f64 {
        self.goal.min(time + self.rolling)
    }
}

impl Driver<'_> {
    /// Changes the pace before a step if another one serves better.
    pub(crate) fn choose_pace(&mut self) -> Result<(), AdaptiveError> {
        match self.pace.kind {
            PhaseKind::Lasting => {
                if self.is_worthwhile() {
                    Ok(())
                } else {
                    self.slow_down()
                }
            }
            PhaseKind::Free | PhaseKind::Impact => {
                self.note_ringing();
                if self.integrator.time() >= self.pace.next && self.lasts() {
                    if self.is_quiet() {
                        let own = self.integrator.proposed_step();
                        self.pace.step = if own > 0.0 { own.min(self.impact_step) } else { self.impact_step };
                        return self.change_pace(PhaseKind::Lasting, FIRST * self.pace.step);
                    }
                    self.look_again(WAIT * self.impact_step);
                }
                Ok(())
            }
        }
    }

    /// Whether implicit steps cost less than those of the impact before, as far as a block of them has told.
    fn is_worthwhile(&mut self) -> bool {
        let (time, now) = (self.integrator.time(), self.statistics());
        let (start, steps, evaluations) = self.pace.block;
        if now.steps < steps + BLOCK {
            return true;
        }
        self.pace.block = (time, now.steps, now.evaluations);
        EVALUATIONS * (time - start) > (now.evaluations - evaluations) as f64 * self.pace.step
    }

    /// Notes the energies that tell whether modes ring.
    fn note_ringing(&mut self) {
        let states = self.model.system.last_evaluation().0;
        let moving = self.model.bodies.iter().zip(states);
        let moving = moving.map(|(body, state)| body.data.modal_mass.square(&state.elastic_rates));
        // As much again is in their deformation.
        self.pace.ringing = self.pace.ringing.max(moving.sum());
    }

    /// Whether a method that damps what it does not resolve takes next to nothing, or is asked for.
    fn is_quiet(&self) -> bool {
        self.settings.lasting.method.is_some() || self.pace.ringing <= QUIET * self.run.ledger.elastic
    }

    /// Whether every contact that presses lasts, one of them on a body that vibrates, whose shortest period is what implicit steps need
    /// not follow.
    fn lasts(&self) -> bool {
        let is_large = self.model.system.model().n_rates() > LARGE;
        if is_large || self.method(PhaseKind::Lasting) == Method::DormandPrince {
            return false;
        }
        let mut vibrates = false;
        let all = self.slots.iter().enumerate().all(|(i, slot)| {
            if !slot.monitor.is_pressed() {
                return true;
            }
            vibrates |= self.slowest_period(i).is_finite();
            self.has_lasted(i)
        });
        all && vibrates
    }

    /// Whether contact `i` presses and lasts (Eq. A.38).
    pub(crate) fn has_lasted(&self, i: usize) -> bool {
        self.slots[i].monitor.pressed_for().is_some_and(|(lasted, rise)| {
            // Force that is there from the start lasts where it is in equilibrium; elsewhere it is about to change.
            let is_from_rest = self.settings.start.is_static() && lasted >= self.integrator.time();
            let lasts = lasted > 0.0 && lasted >= RISES * rise;
            is_from_rest || lasts || lasted >= PERIODS * self.slowest_period(i)
        })
    }

    /// Period of the slowest vibration of the bodies of contact `i`; infinite if both are rigid \[s\].
    fn slowest_period(&self, i: usize) -> f64 {
        let (body, target) = self.model.system.forces()[i].contact.facts().bodies();
        let bodies = [Some(body), target].into_iter().flatten();
        let squared = bodies.flat_map(|b| &self.model.bodies[b].data.modal_stiffness).copied();
        let slowest = squared.filter(|s| *s > 0.0).reduce(f64::min);
        slowest.map_or(f64::INFINITY, |squared| TAU / squared.sqrt())
    }

    /// Goes on with the steps of impacts for some time.
    pub(crate) fn slow_down(&mut self) -> Result<(), AdaptiveError> {
        self.look_again(self.pace.wait);
        self.pace.wait = (2.0 * self.pace.wait).min(LONGEST_WAIT * self.impact_step);
        self.change_pace(PhaseKind::Impact, 0.0)
    }

    /// Leaves the pace as it is for `time` \[s\].
    fn look_again(&mut self, time: f64) {
        (self.pace.next, self.pace.ringing) = (self.integrator.time() + time, 0.0);
    }

    fn change_pace(&mut self, kind: PhaseKind, step: f64) -> Result<(), AdaptiveError> {
        let (time, y) = (self.integrator.time(), self.integrator.state().to_vec());
        if time > self.work.part.start {
            let record = self.phase_record(self.pace.kind);
            self.output.phase(record)?;
            self.begin_part();
            self.run.n_phases += 1;
        }
        (self.pace.kind, self.pace.goal, self.pace.rolling) = (kind, f64::INFINITY, f64::INFINITY);
        self.pace.middles = self.middles();
        self.replace_integrator(kind, (time, &y), step)?;
        let now = self.statistics();
        self.pace.block = (time, now.steps, now.evaluations);
        Ok(())
    }

    /// The middle of the pressure of contact `i` on the points of its zone, in the frame of its body; none without friction or zone \[m\].
    fn middle(&self, i: usize) -> Option<Vector3<f64>> {
        self.slots[i].fine().and_then(FineContact::row).filter(|_| self.model.contacts[i].has_friction)?;
        let contact = &self.model.system.forces()[i].contact;
        let (mut force, mut moment) = (0.0, Vector3::zeros());
        for (k, f) in contact.point_forces()?.iter().enumerate().filter(|(_, f)| **f > 0.0) {
            (force, moment) = (force + f, moment + Vector3::from(contact.facts().point(k)?.0) * *f);
        }
        (force > 0.0).then(|| moment / force)
    }

    fn middles(&self) -> Vec<Option<Vector3<f64>>> {
        (0..self.slots.len()).map(|i| self.middle(i)).collect()
    }

    /// Whether a contact with friction rolled on too far in the implicit step `step` (section A.10); how long the next one may be.
    pub(crate) fn is_rolled_far(&mut self, step: Step) -> bool {
        let middles = self.middles();
        let way = |i: usize| {
            let row = self.slots[i].fine().and_then(FineContact::row)?;
            let before = self.pace.middles.get(i).copied().flatten()?;
            Some((middles[i]? - before).norm() / row)
        };
        let rolled = (0..middles.len()).filter_map(way).fold(0.0, f64::max);
        self.pace.rolling = ROLLED * (step.end - step.start) / rolled;
        let is_far = rolled > ROLLED_FAR;
        if !is_far {
            self.pace.middles = middles;
        }
        is_far
    }

    /// Whether contact has come to the end of a zone in the last step.
    pub(crate) fn is_rim_touched(&self) -> bool {
        let reports = self.model.system.forces().iter().map(|force| force.contact.report());
        reports
            .zip(&self.slots)
            .any(|(report, slot)| slot.fine().is_some() && report.is_rim_touched && report.normal_force > 0.0)
    }

    /// Whether a contact that has a model has opened or closed in the last step, or did so within it.
    pub(crate) fn is_any_changed(&mut self) -> Result<bool, AdaptiveError> {
        let forces = self.model.system.forces().iter();
        let is_changed = forces
            .zip(&self.slots)
            .any(|(force, slot)| (force.contact.report().normal_force > 0.0) != slot.monitor.is_pressed());
        Ok(is_changed || self.overlap_stepped_over()?.is_some())
    }

    /// Takes back an implicit step in which something opened or closed: it is taken by halves, and the change itself by the steps of
    /// impacts.
    pub(crate) fn undo(&mut self, step: Step) -> Result<(), AdaptiveError> {
        self.return_to(step.start);
        let half = 0.5 * (step.end - step.start);
        if half < FEW * self.pace.step {
            return self.slow_down();
        }
        self.pace.goal = step.start + half;
        self.integrator.invalidate();
        Ok(())
    }
}
