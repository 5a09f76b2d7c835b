//! Hits of the stops of joints: watched in every step, stored densely and reported like impacts
//! (docs/theory.md Eq. M.23).

use ffr_dynamics::integration::DenseOutput;

use ffr_dynamics::system::model::stops::StopSite;

use super::Driver;
use crate::error::AdaptiveError;
use crate::state::stop_hit::Seen;

/// Instants of a step at which a stop is looked at, and stored in free phases: steps follow the
/// force of a hit to the tolerance, four instants of each show its course.
const INSTANTS: u32 = 4;
/// Halvings of the time in which a stop is met or left, to a millionth of it.
const HALVINGS: u32 = 20;

impl Driver<'_> {
    /// Time between the states to be stored in the step from `start` to `end`, if a stop presses in
    /// it that has just been hit.
    pub(super) fn interval_of_hits(&self, (start, end): (f64, f64)) -> Option<f64> {
        let (before, now) = (self.integrator.previous_state(), self.integrator.state());
        let mut hits = self.stops.iter().zip(&self.run.hits);
        let is_hit = hits.any(|(stop, hit)| {
            let presses = stop.force(start, before) > 0.0 || stop.force(end, now) > 0.0;
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
                let now = Seen::at(stop, time, &self.interpolated);
                let crossing = hit.crossing(&now).then(|| {
                    let mut y = self.interpolated.clone();
                    locate((hit.seen().time, time), now.compression > 0.0, |t| {
                        self.integrator.interpolate(t, &mut y);
                        Seen::at(stop, t, &y)
                    })
                });
                for seen in crossing.into_iter().chain([now]) {
                    if let Some(record) = hit.step(seen, (n_contacts + s) as u32) {
                        self.output.hit(record);
                    }
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

impl Seen {
    /// The `stop` at time `time` in the state `y`.
    fn at(stop: &StopSite, time: f64, y: &[f64]) -> Self {
        let [compression, rate] = stop.compression(time, y);
        Self { time, force: stop.force(time, y), compression, rate }
    }
}

/// The instant between two times at which a stop is met, if it `is_closing`, or left: the last one
/// without compression before, or the first one after it.
fn locate((mut open, mut closed): (f64, f64), is_closing: bool, mut at: impl FnMut(f64) -> Seen) -> Seen {
    if !is_closing {
        (open, closed) = (closed, open);
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (open + closed);
        if at(middle).compression > 0.0 { closed = middle } else { open = middle }
    }
    Seen { force: 0.0, ..at(open) }
}
