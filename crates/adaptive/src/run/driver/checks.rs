//! What a run checks of itself: warnings, and errors that end it.

use std::f64::consts::PI;

use contact_qs::Meeting;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::integration::OdeSystem;
use nalgebra::Vector3;

use super::{Driver, touching};
use crate::adaptivity::interval::fewest_at_once;
use crate::adaptivity::overlap::Overlap;
use crate::checks::contact_strain::{HUGE_CONTACT_STRAIN, contact_strain, large_contact_strain};
use crate::checks::resolution::{
    few_modes, highest_vibration, ringing_force, ringing_peak, shown_interval, slow_rise, sparse_output,
    wide_band,
};
use crate::checks::{motion, start};
use crate::error::AdaptiveError;
use crate::impact::FineContact;
use crate::impact::yielding::{Spread, contact_yields, stress_yields};
use crate::record::finding::ContactQuantity;
use crate::record::warning::{Warning, WarningKind};
use crate::record::{ImpactRecord, PeakOf};
use crate::run::driver::impact::judgement::MINOR;
use crate::spec::{LocalField, PenaltySearch};
use crate::state::impact_monitor::Ringing;
use crate::state::simulation::motion_at;
use crate::touch::detection::Search;
use crate::touch::parts::TouchKind;

/// Points across a contact at its peak below which they are too few: as many as elements of a zone that
/// the program refines (theory section A.1).
const FEWEST_ACROSS: f64 = 5.0;

/// Contacts that never close, each with a warning of its own, at most.
const MOST_OPEN: usize = 8;

/// Bodies whose gap at the start is smaller than so many times what the equilibrium changes it by touch:
/// what opened them is their deformation, and what they yield by in the contact is of its size.
const MOVED_BY_EQUILIBRIUM: f64 = 10.0;
/// Acceleration towards each other, as a share of all accelerations there, below which it is round-off.
const LEAST_PRESS: f64 = 1e-6;
/// Share of the contact force at the start by which it may miss what it settles at: less than the impacts of
/// a run are right to.
const SETTLED: f64 = 0.02;

/// What is doubtful about the zone of a contact and its penalty springs in an impact.
pub(super) struct Doubts {
    /// Elements in contact at one instant at most, as a share of those of an interval, and the least
    /// share, if contact moved along it and they were too few.
    few_at_once: Option<[f64; 2]>,
    /// How much of the approach was penetration, if it was too much and the contact could be
    /// judged, with the penalty factor that it was at [N/m³].
    too_soft: Option<(Overlap, f64)>,
    /// Which parts touched.
    pub touch: TouchKind,
    /// How many times stiffer they were than the modes follow.
    beyond_modes: f64,
    /// How its force rings.
    pub ringing: Option<Ringing>,
}

impl Driver<'_> {
    /// What is doubtful about zone and springs of contact `i` in the running impact; `is_minor`: whether
    /// its force is too small to judge them by.
    pub(super) fn doubts(&self, i: usize, is_minor: bool) -> Doubts {
        let whole = self.slots[i].fine().and_then(|fine| fine.whole);
        // The contact has its fine models still, and with them its factor.
        let penalty = self.model.system.forces()[i].contact.facts().penalty();
        let beyond = |kind| {
            let refinement = self.model.contacts[i].refinement.as_ref()?;
            Some(penalty / refinement.penalty_of_modes(kind, &self.model.bodies))
        };
        let few_at_once = || {
            let fine = self.slots[i].fine().filter(|fine| !is_minor && fine.has_moved())?;
            let settings = self.model.contacts[i].refinement.as_ref()?.interval_settings();
            fine.is_coarse(&settings).then(|| [fine.resolution(), fewest_at_once(settings.minimum)])
        };
        Doubts {
            few_at_once: few_at_once(),
            too_soft: self
                .overlap(i)
                .filter(|overlap| !is_minor && overlap.is_too_much())
                .map(|overlap| (overlap, penalty)),
            touch: self.slots[i].fine().map_or(TouchKind::Smooth, FineContact::touch),
            beyond_modes: whole.and_then(beyond).unwrap_or(0.0),
            ringing: self.slots[i].monitor.ringing(),
        }
    }

    /// Checks how the bodies lie at the start; the warnings of that and of the models.
    pub(super) fn check_start(&mut self) -> Result<Vec<(usize, Warning)>, AdaptiveError> {
        let mut searches: Vec<&mut Search> = self.slots.iter_mut().map(|slot| &mut slot.nearest).collect();
        let mut warnings = start::check(self.model, &mut searches)?;
        warnings.extend(start::of_bodies(self.model));
        for touch in &self.model.touches {
            warnings.extend(touch.warnings().map(|warning| (touch.body, warning)));
        }
        Ok(warnings)
    }

    /// Reports `warnings`, each with the index of its subject, that have not been given yet.
    pub(super) fn warn(&mut self, warnings: Vec<(usize, Warning)>) -> Result<(), AdaptiveError> {
        for (subject, warning) in warnings {
            let key = ((warning.kind as u64) << 32) | subject as u64;
            if !self.run.warned.contains(&key) {
                self.run.warned.push(key);
                self.output.observer.warning(&warning)?;
            }
        }
        Ok(())
    }

    /// Notes the gaps of the contacts that have not closed yet, in the state `interpolated` at time
    /// `t`.
    pub(super) fn note_gaps(&mut self, t: f64) -> Result<(), AdaptiveError> {
        self.model.system.body_states(t, &self.interpolated);
        for i in 0..self.slots.len() {
            if !self.run.contacts[i].has_closed() {
                let (system, facts) = (&mut self.model.system, &self.model.contacts[i]);
                let (y, contact) = (&self.interpolated, &mut self.run.contacts[i]);
                let gap = self.slots[i].gap_below(system, (i, facts), y, contact.smallest_gap)?;
                if let Some(gap) = gap.filter(|gap| *gap < contact.smallest_gap) {
                    (contact.smallest_gap, contact.smallest_gap_time) = (gap, t);
                }
            }
        }
        Ok(())
    }

    /// The warnings of contacts whose bodies touch at a start in equilibrium, as they are given or as it
    /// deforms them, and which loads press together: it holds joints and knows of no force that is not there
    /// yet. Bodies that overlap are pressed; others are by the acceleration of their rigid motions.
    pub(super) fn pressed_in_equilibrium(&mut self) -> Result<Vec<(usize, Warning)>, AdaptiveError> {
        let (t, y) = (self.integrator.time(), self.integrator.state());
        let system = &mut self.model.system;
        let (mut given, mut later) = (y.to_vec(), vec![0.0; y.len()]);
        system.model().bodies.iter().for_each(|body| given[body.layout.elastic()].fill(0.0));
        system.rhs(t, y, &mut later).map_err(|refusal| AdaptiveError::refused(t, refusal))?;
        let forces: Vec<f64> =
            system.forces().iter().map(|force| force.contact.report().normal_force).collect();
        let after = self.impact_step;
        later.iter_mut().zip(y).for_each(|(rate, y)| *rate = y + after * *rate);
        let mut warnings = Vec::new();
        for (i, (slot, facts)) in self.slots.iter_mut().zip(&self.model.contacts).enumerate() {
            system.body_states(t, &given);
            let undeformed = slot.gap(system, (i, facts), &given)?;
            system.body_states(t, y);
            let gap = slot.gap(system, (i, facts), y)?;
            let (touching, moved) = (touching(facts), MOVED_BY_EQUILIBRIUM * (gap - undeformed).abs());
            if undeformed.min(gap) > touching + moved {
                continue;
            }
            let (place, normal) = match &facts.refinement {
                Some(refinement) => {
                    system.body_states(t, y);
                    let found = refinement.nearest(system.last_evaluation().0, &mut slot.nearest)?;
                    (found.contact.point, found.normal)
                }
                None => {
                    let (force, motion) = system.force_in_motion(t, y, i);
                    let Meeting { place, normal, .. } = force.contact.meeting(motion);
                    (place, normal)
                }
            };
            let mut velocity = |y: &[f64]| {
                system.body_states(t, y);
                Vector3::from(motion_at(system, i, &place).velocity)
            };
            let acceleration = (velocity(&later) - velocity(y)) / after;
            let (closing, all) =
                (-acceleration.dot(&normal), acceleration.norm() + self.settings.gravity.norm());
            let (body, target) = system.forces()[i].contact.facts().bodies();
            let bodies = [Some(body), target].into_iter().flatten().map(|b| self.model.bodies[b].data.mass);
            let unsettled = closing * bodies.fold(f64::INFINITY, f64::min);
            let is_pressed = closing > LEAST_PRESS * all && unsettled > SETTLED * forces[i];
            if is_pressed || facts.refinement.is_some() && gap < -touching {
                warnings.push((i, start::static_contact(&facts.name)));
            }
        }
        Ok(warnings)
    }

    /// Looks at what contact was like at the peak of `impact`, the hardest of its contact in the running phase.
    pub(super) fn check_peak(&mut self, impact: &ImpactRecord) -> Result<(), AdaptiveError> {
        let i = impact.contact as usize;
        self.check_contact_strain(impact)?;
        if let Some((point, left_out)) = self.slots[i].at_peak.left_out {
            let subject = format!("output.points.{}", self.model.point_name(point));
            let warning = left_out.warning(subject, self.model.name_of(&left_out), impact.peak_time);
            self.warn(vec![(point, warning)])?;
        }
        let coarse = self.coarse_zone(i, impact);
        self.warn(coarse.map(|warning| (i, warning)).into_iter().collect())
    }

    /// Looks at a finished impact; `is_open`: whether the contact had let go; `is_minor`: whether
    /// its force was too small beside others to be judged by; `doubts`: what is doubtful about its
    /// zone and springs.
    pub(super) fn check_impact(
        &mut self,
        impact: &ImpactRecord,
        is_open: bool,
        is_minor: bool,
        doubts: &Doubts,
    ) -> Result<(), AdaptiveError> {
        let i = impact.contact as usize;
        let wide =
            self.settings.accuracy.and_then(|wanted| wide_band(&self.model.contacts[i].name, impact, wanted));
        self.warn(wide.map(|warning| (i, warning)).into_iter().collect())?;
        let (name, is_rigid) = (&self.model.contacts[i].name, self.is_rigid(i));
        let (body, target) = self.model.system.forces()[i].contact.facts().bodies();
        let bodies = [Some(body), target].into_iter().flatten();
        let touching: Vec<_> = bodies.clone().map(|b| &self.model.bodies[b]).collect();
        let rings = ringing_force(name, &touching, impact, doubts.beyond_modes)
            .or_else(|| doubts.ringing.and_then(|ringing| ringing_peak(name, &ringing, is_rigid)))
            .map(|warning| (i, warning));
        if !is_open {
            return self.warn(rings.into_iter().collect());
        }
        let needs = &self.model.force_needs[i];
        let few = |b: usize| Some((b, few_modes((b, &self.model.bodies[b]), impact, needs)?));
        let mut warnings: Vec<(usize, Warning)> = bodies.filter_map(few).collect();
        warnings.extend(rings);
        if doubts.touch.is_jump() {
            warnings.extend(slow_rise(name, &touching, impact).map(|warning| (i, warning)));
        }
        let few_at_once = doubts.few_at_once.map(|shares| (i, moving_contact(name, impact, shares)));
        warnings.extend(few_at_once);
        // Of rigid bodies the springs are all that yields.
        let too_soft = doubts.too_soft.filter(|_| !is_rigid);
        let refinement = self.model.contacts[i].refinement.as_ref();
        let may_search =
            refinement.is_some_and(|refinement| refinement.search_kind() == PenaltySearch::Fixed);
        warnings.extend(too_soft.map(|soft| (i, soft_contact((name, may_search), impact, soft))));
        if is_minor && self.model.contacts[i].refinement.is_some() {
            warnings.push((i, minor_contact(name, impact)));
        }
        self.warn(warnings)
    }

    /// Whether nothing yields in contact `i` but what its law has for it: no body of it is flexible.
    pub(super) fn is_rigid(&self, i: usize) -> bool {
        let (body, target) = self.model.system.forces()[i].contact.facts().bodies();
        [Some(body), target].into_iter().flatten().all(|body| self.model.bodies[body].flexible().is_none())
    }

    /// Points across contact `i` that carried its force at the peak.
    pub(super) fn points_across(&self, i: usize) -> f64 {
        let n = self.slots[i].at_peak.n_active as f64;
        match self.model.bodies[self.model.contacts[i].body].data.motion {
            RigidMotion::Spatial => (4.0 * n / PI).sqrt(),
            RigidMotion::Planar | RigidMotion::Axial => n,
        }
    }

    /// The warning of contact `i`, whose zone lasts for the run, of few points that carried the force at
    /// the peak of `impact`.
    fn coarse_zone(&self, i: usize, impact: &ImpactRecord) -> Option<Warning> {
        let (facts, element) = (&self.model.contacts[i], &self.model.system.forces()[i].contact);
        element.facts().point(0)?;
        if facts.refinement.is_some() || self.is_rigid(i) {
            return None;
        }
        let across = self.points_across(i);
        (across < FEWEST_ACROSS).then(|| Warning {
            kind: WarningKind::CoarseZone,
            subject: format!("contact \"{}\"", facts.name),
            time: impact.peak_time,
            value: across,
            limit: FEWEST_ACROSS,
            message: format!(
                "{across:.1} points across carried the {:.3e} N at its peak, of a zone {:.2e} m wide that stays as it is for the run: the \
                 force may be off by {}, and by more when it is smaller",
                impact.peak_force,
                facts.widths[0],
                match facts.local_field {
                    LocalField::Static | LocalField::Vibrating => "several per cent",
                    // Nothing but the modes yields there.
                    LocalField::ModesAlone => "a few times itself",
                }
            ),
            remedy: format!(
                "leave contacts.{0}.model out, and contacts.{0}.interval if it is given, so that the program refines the zone; else give more elements there",
                facts.name
            ),
        })
    }

    /// Looks at how hard the bodies pressed each other at the peak of `impact` (Eq. P.15).
    fn check_contact_strain(&mut self, impact: &ImpactRecord) -> Result<(), AdaptiveError> {
        let i = impact.contact as usize;
        let facts = &self.model.contacts[i];
        let pressure = self.slots[i].at_peak.pressure;
        let strain = contact_strain(pressure, facts.modulus);
        if strain > HUGE_CONTACT_STRAIN {
            let (contact, time, quantity) = (facts.name.clone(), impact.peak_time, ContactQuantity::Strain);
            let (value, limit) = (strain, HUGE_CONTACT_STRAIN);
            return Err(AdaptiveError::ImplausibleContact { contact, time, quantity, value, limit });
        }
        let is_flat = self.slots[i].fine().and_then(|fine| fine.whole).is_some_and(TouchKind::is_jump);
        let spread = match self.model.bodies[facts.body].data.motion {
            _ if is_flat => Spread::Even,
            RigidMotion::Planar => Spread::Strip,
            RigidMotion::Spatial | RigidMotion::Axial => Spread::Ellipse,
        };
        let large = large_contact_strain(&facts.name, impact, (pressure, strain));
        let yields = contact_yields(&facts.name, impact, spread, (pressure, facts.yield_strength));
        self.warn([large, yields].into_iter().flatten().map(|warning| (i, warning)).collect())
    }

    /// Looks at the vibrations that an impact has left: states are stored as often as they ask for,
    /// or a warning says that they are not.
    pub(super) fn check_output(&mut self) -> Result<(), AdaptiveError> {
        let (time, y) = (self.integrator.time(), self.integrator.state());
        if time >= self.settings.end_time {
            return Ok(());
        }
        self.model.system.body_states(time, y);
        let states = self.model.system.last_evaluation().0;
        let scale = self.run.ledger.scale;
        let bodies = self.model.bodies.iter().zip(states).enumerate();
        let rings =
            bodies.filter_map(|(b, (body, state))| Some((b, body, highest_vibration(body, state, scale)?)));
        let Some(interval) = self.settings.free_interval else {
            let highest = rings.map(|(_, _, frequency)| frequency).fold(0.0, f64::max);
            self.run.free_interval = self.usual_interval.min(shown_interval(highest));
            return Ok(());
        };
        let sparse = |(b, body, highest)| Some((b, sparse_output(body, highest, (time, interval))?));
        let warnings = rings.filter_map(sparse).collect();
        self.warn(warnings)
    }

    /// Looks back from the end of the run.
    pub(super) fn check_end(&mut self) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.state());
        self.note_gaps(self.integrator.time())?;
        let contacts = self.model.contacts.iter().zip(&self.run.contacts).enumerate();
        let open = contacts.filter(|(_, (_, c))| !c.has_closed() && c.smallest_gap.is_finite());
        let mut open: Vec<_> = open.collect();
        // Of the pairs of many bodies most do not meet: the one that came nearest stands for all.
        let others = if open.len() > MOST_OPEN { open.len() - 1 } else { 0 };
        if others > 0 {
            open.sort_by(|(_, (_, a)), (_, (_, b))| a.smallest_gap.total_cmp(&b.smallest_gap));
            open.truncate(1);
        }
        let warnings = open.into_iter().map(|(i, (facts, state))| {
            let (gap, time) = (state.smallest_gap, state.smallest_gap_time);
            let warning = Warning {
                kind: WarningKind::NeverClosed,
                subject: format!("contact \"{}\"", facts.name),
                time,
                value: gap,
                limit: 0.0,
                message: format!(
                    "it has never closed{}; the smallest gap of the stored states was {gap:.6e} m at t = {time:.6e} s",
                    if others > 0 { format!(", as {others} others that came no nearer") } else { String::new() }
                ),
                remedy: "check positions and velocities of its bodies, or raise simulation.end_time".into(),
            };
            (i, warning)
        });
        let stresses = self.run.peaks.records.iter().filter(|peak| peak.of == PeakOf::VonMises);
        let yields = stresses.filter_map(|peak| {
            let (k, n) = (peak.index as usize, self.model.contacts.len());
            let strength = self.model.yield_strengths[self.model.observed.points[k].body];
            let subject = format!("output.points.{}", self.model.point_name(k));
            // Numbers of points follow those of contacts, which may yield as well.
            Some((n + k, stress_yields(subject, (peak.value, peak.time), strength)?))
        });
        let warnings = warnings.chain(yields).collect();
        self.warn(warnings)
    }

    /// Ends the run if the ledger is open by more than allowed in the state noted last.
    pub(super) fn check_ledger(&self) -> Result<(), AdaptiveError> {
        self.run.ledger.check(self.imbalance, self.output.sample.time, self.settings.energy_tolerance)
    }

    /// Ends the run if the present state is none that the equations describe.
    pub(super) fn check_motion(&mut self) -> Result<(), AdaptiveError> {
        let (t, y) = (self.integrator.time(), self.integrator.state());
        // Bodies may be at rest in every state that is stored.
        self.run.ledger.see(self.model.system.invariants(t, y).kinetic);
        let states = self.model.system.last_evaluation().0;
        self.limits.check(&self.model.bodies, states, t)?;
        self.linear.note(&self.model.bodies, states, t)
    }

    /// Tells how far the bodies have gone beyond what linear deformation describes in the running
    /// phase.
    pub(super) fn warn_of_nonlinearity(&mut self) -> Result<(), AdaptiveError> {
        let warnings = self.linear.warnings(&self.model.bodies);
        self.warn(warnings)
    }

    /// Ends the run if the bodies of contact `i`, which move at `approach` towards each other, are
    /// faster than waves or have come into each other by more than their size.
    pub(super) fn check_contact(&self, i: usize, time: f64, approach: f64) -> Result<(), AdaptiveError> {
        let facts = &self.model.contacts[i];
        let depth = self.model.system.forces()[i].contact.report().penetration;
        let fast = motion::fast_approach(&facts.name, time, approach, facts.wave_speed);
        match fast.or_else(|| motion::deep_penetration(&facts.name, time, depth, facts.deepest)) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}

/// The warning of a contact whose springs, of a factor that nobody may change, are as soft as the
/// bodies (Eq. A.36); `may_search`: whether the scenario could leave the factor to the program.
fn soft_contact(
    (name, may_search): (&str, bool),
    impact: &ImpactRecord,
    (overlap, penalty): (Overlap, f64),
) -> Warning {
    Warning {
        kind: WarningKind::SoftContact,
        subject: format!("contact \"{name}\""),
        time: impact.start,
        value: overlap.share,
        limit: overlap.most(),
        message: format!(
            "{:.0} % of the approach of the bodies is penetration and not deformation: the contact is softer than they are",
            100.0 * overlap.share
        ),
        remedy: format!(
            "give contacts.{name}.penalty.initial, {:.0} times as large as the {penalty:.1e} N/m^3 in use{}",
            (overlap.share / overlap.most()).ceil(),
            if may_search { ", or leave penalty.search out" } else { "" }
        ),
    }
}

/// The warning of a contact that moved so far along its interval that few elements, `share` of those
/// of an interval, touched at one instant; `limit` is the least that may.
fn moving_contact(name: &str, impact: &ImpactRecord, [share, limit]: [f64; 2]) -> Warning {
    Warning {
        kind: WarningKind::MovingContact,
        subject: format!("contact \"{name}\""),
        time: impact.start,
        value: share,
        limit,
        message: format!(
            "it moved along its interval so far that {:.0} % of the elements of one touched at one instant at most: the force is that of \
             larger elements than elsewhere",
            100.0 * share
        ),
        remedy: format!("raise contacts.{name}.interval.elements, or interval.accuracy"),
    }
}

/// The warning of a contact whose zone and penalty factor were not judged.
fn minor_contact(name: &str, impact: &ImpactRecord) -> Warning {
    Warning {
        kind: WarningKind::MinorContact,
        subject: format!("contact \"{name}\""),
        time: impact.start,
        value: impact.peak_force,
        limit: MINOR,
        message: format!(
            "its largest force of {:.3e} N is below {MINOR:.0e} of the largest on the bodies that it is connected with: it changes their \
             motion by no more, and the width of its zone and its penalty factor were not judged",
            impact.peak_force
        ),
        remedy: format!("give contacts.{name}.interval.width if this contact matters by itself"),
    }
}
