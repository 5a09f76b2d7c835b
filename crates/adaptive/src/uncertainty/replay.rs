//! An impact repeated with one force along one normal on the masses and modes of a run
//! (docs/theory/uncertainty.md Eqs. U.1, U.2).

use serde::{Deserialize, Serialize};

use super::law::Law;
use crate::record::PeakOf;

/// A mode as the contact meets it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// Squared angular frequency [rad²/s²].
    pub stiffness: f64,
    /// Damping [1/s].
    pub damping: f64,
    /// How far the gap opens by a unit of the coordinate, and the modal force by a unit of the contact's.
    pub share: f64,
    /// What a unit rate of it adds to the speed at which the bodies separate by their momenta (Eq. Q.2); zero of a body that
    /// nothing holds.
    pub carried: f64,
    /// Coordinate and rate at the touch.
    pub start: [f64; 2],
    /// Relative error of the frequency by the mesh.
    pub error: f64,
}

impl Mode {
    /// Frequency \[Hz\].
    pub fn frequency(&self) -> f64 {
        self.stiffness.sqrt() / std::f64::consts::TAU
    }

    /// The mode with the error that is the largest of what `errors` say of its frequency \[Hz\].
    #[must_use]
    pub fn with_error(self, errors: &[impl Fn(f64) -> f64]) -> Self {
        let frequency = self.frequency();
        Self { error: errors.iter().map(|of| of(frequency)).fold(self.error, f64::max), ..self }
    }

    /// The same `time` \[s\] later, without force.
    #[must_use]
    pub fn after(self, time: f64) -> Self {
        let is_later = time > 0.0 && self.start.iter().any(|x| x.abs() > 0.0);
        let start = if is_later { Transition::new(&self, time).step(self.start, 0.0) } else { self.start };
        Self { start, ..self }
    }

    /// The mode with the frequency that a finer mesh would give: a lower one, for meshes that conform (Eq. U.7).
    /// What it yields, `share²/stiffness`, grows with that.
    #[must_use]
    pub fn on_finer_mesh(self) -> Self {
        Self { stiffness: self.stiffness * (1.0 - self.error).max(0.1).powi(2), ..self }
    }

    /// What of it goes into a recorded value `of`, at `[q, rate]` under the force `force`: its acceleration, its rate or its
    /// coordinate.
    pub fn moved(&self, of: PeakOf, [q, rate]: [f64; 2], force: f64) -> f64 {
        match of {
            PeakOf::ReactionForce | PeakOf::ReactionMoment => {
                self.share * force - self.damping * rate - self.stiffness * q
            }
            PeakOf::Speed => rate,
            PeakOf::Displacement | PeakOf::VonMises => q,
        }
    }

    /// What it yields statically [m/N].
    pub fn compliance(&self) -> f64 {
        self.share * self.share / self.stiffness
    }
}

/// What takes a mode over a step with a force that changes evenly: its free vibration, and coordinate and
/// rate by unit forces at the start and the end.
pub(super) struct Transition {
    share: f64,
    free: [[f64; 2]; 2],
    by_force: [[f64; 2]; 2],
}

/// Phase of a step below which what forces do in it is a series: it leaves out 3e-11 of that at most, round-off takes 6e-12 from the
/// closed forms there and more below.
const SLOW: f64 = 1e-2;

impl Transition {
    pub(super) fn new(mode: &Mode, h: f64) -> Self {
        let (stiffness, damping) = (mode.stiffness, mode.damping);
        let bend = stiffness - 0.25 * damping * damping;
        let root = bend.abs().sqrt();
        let (cosine, sine) = match bend > 0.0 {
            true => ((root * h).cos(), (root * h).sin() / root),
            false if root * h < 1e-6 => (1.0, h),
            false => ((root * h).cosh(), (root * h).sinh() / root),
        };
        let fade = (-0.5 * damping * h).exp();
        let [c11, c12] = [fade * (cosine + 0.5 * damping * sine), fade * sine];
        let [c21, c22] = [-stiffness * c12, fade * (cosine - 0.5 * damping * sine)];
        // A constant force and one that grows by one a second from zero.
        let is_slow = stiffness * h * h + damping * h < SLOW * SLOW;
        let by_constant = match is_slow {
            true => h * h * (0.5 - h * damping / 6.0 + h * h * (damping * damping - stiffness) / 24.0),
            false => (1.0 - c11) / stiffness,
        };
        let by_grown = match is_slow {
            true => {
                h * h * h * (1.0 / 6.0 - h * damping / 24.0 + h * h * (damping * damping - stiffness) / 120.0)
            }
            false => (h - c12 - damping * by_constant) / stiffness,
        };
        // The rate by a force is the coordinate by its rate.
        let (constant, grown) = ([by_constant, c12], [by_grown, by_constant]);
        let at_end = grown.map(|x| x * mode.share / h);
        let at_start = [0, 1].map(|i| constant[i] * mode.share - at_end[i]);
        Self { share: mode.share, free: [[c11, c12], [c21, c22]], by_force: [at_start, at_end] }
    }

    fn step(&self, [q, rate]: [f64; 2], force: f64) -> [f64; 2] {
        [0, 1].map(|i| self.free[i][0] * q + self.free[i][1] * rate + self.by_force[0][i] * force)
    }

    /// A step with the forces at its start and its end.
    pub(super) fn forced(&self, at: [f64; 2], [first, last]: [f64; 2]) -> [f64; 2] {
        let at = self.step(at, first);
        [0, 1].map(|i| at[i] + self.by_force[1][i] * last)
    }
}

/// Over which times the impact is repeated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Step \[s\].
    pub step: f64,
    /// End \[s\].
    pub end: f64,
    /// Time over whose means the largest force is sought; zero: in each instant \[s\].
    pub window: f64,
}

/// The masses and modes of an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct Bodies {
    /// Effective mass of the rigid motions; infinite if there are none \[kg\].
    pub mass: f64,
    /// Their closing speed at the touch [m/s].
    pub speed: f64,
    /// The closing speed by the momenta of the bodies, over which the restitution is taken [m/s].
    pub approach: f64,
    /// Modes.
    pub modes: Vec<Mode>,
}

/// Numbers of an impact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Numbers {
    /// Largest force \[N\].
    pub peak_force: f64,
    /// When, after the first contact \[s\].
    pub peak_time: f64,
    /// From the first to the last contact \[s\].
    pub duration: f64,
    /// Impulse [N s].
    pub impulse: f64,
    /// Separating speed of the rigid motions [m/s].
    pub separation_velocity: f64,
    /// Over the closing speed.
    pub restitution: f64,
}

impl Numbers {
    /// Numbers each of which is `value` of the function that reads it from others.
    pub fn each(mut value: impl FnMut(fn(&Self) -> f64) -> f64) -> Self {
        Self {
            peak_force: value(|n| n.peak_force),
            peak_time: value(|n| n.peak_time),
            duration: value(|n| n.duration),
            impulse: value(|n| n.impulse),
            separation_velocity: value(|n| n.separation_velocity),
            restitution: value(|n| n.restitution),
        }
    }
}

/// Motion of the bodies on a grid of times.
struct March {
    h: f64,
    mass: f64,
    approach: f64,
    speed: f64,
    force: f64,
    start: f64,
    transitions: Vec<Transition>,
    coordinates: Vec<[f64; 2]>,
}

impl March {
    fn new(bodies: &Bodies, h: f64) -> Self {
        Self {
            h,
            mass: bodies.mass,
            approach: 0.0,
            speed: bodies.speed,
            force: 0.0,
            start: bodies.modes.iter().map(|m| m.share * m.start[0]).sum(),
            transitions: bodies.modes.iter().map(|m| Transition::new(m, h)).collect(),
            coordinates: bodies.modes.iter().map(|m| m.start).collect(),
        }
    }

    /// Approach by the end of a step without force there, and what a unit force there takes from it.
    fn begin_step(&mut self) -> (f64, f64) {
        let h = self.h;
        let rigid = self.approach + self.speed * h - self.force * h * h / (3.0 * self.mass);
        let (mut opened, mut compliance) = (0.0, h * h / (6.0 * self.mass));
        for (transition, at) in self.transitions.iter().zip(&mut self.coordinates) {
            *at = transition.step(*at, self.force);
            opened += transition.share * at[0];
            compliance += transition.share * transition.by_force[1][0];
        }
        (rigid - (opened - self.start), compliance)
    }

    /// Speed at which the bodies separate by their momenta.
    fn separation(&self, modes: &[Mode]) -> f64 {
        let by_modes = modes.iter().zip(&self.coordinates).map(|(mode, at)| mode.carried * at[1]);
        by_modes.sum::<f64>() - self.speed
    }

    fn end_step(&mut self, force: f64) {
        let h = self.h;
        self.approach += self.speed * h - (2.0 * self.force + force) * h * h / (6.0 * self.mass);
        self.speed -= 0.5 * h * (self.force + force) / self.mass;
        for (transition, at) in self.transitions.iter().zip(&mut self.coordinates) {
            [0, 1].iter().for_each(|i| at[*i] += transition.by_force[1][*i] * force);
        }
        self.force = force;
    }
}

impl Bodies {
    /// Approach beyond what the modes yield under the `forces` \[N\] at instants `h` \[s\] apart, the first
    /// one at the touch (Eq. U.3).
    pub fn approaches(&self, forces: &[f64], h: f64) -> Vec<f64> {
        let mut march = March::new(self, h);
        let steps = forces.iter().skip(1).map(|force| {
            let (free, compliance) = march.begin_step();
            march.end_step(*force);
            free - compliance * force
        });
        std::iter::once(0.0).chain(steps).collect()
    }

    /// The impact with the approach of `law`: its numbers, and the force at the instants of `grid`.
    pub fn replay(&self, law: &Law, grid: Grid) -> (Numbers, Vec<f64>) {
        let Grid { step: h, end, window } = grid;
        let lag = (window / h).round() as usize;
        let (mut impulses, mut forces) = (vec![0.0], vec![0.0]);
        let mut sizes = [0.0; 3];
        let mut march = March::new(self, h);
        let mut numbers = Numbers::default();
        let mut before = 0.0;
        let n_steps = (end / h).ceil() as usize;
        for n in 1..=n_steps {
            let was = march.force;
            let (free, compliance) = march.begin_step();
            let force = law.force(free, compliance, was);
            march.end_step(force);
            numbers.impulse += 0.5 * h * (was + force);
            impulses.push(numbers.impulse);
            let mean = || Some((numbers.impulse - impulses[n.checked_sub(lag)?]) / (h * lag as f64));
            let size = if lag == 0 { force } else { mean().unwrap_or(0.0) };
            forces.push(force);
            sizes = [sizes[1], sizes[2], size];
            if sizes[1] >= numbers.peak_force && sizes[1] > size {
                numbers.peak_time = (n as f64 - 1.0 + top(sizes)) * h - 0.5 * window;
            }
            numbers.peak_force = numbers.peak_force.max(size);
            if was > 0.0 && force <= 0.0 {
                // The force falls to zero like the approach: from there on evenly.
                let share = before / (before - free);
                numbers.duration = (n as f64 - 1.0 + share.clamp(0.0, 1.0)) * h;
                numbers.separation_velocity = march.separation(&self.modes);
            }
            before = if force > 0.0 { free - compliance * force } else { 0.0 };
        }
        if march.force > 0.0 {
            (numbers.duration, numbers.separation_velocity) = (end, march.separation(&self.modes));
        }
        numbers.restitution = numbers.separation_velocity / self.approach;
        (numbers, forces)
    }
}

/// Where the parabola through three values at -1, 0 and 1, of which the middle one is largest, has its top.
fn top([before, at, after]: [f64; 3]) -> f64 {
    let bend = before - 2.0 * at + after;
    if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::law::Power;
    use super::*;

    #[test]
    fn a_mass_on_a_spring_is_right() {
        let bodies = Bodies { mass: 2.0, speed: 3.0, approach: 3.0, modes: Vec::new() };
        let law = Law::shown(Power { factor: 1.0 / 800.0, exponent: 1.0 });
        let omega = 20.0_f64;
        let (found, _) =
            bodies.replay(&law, Grid { step: 1e-3 * PI / omega, end: 1.5 * PI / omega, window: 0.0 });
        // v sqrt(k m) and half a period; the force is linear in a step, (π/1000)²/12 off.
        assert!((found.peak_force / (3.0 * 1600.0_f64.sqrt()) - 1.0).abs() < 2e-6, "{found:?}");
        assert!((found.duration * omega / PI - 1.0).abs() < 2e-6 && (found.restitution - 1.0).abs() < 1e-6);
        assert!((found.impulse - 12.0).abs() < 1e-5);
    }

    #[test]
    fn a_slow_mode_that_carries_momentum_is_a_rigid_motion() {
        let law = Law::shown(Power { factor: 1.0 / 800.0, exponent: 1.0 });
        let grid = Grid { step: 1e-4, end: 0.25, window: 0.0 };
        let rigid = Bodies { mass: 2.0, speed: 3.0, approach: 3.0, modes: Vec::new() };
        // Of unit mass with a share of the root of 1/m; its stiffness moves it by 1e-4 rad meanwhile.
        let share = 0.5_f64.sqrt();
        let slow = Mode {
            stiffness: 2e-7,
            damping: 0.0,
            share,
            carried: share,
            start: [0.0, -3.0 / share],
            error: 0.0,
        };
        let held = Bodies { mass: f64::INFINITY, speed: 0.0, approach: 3.0, modes: vec![slow] };
        let [expected, found] = [rigid, held].map(|bodies| bodies.replay(&law, grid).0);
        for of in
            [|n: &Numbers| n.peak_force, |n: &Numbers| n.separation_velocity, |n: &Numbers| n.restitution]
        {
            assert!((of(&found) / of(&expected) - 1.0).abs() < 1e-5, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn a_mode_moves_as_its_equation_says() {
        // q'' + 0.4 q' + 9 q = 2 (1 + t/2), from 0.3 and 0.1, beside central differences.
        let mode =
            Mode { stiffness: 9.0, damping: 0.4, share: 2.0, carried: 0.0, start: [0.3, 0.1], error: 0.0 };
        let h = 0.5;
        let transition = Transition::new(&mode, h);
        let mut found = transition.step(mode.start, 1.0);
        [0, 1].iter().for_each(|i| found[*i] += transition.by_force[1][*i] * (1.0 + 0.5 * h));
        let n = 100_000;
        let dt = h / f64::from(n);
        let (mut q, mut rate) = (0.3, 0.1);
        for i in 0..n {
            let at = |q: f64, rate: f64, t: f64| 2.0 * (1.0 + 0.5 * t) - 0.4 * rate - 9.0 * q;
            let t = f64::from(i) * dt;
            let middle = rate + 0.5 * dt * at(q, rate, t);
            q += dt * middle;
            rate += dt * at(q - 0.5 * dt * middle, middle, t + 0.5 * dt);
        }
        assert!((found[0] - q).abs() < 1e-8 && (found[1] - rate).abs() < 1e-8, "{found:?} {q} {rate}");
    }

    #[test]
    fn the_law_of_a_record_is_found_again() {
        let mode =
            Mode { stiffness: 900.0, damping: 0.0, share: 0.3, carried: 0.0, start: [0.0; 2], error: 0.0 };
        let bodies = Bodies { mass: 2.0, speed: 3.0, approach: 3.0, modes: vec![mode] };
        let forces: Vec<f64> = (0..200).map(|i| (f64::from(i) * 0.01).sin()).collect();
        let (h, found) = (1e-3, bodies.approaches(&forces, 1e-3));
        // Without modes: v t less the double integral of the force over the mass.
        let rigid = Bodies { modes: Vec::new(), ..bodies };
        let t: f64 = 199.0 * h;
        let expected = 3.0 * t - 0.5 * (t / 10.0 - (10.0 * t).sin() / 100.0);
        assert!((rigid.approaches(&forces, h)[199] - expected).abs() < 1e-6);
        assert!(found[199] < expected);
    }
}
