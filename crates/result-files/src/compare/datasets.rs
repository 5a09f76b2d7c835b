//! One dataset against the reference's.

use super::align::{self, Coordinates};
use super::finding::{Deviation, Finding};
use super::tolerance::{Rules, Tolerance};
use super::track::{Track, difference};
use crate::error::ResultError;
use crate::stored::{Entry, Kind, Stored};

/// Part of the largest value with the same unit that is rounding: what is zero by symmetry is
/// compared with this.
const ROUNDING: f64 = 1e-11;
/// Frequencies are compared one by one, from this part of the largest one on.
const LOWEST_FREQUENCY: f64 = 1e-6;
/// Groups of which the last row is a feature.
const STATE_GROUPS: [&str; 5] = ["energies", "momentum", "bodies", "points", "joints"];

/// Two open results.
pub struct Pair<'a> {
    /// The new result.
    pub new: &'a Stored,
    /// The reference.
    pub reference: &'a Stored,
    /// Largest magnitude in the reference, by unit.
    pub peaks: &'a [(String, f64)],
    /// What is allowed.
    pub rules: &'a Rules,
}

/// The largest finite magnitude.
pub fn peak<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().map(|v| v.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max)
}

/// What keeps `new` from being compared with `reference`.
fn obstacle(new: &Entry, reference: &Entry) -> Option<String> {
    // A table may have more columns than the reference has.
    let has_column = |column: &str| new.unit.split(", ").any(|own| own == column);
    let is_wider = reference.kind == Kind::Other && reference.unit.split(", ").all(has_column);
    if new.unit != reference.unit && !is_wider {
        return Some(format!("unit is \"{}\", the reference's is \"{}\"", new.unit, reference.unit));
    }
    let (a, b) = match reference.kind {
        // A table has as many rows as it has; a series is interpolated.
        Kind::Other => return None,
        Kind::Series => (&new.shape[1.min(new.shape.len())..], &reference.shape[1..]),
        Kind::Fixed => (&new.shape[..], &reference.shape[..]),
    };
    if a != b || new.shape.len() != reference.shape.len() {
        return Some(format!("shape is {:?}, the reference's is {:?}", new.shape, reference.shape));
    }
    if new.kind != reference.kind {
        let rows = new.shape.first().copied().unwrap_or(1);
        return Some(match (new.kind, reference.kind) {
            (Kind::Fixed, Kind::Series) => format!("{rows} rows, which is not the length of /time"),
            _ => "holds something else than the reference's".to_owned(),
        });
    }
    None
}

impl Pair<'_> {
    /// Compares the dataset `name` of the reference.
    ///
    /// # Errors
    /// [`ResultError::File`] if it cannot be read.
    pub fn compare(
        &self,
        name: &str,
        deviations: &mut Vec<Deviation>,
        findings: &mut Vec<Finding>,
    ) -> Result<(), ResultError> {
        let tolerance = self.rules.dataset(name);
        let reference = &self.reference.entries[name];
        let Some(new) = self.new.entries.get(name) else {
            findings.push(Finding::new(name, "missing in the new result"));
            return Ok(());
        };
        if !tolerance.is_compared {
            return Ok(());
        }
        if let Some(what) = obstacle(new, reference) {
            findings.push(Finding::new(name, what));
            return Ok(());
        }
        match reference.kind {
            Kind::Series => self.series(name, reference, tolerance, deviations, findings),
            Kind::Fixed => self.fixed(name, reference, tolerance, deviations),
            Kind::Other => Ok(()),
        }
    }

    fn series(
        &self,
        name: &str,
        entry: &Entry,
        tolerance: Tolerance,
        deviations: &mut Vec<Deviation>,
        findings: &mut Vec<Finding>,
    ) -> Result<(), ResultError> {
        let width = entry.width();
        let (mut new, mut reference) = (self.new.values(name)?, self.reference.values(name)?);
        self.align(name, width, &mut new, &mut reference)?;
        let units: Vec<&str> = entry.unit.split(", ").collect();
        let whole = peak(&reference);
        let mut all = Vec::with_capacity(width);
        let mut last = Vec::with_capacity(width);
        let final_name = format!("final/{name}");
        let final_tolerance = self.rules.feature(&final_name);
        for column in 0..width {
            let track = |times, values| Track { times, values, width, column };
            let (n, r) = (track(&self.new.time, &new[..]), track(&self.reference.time, &reference[..]));
            let has_units = units.len() == width && width > 1;
            let own = || peak(reference.iter().skip(column).step_by(width));
            let (unit, scale) = if has_units { (units[column], own()) } else { (entry.unit.as_str(), whole) };
            let floor = ROUNDING * self.unit_peak(unit);
            let make = |tolerance: Tolerance, time, new, reference, deviation| Deviation {
                name: label(name, width, column),
                unit: unit.to_owned(),
                time: Some(time),
                new,
                reference,
                deviation,
                allowed: tolerance.rtol * if tolerance.has_unit_scale { self.unit_peak(unit) } else { scale }
                    + tolerance.atol
                    + floor,
            };
            let Some(w) = n.worst(&r, tolerance.is_stepwise) else {
                let what = "has no instant within the time span of the reference";
                findings.push(Finding::new(name, what));
                return Ok(());
            };
            all.push(make(tolerance, w.time, w.new, w.reference, w.deviation));
            let (a, b) = (n.value(self.new.time.len() - 1), r.value(self.reference.time.len() - 1));
            let end = self.reference.time[self.reference.time.len() - 1];
            let mut at_end = make(final_tolerance, end, a, b, difference(a, b));
            at_end.name = label(&final_name, width, column);
            last.push(at_end);
        }
        let worst = |of: Vec<Deviation>| of.into_iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
        deviations.extend(worst(all));
        if is_state(name) && final_tolerance.is_compared {
            deviations.extend(worst(last));
        }
        Ok(())
    }

    fn align(
        &self,
        name: &str,
        width: usize,
        new: &mut [f64],
        reference: &mut [f64],
    ) -> Result<(), ResultError> {
        if name.ends_with("/rotation") && width == 4 {
            let first = reference.get(..4).map_or([1.0; 4].to_vec(), <[f64]>::to_vec);
            align::quaternions(reference, &first);
            align::quaternions(new, &first);
        }
        let body =
            name.strip_suffix("/elastic_coordinates").or_else(|| name.strip_suffix("/elastic_velocities"));
        let frequencies = body.map(|body| format!("{body}/eigenfrequencies"));
        if let Some(path) = frequencies.filter(|path| self.reference.entries.contains_key(path)) {
            let frequencies = self.reference.values(&path)?;
            if frequencies.len() == width {
                let mut reference = Coordinates { times: &self.reference.time, values: reference };
                let mut new = Coordinates { times: &self.new.time, values: new };
                align::modes(&mut reference, &mut new, &frequencies);
            }
        }
        Ok(())
    }

    fn fixed(
        &self,
        name: &str,
        entry: &Entry,
        tolerance: Tolerance,
        deviations: &mut Vec<Deviation>,
    ) -> Result<(), ResultError> {
        let (new, reference) = (self.new.values(name)?, self.reference.values(name)?);
        let whole = peak(&reference);
        let each = name.ends_with("/eigenfrequencies");
        let width = reference.len();
        let all = new.iter().zip(&reference).enumerate().map(|(i, (a, b))| {
            let scale = if each { b.abs().max(LOWEST_FREQUENCY * whole) } else { whole };
            Deviation {
                name: label(name, width, i),
                unit: entry.unit.clone(),
                time: None,
                new: *a,
                reference: *b,
                deviation: difference(*a, *b),
                allowed: tolerance.rtol * scale + tolerance.atol,
            }
        });
        deviations.extend(all.max_by(|a, b| a.ratio().total_cmp(&b.ratio())));
        Ok(())
    }

    /// The largest value with the unit; that of an angular momentum is a momentum times a length,
    /// if that is more, that of a moment a force times a length.
    fn unit_peak(&self, unit: &str) -> f64 {
        let of = |unit: &str| self.peaks.iter().find(|(u, _)| u == unit).map_or(0.0, |(_, peak)| *peak);
        match unit {
            "kg m²/s" => of(unit).max(of("kg m/s") * of("m")),
            "N m" => of(unit).max(of("N") * of("m")),
            _ => of(unit),
        }
    }
}

/// Whether the last row of a dataset is a feature. Elastic coordinates are compared as series only.
fn is_state(name: &str) -> bool {
    STATE_GROUPS.contains(&name.split('/').next().unwrap_or_default()) && !name.contains("/elastic_")
}

fn label(name: &str, width: usize, column: usize) -> String {
    if width > 1 { format!("{name}[{column}]") } else { name.to_owned() }
}
