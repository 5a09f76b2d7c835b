//! Overlaps that a step of an impact phase has stepped over.
//!
//! Where no force acts nothing makes the steps short: bodies that graze each other may be apart
//! again before the first of its stages feels them. As in free phases, an overlap between the ends
//! of a step is looked for in the interpolated motion (theory Eq. C.35).

use ffr_dynamics::integration::DenseOutput;

use crate::error::AdaptiveError;
use crate::run::driver::Driver;
use crate::state::simulation::smallest_gap;

/// Halvings, or nearly, of an overlap in search of its deepest instant: to a thousandth of it.
const NARROWINGS: usize = 20;

impl Driver<'_> {
    /// The deepest instant of an overlap within the last step, at whose ends the contact was open:
    /// the first of all contacts that closed at the beginning, that have a model and that have not
    /// touched in this phase. (What is left of a touch in the vibration of its points is not worth
    /// a step of its own.)
    pub(crate) fn overlap_stepped_over(&mut self) -> Result<Option<f64>, AdaptiveError> {
        let (_, end) = self.integrator.interval();
        let mut first: Option<f64> = None;
        let mut open = Vec::new();
        for k in 0..self.near.len() {
            let i = self.near[k];
            let (slot, forces) = (&self.slots[i], self.model.system.forces());
            let may_touch = !slot.monitor.is_running() && slot.monitor.is_closing_without_force();
            let is_left = slot.is_watching() || !may_touch;
            if !is_left && forces[i].contact.report().normal_force <= 0.0 && self.gaps(i)[1] > 0.0 {
                open.push(i);
            }
        }
        for (i, touch) in self.first_crossings(&open)? {
            let deepest = self.deepest(i, (touch.time, end));
            first = Some(first.map_or(deepest, |other| other.min(deepest)));
        }
        if first.is_none() {
            // The search leaves the system at another instant.
            self.model.system.body_states(end, self.integrator.state());
        }
        Ok(first)
    }

    /// When contact `i`, which overlaps at the first of two times and not at the second, is deepest
    /// in the interpolated motion.
    fn deepest(&mut self, i: usize, (mut from, mut to): (f64, f64)) -> f64 {
        let mut gap = |t: f64| {
            self.integrator.interpolate(t, &mut self.interpolated);
            smallest_gap(&mut self.model.system, t, &self.interpolated, i)
        };
        // The overlap alone, which may be a small part of the step.
        for _ in 0..NARROWINGS {
            let middle = 0.5 * (from + to);
            if gap(middle) <= 0.0 {
                break;
            }
            to = middle;
        }
        for _ in 0..NARROWINGS {
            let third = (to - from) / 3.0;
            if gap(from + third) < gap(to - third) { to -= third } else { from += third }
        }
        0.5 * (from + to)
    }
}
