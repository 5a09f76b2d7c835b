//! The seam between the program and the models: from a validated scenario to a finished run.

use adaptive::record::{Observer, Timings};

use crate::error::AppError;
use crate::scenario::Scenario;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The end time was reached.
    Complete,
    /// The observer asked to stop.
    Interrupted,
}

/// What a run hands back besides what its observer saw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunReport {
    /// How it ended.
    pub ending: Ending,
    /// Time reached \[s\].
    pub time: f64,
    /// Wall time a stage; `output` is left to the caller.
    pub timings: Timings,
}

/// Spectra and sizes of the reduced models of a scenario.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModesReport {
    /// One entry a body, in the order of the scenario.
    pub bodies: Vec<BodyModes>,
}

/// Spectrum and sizes of one body's reduced model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyModes {
    /// Name in the scenario.
    pub name: String,
    /// Elements of the full model.
    pub n_elements: usize,
    /// Freedoms of the full model; zero for rigid bodies.
    pub n_dofs: usize,
    /// Interface freedoms of the contact zones.
    pub n_interface: usize,
    /// Mass \[kg\]; infinite for fixed planes.
    pub mass: f64,
    /// Eigenfrequencies of the elastic coordinates \[Hz\], ascending.
    pub frequencies: Vec<f64>,
}

/// Runs `scenario` on `threads` threads and reports every step to `observer`.
///
/// # Errors
/// [`AppError::Model`] if a model cannot be built, [`AppError::Run`] if the run fails.
pub fn simulate(
    scenario: &Scenario,
    observer: &mut dyn Observer,
    threads: usize,
) -> Result<RunReport, AppError> {
    let _ = (observer, threads);
    Err(AppError::Model(format!(
        "the {} bodies of this scenario are not connected to the solver yet",
        scenario.bodies.len()
    )))
}

/// Builds the reduced models of `scenario`, or of its body `body` alone.
///
/// # Errors
/// [`AppError::Model`] if a model cannot be built.
pub fn modes(scenario: &Scenario, body: Option<usize>, threads: usize) -> Result<ModesReport, AppError> {
    let _ = (scenario, body, threads);
    Err(AppError::Model("bodies are not connected to the solver yet".into()))
}
