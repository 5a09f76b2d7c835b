//! Fine models of the two sides of a contact, and the force element that they make.

use std::borrow::Cow;

use contact_qs::zone::points::InterfaceCompliance;
use contact_qs::{ActiveContact, ZoneVibration};
use faer::{Mat, MatRef};
use ffr_dynamics::body::{AssembledBody, ModalDamping};
use ffr_dynamics::force::{BodyState, Motion};
use ffr_dynamics::reduction::{FreeFlexibility, ResidualFlexibility, ResidualModes};

use super::zone_model::ZoneModel;
use super::{AdaptiveContact, CancelCheck, FineBasis, TOUCHED_SURFACE, WIDEST};
use crate::body::fine::FineModel;
use crate::body::fine::refined::FineBody;
use crate::body::point_compliance::{ObservedPlace, PlaceFunctions, n_columns, point_rows};
use crate::body::reduced::damping::damping;
use crate::body::reduced::with_critical;
use crate::body::whole::fine_model;
use crate::body::whole::indentation::{LinePoint, PressedLine};
use crate::body::zone::contact::{ContactSide, ZoneContact};
use crate::body::zone::{ContactZone, PointsAbout};
use crate::error::AdaptiveError;
use crate::paper::fine_modes::FineModes;
use crate::record::{TargetPlace, ZoneSite};
use crate::spec::{InterfaceModes, LowModes};
use crate::store::{ModelKey, StoredModel, matrix, matrix_values};
use crate::system::body::{BodyModel, FlexibleModel};
use crate::system::rigid_surface::RigidSurface;

/// Fine model of one body for one contact.
pub struct FineSide {
    /// The refined body.
    pub body: Box<dyn FineModel>,
    /// Contact points and interface.
    pub zone: ContactZone,
    /// Low-frequency modes at the unknowns.
    shapes: Mat<f64>,
    /// How the interface answers forces beyond the low-frequency modes.
    answer: ZoneAnswer,
    /// Displacements, strains and stresses at observed points by forces at the interface, as of
    /// [`point_rows`]; no columns if the zone vibrates.
    pub points: Mat<f64>,
    /// The fine model with modes of its own, if these become the modes of the body during the
    /// impact.
    pub fine_basis: Option<FineBasis>,
}

/// A fine model of a body that is not reduced, and its contact zone.
pub(super) struct FineZone {
    /// The refined body.
    pub fine: Box<dyn FineModel>,
    /// Contact points and interface.
    pub zone: ContactZone,
}

/// A refined contact, built again.
pub struct RebuiltContact {
    /// The force element.
    pub element: Box<dyn ActiveContact>,
    /// The fine models, each with the index of its body.
    pub models: Vec<(usize, ZoneModel)>,
}

/// How a contact zone answers forces beyond the low-frequency modes.
enum ZoneAnswer {
    /// Quasistatically, by the compliance of the interface [m/N].
    Static(Mat<f64>),
    /// Dynamically, by modes of the zone that vibrate.
    Vibrating(ResidualModes),
}

impl AdaptiveContact {
    /// The fine model of `body` at `site`.
    pub(super) fn fine_body(
        &self,
        body: &FlexibleModel,
        site: &ZoneSite,
    ) -> Result<Box<dyn FineModel>, AdaptiveError> {
        let (face, count) = (site.face, body.body.undeformed().n_faces());
        if face as usize >= count {
            return Err(self.not_of_models(format!("there is no face {face} of {count}")));
        }
        let size = body.body.size();
        let width = site.size.widths().map_or(0.0, |[first, second]| first.max(second));
        if width > WIDEST * size {
            return Err(self.not_of_models(format!("an interval {width:e} m wide on a body of {size:e} m")));
        }
        fine_model(&body.body, site, &self.law.interval)
    }

    /// Whether fine models can be built again from their sites: their zones are quasistatic, on
    /// prolonged modes.
    pub fn is_rebuildable(&self) -> bool {
        !self.is_vibrating() && self.law.transfer.modes == LowModes::Prolonged
    }

    /// The fine model of `body` at `site`, built again.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of body or contact.
    pub fn zone_model(&self, body: &FlexibleModel, site: &ZoneSite) -> Result<ZoneModel, AdaptiveError> {
        let (side, residual) = self.side_again(body, site)?;
        Ok(side.into_model(residual))
    }

    /// The side of the contact on `body`, built again as a [`FineSide`], with the flexibility of
    /// its interface.
    fn side_again(
        &self,
        body: &FlexibleModel,
        site: &ZoneSite,
    ) -> Result<(FineSide, ResidualFlexibility), AdaptiveError> {
        let zone = self.fine_zone(body, site)?;
        let flexibility = flexibility(&zone)?;
        side_with(body, zone, flexibility)
    }

    /// Both sides of the contact again, side by side; equal ones share the flexibility of their
    /// interface.
    fn sides_again(
        &self,
        [own, other]: [&FlexibleModel; 2],
        [own_site, other_site]: [&ZoneSite; 2],
    ) -> Result<[(FineSide, ResidualFlexibility); 2], AdaptiveError> {
        let zones = rayon::join(|| self.fine_zone(own, own_site), || self.fine_zone(other, other_site));
        let (own_zone, other_zone) = (zones.0?, zones.1?);
        let key = |body: &FlexibleModel, FineZone { fine, zone }: &FineZone| {
            fine.compliance_key(&body.reduced, &zone.unknowns, &[], false)
        };
        let flexibilities = if key(own, &own_zone) == key(other, &other_zone) {
            let shared = flexibility(&own_zone)?;
            (shared.clone(), shared)
        } else {
            let both = rayon::join(|| flexibility(&own_zone), || flexibility(&other_zone));
            (both.0?, both.1?)
        };
        Ok([side_with(own, own_zone, flexibilities.0)?, side_with(other, other_zone, flexibilities.1)?])
    }

    /// The contact with fine models at `sites`, the site of the contact body first. A zone that
    /// lies on a smooth surface is moved by `offset` \[m\] along its normal, as `element_at` found
    /// it.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of body or contact; also if a site is missing.
    pub fn rebuilt(
        &self,
        bodies: &[BodyModel],
        (sites, offset): (&[Option<ZoneSite>; 2], f64),
    ) -> Result<RebuiltContact, AdaptiveError> {
        let site = |k: usize| {
            sites[k].ok_or_else(|| self.not_of_models("the place of a fine model is not known".into()))
        };
        let on_body = super::flexible(&bodies[self.body]);
        let (mut own, residual, mut other, other_residual) = match self.flexible_target {
            None => {
                let (own, residual) = self.side_again(on_body, &site(0)?)?;
                (own, residual, None, None)
            }
            Some(index) => {
                let on_target = super::flexible(&bodies[index]);
                let sides = self.sides_again([on_body, on_target], [&site(0)?, &site(1)?])?;
                let [(own, residual), (other, other_residual)] = sides;
                (own, residual, Some((index, other)), Some(other_residual))
            }
        };
        if let Some((_, FineSide { body, zone, .. })) = smooth_side(&mut own, &mut other) {
            body.move_out(zone, offset);
        }
        self.leave_out_of_target(&mut own, other.as_ref(), bodies);
        let element = self.element(&own, other.as_ref(), bodies)?;
        let mut models = vec![(self.body, own.into_model(residual))];
        models.extend(
            other.zip(other_residual).map(|((body, side), residual)| (body, side.into_model(residual))),
        );
        Ok(RebuiltContact { element, models })
    }

    /// Adds what the elements of a flexible target leave out of its indentation under the line that the zone of `own` meets, or of its edge
    /// there.
    pub(super) fn leave_out_of_target(
        &self,
        own: &mut FineSide,
        other: Option<&(usize, FineSide)>,
        bodies: &[BodyModel],
    ) {
        let left_out = other.and_then(|(target, side)| {
            let (meets, body) = (own.body.meets()?, &super::flexible(&bodies[*target]).body);
            let place = body.undeformed().place(meets.face, &meets.xi);
            let outward = body.motion().components(&meets.normal);
            let along = TargetPlace { along: [meets.along[1]; 2], outward, ..*meets };
            let about = PointsAbout { place, meets: Some(along) };
            let line = PressedLine::new(body.as_ref(), &about, &outward).filter(|_| side.body.is_own())?;
            let lengths = own.zone.lengths_of_meeting(&line.edge.half);
            // Ends of an edge are known up to the slack of what lies along it.
            let on = |share: f64| {
                let foot = body.undeformed().nearest(&line.edge.at(share))?;
                body.functions_at(&foot.place.point).ok()
            };
            let functions: Vec<_> = own.zone.meeting.iter().map(|m| on(m.1)).collect::<Option<_>>()?;
            let points: Vec<LinePoint<'_>> = functions.iter().map(Vec::as_slice).zip(lengths).collect();
            line.left_out(body.as_ref(), &points)
        });
        own.zone.leave_out(&left_out.unwrap_or_default());
    }

    /// The side of `body` with its fine model and zone, and how forces on it displace the `places`
    /// of the body.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of body or contact, or the error of `check_cancel`.
    pub(super) fn side(
        &self,
        body: &FlexibleModel,
        FineZone { fine, zone }: FineZone,
        places: &[ObservedPlace],
        modes: LowModes,
        check_cancel: &mut CancelCheck<'_>,
    ) -> Result<FineSide, AdaptiveError> {
        check_cancel()?;
        // Zones that vibrate have no static answer.
        let places = if self.is_vibrating() { &[] } else { places };
        let field = fine.field();
        let shown = places.iter().map(|place| PlaceFunctions::new(place, field));
        let shown: Vec<PlaceFunctions> = shown.collect::<Result<_, AdaptiveError>>()?;
        if modes == LowModes::Fine && !fine.is_own() {
            return self.side_with_modes(body, FineZone { fine, zone }, &shown, check_cancel);
        }
        let points = |residual: &ResidualFlexibility| point_rows(&shown, field, residual);
        let n_rows = n_columns(places, field.motion().n_components());
        let unknowns = &zone.unknowns;
        let has_modes = self.is_vibrating() || !places.is_empty();
        let key = fine.compliance_key(&body.reduced, unknowns, places, has_modes);
        let key = ModelKey { kind: if self.is_vibrating() { "zone-modes" } else { key.kind }, ..key };
        let low = fine.low_modes(&body.reduced);
        let (answer, points) = self.cache.recent(
            key,
            |stored| self.answer_from(stored, unknowns.len(), n_rows),
            || {
                self.cache.count_fine_model();
                let assembled = fine.assemble()?;
                check_cancel()?;
                let flexibility = fine.flexibility(&assembled, unknowns)?;
                check_cancel()?;
                let free = ZoneAnswer::Static(flexibility.compliance().clone());
                if !has_modes {
                    return Ok::<_, AdaptiveError>((free, Mat::zeros(unknowns.len(), 0)));
                }
                let residual = fine.residual(flexibility, low.clone())?;
                let answer =
                    if self.is_vibrating() { self.answer(body.name(), &residual, &assembled)? } else { free };
                Ok((answer, points(&residual)))
            },
            stored_answer,
        )?;
        let answer = match answer {
            ZoneAnswer::Static(free) => ZoneAnswer::Static(low.take_out(free, unknowns, fine.turn())),
            vibrating @ ZoneAnswer::Vibrating(_) => vibrating,
        };
        let shapes = fine.shapes(&body.reduced);
        Ok(FineSide { body: fine, zone, shapes, answer, points, fine_basis: None })
    }

    /// The side of a contact whose fine model has low-frequency modes of its own, which meshes do
    /// not have. `shown`: the observed places as functions of the unknowns.
    fn side_with_modes(
        &self,
        body: &FlexibleModel,
        FineZone { fine, zone }: FineZone,
        shown: &[PlaceFunctions],
        check_cancel: &mut CancelCheck<'_>,
    ) -> Result<FineSide, AdaptiveError> {
        let (Some(mesh), Some(splines)) = (fine.splines().cloned(), body.body.splines()) else {
            return Err(AdaptiveError::unsupported_body(
                body.name(),
                "a body of model \"mesh\" has no fine models with modes = \"own\"; \
             choose modes = \"prolonged\" for its contacts"
                    .into(),
            ));
        };
        let coarse = (splines, &body.reduced);
        self.cache.count_fine_model();
        let assembled = mesh.assemble(splines)?;
        let refined = FineBody { mesh, assembled };
        let (basis, residual) = refined.reduce(coarse, &zone.unknowns, LowModes::Fine)?;
        check_cancel()?;
        let answer = self.answer(body.name(), &residual, &refined.assembled)?;
        let points = point_rows(shown, fine.field(), &residual);
        let modes = FineModes::new(coarse, &refined, basis, self.law.transfer.method)?;
        let shapes = modes.reduced.shapes().to_owned();
        Ok(FineSide {
            body: fine,
            zone,
            shapes,
            answer,
            points,
            fine_basis: Some(FineBasis { body: refined, modes }),
        })
    }

    /// How the zone of the body called `name` answers.
    fn answer(
        &self,
        name: &str,
        residual: &ResidualFlexibility,
        assembled: &AssembledBody,
    ) -> Result<ZoneAnswer, AdaptiveError> {
        if !self.is_vibrating() {
            return Ok(ZoneAnswer::Static(residual.compliance().clone()));
        }
        let modes = ResidualModes::new(residual, assembled).map(ZoneAnswer::Vibrating);
        modes.map_err(|source| AdaptiveError::Reduction { body: name.to_owned(), source })
    }

    /// Whether the zones' high-frequency modes are dynamic.
    pub(super) fn is_vibrating(&self) -> bool {
        self.law.treatment.is_vibrating()
    }

    /// The answer of a zone with `n` unknowns and the `n_points` columns of observed points from
    /// the model store; none if sizes do not fit.
    fn answer_from(&self, stored: &StoredModel, n: usize, n_points: usize) -> Option<(ZoneAnswer, Mat<f64>)> {
        if !self.is_vibrating() {
            let (compliance, points) = stored.values.split_at_checked(n * n)?;
            return matrix(compliance, n, n).map(ZoneAnswer::Static).zip(matrix(points, n, n_points));
        }
        let (omega, shapes) = stored.values.split_at_checked(n)?;
        let interface_shapes = matrix(shapes, n, n)?;
        Some((ZoneAnswer::Vibrating(ResidualModes { omega: omega.to_vec(), interface_shapes }), Mat::new()))
    }

    /// The vibration of the contact zone on body `index`; none if it answers quasistatically.
    fn vibration(
        &self,
        side: &FineSide,
        index: usize,
        body: &BodyModel,
    ) -> Result<Option<ZoneVibration>, AdaptiveError> {
        let (ZoneAnswer::Vibrating(modes), Some(elastic)) = (&side.answer, body.flexible()) else {
            return Ok(None);
        };
        let n_low = side.shapes.ncols();
        let frequencies = body.data.modal_stiffness.iter().copied().chain(modes.omega.iter().map(|w| w * w));
        let stiffness: Vec<f64> = frequencies.collect();
        let own = damping(&elastic.body.settings().damping, &stiffness, stiffness.len())
            .map_err(|source| AdaptiveError::Reduction { body: body.name.clone(), source })?;
        let all = if self.law.treatment.interface_modes() == Some(InterfaceModes::Damped) {
            let omega: Vec<f64> = stiffness.iter().map(|k| k.sqrt()).collect();
            with_critical(own, &omega, n_low)
        } else {
            own
        };
        let damping = match all {
            ModalDamping::None => vec![0.0; modes.omega.len()],
            ModalDamping::PerMode(all) => all[n_low..].to_vec(),
            ModalDamping::Full(_) => unreachable!("bodies with a shape have damping mode by mode"),
        };
        let (omega, mass) = (modes.omega.clone(), body.data.mass);
        Ok(Some(ZoneVibration { body: index, n_low, mass, omega, damping }))
    }

    /// The target with its surface, if it is a rigid body.
    fn rigid_target<'a>(&self, bodies: &'a [BodyModel]) -> Option<(usize, &'a RigidSurface)> {
        let body = self.target.body()?;
        Some((body, bodies[body].rigid_surface()?))
    }

    /// The force element of the refined contact of bodies in the motions `states`, whose surfaces
    /// are `gap` apart, and the offset of its zone \[m\]. A zone that lies on a smooth surface in
    /// place of the sides of its mesh is moved along its normal until the contact has this gap, one at several places
    /// only inwards; other zones have no offset.
    ///
    /// # Errors
    /// As [`AdaptiveContact::element`].
    pub(super) fn element_at(
        &self,
        own: &mut FineSide,
        other: &mut Option<(usize, FineSide)>,
        bodies: &[BodyModel],
        states: &[BodyState],
        gap: f64,
    ) -> Result<(Box<dyn ActiveContact>, f64), AdaptiveError> {
        let mut element = self.element(own, other.as_ref(), bodies)?;
        let Some((most, FineSide { body, zone, .. })) = smooth_side(own, other) else {
            return Ok((element, 0.0));
        };
        let found = element.meeting(Motion::new(0.0, states)).gap;
        if !found.is_finite() {
            return Ok((element, 0.0));
        }
        let offset = (found - gap).min(most);
        body.move_out(zone, offset);
        Ok((self.element(own, other.as_ref(), bodies)?, offset))
    }

    /// The force element of the refined contact.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if points, surfaces and settings do not fit each other.
    pub(super) fn element(
        &self,
        own: &FineSide,
        other: Option<&(usize, FineSide)>,
        bodies: &[BodyModel],
    ) -> Result<Box<dyn ActiveContact>, AdaptiveError> {
        let contact = self.contact_of_points(own, other, bodies)?;
        if !self.is_vibrating() {
            return Ok(contact.active());
        }
        let mut zones = Vec::new();
        for (index, side) in [(self.body, own)].into_iter().chain(other.iter().map(|(i, side)| (*i, side))) {
            zones.extend(self.vibration(side, index, &bodies[index])?);
        }
        zones.extend(self.rigid_target(bodies).map(|(body, _)| ZoneVibration {
            body,
            n_low: 0,
            mass: bodies[body].data.mass,
            omega: Vec::new(),
            damping: Vec::new(),
        }));
        contact.vibrating(zones, bodies.len()).map_err(|e| self.fail(e))
    }

    /// `max_i(A_ii w_i)` of the points of `contact` that are going to touch from the motions `states` on
    /// (Eq. A.25): all of an interval, and of whole surfaces, `is_whole`, the nearest ones [m³/N].
    pub(super) fn weight_of(
        &self,
        contact: &mut dyn ActiveContact,
        states: &[BodyState],
        is_whole: bool,
    ) -> Result<Option<f64>, AdaptiveError> {
        let reach = if is_whole { TOUCHED_SURFACE * self.detector.least_size() } else { f64::INFINITY };
        contact
            .compliance_weight(Motion::new(0.0, states), reach)
            .map_err(|failure| self.fail(failure.into()))
    }

    /// `max_i(A_ii w_i)` of a contact whose zones vibrate, for the static answer, which is the sum
    /// over their modes (Eq. R.26) [m³/N].
    pub(super) fn static_weight(
        &self,
        own: &mut FineSide,
        other: &mut Option<(usize, FineSide)>,
        bodies: &[BodyModel],
        states: &[BodyState],
    ) -> Result<Option<f64>, AdaptiveError> {
        let moving = own.hold();
        let moving_target = other.as_mut().map(|(_, side)| side.hold());
        let contact = self.contact_of_points(own, other.as_ref(), bodies);
        own.answer = moving;
        if let (Some((_, side)), Some(answer)) = (other.as_mut(), moving_target) {
            side.answer = answer;
        }
        self.weight_of(contact?.active().as_mut(), states, false)
    }

    fn contact_of_points(
        &self,
        own: &FineSide,
        other: Option<&(usize, FineSide)>,
        bodies: &[BodyModel],
    ) -> Result<ZoneContact, AdaptiveError> {
        let has_edges = own.zone.is_under_edges();
        let (own_shapes, other_shapes) = (own.all_shapes(), other.map(|(_, side)| side.all_shapes()));
        let own = own.contact_side(self.body, own_shapes.as_ref().as_ref());
        let other = other.zip(other_shapes.as_ref());
        let other = other.map(|((body, side), shapes)| side.contact_side(*body, shapes.as_ref().as_ref()));
        let rigid = self.rigid_target(bodies).map(|(body, surface)| surface.side(body, has_edges));
        let other = other.or(rigid);
        ZoneContact::new(&self.law, self.target, &own, other.as_ref()).map_err(|e| self.fail(e))
    }
}

impl FineSide {
    /// The parts that pictures and probes of a stored result need.
    fn into_model(self, residual: ResidualFlexibility) -> ZoneModel {
        let Self { body: model, zone, shapes, .. } = self;
        ZoneModel { model, zone, shapes, residual }
    }

    /// Replaces the vibration of the zone by its static answer; returns the answer that it had.
    fn hold(&mut self) -> ZoneAnswer {
        let held = match &self.answer {
            ZoneAnswer::Static(compliance) => compliance.clone(),
            ZoneAnswer::Vibrating(ResidualModes { omega, interface_shapes: shapes }) => {
                let scaled = Mat::from_fn(shapes.nrows(), omega.len(), |b, j| shapes[(b, j)] / omega[j]);
                &scaled * scaled.transpose()
            }
        };
        std::mem::replace(&mut self.answer, ZoneAnswer::Static(held))
    }

    /// Compliance of the interface; none if it vibrates.
    fn compliance(&self) -> Option<InterfaceCompliance<'_>> {
        match &self.answer {
            ZoneAnswer::Static(compliance) => {
                Some(InterfaceCompliance { dofs: &self.zone.unknowns, compliance: compliance.as_ref() })
            }
            ZoneAnswer::Vibrating(_) => None,
        }
    }

    /// Low-frequency modes and, behind them, those by which the zone vibrates, at the unknowns. The
    /// latter are given on the interface alone, on which all contact points lie.
    fn all_shapes(&self) -> Cow<'_, Mat<f64>> {
        let ZoneAnswer::Vibrating(modes) = &self.answer else { return Cow::Borrowed(&self.shapes) };
        let n_low = self.shapes.ncols();
        let mut shapes = Mat::zeros(self.shapes.nrows(), n_low + modes.omega.len());
        shapes.as_mut().subcols_mut(0, n_low).copy_from(&self.shapes);
        for (b, &unknown) in self.zone.unknowns.iter().enumerate() {
            for j in 0..modes.omega.len() {
                shapes[(unknown, n_low + j)] = modes.interface_shapes[(b, j)];
            }
        }
        Cow::Owned(shapes)
    }

    /// The side of body `body`, moving with `shapes`, those of [`FineSide::all_shapes`].
    fn contact_side<'a>(&'a self, body: usize, shapes: MatRef<'a, f64>) -> ContactSide<'a> {
        ContactSide {
            body,
            motion: self.body.field().motion(),
            lookup: self.body.field().lookup(),
            splines: self.body.faces(),
            zone: &self.zone,
            shapes,
            compliance: self.compliance(),
            meets: self.body.meets().copied(),
        }
    }
}

/// Flexibility of the interface of the zone.
fn flexibility(FineZone { fine, zone }: &FineZone) -> Result<FreeFlexibility, AdaptiveError> {
    fine.flexibility(&*fine.assemble()?, &zone.unknowns)
}

/// The side of `body` with its zone, built again, and what the modes of the body leave of
/// `flexibility`.
fn side_with(
    body: &FlexibleModel,
    FineZone { fine, zone }: FineZone,
    flexibility: FreeFlexibility,
) -> Result<(FineSide, ResidualFlexibility), AdaptiveError> {
    let residual = fine.residual(flexibility, fine.low_modes(&body.reduced))?;
    let answer = ZoneAnswer::Static(residual.compliance().clone());
    let shapes = fine.shapes(&body.reduced);
    let side = FineSide { body: fine, zone, shapes, answer, points: Mat::new(), fine_basis: None };
    Ok((side, residual))
}

/// The side whose zone lies on smooth surfaces in place of the sides of its mesh, and how far it may be moved outwards \[m\]; the contact body if
/// both do.
fn smooth_side<'s>(
    own: &'s mut FineSide,
    other: &'s mut Option<(usize, FineSide)>,
) -> Option<(f64, &'s mut FineSide)> {
    let sides = [Some(own), other.as_mut().map(|(_, side)| side)];
    sides.into_iter().flatten().find_map(|side| Some((side.body.most_outwards()?, side)))
}

/// The parts of a zone's answer that the model store keeps.
fn stored_answer((answer, points): &(ZoneAnswer, Mat<f64>)) -> StoredModel {
    let values = match answer {
        ZoneAnswer::Static(compliance) => {
            let mut values = matrix_values(compliance);
            values.extend(matrix_values(points));
            values
        }
        ZoneAnswer::Vibrating(modes) => {
            let mut values = modes.omega.clone();
            values.extend(matrix_values(&modes.interface_shapes));
            values
        }
    };
    StoredModel { counts: Vec::new(), values }
}
