//! Widths of the contacts' intervals in the trials of an impact: which ones were too narrow, which
//! ones held the contact, and which one follows (theory section A.1).

use crate::adaptivity::interval::{IntervalAssessment, Verdict};
use crate::record::ZoneSize;

/// Ratio of successive growths of a width of which nothing is known, as large as the first growth.
const GROWTH: f64 = 1.5;

/// Share of a width by which another one differs at least: zones are made of rounded widths.
const SAME_WIDTH: f64 = 1e-4;

/// Change of the peak force from one width to another, as a share of it, that says no more about the widths than penalty factors are searched
/// down to: half of their tolerance.
const SAME_FORCE: f64 = 1e-3;

/// Share of an interval that a contact of known force uses at least in every direction: pressures ask for some elements, too.
const LEAST_USED: f64 = 0.25;

/// Widths of the contacts' intervals in the trials of an impact.
pub(crate) struct Intervals {
    /// Sizes of the zones of the next trial, where earlier ones have set them.
    pub sizes: Vec<Option<ZoneSize>>,
    /// What is known of the widths, per contact and direction.
    brackets: Vec<[Bracket; 2]>,
    /// Peak force of the last whole trial, per contact \[N\].
    peaks: Vec<Option<f64>>,
    /// Whether widths have been found to change no force, per contact.
    agree: Vec<bool>,
    /// Contact whose interval changed last.
    pub latest: usize,
}

/// The interval of a trial that was not accepted.
#[derive(Debug, Clone, Copy)]
pub(super) struct TriedInterval {
    /// Its widths \[m\].
    pub widths: [f64; 2],
    /// Elements across it, per direction, and how many times as many they are as usual.
    pub n_elements: [usize; 2],
    pub finer: f64,
    /// Whether contact reached an end of it, or of the interval on the target, which ended the
    /// trial.
    pub is_edge: bool,
    /// Peak force of a trial that went on to the end of the impact \[N\].
    pub peak: Option<f64>,
}

/// What the trials of an impact told of the width of an interval in one direction.
#[derive(Debug, Clone, Copy)]
struct Bracket {
    /// Widest one whose edge was touched; zero if none was \[m\].
    narrow: f64,
    /// Narrowest one that held the contact; infinite if none did \[m\].
    holding: f64,
    /// How often in a row an edge was touched while no width was known to hold the contact.
    grown: u32,
}

impl Bracket {
    const UNKNOWN: Self = Self { narrow: 0.0, holding: f64::INFINITY, grown: 0 };

    /// Notes that the edge of an interval of this `width` was touched. One that held the contact
    /// before and is no wider tells nothing any more: penalty factors or other contacts have
    /// changed the force.
    fn touch(&mut self, width: f64) {
        self.narrow = self.narrow.max(width);
        if self.holding <= self.narrow {
            self.holding = f64::INFINITY;
        }
        self.grown = if self.holding.is_infinite() { self.grown + 1 } else { 0 };
    }

    /// Notes that an interval of this `width` held the contact.
    fn hold(&mut self, width: f64) {
        (self.holding, self.grown) = (self.holding.min(width), 0);
    }

    /// Whether the narrowest width that held the contact has no more than one of its `n` elements
    /// more at either end than one that did not.
    fn is_closed(&self, n: usize) -> bool {
        self.holding <= self.narrow * (1.0 + 2.0 / n.max(1) as f64)
    }

    /// The next width where Algorithm 2 wants `wanted`: that one if it lies between the widths
    /// known, else one between them. From the third growth in a row on each is larger than the one
    /// before, so that a first width that says nothing takes few trials.
    fn next(&self, wanted: f64, n: usize) -> f64 {
        let wanted = wanted * GROWTH.powi(self.grown.saturating_sub(2) as i32);
        let is_new = self.narrow * (1.0 + SAME_WIDTH) < wanted && wanted < self.holding * (1.0 - SAME_WIDTH);
        if self.narrow == 0.0 || is_new {
            wanted
        } else if self.is_closed(n) {
            self.holding
        } else {
            (self.narrow * self.holding).sqrt()
        }
    }
}

impl Intervals {
    pub fn new(n_contacts: usize) -> Self {
        let brackets = vec![[Bracket::UNKNOWN; 2]; n_contacts];
        let (sizes, peaks, agree) = (vec![None; n_contacts], vec![None; n_contacts], vec![false; n_contacts]);
        Self { sizes, brackets, peaks, agree, latest: 0 }
    }

    /// The widths of the next trial after `verdict` on the interval `tried` of contact `i`, where
    /// Algorithm 2 wants `wanted` \[m\]. None if no better one is left: it held the contact, and in
    /// every direction that was used too little, one narrower by an element at either end did not,
    /// since contact moves along one of the surfaces; or its peak force is that of the trial before, which had other widths.
    pub(super) fn next(
        &mut self,
        i: usize,
        tried: &TriedInterval,
        verdict: &IntervalAssessment,
        wanted: [f64; 2],
    ) -> Option<[f64; 2]> {
        // Contact that left the target's interval alone does not tell in which direction.
        let of_target = tried.is_edge && !verdict.touches_edge();
        let mut next = wanted;
        let mut is_last = !tried.is_edge;
        for (d, direction) in verdict.directions.iter().enumerate() {
            // More elements than usual do not ask for a width to be known better.
            let n = (tried.n_elements[d] as f64 / tried.finer) as usize;
            let bracket = &mut self.brackets[i][d];
            if direction.verdict == Verdict::EdgeTouched || of_target {
                bracket.touch(tried.widths[d]);
            } else if !tried.is_edge {
                bracket.hold(tried.widths[d]);
            }
            is_last &= direction.verdict.is_acceptable() || bracket.is_closed(n);
            next[d] = bracket.next(wanted[d], n);
        }
        let is_used = verdict.directions.iter().all(|d| d.utilisation >= LEAST_USED);
        let before = self.peaks[i];
        self.peaks[i] = tried.peak.or(before);
        let is_same = |(now, before): (f64, f64)| (now - before).abs() <= SAME_FORCE * before;
        self.agree[i] = !is_last && is_used && tried.peak.zip(before).is_some_and(is_same);
        if is_last || self.agree[i] {
            return None;
        }
        if verdict.directions.len() == 1 {
            next[1] = next[0];
        }
        (self.sizes[i], self.latest) = (Some(ZoneSize::Interval { widths: next, finer: tried.finer }), i);
        Some(next)
    }

    /// Whether the widths of contact `i` change its force no more: other elements would not, either.
    pub(super) fn agree(&self, i: usize) -> bool {
        self.agree[i]
    }

    /// Sets the intervals of contact `i` to `finer` times as many elements as usual, over the same
    /// `widths` \[m\].
    pub(super) fn refine(&mut self, i: usize, mut widths: [f64; 2], finer: f64) {
        if widths[1] == 0.0 {
            widths[1] = widths[0];
        }
        (self.sizes[i], self.latest) = (Some(ZoneSize::Interval { widths, finer }), i);
    }

    /// The zone of contact `i` is one of the size `size` from now on; what earlier ones told of widths is over.
    pub(super) fn go_on(&mut self, i: usize, size: Option<ZoneSize>) {
        (self.sizes[i], self.latest) = (size, i);
        (self.brackets[i], self.peaks[i]) = ([Bracket::UNKNOWN; 2], None);
    }

    /// Sets the zones of contact `i` to the whole surfaces.
    pub(super) fn take_whole(&mut self, i: usize) {
        (self.sizes[i], self.latest) = (Some(ZoneSize::Whole), i);
    }

    /// Raises the widths that the accepted `verdicts` name for the next impact to ones that held
    /// the contact, where narrower ones did not.
    pub(crate) fn raise(&self, verdicts: &mut [Option<IntervalAssessment>]) {
        for (verdict, brackets) in verdicts.iter_mut().zip(&self.brackets) {
            let directions = verdict.iter_mut().flat_map(|verdict| &mut verdict.directions);
            for (direction, bracket) in directions.zip(brackets) {
                if direction.width <= bracket.narrow && bracket.holding.is_finite() {
                    direction.width = bracket.holding;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adaptivity::interval::{DirectionUse, IntervalEnd, IntervalSettings, assess};
    use approx::assert_relative_eq;

    const N: usize = 16;

    /// Algorithm 2 for intervals of these `widths`, of which contact used `used`, up to an edge or
    /// not.
    fn verdict(widths: &[f64], used: &[f64], touches: &[bool]) -> IntervalAssessment {
        let rows = |((width, used), touches): ((&f64, &f64), &bool)| -> Vec<bool> {
            let n = (used / width * N as f64).round() as usize;
            let first = if *touches { 0 } else { (N - n.min(N)) / 2 };
            (0..N).map(|i| first <= i && i < first + n).collect()
        };
        let rows: Vec<_> = widths.iter().zip(used).zip(touches).map(rows).collect();
        let ends = [IntervalEnd::Open; 2];
        let uses =
            widths.iter().zip(&rows).map(|(width, contact)| DirectionUse { contact, width: *width, ends });
        assess(&uses.collect::<Vec<_>>(), &IntervalSettings::default())
    }

    /// Trials until one is accepted, from the widths `first`, of a contact that uses `used` of the
    /// contact body's interval and needs `needed` of one of the two; the widths accepted, and how
    /// many trials it took.
    fn settle(used: [f64; 2], needed: [f64; 2], first: [f64; 2], of_target: bool) -> ([f64; 2], u32) {
        let (mut intervals, mut widths) = (Intervals::new(1), first);
        for number in 1..40 {
            let touches = [0, 1].map(|d| widths[d] < needed[d]);
            let is_edge = touches.contains(&true);
            let verdict = verdict(&widths, &used, &touches.map(|touches| touches && !of_target));
            if verdict.is_acceptable() && !is_edge {
                return (widths, number);
            }
            let tried = TriedInterval { widths, n_elements: [N; 2], finer: 1.0, is_edge, peak: None };
            let wanted = if is_edge && of_target { widths.map(|w| 1.5 * w) } else { verdict.widths() };
            match intervals.next(0, &tried, &verdict, wanted) {
                Some(next) => widths = next,
                None => return (widths, number),
            }
        }
        panic!("no width is accepted");
    }

    #[test]
    fn contact_that_moves_along_a_surface_ends_at_the_narrowest_interval_that_holds_it() {
        for of_target in [true, false] {
            for used in [0.1, 0.3, 0.44, 0.49] {
                for first in [0.05, 0.3, 0.7, 1.3, 5.0] {
                    let (widths, trials) = settle([used; 2], [1.0; 2], [first; 2], of_target);
                    let most = 1.0 + 2.0 / N as f64;
                    assert!((1.0..=most).contains(&widths[0]), "{used} {first}: {widths:?}");
                    assert!(trials <= 12, "{used} {first}: {trials} trials");
                }
            }
        }
    }

    #[test]
    fn widths_whose_forces_agree_are_not_searched_any_longer() {
        for (used, forces, is_last) in
            [(0.4, [100.0, 100.09], true), (0.4, [100.0, 100.2], false), (0.2, [100.0, 100.0], false)]
        {
            let mut intervals = Intervals::new(1);
            let found = forces.map(|force| {
                let verdict = verdict(&[1.0; 2], &[used, 0.6], &[false; 2]);
                let tried = TriedInterval {
                    widths: [1.0; 2],
                    n_elements: [N; 2],
                    finer: 1.0,
                    is_edge: false,
                    peak: Some(force),
                };
                intervals.next(0, &tried, &verdict, verdict.widths())
            });
            assert!(found[0].is_some() && found[1].is_none() == is_last, "{used} {forces:?}: {found:?}");
        }
    }

    #[test]
    fn directions_settle_one_by_one() {
        // Contact moves along the first direction; across it the interval is used as asked for.
        for first in [[0.3, 0.1], [0.3, 4.0], [3.0, 0.1], [3.0, 4.0]] {
            let (widths, _) = settle([0.3, 0.7], [1.0, 0.8], first, false);
            assert!((1.0..=1.125).contains(&widths[0]), "{first:?}: {widths:?}");
            assert!((0.8..=1.4).contains(&widths[1]), "half of it at least is used, {first:?}: {widths:?}");
        }
    }

    #[test]
    fn a_width_that_held_a_smaller_force_is_forgotten() {
        let mut bracket = Bracket::UNKNOWN;
        bracket.hold(1.0);
        bracket.touch(0.9);
        assert!(bracket.is_closed(N));
        bracket.touch(1.0);
        assert!(!bracket.is_closed(N));
        assert_relative_eq!(bracket.next(1.5, N), 1.5);
    }

    #[test]
    fn a_width_that_was_touched_is_not_tried_again_for_the_sake_of_round_off() {
        let mut bracket = Bracket::UNKNOWN;
        bracket.touch(1.0);
        bracket.hold(1.5);
        // Algorithm 2 wants what was too narrow, rounded otherwise.
        assert_relative_eq!(bracket.next(1.0 + 1e-6, N), 1.5_f64.sqrt());
    }

    #[test]
    fn widths_of_which_nothing_is_known_grow_faster_and_faster() {
        let mut bracket = Bracket::UNKNOWN;
        let next = [1.0, 1.5, 2.25].map(|width| {
            bracket.touch(width);
            bracket.next(1.5 * width, N) / width
        });
        next.iter().zip([1.5, 1.5, 2.25]).for_each(|(next, growth)| assert_relative_eq!(*next, growth));
    }

    #[test]
    fn the_next_impact_begins_no_narrower_than_what_held_this_one() {
        let mut intervals = Intervals::new(1);
        (intervals.brackets[0][0].narrow, intervals.brackets[0][0].holding) = (1.0, 1.1);
        let mut verdicts = [Some(verdict(&[1.1], &[0.4], &[false]))];
        intervals.raise(&mut verdicts);
        assert_eq!(verdicts[0].as_ref().map(|v| v.directions[0].width), Some(1.1));
    }
}
