//! `fbimpact check`: reads and validates; builds nothing but the meshes that tell what a run takes.

mod cost;
mod joints;
mod contacts;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use adaptive::checks::units;
use adaptive::model::check_unbuilt;
use adaptive::prepared::Prepared;

use crate::commands::scenario_file;
use crate::commands::{Means, print, threads};
use crate::error::AppError;
use crate::progress::while_building;
use crate::scenario::{Override, Scenario};
use cost::CostReport;

/// What to print of scenarios without faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CostFormat {
    /// Nothing.
    None,
    /// A table of what the run takes.
    Table,
    /// The same for programs.
    Json,
}

/// Checks every file and reports the faults of all.
///
/// # Errors
/// [`AppError::Threads`] if the threads cannot be started, [`AppError::NeverMet`], [`AppError::Model`] for contacts that a run refuses or models that cannot be
/// made. The last error; those before it have been reported.
pub fn check(
    scenarios: &[PathBuf],
    overrides: &[Override],
    format: CostFormat,
    means: Means<'_>,
) -> Result<(), AppError> {
    // Body files are checked with linear algebra.
    let n_threads = threads(means.threads)?;
    let mut last = None;
    let mut reports: BTreeMap<String, CostReport> = BTreeMap::new();
    for path in scenarios {
        let read = scenario_file::read_or_input(path, overrides);
        let path = named(path);
        let scenario = match read.and_then(|scenario| accept(path, &scenario).map(|()| scenario)) {
            Ok(scenario) if format != CostFormat::None => scenario,
            Ok(_) => continue,
            Err(error) => {
                later(&mut last, error);
                continue;
            }
        };
        match while_building(means.bar, || cost::cost(&scenario, n_threads)) {
            Ok(report) if format == CostFormat::Table => {
                let head = if scenarios.len() > 1 { format!("{}\n", path.display()) } else { String::new() };
                print(&(head + &cost::table(&report)))?;
            }
            Ok(report) => drop(reports.insert(path.display().to_string(), report)),
            Err(error) => later(&mut last, error.of_scenario(path)),
        }
    }
    if format == CostFormat::Json {
        print(&(serde_json::to_string_pretty(&reports)? + "\n"))?;
    }
    last.map_or(Ok(()), Err)
}

/// Tells what is in a scenario without faults, and whether a run would accept its contacts, which
/// is known from the shapes and the motions at the start.
fn accept(path: &Path, scenario: &Scenario) -> Result<(), AppError> {
    let prepared = Prepared::new(&scenario.run);
    let behind = prepared.as_ref().map_or_else(|_| Vec::new(), contacts::behind);
    let contacts = prepared.and_then(|run| check_unbuilt(&run, &scenario.wishes));
    tracing::info!(
        "{}: {}, {} bodies, {} joints, {} contacts",
        path.display(),
        if contacts.is_ok() && behind.is_empty() { "valid" } else { "refused" },
        scenario.bodies.len(),
        scenario.run.joints.len() + scenario.run.loops.len(),
        scenario.run.contacts.len()
    );
    joints::report(path, scenario);
    tell_units(Some(path), scenario);
    for body in under_constrained(scenario) {
        tracing::warn!(
            "{}: body \"{body}\" is under-constrained: it is the child of no joint and moves freely among bodies that do; name it as the child of a joint unless that is meant",
            path.display()
        );
    }
    contacts.map_err(|error| AppError::from(error).of_scenario(path))?;
    if behind.is_empty() {
        return Ok(());
    }
    Err(AppError::NeverMet(behind.join("; ")).of_scenario(path))
}

/// What messages call a scenario.
fn named(path: &Path) -> &Path {
    if path == Path::new("-") { Path::new("standard input") } else { path }
}

/// Tells numbers that look as if they were given in other units.
pub fn tell_units(path: Option<&Path>, scenario: &Scenario) {
    let place = path.map_or(String::new(), |path| format!("{}: ", path.display()));
    for doubt in units::doubts(&scenario.run) {
        tracing::warn!("{place}{doubt}");
    }
}

/// Keeps `error` for the end and reports the one before it.
fn later(last: &mut Option<AppError>, error: AppError) {
    if let Some(previous) = last.replace(error) {
        crate::report(&previous);
    }
}

/// Bodies that are the child of no joint and of no contact where others are held by joints.
fn under_constrained(scenario: &Scenario) -> Vec<&str> {
    let tree = &scenario.run.joints;
    if tree.is_empty() {
        return Vec::new();
    }
    let bodies = scenario.run.bodies.iter().enumerate();
    // What is thrown at others, or lies on them, moves freely on purpose.
    let touches = |i: usize| scenario.run.contacts.iter().any(|contact| contact.acts_on(i));
    let free = bodies.filter(|(i, _)| tree.iter().all(|j| j.child.body != Some(*i)) && !touches(*i));
    free.map(|(_, body)| body.name.as_str()).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scenario;

    #[test]
    fn free_body_among_jointed_ones_is_named() {
        let text = |joint: &str| {
            format!(
                r#"
                simulation = {{ end_time = 1.0 }}
                [bodies.arm]
                model = "rigid"
                mass = 1.0
                inertia = [1.0, 1.0, 1.0]
                [bodies.stone]
                model = "rigid"
                mass = 1.0
                inertia = [1.0, 1.0, 1.0]
                {joint}
                "#
            )
        };
        let joint = r#"
            [joints.hinge]
            type = "revolute"
            axis = [0.0, 1.0, 0.0]
            parent = { body = "ground", point = [0.0, 0.0, 0.0] }
            child = { body = "arm", point = [0.0, 0.0, 0.1] }
        "#;
        let read = |t: &str| scenario::parse(Path::new("test.toml"), t.as_bytes(), &[]).expect("a scenario");
        assert_eq!(under_constrained(&read(&text(joint))), ["stone"]);
        assert!(under_constrained(&read(&text(""))).is_empty());
        // A ball that is thrown at the arm.
        let thrown = format!(
            r#"{joint}
            [materials.m]
            youngs_modulus = 2e11
            poissons_ratio = 0.3
            density = 8e3
            [bodies.target]
            model = "rigid"
            material = "m"
            geometry = {{ shape = "sphere", radius = 0.1 }}
            position = [1.0, 0.0, 0.0]
            [bodies.ball]
            model = "rigid"
            material = "m"
            geometry = {{ shape = "sphere", radius = 0.1 }}
            position = [2.0, 0.0, 0.0]
            [contacts.hit]
            contact_body = "ball"
            target_body = "target"
            model = "hertz"
            "#
        );
        assert_eq!(under_constrained(&read(&text(&thrown))), ["stone"]);
    }
}
