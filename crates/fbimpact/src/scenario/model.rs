//! The validated scenario: plain values, ready to build models from. SI units and radians.

use std::path::PathBuf;

/// A scenario that has passed every check.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Title for reports; may be empty.
    pub title: String,
    /// Time span, gravity and integrators.
    pub simulation: Simulation,
    /// Bodies in the order of the file.
    pub bodies: Vec<Body>,
    /// Contacts in the order of the file.
    pub contacts: Vec<Contact>,
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
    /// Time without contact force after which an impact has ended \[s\]; `None`: chosen from the model.
    pub quiet_time: Option<f64>,
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
    /// Motion slower than this is resolved as if it were this fast \[m/s\].
    pub velocity_floor: f64,
}

/// Time integration methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// Explicit Dormand-Prince 5(4).
    DormandPrince,
}

/// Linear elastic, isotropic material.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the scenario.
    pub name: String,
    /// Young's modulus \[Pa\].
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
    /// Density [kg/m³].
    pub density: f64,
}

/// A body and its initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name in the scenario.
    pub name: String,
    /// What it is.
    pub kind: BodyKind,
    /// Initial position of the body's origin \[m\].
    pub position: [f64; 3],
    /// Initial orientation, unit quaternion `w x y z` from body to space.
    pub orientation: [f64; 4],
    /// Initial velocity of the origin, in space [m/s].
    pub velocity: [f64; 3],
    /// Initial angular velocity, in space [rad/s].
    pub angular_velocity: [f64; 3],
}

/// Flexible or rigid.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyKind {
    /// A flexible body.
    Elastic(Box<ElasticBody>),
    /// An unbounded rigid plane at rest through the body's position.
    RigidPlane {
        /// Unit normal in space that points out of the material.
        normal: [f64; 3],
    },
}

/// A flexible body.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticBody {
    /// Kinematics and dimension.
    pub model: ElasticModel,
    /// Material.
    pub material: Material,
    /// Shape in the body's frame.
    pub geometry: Geometry,
    /// Spline space.
    pub discretisation: Discretisation,
    /// Reduced basis.
    pub reduction: Reduction,
    /// Rayleigh damping of the elastic coordinates.
    pub damping: Option<Damping>,
    /// Reference frame.
    pub frame: Frame,
}

/// Rayleigh damping with the same ratio at two frequencies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damping {
    /// The two frequencies \[Hz\].
    pub frequencies: [f64; 2],
    /// Damping ratio there.
    pub ratio: f64,
}

/// Kinematics of a flexible body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ElasticModel {
    /// Three-dimensional.
    Solid,
    /// Rotationally symmetric about `z`, in `(r, z)`.
    Axisymmetric,
    /// Plane strain in `(x, y)`.
    PlaneStrain {
        /// Thickness \[m\].
        thickness: f64,
    },
    /// Plane stress in `(x, y)`.
    PlaneStress {
        /// Thickness \[m\].
        thickness: f64,
    },
}

impl ElasticModel {
    /// Number of parametric directions: 2 or 3.
    pub fn dimension(self) -> usize {
        if matches!(self, Self::Solid) { 3 } else { 2 }
    }
}

/// Shape of a flexible body in its own frame; lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// Ball about the origin.
    Sphere {
        /// Radius.
        radius: f64,
        /// Control net of the solid ball; `None`: by the degree.
        net: Option<SphereNet>,
    },
    /// Axisymmetric rod with flat ends.
    Rod {
        /// Radius.
        radius: f64,
        /// Length.
        length: f64,
    },
    /// Axisymmetric rod with one spherical end.
    RodSphericalEnd {
        /// Radius of rod and end.
        radius: f64,
        /// Length over all.
        length: f64,
    },
    /// Solid cylinder.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length.
        length: f64,
    },
    /// Tube.
    HollowCylinder {
        /// Inner radius.
        inner_radius: f64,
        /// Outer radius.
        outer_radius: f64,
        /// Length.
        length: f64,
    },
    /// Cuboid.
    Box {
        /// Edges along x, y, z.
        size: [f64; 3],
    },
    /// Rectangle of a plane model.
    Rectangle {
        /// Edges along x and y.
        size: [f64; 2],
    },
    /// Disc of a plane model.
    Disc {
        /// Radius.
        radius: f64,
    },
    /// Free NURBS patch.
    Nurbs(NurbsGeometry),
}

/// Control nets of a solid ball, as in `iga_core::nurbs::primitives`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SphereNet {
    /// One patch of degree 4, singular along the twelve edges of a cube.
    Cube,
    /// One patch of degree 2, singular on four meridians and at two poles.
    Spindle,
    /// Seven patches of degree 4, regular everywhere.
    Shells,
}

/// A NURBS patch as given in a scenario; the first direction runs fastest in the net.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsGeometry {
    /// Degree a direction.
    pub degrees: Vec<usize>,
    /// Clamped knot vector a direction.
    pub knots: Vec<Vec<f64>>,
    /// Control points \[m\]; entries beyond the model's dimension are zero.
    pub control_points: Vec<[f64; 3]>,
    /// Weights, one a control point.
    pub weights: Vec<f64>,
    /// File that the net was read from.
    pub file: Option<PathBuf>,
}

/// Spline space of a body. Vectors have one entry a parametric direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Discretisation {
    /// Degree a direction.
    pub degree: Vec<usize>,
    /// Uniform elements a direction, before refinement.
    pub elements: Vec<usize>,
    /// Explicit interior knots in (0, 1) a direction, which take the place of `elements`.
    pub knots: Option<Vec<Vec<f64>>>,
    /// Local refinements.
    pub refine: Vec<Refinement>,
}

/// Small elements about a place, growing geometrically away from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Where.
    pub at: Place,
    /// Width of the zone of small elements along the surface \[m\].
    pub width: f64,
    /// Elements across `width`.
    pub elements: usize,
    /// Largest ratio of neighbouring elements outside.
    pub ratio: f64,
}

/// A place on a body.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// Named point of the shape.
    Marker(String),
    /// Point in the components of the body's model: `(x, y, z)`, `(x, y, 0)` or `(r, z, 0)` \[m\].
    Point([f64; 3]),
}

/// Reduced basis of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reduction {
    /// Free eigenmodes only.
    Modal {
        /// Number of elastic modes.
        modes: usize,
    },
    /// Craig-Bampton.
    CraigBampton {
        /// Number of dynamic (low-frequency) elastic modes.
        modes: usize,
        /// Number of fixed-interface modes; `None`: `modes` plus the rigid ones and a margin.
        fixed_interface_modes: Option<usize>,
    },
    /// Every mode of the model.
    All,
}

/// Reference frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// Mean-axis frame.
    Buckens,
}

/// A contact between two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// Name in the scenario.
    pub name: String,
    /// Index of the body that carries the contact points.
    pub contact_body: usize,
    /// Index of the body whose surface they meet.
    pub target_body: usize,
    /// Contact model.
    pub model: ContactModel,
    /// How penetration is resisted.
    pub constraint: Constraint,
    /// Where the contact points are.
    pub points: ContactPoints,
    /// Solver of the quasistatic state.
    pub solver: ContactSolver,
    /// Coefficient of friction, zero for now.
    pub friction: f64,
    /// Contact interval.
    pub interval: Interval,
}

/// Contact models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactModel {
    /// High-frequency modes follow statically.
    Quasistatic,
    /// Every mode is dynamic.
    Dynamic,
}

/// How penetration is resisted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constraint {
    /// Pressure proportional to penetration.
    Penalty {
        /// Pressure per penetration [N/m³].
        value: f64,
    },
    /// No penetration.
    Exact,
}

/// Contact points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactPoints {
    /// Greville abscissae of the surface.
    Greville,
    /// Gauss points of the surface elements.
    Gauss,
}

/// Solvers of the quasistatic state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactSolver {
    /// Primal active-set method.
    ActiveSet,
    /// \[A\] Algorithm 1.
    Broyden,
}

/// The part of the contact body's surface that carries contact points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Width along the surface about the point of first contact \[m\]; `None`: the refined zone there.
    pub width: Option<f64>,
    /// Elements across the width; `None`: the elements that the discretisation has there.
    pub elements: Option<usize>,
}

/// What to store.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Time between stored states in free phases \[s\]; impact phases store every step.
    pub free_interval: f64,
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
