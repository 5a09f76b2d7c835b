//! What is asked of a contact, whatever its law. [`Contact`] is what it is, [`ContactElement`] what it answers with state and workspace
//! handed in, [`ActiveContact`] what a driver holds.

use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::active::{Active, ActiveForce, ActiveParts};
use ffr_dynamics::force::{Findings, ForceElement, ForceEnergies, Motion};
use nalgebra::{Unit, Vector3};

use crate::ContactError;
use crate::quasistatic::SolveReport;

/// A fixed rigid plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// A point of the plane in the inertial frame \[m\].
    pub point: Vector3<f64>,
    /// Normal in the inertial frame, towards the body.
    pub normal: Unit<Vector3<f64>>,
}

impl Plane {
    /// The point of the plane that is nearest to `point` \[m\].
    pub fn foot(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let normal = self.normal.into_inner();
        point - normal * (point - self.point).dot(&normal)
    }
}

/// What a contact body meets: a body `T`, by its index or with what is asked of it, or a plane at
/// rest, a surface that nothing bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target<T = usize> {
    /// A fixed rigid plane.
    Plane(Plane),
    /// Another body.
    Body(T),
}

impl<T> Target<T> {
    /// The fixed plane through `point` whose `normal` points to the side of the contact body.
    pub fn plane(point: Vector3<f64>, normal: Vector3<f64>) -> Self {
        Self::Plane(Plane { point, normal: Unit::new_normalize(normal) })
    }

    /// The body; none of a plane.
    pub fn body(self) -> Option<T> {
        match self {
            Self::Plane(_) => None,
            Self::Body(body) => Some(body),
        }
    }

    /// The same by reference.
    pub fn as_ref(&self) -> Target<&T> {
        match self {
            Self::Plane(plane) => Target::Plane(*plane),
            Self::Body(body) => Target::Body(body),
        }
    }

    /// The same with what `of` says of the body.
    pub fn map<U>(self, of: impl FnOnce(T) -> U) -> Target<U> {
        match self {
            Self::Plane(plane) => Target::Plane(plane),
            Self::Body(body) => Target::Body(of(body)),
        }
    }

    /// The same with what `of` says of the body.
    ///
    /// # Errors
    /// Those of `of`.
    pub fn try_map<U, E>(self, of: impl FnOnce(T) -> Result<U, E>) -> Result<Target<U>, E> {
        Ok(match self.map(of) {
            Target::Plane(plane) => Target::Plane(plane),
            Target::Body(found) => Target::Body(found?),
        })
    }
}

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

/// What a contact is, whatever the motion.
///
/// The contact body is the first of [`Contact::bodies`]; directions and forces are those on it.
pub trait Contact {
    /// Kind of the contact for messages, such as `"sphere-plane"`.
    fn kind(&self) -> &'static str;

    /// Index of the contact body and of the target, none if that is fixed.
    fn bodies(&self) -> (usize, Option<usize>);

    /// Penalty factor in use; infinite where there are no penalty springs \[N/m³\].
    fn penalty(&self) -> f64;

    /// Number of points that can carry force.
    fn n_points(&self) -> usize;

    /// Undeformed contact point `i` in the frame of the contact body \[m\], and its tributary area
    /// \[m²\]; none for laws without points.
    fn point(&self, i: usize) -> Option<([f64; 3], f64)>;
}

/// Where the surfaces of a contact are nearest, in the inertial frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// Smallest gap: positive apart, zero where the force begins or ends \[m\]. NaN if it is not a
    /// number.
    pub gap: f64,
    /// Unit normal towards the contact body.
    pub normal: Vector3<f64>,
    /// Where, on the contact body; NaN if that is not known \[m\].
    pub place: Vector3<f64>,
}

impl Meeting {
    /// That of a gap that is not a number.
    pub const UNKNOWN: Self = {
        let nowhere = Vector3::new(f64::NAN, f64::NAN, f64::NAN);
        Self { gap: f64::NAN, normal: nowhere, place: nowhere }
    };
}

/// A contact as a force element. Every law answers every question, if by saying that it has no
/// answer. Questions about a motion run no solver and change no state.
pub trait ContactElement: Contact + ForceElement {
    /// What an evaluation found.
    fn report<'a>(&self, found: &'a Self::Found) -> &'a ContactReport;

    /// Where the surfaces are nearest at `motion`.
    fn meeting(&self, motion: Motion<'_>, state: &Self::State, workspace: &mut Self::Workspace) -> Meeting;

    /// Normal forces of the points; none for laws without points \[N\].
    fn point_forces<'a>(&self, state: &'a Self::State, found: &'a Self::Found) -> Option<&'a [f64]>;

    /// Friction forces of the points in the frame of the target \[N\]; none without friction, and for laws without points.
    fn friction_forces(&self, state: &Self::State, found: &Self::Found) -> Vec<Vector3<f64>>;

    /// The friction forces are those `wanted` from now on, as of [`ContactElement::friction_forces`], as far as the bounds of the
    /// points allow; none: what the points stick to moves so that those of the last evaluation stay, in its motion
    /// (docs/theory.md Eq. A.41).
    fn prescribe_friction(
        &self,
        wanted: Option<&[Vector3<f64>]>,
        state: &mut Self::State,
        found: &Self::Found,
    );

    /// Changes the penalty factor [N/m³]; allowed during a run.
    ///
    /// # Errors
    /// [`ContactError::Penalty`] if it is not positive, [`ContactError::NoPenalty`] for laws without one.
    fn set_penalty(&mut self, penalty: f64, state: &mut Self::State) -> Result<(), ContactError>;

    /// `max_i(A_ii w_i)` of the points that are nearest at `motion`, or farther by `reach` \[m\] at most
    /// (docs/theory.md Eq. A.25) [m³/N]; none without a quasistatic zone. The state forgets where its iterations started.
    ///
    /// # Errors
    /// [`EvaluationFailure`] if the points have no normals there.
    fn compliance_weight(
        &self,
        at: (Motion<'_>, f64),
        state: &mut Self::State,
        workspace: &mut Self::Workspace,
        found: &mut Self::Found,
    ) -> Result<Option<f64>, EvaluationFailure>;

    /// Replaces `out` by the forces found on the interface unknowns of body `body` \[N\]; false,
    /// and `out` as it was, if the contact has no quasistatic zone there.
    #[must_use]
    fn interface_force(&self, body: usize, found: &Self::Found, out: &mut [f64]) -> bool;
}

/// A contact at work, whatever its law: what a driver asks of it. Implemented by [`Active`] contacts
/// alone.
///
/// What is asked for without a motion is that of the last evaluation.
pub trait ActiveContact: ActiveForce {
    /// What it is.
    fn facts(&self) -> &dyn Contact;

    /// What was found.
    fn report(&self) -> &ContactReport;

    /// Forgets the past, for a start from another state: what is left is a contact that has never
    /// been evaluated, to the last bit.
    fn forget(&mut self);

    /// As [`ContactElement::meeting`].
    fn meeting(&mut self, motion: Motion<'_>) -> Meeting;

    /// As [`ContactElement::point_forces`].
    fn point_forces(&self) -> Option<&[f64]>;

    /// As [`ContactElement::friction_forces`].
    fn friction_forces(&self) -> Vec<Vector3<f64>>;

    /// As [`ContactElement::prescribe_friction`].
    fn prescribe_friction(&mut self, wanted: Option<&[Vector3<f64>]>);

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

    /// As [`ContactElement::interface_force`].
    #[must_use]
    fn interface_force(&self, body: usize, out: &mut [f64]) -> bool;
}

impl<E: ContactElement> ActiveContact for Active<E> {
    fn facts(&self) -> &dyn Contact {
        self.element()
    }

    fn report(&self) -> &ContactReport {
        self.element().report(self.found())
    }

    fn forget(&mut self) {
        let ActiveParts { element, state, workspace, found } = self.parts();
        (*state, *workspace, *found) = element.start();
    }

    fn meeting(&mut self, motion: Motion<'_>) -> Meeting {
        let ActiveParts { element, state, workspace, .. } = self.parts();
        element.meeting(motion, state, workspace)
    }

    fn point_forces(&self) -> Option<&[f64]> {
        self.element().point_forces(self.state(), self.found())
    }

    fn friction_forces(&self) -> Vec<Vector3<f64>> {
        self.element().friction_forces(self.state(), self.found())
    }

    fn prescribe_friction(&mut self, wanted: Option<&[Vector3<f64>]>) {
        let ActiveParts { element, state, found, .. } = self.parts();
        element.prescribe_friction(wanted, state, found);
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

    fn interface_force(&self, body: usize, out: &mut [f64]) -> bool {
        self.element().interface_force(body, self.found(), out)
    }
}
