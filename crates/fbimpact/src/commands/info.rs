//! `fbimpact info`: the gist of a result file.

use std::fmt::Write as _;
use std::path::Path;

use super::{print, ratio};
use crate::error::AppError;
use crate::results::summary::{self, Summary};

/// Prints the summary of a result file.
///
/// # Errors
/// [`AppError::Io`] if the file cannot be read.
pub fn info(file: &Path, json: bool) -> Result<(), AppError> {
    let summary = summary::read(file)?;
    let text = if json { format!("{:#}\n", summary.json()) } else { table(&summary) };
    print(&text)
}

/// The summary for people. Writing to a string cannot fail.
fn table(s: &Summary) -> String {
    let mut out = String::new();
    for (name, value) in s.attributes.iter().filter(|(_, value)| !value.is_empty()) {
        let _ = writeln!(out, "{name:<16} {value}");
    }
    if s.resumptions > 0 {
        let times = if s.resumptions == 1 { "once".to_owned() } else { format!("{} times", s.resumptions) };
        let _ = writeln!(out, "{:<16} resumed {times}, timings are those since", "interruptions");
    }
    let end = s.end.map_or_else(|| "-".to_owned(), |t| format!("{t:.9e} s"));
    let _ = writeln!(out, "{:<16} {} up to t = {end}", "samples", s.n_samples);
    let drift = s.energy_drift.map_or_else(|| "-".to_owned(), |d| format!("{d:.3e}"));
    let _ = writeln!(out, "{:<16} {drift}", "energy drift");
    if let Some(removed) = s.numerical_damping.filter(|removed| removed.abs() > 0.0) {
        let _ = writeln!(
            out,
            "{:<16} {removed:.3e} of the largest energy, by the implicit integrator",
            "numerical loss"
        );
    }
    if let Some(jump) = s.largest_jump {
        let _ = writeln!(
            out,
            "{:<16} {jump:.3e} at most in {} changes of the model",
            "energy jump",
            s.transfers.len()
        );
    }
    for line in &s.warnings {
        let _ = writeln!(out, "{:<16} {line}", "warning");
    }
    bodies(s, &mut out);
    phases(s, &mut out);
    if !s.impacts.is_empty() {
        let _ = writeln!(
            out,
            "\n{:<7} {:<12} {:>14} {:>13} {:>12} {:>14} {:>13} {:>12}",
            "impact",
            "contact",
            "start [s]",
            "duration [s]",
            "peak [N]",
            "peak at [s]",
            "impulse [N s]",
            "restitution"
        );
    }
    for (n, i) in s.impacts.iter().enumerate() {
        let _ = writeln!(
            out,
            "{:<7} {:<12} {:>14.6e} {:>13.5e} {:>12.5} {:>14.6e} {:>13.6e} {:>12}",
            n + 1,
            i.contact.as_str(),
            i.start,
            i.end - i.start,
            i.peak_force,
            i.peak_time,
            i.impulse,
            ratio(i.restitution)
        );
    }
    reactions(s, &mut out);
    tries(s, &mut out);
    if !s.timings.is_empty() {
        out.push('\n');
    }
    for (name, seconds) in &s.timings {
        let _ = writeln!(out, "{name:<16} {seconds:>10.4} s");
    }
    out
}

fn phases(s: &Summary, out: &mut String) {
    if !s.phases.is_empty() {
        let _ = writeln!(
            out,
            "\n{:<8} {:>14} {:>14} {:>9} {:>9} {:>12} {:>10}",
            "phase", "start [s]", "end [s]", "steps", "rejected", "evaluations", "wall [s]"
        );
    }
    for p in &s.phases {
        let _ = writeln!(
            out,
            "{:<8} {:>14.6e} {:>14.6e} {:>9} {:>9} {:>12} {:>10.3}",
            p.kind.as_str(),
            p.start,
            p.end,
            p.steps,
            p.rejected,
            p.evaluations,
            p.wall_time
        );
    }
}

fn reactions(s: &Summary, out: &mut String) {
    if !s.reactions.is_empty() {
        let _ = writeln!(
            out,
            "\n{:<16} {:>14} {:>14} {:>16} {:>14}",
            "joint", "peak [N]", "at [s]", "peak [N m]", "at [s]"
        );
    }
    for r in &s.reactions {
        let _ = writeln!(
            out,
            "{:<16} {:>14.6} {:>14.6e} {:>16.6e} {:>14.6e}",
            r.joint, r.force, r.force_time, r.moment, r.moment_time
        );
    }
}

/// Bodies, and what the program chose for them.
fn bodies(s: &Summary, out: &mut String) {
    for (name, n) in &s.bodies {
        let _ = writeln!(out, "{:<16} {name}: {n} elastic coordinates", "body");
        for note in s.chosen.iter().filter(|note| note.body == *name) {
            let _ = writeln!(out, "{:<16} {name}: {}", "", note.text);
        }
    }
}

fn tries(s: &Summary, out: &mut String) {
    if !s.tries.is_empty() {
        let _ = writeln!(
            out,
            "\n{:<7} {:>4} {:>12} {:>19} {:>9} {:>10} {:>9} {:>7} {:>11} {:>9} {:<9} reason",
            "impact",
            "try",
            "stop [s]",
            "width [m]",
            "used [%]",
            "penalty",
            "freedoms",
            "steps",
            "peak [N]",
            "wall [s]",
            "outcome"
        );
    }
    for t in &s.tries {
        let directions = if t.interval_widths[1] > 0.0 { 2 } else { 1 };
        let list = |of: &[f64; 2], show: fn(f64) -> String| {
            of.iter().take(directions).map(|x| show(*x)).collect::<Vec<_>>().join(" x ")
        };
        let _ = writeln!(
            out,
            "{:<7} {:>4} {:>12.5e} {:>19} {:>9} {:>10.3e} {:>9} {:>7} {:>11.5} {:>9.3} {:<9} {}",
            t.impact + 1,
            t.number,
            t.stop,
            list(&t.interval_widths, |w| format!("{w:.2e}")),
            list(&t.utilisation, |u| format!("{:.0}", 100.0 * u)),
            t.penalty_end,
            t.freedoms,
            t.steps,
            t.peak_force,
            t.wall_time,
            t.outcome.as_str(),
            t.reason.as_str()
        );
    }
}
