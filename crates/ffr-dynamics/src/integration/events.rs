//! Zeros of functions along the dense output (docs/theory.md Eq. T.6).

use super::dense_output::DenseOutput;
use crate::error::{DynamicsError, IntegrationFault};

/// Golden section.
const GOLDEN: f64 = 0.381_966_011_250_105_1;
/// Distance of the slope probe from the end of a sample interval, as a share of it.
const PROBE: f64 = 1e-3;
/// Bisections and secant steps after which the bracket has long reached round-off.
const MAX_ITERATIONS: usize = 200;
/// Golden-section steps in search of a hidden dip: 0.618^24 narrows the bracket to 1e-5 of a sample
/// interval.
const MAX_DIP_ITERATIONS: usize = 24;

/// A zero of a scalar function of time and state, passed from positive to negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Latest time known to lie before the zero \[s\]; the function is positive here.
    pub before: f64,
    /// Time at which the function is zero or negative, within the tolerance of the zero \[s\].
    pub time: f64,
    /// Value of the function at [`Crossing::time`].
    pub value: f64,
}

/// How fast a function may fall: by less than `fastest` times the time, and `jump` at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Its largest rate [1/s].
    pub fastest: f64,
    /// What it may change by besides.
    pub jump: f64,
}

impl Slope {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self { fastest: f64::INFINITY, jump: 0.0 };

    /// Whether a function is positive between two samples.
    fn keeps_positive(&self, left: Sample, right: Sample) -> bool {
        0.5 * (left.1 + right.1 - self.fastest * (right.0 - left.0)) > self.jump
    }
}

/// Search for the first zero within a step. Keeps its buffers, so that a search allocates nothing.
#[derive(Debug, Clone)]
pub struct CrossingSearch {
    tolerance: f64,
    n_samples: usize,
    y: Vec<f64>,
}

impl CrossingSearch {
    /// A search in states with `dimension` components that finds the zero within `tolerance` \[s\].
    ///
    /// Each step is sampled at `n_samples` equal intervals (at least 1); between samples a dip of
    /// the function is followed to its bottom, so that two zeros between two samples are seen as
    /// well.
    ///
    /// # Panics
    /// If the tolerance is negative or not a number.
    pub fn new(dimension: usize, tolerance: f64, n_samples: usize) -> Self {
        assert!(tolerance >= 0.0, "the tolerance is not negative");
        Self { tolerance, n_samples: n_samples.max(1), y: vec![0.0; dimension] }
    }

    /// State at the last evaluation; after a found crossing, the state at its time.
    pub fn state(&self) -> &[f64] {
        &self.y
    }

    /// First time in the last step at which `function` turns from positive to zero or negative.
    ///
    /// A function that is zero or negative from the start of the step has no crossing until it has
    /// been positive.
    ///
    /// # Errors
    /// [`DynamicsError::Integration`] if the function is not a number somewhere.
    pub fn first_crossing(
        &mut self,
        solution: &impl DenseOutput,
        mut function: impl FnMut(f64, &[f64]) -> f64,
    ) -> Result<Option<Crossing>, DynamicsError> {
        self.first_crossing_of(solution.interval(), Slope::UNKNOWN, |t, _, y| {
            solution.interpolate(t, y);
            function(t, y)
        })
    }

    /// How many instants every search in a step may look at, whatever it finds there.
    pub fn n_instants(&self) -> usize {
        self.n_samples + 3
    }

    /// As [`CrossingSearch::first_crossing`] in the time `interval` of a `function` that has the number of the instant
    /// if it is one of those that every search in the step looks at, below [`CrossingSearch::n_instants`], so that many
    /// functions are evaluated there together. Its last argument is a state to work on. Where the `slope` of the function tells
    /// that it stays positive between two samples nothing is looked for.
    ///
    /// # Errors
    /// Likewise.
    pub fn first_crossing_of(
        &mut self,
        (start, end): (f64, f64),
        slope: Slope,
        mut function: impl FnMut(f64, Option<usize>, &mut [f64]) -> f64,
    ) -> Result<Option<Crossing>, DynamicsError> {
        let n = self.n_samples;
        let time = |i: usize| if i == n { end } else { start + (end - start) * (i as f64 / n as f64) };
        let mut evaluate = Evaluation { n, slope, function: &mut function, y: &mut self.y };
        let mut older = None;
        let mut left = (start, evaluate.of(start, Some(0))?);
        for i in 1..=n {
            let right = (time(i), evaluate.of(time(i), Some(i))?);
            let hidden = evaluate.hidden_dip(left, right, i == 1, i == n)?;
            if let Some(bracket) = hidden.or(evaluate.bracket(older, left, right)?) {
                return evaluate.refine(bracket, self.tolerance).map(Some);
            }
            older = Some(left);
            left = right;
        }
        Ok(None)
    }
}

/// A time and the function there.
type Sample = (f64, f64);

struct Evaluation<'a, F> {
    n: usize,
    slope: Slope,
    function: &'a mut F,
    y: &'a mut [f64],
}

impl<F: FnMut(f64, Option<usize>, &mut [f64]) -> f64> Evaluation<'_, F> {
    fn at(&mut self, t: f64) -> Result<f64, DynamicsError> {
        self.of(t, None)
    }

    /// The function at time `t`, which is instant `number` of every search.
    fn of(&mut self, t: f64, number: Option<usize>) -> Result<f64, DynamicsError> {
        let value = (self.function)(t, number, self.y);
        if value.is_nan() {
            return Err(DynamicsError::Integration { time: t, fault: IntegrationFault::WatchedFunction });
        }
        Ok(value)
    }

    /// A dip below zero in the first or last interval of a step that no third sample reveals, only
    /// the slope at its end.
    fn hidden_dip(
        &mut self,
        left: Sample,
        right: Sample,
        is_first: bool,
        is_last: bool,
    ) -> Result<Option<(Sample, Sample)>, DynamicsError> {
        if left.1 <= 0.0 || right.1 <= 0.0 || self.slope.keeps_positive(left, right) {
            return Ok(None);
        }
        let width = right.0 - left.0;
        let falls =
            is_first && right.1 >= left.1 && self.of(left.0 + PROBE * width, Some(self.n + 1))? < left.1;
        let rises =
            is_last && right.1 < left.1 && self.of(right.0 - PROBE * width, Some(self.n + 2))? < right.1;
        if falls || rises { self.dip(left, right) } else { Ok(None) }
    }

    /// A change of sign between `left` and `right`, or in a dip around `left`.
    fn bracket(
        &mut self,
        older: Option<Sample>,
        left: Sample,
        right: Sample,
    ) -> Result<Option<(Sample, Sample)>, DynamicsError> {
        if let Some(older) = older
            && left.1 > 0.0
            && left.1 <= older.1
            && left.1 <= right.1
            && !(self.slope.keeps_positive(older, left) && self.slope.keeps_positive(left, right))
            && let Some(found) = self.dip(older, right)?
        {
            return Ok(Some(found));
        }
        Ok((left.1 > 0.0 && right.1 <= 0.0).then_some((left, right)))
    }

    /// Golden-section descent between two positive samples until the function is not positive.
    fn dip(&mut self, left: Sample, right: Sample) -> Result<Option<(Sample, Sample)>, DynamicsError> {
        if left.1 <= 0.0 || right.1 <= 0.0 {
            return Ok(None);
        }
        let (mut a, mut b) = (left, right);
        let mut t = a.0 + GOLDEN * (b.0 - a.0);
        let mut middle = (t, self.at(t)?);
        for _ in 0..MAX_DIP_ITERATIONS {
            if middle.1 <= 0.0 {
                return Ok(Some((left, middle)));
            }
            if self.slope.keeps_positive(a, middle) && self.slope.keeps_positive(middle, b) {
                return Ok(None);
            }
            let into_right = b.0 - middle.0 > middle.0 - a.0;
            t = if into_right {
                middle.0 + GOLDEN * (b.0 - middle.0)
            } else {
                middle.0 - GOLDEN * (middle.0 - a.0)
            };
            let new = (t, self.at(t)?);
            let is_lower = new.1 < middle.1;
            let (outer_left, outer_right) = if into_right { (middle, new) } else { (new, middle) };
            if is_lower == into_right {
                a = outer_left;
            } else {
                b = outer_right;
            }
            if is_lower {
                middle = new;
            }
        }
        Ok((middle.1 <= 0.0).then_some((left, middle)))
    }

    /// Regula falsi (Illinois) with bisection whenever it gains too little; the sign change stays
    /// bracketed.
    fn refine(
        &mut self,
        (mut a, mut b): (Sample, Sample),
        tolerance: f64,
    ) -> Result<Crossing, DynamicsError> {
        let tolerance = tolerance.max(4.0 * f64::EPSILON * a.0.abs().max(b.0.abs()));
        let (mut weight_a, mut weight_b) = (a.1, b.1);
        let mut was_left = None;
        for iteration in 0..MAX_ITERATIONS {
            let width = b.0 - a.0;
            if width <= tolerance {
                break;
            }
            let secant = a.0 + width * weight_a / (weight_a - weight_b);
            // Step past the estimate by a part of the tolerance: both ends then close in together.
            let guard = 0.5 * tolerance.min(width);
            let is_bisection = iteration % 3 == 2;
            let t = if is_bisection { 0.5 * (a.0 + b.0) } else { secant.clamp(a.0 + guard, b.0 - guard) };
            let new = (t, self.at(t)?);
            if new.1 > 0.0 {
                (a, weight_a) = (new, new.1);
                weight_b *= if was_left == Some(true) { 0.5 } else { 1.0 };
                was_left = Some(true);
            } else {
                (b, weight_b) = (new, new.1);
                weight_a *= if was_left == Some(false) { 0.5 } else { 1.0 };
                was_left = Some(false);
            }
        }
        let value = self.at(b.0)?; // leaves the state at the crossing in the buffer
        Ok(Crossing { before: a.0, time: b.0, value })
    }
}
