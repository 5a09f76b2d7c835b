//! Settings of the run: time span, gravity, integrators, intervals of output.

use adaptive::spec::resolution::shortening;
use adaptive::spec::{Accuracy, IMPACT_TOLERANCE, PhaseSettings, RestSettings, RunSettings, Start};
use ffr_dynamics::integration::Method as IntegrationMethod;
use ffr_dynamics::system::multibody::error_scale::ErrorScale;

use super::super::section::Section;

/// Longest step of an impact phase as a share of the period of the highest mode: half of it just
/// resolves the mode.
const STEP_SHARE: f64 = 0.5;

/// States of a phase before they are stored ever more rarely, where nobody has given their number.
const PHASE_STATES: f64 = 1000.0;

/// The settings of the tables `[simulation]` and `[output]` at a level of `accuracy`, before
/// factors on the resolution.
pub fn settings(simulation: &Section, output: &Section, accuracy: Accuracy) -> Option<RunSettings> {
    let (free_interval, states) = (output.number("free_interval"), output.number("phase_states"));
    let phase_share = 1.0 / states.unwrap_or(PHASE_STATES);
    // An interval that is asked for is kept, unless states are counted as well.
    let is_even = free_interval.is_some() && states.is_none();
    Some(RunSettings {
        end_time: simulation.number("end_time")?,
        gravity: simulation.vector::<3>("gravity")?.into(),
        start: start(simulation)?,
        free: phase(simulation.table("free")?, accuracy, None)?,
        impact: phase(simulation.table("impact")?, accuracy, Some(IMPACT_TOLERANCE))?,
        lasting: phase(simulation.table("lasting")?, accuracy, None)?,
        step_share: STEP_SHARE * shortening(accuracy.step_error()).min(1.0),
        quiet_time: simulation.number("quiet_time"),
        stop_after_impacts: simulation.integer("stop_after_impacts").and_then(|n| u32::try_from(n).ok()),
        stop_at_rest: rest(simulation),
        energy_tolerance: simulation.number("energy_tolerance")?,
        free_interval,
        impact_interval: output.number("impact_interval")?,
        phase_share,
        free_share: if is_even { 0.0 } else { phase_share },
        pressure: output.boolean("pressure")?,
        uncertainty: true,
        accuracy: None,
    })
}

fn start(simulation: &Section) -> Option<Start> {
    let start = simulation.choice("start")?;
    Some(if start == Start::Given && simulation.boolean("static_start")? { Start::Elastic } else { start })
}

fn rest(simulation: &Section) -> Option<RestSettings> {
    let section = simulation.table("stop_at_rest")?;
    Some(RestSettings { speed: section.number("speed")?, duration: section.number("duration")? })
}

/// Settings of a phase; `explicit`: the error that the explicit method is allowed where none is given, if not its own default.
fn phase(section: &Section, accuracy: Accuracy, explicit: Option<f64>) -> Option<PhaseSettings> {
    let (method, given) = (section.choice("integrator"), section.number("rtol"));
    let is_explicit = method.is_none_or(|method| method == IntegrationMethod::DormandPrince);
    Some(PhaseSettings {
        method,
        max_step: section.number("max_step").unwrap_or(f64::INFINITY),
        tolerance: given.or(explicit.filter(|_| is_explicit)),
        tolerance_factor: if given.is_some() { 1.0 } else { accuracy.step_error() },
        velocity_floor: ErrorScale::default().velocity_floor,
    })
}
