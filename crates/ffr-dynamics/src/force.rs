//! The seam through which forces enter the equations of motion: a law of force, with its state and
//! its workspace handed in.
//!
//! An element itself never changes in an evaluation. What later evaluations depend on is its state,
//! which whoever evaluates it owns, saves and restores; its workspace is buffers alone, and what an
//! evaluation finds goes to a place of its own.

pub mod active;

use std::ops::Add;

use nalgebra::{UnitQuaternion, Vector3};

use crate::error::EvaluationFailure;

/// Motion of one body at one instant, as force elements see it.
#[derive(Debug, Clone)]
pub struct BodyState {
    /// Origin of the reference frame in the inertial frame, `p_IR` \[m\].
    pub position: Vector3<f64>,
    /// Rotation from the body's reference frame to the inertial frame.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity of the frame's origin, expressed in the inertial frame [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity, expressed in the body's frame [rad/s].
    pub angular_velocity_in_body: Vector3<f64>,
    /// Elastic coordinates `q_e` (mass-orthonormal modes: m sqrt(kg)).
    pub elastic: Vec<f64>,
    /// Rates `dq_e/dt`.
    pub elastic_rates: Vec<f64>,
}

impl BodyState {
    /// A body at rest and undeformed, with its frame in the inertial frame.
    pub fn at_rest(n_modes: usize) -> Self {
        Self {
            position: Vector3::zeros(),
            rotation: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            angular_velocity_in_body: Vector3::zeros(),
            elastic: vec![0.0; n_modes],
            elastic_rates: vec![0.0; n_modes],
        }
    }

    /// Whether nothing of it moves.
    pub fn is_at_rest(&self) -> bool {
        let rigid = self.velocity.iter().chain(self.angular_velocity_in_body.iter());
        rigid.chain(&self.elastic_rates).all(|v| *v == 0.0)
    }
}

/// Force on one body, reduced to its reference frame and its modes.
#[derive(Debug, Clone)]
pub struct GeneralisedForce {
    /// Resultant, expressed in the inertial frame \[N\].
    pub force: Vector3<f64>,
    /// Moment about the frame's origin, expressed in the body's frame \[N m\].
    pub torque_in_body: Vector3<f64>,
    /// Modal forces `Φᵀ f`.
    pub elastic: Vec<f64>,
}

impl GeneralisedForce {
    /// The force times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let elastic = self.elastic.iter().map(|f| f * factor).collect();
        Self { force: self.force * factor, torque_in_body: self.torque_in_body * factor, elastic }
    }

    /// The force without `other`.
    #[must_use]
    pub fn without(&self, other: &Self) -> Self {
        Self {
            force: self.force - other.force,
            torque_in_body: self.torque_in_body - other.torque_in_body,
            elastic: self.elastic.iter().zip(&other.elastic).map(|(a, b)| a - b).collect(),
        }
    }

    /// No force on a body with `n` elastic coordinates.
    pub fn zeros(n: usize) -> Self {
        Self { force: Vector3::zeros(), torque_in_body: Vector3::zeros(), elastic: vec![0.0; n] }
    }

    /// Adds `factor` times `other`.
    pub fn add_multiple(&mut self, factor: f64, other: &Self) {
        self.force += other.force * factor;
        self.torque_in_body += other.torque_in_body * factor;
        self.elastic.iter_mut().zip(&other.elastic).for_each(|(sum, f)| *sum += f * factor);
    }

    /// Sets everything to zero.
    pub fn clear(&mut self) {
        self.force.fill(0.0);
        self.torque_in_body.fill(0.0);
        self.elastic.fill(0.0);
    }
}

/// Energy held and power lost by a force element.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ForceEnergies {
    /// Quasistatic elastic energy `½ fᵀ G f` \[J\].
    pub elastic_high: f64,
    /// Energy in penalty springs \[J\].
    pub penalty: f64,
    /// Kinetic energy of the element's internal coordinates \[J\].
    pub kinetic: f64,
    /// Power dissipated, not negative \[W\].
    pub dissipated_power: f64,
    /// Work lost since the inner state was saved last that is a function of the present state
    /// \[J\].
    ///
    /// Where a point begins to slide, its power jumps, which no quadrature over a step sees; `b|w|`
    /// with its bound and its slip is what it loses beside `∫ |w| db`, which begins at zero
    /// (docs/theory.md Eq. F.15).
    pub slid: f64,
    /// Rate of `slid` \[W\].
    pub slid_rate: f64,
    /// The part of the dissipated power that sliding friction takes \[W\].
    pub sliding_power: f64,
}

impl ForceEnergies {
    /// Power that is integrated within a step, while `slid` is added at its end \[W\].
    pub fn integrated_power(&self) -> f64 {
        self.dissipated_power - self.slid_rate
    }
}

impl Add for ForceEnergies {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            elastic_high: self.elastic_high + other.elastic_high,
            penalty: self.penalty + other.penalty,
            kinetic: self.kinetic + other.kinetic,
            dissipated_power: self.dissipated_power + other.dissipated_power,
            slid: self.slid + other.slid,
            slid_rate: self.slid_rate + other.slid_rate,
            sliding_power: self.sliding_power + other.sliding_power,
        }
    }
}

/// The motion at which a force element is evaluated.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Motions of all bodies of the system.
    pub bodies: &'a [BodyState],
    /// Internal coordinates of the element, then their rates.
    pub internal: &'a [f64],
}

impl<'a> Motion<'a> {
    /// Bodies at time `time`, for an element without internal coordinates.
    pub fn new(time: f64, bodies: &'a [BodyState]) -> Self {
        Self { time, bodies, internal: &[] }
    }
}

/// Results of an evaluation of a force element that the system reads.
pub trait Findings: Send {
    /// Energies and powers.
    fn energies(&self) -> ForceEnergies;

    /// Resultant on the element's first body in the inertial frame; its time integral is the
    /// impulse \[N\].
    fn resultant(&self) -> Vector3<f64>;

    /// Whether the force and all its derivatives were zero, as in an open contact.
    fn is_idle(&self) -> bool {
        false
    }

    /// Second derivatives of the element's internal coordinates, one each.
    fn accelerations(&self) -> &[f64] {
        &[]
    }
}

/// A force on one or more bodies.
pub trait ForceElement: Send {
    /// What later evaluations depend on: references of sticking points, starts of iterations, and
    /// what of them is saved.
    type State: Send;
    /// Buffers; their contents change no result.
    type Workspace: Send;
    /// Results of an evaluation.
    type Found: Findings;

    /// State before the first evaluation, buffers, and a place for what evaluations find, with
    /// nothing found yet.
    fn start(&self) -> (Self::State, Self::Workspace, Self::Found);

    /// Adds the forces at `motion` to `forces` (one entry per body, in the order of the bodies) and
    /// notes in `found` what it finds. Must not allocate.
    ///
    /// # Errors
    /// [`EvaluationFailure`] where the force cannot be found, for instance when the contact solver does not converge.
    fn evaluate(
        &self,
        motion: Motion<'_>,
        state: &mut Self::State,
        workspace: &mut Self::Workspace,
        found: &mut Self::Found,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure>;

    /// Adds to `rates` how fast the forces of the last evaluation change while the bodies stand as in it and move with the
    /// velocities of the motion given (docs/theory.md Eq. C.109), or, `by_velocity`, by how much they change with these velocities.
    /// False where that is not known; what was added is then of no use. It may be an approximation, for the iterations of
    /// implicit methods. Must not allocate.
    fn rates(
        &self,
        (_motion, _by_velocity): (Motion<'_>, bool),
        _state: &mut Self::State,
        _workspace: &mut Self::Workspace,
        _found: &Self::Found,
        _rates: &mut [GeneralisedForce],
    ) -> bool {
        false
    }

    /// Accepts what the last evaluation found at the end of a step, and saves the state; for
    /// elements whose evaluations depend on those before.
    fn save(&self, _state: &mut Self::State, _found: &Self::Found) {}

    /// Returns to the saved state after a rejected step.
    fn restore(&self, _state: &mut Self::State, _found: &mut Self::Found) {}

    /// Number `n` of internal coordinates of the element. The system's state holds them and their
    /// rates, `2 n` numbers.
    fn n_coordinates(&self) -> usize {
        0
    }

    /// Velocity that carries the energy of `internal`, coordinates and rates, in the body that the
    /// element acts on [m/s].
    fn coordinate_speed(&self, _internal: &[f64]) -> f64 {
        0.0
    }

    /// By how much the origins of the frames of the element's two bodies may move relative to each other, that of a
    /// body on space itself, from the motions `bodies` until an evaluation finds anything else than right after
    /// [`ForceElement::start`], however the bodies turn \[m\]; none, or nothing positive, where that is not known at
    /// once. Elements with internal coordinates have none.
    fn clearance(&self, _bodies: &[BodyState]) -> Option<f64> {
        None
    }

    /// Whether it notes, in evaluations in which its bodies are apart, how they stand: then it is to be evaluated in all of them.
    fn notes_motions(&self) -> bool {
        false
    }
}
