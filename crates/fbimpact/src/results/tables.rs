//! Rows of the tables in a result file.

use adaptive::record::{ImpactRecord, PhaseKind, PhaseRecord, TransferRecord, TryRecord, ZoneSite};
use hdf5::types::VarLenUnicode;
use hdf5::{H5Type, Result};

use super::series::unicode;

/// A row of `/phases`.
#[derive(Debug, Clone, PartialEq, H5Type)]
#[repr(C)]
pub struct PhaseRow {
    /// "free" or "impact".
    pub kind: VarLenUnicode,
    /// \[s\]
    pub start: f64,
    /// \[s\]
    pub end: f64,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the right-hand side.
    pub evaluations: u64,
    /// \[s\]
    pub wall_time: f64,
}

/// Units of the columns of `/phases`.
pub const PHASE_UNITS: &str =
    "kind: –, start: s, end: s, steps: –, rejected: –, evaluations: –, wall_time: s";

impl PhaseRow {
    /// The row of a record.
    pub fn new(r: &PhaseRecord) -> Result<Self> {
        let kind = match r.kind {
            PhaseKind::Free => "free",
            PhaseKind::Impact => "impact",
        };
        Ok(Self {
            kind: unicode(kind)?,
            start: r.start,
            end: r.end,
            steps: r.steps,
            rejected: r.rejected,
            evaluations: r.evaluations,
            wall_time: r.wall_time,
        })
    }
}

/// A row of `/impacts`.
#[derive(Debug, Clone, PartialEq, H5Type)]
#[repr(C)]
pub struct ImpactRow {
    /// Name of the contact.
    pub contact: VarLenUnicode,
    /// First contact \[s\].
    pub start: f64,
    /// Last contact \[s\].
    pub end: f64,
    /// Largest normal force \[N\].
    pub peak_force: f64,
    /// Its time \[s\].
    pub peak_time: f64,
    /// [N s]
    pub impulse: f64,
    /// [m/s]
    pub approach_velocity: f64,
    /// [m/s]
    pub separation_velocity: f64,
    /// Ratio of the two; NaN where it has no meaning.
    pub restitution: f64,
}

/// Units of the columns of `/impacts`.
pub const IMPACT_UNITS: &str = "contact: –, start: s, end: s, peak_force: N, peak_time: s, impulse: N s, \
    approach_velocity: m/s, separation_velocity: m/s, restitution: –";

impl ImpactRow {
    /// The row of a record of the contact called `contact`.
    pub fn new(r: &ImpactRecord, contact: &str) -> Result<Self> {
        Ok(Self {
            contact: unicode(contact)?,
            start: r.start,
            end: r.end,
            peak_force: r.peak_force,
            peak_time: r.peak_time,
            impulse: r.impulse,
            approach_velocity: r.approach_velocity,
            separation_velocity: r.separation_velocity,
            restitution: r.restitution,
        })
    }
}

/// A row of `/tries`.
#[derive(Debug, Clone, PartialEq, H5Type)]
#[repr(C)]
pub struct TryRow {
    /// Index of the impact, from 0.
    pub impact: u32,
    /// Number of the try, from 1.
    #[hdf5(rename = "try")]
    pub number: u32,
    /// \[s\]
    pub start: f64,
    /// Time reached \[s\].
    pub stop: f64,
    /// [N/m³]
    pub penalty_start: f64,
    /// [N/m³]
    pub penalty_end: f64,
    /// \[m\]
    pub interval_widths: [f64; 2],
    /// Contact elements over interval elements.
    pub utilisation: [f64; 2],
    /// Elements of the fine model.
    pub elements: u64,
    /// Its freedoms.
    pub freedoms: u64,
    /// Its interface freedoms.
    pub interface_freedoms: u64,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// \[N\]
    pub peak_force: f64,
    /// "accepted", "rejected" or "failed".
    pub outcome: VarLenUnicode,
    /// Why.
    pub reason: VarLenUnicode,
    /// \[s\]
    pub wall_time: f64,
    /// \[s\]
    pub cpu_time: f64,
}

/// Units of the columns of `/tries`.
pub const TRY_UNITS: &str = "impact: –, try: –, start: s, stop: s, penalty_start: N/m³, penalty_end: N/m³, \
    interval_widths: m, utilisation: –, elements: –, freedoms: –, interface_freedoms: –, steps: –, rejected: –, \
    peak_force: N, outcome: –, reason: –, wall_time: s, cpu_time: s";

impl TryRow {
    /// The row of a record.
    pub fn new(r: &TryRecord) -> Result<Self> {
        Ok(Self {
            impact: r.impact,
            number: r.number,
            start: r.start,
            stop: r.stop,
            penalty_start: r.penalty_start,
            penalty_end: r.penalty_end,
            interval_widths: r.interval_widths,
            utilisation: r.utilisation,
            elements: r.elements,
            freedoms: r.freedoms,
            interface_freedoms: r.interface_freedoms,
            steps: r.steps,
            rejected: r.rejected,
            peak_force: r.peak_force,
            outcome: unicode(r.outcome.identifier())?,
            reason: unicode(&r.reason)?,
            wall_time: r.wall_time,
            cpu_time: r.cpu_time,
        })
    }
}

/// A row of `/transfers`.
#[derive(Debug, Clone, PartialEq, H5Type)]
#[repr(C)]
pub struct TransferRow {
    /// \[s\]
    pub time: f64,
    /// "coarse to fine", "fine to coarse" or "penalty".
    pub direction: VarLenUnicode,
    /// Name of the contact.
    pub contact: VarLenUnicode,
    /// \[J\]
    pub energy_before: f64,
    /// \[J\]
    pub energy_after: f64,
    /// [kg m/s]
    pub momentum_change: f64,
    /// Face of the contact body that the fine model's interval lies on; -1 if no fine model came.
    pub face: i32,
    /// Parameters of the interval's centre there; zero without.
    pub centre: [f64; 3],
    /// The same of the target body.
    pub target_face: i32,
    /// The same of the target body.
    pub target_centre: [f64; 3],
    /// \[m\]
    pub interval_widths: [f64; 2],
}

/// Units of the columns of `/transfers`.
pub const TRANSFER_UNITS: &str = "time: s, direction: –, contact: –, energy_before: J, energy_after: J, \
    momentum_change: kg m/s, face: –, centre: –, target_face: –, target_centre: –, interval_widths: m";

impl TransferRow {
    /// The row of a record of the contact called `contact`.
    pub fn new(r: &TransferRecord, contact: &str) -> Result<Self> {
        Ok(Self {
            time: r.time,
            direction: unicode(r.direction.identifier())?,
            contact: unicode(contact)?,
            energy_before: r.energy_before,
            energy_after: r.energy_after,
            momentum_change: r.momentum_change,
            face: r.site.map_or(-1, |s| s.face as i32),
            centre: r.site.map_or([0.0; 3], |s| s.centre),
            target_face: r.target_site.map_or(-1, |s| s.face as i32),
            target_centre: r.target_site.map_or([0.0; 3], |s| s.centre),
            interval_widths: r.site.map_or([0.0; 2], |s| s.widths),
        })
    }

    /// Where the fine models of the contact body and of the target lie, as far as any came. Columns that a result of an earlier
    /// version does not have are zero: no model has an interval without width.
    pub fn sites(&self) -> [Option<ZoneSite>; 2] {
        let widths = self.interval_widths;
        let is_interval = widths.iter().all(|w| w.is_finite() && *w > 0.0);
        [(self.face, self.centre), (self.target_face, self.target_centre)].map(|(face, centre)| {
            let face = u32::try_from(face).ok()?;
            let is_place = is_interval && centre.iter().all(|u| u.is_finite());
            is_place.then_some(ZoneSite { face, centre, widths })
        })
    }
}
