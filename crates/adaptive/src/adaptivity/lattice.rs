//! Graded refinement around one contact interval: lattices whose spacing doubles from level to
//! level (theory section A.2, `docs/decisions/0009-graded-lattices.md`,
//! `docs/decisions/0019-levels-of-a-zone.md`).
//!
//! The finest level is laid through the ends of the interval, and every coarser level takes each
//! second knot of the finer one, until the elements of the coarse model are reached: as many levels
//! as the logarithm of the ratio of sizes, each with as many elements as the interval is wide in
//! its own. Works on parameters; what the levels do to a space is
//! [`crate::body::fine::refined`]'s part.

use iga_core::splines::knots::KnotVector;

/// Distance of a lattice point from a knot, as a share of the spacing, below which the knot serves
/// in its place.
const NEAR_KNOT: f64 = 0.3;
/// Largest spacing of a lattice, as a share of the coarse element at the contact.
const COARSEST: f64 = 0.75;

/// The lattice of one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionLattice {
    /// A point of the lattices of all levels.
    pub anchor: f64,
    /// Spacing on the finest level.
    pub spacing: f64,
    /// Number of levels that divide this direction.
    pub n_levels: usize,
    /// Number of levels from the finest on that leave this direction as it is, for elements across
    /// it are shorter.
    pub n_skipped: usize,
}

impl DirectionLattice {
    /// The lattice of an interval of `n` elements, and the interval with its ends on the lattice.
    ///
    /// A knot of the coarse model inside the interval, or just outside, stays a knot of every
    /// level; so that all elements are alike, the interval is moved, by half an element at most,
    /// until that knot lies on the lattice. Where a second knot stands close to an end, it takes
    /// the place of the lattice point, so that the ends are always knots of the finest level.
    pub fn along(knots: &KnotVector, interval: [f64; 2], n: usize) -> (Self, [f64; 2]) {
        let [lower, upper] = interval;
        let spacing = (upper - lower) / n as f64;
        let (first, last) = knots.domain();
        let breaks = knots.breaks();
        let n_levels = levels(largest_element(knots, interval), spacing);
        if n_levels == 0 {
            return (Self { anchor: lower, spacing, n_levels, n_skipped: 0 }, interval);
        }
        let is_inside = |b: &&f64| lower - NEAR_KNOT * spacing < **b && **b < upper + NEAR_KNOT * spacing;
        let shift = breaks.iter().find(is_inside).map_or(0.0, |b| {
            let place = (b - lower) / spacing;
            (place - place.round()) * spacing
        });
        // Not beyond an end of the face.
        let shift = shift.clamp((first - lower).min(0.0), (last - upper).max(0.0));
        let (lower, upper) = (lower + shift, upper + shift);
        let on_a_knot =
            |end: f64| *breaks.iter().find(|b| (**b - end).abs() < NEAR_KNOT * spacing).unwrap_or(&end);
        (Self { anchor: lower, spacing, n_levels, n_skipped: 0 }, [on_a_knot(lower), on_a_knot(upper)])
    }

    /// The lattice of a direction into the depth, from the surface at `surface` to `end`, with the
    /// spacing `spacing`.
    pub fn into_depth(knots: &KnotVector, surface: f64, end: f64, spacing: f64) -> Self {
        let reach = [surface.min(end), surface.max(end)];
        let n_levels = levels(largest_element(knots, reach), spacing);
        Self { anchor: surface, spacing, n_levels, n_skipped: 0 }
    }

    /// The lattice beside one whose elements are `ratio` times shorter: its finest level is the one
    /// on which those have become as long, so that below an elongated interval elements stay short
    /// along it to the depth of its length.
    #[must_use]
    pub fn beside_shorter(self, ratio: f64) -> Self {
        Self { n_skipped: ratio.max(1.0).log2().round() as usize, ..self }
    }

    /// Whether level `level` (0: the finest) divides this direction.
    pub fn divides(&self, level: usize) -> bool {
        (self.n_skipped..self.n_skipped + self.n_levels).contains(&level)
    }

    /// Points of level `level` (0: the finest) in the `wanted` elements of the next coarser one,
    /// not at their ends.
    pub fn new_knots(&self, coarse: &KnotVector, level: usize, wanted: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut new = Vec::new();
        if !self.divides(level) {
            return new;
        }
        let spacing = self.spacing * 2f64.powi((level - self.n_skipped) as i32);
        for e in (0..coarse.n_elements()).filter(|&e| wanted(e)) {
            let (a, b) = coarse.element(e);
            let near = NEAR_KNOT * spacing;
            let from = ((a + near - self.anchor) / spacing).ceil() as i64;
            let to = ((b - near - self.anchor) / spacing).floor() as i64;
            new.extend((from..=to).map(|i| self.anchor + i as f64 * spacing));
        }
        new
    }
}

/// Largest of the elements that meet `interval`.
fn largest_element(knots: &KnotVector, [lower, upper]: [f64; 2]) -> f64 {
    let sizes = (knots.find_element(lower)..=knots.find_element(upper)).map(|e| {
        let (a, b) = knots.element(e);
        b - a
    });
    sizes.fold(0.0, f64::max)
}

/// Levels until the spacing reaches that of the coarse elements.
fn levels(element: f64, spacing: f64) -> usize {
    let ratio = COARSEST * element / spacing;
    if ratio >= 1.0 { ratio.log2().floor() as usize + 1 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn uniform(n: usize) -> KnotVector {
        KnotVector::uniform(2, n).unwrap()
    }

    fn refine(
        lattice: &DirectionLattice,
        coarse: &KnotVector,
        level: usize,
        wanted: impl Fn(usize) -> bool,
    ) -> KnotVector {
        coarse.with_knots(&lattice.new_knots(coarse, level, wanted)).unwrap()
    }

    /// All levels of a lattice about `interval`, every level refined over the whole patch.
    fn finest(lattice: &DirectionLattice, coarse: &KnotVector) -> KnotVector {
        (0..lattice.n_levels).rev().fold(coarse.clone(), |knots, l| refine(lattice, &knots, l, |_| true))
    }

    #[test]
    fn the_depth_starts_at_the_surface_and_sizes_double() {
        let coarse = uniform(4);
        let lattice = DirectionLattice::into_depth(&coarse, 1.0, 0.92, 0.01);
        assert_eq!(lattice.n_levels, 5); // 0.01 to 0.16, below three quarters of 0.25
        let breaks = refine(&lattice, &coarse, 4, |e| e == 3).breaks();
        let expected = [0.0, 0.25, 0.5, 0.75, 0.84, 1.0];
        assert!(breaks.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{breaks:?}");
    }

    #[test]
    fn a_long_direction_is_divided_where_the_others_have_grown_to_its_elements() {
        let (along, _) = DirectionLattice::along(&uniform(4), [0.3, 0.46], 16); // 0.01 to 0.16
        let beside = along.beside_shorter(8.0);
        assert_eq!((along.n_levels, beside.n_levels, beside.n_skipped), (5, 5, 3));
        let divided: Vec<usize> = (0..10).filter(|level| beside.divides(*level)).collect();
        assert_eq!(divided, [3, 4, 5, 6, 7]);
        let refined_by = |lattice: &DirectionLattice, level| refine(lattice, &uniform(4), level, |_| true);
        assert_eq!(refined_by(&beside, 2), uniform(4));
        assert_eq!(refined_by(&beside, 5), refined_by(&along, 2));
        // Equal elements, and less than twice as long ones to the nearest level.
        assert_eq!([0.5, 1.0, 1.4].map(|ratio| along.beside_shorter(ratio).n_skipped), [0; 3]);
    }

    #[test]
    fn a_body_that_is_fine_enough_is_not_divided() {
        let (lattice, interval) = DirectionLattice::along(&uniform(64), [0.25, 0.75], 16);
        assert_eq!((lattice.n_levels, interval), (0, [0.25, 0.75]));
    }

    proptest! {
        #[test]
        fn intervals_end_on_knots_and_hold_equal_elements(
            n in 1usize..12,
            elements in 2usize..33,
            centre in 0.1f64..0.9,
            width in 1e-4f64..0.15,
        ) {
            let (coarse, wanted) = (uniform(n), [centre - 0.5 * width, centre + 0.5 * width]);
            let (lattice, [lower, upper]) = DirectionLattice::along(&coarse, wanted, elements);
            // Half an element for the first knot, less than a third of one for the second.
            prop_assert!((lower - wanted[0]).abs() <= (0.5001 + NEAR_KNOT) * lattice.spacing);
            prop_assume!(lattice.n_levels > 0);
            let breaks = finest(&lattice, &coarse).breaks();
            let slack = 1e-9;
            for end in [lower, upper] {
                prop_assert!(breaks.iter().any(|b| (b - end).abs() < slack), "{} is no knot of {:?}", end, breaks);
            }
            // The elements are alike unless a coarse knot, in the interval or in place of an end,
            // is not on the lattice.
            let is_stray = |b: &f64| {
                let place = (b - lattice.anchor) / lattice.spacing;
                (place - place.round()).abs() > 1e-6 && (lower - slack..=upper + slack).contains(b)
            };
            if !coarse.breaks().iter().any(is_stray) {
                let n_inside = breaks.iter().filter(|b| (lower - slack..=upper + slack).contains(*b)).count();
                prop_assert_eq!(n_inside, elements + 1);
            }
            // No element is a sliver.
            let least = breaks.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
            prop_assert!(least >= 0.29 * lattice.spacing, "{} {}", least, lattice.spacing);
        }
    }
}
