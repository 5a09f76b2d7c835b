//! What makes the band of a peak force as narrow as it is wanted (docs/theory/uncertainty.md Eq. U.14).

use crate::record::band::Source;

/// Most times as many elements as usual that a zone gets.
pub const MOST_FINER: f64 = 4.0;
/// Most times as stiff that springs get at once.
const MOST_STIFFER: f64 = 100.0;
/// Share of what other sources leave that zone and penalty together are to have: estimates of two models differ.
const AIM: f64 = 0.9;

/// What is to be different in the next trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remedy {
    /// How many times as many elements across the zone, a whole number.
    pub finer: f64,
    /// How many times as stiff springs.
    pub stiffer: f64,
}

/// What brings the parts `shares` of a band down to `accuracy` together, a share of the peak force: parts of the zone fall
/// with the square of its elements, those of springs with their stiffness. None if they are there already, or other parts alone
/// are more.
pub fn remedy(shares: &[(Source, f64)], accuracy: f64) -> Option<Remedy> {
    let sum = |of: &dyn Fn(Source) -> bool| {
        shares.iter().filter(|(source, _)| of(*source)).map(|(_, share)| share).sum::<f64>()
    };
    let [zone, springs] = [Source::Zone, Source::Penalty].map(|wanted| sum(&|source| source == wanted));
    let others = sum(&|source| !matches!(source, Source::Zone | Source::Penalty));
    let left = AIM * (accuracy - others);
    if zone + springs + others <= accuracy || left <= 0.0 {
        return None;
    }
    // Each to half of what is left, or as it is.
    let times = |part: f64, other: f64| part / (left - other.min(0.5 * left));
    let finer = times(zone, springs).sqrt().ceil().clamp(1.0, MOST_FINER);
    let stiffer = times(springs, zone).clamp(1.0, MOST_STIFFER);
    Some(Remedy { finer, stiffer })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zone_and_springs_share_what_others_leave() {
        let of = |zone, springs, modes| {
            remedy(&[(Source::Zone, zone), (Source::Penalty, springs), (Source::Modes, modes)], 1e-2)
        };
        assert_eq!(of(4e-3, 3e-3, 2e-3), None, "it is there");
        assert_eq!(of(4e-3, 3e-3, 1.1e-2), None, "modes alone are too much");
        // 0.9 of 1e-2: 8.9e-3 beside a small part of springs, a quarter of which is less.
        assert_eq!(of(3e-2, 1e-4, 0.0), Some(Remedy { finer: 2.0, stiffer: 1.0 }));
        let found = of(1e-4, 3e-2, 0.0).expect("stiffer");
        assert!(
            (found.stiffer - 3e-2 / 8.9e-3).abs() < 1e-12 && (found.finer - 1.0).abs() <= 0.0,
            "{found:?}"
        );
        let both = of(3e-2, 3e-2, 0.0).expect("both");
        // Each has half of 9e-3.
        assert!((both.stiffer - 3e-2 / 4.5e-3).abs() < 1e-12 && (both.finer - 3.0).abs() <= 0.0, "{both:?}");
        let after = 3e-2 / both.finer.powi(2) + 3e-2 / both.stiffer;
        assert!(after <= 1e-2, "{after}");
    }
}
