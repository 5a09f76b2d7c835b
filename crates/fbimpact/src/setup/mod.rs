//! From a validated scenario to the specification of a run: exact shapes, materials, places, joints, contact pairs.

pub mod geometry;
mod rigid;
mod bodies;
mod places;
mod joints;
mod contacts;

use adaptive::spec::{Area, PhaseSettings, PointSpec, RunSettings, RunSpec, StressInstant, StressSpec};
use ffr_dynamics::integration::Method;
use ffr_dynamics::system::error_scale::ErrorScale;
use nalgebra::Vector3;

use crate::error::AppError;
use crate::scenario::{self, Scenario};
use bodies::Bodies;

/// The specification of the run that `scenario` describes. Sizes that the program has yet to choose, see [`crate::sizing`], are
/// some that do.
///
/// # Errors
/// [`AppError::Model`] naming the body, joint or contact that cannot be built.
pub fn run_spec(scenario: &Scenario) -> Result<RunSpec, AppError> {
    let bodies = Bodies::new(scenario)?;
    let of_kind = |closes_loop: bool| {
        let list = scenario.joints.iter().filter(|j| j.closes_loop == closes_loop);
        list.map(|j| joints::joint(j, &bodies)).collect::<Result<_, AppError>>()
    };
    let (tree, loops) = (of_kind(false)?, of_kind(true)?);
    let loads = scenario.loads.iter().map(|l| joints::load(l, &bodies)).collect::<Result<_, AppError>>()?;
    let contacts = scenario.contacts.iter().map(|c| contacts::contact(c, scenario, &bodies));
    let contacts = contacts.collect::<Result<_, AppError>>()?;
    let points = scenario.output.points.iter().map(|p| {
        let subject = format!("output.points.{}", p.name);
        let body = bodies.moving(p.body, &subject)?;
        Ok(PointSpec { name: p.name.clone(), body, place: bodies.observed(body, &p.at)? })
    });
    let points = points.collect::<Result<_, AppError>>()?;
    let stress = scenario.output.stress.iter().map(|line| stress(line, &bodies));
    let stress = stress.collect::<Result<_, AppError>>()?;
    let settings = settings(scenario);
    let resolution = bodies.resolution(&scenario.resolution);
    Ok(RunSpec {
        joints: tree,
        loops,
        loads,
        contacts,
        points,
        stress,
        settings,
        resolution,
        bodies: bodies.specs,
    })
}

/// Parts of body `name` that can be held, by name: markers with an extent and the faces of the shape.
///
/// # Errors
/// As [`run_spec`]; none for an unknown body, which has no parts.
pub fn areas(scenario: &Scenario, name: &str) -> Result<Vec<(String, Area)>, AppError> {
    Ok(Bodies::new(scenario)?.areas(name))
}

fn stress(line: &scenario::StressLine, bodies: &Bodies) -> Result<StressSpec, AppError> {
    let body = bodies.flexible(line.body, &format!("output.stress.{}", line.name))?;
    Ok(StressSpec {
        name: line.name.clone(),
        body,
        ends: [bodies.point(body, &line.from)?, bodies.point(body, &line.to)?],
        samples: line.samples,
        at: match line.at {
            scenario::StressTime::PeakForce => StressInstant::PeakForce,
            scenario::StressTime::Time(t) => StressInstant::Time(t),
        },
    })
}

/// Longest step of an impact phase as a share of the period of the highest mode: half of it just resolves the mode.
const STEP_SHARE: f64 = 0.5;
/// Power of a factor on the tolerance that steps are shortened by: a tenth halves them, as an error of third order per step.
const STEP_POWER: f64 = std::f64::consts::LOG10_2;

/// Permitted errors below round-off cannot be met.
const LEAST_TOLERANCE: f64 = 1e-14;

fn settings(scenario: &Scenario) -> RunSettings {
    let simulation = &scenario.simulation;
    let tightened = scenario.resolution.tolerance;
    let shortened = tightened.powf(STEP_POWER);
    let phase = |i: &scenario::Integration| PhaseSettings {
        method: match i.integrator {
            scenario::Integrator::DormandPrince => Method::DormandPrince,
            scenario::Integrator::TrBdf2 => Method::TrBdf2,
            scenario::Integrator::Esdirk4 => Method::Esdirk4,
        },
        max_step: i.max_step.unwrap_or(f64::INFINITY) * shortened,
        tolerance: (i.rtol * tightened).max(LEAST_TOLERANCE),
        velocity_floor: ErrorScale::default().velocity_floor,
    };
    RunSettings {
        end_time: simulation.end_time,
        gravity: Vector3::from(simulation.gravity),
        static_start: simulation.static_start,
        free: phase(&simulation.free),
        impact: phase(&simulation.impact),
        step_share: STEP_SHARE * shortened,
        quiet_time: simulation.quiet_time,
        energy_tolerance: simulation.energy_tolerance,
        free_interval: scenario.output.free_interval,
        impact_interval: scenario.output.impact_interval,
    }
}
