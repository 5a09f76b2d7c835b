//! How far two bodies come nearer under a force beyond what their modes yield (docs/theory/uncertainty.md
//! Eq. U.3).

/// A term `a F^q`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Power {
    /// Factor.
    pub factor: f64,
    /// Exponent.
    pub exponent: f64,
}

/// Exponents that are tried: from the pressure below a point to springs that stiffen as they give way.
const EXPONENTS: [f64; 2] = [0.2, 1.2];
/// Exponents tried.
const TRIED: usize = 51;
/// Forces, as a share of the largest, that say nothing: there contact begins point by point.
const SMALL: f64 = 0.03;

impl Power {
    /// The term that fits the `samples`, pairs of force and value, best; none without force.
    pub fn fit(samples: &[(f64, f64)]) -> Option<Self> {
        let largest = samples.iter().map(|s| s.0).fold(0.0, f64::max);
        let telling: Vec<(f64, f64)> = samples
            .iter()
            .filter(|(force, value)| *force > SMALL * largest && value.is_finite())
            .map(|(force, value)| (force / largest, *value))
            .collect();
        let of_exponent = |i: usize| {
            let exponent = EXPONENTS[0] + (EXPONENTS[1] - EXPONENTS[0]) * i as f64 / (TRIED - 1) as f64;
            let (mut vu, mut uu, mut vv) = (0.0, 0.0, 0.0);
            for (force, value) in &telling {
                let unit = force.powf(exponent);
                (vu, uu, vv) = (vu + value * unit, uu + unit * unit, vv + value * value);
            }
            (vv - vu * vu / uu, Self { factor: vu / uu * largest.powf(-exponent), exponent })
        };
        let best = (0..TRIED).map(of_exponent).filter(|(_, term)| term.factor > 0.0);
        best.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, term)| term)
    }

    fn at(self, force: f64) -> f64 {
        self.factor * force.powf(self.exponent)
    }
}

/// Approach as a function of the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// What the run showed.
    pub shown: Power,
    /// Factor on it.
    pub scale: f64,
    /// What is taken from it.
    pub less: Option<Power>,
    /// Compliance that is added [m/N].
    pub more: f64,
}

/// Largest share of the approach that is taken away: beyond, the rest is a difference of two numbers that
/// are almost the same.
const MOST_TAKEN: f64 = 0.9;
/// Steps of the search for a force; halves alone would find it to 1e-18 of the first interval.
const SEARCH: usize = 60;

impl Law {
    /// The law that the run showed.
    pub fn shown(shown: Power) -> Self {
        Self { shown, scale: 1.0, less: None, more: 0.0 }
    }

    fn approach(&self, force: f64) -> f64 {
        let shown = self.shown.at(force);
        let less = self.less.map_or(0.0, |less| less.at(force).min(MOST_TAKEN * shown));
        self.scale * shown - less + self.more * force
    }

    /// The force at which the bodies, `free` \[m\] nearer without it and moved apart by `compliance`
    /// [m/N] by it within the step, have the approach that the law asks for; `near`: the force before.
    pub fn force(&self, free: f64, compliance: f64, near: f64) -> f64 {
        if free <= 0.0 {
            return 0.0;
        }
        let rest = |force: f64| self.approach(force) + compliance * force - free;
        let (mut low, mut high) = (0.0, near.max(1e-12 * free / (compliance + self.shown.factor)));
        while rest(high) < 0.0 {
            (low, high) = (high, 2.0 * high);
        }
        let (mut at_low, mut at_high) = (rest(low), rest(high));
        // The Illinois variant of the false position: the end that stays counts half.
        for _ in 0..SEARCH {
            let force = (low * at_high - high * at_low) / (at_high - at_low);
            let found = rest(force);
            if found.abs() <= 1e-12 * free || high - low <= 1e-14 * high {
                return force;
            }
            if found > 0.0 {
                (high, at_high, at_low) = (force, found, 0.5 * at_low);
            } else {
                (low, at_low, at_high) = (force, found, 0.5 * at_high);
            }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_is_found_again() {
        let samples: Vec<(f64, f64)> =
            (1..50).map(|i| (f64::from(i), 3e-6 * f64::from(i).powf(0.66))).collect();
        let found = Power::fit(&samples).expect("a fit");
        // 0.66 is one of the exponents that are tried.
        assert!(
            (found.exponent - 0.66).abs() < 1e-12 && (found.factor / 3e-6 - 1.0).abs() < 1e-9,
            "{found:?}"
        );
    }

    #[test]
    fn the_force_meets_the_law() {
        let law = Law {
            less: Some(Power { factor: 1e-8, exponent: 0.3 }),
            more: 1e-8,
            scale: 1.1,
            ..Law::shown(Power { factor: 1e-6, exponent: 2.0 / 3.0 })
        };
        for free in [1e-9, 1e-6, 1e-4] {
            let force = law.force(free, 2e-8, 0.0);
            assert!((law.approach(force) + 2e-8 * force - free).abs() < 1e-11 * free, "{free}");
        }
        assert!(law.force(-1.0, 1.0, 5.0).abs() <= 0.0, "none apart");
    }
}
