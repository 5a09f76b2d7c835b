//! A force element at work: the one place where an element, its state, its workspace and what it
//! found come together.

use std::time::{Duration, Instant};

use nalgebra::Vector3;

use super::{BodyState, Findings, ForceElement, ForceEnergies, GeneralisedForce, Motion};
use crate::error::EvaluationFailure;

/// A force element at work, whatever its kind: what a system asks of it.
///
/// Implemented by [`Active`] alone. What is asked for without an evaluation is that of the last
/// [`ActiveForce::evaluate`].
pub trait ActiveForce: Send {
    /// Adds the forces at `motion` to `forces`. Does not allocate.
    ///
    /// # Errors
    /// As [`ForceElement::evaluate`].
    fn evaluate(
        &mut self,
        motion: Motion<'_>,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure>;

    /// As [`ForceElement::rates`].
    fn rates(&mut self, motion: Motion<'_>, by_velocity: bool, rates: &mut [GeneralisedForce]) -> bool;

    /// Energies and powers found.
    fn energies(&self) -> ForceEnergies;

    /// Resultant found, on the element's first body in the inertial frame \[N\].
    fn resultant(&self) -> Vector3<f64>;

    /// Whether the force found and all its derivatives are zero.
    fn is_idle(&self) -> bool;

    /// Second derivatives found of the element's internal coordinates.
    fn accelerations(&self) -> &[f64];

    /// Accepts what was found at the end of a step, and saves the state.
    fn save(&mut self);

    /// Returns to the saved state after a rejected step.
    fn restore(&mut self);

    /// As [`ForceElement::n_coordinates`].
    fn n_coordinates(&self) -> usize;

    /// As [`ForceElement::coordinate_speed`].
    fn coordinate_speed(&self, internal: &[f64]) -> f64;

    /// As [`ForceElement::clearance`].
    fn clearance(&self, bodies: &[BodyState]) -> Option<f64>;

    /// As [`ForceElement::notes_motions`].
    fn notes_motions(&self) -> bool;

    /// Time spent in evaluations since the start, or since it was taken last.
    fn elapsed(&self) -> Duration;

    /// The same, to be counted from zero again.
    fn take_elapsed(&mut self) -> Duration;
}

/// A force element with its state, its workspace and what its last evaluation found.
pub struct Active<E: ForceElement> {
    element: E,
    state: E::State,
    workspace: E::Workspace,
    found: E::Found,
    elapsed: Duration,
}

/// The parts of an [`Active`] element, to be changed together.
pub struct ActiveParts<'a, E: ForceElement> {
    /// The element.
    pub element: &'a mut E,
    /// Its state.
    pub state: &'a mut E::State,
    /// Its workspace.
    pub workspace: &'a mut E::Workspace,
    /// What its last evaluation found.
    pub found: &'a mut E::Found,
}

impl<E: ForceElement> Active<E> {
    /// Puts `element` to work, before its first evaluation.
    pub fn new(element: E) -> Self {
        let (state, workspace, found) = element.start();
        Self { element, state, workspace, found, elapsed: Duration::ZERO }
    }

    /// The element.
    pub fn element(&self) -> &E {
        &self.element
    }

    /// Its state.
    pub fn state(&self) -> &E::State {
        &self.state
    }

    /// What its last evaluation found.
    pub fn found(&self) -> &E::Found {
        &self.found
    }

    /// All parts.
    pub fn parts(&mut self) -> ActiveParts<'_, E> {
        let Self { element, state, workspace, found, .. } = self;
        ActiveParts { element, state, workspace, found }
    }
}

impl<E: ForceElement> ActiveForce for Active<E> {
    fn evaluate(
        &mut self,
        motion: Motion<'_>,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let start = Instant::now();
        let Self { element, state, workspace, found, .. } = self;
        let outcome = element.evaluate(motion, state, workspace, found, forces);
        self.elapsed += start.elapsed();
        outcome
    }

    fn rates(&mut self, motion: Motion<'_>, by_velocity: bool, rates: &mut [GeneralisedForce]) -> bool {
        let Self { element, state, workspace, found, .. } = self;
        element.rates((motion, by_velocity), state, workspace, found, rates)
    }

    fn energies(&self) -> ForceEnergies {
        self.found.energies()
    }

    fn resultant(&self) -> Vector3<f64> {
        self.found.resultant()
    }

    fn is_idle(&self) -> bool {
        self.found.is_idle()
    }

    fn accelerations(&self) -> &[f64] {
        self.found.accelerations()
    }

    fn save(&mut self) {
        self.element.save(&mut self.state, &self.found);
    }

    fn restore(&mut self) {
        self.element.restore(&mut self.state, &mut self.found);
    }

    fn n_coordinates(&self) -> usize {
        self.element.n_coordinates()
    }

    fn coordinate_speed(&self, internal: &[f64]) -> f64 {
        self.element.coordinate_speed(internal)
    }

    fn clearance(&self, bodies: &[BodyState]) -> Option<f64> {
        self.element.clearance(bodies)
    }

    fn notes_motions(&self) -> bool {
        self.element.notes_motions()
    }

    fn elapsed(&self) -> Duration {
        self.elapsed
    }

    fn take_elapsed(&mut self) -> Duration {
        std::mem::take(&mut self.elapsed)
    }
}
