//! Size of a local error of a multibody system: in energy, whatever the coordinates (docs/theory.md
//! Eq. M.41, T.7, T.8).
//!
//! Errors of joint and elastic coordinates become motions of the bodies, and count by the energy of
//! those. The choice of joints and frames does not change the size.

use nalgebra::{Matrix3, Vector3};

use super::error_filter::ErrorFilter;
use super::kinematics::{JointKinematics, SpatialVector, frame_velocities, split, update};
use crate::body::StandardInputData;
use crate::error::DynamicsError;
use crate::force::BodyState;
use crate::rotation::rotation_from_slice;
use crate::system::free_body::free_modes::squared_frequencies;
use crate::system::model::{MultibodyModel, TreeBody};

/// Longest length that position errors are compared with, as a share of the body's radius of
/// gyration.
const LENGTH_SHARE: f64 = 1e-2;

/// Inertia of one undeformed body.
#[derive(Debug, Clone)]
struct BodyScale {
    inertia: Matrix3<f64>,
    /// Rows of `C_r` at rest.
    coupling_rotation: Vec<Vector3<f64>>,
    /// Root mean square distance from the centre of mass \[m\].
    radius: f64,
    /// Lowest eigenfrequency of the free body; 0 for rigid bodies [rad/s].
    lowest: f64,
    /// Highest one, squared [rad²/s²].
    highest_squared: f64,
    /// Lowest eigenfrequency among the flexible bodies that it is joined to [rad/s].
    lowest_of_joined: f64,
}

impl BodyScale {
    fn new(data: &StandardInputData) -> Result<Self, DynamicsError> {
        let squared = data.second_moment.trace() / data.mass - data.centre_of_mass().norm_squared();
        let frequencies = squared_frequencies(data)?;
        let lowest = frequencies.iter().copied().fold(f64::INFINITY, f64::min);
        let lowest = if lowest.is_finite() { lowest.sqrt() } else { 0.0 };
        Ok(Self {
            inertia: data.inertia(),
            coupling_rotation: (0..data.n_modes()).map(|j| data.coupling_rotation_at_rest(j)).collect(),
            radius: squared.max(0.0).sqrt(),
            lowest,
            lowest_of_joined: lowest,
            highest_squared: frequencies.iter().copied().fold(0.0, f64::max),
        })
    }

    /// Twice the kinetic energy of a motion of the undeformed body over its mass [m²/s²].
    fn squared_speed(&self, data: &StandardInputData, frame: &SpatialVector, elastic_rates: &[f64]) -> f64 {
        let (v, omega) = split(frame);
        let (mut moved, mut spin) = (omega.cross(&data.mass_moment), self.inertia * omega);
        let terms = data.coupling_translation.iter().zip(&self.coupling_rotation).zip(elastic_rates);
        let mut relative = Vector3::zeros();
        for ((t, r), rate) in terms {
            moved += t * *rate;
            relative += r * *rate;
        }
        spin += 2.0 * relative;
        let twice = data.mass * v.norm_squared()
            + 2.0 * v.dot(&moved)
            + omega.dot(&spin)
            + data.modal_mass.square(elastic_rates);
        twice / data.mass
    }
}

/// Buffers and fixed scales of the norm.
#[derive(Debug, Clone)]
pub(in crate::system) struct TreeNorm {
    scales: Vec<BodyScale>,
    /// Length that stands in for the radius of bodies without extent \[m\].
    length: f64,
    states: Vec<BodyState>,
    edges: Vec<JointKinematics>,
    rates: Vec<f64>,
    /// Errors of velocities, then of positions.
    frames: [Vec<SpatialVector>; 2],
    elastic: Vec<f64>,
    filter: ErrorFilter,
    /// Time, state and speed at the start of a step, which every iteration asks for.
    start: (f64, Vec<f64>, f64),
}

impl TreeNorm {
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] if the inertia of an undeformed body is not.
    pub fn new(
        model: &MultibodyModel,
        states: &[BodyState],
        edges: &[JointKinematics],
    ) -> Result<Self, DynamicsError> {
        let mut scales =
            model.bodies.iter().map(|b| BodyScale::new(&b.data)).collect::<Result<Vec<_>, _>>()?;
        join_scales(&mut scales, &model.groups());
        let arms = model.bodies.iter().flat_map(|b| [b.joint.parent.marker.position, b.joint.child.position]);
        let arm = arms.map(|p| p.norm()).fold(0.0, f64::max);
        let radius = scales.iter().map(|s| s.radius).fold(0.0, f64::max);
        Ok(Self {
            filter: ErrorFilter::new(model, states, edges),
            scales,
            length: if radius > 0.0 { radius } else { arm },
            states: states.to_vec(),
            edges: edges.to_vec(),
            rates: vec![0.0; model.n_rates()],
            frames: [vec![[0.0; 6]; model.bodies.len()], vec![[0.0; 6]; model.bodies.len()]],
            elastic: vec![0.0; model.n_rates()],
            start: (f64::NAN, vec![f64::NAN; model.n_states()], f64::NAN),
        })
    }

    /// Forgets what was derived from tolerances.
    pub fn forget(&mut self) {
        self.filter.forget();
        self.start.1.fill(f64::NAN);
    }

    /// Highest eigenfrequency of the free bodies [rad/s].
    pub fn highest_frequency(&self) -> f64 {
        self.scales.iter().map(|s| s.highest_squared).fold(0.0, f64::max).sqrt()
    }

    /// Velocity of the fastest body in the state `y` (Eq. T.8) [m/s].
    pub fn speed(&mut self, model: &MultibodyModel, t: f64, y: &[f64]) -> f64 {
        update(model, t, y, &mut self.states, &mut self.edges);
        let mut fastest: f64 = 0.0;
        for ((body, scale), state) in model.bodies.iter().zip(&self.scales).zip(&self.states) {
            let v = state.rotation.inverse_transform_vector(&state.velocity);
            let omega = &state.angular_velocity_in_body;
            let frame = [v.x, v.y, v.z, omega.x, omega.y, omega.z];
            let kinetic = scale.squared_speed(&body.data, &frame, &state.elastic_rates);
            let size = kinetic + squared_deformation(&body.data, &state.elastic);
            fastest = fastest.max(size.max(0.0).sqrt());
        }
        fastest
    }

    /// [`TreeNorm::speed`] at the start of a step.
    pub fn speed_at_start(&mut self, model: &MultibodyModel, t: f64, y: &[f64]) -> f64 {
        let y = &y[..model.n_states()];
        let is_known = self.start.0.total_cmp(&t).is_eq()
            && self.start.1.iter().zip(y).all(|(a, b)| a.total_cmp(b).is_eq());
        if !is_known {
            let speed = self.speed(model, t, y);
            self.start.1.copy_from_slice(y);
            (self.start.0, self.start.2) = (t, speed);
        }
        self.start.2
    }

    /// Largest velocity that carries the energy of `error` in one body, at the state of the last
    /// [`TreeNorm::speed`], for motion of velocity `speed` (Eq. M.41) [m/s].
    pub fn error_speed(&mut self, model: &MultibodyModel, error: &[f64], speed: f64) -> f64 {
        self.take(model, error);
        self.largest(model, speed, false)
    }

    /// [`TreeNorm::error_speed`] with ringing counted by its displacement (Eq. M.49); `y0` at `t` is the start of the step, and
    /// `start_speed` the speed there.
    pub fn damped_error_speed(
        &mut self,
        model: &MultibodyModel,
        (t, y0, start_speed): (f64, &[f64], f64),
        error: &[f64],
        speed: f64,
    ) -> f64 {
        self.take(model, error);
        if !self.filter.is_for(y0) {
            let (scales, length) = (&self.scales, self.length);
            self.filter.factorise(model, t, y0, |i| {
                position_rate(&scales[i], length, start_speed, scales[i].lowest_of_joined)
            });
        }
        self.filter.apply(model, &mut self.rates);
        // Elastic energy below the frequency ν is less than that of its displacement, and above it
        // counts no more than that.
        self.largest(model, speed, true)
    }

    /// Sorts an error of the state by rates and positions, both along the rates.
    fn take(&mut self, model: &MultibodyModel, error: &[f64]) {
        for (body, edge) in model.bodies.iter().zip(&self.edges) {
            let layout = &body.layout;
            self.rates[layout.rates_elastic()].copy_from_slice(&error[layout.elastic_rates()]);
            self.rates[layout.rates_joint()].copy_from_slice(&error[layout.velocities()]);
            self.elastic[layout.rates_elastic()].copy_from_slice(&error[layout.elastic()]);
            let joint = &mut self.elastic[layout.rates_joint()];
            position_error(body, &edge.coordinates.positions, &error[layout.positions()], joint);
        }
    }

    /// Largest size of the errors taken; filtered ones (Eq. M.49) are counted without elastic
    /// energy.
    fn largest(&mut self, model: &MultibodyModel, speed: f64, is_filtered: bool) -> f64 {
        let [velocities, positions] = &mut self.frames;
        frame_velocities(model, &self.edges, &self.rates, velocities);
        frame_velocities(model, &self.edges, &self.elastic, positions);
        let mut largest: f64 = 0.0;
        for (i, (body, scale)) in model.bodies.iter().zip(&self.scales).enumerate() {
            let (data, layout) = (&body.data, &body.layout);
            let elastic = &self.elastic[layout.rates_elastic()];
            let lowest = if is_filtered { scale.lowest_of_joined } else { scale.lowest };
            let rate = position_rate(scale, self.length, speed, lowest);
            let deformation = if is_filtered { 0.0 } else { squared_deformation(data, elastic) };
            let size = scale.squared_speed(data, &velocities[i], &self.rates[layout.rates_elastic()])
                + deformation
                + rate * rate * scale.squared_speed(data, &positions[i], elastic);
            // `max` would drop a NaN; a negative sum is round-off of nothing.
            if size.is_nan() {
                return size;
            }
            largest = largest.max(size.max(0.0).sqrt());
        }
        largest
    }
}

/// A position error is worth the velocity that covers it in this rate's time scale (`ν` of Eq. T.8)
/// [1/s].
fn position_rate(scale: &BodyScale, length: f64, speed: f64, lowest: f64) -> f64 {
    let radius = if scale.radius > 0.0 { scale.radius } else { length };
    let by_speed = if radius > 0.0 { speed / (LENGTH_SHARE * radius) } else { 0.0 };
    by_speed.max(lowest)
}

/// Sets the lowest eigenfrequency among joined bodies; `groups` numbers the bodies that are joined
/// to each other alike.
fn join_scales(scales: &mut [BodyScale], groups: &[usize]) {
    for i in 0..scales.len() {
        let joined = scales.iter().zip(groups).filter(|(s, g)| **g == groups[i] && s.lowest > 0.0);
        let lowest = joined.map(|(s, _)| s.lowest).fold(f64::INFINITY, f64::min);
        scales[i].lowest_of_joined = if lowest.is_finite() { lowest } else { 0.0 };
    }
}

/// Twice the elastic energy over the mass [m²/s²].
fn squared_deformation(data: &StandardInputData, elastic: &[f64]) -> f64 {
    data.modal_stiffness.iter().zip(elastic).map(|(k, q)| k * q * q).sum::<f64>() / data.mass
}

/// Error of joint positions as a displacement along the joint's velocities.
fn position_error(body: &TreeBody, positions: &[f64; 7], error: &[f64], displacement: &mut [f64]) {
    let Some(w) = body.joint.kind.quaternion() else {
        displacement.copy_from_slice(error);
        return;
    };
    displacement[..w].copy_from_slice(&error[..w]);
    let rotation = rotation_from_slice(&positions[w..w + 4]);
    let e = nalgebra::Quaternion::new(error[w], error[w + 1], error[w + 2], error[w + 3]);
    let turn = rotation.inverse().into_inner() * e;
    displacement[w..w + 3].copy_from_slice(&[2.0 * turn.i, 2.0 * turn.j, 2.0 * turn.k]);
}
