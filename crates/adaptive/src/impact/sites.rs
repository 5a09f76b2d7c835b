//! Where the zones of a refined contact lie at a touch: about the nearest places of smooth
//! surfaces, of all at which they touch at once, where the last impact had them, or on the whole surfaces of bodies that touch with
//! flat faces, edges or corners (docs/theory.md section C.9).

use contact_qs::ActiveContact;
use contact_qs::search::SurfaceSite;
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::jet::{difference, norm};
use nalgebra::Vector3;

use super::widths::PredictedWidths;
use super::{
    Activation, AdaptiveContact, FineContact, MISSED_SURFACE, RefinementRequest, TOUCHED_SURFACE, WIDEST,
    ZoneOnBody, flexible, kept_zone, zone_site,
};
use crate::adaptivity::interval::finer_elements;
use crate::adaptivity::penalty_search::{PenaltySearch, PenaltyStrategy};
use crate::body::fine::refined::ELEMENTS;
use crate::error::{AdaptiveError, ContactModelFault};
use crate::record::{TargetPlace, TouchedPart, ZoneSite, ZoneSize};
use crate::spec;
use crate::state::ImpactHistory;
use crate::surface::Surface;
use crate::system::body::{BodyModel, FlexibleModel};
use crate::system::whole_surface::resolved_penalty;
use crate::touch::detection::{Nearest, Search};
use crate::touch::parts::side::{Moved, Side, met_place};
use crate::touch::parts::{Touch, TouchKind, TouchLine, TouchZone, pressed_parts};
use crate::touch::tolerances::PARALLEL_IN_RUN;

/// Where the zones of a contact lie.
pub(super) struct Sites {
    /// On the contact body.
    pub own: ZoneSite,
    /// On the target; none of a plane and of a rigid body.
    pub target: Option<ZoneSite>,
    /// Widths predicted for the impact \[m\].
    pub predicted: [f64; 2],
    /// Least widths: in narrower intervals round-off decides which points touch \[m\].
    pub least: [f64; 2],
    /// The kind of touch, if the zones are the whole surfaces of the bodies.
    pub whole: Option<TouchKind>,
}

/// Unknowns of the zone of a mesh at most: elements are divided alike in all directions, so that of a long zone their number
/// grows with its length over its width. The compliance of more takes longer than the impact of a part of a few thousand nodes
/// on the sides as they are. Zones that an impact has begun with may grow by the half of that.
const MOST_UNKNOWNS: [f64; 2] = [8000.0, 12_000.0];
/// Elements of the contact body across a flat face of the target below which the zone is refined about this face:
/// fewer have some points under it, or none.
const NARROW: f64 = 1.5;
/// Lowest bits of a width that are set to zero, a millionth of it: far above round-off and far
/// below the accuracy of widths.
const LOOSE_BITS: u32 = 32;

/// The width next to `width` with twenty bits \[m\]: equal bodies then have zones of the same
/// width, in spite of the round-off of the places where they touch.
fn without_round_off(width: f64) -> f64 {
    if !width.is_finite() {
        return width;
    }
    let half = 1 << (LOOSE_BITS - 1);
    f64::from_bits((width.to_bits() + half) >> LOOSE_BITS << LOOSE_BITS)
}

/// Undeformed surfaces of a contact body and of its target, none of a plane, with the motions that carry the places at which the deformed
/// bodies touch to where they are: how far bodies have yielded elsewhere is no matter of what touches.
struct TouchingSurfaces<'a> {
    own: (&'a dyn Surface, BodyState),
    other: Option<(&'a dyn Surface, BodyState)>,
}

impl TouchingSurfaces<'_> {
    fn moved(&self) -> (Moved<'_>, Option<Moved<'_>>) {
        ((self.own.0, &self.own.1), self.other.as_ref().map(|(surface, pose)| (*surface, pose)))
    }
}

/// The direction `across` a line in the frame of a mesh in the motion `state`, which zones on surfaces without directions take; zero
/// of other bodies.
fn across_of(body: &BodyModel, state: &BodyState, across: Option<&Vector3<f64>>) -> [f64; 3] {
    let is_mesh = body.flexible().is_some_and(|flexible| flexible.body.mesh().is_some());
    across.filter(|_| is_mesh).map_or([0.0; 3], |way| state.rotation.inverse_transform_vector(way).into())
}

/// The widths next to `widths` that an interval of `body` can have: none reaches beyond it, as that along a line of a longer
/// partner would \[m\].
fn held_widths(body: &FlexibleModel, widths: [f64; 2]) -> [f64; 2] {
    let widest = WIDEST * body.body.size();
    widths.map(|width| without_round_off(width).min(widest))
}

/// Half of the width over which an edge presses a face, as a share of the body's least extent: that of one rounded by some hundredth of it.
const EDGE_SPREAD: f64 = 1.0 / 300.0;
/// Half of the width of an even load over half of that of Hertz' pressure: it indents a half-plane as deep if it is sqrt(e) / 2 times as wide,
/// and takes the same work up to that force, while Hertz' width grows, if it is e^(1/4) times as wide as that.
const AS_EVEN: f64 = 1.058;

impl AdaptiveContact {
    /// How the bodies touch in the motions `states`. Zones that vibrate lie about the nearest
    /// points, even if these belong to a line.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if the motions are not finite.
    pub fn touch(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        search: &mut Search,
    ) -> Result<Touch, AdaptiveError> {
        let nearest = self.nearest(states, search)?;
        let Some(surfaces) = self.touching_surfaces(bodies, states, &nearest) else {
            let (kind, normal) = (TouchKind::Smooth, nearest.normal);
            return Ok(Touch { nearest, kind, normal, extents: [0.0; 2], line: None });
        };
        let (own, other) = surfaces.moved();
        if self.is_vibrating() {
            return Ok(Touch::at_places(own, other, &nearest, PARALLEL_IN_RUN));
        }
        let touch = Touch::at(own, other, &nearest, PARALLEL_IN_RUN);
        if !self.may_be_whole() {
            return Ok(touch);
        }
        Ok(touch.narrower_than(own, other, PARALLEL_IN_RUN, |place| {
            let element = flexible(&bodies[self.body]).body.element_at(place)?;
            Some(element.map(|length| NARROW * length))
        }))
    }

    /// The undeformed surfaces of the contact body and of the target, if that is a body, as they touch at the places `nearest` of
    /// the deformed ones in the motions `states`; none if one has no surface.
    fn touching_surfaces<'a>(
        &self,
        bodies: &'a [BodyModel],
        states: &[BodyState],
        nearest: &Nearest,
    ) -> Option<TouchingSurfaces<'a>> {
        let at = |body: usize, site: &SurfaceSite| {
            let (surface, mut pose) = (bodies[body].undeformed()?, states[body].clone());
            let place = surface.motion().in_space(&surface.place(site.face, &site.xi).point);
            pose.position = site.point - pose.rotation * place;
            Some((surface, pose))
        };
        let on_target = |other| nearest.target.as_ref().and_then(|site| at(other, site)).ok_or(());
        let other = self.target.try_map(on_target).ok()?;
        Some(TouchingSurfaces { own: at(self.body, &nearest.contact)?, other: other.body() })
    }

    /// Whether a line of the contact body lies across the target, which ends before it, at the places `nearest`: a touch along a line
    /// as soon as the two are exchanged.
    pub fn lies_across(&self, bodies: &[BodyModel], states: &[BodyState], nearest: &Nearest) -> bool {
        let surfaces = self.touching_surfaces(bodies, states, nearest);
        let moved = surfaces.as_ref().map(TouchingSurfaces::moved);
        let Some(((own, Some(other)), contact)) = moved.zip(nearest.target) else {
            return false;
        };
        let (target, normal) = (Some(nearest.contact), -nearest.normal);
        let exchanged = Nearest { contact, target, normal, ..*nearest };
        Touch::at(other, Some(own), &exchanged, PARALLEL_IN_RUN).kind == TouchKind::Line
    }

    /// Where the zones lie: the whole surfaces if an edge or flat faces touch, else about the
    /// nearest places.
    ///
    /// # Errors
    /// As [`AdaptiveContact::whole_at`].
    pub(super) fn sites(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        touch: &Touch,
        request: &RefinementRequest<'_>,
    ) -> Result<Sites, AdaptiveError> {
        let (whole, nearest) = (self.whole_at(touch, request.size)?, &touch.nearest);
        let target = self.flexible_target.zip(nearest.target.as_ref());
        if whole.is_some() {
            let [own_part, part] = self.parts(bodies, states, touch, request);
            let site = self.whole_site(bodies, states, touch, whole);
            let own = ZoneSite { part: own_part, ..site };
            let target = target.map(|_| ZoneSite { part, ..ZoneSite::WHOLE });
            return Ok(Sites { own, target, predicted: [0.0; 2], least: [0.0; 2], whole });
        }
        let is_narrow = touch.kind == TouchKind::Narrow;
        let PredictedWidths { widths: predicted, least, across } = match is_narrow {
            true => self.widths_about(bodies, touch),
            false => self.predicted_widths(bodies, states, nearest, request.peak),
        };
        // What smooth faces have told is not asked of flat ones.
        let history = if is_narrow { ImpactHistory::default() } else { request.history };
        let widths = self.widths(bodies, request.size, (predicted, &history));
        let finer = request.size.map_or(history.finer, ZoneSize::finer).max(1.0);
        let [ahead, ahead_on_target] = &request.ahead;
        let mut own =
            Self::ahead(&bodies[self.body], &nearest.contact, ahead, ZoneSize::Interval { widths, finer });
        own.across = across_of(&bodies[self.body], &states[self.body], across.as_ref());
        let mut target = target.map(|(other, there)| {
            let on_target = (other, there);
            let widths =
                self.target_widths(bodies, states, (&nearest.contact, across.as_ref()), widths, on_target);
            let size = ZoneSize::Interval { widths: held_widths(flexible(&bodies[other]), widths), finer };
            ZoneSite {
                across: across_of(&bodies[other], &states[other], across.as_ref()),
                ..Self::ahead(&bodies[other], there, ahead_on_target, size)
            }
        });
        for (k, further) in request.others.iter().enumerate() {
            let place = |site: &SurfaceSite| (site.face, site.xi);
            own.others[k] = Some(place(&further.contact));
            if let Some(target) = &mut target {
                target.others[k] = further.target.as_ref().map(place);
            }
        }
        if is_narrow {
            let [_, part] = self.parts(bodies, states, touch, request);
            target = target.map(|_| ZoneSite { part, ..ZoneSite::WHOLE });
            own.part = self.touching_surfaces(bodies, states, nearest).map(|surfaces| {
                let side = Side::new(surfaces.moved().0).facing(&-touch.normal);
                side.part(side.place(&nearest.contact).point, self.first_reach())
            });
        }
        if request.size.is_none()
            && let Some(kept) = self.kept_zones(bodies, &history, [Some(own), target])
        {
            (own, target) = kept;
        }
        Ok(Sites { own, target, predicted, least, whole })
    }

    /// How far contact, now at the places `nearest`, has come from the middles of the zones of `fine`, the nearest ones, on contact
    /// body and target \[m\].
    pub fn ways(&self, bodies: &[BodyModel], fine: &FineContact, nearest: &Nearest) -> [[f64; 3]; 2] {
        let places = [Some(&nearest.contact), nearest.target.as_ref()];
        let way = |(zone, place): (&ZoneOnBody, Option<&SurfaceSite>)| {
            let (surface, site) = (bodies[zone.body].undeformed()?, place?);
            let to = surface.place(site.face, &site.xi).point;
            let ways = zone.site.places().map(|(face, xi)| difference(&to, &surface.place(face, &xi).point));
            ways.min_by(|a, b| norm(a).total_cmp(&norm(b)))
        };
        let mut ways = fine.zones.iter().zip(places).map(|pair| way(pair).unwrap_or([0.0; 3]));
        [ways.next().unwrap_or_default(), ways.next().unwrap_or_default()]
    }

    /// Whether the bodies touch at the places `nearest` beside the zones of `fine`.
    pub fn is_beside(&self, bodies: &[BodyModel], fine: &FineContact, nearest: &Nearest) -> bool {
        let ways = self.ways(bodies, fine, nearest);
        fine.zones.iter().zip(&ways).any(|(zone, way)| norm(way) > zone.reach())
    }

    /// The place that is `ahead` \[m\] of `site` along the surface of `body`.
    fn ahead(body: &BodyModel, site: &SurfaceSite, ahead: &[f64; 3], size: ZoneSize) -> ZoneSite {
        let usual = zone_site(site, size);
        let Some(surface) = body.undeformed().filter(|_| ahead.iter().any(|c| c.abs() > 0.0)) else {
            return usual;
        };
        let from = surface.place(site.face, &site.xi).point;
        let foot = surface.nearest(&[0, 1, 2].map(|c| from[c] + ahead[c]));
        foot.map_or(usual, |foot| ZoneSite::about((foot.place.face, foot.place.xi), size))
    }

    /// The zone on the contact body for a touch of the kind `whole`: its whole surface. An edge
    /// that may touch between the points of its elements has further points about the nearest place
    /// (Eq. C.65), a touch with an edge or a corner of the target has one point there (Eq. C.63), and
    /// an edge of either along a face points along it (Eq. C.97). Flat faces, and corners on a plane, touch at the points of the elements.
    pub fn whole_site(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        touch: &Touch,
        whole: Option<TouchKind>,
    ) -> ZoneSite {
        let nearest = &touch.nearest;
        if !whole.is_some_and(TouchKind::adds_points) {
            return ZoneSite::WHOLE;
        }
        let body = &bodies[self.body];
        let surfaces = self.touching_surfaces(bodies, states, nearest);
        let on_edge = || surfaces.as_ref().and_then(|surfaces| self.pressed_edge(bodies, surfaces, touch));
        if let Some(TouchLine { place, meets }) = touch.line.or_else(on_edge) {
            return ZoneSite { meets: Some(meets), ..zone_site(&place, ZoneSize::Whole) };
        }
        let is_bent = || body.height_between_points() > MISSED_SURFACE * self.detector.size();
        if self.target.body().is_none() && !is_bent() {
            return ZoneSite::WHOLE;
        }
        zone_site(&nearest.contact, ZoneSize::Whole)
    }

    /// The parts of the surfaces of contact body and target that may press at `touch`: what lies
    /// within the reach of `request` of the plane of the touch, no farther aside than both do
    /// (Eq. C.91). None of a surface that is a zone as a whole.
    pub fn parts(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        touch: &Touch,
        request: &RefinementRequest<'_>,
    ) -> [Option<TouchedPart>; 2] {
        let none = [None; 2];
        if request.size == Some(ZoneSize::Whole) {
            return none;
        }
        let depth = request.reach.unwrap_or_else(|| self.first_reach());
        let Some(surfaces) = self.touching_surfaces(bodies, states, &touch.nearest) else { return none };
        let (own, target) = surfaces.moved();
        let place = |(surface, _): Moved<'_>, site: &SurfaceSite| surface.place(site.face, &site.xi).point;
        let on_target = target.zip(touch.nearest.target.as_ref()).map(|(target, site)| place(target, site));
        let at = [Some(place(own, &touch.nearest.contact)), on_target];
        pressed_parts([Some(own), target], at, &touch.normal, depth)
    }

    /// How far from the plane of a touch surfaces may press in its first trial \[m\].
    fn first_reach(&self) -> f64 {
        TOUCHED_SURFACE * self.detector.least_size()
    }

    /// The edge or corner of the target that the contact body meets at `touch`, else the edge of the contact body, in the plane its corner, that
    /// presses the target; none of other touches.
    fn pressed_edge(
        &self,
        bodies: &[BodyModel],
        surfaces: &TouchingSurfaces<'_>,
        touch: &Touch,
    ) -> Option<TouchLine> {
        let (own, target) = surfaces.moved();
        let blunted = |line: TouchLine, body: usize| {
            let spread = EDGE_SPREAD * flexible(&bodies[body]).body.thickness();
            TouchLine { meets: TargetPlace { spread, ..line.meets }, ..line }
        };
        let nearest = &touch.nearest;
        let meets = target
            .and_then(|target| met_place(&Side::new(own), &Side::new(target), nearest, PARALLEL_IN_RUN));
        if let Some(meets) = meets {
            return Some(blunted(TouchLine { place: nearest.contact, meets }, self.body));
        }
        let line = touch.own_edge(own, target, PARALLEL_IN_RUN)?;
        Some(blunted(line, self.flexible_target.unwrap_or(self.body)))
    }

    /// The middle of the line along which smooth faces of the bodies touch, for a peak force if one is known, and the place of the target that it
    /// meets there; none of other touches.
    fn met_line(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        touch: &Touch,
        peak: Option<f64>,
    ) -> Option<TouchLine> {
        let (way, half) = self.line_of_touch(bodies, states, &touch.nearest, peak)?;
        let surfaces = self.touching_surfaces(bodies, states, &touch.nearest)?;
        let (own, target) = surfaces.moved();
        let line = touch.line(own, target, (&way, PARALLEL_IN_RUN))?;
        Some(TouchLine { meets: TargetPlace { spread: AS_EVEN * half, ..line.meets }, ..line })
    }

    /// `touch` on the sides of a mesh as they are: by points along a line, if it is one, else by those of the sides.
    #[must_use]
    pub fn on_own_sides(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        touch: Touch,
        peak: Option<f64>,
    ) -> Touch {
        let is_smooth = matches!(touch.kind, TouchKind::Smooth | TouchKind::Line);
        let line = if is_smooth { self.met_line(bodies, states, &touch, peak) } else { None };
        let kind = line.map_or(TouchKind::Edge, |_| TouchKind::LineOfPoints);
        Touch { kind, line, ..touch }
    }

    /// The kind of `touch`, if an edge or flat faces touch and `widths` do not ask for an interval:
    /// then the zones are the whole surfaces, which [`ZoneSize::Whole`] stands for. None if smooth
    /// surfaces touch.
    ///
    /// # Errors
    /// [`AdaptiveError::ContactModel`] if no contact point sees the touch, or zones that vibrate would be whole surfaces.
    pub fn whole_at(
        &self,
        touch: &Touch,
        size: Option<ZoneSize>,
    ) -> Result<Option<TouchKind>, AdaptiveError> {
        match size.or(self.law.interval.width.map(|w| ZoneSize::usual([w; 2]))) {
            Some(ZoneSize::Whole) => return Ok(Some(TouchKind::Edge)),
            Some(ZoneSize::Interval { .. }) => return Ok(None),
            None => {}
        }
        let kind = touch.kind;
        match kind.zone() {
            TouchZone::Interval => Ok(None),
            TouchZone::Unseen => {
                let is_rigid = self.flexible_target.is_none();
                Err(self.without_model(ContactModelFault::BetweenPoints { is_rigid }))
            }
            TouchZone::Whole if self.is_vibrating() => {
                Err(self.without_model(ContactModelFault::NotSmooth { what: kind.parts() }))
            }
            TouchZone::Whole if self.law.is_exact() => {
                Err(self.without_model(ContactModelFault::ExactWhole { what: kind.parts() }))
            }
            TouchZone::Whole => Ok(Some(kind)),
        }
    }

    /// Whether the contact may have zones that are the whole surfaces: it is quasistatic, and
    /// nobody has given a width.
    pub fn may_be_whole(&self) -> bool {
        !self.is_vibrating() && self.law.interval.width.is_none()
    }

    /// Whether a touch of the kind `kind`, for whose zone `error` tells that elements cannot be divided so, may have the sides about it as
    /// they are: of a mesh whose zones nobody has given.
    pub fn may_keep_sides(&self, kind: TouchKind, bodies: &[BodyModel], error: &AdaptiveError) -> bool {
        let undivided = error.undivided_body();
        self.open_meshes(kind, bodies).into_iter().flatten().any(|mesh| Some(mesh.name()) == undivided)
    }

    /// The contact body and the target, if they are meshes whose zones at a touch of the kind `kind` nobody has given.
    fn open_meshes<'a>(&self, kind: TouchKind, bodies: &'a [BodyModel]) -> [Option<&'a FlexibleModel>; 2] {
        // About a narrow face the contact body is one of splines, and the target has all its surface.
        let is_open = self.law.leaves_zone_open() && matches!(kind, TouchKind::Smooth | TouchKind::Line);
        [Some(self.body), self.flexible_target].map(|body| {
            let model = bodies[body.filter(|_| is_open)?].flexible();
            model.filter(|model| model.body.mesh().is_some())
        })
    }

    /// Whether `touch` has the sides of a mesh about it as they are, for nobody has given its zone: where the curvatures of
    /// the sides tell no width, where the surface along a line has no known shape, or where the zone that `request` leads to
    /// would have too many unknowns.
    ///
    /// # Errors
    /// As [`AdaptiveContact::whole_at`].
    pub fn keeps_sides(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        touch: &Touch,
        request: &RefinementRequest<'_>,
    ) -> Result<bool, AdaptiveError> {
        let meshes = self.open_meshes(touch.kind, bodies);
        if meshes.iter().all(Option::is_none) {
            return Ok(false);
        }
        let Sites { own, target, least, .. } = self.sites(bodies, states, touch, request)?;
        let most = MOST_UNKNOWNS[usize::from(request.size.is_some())];
        let is_blind = least.iter().all(|width| *width <= 0.0);
        let is_long = |(mesh, site): (Option<&FlexibleModel>, Option<ZoneSite>)| {
            let mesh = mesh.and_then(|mesh| mesh.body.mesh()).zip(site);
            mesh.is_some_and(|(mesh, site)| mesh.interface_at(&site, &self.law.interval) > most)
        };
        Ok(is_blind || meshes.into_iter().zip([Some(own), target]).any(is_long))
    }

    /// The penalty factor of a contact of whole surfaces: the one given, or as stiff as the modes can follow (theory
    /// section C.9), and raised where penetration is too large a share of the approach (theory
    /// section A.9), unless it is to stay as it is given.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if no point that is going to touch yields.
    pub(super) fn penalty_of_whole(
        &self,
        kind: TouchKind,
        bodies: &[BodyModel],
        weight: Option<f64>,
    ) -> Result<PenaltySearch, AdaptiveError> {
        let is_fixed = self.law.is_exact() || self.law.search == spec::PenaltySearch::Fixed;
        let strategy = if is_fixed { PenaltyStrategy::Fixed } else { PenaltyStrategy::UntilStiff };
        let first = self.law.first_penalty(weight).map_err(|e| self.fail(e))?;
        let first = match self.law.penalty {
            Some(given) => given,
            None => (strategy.start() * first).min(self.penalty_of_modes(kind, bodies)),
        };
        Ok(PenaltySearch::new(strategy, first))
    }

    /// The stiffest springs that the modes of the bodies follow where flat faces touch (theory
    /// Eq. C.69); infinite of other touches [N/m³].
    pub fn penalty_of_modes(&self, kind: TouchKind, bodies: &[BodyModel]) -> f64 {
        let sides =
            [Some(self.body), self.flexible_target].into_iter().flatten().map(|b| flexible(&bodies[b]));
        if kind.is_jump() { resolved_penalty(sides) } else { f64::INFINITY }
    }

    /// Resets `element` with the models `fine` of whole surfaces, which served an earlier impact or
    /// trial, as if they had just been built in the motions `states`; `search`: the penalty search
    /// of the running impact, if it goes on.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if the motions are not finite.
    pub fn begin_again(
        &self,
        (element, fine): (&mut dyn ActiveContact, &mut FineContact),
        search: Option<PenaltySearch>,
        activation: Activation,
        (bodies, states): (&[BodyModel], &[BodyState]),
    ) -> Result<(), AdaptiveError> {
        let Some(kind) = fine.whole else { return Ok(()) };
        element.forget();
        fine.clear();
        (fine.activation, fine.weight) = (activation, self.weight_of(element, states, true)?);
        fine.search = search.map_or_else(|| self.penalty_of_whole(kind, bodies, fine.weight), Ok)?;
        element.set_penalty(fine.search.penalty()).map_err(|e| self.fail(e))
    }

    /// Widths of an interval: those asked for, given or, with what earlier impacts found, predicted
    /// \[m\].
    fn widths(
        &self,
        bodies: &[BodyModel],
        size: Option<ZoneSize>,
        (predicted, history): ([f64; 2], &ImpactHistory),
    ) -> [f64; 2] {
        let factor = history.width_factor.unwrap_or([1.0; 2]);
        let start =
            self.law.interval.width.map_or([predicted[0] * factor[0], predicted[1] * factor[1]], |w| [w; 2]);
        self.granted(bodies, size.and_then(ZoneSize::widths).unwrap_or(start))
    }

    /// The widths that an interval gets if `widths` are asked for \[m\].
    pub fn granted(&self, bodies: &[BodyModel], widths: [f64; 2]) -> [f64; 2] {
        held_widths(flexible(&bodies[self.body]), widths)
    }

    /// The zones of the last impact on contact body and target, if they hold the zones `wanted`
    /// now.
    fn kept_zones(
        &self,
        bodies: &[BodyModel],
        history: &ImpactHistory,
        wanted: [Option<ZoneSite>; 2],
    ) -> Option<(ZoneSite, Option<ZoneSite>)> {
        let given = &self.law.interval;
        let elements = given.elements_or(ELEMENTS);
        let of_target = self.flexible_target.unwrap_or(self.body);
        let holds = |body: usize, kept: &ZoneSite, wanted: &ZoneSite| {
            let elements = finer_elements(elements, kept.size.finer());
            kept.size.finer() >= wanted.size.finer()
                && kept_zone::holds(flexible(&bodies[body]), kept, wanted, elements, given.target_utilisation)
        };
        let own = history.zones[0].filter(|kept| wanted[0].is_some_and(|w| holds(self.body, kept, &w)))?;
        match (history.zones[1], wanted[1]) {
            (Some(kept), Some(w)) => holds(of_target, &kept, &w).then_some((own, Some(kept))),
            (None, None) => Some((own, None)),
            _ => None,
        }
    }
}
