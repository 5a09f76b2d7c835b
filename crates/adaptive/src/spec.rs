//! What a run is made from: plain, validated values. SI units; body-fixed data in the body's own frame.

use contact_qs::quasistatic::Method;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use nalgebra::{UnitQuaternion, Vector3};

/// Motion of a body at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct InitialMotion {
    /// Origin of the body's frame \[m\].
    pub position: Vector3<f64>,
    /// Rotation from the body's frame to space.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity of the origin in space [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity in space [rad/s].
    pub angular_velocity: Vector3<f64>,
}

/// Small elements about a point of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinementSpec {
    /// Centre, in the model's components \[m\].
    pub centre: [f64; 3],
    /// Width of the zone of small elements along the surface; from the axis outwards where the centre lies on the axis of an
    /// axisymmetric model \[m\].
    pub width: f64,
    /// Elements across the width; elements into the depth have the same size.
    pub elements: usize,
    /// Ratio of neighbouring elements outside the zone.
    pub ratio: f64,
}

impl RefinementSpec {
    /// Reach of a zone of width `width` about `centre` on either side \[m\].
    pub fn half_width(model: &Model, centre: &[f64; 3], width: f64) -> f64 {
        let is_on_axis = *model == Model::Axisymmetric && centre[0].abs() < ON_AXIS * width;
        if is_on_axis { width } else { 0.5 * width }
    }
}

/// Part of a zone's width within which its centre counts as lying on the axis.
const ON_AXIS: f64 = 1e-9;

/// Spline space of a body; one entry a parametric direction.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscretisationSpec {
    /// Degrees.
    pub degrees: Vec<usize>,
    /// Uniform elements before refinement.
    pub elements: Vec<usize>,
    /// Interior knots in (0, 1) that take the place of uniform elements.
    pub knots: Option<Vec<Vec<f64>>>,
    /// Local refinements.
    pub refine: Vec<RefinementSpec>,
}

/// Reduced basis of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReductionSpec {
    /// The first free eigenmodes.
    Modal {
        /// Number of elastic modes.
        modes: usize,
    },
    /// Craig-Bampton.
    CraigBampton {
        /// Number of low-frequency modes.
        modes: usize,
        /// Number of fixed-interface modes; `None`: enough for the low-frequency ones to be right.
        fixed_interface_modes: Option<usize>,
    },
    /// Every elastic mode of the model.
    All,
}

/// A flexible body.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticBodySpec {
    /// Name.
    pub name: String,
    /// Exact geometry.
    pub shape: Shape,
    /// Kinematics.
    pub model: Model,
    /// Material.
    pub material: Material,
    /// Spline space.
    pub discretisation: DiscretisationSpec,
    /// Reduced basis.
    pub reduction: ReductionSpec,
    /// Rayleigh damping: two frequencies \[Hz\] and the damping ratio at both.
    pub damping: Option<([f64; 2], f64)>,
    /// Motion at the start.
    pub motion: InitialMotion,
}

/// Where contact points stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointRule {
    /// Greville abscissae of the surface functions (\[A\]).
    Greville,
    /// Gauss points of the surface elements (\[B\]).
    Gauss,
}

/// Contact of a flexible body with a fixed rigid plane.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneContactSpec {
    /// Name.
    pub name: String,
    /// Index of the body among the flexible ones.
    pub body: usize,
    /// A point of the plane \[m\].
    pub plane_point: Vector3<f64>,
    /// Unit normal that points to the body's side.
    pub plane_normal: Vector3<f64>,
    /// Whether high-frequency modes follow statically; all modes are dynamic otherwise.
    pub is_quasistatic: bool,
    /// Penalty factor, infinite for the exact constraint [N/m³].
    pub penalty: f64,
    /// Contact points.
    pub points: PointRule,
    /// Solver of the quasistatic problem.
    pub method: Method,
    /// Width of the contact interval about the point of first contact, measured as [`RefinementSpec::width`] \[m\]; `None`:
    /// the refined zone there.
    pub width: Option<f64>,
    /// Elements across the interval, for which the body is refined; `None`: those that its discretisation has there.
    pub elements: Option<usize>,
}

/// Integration in one kind of phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseSettings {
    /// Longest step \[s\]; infinite where only the model decides.
    pub max_step: f64,
    /// Permitted error a step as a share of the motion's velocity.
    pub tolerance: f64,
    /// Motion slower than this is resolved as if it were this fast \[m/s\].
    pub velocity_floor: f64,
}

/// Settings of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    /// End of the simulated time \[s\].
    pub end_time: f64,
    /// Gravity [m/s²].
    pub gravity: Vector3<f64>,
    /// Phases without contact.
    pub free: PhaseSettings,
    /// Phases with contact.
    pub impact: PhaseSettings,
    /// Time without contact force after which an impact has ended \[s\].
    pub quiet_time: Option<f64>,
    /// Time between stored states in free phases \[s\].
    pub free_interval: f64,
}

/// A point to observe.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSpec {
    /// Name.
    pub name: String,
    /// Index of the body among the flexible ones.
    pub body: usize,
    /// Undeformed place in the model's components \[m\].
    pub place: [f64; 3],
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
    /// Index of the body among the flexible ones.
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
    /// Flexible bodies.
    pub bodies: Vec<ElasticBodySpec>,
    /// Contacts.
    pub contacts: Vec<PlaneContactSpec>,
    /// Observed points.
    pub points: Vec<PointSpec>,
    /// Stress requests.
    pub stress: Vec<StressSpec>,
    /// Settings.
    pub settings: RunSettings,
}
