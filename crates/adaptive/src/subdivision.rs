//! How the elements around a contact interval are divided, level by level (\[A\] Algorithm 3, Figs. 5, 6; theory section A.2).
//!
//! Works on the breaks of one parametric direction at a time; neither geometry nor functions are needed. What the levels do to
//! a space is [`crate::fine_model`]'s part.

use thiserror::Error;

/// Limits of the division.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubdivisionLimits {
    /// Largest number of levels, the coarse one and the one of contact elements included.
    pub max_levels: usize,
    /// Largest number of knots inserted into an element from one level to the next.
    pub max_knots: usize,
    /// Distance of an end of an interval from its knot, as a share of the width.
    pub tolerance: f64,
    /// Elements inside an interval.
    pub elements: usize,
    /// More elements than wanted, as a share, before a division is passed over.
    pub excess: f64,
}

impl Default for SubdivisionLimits {
    /// The values of \[A\] section 4.3; 16 elements cannot be had everywhere, up to 20 are taken.
    fn default() -> Self {
        Self { max_levels: 5, max_knots: 10, tolerance: 0.01, elements: 16, excess: 0.25 }
    }
}

impl SubdivisionLimits {
    /// The values of \[A\] for bodies of two directions. On a solid body a level that splits elements in two costs least, as every
    /// level reaches beyond the interval by whole elements of the one before, on all sides: up to nine levels are taken.
    pub fn for_dimension(dimension: usize) -> Self {
        Self { max_levels: if dimension > 2 { 9 } else { 5 }, ..Self::default() }
    }
}

/// Why no division was found.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SubdivisionError {
    /// An interval that is none.
    #[error("contact interval from {lower} to {upper} is not inside the parameters {first} to {last}")]
    Interval {
        /// Lower end.
        lower: f64,
        /// Upper end.
        upper: f64,
        /// First parameter of the face.
        first: f64,
        /// Last one.
        last: f64,
    },
    /// The limits leave no division.
    #[error(
        "no division of elements of size {element:.3e} resolves a contact interval of {width:.3e} with {levels} levels and {knots} knots a level; refine the coarse model near the contact"
    )]
    TooSmall {
        /// Size of the coarse elements.
        element: f64,
        /// Width of the narrowest interval.
        width: f64,
        /// Permitted levels.
        levels: usize,
        /// Permitted knots a level.
        knots: usize,
    },
    /// The elements of a solid body would have to be halved more often than permitted.
    #[error(
        "a contact interval of {width:.3e} m needs {needed} levels of refinement, {allowed} are allowed; raise interval.max_levels or refine the coarse model near the contact"
    )]
    TooManyLevels {
        /// Levels needed.
        needed: usize,
        /// Permitted levels.
        allowed: usize,
        /// Width of the interval \[m\].
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

/// Lines 3 to 9 of Algorithm 3: the levels over which `n_elements` parts are spread, or `None` if the limits forbid it.
///
/// The prime factors, ascending; the two first ones are merged until the levels are few enough.
pub fn level_factors(n_elements: usize, limits: &SubdivisionLimits) -> Option<Vec<usize>> {
    let mut factors = prime_factors(n_elements);
    while factors.len() > 1 && factors.len() + 2 > limits.max_levels {
        let first = factors.remove(0);
        factors[0] *= first;
    }
    let fits =
        factors.len() + 2 <= limits.max_levels.max(2) && factors.iter().all(|f| f - 1 <= limits.max_knots);
    fits.then_some(factors)
}

/// Algorithm 3: the next permitted number of knots after `n_knots`, with the parts a level; `None` after the largest.
pub fn next_allowed(n_knots: usize, limits: &SubdivisionLimits) -> Option<(usize, Vec<usize>)> {
    let levels = limits.max_levels.saturating_sub(2) as u32;
    let largest = (limits.max_knots + 1).saturating_pow(levels);
    (n_knots + 1..largest).find_map(|knots| Some((knots, level_factors(knots + 1, limits)?)))
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

/// What the levels cost beside the direction that is divided.
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

/// Divides one direction so that the ends of all `intervals` lie on knots and each holds the wanted number of elements.
///
/// `breaks`: the distinct knots of the coarse model; `surface`: what a level costs.
/// Every coarse element is divided alike (Fig. 5). Of the divisions that Algorithm 3 permits, those are taken whose knots hit
/// the ends to the tolerance and which hold 16 to 20 elements, and of these the one with the fewest elements over all levels;
/// \[A\] takes the first hit and leaves open how the number of elements is kept. If there is none, up to twice the
/// elements are allowed, and then a larger distance of the ends; the plan says how large it is.
///
/// # Errors
/// [`SubdivisionError`] for impossible intervals, or if the levels cannot resolve them.
pub fn divide(
    breaks: &[f64],
    intervals: &[[f64; 2]],
    surface: SurfaceGrowth,
    limits: &SubdivisionLimits,
) -> Result<DirectionPlan, SubdivisionError> {
    let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
    for &[lower, upper] in intervals {
        if !(first <= lower && lower < upper && upper <= last) {
            return Err(SubdivisionError::Interval { lower, upper, first, last });
        }
    }
    let undivided = std::iter::once((0, Vec::new()));
    let allowed = std::iter::successors(next_allowed(0, limits), |(knots, _)| next_allowed(*knots, limits));
    let most = 2 * limits.elements;
    let mut candidates = Vec::new();
    for (knots, factors) in undivided.chain(allowed) {
        let (Some(snapped), n) = (snap(breaks, intervals, knots + 1), knots + 1) else { continue };
        let fewest = snapped.iter().map(|s| s.count).min().unwrap_or(0);
        if fewest > most && !candidates.is_empty() {
            break; // more parts only make more elements
        }
        candidates.extend(candidate(breaks, &snapped, n, factors, surface, limits));
    }
    let wanted = limits.elements..=((1.0 + limits.excess) * limits.elements as f64) as usize;
    let hits = |c: &&Candidate| c.plan.deviation <= limits.tolerance;
    let cheapest = |a: &&Candidate, b: &&Candidate| a.cost.total_cmp(&b.cost);
    let best = candidates.iter().filter(hits).filter(|c| wanted.contains(&c.n_least)).min_by(cheapest);
    let more = || candidates.iter().filter(hits).filter(|c| c.n_least <= most).min_by(cheapest);
    let nearest = || candidates.iter().min_by(|a, b| a.plan.deviation.total_cmp(&b.plan.deviation));
    best.or_else(more)
        .or_else(nearest)
        .map(|c| c.plan.clone())
        .ok_or_else(|| too_small(breaks, intervals, limits))
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

/// Moves the ends of intervals to the nearest knots of elements divided into `n` parts; `None` if one vanishes.
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

/// The division into `n` parts spread over `factors`, with a last level that makes the contact elements; `None` if that one
/// would take too many knots.
fn candidate(
    breaks: &[f64],
    snapped: &[Snapped],
    n: usize,
    factors: Vec<usize>,
    surface: SurfaceGrowth,
    limits: &SubdivisionLimits,
) -> Option<Candidate> {
    let fewest = snapped.iter().map(|s| s.count).min()?;
    let last = limits.elements.div_ceil(fewest);
    if last - 1 > limits.max_knots {
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

/// Elements of all levels around an interval that is as wide in every direction along the surface and half as deep.
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

fn too_small(breaks: &[f64], intervals: &[[f64; 2]], limits: &SubdivisionLimits) -> SubdivisionError {
    let element = breaks.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
    let width = intervals.iter().map(|[a, b]| b - a).fold(f64::INFINITY, f64::min);
    SubdivisionError::TooSmall { element, width, levels: limits.max_levels, knots: limits.max_knots }
}

/// Parts a level of a direction into the depth, so that the sizes of its elements follow those along the surface (theory
/// Eq. A.4): `size` is its coarse element at the contact, `along` the size along the surface after each level \[m\].
pub fn follow(size: f64, along: &[f64], limits: &SubdivisionLimits) -> Vec<usize> {
    let mut size = size;
    let mut parts = Vec::with_capacity(along.len());
    for wanted in along {
        let n = ((size / wanted).round() as usize).clamp(1, limits.max_knots + 1);
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

    fn limits() -> SubdivisionLimits {
        SubdivisionLimits::default()
    }

    fn curve(growth: usize) -> SurfaceGrowth {
        SurfaceGrowth { growth, directions: 1 }
    }

    fn uniform(n: usize) -> Vec<f64> {
        (0..=n).map(|i| i as f64 / n as f64).collect()
    }

    #[test]
    fn three_knots_spread_over_two_levels_and_two_do_not() {
        // \[A\] Fig. 6: four elements are two times two, three elements are prime.
        assert_eq!(level_factors(4, &limits()), Some(vec![2, 2]));
        assert_eq!(level_factors(3, &limits()), Some(vec![3]));
    }

    #[test]
    fn levels_are_merged_from_the_front_as_printed() {
        assert_eq!(level_factors(36, &limits()), Some(vec![4, 3, 3]));
        assert_eq!(level_factors(32, &limits()), Some(vec![8, 2, 2]));
        assert_eq!(level_factors(60, &limits()), Some(vec![4, 3, 5]));
    }

    #[test]
    fn forbidden_numbers_of_knots_are_passed_over() {
        // 12 knots: 13 is prime and above 11. 64 = 2^6 merges to [16, 2, 2]: 15 knots.
        assert_eq!(level_factors(13, &limits()), None);
        assert_eq!(level_factors(64, &limits()), None);
        assert_eq!(next_allowed(11, &limits()), Some((13, vec![2, 7])));
        // 64 is forbidden, 65 = 5 × 13 too.
        assert_eq!(next_allowed(62, &limits()), Some((65, vec![2, 3, 11])));
        assert_eq!(next_allowed(0, &limits()), Some((1, vec![2])));
        let all: Vec<usize> =
            std::iter::successors(next_allowed(0, &limits()), |(k, _)| next_allowed(*k, &limits()))
                .map(|c| c.0)
                .collect();
        assert_eq!(all.last(), Some(&1330)); // 11 × 11 × 11 elements
        assert_eq!(next_allowed(1330, &limits()), None);
    }

    #[test]
    fn every_permitted_division_keeps_its_product_and_limits() {
        for n in 2..=1331 {
            if let Some(factors) = level_factors(n, &limits()) {
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
        let plan = divide(&uniform(8), &[[0.0, 0.0203]], curve(2), &limits()).unwrap();
        assert!(plan.deviation <= 0.01, "{plan:?}");
        assert!((16..=20).contains(&plan.n_elements[0]), "{plan:?}");
        assert!(plan.parts.len() <= 4 && plan.parts.iter().all(|&f| f <= 11));
        assert_relative_eq!(plan.intervals[0][0], 0.0);
    }

    #[test]
    fn several_small_steps_are_preferred_to_a_large_one() {
        let plan = divide(&uniform(4), &[[0.25, 0.75]], curve(2), &limits()).unwrap();
        // 8 parts at once would refine more coarse elements than 2 × 2 × 2.
        assert_eq!((plan.parts.clone(), plan.n_elements[0]), (vec![2, 2, 2], 16));
        assert!(plan.deviation < 1e-14);
    }

    #[test]
    fn two_intervals_share_one_division() {
        let plan = divide(&uniform(10), &[[0.0, 0.03], [0.0, 0.018]], curve(2), &limits()).unwrap();
        assert!(plan.deviation <= 0.01, "{plan:?}");
        assert!(plan.n_elements[1] >= 16 && plan.n_elements[0] > plan.n_elements[1], "{plan:?}");
    }

    #[test]
    fn impossible_intervals_are_errors() {
        let coarse = uniform(4);
        for bad in [[0.5, 0.5], [0.6, 0.5], [-0.1, 0.2], [0.9, 1.1], [f64::NAN, 0.5]] {
            assert!(matches!(
                divide(&coarse, &[bad], curve(2), &limits()),
                Err(SubdivisionError::Interval { .. })
            ));
        }
        let tiny = divide(&coarse, &[[0.0, 1e-9]], curve(2), &limits()).unwrap_err();
        assert!(tiny.to_string().contains("refine the coarse model"), "{tiny}");
    }

    #[test]
    fn depth_follows_the_size_along_the_surface() {
        assert_eq!(follow(8.0, &[2.0, 1.0, 0.25], &limits()), vec![4, 2, 4]);
        assert_eq!(follow(100.0, &[2.0, 1.0], &limits()), vec![11, 9]);
        assert_eq!(follow(0.1, &[2.0, 1.0, 0.05], &limits()), vec![1, 1, 2]);
    }

    proptest! {
        #[test]
        fn intervals_anywhere_are_hit_and_hold_their_elements(
            n in 1usize..12,
            centre in 0.05f64..0.95,
            width in 0.004f64..0.08,
        ) {
            let interval = [(centre - 0.5 * width).max(0.0), (centre + 0.5 * width).min(1.0)];
            let plan = divide(&uniform(n), &[interval], curve(3), &limits()).unwrap();
            let product: usize = plan.parts.iter().product();
            let h = 1.0 / (n * product) as f64;
            let [a, b] = plan.intervals[0];
            prop_assert!(((b - a) / h - plan.n_elements[0] as f64).abs() < 1e-6, "{:?}", plan);
            prop_assert!(plan.n_elements[0] >= 16, "{:?}", plan);
            prop_assert!(plan.parts.len() <= 4 && plan.parts.iter().all(|&f| f <= 11), "{:?}", plan);
            // Two free ends are not always hit to 1 %; half an element of the delimiting level is the worst.
            prop_assert!(plan.deviation <= 0.06, "{:?}", plan);
        }
    }
}
