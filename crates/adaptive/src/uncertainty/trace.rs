//! What is kept of a contact in a trial.

use ffr_dynamics::force::GeneralisedForce;
use nalgebra::Vector3;

use crate::record::Sample;

/// The force of a contact at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Time \[s\].
    pub time: f64,
    /// Normal force \[N\].
    pub force: f64,
    /// Largest penetration of the springs; zero without springs \[m\].
    pub penetration: f64,
}

/// What a contact begins with.
#[derive(Debug, Clone, PartialEq)]
pub struct Beginning {
    /// When \[s\].
    pub time: f64,
    /// Coordinates and rates of the modes of each of its bodies.
    pub modes: Vec<Vec<[f64; 2]>>,
    /// The state of the system; none of one that is too large for bands by its modes.
    pub state: Option<Vec<f64>>,
    /// Places of points and reactions of joints, as in a stored state.
    pub places: Sample,
}

/// All forces on the bodies of a contact at an instant.
#[derive(Debug, Clone)]
pub struct Pressed {
    /// The contact's normal force \[N\].
    pub normal: f64,
    /// Its force on each body \[N\].
    pub own: Vec<Vector3<f64>>,
    /// The sums of all forces on each body.
    pub sums: Vec<GeneralisedForce>,
}

impl Pressed {
    /// Forces of the contact on each body for a unit of its normal force, and whether those of others, as a share of its own, are
    /// within `share` of what they were `before`: then the difference is the contact's alone.
    pub fn pushes(&self, before: &Self, share: f64) -> (Vec<GeneralisedForce>, bool) {
        let mut is_alone = true;
        let bodies = self.sums.iter().zip(&before.sums).zip(self.own.iter().zip(&before.own));
        let pushes = bodies.map(|((now, then), (own, own_then))| {
            let change = now.without(then);
            let others = change.force - (own - own_then);
            is_alone &= others.norm() <= share * own.norm();
            change.scaled((self.normal - before.normal).recip())
        });
        (pushes.collect(), is_alone)
    }

    /// No forces on the same bodies.
    pub fn none(&self) -> Self {
        Self {
            normal: 0.0,
            own: vec![Vector3::zeros(); self.own.len()],
            sums: self.sums.iter().map(|sum| GeneralisedForce::zeros(sum.elastic.len())).collect(),
        }
    }
}

/// What is kept of a contact.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Its beginning.
    pub begun: Option<Beginning>,
    /// Its force.
    pub instants: Vec<Instant>,
    /// All forces at the first instant.
    pub first: Option<Pressed>,
    /// Forces of the contact on each body at the peak, for a unit of its normal force.
    pub pushes: Vec<GeneralisedForce>,
    /// Whether other forces on the bodies are there what they were at the first instant.
    pub is_alone: bool,
    /// Energy at the first instant and at the last \[J\].
    pub energy: Option<[f64; 2]>,
    largest: f64,
}

impl Trace {
    /// Keeps the force at an instant, in place of those from there on if there are some: a step is taken
    /// again; of instants without force that follow each other the first. Returns whether it is the largest.
    pub fn keep(&mut self, now: Instant) -> bool {
        let is_later = self.instants.last().is_none_or(|last| last.force <= 0.0 && last.time < now.time);
        if now.force <= 0.0 && is_later {
            return false;
        }
        if self.instants.last().is_some_and(|last| last.time >= now.time) {
            self.instants.retain(|instant| instant.time < now.time);
            self.largest = self.instants.iter().map(|instant| instant.force).fold(0.0, f64::max);
        }
        self.instants.push(now);
        let is_largest = now.force > self.largest;
        self.largest = self.largest.max(now.force);
        is_largest
    }

    /// Keeps the energy of the run \[J\].
    pub fn keep_energy(&mut self, energy: f64) {
        self.energy = Some([self.energy.map_or(energy, |[first, _]| first), energy]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_is_taken_again_replaces_what_was_kept() {
        let mut trace = Trace::default();
        let at = |time: f64, force: f64| Instant { time, force, penetration: 0.0 };
        assert!(trace.keep(at(1.0, 2.0)) && trace.keep(at(2.0, 5.0)));
        assert!(trace.keep(at(1.5, 3.0)), "the 5 N are gone");
        assert_eq!(trace.instants, [at(1.0, 2.0), at(1.5, 3.0)]);
        assert!(!trace.keep(at(1.8, 3.0)));
    }
}
