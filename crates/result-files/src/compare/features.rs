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

/// A feature of an impact: name, unit, value, scale.
struct Feature {
    name: &'static str,
    unit: &'static str,
    of: fn(&ImpactRow) -> f64,
    scale: fn(&ImpactRow) -> f64,
}

const fn feature(
    name: &'static str,
    unit: &'static str,
    of: fn(&ImpactRow) -> f64,
    scale: fn(&ImpactRow) -> f64,
) -> Feature {
    Feature { name, unit, of, scale }
}

fn speed(row: &ImpactRow) -> f64 {
    row.approach_velocity.abs().max(row.separation_velocity.abs())
}

fn duration(row: &ImpactRow) -> f64 {
    row.end - row.start
}

/// All features, and the names by which patterns find them.
const FEATURES: [Feature; 9] = [
    feature("start", "s", |r| r.start, duration),
    feature("end", "s", |r| r.end, duration),
    feature("duration", "s", duration, duration),
    feature("peak_time", "s", |r| r.peak_time, duration),
    feature("peak_force", "N", |r| r.peak_force, |r| r.peak_force.abs()),
    feature("impulse", "N s", |r| r.impulse, |r| r.impulse.abs()),
    feature("approach_velocity", "m/s", |r| r.approach_velocity, speed),
    feature("separation_velocity", "m/s", |r| r.separation_velocity, speed),
    feature("restitution", "–", |r| r.restitution, |r| r.restitution.abs()),
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
