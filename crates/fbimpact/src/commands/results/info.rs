//! `fbimpact info`: the gist of a result file.

use std::fmt::Write as _;
use std::path::Path;

use result_files::stored::Stored;
use result_files::stored::peak::Peak;
use result_files::stored::summary::{self, Summary};
use result_files::tables::{EventRow, ImpactRow, PhaseRow, TableRow, TrialRow};
use result_files::words::band::{NOTHING, within};
use result_files::words::shown::short;
use result_files::words::table::{Shown, heading, table, with_unit};

use crate::commands::print;
use crate::error::AppError;
use crate::results::columns;

/// Events that are shown at most: more than a screen says nothing.
const MOST_EVENTS: usize = 40;

/// Prints the summary of a result file, whose datasets are all looked at first if `check` is set.
///
/// # Errors
/// [`AppError::Io`] if the file cannot be read.
pub fn info(file: &Path, json: bool, check: bool) -> Result<(), AppError> {
    if check {
        Stored::open(file)?.check()?;
    }
    let summary = summary::read(file)?;
    let text = if json { format!("{:#}\n", summary.json()) } else { for_people(&summary) };
    print(&text)
}

/// The summary for people. Writing to a string cannot fail.
fn for_people(s: &Summary) -> String {
    let mut out = String::new();
    for (name, value) in s.attributes.iter().filter(|(_, value)| !value.is_empty()) {
        let _ = writeln!(out, "{name:<16} {}", short(value));
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
        let _ =
            writeln!(out, "{:<16} {removed:.3e} of the largest energy, by the integrator", "numerical loss");
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
    table(&s.phases, &phases(), &mut out);
    table(&s.impacts, &impacts(), &mut out);
    // Results of earlier versions tell nothing.
    if s.impacts.iter().any(|i| !i.uncertainty.as_str().is_empty()) {
        table(&s.impacts, &bands(), &mut out);
    }
    // Touches and releases are told of with the impacts.
    let within = s.events.iter().filter(|event| !matches!(event.kind.as_str(), "touch" | "release"));
    let within: Vec<_> = within.cloned().collect();
    let n = within.len().min(MOST_EVENTS);
    table(&within[..n], &events(), &mut out);
    if n < within.len() {
        let _ = writeln!(out, "and {} more in the table /{}", within.len() - n, EventRow::NAME);
    }
    table(&s.peaks, &peaks(), &mut out);
    table(&s.trials, &trials(), &mut out);
    if !s.timings.is_empty() {
        out.push('\n');
    }
    for (name, seconds) in &s.timings {
        let models = match (name.as_str(), s.fine_models) {
            ("reduction", Some(1)) => "   1 fine model built".to_owned(),
            ("reduction", Some(n)) => format!("   {n} fine models built"),
            _ => String::new(),
        };
        let _ = writeln!(out, "{name:<16} {seconds:>10.4} s{models}");
    }
    out
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

fn phases() -> [Shown<PhaseRow>; 7] {
    let heading = heading::<PhaseRow>;
    [
        Shown::text("phase", 8, |_, p| p.kind.as_str().to_owned()),
        Shown::number(heading("start", "start"), 14, |_, p| format!("{:.6e}", p.start)),
        Shown::number(heading("end", "end"), 14, |_, p| format!("{:.6e}", p.end)),
        Shown::number("steps", 9, |_, p| p.steps.to_string()),
        Shown::number("rejected", 9, |_, p| p.rejected.to_string()),
        Shown::number("evaluations", 12, |_, p| p.evaluations.to_string()),
        Shown::number(heading("wall_time", "wall"), 10, |_, p| format!("{:.3}", p.wall_time)),
    ]
}

fn impacts() -> [Shown<ImpactRow>; 8] {
    let heading = heading::<ImpactRow>;
    [
        Shown::text("impact", 7, |n, _| (n + 1).to_string()),
        Shown::text("contact", 12, |_, i| i.contact.as_str().to_owned()),
        Shown::number(heading("start", "start"), 14, |_, i| format!("{:.6e}", i.start)),
        Shown::number(heading("end", "duration"), 21, |_, i| within(i.end - i.start, i.duration_uncertainty)),
        Shown::number(heading("peak_force", "peak"), 18, |_, i| {
            within(i.peak_force, i.peak_force_uncertainty)
        }),
        Shown::number(heading("peak_time", "peak at"), 23, |_, i| {
            within(i.peak_time, i.peak_time_uncertainty)
        }),
        Shown::number(heading("impulse", "impulse"), 23, |_, i| within(i.impulse, i.impulse_uncertainty)),
        Shown::number("restitution", 21, |_, i| within(i.restitution, i.restitution_uncertainty)),
    ]
}

fn events() -> [Shown<EventRow>; 4] {
    let heading = heading::<EventRow>;
    [
        Shown::text("event", 12, |_, e| e.kind.as_str().to_owned()),
        Shown::text("contact", 12, |_, e| e.contact.as_str().to_owned()),
        Shown::number(heading("time", "at"), 14, |_, e| format!("{:.6e}", e.time)),
        Shown::number(heading("normal_force", "force"), 14, |_, e| format!("{:.5}", e.normal_force)),
    ]
}

/// What else is told of impacts with bands.
fn bands() -> [Shown<ImpactRow>; 3] {
    let heading = heading::<ImpactRow>;
    [
        Shown::text("impact", 7, |n, _| (n + 1).to_string()),
        Shown::number(heading("separation_velocity", "separation"), 23, |_, i| {
            within(i.separation_velocity, i.separation_velocity_uncertainty)
        }),
        Shown::text("largest part of ±, or why there is none", 0, |_, i| i.uncertainty.as_str().to_owned()),
    ]
}

fn peaks() -> [Shown<Peak>; 6] {
    [
        Shown::text("largest at", 16, |_, p| p.place.clone()),
        Shown::text("of", 16, |_, p| p.quantity.words.to_owned()),
        Shown::number("value", 23, |_, p| within(p.peak.value, p.peak.band)),
        Shown::text("unit", 4, |_, p| p.quantity.unit.to_owned()),
        Shown::number(with_unit("at", columns::TIME.unit), 14, |_, p| format!("{:.6e}", p.peak.time)),
        Shown::text("largest part of ±, or why there is none", 0, |_, p| p.peak.note.clone()),
    ]
}

fn trials() -> [Shown<TrialRow>; 12] {
    let heading = heading::<TrialRow>;
    [
        Shown::text("impact", 7, |_, t| (t.impact + 1).to_string()),
        Shown::number("trial", 6, |_, t| t.number.to_string()),
        Shown::number(heading("stop", "stop"), 12, |_, t| format!("{:.5e}", t.stop)),
        Shown::number(heading("interval_widths", "width"), 19, |_, t| {
            by_direction(t, &t.interval_widths, |w| if w > 0.0 { format!("{w:.2e}") } else { NOTHING.into() })
        }),
        Shown::number("used [%]", 9, |_, t| by_direction(t, &t.utilisation, |u| format!("{:.0}", 100.0 * u))),
        Shown::number("penalty", 10, |_, t| match t.penalty_end.is_nan() {
            // A trial that ended before there was a model.
            true => NOTHING.into(),
            false => format!("{:.3e}", t.penalty_end),
        }),
        Shown::number("dofs", 9, |_, t| t.dofs.to_string()),
        Shown::number("steps", 7, |_, t| t.steps.to_string()),
        Shown::number(heading("peak_force", "peak"), 11, |_, t| format!("{:.5}", t.peak_force)),
        Shown::number(heading("wall_time", "wall"), 9, |_, t| format!("{:.3}", t.wall_time)),
        Shown::text("outcome", 9, |_, t| t.outcome.as_str().to_owned()),
        Shown::text("reason", 0, |_, t| t.reason.as_str().to_owned()),
    ]
}

/// A value per direction in which the interval of the trial has a width.
fn by_direction(row: &TrialRow, values: &[f64; 2], show: fn(f64) -> String) -> String {
    let directions = if row.interval_widths[1] > 0.0 { 2 } else { 1 };
    values.iter().take(directions).map(|x| show(*x)).collect::<Vec<_>>().join(" x ")
}
