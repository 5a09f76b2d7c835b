//! Amplitude spectra of histories whose instants are not evenly spaced (docs/theory.md Eq. Q.9).

use std::f64::consts::{PI, TAU};

/// Share of the window's weight that instants farther apart than the limit may take.
const COARSE_SHARE: f64 = 0.05;
/// Products of instants and lines at most: some ten seconds.
const MOST: f64 = 4e9;
/// Even instants differ by round-off of their times.
const ROUND_OFF: f64 = 1e-9;
/// Lines after which phases are evaluated anew: the recurrence between them loses a digit at most.
const RENEWED: usize = 64;

/// Lines of a spectrum.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Spectrum {
    /// Frequencies \[Hz\], from the first line above zero on.
    pub frequency: Vec<f64>,
    /// Amplitudes in the unit of the history.
    pub amplitude: Vec<f64>,
}

/// The spectrum of `values` at the instants `time` \[s\], which rise; none of fewer than eight
/// instants or of no time.
pub fn spectrum(time: &[f64], values: &[f64]) -> Option<Spectrum> {
    let n = time.len().min(values.len());
    let (first, length) = (*time.first()?, time.get(n.checked_sub(1)?)? - time[0]);
    let is_rising = time[..n].windows(2).all(|pair| pair[1] >= pair[0]);
    if n < 8 || length <= 0.0 || !length.is_finite() || !is_rising {
        return None;
    }
    let phase: Vec<f64> = time[..n].iter().map(|t| (t - first) / length).collect();
    let step = |i: usize| if i + 1 < n { phase[i + 1] - phase[i] } else { 0.0 };
    // Trapezoidal rule: half of the interval on either side.
    let weight = |i: usize| {
        let window = 0.5 * (1.0 - (TAU * phase[i]).cos());
        0.5 * window * (step(i) + if i > 0 { step(i - 1) } else { 0.0 })
    };
    let weights: Vec<f64> = (0..n).map(weight).collect();
    let total: f64 = weights.iter().sum();
    let mean = weights.iter().zip(values).map(|(w, v)| w * v).sum::<f64>() / total;
    let terms: Vec<f64> =
        weights.iter().zip(values).map(|(w, v)| if *w > 0.0 { w * (v - mean) } else { 0.0 }).collect();
    let lines = 0.5 / coarsest(&phase) * (1.0 + ROUND_OFF);
    let lines = lines.min(MOST / n as f64).floor() as usize;
    let turns: Vec<(f64, f64)> = phase.iter().map(|s| (TAU * s).sin_cos()).collect();
    let mut phasors = vec![(0.0, 1.0); n];
    let mut found = Spectrum::default();
    for k in 1..=lines {
        let (mut re, mut im) = (0.0, 0.0);
        for (i, (term, (sin, cos))) in terms.iter().zip(&mut phasors).enumerate() {
            (*sin, *cos) = match k % RENEWED {
                1 => (TAU * (k as f64 * phase[i]).fract()).sin_cos(),
                _ => (*sin * turns[i].1 + *cos * turns[i].0, *cos * turns[i].1 - *sin * turns[i].0),
            };
            re += term * *cos;
            im += term * *sin;
        }
        found.frequency.push(k as f64 / length);
        found.amplitude.push(2.0 * re.hypot(im) / total);
    }
    Some(found)
}

/// The interval beyond which those that are longer have a twentieth of the window's weight, of
/// instants between 0 and 1.
fn coarsest(phase: &[f64]) -> f64 {
    // Integral of the window from 0.
    let window = |s: f64| 0.5 * (s - (TAU * s).sin() / TAU);
    let mut intervals: Vec<(f64, f64)> =
        phase.windows(2).map(|pair| (pair[1] - pair[0], window(pair[1]) - window(pair[0]))).collect();
    intervals.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut sum = 0.0;
    for (length, weight) in &intervals {
        sum += weight;
        if sum > COARSE_SHARE * window(1.0) {
            return *length;
        }
    }
    1.0
}

/// Largest amplitude that Hann's window shows too little of a vibration between two lines.
pub const SCALLOP: f64 = 1.0 - 8.0 / (3.0 * PI);

#[cfg(test)]
mod tests {
    use super::*;

    fn at(spectrum: &Spectrum, f: f64) -> f64 {
        let near = |k: &usize| (spectrum.frequency[*k] - f).abs();
        let k = (0..spectrum.frequency.len()).min_by(|a, b| near(a).total_cmp(&near(b))).expect("lines");
        spectrum.amplitude[k]
    }

    #[test]
    fn amplitude_and_frequency_of_vibrations_are_found() {
        let time: Vec<f64> = (0..=2000).map(|i| 3.0 + 1e-4 * f64::from(i)).collect();
        let vibration = |t: f64| 5.0 + 0.3 * (TAU * 500.0 * t).sin() + 0.02 * (TAU * 2000.0 * t + 0.4).cos();
        let values: Vec<f64> = time.iter().map(|t| vibration(*t)).collect();
        let found = spectrum(&time, &values).expect("a spectrum");
        assert_eq!(found.frequency.len(), 1000);
        assert!((found.frequency[999] - 5000.0).abs() < 1e-6);
        // Whole periods: even sampling makes the rule exact, to the round-off of phases of 1e3
        // turns.
        assert!((at(&found, 500.0) - 0.3).abs() < 1e-10 && (at(&found, 2000.0) - 0.02).abs() < 1e-10);
        // Hann's window reaches one line to either side.
        for (f, a) in found.frequency.iter().zip(&found.amplitude) {
            let is_near = [500.0, 2000.0].iter().any(|g| (f - g).abs() < 1.5 * 5.0);
            assert!(is_near || *a < 1e-10, "{f}: {a:e}");
        }
    }

    #[test]
    fn between_two_lines_hanns_window_shows_a_seventh_less() {
        let time: Vec<f64> = (0..=4000).map(|i| 1e-4 * f64::from(i)).collect();
        let values: Vec<f64> = time.iter().map(|t| (TAU * 501.25 * t).sin()).collect();
        let found = spectrum(&time, &values).expect("a spectrum");
        let largest = found.amplitude.iter().fold(0.0f64, |m, a| m.max(*a));
        // The images at negative frequencies are 400 lines away, where the window has fallen to its
        // third power.
        assert!((largest - (1.0 - SCALLOP)).abs() < 1e-6, "{largest}");
    }

    #[test]
    fn uneven_instants_converge_with_the_square_of_the_step() {
        let error = |n: u32| {
            // Steps that swell and shrink threefold.
            let place = |i: u32| f64::from(i) / f64::from(n);
            let time: Vec<f64> = (0..=n).map(|i| place(i) + 0.08 * (TAU * place(i)).sin()).collect();
            let values: Vec<f64> = time.iter().map(|t| (TAU * 8.0 * t).cos()).collect();
            (at(&spectrum(&time, &values).expect("a spectrum"), 8.0) - 1.0).abs()
        };
        let rate = (error(400) / error(800)).log2();
        assert!(rate > 1.9, "{rate}");
    }

    #[test]
    fn a_long_interval_at_rest_hides_no_line() {
        // Nine tenths of the instants lie in the second half; one interval of a fiftieth at the
        // start, where the window is small.
        let mut time = vec![0.0];
        time.extend((0..=980).map(|i| 0.02 + 1e-3 * f64::from(i)));
        let values: Vec<f64> = time.iter().map(|t| (TAU * 100.0 * t).sin()).collect();
        let found = spectrum(&time, &values).expect("a spectrum");
        assert!((found.frequency.last().expect("lines") - 500.0).abs() < 1.0);
        assert!((at(&found, 100.0) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn nothing_comes_of_nothing() {
        assert_eq!(spectrum(&[], &[]), None);
        assert_eq!(spectrum(&[0.0; 20], &[1.0; 20]), None);
        let mut damaged: Vec<f64> = (0..20).map(f64::from).collect();
        for wrong in [f64::NAN, -1.0, f64::INFINITY] {
            damaged[7] = wrong;
            assert_eq!(spectrum(&damaged, &[1.0; 20]), None);
        }
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        let found = spectrum(&time, &[2.5; 100]).expect("a spectrum");
        assert!(found.amplitude.iter().all(|a| *a < 1e-14));
    }
}
