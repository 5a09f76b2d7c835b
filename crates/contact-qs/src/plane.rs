//! Contact of one body with a rigid plane, as a force element.
//!
//! A point's gap is `g_i = (r + R(X_i + Φ_i q) - p)·n` (docs/theory.md Eq. C.1). With a quasistatic compliance the point
//! forces are the solution of the convex problem of [`crate::quasistatic`]; without one (all modes dynamic) they follow
//! from the penalty law. Both derive from a potential, and resultant, torque and modal forces are its exact gradient
//! (Eqs. C.16-C.18): the lever arm carries the whole displacement, the quasistatic one included.
//!
//! In axisymmetric models a point is a ring: its force acts along the axis, radial parts and moments cancel.

use ffr_dynamics::data_error::DataError;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
use nalgebra::{Unit, UnitQuaternion, Vector3};

use crate::ContactError;
use crate::contact_element::ContactElement;
pub use crate::contact_element::ContactReport;
use crate::law::{Friction, penalty};
use crate::quasistatic::{Method, PointState, Quasistatic};
use crate::submodel::ContactSubmodel;

mod evaluation;
mod friction;

use friction::PlaneFriction;

/// Largest part of the plane's normal across the directions that an axisymmetric or plane model can move in.
const NORMAL_TOLERANCE: f64 = 1e-9;

/// A fixed rigid plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// A point of the plane in the inertial frame \[m\].
    pub point: Vector3<f64>,
    /// Normal in the inertial frame, towards the body.
    pub normal: Unit<Vector3<f64>>,
}

/// What a plane contact consists of besides the body's submodel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneContactSettings {
    /// Index of the body in the lists given to [`ForceElement::apply`].
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
    springs: Vec<f64>,
    is_rim: Vec<bool>,
    /// Gaps without quasistatic displacement.
    free_gaps: Vec<f64>,
    gaps: Vec<f64>,
    forces: Vec<f64>,
    displacements: Vec<f64>,
    /// Point forces of the last evaluation in the model's components.
    loads: Vec<f64>,
    /// Their rates by the turn of the body alone.
    load_rates: Vec<f64>,
    /// Rates of the points along the normal and the tangents without those of the forces.
    gap_rates: Vec<f64>,
    slip_rates: Vec<f64>,
    /// Normal of the last evaluation in the model's components.
    normal: [f64; 3],
    friction: Option<Box<PlaneFriction>>,
    report: ContactReport,
}

impl PlaneContact {
    /// Contact of the body with submodel `submodel`.
    ///
    /// # Errors
    /// [`ContactError`] if the submodel does not fit, the penalty factor is not positive, or it is infinite where springs
    /// are needed.
    pub fn new(submodel: ContactSubmodel, settings: PlaneContactSettings) -> Result<Self, ContactError> {
        submodel.validate()?;
        let quasistatic = if submodel.is_quasistatic() {
            Some(Quasistatic::new(settings.method, submodel.motion, submodel.compliance.clone())?)
        } else {
            None
        };
        Self::assemble(submodel, settings, quasistatic)
    }

    /// Contact with a quasistatic zone of its own making, such as one from Craig-Bampton modes
    /// ([`Quasistatic::with_modes`]).
    ///
    /// # Errors
    /// As [`PlaneContact::new`].
    pub fn with_zone(
        submodel: ContactSubmodel,
        settings: PlaneContactSettings,
        zone: Quasistatic,
    ) -> Result<Self, ContactError> {
        submodel.validate()?;
        if zone.n_points() != submodel.n_points() {
            let (what, found) = ("points of the quasistatic zone".into(), zone.n_points());
            return Err(DataError::Count { what, found, expected: submodel.n_points() }.into());
        }
        Self::assemble(submodel, settings, Some(zone))
    }

    fn assemble(
        submodel: ContactSubmodel,
        settings: PlaneContactSettings,
        quasistatic: Option<Quasistatic>,
    ) -> Result<Self, ContactError> {
        let n = submodel.n_points();
        let n_rows = submodel.low.nrows();
        let mut contact = Self {
            low_rows: submodel.low_rows(),
            springs: vec![0.0; n],
            is_rim: submodel.is_rim(),
            free_gaps: vec![0.0; n],
            gaps: vec![0.0; n],
            forces: vec![0.0; n],
            displacements: vec![0.0; n_rows],
            loads: vec![0.0; n_rows],
            load_rates: vec![0.0; n_rows],
            gap_rates: vec![0.0; n],
            slip_rates: vec![0.0; n_rows - n],
            normal: [0.0; 3],
            friction: None,
            report: ContactReport::default(),
            quasistatic,
            settings,
            submodel,
        };
        contact.set_penalty(settings.penalty)?;
        Ok(contact)
    }

    /// Changes the penalty factor [N/m³]; allowed during a run.
    ///
    /// # Errors
    /// [`ContactError::Penalty`] if it is not positive, [`ContactError::ExactConstraint`] if it is infinite and the method
    /// needs springs.
    pub fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        let needs_springs = self.quasistatic.as_ref().map(Quasistatic::needs_springs);
        penalty::set_springs(penalty, needs_springs, &self.submodel.areas, &mut self.springs)?;
        self.settings.penalty = penalty;
        if let Some(zone) = &mut self.quasistatic {
            zone.springs_changed();
        }
        if let Some(friction) = &mut self.friction {
            friction.stick_slip.set_springs(&self.springs, 1.0 / friction.law.stiffness_ratio);
        }
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
        let normal = self.settings.plane.normal.into_inner();
        let (motion, n_points) = (self.submodel.motion, self.submodel.n_points());
        let is_quasistatic = self.quasistatic.is_some();
        let mut state = PlaneFriction::new(friction, motion, n_points, &normal, is_quasistatic);
        state.stick_slip.set_springs(&self.springs, 1.0 / friction.stiffness_ratio);
        self.friction = Some(Box::new(state));
        Ok(self)
    }

    /// Forgets where the points stuck, for a start from another state; without effect when there is no friction.
    pub fn forget_slip(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.forget();
        }
    }

    /// Tangential point forces of the last evaluation, one (plane models, axisymmetric ones) or two a point; empty without
    /// friction \[N\].
    pub fn tangential_forces(&self) -> &[f64] {
        self.friction.as_ref().map_or(&[], |f| f.stick_slip.forces())
    }

    /// States of the points in the last evaluation; empty without friction.
    pub fn point_states(&self) -> &[PointState] {
        self.friction.as_ref().map_or(&[], |f| f.stick_slip.states())
    }

    /// Penalty factor [N/m³].
    pub fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    /// The body's contact data.
    pub fn submodel(&self) -> &ContactSubmodel {
        &self.submodel
    }

    /// Quasistatic zone, none when all modes are dynamic. Its projection belongs to the last evaluation in contact.
    pub fn zone(&self) -> Option<&Quasistatic> {
        self.quasistatic.as_ref()
    }

    /// What the last evaluation found.
    pub fn report(&self) -> &ContactReport {
        &self.report
    }

    /// Point forces along the normal of the last evaluation \[N\].
    pub fn point_forces(&self) -> &[f64] {
        &self.forces
    }

    /// Gaps of the last evaluation, quasistatic displacement included \[m\].
    pub fn gaps(&self) -> &[f64] {
        &self.gaps
    }

    /// Checks that a body with rotation `rotation` can meet the plane.
    ///
    /// # Errors
    /// [`ContactError::Normal`] if the normal does not lie along an axisymmetric body's axis or in a plane body's plane.
    pub fn check_alignment(&self, rotation: &UnitQuaternion<f64>) -> Result<(), ContactError> {
        self.normal_components(rotation).map(|_| ())
    }

    /// Projects the compliance for a body with rotation `rotation` and returns the normal compliance of the points,
    /// `n_points × n_points` [m/N]; none when all modes are dynamic.
    ///
    /// # Errors
    /// As [`PlaneContact::check_alignment`].
    pub fn normal_compliance(
        &mut self,
        rotation: &UnitQuaternion<f64>,
    ) -> Result<Option<&faer::Mat<f64>>, ContactError> {
        let normal = self.normal_components(rotation)?;
        Ok(self.quasistatic.as_mut().map(|zone| {
            zone.project(normal);
            zone.normal_compliance()
        }))
    }

    /// Smallest gap of all points at `state` without quasistatic displacement \[m\]: zero where contact begins or ends. The
    /// solver is neither run nor changed. NaN if a gap is not a number.
    pub fn smallest_gap(&self, state: &BodyState) -> f64 {
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

    /// Replaces `out` by the forces of the last evaluation on the interface freedoms, `f_b = N_bᵀ (n λ + t τ)` (Eq. C.19) \[N\], for
    /// the recovery of stresses.
    ///
    /// # Panics
    /// If `out` is not as long as the interface.
    pub fn interface_force(&self, out: &mut [f64]) {
        let rows = &self.submodel.interface;
        assert_eq!(out.len(), rows.n_columns(), "number of interface freedoms");
        out.fill(0.0);
        if rows.n_rows() == 0 {
            return;
        }
        for (row, &load) in self.loads.iter().enumerate().filter(|(_, load)| **load != 0.0) {
            for &(b, value) in rows.row(row) {
                out[b] += value * load;
            }
        }
    }
}

impl ForceElement for PlaneContact {
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let state = &bodies[self.settings.body];
        debug_assert_eq!(state.elastic.len(), self.submodel.low.ncols());
        self.locate(t, state)?;
        let solver = self.solve()?;
        self.load_points();
        self.sum_up(solver);
        if let Some(friction) = &mut self.friction {
            friction.note();
        }
        if self.report.n_active == 0 {
            return Ok(());
        }
        self.sliding_work(state)?.enter(&mut self.report.energies);
        self.push(&state.elastic, &mut forces[self.settings.body]);
        Ok(())
    }

    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.report.n_active == 0
    }

    fn save(&mut self) {
        if let Some(zone) = &mut self.quasistatic {
            zone.save();
        }
        if let Some(friction) = &mut self.friction {
            friction.save();
        }
    }

    fn restore(&mut self) {
        if let Some(zone) = &mut self.quasistatic {
            zone.restore();
        }
        if let Some(friction) = &mut self.friction {
            friction.restore();
        }
    }
}

impl ContactElement for PlaneContact {
    fn kind(&self) -> &'static str {
        "plane"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.settings.body, None)
    }

    fn smallest_gap(&self, bodies: &[BodyState]) -> f64 {
        Self::smallest_gap(self, &bodies[self.settings.body])
    }

    fn normal(&self, _bodies: &[BodyState]) -> Vector3<f64> {
        self.settings.plane.normal.into_inner()
    }

    fn place(&self, bodies: &[BodyState]) -> Vector3<f64> {
        let state = &bodies[self.settings.body];
        self.nearest(state).map_or(Vector3::repeat(f64::NAN), |(i, _)| {
            state.position + state.rotation * self.local_place(i, &state.elastic)
        })
    }

    fn report(&self) -> &ContactReport {
        &self.report
    }

    fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    fn n_points(&self) -> usize {
        self.submodel.n_points()
    }

    fn check_orientation(&self, rotation: &UnitQuaternion<f64>) -> Result<(), ContactError> {
        self.check_alignment(rotation)
    }

    fn point_forces(&self) -> &[f64] {
        Self::point_forces(self)
    }

    fn point(&self, i: usize) -> Option<([f64; 3], f64)> {
        Some((*self.submodel.points.get(i)?, self.submodel.areas[i]))
    }

    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        Self::set_penalty(self, penalty)
    }

    fn compliance_weight(&mut self, bodies: &[BodyState]) -> Result<Option<f64>, EvaluationFailure> {
        let rotation = bodies[self.settings.body].rotation;
        let areas = self.submodel.areas.clone();
        let compliance =
            self.normal_compliance(&rotation).map_err(|e| EvaluationFailure::out_of_model(e.to_string()))?;
        Ok(compliance.map(|a| areas.iter().enumerate().map(|(i, w)| a[(i, i)] * w).fold(0.0, f64::max)))
    }

    fn forget(&mut self) {
        self.forget_slip();
    }

    fn interface_force(&self, body: usize, out: &mut [f64]) {
        if body == self.settings.body {
            Self::interface_force(self, out);
        } else {
            out.fill(0.0);
        }
    }
}
