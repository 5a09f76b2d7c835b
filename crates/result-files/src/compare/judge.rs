//! The comparison as a whole.

use std::path::{Path, PathBuf};

use super::datasets::{Pair, peak};
use super::features;
use super::finding::{Deviation, Finding};
use super::tolerance::Rules;
use crate::error::ResultError;
use crate::stored::scenario_values::{Change, changes, read};
use crate::stored::{Kind, Stored};

/// End times may differ by this part of the time span: rounding.
const SAME_END: f64 = 1e-9;

/// Outcome of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The new file.
    pub new: PathBuf,
    /// The reference.
    pub reference: PathBuf,
    /// Instants of the reference.
    pub n_instants: usize,
    /// Largest deviation of every quantity, worst first.
    pub deviations: Vec<Deviation>,
    /// Differences that are no numbers.
    pub findings: Vec<Finding>,
    /// Datasets of the new result that the reference does not have; no difference.
    pub extra: Vec<String>,
    /// Scenario keys with other values; no difference by themselves.
    pub scenario: Vec<Change>,
    /// Patterns of the tolerance file that match nothing.
    pub unused: Vec<String>,
}

/// Compares the result `new` with `reference`.
///
/// # Errors
/// [`ResultError::File`] if one of them cannot be read, is damaged or is not a result file.
pub fn compare(new: &Path, reference: &Path, rules: &Rules) -> Result<Comparison, ResultError> {
    let (new, reference) = (Stored::open(new)?, Stored::open(reference)?);
    let peaks = unit_peaks(&reference)?;
    let pair = Pair { new: &new, reference: &reference, peaks: &peaks, rules };
    let (mut deviations, mut findings) = (Vec::new(), Vec::new());
    status(&new, &reference, &mut findings);
    end(&pair, &mut deviations, &mut findings);
    for name in reference.entries.keys() {
        pair.compare(name, &mut deviations, &mut findings)?;
    }
    features::impacts(&new.impacts, &reference.impacts, rules, &mut deviations, &mut findings);
    deviations.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    let features: Vec<&str> =
        deviations.iter().map(|d| d.name.split('[').next().unwrap_or_default()).collect();
    let datasets: Vec<&str> = reference.entries.keys().map(String::as_str).collect();
    let unused = rules.unused(&datasets, &features).into_iter().map(str::to_owned).collect();
    let is_extra = |name: &&String| !reference.entries.contains_key(*name);
    Ok(Comparison {
        n_instants: reference.time.len(),
        extra: new.entries.keys().filter(is_extra).cloned().collect(),
        scenario: changes(&read(&new.scenario), &read(&reference.scenario)),
        new: new.path().to_owned(),
        reference: reference.path().to_owned(),
        deviations,
        findings,
        unused,
    })
}

fn unit_peaks(reference: &Stored) -> Result<Vec<(String, f64)>, ResultError> {
    let mut peaks: Vec<(String, f64)> = Vec::new();
    for (name, entry) in reference.entries.iter().filter(|(_, e)| e.kind == Kind::Series) {
        let value = peak(&reference.values(name)?);
        match peaks.iter_mut().find(|(unit, _)| *unit == entry.unit) {
            Some((_, largest)) => *largest = largest.max(value),
            None => peaks.push((entry.unit.clone(), value)),
        }
    }
    Ok(peaks)
}

fn status(new: &Stored, reference: &Stored, findings: &mut Vec<Finding>) {
    let (a, b) = (new.attribute("status"), reference.attribute("status"));
    if a != b {
        let message = new.attribute("message");
        let why = if message.is_empty() { String::new() } else { format!(" ({message})") };
        findings.push(Finding::new("status", format!("{a}{why}, the reference's is {b}")));
    }
}

/// Compares the last instants.
fn end(pair: &Pair<'_>, deviations: &mut Vec<Deviation>, findings: &mut Vec<Finding>) {
    let tolerance = pair.rules.feature("final/time");
    match (pair.new.time.last(), pair.reference.time.last()) {
        (Some(new), Some(reference)) if tolerance.is_compared => {
            let span = (reference - pair.reference.time[0]).abs();
            let rtol = if tolerance.is_chosen { tolerance.rtol } else { SAME_END };
            deviations.push(Deviation {
                name: "final/time".to_owned(),
                unit: "s".to_owned(),
                time: Some(*reference),
                new: *new,
                reference: *reference,
                deviation: (new - reference).abs(),
                allowed: rtol * span + tolerance.atol,
            });
        }
        (None, Some(_)) => findings.push(Finding::new("time", "the new result has no instants")),
        _ => {}
    }
}
