//! The fine model of a body: its coarse model, refined around contact intervals (\[A\] section 4.3;
//! theory section A.3).
//!
//! A truncated hierarchical space over the body's patches, with graded levels
//! ([`crate::adaptivity::lattice`]) or those of Algorithm 3 ([`crate::adaptivity::subdivision`]).
//! Its dynamic coordinates are those of the coarse model: the low-frequency modes are the coarse
//! ones, prolonged, and everything else that the fine space can do follows quasistatically
//! (`docs/decisions/0008-modes-of-fine-models.md`).

use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::zone::points::{DofLookup, SurfacePoint};
use faer::{Mat, MatRef};
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion};
use ffr_dynamics::reduction::compliance::{BodyTurn, ResidualFlexibility};
use ffr_dynamics::reduction::modal::ReducedBasis;
use ffr_dynamics::reduction::problem::ElasticProblem;
use ffr_dynamics::reduction::static_answers::{TakenLoads, with_static_answers};
use iga_core::ParameterBox;
use iga_core::elasticity::assembly::{assemble, unknowns};
use iga_core::elasticity::{Material, MaterialField, Model};
use iga_core::extent::{Extent, ExtentPoint};
use iga_core::hierarchical::{HierarchicalSpace, Prolongation};
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::{FaceId, Patch, Shape};
use iga_core::space::Space;
use iga_core::surface::CollocationPoint;
use nalgebra::Vector3;
use tracing::debug;

use crate::adaptivity::lattice::DirectionLattice;
use crate::adaptivity::wanted_interval::WantedInterval;
use crate::body::field::Field;
use crate::body::reduced::ReducedBody;
use crate::body::splines::rotated_net::{NetRotation, RotatedNet};
use crate::body::splines::{Discretised, ElasticBody, locate, named_place, points_of, rigid_motion};
use crate::body::zone::{ContactZone, ZoneLimits};
use crate::error::AdaptiveError;
use crate::spec::{DivisionRule, ElasticSpec, FlexibleSpec, LowModes, PointRule};

mod key;
mod levels;
mod across;
mod measures;
mod spread;
mod intervals;
mod spread_plan;
mod plan;
mod size;

pub use intervals::{FineInterval, IntervalPart};
use intervals::{fine_intervals, finest_knots};
pub use key::zone_definition;
use levels::refined;
use plan::{check_regular, plan};
use size::check_size;
pub use size::{gigabytes, most_gigabytes};
pub use spread::{Spread, SpreadPart, ZoneFrame};

/// How the elements of a body are divided.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinementPlan {
    /// The levels.
    pub division: Division,
    /// Regions around which every level is refined: one for each interval, or for each part of an
    /// interval on several faces.
    pub regions: Vec<Region>,
    /// The parts of each interval, if it is one on several faces or there are several.
    pub spreads: Vec<Spread>,
}

/// A box of parameters of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// The patch.
    pub patch: usize,
    /// Its parameters.
    pub bounds: ParameterBox,
}

/// Ways of making levels.
#[derive(Debug, Clone, PartialEq)]
pub enum Division {
    /// Parts of every element from each level to the next in every direction (\[A\] Algorithm 3).
    Parts(Vec<[usize; 3]>),
    /// Lattices, their spacing doubled from level to level, one for all directions that shared
    /// faces turn into one another.
    Lattice(Vec<LinkedLattice>),
}

/// A lattice in a direction of a patch, and in all that are divided together with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkedLattice {
    /// The patch in whose parameters it is given.
    pub patch: usize,
    /// The direction.
    pub direction: usize,
    /// The lattice.
    pub lattice: DirectionLattice,
}

/// Elements across an interval unless the scenario says otherwise (\[A\] section 4.3).
pub const ELEMENTS: usize = 16;

/// Settings of fine models.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FineSettings {
    /// How levels are found.
    pub division: DivisionRule,
    /// Elements across an interval; Algorithm 3 takes some more where they are needed to meet its
    /// ends.
    pub elements: usize,
    /// Elements by which every level reaches beyond the intervals, the degree at most; `None`: half
    /// the degree, rounded up, in directions that the level divides. With two parts or more all
    /// functions on an interval are then of the finest level.
    pub growth: Option<usize>,
}

impl Default for FineSettings {
    fn default() -> Self {
        Self { division: DivisionRule::default(), elements: ELEMENTS, growth: None }
    }
}

/// A refined body without its matrices: all that contact needs when the compliance is known
/// already.
pub struct FineMesh {
    /// Name.
    pub name: String,
    /// Its shape before any refinement, in whose parameters the model is given.
    pub shape: Arc<Shape>,
    /// Kinematics.
    pub model: Model,
    /// Material.
    pub material: Material,
    /// Rigid motions of the model.
    pub motion: RigidMotion,
    /// How its elements were divided.
    pub plan: RefinementPlan,
    /// Its contact intervals, in the order asked for.
    pub intervals: Vec<FineInterval>,
    /// Its patches, those of the coarse model.
    pub patches: Vec<Patch>,
    /// Its space.
    pub space: HierarchicalSpace,
    /// The unknowns, sorted by node, then component.
    pub dofs: Vec<Dof>,
    /// The number of the unknown of each function and component.
    pub lookup: DofLookup,
    /// Functions of the coarse model, or of its turned copy, as combinations of the functions of
    /// the fine one.
    pub prolongation: Prolongation,
    /// The turned net, if it is one.
    pub rotated: Option<TurnedMesh>,
}

/// Additional data of a fine model on a turned net.
pub struct TurnedMesh {
    /// How displacements are carried to the net.
    pub net: RotatedNet,
    /// The space on the net before it was turned.
    unturned: HierarchicalSpace,
}

/// A refined body before reduction; dereferences to its mesh.
pub struct FineBody {
    /// All but the matrices.
    pub mesh: Arc<FineMesh>,
    /// Matrices.
    pub assembled: AssembledBody,
}

impl std::ops::Deref for FineBody {
    type Target = FineMesh;

    fn deref(&self) -> &Self::Target {
        &self.mesh
    }
}

impl FineBody {
    /// Refines `coarse` around `wanted` intervals and assembles the matrices.
    ///
    /// # Errors
    /// As [`FineMesh::build`] and [`FineMesh::assemble`].
    pub fn build(
        coarse: &ElasticBody,
        wanted: &[WantedInterval],
        settings: &FineSettings,
    ) -> Result<Self, AdaptiveError> {
        let mesh = FineMesh::build(coarse, wanted, settings)?;
        let assembled = mesh.assemble(coarse)?;
        Ok(Self { mesh: Arc::new(mesh), assembled })
    }

    /// As [`FineMesh::reduce`] with the body's own matrices.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn reduce(
        &self,
        coarse: (&ElasticBody, &ReducedBody),
        unknowns: &[usize],
        modes: LowModes,
    ) -> Result<(ReducedBasis, ResidualFlexibility), AdaptiveError> {
        self.mesh.reduce(&self.assembled, coarse, unknowns, modes)
    }
}

impl FineMesh {
    /// Refines `coarse` around `wanted` intervals.
    ///
    /// # Errors
    /// [`AdaptiveError::Subdivision`] if no memory holds the intervals or round-off would fold their elements, or Algorithm 3
    /// does not resolve them; [`AdaptiveError::Geometry`] if the space cannot be built;
    /// [`AdaptiveError::Unsupported`] for Algorithm 3 on several patches and intervals on singular
    /// lines.
    pub fn build(
        coarse: &ElasticBody,
        wanted: &[WantedInterval],
        settings: &FineSettings,
    ) -> Result<Self, AdaptiveError> {
        let turn = match wanted {
            [one] if coarse.spec.model != Model::Axisymmetric => NetRotation::new(coarse, one)?,
            _ => None,
        };
        match turn {
            None => Self::refine(coarse, wanted, settings),
            Some(turn) => Self::refine(coarse, &[turn.wanted], settings)?.turned(coarse, turn),
        }
    }

    /// The model, turned together with its net; the body stays the same.
    fn turned(self, coarse: &ElasticBody, turn: NetRotation) -> Result<Self, AdaptiveError> {
        let fail = |source| AdaptiveError::Geometry { body: coarse.name.clone(), source };
        let rotation = &turn.rotation;
        let patches = self.patches.iter().map(|patch| patch.rotated(rotation)).collect::<Result<_, _>>();
        let shape = Arc::new(self.shape.rotated(rotation).map_err(fail)?);
        let (patches, space) = (patches.map_err(fail)?, self.space.rotated(rotation));
        let net = RotatedNet::new(coarse, turn)?;
        let rotated = Some(TurnedMesh { net, unturned: self.space });
        Ok(Self { shape, patches, space, rotated, ..self })
    }

    /// The rotation by which the model of a body without rigid parts is turned, if it keeps
    /// lengths: matrices and flexibility are then those of the model before it was turned, the same
    /// for all places of a ball. None for ellipsoids, whose maps change lengths.
    pub fn turn(&self, coarse: &ElasticBody) -> Option<BodyTurn> {
        let keeps_lengths = self.shape.symmetry.as_ref().is_some_and(|symmetry| symmetry.stretch().is_none());
        let is_rotation = keeps_lengths && coarse.spec.flexible.rigid_areas.is_empty();
        let rotated = self.rotated.as_ref().filter(|_| is_rotation)?;
        Some(BodyTurn { rotation: rotated.net.turn.rotation, n_components: self.motion.n_components() })
    }

    fn refine(
        coarse: &ElasticBody,
        wanted: &[WantedInterval],
        settings: &FineSettings,
    ) -> Result<Self, AdaptiveError> {
        let patches = &coarse.shape.patches[..];
        let fail = |source| AdaptiveError::Geometry { body: coarse.name.clone(), source };
        let plan = plan(coarse, wanted, settings)?;
        check_regular(coarse, wanted, &plan)?;
        let hierarchies = refined(patches, &plan, settings).map_err(fail)?;
        check_size(patches, &hierarchies, wanted, &plan)
            .map_err(|source| AdaptiveError::Subdivision { body: coarse.name.clone(), source })?;
        let space = HierarchicalSpace::of_patches(patches, hierarchies).map_err(fail)?;
        let plain = HierarchicalSpace::plain_patches(patches).map_err(fail)?;
        let prolongation = Prolongation::between(&plain, &space).map_err(fail)?;
        let intervals = fine_intervals(coarse, &space, wanted, &plan, settings.elements);
        debug!(body = coarse.name, elements = ?elements_of_levels(&space), "fine model");
        let unknowns = unknowns(&coarse.spec.model, space.control_points());
        let dofs: Vec<Dof> = unknowns.into_iter().map(|(node, component)| Dof { node, component }).collect();
        let lookup = DofLookup::new(&dofs);
        Ok(Self {
            name: coarse.name.clone(),
            shape: coarse.spec.shape.clone(),
            model: coarse.spec.model,
            material: coarse.spec.material,
            motion: rigid_motion(&coarse.spec.model),
            plan,
            intervals,
            patches: patches.to_vec(),
            space,
            dofs,
            lookup,
            prolongation,
            rotated: None,
        })
    }

    /// As [`FineMesh::assemble`], of the model before it was turned by [`FineMesh::turn`].
    ///
    /// # Errors
    /// As [`FineMesh::assemble`].
    pub fn assemble_unturned(&self, coarse: &ElasticBody) -> Result<AssembledBody, AdaptiveError> {
        match &self.rotated {
            Some(rotated) if self.turn(coarse).is_some() => self.assemble_on(&rotated.unturned, coarse),
            _ => self.assemble(coarse),
        }
    }

    /// Stiffness and mass of the body, whose material and rigid parts are those of `coarse`.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the mapping folds, or there are too many entries; those of
    /// [`Field::stiffened`] for rigid parts.
    pub fn assemble(&self, coarse: &ElasticBody) -> Result<AssembledBody, AdaptiveError> {
        self.assemble_on(&self.space, coarse)
    }

    fn assemble_on(
        &self,
        space: &HierarchicalSpace,
        coarse: &ElasticBody,
    ) -> Result<AssembledBody, AdaptiveError> {
        let fail = |source| AdaptiveError::Geometry { body: self.name.clone(), source };
        let ElasticSpec { material, flexible: FlexibleSpec { rigid_areas, .. }, .. } = &coarse.spec;
        let matrices = assemble(space, &self.model, material).map_err(fail)?;
        let stiffness = self.stiffened(matrices.stiffness, rigid_areas, material)?;
        Ok(AssembledBody {
            name: self.name.clone(),
            motion: self.motion,
            stiffness,
            mass: MassMatrix::PerComponent(matrices.mass),
            nodes: space.control_points().to_vec(),
            anchors: self.anchors(),
            dofs: self.dofs.clone(),
        })
    }

    /// Coordinates of the control points by which unknowns are ordered for the factorisation. On
    /// several patches they are taken along the surface and into the depth at the first interval,
    /// where most points are, so that layers of points lie in planes.
    fn anchors(&self) -> Vec<[f64; 3]> {
        let (Some(part), true) = (self.intervals.first().map(|i| &i.parts[0]), self.patches.len() > 1) else {
            return self.space.anchors();
        };
        let ParameterBox { lower, upper } = &part.region;
        let middle = std::array::from_fn(|d| 0.5 * (lower[d] + upper[d]));
        let patch = &self.patches[part.face.id.patch];
        let at = part.face.at(patch, &middle, &mut PointBasis::default());
        let along = Vector3::from(at.tangents[0]).try_normalize(0.0).unwrap_or_else(Vector3::x);
        let normal = Vector3::from(at.normal);
        let axes = [along, normal.cross(&along), normal];
        let place = |x: &[f64; 3]| axes.map(|axis| axis.dot(&Vector3::from(*x)));
        self.space.control_points().iter().map(place).collect()
    }

    /// The data that contact zones on its faces need.
    pub fn discretised(&self) -> Discretised<'_> {
        Discretised { patches: &self.patches, space: &self.space, model: &self.model, lookup: &self.lookup }
    }

    /// Displacements of the coarse unknowns (n_coarse x k) on the fine ones: the same displacement
    /// fields (theory Eq. A.12). On a turned net these are the nearest fields in the mass norm.
    pub fn prolong(&self, coarse: &AssembledBody, shapes: MatRef<'_, f64>) -> Mat<f64> {
        match &self.rotated {
            None => self.prolong_nested(coarse, shapes),
            Some(TurnedMesh { net, .. }) => self.prolong_nested(coarse, net.prolong(coarse, shapes).as_ref()),
        }
    }

    fn prolong_nested(&self, coarse: &AssembledBody, shapes: MatRef<'_, f64>) -> Mat<f64> {
        let mut fine = Mat::zeros(self.n_unknowns(), shapes.ncols());
        for j in 0..shapes.ncols() {
            let mut values = vec![[0.0; 3]; self.prolongation.n_coarse()];
            for (i, dof) in coarse.dofs.iter().enumerate() {
                values[dof.node as usize][dof.component as usize] = shapes[(i, j)];
            }
            let values = self.prolongation.apply(&values);
            for (i, dof) in self.dofs.iter().enumerate() {
                fine[(i, j)] = values[dof.node as usize][dof.component as usize];
            }
        }
        fine
    }

    /// Reduces the body with the matrices `assembled` for quasistatic contact at the interface
    /// `unknowns`, the dynamic coordinates being those of the reduced `coarse` model (theory
    /// Eqs. A.12, A.13).
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn reduce(
        &self,
        assembled: &AssembledBody,
        coarse: (&ElasticBody, &ReducedBody),
        unknowns: &[usize],
        modes: LowModes,
    ) -> Result<(ReducedBasis, ResidualFlexibility), AdaptiveError> {
        let fail = |source| AdaptiveError::Reduction { body: self.name.clone(), source };
        let problem = ElasticProblem::free(assembled, unknowns).map_err(fail)?;
        let rigid = problem.free_rigid().map_err(fail)?;
        let (body, reduced) = (coarse.0, &coarse.1.basis);
        let basis = match modes {
            LowModes::Prolonged => {
                reduced.prolonged(self.prolong(&body.assembled, reduced.shapes.as_ref()), rigid)
            }
            LowModes::Fine => {
                let modes = problem.lowest_modes(reduced.first_static()).map_err(fail)?;
                let loads = self.load_columns(assembled, &coarse.1.loads)?;
                let taken = TakenLoads::Given(&reduced.static_loads);
                with_static_answers(&problem, ReducedBasis::from_modes(modes, rigid), loads.as_ref(), taken)
                    .map_err(fail)?
            }
        };
        let residual = ResidualFlexibility::new(&problem, unknowns, &basis).map_err(fail)?;
        Ok((basis, residual))
    }

    /// The contact zone of interval `i`. The points in its edge elements are on its rim.
    ///
    /// # Errors
    /// [`ContactError::Empty`] if no point lies in it.
    pub fn zone(&self, i: usize, rule: PointRule) -> Result<ContactZone, ContactError> {
        self.zone_of(&self.intervals[i..=i], rule)
    }

    /// The contact zone of all of its intervals together, as [`FineMesh::zone`].
    ///
    /// # Errors
    /// [`ContactError::Empty`] if no point lies in them.
    pub fn whole_zone(&self, rule: PointRule) -> Result<ContactZone, ContactError> {
        self.zone_of(&self.intervals, rule)
    }

    fn zone_of(&self, intervals: &[FineInterval], rule: PointRule) -> Result<ContactZone, ContactError> {
        let is_on_rim = |p: &CollocationPoint| {
            let interval = &intervals[holder(intervals, p.face, (&p.xi, &p.point))];
            interval.is_edge(self.rows(interval, p.face, (&p.xi, &p.point)))
        };
        let on_rim = |points: &[CollocationPoint]| points.iter().map(is_on_rim).collect();
        let limits: Vec<ZoneLimits> = intervals.iter().flat_map(FineInterval::limits).collect();
        ContactZone::new(&self.discretised(), &limits, rule, on_rim)
    }

    /// For each point of `zone`, that of all intervals, the contact element of its interval in which it lies:
    /// its row in each of the two directions, from which the utilisation is counted.
    pub fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        let places = zone.faces.iter().zip(&zone.parameters).zip(&zone.points);
        let rows = |((face, xi), p): ((&FaceId, &[f64; 3]), &SurfacePoint)| {
            let place = (xi, &p.position);
            self.rows(&self.intervals[holder(&self.intervals, *face, place)], *face, place)
        };
        places.map(rows).collect()
    }

    /// The row in each direction of an interval in which a place of a face lies.
    fn rows(&self, interval: &FineInterval, face: FaceId, place: (&[f64; 3], &[f64; 3])) -> [usize; 2] {
        let part = interval.parts.iter().position(|p| p.face.id == face).unwrap_or_default();
        interval.rows(part, finest_knots(&self.space, face.patch), place)
    }
}

impl Field for FineMesh {
    fn name(&self) -> &str {
        &self.name
    }

    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn model(&self) -> &Model {
        &self.model
    }

    fn materials(&self) -> &dyn MaterialField {
        &self.material
    }

    fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    fn lookup(&self) -> &DofLookup {
        &self.lookup
    }

    fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError> {
        locate(self, &self.shape, &self.space, place)
    }

    fn points_of(&self, extent: &Extent) -> Result<Vec<ExtentPoint>, AdaptiveError> {
        points_of(self, &self.shape, &self.space, extent)
    }

    fn named_place(&self, marker: &str) -> Result<[f64; 3], AdaptiveError> {
        named_place(self, &self.shape, marker)
    }
}

/// The one of `intervals` that holds a place of a face best: where it lies farthest from the ends.
fn holder(intervals: &[FineInterval], face: FaceId, (xi, point): (&[f64; 3], &[f64; 3])) -> usize {
    let held = |interval: &FineInterval| interval.holds(face, xi).then(|| interval.share(point));
    let shares = intervals.iter().enumerate().filter_map(|(i, interval)| Some((i, held(interval)?)));
    shares.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i)
}

/// Leaf elements of every level.
fn elements_of_levels(space: &HierarchicalSpace) -> Vec<usize> {
    let mut counts = vec![0; space.basis(0).hierarchy().levels().len()];
    for patch in 0..space.n_patches() {
        space.basis(patch).hierarchy().leaves().for_each(|leaf| counts[leaf.level] += 1);
    }
    counts
}
