//! Impacts of two results, matched in order for each contact.

use super::finding::{Deviation, Finding};
use super::tolerance::{Rules, Tolerance};
use super::track::difference;
use crate::tables::ImpactRow;

/// Times of an impact may differ by the relative tolerance times its duration, but by default not
/// by more than this \[s\].
const LARGEST_SHIFT: f64 = 0.5e-6;
/// Rounding of times, relative.
const TIME_ROUNDING: f64 = 1e-13;

/// A feature of an impact: name, unit, value, scale, band.
struct Feature {
    name: &'static str,
    unit: &'static str,
    of: fn(&ImpactRow) -> f64,
    scale: fn(&ImpactRow) -> f64,
    band: fn(&ImpactRow) -> f64,
}

const fn feature(
    name: &'static str,
    unit: &'static str,
    of: fn(&ImpactRow) -> f64,
    scale: fn(&ImpactRow) -> f64,
    band: fn(&ImpactRow) -> f64,
) -> Feature {
    Feature { name, unit, of, scale, band }
}

fn no_band(_: &ImpactRow) -> f64 {
    f64::NAN
}

fn speed(row: &ImpactRow) -> f64 {
    row.approach_velocity.abs().max(row.separation_velocity.abs())
}

fn duration(row: &ImpactRow) -> f64 {
    row.end - row.start
}

/// All features, and the names by which patterns find them.
const FEATURES: [Feature; 9] = [
    feature("start", "s", |r| r.start, duration, no_band),
    feature("end", "s", |r| r.end, duration, |r| r.duration_uncertainty),
    feature("duration", "s", duration, duration, |r| r.duration_uncertainty),
    feature("peak_time", "s", |r| r.peak_time, duration, no_band),
    feature("peak_force", "N", |r| r.peak_force, |r| r.peak_force.abs(), |r| r.peak_force_uncertainty),
    feature("impulse", "N s", |r| r.impulse, |r| r.impulse.abs(), |r| r.impulse_uncertainty),
    feature("approach_velocity", "m/s", |r| r.approach_velocity, speed, no_band),
    feature(
        "separation_velocity",
        "m/s",
        |r| r.separation_velocity,
        speed,
        |r| r.separation_velocity_uncertainty,
    ),
    feature("restitution", "–", |r| r.restitution, |r| r.restitution.abs(), |r| r.restitution_uncertainty),
];

/// Compares the impacts of two results.
pub fn impacts(
    new: &[ImpactRow],
    reference: &[ImpactRow],
    rules: &Rules,
    deviations: &mut Vec<Deviation>,
    findings: &mut Vec<Finding>,
) {
    let mut contacts: Vec<&str> = new.iter().chain(reference).map(|r| r.contact.as_str()).collect();
    contacts.sort_unstable();
    contacts.dedup();
    for contact in contacts {
        let of = |rows: &'_ [ImpactRow]| -> Vec<ImpactRow> {
            rows.iter().filter(|r| r.contact.as_str() == contact).cloned().collect()
        };
        let (new, reference) = (of(new), of(reference));
        let name = format!("impacts/{contact}");
        if new.len() != reference.len() && rules.feature(&name).is_compared {
            let what = format!("{} impacts, the reference has {}", new.len(), reference.len());
            findings.push(Finding::new(name, what));
        }
        for (i, (new, reference)) in new.iter().zip(&reference).enumerate() {
            for f in &FEATURES {
                let name = format!("impacts/{contact}/{}/{}", i + 1, f.name);
                let tolerance = rules.feature(&name);
                if tolerance.is_compared {
                    deviations.push(deviation(name, f, new, reference, tolerance));
                }
            }
        }
    }
}

fn deviation(
    name: String,
    f: &Feature,
    new: &ImpactRow,
    reference: &ImpactRow,
    tolerance: Tolerance,
) -> Deviation {
    let (value, expected) = ((f.of)(new), (f.of)(reference));
    let scale = (f.scale)(reference);
    let relative = tolerance.rtol * if scale.is_finite() { scale } else { 0.0 };
    let allowed = match f.unit {
        "s" if tolerance.is_chosen => relative,
        "s" => relative.min(LARGEST_SHIFT) + TIME_ROUNDING * reference.end.abs(),
        _ => relative,
    };
    // Two results, each off by its band at most, agree; nobody who chose a tolerance asked for that.
    let bands = (f.band)(new) + (f.band)(reference);
    let allowed = if tolerance.is_chosen { allowed } else { allowed.max(bands) };
    Deviation {
        name,
        unit: f.unit.to_owned(),
        time: Some(reference.start).filter(|t| t.is_finite()),
        new: value,
        reference: expected,
        deviation: difference(value, expected),
        allowed: allowed + tolerance.atol,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdf5::types::VarLenUnicode;

    fn row(peak_force: f64, band: f64) -> ImpactRow {
        ImpactRow {
            contact: VarLenUnicode::new(),
            start: 0.0,
            end: 1e-4,
            peak_force,
            peak_time: 5e-5,
            impulse: 1.0,
            approach_velocity: 1.0,
            separation_velocity: 1.0,
            restitution: 1.0,
            peak_force_uncertainty: band,
            duration_uncertainty: f64::NAN,
            impulse_uncertainty: f64::NAN,
            separation_velocity_uncertainty: f64::NAN,
            restitution_uncertainty: f64::NAN,
            uncertainty: VarLenUnicode::new(),
            peak_time_uncertainty: f64::NAN,
        }
    }

    #[test]
    fn results_agree_within_both_bands_unless_a_tolerance_is_given() {
        // Five thousandths apart: more than the default, less than three and four thousandths together.
        let allows = |rtol: Option<f64>, [own, other]: [f64; 2]| {
            let rules = Rules::read(None, rtol, None).expect("the defaults");
            let (mut deviations, mut findings) = (Vec::new(), Vec::new());
            impacts(&[row(1005.0, own)], &[row(1000.0, other)], &rules, &mut deviations, &mut findings);
            let peak = deviations.iter().find(|d| d.name.ends_with("/peak_force")).expect("compared");
            peak.deviation <= peak.allowed
        };
        assert!(allows(None, [3.0, 4.0]));
        assert!(!allows(None, [1.0, 2.0]) && !allows(None, [3.0, f64::NAN]));
        assert!(!allows(Some(1e-3), [3.0, 4.0]));
    }
}
