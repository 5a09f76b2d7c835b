//! Judgement of a trial of an impact: whether it is the result, and what the next one is to be
//! like.

use ffr_dynamics::error::EvaluationFailure;
use tracing::debug;

use super::intervals::{Intervals, TriedInterval};
use super::trial_reason::{Acceptance, Change, Demand, PenaltyCause};
use crate::adaptivity::interval::{IntervalAssessment, IntervalSettings};
use crate::adaptivity::overlap::{Overlap, Pressing};
use crate::adaptivity::penalty_search::{PenaltyAction, PenaltyFailure, RunOutcome};
use crate::checks::resolution::longest_element_of;
use crate::error::AdaptiveError;
use crate::impact::{AdaptiveContact, FineContact};
use crate::run::driver::contact_slot::ContactSlot;
use crate::run::driver::{Driver, TOUCHING};
use crate::touch::parts::TouchKind;
use crate::uncertainty::accuracy::{MOST_FINER, Remedy, remedy};

/// Share of the largest force on connected bodies below which a contact is not judged: a twentieth
/// of the change of the peak force down to which penalty factors are searched. Such a contact
/// changes no motion by more, and its force may be no more than the error of the motion, as between
/// bodies at rest that a wave has not reached yet.
pub(crate) const MINOR: f64 = 1e-4;
/// Trials of an impact at most that are to make the band of a contact narrower.
const MOST_SHARPER: u32 = 3;

/// How a trial of an impact ended.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Ending {
    /// All contacts are open for good, or the simulated time is up.
    Complete,
    /// The observer asked to stop.
    Interrupted,
    /// An interval of a refined contact turned out too small.
    EdgeTouched(usize),
    /// Contact went on to the end of its zone, which is acceptable so far.
    Travelled(usize),
    /// The peak of the force has shown that another penalty factor follows.
    PastPeak,
    /// The steps with contact after which the penalty search stops a trial have passed.
    TrialPassed,
    /// The contact solver failed.
    SolverFailed(EvaluationFailure),
}

/// The consequence of a trial: accepted, or to be repeated.
pub(crate) enum Judgement {
    Accept(Acceptance),
    Again { demands: Vec<Demand>, contact_steps: Option<usize> },
}

impl Driver<'_> {
    pub(crate) fn no_model(&self, i: usize, trials: u32) -> AdaptiveError {
        AdaptiveError::NoAcceptableModel {
            contact: self.model.contacts[i].name.clone(),
            time: self.work.start,
            trials,
            width: self.slots[i].fine().map_or(0.0, |f| f.widths()[0]),
        }
    }

    pub(crate) fn is_width_given(&self, i: usize) -> bool {
        self.model.contacts[i].refinement.as_ref().is_some_and(AdaptiveContact::is_width_given)
    }

    /// Whether whole surfaces can take the place of the interval of contact `i`: no element of the
    /// bodies, of which rigid ones have none, is longer than it is wide.
    fn may_be_whole(&self, i: usize) -> bool {
        let (body, target) = self.model.system.forces()[i].contact.facts().bodies();
        let width = self.slots[i].fine().map_or(0.0, |fine| fine.widths()[0]);
        let is_fine = |b: usize| longest_element_of(&self.model.bodies[b]).is_none_or(|l| l <= width);
        self.model.contacts[i].refinement.as_ref().is_some_and(AdaptiveContact::may_be_whole)
            && [Some(body), target].into_iter().flatten().all(is_fine)
    }

    /// Answer of Algorithm 2 for every refined contact that touched, but for the `minor` ones.
    pub(crate) fn assess(&self, minor: &[bool]) -> Vec<Option<IntervalAssessment>> {
        let mut verdicts = vec![None; self.slots.len()];
        for (i, (slot, contact)) in self.slots.iter().zip(&self.model.contacts).enumerate() {
            let Some(refinement) = &contact.refinement else { continue };
            let fine = slot.fine().filter(|f| f.has_touched() && !minor[i]);
            verdicts[i] = fine.map(|f| f.assess(&refinement.interval_settings()));
        }
        verdicts
    }

    /// Whether the trial is the result, and what the next one is to be like.
    pub(crate) fn judge(
        &mut self,
        ending: &Ending,
        (verdicts, minor): (&[Option<IntervalAssessment>], &[bool]),
        intervals: &mut Intervals,
        number: u32,
    ) -> Result<Judgement, AdaptiveError> {
        if *ending == Ending::Interrupted {
            return Ok(Judgement::Accept(Acceptance::Interrupted));
        }
        // Intervals first: an unacceptable model says nothing about the penalty factor.
        let mut demands = Vec::new();
        if let Ending::EdgeTouched(i) = *ending
            && let Some(reach) = self.slots[i].fine().and_then(FineContact::wider)
        {
            (self.slots[i].found.reach, intervals.latest) = (Some(reach), i);
            demands.push(self.demand(i, Change::Reach(reach)));
            return Ok(Judgement::Again { demands, contact_steps: self.restart_searches() });
        }
        if let Ending::EdgeTouched(i) = *ending
            && self.slots[i].lacks_zone()
        {
            intervals.latest = i;
            demands.push(self.demand(i, Change::Beside(self.slots[i].found.touches.len())));
            return Ok(Judgement::Again { demands, contact_steps: self.restart_searches() });
        }
        for (i, verdict) in verdicts.iter().enumerate() {
            let (Some(verdict), false) = (verdict, self.is_width_given(i)) else { continue };
            let is_short = matches!(ending, Ending::TrialPassed | Ending::PastPeak | Ending::SolverFailed(_));
            let is_edge = *ending == Ending::EdgeTouched(i);
            let is_target_at_end = is_edge && self.slots[i].fine().is_some_and(FineContact::is_target_at_end);
            if verdict.is_at_face_end() || is_target_at_end && !verdict.touches_edge() {
                if !self.may_be_whole(i) {
                    return Err(self.face_end(i, number));
                }
                intervals.take_whole(i);
                demands.push(self.demand(i, Change::WholeSurfaces));
                continue;
            }
            // A trial that ends early has not used its interval yet.
            let is_cut = matches!(ending, Ending::EdgeTouched(_) | Ending::Travelled(_));
            if is_edge && self.slots[i].fine().is_some_and(FineContact::fits_twice) {
                self.slots[i].found.left += 1;
            }
            if is_edge || !(verdict.is_acceptable() || is_short || is_cut || self.slots[i].found.travels) {
                let Some((fine, tried)) = self.tried(i, ending) else { continue };
                let wanted = match is_edge && !verdict.touches_edge() {
                    // Contact left the target's interval.
                    true => fine.widths().map(|w| w * (1.0 + IntervalSettings::default().max_change)),
                    false => verdict.widths(),
                };
                if let Some(next) = intervals.next(i, &tried, verdict, wanted) {
                    let directions =
                        verdict.directions.iter().zip(next).map(|(d, width)| (d.utilisation, width));
                    let change = Change::Widths { is_edge, directions: directions.collect() };
                    demands.push(self.demand(i, change));
                    continue;
                }
            }
            if *ending == Ending::Travelled(i) {
                demands.extend(self.shorter(i, intervals));
            }
            if *ending == Ending::Complete {
                demands.extend(self.finer(i, verdict, intervals));
            }
        }
        if !demands.is_empty() {
            return Ok(Judgement::Again { demands, contact_steps: self.restart_searches() });
        }
        let judgement = self.judge_penalties(ending, (verdicts, minor), number)?;
        if let (Judgement::Accept(_), Ending::Complete, Some(wanted)) =
            (&judgement, ending, self.settings.accuracy)
        {
            for (i, minor) in minor.iter().enumerate() {
                demands.extend(self.sharper(i, wanted, *minor, intervals));
            }
            if !demands.is_empty() {
                return Ok(Judgement::Again { demands, contact_steps: None });
            }
        }
        Ok(judgement)
    }

    /// The interval of contact `i` in a trial that ended as said, with its fine model.
    fn tried(&self, i: usize, ending: &Ending) -> Option<(&FineContact, TriedInterval)> {
        let fine = self.slots[i].fine()?;
        let asked = self.model.contacts[i].refinement.as_ref()?.interval_settings().minimum;
        // Whoever asks for more than is usual gets it.
        let is_told = *ending == Ending::Complete && asked <= IntervalSettings::default().minimum;
        let tried = TriedInterval {
            widths: fine.widths(),
            n_elements: fine.n_elements(),
            finer: fine.finer(),
            is_edge: *ending == Ending::EdgeTouched(i),
            peak: is_told.then(|| self.slots[i].monitor.judged_peak()),
        };
        Some((fine, tried))
    }

    /// The demand for a finer zone and stiffer springs of contact `i` if the band of its peak force is wider than `wanted`, a share of it, and
    /// these make it narrower (Eq. U.14).
    fn sharper(
        &mut self,
        i: usize,
        wanted: f64,
        is_minor: bool,
        intervals: &mut Intervals,
    ) -> Option<Demand> {
        let fine = self.slots[i]
            .fine()
            .filter(|f| f.has_touched() && f.touch() == TouchKind::Smooth && !is_minor)?;
        if self.slots[i].found.sharper >= MOST_SHARPER {
            return None;
        }
        let shares = self.shares_of_trial(i, is_minor)?;
        let mut next = remedy(&shares, wanted)?;
        let before = fine.finer();
        let finer = if self.is_width_given(i) { before } else { (before * next.finer).min(MOST_FINER) };
        let stiffer = fine.search.raised_by(next.stiffer).filter(|_| next.stiffer > 1.0);
        let is_finer = finer > before;
        if !is_finer && stiffer.is_none() {
            return None;
        }
        next = Remedy { finer: finer / before, stiffer: stiffer.as_ref().map_or(1.0, |_| next.stiffer) };
        let widths = fine.widths();
        let search = stiffer.unwrap_or_else(|| fine.search.clone());
        let slot = &mut self.slots[i];
        slot.found.sharper += 1;
        if is_finer {
            slot.found.search = Some(search);
            intervals.refine(i, widths, finer);
        } else if let Some(fine) = slot.fine_mut() {
            fine.search = search;
        }
        let band = shares.iter().map(|(_, share)| share).sum();
        Some(self.demand(i, Change::Accuracy { band, wanted, next }))
    }

    /// The demand for a shorter zone of contact `i`, which goes on beyond it and had too few of its elements at one instant.
    fn shorter(&self, i: usize, intervals: &mut Intervals) -> Option<Demand> {
        let (fine, refinement) = (self.slots[i].fine()?, self.model.contacts[i].refinement.as_ref()?);
        let settings = refinement.interval_settings();
        let size = fine.size_on_the_way(settings.target);
        if !fine.is_coarse(&settings) || self.has_size(i, Some(size)) {
            return None;
        }
        intervals.go_on(i, Some(size));
        let directions = fine.shares_at_once().zip(size.widths()?).collect();
        Some(self.demand(i, Change::Widths { is_edge: false, directions }))
    }

    /// The demand for more elements in the interval of contact `i`, whose width is settled, if
    /// contact moved along it so far that too few of them touched at one instant (theory section A.1).
    fn finer(&self, i: usize, verdict: &IntervalAssessment, intervals: &mut Intervals) -> Option<Demand> {
        let (fine, refinement) = (self.slots[i].fine()?, self.model.contacts[i].refinement.as_ref()?);
        let settings = refinement.interval_settings();
        let resolution = fine.resolution();
        debug!(contact = self.model.contacts[i].name, resolution, finer = fine.finer(), "elements at once");
        let finer = fine.wanted_finer(settings.target);
        // An interval that is as narrow as can be need not be used.
        let is_spared =
            verdict.directions.iter().any(|d| d.verdict.is_acceptable() && d.utilisation < settings.minimum);
        if is_spared || intervals.agree(i) || !fine.is_coarse(&settings) || finer <= fine.finer() {
            return None;
        }
        intervals.refine(i, fine.widths(), finer);
        Some(self.demand(i, Change::Finer { share: resolution, times: finer }))
    }

    fn judge_penalties(
        &mut self,
        ending: &Ending,
        (verdicts, minor): (&[Option<IntervalAssessment>], &[bool]),
        number: u32,
    ) -> Result<Judgement, AdaptiveError> {
        let mut demands = Vec::new();
        let mut limit = None;
        if matches!(ending, Ending::Travelled(i) if !self.has_lasted(*i)) {
            return Ok(Judgement::Accept(self.acceptance(verdicts, minor)));
        }
        for (i, minor) in minor.iter().enumerate() {
            let (peak_force, overlap) = (self.slots[i].monitor.judged_peak(), self.overlap(i));
            debug!(contact = self.model.contacts[i].name, peak_force, ?overlap, "penetration over approach");
            let Some(fine) = self.slots[i].fine_mut() else { continue };
            if (!fine.has_touched() || *minor) && !matches!(ending, Ending::SolverFailed(_)) {
                continue;
            }
            let before = fine.search.penalty();
            let cause = penalty_cause(ending, overlap);
            let outcome = match ending {
                Ending::TrialPassed => RunOutcome::TrialPassed,
                Ending::SolverFailed(_) => RunOutcome::SolverError,
                _ => RunOutcome::Completed { peak_force, overlap },
            };
            let after = match fine.search.next(outcome) {
                PenaltyAction::Accept { is_last_run: true, .. } => continue,
                PenaltyAction::Accept { penalty, is_last_run: false } => {
                    // The run with this factor is gone: it is made again.
                    fine.search = fine.search.accepted();
                    penalty
                }
                PenaltyAction::Run { penalty, contact_steps } => {
                    limit = limit.or(contact_steps);
                    penalty
                }
                PenaltyAction::Resume { penalty } => penalty,
                PenaltyAction::Fail(failure) => {
                    let contact = self.model.contacts[i].name.clone();
                    let time = self.work.start;
                    let refusal = match (ending, failure) {
                        (Ending::SolverFailed(refusal), PenaltyFailure::TooLow { .. }) => {
                            Some(refusal.clone())
                        }
                        _ => None,
                    };
                    return Err(AdaptiveError::Penalty { contact, time, trials: number, failure, refusal });
                }
            };
            demands.push(self.demand(i, Change::Penalty { cause, before, after }));
        }
        if demands.is_empty() {
            return Ok(Judgement::Accept(self.acceptance(verdicts, minor)));
        }
        Ok(Judgement::Again { demands, contact_steps: limit })
    }

    /// Whether the peaks of the contacts that have touched, all of which have turned back, show already that another penalty factor
    /// follows, and their intervals are acceptable: the rest of the trial would say no more (theory section
    /// A.4). Trials of Fig. 3 as printed end by themselves.
    pub(crate) fn is_past_peak(&self) -> bool {
        let touched = || self.refined().filter(|(_, fine)| fine.has_touched());
        if touched().any(|(i, fine)| !self.slots[i].monitor.has_turned() || fine.search.stops_at_errors()) {
            return false;
        }
        let follows = |(i, fine): (usize, &FineContact)| {
            let (peak_force, overlap) = (self.slots[i].monitor.judged_peak(), self.overlap(i));
            let next = fine.search.clone().next(RunOutcome::Completed { peak_force, overlap });
            matches!(next, PenaltyAction::Run { .. })
        };
        let is_acceptable = |(i, fine): (usize, &FineContact)| {
            let refinement = self.model.contacts[i].refinement.as_ref();
            refinement.is_some_and(|refinement| {
                self.is_width_given(i) || {
                    let verdict = fine.assess(&refinement.interval_settings());
                    verdict.is_acceptable() && !verdict.is_at_face_end()
                }
            })
        };
        // Whether a contact is minor is asked of all bodies: only where a search goes on.
        let following: Vec<usize> = touched().filter(|contact| follows(*contact)).map(|(i, _)| i).collect();
        if following.is_empty() {
            return false;
        }
        let minor = self.minor_contacts(&Ending::PastPeak);
        following.iter().any(|i| !minor[*i]) && touched().filter(|(i, _)| !minor[*i]).all(is_acceptable)
    }

    /// For every contact whether its force in a trial that ended as said was too small, beside the
    /// largest force on the bodies that it is connected with, to judge zone and penalty factor by
    /// it. In a trial cut short before the peaks no force is known to be small.
    pub(crate) fn minor_contacts(&self, ending: &Ending) -> Vec<bool> {
        if !matches!(ending, Ending::Complete | Ending::PastPeak) {
            return vec![false; self.slots.len()];
        }
        let peaks: Vec<f64> = self.slots.iter().map(|slot| slot.monitor.peak_force()).collect();
        let forces = self.model.system.forces().iter();
        let pairs: Vec<_> = forces.map(|force| force.contact.facts().bodies()).collect();
        let is_closed =
            self.slots.iter().zip(&peaks).map(|(slot, peak)| slot.fine().is_some() || *peak > 0.0);
        let is_closed: Vec<bool> = is_closed.collect();
        minor(&peaks, &pairs, &is_closed, &self.groups)
    }

    /// How much of the approach of the bodies of contact `i` was penetration in the running impact;
    /// none where nothing approached, and where no springs stand between them: what Hertz's law
    /// calls approach is deformation.
    pub(crate) fn overlap(&self, i: usize) -> Option<Overlap> {
        let (facts, element) = (&self.model.contacts[i], &self.model.system.forces()[i].contact);
        let element = element.facts();
        if element.n_points() == 0 || !element.penalty().is_finite() {
            return None;
        }
        let before = self.slots[i].fine().map_or(0.0, |fine| fine.overlap);
        let (share, time) = self.slots[i].monitor.overlap_share(TOUCHING * facts.size, before)?;
        let is_jump = self.slots[i].fine().and_then(|fine| fine.whole).is_some_and(TouchKind::is_jump);
        let pressing = if is_jump { Pressing::of_flat_faces(time, facts.round_trip) } else { Pressing::Body };
        Some(Overlap { share, pressing })
    }

    fn acceptance(&self, verdicts: &[Option<IntervalAssessment>], minor: &[bool]) -> Acceptance {
        if self.refined().next().is_none() {
            return Acceptance::Given;
        }
        let contacts = self.model.contacts.iter();
        let little = contacts.clone().zip(verdicts).enumerate().filter_map(|(i, (contact, verdict))| {
            let verdict = verdict.as_ref().filter(|v| !(v.is_acceptable() || self.is_width_given(i)))?;
            let utilisation = verdict.directions.iter().map(|d| d.utilisation).fold(1.0, f64::min);
            Some((contact.name.clone(), utilisation))
        });
        let little = little.collect();
        let contacts = contacts.zip(minor).zip(&self.slots);
        let unjudged = contacts.filter(|((_, minor), slot)| **minor && slot.fine().is_some());
        let minor = unjudged.map(|((contact, _), _)| contact.name.clone()).collect();
        Acceptance::Judged { minor, share: MINOR, little }
    }

    pub(crate) fn demand(&self, i: usize, change: Change) -> Demand {
        Demand { contact: self.model.contacts[i].name.clone(), change }
    }

    pub(crate) fn restart_searches(&mut self) -> Option<usize> {
        let mut limit = None;
        for fine in self.slots.iter_mut().filter_map(ContactSlot::fine_mut) {
            if let PenaltyAction::Run { contact_steps, .. } = fine.search.restart() {
                limit = limit.or(contact_steps);
            }
        }
        limit
    }

    /// Error for a contact that reached the end of its surface.
    fn face_end(&self, i: usize, trials: u32) -> AdaptiveError {
        let width = self.slots[i].fine().map_or(0.0, |f| f.widths()[0]);
        AdaptiveError::IntervalAtEdge {
            contact: self.model.contacts[i].name.clone(),
            time: self.integrator.time(),
            trials,
            width,
        }
    }
}

/// Why a penalty factor is not the last one after a trial that ended as said, `overlap` of whose
/// approach was penetration.
fn penalty_cause(ending: &Ending, overlap: Option<Overlap>) -> PenaltyCause {
    match ending {
        Ending::TrialPassed => PenaltyCause::TrialPassed,
        Ending::SolverFailed(failure) => PenaltyCause::SolverFailed(failure.clone()),
        _ => match overlap.filter(Overlap::is_too_much) {
            Some(overlap) => PenaltyCause::TooSoft(overlap),
            None => PenaltyCause::NotCompared,
        },
    }
}

/// Contacts whose peak force is below [`MINOR`] of the largest among those that contacts and joints
/// connect them with. `pairs`: bodies of each contact; `is_closed`: whether they touched, with
/// force or without; `groups`: for each body the number of the group of bodies that joints connect.
fn minor(peaks: &[f64], pairs: &[(usize, Option<usize>)], is_closed: &[bool], groups: &[usize]) -> Vec<bool> {
    let mut cluster: Vec<usize> = groups.to_vec();
    for ((body, target), _) in pairs.iter().zip(is_closed).filter(|(_, closed)| **closed) {
        if let Some(target) = target {
            let (kept, merged) = (cluster[*body], cluster[*target]);
            cluster.iter_mut().filter(|c| **c == merged).for_each(|c| *c = kept);
        }
    }
    let mut largest = vec![0.0_f64; groups.len()];
    for (peak, (body, _)) in peaks.iter().zip(pairs) {
        largest[cluster[*body]] = largest[cluster[*body]].max(*peak);
    }
    peaks.iter().zip(pairs).map(|(peak, (body, _))| *peak < MINOR * largest[cluster[*body]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_is_minor_beside_those_that_it_is_connected_with() {
        let pairs = [(0, Some(1)), (1, Some(2)), (3, Some(4)), (5, None)];
        let (groups, closed) = ([0, 1, 2, 3, 4, 5], [true; 4]);
        let peaks = [100.0, 1e-3, 1e-3, 1e-9];
        assert_eq!(minor(&peaks, &pairs, &closed, &groups), [false, true, false, false]);
        // A joint between bodies 2 and 3 connects the third contact with the first.
        assert_eq!(minor(&peaks, &pairs, &closed, &[0, 1, 2, 2, 4, 5]), [false, true, true, false]);
        // A row of bodies that touch without force in the middle is connected; bodies that are
        // apart do not.
        let (row, peaks) = ([(0, Some(1)), (1, Some(2)), (2, Some(3))], [1.0, 0.0, 1e-9]);
        assert_eq!(minor(&peaks, &row, &[true; 3], &groups), [false, true, true]);
        assert_eq!(minor(&peaks, &row, &[true, false, true], &groups), [false, true, false]);
    }
}
