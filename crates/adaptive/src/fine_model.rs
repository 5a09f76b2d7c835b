//! The fine model of a body: its coarse model, refined around contact intervals (\[A\] section 4.3; theory section A.3).
//!
//! A truncated hierarchical space over the body's patch, with graded levels ([`crate::lattice`]) or those of Algorithm 3
//! ([`crate::subdivision`]). Its dynamic
//! coordinates are those of the coarse model: the low-frequency modes are the coarse ones, prolonged, and everything
//! else that the fine space can do follows quasistatically (`docs/decisions/0008-modes-of-fine-models.md`).

use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::points::DofLookup;
use contact_qs::surface_pair::TargetFace;
use faer::{Mat, MatRef};
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion};
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::modal::ReducedBasis;
use ffr_dynamics::reduction::problem::ElasticProblem;
use ffr_dynamics::reduction::static_answers::{TakenLoads, with_static_answers};
use iga_core::ParameterBox;
use iga_core::assembly::{assemble, unknowns};
use iga_core::elasticity::Model;
use iga_core::hierarchical::{HierarchicalSpace, Prolongation};
use iga_core::knots::KnotVector;
use iga_core::nurbs::{Patch, Shape};
use iga_core::space::Space;
use iga_core::surface::{CollocationPoint, Face};
use tracing::debug;

use crate::contact_zone::{ContactZone, ZoneLimits};
use crate::elastic_body::{Discretised, ElasticBody, ReducedBody, rigid_motion};
use crate::error::AdaptiveError;
use crate::interval::{IntervalEnd, IntervalGrid};
use crate::lattice::DirectionLattice;
use crate::rotated_net::RotatedNet;
use crate::spec::{DivisionRule, ElasticSpec, LowModes, PointRule};
use crate::unsupported::Unsupported;
use crate::wanted_interval::WantedInterval;

mod key;
mod plan;
mod size;

pub use key::compliance_key;
use plan::{check_regular, fine_intervals, plan, refined};
use size::check_size;
pub use size::{gigabytes, most_gigabytes};

/// A contact interval as the fine model has it: its ends lie on knots.
#[derive(Debug, Clone, PartialEq)]
pub struct FineInterval {
    /// Face that it lies on.
    pub face: Face,
    /// Directions along the face.
    pub directions: Vec<usize>,
    /// Lower and upper parameters.
    pub region: ParameterBox,
    /// What lies at the ends, one entry per direction along the face.
    pub ends: Vec<[IntervalEnd; 2]>,
    /// Contact elements per direction along the face; 1 in directions that the face does not have.
    pub n_elements: [usize; 2],
    /// Widths that were asked for \[m\].
    pub widths: [f64; 2],
    /// Number of its first element among those of the finest level, along the face.
    first: [usize; 2],
    slack: [f64; 3],
}

/// How the elements of a body are divided.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinementPlan {
    /// The levels.
    pub division: Division,
    /// Regions around which every level is refined, one per interval.
    pub regions: Vec<ParameterBox>,
}

/// Ways of making levels.
#[derive(Debug, Clone, PartialEq)]
pub enum Division {
    /// Parts of every element from each level to the next in every direction (\[A\] Algorithm 3).
    Parts(Vec<[usize; 3]>),
    /// Lattices through the ends of one interval, their spacing doubled from level to level.
    Lattice([DirectionLattice; 3]),
}

/// Elements across an interval unless the scenario says otherwise (\[A\] section 4.3).
pub const ELEMENTS: usize = 16;

/// Settings of fine models.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FineSettings {
    /// How levels are found.
    pub division: DivisionRule,
    /// Elements across an interval; Algorithm 3 takes some more where they are needed to meet its ends.
    pub elements: usize,
    /// Elements by which every level reaches beyond the intervals, the degree at most; `None`: half the degree, rounded up, in
    /// directions that the level divides. With two parts or more all functions on an interval are then of the finest level.
    pub growth: Option<usize>,
}

impl Default for FineSettings {
    fn default() -> Self {
        Self { division: DivisionRule::default(), elements: ELEMENTS, growth: None }
    }
}

/// A refined body without its matrices: all that contact needs when the compliance is known already.
pub struct FineMesh {
    /// Name.
    pub name: String,
    /// Its shape before any refinement, in whose parameters the model is given.
    pub shape: Arc<Shape>,
    /// Kinematics.
    pub model: Model,
    /// Rigid motions of the model.
    pub motion: RigidMotion,
    /// How its elements were divided.
    pub plan: RefinementPlan,
    /// Its contact intervals, in the order asked for.
    pub intervals: Vec<FineInterval>,
    /// Its patch, that of the coarse model.
    pub patch: Patch,
    /// Its space.
    pub space: HierarchicalSpace,
    /// The unknowns, sorted by node, then component.
    pub dofs: Vec<Dof>,
    /// Numbers of the unknowns.
    pub lookup: DofLookup,
    /// Functions of the coarse model, or of its turned copy, in those of the fine one.
    pub prolongation: Prolongation,
    /// The turned copy of the coarse model, where the coarse net is singular or not smooth at the contact.
    pub rotated: Option<RotatedNet>,
}

/// A refined body before reduction; dereferences to its mesh.
pub struct FineBody {
    /// All but the matrices.
    pub mesh: FineMesh,
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
        Ok(Self { mesh, assembled })
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
    /// does not resolve them; [`AdaptiveError::Geometry`] if the space cannot be
    /// built; [`AdaptiveError::Unsupported`] for bodies of several patches and intervals on singular lines.
    pub fn build(
        coarse: &ElasticBody,
        wanted: &[WantedInterval],
        settings: &FineSettings,
    ) -> Result<Self, AdaptiveError> {
        let rotated = match wanted {
            [one] if coarse.spec.model == Model::Solid => RotatedNet::new(coarse, one)?,
            _ => None,
        };
        match rotated {
            None => Self::refine(coarse, wanted, settings),
            Some(net) => {
                let fine = Self::refine(&net.body, &[net.wanted], settings)?;
                Ok(Self { rotated: Some(net), ..fine })
            }
        }
    }

    fn refine(
        coarse: &ElasticBody,
        wanted: &[WantedInterval],
        settings: &FineSettings,
    ) -> Result<Self, AdaptiveError> {
        let [patch] = coarse.shape.patches.as_slice() else {
            return Err(AdaptiveError::unsupported_body(&coarse.name, Unsupported::SeveralPatches));
        };
        let fail = |source| AdaptiveError::Geometry { body: coarse.name.clone(), source };
        let plan = plan(coarse, patch, wanted, settings)?;
        check_regular(coarse, wanted, &plan)?;
        let hierarchy = refined(patch, &plan, settings).map_err(fail)?;
        check_size(patch, &hierarchy, wanted, &plan)
            .map_err(|source| AdaptiveError::Subdivision { body: coarse.name.clone(), source })?;
        let space = HierarchicalSpace::new(patch, hierarchy).map_err(fail)?;
        let prolongation =
            Prolongation::between(&HierarchicalSpace::plain(patch).map_err(fail)?, &space).map_err(fail)?;
        let intervals = fine_intervals(coarse, patch, &space, wanted, &plan);
        debug!(body = coarse.name, elements = ?elements_of_levels(&space), "fine model");
        let unknowns = unknowns(&coarse.spec.model, space.control_points());
        let dofs: Vec<Dof> = unknowns.into_iter().map(|(node, component)| Dof { node, component }).collect();
        let lookup = DofLookup::new(&dofs);
        Ok(Self {
            name: coarse.name.clone(),
            shape: coarse.spec.shape.clone(),
            model: coarse.spec.model,
            motion: rigid_motion(&coarse.spec.model),
            plan,
            intervals,
            patch: patch.clone(),
            space,
            dofs,
            lookup,
            prolongation,
            rotated: None,
        })
    }

    /// Stiffness and mass of the body, whose material and rigid parts are those of `coarse`.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the mapping folds, or there are too many entries; those of
    /// [`Discretised::stiffened`] for rigid parts.
    pub fn assemble(&self, coarse: &ElasticBody) -> Result<AssembledBody, AdaptiveError> {
        let fail = |source| AdaptiveError::Geometry { body: self.name.clone(), source };
        let ElasticSpec { material, rigid_areas, .. } = &coarse.spec;
        let matrices = assemble(&self.space, &self.model, material).map_err(fail)?;
        let stiffness = self.discretised().stiffened(matrices.stiffness, rigid_areas, material)?;
        Ok(AssembledBody {
            name: self.name.clone(),
            motion: self.motion,
            stiffness,
            mass: MassMatrix::PerComponent(matrices.mass),
            nodes: self.space.control_points().to_vec(),
            anchors: self.space.anchors(),
            dofs: self.dofs.clone(),
        })
    }

    /// What points, markers and contact zones need.
    pub fn discretised(&self) -> Discretised<'_> {
        Discretised {
            name: &self.name,
            shape: &self.shape,
            patches: std::slice::from_ref(&self.patch),
            space: &self.space,
            model: &self.model,
            dofs: &self.dofs,
            lookup: &self.lookup,
        }
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.dofs.len()
    }

    /// Displacements of the coarse unknowns (n_coarse x k) on the fine ones: the same displacement fields (theory Eq. A.5).
    /// On a turned net the nearest ones in the mass norm.
    pub fn prolong(&self, coarse: &AssembledBody, shapes: MatRef<'_, f64>) -> Mat<f64> {
        match &self.rotated {
            None => self.prolong_nested(coarse, shapes),
            Some(net) => self.prolong_nested(&net.body.assembled, net.prolong(coarse, shapes).as_ref()),
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

    /// Reduces the body with the matrices `assembled` for quasistatic contact at the interface `unknowns`, the dynamic
    /// coordinates being those of the reduced `coarse` model (theory Eqs. A.5, A.6).
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
                let loads = self.discretised().load_columns(assembled, &coarse.1.loads)?;
                let taken = TakenLoads::Given(&reduced.static_loads);
                with_static_answers(&problem, ReducedBasis::from_modes(modes, rigid), loads.as_ref(), taken)
                    .map_err(fail)?
            }
        };
        let residual = ResidualFlexibility::new(&problem, unknowns, &basis).map_err(fail)?;
        Ok((basis, residual))
    }

    /// The contact zone of interval `i`; on its rim are the points in edge elements.
    ///
    /// # Errors
    /// [`ContactError::Empty`] if no point lies in the interval.
    pub fn zone(&self, i: usize, rule: PointRule) -> Result<ContactZone, ContactError> {
        let interval = &self.intervals[i];
        let knots = self.finest_knots();
        let on_rim = |points: &[CollocationPoint]| {
            points.iter().map(|p| interval.is_edge(interval.element(knots, &p.xi))).collect()
        };
        ContactZone::new(&self.discretised(), interval.limits(), rule, on_rim)
    }

    /// Contact element of each point of `zone`, which is that of interval `i`, for the utilisation.
    pub fn contact_elements(&self, i: usize, zone: &ContactZone) -> Vec<[usize; 2]> {
        let knots = self.finest_knots();
        zone.parameters.iter().map(|xi| self.intervals[i].element(knots, xi)).collect()
    }

    fn finest_knots(&self) -> &[KnotVector] {
        let levels = self.space.basis().hierarchy().levels();
        levels[levels.len() - 1].knots()
    }
}

impl FineInterval {
    /// The rows by which the use of the interval is judged.
    pub fn grid(&self) -> IntervalGrid {
        let n = self.directions.len();
        IntervalGrid {
            widths: std::array::from_fn(|d| if d < n { self.widths[d] } else { 0.0 }),
            ends: self.ends.clone(),
            n_elements: self.n_elements,
        }
    }

    /// Where the contact zone of the interval ends.
    fn limits(&self) -> ZoneLimits {
        let region = TargetFace { face: self.face, bounds: self.region };
        ZoneLimits { region, slack: self.slack, widths: self.widths }
    }

    /// Contact element that holds parameters of the face.
    fn element(&self, knots: &[KnotVector], xi: &[f64; 3]) -> [usize; 2] {
        let mut index = [0; 2];
        for (i, &d) in self.directions.iter().enumerate() {
            // Points on a knot belong to the element above it, whatever round-off says.
            let e = knots[d].find_element(xi[d] + self.slack[d]);
            index[i] = e.saturating_sub(self.first[i]).min(self.n_elements[i] - 1);
        }
        index
    }

    /// Whether a contact element lies at an end beyond which nothing is watched.
    fn is_edge(&self, element: [usize; 2]) -> bool {
        self.ends.iter().enumerate().any(|(i, ends)| {
            let at = [element[i] == 0, element[i] + 1 == self.n_elements[i]];
            (0..2).any(|side| at[side] && ends[side] != IntervalEnd::Axis)
        })
    }
}

/// Leaf elements of every level.
fn elements_of_levels(space: &HierarchicalSpace) -> Vec<usize> {
    let hierarchy = space.basis().hierarchy();
    let mut counts = vec![0; hierarchy.levels().len()];
    hierarchy.leaves().for_each(|leaf| counts[leaf.level] += 1);
    counts
}
