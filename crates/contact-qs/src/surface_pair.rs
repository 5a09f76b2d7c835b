//! Contact of a body's points with the surface of another body, as a force element.
//!
//! Points of the contact body are projected on the deformed surface of the target; gaps are
//! measured along its outward normal (docs/theory.md Eqs. C.38, C.39). Either body may be rigid,
//! carry all its modes dynamically, or have a quasistatic compliance; both compliances add up in
//! one convex problem for the point forces (Eq. C.40). The forces act at the displaced points,
//! quasistatic part included, along the normals there: they are the gradient of one potential
//! (Eq. C.44), equal and opposite, with a common line of action.
//!
//! In axisymmetric models a point is a ring: only the axial resultant moves the bodies, radial
//! parts load their modes.
//!
//! Each pair has a compliance of its own. A body in two pairs has two zones; the displacement of
//! one zone under the forces in the other is that of the dynamic modes alone, without its
//! quasistatic part (Eq. C.45).

use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::DataError;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::{BodyState, Findings, ForceElement, ForceEnergies, GeneralisedForce, Motion};
use iga_core::nurbs::jet::{diagonal, difference, norm};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{Contact, ContactElement, ContactReport, Meeting};
use crate::law::{Friction, penalty};
use crate::quasistatic::Method;
use crate::quasistatic::compliance::sparse_rows::SparseRows;
use crate::zone::submodel::ContactSubmodel;

mod relative_pose;
mod target;
mod projection;
mod contact_jacobian;
mod friction;
mod search;
mod solver;
mod state;
mod forces;
mod evaluation;

use friction::PairFriction;
use projection::meeting_point::MetPlanes;
use solver::{Compliances, PairBodies};
use state::Work;

pub use projection::SurfacePlace;
pub use projection::meeting_point::MeetingPoint;
pub use state::{PairFound, PairState, PairWorkspace};
pub use target::{TargetFace, TargetSurface};

/// Settings of a surface pair besides its points and its surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePairSettings {
    /// Index of the body that carries the points in the lists given to [`ForceElement::evaluate`].
    pub contact_body: usize,
    /// Index of the body that carries the surface; none if it is fixed, its frame being the
    /// inertial one.
    pub target_body: Option<usize>,
    /// Penalty factor; infinite for the exact constraint [N/m³].
    pub penalty: f64,
    /// Solver of the quasistatic problem; without effect when all modes of both bodies are dynamic.
    pub method: Method,
}

/// Contact of a body's points with a surface of another body.
pub struct SurfacePair {
    settings: SurfacePairSettings,
    motion: RigidMotion,
    /// Undeformed points in the model's components.
    points: Vec<[f64; 3]>,
    areas: Vec<f64>,
    is_rim: Vec<bool>,
    /// Outward normals of the faces of the points in the model's components; empty if every surface
    /// can press every point.
    facing: Vec<[f64; 3]>,
    /// Rows of the contact body's low-frequency shapes.
    low_rows: Vec<f64>,
    /// The entries of `low_rows`, mode after mode, three for each point.
    low_columns: Vec<f64>,
    n_modes: usize,
    interface: SparseRows,
    surface: TargetSurface,
    compliances: Option<Compliances>,
    friction: Option<Friction>,
    springs: Vec<f64>,
    /// The part of `springs` that is what elements leave out of the indentation at a point; empty if nothing.
    left_out: Vec<f64>,
    /// Points nearer than this to an end of the target count as touching it.
    rim_reach: f64,
    ground: BodyState,
    tolerance: f64,
    /// Where edges cross, or the target has a corner.
    meeting: Option<MetPlanes>,
}

impl SurfacePair {
    /// Contact of the points of `submodel` with `surface`.
    ///
    /// # Errors
    /// [`ContactError`] if bodies or data do not fit, the penalty factor is not positive, or it is infinite where springs are
    /// needed.
    pub fn new(
        submodel: ContactSubmodel,
        surface: TargetSurface,
        settings: SurfacePairSettings,
    ) -> Result<Self, ContactError> {
        submodel.validate()?;
        let motion = submodel.motion;
        check(&submodel, &surface, &settings)?;
        let (n, nc) = (submodel.n_points(), motion.n_components());
        let n_q = submodel.low.ncols();
        let (low_rows, is_rim) = (submodel.low_rows(), submodel.is_rim());
        let compliances = if submodel.is_quasistatic() || surface.is_quasistatic() {
            let body = (submodel.compliance, &submodel.interface);
            Some(Compliances::new(settings.method, nc, body, n, &surface)?)
        } else {
            None
        };
        let low = &submodel.low;
        let mut pair = Self {
            points: submodel.points.iter().map(|p| motion.components(p)).collect(),
            low_rows,
            low_columns: (0..n_q)
                .flat_map(|k| target::by_places(nc, low.col_as_slice(k).iter().copied()))
                .collect(),
            n_modes: n_q,
            is_rim,
            springs: vec![0.0; n],
            rim_reach: spacing(&submodel.areas, motion, &submodel.points),
            ground: BodyState::at_rest(0),
            tolerance: evaluation::GAP_TOLERANCE,
            meeting: None,
            facing: submodel.facing.iter().map(|n| motion.components(n)).collect(),
            areas: submodel.areas,
            left_out: submodel.left_out,
            interface: submodel.interface,
            settings,
            motion,
            surface,
            compliances,
            friction: None,
        };
        pair.set_springs(settings.penalty)?;
        Ok(pair)
    }

    /// Adds friction; without effect if the coefficient is zero.
    ///
    /// # Errors
    /// [`ContactError::Friction`] if its values make no law, [`ContactError::FrictionSolver`] with Algorithm 1.
    pub fn with_friction(mut self, friction: Friction) -> Result<Self, ContactError> {
        friction.check()?;
        if friction.coefficient <= 0.0 {
            return Ok(self);
        }
        if self.compliances.as_ref().is_some_and(Compliances::needs_springs) {
            return Err(ContactError::FrictionSolver);
        }
        self.friction = Some(friction);
        Ok(self)
    }

    /// Changes the error of gaps, as a share of the deepest penetration, at which projection and
    /// deformation count as having met; 1e-8 unless changed.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Sets penalty factor and springs.
    fn set_springs(&mut self, penalty: f64) -> Result<(), ContactError> {
        let needs_springs = self.compliances.as_ref().map(Compliances::needs_springs);
        penalty::set_springs(penalty, needs_springs, (&self.areas, &self.left_out), &mut self.springs)?;
        self.settings.penalty = penalty;
        Ok(())
    }

    /// Tributary areas of the points \[m²\].
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The target.
    pub fn surface(&self) -> &TargetSurface {
        &self.surface
    }

    /// Normal compliance `A` of both bodies together at the projections of the motion `bodies`
    /// (Eq. C.40), `n_points` squared [m/N]; none when all modes are dynamic. The state forgets
    /// where its iterations started.
    ///
    /// # Errors
    /// [`EvaluationFailure`] if the points cannot be projected.
    pub fn normal_compliance<'a>(
        &self,
        bodies: &[BodyState],
        state: &'a mut PairState,
        workspace: &mut PairWorkspace,
        found: &mut PairFound,
    ) -> Result<Option<&'a Mat<f64>>, EvaluationFailure> {
        state.forget_evaluation();
        let mut work = Work { state: &mut *state, buffers: &mut workspace.buffers, found: &mut *found };
        let outcome = self.project_for_compliance(bodies, &mut work);
        found.is_known = state.start.is_known;
        outcome?;
        Ok(state.zone.as_ref().map(solver::PairZone::normal_compliance))
    }

    /// Number of tangents of a point, zero without friction.
    fn n_tangents(&self) -> usize {
        if self.friction.is_some() { self.motion.n_components() - 1 } else { 0 }
    }

    /// Compliances and target surface of the pair; none when all modes are dynamic.
    fn both(&self) -> Option<PairBodies<'_>> {
        self.compliances.as_ref().map(|compliances| PairBodies { compliances, surface: &self.surface })
    }

    fn body_row(&self, row: usize) -> &[f64] {
        &self.low_rows[row * self.n_modes..(row + 1) * self.n_modes]
    }
}

/// Checks that points and surface can meet.
fn check(
    submodel: &ContactSubmodel,
    surface: &TargetSurface,
    settings: &SurfacePairSettings,
) -> Result<(), ContactError> {
    if submodel.motion != surface.motion {
        return Err(ContactError::MixedModels { first: submodel.motion, second: surface.motion });
    }
    if settings.target_body == Some(settings.contact_body) {
        return Err(ContactError::OneBody { body: settings.contact_body });
    }
    if settings.target_body.is_none() && surface.n_modes > 0 {
        let what = "elastic coordinates of a fixed target".into();
        return Err(DataError::Count { what, found: surface.n_modes, expected: 0 }.into());
    }
    Ok(())
}

/// Distance of neighbouring points \[m\]: of points on the surface of a solid in the direction in
/// which they are wider apart, so that one of them is within it of any end of the target that
/// contact reaches.
fn spacing(areas: &[f64], motion: RigidMotion, points: &[[f64; 3]]) -> f64 {
    let n = points.len() as f64;
    let all: Vec<[f64; 3]> = points.iter().map(|p| motion.components(p)).collect();
    if motion != RigidMotion::Spatial {
        return diagonal(&all) / n;
    }
    let nearest = |(i, p): (usize, &[f64; 3])| {
        let others = all.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, q)| norm(&difference(p, q))).fold(f64::INFINITY, f64::min)
    };
    let narrow = all.iter().enumerate().map(nearest).sum::<f64>() / n;
    let area = areas.iter().sum::<f64>() / n;
    area.sqrt().max(area / narrow)
}

impl SurfacePair {
    /// Forces at the motions `own` and `target`, summed up, with the work lost to sliding.
    fn find(
        &self,
        t: f64,
        [own, target]: [&BodyState; 2],
        work: &mut Work<'_>,
    ) -> Result<(), EvaluationFailure> {
        let solver = self.find_forces(t, own, target, work)?;
        self.sum_up(solver, target, work);
        let PairState { start, friction, .. } = &mut *work.state;
        if let Some(friction) = friction {
            friction.is_evaluated = true;
            friction.note_way(t, &start.forces);
            work.found.report.energies.slid = friction.sliding_work();
        }
        Ok(())
    }
}

impl ForceElement for SurfacePair {
    type State = PairState;
    type Workspace = PairWorkspace;
    type Found = PairFound;

    fn start(&self) -> (PairState, PairWorkspace, PairFound) {
        let (n, nc) = (self.points.len(), self.motion.n_components());
        let is_quasistatic = self.compliances.is_some();
        let friction = self.friction.map(|law| {
            let n_nodes = self.surface.nodes.len();
            let mut state = PairFriction::new(law, (n, nc), n_nodes, is_quasistatic);
            state.stick_slip.set_springs(&self.springs);
            Box::new(state)
        });
        let n_t = friction.as_ref().map_or(0, |f| f.n_t);
        let zone = self.compliances.as_ref().map(|c| c.solver(&self.surface, n_t));
        let state = PairState::new(n, nc, (self.surface.nodes.len(), self.surface.spread), zone, friction);
        let workspace = PairWorkspace::new(&self.surface, n, self.n_tangents());
        (state, workspace, PairFound::new(&self.surface, n, self.n_tangents()))
    }

    fn evaluate(
        &self,
        motion: Motion<'_>,
        state: &mut PairState,
        workspace: &mut PairWorkspace,
        found: &mut PairFound,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let (own, target) = self.states(motion.bodies);
        debug_assert_eq!(own.elastic.len(), self.n_modes);
        let PairWorkspace { buffers, .. } = workspace;
        let mut work = Work { state: &mut *state, buffers, found: &mut *found };
        let outcome = self.find(motion.time, [own, target], &mut work);
        if outcome.is_err() {
            // Nothing of a failed evaluation may lead the next one.
            state.forget_evaluation();
        }
        found.is_known = state.start.is_known;
        outcome?;
        if found.report.n_active > 0 {
            self.push(motion.bodies, state, found, forces);
        }
        Ok(())
    }

    fn rates(
        &self,
        (motion, by_velocity): (Motion<'_>, bool),
        state: &mut PairState,
        workspace: &mut PairWorkspace,
        found: &PairFound,
        rates: &mut [GeneralisedForce],
    ) -> bool {
        let (own, target) = self.states(motion.bodies);
        let is_zero = by_velocity || found.report.n_active == 0 || (own.is_at_rest() && target.is_at_rest());
        is_zero || self.add_force_rates(motion.bodies, (state, &mut workspace.buffers), found, rates)
    }

    fn save(&self, state: &mut PairState, found: &PairFound) {
        let PairState { start, saved, zone, friction } = state;
        saved.copy_from(start);
        if let Some(zone) = zone {
            zone.save();
        }
        if let Some(friction) = friction {
            if friction.is_evaluated {
                friction.update_references(
                    &start.forces,
                    &found.nodes,
                    &found.jacobian,
                    &found.projections,
                    &found.is_wanted,
                );
            }
            friction.save();
        }
    }

    fn restore(&self, state: &mut PairState, found: &mut PairFound) {
        let PairState { start, saved, zone, friction } = state;
        start.copy_from(saved);
        if let Some(zone) = zone {
            zone.restore();
        }
        if let Some(friction) = friction {
            friction.restore();
        }
        found.is_known = start.is_known;
    }
}

impl Contact for SurfacePair {
    fn kind(&self) -> &'static str {
        "surface-surface"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.settings.contact_body, self.settings.target_body)
    }

    fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    fn n_points(&self) -> usize {
        self.points.len()
    }

    fn point(&self, i: usize) -> Option<([f64; 3], f64)> {
        Some((self.motion.in_space(self.points.get(i)?).into(), self.areas[i]))
    }
}

impl ContactElement for SurfacePair {
    fn report<'a>(&self, found: &'a PairFound) -> &'a ContactReport {
        &found.report
    }

    fn meeting(&self, motion: Motion<'_>, state: &PairState, workspace: &mut PairWorkspace) -> Meeting {
        let (own, target) = self.states(motion.bodies);
        let nearest = self.nearest(motion.bodies, &state.start, &mut workspace.search);
        nearest.map_or(Meeting::UNKNOWN, |found| Meeting {
            gap: found.gap,
            normal: relative_pose::direction(self.motion, &target.rotation, &found.normal),
            place: own.position + own.rotation * self.motion.in_space(&found.place),
        })
    }

    fn point_forces<'a>(&self, state: &'a PairState, _: &'a PairFound) -> Option<&'a [f64]> {
        Some(&state.start.forces)
    }

    fn friction_forces(&self, state: &PairState, found: &PairFound) -> Vec<Vector3<f64>> {
        let vector = |v: [f64; 3]| self.motion.in_space(&v);
        state.friction.as_ref().map_or_else(Vec::new, |friction| {
            friction.vectors(&found.jacobian).into_iter().map(vector).collect()
        })
    }

    fn prescribe_friction(&self, wanted: Option<&[Vector3<f64>]>, state: &mut PairState, found: &PairFound) {
        if let Some(friction) = &mut state.friction {
            let components = |wanted: &[Vector3<f64>]| {
                wanted.iter().map(|w| self.motion.components(&(*w).into())).collect()
            };
            let wanted: Option<Vec<_>> = wanted.map(components);
            friction.prescribe(wanted.as_deref(), &found.jacobian);
        }
    }

    fn set_penalty(&mut self, penalty: f64, state: &mut PairState) -> Result<(), ContactError> {
        self.set_springs(penalty)?;
        if let Some(zone) = &mut state.zone {
            zone.springs_changed();
        }
        if let Some(friction) = &mut state.friction {
            friction.stick_slip.set_springs(&self.springs);
        }
        Ok(())
    }

    fn compliance_weight(
        &self,
        (motion, reach): (Motion<'_>, f64),
        state: &mut PairState,
        workspace: &mut PairWorkspace,
        found: &mut PairFound,
    ) -> Result<Option<f64>, EvaluationFailure> {
        self.normal_compliance(motion.bodies, state, workspace, found)?;
        let gaps = &state.start.proximity.gaps;
        let gap = |i: usize| if found.is_wanted[i] { gaps[i] } else { f64::INFINITY };
        let compliance = state.zone.as_ref().map(solver::PairZone::normal_compliance);
        Ok(compliance.map(|a| penalty::compliance_weight(a, &self.areas, gap, reach)))
    }

    /// Forces on the interface unknowns, `f_b = ±N_bᵀ λ` (Eq. C.19), for the recovery of stresses.
    ///
    /// # Panics
    /// If `out` is not as long as the body's interface.
    fn interface_force(&self, body: usize, found: &PairFound, out: &mut [f64]) -> bool {
        if body == self.settings.contact_body && self.interface.n_rows() > 0 {
            assert_eq!(out.len(), self.interface.n_columns(), "number of interface degrees of freedom");
            self.interface.spread(&found.loads, out);
        } else if Some(body) == self.settings.target_body && !found.interface_loads.is_empty() {
            assert_eq!(out.len(), found.interface_loads.len(), "number of interface degrees of freedom");
            out.copy_from_slice(&found.interface_loads);
        } else {
            return false;
        }
        true
    }
}

impl Findings for PairFound {
    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.is_known && self.report.n_active == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elongated_points_are_as_far_apart_as_in_their_long_direction() {
        let (long, short) = (0.1, 0.02);
        let points: Vec<[f64; 3]> =
            (0..48).map(|i| [long * f64::from(i % 8), short * f64::from(i / 8), 0.0]).collect();
        let areas = vec![long * short; points.len()];
        assert!((spacing(&areas, RigidMotion::Spatial, &points) / long - 1.0).abs() < 1e-12);
        // A single point has no neighbour.
        assert!((spacing(&[4e-4], RigidMotion::Spatial, &points[..1]) / 0.02 - 1.0).abs() < 1e-12);
    }
}
