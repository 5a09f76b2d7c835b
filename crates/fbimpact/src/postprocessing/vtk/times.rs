//! Which stored instants are shown.

use std::str::FromStr;

use crate::error::{AppError, CommandFault};

/// Instants without a choice at most: enough for a smooth picture, few enough for a disk.
const MOST: usize = 200;
/// Instants with a choice at most.
const LIMIT: f64 = 1e6;

/// Which instants are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Times {
    /// Evenly spaced ones.
    Range(TimeRange),
    /// The peak of every impact.
    Peak,
}

impl FromStr for Times {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "peak" { Ok(Self::Peak) } else { text.parse().map(Self::Range) }
    }
}

/// `A:B:STEP` in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeRange {
    /// First time \[s\].
    pub from: f64,
    /// Last time \[s\].
    pub to: f64,
    /// Distance \[s\].
    pub step: f64,
}

impl FromStr for TimeRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<f64>, _> = text.split(':').map(str::parse::<f64>).collect();
        let numbers = numbers
            .map_err(|e| format!("{e}; wanted is A:B:STEP in seconds, such as 0:1e-4:1e-6, or peak"))?;
        let &[from, to, step] = numbers.as_slice() else {
            return Err("wanted is A:B:STEP in seconds, such as 0:1e-4:1e-6, or peak".into());
        };
        let is_sound = from.is_finite() && to.is_finite() && step.is_finite() && to >= from && step > 0.0;
        if !is_sound {
            return Err("B must not be less than A, and STEP must be positive".into());
        }
        if (to - from) / step > LIMIT {
            return Err(format!("{:.0} instants are too many, the limit is {LIMIT:.0}", (to - from) / step));
        }
        Ok(Self { from, to, step })
    }
}

/// Numbers of the stored instants `time` to show: the ones nearest to the times of a range or to
/// `peaks`, or every n-th, or at most 200.
///
/// # Errors
/// [`AppError::Command`] if the range lies outside the stored times, or if there are no peaks.
pub fn chosen(
    time: &[f64],
    (times, every): (Option<Times>, Option<usize>),
    peaks: &[f64],
) -> Result<Vec<usize>, AppError> {
    let TimeRange { from, to, step } = match times {
        Some(Times::Range(range)) => range,
        Some(Times::Peak) if peaks.is_empty() => {
            return Err(CommandFault::request(
                "--times peak: the result has no impacts, name times as A:B:STEP",
            )
            .into());
        }
        Some(Times::Peak) => {
            let mut all: Vec<usize> = peaks.iter().map(|t| nearest(time, *t)).collect();
            all.sort_unstable();
            all.dedup();
            return Ok(all);
        }
        None => {
            let every = every.unwrap_or_else(|| time.len().div_ceil(MOST)).max(1);
            return Ok((0..time.len()).step_by(every).collect());
        }
    };
    let (first, last) = (time[0], time[time.len() - 1]);
    if to < first || from > last {
        let given = format!("{from}:{to}:{step}");
        let reason = format!("the result holds {first:e} s to {last:e} s");
        return Err(CommandFault::argument("--times", given, reason).into());
    }
    // The last time counts although it is round-off behind the end.
    let n = ((to - from) / step + 1e-9).floor() as usize;
    let mut all: Vec<usize> = (0..=n).map(|k| from + k as f64 * step).map(|t| nearest(time, t)).collect();
    all.dedup();
    Ok(all)
}

/// The instant nearest to `t`.
fn nearest(time: &[f64], t: f64) -> usize {
    let after = time.partition_point(|x| *x < t).min(time.len() - 1);
    let before = after.saturating_sub(1);
    if (t - time[before]).abs() <= (time[after] - t).abs() { before } else { after }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(text: &str) -> (Option<Times>, Option<usize>) {
        (Some(text.parse().expect("a range")), None)
    }

    #[test]
    fn nearest_instants_are_taken_once() {
        let time = [0.0, 0.1, 0.11, 0.5, 1.0];
        assert_eq!(chosen(&time, range("0:1:0.25"), &[]).expect("inside"), [0, 2, 3, 4]);
        assert_eq!(chosen(&time, range("0.09:0.12:0.001"), &[]).expect("inside"), [1, 2]);
        assert!(chosen(&time, range("2:3:0.1"), &[]).is_err());
        // Impacts of several contacts are not listed in the order of their peaks.
        assert_eq!(chosen(&time, range("peak"), &[0.49, 0.104, 0.5]).expect("inside"), [1, 3]);
        assert!(chosen(&time, range("peak"), &[]).is_err());
    }

    #[test]
    fn every_nth_and_at_most_two_hundred() {
        let time: Vec<f64> = (0..1001).map(f64::from).collect();
        assert_eq!(chosen(&time, (None, Some(500)), &[]).expect("inside"), [0, 500, 1000]);
        let all = chosen(&time, (None, None), &[]).expect("inside");
        assert!(all.len() <= MOST && all.len() > MOST / 2 && all[0] == 0);
        assert_eq!(chosen(&time[..3], (None, None), &[]).expect("inside"), [0, 1, 2]);
    }

    #[test]
    fn senseless_ranges_are_refused() {
        for text in ["1", "0:1", "0:1:0", "1:0:0.1", "0:inf:1", "a:b:c", "0:1:nan", "0:1:1e-9"] {
            assert!(text.parse::<Times>().is_err(), "{text}");
        }
    }
}
