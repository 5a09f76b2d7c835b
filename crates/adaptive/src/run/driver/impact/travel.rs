//! Contact that rolls or slides out of its zone: the zone about the present touch takes over, with the forces of friction that the
//! one before held (docs/theory.md section A.11).

use ffr_dynamics::integration::OdeSystem;
use iga_core::nurbs::jet::norm;
use nalgebra::Vector3;

use super::by_law::Next;
use super::intervals::Intervals;
use crate::error::AdaptiveError;
use crate::impact::FineContact;
use crate::record::{TransferDirection, ZoneSize};
use crate::run::driver::{Driver, TOUCHING};

/// Zones that were made wider, in vain, for contact that fits into one twice, after which the next one takes over.
const WIDENED: u32 = 1;
/// Way in a zone, as a share of its width, from which on contact goes on along the body.
const GONE: f64 = 0.1;
/// Distance from the nearest points of the zone before, in units of that between these, from which on a point had no force there.
const BESIDE: f64 = 1.5;

/// A point of a zone: its place on the undeformed body \[m\], and the area that it stands for \[m²\].
type ZonePoint = (Vector3<f64>, f64);

/// Forces of friction that a contact holds, and the points of its zone that they act on \[N\].
#[derive(Debug, Clone, Default)]
pub(crate) struct HeldFriction {
    points: Vec<ZonePoint>,
    forces: Vec<Vector3<f64>>,
}

impl Driver<'_> {
    /// Whether the zone of contact `i`, which ends where contact is now, gives way to another one: contact fits into it twice (Eq. A.40),
    /// and lasts (Eq. A.38), or wider zones did not hold it. Zones that are no intervals, that vibrate or bring modes of their own stay.
    pub(crate) fn travels(&self, i: usize) -> bool {
        let slot = &self.slots[i];
        self.may_hand_over(i)
            && slot.fine().is_some_and(FineContact::fits_twice)
            && (slot.found.travels || slot.found.left >= WIDENED || self.has_lasted(i))
    }

    fn may_hand_over(&self, i: usize) -> bool {
        let is_interval = self.slots[i].fine().is_some_and(|fine| fine.whole.is_none());
        is_interval
            && !self.is_width_given(i)
            && self.refined().all(|(_, fine)| fine.hosted.is_empty())
            && self.model.system.forces().iter().all(|force| force.n_coordinates() == 0)
    }

    /// The first contact that is open in its zone and whose bodies touch beside it.
    pub(crate) fn first_elsewhere(&mut self) -> Result<Option<usize>, AdaptiveError> {
        let refined: Vec<usize> = self.refined().map(|(i, _)| i).collect();
        for i in refined {
            let is_open = self.model.system.forces()[i].contact.report().normal_force <= 0.0;
            if !is_open || !self.may_hand_over(i) {
                continue;
            }
            let (t, y) = (self.integrator.time(), self.integrator.state());
            self.model.system.body_states(t, y);
            let states = self.model.system.last_evaluation().0;
            let slot = &mut self.slots[i];
            let Some(refinement) = &self.model.contacts[i].refinement else { continue };
            let nearest = refinement.nearest(states, &mut slot.nearest)?;
            let is_overlap = nearest.gap < -TOUCHING * refinement.detector.size();
            let is_beside = |fine| refinement.is_beside(&self.model.bodies, fine, &nearest);
            // What lies deep in each other there has touched before it let go here.
            if is_overlap && slot.fine().is_some_and(is_beside) && !self.adds_zone(i, &nearest) {
                return Ok(Some(i));
            }
        }
        Ok(None)
    }

    /// Gives contact `i`, whose trial was accepted up to the present instant, what is `next`: a zone about the present touch, or its law. The impact
    /// goes on in it.
    ///
    /// # Errors
    /// [`AdaptiveError`] if there is no such zone.
    pub(super) fn hand_over(
        &mut self,
        i: usize,
        next: Next,
        intervals: &mut Intervals,
    ) -> Result<(), AdaptiveError> {
        self.store_noted()?;
        self.report_hits()?;
        self.marked_hits.clone_from(&self.run.hits);
        self.output.flush()?;
        self.output.buffer(true);
        if let Next::Law(law, zones) = next {
            return self.go_on_by_law(i, (*law, zones), intervals);
        }
        let (Some(fine), Some(refinement)) = (self.slots[i].fine(), &self.model.contacts[i].refinement)
        else {
            return Ok(());
        };
        let handed = (fine.activation.time, fine.length());
        // Before a peak there is nothing to compare factors by.
        let search = if self.has_lasted(i) { fine.search.accepted() } else { fine.search.clone() };
        let overlap = fine.overlap;
        let is_pressed = self.slots[i].monitor.is_pressed();
        let size = is_pressed.then(|| fine.size_on_the_way(refinement.interval_settings().target));
        let ahead = match size {
            Some(size) => self.ahead(i, size)?,
            None => [[0.0; 3]; 2],
        };
        self.slots[i].found.handed.push(handed);
        let before = self.present_balance()?;
        let held = self.held_friction();
        self.deactivate(i)?;
        if !is_pressed {
            // Another touch, of which nothing is known.
            self.slots[i].found.preview = None;
            self.preview(&[i])?;
        }
        (self.slots[i].found.search, self.slots[i].found.ahead) = (Some(search), ahead);
        self.slots[i].found.touches.clear();
        self.activate(i, size)?;
        if let Some(fine) = self.slots[i].fine_mut().filter(|_| is_pressed) {
            fine.overlap = overlap;
        }
        self.slots[i].found.travels |= is_pressed;
        intervals.go_on(i, size);
        self.hold_friction(&held)?;
        let after = self.present_balance()?;
        self.output.discard_transfers_of(i);
        self.record_transfer(i, TransferDirection::CoarseToFine, &before, &after);
        self.integrator.invalidate();
        Ok(())
    }

    /// How far ahead of the touch of contact `i` zones of the size `size` lie along the way that it has come in the present ones: so
    /// far that what presses has its other end in them \[m\].
    fn ahead(&mut self, i: usize, size: ZoneSize) -> Result<[[f64; 3]; 2], AdaptiveError> {
        let (t, y) = (self.integrator.time(), self.integrator.state());
        self.model.system.body_states(t, y);
        let states = self.model.system.last_evaluation().0;
        let slot = &mut self.slots[i];
        let Some(refinement) = &self.model.contacts[i].refinement else { return Ok([[0.0; 3]; 2]) };
        let nearest = refinement.nearest(states, &mut slot.nearest)?;
        let Some(fine) = slot.fine() else { return Ok([[0.0; 3]; 2]) };
        let ways = refinement.ways(&self.model.bodies, fine, &nearest);
        let length = fine.ahead_in(size);
        let least = GONE * fine.widths().into_iter().filter(|w| *w > 0.0).fold(f64::INFINITY, f64::min);
        // On a body that slides the touch stays where it is.
        Ok(ways.map(|way| if norm(&way) < least { [0.0; 3] } else { way.map(|c| c * length / norm(&way)) }))
    }

    /// What the contacts hold by friction, in their order.
    pub(crate) fn held_friction(&self) -> Vec<HeldFriction> {
        let of = |i: usize| {
            let forces = self.model.system.forces()[i].contact.friction_forces();
            let is_any = forces.iter().any(|force| *force != Vector3::zeros());
            if is_any {
                HeldFriction { points: self.zone_points(i), forces }
            } else {
                HeldFriction::default()
            }
        };
        (0..self.slots.len()).map(of).collect()
    }

    /// Has the contacts hold what was `held` in the present state, by zones of others if these have other points, as far as the bounds
    /// of the points allow.
    ///
    /// # Errors
    /// [`AdaptiveError`] if forces are refused.
    pub(crate) fn hold_friction(&mut self, held: &[HeldFriction]) -> Result<(), AdaptiveError> {
        let on_points = |(i, held): (usize, &HeldFriction)| {
            let is_any = !held.forces.is_empty() && self.slots[i].fine().is_some();
            is_any.then(|| (i, held.on(&self.zone_points(i))))
        };
        let wanted: Vec<(usize, Vec<Vector3<f64>>)> = held.iter().enumerate().filter_map(on_points).collect();
        if wanted.is_empty() {
            return Ok(());
        }
        let (t, y) = (self.integrator.time(), self.integrator.state().to_vec());
        let evaluate = |driver: &mut Self| {
            let outcome = driver.model.system.evaluate_accelerations(t, &y);
            outcome.map_err(|refusal| AdaptiveError::refused(t, refusal))
        };
        // The first evaluation finds the tangents, on which the second one has the forces.
        let mut outcome = Ok(());
        for _ in 0..2 {
            wanted.iter().for_each(|(i, forces)| self.prescribe_friction(*i, Some(forces)));
            outcome = outcome.and_then(|()| evaluate(self));
        }
        wanted.iter().for_each(|(i, _)| self.prescribe_friction(*i, None));
        outcome?;
        evaluate(self)?;
        self.model.system.save();
        Ok(())
    }

    fn prescribe_friction(&mut self, i: usize, wanted: Option<&[Vector3<f64>]>) {
        self.model.system.forces_mut()[i].contact.prescribe_friction(wanted);
    }

    /// The points of the zone of contact `i`.
    fn zone_points(&self, i: usize) -> Vec<ZonePoint> {
        let facts = self.model.system.forces()[i].contact.facts();
        let points = (0..facts.n_points()).map_while(|k| facts.point(k));
        points.map(|(place, area)| (Vector3::from(place), area)).collect()
    }
}

impl HeldFriction {
    /// The forces on the points `to` of another zone of the same body: tractions between the nearest points, with the sum that they had.
    fn on(&self, to: &[ZonePoint]) -> Vec<Vector3<f64>> {
        if self.points == to {
            return self.forces.clone();
        }
        let found: Vec<Vector3<f64>> = to.iter().map(|point| self.traction_at(&point.0) * point.1).collect();
        let (wanted, sum) = (self.forces.iter().sum::<Vector3<f64>>(), found.iter().sum::<Vector3<f64>>());
        let scale = wanted.norm_squared() / wanted.dot(&sum);
        // Where forces cancel each other their sum says nothing.
        if (0.5..2.0).contains(&scale) { found.into_iter().map(|f| f * scale).collect() } else { found }
    }

    /// The traction at `place`, between those of the two nearest points; none beside the zone \[Pa\].
    fn traction_at(&self, place: &Vector3<f64>) -> Vector3<f64> {
        let mut nearest = [(f64::INFINITY, usize::MAX); 2];
        for (k, (point, _)) in self.points.iter().enumerate() {
            let distance = (point - place).norm();
            if distance < nearest[0].0 {
                nearest = [(distance, k), nearest[0]];
            } else if distance < nearest[1].0 {
                nearest[1] = (distance, k);
            }
        }
        let traction = |k: usize| self.forces[k] / self.points[k].1;
        match nearest {
            [(_, usize::MAX), _] => Vector3::zeros(),
            [(distance, first), (_, usize::MAX)] if distance <= 0.0 => traction(first),
            [_, (_, usize::MAX)] => Vector3::zeros(),
            [(near, first), (far, second)] => {
                let spacing = (self.points[first].0 - self.points[second].0).norm();
                if near > BESIDE * spacing {
                    return Vector3::zeros();
                }
                (traction(first) * far + traction(second) * near) / (near + far)
            }
        }
    }
}
