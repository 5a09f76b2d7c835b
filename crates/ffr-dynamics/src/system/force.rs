//! The seam through which forces enter the equations of motion.

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
    pub angular_velocity: Vector3<f64>,
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
            angular_velocity: Vector3::zeros(),
            elastic: vec![0.0; n_modes],
            elastic_rates: vec![0.0; n_modes],
        }
    }
}

/// Force on one body, reduced to its reference frame and its modes.
#[derive(Debug, Clone)]
pub struct GeneralisedForce {
    /// Resultant, expressed in the inertial frame \[N\].
    pub force: Vector3<f64>,
    /// Moment about the frame's origin, expressed in the body's frame \[N m\].
    pub torque: Vector3<f64>,
    /// Modal forces `Φᵀ f`.
    pub elastic: Vec<f64>,
}

impl GeneralisedForce {
    /// No force on a body with `n` elastic coordinates.
    pub fn zeros(n: usize) -> Self {
        Self { force: Vector3::zeros(), torque: Vector3::zeros(), elastic: vec![0.0; n] }
    }

    /// Sets everything to zero.
    pub fn clear(&mut self) {
        self.force.fill(0.0);
        self.torque.fill(0.0);
        self.elastic.fill(0.0);
    }
}

/// Energy held and power lost by a force element at its last evaluation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ForceEnergies {
    /// Quasistatic elastic energy `½ fᵀ G f` \[J\].
    pub elastic_high: f64,
    /// Energy in penalty springs \[J\].
    pub penalty: f64,
    /// Kinetic energy of the element's own coordinates \[J\].
    pub kinetic: f64,
    /// Power dissipated, not negative \[W\].
    pub dissipated_power: f64,
    /// Work lost since the inner state was saved last that is a function of the present state \[J\].
    ///
    /// Where a point begins to slide, its power jumps, which no quadrature over a step sees; `b|w|` with its bound and its slip
    /// is what it loses beside `∫ |w| db`, which begins at zero (docs/theory.md Eq. F.30).
    pub slid: f64,
    /// Rate of `slid` \[W\].
    pub slid_rate: f64,
    /// What of the dissipated power is that of sliding \[W\].
    pub sliding_power: f64,
}

impl ForceEnergies {
    /// Power that is integrated within a step, while `slid` is booked at its end \[W\].
    pub fn integrated_power(&self) -> f64 {
        self.dissipated_power - self.slid_rate
    }
}

/// Books what the force elements have lost by sliding in a step that is about to be accepted in component `k` of the state `y`, the
/// dissipated work, and takes its `rate` to the start of the next step, where nothing has slid yet: there `slid` grows with the
/// power of sliding.
pub(super) fn book_work<F: ForceElement>(forces: &[F], k: usize, y: &mut [f64], rate: &mut [f64]) {
    for force in forces {
        let energies = force.energies();
        y[k] += energies.slid;
        rate[k] += energies.slid_rate - energies.sliding_power;
    }
}

/// A force on one or more bodies. Evaluations must not allocate.
pub trait ForceElement: Send {
    /// Adds the forces at time `t` to `forces` (one entry a body, in the order of `bodies`).
    ///
    /// # Errors
    /// [`EvaluationFailure`] where the force cannot be found, for instance when the contact solver does not converge.
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure>;

    /// Energies at the last evaluation.
    fn energies(&self) -> ForceEnergies;

    /// Resultant on the element's first body in the inertial frame at the last evaluation; its time integral is the impulse \[N\].
    fn resultant(&self) -> Vector3<f64>;

    /// Whether the force and all its derivatives were zero at the last evaluation, as in an open contact.
    fn is_idle(&self) -> bool {
        false
    }

    /// Remembers the inner state before a step; for elements whose evaluations depend on those before.
    fn save(&mut self) {}

    /// Returns to the remembered inner state after a rejected step.
    fn restore(&mut self) {}

    /// Number `n` of coordinates that the element has of its own. The system's state holds them and their rates, `2 n` numbers.
    fn n_coordinates(&self) -> usize {
        0
    }

    /// Takes the element's coordinates, then their rates, before an evaluation.
    fn set_coordinates(&mut self, _own: &[f64]) {}

    /// Writes the second derivatives of the element's coordinates at the last evaluation.
    fn accelerations(&self, _out: &mut [f64]) {}

    /// Velocity that carries the energy of `own`, coordinates and rates, in the body that the element acts on [m/s].
    fn coordinate_speed(&self, _own: &[f64]) -> f64 {
        0.0
    }
}

impl<T: ForceElement + ?Sized> ForceElement for Box<T> {
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        (**self).apply(t, bodies, forces)
    }

    fn energies(&self) -> ForceEnergies {
        (**self).energies()
    }

    fn resultant(&self) -> Vector3<f64> {
        (**self).resultant()
    }

    fn is_idle(&self) -> bool {
        (**self).is_idle()
    }

    fn save(&mut self) {
        (**self).save();
    }

    fn restore(&mut self) {
        (**self).restore();
    }

    fn n_coordinates(&self) -> usize {
        (**self).n_coordinates()
    }

    fn set_coordinates(&mut self, own: &[f64]) {
        (**self).set_coordinates(own);
    }

    fn accelerations(&self, out: &mut [f64]) {
        (**self).accelerations(out);
    }

    fn coordinate_speed(&self, own: &[f64]) -> f64 {
        (**self).coordinate_speed(own)
    }
}
