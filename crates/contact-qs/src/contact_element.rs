//! What a driver asks of a contact, whatever its law: gap, direction, report, penalty factor.

use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies};
use nalgebra::{UnitQuaternion, Vector3};

use crate::ContactError;
use crate::quasistatic::SolveReport;

/// What a contact evaluation found.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContactReport {
    /// Sum of the normal point forces \[N\].
    pub normal_force: f64,
    /// Force on the contact body in the inertial frame, friction included \[N\].
    pub force: Vector3<f64>,
    /// Friction force on the contact body in the inertial frame \[N\].
    pub friction_force: Vector3<f64>,
    /// Largest penetration, quasistatic displacement included, zero without contact; Hertz: the approach \[m\].
    pub penetration: f64,
    /// Number of points that carry force.
    pub n_active: usize,
    /// Number of them that slide; zero without friction.
    pub n_sliding: usize,
    /// Sum of their areas; Hertz: area of the contact circle \[m²\].
    pub contact_area: f64,
    /// Whether a point on the rim of the zone carries force.
    pub is_rim_touched: bool,
    /// Energies.
    pub energies: ForceEnergies,
    /// Work of the solver.
    pub solver: SolveReport,
}

/// A contact of one body with another or with a fixed target.
///
/// The contact body is the first of [`ContactElement::bodies`]; directions and forces are those on it.
pub trait ContactElement: ForceElement {
    /// Kind of the contact for messages, such as `"sphere-plane"`.
    fn kind(&self) -> &'static str;

    /// Index of the contact body and of the target, none if that is fixed.
    fn bodies(&self) -> (usize, Option<usize>);

    /// Smallest gap at the motion `bodies` of all bodies: positive apart, zero where the force begins or ends \[m\]. Runs no
    /// solver and changes no state; NaN if the gap is not a number.
    fn smallest_gap(&self, bodies: &[BodyState]) -> f64;

    /// Unit normal towards the contact body at the motion `bodies`, in the inertial frame.
    fn normal(&self, bodies: &[BodyState]) -> Vector3<f64>;

    /// Place of the smallest gap at the motion `bodies`, on the contact body, in the inertial frame; NaN if there is none \[m\].
    fn place(&self, bodies: &[BodyState]) -> Vector3<f64>;

    /// What the last evaluation found.
    fn report(&self) -> &ContactReport;

    /// Penalty factor in use; infinite where there are no penalty springs \[N/m³\].
    fn penalty(&self) -> f64;

    /// Number of points that can carry force.
    fn n_points(&self) -> usize;

    /// Checks that the contact can work when the contact body has the rotation `rotation`.
    ///
    /// # Errors
    /// [`ContactError`] with the reason.
    fn check_orientation(&self, _rotation: &UnitQuaternion<f64>) -> Result<(), ContactError> {
        Ok(())
    }

    /// Normal forces of the points at the last evaluation; empty for laws without points \[N\].
    fn point_forces(&self) -> &[f64] {
        &[]
    }

    /// Undeformed contact point `i` in the frame of the contact body \[m\], and its tributary area \[m²\]; none for laws without
    /// points.
    fn point(&self, _i: usize) -> Option<([f64; 3], f64)> {
        None
    }

    /// Changes the penalty factor [N/m³]; allowed during a run.
    ///
    /// # Errors
    /// [`ContactError::Penalty`] if it is not positive, [`ContactError::Data`] for laws without one.
    fn set_penalty(&mut self, _penalty: f64) -> Result<(), ContactError> {
        Err(ContactError::NoPenalty { kind: self.kind() })
    }

    /// `max_i(A_ii w_i)` of the points in the motion `bodies` (docs/theory.md Eq. A.14) [m³/N]; none without a quasistatic
    /// zone. Forgets the last evaluation.
    ///
    /// # Errors
    /// [`EvaluationFailure`] if the points have no normals there.
    fn compliance_weight(&mut self, _bodies: &[BodyState]) -> Result<Option<f64>, EvaluationFailure> {
        Ok(None)
    }

    /// Forgets the last evaluation, for a start from another state.
    fn forget(&mut self) {}

    /// Replaces `out` by the forces of the last evaluation on the interface unknowns of body `body` \[N\]; zero where there is no
    /// quasistatic zone.
    fn interface_force(&self, _body: usize, out: &mut [f64]) {
        out.fill(0.0);
    }
}

impl<T: ContactElement + ?Sized> ContactElement for Box<T> {
    fn kind(&self) -> &'static str {
        (**self).kind()
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (**self).bodies()
    }

    fn smallest_gap(&self, bodies: &[BodyState]) -> f64 {
        (**self).smallest_gap(bodies)
    }

    fn normal(&self, bodies: &[BodyState]) -> Vector3<f64> {
        (**self).normal(bodies)
    }

    fn place(&self, bodies: &[BodyState]) -> Vector3<f64> {
        (**self).place(bodies)
    }

    fn report(&self) -> &ContactReport {
        (**self).report()
    }

    fn penalty(&self) -> f64 {
        (**self).penalty()
    }

    fn n_points(&self) -> usize {
        (**self).n_points()
    }

    fn check_orientation(&self, rotation: &UnitQuaternion<f64>) -> Result<(), ContactError> {
        (**self).check_orientation(rotation)
    }

    fn point_forces(&self) -> &[f64] {
        (**self).point_forces()
    }

    fn point(&self, i: usize) -> Option<([f64; 3], f64)> {
        (**self).point(i)
    }

    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        (**self).set_penalty(penalty)
    }

    fn compliance_weight(&mut self, bodies: &[BodyState]) -> Result<Option<f64>, EvaluationFailure> {
        (**self).compliance_weight(bodies)
    }

    fn forget(&mut self) {
        (**self).forget();
    }

    fn interface_force(&self, body: usize, out: &mut [f64]) {
        (**self).interface_force(body, out);
    }
}
