//! Contact of one body with a rigid plane, as a force element.
//!
//! A point's gap is `g_i = (r + R(X_i + Φ_i q) - p)·n` (docs/theory.md Eq. C.1). With a quasistatic compliance the point
//! forces are the solution of the convex problem of [`crate::quasistatic`]; without one (all modes dynamic) they follow
//! from the penalty law. Both derive from a potential, and resultant, torque and modal forces are its exact gradient
//! (Eqs. C.16-C.18): the lever arm carries the whole displacement, the quasistatic one included.
//!
//! In axisymmetric models a point is a ring: its force acts along the axis, radial parts and moments cancel.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::Rejection;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
use nalgebra::{Unit, UnitQuaternion, Vector3};

use crate::ContactError;
use crate::contact_element::ContactElement;
pub use crate::contact_element::ContactReport;
use crate::law::penalty;
use crate::quasistatic::{Method, Problem, Quasistatic, SolveReport};
use crate::submodel::ContactSubmodel;

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
    /// Normal of the last evaluation in the model's components.
    normal: [f64; 3],
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
            return Err(ContactError::Inconsistent {
                reason: format!(
                    "the quasistatic zone has {} points, the submodel {}",
                    zone.n_points(),
                    submodel.n_points()
                ),
            });
        }
        Self::assemble(submodel, settings, Some(zone))
    }

    fn assemble(
        submodel: ContactSubmodel,
        settings: PlaneContactSettings,
        quasistatic: Option<Quasistatic>,
    ) -> Result<Self, ContactError> {
        let n = submodel.n_points();
        let (n_rows, n_q) = (submodel.low.nrows(), submodel.low.ncols());
        let mut is_rim = vec![false; n];
        submodel.rim.iter().for_each(|&i| is_rim[i] = true);
        let mut contact = Self {
            low_rows: (0..n_rows * n_q).map(|k| submodel.low[(k / n_q, k % n_q)]).collect(),
            springs: vec![0.0; n],
            is_rim,
            free_gaps: vec![0.0; n],
            gaps: vec![0.0; n],
            forces: vec![0.0; n],
            displacements: vec![0.0; n_rows],
            normal: [0.0; 3],
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
        penalty::check(penalty)?;
        let method = match &self.quasistatic {
            None => Some("contact with all modes dynamic"),
            Some(zone) if zone.needs_springs() => Some("Algorithm 1"),
            Some(_) => None,
        };
        if let (true, Some(method)) = (penalty.is_infinite(), method) {
            return Err(ContactError::ExactConstraint { method });
        }
        self.settings.penalty = penalty;
        for (spring, &area) in self.springs.iter_mut().zip(&self.submodel.areas) {
            *spring = penalty::spring_compliance(penalty, area);
        }
        if let Some(zone) = &mut self.quasistatic {
            zone.springs_changed();
        }
        Ok(())
    }

    /// Penalty factor [N/m³].
    pub fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    /// The body's contact data.
    pub fn submodel(&self) -> &ContactSubmodel {
        &self.submodel
    }

    /// Quasistatic zone, none when all modes are dynamic. Its projection belongs to the last evaluation.
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

    /// Smallest gap of all points at `state` without quasistatic displacement [m]: zero where contact begins or ends. The
    /// solver is neither run nor changed. NaN if a gap is not a number.
    pub fn smallest_gap(&self, state: &BodyState) -> f64 {
        let Ok(normal) = self.normal_components(&state.rotation) else {
            return f64::NAN;
        };
        let offset = self.offset(state);
        let mut smallest = f64::INFINITY;
        for i in 0..self.submodel.n_points() {
            let gap = self.gap(i, offset, &normal, &state.elastic);
            // min() would hide a NaN
            if gap.is_nan() {
                return gap;
            }
            smallest = smallest.min(gap);
        }
        smallest
    }

    /// Replaces `out` by the forces of the last evaluation on the interface freedoms, `f_b = N_bᵀ n λ` (Eq. C.19) \[N\], for
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
        let nc = self.submodel.motion.n_components();
        for (i, &force) in self.forces.iter().enumerate() {
            for c in 0..nc {
                for &(b, value) in rows.row(nc * i + c) {
                    out[b] += value * self.normal[c] * force;
                }
            }
        }
    }

    /// Plane normal in the model's components.
    fn normal_components(&self, rotation: &UnitQuaternion<f64>) -> Result<[f64; 3], ContactError> {
        let normal = rotation.inverse_transform_vector(&self.settings.plane.normal);
        let fail =
            |requirement| Err(ContactError::Normal { normal: [normal.x, normal.y, normal.z], requirement });
        // Asked this way round, a NaN fails.
        let is_along_axis = normal.x.hypot(normal.y) < NORMAL_TOLERANCE;
        let is_in_plane = normal.z.abs() < NORMAL_TOLERANCE;
        match self.submodel.motion {
            RigidMotion::Axial if is_along_axis => Ok([0.0, normal.z, 0.0]),
            RigidMotion::Axial => fail("an axisymmetric body needs a normal along its axis z"),
            RigidMotion::Planar if is_in_plane => Ok([normal.x, normal.y, 0.0]),
            RigidMotion::Planar => fail("a plane body needs a normal in its plane x, y"),
            RigidMotion::Spatial => Ok([normal.x, normal.y, normal.z]),
        }
    }

    /// Distance of the frame's origin from the plane.
    fn offset(&self, state: &BodyState) -> f64 {
        (state.position - self.settings.plane.point).dot(&self.settings.plane.normal)
    }

    /// Row of the low-frequency shapes of component `c` at point `i`.
    fn low_row(&self, i: usize, c: usize) -> &[f64] {
        let n_q = self.submodel.low.ncols();
        let row = self.submodel.motion.n_components() * i + c;
        &self.low_rows[row * n_q..(row + 1) * n_q]
    }

    /// Gap of point `i` without quasistatic displacement (Eq. C.1).
    fn gap(&self, i: usize, offset: f64, normal: &[f64; 3], elastic: &[f64]) -> f64 {
        let motion = self.submodel.motion;
        let mut gap = offset;
        for (c, &normal_c) in normal[..motion.n_components()].iter().enumerate() {
            if normal_c != 0.0 {
                let low: f64 = self.low_row(i, c).iter().zip(elastic).map(|(s, q)| s * q).sum();
                gap += normal_c * (self.submodel.points[i][motion.direction(c)] + low);
            }
        }
        gap
    }

    /// Point forces at the gaps just found, by the solver or the penalty law.
    fn solve(&mut self) -> Result<SolveReport, Rejection> {
        let Some(zone) = &mut self.quasistatic else {
            for ((force, &gap), &area) in
                self.forces.iter_mut().zip(&self.free_gaps).zip(&self.submodel.areas)
            {
                *force = area * penalty::pressure(self.settings.penalty, gap);
            }
            self.gaps.copy_from_slice(&self.free_gaps);
            return Ok(SolveReport::default());
        };
        zone.project(self.normal);
        let report = zone.solve(&self.springs, &self.free_gaps, &mut self.forces)?;
        let problem =
            Problem { compliance: zone.normal_compliance(), springs: &self.springs, gaps: &self.free_gaps };
        problem.deformed_gaps(&self.forces, &mut self.gaps);
        Ok(report)
    }

    /// Sums up the last evaluation.
    fn sum_up(&mut self, solver: SolveReport) {
        let mut report = ContactReport { solver, ..ContactReport::default() };
        for (i, &force) in self.forces.iter().enumerate() {
            report.penetration = report.penetration.max(-self.gaps[i]);
            if force > 0.0 {
                report.normal_force += force;
                report.n_active += 1;
                report.contact_area += self.submodel.areas[i];
                report.is_rim_touched |= self.is_rim[i];
                // Work of the normal displacement of the zone, Eq. C.7; zero when all modes are dynamic.
                report.energies.elastic_high += 0.5 * force * (self.gaps[i] - self.free_gaps[i]);
                report.energies.penalty += 0.5 * force * force * self.springs[i];
            }
        }
        report.force = self.settings.plane.normal.into_inner() * report.normal_force;
        self.report = report;
    }

    /// Moment of the point forces about the frame's origin in the body's frame (Eq. C.17).
    fn torque(&mut self, elastic: &[f64]) -> Vector3<f64> {
        let motion = self.submodel.motion;
        let mut torque = Vector3::zeros();
        if motion == RigidMotion::Axial {
            return torque;
        }
        let nc = motion.n_components();
        self.displacements.fill(0.0);
        if let Some(zone) = &self.quasistatic {
            zone.displacements(&self.forces, &mut self.displacements);
        }
        let normal = Vector3::from(self.normal);
        for (i, &force) in self.forces.iter().enumerate() {
            if force > 0.0 {
                let mut arm = Vector3::from(self.submodel.points[i]);
                for c in 0..nc {
                    let low: f64 = self.low_row(i, c).iter().zip(elastic).map(|(s, q)| s * q).sum();
                    arm[motion.direction(c)] += low + self.displacements[nc * i + c];
                }
                torque += arm.cross(&normal) * force;
            }
        }
        torque
    }
}

impl ForceElement for PlaneContact {
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), Rejection> {
        let state = &bodies[self.settings.body];
        debug_assert_eq!(state.elastic.len(), self.submodel.low.ncols());
        self.normal = self
            .normal_components(&state.rotation)
            .map_err(|error| Rejection { code: 0, reason: error.to_string() })?;
        let offset = self.offset(state);
        for i in 0..self.submodel.n_points() {
            let gap = self.gap(i, offset, &self.normal, &state.elastic);
            if !gap.is_finite() {
                return Err(Rejection {
                    code: 2,
                    reason: format!("the gap of contact point {i} is {gap} at t = {t:.9e} s"),
                });
            }
            self.free_gaps[i] = gap;
        }
        let solver = self.solve()?;
        self.sum_up(solver);
        if self.report.n_active == 0 {
            return Ok(());
        }
        let torque = self.torque(&state.elastic);
        let target = &mut forces[self.settings.body];
        target.force += self.report.force;
        target.torque += torque;
        for (i, &force) in self.forces.iter().enumerate() {
            for (c, &normal_c) in self.normal[..self.submodel.motion.n_components()].iter().enumerate() {
                let factor = force * normal_c;
                if factor != 0.0 {
                    target.elastic.iter_mut().zip(self.low_row(i, c)).for_each(|(f, s)| *f += s * factor);
                }
            }
        }
        Ok(())
    }

    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn save(&mut self) {
        if let Some(zone) = &mut self.quasistatic {
            zone.save();
        }
    }

    fn restore(&mut self) {
        if let Some(zone) = &mut self.quasistatic {
            zone.restore();
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

    fn report(&self) -> &ContactReport {
        &self.report
    }

    fn penalty(&self) -> f64 {
        self.settings.penalty
    }

    fn n_points(&self) -> usize {
        self.submodel.n_points()
    }
}
