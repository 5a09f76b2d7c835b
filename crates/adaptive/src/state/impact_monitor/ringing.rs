//! How a force rings about its mean at its peak, told from the lulls between which that stands.

/// Share of the time since the first touch that a period of ringing takes at most: longer ones are what
/// waves and sub-impacts make.
const SHORT_PERIOD: f64 = 0.1;

/// A force that rings about its mean at its peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ringing {
    /// The mean there \[N\].
    pub mean: f64,
    /// When \[s\].
    pub time: f64,
    /// How far the peak is above it, as a share of it.
    pub share: f64,
    /// Period \[s\].
    pub period: f64,
}

/// Times and forces of lulls, instants of least force between two larger ones \[s, N\].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lulls {
    last: Option<(f64, f64)>,
    around_peak: [Option<(f64, f64)>; 2],
}

impl Lulls {
    /// Looks at times and forces of three instants in a row.
    pub fn see(&mut self, [(_, before), lull, (_, after)]: [(f64, f64); 3]) {
        if lull.1 < before && lull.1 <= after {
            self.last = Some(lull);
            self.around_peak[1] = self.around_peak[1].or(self.last);
        }
    }

    /// Takes note of a new largest force.
    pub fn rise(&mut self) {
        self.around_peak = [self.last, None];
    }

    /// How the force rings at its `peak`, time and force, between the lulls before and after it, if it does; the touch lasted for the time `lasted`
    /// \[s\].
    pub fn ringing(&self, (time, peak): (f64, f64), lasted: f64) -> Option<Ringing> {
        let [(first, before), (last, after)] = [self.around_peak[0]?, self.around_peak[1]?];
        let (period, mean) = (last - first, 0.5 * (peak + 0.5 * (before + after)));
        let is_ringing = before.min(after) > 0.0 && period < SHORT_PERIOD * lasted;
        is_ringing.then(|| Ringing { mean, time, share: peak / mean - 1.0, period })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn ringing_at_the_peak_is_told_from_its_lulls() {
        // A half sine of 1 s that rings by a share forty times a second.
        let of = |share: f64| {
            let at = |i: i32| {
                let t = f64::from(i) * 5e-4;
                (t, 10.0 * (PI * t).sin() * (1.0 + share * (80.0 * PI * t).cos()))
            };
            let (mut lulls, mut peak) = (Lulls::default(), (0.0, 0.0));
            for i in 2..=2000 {
                lulls.see([at(i - 2), at(i - 1), at(i)]);
                if at(i).1 > peak.1 {
                    peak = at(i);
                    lulls.rise();
                }
            }
            lulls.ringing(peak, 1.0)
        };
        let found = of(0.05).expect("it rings");
        // The half sine falls by 0.08 % to the lulls.
        assert!((found.mean / 10.0 - 1.0).abs() < 1e-3 && (found.share - 0.05).abs() < 1e-3, "{found:?}");
        // Two instants.
        assert!((found.period - 0.025).abs() < 1e-3 && (found.time - 0.5).abs() < 1e-3, "{found:?}");
        assert_eq!(of(0.0), None);
    }
}
