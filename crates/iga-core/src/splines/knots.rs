//! Clamped knot vectors: where a spline's pieces meet and how smoothly.
//!
//! A knot vector `Ξ = [ξ_1 … ξ_{n+p+1}]` of degree `p` carries `n` B-splines (theory Eq. S.1). Here
//! it is always clamped: both end knots stand `p + 1` times, so that the end functions interpolate.

use crate::SplineError;

/// Highest degree that the evaluation buffers are laid out for.
pub const MAX_DEGREE: usize = 9;

/// A clamped knot vector of degree `p`, non-decreasing, with interior multiplicities of at most
/// `p`.
#[derive(Debug, Clone, PartialEq)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
    /// Index into `knots` of the last knot of each element's lower break:
    /// `knots[spans[e]] < knots[spans[e] + 1]`.
    spans: Vec<usize>,
}

impl KnotVector {
    /// Checks and takes a full knot vector.
    ///
    /// # Errors
    /// [`SplineError::Degree`] outside `1..=9`; [`SplineError::Knots`] for too few knots, knots that fall or are not finite,
    /// ends that are not repeated `p + 1` times, or an interior knot repeated more than `p` times.
    pub fn new(degree: usize, knots: Vec<f64>) -> Result<Self, SplineError> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(SplineError::Degree { degree, min: 1, max: MAX_DEGREE });
        }
        let fail = |fault: String| Err(SplineError::Knots(fault));
        if knots.len() < 2 * (degree + 1) {
            let least = 2 * (degree + 1);
            return fail(format!("{} knots, degree {degree} needs at least {least}", knots.len()));
        }
        if let Some(index) = knots.iter().position(|u| !u.is_finite()) {
            return fail(format!("knot {index} is {}, it must be finite", knots[index]));
        }
        if let Some(i) = knots.windows(2).position(|w| w[1] < w[0]) {
            return fail(format!(
                "knot {index} = {value} is below its predecessor {before}",
                index = i + 1,
                value = knots[i + 1],
                before = knots[i]
            ));
        }
        let last = knots.len() - 1;
        let runs = runs(&knots);
        if runs.len() < 2 || runs[0] != degree + 1 || runs[runs.len() - 1] != degree + 1 {
            return fail(format!(
                "the end knots {} and {} must each stand {times} times",
                knots[0],
                knots[last],
                times = degree + 1
            ));
        }
        if let Some(&times) = runs[1..runs.len() - 1].iter().find(|&&m| m > degree) {
            return fail(format!("an interior knot stands {times} times, degree {degree} allows {degree}"));
        }
        let spans = (degree..last - degree).filter(|&i| knots[i] < knots[i + 1]).collect();
        Ok(Self { degree, knots, spans })
    }

    /// The smoothest clamped knot vector with the given breaks (strictly rising, at least two).
    ///
    /// # Errors
    /// As [`KnotVector::new`].
    pub fn from_breaks(degree: usize, breaks: &[f64]) -> Result<Self, SplineError> {
        let (Some(&first), Some(&last)) = (breaks.first(), breaks.last()) else {
            return Err(SplineError::Knots("no breaks given".into()));
        };
        if let Some(w) = breaks.windows(2).find(|w| w[0].partial_cmp(&w[1]) != Some(std::cmp::Ordering::Less))
        {
            return Err(SplineError::Knots(format!(
                "break {value} is not above {before}",
                value = w[1],
                before = w[0]
            )));
        }
        let mut knots = vec![first; degree];
        knots.extend_from_slice(breaks);
        knots.extend(std::iter::repeat_n(last, degree));
        Self::new(degree, knots)
    }

    /// `n_elements` equal elements on `[0, 1]`.
    ///
    /// # Errors
    /// As [`KnotVector::new`]; zero elements are an error.
    pub fn uniform(degree: usize, n_elements: usize) -> Result<Self, SplineError> {
        let breaks: Vec<f64> = (0..=n_elements).map(|i| i as f64 / n_elements.max(1) as f64).collect();
        Self::from_breaks(degree, &breaks)
    }

    /// The knot vector of degree `p + by` with the same breaks and the same smoothness at each of
    /// them: every knot stands `by` times more.
    ///
    /// # Errors
    /// [`SplineError::Degree`] beyond the supported range.
    pub fn elevated(&self, by: usize) -> Result<Self, SplineError> {
        let mut knots = Vec::with_capacity(self.knots.len() + by * (self.spans.len() + 1));
        for run in self.knots.chunk_by(|a, b| a.total_cmp(b).is_eq()) {
            knots.extend_from_slice(run);
            knots.extend(std::iter::repeat_n(run[0], by));
        }
        Self::new(self.degree.saturating_add(by), knots)
    }

    /// The knot vector with further knots, in any order, repeated as often as they are listed.
    ///
    /// # Errors
    /// [`SplineError::Knots`] for a knot outside the open range or one that would stand more than `p` times.
    pub fn with_knots(&self, more: &[f64]) -> Result<Self, SplineError> {
        let (a, b) = self.domain();
        if let Some(&knot) = more.iter().find(|&&u| !(u > a && u < b)) {
            return Err(SplineError::Knots(format!("new knot {knot} is not inside ({a}, {b})")));
        }
        let mut knots = self.knots.clone();
        knots.extend_from_slice(more);
        knots.sort_by(f64::total_cmp);
        Self::new(self.degree, knots)
    }

    /// The same functions over `[0, 1]`.
    ///
    /// # Errors
    /// [`SplineError::Knots`] if knots become one by round-off.
    pub fn over_unit_range(&self) -> Result<Self, SplineError> {
        let (a, b) = self.domain();
        Self::new(self.degree, self.knots.iter().map(|u| (u - a) / (b - a)).collect())
    }

    /// The same functions in reverse order, over the same range.
    ///
    /// # Errors
    /// [`SplineError::Knots`] if knots become one by round-off.
    pub fn reversed(&self) -> Result<Self, SplineError> {
        let (a, b) = self.domain();
        // The ends to the bit, what lies between by its share of the range.
        let mirrored = |u: &f64| if *u >= b { a } else { b - (u - a) };
        Self::new(self.degree, self.knots.iter().rev().map(mirrored).collect())
    }

    /// Degree `p`.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All knots with their repetitions.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Number `n` of B-splines.
    pub fn n_functions(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// First and last knot.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// Number of non-empty knot spans.
    pub fn n_elements(&self) -> usize {
        self.spans.len()
    }

    /// Distinct knots, rising.
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots.clone();
        breaks.dedup();
        breaks
    }

    /// Lower and upper end of element `e`.
    pub fn element(&self, e: usize) -> (f64, f64) {
        let s = self.spans[e];
        (self.knots[s], self.knots[s + 1])
    }

    /// Span index `s` of element `e`: the functions `s - p ..= s` are active there.
    pub fn element_span(&self, e: usize) -> usize {
        self.spans[e]
    }

    /// The element that holds `u`: half-open intervals, the last one closed; values outside are
    /// clamped to the ends.
    pub fn find_element(&self, u: f64) -> usize {
        self.spans.partition_point(|&s| self.knots[s] <= u).saturating_sub(1)
    }

    /// How often `u` stands in the knot vector.
    pub fn multiplicity(&self, u: f64) -> usize {
        let below = self.knots.partition_point(|&k| k < u);
        let up_to = self.knots.partition_point(|&k| k <= u);
        up_to - below
    }

    /// Greville abscissae: the mean of the `p` inner knots of each function (theory Eq. S.3).
    pub fn greville(&self) -> Vec<f64> {
        let p = self.degree;
        (0..self.n_functions()).map(|i| self.knots[i + 1..=i + p].iter().sum::<f64>() / p as f64).collect()
    }

    /// Whether every interior knot is simple, so that the spline is `C^(p-1)` throughout.
    pub fn is_smooth(&self) -> bool {
        self.knots.len() == 2 * self.degree + self.spans.len() + 1
    }
}

/// Lengths of the runs of equal values.
fn runs(values: &[f64]) -> Vec<usize> {
    values.chunk_by(|a, b| a.total_cmp(b).is_eq()).map(<[f64]>::len).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_agree_for_every_degree() {
        for p in 1..=MAX_DEGREE {
            let k = KnotVector::uniform(p, 5).unwrap();
            assert_eq!((k.n_functions(), k.n_elements(), k.is_smooth()), (p + 5, 5, true));
            assert_eq!(k.greville().len(), k.n_functions());
            assert_eq!(k.find_element(0.0), 0);
            assert_eq!(k.find_element(0.2), 1);
            assert_eq!(k.find_element(1.0), 4);
            assert_eq!(k.find_element(7.0), 4);
        }
    }

    #[test]
    fn impossible_knots_are_refused_with_the_reason() {
        for (p, knots, word) in [
            (2, vec![0.0, 0.0, 1.0, 1.0], "needs at least"),
            (1, vec![0.0, 0.0, f64::NAN, 1.0, 1.0], "finite"),
            (1, vec![0.0, 0.0, 0.7, 0.3, 1.0, 1.0], "below"),
            (2, vec![0.0, 0.0, 0.5, 1.0, 1.0, 1.0], "end knots"),
            (1, vec![0.0, 0.0, 0.5, 0.5, 1.0, 1.0], "interior"),
            (1, vec![0.0; 4], "end knots"),
        ] {
            let text = KnotVector::new(p, knots).unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        }
        assert!(matches!(KnotVector::new(0, vec![0.0, 1.0]), Err(SplineError::Degree { .. })));
    }
}
