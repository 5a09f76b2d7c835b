//! What a run is made from: plain, validated values. SI units; body-fixed data in the body's own
//! frame. What they cannot be together is an `AdaptiveError::Unsupported`, said where it is found.
//!
//! Knows shapes, meshes and materials as data; knows no matrices, and no file format.

pub mod accuracy;
pub mod reduction;
pub mod body;
pub mod contact;
pub mod imported;
pub mod kind;
pub mod resolution;
pub mod time_curve;
pub mod joint;

use ffr_dynamics::integration::Method as IntegrationMethod;
use ffr_dynamics::system::JointKind;
use nalgebra::Vector3;

pub use accuracy::Accuracy;
pub use body::{
    Area, ByGroup, Coupling, DiscretisationSpec, ElasticSpec, FlexibleSpec, FrameSpec, Geometry,
    InitialMotion, MeshedSpec, Place, RefinementSpec, RigidSpec,
};
pub use contact::{
    ContactLaw, ContactSpec, DivisionRule, HertzPartner, HertzSpec, HertzSphere, InterfaceModes,
    IntervalSpec, LocalField, LowModes, PenaltySearch, PointRule, SurfaceLaw, Target, TransferMethod,
    TransferSpec, Treatment,
};
pub use iga_core::extent::Extent;
pub use imported::ImportedSpec;
pub use joint::{Attachment, CoordinateSpec, GearSpec, JointSpec, LoadSpec};
pub use kind::{BodyKind, BodySpec};
pub use reduction::{DampingSpec, ReductionSpec};
pub use resolution::{BodyFactors, ContactFactors, Resolution};
pub use time_curve::TimeCurve;

/// Integration in one kind of phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseSettings {
    /// Integration method; `None`: the explicit one, but Gauss collocation between impacts where
    /// bodies vibrate on joints, of which the explicit one would follow every period.
    pub method: Option<IntegrationMethod>,
    /// Longest step \[s\]; infinite where only the model decides.
    pub max_step: f64,
    /// Permitted error a step as a share of the motion's velocity; `None`: the method's own.
    pub tolerance: Option<f64>,
    /// Factor of that error.
    pub tolerance_factor: f64,
    /// Motion slower than this is resolved as if it were this fast \[m/s\].
    pub velocity_floor: f64,
}

/// Error that the explicit method is allowed in a step of an impact, as a share of the motion's velocity, where none is given. An impact
/// takes some hundred steps, and what contact zones and penalty springs leave out of its force is 1e-4 of it and more; between impacts,
/// where steps may be a thousand times as many, the method's own default is taken.
pub const IMPACT_TOLERANCE: f64 = 1e-7;

/// Permitted errors below round-off cannot be met.
const LEAST_TOLERANCE: f64 = 1e-14;

impl PhaseSettings {
    /// Error permitted in a step of `method`, as a share of the motion's velocity.
    pub fn permitted_error(&self, method: IntegrationMethod) -> f64 {
        let tolerance = self.tolerance.unwrap_or_else(|| method.default_tolerance());
        (tolerance * self.tolerance_factor).max(LEAST_TOLERANCE)
    }
}

/// When the bodies of a run are at rest: the root of their mean square speed has been below `speed`
/// for `duration`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestSettings {
    /// Speed [m/s].
    pub speed: f64,
    /// Time \[s\]: bodies that swing or are thrown are slow for a moment.
    pub duration: f64,
}

/// The pose that a run starts from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Start {
    /// As it is given, bodies undeformed.
    #[default]
    Given,
    /// With elastic coordinates in equilibrium, those of joints held, contacts left out.
    Elastic,
    /// With all that is at rest in equilibrium, contacts among it.
    Static,
    /// The same, and nothing else.
    StaticOnly,
}

impl Start {
    /// Whether all that is at rest is in equilibrium.
    pub fn is_static(self) -> bool {
        matches!(self, Self::Static | Self::StaticOnly)
    }
}

/// Settings of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    /// End of the simulated time \[s\].
    pub end_time: f64,
    /// Gravity [m/s²].
    pub gravity: Vector3<f64>,
    /// From what pose it starts.
    pub start: Start,
    /// Share of the largest energy by which the ledger may be open.
    pub energy_tolerance: f64,
    /// Phases without contact.
    pub free: PhaseSettings,
    /// Phases with contact.
    pub impact: PhaseSettings,
    /// Phases in which a contact lasts; without effect where their method is explicit.
    pub lasting: PhaseSettings,
    /// Longest step of impact phases as a share of the period of the highest mode; half of it
    /// resolves the mode.
    pub step_share: f64,
    /// Time without contact force after which an impact has ended \[s\].
    pub quiet_time: Option<f64>,
    /// Number of impacts with whose end the run ends, if it has not before.
    pub stop_after_impacts: Option<u32>,
    /// When bodies count as at rest, with which the run ends, if it has not before.
    pub stop_at_rest: Option<RestSettings>,
    /// Time between stored states in free phases \[s\]; `None`: [`FREE_INTERVAL`], after an impact
    /// less where bodies vibrate fast.
    pub free_interval: Option<f64>,
    /// Least time between stored states in impact phases; zero: every step is stored \[s\].
    pub impact_interval: f64,
    /// Least time between stored states of impact phases as a share of the time since the start of
    /// their phase: long phases do not fill the disk.
    pub phase_share: f64,
    /// The same of free phases; zero where their interval is given.
    pub free_share: f64,
    /// Whether stored states have the pressures at contact points.
    pub pressure: bool,
    /// Whether numbers of impacts get bands.
    pub uncertainty: bool,
    /// How wide the band of a peak force may be, as a share of it; none: as it is.
    pub accuracy: Option<f64>,
}

/// Time between stored states in free phases unless it is given, if nothing vibrates fast \[s\].
pub const FREE_INTERVAL: f64 = 1e-3;

/// Whether strain and stress are recorded at a point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct GaugeRequest {
    /// Strain.
    pub strain: bool,
    /// Stress.
    pub stress: bool,
}

impl GaugeRequest {
    /// Whether anything is.
    pub fn is_any(self) -> bool {
        self.strain || self.stress
    }
}

/// A point to observe.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSpec {
    /// Name.
    pub name: String,
    /// Index of the body.
    pub body: usize,
    /// Undeformed place.
    pub place: Place,
    /// Whether strain and stress are recorded there.
    pub gauge: GaugeRequest,
}

/// Instant of a stress request.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StressInstant {
    /// When the largest contact force on the body acts.
    PeakForce,
    /// At a given time \[s\].
    Time(f64),
}

/// Stress along a straight line.
#[derive(Debug, Clone, PartialEq)]
pub struct StressSpec {
    /// Name.
    pub name: String,
    /// Index of the body, an elastic one.
    pub body: usize,
    /// Ends of the line in the model's components \[m\].
    pub ends: [[f64; 3]; 2],
    /// Number of points, ends included.
    pub samples: usize,
    /// When.
    pub at: StressInstant,
}

/// Everything that a run needs.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSpec {
    /// Bodies; indices elsewhere refer to this list.
    pub bodies: Vec<BodySpec>,
    /// Joints of the tree. A body that is the child of none moves freely.
    pub joints: Vec<JointSpec>,
    /// Joints that close loops.
    pub loops: Vec<JointSpec>,
    /// Gears between coordinates of the tree's joints.
    pub gears: Vec<GearSpec>,
    /// Forces and moments over time.
    pub loads: Vec<LoadSpec>,
    /// Contacts.
    pub contacts: Vec<ContactSpec>,
    /// Observed points.
    pub points: Vec<PointSpec>,
    /// Stress requests.
    pub stress: Vec<StressSpec>,
    /// Settings.
    pub settings: RunSettings,
    /// Factors on what bodies and contacts say of their resolution.
    pub resolution: Resolution,
    /// Level of what the program chooses: meshes and modes. Contacts and phases have theirs in
    /// [`IntervalSpec`], [`SurfaceLaw`] and [`PhaseSettings`].
    pub accuracy: Accuracy,
    /// Relative error of the frequencies of each body on the elements that the program has chosen
    /// for it, as far as it has; empty if for none.
    pub frequency_errors: Vec<Option<f64>>,
}

impl RunSpec {
    /// Whether body `body` is rigid and a joint to ground holds it in its place.
    pub fn is_held(&self, body: usize) -> bool {
        let holds = |joint: &JointSpec| {
            let ends = [joint.parent.body, joint.child.body];
            joint.kind == JointKind::Fixed && ends.contains(&Some(body)) && ends.contains(&None)
        };
        self.bodies[body].kind.is_rigid() && self.joints.iter().any(holds)
    }
}
