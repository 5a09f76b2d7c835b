//! Bodies: models, shapes, discretisation, reduction, rigid bodies.

use std::path::PathBuf;

use adaptive::spec::{Coupling, Extent};
use ffr_dynamics::body::RigidMotion;

use super::imported::ImportedBody;

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
    /// Markers that the user has added to those of the shape.
    pub markers: Vec<Marker>,
    /// Initial position of the body's origin \[m\]; zero, like the velocities, if the body hangs on a joint.
    pub position: [f64; 3],
    /// Initial orientation, unit quaternion `w x y z` from body to space; of a body that hangs on a joint, with all joint
    /// coordinates at zero.
    pub orientation: [f64; 4],
    /// Initial velocity of the origin, in space [m/s].
    pub velocity: [f64; 3],
    /// Initial angular velocity, in space [rad/s].
    pub angular_velocity: [f64; 3],
}

/// A named place of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Name in the scenario.
    pub name: String,
    /// A point or a part of the body.
    pub at: Place,
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
        /// Material, which Hertz contacts take into account; rigid without it.
        material: Option<Material>,
    },
    /// A rigid body.
    Rigid(Box<RigidBody>),
    /// A body from a file.
    Imported(Box<ImportedBody>),
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidBody {
    /// Motions that it can make.
    pub motion: RigidMotion,
    /// Where its mass and inertia come from.
    pub mass: RigidMass,
}

/// Mass of a rigid body.
#[derive(Debug, Clone, PartialEq)]
pub enum RigidMass {
    /// Given as numbers.
    Given {
        /// Mass \[kg\].
        mass: f64,
        /// Centre of mass in the body's frame \[m\].
        centre: [f64; 3],
        /// Inertia about the centre of mass in the axes of the body's frame [kg m²].
        inertia: [[f64; 3]; 3],
    },
    /// Following from the shape.
    Shape {
        /// What the components of the shape's points mean.
        model: ElasticModel,
        /// Shape in the body's frame.
        geometry: Geometry,
        /// Material.
        material: Material,
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
    /// Damping of the elastic coordinates.
    pub damping: Option<Damping>,
    /// Reference frame.
    pub frame: Frame,
    /// Whether inertia forces stiffen the body.
    pub geometric_stiffening: bool,
}

/// Damping of elastic coordinates.
#[derive(Debug, Clone, PartialEq)]
pub enum Damping {
    /// Rayleigh damping with the same ratio at two frequencies.
    Rayleigh {
        /// The two frequencies \[Hz\].
        frequencies: [f64; 2],
        /// Damping ratio there.
        ratio: f64,
    },
    /// Damping ratios, one a mode; the last holds for all that follow.
    Modal(Vec<f64>),
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

    /// Rigid motions of a body of this model.
    pub fn motion(self) -> RigidMotion {
        match self {
            Self::Solid => RigidMotion::Spatial,
            Self::Axisymmetric => RigidMotion::Axial,
            Self::PlaneStrain { .. } | Self::PlaneStress { .. } => RigidMotion::Planar,
        }
    }
}

/// Shape of a body in its own frame; lengths in m.
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
    /// One patch of degree 2, 2, 3, singular on four meridians and at two poles.
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
    /// Uniform elements a direction, before refinement; `None`: chosen by the program.
    pub elements: Option<Vec<usize>>,
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
    /// Named point or part of the body.
    Marker(String),
    /// Point in the components of the body's model: `(x, y, z)`, `(x, y, 0)` or `(r, z, 0)` \[m\].
    Point([f64; 3]),
    /// Part of the body.
    Area {
        /// Which part.
        extent: Extent,
        /// How it hangs together with what holds it.
        coupling: Coupling,
    },
}

/// Reduced basis of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reduction {
    /// Free eigenmodes only.
    Modal {
        /// Number of elastic modes; `None`: chosen by the program.
        modes: Option<usize>,
        /// Whether the basis has the static answers to joints and loads.
        static_answers: bool,
    },
    /// Craig-Bampton.
    CraigBampton {
        /// Number of dynamic (low-frequency) elastic modes; `None`: chosen by the program.
        modes: Option<usize>,
        /// Number of fixed-interface modes; `None`: `modes` plus the rigid ones and a margin.
        fixed_interface_modes: Option<usize>,
        /// Whether the basis has the static answers to joints and loads.
        static_answers: bool,
    },
    /// Every mode of the model.
    All,
}

impl Reduction {
    /// Whether static answers to joints and loads are added to the modes; to all modes they add nothing.
    pub fn has_static_answers(&self) -> bool {
        matches!(
            self,
            Self::Modal { static_answers: true, .. } | Self::CraigBampton { static_answers: true, .. }
        )
    }

    /// Whether the program shall choose the number of modes.
    pub fn wants_modes(&self) -> bool {
        matches!(self, Self::Modal { modes: None, .. } | Self::CraigBampton { modes: None, .. })
    }

    /// Sets the number of modes, where the method has one.
    pub fn set_modes(&mut self, n: usize) {
        if let Self::Modal { modes, .. } | Self::CraigBampton { modes, .. } = self {
            *modes = Some(n);
        }
    }
}

/// Reference frames.
#[derive(Debug, Clone, PartialEq)]
pub enum Frame {
    /// Mean-axis frame.
    Buckens,
    /// Frame that follows the material at a place.
    Tangent(Place),
}
