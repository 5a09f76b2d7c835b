//! Motions that have left what the equations describe: displacements beyond the scenario's or the
//! body's size, deformation and approach faster than waves (docs/theory.md Eqs. P.3, P.4).

use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use crate::error::AdaptiveError;
use crate::model::RunModel;
use crate::record::finding::{BodyQuantity, ContactQuantity};
use crate::spec::RunSettings;
use crate::system::body::{BodyModel, FlexibleModel};
use iga_core::elasticity::Material;

/// A body is lost when it is so many times farther from its start than bodies, given motions and
/// gravity reach.
const LOST: f64 = 1e6;

/// Limits of one body.
#[derive(Debug, Clone, PartialEq)]
struct BodyLimits {
    /// Position of the frame at the start \[m\].
    start: Vector3<f64>,
    /// Size of an elastic body \[m\]; infinite of others.
    size: f64,
    /// Speed of longitudinal waves in a bar of its material [m/s]; infinite of rigid bodies.
    wave_speed: f64,
    /// Largest displacement of a control point in each mode.
    largest: Vec<f64>,
}

/// Limits of displacement, deformation and its rate that end a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MotionLimits {
    bodies: Vec<BodyLimits>,
    /// Largest distance from the start \[m\].
    reach: f64,
}

impl MotionLimits {
    /// Limits of `model`, whose bodies are in the motions `states` at the start.
    pub fn new(model: &RunModel, states: &[BodyState], settings: &RunSettings) -> Self {
        let bodies: Vec<BodyLimits> =
            model.bodies.iter().zip(states).map(|(body, state)| limits(body, state)).collect();
        let centre = bodies.iter().map(|b| b.start).sum::<Vector3<f64>>() / bodies.len().max(1) as f64;
        let largest = |of: &dyn Fn(usize) -> f64| (0..bodies.len()).map(of).fold(0.0, f64::max);
        let sizes = largest(&|b| if bodies[b].size.is_finite() { bodies[b].size } else { 0.0 });
        let spread = largest(&|b| (bodies[b].start - centre).norm());
        let speed = largest(&|b| states[b].velocity.norm());
        let (t, g) = (settings.end_time, settings.gravity.norm());
        // Rigid bodies alone at one place: a metre.
        let size = if sizes + spread > 0.0 { sizes + spread } else { 1.0 };
        Self { reach: LOST * (size + speed * t + g * t * t), bodies }
    }

    /// Checks the motions `states` at time `time`.
    ///
    /// # Errors
    /// [`AdaptiveError::ImplausibleBody`] with the name of the body.
    pub fn check(&self, models: &[BodyModel], states: &[BodyState], time: f64) -> Result<(), AdaptiveError> {
        for (b, (limits, state)) in self.bodies.iter().zip(states).enumerate() {
            let fail = |quantity: BodyQuantity, value: f64, limit: f64| {
                let body = models[b].name.clone();
                Err(AdaptiveError::ImplausibleBody { body, time, quantity, value, limit })
            };
            let moved = (state.position - limits.start).norm();
            if exceeds(moved, self.reach) {
                return fail(BodyQuantity::Distance, moved, self.reach);
            }
            let Some(flexible) = models[b].flexible() else { continue };
            let displacement = largest(flexible, &limits.largest, &state.elastic, limits.size);
            if exceeds(displacement, limits.size) {
                return fail(BodyQuantity::Displacement, displacement, limits.size);
            }
            let speed = largest(flexible, &limits.largest, &state.elastic_rates, limits.wave_speed);
            if exceeds(speed, limits.wave_speed) {
                return fail(BodyQuantity::DeformationSpeed, speed, limits.wave_speed);
            }
        }
        Ok(())
    }
}

/// The error of a contact whose bodies approach each other at `speed`, faster than waves at
/// `limit`, or `None`.
pub fn fast_approach(contact: &str, time: f64, speed: f64, limit: f64) -> Option<AdaptiveError> {
    beyond(contact, time, ContactQuantity::Speed, speed, limit)
}

/// The error of a contact whose bodies have come into each other by `depth`, more than their size
/// `limit`, or `None`.
pub fn deep_penetration(contact: &str, time: f64, depth: f64, limit: f64) -> Option<AdaptiveError> {
    beyond(contact, time, ContactQuantity::Approach, depth, limit)
}

fn beyond(
    contact: &str,
    time: f64,
    quantity: ContactQuantity,
    value: f64,
    limit: f64,
) -> Option<AdaptiveError> {
    let contact = contact.to_owned();
    (value > limit).then_some(AdaptiveError::ImplausibleContact { contact, time, quantity, value, limit })
}

/// Whether `value` is above `limit`, or no number.
fn exceeds(value: f64, limit: f64) -> bool {
    value > limit || value.is_nan()
}

fn limits(body: &BodyModel, state: &BodyState) -> BodyLimits {
    let start = state.position;
    let Some(flexible) = body.flexible() else {
        return BodyLimits { start, size: f64::INFINITY, wave_speed: f64::INFINITY, largest: Vec::new() };
    };
    let shapes = flexible.reduced.shapes();
    BodyLimits {
        start,
        size: flexible.body.size(),
        wave_speed: flexible.body.slowest_material().map_or(f64::INFINITY, Material::bar_speed),
        largest: (0..shapes.ncols()).map(|j| over_nodes(flexible, |unknown| shapes[(unknown, j)])).collect(),
    }
}

/// Largest vector at a node of a field with the values `value` at the unknowns.
fn over_nodes(flexible: &FlexibleModel, value: impl Fn(usize) -> f64) -> f64 {
    let n_components = flexible.motion().n_components();
    let square = |node: usize| -> f64 {
        let unknowns = (0..n_components).filter_map(|c| flexible.lookup().number(node as u32, c));
        unknowns.map(|unknown| value(unknown).powi(2)).sum()
    };
    (0..flexible.body.space().n_functions())
        .map(square)
        .fold(0.0, |m: f64, s| if s > m || s.is_nan() { s } else { m })
        .sqrt()
}

/// Largest value of the field `Σ φ_j x_j` at a node; of its bound `Σ |x_j| max|φ_j|` as long as
/// that is below `limit`.
fn largest(flexible: &FlexibleModel, bounds: &[f64], coordinates: &[f64], limit: f64) -> f64 {
    let bound: f64 = bounds.iter().zip(coordinates).map(|(b, x)| b * x.abs()).sum();
    // Own modes of a fine model may be of another number.
    if bound <= limit || bounds.len() != coordinates.len() {
        return if bound.is_nan() { bound } else { bound.min(limit) };
    }
    let shapes = flexible.reduced.shapes();
    over_nodes(flexible, |unknown| {
        coordinates.iter().enumerate().map(|(j, x)| shapes[(unknown, j)] * x).sum()
    })
}
