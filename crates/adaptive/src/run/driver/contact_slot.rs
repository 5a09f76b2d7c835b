//! A contact of the run: what its watching and its impacts need beside its model.

use ffr_dynamics::integration::Slope;

use crate::adaptivity::penalty_search::PenaltySearch;
use crate::error::AdaptiveError;
use crate::impact::stress::LeftOut;
use crate::impact::{AdaptiveContact, FineContact};
use crate::model::ContactFacts;
use crate::state::impact_monitor::ImpactMonitor;
use crate::state::simulation::{RunContact, System, gap_as_placed};
use crate::touch::detection::{Clearance, Nearest, Search};
use crate::uncertainty::trace::Trace;

/// State of a contact between steps. What outlasts an impact is in [`crate::state::ContactState`].
pub(super) struct ContactSlot {
    /// Which model the contact has at present.
    pub phase: ContactPhase,
    /// Follows the running impact.
    pub monitor: ImpactMonitor,
    /// What the contact was like at the largest force that the monitor knows of this phase.
    pub at_peak: AtPeak,
    /// What the trials of the running impact have found so far.
    pub found: Found,
    /// Search for the nearest points of the surfaces.
    pub nearest: Search,
    /// The model with whole surfaces that the last such impact had: it is the same in the next one.
    pub whole: Option<(RunContact, Box<FineContact>)>,
    /// What is known of the gap at the end of the last step without a search.
    pub clearance: Clearance,
    /// What bands of the running impact are made from.
    pub trace: Trace,
    /// How near the bodies were in the last step.
    pub nearness: Nearness,
}

/// A contact at its largest force in a phase, in whichever of its zones that was.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct AtPeak {
    /// Mean pressure; zero where too few points carry it to tell \[Pa\].
    pub pressure: f64,
    /// Points that carried force.
    pub n_active: usize,
    /// What the stress of an observed point leaves out of the contact, with the number of the point.
    pub left_out: Option<(usize, LeftOut)>,
}

/// What the trials of an impact have found of a contact for those that follow.
#[derive(Default)]
pub(super) struct Found {
    /// Peak force that a preview gave \[N\].
    pub preview: Option<f64>,
    /// Until when it pressed there; infinite if it did not cease \[s\].
    pub presses_until: f64,
    /// Zones that have given way to others: when they began \[s\] and their length along the way \[m\].
    pub handed: Vec<(f64, f64)>,
    /// How far whole surfaces are to reach in the next trial, if earlier ones were too small \[m\].
    pub reach: Option<f64>,
    /// Whether the sides of a mesh about the touch, as they are, hold it: no memory holds as many
    /// finer ones as a long touch wants.
    pub keeps_sides: bool,
    /// Whether the zone is one of several that the impact has had on its way.
    pub travels: bool,
    /// Where the bodies touch at once in the running impact, in the order in which that was found.
    pub touches: Vec<Nearest>,
    /// How far ahead of the touch the middles of the next zones lie, on contact body and target \[m\].
    pub ahead: [[f64; 3]; 2],
    /// Trials that ended at an end of a zone into which contact fits twice.
    pub left: u32,
    /// Trials that were to make the band of its peak force narrower.
    pub sharper: u32,
    /// Penalty search with which the next model of the contact goes on.
    pub search: Option<PenaltySearch>,
}

/// How near the bodies of a contact were in the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Nearness {
    /// Not in closed form.
    Unknown,
    /// Too far apart for a touch, by several times, and no impact is followed; or without a model that could tell.
    Far,
    /// Others, with the gaps at both ends, and how fast they may have closed in between \[m\].
    Near { gaps: [f64; 2], slope: Slope },
}

/// Model of a contact.
pub(super) enum ContactPhase {
    /// One for the whole run.
    Lasting,
    /// None: the surfaces are watched until they touch.
    Watching,
    /// Fine models of the bodies, as long as an impact lasts.
    Fine(Box<FineContact>),
}

impl ContactSlot {
    /// A contact before the first step, which `search`es its nearest points; `is_refined`: whether it gets fine models when its
    /// bodies touch.
    pub fn new(is_refined: bool, search: Search) -> Self {
        Self {
            phase: if is_refined { ContactPhase::Watching } else { ContactPhase::Lasting },
            monitor: ImpactMonitor::default(),
            at_peak: AtPeak::default(),
            found: Found::default(),
            nearest: search,
            whole: None,
            clearance: Clearance::UNKNOWN,
            nearness: Nearness::Unknown,
            trace: Trace::default(),
        }
    }

    /// The fine models, if the contact has some at present.
    pub fn fine(&self) -> Option<&FineContact> {
        match &self.phase {
            ContactPhase::Fine(fine) => Some(fine),
            ContactPhase::Lasting | ContactPhase::Watching => None,
        }
    }

    /// The same, to change what they hold.
    pub fn fine_mut(&mut self) -> Option<&mut FineContact> {
        match &mut self.phase {
            ContactPhase::Fine(fine) => Some(fine),
            ContactPhase::Lasting | ContactPhase::Watching => None,
        }
    }

    /// Whether the bodies touch at more places at once than zones lie about.
    pub fn lacks_zone(&self) -> bool {
        let n_zones = self.fine().map(|fine| fine.zones.first().map_or(0, |zone| zone.site.places().count()));
        n_zones.is_some_and(|n| n < self.found.touches.len())
    }

    /// Goes back to watching; the fine models that the contact had.
    pub fn take_fine(&mut self) -> Option<Box<FineContact>> {
        match std::mem::replace(&mut self.phase, ContactPhase::Watching) {
            ContactPhase::Fine(fine) => Some(fine),
            other => {
                self.phase = other;
                None
            }
        }
    }

    /// Gap of this contact, number `i` of the `system`, in the state `y` that it was placed in last; of one that is
    /// refined at a touch between the surfaces \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if the motions are not finite.
    pub fn gap(
        &mut self,
        system: &mut System,
        (i, facts): (usize, &ContactFacts),
        y: &[f64],
    ) -> Result<f64, AdaptiveError> {
        let Some(refinement) = &facts.refinement else { return Ok(gap_as_placed(system, y, i)) };
        Ok(refinement.nearest(system.last_evaluation().0, &mut self.nearest)?.gap)
    }

    /// As [`ContactSlot::gap`], if it is at most `most`.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if the motions are not finite.
    pub fn gap_below(
        &mut self,
        system: &mut System,
        contact: (usize, &ContactFacts),
        y: &[f64],
        most: f64,
    ) -> Result<Option<f64>, AdaptiveError> {
        let states = system.last_evaluation().0;
        let is_far = |refinement: &AdaptiveContact| refinement.detector.least_gap(states) > most;
        if contact.1.refinement.as_ref().is_some_and(is_far) {
            return Ok(None);
        }
        Ok(Some(self.gap(system, contact, y)?).filter(|gap| *gap <= most))
    }

    /// How near the bodies are where no distance tells: without a model nothing acts between them.
    pub fn without_distance(&self) -> Nearness {
        if self.is_watching() { Nearness::Far } else { Nearness::Unknown }
    }

    /// Whether the contact is watched, without a model.
    pub fn is_watching(&self) -> bool {
        matches!(self.phase, ContactPhase::Watching)
    }
}
