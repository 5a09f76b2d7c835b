//! Elastic coordinates whose free vibration has a closed form, and what that takes off an explicit
//! method (docs/theory.md Eq. T.9 to T.12).
//!
//! The free vibration under the force at the start of the step is exact, whatever the step; the
//! method integrates what the force changes in it, seen in coordinates that vibrate along.

/// A coordinate `x` with `d²x/dt² = -ω² x - c dx/dt + g`, `g` what the rest of the system adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    /// Place of `x` in the state.
    pub position: usize,
    /// Place of `dx/dt` in the state.
    pub velocity: usize,
    /// Squared angular frequency `ω²` of the undamped vibration [rad²/s²].
    pub squared_frequency: f64,
    /// Damping `c`, less than critical [1/s].
    pub damping: f64,
}

/// Oscillators of a system.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Oscillators<'a> {
    /// All of them.
    pub list: &'a [Oscillator],
    /// Place in the state of the quadrature of `c (dx/dt)²`, summed over them; none where nothing
    /// is damped or recorded.
    pub dissipated: Option<usize>,
}

/// Decay of a vibration within one step, as an exponent, that the method takes: it looks back from
/// the end of a step to its start, which makes round-off larger by the exponential of it.
const LARGEST_DECAY: f64 = 2.0;

/// Angle that a vibration turns in a step from which on the stages no longer see how it turns the
/// changes of the force.
const UNRESOLVED: f64 = std::f64::consts::TAU;

impl Oscillator {
    /// Whether the closed form used here is its vibration: damped less than critically.
    pub fn vibrates(&self) -> bool {
        self.damping >= 0.0 && self.squared_frequency > 0.25 * self.damping * self.damping
    }

    fn turn(&self, time: f64) -> Turn {
        let decay = 0.5 * self.damping;
        let frequency = (self.squared_frequency - decay * decay).sqrt();
        let (sin, cos) = (frequency * time).sin_cos();
        Turn { factor: (-decay * time).exp(), cos, sin: sin / frequency }
    }

    /// State after the turn `turn` of the free vibration from `state`.
    fn rotated(&self, turn: Turn, [x, v]: [f64; 2]) -> [f64; 2] {
        let Turn { factor, cos, sin } = turn;
        let decay = 0.5 * self.damping;
        [
            factor * ((cos + decay * sin) * x + sin * v),
            factor * ((cos - decay * sin) * v - self.squared_frequency * sin * x),
        ]
    }

    /// Twice the energy per modal mass of `state`.
    fn twice_energy(&self, [x, v]: [f64; 2]) -> f64 {
        v * v + self.squared_frequency * x * x
    }
}

/// Free vibration over a time: decay, cosine, and sine over the damped frequency \[s\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Turn {
    factor: f64,
    cos: f64,
    sin: f64,
}

impl Turn {
    fn back(self) -> Self {
        Self { factor: 1.0 / self.factor, cos: self.cos, sin: -self.sin }
    }
}

/// One oscillator in a step.
#[derive(Debug, Clone, Copy)]
struct Course<const STAGES: usize> {
    /// State at the start.
    start: [f64; 2],
    /// Force `g` at the start.
    force: f64,
    /// Free vibration up to each stage.
    turns: [Turn; STAGES],
    /// Rates in coordinates that vibrate along, at each stage.
    rates: [[f64; 2]; STAGES],
    /// What the interpolation of those coordinates adds up, by its four terms.
    dense: [[f64; 2]; 4],
    /// Change of the force since the start, and velocity, at each stage.
    changes: [f64; STAGES],
    speeds: [f64; STAGES],
    /// Terms of the integral of the change.
    change_dense: [f64; 4],
    /// What given forces supply per velocity, at both ends.
    supply: [f64; 2],
}

/// Oscillators in the steps of an explicit method with `STAGES` stages, the last of which is the
/// end of the step.
#[derive(Debug, Clone)]
pub(super) struct Vibration<const STAGES: usize> {
    nodes: [f64; STAGES],
    oscillators: Vec<Oscillator>,
    dissipated: Option<usize>,
    courses: Vec<Course<STAGES>>,
    /// Step that the turns belong to \[s\].
    step: f64,
    /// What the quadrature is short of by its stages, apart from the balance of energies at the
    /// end.
    powers: [f64; STAGES],
    power_dense: [f64; 4],
    /// Place in the state of the quadrature of the power supplied, and its terms by the stages as
    /// far as forces supply it that change evenly.
    supplied: Option<usize>,
    supply_dense: [f64; 4],
    supply: Vec<f64>,
}

impl<const STAGES: usize> Vibration<STAGES> {
    /// For a method with stages at `nodes`, as shares of the step.
    pub fn new(nodes: [f64; STAGES]) -> Self {
        Self {
            nodes,
            oscillators: Vec::new(),
            dissipated: None,
            courses: Vec::new(),
            step: 0.0,
            powers: [0.0; STAGES],
            power_dense: [0.0; 4],
            supplied: None,
            supply_dense: [0.0; 4],
            supply: Vec::new(),
        }
    }

    /// Begins a step from `y`, where rates are `rate`, with the oscillators that the system has
    /// now.
    pub fn begin(&mut self, of: Oscillators<'_>, y: &[f64], rate: &[f64]) {
        self.take_over(of);
        for (o, course) in self.oscillators.iter().zip(&mut self.courses) {
            let [x, v] = [y[o.position], y[o.velocity]];
            course.start = [x, v];
            course.force = rate[o.velocity] + o.squared_frequency * x + o.damping * v;
        }
    }

    /// Takes over the oscillators that the system has now. Allocates if they are more than before.
    pub fn take_over(&mut self, of: Oscillators<'_>) {
        if self.oscillators != of.list {
            self.oscillators.clear();
            self.oscillators.extend_from_slice(of.list);
            self.courses.resize(of.list.len(), Course::blank());
            self.supply.resize(of.list.len(), 0.0);
            self.step = 0.0;
        }
        let is_damped = self.oscillators.iter().any(|o| o.damping > 0.0);
        self.dissipated = of.dissipated.filter(|_| is_damped);
    }

    /// Takes what given forces supply at the start of the step, as [`super::OdeSystem::supply`]
    /// tells it.
    pub fn begin_supply(&mut self, ask: impl FnOnce(&mut [f64]) -> Option<usize>) {
        self.supplied = if self.oscillators.is_empty() { None } else { ask(&mut self.supply) };
        self.keep_supply(0);
    }

    /// The same at the end of the step.
    pub fn end_supply(&mut self, ask: impl FnOnce(&mut [f64]) -> Option<usize>) {
        if self.supplied.is_some() {
            ask(&mut self.supply);
            self.keep_supply(1);
        }
    }

    fn keep_supply(&mut self, end: usize) {
        if self.supplied.is_some() {
            self.courses.iter_mut().zip(&self.supply).for_each(|(course, force)| course.supply[end] = *force);
        }
    }

    /// Longest step that the decay of the vibrations allows \[s\].
    pub fn longest_step(&self) -> f64 {
        let fastest = self.oscillators.iter().map(|o| 0.5 * o.damping).fold(0.0, f64::max);
        LARGEST_DECAY / fastest
    }

    /// Prepares a step of size `h`.
    pub fn prepare(&mut self, h: f64) {
        let is_same = self.step.to_bits() == h.to_bits();
        self.step = h;
        self.powers = [0.0; STAGES];
        for (o, course) in self.oscillators.iter().zip(&mut self.courses) {
            if !is_same {
                for (turn, node) in course.turns.iter_mut().zip(self.nodes) {
                    *turn = o.turn(node * h);
                }
            }
            course.rates[0] = [0.0; 2];
            (course.changes[0], course.speeds[0]) = (0.0, course.start[1]);
            self.powers[0] -= o.damping * course.start[1] * course.start[1];
        }
    }

    /// Sets the oscillators' part of `state` to that of stage `stage`, with the stage's `weights`
    /// (Eq. T.10).
    pub fn place(&self, stage: usize, weights: &[f64], state: &mut [f64]) {
        for (o, course) in self.oscillators.iter().zip(&self.courses) {
            let gained = course.gained(self.step, weights);
            [state[o.position], state[o.velocity]] = course.at(o, course.turns[stage], gained);
        }
    }

    /// Takes the rates `rate` of stage `stage` in the state `state`.
    pub fn take(&mut self, stage: usize, state: &[f64], rate: &[f64]) {
        for (o, course) in self.oscillators.iter().zip(&mut self.courses) {
            let [x, v] = [state[o.position], state[o.velocity]];
            let change = rate[o.velocity] + o.squared_frequency * x + o.damping * v - course.force;
            course.rates[stage] = o.rotated(course.turns[stage].back(), [0.0, change]);
            (course.changes[stage], course.speeds[stage]) = (change, v);
            self.powers[stage] += (change - o.damping * v) * v;
        }
    }

    /// Sets the oscillators' part of the error `error` of the step, with the `weights` of the error
    /// and of the step (Eq. T.11).
    pub fn place_error(&self, weights: &[f64], of_step: &[f64], error: &mut [f64]) {
        for (o, course) in self.oscillators.iter().zip(&self.courses) {
            let (estimate, gained) = (course.gained(self.step, weights), course.gained(self.step, of_step));
            let angle = self.step * o.squared_frequency.sqrt();
            let unseen = (angle / UNRESOLVED).powi(5).min(1.0);
            let sum = [estimate[0] + unseen * gained[0], estimate[1] + unseen * gained[1]];
            [error[o.position], error[o.velocity]] = o.rotated(course.turns[STAGES - 1], sum);
        }
    }

    /// Ends the step in `state`: adds what the quadrature of the damping is short of (Eq. T.12),
    /// and prepares the interpolation from the `weights` of the step and of the last term of the
    /// dense output.
    pub fn end(&mut self, weights: &[f64], last_term: &[f64], state: &mut [f64]) {
        let h = self.step;
        for course in &mut self.courses {
            let (gained, last) = (course.gained(h, weights), course.gained(h, last_term));
            let end = course.rates[STAGES - 1];
            let part = |i: usize| dense_terms(gained[i], [0.0, h * end[i]], last[i]);
            let [x, v] = [part(0), part(1)];
            course.dense = std::array::from_fn(|k| [x[k], v[k]]);
        }
        if let Some(place) = self.dissipated {
            let sum = |weights: &[f64]| h * weights.iter().zip(&self.powers).map(|(w, p)| w * p).sum::<f64>();
            let slopes = [h * self.powers[0], h * self.powers[STAGES - 1]];
            self.power_dense = dense_terms(sum(weights), slopes, sum(last_term));
            state[place] += sum(weights) + self.balance(|o, _| [state[o.position], state[o.velocity]]);
        }
    }

    /// Adds to the quadrature of the power supplied what its stages are short of (Eq. T.33), and
    /// prepares its interpolation; arguments as of [`Self::end`], behind it.
    pub fn end_supplied(&mut self, weights: &[f64], last_term: &[f64], state: &mut [f64]) {
        let Some(place) = self.supplied else { return };
        let h = self.step;
        let mut powers = [0.0; STAGES];
        for course in &mut self.courses {
            let sum = |weights: &[f64]| {
                h * weights.iter().zip(&course.changes).map(|(w, change)| w * change).sum::<f64>()
            };
            let slopes = [0.0, h * course.changes[STAGES - 1]];
            course.change_dense = dense_terms(sum(weights), slopes, sum(last_term));
            for ((power, speed), node) in powers.iter_mut().zip(&course.speeds).zip(self.nodes) {
                *power += course.supply_at(node) * speed;
            }
        }
        let sum = |weights: &[f64]| h * weights.iter().zip(&powers).map(|(w, p)| w * p).sum::<f64>();
        let slopes = [h * powers[0], h * powers[STAGES - 1]];
        self.supply_dense = dense_terms(sum(weights), slopes, sum(last_term));
        state[place] += self.unseen_supply(1.0, |o, _| [state[o.position], state[o.velocity]]);
    }

    /// Work that forces have supplied which change evenly over the step, up to its share `theta`,
    /// without what the stages have seen of it (Eq. T.33).
    fn unseen_supply(&self, theta: f64, state: impl Fn(&Oscillator, &Course<STAGES>) -> [f64; 2]) -> f64 {
        let time = theta * self.step;
        let work = self.oscillators.iter().zip(&self.courses).map(|(o, course)| {
            let ([x0, v0], [x, v]) = (course.start, state(o, course));
            let impulse = course.force * time + horner(course.change_dense, theta);
            let way = (impulse - (v - v0) - o.damping * (x - x0)) / o.squared_frequency;
            let [first, last] = course.supply;
            course.supply_at(theta) * x - first * x0 - (last - first) / self.step * way
        });
        work.sum::<f64>() - horner(self.supply_dense, theta)
    }

    /// Sets the oscillators' part of `out`, the interpolation at the share `theta` of the last
    /// step, and adds to the quadrature what its stages are short of.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        for (o, course) in self.oscillators.iter().zip(&self.courses) {
            [out[o.position], out[o.velocity]] = course.between(o, theta, self.step);
        }
        if let Some(place) = self.dissipated {
            let part = horner(self.power_dense, theta);
            out[place] += part + self.balance(|o, course| course.between(o, theta, self.step));
        }
        if let Some(place) = self.supplied {
            out[place] += self.unseen_supply(theta, |o, course| course.between(o, theta, self.step));
        }
    }

    /// Energy that the oscillators have lost since the start, with the work of the forces that
    /// acted there.
    fn balance(&self, state: impl Fn(&Oscillator, &Course<STAGES>) -> [f64; 2]) -> f64 {
        let lost = self.oscillators.iter().zip(&self.courses).map(|(o, course)| {
            let now = state(o, course);
            0.5 * (o.twice_energy(course.start) - o.twice_energy(now))
                + course.force * (now[0] - course.start[0])
        });
        lost.sum()
    }
}

impl<const STAGES: usize> Course<STAGES> {
    fn blank() -> Self {
        Self {
            start: [0.0; 2],
            force: 0.0,
            turns: [Turn::default(); STAGES],
            rates: [[0.0; 2]; STAGES],
            dense: [[0.0; 2]; 4],
            changes: [0.0; STAGES],
            speeds: [0.0; STAGES],
            change_dense: [0.0; 4],
            supply: [0.0; 2],
        }
    }

    /// What given forces supply per velocity at the share `theta` of the step, if they change
    /// evenly.
    fn supply_at(&self, theta: f64) -> f64 {
        let [first, last] = self.supply;
        first + theta * (last - first)
    }

    /// `h Σ weights_i rates_i`.
    fn gained(&self, h: f64, weights: &[f64]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (weight, rate) in weights.iter().zip(&self.rates) {
            sum[0] += weight * rate[0];
            sum[1] += weight * rate[1];
        }
        sum.map(|s| h * s)
    }

    /// State after `turn` from the start, with `gained` in coordinates that vibrate along.
    fn at(&self, o: &Oscillator, turn: Turn, gained: [f64; 2]) -> [f64; 2] {
        let rest = self.force / o.squared_frequency;
        let [x, v] = o.rotated(turn, [self.start[0] - rest + gained[0], self.start[1] + gained[1]]);
        [x + rest, v]
    }

    fn between(&self, o: &Oscillator, theta: f64, h: f64) -> [f64; 2] {
        let gained = [0, 1].map(|i| horner(self.dense.map(|term| term[i]), theta));
        self.at(o, o.turn(theta * h), gained)
    }
}

/// Terms of the dense output (Eq. T.2) of a coordinate that starts at zero, gains `gained`, has the
/// slopes `slopes` per step at the two ends, and the last term `last`.
fn dense_terms(gained: f64, slopes: [f64; 2], last: f64) -> [f64; 4] {
    let third = slopes[0] - gained;
    [gained, third, gained - slopes[1] - third, last]
}

/// Dense output (Eq. T.2) from its terms.
fn horner([d1, d2, d3, d4]: [f64; 4], theta: f64) -> f64 {
    let rest = 1.0 - theta;
    theta * (d1 + rest * (d2 + theta * (d3 + rest * d4)))
}
