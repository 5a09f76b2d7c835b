//! Quantities given over time, as data.

use std::f64::consts::TAU;

use ffr_dynamics::system::joints::TimeFunction;

/// A quantity over time with continuous first and second derivatives.
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
    /// `rate/T (t²/2 + (T/2π)² (cos(2πt/T) - 1))`, then `rate (t - T/2)` (Simo and Vu-Quoc's spin-up).
    SpinUp {
        /// Final rate [1/s].
        rate: f64,
        /// Time at which it is reached \[s\].
        duration: f64,
    },
    /// Natural cubic spline through points; goes on with constant rate outside them.
    Table(CubicSpline),
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
        }
    }

    /// The same as a function.
    pub fn function(&self) -> TimeFunction {
        let curve = self.clone();
        TimeFunction::new(move |t| curve.at(t))
    }
}

/// Natural cubic spline.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicSpline {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the points.
    bends: Vec<f64>,
}

impl CubicSpline {
    /// Spline through `values` at rising `times`; `None` unless there are two points at least, as many values as times, all
    /// finite and the times rising.
    pub fn new(times: Vec<f64>, values: Vec<f64>) -> Option<Self> {
        let n = times.len();
        let is_sound = n >= 2
            && values.len() == n
            && times.iter().chain(&values).all(|x| x.is_finite())
            && times.windows(2).all(|w| w[1] > w[0]);
        if !is_sound {
            return None;
        }
        // Thomas algorithm for the second derivatives, zero at both ends.
        let (mut ratio, mut bends) = (vec![0.0; n], vec![0.0; n]);
        for i in 1..n - 1 {
            let (left, right) = (times[i] - times[i - 1], times[i + 1] - times[i]);
            let jump = (values[i + 1] - values[i]) / right - (values[i] - values[i - 1]) / left;
            let pivot = 2.0 * (left + right) - left * ratio[i - 1];
            ratio[i] = right / pivot;
            bends[i] = (6.0 * jump - left * bends[i - 1]) / pivot;
        }
        for i in (1..n - 1).rev() {
            bends[i] -= ratio[i] * bends[i + 1];
        }
        Some(Self { times, values, bends })
    }

    /// Value, first and second derivative at time `t`.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let last = self.times.len() - 1;
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
    fn unsound_tables_are_refused() {
        assert!(CubicSpline::new(vec![0.0], vec![1.0]).is_none());
        assert!(CubicSpline::new(vec![0.0, 0.0], vec![1.0, 2.0]).is_none());
        assert!(CubicSpline::new(vec![0.0, f64::NAN], vec![1.0, 2.0]).is_none());
        assert!(CubicSpline::new(vec![0.0, 1.0], vec![1.0]).is_none());
    }
}
