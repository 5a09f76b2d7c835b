//! SI prefixes for axes.

/// Prefixes with their powers of ten, rising.
const PREFIXES: [(i32, &str); 11] = [
    (-15, "f"),
    (-12, "p"),
    (-9, "n"),
    (-6, "µ"),
    (-3, "m"),
    (0, ""),
    (3, "k"),
    (6, "M"),
    (9, "G"),
    (12, "T"),
    (15, "P"),
];

/// Power of ten of the prefix that brings `largest` between 1 and 1000; 0 for numbers without unit,
/// zero and what is not finite.
///
/// `unit` must let a prefix stand before it without changing its power: `m/s` does, `m²` does not.
pub fn exponent(largest: f64, unit: &str) -> i32 {
    let takes_prefix = !unit.is_empty() && unit != "%" && !unit.starts_with("m²") && !unit.starts_with("m³");
    if !takes_prefix || !largest.is_finite() || largest <= 0.0 {
        return 0;
    }
    // 1e-9: a largest value of 0.9999999999 counts as 1.
    let power = (largest.log10() + 1e-9).floor() as i32;
    (3 * power.div_euclid(3)).clamp(PREFIXES[0].0, PREFIXES[PREFIXES.len() - 1].0)
}

/// `unit` with the prefix for `10^exponent`, which comes from [`exponent`].
pub fn prefixed(unit: &str, exponent: i32) -> String {
    let prefix = PREFIXES.iter().find(|(e, _)| *e == exponent).map_or("", |(_, p)| p);
    format!("{prefix}{unit}")
}

/// An integer in superscript digits.
pub fn superscript(n: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32('⁰' as u32 + c as u32 - '0' as u32).unwrap_or(c),
    };
    n.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefix_brings_the_largest_value_between_one_and_a_thousand() {
        for (largest, unit, wanted) in [
            (8.3e-5, "s", "µs"),
            (1.0e-3, "s", "ms"),
            (0.5, "s", "ms"),
            (52.0, "N", "N"),
            (5200.0, "N", "kN"),
            (2.1e11, "Pa", "GPa"),
            (0.1, "m/s", "mm/s"),
            (3.0e-21, "J", "fJ"),
        ] {
            assert_eq!(prefixed(unit, exponent(largest, unit)), wanted, "{largest} {unit}");
        }
    }

    #[test]
    fn powers_of_units_zero_and_nan_get_no_prefix() {
        for (largest, unit) in [(1e-6, "m²"), (0.0, "N"), (f64::NAN, "N"), (1e7, ""), (1e3, "%")] {
            assert_eq!(exponent(largest, unit), 0, "{largest} {unit}");
        }
    }

    #[test]
    fn superscripts_cover_all_digits() {
        assert_eq!(superscript(-1_234_567_890), "⁻¹²³⁴⁵⁶⁷⁸⁹⁰");
    }
}
