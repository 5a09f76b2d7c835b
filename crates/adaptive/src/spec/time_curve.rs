//! Quantities given over time, as data.

use std::f64::consts::TAU;

use ffr_dynamics::system::joints::{TimeCourse, TimeFunction};

/// A quantity over time, with continuous first and second derivatives unless it is piecewise.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeCurve {
    /// `Σ_k c_k t^k`.
    Polynomial {
        /// Coefficients, the constant first.
        coefficients: Vec<f64>,
    },
    /// `offset + amplitude sin(2π f t + phase)`.
    Harmonic {
        /// Amplitude.
        amplitude: f64,
        /// Frequency \[Hz\].
        frequency: f64,
        /// Phase \[rad\].
        phase: f64,
        /// Mean value.
        offset: f64,
    },
    /// From rest to the constant rate `rate`, reached smoothly at the time `duration`:
    /// `rate/T (t²/2 + (T/2π)² (cos(2πt/T) - 1))`, then `rate (t - T/2)` (Simo and Vu-Quoc's
    /// spin-up).
    SpinUp {
        /// Final rate [1/s].
        rate: f64,
        /// Time at which it is reached \[s\].
        duration: f64,
    },
    /// Cubic spline through points: a natural one, which goes on with constant rate outside them,
    /// or a periodic one.
    Table(CubicSpline),
    /// Lines or steps through points, with jumps of the rate or of the value.
    Piecewise(Piecewise),
}

impl TimeCurve {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self::Polynomial { coefficients: vec![value] }
    }

    /// Value, first and second derivative at time `t`.
    pub fn at(&self, t: f64) -> [f64; 3] {
        match self {
            Self::Polynomial { coefficients } => {
                let mut sums = [0.0; 3];
                for c in coefficients.iter().rev() {
                    sums[2] = sums[2] * t + 2.0 * sums[1];
                    sums[1] = sums[1] * t + sums[0];
                    sums[0] = sums[0] * t + c;
                }
                sums
            }
            Self::Harmonic { amplitude, frequency, phase, offset } => {
                let w = TAU * frequency;
                let (s, c) = (w * t + phase).sin_cos();
                [offset + amplitude * s, amplitude * w * c, -amplitude * w * w * s]
            }
            Self::SpinUp { rate, duration } => {
                if t >= *duration {
                    return [rate * (t - 0.5 * duration), *rate, 0.0];
                }
                let w = TAU / duration;
                let (s, c) = (w * t).sin_cos();
                let slope = rate / duration;
                [slope * (0.5 * t * t + (c - 1.0) / (w * w)), slope * (t - s / w), slope * (1.0 - c)]
            }
            Self::Table(spline) => spline.at(t),
            Self::Piecewise(points) => points.at(t),
        }
    }

    /// The same as a function.
    pub fn function(&self) -> TimeFunction {
        TimeFunction::with_course(self.clone())
    }
}

impl TimeCourse for TimeCurve {
    fn at(&self, t: f64) -> [f64; 3] {
        Self::at(self, t)
    }

    fn next_break(&self, t: f64) -> f64 {
        match self {
            Self::Polynomial { .. } | Self::Harmonic { .. } => f64::INFINITY,
            // Its third derivative jumps.
            Self::SpinUp { duration, .. } => next_of(&[0.0, *duration], false, t),
            Self::Table(CubicSpline { times, is_periodic, .. })
            | Self::Piecewise(Piecewise { times, is_periodic, .. }) => next_of(times, *is_periodic, t),
        }
    }

    fn longest_step(&self, t: f64) -> f64 {
        match self {
            Self::Harmonic { frequency, .. } if *frequency > 0.0 => QUARTER / frequency,
            Self::SpinUp { duration, .. } if t < *duration => QUARTER * duration,
            _ => f64::INFINITY,
        }
    }
}

/// Longest step in terms of a period: a quadrature of order eight errs by 2e-8 of the amplitude
/// then.
const QUARTER: f64 = 0.25;

/// The next of rising `times`, repeated with the time from the first to the last one if they are
/// periodic, after `t`.
fn next_of(times: &[f64], is_periodic: bool, t: f64) -> f64 {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return f64::INFINITY };
    let period = last - first;
    let begin = if is_periodic { ((t - first) / period).floor() * period } else { 0.0 };
    // Round-off may place `t` at the end of one period or at the start of the next.
    let candidates = [0.0, if is_periodic { period } else { 0.0 }];
    let next = candidates.iter().flat_map(|more| {
        let i = times.partition_point(|x| begin + more + x <= t);
        times.get(i).map(|x| begin + more + x)
    });
    next.fold(f64::INFINITY, f64::min)
}

/// How a [`Piecewise`] is interpolated between its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PiecewiseForm {
    /// Lines.
    Lines,
    /// Each value lasts until the next time.
    Steps,
}

/// Lines or steps through points; outside, the value of the first or the last one, or a repetition.
#[derive(Debug, Clone, PartialEq)]
pub struct Piecewise {
    /// Rising times \[s\], two at least.
    pub times: Vec<f64>,
    /// Values, as many.
    pub values: Vec<f64>,
    /// The interpolation between the points.
    pub form: PiecewiseForm,
    /// Whether they repeat with the time from the first to the last one.
    pub is_periodic: bool,
}

impl Piecewise {
    /// Value and rate at time `t`, at a point those behind it; the second derivative is zero.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let Self { times, values, .. } = self;
        let t = if self.is_periodic { within_period(times, t) } else { t };
        let behind = times.partition_point(|x| *x <= t);
        let (Some(&before), Some(next)) = (values.get(behind.saturating_sub(1)), times.get(behind)) else {
            return [values.last().copied().unwrap_or(0.0), 0.0, 0.0];
        };
        if behind == 0 || self.form == PiecewiseForm::Steps {
            return [before, 0.0, 0.0];
        }
        let start = times[behind - 1];
        let slope = (values[behind] - before) / (next - start);
        [before + slope * (t - start), slope, 0.0]
    }
}

/// The time of the first period that belongs to `t`.
fn within_period(times: &[f64], t: f64) -> f64 {
    let (first, last) = (times[0], times[times.len() - 1]);
    first + (t - first).rem_euclid(last - first)
}

/// Cubic spline, natural or periodic.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicSpline {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the points.
    bends: Vec<f64>,
    is_periodic: bool,
}

/// Solution of the equations `left_i x_{i-1} + middle_i x_i + right_i x_{i+1} = b_i` by elimination
/// without exchange, which diagonally dominant ones need none of; the first `left` and the last
/// `right` are taken as zero.
fn solve_tridiagonal([left, middle, right]: [&[f64]; 3], b: &[f64]) -> Vec<f64> {
    let n = b.len();
    let (mut ratio, mut x) = (vec![0.0; n], vec![0.0; n]);
    for i in 0..n {
        let (before, pivot) = match i {
            0 => (0.0, middle[0]),
            _ => (left[i] * x[i - 1], middle[i] - left[i] * ratio[i - 1]),
        };
        ratio[i] = right[i] / pivot;
        x[i] = (b[i] - before) / pivot;
    }
    for i in (0..n.saturating_sub(1)).rev() {
        x[i] -= ratio[i] * x[i + 1];
    }
    x
}

impl CubicSpline {
    /// Spline through `values` at rising `times` that repeats itself after the last one, whose
    /// value must be the first; otherwise as [`CubicSpline::new`].
    pub fn periodic(times: Vec<f64>, values: Vec<f64>) -> Option<Self> {
        let spline = Self { is_periodic: true, ..Self::new(times, values)? };
        let (times, values) = (&spline.times, &spline.values);
        let n = times.len() - 1;
        if values[n].to_bits() != values[0].to_bits() {
            return None;
        }
        // The last point is the first one of the next period.
        let step = |i: usize| times[i % n + 1] - times[i % n];
        let slope = |i: usize| (values[i % n + 1] - values[i % n]) / step(i);
        let right: Vec<f64> = (0..n).map(step).collect();
        let left: Vec<f64> = (0..n).map(|i| step(i + n - 1)).collect();
        let jump = |i: usize| 6.0 * (slope(i) - slope(i + n - 1));
        let b: Vec<f64> = (0..n).map(jump).collect();
        let mut bends = match n {
            // One point per period is a constant; of two each is the neighbour of the other on both
            // sides.
            1 => vec![0.0],
            2 => {
                let (own, other) = (2.0 * (left[0] + right[0]), left[0] + right[0]);
                let determinant = own * own - other * other;
                vec![(own * b[0] - other * b[1]) / determinant, (own * b[1] - other * b[0]) / determinant]
            }
            // The corners of the cyclic matrix as a product of two vectors (Sherman and Morrison).
            _ => {
                let corner = left[0];
                let mut middle: Vec<f64> = (0..n).map(|i| 2.0 * (left[i] + right[i])).collect();
                let gamma = -middle[0];
                middle[0] -= gamma;
                middle[n - 1] -= corner * corner / gamma;
                let mut u = vec![0.0; n];
                (u[0], u[n - 1]) = (gamma, corner);
                let bands = [&left[..], &middle, &right];
                let (y, z) = (solve_tridiagonal(bands, &b), solve_tridiagonal(bands, &u));
                let along = |x: &[f64]| x[0] + corner / gamma * x[n - 1];
                let share = along(&y) / (1.0 + along(&z));
                y.iter().zip(&z).map(|(y, z)| y - share * z).collect()
            }
        };
        bends.push(bends[0]);
        Some(Self { bends, ..spline })
    }

    /// Spline through `values` at rising `times`; `None` unless there are two points at least, as
    /// many values as times, all finite and the times rising.
    pub fn new(times: Vec<f64>, values: Vec<f64>) -> Option<Self> {
        let n = times.len();
        let is_sound = n >= 2
            && values.len() == n
            && times.iter().chain(&values).all(|x| x.is_finite())
            && times.windows(2).all(|w| w[1] > w[0]);
        if !is_sound {
            return None;
        }
        // Second derivatives are zero at both ends.
        let step = |i: usize| times[i + 1] - times[i];
        let slope = |i: usize| (values[i + 1] - values[i]) / step(i);
        let inner = 1..n - 1;
        let left: Vec<f64> = inner.clone().map(|i| step(i - 1)).collect();
        let right: Vec<f64> = inner.clone().map(step).collect();
        let middle: Vec<f64> = left.iter().zip(&right).map(|(a, b)| 2.0 * (a + b)).collect();
        let jumps: Vec<f64> = inner.map(|i| 6.0 * (slope(i) - slope(i - 1))).collect();
        let mut bends = vec![0.0];
        bends.extend(solve_tridiagonal([&left, &middle, &right], &jumps));
        bends.push(0.0);
        Some(Self { times, values, bends, is_periodic: false })
    }

    /// Value, first and second derivative at time `t`.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let last = self.times.len() - 1;
        let t = if self.is_periodic { within_period(&self.times, t) } else { t };
        let i = self.times.partition_point(|x| *x <= t).clamp(1, last);
        let (start, end) = (self.times[i - 1], self.times[i]);
        let inside = t.clamp(start, end);
        let h = end - start;
        let (a, b) = ((end - inside) / h, (inside - start) / h);
        let (y0, y1, m0, m1) = (self.values[i - 1], self.values[i], self.bends[i - 1], self.bends[i]);
        let value = a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0;
        let slope = (y1 - y0) / h + ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * h / 6.0;
        [value + slope * (t - inside), slope, a * m0 + b * m1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn derivatives_match(curve: &TimeCurve, times: &[f64]) {
        for &t in times {
            let h = 1e-4;
            let [_, rate, bend] = curve.at(t);
            let (before, after) = (curve.at(t - h), curve.at(t + h));
            // Central differences: error h² times the third derivative, at most 100 here.
            assert!((rate - (after[0] - before[0]) / (2.0 * h)).abs() < 1e-6, "{curve:?} {t}");
            assert!((bend - (after[1] - before[1]) / (2.0 * h)).abs() < 1e-5, "{curve:?} {t}");
        }
    }

    #[test]
    fn lines_and_steps_take_the_value_behind_a_point_and_end_there() {
        let points = |form, is_periodic| Piecewise {
            times: vec![0.0, 1.0, 3.0],
            values: vec![2.0, 4.0, 2.0],
            form,
            is_periodic,
        };
        let lines = TimeCurve::Piecewise(points(PiecewiseForm::Lines, false));
        let expected = [
            (-1.0, [2.0, 0.0]),
            (0.5, [3.0, 2.0]),
            (1.0, [4.0, -1.0]),
            (2.0, [3.0, -1.0]),
            (3.0, [2.0, 0.0]),
        ];
        for (t, [value, rate]) in expected {
            let found = lines.at(t);
            // Exact in binary numbers; round-off otherwise.
            assert!((found[0] - value).abs() < 1e-15 && (found[1] - rate).abs() < 1e-15, "{t} {found:?}");
        }
        for (t, next) in [(-1.0, 0.0), (0.0, 1.0), (0.5, 1.0), (1.0, 3.0)] {
            assert!((lines.next_break(t) - next).abs() < 1e-15, "{t}");
        }
        assert!(lines.next_break(3.0).is_infinite());
        let steps = TimeCurve::Piecewise(points(PiecewiseForm::Steps, true));
        for (t, value) in [(0.5, 2.0), (1.0, 4.0), (2.9, 4.0), (3.5, 2.0), (4.0, 4.0), (-0.5, 4.0)] {
            assert!((steps.at(t)[0] - value).abs() < 1e-15, "{t}");
        }
        // From break to break, whatever round-off does to the periods.
        let mut t = -0.5;
        for expected in [0.0, 1.0, 3.0, 4.0, 6.0, 7.0, 9.0] {
            t = steps.next_break(t);
            assert!((t - expected).abs() < 1e-14, "{t} {expected}");
        }
    }

    #[test]
    fn derivatives_of_all_curves_equal_finite_differences() {
        let times = [0.13, 0.7, 1.9, 2.6];
        derivatives_match(&TimeCurve::Polynomial { coefficients: vec![1.0, -2.0, 0.5, 0.25] }, &times);
        let harmonic = TimeCurve::Harmonic { amplitude: 0.3, frequency: 0.8, phase: 0.2, offset: -1.0 };
        derivatives_match(&harmonic, &times);
        derivatives_match(&TimeCurve::SpinUp { rate: 6.0, duration: 1.5 }, &times);
        let spline = CubicSpline::new(vec![0.0, 0.5, 1.0, 2.0], vec![0.0, 1.0, 0.5, 0.25]).unwrap();
        derivatives_match(&TimeCurve::Table(spline), &times);
    }

    #[test]
    fn spin_up_is_smooth_where_the_rate_is_reached() {
        let curve = TimeCurve::SpinUp { rate: 6.0, duration: 15.0 };
        let (before, after) = (curve.at(15.0 - 1e-9), curve.at(15.0));
        assert!((before[0] - after[0]).abs() < 1e-7 && (before[1] - after[1]).abs() < 1e-12);
        assert!((after[0] - 45.0).abs() < 1e-12, "the mean rate is half the final one");
    }

    #[test]
    fn spline_goes_through_its_points_and_reproduces_a_line() {
        let times = vec![-1.0, 0.0, 0.3, 2.0];
        let values: Vec<f64> = times.iter().map(|t| 2.0 * t - 0.5).collect();
        let spline = CubicSpline::new(times, values).unwrap();
        for t in [-3.0, -1.0, 0.1, 0.3, 1.7, 5.0] {
            let [value, rate, bend] = spline.at(t);
            // Round-off of numbers of order 10.
            assert!(
                (value - (2.0 * t - 0.5)).abs() < 1e-13 && (rate - 2.0).abs() < 1e-13 && bend.abs() < 1e-12
            );
        }
    }

    #[test]
    fn periodic_splines_repeat_and_are_smooth_at_the_seam() {
        let tables: [(&[f64], &[f64]); 3] = [
            (&[0.0, 0.4, 1.0, 1.5, 2.0], &[1.0, -0.5, 0.25, 2.0, 1.0]),
            (&[0.0, 0.7, 2.0, 2.5], &[0.0, 1.0, -1.0, 0.0]),
            (&[0.0, 0.7, 2.0], &[0.0, 1.0, 0.0]),
        ];
        for (times, values) in tables {
            let spline = CubicSpline::periodic(times.to_vec(), values.to_vec()).unwrap();
            let period = times[times.len() - 1];
            for (t, v) in times.iter().zip(values) {
                assert!(
                    (spline.at(*t)[0] - v).abs() < 1e-14
                        && (spline.at(t + 3.0 * period)[0] - v).abs() < 1e-13
                );
            }
            for (i, tolerance) in [1e-8, 1e-7, 1e-6].into_iter().enumerate() {
                for t in times {
                    // A jump in the i-th derivative would stay; the next one moves it by the step
                    // of 2e-9 times some hundreds.
                    let (before, after) = (spline.at(t - 1e-9), spline.at(t + 1e-9));
                    assert!((before[i] - after[i]).abs() < tolerance, "{i} at {t}: {before:?} {after:?}");
                }
            }
            derivatives_match(&TimeCurve::Table(spline), &[0.13 + period, 0.35 - period, 0.9]);
        }
        // A harmonic through 40 points: the error of a cubic spline is 5/384 (2 pi / 40)^4, 8e-6.
        let times: Vec<f64> = (0..=40).map(|i| f64::from(i) / 40.0).collect();
        let mut values: Vec<f64> = times.iter().map(|t| (TAU * t).cos()).collect();
        values[40] = values[0];
        let spline = CubicSpline::periodic(times, values).unwrap();
        assert!((spline.at(7.0125)[0] - (TAU * 0.0125).cos()).abs() < 1e-5);
        assert!(CubicSpline::periodic(vec![0.0, 1.0], vec![1.0, 2.0]).is_none());
    }

    #[test]
    fn unsound_tables_are_refused() {
        assert!(CubicSpline::new(vec![0.0], vec![1.0]).is_none());
        assert!(CubicSpline::new(vec![0.0, 0.0], vec![1.0, 2.0]).is_none());
        assert!(CubicSpline::new(vec![0.0, f64::NAN], vec![1.0, 2.0]).is_none());
        assert!(CubicSpline::new(vec![0.0, 1.0], vec![1.0]).is_none());
    }
}
