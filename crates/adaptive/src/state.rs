//! The state of a run: all that its future depends on, and what is counted from its start: impacts
//! that go on ([`impact_monitor`]), hits of stops ([`stop_hit`]), the ledger of energies
//! ([`ledger`]), largest values ([`peaks`]); the system that it belongs to and a sample of it ([`simulation`]); who is told of
//! it ([`observer`]). A restart file holds it as it is.
//!
//! Knows no bodies' models and no phases.

pub mod impact_monitor;
pub mod ledger;
pub mod observer;
pub mod peaks;
pub mod simulation;
pub mod stop_hit;

use serde::{Deserialize, Serialize};

use crate::record::{PhaseRecord, StressState, ZoneSite};
use crate::state::impact_monitor::Impact;
use crate::state::ledger::{EnergyLedger, NumericalDamping};
use crate::state::peaks::Peaks;
use crate::state::stop_hit::StopHit;
use crate::uncertainty::response::Sequel;

/// State of a run. Where it is reported as a restart point, a run taken up from it has the same
/// result as the one that goes on (docs/decisions/0013-restart-file.md).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RunState {
    /// Simulated time \[s\].
    pub time: f64,
    /// State variables of the system.
    pub state: Vec<f64>,
    /// Their rates: they tell whether a model built later has the same coordinates. Empty where
    /// forces are refused.
    pub rates: Vec<f64>,
    /// Step size to go on with; zero: the integrator finds one \[s\].
    pub step: f64,
    /// The running phase up to here, which is its start in impact phases.
    pub phase: PhaseRecord,
    /// Phases before it.
    pub n_phases: u32,
    /// Impacts before it.
    pub n_impacts: u32,
    /// Hits of stops reported before it.
    pub n_hits: u32,
    /// The stops of the joints, in their order.
    pub hits: Vec<StopHit>,
    /// Fine models built before it.
    pub n_refined: u64,
    /// Time of the state stored last \[s\].
    pub last_output: f64,
    /// When the next state is due \[s\].
    pub next_output: f64,
    /// Time between stored states in the present free phase, as long as it is short \[s\].
    pub free_interval: f64,
    /// Energy that a dissipative integrator removed, up to the state stored last.
    pub numerical: NumericalDamping,
    /// The energy balance up to the state stored last.
    pub ledger: EnergyLedger,
    /// Contacts in the order of the system's force elements.
    pub contacts: Vec<ContactState>,
    /// Warnings given: number of the kind times 2³² plus index of the subject.
    pub warned: Vec<u64>,
    /// Since when the bodies are as slow as at rest \[s\].
    pub slow_since: Option<f64>,
    /// Averages of the axial loads of the bodies; empty before the first state.
    pub loads: Vec<f64>,
    /// States that the stress requests hold.
    pub stress: Vec<Option<StressState>>,
    /// Largest values of joints and points.
    pub peaks: Peaks,
    /// The impacts after which they may have come.
    pub sequels: Vec<Sequel>,
}

impl RunState {
    /// Rows of impacts so far: those of contacts and hits of stops.
    pub fn n_rows(&self) -> u32 {
        self.n_impacts + self.n_hits
    }
}

/// The data of a contact that outlast an impact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactState {
    /// Widths and penalty factors that earlier impacts have found.
    pub history: ImpactHistory,
    /// Smallest gap seen, -∞ once the contact has closed \[m\].
    pub smallest_gap: f64,
    /// When it was seen \[s\].
    pub smallest_gap_time: f64,
    /// The impact reported last, which another touch may join.
    pub impact: Option<Impact>,
    /// Whether it has gone on by Hertz's law and keeps that (docs/theory.md section A.13).
    pub is_by_law: bool,
}

impl ContactState {
    /// Notes that the contact has closed, at `time` \[s\].
    pub fn close(&mut self, time: f64) {
        (self.smallest_gap, self.smallest_gap_time) = (f64::NEG_INFINITY, time);
    }

    /// Whether the contact has closed.
    pub fn has_closed(&self) -> bool {
        self.smallest_gap <= f64::NEG_INFINITY
    }
}

impl Default for ContactState {
    fn default() -> Self {
        Self {
            history: ImpactHistory::default(),
            smallest_gap: f64::INFINITY,
            smallest_gap_time: 0.0,
            impact: None,
            is_by_law: false,
        }
    }
}

/// Zone, width and penalty factor of accepted impacts, from which the search of the next one
/// starts.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ImpactHistory {
    /// Width found over width predicted, per direction, at this contact.
    pub width_factor: Option<[f64; 2]>,
    /// How many times as many elements the last interval should have had as intervals of the
    /// contact have; 0 if there was none.
    pub finer: f64,
    /// Accepted penalty factor times `max_i(A_ii w_i)`, at any contact with the same search: the
    /// number has no unit and does not depend on sizes.
    pub stiffness_ratio: Option<f64>,
    /// Accepted penalty factor of this contact [N/m³].
    pub penalty: Option<f64>,
    /// Accepted contact zones of this contact, on contact body and target.
    pub zones: [Option<ZoneSite>; 2],
}
