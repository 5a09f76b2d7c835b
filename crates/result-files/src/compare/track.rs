//! A quantity over time, and its largest deviation from another one on the other's instants.
//!
//! Between two samples a straight line is taken. What the samples themselves leave open is no
//! deviation: a line through `y_i`, `y_i+1` errs at most by
//! `s (1 - s) h (|m_i - m_i-1| + |m_i+1 - m_i|)`, with `s` the position in the interval, `h` its
//! length and `m` the slopes of it and its neighbours. This is exact for one kink in the interval
//! (a contact that closes) and four times the error for a curve of constant curvature. It vanishes
//! at the samples.

/// Instants closer than this part of the whole time span are the same: rounding of an event's time.
const SAME_TIME: f64 = 1e-12;

/// One column of a time series.
#[derive(Debug, Clone, Copy)]
pub struct Track<'a> {
    /// Instants, not decreasing \[s\].
    pub times: &'a [f64],
    /// Numbers in the order of rows.
    pub values: &'a [f64],
    /// How many numbers each row has.
    pub width: usize,
    /// Column.
    pub column: usize,
}

/// The largest deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worst {
    /// Deviation, beyond what the samples leave open; infinite if one value is no number.
    pub deviation: f64,
    /// The instant \[s\].
    pub time: f64,
    /// The new value there.
    pub new: f64,
    /// The reference's value there.
    pub reference: f64,
}

/// `|a - b|`, zero for equal infinities and for two values that are no numbers, infinite where only
/// one is finite.
pub fn difference(a: f64, b: f64) -> f64 {
    let is_same = a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
    match (a - b).abs() {
        _ if is_same => 0.0,
        d if d.is_nan() => f64::INFINITY,
        d => d,
    }
}

impl Track<'_> {
    /// Value of row `i`.
    pub fn value(&self, i: usize) -> f64 {
        self.values[i * self.width + self.column]
    }

    /// Slope of the nearest interval of positive length at or before `i` (`step < 0`) or after it.
    fn slope(&self, mut i: isize, step: isize) -> Option<f64> {
        while i >= 0 && (i as usize) + 1 < self.times.len() {
            let k = i as usize;
            let h = self.times[k + 1] - self.times[k];
            if h > 0.0 {
                return Some((self.value(k + 1) - self.value(k)) / h);
            }
            i += step;
        }
        None
    }

    /// Value at `t` in the interval from row `i`, and what the samples leave open.
    fn between(&self, i: usize, t: f64) -> (f64, f64) {
        let (h, a, b) = (self.times[i + 1] - self.times[i], self.value(i), self.value(i + 1));
        let s = (t - self.times[i]) / h;
        let slope = (b - a) / h;
        let change = |other: Option<f64>| other.map_or(0.0, |m| (m - slope).abs());
        let bend = change(self.slope(i as isize - 1, -1)) + change(self.slope(i as isize + 1, 1));
        (a + s * (b - a), s * (1.0 - s) * h * bend)
    }

    /// Smallest and largest value of the rows `from..=to`, as far as there are such rows with
    /// numbers.
    fn range(&self, from: usize, to: usize) -> (f64, f64) {
        let values = (from..=to.min(self.times.len() - 1)).map(|i| self.value(i)).filter(|v| !v.is_nan());
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    }

    fn has_nan(&self) -> bool {
        (0..self.times.len()).any(|i| self.value(i).is_nan())
    }

    /// Deviation of this track from `reference` at the time `t`, whose neighbours are the rows
    /// `first..end` at the same time, or none; with it the value there.
    fn deviation(&self, t: f64, first: usize, end: usize, reference: f64, is_stepwise: bool) -> (f64, f64) {
        let nearest = |a: (f64, f64), b: (f64, f64)| if b.0 < a.0 { b } else { a };
        let at_samples = (first..end).map(|i| (difference(self.value(i), reference), self.value(i)));
        let at_samples = at_samples.reduce(nearest);
        if is_stepwise {
            let rows = (first.saturating_sub(2), end + 1);
            let (low, high) = self.range(rows.0, rows.1);
            let is_nan_there = || (rows.0..=rows.1.min(self.times.len() - 1)).any(|i| self.value(i).is_nan());
            if (low <= reference && reference <= high) || (reference.is_nan() && is_nan_there()) {
                return (0.0, reference);
            }
            let sides = nearest((difference(low, reference), low), (difference(high, reference), high));
            return at_samples.map_or(sides, |at| nearest(sides, at));
        }
        at_samples.unwrap_or_else(|| {
            let (value, open) = self.between(first - 1, t);
            let deviation = difference(value, reference);
            (if open.is_finite() { (deviation - open).max(0.0) } else { deviation }, value)
        })
    }

    /// The largest deviation of this track from `reference` on the instants of `reference` that it
    /// covers; `None` if it covers none.
    pub fn worst(&self, reference: &Track<'_>, is_stepwise: bool) -> Option<Worst> {
        let (start, stop) = (*self.times.first()?, *self.times.last()?);
        // A quantity that is undefined at times (NaN) may become so one instant earlier, but not if
        // the reference never is.
        let is_stepwise = is_stepwise && (reference.has_nan() || !self.has_nan());
        let same = SAME_TIME * (reference.times.last()? - reference.times.first()?).abs();
        let mut worst: Option<Worst> = None;
        let (mut first, mut end) = (0, 0);
        for (row, t) in reference.times.iter().enumerate() {
            if *t < start - same || *t > stop + same {
                continue;
            }
            while first < self.times.len() && self.times[first] < t - same {
                first += 1;
            }
            end = end.max(first);
            while end < self.times.len() && self.times[end] <= t + same {
                end += 1;
            }
            let value = reference.value(row);
            let (deviation, new) = self.deviation(*t, first, end, value, is_stepwise);
            if worst.is_none_or(|w| deviation > w.deviation) {
                worst = Some(Worst { deviation, time: *t, new, reference: value });
            }
        }
        worst
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact by construction")]
mod tests {
    use super::*;

    fn track<'a>(times: &'a [f64], values: &'a [f64]) -> Track<'a> {
        Track { times, values, width: 1, column: 0 }
    }

    fn sampled(n: usize, f: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let times: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
        let values = times.iter().map(|t| f(*t)).collect();
        (times, values)
    }

    #[test]
    fn equal_curves_on_other_instants_do_not_deviate() {
        // A force that rises with a kink, and with a steep smooth flank.
        for f in [|t: f64| (t - 0.4031).max(0.0), |t: f64| (t - 0.4031).max(0.0).powf(1.5)] {
            let (a, b) = (sampled(97, f), sampled(60, f));
            let w = track(&b.0, &b.1).worst(&track(&a.0, &a.1), false).expect("overlap");
            // The kink is covered exactly, up to rounding; a power of 1.5 has the growing curvature
            // of the first interval.
            assert!(w.deviation < 1e-4, "{w:?}");
        }
    }

    #[test]
    fn changed_height_and_shift_are_found() {
        let f = |t: f64| (std::f64::consts::PI * t).sin();
        let (a, b) = (sampled(400, f), sampled(333, |t| 1.005 * f(t)));
        let w = track(&b.0, &b.1).worst(&track(&a.0, &a.1), false).expect("overlap");
        // 0.5 %, less four times the error of a line: 4 * (pi / 333)^2 / 8.
        assert!((w.deviation - 5e-3).abs() < 6e-5 && (w.time - 0.5).abs() < 0.1, "{w:?}");
        let b = sampled(333, |t| f(t + 0.01));
        let w = track(&b.0, &b.1).worst(&track(&a.0, &a.1), false).expect("overlap");
        assert!(w.deviation > 0.03, "{w:?}");
    }

    #[test]
    fn nan_deviates_without_limit_and_equal_infinities_do_not() {
        let t = [0.0, 1.0, 2.0];
        let reference = track(&t, &[1.0, 2.0, 3.0]);
        for bad in [f64::NAN, f64::INFINITY] {
            let values = [1.0, bad, 3.0];
            let w = track(&t, &values).worst(&reference, false).expect("overlap");
            assert!(w.deviation.is_infinite() && w.time == 1.0, "{w:?}");
            let other = track(&[0.0, 0.9, 2.0], &values).worst(&reference, false).expect("overlap");
            assert!(other.deviation.is_infinite(), "{other:?}");
            assert_eq!(track(&t, &values).worst(&track(&t, &values), false).expect("overlap").deviation, 0.0);
        }
    }

    #[test]
    fn step_one_instant_later_is_no_deviation_of_a_stepwise_quantity() {
        let t: Vec<f64> = (0..6).map(f64::from).collect();
        let (a, b) = ([0.0, 0.0, 2.0, 2.0, 5.0, 5.0], [0.0, 0.0, 0.0, 2.0, 5.0, 5.0]);
        assert_eq!(track(&t, &b).worst(&track(&t, &a), true).expect("overlap").deviation, 0.0);
        assert_eq!(track(&t, &b).worst(&track(&t, &a), false).expect("overlap").deviation, 2.0);
        let undefined = [f64::NAN, f64::NAN, 2.0, 2.0, 5.0, 5.0];
        let later = [f64::NAN, f64::NAN, f64::NAN, 2.0, 5.0, 5.0];
        assert_eq!(track(&t, &later).worst(&track(&t, &undefined), true).expect("overlap").deviation, 0.0);
        assert!(track(&t, &later).worst(&track(&t, &a), true).expect("overlap").deviation.is_infinite());
        let c = [0.0, 0.0, 3.0, 3.0, 5.0, 5.0];
        assert_eq!(
            track(&t, &c)
                .worst(&track(&t, &[0.0, 0.0, 7.0, 7.0, 5.0, 5.0]), true)
                .expect("overlap")
                .deviation,
            2.0
        );
    }

    #[test]
    fn two_values_at_one_instant_are_both_accepted() {
        let (t, v) = ([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 4.0, 5.0]);
        for value in [1.0, 4.0] {
            let w = track(&t, &v).worst(&track(&[0.0, 1.0], &[0.0, value]), false).expect("overlap");
            assert_eq!(w.deviation, 0.0);
        }
    }

    #[test]
    fn instants_that_are_not_covered_do_not_count() {
        let (t, v) = ([0.0, 1.0], [0.0, 1.0]);
        let w = track(&t, &v).worst(&track(&[0.5, 3.0], &[0.5, 9.0]), false).expect("overlap");
        assert_eq!(w.deviation, 0.0);
        assert!(track(&t, &v).worst(&track(&[3.0], &[9.0]), false).is_none());
        assert!(track(&[], &[]).worst(&track(&t, &v), false).is_none());
    }
}
