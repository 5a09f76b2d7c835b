//! Contact of one body with a rigid plane, as a force element.
//!
//! A point's gap is `g_i = (r + R(X_i + Φ_i q) - p)·n` (docs/theory.md Eq. C.1). With a quasistatic
//! compliance the point forces are the solution of the convex problem of [`crate::quasistatic`];
//! without one (all modes dynamic) they follow from the penalty law. Both derive from a potential,
//! and resultant, torque and modal forces are its exact gradient (Eqs. C.16-C.18): the lever arm
//! carries the whole displacement, the quasistatic one included.
//!
//! In axisymmetric models a point is a ring: its force acts along the axis, radial parts and
//! moments cancel.

use crate::solver_fault::SolverFault;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::{BodyState, Findings, ForceElement, ForceEnergies, GeneralisedForce, Motion};
use iga_core::nurbs::jet::diagonal;
use nalgebra::{UnitQuaternion, Vector3};

use crate::ContactError;
pub use crate::contact_element::ContactReport;
use crate::contact_element::{Contact, ContactElement, Meeting, Plane};
use crate::law::{Friction, penalty};
use crate::quasistatic::compliance::ZoneCompliance;
use crate::quasistatic::{Method, PointState, Quasistatic, ZoneSolver};
use crate::zone::submodel::ContactSubmodel;

mod friction;
mod evaluation;

use friction::PlaneFriction;

/// Largest part of the plane's normal across the directions that an axisymmetric or plane model can
/// move in.
const NORMAL_TOLERANCE: f64 = 1e-9;

/// What a plane contact consists of besides the body's submodel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneContactSettings {
    /// Index of the body in the lists given to [`ForceElement::evaluate`].
    pub body: usize,
    /// The plane.
    pub plane: Plane,
    /// Penalty factor; infinite for the exact constraint [N/m³].
    pub penalty: f64,
    /// Solver of the quasistatic problem; without effect when all modes are dynamic.
    pub method: Method,
}

/// Contact of a body with a rigid plane.
pub struct PlaneContact {
    settings: PlaneContactSettings,
    submodel: ContactSubmodel,
    /// Rows of `submodel.low`, one after the other.
    low_rows: Vec<f64>,
    quasistatic: Option<Quasistatic>,
    friction: Option<Friction>,
    springs: Vec<f64>,
    is_rim: Vec<bool>,
    /// Diagonal of the box around the points \[m\].
    size: f64,
}

/// State of a plane contact: starts of the solvers, references of the points.
pub struct PlaneState {
    zone: Option<ZoneSolver>,
    friction: Option<Box<PlaneFriction>>,
}

/// Buffers of a plane contact.
pub struct PlaneWorkspace {
    /// Compliances of the springs, of points on springs alone by the area that the plane sees.
    springs: Vec<f64>,
    /// Gaps without quasistatic displacement.
    free_gaps: Vec<f64>,
    /// Points whose compliance the forces are found with, and the gaps with which these are.
    is_member: Vec<bool>,
    pressed_gaps: Vec<f64>,
    /// Rates of the loads by the turn of the body alone, and of the displacements by these.
    load_rates: Vec<f64>,
    displacement_rates: Vec<f64>,
    buffers: [Vec<f64>; 2],
    /// Rates of the points along the normal and the tangents without those of the forces; of the forces.
    gap_rates: Vec<f64>,
    slip_rates: Vec<f64>,
    rates: [Vec<f64>; 2],
}

/// What an evaluation of a plane contact finds.
pub struct PlaneFound {
    /// Normal in the model's components.
    normal: [f64; 3],
    gaps: Vec<f64>,
    forces: Vec<f64>,
    displacements: Vec<f64>,
    /// Point forces in the model's components.
    loads: Vec<f64>,
    /// Its product with the plane's normal is the moment by which faces are turned towards the plane, in the body's axes (Eq. C.111) \[N m\].
    couple: Vector3<f64>,
    report: ContactReport,
}

impl PlaneState {
    /// Tangential point forces of the last evaluation, one (plane models, axisymmetric ones) or two
    /// per point; empty without friction \[N\].
    pub fn tangential_forces(&self) -> &[f64] {
        self.friction.as_ref().map_or(&[], |f| f.stick_slip.forces())
    }

    /// States of the points in the last evaluation; empty without friction.
    pub fn point_states(&self) -> &[PointState] {
        self.friction.as_ref().map_or(&[], |f| f.stick_slip.states())
    }

    /// Solver of the quasistatic zone, none when all modes are dynamic. Its projection belongs to
    /// the last evaluation in contact.
    pub fn zone(&self) -> Option<&ZoneSolver> {
        self.zone.as_ref()
    }
}

impl PlaneFound {
    /// Gaps, quasistatic displacement included \[m\].
    pub fn gaps(&self) -> &[f64] {
        &self.gaps
    }
}

impl Findings for PlaneFound {
    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.report.n_active == 0
    }
}

impl PlaneContact {
    /// Contact of the body with submodel `submodel`.
    ///
    /// # Errors
    /// [`ContactError`] if the submodel does not fit, the penalty factor is not positive, or it is infinite where springs
    /// are needed.
    pub fn new(mut submodel: ContactSubmodel, settings: PlaneContactSettings) -> Result<Self, ContactError> {
        submodel.validate()?;
        let quasistatic = if submodel.is_quasistatic() {
            let compliance = std::mem::replace(&mut submodel.compliance, ZoneCompliance::none());
            let (yielding, n) = ((compliance, &submodel.interface), submodel.n_points());
            Some(Quasistatic::of_points(settings.method, submodel.motion, yielding, n)?)
        } else {
            None
        };
        let springs = vec![0.0; submodel.n_points()];
        let (low_rows, is_rim) = (submodel.low_rows(), submodel.is_rim());
        let size = diagonal(&submodel.points);
        let mut contact =
            Self { settings, submodel, low_rows, quasistatic, friction: None, springs, is_rim, size };
        contact.set_springs(settings.penalty)?;
        Ok(contact)
    }

    /// Sets penalty factor and springs.
    fn set_springs(&mut self, penalty: f64) -> Result<(), ContactError> {
        let needs_springs = self.quasistatic.as_ref().map(Quasistatic::needs_springs);
        let of_points = (self.submodel.areas.as_slice(), self.submodel.left_out.as_slice());
        penalty::set_springs(penalty, needs_springs, of_points, &mut self.springs)?;
        self.settings.penalty = penalty;
        Ok(())
    }

    /// Adds friction.
    ///
    /// # Errors
    /// [`ContactError::Friction`] if its values make no law, [`ContactError::FrictionSolver`] with Algorithm 1.
    pub fn with_friction(mut self, friction: Friction) -> Result<Self, ContactError> {
        friction.check()?;
        if self.quasistatic.as_ref().is_some_and(Quasistatic::needs_springs) {
            return Err(ContactError::FrictionSolver);
        }
        self.friction = Some(friction);
        Ok(self)
    }

    /// Penalty factor [N/m³].
    pub fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    /// The body's contact data.
    pub fn submodel(&self) -> &ContactSubmodel {
        &self.submodel
    }

    /// Checks that a body with rotation `rotation` can meet the plane.
    ///
    /// # Errors
    /// [`ContactError::Normal`] if the normal does not lie along an axisymmetric body's axis or in a plane body's plane.
    pub fn check_alignment(&self, rotation: &UnitQuaternion<f64>) -> Result<(), ContactError> {
        self.normal_components(rotation).map(|_| ())
    }

    /// Projects the compliance for a body with rotation `rotation` and returns the normal
    /// compliance of the points, `n_points × n_points` [m/N]; none when all modes are dynamic.
    ///
    /// # Errors
    /// As [`PlaneContact::check_alignment`].
    pub fn normal_compliance<'a>(
        &self,
        rotation: &UnitQuaternion<f64>,
        state: &'a mut PlaneState,
    ) -> Result<Option<&'a faer::Mat<f64>>, ContactError> {
        let normal = self.normal_components(rotation)?;
        let zone = self.quasistatic.as_ref().zip(state.zone.as_mut());
        Ok(zone.map(|(zone, solver)| {
            solver.project(zone, normal);
            solver.normal_compliance()
        }))
    }

    /// Smallest gap of all points at `state` without quasistatic displacement \[m\]: zero where
    /// contact begins or ends. NaN if a gap is not a number.
    pub fn smallest_gap_at(&self, state: &BodyState) -> f64 {
        self.nearest(state).map_or(f64::NAN, |(_, gap)| gap)
    }

    /// The point of the smallest gap at `state`, and the gap; none if a gap is not a number.
    fn nearest(&self, state: &BodyState) -> Option<(usize, f64)> {
        let normal = self.normal_components(&state.rotation).ok()?;
        let offset = self.offset(state);
        let mut smallest = (0, f64::INFINITY);
        for i in 0..self.submodel.n_points() {
            let gap = self.gap(i, offset, &normal, &state.elastic);
            // min() would hide a NaN
            if gap.is_nan() {
                return None;
            }
            if gap < smallest.1 {
                smallest = (i, gap);
            }
        }
        Some(smallest)
    }
}

impl ForceElement for PlaneContact {
    type State = PlaneState;
    type Workspace = PlaneWorkspace;
    type Found = PlaneFound;

    fn start(&self) -> (PlaneState, PlaneWorkspace, PlaneFound) {
        let (n, n_rows) = (self.submodel.n_points(), self.submodel.low.nrows());
        let normal = self.settings.plane.normal.into_inner();
        let friction = self.friction.map(|law| {
            let (motion, is_quasistatic) = (self.submodel.motion, self.quasistatic.is_some());
            let mut state = PlaneFriction::new(law, motion, n, &normal, is_quasistatic);
            state.stick_slip.set_springs(&self.springs);
            Box::new(state)
        });
        let state = PlaneState { zone: self.quasistatic.as_ref().map(Quasistatic::solver), friction };
        let workspace = PlaneWorkspace {
            springs: self.springs.clone(),
            free_gaps: vec![0.0; n],
            is_member: vec![true; n],
            pressed_gaps: vec![0.0; n],
            load_rates: vec![0.0; n_rows],
            displacement_rates: vec![0.0; n_rows],
            buffers: self.quasistatic.as_ref().map_or_else(Default::default, Quasistatic::buffers),
            gap_rates: vec![0.0; n],
            slip_rates: vec![0.0; n_rows - n],
            rates: [vec![0.0; n], vec![0.0; n_rows - n]],
        };
        let found = PlaneFound {
            normal: [0.0; 3],
            gaps: vec![0.0; n],
            forces: vec![0.0; n],
            displacements: vec![0.0; n_rows],
            loads: vec![0.0; n_rows],
            couple: Vector3::zeros(),
            report: ContactReport::default(),
        };
        (state, workspace, found)
    }

    fn evaluate(
        &self,
        motion: Motion<'_>,
        state: &mut PlaneState,
        workspace: &mut PlaneWorkspace,
        found: &mut PlaneFound,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let body = &motion.bodies[self.settings.body];
        debug_assert_eq!(body.elastic.len(), self.submodel.low.ncols());
        self.locate(motion.time, body, state, workspace, found)?;
        let solver = self.solve(state, workspace, found)?;
        self.sum_up(solver, state, workspace, found);
        if let Some(friction) = &mut state.friction {
            friction.note();
        }
        if found.report.n_active == 0 {
            return Ok(());
        }
        self.sliding_work(body, state, workspace, found)?.enter(&mut found.report.energies);
        let sum = found.report.force;
        let force = &mut forces[self.settings.body];
        self.push((&body.elastic, sum), &found.loads, found, force);
        if self.submodel.motion != RigidMotion::Axial {
            let normal = body.rotation.inverse_transform_vector(&self.settings.plane.normal);
            force.torque_in_body += found.couple.cross(&normal);
        }
        Ok(())
    }

    fn rates(
        &self,
        (motion, by_velocity): (Motion<'_>, bool),
        state: &mut PlaneState,
        workspace: &mut PlaneWorkspace,
        found: &PlaneFound,
        rates: &mut [GeneralisedForce],
    ) -> bool {
        let body = &motion.bodies[self.settings.body];
        let is_zero = by_velocity || found.report.n_active == 0 || body.is_at_rest();
        is_zero || self.add_force_rates(body, state, workspace, found, &mut rates[self.settings.body])
    }

    fn save(&self, state: &mut PlaneState, _found: &PlaneFound) {
        if let Some(zone) = &mut state.zone {
            zone.save();
        }
        if let Some(friction) = &mut state.friction {
            friction.save();
        }
    }

    fn restore(&self, state: &mut PlaneState, _found: &mut PlaneFound) {
        if let (Some(model), Some(zone)) = (&self.quasistatic, &mut state.zone) {
            zone.restore(model);
        }
        if let Some(friction) = &mut state.friction {
            friction.restore();
        }
    }
}

impl Contact for PlaneContact {
    fn kind(&self) -> &'static str {
        "plane"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.settings.body, None)
    }

    fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    fn n_points(&self) -> usize {
        self.submodel.n_points()
    }

    fn point(&self, i: usize) -> Option<([f64; 3], f64)> {
        Some((*self.submodel.points.get(i)?, self.submodel.areas[i]))
    }
}

impl ContactElement for PlaneContact {
    fn report<'a>(&self, found: &'a PlaneFound) -> &'a ContactReport {
        &found.report
    }

    fn meeting(&self, motion: Motion<'_>, _: &PlaneState, _: &mut PlaneWorkspace) -> Meeting {
        let (body, normal) = (&motion.bodies[self.settings.body], self.settings.plane.normal.into_inner());
        let place = |i: usize| body.position + body.rotation * self.local_place(i, &body.elastic);
        let nearest = self.nearest(body).map(|(i, gap)| Meeting { gap, normal, place: place(i) });
        nearest.unwrap_or(Meeting { normal, ..Meeting::UNKNOWN })
    }

    fn point_forces<'a>(&self, _: &'a PlaneState, found: &'a PlaneFound) -> Option<&'a [f64]> {
        Some(&found.forces)
    }

    fn friction_forces(&self, state: &PlaneState, _: &PlaneFound) -> Vec<Vector3<f64>> {
        state.friction.as_ref().map_or_else(Vec::new, |friction| friction.vectors())
    }

    fn prescribe_friction(&self, wanted: Option<&[Vector3<f64>]>, state: &mut PlaneState, _: &PlaneFound) {
        if let Some(friction) = &mut state.friction {
            friction.prescribe(wanted);
        }
    }

    fn set_penalty(&mut self, penalty: f64, state: &mut PlaneState) -> Result<(), ContactError> {
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
        state: &mut PlaneState,
        _: &mut PlaneWorkspace,
        _: &mut PlaneFound,
    ) -> Result<Option<f64>, EvaluationFailure> {
        let body = &motion.bodies[self.settings.body];
        let normal = self.normal_components(&body.rotation).map_err(SolverFault::Alignment)?;
        let compliance = self.normal_compliance(&body.rotation, state).map_err(SolverFault::Alignment)?;
        let gap = |i: usize| self.gap(i, self.offset(body), &normal, &body.elastic);
        Ok(compliance.map(|a| penalty::compliance_weight(a, &self.submodel.areas, gap, reach)))
    }

    /// Forces on the interface unknowns, `f_b = N_bᵀ (n λ + t τ)` (Eq. C.19), for the recovery of
    /// stresses.
    ///
    /// # Panics
    /// If `out` is not as long as the interface.
    fn interface_force(&self, body: usize, found: &PlaneFound, out: &mut [f64]) -> bool {
        let rows = &self.submodel.interface;
        if body != self.settings.body || rows.n_rows() == 0 {
            return false;
        }
        assert_eq!(out.len(), rows.n_columns(), "number of interface degrees of freedom");
        rows.spread(&found.loads, out);
        true
    }
}
