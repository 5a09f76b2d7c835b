//! What a run reports while it goes on: samples, phases, impacts, events of contacts ([`event`]), trials, transfers, timings; its
//! warnings ([`warning`]), what may be wrong with a result ([`finding`]), and which work is being
//! done ([`work`]).
//!
//! Knows numbers with names and units; does not know how they are computed or stored.

pub mod band;
pub mod event;
pub mod finding;
pub mod peak;
pub mod stress;
pub mod warning;
pub mod work;
mod zone_site;

use iga_core::elasticity::kinematics::PointState;
use serde::{Deserialize, Serialize};

pub use band::Band;
pub use event::{EventKind, EventRecord};
pub use peak::{PeakBand, PeakOf, PeakRecord};
pub use stress::StressRecord;
pub use zone_site::{MOST_TOUCHES, TargetPlace, TouchedPart, ZoneSite, ZoneSize};

use crate::spec::GaugeRequest;
use crate::store::CacheUse;

/// Fixed facts of a run that an observer needs before the first sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RunLayout {
    /// Bodies in the order of [`Sample::bodies`].
    pub bodies: Vec<BodyLayout>,
    /// Names of contacts in the order of [`Sample::contacts`].
    pub contacts: Vec<String>,
    /// Names of the stops of joints, whose indices in records of impacts follow those of the contacts.
    pub stops: Vec<String>,
    /// Observed points in the order of [`Sample::points`].
    pub points: Vec<PointLayout>,
    /// Joints in the order of [`Sample::joints`]; those that close loops have no coordinates.
    pub joints: Vec<JointLayout>,
    /// Gears in the order of [`Sample::gears`]: names, units of their forces.
    pub gears: Vec<NameAndUnit>,
    /// Start and end of the simulated time \[s\].
    pub time_span: (f64, f64),
}

/// Name and spectrum of a body.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyLayout {
    /// Name in the scenario.
    pub name: String,
    /// Eigenfrequencies of the elastic coordinates \[Hz\]; empty for rigid bodies.
    pub eigenfrequencies: Vec<f64>,
    /// By how much the mesh may put them off; NaN where that is not known \[Hz\].
    pub frequency_bands: Vec<f64>,
}

/// Name of an observed point, and what is recorded of it besides its motion.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointLayout {
    /// Name in the scenario.
    pub name: String,
    /// Strain and stress.
    pub gauge: GaugeRequest,
    /// Whether their components are those of an axisymmetric model.
    pub is_axisymmetric: bool,
}

/// Name and coordinates of a joint.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JointLayout {
    /// Name in the scenario.
    pub name: String,
    /// Kind, such as "revolute".
    pub kind: String,
    /// Name and unit of every position coordinate.
    pub positions: Vec<NameAndUnit>,
    /// Name and unit of every velocity.
    pub velocities: Vec<NameAndUnit>,
}

/// Name and unit of a coordinate.
pub type NameAndUnit = (String, String);

/// Energies at one instant \[J\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy of all bodies.
    pub kinetic: f64,
    /// Elastic energy of the dynamic (low-frequency) coordinates.
    pub elastic_low: f64,
    /// Quasistatic elastic energy of the contact zones.
    pub elastic_high: f64,
    /// Potential of gravity, zero at the start.
    pub gravity: f64,
    /// Energy in penalty springs.
    pub penalty: f64,
    /// Energy in joint springs.
    pub springs: f64,
    /// Work lost to damping and friction so far.
    pub dissipated: f64,
    /// Work supplied by loads, drives and prescribed motion so far.
    pub supplied: f64,
    /// Energy that a dissipative integrator removed so far: what is missing after all other
    /// entries.
    pub numerical: f64,
}

impl Energies {
    /// Energy held and lost, less the work supplied: constant in an exact solution. What changes it
    /// otherwise is the error of the explicit integrator; what the implicit one removes is in the
    /// entry `numerical`.
    pub fn total(&self) -> f64 {
        self.kinetic
            + self.elastic_low
            + self.elastic_high
            + self.gravity
            + self.penalty
            + self.springs
            + self.dissipated
            + self.numerical
            - self.supplied
    }

    /// Energy held, moved and lost, whatever its sign: what an open ledger is compared with
    /// (docs/theory.md Eq. P.2).
    pub fn size(&self) -> f64 {
        let held = self.kinetic + self.elastic_low + self.elastic_high + self.penalty + self.springs;
        held + self.gravity.abs() + self.dissipated.abs() + self.supplied.abs()
    }
}

/// Motion of one body at one instant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodySample {
    /// Origin of the reference frame \[m\].
    pub position: [f64; 3],
    /// Unit quaternion `w x y z` from body frame to inertial frame.
    pub rotation: [f64; 4],
    /// Velocity of the origin in the inertial frame [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity in the inertial frame [rad/s].
    pub angular_velocity: [f64; 3],
    /// Deformed centre of mass \[m\].
    pub centre_of_mass: [f64; 3],
    /// Elastic coordinates.
    pub elastic_coordinates: Vec<f64>,
    /// Their rates.
    pub elastic_velocities: Vec<f64>,
}

/// State of one contact at one instant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContactSample {
    /// Sum of the normal point forces \[N\].
    pub normal_force: f64,
    /// Total force on the contact body in the inertial frame \[N\].
    pub force: [f64; 3],
    /// Friction force on the contact body in the inertial frame \[N\].
    pub friction_force: [f64; 3],
    /// Largest penetration of a contact point, zero without contact \[m\].
    pub penetration: f64,
    /// Number of points in contact.
    pub active_points: u32,
    /// Number of points that slide.
    pub sliding_points: u32,
    /// Sum of tributary areas of the points in contact \[m²\].
    pub contact_area: f64,
    /// Penalty factor in use, infinite for the exact constraint [N/m³].
    pub penalty: f64,
}

/// Normal pressure at a contact point that carries force.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PressurePoint {
    /// The undeformed point in the frame of the contact body \[m\].
    pub position: [f64; 3],
    /// Its tributary area; that of a ring in axisymmetric models \[m²\].
    pub area: f64,
    /// Normal force over area \[Pa\].
    pub pressure: f64,
}

/// An observed point at one instant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PointSample {
    /// Deformed position \[m\].
    pub position: [f64; 3],
    /// Velocity [m/s].
    pub velocity: [f64; 3],
    /// Strain and stress in the axes of the body's frame; zero where they are not recorded.
    pub state: PointState,
}

/// Coordinates and reaction of a joint at one instant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JointSample {
    /// Positions, prescribed ones included [m, rad, quaternion]; none of a joint that closes a
    /// loop.
    pub positions: Vec<f64>,
    /// Velocities [m/s, rad/s]; none of a joint that closes a loop.
    pub velocities: Vec<f64>,
    /// Force that the joint exerts on its child, in the inertial frame \[N\].
    pub reaction_force: [f64; 3],
    /// Moment that it exerts on its child about the place of the child's marker, in the inertial
    /// frame \[N m\].
    pub reaction_moment: [f64; 3],
}

/// Everything recorded at one instant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sample {
    /// Simulated time \[s\].
    pub time: f64,
    /// Index of the running phase.
    pub phase: u32,
    /// Energy ledger.
    pub energies: Energies,
    /// Linear momentum [kg m/s].
    pub linear_momentum: [f64; 3],
    /// Angular momentum about the inertial origin [kg m²/s].
    pub angular_momentum: [f64; 3],
    /// One entry per body.
    pub bodies: Vec<BodySample>,
    /// One entry per contact.
    pub contacts: Vec<ContactSample>,
    /// Points that carry force, one entry per contact; none for laws without points.
    pub pressures: Vec<Vec<PressurePoint>>,
    /// One entry an observed point.
    pub points: Vec<PointSample>,
    /// One entry per joint of the scenario: those of the tree, then those that close loops.
    pub joints: Vec<JointSample>,
    /// Force of each gear along its second coordinate [N, N m].
    pub gears: Vec<f64>,
}

/// Kind of a phase (\[A\] Fig. 2).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PhaseKind {
    /// No contact force acts.
    #[default]
    Free,
    /// Contact is watched at every stage of every step.
    Impact,
    /// Contact lasts: the pace is that of the motion, whatever vibrates.
    Lasting,
}

impl PhaseKind {
    /// Name in logs and files.
    pub fn identifier(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Impact => "impact",
            Self::Lasting => "lasting",
        }
    }
}

/// A finished phase.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseRecord {
    /// Kind.
    pub kind: PhaseKind,
    /// Start \[s\].
    pub start: f64,
    /// End \[s\].
    pub end: f64,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the right-hand side.
    pub evaluations: u64,
    /// Wall time \[s\].
    pub wall_time: f64,
}

/// A finished impact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ImpactRecord {
    /// Index among the records of impacts, from 0. A later record with the same index replaces the
    /// earlier one: another touch has been found to belong to the impact (theory Eq. Q.1).
    pub row: u32,
    /// Index of the contact.
    pub contact: u32,
    /// First contact \[s\].
    pub start: f64,
    /// Last contact \[s\].
    pub end: f64,
    /// Largest normal force \[N\].
    pub peak_force: f64,
    /// Its time \[s\].
    pub peak_time: f64,
    /// Time integral of the normal force [N s].
    pub impulse: f64,
    /// Closing speed of the bodies' rigid motions at the place of contact when it closes, along the
    /// normal at the peak (theory Eq. Q.2) [m/s].
    pub approach_velocity: f64,
    /// Their separating speed when it opens for the last time, along the same normal; NaN while
    /// force acts [m/s].
    pub separation_velocity: f64,
    /// Ratio of the two (theory Eq. Q.3); NaN where it has no meaning: without approach, while
    /// force acts, if the motions go on approaching each other, if the bodies rang before they
    /// touched (Eq. Q.4), if another contact pressed the same bodies meanwhile, or they touched at several places at once.
    pub restitution: f64,
    /// By how much these numbers may be off because of what the run is resolved to.
    pub band: Band,
}

/// One trial of an impact phase.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TrialRecord {
    /// Index of the impact among the records of impacts, from 0.
    pub impact: u32,
    /// Number of the trial, from 1.
    pub number: u32,
    /// Start \[s\].
    pub start: f64,
    /// Time reached \[s\].
    pub stop: f64,
    /// Penalty factor at the start [N/m³].
    pub penalty_start: f64,
    /// Penalty factor at the end [N/m³].
    pub penalty_end: f64,
    /// Widths of the contact interval along the two surface directions \[m\]; the second is zero
    /// for curves.
    pub interval_widths: [f64; 2],
    /// Contact elements over interval elements, per direction.
    pub utilisation: [f64; 2],
    /// Elements of the fine model.
    pub elements: u64,
    /// Degrees of freedom of the fine model.
    pub dofs: u64,
    /// Interface degrees of freedom.
    pub interface_dofs: u64,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Largest normal force \[N\].
    pub peak_force: f64,
    /// How the trial ended.
    pub outcome: TrialOutcome,
    /// Reason for the outcome, a sentence.
    pub reason: String,
    /// Wall time \[s\].
    pub wall_time: f64,
    /// Processor time of the whole process; NaN where the system does not tell \[s\].
    pub cpu_time: f64,
}

/// How a trial of an impact ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TrialOutcome {
    /// The trial is accepted and reported as the result.
    Accepted,
    /// Another trial follows.
    #[default]
    Rejected,
    /// The user stopped the run in this trial; what it has computed is reported.
    Interrupted,
    /// The trial ended the run with an error.
    Failed,
}

impl TrialOutcome {
    /// Name in logs and files.
    pub fn identifier(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::Rejected => "rejected",
            Self::Interrupted => "interrupted",
            Self::Failed => "failed",
        }
    }
}

/// A change of the model in the course of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TransferDirection {
    /// The fine models of a contact come into the system.
    #[default]
    CoarseToFine,
    /// The fine models leave the system.
    FineToCoarse,
    /// A penalty factor is lowered.
    Penalty,
}

impl TransferDirection {
    /// Name in logs and files.
    pub fn identifier(self) -> &'static str {
        match self {
            Self::CoarseToFine => "coarse to fine",
            Self::FineToCoarse => "fine to coarse",
            Self::Penalty => "penalty",
        }
    }
}

/// A change of the model in the course of a run, and what it did to the ledger.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TransferRecord {
    /// Time of the change \[s\].
    pub time: f64,
    /// The kind of change.
    pub direction: TransferDirection,
    /// Index of the contact.
    pub contact: u32,
    /// Total energy before \[J\].
    pub energy_before: f64,
    /// Total energy after \[J\].
    pub energy_after: f64,
    /// Size of the change of the linear momentum [kg m/s].
    pub momentum_change: f64,
    /// Where the fine model of the contact body lies, if one came.
    pub site: Option<ZoneSite>,
    /// Where the fine model of the target body lies, if one came.
    pub target_site: Option<ZoneSite>,
    /// How far a zone on a smooth surface in place of the sides of a mesh was moved along its
    /// normal \[m\].
    pub offset: f64,
}

impl TransferRecord {
    /// The place on an edge or a corner of the target that the contact body meets, if a model came
    /// for such a touch.
    pub fn met(&self) -> Option<TargetPlace> {
        self.site.and_then(|site| site.meets)
    }
}

/// Wall seconds spent in each stage of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Timings {
    /// Before the models, but for the next.
    pub preparation: f64,
    /// Choice of meshes and numbers of modes.
    pub sizes: f64,
    /// Geometry and assembly of the matrices.
    pub assembly: f64,
    /// Eigenmodes and compliance.
    pub reduction: f64,
    /// Contact search.
    pub search: f64,
    /// Contact solver.
    pub contact: f64,
    /// Time integration without contact.
    pub integration: f64,
    /// Writing results.
    pub output: f64,
    /// What has no field of its own.
    pub rest: f64,
    /// Models kept between runs.
    pub cache: CacheUse,
}

/// State of a body at the instant of a stress request.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StressState {
    /// Time \[s\].
    pub time: f64,
    /// Contact force that belongs to it \[N\].
    pub force: f64,
    /// Elastic coordinates.
    pub elastic: Vec<f64>,
    /// Forces on the interface unknowns \[N\]; empty if all modes are dynamic.
    pub interface_forces: Vec<f64>,
    /// Forces of contacts that were refined in the run.
    pub zones: Vec<ZoneLoad>,
    /// Forces of which the elastic coordinates alone tell.
    pub bare: Vec<BareForce>,
}

/// The force of a contact on a body whose modes alone tell of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BareForce {
    /// Index of the contact.
    pub contact: u32,
    /// Index of the body.
    pub body: u32,
    /// Where it acts, in the frame of the body \[m\].
    pub place: [f64; 3],
    /// Its size \[N\].
    pub force: f64,
    /// Radius of the circle over which it is spread, of plane models half the width \[m\].
    pub radius: f64,
}

/// Forces of a contact that was refined in the run on a body.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ZoneLoad {
    /// Index of the contact.
    pub contact: u32,
    /// Where the fine model of the body lies.
    pub site: ZoneSite,
    /// Forces on the interface unknowns of that model \[N\].
    pub forces: Vec<f64>,
}
