//! Where the forces of a joint change their form within a step: at the ends of the travel, and about zero velocity where there is friction
//! (docs/theory.md Eq. M.62).

use super::forces::CoordinateForce;
use super::kind::JointKind;

/// Speeds, in terms of that of the transition, between which friction is followed by steps of their own.
const SPEEDS: [f64; 2] = [2.0, 10.0];
/// Places within a step at which the form is compared first; a change that is undone between two of them is not found.
const PLACES: u32 = 8;
/// Bisections between two of these places.
const BISECTIONS: u32 = 40;

/// Positions and velocities of a joint.
pub(crate) type JointState<'a> = (&'a [f64], &'a [f64]);

impl CoordinateForce {
    /// Whether the force has several forms.
    fn has_forms(&self) -> bool {
        self.stop.is_some() || self.friction.is_some()
    }

    /// Number of the form at a position and a velocity; friction of a rotation about a point goes by the speed.
    fn form(&self, position: f64, velocity: f64, speed: f64) -> (i8, i8) {
        let stop = self
            .stop
            .as_ref()
            .map_or(0, |stop| i8::from(position > stop.upper) - i8::from(position < stop.lower));
        let friction = self.friction.as_ref().map_or(0, |friction| {
            let passed = SPEEDS.iter().filter(|share| speed > **share * friction.velocity).count();
            if velocity < 0.0 { -(passed as i8) } else { passed as i8 } // two speeds at most
        });
        (stop, friction)
    }
}

/// Share of a step of size `h` at which the force along coordinate `k` of the state changes its form, on the cubic between both ends.
pub(crate) fn change_of_form(
    kind: JointKind,
    force: &CoordinateForce,
    k: usize,
    (p0, v0): JointState<'_>,
    (p1, v1): JointState<'_>,
    h: f64,
) -> Option<f64> {
    if !force.has_forms() {
        return None;
    }
    let form = |share: f64| {
        let about_a_point = kind.quaternion().filter(|w| k >= *w);
        if let Some(w) = about_a_point {
            let squared = |i: usize| (v0[i] + share * (v1[i] - v0[i])).powi(2);
            return force.form(0.0, 0.0, (w..w + 3).map(squared).sum::<f64>().sqrt());
        }
        let (a, b) = (share, 1.0 - share);
        let change = p1[k] - p0[k];
        let position = p0[k] + a * a * (3.0 - 2.0 * a) * change + a * b * h * (b * v0[k] - a * v1[k]);
        let velocity = 6.0 * a * b * change / h + b * (1.0 - 3.0 * a) * v0[k] + a * (1.0 - 3.0 * b) * v1[k];
        force.form(position, velocity, velocity.abs())
    };
    let first = form(0.0);
    let later = (1..=PLACES).map(|i| f64::from(i) / f64::from(PLACES)).find(|share| form(*share) != first)?;
    let (mut before, mut behind) = (later - 1.0 / f64::from(PLACES), later);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + behind);
        if form(middle) == first {
            before = middle;
        } else {
            behind = middle;
        }
    }
    Some(behind)
}
