//! How the elements around a contact interval are divided, level by level (\[A\] Algorithm 3,
//! Figs. 5, 6; theory section A.2).
//!
//! Works on the breaks of one parametric direction at a time; neither geometry nor functions are
//! needed. What the levels do to a space is [`crate::body::fine::refined`]'s part.

use ffr_dynamics::memory::gigabytes as gb;
use thiserror::Error;

/// Largest number of levels, the coarse one and the one of contact elements included (\[A\]
/// section 4.3).
const MAX_LEVELS: usize = 5;
/// Largest number of knots inserted into an element from one level to the next (\[A\] section 4.3).
const MAX_KNOTS: usize = 10;
/// Distance of an end of an interval from its knot, as a share of the width (\[A\] section 4.3).
const TOLERANCE: f64 = 0.01;
/// More elements than wanted, as a share, before a division is passed over: 16 elements cannot be
/// had everywhere.
const EXCESS: f64 = 0.25;

/// Why an interval cannot be refined.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SubdivisionError {
    /// A width that is none.
    #[error("a contact interval of {width:.3e} m cannot be refined, its width must be positive and finite")]
    Width {
        /// Width asked for \[m\].
        width: f64,
    },
    /// Elements that round-off would fold.
    #[error(
        "a contact interval of {width:.3e} m with elements of {element:.3e} m cannot be resolved on a body of {size:.3e} m, whose points are known to {round_off:.0e} m; the touch is too slow or the partner too small for this body, choose model \"hertz\" for the contact or a smaller body"
    )]
    BelowRoundOff {
        /// Width of the interval \[m\].
        width: f64,
        /// Size of its elements \[m\].
        element: f64,
        /// Size of the body \[m\].
        size: f64,
        /// Round-off of places on it \[m\].
        round_off: f64,
    },
    /// A fine model that no memory holds.
    #[error(
        "a contact interval of {width:.3e} m with {across} elements across, {element:.3e} m each, makes about {unknowns:.1e} unknowns, {interface:.1e} of them in the contact zone, and needs about {} GB (at most {} GB); give interval.elements a smaller number",
        gb(*gigabytes), gb(*most)
    )]
    TooLarge {
        /// Width of the interval \[m\].
        width: f64,
        /// Elements across it.
        across: usize,
        /// Size of its elements \[m\].
        element: f64,
        /// Unknowns of the fine model.
        unknowns: f64,
        /// Unknowns of the contact zone.
        interface: f64,
        /// Memory needed \[GB\].
        gigabytes: f64,
        /// Memory permitted \[GB\].
        most: f64,
    },
    /// Algorithm 3 within its limits finds no division.
    #[error(
        "elements of {element:.3e} m cannot be divided as printed for a contact interval of {width:.3e} m: {levels} levels of at most {knots} knots per element are not enough; leave out interval.division, for graded levels resolve any interval",
        levels = MAX_LEVELS,
        knots = MAX_KNOTS
    )]
    TooSmall {
        /// Size of the coarse elements \[m\].
        element: f64,
        /// Width of the narrowest interval \[m\].
        width: f64,
    },
}

/// Division of one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionPlan {
    /// Parts of an element from each level to the next; the last entry makes the contact elements.
    pub parts: Vec<usize>,
    /// The intervals with their ends moved to knots.
    pub intervals: Vec<[f64; 2]>,
    /// Contact elements in each of them.
    pub n_elements: Vec<usize>,
    /// Largest distance by which an end was moved, as a share of its interval's width.
    pub deviation: f64,
}

/// Lines 3 to 9 of Algorithm 3: the levels over which `n_elements` parts are spread, or `None` if
/// its limits forbid it.
///
/// The prime factors, ascending; the two first ones are merged until the levels are few enough.
pub fn level_factors(n_elements: usize) -> Option<Vec<usize>> {
    let mut factors = prime_factors(n_elements);
    while factors.len() + 2 > MAX_LEVELS {
        let first = factors.remove(0);
        factors[0] *= first;
    }
    factors.iter().all(|f| f - 1 <= MAX_KNOTS).then_some(factors)
}

/// Algorithm 3: the next permitted number of knots after `n_knots`, with the parts per level;
/// `None` after the largest.
pub fn next_allowed(n_knots: usize) -> Option<(usize, Vec<usize>)> {
    let largest = (MAX_KNOTS + 1).pow(MAX_LEVELS as u32 - 2);
    (n_knots + 1..largest).find_map(|knots| Some((knots, level_factors(knots + 1)?)))
}

fn prime_factors(mut n: usize) -> Vec<usize> {
    let (mut factors, mut divisor) = (Vec::new(), 2);
    while n > 1 {
        while n.is_multiple_of(divisor) {
            factors.push(divisor);
            n /= divisor;
        }
        divisor = if divisor * divisor > n { n.max(2) } else { divisor + 1 };
    }
    factors
}

/// The data of a surface from which the number of elements of the levels follows, besides the
/// direction that is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SurfaceGrowth {
    /// Elements by which every level reaches beyond the intervals.
    pub growth: usize,
    /// Directions along the surface: 1 of a plane or axisymmetric body, 2 of a solid one.
    pub directions: i32,
}

/// A possible division.
struct Candidate {
    plan: DirectionPlan,
    /// Contact elements of the interval that has fewest.
    n_least: usize,
    /// Estimated number of elements of all levels around the intervals.
    cost: f64,
}

/// Divides one direction so that the ends of all `intervals`, which lie inside the face, lie on
/// knots and each holds `elements` contact elements or some more.
///
/// `breaks`: the distinct knots of the coarse model; `surface`: what a level costs. `None` if the
/// limits of Algorithm 3 leave no division. Every coarse element is divided alike (Fig. 5). Of the
/// divisions that Algorithm 3 permits, those are taken whose knots hit the ends to the tolerance
/// and which hold 16 to 20 elements, and of these the one with the fewest elements over all levels;
/// \[A\] takes the first hit and leaves open how the number of elements is kept. If there is none,
/// up to twice the elements are allowed, and then a larger distance of the ends; the plan says how
/// large it is.
pub fn divide(
    breaks: &[f64],
    intervals: &[[f64; 2]],
    surface: SurfaceGrowth,
    elements: usize,
) -> Option<DirectionPlan> {
    let undivided = std::iter::once((0, Vec::new()));
    let allowed = std::iter::successors(next_allowed(0), |(knots, _)| next_allowed(*knots));
    let most = 2 * elements;
    let mut candidates = Vec::new();
    for (knots, factors) in undivided.chain(allowed) {
        let (Some(snapped), n) = (snap(breaks, intervals, knots + 1), knots + 1) else { continue };
        let fewest = snapped.iter().map(|s| s.count).min().unwrap_or(0);
        if fewest > most && !candidates.is_empty() {
            break; // more parts only make more elements
        }
        candidates.extend(candidate(breaks, &snapped, n, factors, surface, elements));
    }
    let wanted = elements..=((1.0 + EXCESS) * elements as f64) as usize;
    let hits = |c: &&Candidate| c.plan.deviation <= TOLERANCE;
    let cheapest = |a: &&Candidate, b: &&Candidate| a.cost.total_cmp(&b.cost);
    let best = candidates.iter().filter(hits).filter(|c| wanted.contains(&c.n_least)).min_by(cheapest);
    let more = || candidates.iter().filter(hits).filter(|c| c.n_least <= most).min_by(cheapest);
    let nearest = || candidates.iter().min_by(|a, b| a.plan.deviation.total_cmp(&b.plan.deviation));
    best.or_else(more).or_else(nearest).map(|c| c.plan.clone())
}

/// An interval whose ends were moved to knots.
struct Snapped {
    interval: [f64; 2],
    /// Elements of the delimiting level inside.
    count: usize,
    deviation: f64,
    /// How many of its ends are open: no end of the face.
    n_open: usize,
}

/// Moves the ends of intervals to the nearest knots of elements divided into `n` parts; `None` if
/// one vanishes.
fn snap(breaks: &[f64], intervals: &[[f64; 2]], n: usize) -> Option<Vec<Snapped>> {
    let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
    let n_elements = breaks.len() - 1;
    let nearest = |u: f64| {
        let e = breaks.partition_point(|&b| b <= u).clamp(1, n_elements) - 1;
        let (a, b) = (breaks[e], breaks[e + 1]);
        let k = ((u - a) / (b - a) * n as f64).round();
        (e * n + k as usize, a + (b - a) * (k / n as f64))
    };
    let snapped = intervals.iter().map(|&[lower, upper]| {
        let ((from, a), (to, b)) = (nearest(lower), nearest(upper));
        let n_open = usize::from(a > first) + usize::from(b < last);
        let deviation = (a - lower).abs().max((b - upper).abs()) / (upper - lower);
        (to > from).then_some(Snapped { interval: [a, b], count: to - from, deviation, n_open })
    });
    snapped.collect()
}

/// The division into `n` parts spread over `factors`, with a last level that makes the contact
/// elements; `None` if that one would take too many knots.
fn candidate(
    breaks: &[f64],
    snapped: &[Snapped],
    n: usize,
    factors: Vec<usize>,
    surface: SurfaceGrowth,
    elements: usize,
) -> Option<Candidate> {
    let fewest = snapped.iter().map(|s| s.count).min()?;
    let last = elements.div_ceil(fewest);
    if last - 1 > MAX_KNOTS {
        return None;
    }
    let mut parts = factors;
    if last > 1 || parts.is_empty() {
        parts.push(last);
    }
    let divided: usize = parts.iter().product::<usize>() / n;
    let cost = snapped.iter().map(|s| elements_of_levels(s, n, &parts, surface, breaks.len() - 1)).sum();
    let plan = DirectionPlan {
        parts,
        intervals: snapped.iter().map(|s| s.interval).collect(),
        n_elements: snapped.iter().map(|s| s.count * divided).collect(),
        deviation: snapped.iter().map(|s| s.deviation).fold(0.0, f64::max),
    };
    let n_least = fewest * divided;
    Some(Candidate { plan, n_least, cost })
}

/// Elements of all levels around an interval that is as wide in every direction along the surface
/// and half as deep.
fn elements_of_levels(
    s: &Snapped,
    n: usize,
    parts: &[usize],
    surface: SurfaceGrowth,
    n_coarse: usize,
) -> f64 {
    let whole = s.count as f64 / n as f64; // coarse elements
    let half = if s.n_open < 2 { whole } else { 0.5 * whole };
    let (mut scale, mut sum) = (1.0, 0.0);
    for &f in parts {
        let reach = |inside: f64, ends: usize| {
            let inside = (inside * scale).ceil() + (ends * surface.growth) as f64;
            inside.min(n_coarse as f64 * scale) * f as f64
        };
        sum += reach(whole, s.n_open).powi(surface.directions) * reach(half, 1);
        scale *= f as f64;
    }
    sum
}

/// Parts a level of a direction into the depth, so that the sizes of its elements follow those
/// along the surface (theory Eq. A.7): `size` is its coarse element at the contact, `along` the
/// size along the surface after each level \[m\].
pub fn follow(size: f64, along: &[f64]) -> Vec<usize> {
    let mut size = size;
    let mut parts = Vec::with_capacity(along.len());
    for wanted in along {
        let n = ((size / wanted).round() as usize).clamp(1, MAX_KNOTS + 1);
        size /= n as f64;
        parts.push(n);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn curve(growth: usize) -> SurfaceGrowth {
        SurfaceGrowth { growth, directions: 1 }
    }

    fn uniform(n: usize) -> Vec<f64> {
        (0..=n).map(|i| i as f64 / n as f64).collect()
    }

    #[test]
    fn three_knots_spread_over_two_levels_and_two_do_not() {
        // \[A\] Fig. 6: four elements are two times two, three elements are prime.
        assert_eq!(level_factors(4), Some(vec![2, 2]));
        assert_eq!(level_factors(3), Some(vec![3]));
    }

    #[test]
    fn levels_are_merged_from_the_front_as_printed() {
        assert_eq!(level_factors(36), Some(vec![4, 3, 3]));
        assert_eq!(level_factors(32), Some(vec![8, 2, 2]));
        assert_eq!(level_factors(60), Some(vec![4, 3, 5]));
    }

    #[test]
    fn forbidden_numbers_of_knots_are_passed_over() {
        // 12 knots: 13 is prime and above 11. 64 = 2^6 merges to [16, 2, 2]: 15 knots.
        assert_eq!(level_factors(13), None);
        assert_eq!(level_factors(64), None);
        assert_eq!(next_allowed(11), Some((13, vec![2, 7])));
        // 64 is forbidden, 65 = 5 × 13 too.
        assert_eq!(next_allowed(62), Some((65, vec![2, 3, 11])));
        assert_eq!(next_allowed(0), Some((1, vec![2])));
        let all: Vec<usize> =
            std::iter::successors(next_allowed(0), |(k, _)| next_allowed(*k)).map(|c| c.0).collect();
        assert_eq!(all.last(), Some(&1330)); // 11 × 11 × 11 elements
        assert_eq!(next_allowed(1330), None);
    }

    #[test]
    fn every_permitted_division_keeps_its_product_and_limits() {
        for n in 2..=1331 {
            if let Some(factors) = level_factors(n) {
                assert_eq!(factors.iter().product::<usize>(), n);
                assert!(
                    factors.len() <= 3 && factors.iter().all(|&f| (2..=11).contains(&f)),
                    "{n}: {factors:?}"
                );
            }
        }
    }

    #[test]
    fn an_interval_from_the_axis_is_met_to_one_percent() {
        let plan = divide(&uniform(8), &[[0.0, 0.0203]], curve(2), 16).unwrap();
        assert!(plan.deviation <= 0.01, "{plan:?}");
        assert!((16..=20).contains(&plan.n_elements[0]), "{plan:?}");
        assert!(plan.parts.len() <= 4 && plan.parts.iter().all(|&f| f <= 11));
        assert_relative_eq!(plan.intervals[0][0], 0.0);
    }

    #[test]
    fn several_small_steps_are_preferred_to_a_large_one() {
        let plan = divide(&uniform(4), &[[0.25, 0.75]], curve(2), 16).unwrap();
        // 8 parts at once would refine more coarse elements than 2 × 2 × 2.
        assert_eq!((plan.parts.clone(), plan.n_elements[0]), (vec![2, 2, 2], 16));
        assert!(plan.deviation < 1e-14);
    }

    #[test]
    fn two_intervals_share_one_division() {
        let plan = divide(&uniform(10), &[[0.0, 0.03], [0.0, 0.018]], curve(2), 16).unwrap();
        assert!(plan.deviation <= 0.01, "{plan:?}");
        assert!(plan.n_elements[1] >= 16 && plan.n_elements[0] > plan.n_elements[1], "{plan:?}");
    }

    #[test]
    fn intervals_beyond_the_limits_have_no_division() {
        // 11 * 11 * 11 parts with a last level of eleven: 1e-9 of the range would need more.
        assert_eq!(divide(&uniform(4), &[[0.0, 1e-9]], curve(2), 16), None);
    }

    #[test]
    fn depth_follows_the_size_along_the_surface() {
        assert_eq!(follow(8.0, &[2.0, 1.0, 0.25]), vec![4, 2, 4]);
        assert_eq!(follow(100.0, &[2.0, 1.0]), vec![11, 9]);
        assert_eq!(follow(0.1, &[2.0, 1.0, 0.05]), vec![1, 1, 2]);
    }

    proptest! {
        #[test]
        fn intervals_anywhere_are_hit_and_hold_their_elements(
            n in 1usize..12,
            centre in 0.05f64..0.95,
            width in 0.004f64..0.08,
        ) {
            let interval = [(centre - 0.5 * width).max(0.0), (centre + 0.5 * width).min(1.0)];
            let plan = divide(&uniform(n), &[interval], curve(3), 16).unwrap();
            let product: usize = plan.parts.iter().product();
            let h = 1.0 / (n * product) as f64;
            let [a, b] = plan.intervals[0];
            prop_assert!(((b - a) / h - plan.n_elements[0] as f64).abs() < 1e-6, "{:?}", plan);
            prop_assert!(plan.n_elements[0] >= 16, "{:?}", plan);
            prop_assert!(plan.parts.len() <= 4 && plan.parts.iter().all(|&f| f <= 11), "{:?}", plan);
            // Two free ends are not always hit to 1 %: each lies within half an element of the
            // level whose knots delimit the interval.
            let delimiting = h * *plan.parts.last().unwrap() as f64;
            let half = 0.5 * delimiting / (interval[1] - interval[0]);
            prop_assert!(plan.deviation <= half * (1.0 + 1e-9), "{:?}", plan);
        }
    }
}
