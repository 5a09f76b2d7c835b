//! Contact of a body's points with the surface of another body, as a force element.
//!
//! Points of the contact body are projected on the deformed surface of the target; gaps are measured along its outward
//! normal (docs/theory.md Eqs. C.37, C.38). Either body may be rigid, carry all its modes dynamically, or have a quasistatic
//! compliance; both compliances add up in one convex problem for the point forces (Eq. C.39). The forces act at the
//! displaced points, quasistatic part included, along the normals there: they are the gradient of one potential
//! (Eq. C.43), equal and opposite, with a common line of action.
//!
//! In axisymmetric models a point is a ring: only the axial resultant moves the bodies, radial parts load their modes.
//!
//! Each pair has a compliance of its own. A body in two pairs has two zones; the displacement of one zone under the forces in
//! the other is that of the dynamic modes alone, without its quasistatic part (Eq. C.44).

use std::sync::{Mutex, PoisonError};

use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::DataError;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{ContactElement, ContactReport};
use crate::law::{Friction, penalty};
use crate::points::in_space;
use crate::quasistatic::{Method, PointState};
use crate::submodel::{ContactSubmodel, SparseRows};

mod bezier;
mod evaluation;
mod friction;
mod motion;
mod projection;
mod rows;
mod search;
mod solver;
mod target;
mod watch;

use evaluation::{WarmStart, Workspace};
use friction::PairFriction;
use projection::{Functions, Projection, Samples};
use rows::Rows;
use search::SearchBuffers;
use solver::PairZone;

use watch::Watch;

pub use projection::SurfacePlace;
pub use target::{TargetFace, TargetSurface};

/// What a surface pair consists of besides points and surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePairSettings {
    /// Index of the body that carries the points in the lists given to [`ForceElement::apply`].
    pub contact_body: usize,
    /// Index of the body that carries the surface; none if it is fixed, its frame being the inertial one.
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
    /// Rows of the contact body's low-frequency shapes.
    low_rows: Vec<f64>,
    /// The same, mode after mode.
    low_columns: Vec<f64>,
    n_modes: usize,
    interface: SparseRows,
    surface: TargetSurface,
    zone: Option<PairZone>,
    friction: Option<Box<PairFriction>>,
    springs: Vec<f64>,
    /// Points nearer than this to an end of the target count as touching it.
    rim_reach: f64,
    state: WarmStart,
    saved: WarmStart,
    workspace: Option<Workspace>,
    search: Mutex<SearchBuffers>,
    ground: BodyState,
    tolerance: f64,
    /// Solutions of the last evaluation.
    n_passes: usize,
    report: ContactReport,
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
        let zone = if submodel.is_quasistatic() || surface.is_quasistatic() {
            Some(PairZone::new(settings.method, nc, submodel.compliance, n, &surface)?)
        } else {
            None
        };
        let low = &submodel.low;
        let state = WarmStart {
            forces: vec![0.0; n],
            own: vec![0.0; n * nc],
            nodes: vec![0.0; surface.nodes.len() * nc],
            places: vec![SurfacePlace::default(); n],
            is_known: false,
            watch: Watch::new(n, surface.nodes.len()),
        };
        let mut pair = Self {
            points: submodel.points.iter().map(|p| components(motion, p)).collect(),
            low_rows,
            low_columns: (0..n_q).flat_map(|k| low.col_as_slice(k)).copied().collect(),
            n_modes: n_q,
            is_rim,
            springs: vec![0.0; n],
            rim_reach: mean_spacing(&submodel.areas, motion, &submodel.points),
            saved: state.clone(),
            state,
            workspace: Some(workspace(&surface, n, 0)),
            search: Mutex::new(SearchBuffers::new(&surface, n)),
            ground: BodyState::at_rest(0),
            tolerance: evaluation::GAP_TOLERANCE,
            n_passes: 0,
            report: ContactReport::default(),
            areas: submodel.areas,
            interface: submodel.interface,
            settings,
            motion,
            surface,
            zone,
            friction: None,
        };
        pair.set_penalty(settings.penalty)?;
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
        if self.zone.as_ref().is_some_and(PairZone::needs_springs) {
            return Err(ContactError::FrictionSolver);
        }
        let (n, nc) = (self.points.len(), self.motion.n_components());
        let n_modes = [self.n_modes, self.surface.n_modes];
        let n_nodes = self.surface.nodes.len();
        let mut state = PairFriction::new(friction, (n, nc), n_nodes, self.zone.is_some(), n_modes);
        state.stick_slip.set_springs(&self.springs, 1.0 / friction.stiffness_ratio);
        if let Some(zone) = &mut self.zone {
            zone.add_tangents(state.n_t);
        }
        self.workspace = Some(workspace(&self.surface, n, state.n_t));
        self.friction = Some(Box::new(state));
        Ok(self)
    }

    /// Tangential point forces of the last evaluation, one (plane models, axisymmetric ones) or two a point; empty without
    /// friction \[N\].
    pub fn tangential_forces(&self) -> &[f64] {
        self.friction.as_ref().map_or(&[], |f| f.stick_slip.forces())
    }

    /// States of the points in the last evaluation, where they carry force; empty without friction.
    pub fn point_states(&self) -> &[PointState] {
        self.friction.as_ref().map_or(&[], |f| f.stick_slip.states())
    }

    /// Changes the error of gaps, as a share of the deepest penetration, at which projection and deformation count as having
    /// met; 1e-8 unless changed.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Changes the penalty factor [N/m³]; allowed during a run.
    ///
    /// # Errors
    /// [`ContactError::Penalty`] if it is not positive, [`ContactError::ExactConstraint`] if it is infinite and the method
    /// needs springs.
    pub fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        let needs_springs = self.zone.as_ref().map(PairZone::needs_springs);
        penalty::set_springs(penalty, needs_springs, &self.areas, &mut self.springs)?;
        self.settings.penalty = penalty;
        if let Some(zone) = &mut self.zone {
            zone.springs_changed();
        }
        if let Some(friction) = &mut self.friction {
            friction.stick_slip.set_springs(&self.springs, 1.0 / friction.law.stiffness_ratio);
        }
        Ok(())
    }

    /// Forgets the last evaluation and where the points stuck, for a start from another state.
    pub fn forget(&mut self) {
        self.forget_evaluation();
        if let Some(friction) = &mut self.friction {
            friction.forget();
        }
    }

    /// Forgets the last evaluation.
    fn forget_evaluation(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.is_evaluated = false;
            friction.stick_slip.clear_forces();
        }
        self.state.is_known = false;
        self.state.forces.fill(0.0);
        self.state.own.fill(0.0);
        self.state.nodes.fill(0.0);
    }

    /// Penalty factor [N/m³].
    pub fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    /// What the last evaluation found.
    pub fn report(&self) -> &ContactReport {
        &self.report
    }

    /// Point forces along the normals of the last evaluation; a point is in contact if its force is positive \[N\].
    pub fn point_forces(&self) -> &[f64] {
        &self.state.forces
    }

    /// Gaps of the last evaluation, quasistatic displacements included; of points beyond an end of the target the distance
    /// from it; of points that are open for certain as found at an earlier evaluation \[m\].
    pub fn gaps(&self) -> &[f64] {
        &self.state.watch.gaps
    }

    /// Solutions that the last evaluation took until projection and deformation met.
    pub fn n_passes(&self) -> usize {
        self.n_passes
    }

    /// Places of the points' projections on the target in the last evaluation.
    pub fn places(&self) -> &[SurfacePlace] {
        &self.state.places
    }

    /// Tributary areas of the points \[m²\].
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The target.
    pub fn surface(&self) -> &TargetSurface {
        &self.surface
    }

    /// Normal compliance `A` of both bodies together at the projections of the motion `bodies` (Eq. C.39), `n_points`
    /// squared [m/N]; none when all modes are dynamic. Forgets the last evaluation.
    ///
    /// # Errors
    /// [`EvaluationFailure`] if the points cannot be projected.
    pub fn normal_compliance(
        &mut self,
        bodies: &[BodyState],
    ) -> Result<Option<&Mat<f64>>, EvaluationFailure> {
        self.forget_evaluation();
        self.project_for_compliance(bodies)?;
        Ok(self.zone.as_ref().map(PairZone::normal_compliance))
    }

    /// `max_i(A_ii w_i)`, from which a penalty factor follows (Eq. C.4) [m³/N]; none when all modes are dynamic. Forgets the
    /// last evaluation.
    ///
    /// # Errors
    /// As [`SurfacePair::normal_compliance`].
    pub fn largest_compliance_weight(
        &mut self,
        bodies: &[BodyState],
    ) -> Result<Option<f64>, EvaluationFailure> {
        let areas = self.areas.clone();
        let compliance = self.normal_compliance(bodies)?;
        Ok(compliance.map(|a| areas.iter().enumerate().map(|(i, w)| a[(i, i)] * w).fold(0.0, f64::max)))
    }

    /// Replaces `out` by the forces of the last evaluation on the interface freedoms of body `body`, `f_b = ±N_bᵀ λ`
    /// (Eq. C.19) \[N\], for the recovery of stresses; zero for a body that is not part of the pair.
    ///
    /// # Panics
    /// If `out` is not as long as the body's interface.
    pub fn interface_force(&self, body: usize, out: &mut [f64]) {
        out.fill(0.0);
        let Some(w) = &self.workspace else { return };
        if body == self.settings.contact_body && self.interface.n_rows() > 0 {
            assert_eq!(out.len(), self.interface.n_columns(), "number of interface freedoms");
            for (row, &load) in w.loads.iter().enumerate().filter(|(_, load)| **load != 0.0) {
                self.interface.row(row).iter().for_each(|&(b, value)| out[b] += value * load);
            }
        } else if Some(body) == self.settings.target_body {
            assert_eq!(out.len(), w.interface_loads.len(), "number of interface freedoms");
            out.copy_from_slice(&w.interface_loads);
        }
    }

    fn own_row(&self, row: usize) -> &[f64] {
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

/// A point in space in the model's components.
fn components(motion: RigidMotion, point: &[f64; 3]) -> [f64; 3] {
    let mut out = [0.0; 3];
    (0..motion.n_components()).for_each(|c| out[c] = point[motion.direction(c)]);
    out
}

/// Typical distance of neighbouring points \[m\].
fn mean_spacing(areas: &[f64], motion: RigidMotion, points: &[[f64; 3]]) -> f64 {
    let n = points.len() as f64;
    let all: Vec<[f64; 3]> = points.iter().map(|p| components(motion, p)).collect();
    if motion == RigidMotion::Spatial {
        (areas.iter().sum::<f64>() / n).sqrt()
    } else {
        target::diagonal(&all) / n
    }
}

fn workspace(surface: &TargetSurface, n: usize, n_t: usize) -> Workspace {
    let nc = surface.motion.n_components();
    let n_nodes = surface.nodes.len();
    Workspace {
        functions: Functions::new(surface),
        samples: Samples::new(surface),
        low_points: vec![[0.0; 3]; n],
        points: vec![[0.0; 3]; n],
        low_nodes: vec![[0.0; 3]; n_nodes],
        nodes: vec![[0.0; 3]; n_nodes],
        seen: vec![[0.0; 3]; n],
        is_wanted: vec![true; n],
        projections: vec![Projection::default(); n],
        rows: Rows::new(n, surface.n_functions, n_t),
        loaded: Rows::new(n, surface.n_functions, n_t),
        free_gaps: vec![0.0; n],
        settled: vec![0.0; n],
        loads: vec![0.0; n * nc],
        node_loads: vec![0.0; n_nodes * nc],
        interface_loads: vec![0.0; surface.n_interface()],
        interface_displacements: vec![0.0; surface.n_interface()],
    }
}

impl SurfacePair {
    /// Forces at the motions `own` and `target`, summed up, with the power lost to sliding.
    fn evaluate(&mut self, t: f64, own: &BodyState, target: &BodyState) -> Result<(), EvaluationFailure> {
        // Rates come from a look back, best taken first; the last evaluation tells whether there is something to see.
        let was_touching = self.friction.is_some() && self.state.forces.iter().any(|f| *f > 0.0);
        let mut time = if was_touching { self.look_back(t, own, target)? } else { None };
        let mut solver = self.find_forces(t, own, target)?;
        self.sum_up(solver, target);
        if self.report.n_sliding > 0 && !was_touching {
            time = self.look_back(t, own, target)?;
            solver = self.find_forces(t, own, target)?;
            self.sum_up(solver, target);
        }
        if let Some(friction) = &mut self.friction {
            friction.is_evaluated = true;
            friction.time = t;
            if self.report.n_sliding > 0 {
                let work = friction.sliding_work(&self.state.forces, time);
                work.enter(&mut self.report.energies);
            }
        }
        Ok(())
    }
}

impl ForceElement for SurfacePair {
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        debug_assert_eq!(bodies[self.settings.contact_body].elastic.len(), self.n_modes);
        let ground = BodyState::at_rest(0);
        let own = &bodies[self.settings.contact_body];
        let target = self.settings.target_body.map_or(&ground, |b| &bodies[b]);
        let found = self.evaluate(t, own, target);
        if found.is_err() {
            // Nothing of a failed evaluation may lead the next one.
            self.forget_evaluation();
        }
        found?;
        if self.report.n_active > 0 {
            self.push(bodies, forces);
        }
        Ok(())
    }

    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.state.is_known && self.report.n_active == 0
    }

    fn save(&mut self) {
        self.saved.copy_from(&self.state);
        if let Some(zone) = &mut self.zone {
            zone.save();
        }
        if let Some(friction) = &mut self.friction {
            if let (true, Some(w)) = (friction.is_evaluated, &self.workspace) {
                friction.commit(&self.state.forces, &w.nodes, &w.rows, &w.projections, &w.is_wanted);
            }
            friction.save();
        }
    }

    fn restore(&mut self) {
        self.state.copy_from(&self.saved);
        if let Some(zone) = &mut self.zone {
            zone.restore(&self.surface, self.friction.as_mut().map(|f| &mut f.stick_slip));
        }
        if let Some(friction) = &mut self.friction {
            friction.restore();
        }
    }
}

impl ContactElement for SurfacePair {
    fn kind(&self) -> &'static str {
        "surface-surface"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.settings.contact_body, self.settings.target_body)
    }

    fn smallest_gap(&self, bodies: &[BodyState]) -> f64 {
        let mut buffers = self.search.lock().unwrap_or_else(PoisonError::into_inner);
        self.nearest(bodies, &mut buffers).map_or(f64::NAN, |found| found.gap)
    }

    fn normal(&self, bodies: &[BodyState]) -> Vector3<f64> {
        let mut buffers = self.search.lock().unwrap_or_else(PoisonError::into_inner);
        let (_, target) = self.states(bodies);
        self.nearest(bodies, &mut buffers).map_or(Vector3::repeat(f64::NAN), |found| {
            motion::direction(self.motion, &target.rotation, &found.normal)
        })
    }

    fn place(&self, bodies: &[BodyState]) -> Vector3<f64> {
        let mut buffers = self.search.lock().unwrap_or_else(PoisonError::into_inner);
        let (own, _) = self.states(bodies);
        self.nearest(bodies, &mut buffers).map_or(Vector3::repeat(f64::NAN), |found| {
            own.position + own.rotation * Vector3::from(in_space(self.motion, found.place))
        })
    }

    fn report(&self) -> &ContactReport {
        &self.report
    }

    fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    fn point_forces(&self) -> &[f64] {
        Self::point_forces(self)
    }

    fn point(&self, i: usize) -> Option<([f64; 3], f64)> {
        Some((in_space(self.motion, *self.points.get(i)?), self.areas[i]))
    }

    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        Self::set_penalty(self, penalty)
    }

    fn compliance_weight(&mut self, bodies: &[BodyState]) -> Result<Option<f64>, EvaluationFailure> {
        self.largest_compliance_weight(bodies)
    }

    fn forget(&mut self) {
        Self::forget(self);
    }

    fn interface_force(&self, body: usize, out: &mut [f64]) {
        Self::interface_force(self, body, out);
    }

    fn n_points(&self) -> usize {
        self.points.len()
    }
}
