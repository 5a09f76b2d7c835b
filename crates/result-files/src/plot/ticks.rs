//! Where axes are divided, and what stands there.

pub mod units;

use units::superscript;

/// A division of an axis: where, and its label.
pub type Tick = (f64, String);

/// About `wanted` divisions of `low..high` at multiples of 1, 2 or 5 times a power of ten, with as
/// many decimals as they need.
pub fn linear(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    if high <= low || !(high - low).is_finite() {
        return Vec::new();
    }
    let raw = (high - low) / wanted.max(1) as f64;
    let power = raw.log10().floor();
    let base = 10f64.powf(power);
    // Geometric means between the candidates.
    let step = match raw / base {
        m if m < 1.5 => base,
        m if m < 3.2 => 2.0 * base,
        m if m < 7.1 => 5.0 * base,
        _ => 10.0 * base,
    };
    let decimals = (-(step * 1.000_001).log10().floor()).max(0.0) as usize;
    // Divisions on the ends count although they are round-off outside.
    let slack = 1e-9 * (high - low);
    let first = ((low - slack) / step).ceil() as i64;
    let last = ((high + slack) / step).floor() as i64;
    (first..=last)
        .map(|i| {
            let value = i as f64 * step;
            (value, signed(value, decimals))
        })
        .collect()
}

/// Divisions of a logarithmic axis from `10^low` to `10^high`, at most `wanted` or so: powers of
/// ten, and on short axes 2 and 5 times them.
pub fn logarithmic(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    if high <= low || !(high - low).is_finite() {
        return Vec::new();
    }
    let (first, last) = (low.floor() as i32, high.ceil() as i32);
    let inside = |x: f64| x >= low - 1e-9 && x <= high + 1e-9;
    if high - low < 2.0 {
        let fine = (first..=last).flat_map(|n| [1, 2, 5].map(|m| (n, m)));
        return fine
            .map(|(n, m)| {
                let label = if m == 1 {
                    format!("10{}", superscript(n))
                } else {
                    format!("{m}·10{}", superscript(n))
                };
                (f64::from(n) + f64::from(m).log10(), label)
            })
            .filter(|(x, _)| inside(*x))
            .collect();
    }
    let every = ((high - low) / wanted.max(1) as f64).ceil().max(1.0) as i32;
    (first..=last)
        .filter(|n| n.rem_euclid(every) == 0 && inside(f64::from(*n)))
        .map(|n| (f64::from(n), format!("10{}", superscript(n))))
        .collect()
}

/// A number with the minus sign of typography, zero without sign.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value.abs());
    let is_zero = text.chars().all(|c| c == '0' || c == '.');
    if value < 0.0 && !is_zero { format!("−{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: Vec<Tick>) -> Vec<String> {
        ticks.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn divisions_are_round_and_inside() {
        assert_eq!(labels(linear(0.0, 100.0, 5)), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(labels(linear(-0.26, 0.26, 5)), ["−0.2", "−0.1", "0.0", "0.1", "0.2"]);
        assert_eq!(labels(linear(0.0, 82.7, 6)), ["0", "10", "20", "30", "40", "50", "60", "70", "80"]);
    }

    #[test]
    fn logarithmic_divisions_fit_the_length() {
        assert_eq!(labels(logarithmic(14.9, 18.1, 5)), ["10¹⁵", "10¹⁶", "10¹⁷", "10¹⁸"]);
        assert_eq!(labels(logarithmic(17.5, 18.4, 5)), ["5·10¹⁷", "10¹⁸", "2·10¹⁸"]);
        assert!(logarithmic(0.0, 40.0, 5).len() <= 6);
    }

    #[test]
    fn empty_and_undefined_ranges_have_no_divisions() {
        for (low, high) in [(1.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (2.0, 1.0)] {
            assert!(linear(low, high, 5).is_empty() && logarithmic(low, high, 5).is_empty());
        }
    }
}
