//! The study as a table for people and as JSON for programs.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};

use super::difference::{Difference, Quantity};
use super::outcome::{Impact, Outcome};
use super::peaks::{Peak, PeakKind};
use super::variant::Parameter;
use super::verdict::{Compared, Verdict};

/// The report in the folder of the runs.
pub const FILE: &str = "converge.json";

/// A finished study.
pub struct Study<'a> {
    /// The scenario file.
    pub scenario: &'a Path,
    /// Folder of the runs.
    pub folder: &'a Path,
    /// Largest relative change allowed.
    pub tolerance: f64,
    /// The run of the scenario as it is.
    pub base: &'a Outcome,
    /// Variants in the order of the report.
    pub variants: &'a [Compared],
    /// Parameters without meaning, and why.
    pub not_varied: &'a [(Parameter, &'static str)],
    /// The judgement.
    pub verdict: &'a Verdict,
}

/// A change in percent, in a column; small ones in powers of ten.
fn share(relative: f64) -> String {
    let percent = 100.0 * relative;
    match percent.abs() {
        p if !p.is_finite() => "-".into(),
        p if p > 0.0 && p < SMALL => format!("{percent:+.0e}"),
        _ => format!("{percent:+.4}"),
    }
}

/// Percentage of which four decimals show nothing.
const SMALL: f64 = 1e-4;

impl Study<'_> {
    /// For people. Writing to a string cannot fail.
    pub fn table(&self) -> String {
        let mut out = String::new();
        for (i, impact) in self.base.impacts.iter().enumerate() {
            self.impact(i + 1, impact, &mut out);
        }
        if self.base.impacts.is_empty() {
            let _ = writeln!(out, "no impact, final motions and what is asked for are compared\n");
        }
        self.velocities(&mut out);
        self.peaks(PeakKind::Displacement, "m", &mut out);
        self.peaks(PeakKind::Stress, "Pa", &mut out);
        self.remarks(&mut out);
        let _ = writeln!(out, "\n{}", self.verdict.sentence);
        out
    }

    fn impact(&self, number: usize, impact: &Impact, out: &mut String) {
        let Impact { contact, start, duration, peak_force, impulse, bands, .. } = impact;
        let _ = writeln!(
            out,
            "impact {number}, contact {contact}: at {start:.6e} s, peak {peak_force:.6} N, {duration:.5e} s long, impulse {impulse:.6e} N s"
        );
        let heads = ["change in %", "time", "peak", "duration", "impulse"];
        let _ = writeln!(
            out,
            "  {:<16} {:>11} {:>11} {:>11} {:>11}",
            heads[0], heads[1], heads[2], heads[3], heads[4]
        );
        let values = [peak_force, duration, impulse];
        let [peak, long, push] = [0, 1, 2].map(|k| share(bands[k] / values[k].abs()).replace('+', "±"));
        let _ = writeln!(out, "  {:<16} {:>11} {peak:>11} {long:>11} {push:>11}", "predicted", "-");
        for (name, difference) in self.complete() {
            let Some(change) = difference.impacts.iter().find(|i| i.number == number) else {
                let _ = writeln!(out, "  {name:<16} {:>11}", "missing");
                continue;
            };
            let [time, peak, duration, impulse] = change.changes.map(|c| share(c.relative));
            let _ = writeln!(out, "  {name:<16} {time:>11} {peak:>11} {duration:>11} {impulse:>11}");
        }
        out.push('\n');
    }

    fn velocities(&self, out: &mut String) {
        for motion in &self.base.motions {
            let [x, y, z] = motion.velocity;
            let _ = writeln!(out, "body {}: final velocity [{x:.6e}, {y:.6e}, {z:.6e}] m/s", motion.body);
        }
        let _ = writeln!(out, "  {:<16} of final velocities, of the largest speed in the run", "change in %");
        for (name, difference) in self.complete() {
            let list: Vec<String> = difference
                .velocities
                .iter()
                .map(|v| format!("{} {}", v.body, share(v.relative).trim_start_matches('+')))
                .collect();
            let _ = writeln!(out, "  {name:<16} {}", list.join("  "));
        }
    }

    /// Largest values of a `kind`; nothing if the scenario does not ask for any.
    fn peaks(&self, kind: PeakKind, unit: &str, out: &mut String) {
        let words = Quantity::from(kind).words();
        let of_base: Vec<&Peak> = self.base.peaks.iter().filter(|p| p.kind == kind).collect();
        for Peak { place, value, .. } in &of_base {
            let _ = writeln!(out, "{place}: {words} {value:.6e} {unit}");
        }
        if of_base.is_empty() {
            return;
        }
        let _ = writeln!(
            out,
            "  {:<16} of the {words} at each place, as a share of the largest one",
            "change in %"
        );
        for (name, difference) in self.complete() {
            let of_kind = difference.peaks.iter().filter(|p| p.peak.kind == kind);
            let list: Vec<String> =
                of_kind.map(|p| format!("{} {}", p.peak.place, share(p.relative))).collect();
            let _ = writeln!(out, "  {name:<16} {}", list.join("  "));
        }
    }

    fn remarks(&self, out: &mut String) {
        for c in self.variants {
            for count in c.difference.iter().flat_map(|d| &d.counts) {
                let name = &c.variant.name;
                let _ = writeln!(
                    out,
                    "{name}: {} impacts of contact {} instead of {}",
                    count.variant, count.contact, count.base
                );
            }
            if c.difference.is_none() {
                let _ = writeln!(out, "{}: {}: {}", c.variant.name, c.outcome.status, c.outcome.message);
            }
        }
        for (parameter, reason) in self.not_varied {
            let _ = writeln!(out, "{}: not varied, {reason}", parameter.name());
        }
    }

    fn complete(&self) -> impl Iterator<Item = (&str, &Difference)> {
        self.variants.iter().filter_map(|c| Some((c.variant.name.as_str(), c.difference.as_ref()?)))
    }

    /// For programs; `docs/is_it_right.md` has the keys.
    pub fn json(&self) -> Value {
        let limit = self.verdict.limit.as_ref().map(|(variant, l)| {
            json!({ "variant": variant, "quantity": l.quantity.name(), "where": l.place, "change": finite(l.relative) })
        });
        let not_varied =
            self.not_varied.iter().map(|(p, reason)| json!({ "name": p.name(), "reason": reason }));
        json!({
            "scenario": self.scenario.display().to_string(),
            "folder": self.folder.display().to_string(),
            "tolerance": self.tolerance,
            "converged": self.verdict.is_converged,
            "verdict": self.verdict.sentence,
            "limit": limit,
            "base": base(self.base),
            "variants": self.variants.iter().map(variant).collect::<Vec<_>>(),
            "not_varied": not_varied.collect::<Vec<_>>(),
        })
    }
}

/// A number, or null where JSON has none.
fn finite(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { Value::Null }
}

/// How a run ended.
fn run(outcome: &Outcome) -> Value {
    json!({ "result": outcome.result.display().to_string(), "status": outcome.status, "message": outcome.message,
        "exit_code": outcome.exit_code, "wall_time": outcome.wall_time, "reused": outcome.is_reused })
}

fn base(outcome: &Outcome) -> Value {
    let impacts = outcome.impacts.iter().enumerate().map(|(i, impact)| {
        json!({ "impact": i + 1, "contact": impact.contact, "start": impact.start, "duration": impact.duration,
            "peak_force": impact.peak_force, "impulse": impact.impulse,
            "peak_force_uncertainty": finite(impact.bands[0]), "duration_uncertainty": finite(impact.bands[1]),
            "impulse_uncertainty": finite(impact.bands[2]) })
    });
    let bodies = outcome
        .motions
        .iter()
        .map(|m| json!({ "body": m.body, "velocity": m.velocity, "angular_velocity": m.angular_velocity }));
    let peaks = outcome
        .peaks
        .iter()
        .map(|p| json!({ "place": p.place, "quantity": Quantity::from(p.kind).name(), "value": p.value }));
    json!({ "run": run(outcome), "impacts": impacts.collect::<Vec<_>>(), "bodies": bodies.collect::<Vec<_>>(),
        "peaks": peaks.collect::<Vec<_>>() })
}

fn variant(compared: &Compared) -> Value {
    let difference = compared.difference.as_ref();
    let impacts = difference.iter().flat_map(|d| &d.impacts).map(|i| {
        let values: serde_json::Map<String, Value> = Quantity::OF_IMPACT
            .iter()
            .zip(&i.changes)
            .map(|(q, c)| (q.name().to_owned(), json!({ "value": c.value, "change": finite(c.relative) })))
            .collect();
        let mut row = json!({ "impact": i.number, "contact": i.contact });
        if let Value::Object(map) = &mut row {
            map.extend(values);
        }
        row
    });
    let counts = difference.iter().flat_map(|d| &d.counts);
    let counts = counts.map(|c| json!({ "contact": c.contact, "base": c.base, "variant": c.variant }));
    let bodies = difference.iter().flat_map(|d| &d.velocities).map(|v| {
        json!({ "body": v.body, "velocity": v.velocity, "angular_velocity": v.angular_velocity,
            "change": finite(v.relative) })
    });
    let peaks = difference.iter().flat_map(|d| &d.peaks).map(|p| {
        json!({ "place": p.peak.place, "quantity": Quantity::from(p.peak.kind).name(), "value": p.peak.value,
            "change": finite(p.relative) })
    });
    json!({
        "name": compared.variant.name,
        "parameters": compared.variant.parameters.iter().map(|p| p.name()).collect::<Vec<_>>(),
        "subjects": compared.variant.subjects,
        "set": compared.variant.set,
        "run": run(&compared.outcome),
        "largest_change": compared.largest().map(|l| finite(l.relative)),
        "impacts": impacts.collect::<Vec<_>>(),
        "impact_counts": counts.collect::<Vec<_>>(),
        "bodies": bodies.collect::<Vec<_>>(),
        "peaks": peaks.collect::<Vec<_>>(),
    })
}
