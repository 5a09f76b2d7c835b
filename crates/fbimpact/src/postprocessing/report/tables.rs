//! What was simulated and what came out, as tables and lists.

use std::fmt::Write as _;
use std::path::Path;

use result_files::stored::peak::Peak;
use result_files::stored::summary::Summary;
use result_files::tables::{EventRow, ImpactRow, PhaseRow, TableRow, TrialRow};
use serde_json::{Map, Value, json};

use super::html::{Column, escaped, number, table};

/// A result with what its report says of it.
pub struct Told<'a> {
    /// How legends call it.
    pub label: &'a str,
    /// Its file.
    pub path: &'a Path,
    /// Its gist.
    pub summary: &'a Summary,
    /// [`Summary::json`] of it.
    pub json: &'a Value,
    /// The scenario, as TOML.
    pub scenario: &'a str,
    /// `converge.json` of a study of the scenario, if there is one beside the result.
    pub study: Option<&'a Value>,
}

/// A line a result, for several of them.
pub fn overview(all: &[Told<'_>]) -> String {
    let columns = [
        column("result", "", "label"),
        column("title", "", "title"),
        column("status", "", "status"),
        column("end [s]", "last stored time", "end"),
        column("impacts", "", "impacts"),
        column("largest peak [N]", "largest normal force of all impacts", "peak"),
        column(
            "energy drift",
            "largest deviation of the total energy from its start, of the largest energy",
            "drift",
        ),
        column("warnings", "", "warnings"),
    ];
    let row = |told: &Told<'_>| {
        let s = told.summary;
        let peak = s.impacts.iter().map(|i| i.peak_force).reduce(f64::max);
        map(&json!({
            "label": told.label, "title": s.attribute("title"), "status": s.attribute("status"), "end": s.end,
            "impacts": s.impacts.len(), "peak": peak, "drift": s.energy_drift, "warnings": s.warnings.len(),
        }))
    };
    table("", &columns, &all.iter().map(row).collect::<Vec<_>>())
}

/// All sections about one result; `has_heading`: under its name, as one of several.
pub fn result(told: &Told<'_>, has_heading: bool) -> String {
    let mut out = String::from("<section class=\"result\">");
    if has_heading {
        let _ = write!(out, "<h2>{}</h2>", escaped(told.label));
    }
    verdict(told, &mut out);
    bodies(told, &mut out);
    impacts(told, &mut out);
    peaks(told, &mut out);
    events(told, &mut out);
    trials(told, &mut out);
    phases(told, &mut out);
    if !told.scenario.is_empty() {
        let _ = write!(
            out,
            "<details><summary>Scenario, as the run resolved it</summary><pre>{}</pre></details>",
            escaped(told.scenario)
        );
    }
    out.push_str("</section>");
    out
}

fn column<'a>(heading: &str, meaning: &'a str, key: &'a str) -> Column<'a> {
    Column { heading: heading.to_owned(), meaning, key }
}

/// Columns of the table `T` under other names.
fn declared<'a, T: TableRow>(wanted: &[(&str, &'a str)]) -> Vec<Column<'a>> {
    let one = |(heading, key): &(&str, &'a str)| {
        let declared = T::COLUMNS.iter().find(|c| c.name == *key);
        let unit = declared.map_or("–", |c| c.unit);
        let heading = if unit == "–" { (*heading).to_owned() } else { format!("{heading} [{unit}]") };
        Column { heading, meaning: declared.map_or("", |c| c.meaning), key }
    };
    wanted.iter().map(one).collect()
}

fn map(value: &Value) -> Map<String, Value> {
    value.as_object().cloned().unwrap_or_default()
}

fn rows(json: &Value, key: &str) -> Vec<Map<String, Value>> {
    json[key].as_array().map(|all| all.iter().map(map).collect()).unwrap_or_default()
}

/// Status, warnings, ledger, convergence.
fn verdict(told: &Told<'_>, out: &mut String) {
    let s = told.summary;
    let status = s.attribute("status");
    let class = match (status, s.warnings.is_empty()) {
        ("complete", true) => "good",
        ("complete", false) => "warned",
        _ => "bad",
    };
    let _ = write!(out, "<div class=\"verdict {class}\"><p class=\"status\">{}", escaped(status));
    let warned = match s.warnings.len() {
        0 => "no warnings".to_owned(),
        1 => "one warning".to_owned(),
        n => format!("{n} warnings"),
    };
    let _ = write!(out, ", {warned}</p>");
    if !s.attribute("message").is_empty() {
        let _ = write!(out, "<p>{}</p>", escaped(s.attribute("message")));
    }
    warnings(told.json, out);
    out.push_str("<dl>");
    let mut fact = |name: &str, text: &str| {
        let _ = write!(out, "<div><dt>{name}</dt><dd>{}</dd></div>", escaped(text));
    };
    let end = s.end.map_or_else(|| "–".into(), |t| format!("{} s", number(t)));
    fact("simulated", &format!("{end}, {} stored states", s.n_samples));
    fact("impacts", &s.impacts.len().to_string());
    let part = |x: Option<f64>| x.map_or_else(|| "–".into(), number);
    fact("energy drift, of the largest energy", &part(s.energy_drift));
    if s.numerical_damping.is_some() {
        fact("removed by the integrator, of the same", &part(s.numerical_damping));
    }
    if s.largest_jump.is_some() {
        let text = format!("{} in {} changes of the model", part(s.largest_jump), s.transfers.len());
        fact("largest jump of the energy, of the same", &text);
    }
    if s.resumptions > 0 {
        fact("taken up after interruptions", &format!("{} times", s.resumptions));
    }
    let time: f64 = s.phases.iter().map(|p| p.wall_time).sum();
    fact("wall time of all phases", &format!("{} s", number(time)));
    let version = format!("fbimpact {} {}", s.attribute("program_version"), s.attribute("commit"));
    fact("made by", version.trim());
    fact("made on", s.attribute("created"));
    let file = told.path.file_name().unwrap_or(told.path.as_os_str());
    fact("file", &file.to_string_lossy());
    out.push_str("</dl>");
    convergence(told.study, out);
    out.push_str("</div>");
}

fn warnings(json: &Value, out: &mut String) {
    let all = rows(json, "warnings");
    if all.is_empty() {
        return;
    }
    out.push_str("<ul class=\"warnings\">");
    for warning in &all {
        let text = |key: &str| escaped(warning.get(key).and_then(Value::as_str).unwrap_or_default());
        let _ = write!(out, "<li><b>{}</b> {}: {}", text("identifier"), text("subject"), text("message"));
        if !text("remedy").is_empty() {
            let _ = write!(out, "<br><span class=\"remedy\">Remedy: {}</span>", text("remedy"));
        }
        out.push_str("</li>");
    }
    out.push_str("</ul>");
}

/// The verdict of a study of the resolution.
fn convergence(study: Option<&Value>, out: &mut String) {
    let Some(study) = study else {
        out.push_str(
            "<p class=\"note\">How far the result depends on its resolution is not known: there is no study of <code>fbimpact converge</code> beside it.</p>",
        );
        return;
    };
    let text = |value: &Value| escaped(value.as_str().unwrap_or_default());
    let _ = write!(out, "<p>Resolution: {}</p>", text(&study["verdict"]));
    let variants = rows(study, "variants");
    let percent = |variant: &Map<String, Value>| {
        let change = variant.get("largest_change").and_then(Value::as_f64);
        map(&json!({ "name": variant.get("name"), "change": change.map(|c| 100.0 * c) }))
    };
    if !variants.is_empty() {
        let columns = [
            column("refined", "what a variant of the scenario had finer", "name"),
            column("largest change [%]", "", "change"),
        ];
        out.push_str(&table("", &columns, &variants.iter().map(percent).collect::<Vec<_>>()));
    }
}

fn bodies(told: &Told<'_>, out: &mut String) {
    let s = told.summary;
    let row = |(name, n): &(String, usize)| {
        let notes: Vec<&str> =
            s.chosen.iter().filter(|note| note.body == *name).map(|note| note.text.as_str()).collect();
        map(&json!({ "name": name, "n": n, "note": notes.join("; ") }))
    };
    let mut columns = vec![column("body", "", "name"), column("elastic coordinates", "0: rigid", "n")];
    if !s.chosen.is_empty() {
        columns.push(column("chosen by the program", "", "note"));
    }
    section(
        "Bodies",
        &table("", &columns, &s.bodies.iter().map(row).collect::<Vec<_>>()),
        s.bodies.len(),
        out,
    );
}

/// A heading with `inner` below it, if there are any rows.
fn section(heading: &str, inner: &str, n: usize, out: &mut String) {
    if n > 0 {
        let _ = write!(out, "<h3>{heading}</h3>{inner}");
    }
}

fn impacts(told: &Told<'_>, out: &mut String) {
    let mut columns = vec![column("impact", "", "impact")];
    columns.extend(declared::<ImpactRow>(&[("contact", "contact"), ("start", "start")]));
    columns.push(column("duration [s]", "from the first to the last contact", "duration"));
    columns.extend(declared::<ImpactRow>(&[
        ("peak", "peak_force"),
        ("peak at", "peak_time"),
        ("impulse", "impulse"),
        ("approach", "approach_velocity"),
        ("separation", "separation_velocity"),
        ("restitution", "restitution"),
        ("± peak", "peak_force_uncertainty"),
        ("± peak at", "peak_time_uncertainty"),
        ("± duration", "duration_uncertainty"),
        ("± impulse", "impulse_uncertainty"),
        ("± separation", "separation_velocity_uncertainty"),
        ("± restitution", "restitution_uncertainty"),
        ("largest part of ±", "uncertainty"),
    ]));
    let rows = rows(told.json, "impacts");
    if rows.is_empty() {
        out.push_str("<h3>Impacts</h3><p>There was no impact.</p>");
    }
    section("Impacts", &table("", &columns, &rows), rows.len(), out);
}

fn peaks(told: &Told<'_>, out: &mut String) {
    let columns = [
        column("at", "joint or point", "place"),
        column("largest", "", "quantity"),
        column("value", "at a time step", "value"),
        column("unit", "", "unit"),
        column("at [s]", "when", "time"),
        column("±", "by how much it may be off", "band"),
        column("largest part of ±", "or why there is none", "note"),
    ];
    let row = |p: &Peak| {
        let Peak { place, quantity, peak } = p;
        map(&json!({ "place": place, "quantity": quantity.words, "value": peak.value, "unit": quantity.unit,
            "time": peak.time, "band": peak.band, "note": peak.note }))
    };
    let rows: Vec<_> = told.summary.peaks.iter().map(row).collect();
    section(
        "Reactions of joints, displacements and stresses of points",
        &table("", &columns, &rows),
        rows.len(),
        out,
    );
}

fn trials(told: &Told<'_>, out: &mut String) {
    let columns = declared::<TrialRow>(&[
        ("impact", "impact"),
        ("trial", "try"),
        ("stop", "stop"),
        ("width", "interval_widths"),
        ("used", "utilisation"),
        ("penalty", "penalty_end"),
        ("freedoms", "freedoms"),
        ("steps", "steps"),
        ("peak", "peak_force"),
        ("wall time", "wall_time"),
        ("outcome", "outcome"),
        ("reason", "reason"),
    ]);
    folded("Trials of impacts", &columns, &rows(told.json, "tries"), out);
}

fn events(told: &Told<'_>, out: &mut String) {
    let columns = declared::<EventRow>(&[
        ("event", "kind"),
        ("contact", "contact"),
        ("time", "time"),
        ("force", "normal_force"),
    ]);
    folded("Events of contacts", &columns, &rows(told.json, EventRow::NAME), out);
}

fn phases(told: &Told<'_>, out: &mut String) {
    let columns = declared::<PhaseRow>(&[
        ("phase", "kind"),
        ("start", "start"),
        ("end", "end"),
        ("steps", "steps"),
        ("rejected", "rejected"),
        ("evaluations", "evaluations"),
        ("wall time", "wall_time"),
    ]);
    folded("Phases", &columns, &rows(told.json, "phases"), out);
}

/// A table that opens when it is asked for.
fn folded(heading: &str, columns: &[Column<'_>], rows: &[Map<String, Value>], out: &mut String) {
    if !rows.is_empty() {
        let n = rows.len();
        let _ =
            write!(out, "<details><summary>{heading} ({n})</summary>{}</details>", table("", columns, rows));
    }
}
