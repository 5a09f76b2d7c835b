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

/// The rigid motion that carries the momenta of a body (Eq. Q.2), and what the body does beside it.
/// The choice of the frame of reference does not enter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanMotion {
    /// Mass of the body \[kg\].
    pub mass: f64,
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
        let turn = match data.motion.n_rotations() {
            3 => about_centre.try_inverse().map_or_else(Vector3::zeros, |inverse| inverse * spin),
            1 if about_centre[(2, 2)] > 0.0 => Vector3::z() * (spin.z / about_centre[(2, 2)]),
            _ => Vector3::zeros(),
        };
        let omega = &state.angular_velocity_in_body;
        let rigid = data.mass * velocity.norm_squared() + spin.dot(&turn);
        Self {
            mass: data.mass,
            centre: state.position + state.rotation * centre,
            velocity: state.velocity + state.rotation * (omega.cross(&centre) + velocity),
            angular_velocity: state.rotation * (omega + turn),
            vibration: (0.5 * (data.modal_mass.square(&state.elastic_rates) - rigid)).max(0.0),
        }
    }

    /// Velocity at `place` \[m\], both in the inertial frame [m/s]. Vibration does not enter.
    pub fn velocity_at(&self, place: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.angular_velocity.cross(&(place - self.centre))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::body::RigidMotion;

    #[test]
    fn rigid_velocity_of_a_rigid_body_is_that_of_its_points() {
        let inertia = Matrix3::new(3.0, 0.1, -0.2, 0.1, 4.0, 0.3, -0.2, 0.3, 5.0);
        let centre = Vector3::new(0.2, -0.1, 0.4);
        let data = StandardInputData::rigid(RigidMotion::Spatial, 2.0, centre, inertia).unwrap();
        let state = BodyState {
            position: Vector3::new(0.3, -0.2, 1.0),
            rotation: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.9, 0.2)),
            velocity: Vector3::new(1.0, 2.0, -0.5),
            angular_velocity_in_body: Vector3::new(-3.0, 0.7, 1.9),
            elastic: Vec::new(),
            elastic_rates: Vec::new(),
        };
        let arm = Vector3::new(0.5, 0.6, -0.7);
        let place = state.position + state.rotation * arm;
        let expected = state.velocity + state.rotation * state.angular_velocity_in_body.cross(&arm);
        let found = MeanMotion::of(&data, &state).velocity_at(&place);
        assert!((found - expected).norm() < 1e-14, "{found} {expected}"); // round-off
    }
}
