//! Shares in percent, for people.

/// A share in percent, with as many digits as say something.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent.abs() {
        p if p >= 10.0 => format!("{percent:.0} %"),
        p if p >= 1.0 => format!("{percent:.1} %"),
        p if p >= 0.01 || p <= 0.0 => format!("{percent:.2} %"),
        _ => format!("{percent:.0e} %"),
    }
}
