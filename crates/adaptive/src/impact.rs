//! A contact for which the program finds the refinement and the penalty factor itself (\[A\]
//! section 4).
//!
//! Between impacts the pair is only watched. At a touch, fine models are built about the nearest
//! points and become the contact's force element; widths and penalty factors of accepted impacts
//! seed the next search. Knows the bodies of its pair and their motion; knows no phases and no
//! trials.

use std::sync::Arc;

use contact_qs::law::penalty;
use contact_qs::search::{SurfaceModel, SurfaceSite};
use contact_qs::{ActiveContact, ContactError, Detector, PressureRecovery};
use ffr_dynamics::force::BodyState;

use crate::adaptivity::interval::{
    ContactFlags, DirectionUse, IntervalAssessment, IntervalEnd, IntervalGrid, IntervalSettings, Verdict,
    assess, fewest_at_once, finer_by, share_at_once,
};
use crate::adaptivity::penalty_search::{PenaltySearch, PenaltyStrategy};
use crate::body::fine::refined::FineBody;
use crate::body::point_compliance::{ObservedPlace, PointCompliance, compliances, points_on};
use crate::error::{AdaptiveError, ContactModelFault};
use crate::paper::fine_modes::FineModes;
use crate::record::ZoneSite;
use crate::record::ZoneSize;
use crate::spec::LowModes;
use crate::spec::{self, ContactSpec, SurfaceLaw, Target};
use crate::state::ImpactHistory;
use crate::state::simulation::ObservedPoint;
use crate::store::ModelCache;
use crate::system::body::{BodyModel, FlexibleModel};
use crate::touch::detection::{Nearest, Search};
use crate::touch::parts::{Touch, TouchKind};
use crate::touch::tolerances::TOUCHED_SURFACE;

mod kept_zone;
mod widths;
mod sites;
mod zone_model;
mod fine_side;
mod sides;
mod outside;
mod on_the_way;
pub mod local_deformation;
pub mod stress;
pub mod yielding;

use fine_side::FineSide;
pub use fine_side::RebuiltContact;
pub use outside::Outside;
use sides::SideRequest;
use sites::Sites;
pub use zone_model::ZoneModel;

/// Overlap of whole surfaces, as a share of the body's size, that is an error if no contact point
/// touches. It is far above the waves of ringing surfaces between points and far below the overlap
/// of bodies that pass through each other.
pub const MISSED_SURFACE: f64 = 1e-5;

/// Largest width of an interval, as a share of the body's size: with a centre at one end of the
/// body it then reaches the other end.
const WIDEST: f64 = 2.0;
/// Growth of the reach of a part of a surface that was too small.
const REACH_GROWTH: f64 = 4.0;
/// Relative tolerance when a width is compared with the least one, for round-off.
const LEAST_SLACK: f64 = 1e-9;
/// Ratio of successive penalty factors of a search, as in \[A\] section 4.1.
const PENALTY_RISE: f64 = 10.0;
/// Time steps with contact of a trial of the error-driven penalty search (\[A\] section 4.1).
const TRIAL_STEPS: usize = 30;

/// A contact that is refined during the run.
pub struct AdaptiveContact {
    /// Name.
    pub name: String,
    body: usize,
    target: Target,
    /// The target, if it is a flexible body and has fine models, too.
    flexible_target: Option<usize>,
    law: SurfaceLaw,
    /// The smaller thickness of two bodies of plane models \[m\].
    thickness: Option<f64>,
    /// Watches the pair.
    pub detector: Detector,
    cache: ModelCache,
}

/// Sizes for the log of trials.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TrialSizes {
    /// Elements of the bodies in contact.
    pub elements: u64,
    /// Their degrees of freedom.
    pub dofs: u64,
    /// Their interface degrees of freedom.
    pub interface: u64,
}

/// Fine models of a contact in an impact phase: what the run keeps of them beside the force
/// element.
pub struct FineContact {
    /// Contact element of each point.
    elements: Vec<[usize; 2]>,
    interval: IntervalGrid,
    /// Whether the target's interval ends where its surface does.
    is_target_at_end: bool,
    flags: ContactFlags,
    /// Most rows of elements that were in contact at one instant, per direction.
    at_once: [usize; 2],
    /// Sizes for the log.
    pub sizes: TrialSizes,
    /// Widths predicted for this impact \[m\].
    predicted: [f64; 2],
    /// Least widths: in narrower intervals round-off decides which points touch \[m\].
    least: [f64; 2],
    /// The kind of touch, if the zones are the whole surfaces of the bodies, or parts of them.
    pub whole: Option<TouchKind>,
    /// What is left of surfaces of which zones are parts.
    pub outside: Option<Outside>,
    /// Penalty search of this impact.
    pub search: PenaltySearch,
    /// `max_i(A_ii w_i)` [m³/N].
    weight: Option<f64>,
    /// Bodies that have modes of the fine model because of this contact.
    pub hosted: Vec<usize>,
    /// When the fine models came into the system.
    pub activation: Activation,
    /// How far the undeformed bodies overlapped then \[m\].
    pub overlap: f64,
    /// The fine models, one for each body.
    pub zones: Vec<ZoneOnBody>,
    /// How far a zone that lies on a smooth surface in place of its sides was moved along its
    /// normal (theory Eq. C.75); zero if none does \[m\].
    pub offset: f64,
    /// Displacements of observed points by the forces of the contact.
    pub points: Vec<PointCompliance>,
}

/// When a fine model came into the system, and as which one of the run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Activation {
    /// Time \[s\].
    pub time: f64,
    /// Number, from 1.
    pub number: u64,
}

/// A refined contact with its fine models, as it is built.
pub struct RefinedContact {
    /// The force element, for the system.
    pub element: Box<dyn ActiveContact>,
    /// Pressures from its point forces.
    pub recovery: PressureRecovery,
    /// Fine models whose modes their bodies are to have, by body.
    pub bases: Vec<(usize, FineBasis)>,
    /// The data that the run keeps beside them.
    pub contact: FineContact,
}

/// A fine model of a body and the modes of it that the body is to have.
pub struct FineBasis {
    /// The fine model.
    pub body: FineBody,
    /// Its modes, and how states are transferred to them.
    pub modes: FineModes,
}

/// The fine model of a contact on one of its bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneOnBody {
    /// Index of the body.
    pub body: usize,
    /// The place and widths of the zone.
    pub site: ZoneSite,
    /// Unknowns of its interface.
    pub n_unknowns: usize,
}

impl ZoneOnBody {
    /// Distance from its middle that no place of the zone has \[m\].
    pub fn reach(&self) -> f64 {
        self.site.size.widths().map_or(f64::INFINITY, |[first, second]| 0.5 * first.hypot(second))
    }
}

/// A function that is called between the stages of a build; an error of it ends the build.
pub type CancelCheck<'a> = dyn FnMut() -> Result<(), AdaptiveError> + 'a;

/// Where and for what force a contact is refined.
#[derive(Debug, Clone, Default)]
pub struct RefinementRequest<'a> {
    /// Size of the zones; `None`: predicted.
    pub size: Option<ZoneSize>,
    /// How far from the plane of the touch whole surfaces may press; none: as far as in a first trial \[m\].
    pub reach: Option<f64>,
    /// How far from the nearest places the middles of the intervals lie, on contact body and target, along the way of contact \[m\].
    pub ahead: [[f64; 3]; 2],
    /// Where the bodies touch beside the nearest places at once.
    pub others: &'a [Nearest],
    /// Peak force of a preview \[N\].
    pub peak: Option<f64>,
    /// Widths and penalty factors that earlier impacts have found.
    pub history: ImpactHistory,
    /// Penalty search of an earlier trial of the same impact, which goes on.
    pub search: Option<PenaltySearch>,
    /// When the model comes into the system.
    pub activation: Activation,
    /// Points of the bodies that are observed.
    pub points: &'a [ObservedPoint],
    /// Bodies whose modes must stay, for other contacts in the system act on them.
    pub fixed: &'a [usize],
}

impl AdaptiveContact {
    /// A contact to be refined between `bodies`; `surfaces` has the surface of every body that
    /// takes part in such contacts, `cache` the compliances of earlier runs.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if a body has no surface.
    pub fn new(
        spec: &ContactSpec,
        law: &SurfaceLaw,
        (bodies, surfaces): (&[BodyModel], &[Option<Arc<SurfaceModel>>]),
        cache: &ModelCache,
    ) -> Result<Self, AdaptiveError> {
        let surface = |body: usize| {
            let none = || AdaptiveError::no_surface(&bodies[body].name);
            surfaces[body].clone().ok_or_else(|| AdaptiveError::unsupported_contact(&spec.name, none()))
        };
        let thickness = |body: usize| bodies[body].flexible().and_then(|f| f.body.model().thickness());
        let flexible_target = spec.target.body().filter(|other| bodies[*other].flexible().is_some());
        Ok(Self {
            thickness: spec.bodies().filter_map(thickness).reduce(f64::min),
            name: spec.name.clone(),
            body: spec.body,
            target: spec.target,
            flexible_target,
            law: law.clone(),
            detector: Detector::of(spec.body, spec.target, surface)?,
            cache: cache.clone(),
        })
    }

    fn fail(&self, source: ContactError) -> AdaptiveError {
        AdaptiveError::Contact { contact: self.name.clone(), source }
    }

    /// A stored zone that does not belong to the models.
    fn not_of_models(&self, why: String) -> AdaptiveError {
        self.without_model(ContactModelFault::Stored(why))
    }

    fn without_model(&self, fault: ContactModelFault) -> AdaptiveError {
        AdaptiveError::ContactModel { contact: self.name.clone(), fault }
    }

    /// Nearest points in the motions `states`.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if the motions are not finite.
    pub fn nearest(&self, states: &[BodyState], search: &mut Search) -> Result<Nearest, AdaptiveError> {
        search.nearest(&self.detector, states).map_err(|e| self.fail(e))
    }

    /// Fine models at a `touch` in the motions `states`, with intervals of the widths wished for
    /// or, at the first trial of an impact, of a width predicted: for the peak force if a preview
    /// gave one.
    ///
    /// `check_cancel` is asked between stages.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of body or contact if no fine model can be built, or the error of `check_cancel`.
    pub fn refine(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        touch: &Touch,
        request: RefinementRequest<'_>,
        check_cancel: &mut CancelCheck<'_>,
    ) -> Result<RefinedContact, AdaptiveError> {
        let own_body = flexible(&bodies[self.body]);
        let Sites { own: site, target: target_site, predicted, least, whole } =
            self.sites(bodies, states, touch, &request)?;
        let modes = |body: usize| match request.fixed.contains(&body) {
            true => LowModes::Prolonged,
            false => self.law.transfer.modes,
        };
        let on = |body: usize| points_on(request.points, body, own_body.motion());
        let (points, places) = on(self.body);
        let (mut target_points, mut target_places) = (Vec::new(), Vec::new());
        if let Some(other) = self.flexible_target {
            (target_points, target_places) = on(other);
        }
        let on_own = SideRequest { body: own_body, site: &site, places: &places, modes: modes(self.body) };
        let (mut own, mut other) = match (self.flexible_target, &target_site) {
            (Some(other), Some(site)) => {
                let body = flexible(&bodies[other]);
                let on_target = SideRequest { body, site, places: &target_places, modes: modes(other) };
                let (own, target) = self.both_sides(on_own, on_target, check_cancel)?;
                (own, Some((other, target)))
            }
            _ => (self.side_on(on_own, check_cancel)?, None),
        };
        self.leave_out_of_target(&mut own, other.as_ref(), bodies);
        let (mut element, offset) =
            self.element_at(&mut own, &mut other, bodies, states, touch.nearest.gap)?;
        let on_body =
            |body, site, side: &FineSide| ZoneOnBody { body, site, n_unknowns: side.zone.unknowns.len() };
        let mut zones = vec![on_body(self.body, site, &own)];
        zones.extend(other.as_ref().zip(target_site).map(|((body, side), site)| on_body(*body, site, side)));
        let displaced = |(points, places): (&[usize], &[ObservedPlace]), body: usize, side: &FineSide| {
            let points = if side.points.ncols() == 0 { &[] } else { points };
            compliances(points, places, body, side.body.field().motion(), &side.points)
        };
        let mut observed = displaced((&points, &places), self.body, &own);
        let on_target = other.iter();
        observed.extend(
            on_target.flat_map(|(body, side)| displaced((&target_points, &target_places), *body, side)),
        );
        let weight = match self.is_vibrating() {
            true => self.static_weight(&mut own, &mut other, bodies, states)?,
            false => self.weight_of(element.as_mut(), states, whole.is_some())?,
        };
        let search = match (request.search, whole) {
            (Some(search), _) => search,
            (None, Some(kind)) => self.penalty_of_whole(kind, bodies, weight)?,
            (None, None) => self.penalty_search(&request.history, weight).map_err(|e| self.fail(e))?,
        };
        element.set_penalty(search.penalty()).map_err(|e| self.fail(e))?;
        let rest = whole.and_then(|_| self.outside(&own, other.as_ref().map(|(_, side)| side)));
        let grid = own.body.grid();
        let interval = if site.flat_face().is_some() { grid.up_to_edges() } else { grid };
        let sizes = sizes([Some(&own), other.as_ref().map(|(_, side)| side)]);
        let is_target_at_end = self.is_at_end_of_target(other.as_ref().map(|(_, side)| side));
        let (elements, recovery) =
            (own.body.contact_elements(&own.zone), PressureRecovery::new(&own.zone.points));
        let bases = fine_bases([(self.body, own)].into_iter().chain(other));
        let contact = FineContact {
            flags: ContactFlags::new(interval.n_elements),
            at_once: [0; 2],
            elements,
            interval,
            is_target_at_end,
            sizes,
            predicted,
            least,
            whole,
            outside: rest,
            search,
            weight,
            hosted: bases.iter().map(|(body, _)| *body).collect(),
            activation: request.activation,
            overlap: (0.0 - touch.nearest.gap).max(0.0),
            zones,
            offset,
            points: observed,
        };
        Ok(RefinedContact { element, recovery, bases, contact })
    }

    /// Whether the interval of the target side `other` ends where the surface of the target does. A
    /// rigid target has its whole surface.
    fn is_at_end_of_target(&self, other: Option<&FineSide>) -> bool {
        other.map_or(self.target.body().is_some(), |other| is_at_end(&other.body.grid()))
    }

    /// The widths and penalty factor of an accepted impact, from which the search of the next one
    /// starts.
    pub fn history(
        &self,
        fine: &FineContact,
        assessment: &IntervalAssessment,
        penalty: f64,
    ) -> ImpactHistory {
        let mut width_factor = [1.0; 2];
        for ((factor, d), predicted) in
            width_factor.iter_mut().zip(&assessment.directions).zip(fine.predicted)
        {
            if predicted > 0.0 && d.width.is_finite() {
                *factor = d.width / predicted;
            }
        }
        let stiffness_ratio = fine.weight.filter(|_| penalty.is_finite()).map(|w| penalty * w);
        let zones = [0, 1].map(|i| fine.zones.get(i).map(|zone| zone.site));
        let finer = if fine.finer() > 1.0 { fine.wanted_finer(self.interval_settings().target) } else { 1.0 };
        ImpactHistory {
            width_factor: Some(width_factor),
            finer,
            stiffness_ratio,
            penalty: Some(penalty),
            zones,
        }
    }

    /// How the penalty factor is searched for.
    pub fn search_kind(&self) -> spec::PenaltySearch {
        self.law.search
    }

    /// The search for the penalty factor of an impact.
    fn penalty_search(
        &self,
        history: &ImpactHistory,
        weight: Option<f64>,
    ) -> Result<PenaltySearch, ContactError> {
        let strategy = match self.law.search {
            spec::PenaltySearch::Fixed => PenaltyStrategy::Fixed,
            spec::PenaltySearch::UntilConverged { tolerance } => {
                PenaltyStrategy::UntilConverged { factor: PENALTY_RISE, tolerance }
            }
            spec::PenaltySearch::UntilError => PenaltyStrategy::ErrorDriven { trial_steps: TRIAL_STEPS },
        };
        let from_ratio = |r: f64| weight.map(|w| penalty::from_weight(r, w)).transpose();
        if let Some(given) = self.law.penalty
            && (strategy == PenaltyStrategy::Fixed || given.is_infinite())
        {
            return Ok(PenaltySearch::new(PenaltyStrategy::Fixed, given));
        }
        let earlier = history.stiffness_ratio.map(from_ratio).transpose()?.flatten();
        if let Some(known) = earlier.or(history.penalty) {
            return Ok(PenaltySearch::from_accepted(strategy, known));
        }
        // A predicted factor is as large as the search would make it: stiffer springs cost no steps, another trial does.
        let start = self.law.penalty.map_or_else(|| strategy.start(), |_| 1.0);
        Ok(PenaltySearch::new(strategy, start * self.law.first_penalty(weight)?))
    }

    /// Settings of Algorithm 2.
    pub fn interval_settings(&self) -> IntervalSettings {
        let given = &self.law.interval;
        IntervalSettings {
            target: given.target_utilisation,
            minimum: given.min_utilisation,
            ..IntervalSettings::default()
        }
    }

    /// Whether the scenario gives the width of the interval.
    pub fn has_width(&self) -> bool {
        self.law.interval.width.is_some()
    }

    /// Whether the contact has friction.
    pub fn has_friction(&self) -> bool {
        self.law.friction.is_some()
    }

    /// Whether the width of the interval is the scenario's, not to be changed.
    pub fn is_width_given(&self) -> bool {
        self.has_width() && !self.law.treatment.is_searched()
    }
}

impl FineContact {
    /// Marks the contact elements of the last evaluation of `element`.
    pub fn mark(&mut self, element: &dyn ActiveContact) {
        let (mut first, mut last) = ([usize::MAX; 2], [0; 2]);
        for (force, index) in element.point_forces().into_iter().flatten().zip(&self.elements) {
            if *force > 0.0 {
                self.flags.mark(*index);
                for d in 0..2 {
                    (first[d], last[d]) = (first[d].min(index[d]), last[d].max(index[d]));
                }
            }
        }
        for d in 0..2 {
            self.at_once[d] = self.at_once[d].max((last[d] + 1).saturating_sub(first[d]));
        }
    }

    /// Forgets all contact.
    pub fn clear(&mut self) {
        self.flags.clear();
        self.at_once = [0; 2];
    }

    /// What touches; smooth faces of any other zone than those of flat faces and edges.
    pub fn touch(&self) -> TouchKind {
        let is_narrow = || self.zones.first().is_some_and(|zone| zone.site.flat_face().is_some());
        self.whole.unwrap_or_else(|| if is_narrow() { TouchKind::Narrow } else { TouchKind::Smooth })
    }

    /// Whether any element was in contact.
    pub fn has_touched(&self) -> bool {
        self.flags.is_any()
    }

    /// Algorithm 2 for the impact so far. An interval is not made narrower than the smallest contact that round-off of places lets the
    /// bodies see.
    pub fn assess(&self, settings: &IntervalSettings) -> IntervalAssessment {
        let n = self.interval.ends.len();
        let flags: Vec<Vec<bool>> = (0..n).map(|d| self.flags.along(d)).collect();
        let directions: Vec<DirectionUse<'_>> = (0..n)
            .map(|d| DirectionUse {
                contact: &flags[d],
                width: self.interval.widths[d],
                ends: self.interval.ends[d],
            })
            .collect();
        let mut assessment = assess(&directions, settings);
        for (d, least) in assessment.directions.iter_mut().zip(self.least) {
            let is_least = d.width < least;
            d.width = d.width.max(least);
            if d.verdict == Verdict::UnderUtilised && is_least && self.has_least_width() {
                d.verdict = Verdict::BelowTarget;
            }
        }
        assessment
    }

    /// Whether no direction of the interval can be made narrower.
    fn has_least_width(&self) -> bool {
        let n = self.interval.ends.len();
        (0..n).all(|d| self.interval.widths[d] <= (1.0 + LEAST_SLACK) * self.least[d])
    }

    /// Whether the target's interval ends where its surface does, so that it cannot grow.
    pub fn is_target_at_end(&self) -> bool {
        self.is_target_at_end
    }

    /// How many times as many elements the interval has as others of its contact.
    pub fn finer(&self) -> f64 {
        self.zones.first().map_or(1.0, |zone| zone.site.size.finer())
    }

    /// Rows of elements that were in contact at one instant at most, as a share of those that
    /// intervals of the contact have, but for more than suffice: the least of the directions.
    pub fn resolution(&self) -> f64 {
        let share = |d: usize| share_at_once(self.at_once[d], self.interval.n_elements[d], self.finer());
        (0..self.interval.ends.len()).map(share).fold(f64::INFINITY, f64::min)
    }

    /// Whether too few elements touched at one instant.
    pub fn is_coarse(&self, settings: &IntervalSettings) -> bool {
        self.resolution() < fewest_at_once(settings.minimum)
    }

    /// Whether contact moved along its interval, or along that of the target, as far as more elements
    /// could follow.
    pub fn has_moved(&self) -> bool {
        let moved = |d: usize| {
            let rows = self.flags.along(d).iter().filter(|touched| **touched).count();
            2 * rows >= 3 * self.at_once[d]
        };
        self.finer() > 1.0 || (0..self.interval.ends.len()).any(moved)
    }

    /// How many times as many elements as others of its contact the interval should have had.
    pub fn wanted_finer(&self, target: f64) -> f64 {
        finer_by(self.finer(), self.resolution(), target, self.interval.ends.len())
    }

    /// How far from the plane of the touch a part of whole surfaces is to reach that is larger than the
    /// zones by so much that the next trial is worth its price; none of zones that leave nothing out \[m\].
    pub fn wider(&self) -> Option<f64> {
        self.outside.as_ref()?;
        let depths = self.zones.iter().filter_map(|zone| zone.site.part).map(|part| part.depth);
        Some(REACH_GROWTH * depths.fold(0.0, f64::max))
    }

    /// Elements across the interval, per direction.
    pub fn n_elements(&self) -> [usize; 2] {
        self.interval.n_elements
    }

    /// Widths of the interval \[m\]; the second is zero for curves.
    pub fn widths(&self) -> [f64; 2] {
        self.interval.widths
    }
}

/// The model of the contact body or of a flexible target.
fn flexible(model: &BodyModel) -> &FlexibleModel {
    model.flexible().expect("the contact body and flexible_target are flexible, see AdaptiveContact::new")
}

/// The place `site` on a body, for an interval of the widths given.
fn zone_site(site: &SurfaceSite, size: ZoneSize) -> ZoneSite {
    ZoneSite::about((site.face, site.xi), size)
}

fn is_at_end(interval: &IntervalGrid) -> bool {
    interval.ends.iter().flatten().any(|&end| end == IntervalEnd::FaceEnd)
}

/// The fine models among `sides`, by body, that bring modes of their own.
fn fine_bases(sides: impl Iterator<Item = (usize, FineSide)>) -> Vec<(usize, FineBasis)> {
    sides.filter_map(|(index, side)| Some((index, side.fine_basis?))).collect()
}

/// Sizes of the fine models of a contact's bodies, together.
fn sizes(sides: [Option<&FineSide>; 2]) -> TrialSizes {
    sides.into_iter().flatten().fold(TrialSizes::default(), |sum, side| TrialSizes {
        elements: sum.elements + side.body.field().space().n_elements() as u64,
        dofs: sum.dofs + side.body.field().n_unknowns() as u64,
        interface: sum.interface + side.zone.unknowns.len() as u64,
    })
}
