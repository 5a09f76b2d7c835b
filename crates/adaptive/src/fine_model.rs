//! The fine model of a body: its coarse model, refined around contact intervals (\[A\] section 4.3; theory section A.3).
//!
//! A truncated hierarchical space over the body's patch, with levels from Algorithm 3 ([`crate::subdivision`]). Its dynamic
//! coordinates are those of the coarse model: the low-frequency modes are the coarse ones, prolonged, and everything
//! else that the fine space can do follows quasistatically (`docs/decisions/0008-modes-of-fine-models.md`).

use contact_qs::points::{DofLookup, SurfacePoint};
use faer::{Mat, MatRef};
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion};
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::modal::ReducedBasis;
use ffr_dynamics::reduction::problem::ElasticProblem;
use iga_core::SplineError;
use iga_core::assembly::{assemble, unknowns};
use iga_core::elasticity::Model;
use iga_core::hierarchical::{HierarchicalSpace, ParameterBox, PatchTies, Prolongation, SubdomainHierarchy};
use iga_core::knots::KnotVector;
use iga_core::nurbs::Patch;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::local::parameter_at_distance;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::Space;
use iga_core::surface::{CollocationPoint, Face};
use tracing::debug;

use crate::body_space::BodySpace;
use crate::elastic_body::{Discretised, ElasticBody, ReducedBody, rigid_motion};
use crate::error::AdaptiveError;
use crate::interval::IntervalEnd;
use crate::lattice::DirectionLattice;
use crate::spec::PointRule;
use crate::subdivision::{DirectionPlan, SubdivisionError, SubdivisionLimits, SurfaceGrowth, divide, follow};
use crate::turned_net::TurnedNet;

/// Slack of comparisons between parameters, as a share of the patch's range: round-off of knots and arc lengths.
const PARAMETER_SLACK: f64 = 1e-9;

/// Elements by which the coarser levels of a lattice reach beyond the interval at least.
const COARSE_REACH: usize = 2;

/// A contact interval as it is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WantedInterval {
    /// Face that it lies on.
    pub face: Face,
    /// Parameters of its centre in the face's patch.
    pub centre: [f64; 3],
    /// Widths along the face's directions, rising; from the axis outwards where the centre lies on the axis of an
    /// axisymmetric model \[m\].
    pub widths: [f64; 2],
}

/// A contact interval as the fine model has it: its ends lie on knots.
#[derive(Debug, Clone, PartialEq)]
pub struct FineInterval {
    /// Face that it lies on.
    pub face: Face,
    /// Directions along the face.
    pub directions: Vec<usize>,
    /// Lower and upper parameters.
    pub region: ParameterBox,
    /// What lies at the ends, one entry a direction along the face.
    pub ends: Vec<[IntervalEnd; 2]>,
    /// Contact elements a direction along the face; 1 in directions that the face does not have.
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
    /// Regions around which every level is refined, one an interval.
    pub regions: Vec<ParameterBox>,
}

/// Ways of making levels.
#[derive(Debug, Clone, PartialEq)]
pub enum Division {
    /// Parts of every element from each level to the next, a direction (\[A\] Algorithm 3).
    Parts(Vec<[usize; 3]>),
    /// Lattices through the ends of one interval, their spacing doubled from level to level.
    Lattice([DirectionLattice; 3]),
}

/// Settings of fine models.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FineSettings {
    /// Limits of Algorithm 3.
    pub limits: SubdivisionLimits,
    /// Elements by which every level reaches beyond the intervals, the degree at most; `None`: half the degree, rounded up, in
    /// directions that the level divides. With two parts or more all functions on an interval are then of the finest level.
    pub growth: Option<usize>,
}

/// A refined body without its matrices: all that contact needs when the compliance is known already.
pub struct FineMesh {
    /// Name.
    pub name: String,
    /// Rigid motions of the model.
    pub motion: RigidMotion,
    /// How its elements were divided.
    pub plan: RefinementPlan,
    /// Its contact intervals, in the order asked for.
    pub intervals: Vec<FineInterval>,
    /// Its patch, that of the coarse model.
    pub patch: Patch,
    /// Its space.
    pub space: BodySpace,
    /// The unknowns, sorted by node, then component.
    pub dofs: Vec<Dof>,
    /// Numbers of the unknowns.
    pub lookup: DofLookup,
    /// Functions of the coarse model, or of its turned copy, in those of the fine one.
    pub prolongation: Prolongation,
    /// The turned copy of the coarse model, where the coarse net is singular or not smooth at the contact.
    pub turned: Option<TurnedNet>,
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

/// Contact points of an interval.
#[derive(Debug, Clone, PartialEq)]
pub struct FineZone {
    /// The points with their functions. On the rim are those in edge elements.
    pub points: Vec<SurfacePoint>,
    /// Contact element of each point, for the utilisation.
    pub elements: Vec<[usize; 2]>,
    /// Unknowns of the interface, rising.
    pub unknowns: Vec<usize>,
}

/// Low-frequency modes of a fine model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LowModes {
    /// Those of the coarse model, prolonged: the state is handed over without loss.
    #[default]
    Prolonged,
    /// The fine model's own, as in \[A\].
    Own,
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

    /// What points and markers need; `coarse` is the body that was refined.
    pub fn discretised<'a>(&'a self, coarse: &'a ElasticBody) -> Discretised<'a> {
        Discretised {
            name: &self.assembled.name,
            shape: self.turned.as_ref().map_or(&coarse.spec.shape, |net| &net.body.spec.shape),
            space: self.space.as_space(),
            assembled: &self.assembled,
            lookup: &self.lookup,
        }
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
    /// [`AdaptiveError::Subdivision`] if no division resolves the intervals; [`AdaptiveError::Geometry`] if the space cannot be
    /// built; [`AdaptiveError::Unsupported`] for bodies of several patches and intervals on singular lines.
    pub fn build(
        coarse: &ElasticBody,
        wanted: &[WantedInterval],
        settings: &FineSettings,
    ) -> Result<Self, AdaptiveError> {
        let turned = match wanted {
            [one] if coarse.spec.model == Model::Solid => TurnedNet::new(coarse, one)?,
            _ => None,
        };
        match turned {
            None => Self::refine(coarse, wanted, settings),
            Some(net) => {
                let fine = Self::refine(&net.body, &[net.wanted], settings)?;
                Ok(Self { turned: Some(net), ..fine })
            }
        }
    }

    fn refine(
        coarse: &ElasticBody,
        wanted: &[WantedInterval],
        settings: &FineSettings,
    ) -> Result<Self, AdaptiveError> {
        let [patch] = coarse.shape.patches.as_slice() else {
            return Err(AdaptiveError::Unsupported {
                subject: format!("body \"{}\"", coarse.name),
                reason:
                    "bodies of several patches cannot be refined adaptively; refine them by [discretisation]"
                        .into(),
            });
        };
        let fail = |source| AdaptiveError::Geometry { body: coarse.name.clone(), source };
        let plan = plan(coarse, patch, wanted, settings)?;
        check_regular(coarse, wanted, &plan)?;
        let hierarchy = refined(patch, &plan, settings).map_err(fail)?;
        let space = HierarchicalSpace::new(patch, hierarchy).map_err(fail)?;
        let prolongation =
            Prolongation::between(&HierarchicalSpace::plain(patch).map_err(fail)?, &space).map_err(fail)?;
        let intervals = fine_intervals(coarse, patch, &space, wanted, &plan);
        debug!(body = coarse.name, elements = ?elements_of_levels(&space), "fine model");
        let unknowns = unknowns(&coarse.spec.model, space.control_points());
        let dofs: Vec<Dof> = unknowns.into_iter().map(|(node, component)| Dof { node, component }).collect();
        let lookup = DofLookup::new(&dofs);
        let (name, motion) = (coarse.name.clone(), rigid_motion(&coarse.spec.model));
        let (patch, space) = (patch.clone(), BodySpace::Hierarchical(Box::new(space)));
        Ok(Self { name, motion, plan, intervals, patch, space, dofs, lookup, prolongation, turned: None })
    }

    /// Stiffness and mass of the body, whose model and material are those of `coarse`.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the mapping folds, or there are too many entries.
    pub fn assemble(&self, coarse: &ElasticBody) -> Result<AssembledBody, AdaptiveError> {
        let fail = |source| AdaptiveError::Geometry { body: self.name.clone(), source };
        let space = self.space.as_space();
        let matrices = assemble(space, &coarse.spec.model, &coarse.spec.material).map_err(fail)?;
        Ok(AssembledBody {
            name: self.name.clone(),
            motion: self.motion,
            stiffness: matrices.stiffness,
            mass: MassMatrix::PerComponent(matrices.mass),
            nodes: space.control_points().to_vec(),
            anchors: space.anchors(),
            dofs: self.dofs.clone(),
        })
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.dofs.len()
    }

    /// Displacements of the coarse unknowns (n_coarse x k) on the fine ones: the same displacement fields (theory Eq. A.5).
    /// On a turned net the nearest ones in the mass norm.
    pub fn prolong(&self, coarse: &AssembledBody, shapes: MatRef<'_, f64>) -> Mat<f64> {
        match &self.turned {
            None => self.prolong_nested(coarse, shapes),
            Some(net) => self.prolong_nested(&net.body.assembled, net.carry(coarse, shapes).as_ref()),
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

    /// Forces on the fine unknowns (n_fine x k) collected on the coarse ones, the transpose of [`FineMesh::prolong`].
    pub fn restrict(&self, coarse: &AssembledBody, forces: MatRef<'_, f64>) -> Mat<f64> {
        match &self.turned {
            None => self.restrict_nested(coarse, forces),
            Some(net) => net.collect(coarse, self.restrict_nested(&net.body.assembled, forces).as_ref()),
        }
    }

    fn restrict_nested(&self, coarse: &AssembledBody, forces: MatRef<'_, f64>) -> Mat<f64> {
        let mut collected = Mat::zeros(coarse.dofs.len(), forces.ncols());
        for j in 0..forces.ncols() {
            let mut values = vec![[0.0; 3]; self.prolongation.n_fine()];
            for (i, dof) in self.dofs.iter().enumerate() {
                values[dof.node as usize][dof.component as usize] = forces[(i, j)];
            }
            let values = self.prolongation.apply_transposed(&values);
            for (i, dof) in coarse.dofs.iter().enumerate() {
                collected[(i, j)] = values[dof.node as usize][dof.component as usize];
            }
        }
        collected
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
        let Some(rigid) = problem.rigid().cloned() else {
            let reason = "a free body is needed for its free modes".into();
            return Err(fail(ffr_dynamics::DynamicsError::Inconsistent { reason }));
        };
        let (body, reduced) = (coarse.0, &coarse.1.basis);
        let basis = match modes {
            LowModes::Prolonged => ReducedBasis {
                shapes: self.prolong(&body.assembled, reduced.shapes.as_ref()),
                omega: reduced.omega.clone(),
                n_low: reduced.n_low,
                rigid,
                multiplet: None,
            },
            LowModes::Own => {
                ReducedBasis::from_modes(problem.lowest_modes(reduced.n_low).map_err(fail)?, rigid)
            }
        };
        let residual = ResidualFlexibility::new(&problem, unknowns, &basis).map_err(fail)?;
        Ok((basis, residual))
    }

    /// Contact points of interval `i`, and the unknowns of the functions that are not zero on it.
    pub fn zone(&self, i: usize, rule: PointRule, thickness: f64) -> FineZone {
        let interval = &self.intervals[i];
        let patches = std::slice::from_ref(&self.patch);
        let gauss = self.space.gauss_points(patches, &[interval.face]);
        let greville;
        let all = match rule {
            PointRule::Greville => {
                greville = self.space.greville_points(patches, &[interval.face]);
                &greville
            }
            PointRule::Gauss => &gauss,
        };
        let inside: Vec<&CollocationPoint> = all.iter().filter(|p| interval.contains(&p.xi)).collect();
        let knots = self.finest_knots();
        let elements: Vec<[usize; 2]> = inside.iter().map(|p| interval.element(knots, &p.xi)).collect();
        let points: Vec<SurfacePoint> = inside
            .iter()
            .zip(&elements)
            .map(|(p, &element)| SurfacePoint {
                position: p.point,
                area: p.area * thickness,
                functions: self.functions_at(p.element, &p.xi),
                on_rim: interval.is_edge(element),
            })
            .collect();
        let within = gauss.iter().filter(|p| interval.contains(&p.xi));
        let mut nodes: Vec<u32> = within
            .flat_map(|p| self.functions_at(p.element, &p.xi))
            .chain(points.iter().flat_map(|p| p.functions.iter().copied()))
            .map(|f| f.0)
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        let n_components = self.motion.n_components();
        let number = |&n: &u32| (0..n_components).filter_map(move |c| self.lookup.number(n, c));
        let mut unknowns: Vec<usize> = nodes.iter().flat_map(number).collect();
        unknowns.sort_unstable();
        FineZone { points, elements, unknowns }
    }

    fn finest_knots(&self) -> &[KnotVector] {
        match &self.space {
            BodySpace::Hierarchical(space) => {
                let levels = space.basis().hierarchy().levels();
                levels[levels.len() - 1].knots()
            }
            BodySpace::Plain(_) => self.patch.knots(),
        }
    }

    /// Functions that are not zero at parameters `xi` of element `e`, with their values.
    pub fn functions_at(&self, e: usize, xi: &[f64; 3]) -> Vec<(u32, f64)> {
        let (mut basis, mut active) = (PointBasis::default(), Vec::new());
        self.space.evaluate(e, xi, 0, &mut basis);
        self.space.active_functions(e, &mut active);
        active.into_iter().zip(basis.values).filter(|(_, value)| value.abs() > 0.0).collect()
    }

    /// Displacements of the unknowns as node-major control values, with zeros where a component is constrained.
    pub fn control_values(&self, displacement: &[f64]) -> Vec<f64> {
        let n_components = self.motion.n_components();
        let mut values = vec![0.0; self.space.n_functions() * n_components];
        for (dof, u) in self.dofs.iter().zip(displacement) {
            values[dof.node as usize * n_components + dof.component as usize] = *u;
        }
        values
    }
}

impl FineInterval {
    /// Whether parameters of the face lie in the interval.
    pub fn contains(&self, xi: &[f64; 3]) -> bool {
        let inside = |&d: &usize| {
            xi[d] >= self.region.lower[d] - self.slack[d] && xi[d] <= self.region.upper[d] + self.slack[d]
        };
        self.directions.iter().all(inside)
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

/// The parameters of an interval's ends along the face, as it is asked for.
fn parameters(coarse: &ElasticBody, patch: &Patch, wanted: &WantedInterval) -> [Option<[f64; 2]>; 3] {
    let on_face = wanted.face.on_face(&wanted.centre);
    let point = patch.point(&on_face);
    let mut spans = [None; 3];
    for (d, width) in wanted.face.directions().zip(wanted.widths) {
        let reach = reach(coarse, &point, width);
        spans[d] = Some(reach.map(|s| parameter_at_distance(patch, &on_face, d, s)));
    }
    spans
}

/// Ends of an interval of width `width` about `point`, along the surface \[m\].
///
/// An interval that would cross the axis of an axisymmetric model goes from the axis outwards: what lies beyond the axis is
/// the same surface once more, and a search finds points on the axis no nearer to it than the square root of round-off.
fn reach(coarse: &ElasticBody, point: &[f64; 3], width: f64) -> [f64; 2] {
    let half = 0.5 * width;
    let is_on_axis = coarse.spec.model == Model::Axisymmetric && point[0].abs() < half;
    // The end on the axis is cut off there.
    if is_on_axis { [-(width - point[0]), width - point[0]] } else { [-half, half] }
}

/// How deep the refinement goes: half the width of the whole interval \[m\].
fn depth(coarse: &ElasticBody, patch: &Patch, wanted: &WantedInterval) -> f64 {
    let point = patch.point(&wanted.face.on_face(&wanted.centre));
    let half = |&w: &f64| reach(coarse, &point, w)[1];
    wanted.widths[..wanted.face.directions().count()].iter().map(half).fold(0.0, f64::max)
}

/// Levels and regions for all intervals of a body.
fn plan(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &[WantedInterval],
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    match wanted {
        [one] if patch.dimension() == 3 => lattice_plan(coarse, patch, one, settings),
        _ => parts_plan(coarse, patch, wanted, settings),
    }
}

/// Lattices about one interval of a solid body.
fn lattice_plan(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &WantedInterval,
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    let mut spans = parameters(coarse, patch, wanted);
    let xi = wanted.face.on_face(&wanted.centre);
    let first = patch.jet(&xi, 1, &mut PointBasis::default()).first;
    let none = DirectionLattice { anchor: 0.0, spacing: 1.0, n_levels: 0 };
    let (mut lattices, mut size) = ([none; 3], f64::INFINITY);
    for d in 0..3 {
        let Some(span) = &mut spans[d] else { continue };
        (lattices[d], *span) = DirectionLattice::along(&patch.knots()[d], *span, settings.limits.elements);
        size = size.min(lattices[d].spacing * norm(&first[d]));
    }
    let across = wanted.face.id.direction;
    let spacing = size / norm(&first[across]);
    lattices[across] = DirectionLattice::into_depth(&patch.knots()[across], wanted.face.parameter, spacing);
    let n_levels = lattices.iter().map(|l| l.n_levels).max().unwrap_or(0);
    if n_levels + 1 > settings.limits.max_levels {
        let source = SubdivisionError::TooManyLevels {
            needed: n_levels + 1,
            allowed: settings.limits.max_levels,
            width: wanted.widths[0].min(wanted.widths[1]),
        };
        return Err(AdaptiveError::Subdivision { body: coarse.name.clone(), source });
    }
    let along = spans.map(|span| {
        span.map(|interval| DirectionPlan {
            parts: Vec::new(),
            intervals: vec![interval],
            n_elements: vec![settings.limits.elements],
            deviation: 0.0,
        })
    });
    let region = region(coarse, patch, wanted, &spans, &along, &mut [0; 3]);
    Ok(RefinementPlan { division: Division::Lattice(lattices), regions: vec![region] })
}

/// Algorithm 3 for all intervals of a body.
fn parts_plan(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &[WantedInterval],
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    let fail = |source| AdaptiveError::Subdivision { body: coarse.name.clone(), source };
    let spans: Vec<_> = wanted.iter().map(|w| parameters(coarse, patch, w)).collect();
    let mut along: [Option<DirectionPlan>; 3] = Default::default();
    for (d, knots) in patch.knots().iter().enumerate() {
        let intervals: Vec<[f64; 2]> = spans.iter().filter_map(|s| s[d]).collect();
        if !intervals.is_empty() {
            let growth = growth(knots, 2, settings);
            let surface = SurfaceGrowth { growth, directions: patch.dimension() as i32 - 1 };
            along[d] = Some(divide(&knots.breaks(), &intervals, surface, &settings.limits).map_err(fail)?);
        }
    }
    let n_levels = along.iter().flatten().map(|p| p.parts.len()).max().unwrap_or(0);
    let mut parts = vec![[1; 3]; n_levels];
    for (d, plan) in along.iter().enumerate() {
        let Some(plan) = plan else { continue };
        let first = n_levels - plan.parts.len();
        plan.parts.iter().zip(&mut parts[first..]).for_each(|(n, level)| level[d] = *n);
    }
    for d in (0..patch.dimension()).filter(|&d| along[d].is_none()) {
        let into_depth = wanted.iter().map(|w| depth_parts(patch, w, d, &parts, settings));
        let most = into_depth.max_by_key(|list| list.iter().product::<usize>()).unwrap_or_default();
        most.into_iter().zip(&mut parts).for_each(|(n, level)| level[d] = n);
    }
    let mut taken = [0; 3];
    let mut regions = Vec::new();
    for (w, span) in wanted.iter().zip(&spans) {
        regions.push(region(coarse, patch, w, span, &along, &mut taken));
    }
    Ok(RefinementPlan { division: Division::Parts(parts), regions })
}

/// Refuses intervals that touch a singular line of the parametrisation.
fn check_regular(
    coarse: &ElasticBody,
    wanted: &[WantedInterval],
    plan: &RefinementPlan,
) -> Result<(), AdaptiveError> {
    for (w, region) in wanted.iter().zip(&plan.regions) {
        let [lower, upper] = [region.lower, region.upper].map(|corner| w.face.on_face(&corner));
        if let Some(set) = coarse.shape.singular_in(w.face.id.patch, &lower, &upper) {
            return Err(AdaptiveError::Unsupported {
                subject: format!("body \"{}\"", coarse.name),
                reason: format!(
                    "a contact interval touches the singular {} of the parametrisation; turn the body's frame or choose another net",
                    set.name
                ),
            });
        }
    }
    Ok(())
}

/// Parts into the depth, so that elements at the contact have about the same size in all directions.
fn depth_parts(
    patch: &Patch,
    wanted: &WantedInterval,
    depth: usize,
    parts: &[[usize; 3]],
    settings: &FineSettings,
) -> Vec<usize> {
    let xi = wanted.face.on_face(&wanted.centre);
    let first = patch.jet(&xi, 1, &mut PointBasis::default()).first;
    let size = |d: usize| {
        let knots = &patch.knots()[d];
        let (a, b) = knots.element(knots.find_element(xi[d]));
        (b - a) * norm(&first[d])
    };
    let mut sizes: Vec<(usize, f64)> = wanted.face.directions().map(|d| (d, size(d))).collect();
    let along: Vec<f64> = parts
        .iter()
        .map(|level| {
            sizes.iter_mut().for_each(|(d, s)| *s /= level[*d] as f64);
            sizes.iter().map(|s| s.1).fold(f64::INFINITY, f64::min)
        })
        .collect();
    follow(size(depth), &along, &settings.limits)
}

/// The box around which the levels are refined for an interval, its ends moved to knots. `taken` counts the intervals
/// of each direction that were used before.
fn region(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &WantedInterval,
    span: &[Option<[f64; 2]>; 3],
    along: &[Option<DirectionPlan>; 3],
    taken: &mut [usize; 3],
) -> ParameterBox {
    let (mut lower, mut upper) = ([0.0; 3], [0.0; 3]);
    for d in 0..patch.dimension() {
        let ends = match (span[d], &along[d]) {
            (Some(_), Some(plan)) => {
                taken[d] += 1;
                plan.intervals[taken[d] - 1]
            }
            _ => {
                let surface = wanted.face.on_face(&wanted.centre);
                let inwards = if wanted.face.id.upper { -1.0 } else { 1.0 };
                let end = parameter_at_distance(patch, &surface, d, inwards * depth(coarse, patch, wanted));
                [end.min(wanted.face.parameter), end.max(wanted.face.parameter)]
            }
        };
        (lower[d], upper[d]) = (ends[0], ends[1]);
    }
    ParameterBox { lower, upper }
}

/// Elements by which a level that splits elements into `parts` reaches beyond an interval. A function of the finer level
/// that is not zero on the interval ends within the degree divided by `parts` elements of the coarser one.
fn growth(knots: &KnotVector, parts: usize, settings: &FineSettings) -> usize {
    let degree = knots.degree();
    let own = if parts == 1 { degree } else { degree.div_ceil(2) };
    settings.growth.map_or(own, |g| g.min(degree))
}

/// The levels of a plan.
fn refined(
    patch: &Patch,
    plan: &RefinementPlan,
    settings: &FineSettings,
) -> Result<SubdomainHierarchy, SplineError> {
    let ties = PatchTies::detect(patch);
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    let levels = match &plan.division {
        Division::Lattice(lattices) => {
            return refined_lattice(hierarchy, lattices, &plan.regions, settings, &ties);
        }
        Division::Parts(parts) => parts,
    };
    for &parts in levels.iter().filter(|p| p.iter().any(|&n| n > 1)) {
        let growth =
            std::array::from_fn(|d| patch.knots().get(d).map_or(0, |k| growth(k, parts[d], settings)));
        let mut boxes = Vec::new();
        for region in &plan.regions {
            boxes.extend(hierarchy.elements_around(region, growth, &ties)?);
        }
        let levels = hierarchy.levels();
        let coarse = levels[levels.len() - 1].knots();
        let split = |(d, k): (usize, &KnotVector)| {
            split_inside(k, parts[d], |e| boxes.iter().any(|b| (b.lower[d]..b.upper[d]).contains(&e)))
        };
        let knots = coarse.iter().enumerate().map(split).collect::<Result<Vec<_>, _>>()?;
        hierarchy.refine_knots(knots, &boxes)?;
    }
    Ok(hierarchy)
}

/// The levels of lattices.
fn refined_lattice(
    mut hierarchy: SubdomainHierarchy,
    lattices: &[DirectionLattice; 3],
    regions: &[ParameterBox],
    settings: &FineSettings,
    ties: &PatchTies,
) -> Result<SubdomainHierarchy, SplineError> {
    let n_levels = lattices.iter().map(|l| l.n_levels).max().unwrap_or(0);
    for level in (0..n_levels).rev() {
        let levels = hierarchy.levels();
        let coarse = levels[levels.len() - 1].knots().to_vec();
        // Levels beyond the finest reach out further: their elements then grow with the distance from the contact.
        let reach = |d: usize| {
            let parts = if level < lattices[d].n_levels { 2 } else { 1 };
            growth(&coarse[d], parts, settings).max(if level == 0 { 1 } else { COARSE_REACH })
        };
        let by = std::array::from_fn(|d| if d < coarse.len() { reach(d) } else { 0 });
        let mut boxes = Vec::new();
        for region in regions {
            boxes.extend(hierarchy.elements_around(region, by, ties)?);
        }
        let split = |(d, k): (usize, &KnotVector)| {
            lattices[d].refine(k, level, |e| boxes.iter().any(|b| (b.lower[d]..b.upper[d]).contains(&e)))
        };
        let knots = coarse.iter().enumerate().map(split).collect::<Result<Vec<_>, _>>()?;
        if knots != coarse {
            hierarchy.refine_knots(knots, &boxes)?;
        }
    }
    Ok(hierarchy)
}

/// Splits the elements that are `wanted` into `parts` equal ones. Elsewhere the next level is not used and needs no knots, of
/// which a long body would have many.
fn split_inside(
    coarse: &KnotVector,
    parts: usize,
    wanted: impl Fn(usize) -> bool,
) -> Result<KnotVector, SplineError> {
    let mut new = Vec::new();
    for e in (0..coarse.n_elements()).filter(|&e| wanted(e)) {
        let (a, b) = coarse.element(e);
        new.extend((1..parts).map(|k| a + (b - a) * (k as f64 / parts as f64)));
    }
    coarse.with_knots(&new)
}

fn fine_intervals(
    coarse: &ElasticBody,
    patch: &Patch,
    space: &HierarchicalSpace,
    wanted: &[WantedInterval],
    plan: &RefinementPlan,
) -> Vec<FineInterval> {
    let levels = space.basis().hierarchy().levels();
    let knots = levels[levels.len() - 1].knots();
    let make = |(w, region): (&WantedInterval, &ParameterBox)| {
        let directions: Vec<usize> = w.face.directions().collect();
        let slack = std::array::from_fn(|d| {
            knots.get(d).map_or(0.0, |k| PARAMETER_SLACK * (k.domain().1 - k.domain().0))
        });
        let (mut n_elements, mut first) = ([1; 2], [0; 2]);
        for (i, &d) in directions.iter().enumerate() {
            first[i] = knots[d].find_element(region.lower[d] + slack[d]);
            n_elements[i] = knots[d].find_element(region.upper[d] - slack[d]) + 1 - first[i];
        }
        let ends = directions.iter().map(|&d| interval_ends(coarse, patch, &w.face, region, d)).collect();
        let (face, widths) = (w.face, w.widths);
        FineInterval { face, directions, region: *region, ends, n_elements, widths, first, slack }
    };
    wanted.iter().zip(&plan.regions).map(make).collect()
}

/// What lies at both ends of an interval in direction `d`.
fn interval_ends(
    coarse: &ElasticBody,
    patch: &Patch,
    face: &Face,
    region: &ParameterBox,
    d: usize,
) -> [IntervalEnd; 2] {
    let (first, last) = patch.knots()[d].domain();
    let slack = PARAMETER_SLACK * (last - first);
    let size = coarse.size();
    [(region.lower, first), (region.upper, last)].map(|(corner, end)| {
        let is_axis = coarse.spec.model == Model::Axisymmetric
            && patch.point(&face.on_face(&corner))[0].abs() < PARAMETER_SLACK * size;
        match ((corner[d] - end).abs() <= slack, is_axis) {
            (false, _) => IntervalEnd::Open,
            (true, true) => IntervalEnd::Axis,
            (true, false) => IntervalEnd::FaceEnd,
        }
    })
}
