//! The seam between the program and the models: from a validated scenario to a finished run.

mod one_body;
pub mod thread_pool;
pub mod sizing;

use std::collections::BTreeMap;
use std::time::Instant;

use adaptive::AdaptiveError;
use adaptive::checks::start::of_bodies;
use adaptive::model::RunModel;
use adaptive::prepared::Prepared;
use adaptive::record::Timings;
use adaptive::run::driver;
use adaptive::spec::{BodySpec, ImportedSpec, RunSpec, Start};
use adaptive::state::RunState;
use adaptive::state::observer::{Observer, Stage};
use adaptive::store::ModelCache;
use adaptive::system::body::BodyModel;
use ffr_dynamics::system::SystemModes;
use result_files::stored::chosen_sizes;

use crate::error::AppError;

use crate::scenario::Scenario;
use sizing::{sized, sized_for};
use thread_pool::thread_pool;

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
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct ModesReport {
    /// One entry per body, in the order of the scenario.
    pub bodies: Vec<BodyModes>,
}

/// Spectrum and sizes of one body's reduced model.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct BodyModes {
    /// Name in the scenario.
    pub name: String,
    /// Elements of the full model; zero for rigid bodies and those from files.
    #[serde(rename = "elements")]
    pub n_elements: usize,
    /// Freedoms of the full model; zero for rigid bodies and those that come reduced.
    #[serde(rename = "freedoms")]
    pub n_dofs: usize,
    /// Interface degrees of freedom of the contact zones.
    #[serde(rename = "interface_freedoms")]
    pub n_interface: usize,
    /// Mass \[kg\]; infinite for fixed planes.
    pub mass: f64,
    /// Named points in the components of the body's model \[m\].
    pub points: BTreeMap<String, Vec<f64>>,
    /// What the elastic coordinates stand for.
    pub coordinates: Coordinates,
    /// Frequencies of the elastic coordinates \[Hz\], ascending: eigenfrequencies, then those of
    /// static answers.
    pub frequencies: Vec<f64>,
    /// By how much the mesh may put the first of them off, as many as are free modes; none where that is not known \[Hz\].
    #[serde(rename = "frequencies_uncertainty")]
    pub frequency_bands: Vec<f64>,
    /// Sizes that the program has chosen, and why.
    pub chosen: Vec<String>,
}

/// What the elastic coordinates of a body stand for.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Coordinates {
    /// Number of free modes.
    pub free_modes: usize,
    /// Number of modes that a contact interface adds.
    pub interface_modes: usize,
    /// Static answers to joints and loads.
    pub static_answers: Vec<StaticAnswers>,
}

/// Static answers to one joint or load.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct StaticAnswers {
    /// `NAME (child)` or `NAME (parent)` of a joint, the name of a load.
    pub to: String,
    /// Number of coordinates; fewer than directions of force where others have the same answer.
    pub count: usize,
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
    simulate_with(scenario, None, observer, threads, &ModelCache::default())
}

/// As [`simulate`], with the models that are in `cache`, and from the restart point `point` of an
/// earlier run of the same scenario on, if there is one.
///
/// # Errors
/// As [`simulate`]; [`AppError::Model`] if the point does not belong to the models, too.
pub fn simulate_with(
    scenario: &Scenario,
    point: Option<&RunState>,
    observer: &mut dyn Observer,
    threads: usize,
    cache: &ModelCache,
) -> Result<RunReport, AppError> {
    let began = Instant::now();
    observer.stage(Stage::Sizes);
    let run = Prepared::new(&scenario.run)?;
    let scenario = &*sized_for(scenario, &run, threads, cache)?;
    let sizes = began.elapsed().as_secs_f64();
    let mut report = simulate_prepared(run.with_sizes(&scenario.run)?, point, observer, threads, cache)?;
    report.timings.sizes = sizes;
    Ok(report)
}

/// Runs what is prepared, whose sizes are known, as [`simulate_with`] does.
///
/// # Errors
/// Likewise.
pub fn simulate_prepared(
    run: Prepared<'_>,
    point: Option<&RunState>,
    observer: &mut dyn Observer,
    threads: usize,
    cache: &ModelCache,
) -> Result<RunReport, AppError> {
    let spec = run.spec();
    observer.stage(Stage::Bodies);
    let mut model = thread_pool(threads)?.install(|| RunModel::of(run, cache))?;
    observer.stage(Stage::Motion);
    let (started, before) = (Instant::now(), model.timings());
    let end = match point {
        Some(point) => driver::resume(&mut model, &spec.settings, point, observer),
        None => driver::run(&mut model, &spec.settings, observer),
    };
    let end = end?;
    let mut timings = model.timings();
    // Fine models and searches in the run are not time integration.
    let other = |t: &Timings| t.contact + t.reduction + t.search;
    timings.integration = started.elapsed().as_secs_f64() - (other(&timings) - other(&before));
    let ending = if end.is_interrupted { Ending::Interrupted } else { Ending::Complete };
    Ok(RunReport { ending, time: end.time, timings })
}

/// Builds the reduced models of `scenario`, or of its body `body` alone.
///
/// # Errors
/// [`AppError::Model`] if a model cannot be built.
pub fn modes(scenario: &Scenario, body: Option<usize>, threads: usize) -> Result<ModesReport, AppError> {
    modes_with(scenario, body, threads, &ModelCache::default())
}

/// As [`modes`], with the models that are in `cache`, which keeps those that are built.
///
/// # Errors
/// As [`modes`].
pub fn modes_with(
    scenario: &Scenario,
    body: Option<usize>,
    threads: usize,
    cache: &ModelCache,
) -> Result<ModesReport, AppError> {
    let asked = body.map(|body| one_body::asked(scenario, body));
    let sized = sized(asked.as_ref().unwrap_or(scenario), threads, cache)?;
    let alone = body.map(|body| one_body::alone(&sized, body));
    let scenario = alone.as_ref().unwrap_or(&sized);
    let spec = &scenario.run;
    let model = told(build(spec, threads, cache)?);
    let notes = chosen_sizes::notes(&scenario.source.resolved);
    let wanted = body.map(|b| scenario.bodies[b].name.as_str());
    let bodies = model.bodies.iter().zip(&spec.bodies).zip(model.layout(0.0).bodies);
    let bodies = bodies.filter(|((b, _), _)| wanted.is_none_or(|name| b.name == name));
    let of = |name: &str| notes.iter().filter(|n| n.body == name).map(|n| n.text.clone()).collect();
    let bodies = bodies.map(|((body, spec), layout)| BodyModes {
        chosen: of(&body.name),
        frequency_bands: layout.frequency_bands.into_iter().take_while(|band| band.is_finite()).collect(),
        points: points(scenario, body),
        ..body_modes(body, spec)
    });
    Ok(ModesReport { bodies: bodies.collect() })
}

/// Names of the bodies of `scenario`, and small vibrations of the whole system at its initial pose;
/// `is_static`: after elastic coordinates have come to rest, whatever the scenario says.
///
/// # Errors
/// [`AppError::Model`] if a model cannot be built or there is no equilibrium.
pub fn system_modes(
    scenario: &Scenario,
    is_static: bool,
    threads: usize,
) -> Result<(Vec<String>, SystemModes), AppError> {
    system_modes_with(scenario, is_static, threads, &ModelCache::default())
}

/// As [`system_modes`], with the models that are in `cache`, which keeps those that are built.
///
/// # Errors
/// As [`system_modes`].
pub fn system_modes_with(
    scenario: &Scenario,
    is_static: bool,
    threads: usize,
    cache: &ModelCache,
) -> Result<(Vec<String>, SystemModes), AppError> {
    let scenario = &*sized(scenario, threads, cache)?;
    let mut spec = scenario.run.clone();
    if is_static {
        spec.settings.start = Start::Elastic;
    }
    let model = told(build(&spec, threads, cache)?);
    let modes = model.system.small_vibrations(0.0, &model.initial);
    let names = model.bodies.iter().map(|b| b.name.clone()).collect();
    Ok((names, modes.map_err(|e| AppError::model(AdaptiveError::Model(e)))?))
}

/// Tells of bodies what a run would tell of them.
fn told(model: RunModel) -> RunModel {
    of_bodies(&model).iter().for_each(|(_, warning)| tracing::warn!("{}", warning.line()));
    model
}

fn body_modes(body: &BodyModel, spec: &BodySpec) -> BodyModes {
    let n_dofs = spec.kind.imported().map_or(0, ImportedSpec::n_unknowns);
    let plain = BodyModes {
        name: body.name.clone(),
        mass: body.data.mass,
        frequencies: body.frequencies(),
        coordinates: coordinates(body),
        n_dofs,
        ..BodyModes::default()
    };
    let Some(flexible) = body.flexible() else { return plain };
    BodyModes {
        n_elements: flexible.body.space().n_elements(),
        n_dofs: flexible.body.n_unknowns(),
        n_interface: flexible.interface.unknowns.len(),
        ..plain
    }
}

/// Named points of `body` in the components of its model \[m\].
fn points(scenario: &Scenario, body: &BodyModel) -> BTreeMap<String, Vec<f64>> {
    let places = scenario.bodies.iter().find(|file| file.name == body.name).map(|file| file.places.points());
    let n = body.data.motion.n_components();
    places.into_iter().flatten().map(|(name, at)| (name.clone(), at[..n].to_vec())).collect()
}

fn coordinates(body: &BodyModel) -> Coordinates {
    let counts = body.coordinates();
    let answers = counts.answers.into_iter();
    Coordinates {
        free_modes: counts.free,
        interface_modes: counts.interface,
        static_answers: answers.map(|(to, count)| StaticAnswers { to, count }).collect(),
    }
}

/// Builds all models on a pool of `threads` threads.
///
/// # Errors
/// [`AppError::Model`] if a model cannot be built.
pub fn build(spec: &RunSpec, threads: usize, cache: &ModelCache) -> Result<RunModel, AppError> {
    Ok(thread_pool(threads)?.install(|| RunModel::build_with(spec, cache))?)
}
