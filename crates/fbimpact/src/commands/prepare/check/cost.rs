//! `fbimpact check --cost`: what a run takes of the machine, roughly, before it begins.

use std::fmt::Write as _;

use adaptive::model::{ModelCost, costs};
use adaptive::prepared::Prepared;
use adaptive::spec::GaugeRequest;
use adaptive::spec::{BodySpec, FREE_INTERVAL, PointSpec, RunSpec};
use serde::Serialize;

use crate::cache::{self, CacheSettings};
use crate::error::AppError;
use crate::scenario::Scenario;
use crate::simulate::sizing::sized;
use crate::simulate::thread_pool::thread_pool;

/// Numbers of a stored state beside those of bodies, contacts, joints and points: time, energies,
/// momentum.
const OF_STATE: usize = 17;
/// Numbers of a body beside its elastic coordinates, of a contact, of a joint and of a point.
const OF_BODY: usize = 16;
const OF_CONTACT: usize = 14;
const OF_JOINT: usize = 10;
const OF_POINT: usize = 6;
const OF_STRESS: usize = 7;
const OF_STRAIN: usize = 6;
/// Elastic coordinates of a body whose scenario does not say how many: a few modes and the static
/// answers of two joints.
const USUAL_COORDINATES: usize = 32;

/// What a scenario takes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CostReport {
    /// Models of the bodies, each followed by the fine models predicted for its contacts.
    pub models: Vec<ModelRow>,
    /// Memory of the two largest models, which may be built side by side \[bytes\].
    pub memory: f64,
    /// States stored in one phase without contact that lasts until the end, at most.
    pub states: f64,
    /// Size of a stored state \[bytes\].
    pub state_bytes: usize,
}

/// One model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModelRow {
    /// Name of the body.
    pub body: String,
    /// Contact that the fine model is for.
    pub contact: Option<String>,
    /// Number of elements.
    pub elements: usize,
    /// Number of degrees of freedom.
    pub dofs: usize,
    /// Number of degrees of freedom at the interface of the contact.
    pub interface: usize,
    /// Memory \[bytes\].
    pub memory: f64,
    /// Time to build it, roughly \[s\].
    pub seconds: f64,
}

/// Costs of a scenario whose sizes the program may have to choose first, on `threads` threads.
///
/// # Errors
/// [`AppError::Model`] if a mesh cannot be made or no memory holds a model.
pub fn cost(scenario: &Scenario, threads: usize) -> Result<CostReport, AppError> {
    let sized = sized(scenario, threads, &cache::open(&CacheSettings::of_environment()))?;
    let spec = &sized.run;
    let models = thread_pool(threads)?.install(|| costs(Prepared::new(spec)?)).map_err(AppError::model)?;
    let row = |cost: ModelCost| ModelRow {
        body: cost.body,
        contact: cost.contact,
        elements: cost.n_elements,
        dofs: cost.n_dofs,
        interface: cost.n_interface,
        memory: cost.cost.bytes,
        seconds: cost.cost.seconds(threads),
    };
    let models: Vec<ModelRow> = models.into_iter().map(row).collect();
    let mut sizes: Vec<f64> = models.iter().map(|m| m.memory).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    Ok(CostReport {
        memory: sizes.iter().take(2).sum(),
        states: states(spec),
        state_bytes: state_bytes(spec),
        models,
    })
}

/// Stored states of a phase that lasts the whole run: evenly up to the number of
/// `output.phase_states`, then at intervals that grow with the age of the phase.
fn states(spec: &RunSpec) -> f64 {
    let settings = &spec.settings;
    let (end, interval) =
        (settings.end_time, settings.free_interval.unwrap_or(FREE_INTERVAL).max(f64::MIN_POSITIVE));
    let even = 1.0 / settings.free_share.max(f64::MIN_POSITIVE);
    let turn = even * interval;
    if end <= turn { end / interval + 1.0 } else { even * (1.0 + (end / turn).ln()) + 1.0 }
}

fn state_bytes(spec: &RunSpec) -> usize {
    let elastic = |body: &BodySpec| match &body.kind {
        kind if kind.is_rigid() => 0,
        kind => 2 * kind.flexible().and_then(|f| f.reduction.modes()).unwrap_or(USUAL_COORDINATES),
    };
    let bodies: usize = spec.bodies.iter().map(|body| OF_BODY + elastic(body)).sum();
    let joints = spec.joints.len() + spec.loops.len();
    let of_point = |point: &PointSpec| {
        let GaugeRequest { strain, stress } = point.gauge;
        OF_POINT + if stress { OF_STRESS } else { 0 } + if strain { OF_STRAIN } else { 0 }
    };
    let points: usize = spec.points.iter().map(of_point).sum();
    let others = OF_CONTACT * spec.contacts.len() + OF_JOINT * joints + points;
    size_of::<f64>() * (OF_STATE + bodies + others)
}

/// The report for people. Writing to a string cannot fail.
pub fn table(report: &CostReport) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{:<16} {:<16} {:>10} {:>10} {:>10} {:>12} {:>10}",
        "body", "contact", "elements", "dofs", "interface", "memory [GB]", "time [s]"
    );
    for m in &report.models {
        let contact = m.contact.as_deref().unwrap_or("-");
        let _ = writeln!(
            out,
            "{:<16} {contact:<16} {:>10} {:>10} {:>10} {:>12.3} {:>10.1}",
            m.body,
            m.elements,
            m.dofs,
            m.interface,
            1e-9 * m.memory,
            m.seconds
        );
    }
    let _ = writeln!(
        out,
        "memory: some {:.2} GB, two models being built side by side\n\
         result: up to {:.0} states of {:.1} kB before compression for each phase without contact; impacts and what rings after them add more",
        1e-9 * report.memory,
        report.states,
        1e-3 * report.state_bytes as f64
    );
    out
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn states_are_counted_as_the_run_stores_them() {
        let text = "simulation = { end_time = 40.0 }\n[output]\nfree_interval = 1e-2\nphase_states = 500\n\
                    [bodies.b]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n";
        let scenario = crate::scenario::parse(Path::new("t.toml"), text.as_bytes(), &[]).expect("a scenario");
        let (mut count, mut t) = (1.0, 0.0);
        while t < 40.0 {
            t += f64::max(1e-2, scenario.run.settings.free_share * t);
            count += 1.0;
        }
        // The sum of growing intervals is half of one of them, 1/500, off the integral, per state
        // that grows.
        assert!((states(&scenario.run) / count - 1.0).abs() < 2.0 / 500.0, "{count}");
    }
}
