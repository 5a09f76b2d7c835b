//! What figures need of a result file.

use std::path::Path;

use hdf5::types::VarLenUnicode;
use hdf5::{File, Group, Result};

use crate::error::ResultError;
use crate::file::fault::FileFault;
use crate::file::hdf5_integrity;
use crate::stored::impacts::impacts;
use crate::stored::open::{attribute, open, scenario_text, table};
use crate::stored::pressure_series::PressureSeries;
use crate::stored::scenario_values::{self, Values};
use crate::tables::{ImpactRow, PhaseRow, TrialRow};

/// A motion in space: x, y, z over time.
pub type Components = [Vec<f64>; 3];

/// Histories by their names.
pub type Named = Vec<(String, Vec<f64>)>;

/// Stress along a line.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StressLine {
    /// Name.
    pub name: String,
    /// When \[s\].
    pub time: f64,
    /// Distances from the first point \[m\].
    pub distance: Vec<f64>,
    /// Von Mises stress \[Pa\].
    pub von_mises: Vec<f64>,
    /// Components \[Pa\].
    pub components: Named,
}

/// Which share of a contact interval shall touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Utilisation {
    /// Share below which the interval is too wide; only results of the first versions tell, others
    /// leave it to the program.
    pub least: Option<f64>,
    /// Share that is aimed at.
    pub target: f64,
}

/// Series and tables of a result file.
#[derive(Debug, Clone, Default)]
pub struct ResultData {
    /// How legends call the file.
    pub label: String,
    /// Title of the scenario.
    pub title: String,
    /// Keys and values of the scenario.
    pub scenario: Values,
    /// Stored instants \[s\].
    pub time: Vec<f64>,
    /// Energies by name \[J\].
    pub energies: Vec<(String, Vec<f64>)>,
    /// Normal force \[N\] of every contact.
    pub forces: Vec<(String, Vec<f64>)>,
    /// Pressures of contacts whose points are stored.
    pub pressures: Vec<(String, PressureSeries)>,
    /// Position \[m\] and velocity [m/s] of the chosen points.
    pub points: Vec<(String, Components, Components)>,
    /// Stress of those points where it is stored, by its components \[Pa\].
    pub stresses: Vec<(String, Named)>,
    /// Stress along the lines that the scenario asks for.
    pub lines: Vec<StressLine>,
    /// Force \[N\] and moment \[N m\] of every joint on its child.
    pub reactions: Vec<(String, Components, Components)>,
    /// Phases.
    pub phases: Vec<PhaseRow>,
    /// Impacts.
    pub impacts: Vec<ImpactRow>,
    /// Trials.
    pub trials: Vec<TrialRow>,
    /// Utilisation of the contact interval, if all contacts agree on it.
    pub utilisation: Option<Utilisation>,
}

impl ResultData {
    /// Reads `path`; `label` is what legends call it.
    ///
    /// # Errors
    /// [`ResultError::File`] if it is no readable result file.
    pub fn read(path: &Path, label: String) -> std::result::Result<Self, ResultError> {
        let file = open(path)?;
        let mut data = contents(&file).map_err(|e| ResultError::io(path, FileFault::part(e)))?;
        if data.time.is_empty() {
            return Err(ResultError::io(path, "has no stored states, there is nothing to draw"));
        }
        data.label = label;
        Ok(data)
    }

    /// Leaves the stored instants from `from` to `to` \[s\], and the impacts that begin between
    /// them; false if there is no such instant.
    pub fn cut(&mut self, from: f64, to: f64) -> bool {
        let first = self.time.partition_point(|t| *t < from);
        let end = self.time.partition_point(|t| *t <= to);
        if first >= end {
            return false;
        }
        let vectors = self.points.iter_mut().chain(&mut self.reactions);
        let components = vectors.flat_map(|(_, x, v)| x.iter_mut().chain(v));
        let named = self.energies.iter_mut().chain(&mut self.forces);
        let stresses = self.stresses.iter_mut().flat_map(|(_, all)| all);
        let series = named.chain(stresses).map(|(_, values)| values).chain(components);
        for values in series.chain([&mut self.time]) {
            values.truncate(end);
            values.drain(..first.min(values.len()));
        }
        self.pressures.iter_mut().for_each(|(_, series)| series.cut(first..end));
        self.impacts.retain(|impact| impact.start >= from && impact.start <= to);
        self.phases.retain(|phase| phase.end >= from && phase.start <= to);
        for phase in &mut self.phases {
            (phase.start, phase.end) = (phase.start.max(from), phase.end.min(to));
        }
        true
    }

    /// Impacts of contact `contact`, in time.
    pub fn impacts_of<'a>(&'a self, contact: &'a str) -> impl Iterator<Item = &'a ImpactRow> + 'a {
        self.impacts.iter().filter(move |i| i.contact.as_str() == contact)
    }
}

fn contents(file: &File) -> Result<ResultData> {
    let scenario = if file.link_exists("scenario") { scenario_text(file)? } else { String::new() };
    let mut data = ResultData {
        scenario: scenario_values::read(&scenario),
        title: attribute(file, "title").unwrap_or_default(),
        time: hdf5_integrity::rows(&file.dataset("time")?)?,
        phases: table(file, "phases")?,
        impacts: impacts(file)?,
        trials: table(file, "tries")?,
        utilisation: utilisation(&scenario),
        ..ResultData::default()
    };
    for (name, group) in members(file, "energies")? {
        data.energies.push((name.clone(), hdf5_integrity::rows(&group.dataset(&name)?)?));
    }
    for (name, group) in members(file, "contacts")? {
        data.forces
            .push((name.clone(), hdf5_integrity::rows(&group.dataset(&format!("{name}/normal_force"))?)?));
    }
    for (name, _) in members(file, "pressure")? {
        let stored = PressureSeries::read(file, &name)?.filter(|series| series.is_whole(data.time.len()));
        data.pressures.extend(stored.map(|series| (name, series)));
    }
    for (name, group) in members(file, "points")? {
        let position = components(&group, &format!("{name}/position"))?;
        let velocity = components(&group, &format!("{name}/velocity"))?;
        if let Some(stress) = stress(&group, &name)? {
            data.stresses.push((name.clone(), stress));
        }
        data.points.push((name, position, velocity));
    }
    for (name, group) in members(file, "stress")? {
        // Small copies have the numbers without the names of their components.
        data.lines.extend(stress_line(name.clone(), &group.group(&name)?).ok());
    }
    for (name, group) in members(file, "joints")? {
        let joint = group.group(&name)?;
        if joint.link_exists("reaction_force") && joint.link_exists("reaction_moment") {
            let force = components(&joint, "reaction_force")?;
            let moment = components(&joint, "reaction_moment")?;
            data.reactions.push((name, force, moment));
        }
    }
    // A file that is being written may have rows that others lack.
    let lengths = data.energies.iter().chain(&data.forces).map(|(_, v)| v.len());
    let vectors = data.points.iter().chain(&data.reactions);
    let lengths = lengths.chain(vectors.flat_map(|(_, p, v)| [p[0].len(), v[0].len()]));
    let stresses = data.stresses.iter().flat_map(|(_, components)| components.iter().map(|(_, v)| v.len()));
    let n = lengths.chain(stresses).fold(data.time.len(), usize::min);
    data.time.truncate(n);
    Ok(data)
}

/// Members of the group `name` with the group, none if it does not exist.
fn members(file: &File, name: &str) -> Result<Vec<(String, Group)>> {
    let Ok(group) = file.group(name) else { return Ok(Vec::new()) };
    Ok(group.member_names()?.into_iter().map(|member| (member, group.clone())).collect())
}

/// Components of the stress at point `name`, if it is stored.
fn stress(group: &Group, name: &str) -> Result<Option<Named>> {
    let point = group.group(name)?;
    if !point.link_exists("stress") {
        return Ok(None);
    }
    tensor(&point).map(Some)
}

/// Components of the dataset `stress` of `group` by their names; those that the model does not have
/// are left out.
fn tensor(group: &Group) -> Result<Named> {
    let labels: Vec<VarLenUnicode> = hdf5_integrity::rows(&group.dataset("component")?)?;
    let labels: Vec<String> = labels.iter().map(|label| label.as_str().to_owned()).collect();
    let rows: Vec<f64> = hdf5_integrity::rows(&group.dataset("stress")?)?;
    let n = labels.len().max(1);
    let component = |c: usize| rows.iter().skip(c).step_by(n).copied().collect();
    let all = labels.into_iter().enumerate().map(|(c, label)| (label, component(c)));
    Ok(all.filter(|(label, _)| label != "-").collect())
}

fn stress_line(name: String, group: &Group) -> Result<StressLine> {
    Ok(StressLine {
        name,
        time: group.attr("time")?.read_scalar()?,
        distance: hdf5_integrity::rows(&group.dataset("distance")?)?,
        von_mises: hdf5_integrity::rows(&group.dataset("von_mises")?)?,
        components: tensor(group)?,
    })
}

fn components(group: &Group, name: &str) -> Result<Components> {
    let rows: Vec<f64> = hdf5_integrity::rows(&group.dataset(name)?)?;
    Ok(std::array::from_fn(|c| rows.iter().skip(c).step_by(3).copied().collect()))
}

/// Utilisation of the contacts that the program refines, if they all agree.
fn utilisation(scenario: &str) -> Option<Utilisation> {
    let scenario: toml::Table = scenario.parse().ok()?;
    let contacts = scenario.get("contacts")?.as_table()?.values();
    let refined = contacts.filter(|c| c.get("model").and_then(|m| m.as_str()) == Some("adaptive"));
    let of = |contact: &toml::Value| {
        let value = |key: &str| contact.get("interval")?.get(key)?.as_float();
        Some(Utilisation { least: value("min_utilisation"), target: value("target_utilisation")? })
    };
    let mut all: Vec<Option<Utilisation>> = refined.map(of).collect();
    all.dedup();
    if let [one] = all[..] { one } else { None }
}
