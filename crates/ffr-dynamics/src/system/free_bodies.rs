//! Free flexible bodies under force elements (docs/theory.md Eq. D.7 to D.12).
//!
//! A body moves in the rigid motions of its model ([`crate::body::RigidMotion`]); bodies meet only through force elements. Joints are
//! another system's business.

use nalgebra::Vector3;

use super::equations::{BodyWorkspace, active_directions};
use super::error_scale::{BodyScale, ErrorScale};
use super::force::{BodyState, ForceElement, GeneralisedForce, book_work};
use super::layout::BodyLayout;
use crate::body::{ModalDamping, StandardInputData};
use crate::data_error::DataError;
use crate::error::{DynamicsError, EvaluationFailure};
use crate::integration::{KinematicBlock, Linearisation, OdeSystem};
use crate::invariants::{Invariants, centre_of_mass};
use crate::kinematics::rotation::{quaternion_rate, renormalise};

/// A body with its name.
#[derive(Debug, Clone)]
pub struct FreeBody {
    /// Name for messages.
    pub name: String,
    /// Inertia, modes, stiffness, damping.
    pub data: StandardInputData,
}

/// Free bodies, gravity and forces as a system of ordinary differential equations.
///
/// With a concrete type of force element `F` (an enum, for instance) [`FreeBodies::forces_mut`] gives full access to each.
pub struct FreeBodies<F = Box<dyn ForceElement>> {
    bodies: Vec<FreeBody>,
    layouts: Vec<BodyLayout>,
    scales: Vec<BodyScale>,
    gravity: Vector3<f64>,
    forces: Vec<F>,
    error_scale: ErrorScale,
    states: Vec<BodyState>,
    sums: Vec<GeneralisedForce>,
    workspaces: Vec<BodyWorkspace>,
}

impl<F: ForceElement> FreeBodies<F> {
    /// Bodies under `gravity` [m/s²] and force elements.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if gravity is not finite or a damping does not fit its body.
    pub fn new(bodies: Vec<FreeBody>, gravity: Vector3<f64>, forces: Vec<F>) -> Result<Self, DynamicsError> {
        if !gravity.norm().is_finite() {
            return Err(DataError::NotFinite { what: "gravity".into() }.into());
        }
        let mut layouts = Vec::with_capacity(bodies.len());
        let mut offset = 0;
        for body in &bodies {
            check_damping(&body.name, &body.data)?;
            let layout = BodyLayout { offset, n_modes: body.data.n_modes() };
            offset += layout.len();
            layouts.push(layout);
        }
        Ok(Self {
            scales: bodies.iter().map(|b| BodyScale::new(&b.data)).collect::<Result<_, _>>()?,
            states: bodies.iter().map(|b| BodyState::at_rest(b.data.n_modes())).collect(),
            sums: bodies.iter().map(|b| GeneralisedForce::zeros(b.data.n_modes())).collect(),
            workspaces: bodies.iter().map(|b| BodyWorkspace::new(&b.data)).collect(),
            layouts,
            bodies,
            gravity,
            forces,
            error_scale: ErrorScale::default(),
        })
    }

    /// The bodies.
    pub fn bodies(&self) -> &[FreeBody] {
        &self.bodies
    }

    /// Places of the bodies in the state vector.
    pub fn layouts(&self) -> &[BodyLayout] {
        &self.layouts
    }

    /// Gravity [m/s²].
    pub fn gravity(&self) -> &Vector3<f64> {
        &self.gravity
    }

    /// The force elements.
    pub fn forces(&self) -> &[F] {
        &self.forces
    }

    /// The force elements, to be changed. Tell the integrator ([`crate::integration::DormandPrince::invalidate`]).
    pub fn forces_mut(&mut self) -> &mut [F] {
        &mut self.forces
    }

    /// Tolerances of the error norm.
    pub fn error_scale(&self) -> ErrorScale {
        self.error_scale
    }

    /// Changes the tolerances of the error norm.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if one is not positive.
    pub fn set_error_scale(&mut self, scale: ErrorScale) -> Result<(), DynamicsError> {
        self.error_scale = scale.checked()?;
        Ok(())
    }

    /// Highest eigenfrequency of all elastic coordinates, 0 if all bodies are rigid \[Hz\].
    pub fn highest_frequency(&self) -> f64 {
        self.scales.iter().map(BodyScale::highest_squared).fold(0.0, f64::max).sqrt() / std::f64::consts::TAU
    }

    /// State vector of bodies in motion, with quadratures at zero.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit, a number is not finite, or a body moves in a direction that
    /// its model does not have.
    pub fn state_vector(&self, states: &[BodyState]) -> Result<Vec<f64>, DynamicsError> {
        if states.len() != self.bodies.len() {
            let (what, found) = ("initial motions of the bodies".into(), states.len());
            return Err(DataError::Count { what, found, expected: self.bodies.len() }.into());
        }
        let mut y = vec![0.0; self.dimension()];
        for ((body, layout), state) in self.bodies.iter().zip(&self.layouts).zip(states) {
            check_motion(body, state)?;
            layout.write(state, &mut y);
            if let Some(i) =
                y[layout.offset..layout.offset + layout.len()].iter().position(|v| !v.is_finite())
            {
                let what = format!("component {i} of the initial motion of body \"{}\"", body.name);
                return Err(DataError::NotFinite { what }.into());
            }
        }
        Ok(y)
    }

    /// Motion of body `body` in the state `y`. Allocates; see [`FreeBodies::read_body`].
    pub fn body_state(&self, y: &[f64], body: usize) -> BodyState {
        let mut state = BodyState::at_rest(self.layouts[body].n_modes);
        self.read_body(y, body, &mut state);
        state
    }

    /// Reads the motion of body `body` in the state `y` into `state`.
    ///
    /// # Panics
    /// If `state` has another number of elastic coordinates than the body.
    pub fn read_body(&self, y: &[f64], body: usize, state: &mut BodyState) {
        self.layouts[body].read(y, state);
    }

    /// Evaluates the force elements in the state `y`, so that their energies and resultants belong to it.
    ///
    /// After an accepted step they do already, unless something else was evaluated in between. Does not allocate.
    ///
    /// # Errors
    /// [`EvaluationFailure`] of a force element.
    pub fn evaluate_forces(&mut self, t: f64, y: &[f64]) -> Result<(), EvaluationFailure> {
        for (layout, state) in self.layouts.iter().zip(&mut self.states) {
            layout.read(y, state);
        }
        self.sums.iter_mut().for_each(GeneralisedForce::clear);
        for force in &mut self.forces {
            force.apply(t, &self.states, &mut self.sums)?;
        }
        Ok(())
    }

    /// Motions and forces of the bodies at the last evaluation.
    pub fn last_evaluation(&self) -> (&[BodyState], &[GeneralisedForce]) {
        (&self.states, &self.sums)
    }

    /// Energies and momenta of all bodies in the state `y`. Does not allocate.
    pub fn invariants(&mut self, y: &[f64]) -> Invariants {
        let mut sum = Invariants::default();
        for ((body, layout), state) in self.bodies.iter().zip(&self.layouts).zip(&mut self.states) {
            layout.read(y, state);
            sum += Invariants::of_body(&body.data, state, &self.gravity);
        }
        sum
    }

    /// Centre of mass of the deformed body `body` in the state `y`, in the inertial frame \[m\].
    pub fn centre_of_mass(&mut self, y: &[f64], body: usize) -> Vector3<f64> {
        self.layouts[body].read(y, &mut self.states[body]);
        centre_of_mass(&self.bodies[body].data, &self.states[body])
    }

    /// Work lost to modal damping and in force elements since the start \[J\].
    pub fn dissipated_work(&self, y: &[f64]) -> f64 {
        y[self.quadratures()]
    }

    /// Time integral of the resultant of force element `element` since the start [N s].
    pub fn impulse(&self, y: &[f64], element: usize) -> Vector3<f64> {
        let start = self.quadratures() + 1 + 3 * element;
        Vector3::from_column_slice(&y[start..start + 3])
    }

    /// Index of the first quadrature.
    fn quadratures(&self) -> usize {
        self.layouts.last().map_or(0, |l| l.offset + l.len())
    }

    /// Velocity that the motion in `y` is measured with (Eq. T.8) [m/s].
    fn speed(&self, y: &[f64]) -> f64 {
        let speeds = self.bodies.iter().zip(&self.layouts).zip(&self.scales);
        speeds.map(|((b, layout), scale)| scale.speed(&b.data, layout, y)).fold(0.0, f64::max)
    }

    /// Largest error of a body, measured by `size` (of body and speed of the motion), as a share of what is permitted.
    fn largest_error(&self, y0: &[f64], y1: &[f64], size: impl Fn(usize, f64) -> f64) -> f64 {
        let motion = self.speed(y0).max(self.speed(y1)).max(self.error_scale.velocity_floor);
        let mut largest: f64 = 0.0;
        for i in 0..self.bodies.len() {
            let size = size(i, motion);
            // `max` would drop a NaN.
            largest = if size.is_nan() { size } else { largest.max(size) };
            if largest.is_nan() {
                break;
            }
        }
        largest / (self.error_scale.relative * motion)
    }
}

impl<F: ForceElement> OdeSystem for FreeBodies<F> {
    fn dimension(&self) -> usize {
        self.quadratures() + 1 + 3 * self.forces.len()
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), EvaluationFailure> {
        self.evaluate_forces(t, y)?;
        let quadratures = self.quadratures();
        let mut power = 0.0;
        for (i, layout) in self.layouts.iter().enumerate() {
            let (data, state) = (&self.bodies[i].data, &self.states[i]);
            let a = self.workspaces[i].accelerations(data, state, &self.gravity, &self.sums[i])?;
            power += a.dissipated_power;
            dydt[layout.position()].copy_from_slice(state.velocity.as_slice());
            quaternion_rate(&y[layout.rotation()], &state.angular_velocity, &mut dydt[layout.rotation()]);
            dydt[layout.elastic()].copy_from_slice(&state.elastic_rates);
            dydt[layout.velocity()].copy_from_slice(a.translation.as_slice());
            dydt[layout.angular_velocity()].copy_from_slice(a.rotation.as_slice());
            dydt[layout.elastic_rates()].copy_from_slice(a.elastic);
        }
        for (i, force) in self.forces.iter().enumerate() {
            power += force.energies().integrated_power();
            let start = quadratures + 1 + 3 * i;
            dydt[start..start + 3].copy_from_slice(force.resultant().as_slice());
        }
        dydt[quadratures] = power;
        Ok(())
    }

    fn error_norm(&self, y0: &[f64], y1: &[f64], error: &[f64]) -> f64 {
        self.largest_error(y0, y1, |i, speed| self.scales[i].error_speed(&self.layouts[i], y1, error, speed))
    }

    fn damped_error_norm(&self, y0: &[f64], y1: &[f64], error: &[f64]) -> f64 {
        self.largest_error(y0, y1, |i, speed| {
            self.scales[i].damped_error_speed(&self.layouts[i], y1, error, speed)
        })
    }

    fn has_memory(&self) -> bool {
        !self.forces.is_empty()
    }

    fn kinematics(&self) -> Vec<KinematicBlock> {
        self.layouts.iter().flat_map(BodyLayout::kinematics).collect()
    }

    fn linearise(
        &mut self,
        t: f64,
        y: &[f64],
        derivative: &mut Linearisation,
    ) -> Result<(), EvaluationFailure> {
        self.evaluate_forces(t, y)?;
        if !self.forces.iter().all(ForceElement::is_idle) {
            return Ok(()); // forces couple everything: differences find out how
        }
        let mut first = 0;
        for (i, layout) in self.layouts.iter().enumerate() {
            let (data, state) = (&self.bodies[i].data, &self.states[i]);
            for j in first..first + 3 {
                derivative.position_column_mut(j).fill(0.0);
                derivative.velocity_column_mut(j).fill(0.0);
            }
            self.workspaces[i].linearise(data, state, first, derivative)?;
            first += 6 + layout.n_modes;
        }
        Ok(())
    }

    fn project(&mut self, _t: f64, y: &mut [f64]) -> bool {
        let mut changed = false;
        for layout in &self.layouts {
            changed |= renormalise(&mut y[layout.rotation()]);
        }
        changed
    }

    fn book(&mut self, y: &mut [f64], rate: &mut [f64]) {
        book_work(&self.forces, self.quadratures(), y, rate);
    }

    fn save(&mut self) {
        self.forces.iter_mut().for_each(ForceElement::save);
    }

    fn restore(&mut self) {
        self.forces.iter_mut().for_each(ForceElement::restore);
    }
}

/// Refuses damping of another size, or negative.
pub(super) fn check_damping(name: &str, data: &StandardInputData) -> Result<(), DynamicsError> {
    let n_q = data.n_modes();
    let fits = match &data.modal_damping {
        ModalDamping::None => true,
        ModalDamping::PerMode(d) => d.len() == n_q && d.iter().all(|d| *d >= 0.0 && d.is_finite()),
        ModalDamping::Full(d) => d.nrows() == n_q && d.ncols() == n_q && (0..n_q).all(|i| d[(i, i)] >= 0.0),
    };
    if fits {
        return Ok(());
    }
    Err(DataError::Damping { body: name.to_owned(), modes: n_q }.into())
}

/// Refuses motion in directions that the body's model does not have.
fn check_motion(body: &FreeBody, state: &BodyState) -> Result<(), DynamicsError> {
    let n_q = body.data.n_modes();
    if state.elastic.len() != n_q || state.elastic_rates.len() != n_q {
        let (what, found) = (format!("elastic coordinates of body \"{}\"", body.name), state.elastic.len());
        return Err(DataError::Count { what, found, expected: n_q }.into());
    }
    let motion = body.data.motion;
    let v = state.rotation.inverse_transform_vector(&state.velocity);
    let all = [v.x, v.y, v.z, state.angular_velocity.x, state.angular_velocity.y, state.angular_velocity.z];
    let tolerance = 1e-12 * v.norm().max(state.angular_velocity.norm()); // round-off of the rotation
    let forbidden = (0..6).find(|i| !active_directions(motion).contains(i) && all[*i].abs() > tolerance);
    if let Some(i) = forbidden {
        let direction = ["x", "y", "z", "rotation x", "rotation y", "rotation z"][i];
        let what = format!("the initial velocity of body \"{}\" in direction {direction}", body.name);
        let range = "0: its model has no such motion";
        return Err(DataError::OutOfRange { what, value: all[i], range }.into());
    }
    Ok(())
}
