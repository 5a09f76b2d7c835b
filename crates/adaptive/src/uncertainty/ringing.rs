//! A force that rings at its peak (docs/theory/uncertainty.md Eq. U.9).

use std::f64::consts::{FRAC_1_PI, SQRT_2};

use super::replay::Numbers;

/// Largest error of a time within an impact, as a share of its duration.
const ANYWHERE: f64 = 0.5;

/// The changes `other` in `numbers` with those by a force that is off by `force` at single instants: its peak may then be where half a
/// sine of the duration is less than its top by as much, √(2 e)/π of it to either side for a share e.
pub fn in_force(force: f64, numbers: &Numbers, other: Numbers) -> Numbers {
    let share = (FRAC_1_PI * SQRT_2 * (force / numbers.peak_force).sqrt()).min(ANYWHERE);
    Numbers {
        peak_force: other.peak_force + force,
        peak_time: other.peak_time + share * numbers.duration,
        ..other
    }
}

/// How far the peak of `samples`, times and forces, lies above the largest mean over `window` \[s\] that holds
/// it.
pub fn above_mean(samples: &[(f64, f64)], window: f64) -> f64 {
    let Some(peak) = samples.iter().map(|s| s.1).reduce(f64::max) else { return 0.0 };
    let mut sums = vec![0.0];
    for pair in samples.windows(2) {
        let last = sums[sums.len() - 1];
        sums.push(last + 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0));
    }
    let until = |time: f64| {
        let k = samples.partition_point(|s| s.0 <= time).clamp(1, samples.len() - 1);
        let [(a, from), (b, to)] = [samples[k - 1], samples[k]];
        let part = (time.clamp(a, b) - a) / (b - a);
        sums[k - 1] + (b - a) * part * (from + 0.5 * part * (to - from))
    };
    let Some(at) = samples.iter().find(|s| s.1 >= peak).map(|s| s.0) else { return 0.0 };
    let means = (0..=10).map(|i| {
        let start = at - window * f64::from(i) / 10.0;
        (until(start + window) - until(start)) / window
    });
    (peak - means.fold(0.0, f64::max)).max(0.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn ringing_is_what_a_mean_over_its_period_leaves_out() {
        let samples: Vec<(f64, f64)> =
            (0..2000).map(|i| (f64::from(i) * 1e-3, 10.0 + (TAU * f64::from(i) * 1e-2).sin())).collect();
        assert!((above_mean(&samples, 0.1) - 1.0).abs() < 1e-3);
        assert!(above_mean(&[(0.0, 1.0), (1.0, 1.0)], 0.1).abs() < 1e-12);
    }
}
