//! Zones of contact that rolls or slides on: whether one is to give way to another, how large that is and where it lies
//! (docs/theory.md section A.11).

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;

use super::{AdaptiveContact, FineContact, flexible};
use crate::record::ZoneSize;
use crate::system::body::BodyModel;
use crate::touch::detection::Nearest;

/// Zones of contact that goes on, of curves and of surfaces: how many times as long as others along the way, and with how many times as
/// many elements, which surfaces, whose unknowns they raise by the square, do not pay for.
const ON_THE_WAY: [[f64; 2]; 2] = [[4.0, 4.0], [1.5, 1.0]];
/// Rows of elements that a zone on the way has behind what presses.
const BEHIND: f64 = 3.0;
/// Difference of the share that touches from the one wanted up to which the next zone is as large.
const SAME_SHARE: f64 = 0.25;

impl FineContact {
    /// Rows of elements that were in contact at one instant at most, per direction, as a share of the zone (Eq. A.40).
    pub fn shares_at_once(&self) -> impl Iterator<Item = f64> {
        let directions = 0..self.interval.ends.len();
        directions.map(|d| self.at_once[d] as f64 / self.interval.n_elements[d] as f64)
    }

    /// For each direction whether contact came to an end of the zone.
    fn reached(&self) -> Vec<bool> {
        let of = |d: usize| self.flags.along(d);
        let ends = (0..self.interval.ends.len()).map(of);
        ends.map(|rows| rows.first() == Some(&true) || rows.last() == Some(&true)).collect()
    }

    /// Whether what touched at one instant fits into the zone twice, in every direction in which contact came to an end of it.
    pub fn fits_twice(&self) -> bool {
        let reached = self.reached();
        // Contact that left the zone of the target alone does not tell in which direction.
        let is_told = reached.contains(&true);
        self.shares_at_once().zip(reached).all(|(share, end)| share <= 0.5 || is_told && !end)
    }

    /// The size of the next zone of contact that goes on beyond this one, of which the share `target` would touch if it stayed.
    pub fn size_on_the_way(&self, target: f64) -> ZoneSize {
        let [longer, finer] = ON_THE_WAY[self.interval.ends.len().clamp(1, 2) - 1];
        let mut widths = self.interval.widths;
        let is_along = self.reached().into_iter().map(|end| end || self.interval.ends.len() == 1);
        let wanted: Vec<f64> = is_along.map(|along| if along { target / longer } else { target }).collect();
        let shares: Vec<f64> = self.shares_at_once().collect();
        let is_near = |(share, wanted): (&f64, &f64)| (share / wanted - 1.0).abs() <= SAME_SHARE;
        if (self.finer() / finer - 1.0).abs() <= SAME_SHARE && shares.iter().zip(&wanted).all(is_near)
            || shares.contains(&0.0)
        {
            return ZoneSize::Interval { widths: both(widths), finer: self.finer() };
        }
        for (width, (share, wanted)) in widths.iter_mut().zip(shares.iter().zip(&wanted)) {
            *width *= share / wanted;
        }
        ZoneSize::Interval { widths: both(widths), finer }
    }

    /// Length of the zone, of surfaces the larger one \[m\].
    pub fn length(&self) -> f64 {
        self.interval.widths.into_iter().fold(0.0, f64::max)
    }

    /// Length of an element of the zone, of surfaces the smaller one; none of zones that are no intervals \[m\].
    pub fn row(&self) -> Option<f64> {
        let rows = (0..self.interval.ends.len())
            .map(|d| self.interval.widths[d] / self.interval.n_elements[d] as f64);
        rows.reduce(f64::min).filter(|row| self.whole.is_none() && *row > 0.0)
    }

    /// How far ahead of the touch the middle of a zone of the size `next` may lie along the way, so that what presses has its other end
    /// in it, three rows of elements before the end \[m\].
    pub fn ahead_in(&self, next: ZoneSize) -> f64 {
        let (Some(widths), reached) = (next.widths(), self.reached()) else { return 0.0 };
        let d = reached.iter().position(|end| *end).unwrap_or(0);
        let pressed = self.shares_at_once().nth(d).unwrap_or(1.0) * self.interval.widths[d];
        let n = self.interval.n_elements[d] as f64 * next.finer() / self.finer();
        (0.5 * (widths[d] - pressed) - BEHIND * widths[d] / n).max(0.0)
    }
}

impl AdaptiveContact {
    /// Length of a zone of contact that goes on, under the force `force` \[N\] at the nearest places in the motions `states` \[m\].
    pub fn length_on_the_way(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        nearest: &Nearest,
        force: f64,
    ) -> f64 {
        let is_surface = flexible(&bodies[self.body]).motion() == RigidMotion::Spatial;
        let [longer, _] = ON_THE_WAY[usize::from(is_surface)];
        longer
            * self
                .predicted_widths(bodies, states, nearest, Some(force))
                .widths
                .into_iter()
                .fold(0.0, f64::max)
    }
}

/// The widths of zones of one direction, twice.
fn both(widths: [f64; 2]) -> [f64; 2] {
    if widths[1] == 0.0 { [widths[0]; 2] } else { widths }
}
