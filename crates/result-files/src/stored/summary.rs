//! Reads a result file back: what `fbimpact info` shows.

use std::path::Path;

use hdf5::{File, Result};
use serde_json::{Value, json};

use crate::error::ResultError;
use crate::file::fault::FileFault;
use crate::file::hdf5_integrity;
use crate::stored::chosen_sizes::{self, Note};
use crate::stored::impacts::impacts;
use crate::stored::members::Members;
use crate::stored::open::{attribute, open, scenario_text, table};
use crate::stored::peak::{self, Peak};
use crate::stored::stages::STAGES;
use crate::stored::warnings;
use crate::tables::{EventRow, ImpactRow, PhaseRow, TableRow, TransferRow, TrialRow};

/// The gist of a result file.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Root attributes, by name.
    pub attributes: Vec<(String, String)>,
    /// How often the run was taken up after an interruption.
    pub resumptions: u32,
    /// Stored instants.
    pub n_samples: usize,
    /// Last stored time \[s\].
    pub end: Option<f64>,
    /// Bodies with their number of elastic coordinates.
    pub bodies: Vec<(String, usize)>,
    /// Sizes that the program chose for the run.
    pub chosen: Vec<Note>,
    /// Phases.
    pub phases: Vec<PhaseRow>,
    /// Impacts.
    pub impacts: Vec<ImpactRow>,
    /// What contacts did.
    pub events: Vec<EventRow>,
    /// Trials.
    pub trials: Vec<TrialRow>,
    /// Changes of the model.
    pub transfers: Vec<TransferRow>,
    /// Largest reactions of joints, displacements and stresses of points.
    pub peaks: Vec<Peak>,
    /// Warnings, a line each.
    pub warnings: Vec<String>,
    /// Largest deviation of the total energy from its start, relative to the largest energy
    /// (docs/theory.md Eqs. P.1, P.2).
    pub energy_drift: Option<f64>,
    /// Energy that a dissipative integrator removed, as a share of the same energy.
    pub numerical_damping: Option<f64>,
    /// Largest jump of the total energy at a change of the model, relative to the same.
    pub largest_jump: Option<f64>,
    /// Seconds a stage.
    pub timings: Vec<(String, f64)>,
    /// Fine models that were built; none in results of earlier versions and of runs that were
    /// killed.
    pub fine_models: Option<u64>,
}

/// Reads the summary of `path`.
///
/// # Errors
/// [`ResultError::File`] if the file cannot be read or is not a result file.
pub fn read(path: &Path) -> Result<Summary, ResultError> {
    let file = open(path)?;
    summary(&file).map_err(|e| ResultError::io(path, FileFault::part(e)))
}

fn summary(file: &File) -> Result<Summary> {
    let names = ["title", "status", "message", "program_version", "commit", "compiler", "target", "created"];
    let attributes =
        names.iter().filter_map(|n| attribute(file, n).map(|value| ((*n).to_owned(), value))).collect();
    let time = match file.dataset("time") {
        Ok(dataset) => hdf5_integrity::rows::<f64>(&dataset)?,
        Err(_) => Vec::new(),
    };
    let members = Members::of(file, "bodies")?;
    let modes = |name: &String| members.group(name).and_then(|own| own.dataset("eigenfrequencies").ok());
    let bodies =
        members.names().iter().map(|name| (name.clone(), modes(name).map_or(0, |d| d.size()))).collect();
    let (mut timings, mut fine_models) = (Vec::new(), None);
    if let Ok(group) = file.group("timings") {
        let count = group.dataset("reduction").and_then(|d| d.attr("fine_models")?.read_scalar::<u64>());
        fine_models = count.ok();
        // In the order of the run; a result of an earlier version has not all of them.
        let names = STAGES.into_iter().chain(["cache"]);
        for name in names.filter(|name| group.link_exists(name)) {
            timings.push((name.to_owned(), hdf5_integrity::scalar(&group.dataset(name)?)?));
        }
    }
    let transfers: Vec<TransferRow> = table(file, "transfers")?;
    let energies = energies(file)?;
    let jumps = transfers.iter().map(|t| (t.energy_after - t.energy_before).abs());
    Ok(Summary {
        attributes,
        // Results of earlier versions do not tell.
        resumptions: file.attr("resumptions").and_then(|a| a.read_scalar()).unwrap_or(0),
        n_samples: time.len(),
        end: time.last().copied(),
        bodies,
        chosen: scenario_text(file).map(|text| chosen_sizes::notes(&text)).unwrap_or_default(),
        phases: table(file, "phases")?,
        impacts: impacts(file)?,
        events: table(file, EventRow::NAME)?,
        trials: table(file, "tries")?,
        peaks: peak::peaks(file, &time)?,
        energy_drift: energies.map(|(drift, scale)| drift / scale),
        numerical_damping: energies.and_then(|(_, scale)| removed(file).map(|removed| removed / scale)),
        largest_jump: energies.and_then(|(_, scale)| jumps.reduce(f64::max).map(|jump| jump / scale)),
        transfers,
        warnings: warnings::read(file)?,
        timings,
        fine_models,
    })
}

/// Energy that a dissipative integrator removed \[J\]; none in files of earlier versions.
fn removed(file: &File) -> Option<f64> {
    hdf5_integrity::rows::<f64>(&file.dataset("energies/numerical").ok()?).ok()?.last().copied()
}

/// Largest deviation of the total energy from its start, and the largest size of the ledger's
/// entries unless it is zero (Eqs. P.1, P.2) \[J\].
fn energies(file: &File) -> Result<Option<(f64, f64)>> {
    let Ok(group) = file.group("energies") else { return Ok(None) };
    let total = hdf5_integrity::rows::<f64>(&group.dataset("total")?)?;
    let Some(first) = total.first() else { return Ok(None) };
    // A damaged file may have series of different lengths.
    let mut sizes = vec![0.0; total.len()];
    for name in
        ["kinetic", "elastic_low", "elastic_high", "penalty", "springs", "gravity", "dissipated", "supplied"]
    {
        if group.link_exists(name) {
            let part = hdf5_integrity::rows::<f64>(&group.dataset(name)?)?;
            sizes.iter_mut().zip(&part).for_each(|(sum, x)| *sum += x.abs());
        }
    }
    let scale = sizes.into_iter().fold(0.0_f64, |a, x| if x > a { x } else { a });
    let largest = total.iter().map(|x| (x - first).abs()).fold(0.0_f64, f64::max);
    Ok((scale > 0.0).then_some((largest, scale)))
}

impl Summary {
    /// An attribute, or an empty text.
    pub fn attribute(&self, name: &str) -> &str {
        self.attributes.iter().find(|(n, _)| n == name).map_or("", |(_, value)| value)
    }

    /// As JSON, for programs.
    pub fn json(&self) -> Value {
        let phases: Vec<_> = self.phases.iter().map(TableRow::json).collect();
        let mut impacts: Vec<_> = self.impacts.iter().map(TableRow::json).collect();
        let mut trials: Vec<_> = self.trials.iter().map(TableRow::json).collect();
        let transfers: Vec<_> = self.transfers.iter().map(TableRow::json).collect();
        let events: Vec<_> = self.events.iter().map(TableRow::json).collect();
        // Numbers of impacts count from 1.
        for (n, (json, row)) in impacts.iter_mut().zip(&self.impacts).enumerate() {
            json.insert("impact".into(), (n + 1).into());
            json.insert("duration".into(), (row.end - row.start).into());
        }
        for (json, row) in trials.iter_mut().zip(&self.trials) {
            json.insert("impact".into(), (u64::from(row.impact) + 1).into());
        }
        let attributes: serde_json::Map<String, Value> =
            self.attributes.iter().map(|(n, v)| (n.clone(), v.clone().into())).collect();
        let chosen: Vec<Value> =
            self.chosen.iter().map(|n| json!({ "body": n.body, "text": n.text })).collect();
        let timings: serde_json::Map<String, Value> =
            self.timings.iter().map(|(n, v)| (n.clone(), (*v).into())).collect();
        let bodies: serde_json::Map<String, Value> =
            self.bodies.iter().map(|(n, q)| (n.clone(), json!({ "elastic_coordinates": q }))).collect();
        let [joints, points] = ["joints", "points"].map(|group| peak::json(&self.peaks, group));
        let mut all = json!({
            "resumptions": self.resumptions, "samples": self.n_samples, "end": self.end,
            "energy_drift": self.energy_drift, "numerical_damping": self.numerical_damping,
            "largest_transfer_jump": self.largest_jump, "bodies": bodies, "joints": joints, "points": points,
            "chosen": chosen,
            "phases": phases, "impacts": impacts, "events": events,
            "warnings": self.warnings.iter().map(|line| warnings::json(line)).collect::<Vec<_>>(),
            "tries": trials, "transfers": transfers, "timings": timings, "fine_models": self.fine_models,
        });
        if let Value::Object(map) = &mut all {
            map.extend(attributes);
        }
        all
    }
}
