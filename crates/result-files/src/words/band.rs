//! Numbers with their bands.

/// What is shown where there is nothing.
pub const NOTHING: &str = "-";

/// A number with its band, both to two digits of the band, which are those that it is right to; to six digits without one.
pub fn within(x: f64, band: f64) -> String {
    let exponent = |x: f64| x.abs().log10().floor() as i32;
    if !x.is_finite() {
        return NOTHING.into();
    }
    let is_plain = x.abs() < 1e6 && x.abs() >= 1e-3;
    let (digits, bands) = match band > 0.0 && x.abs() > 0.0 {
        true => (exponent(x) - exponent(band) + 1, format!(" ± {}", rounded(band))),
        false => (5, String::new()),
    };
    let digits = digits.clamp(1, 9);
    if is_plain {
        let decimals = usize::try_from(digits - exponent(x)).unwrap_or(0);
        format!("{x:.decimals$}{bands}")
    } else {
        format!("{x:.0$e}{bands}", digits as usize)
    }
}

/// A band to two digits.
pub fn rounded(band: f64) -> String {
    if (1e-3..1e3).contains(&band) {
        let decimals = usize::try_from(1 - band.log10().floor() as i32).unwrap_or(0);
        format!("{band:.decimals$}")
    } else {
        format!("{band:.1e}")
    }
}
