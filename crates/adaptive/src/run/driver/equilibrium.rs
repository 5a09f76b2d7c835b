//! A start in static equilibrium: bodies, joints and contacts come to rest under their loads before time begins (docs/theory.md
//! section M.16).

use ffr_dynamics::integration::OdeSystem;
use ffr_dynamics::system::equilibrium::balance::{Balance, Outcome};
use tracing::debug;

use super::Driver;
use super::contact_slot::ContactSlot;
use super::impact::MAX_TRIALS;
use super::impact::intervals::Intervals;
use super::impact::judgement::{Ending, Judgement};
use super::impact::trial_reason;
use crate::checks::start::{out_of_balance, unstable};
use crate::error::AdaptiveError;
use crate::model::ContactFacts;

use crate::record::ZoneSize;
use crate::record::finding::Components;
use crate::state::simulation::smallest_gap;

/// Steps towards equilibrium at most: a body that slides far takes some twenty for every turn by a radian.
const MAX_STEPS: usize = 2000;
/// What may be left out of balance, as a share of all forces: contact forces are solved to a hundredth of it.
const BALANCED: f64 = 1e-8;
/// What may be left where steps gain nothing any more: flat faces under light loads yield by so little that the round-off of places
/// shows in their forces.
const ROUGHLY: f64 = 1e-5;
/// The same up to which that is told: friction between flexible bodies is found to some 1e-5 of its force, and a body that rolls on it
/// resists by less.
const TOLD: f64 = 1e-4;
/// Steps without a gain of half of what is left after which that is so.
const NO_GAIN: usize = 10;
/// Share of the size of all bodies that they move in the first step, and after a touch: a thousandth of what elastic bodies yield
/// by under light loads.
const FIRST: f64 = 1e-11;
/// Factor between steps that meet what they expect.
const GROWTH: f64 = 4.0;
/// Share of the work of a step that is left at its end above which nothing resisted it, and the next one is longer by [`GROWTH`].
const LEFT: f64 = 0.5;
/// The same below which the next one is shorter, since it has gone beyond the equilibrium.
const TURNED: f64 = -0.25;
/// The same below which it is taken again, for the way back is as long, and above which it leads away from any equilibrium.
const BACK: f64 = -0.9;
const AWAY: f64 = 3.0;
/// Difference of the work left from what was expected up to which the stiffness is still known.
const KNOWN: f64 = 0.1;
/// Step, as a share of the size of the largest body, by which joints and loops turn too little to have another stiffness.
const SMALL: f64 = 1e-3;
/// Steps in a row that Newton's method takes and that leave more than the share [`VAIN`] of their work, after which something slides.
const IN_VAIN: usize = 30;
const VAIN: f64 = 0.9;
/// Longest step, as a share of the size of the largest body: a turn by some 0.3 rad.
const LONGEST: f64 = 0.3;
/// Bodies that have moved by so many times the size of all of them without meeting a resistance are not held.
const FAR: f64 = 100.0;
/// Touches on the way, each with a zone of its own, at most.
const MAX_LANDINGS: usize = 200;
/// Growth of the force at rest of a contact for which it gets another zone on the way.
const MORE: f64 = 1.1;
/// Halvings of a step in which a contact closes.
const HALVINGS: usize = 60;

/// How a way to equilibrium ended.
enum Arrival {
    /// In equilibrium.
    Settled,
    /// At the first touch of a contact that is to get its zone, or another one than it has.
    Touch(usize),
    /// Before a contact reaches the rim of its zone.
    Rim(usize),
    /// Where a contact presses beyond its zone.
    Beyond(usize),
}

/// What presses on the way to equilibrium.
#[derive(Clone, Copy)]
enum Pressing<'a> {
    /// Zones, which are made as contacts touch; which contacts get no other one any more.
    Zones(&'a [bool]),
    /// Hertz's law in place of these contacts.
    Hertz(&'a [usize]),
}

/// What rests by Hertz's law.
#[derive(Default)]
struct AtRest {
    /// The state, if an equilibrium was reached.
    state: Option<Vec<f64>>,
    /// Contacts with their forces \[N\].
    forces: Vec<(usize, f64)>,
}

/// A step towards equilibrium.
struct Step {
    /// The state at its end.
    moved: Vec<f64>,
    /// What is left of its work there.
    outcome: Outcome,
    /// Whether it is shorter than Newton's.
    is_short: bool,
}

impl Driver<'_> {
    /// Brings bodies and joints that are at rest at the start into equilibrium, contacts among them; what moves keeps its pose and
    /// velocity.
    ///
    /// # Errors
    /// [`AdaptiveError::Equilibrium`] if something is not held or the way does not end.
    pub(super) fn begin_in_equilibrium(&mut self) -> Result<(), AdaptiveError> {
        let start = self.impact_start();
        let mut intervals = Intervals::new(self.slots.len());
        let mut beyond = self.settle_all(&intervals.sizes)?;
        for number in 1..=MAX_TRIALS {
            self.begin_trial(number, None);
            let seen = self.see_equilibrium()?;
            let ending = beyond.map_or(seen, Ending::EdgeTouched);
            let minor = self.minor_contacts(&ending);
            let verdicts = self.assess(&minor);
            match self.judge(&ending, (&verdicts, &minor), &mut intervals, number)? {
                Judgement::Accept(_) => {
                    let forces = self.model.system.forces().iter().zip(&mut self.run.contacts);
                    forces
                        .filter(|(f, _)| f.contact.report().normal_force > 0.0)
                        .for_each(|(_, c)| c.close(start.time));
                    for fine in self.slots.iter_mut().filter_map(ContactSlot::fine_mut) {
                        fine.search = fine.search.accepted();
                    }
                    return self.tell_faults();
                }
                Judgement::Again { demands, .. } => {
                    debug!(number, demands = trial_reason::line(&demands), "equilibrium again");
                    self.rewind(&start, &intervals.sizes)?;
                    beyond = self.settle_all(&intervals.sizes)?;
                }
            }
        }
        Err(self.no_model(intervals.latest, MAX_TRIALS))
    }

    /// Tells of an equilibrium in which forces do not balance, or that a small disturbance leaves.
    fn tell_faults(&mut self) -> Result<(), AdaptiveError> {
        let (t, y, held) =
            (self.integrator.time(), self.integrator.state().to_vec(), self.moving_coordinates());
        let balance = self.model.system.balance(t, &y, &held).map_err(AdaptiveError::Model)?;
        let mut warnings = Vec::new();
        if balance.residual() > ROUGHLY {
            let change = balance.change(LONGEST * self.size_of_all()).0;
            let body = self.model.system.most_moved(t, &y, &change).map_or(0, |(body, ..)| body);
            warnings.push((body, out_of_balance(&self.model.bodies[body].name, balance.residual(), ROUGHLY)));
        }
        if let Some((squared, change)) = balance.softest().filter(|(squared, _)| *squared < 0.0)
            && let Some((body, ..)) = self.model.system.most_moved(t, &y, &change)
        {
            warnings.push((body, unstable(&self.model.bodies[body].name, squared)));
        }
        self.warn(warnings)
    }

    /// Notes what the contacts hold in equilibrium; whether one of them reached the rim of its zone.
    fn see_equilibrium(&mut self) -> Result<Ending, AdaptiveError> {
        let mut ending = Ending::Complete;
        self.begin_monitors(0..self.slots.len())?;
        for i in 0..self.slots.len() {
            if self.note_elements(i)? {
                ending = Ending::EdgeTouched(i);
            }
            let report = *self.model.system.forces()[i].contact.report();
            let energies = report.energies;
            if let Some(fine) = self.slots[i].fine_mut().filter(|_| energies.penalty > 0.0) {
                // Springs in series: the share of the energy is that of the approach.
                let share = energies.penalty / (energies.penalty + energies.elastic_high);
                fine.overlap = fine.overlap.max(report.penetration / share);
            }
        }
        Ok(ending)
    }

    /// Whether the present state is the equilibrium that the run begins in, contacts and what sticks in them among it.
    pub(super) fn is_settled_start(&self) -> bool {
        self.integrator.time() <= 0.0 && self.settings.start.is_static()
    }

    /// Brings the present state, the start of another trial, into equilibrium with its own zones, of the `sizes` wanted, and its own
    /// penalty factors: what friction holds in it is its own as well.
    pub(super) fn settle_again(&mut self, sizes: &[Option<ZoneSize>]) -> Result<(), AdaptiveError> {
        self.settle_all(sizes).map(|_| ())
    }

    /// Goes to equilibrium, with zones of the `sizes` wanted for contacts that touch on the way; the contact that came to press
    /// beyond its zone, if one did, where the way ends.
    fn settle_all(&mut self, sizes: &[Option<ZoneSize>]) -> Result<Option<usize>, AdaptiveError> {
        let held = self.moving_coordinates();
        let (t, mut y) = (self.integrator.time(), self.integrator.state().to_vec());
        self.slots.iter_mut().filter(|slot| slot.is_watching()).for_each(|slot| slot.found.preview = None);
        let mut are_made: Vec<bool> = sizes.iter().map(Option::is_some).collect();
        if self.is_free_of_way() && self.slots.iter().any(|slot| slot.fine().is_some()) {
            // Zones that touched in the pose given.
            let found = self.at_rest_by_hertz(None, (0..self.slots.len()).collect(), &held)?;
            if let Some(pose) = self.near_equilibrium(found)? {
                self.integrator.restart(t, &pose);
                y = pose;
            }
        }
        for _ in 0..MAX_LANDINGS {
            let arrival = self.settle(&mut y, &held, Pressing::Zones(&are_made))?;
            self.integrator.restart(t, &y);
            let is_at_rim = matches!(arrival, Arrival::Rim(_));
            let (i, known) = match arrival {
                Arrival::Settled => {
                    // What sticks now does so with the references of its first touch.
                    self.model.system.save();
                    return Ok(None);
                }
                Arrival::Beyond(i) => return Ok(Some(i)),
                Arrival::Touch(i) => (i, None),
                Arrival::Rim(i) => (i, self.slots[i].found.preview),
            };
            let has_zone = self.slots[i].fine().is_some();
            if has_zone {
                self.slots[i].found.preview = None;
            }
            let is_asked = sizes[i].is_none() || self.is_free_of_way();
            let pose = match self.slots[i].found.preview {
                None if is_asked => self.preview_at_rest(i, &held)?,
                _ => None,
            };
            if is_at_rim {
                // More has come to rest on it since its zone was made; else the way alone led beyond, or Hertz's law is not the one.
                let force = self.slots[i].found.preview;
                if !force.zip(known).is_some_and(|(force, known)| force >= MORE * known) {
                    self.slots[i].found.preview = known;
                    are_made[i] = true;
                    continue;
                }
            }
            if has_zone {
                self.deactivate(i)?;
            }
            if let Some(pose) = pose {
                self.integrator.restart(t, &pose);
            }
            self.activate(i, sizes[i])?;
            y = self.integrator.state().to_vec();
        }
        Err(AdaptiveError::Equilibrium(not_found(MAX_LANDINGS, 1.0)))
    }

    /// Notes the force of contact `i`, which touches, in equilibrium if Hertz's law, or that of a line, held there and in all contacts that have no
    /// zone yet, and their forces with it; nothing where there is no law, or no equilibrium of it. Returns the state of that equilibrium if the way to it
    /// counts for nothing.
    fn preview_at_rest(&mut self, i: usize, held: &[bool]) -> Result<Option<Vec<f64>>, AdaptiveError> {
        let waiting = (0..self.slots.len()).filter(|k| *k == i || self.slots[*k].is_watching()).collect();
        // What slides, since the law has no friction, presses all the same.
        for (which, may_slide) in [(waiting, false), (vec![i], true)] {
            let found = self.at_rest_by_hertz(Some(i), which, held)?;
            debug!(
                contact = self.model.contacts[i].name,
                forces = ?found.forces,
                is_settled = found.state.is_some(),
                "forces at rest by Hertz's law"
            );
            if found.state.is_some() || may_slide {
                let pressed = found.forces.iter().filter(|(_, f)| *f > 0.0);
                pressed.for_each(|(k, f)| self.slots[*k].found.preview = Some(*f));
                return self.near_equilibrium(found);
            }
        }
        Ok(None)
    }

    /// The state found by Hertz's law, where the equilibrium is near and the way to it counts for nothing: none of
    /// these contacts is open there, as where a line yields by less than its law says.
    fn near_equilibrium(&mut self, found: AtRest) -> Result<Option<Vec<f64>>, AdaptiveError> {
        let Some(pose) = found.state.filter(|_| self.is_free_of_way()) else { return Ok(None) };
        for (k, _) in found.forces.iter().filter(|(_, force)| *force > 0.0) {
            if self.open_gap(*k, &pose)? > 0.0 {
                return Ok(None);
            }
        }
        Ok(Some(pose))
    }

    /// Whether the way to an equilibrium counts for nothing: no contact has friction, and all get their zones on it.
    fn is_free_of_way(&self) -> bool {
        let is_smooth =
            |contact: &ContactFacts| contact.refinement.as_ref().is_some_and(|r| !r.has_friction());
        self.model.contacts.iter().all(is_smooth)
    }

    /// Forces of the contacts `which` that have a law by Hertz, of which `i` touches, in equilibrium; with it the state, if that was reached.
    fn at_rest_by_hertz(
        &mut self,
        i: Option<usize>,
        which: Vec<usize>,
        held: &[bool],
    ) -> Result<AtRest, AdaptiveError> {
        let y = self.integrator.state().to_vec();
        let settle = |driver: &mut Self, places: &[usize]| {
            let has_law = i.is_none_or(|i| places.contains(&i));
            let mut pose = y.clone();
            let is_settled = has_law && driver.settle(&mut pose, held, Pressing::Hertz(places)).is_ok();
            (has_law, is_settled.then_some(pose))
        };
        let ((has_law, state), forces) = self.under_laws(which, |k| i == Some(k), &y, settle)?;
        Ok(if has_law { AtRest { state, forces } } else { AtRest::default() })
    }

    /// For each rate whether its coordinate is none of the equilibrium: those of the joints of bodies that move at the start.
    fn moving_coordinates(&self) -> Vec<bool> {
        let model = self.model.system.model();
        let y = self.integrator.state();
        let mut held = vec![false; model.n_rates()];
        for body in &model.bodies {
            let moves = y[body.layout.velocities()].iter().any(|v| *v != 0.0);
            held[body.layout.rates_joint()].fill(moves);
        }
        held
    }

    /// Moves `y` towards equilibrium until it is there; with zones, until a contact touches that is to get its zone, or another one.
    fn settle(
        &mut self,
        y: &mut Vec<f64>,
        held: &[bool],
        pressing: Pressing<'_>,
    ) -> Result<Arrival, AdaptiveError> {
        let (t, zones) = (self.integrator.time(), matches!(pressing, Pressing::Zones(_)));
        let fail = |fault| Err(AdaptiveError::Equilibrium(fault));
        let size = self.size_of_all();
        let (mut radius, mut gone) = (FIRST * size, 0.0);
        let (mut has_closed, mut in_vain, mut best) = (vec![false; self.slots.len()], 0, (f64::INFINITY, 0));
        if zones && let Some(i) = self.touching()?.first() {
            return Ok(Arrival::Touch(*i));
        }
        let mut balance = self.model.system.balance(t, y, held).map_err(AdaptiveError::Model)?;
        for step in 0..MAX_STEPS {
            let residual = balance.residual();
            if residual < 0.5 * best.0 {
                best = (residual, step);
            }
            let gains_nothing = step - best.1 >= NO_GAIN;
            if residual <= BALANCED || gains_nothing && residual <= TOLD {
                debug!(step, residual, "equilibrium");
                return Ok(Arrival::Settled);
            }
            let Step { moved, outcome, is_short } = self.step(&balance, y, &mut radius)?;
            debug!(step, residual, radius, ?outcome, "towards equilibrium");
            if let Some((i, at)) = self.first_closing_between((y, &moved), pressing, &has_closed)? {
                (*y, radius, has_closed[i]) = (at, FIRST * size, true);
                if zones && self.slots[i].is_watching() {
                    return Ok(Arrival::Touch(i));
                }
                balance = self.balance_after(&balance, y, held)?;
                continue;
            }
            if let Pressing::Zones(are_made) = pressing
                && let Some(arrival) = self.leaves_zone(y, &moved, are_made)?
            {
                return Ok(arrival);
            }
            *y = moved;
            gone += radius;
            in_vain = if outcome.left > VAIN && !is_short { in_vain + 1 } else { 0 };
            if gone > FAR * size || in_vain > IN_VAIN {
                let change = balance.change(radius).0;
                return fail(self.unheld(y, &change, &balance));
            }
            let growth = match outcome.left {
                left if left < TURNED => 0.5,
                left if is_short && left > LEFT => GROWTH,
                _ if is_short => 2.0,
                _ => 1.0,
            };
            radius = (growth * radius).min(LONGEST * size);
            self.model
                .system
                .evaluate_accelerations(t, y)
                .map_err(|refusal| AdaptiveError::refused(t, refusal))?;
            if (outcome.left - outcome.expected).abs() < KNOWN && radius < SMALL * size {
                balance.refresh(&self.model.system);
            } else {
                balance = self.balance_after(&balance, y, held)?;
            }
            if self.output.observer.is_interrupted() {
                return Err(AdaptiveError::Interrupted);
            }
        }
        fail(not_found(MAX_STEPS, balance.residual()))
    }

    /// Where a contact that has its zone lands or presses beside it on the way from `y` to `moved`, which the system was
    /// evaluated in last: `y` is then the state of the landing, or that one.
    fn leaves_zone(
        &mut self,
        y: &mut Vec<f64>,
        moved: &[f64],
        are_made: &[bool],
    ) -> Result<Option<Arrival>, AdaptiveError> {
        let t = self.integrator.time();
        if let Some(i) = (0..self.slots.len()).find(|i| !are_made[*i] && self.is_narrow(*i)) {
            return Ok(Some(Arrival::Rim(i)));
        }
        for i in 0..self.slots.len() {
            let is_idle = self.model.system.forces()[i].is_idle();
            if self.slots[i].fine().is_none()
                || !is_idle
                || smallest_gap(&mut self.model.system, t, moved, i) <= 0.0
            {
                continue;
            }
            let gap = |driver: &mut Self, y: &[f64]| {
                driver.model.system.body_states(t, y);
                driver.slots[i].gap(&mut driver.model.system, (i, &driver.model.contacts[i]), y)
            };
            if let Some(share) = self.closing((y, moved), 1.0, gap)? {
                *y = self.part_of_way((y, moved), share);
                return Ok(Some(Arrival::Touch(i)));
            }
        }
        Ok(self.touched_outside(Some(moved))?.map(|i| {
            y.copy_from_slice(moved);
            Arrival::Beyond(i)
        }))
    }

    /// Whether the contact `i` reached the rim of a zone whose width nobody has given in the last evaluation.
    fn is_narrow(&self, i: usize) -> bool {
        let report = self.model.system.forces()[i].contact.report();
        report.is_rim_touched
            && report.normal_force > 0.0
            && self.slots[i].fine().is_some()
            && !self.is_width_given(i)
    }

    /// How far the state `y` is from equilibrium, after another one on the way there.
    fn balance_after(
        &mut self,
        before: &Balance,
        y: &[f64],
        held: &[bool],
    ) -> Result<Balance, AdaptiveError> {
        let t = self.integrator.time();
        let mut balance = self.model.system.balance(t, y, held).map_err(AdaptiveError::Model)?;
        balance.remember(before);
        Ok(balance)
    }

    /// A step from `y` after which no more than the allowed part of its work is left, with shorter ones where it went too far.
    fn step(&mut self, balance: &Balance, y: &[f64], radius: &mut f64) -> Result<Step, AdaptiveError> {
        let t = self.integrator.time();
        let mut refusal = None;
        for _ in 0..HALVINGS {
            let (change, is_short) = balance.change(*radius);
            let moved = self.model.system.displaced(t, y, &change);
            match self.model.system.evaluate_accelerations(t, &moved) {
                Ok(()) => {
                    let outcome = balance.outcome((&change, *radius), self.model.system.accelerations());
                    if (BACK..=AWAY).contains(&outcome.left) {
                        return Ok(Step { moved, outcome, is_short });
                    }
                    // Where the push changes its sign, if it does so evenly.
                    *radius =
                        balance.displacement(&change) * (1.0 / (1.0 - outcome.left).abs()).clamp(0.01, 0.7);
                }
                Err(error) => {
                    refusal = Some(error);
                    *radius = 0.25 * balance.displacement(&change);
                }
            }
        }
        Err(match refusal {
            Some(refusal) => AdaptiveError::refused(t, refusal),
            None => AdaptiveError::Equilibrium(not_found(HALVINGS, balance.residual())),
        })
    }

    /// The first open contact that closes for the first time on the way from `y` to `moved`, and the state in which it touches; of those
    /// that wait for their zones only if these are made.
    fn first_closing_between(
        &mut self,
        (y, moved): (&[f64], &[f64]),
        pressing: Pressing<'_>,
        has_closed: &[bool],
    ) -> Result<Option<(usize, Vec<f64>)>, AdaptiveError> {
        let mut first: Option<(usize, f64)> = None;
        for (i, has_closed) in has_closed.iter().enumerate() {
            let is_left = |places: &[usize]| places.contains(&i) || self.slots[i].is_watching();
            if *has_closed || matches!(pressing, Pressing::Hertz(places) if is_left(places)) {
                continue;
            }
            let most = first.map_or(1.0, |(_, share)| share);
            let share = self.closing((y, moved), most, |driver, y| driver.open_gap(i, y))?;
            first = share.map(|share| (i, share)).or(first);
        }
        Ok(first.map(|(i, share)| (i, self.part_of_way((y, moved), share))))
    }

    /// The share of the way from `y` to `moved`, `most` at most, at which `gap` closes; none if it is closed at first or open there.
    fn closing(
        &mut self,
        (y, moved): (&[f64], &[f64]),
        most: f64,
        gap: impl Fn(&mut Self, &[f64]) -> Result<f64, AdaptiveError>,
    ) -> Result<Option<f64>, AdaptiveError> {
        if gap(self, y)? <= 0.0 || gap(self, &between(y, moved, most))? > 0.0 {
            return Ok(None);
        }
        let (mut open, mut closed) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (open + closed);
            if gap(self, &between(y, moved, middle))? > 0.0 { open = middle } else { closed = middle }
        }
        Ok(Some(closed))
    }

    /// The state at `share` of the way from `y` to `moved`, with loops closed.
    fn part_of_way(&mut self, (y, moved): (&[f64], &[f64]), share: f64) -> Vec<f64> {
        let mut at = between(y, moved, share);
        self.model.system.project(self.integrator.time(), &mut at);
        at
    }

    /// Gap of contact `i` in the state `y` \[m\].
    fn open_gap(&mut self, i: usize, y: &[f64]) -> Result<f64, AdaptiveError> {
        let t = self.integrator.time();
        if !self.slots[i].is_watching() {
            return Ok(smallest_gap(&mut self.model.system, t, y, i));
        }
        self.model.system.body_states(t, y);
        self.slots[i].gap(&mut self.model.system, (i, &self.model.contacts[i]), y)
    }

    /// Size of the largest body \[m\].
    fn size_of_all(&self) -> f64 {
        let bodies = self.model.bodies.iter().map(|body| &body.data).filter(|data| data.mass.is_finite());
        let bodies = bodies.map(|data| (data.second_moment.trace() / data.mass).sqrt());
        self.model.contacts.iter().map(|contact| contact.size).chain(bodies).fold(0.0, f64::max)
    }

    /// The body that `change` moves most, which nothing holds in the state `y`.
    fn unheld(&mut self, y: &[f64], change: &[f64], balance: &Balance) -> String {
        let t = self.integrator.time();
        let Some((body, moved, turned)) = self.model.system.most_moved(t, y, change) else {
            return not_found(0, balance.residual());
        };
        let force = balance.work(change) / moved.norm().max(turned.norm()).max(f64::MIN_POSITIVE);
        let name = self.model.bodies[body].name.clone();
        let data = &self.model.bodies[body].data;
        let turns = turned.norm() * (data.second_moment.trace() / data.mass).sqrt() > moved.norm();
        let along = if turns { turned } else { moved };
        format!(
            "body \"{name}\" is not held: nothing balances {force:.4e} {} it {} {along}; hold it by a joint, a spring or a contact, or give it a \
         velocity if it is to move",
            if turns { "N m on" } else { "N on" },
            if turns { "about" } else { "along" },
            along = Components(along.normalize())
        )
    }
}

/// The state at `share` of the way between two.
fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect()
}

/// Why there is no equilibrium after so many steps, with the share of the forces that is left.
fn not_found(steps: usize, residual: f64) -> String {
    format!(
        "{residual:.1e} of the forces are left after {steps} steps; begin with a pose nearer to rest, or let bodies and joints come to rest in a \
         run with damping"
    )
}
