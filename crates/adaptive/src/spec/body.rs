//! Bodies: elastic ones from exact geometry or of finite elements, rigid ones, reduced ones from a
//! file.

use std::sync::Arc;

use super::reduction::{DampingSpec, ReductionSpec};
use fe_mesh::Mesh;
use fe_mesh::element::rules::MassRule;
use ffr_dynamics::body::{Dof, RigidMotion};
use iga_core::SplineError;
use iga_core::elasticity::assembly::unknowns;
use iga_core::elasticity::{Material, Model};
use iga_core::extent::Extent;
use iga_core::nurbs::Shape;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// An exact shape and its kinematics, of which surfaces are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry<'a> {
    /// The shape.
    pub shape: &'a Arc<Shape>,
    /// The kinematics.
    pub model: &'a Model,
}

impl Geometry<'_> {
    /// Rigid motions of the model.
    pub fn motion(&self) -> RigidMotion {
        rigid_motion(self.model)
    }

    /// Whether its surface is turned about the axis.
    pub fn is_axisymmetric(&self) -> bool {
        *self.model == Model::Axisymmetric
    }
}

/// Rigid motions of a kinematic model.
pub fn rigid_motion(model: &Model) -> RigidMotion {
    match model {
        Model::Axisymmetric => RigidMotion::Axial,
        Model::PlaneStrain { .. } | Model::PlaneStress { .. } => RigidMotion::Planar,
        Model::Solid => RigidMotion::Spatial,
    }
}

/// The unknowns of `nodes` in the kinematics `model`, rising by node, then component.
pub fn dofs_of(model: &Model, nodes: &[[f64; 3]]) -> Vec<Dof> {
    unknowns(model, nodes).into_iter().map(|(node, component)| Dof { node, component }).collect()
}

/// A place on a body.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// A point in the components of the body's model: `(x, y, z)`, `(x, y, 0)` or `(r, z, 0)`
    /// \[m\].
    Point([f64; 3]),
    /// A marker that the body brings with it.
    Marker(String),
    /// A part of the body, which can carry forces.
    Area(Area),
}

/// A part of a body that carries a marker.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// Which part.
    pub extent: Extent,
    /// Where the marker is, in the model's components \[m\].
    pub centre: [f64; 3],
    /// How the marker and the part are connected.
    pub coupling: Coupling,
}

impl Area {
    /// A part of the undeformed body `shape`, with the marker at its centre.
    ///
    /// # Errors
    /// [`SplineError`] of a face that does not exist.
    pub fn new(
        extent: Extent,
        coupling: Coupling,
        shape: &Shape,
        model: &Model,
    ) -> Result<Self, SplineError> {
        let centre = extent.centre(shape, model)?;
        Ok(Self { extent, centre, coupling })
    }
}

/// How a marker and the part of the body that carries it are connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coupling {
    /// Distributing (RBE3): the marker follows the mean motion of the part, forces are spread over
    /// it; the part deforms (theory Eq. M.9).
    #[default]
    Average,
    /// Kinematic (RBE2): the part moves like a rigid body (theory Eq. M.10).
    Rigid,
}

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

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidSpec {
    /// Motions that it can make.
    pub motion: RigidMotion,
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass in the body's frame \[m\].
    pub centre_of_mass: Vector3<f64>,
    /// Inertia about the centre of mass in the axes of the body's frame [kg m²].
    pub inertia: Matrix3<f64>,
    /// Density of its material [kg/m³], where its mass follows from its shape.
    pub density: Option<f64>,
    /// Its exact shape, by whose surface others may touch it; clones share it.
    pub shape: Option<(Arc<Shape>, Model)>,
}

impl RigidSpec {
    /// The exact shape, if it has one.
    pub fn geometry(&self) -> Option<Geometry<'_>> {
        self.shape.as_ref().map(|(shape, model)| Geometry { shape, model })
    }
}

/// What flexible bodies have in common, whatever their matrices come from.
#[derive(Debug, Clone, PartialEq)]
pub struct FlexibleSpec {
    /// Reduced basis.
    pub reduction: ReductionSpec,
    /// Whether the basis has the static answers to the body's joints and loads.
    pub static_answers: bool,
    /// Parts of the body that move like rigid ones, which stiffens it.
    pub rigid_areas: Vec<Area>,
    /// Damping of the elastic coordinates.
    pub damping: DampingSpec,
    /// Reference frame.
    pub frame: FrameSpec,
    /// Whether inertia forces stiffen the body.
    pub geometric_stiffening: bool,
}

impl FlexibleSpec {
    /// An undamped body in a mean-axis frame, with static answers, without rigid parts and without
    /// geometric stiffening.
    pub fn new(reduction: ReductionSpec) -> Self {
        Self {
            reduction,
            static_answers: true,
            rigid_areas: Vec::new(),
            damping: DampingSpec::None,
            frame: FrameSpec::Buckens,
            geometric_stiffening: false,
        }
    }

    /// Whether static answers are added to the modes; all modes leave nothing out.
    pub fn has_static_answers(&self) -> bool {
        self.static_answers && self.reduction != ReductionSpec::All
    }
}

/// An elastic body of splines.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticSpec {
    /// Exact geometry, with the named points of the body; clones share it.
    pub shape: Arc<Shape>,
    /// Kinematics.
    pub model: Model,
    /// Material.
    pub material: Material,
    /// Spline space.
    pub discretisation: DiscretisationSpec,
    /// How it is reduced, held, damped and framed.
    pub flexible: FlexibleSpec,
}

impl ElasticSpec {
    /// The exact shape.
    pub fn geometry(&self) -> Geometry<'_> {
        Geometry { shape: &self.shape, model: &self.model }
    }

    /// The body with what [`FlexibleSpec::new`] gives beside `reduction`.
    pub fn new(
        shape: impl Into<Arc<Shape>>,
        model: Model,
        material: Material,
        discretisation: DiscretisationSpec,
        reduction: ReductionSpec,
    ) -> Self {
        Self { shape: shape.into(), model, material, discretisation, flexible: FlexibleSpec::new(reduction) }
    }
}

/// A material of each group of elements.
pub type ByGroup = Vec<(String, Material)>;

/// An elastic body of finite elements, of the kinematics that its mesh has.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshedSpec {
    /// The mesh, in metres; clones share it.
    pub mesh: Arc<Mesh>,
    /// Material of all elements that [`MeshedSpec::groups`] does not name.
    pub material: Option<Material>,
    /// Materials by group; without [`MeshedSpec::material`] every element must be in one of them.
    pub groups: ByGroup,
    /// Points by which the mass is integrated.
    pub mass_rule: MassRule,
    /// How it is reduced, held, damped and framed.
    pub flexible: FlexibleSpec,
}

/// Reference frames.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum FrameSpec {
    /// Mean-axis frame.
    #[default]
    Buckens,
    /// The frame that follows the body at a place.
    Tangent(Place),
}

/// Small elements about a point of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinementSpec {
    /// Centre, in the model's components \[m\].
    pub centre: [f64; 3],
    /// Width of the zone of small elements along the surface; from the axis outwards where the
    /// centre lies on the axis of an axisymmetric model \[m\].
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
