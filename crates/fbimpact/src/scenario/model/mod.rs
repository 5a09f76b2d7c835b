//! The validated scenario: plain values, ready to build models from. SI units and radians.

mod bodies;
mod contacts;
mod imported;
mod joints;
mod resolution;

use std::path::PathBuf;

pub use bodies::*;
pub use contacts::*;
pub use imported::*;
pub use joints::*;
pub use resolution::*;

/// A scenario that has passed every check.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Title for reports; may be empty.
    pub title: String,
    /// Time span, gravity and integrators.
    pub simulation: Simulation,
    /// Bodies in the order of the file.
    pub bodies: Vec<Body>,
    /// Joints in the order of the file.
    pub joints: Vec<Joint>,
    /// Loads in the order of the file.
    pub loads: Vec<Load>,
    /// Contacts in the order of the file.
    pub contacts: Vec<Contact>,
    /// Factors on the resolution of all these.
    pub resolution: Resolution,
    /// What to store.
    pub output: Output,
    /// Where the scenario comes from.
    pub source: Source,
}

/// Origin of a scenario, stored in the result.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The file as named on the command line.
    pub path: PathBuf,
    /// SHA-256 of the file as read, in hexadecimal.
    pub sha256: String,
    /// The scenario with overrides applied and defaults filled in, as TOML that reads back to the same scenario.
    pub resolved: String,
}

/// Time span, gravity and integrators.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// End of the simulated time, which starts at zero \[s\].
    pub end_time: f64,
    /// Acceleration of gravity [m/s²].
    pub gravity: [f64; 3],
    /// Whether elastic coordinates start from equilibrium with the joint coordinates held.
    pub static_start: bool,
    /// Time without contact force after which an impact has ended \[s\]; `None`: chosen from the model.
    pub quiet_time: Option<f64>,
    /// Share of the largest energy by which the energy ledger may be open.
    pub energy_tolerance: f64,
    /// Integration between impacts; its `max_step` is never `None`.
    pub free: Integration,
    /// Integration in impact phases; `max_step` `None` means `1 / (2 f_max)`.
    pub impact: Integration,
}

/// Settings of one integrator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integration {
    /// Method.
    pub integrator: Integrator,
    /// Longest step \[s\].
    pub max_step: Option<f64>,
    /// Permitted error of a step as a share of the motion's velocity.
    pub rtol: f64,
}

/// Time integration methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// Explicit Dormand-Prince 5(4).
    DormandPrince,
    /// Implicit TR-BDF2.
    TrBdf2,
    /// Implicit, order four.
    Esdirk4,
}

/// What to store.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Time between stored states in free phases \[s\].
    pub free_interval: f64,
    /// Least time between stored states in impact phases; zero: every step is stored \[s\].
    pub impact_interval: f64,
    /// Compression of the result file.
    pub compression: Compression,
    /// Observed points.
    pub points: Vec<OutputPoint>,
    /// Stress along lines.
    pub stress: Vec<StressLine>,
}

/// Compression of datasets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    /// None.
    None,
    /// Shuffle and gzip level 1.
    Gzip,
}

/// An observed point.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputPoint {
    /// Name in the scenario.
    pub name: String,
    /// Index of the body.
    pub body: usize,
    /// Where on it.
    pub at: Place,
}

/// Stress along a straight line through a body.
#[derive(Debug, Clone, PartialEq)]
pub struct StressLine {
    /// Name in the scenario.
    pub name: String,
    /// Index of the body.
    pub body: usize,
    /// First point.
    pub from: Place,
    /// Last point.
    pub to: Place,
    /// Number of points, ends included.
    pub samples: usize,
    /// When.
    pub at: StressTime,
}

/// Instant of a stress line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StressTime {
    /// When the largest contact force on the body acts.
    PeakForce,
    /// A given time \[s\].
    Time(f64),
}
