//! Energy, momentum and angular momentum (docs/theory.md Eq. D.11, D.12).

use nalgebra::{Matrix3, Vector3};

use crate::body::{DeformedMoments, StandardInputData};
use crate::force::BodyState;

/// What a free body keeps, or exchanges with others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invariants {
    /// Kinetic energy, equal to that of the unreduced model in the same motion \[J\].
    pub kinetic: f64,
    /// Elastic energy `½ q_eᵀ K_e q_e` \[J\].
    pub elastic: f64,
    /// Potential of gravity, `-m g · r_c` with the deformed centre of mass; zero at the inertial
    /// origin \[J\].
    pub gravity: f64,
    /// Linear momentum in the inertial frame [kg m/s].
    pub linear_momentum: Vector3<f64>,
    /// Angular momentum about the inertial origin, in the inertial frame [kg m²/s].
    pub angular_momentum: Vector3<f64>,
}

impl Default for Invariants {
    fn default() -> Self {
        Self {
            kinetic: 0.0,
            elastic: 0.0,
            gravity: 0.0,
            linear_momentum: Vector3::zeros(),
            angular_momentum: Vector3::zeros(),
        }
    }
}

impl Invariants {
    /// Invariants of one body in motion under `gravity` [m/s²]. Does not allocate.
    pub fn of_body(data: &StandardInputData, state: &BodyState, gravity: &Vector3<f64>) -> Self {
        let DeformedMoments { mass_moment, mass_moment_rate, inertia, relative_spin } =
            data.deformed_moments(&state.elastic, &state.elastic_rates);
        let omega = &state.angular_velocity_in_body;
        let v = state.rotation.inverse_transform_vector(&state.velocity);
        let p = v * data.mass + omega.cross(&mass_moment) + mass_moment_rate;
        let spin = inertia * omega + relative_spin;
        let modal = data.modal_mass.square(&state.elastic_rates);
        let kinetic = 0.5 * v.norm_squared() * data.mass
            + v.dot(&(omega.cross(&mass_moment) + mass_moment_rate))
            + 0.5 * omega.dot(&(inertia * omega))
            + omega.dot(&relative_spin)
            + 0.5 * modal;
        let elastic = data.modal_stiffness.iter().zip(&state.elastic).map(|(k, q)| 0.5 * k * q * q).sum();
        let linear_momentum = state.rotation * p;
        let about_frame = state.rotation * (mass_moment.cross(&v) + spin);
        let centre = state.position * data.mass + state.rotation * mass_moment;
        Self {
            kinetic,
            elastic,
            gravity: -gravity.dot(&centre),
            linear_momentum,
            angular_momentum: state.position.cross(&linear_momentum) + about_frame,
        }
    }

    /// Kinetic, elastic and gravity energy together \[J\].
    pub fn energy(&self) -> f64 {
        self.kinetic + self.elastic + self.gravity
    }
}

impl std::ops::AddAssign for Invariants {
    fn add_assign(&mut self, other: Self) {
        self.kinetic += other.kinetic;
        self.elastic += other.elastic;
        self.gravity += other.gravity;
        self.linear_momentum += other.linear_momentum;
        self.angular_momentum += other.angular_momentum;
    }
}

/// Centre of mass of the deformed body in the inertial frame \[m\].
pub fn centre_of_mass(data: &StandardInputData, state: &BodyState) -> Vector3<f64> {
    let terms = data.coupling_translation.iter().zip(&state.elastic);
    let moment = terms.fold(data.mass_moment, |sum, (c, q)| sum + c * *q);
    state.position + state.rotation * (moment / data.mass)
}

/// The rigid motion that carries the momenta of a body, or of several (Eq. Q.2), and what they do beside it.
/// The choice of the frame of reference does not enter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanMotion {
    /// Mass \[kg\].
    pub mass: f64,
    /// Rotations that the body can make, and its inertia about the centre of mass in the inertial
    /// frame [kg m²].
    n_rotations: usize,
    inertia: Matrix3<f64>,
    /// Deformed centre of mass in the inertial frame \[m\].
    centre: Vector3<f64>,
    /// Its velocity [m/s].
    velocity: Vector3<f64>,
    /// Angular velocity in the inertial frame, with the turn `J⁻¹ L` relative to the frame of
    /// reference [rad/s].
    angular_velocity: Vector3<f64>,
    /// Kinetic energy of the motion relative to it (Eq. Q.4): no other rigid motion leaves less
    /// \[J\].
    pub vibration: f64,
}

impl MeanMotion {
    /// The mean motion of a body in motion `state`: the velocity of the deformed centre of mass,
    /// and the turn with inertia and angular momentum about it. A body without inertia about an
    /// axis turns with its frame. Does not allocate.
    pub fn of(data: &StandardInputData, state: &BodyState) -> Self {
        let DeformedMoments { mass_moment, mass_moment_rate, inertia, relative_spin } =
            data.deformed_moments(&state.elastic, &state.elastic_rates);
        let (centre, velocity) = (mass_moment / data.mass, mass_moment_rate / data.mass);
        let about_centre = inertia
            - (Matrix3::identity() * mass_moment.norm_squared() - mass_moment * mass_moment.transpose())
                / data.mass;
        let spin = relative_spin - centre.cross(&mass_moment_rate);
        let n_rotations = data.motion.n_rotations();
        let turn = turn(n_rotations, &about_centre, &spin);
        let omega = &state.angular_velocity_in_body;
        let rigid = data.mass * velocity.norm_squared() + spin.dot(&turn);
        let axes = state.rotation.to_rotation_matrix().into_inner();
        Self {
            mass: data.mass,
            n_rotations,
            inertia: axes * about_centre * axes.transpose(),
            centre: state.position + state.rotation * centre,
            velocity: state.velocity + state.rotation * (omega.cross(&centre) + velocity),
            angular_velocity: state.rotation * (omega + turn),
            vibration: (0.5 * (data.modal_mass.square(&state.elastic_rates) - rigid)).max(0.0),
        }
    }

    /// The mean motion of this and `other` together, which move as one body.
    #[must_use]
    pub fn with(self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        let share = other.mass / mass;
        let (apart, rate) = (other.centre - self.centre, other.velocity - self.velocity);
        // Of two masses about their common centre: that of the reduced mass between them.
        let reduced = self.mass * share;
        let steiner = Matrix3::identity() * apart.norm_squared() - apart * apart.transpose();
        let inertia = self.inertia + other.inertia + steiner * reduced;
        let momenta = [self, *other].map(|part| part.inertia * part.angular_velocity);
        let momentum = momenta[0] + momenta[1] + apart.cross(&rate) * reduced;
        let n_rotations = self.n_rotations.max(other.n_rotations);
        let angular_velocity = turn(n_rotations, &inertia, &momentum);
        let rotation = |part: &Self, momentum: &Vector3<f64>| part.angular_velocity.dot(momentum);
        let own = rotation(&self, &momenta[0]) + rotation(other, &momenta[1]);
        let beside = own + reduced * rate.norm_squared() - angular_velocity.dot(&momentum);
        Self {
            mass,
            n_rotations,
            inertia,
            centre: self.centre + apart * share,
            velocity: self.velocity + rate * share,
            angular_velocity,
            vibration: self.vibration + other.vibration + (0.5 * beside).max(0.0),
        }
    }

    /// Velocity at `place` \[m\], both in the inertial frame [m/s]. Vibration does not enter.
    pub fn velocity_at(&self, place: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.angular_velocity.cross(&(place - self.centre))
    }
}

/// Angular velocity of a body with `n_rotations`, the `inertia` about its centre of mass and the angular
/// `momentum` about it; zero about axes without inertia.
fn turn(n_rotations: usize, inertia: &Matrix3<f64>, momentum: &Vector3<f64>) -> Vector3<f64> {
    match n_rotations {
        3 => inertia.try_inverse().map_or_else(Vector3::zeros, |inverse| inverse * momentum),
        1 if inertia[(2, 2)] > 0.0 => Vector3::z() * (momentum.z / inertia[(2, 2)]),
        _ => Vector3::zeros(),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::body::RigidMotion;

    /// A rigid body that moves and turns.
    fn turning() -> BodyState {
        BodyState {
            position: Vector3::new(0.3, -0.2, 1.0),
            rotation: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.9, 0.2)),
            velocity: Vector3::new(1.0, 2.0, -0.5),
            angular_velocity_in_body: Vector3::new(-3.0, 0.7, 1.9),
            elastic: Vec::new(),
            elastic_rates: Vec::new(),
        }
    }

    #[test]
    fn rigid_velocity_of_a_rigid_body_is_that_of_its_points() {
        let inertia = Matrix3::new(3.0, 0.1, -0.2, 0.1, 4.0, 0.3, -0.2, 0.3, 5.0);
        let centre = Vector3::new(0.2, -0.1, 0.4);
        let data = StandardInputData::rigid(RigidMotion::Spatial, 2.0, centre, inertia).unwrap();
        let state = turning();
        let arm = Vector3::new(0.5, 0.6, -0.7);
        let place = state.position + state.rotation * arm;
        let expected = state.velocity + state.rotation * state.angular_velocity_in_body.cross(&arm);
        let found = MeanMotion::of(&data, &state).velocity_at(&place);
        assert!((found - expected).norm() < 1e-14, "{found} {expected}"); // round-off
    }

    #[test]
    fn parts_of_a_rigid_body_move_as_the_whole() {
        // Two halves of it, each with its share of mass and inertia, in one motion.
        let state = turning();
        let half = |mass: f64, x: f64| {
            let (centre, inertia) =
                (Vector3::new(x, 0.1, -0.2), Matrix3::from_diagonal(&Vector3::new(3.0, 4.0, 4.5)));
            let data = StandardInputData::rigid(RigidMotion::Spatial, mass, centre, inertia).unwrap();
            MeanMotion::of(&data, &state)
        };
        let (left, right) = (half(2.0, -0.5), half(3.0, 0.7));
        let place = Vector3::new(4.0, -1.0, 2.5);
        let together = left.with(&right);
        // Round-off.
        assert!((together.velocity_at(&place) - left.velocity_at(&place)).norm() < 1e-12);
        assert!(together.vibration.abs() < 1e-12, "{}", together.vibration);
        // Halves that move apart share their momenta, and what they have beside it is energy.
        let mut apart = right;
        apart.velocity += Vector3::new(0.0, 1.0, 0.0);
        let together = left.with(&apart);
        let momentum = left.velocity * left.mass + apart.velocity * apart.mass;
        assert!((together.velocity * 5.0 - momentum).norm() < 1e-12);
        let energy = |part: &MeanMotion| {
            let spin = part.angular_velocity.dot(&(part.inertia * part.angular_velocity));
            0.5 * (part.mass * part.velocity.norm_squared() + spin)
        };
        let lost = energy(&left) + energy(&apart) - energy(&together);
        assert!((together.vibration - lost).abs() < 1e-11, "{} {lost}", together.vibration);
        assert!(lost > 0.1);
    }
}
