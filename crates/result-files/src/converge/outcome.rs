//! The outcome of a run: its impacts, the motions at its end, the largest values where it was asked.

use std::path::{Path, PathBuf};

pub use super::motion::Motion;
use super::motion::motions;
use super::peaks::{Peak, peaks};
use crate::collect;
use crate::error::ResultError;
use crate::stored::Stored;
use crate::tables::ImpactRow;

/// The outcome of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outcome {
    /// Whether the run reached its end.
    pub is_complete: bool,
    /// `complete`, `failed`, `interrupted`, or what else is known (see
    /// [`crate::collect::Run::status`]).
    pub status: String,
    /// Why, if the run is not complete.
    pub message: String,
    /// Exit code of the process; none if it was ended by a signal.
    pub exit_code: Option<i32>,
    /// The result.
    pub result: PathBuf,
    /// Whether it was there from an earlier call.
    pub is_reused: bool,
    /// Seconds in all phases.
    pub wall_time: Option<f64>,
    /// Impacts in the order of the result.
    pub impacts: Vec<Impact>,
    /// Motions at the end, in the order of names.
    pub motions: Vec<Motion>,
    /// Largest values at the places that the scenario asks for.
    pub peaks: Vec<Peak>,
}

/// An impact.
#[derive(Debug, Clone, PartialEq)]
pub struct Impact {
    /// Name of the contact.
    pub contact: String,
    /// Number among the impacts of the contact, from 1.
    pub order: usize,
    /// First contact \[s\].
    pub start: f64,
    /// Time to the last contact \[s\].
    pub duration: f64,
    /// Largest normal force \[N\].
    pub peak_force: f64,
    /// Normal force over time [N s].
    pub impulse: f64,
    /// Bands of peak force, duration and impulse, as the run has them; NaN where it has none \[N, s, N s\].
    pub bands: [f64; 3],
}

impl Outcome {
    /// What is left of the run that was to write `result`.
    ///
    /// # Errors
    /// [`ResultError::File`] if a complete result cannot be read.
    pub fn read(result: &Path) -> Result<Self, ResultError> {
        let mut runs = collect::find(&[result.to_owned()], &[])?;
        let run = runs.pop().unwrap_or_default();
        let mut outcome = Self {
            is_complete: run.status == "complete",
            status: run.status,
            message: run.message.strip_prefix("error: ").map_or(run.message.clone(), str::to_owned),
            exit_code: run.exit_code,
            result: result.to_owned(),
            is_reused: false,
            wall_time: run.wall_time,
            impacts: impacts(&run.impacts),
            motions: Vec::new(),
            peaks: Vec::new(),
        };
        if outcome.is_complete {
            let stored = Stored::open(result)?;
            outcome.motions = motions(&stored)?;
            outcome.peaks = peaks(&stored)?;
        }
        Ok(outcome)
    }
}

fn impacts(rows: &[ImpactRow]) -> Vec<Impact> {
    let order = |i: usize| rows[..=i].iter().filter(|r| r.contact == rows[i].contact).count();
    let impact = |(i, row): (usize, &ImpactRow)| Impact {
        contact: row.contact.as_str().to_owned(),
        order: order(i),
        start: row.start,
        duration: row.end - row.start,
        peak_force: row.peak_force,
        impulse: row.impulse,
        bands: [row.peak_force_uncertainty, row.duration_uncertainty, row.impulse_uncertainty],
    };
    rows.iter().enumerate().map(impact).collect()
}
