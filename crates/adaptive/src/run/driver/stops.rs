//! Hits of the stops of joints: watched in every step, stored densely and reported like impacts
//! (docs/theory.md Eq. M.23).

use ffr_dynamics::integration::DenseOutput;

use super::Driver;
use crate::error::AdaptiveError;

/// Instants of a step at which a stop is looked at, and stored in free phases: steps follow the
/// force of a hit to the tolerance, four instants of each show its course.
const INSTANTS: u32 = 4;

impl Driver<'_> {
    /// Time between the states to be stored in the step from `start` to `end`, if a stop presses in
    /// it that has just been hit.
    pub(super) fn interval_of_hits(&self, (start, end): (f64, f64)) -> Option<f64> {
        let (before, now) = (self.integrator.previous_state(), self.integrator.state());
        let mut hits = self.stops.iter().zip(&self.run.hits);
        let is_hit = hits.any(|(stop, hit)| {
            let presses = stop.force(start, before).0 > 0.0 || stop.force(end, now).0 > 0.0;
            presses && (hit.is_short() || !hit.is_pressed())
        });
        is_hit.then(|| (end - start) / f64::from(INSTANTS))
    }

    /// Looks at the stops in the last step.
    pub(super) fn note_stops(&mut self) -> Result<(), AdaptiveError> {
        if self.stops.is_empty() {
            return Ok(());
        }
        let (start, end) = self.integrator.interval();
        let n_contacts = self.slots.len();
        for i in 1..=INSTANTS {
            let time =
                if i == INSTANTS { end } else { start + (end - start) * f64::from(i) / f64::from(INSTANTS) };
            self.integrator.interpolate(time, &mut self.interpolated);
            for (s, (stop, hit)) in self.stops.iter().zip(&mut self.run.hits).enumerate() {
                let (force, rate) = stop.force(time, &self.interpolated);
                if let Some(record) = hit.step(time, force, rate, (n_contacts + s) as u32) {
                    self.output.hit(record);
                }
            }
        }
        Ok(())
    }

    /// Reports the hits that the end of the run leaves open.
    pub(super) fn report_pressed_stops(&mut self) -> Result<(), AdaptiveError> {
        let (n_contacts, time) = (self.slots.len(), self.integrator.time());
        for (s, hit) in self.run.hits.iter().enumerate().filter(|(_, hit)| hit.is_pressed()) {
            self.output.hit(hit.unended(time, (n_contacts + s) as u32));
        }
        self.report_hits()
    }

    /// Reports the hits that have ended.
    pub(super) fn report_hits(&mut self) -> Result<(), AdaptiveError> {
        self.run.n_hits += self.output.send_hits(self.run.n_rows())?;
        Ok(())
    }
}
