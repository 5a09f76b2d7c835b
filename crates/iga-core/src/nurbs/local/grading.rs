//! Element sizes along one direction: uniform, finer in windows, growing geometrically in between.
//!
//! The wanted size is `h(u) = min(h_uniform, h_w + ln(ratio) dist(u, window w))`. Between fixed
//! points (ends, existing breaks, window ends) the breaks share `∫ du / h` equally (theory
//! Eq. S.8): inside a window the elements are equal, beyond it each is `ratio` times its neighbour,
//! and every fixed point is met exactly.

use crate::SplineError;

/// Most elements that one direction may get: a guard against slips of a decimal point.
pub const MAX_ELEMENTS: usize = 20_000;

/// A parametric interval with finer elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Lower end; may lie beyond the range.
    pub lower: f64,
    /// Upper end, above the lower one; may lie beyond the range.
    pub upper: f64,
    /// Number of equal elements between the two ends. What lies beyond the range is cut off, the
    /// size stays.
    pub elements: usize,
    /// Growth of the element size from one element to the next outside the window, >= 1.
    pub ratio: f64,
}

/// The wanted elements of one direction.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Grading {
    /// Number of elements without windows; existing breaks are kept, so there are never fewer than
    /// they ask for.
    pub elements: usize,
    /// Windows of finer elements; where they overlap the finest counts.
    pub windows: Vec<Window>,
}

/// A length that varies linearly: `value + slope * (u - origin)` on a piece of the line.
#[derive(Debug, Clone, Copy)]
struct Piece {
    start: f64,
    end: f64,
    size_at_start: f64,
    slope: f64,
}

impl Piece {
    /// `∫ du / h` over the piece.
    fn elements(&self) -> f64 {
        let length = self.end - self.start;
        if self.slope.abs() * length < 1e-12 * self.size_at_start {
            return length / self.size_at_start;
        }
        (self.slope * length / self.size_at_start).ln_1p() / self.slope
    }

    /// Where `∫ du / h` from the start reaches `count`.
    fn position(&self, count: f64) -> f64 {
        let rise = self.slope * count;
        let step = if rise.abs() < 1e-12 { count } else { rise.exp_m1() / self.slope };
        (self.start + self.size_at_start * step).min(self.end)
    }
}

impl Grading {
    /// `elements` equal elements.
    pub fn uniform(elements: usize) -> Self {
        Self { elements, windows: Vec::new() }
    }

    /// All breaks of the direction: `existing` (rising, both ends included) and the new ones.
    ///
    /// # Errors
    /// [`SplineError::Dimension`] for no elements, a window without elements or width, a ratio below 1, numbers that are not
    /// finite, or more than [`MAX_ELEMENTS`]; [`SplineError::Knots`] if `existing` has fewer than
    /// two breaks.
    pub fn breaks(&self, existing: &[f64]) -> Result<Vec<f64>, SplineError> {
        if existing.len() < 2 {
            return Err(SplineError::Knots(format!("{} breaks, two are needed", existing.len())));
        }
        let range = existing[existing.len() - 1] - existing[0];
        self.check(range)?;
        let counts = share_elements(existing, self.elements);
        let mut breaks = vec![existing[0]];
        for (span, &n) in existing.windows(2).zip(&counts) {
            let uniform = (span[1] - span[0]) / n as f64;
            for part in self.fixed_points(span).windows(2) {
                self.fill(part[0], part[1], uniform, &mut breaks)?;
            }
        }
        Ok(breaks)
    }

    fn check(&self, range: f64) -> Result<(), SplineError> {
        let fail = |name, value, reason| Err(SplineError::Dimension { name, value, reason });
        if self.elements == 0 || self.elements > MAX_ELEMENTS {
            return fail("elements", self.elements as f64, "must be between 1 and 20000 per direction");
        }
        for w in &self.windows {
            let width = w.upper - w.lower;
            // Narrower windows could not be told apart from a point in double precision.
            if !(width.is_finite() && width > 1e-12 * range) {
                return fail("half_width", 0.5 * width, "the refined window must have a width");
            }
            if w.elements == 0 || w.elements > MAX_ELEMENTS {
                return fail("elements", w.elements as f64, "must be between 1 and 20000 in a window");
            }
            if !(w.ratio.is_finite() && w.ratio >= 1.0) {
                return fail("ratio", w.ratio, "the growth of element sizes must be at least 1");
            }
        }
        Ok(())
    }

    /// Ends of the span and the window ends in it, finest windows first; an end nearer than half an
    /// element to a fixed point is given up.
    fn fixed_points(&self, span: &[f64]) -> Vec<f64> {
        let mut windows = self.windows.clone();
        windows.sort_by(|a, b| a.size().total_cmp(&b.size()));
        let mut points = span.to_vec();
        for w in &windows {
            for end in [w.lower, w.upper] {
                let free = |p: &f64| (p - end).abs() > 0.5 * w.size();
                if end > span[0] && end < span[1] && points.iter().all(free) {
                    points.push(end);
                }
            }
        }
        points.sort_by(f64::total_cmp);
        points
    }

    /// Appends the breaks in `(a, b]`.
    fn fill(&self, a: f64, b: f64, uniform: f64, breaks: &mut Vec<f64>) -> Result<(), SplineError> {
        let pieces = self.pieces(a, b, uniform);
        let total: f64 = pieces.iter().map(Piece::elements).sum();
        if total + breaks.len() as f64 > MAX_ELEMENTS as f64 {
            return Err(SplineError::Dimension {
                name: "elements",
                value: total.round(),
                reason: "must not exceed 20000 per direction with the refined windows",
            });
        }
        // A tenth of an element is no reason for one more: the sizes are wishes.
        let n = (total - 0.1).ceil().max(1.0) as usize;
        let mut piece = 0;
        let mut before = 0.0;
        for i in 1..n {
            if pieces.len() == 1 && pieces[0].slope == 0.0 {
                breaks.push(a + (b - a) * (i as f64 / n as f64));
                continue;
            }
            let target = total * (i as f64 / n as f64);
            while piece + 1 < pieces.len() && before + pieces[piece].elements() <= target {
                before += pieces[piece].elements();
                piece += 1;
            }
            breaks.push(pieces[piece].position(target - before));
        }
        breaks.push(b);
        Ok(())
    }

    /// The wanted size on `[a, b]`: lower envelope of straight lines.
    fn pieces(&self, a: f64, b: f64, uniform: f64) -> Vec<Piece> {
        let mut lines = vec![(uniform, 0.0)]; // size at a, slope
        let middle = 0.5 * (a + b);
        for w in &self.windows {
            let growth = w.ratio.ln();
            lines.push(if middle < w.lower {
                (w.size() + growth * (w.lower - a).max(0.0), -growth)
            } else if middle > w.upper {
                (w.size() + growth * (a - w.upper).max(0.0), growth)
            } else {
                (w.size(), 0.0)
            });
        }
        let mut cuts = vec![0.0, b - a];
        for (i, &(size, slope)) in lines.iter().enumerate() {
            for &(other, other_slope) in &lines[..i] {
                let at = (other - size) / (slope - other_slope);
                if at > 0.0 && at < b - a {
                    cuts.push(at);
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        let mut pieces = Vec::with_capacity(cuts.len());
        for cut in cuts.windows(2).filter(|c| c[1] > c[0]) {
            let centre = 0.5 * (cut[0] + cut[1]);
            let at = |line: &(f64, f64), u: f64| line.0 + line.1 * u;
            let lowest = lines.iter().min_by(|x, y| at(x, centre).total_cmp(&at(y, centre)));
            let line = lowest.copied().unwrap_or((uniform, 0.0));
            pieces.push(Piece {
                start: a + cut[0],
                end: a + cut[1],
                size_at_start: at(&line, cut[0]),
                slope: line.1,
            });
        }
        pieces
    }
}

impl Window {
    /// Element size in the window.
    pub fn size(&self) -> f64 {
        (self.upper - self.lower) / self.elements as f64
    }
}

/// Distributes `n` elements over the spans between `breaks` by length, at least one each.
fn share_elements(breaks: &[f64], n: usize) -> Vec<usize> {
    let mut counts = vec![1; breaks.len() - 1];
    for _ in counts.len()..n {
        // The span with the longest elements gets the next one; ties go to the first.
        let length = |k: usize| (breaks[k + 1] - breaks[k]) / counts[k] as f64;
        let mut longest = 0;
        for k in 1..counts.len() {
            if length(k) > length(longest) * (1.0 + 1e-12) {
                longest = k;
            }
        }
        counts[longest] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(breaks: &[f64]) -> Vec<f64> {
        breaks.windows(2).map(|w| w[1] - w[0]).collect()
    }

    #[test]
    fn uniform_breaks_are_equal_and_keep_existing_ones() {
        assert_eq!(Grading::uniform(4).breaks(&[0.0, 1.0]).unwrap(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(Grading::uniform(1).breaks(&[0.0, 0.5, 1.0]).unwrap(), [0.0, 0.5, 1.0]);
        assert_eq!(Grading::uniform(3).breaks(&[0.0, 0.5, 1.0]).unwrap(), [0.0, 0.25, 0.5, 1.0]);
        assert_eq!(Grading::uniform(8).breaks(&[0.0, 0.25, 1.0]).unwrap().len(), 9);
    }

    #[test]
    fn windows_hold_equal_elements_and_grow_outside_by_the_ratio() {
        for at in [0.0, 0.013, 0.3, 0.5, 0.99, 1.0] {
            let window = Window { lower: at - 0.01, upper: at + 0.01, elements: 16, ratio: 1.4 };
            let grading = Grading { elements: 10, windows: vec![window] };
            let breaks = grading.breaks(&[0.0, 1.0]).unwrap();
            assert!(sizes(&breaks).iter().all(|&h| h > 0.0 && h < 0.1 * 1.12), "{breaks:?}");
            assert_eq!((breaks[0], breaks[breaks.len() - 1]), (0.0, 1.0));
            let inside: Vec<_> = breaks
                .windows(2)
                .filter(|w| w[0] > window.lower - 1e-9 && w[1] < window.upper + 1e-9)
                .map(|w| w[1] - w[0])
                .collect();
            let expected = if (0.01..=0.99).contains(&at) { 16 } else { 8 };
            assert_eq!(inside.len(), expected, "{at} {breaks:?}");
            // Differences of numbers of size one.
            assert!(inside.iter().all(|h| (h / window.size() - 1.0).abs() < 1e-12));
            // Rounding to whole elements may stretch the steps a little beyond the ratio where a
            // side is short.
            let steps: Vec<_> = sizes(&breaks).windows(2).map(|h| h[1] / h[0]).collect();
            assert!(steps.iter().all(|&q| q < 1.45 && q > 1.0 / 1.45), "{at} {steps:?}");
        }
    }

    #[test]
    fn windows_beyond_the_ends_overlapping_or_touching_leave_no_slivers() {
        let w = |lower, upper, elements| Window { lower, upper, elements, ratio: 1.5 };
        for windows in [
            vec![w(-0.3, -0.1, 20)],
            vec![w(-0.3, 1e-9, 20)],
            vec![w(1.0 - 1e-9, 1.2, 20)],
            vec![w(-1.0, 2.0, 30)],
            vec![w(0.2, 0.4, 10), w(0.3, 0.35, 10), w(0.4 + 1e-9, 0.5, 10)],
            vec![w(0.5 - 1e-7, 0.7, 8)],
        ] {
            let finest = windows.iter().map(Window::size).fold(f64::INFINITY, f64::min);
            let breaks = Grading { elements: 6, windows }.breaks(&[0.0, 0.5, 1.0]).unwrap();
            assert!(breaks.contains(&0.5));
            assert!(sizes(&breaks).iter().all(|&h| h > 0.45 * finest), "{breaks:?}");
        }
    }

    #[test]
    fn impossible_gradings_are_refused() {
        let ok = Window { lower: 0.1, upper: 0.2, elements: 4, ratio: 1.5 };
        for window in [
            Window { elements: 0, ..ok },
            Window { ratio: 0.9, ..ok },
            Window { ratio: f64::NAN, ..ok },
            Window { upper: 0.1, ..ok },
            Window { lower: f64::NEG_INFINITY, ..ok },
            Window { upper: 0.1 + 1e-9, elements: 20_000, ratio: 1.0, ..ok },
        ] {
            let grading = Grading { elements: 3, windows: vec![window] };
            assert!(grading.breaks(&[0.0, 1.0]).is_err(), "{window:?}");
        }
        assert!(Grading::uniform(0).breaks(&[0.0, 1.0]).is_err());
        assert!(Grading::uniform(3).breaks(&[0.0]).is_err());
    }
}
