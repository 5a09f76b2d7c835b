//! What a driver asks of a contact, whatever its law: gap, direction, report, penalty factor.
//!
//! [`ContactElement`] is what a contact is, its state and workspace handed in; [`ActiveContact`] is what a driver holds.

use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::active::{Active, ActiveForce, ActiveParts};
use ffr_dynamics::force::{Findings, ForceElement, ForceEnergies, Motion};
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
    /// Largest penetration, quasistatic displacement included, zero without contact; Hertz: the
    /// approach \[m\].
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

/// What an evaluation of a contact finds.
pub trait ContactFindings: Findings {
    /// Sums over the points.
    fn report(&self) -> &ContactReport;
}

impl Findings for ContactReport {
    fn energies(&self) -> ForceEnergies {
        self.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.force
    }

    fn is_idle(&self) -> bool {
        self.n_active == 0
    }
}

impl ContactFindings for ContactReport {
    fn report(&self) -> &ContactReport {
        self
    }
}

/// A contact of one body with another or with a fixed target.
///
/// The contact body is the first of [`ContactElement::bodies`]; directions and forces are those on
/// it. Questions about a motion run no solver and change no state.
pub trait ContactElement: ForceElement<Found: ContactFindings> {
    /// Kind of the contact for messages, such as `"sphere-plane"`.
    fn kind(&self) -> &'static str;

    /// Index of the contact body and of the target, none if that is fixed.
    fn bodies(&self) -> (usize, Option<usize>);

    /// Smallest gap at `motion`: positive apart, zero where the force begins or ends \[m\]. NaN if
    /// the gap is not a number.
    fn smallest_gap(&self, motion: Motion<'_>, state: &Self::State, workspace: &mut Self::Workspace) -> f64;

    /// Unit normal towards the contact body at `motion`, in the inertial frame.
    fn normal(
        &self,
        motion: Motion<'_>,
        state: &Self::State,
        workspace: &mut Self::Workspace,
    ) -> Vector3<f64>;

    /// Place of the smallest gap at `motion`, on the contact body, in the inertial frame; NaN if
    /// there is none \[m\].
    fn place(&self, motion: Motion<'_>, state: &Self::State, workspace: &mut Self::Workspace)
    -> Vector3<f64>;

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

    /// Normal forces of the points; empty for laws without points \[N\].
    fn point_forces<'a>(&self, _state: &'a Self::State, _found: &'a Self::Found) -> &'a [f64] {
        &[]
    }

    /// Undeformed contact point `i` in the frame of the contact body \[m\], and its tributary area
    /// \[m²\]; none for laws without points.
    fn point(&self, _i: usize) -> Option<([f64; 3], f64)> {
        None
    }

    /// Changes the penalty factor [N/m³]; allowed during a run.
    ///
    /// # Errors
    /// [`ContactError::Penalty`] if it is not positive, [`ContactError::NoPenalty`] for laws without one.
    fn set_penalty(&mut self, _penalty: f64, _state: &mut Self::State) -> Result<(), ContactError> {
        Err(ContactError::NoPenalty { kind: self.kind() })
    }

    /// `max_i(A_ii w_i)` of the points that are nearest at `motion`, or farther by `reach` \[m\] at most
    /// (docs/theory.md Eq. A.25) [m³/N]; none without a quasistatic zone. The state forgets where its iterations started.
    ///
    /// # Errors
    /// [`EvaluationFailure`] if the points have no normals there.
    fn compliance_weight(
        &self,
        _at: (Motion<'_>, f64),
        _state: &mut Self::State,
        _workspace: &mut Self::Workspace,
        _found: &mut Self::Found,
    ) -> Result<Option<f64>, EvaluationFailure> {
        Ok(None)
    }

    /// Replaces `out` by the forces found on the interface unknowns of body `body` \[N\]; zero
    /// where there is no quasistatic zone.
    fn interface_force(&self, _body: usize, _found: &Self::Found, out: &mut [f64]) {
        out.fill(0.0);
    }
}

/// A contact at work, whatever its kind: what a driver asks of it. Implemented by [`Active`]
/// contacts alone.
///
/// What is asked for without a motion is that of the last evaluation.
pub trait ActiveContact: ActiveForce {
    /// As [`ContactElement::kind`].
    fn kind(&self) -> &'static str;

    /// As [`ContactElement::bodies`].
    fn bodies(&self) -> (usize, Option<usize>);

    /// As [`ContactElement::smallest_gap`].
    fn smallest_gap(&mut self, motion: Motion<'_>) -> f64;

    /// As [`ContactElement::normal`].
    fn normal(&mut self, motion: Motion<'_>) -> Vector3<f64>;

    /// As [`ContactElement::place`].
    fn place(&mut self, motion: Motion<'_>) -> Vector3<f64>;

    /// What was found.
    fn report(&self) -> &ContactReport;

    /// As [`ContactElement::penalty`].
    fn penalty(&self) -> f64;

    /// As [`ContactElement::n_points`].
    fn n_points(&self) -> usize;

    /// As [`ContactElement::check_orientation`].
    ///
    /// # Errors
    /// [`ContactError`] with the reason.
    fn check_orientation(&self, rotation: &UnitQuaternion<f64>) -> Result<(), ContactError>;

    /// As [`ContactElement::point_forces`].
    fn point_forces(&self) -> &[f64];

    /// As [`ContactElement::point`].
    fn point(&self, i: usize) -> Option<([f64; 3], f64)>;

    /// As [`ContactElement::set_penalty`].
    ///
    /// # Errors
    /// Likewise.
    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError>;

    /// As [`ContactElement::compliance_weight`].
    ///
    /// # Errors
    /// Likewise.
    fn compliance_weight(&mut self, motion: Motion<'_>, reach: f64)
    -> Result<Option<f64>, EvaluationFailure>;

    /// Forgets the past, for a start from another state: what is left is a contact that has never
    /// been evaluated, to the last bit.
    fn forget(&mut self);

    /// As [`ContactElement::interface_force`].
    fn interface_force(&self, body: usize, out: &mut [f64]);
}

impl<E: ContactElement> ActiveContact for Active<E> {
    fn kind(&self) -> &'static str {
        self.element().kind()
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        self.element().bodies()
    }

    fn smallest_gap(&mut self, motion: Motion<'_>) -> f64 {
        let ActiveParts { element, state, workspace, .. } = self.parts();
        element.smallest_gap(motion, state, workspace)
    }

    fn normal(&mut self, motion: Motion<'_>) -> Vector3<f64> {
        let ActiveParts { element, state, workspace, .. } = self.parts();
        element.normal(motion, state, workspace)
    }

    fn place(&mut self, motion: Motion<'_>) -> Vector3<f64> {
        let ActiveParts { element, state, workspace, .. } = self.parts();
        element.place(motion, state, workspace)
    }

    fn report(&self) -> &ContactReport {
        self.found().report()
    }

    fn penalty(&self) -> f64 {
        self.element().penalty()
    }

    fn n_points(&self) -> usize {
        self.element().n_points()
    }

    fn check_orientation(&self, rotation: &UnitQuaternion<f64>) -> Result<(), ContactError> {
        self.element().check_orientation(rotation)
    }

    fn point_forces(&self) -> &[f64] {
        self.element().point_forces(self.state(), self.found())
    }

    fn point(&self, i: usize) -> Option<([f64; 3], f64)> {
        self.element().point(i)
    }

    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        let ActiveParts { element, state, .. } = self.parts();
        element.set_penalty(penalty, state)
    }

    fn compliance_weight(
        &mut self,
        motion: Motion<'_>,
        reach: f64,
    ) -> Result<Option<f64>, EvaluationFailure> {
        let ActiveParts { element, state, workspace, found } = self.parts();
        element.compliance_weight((motion, reach), state, workspace, found)
    }

    fn forget(&mut self) {
        let ActiveParts { element, state, workspace, found } = self.parts();
        (*state, *workspace, *found) = element.start();
    }

    fn interface_force(&self, body: usize, out: &mut [f64]) {
        self.element().interface_force(body, self.found(), out);
    }
}
