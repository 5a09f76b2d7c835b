//! What a comparison found, for people and for programs.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::finding::Deviation;
use super::judge::Comparison;

/// Rows of the table that agree, at most.
const SHOWN_AGREEING: usize = 12;
/// Rows of the table that differ, at most.
const SHOWN_DIFFERING: usize = 40;

impl Comparison {
    /// Quantities that differ, and all that were compared.
    pub fn counts(&self) -> (usize, usize) {
        let differing = self.deviations.iter().filter(|d| d.is_difference()).count();
        (self.findings.len() + differing, self.findings.len() + self.deviations.len())
    }

    /// As a table, worst first. Writing to a string cannot fail.
    pub fn table(&self) -> String {
        let mut out = String::new();
        for change in &self.scenario {
            let _ = writeln!(out, "scenario: {change}");
        }
        for finding in &self.findings {
            let _ = writeln!(out, "{}: {}", finding.name, finding.what);
        }
        self.only_new(&mut out);
        if !out.is_empty() {
            out.push('\n');
        }
        self.rows(&mut out);
        let (differing, all) = self.counts();
        let instants = self.n_instants;
        let _ = if differing == 0 {
            let worst = self.deviations.first().map_or(0.0, Deviation::ratio);
            writeln!(
                out,
                "agrees: {all} quantities on {instants} instants, the worst at {} of what is allowed",
                times(worst)
            )
        } else {
            writeln!(out, "differs: {differing} of {all} quantities on {instants} instants")
        };
        out
    }

    fn only_new(&self, out: &mut String) {
        let Some((first, more)) = self.extra.split_first() else { return };
        let _ = match more.len() {
            0 => writeln!(out, "only in the new result: {first}"),
            n => writeln!(out, "only in the new result: {first} and {n} more datasets"),
        };
    }

    fn rows(&self, out: &mut String) {
        let differing = self.deviations.iter().filter(|d| d.is_difference()).count();
        let shown = differing.clamp(SHOWN_AGREEING, SHOWN_DIFFERING).min(self.deviations.len());
        let rows = &self.deviations[..shown];
        let width = rows.iter().map(|d| d.name.chars().count()).max().unwrap_or(0).max(8);
        let _ = writeln!(
            out,
            "{:<width$} {:>13} {:>14} {:>14} {:>10} {:>10} {:>10}  unit",
            "quantity", "at [s]", "new", "reference", "deviation", "allowed", "of allowed"
        );
        for d in rows {
            let time = d.time.map_or_else(|| "-".to_owned(), |t| format!("{t:.6e}"));
            let mark = if d.is_difference() { " <-- differs" } else { "" };
            let _ = writeln!(
                out,
                "{:<width$} {time:>13} {:>14.7e} {:>14.7e} {:>10.2e} {:>10.2e} {:>10}  {}{mark}",
                d.name,
                d.new,
                d.reference,
                d.deviation,
                d.allowed,
                times(d.ratio()),
                d.unit
            );
        }
        let more = self.deviations.len() - shown;
        if more > 0 {
            let worst = self.deviations[shown].ratio();
            let _ = writeln!(out, "and {more} more, at most at {} of what is allowed", times(worst));
        }
        out.push('\n');
    }

    /// As JSON; numbers that JSON cannot hold are `null`.
    pub fn json(&self) -> Value {
        let (differing, all) = self.counts();
        let deviations = self.deviations.iter().map(|d| {
            json!({ "name": d.name, "unit": d.unit, "time": d.time, "new": d.new, "reference": d.reference,
                "deviation": d.deviation, "allowed": d.allowed, "ratio": d.ratio(), "differs": d.is_difference() })
        });
        let findings = self.findings.iter().map(|f| json!({ "name": f.name, "what": f.what }));
        let changes = self.scenario.iter().map(ToString::to_string);
        json!({
            "agrees": differing == 0, "differing": differing, "compared": all, "instants": self.n_instants,
            "new": self.new.display().to_string(), "reference": self.reference.display().to_string(),
            "findings": findings.collect::<Vec<_>>(), "quantities": deviations.collect::<Vec<_>>(),
            "extra": self.extra, "scenario_changes": changes.collect::<Vec<_>>(),
        })
    }
}

/// A ratio as per cent, or as a multiple where it is large.
fn times(ratio: f64) -> String {
    match ratio {
        r if r.is_infinite() => "no limit".to_owned(),
        r if r >= 10.0 => format!("{r:.0} x"),
        r if r > 1.0 => format!("{r:.2} x"),
        r if r > 0.0 && r < 1e-4 => "< 0.01 %".to_owned(),
        r => format!("{:.2} %", 100.0 * r),
    }
}
