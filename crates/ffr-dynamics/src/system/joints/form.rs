//! Where the forces of a joint change their form within a step: at the ends of the travel, and
//! about zero velocity where there is friction (docs/theory.md Eq. M.22).

use super::bearing::JointBearing;
use super::forces::{CoordinateForce, Friction, Stop};
use super::kind::JointKind;

/// Speeds, in terms of that of the transition, between which friction is followed by steps of their
/// own.
const SPEEDS: [f64; 2] = [2.0, 10.0];
/// Places within a step at which the form is compared first; a change that is undone between two of
/// them is not found.
const PLACES: u32 = 8;
/// Bisections between two of these places.
const BISECTIONS: u32 = 40;

/// Share of a speed at the border of two forms, and of positions at the end of a travel, by which a
/// state may lie beyond it in the form that it comes from: one that stands on a border to the last
/// bit changes its form by more than the round-off of what lies between two states. Velocities
/// between two states are differences of positions, whose round-off counts over the step beside
/// their own.
const SPEED_SLACK: f64 = 1e-9;
const POSITION_SLACK: f64 = 16.0 * f64::EPSILON;

/// Positions and velocities of a joint.
pub(crate) type JointState<'a> = (&'a [f64], &'a [f64]);

/// Number of the form of friction with a transition at `transition` at a velocity along a direction
/// or a speed: how many of the speeds about the transition it passes, two at most, with its sign.
fn form_of_sliding(velocity: f64, transition: f64) -> i8 {
    let passed = SPEEDS.iter().filter(|share| velocity.abs() > **share * transition).count() as i8;
    if velocity < 0.0 { -passed } else { passed }
}

/// Whether a velocity that is known up to `round_off` has the form `first`, or one that is not told
/// from it.
fn slides_as(first: i8, velocity: f64, round_off: f64, transition: f64) -> bool {
    let reach = SPEED_SLACK * velocity.abs() + round_off;
    (form_of_sliding(velocity - reach, transition)..=form_of_sliding(velocity + reach, transition))
        .contains(&first)
}

/// How far velocities within a step of size `h` are known from the positions at its ends, beside
/// [`SPEED_SLACK`].
fn rate_round_off((p0, p1): (f64, f64), h: f64) -> f64 {
    POSITION_SLACK * p0.abs().max(p1.abs()) / h
}

impl CoordinateForce {
    /// Whether the force has several forms.
    fn has_forms(&self) -> bool {
        self.stop.is_some() || self.friction.is_some()
    }

    /// Number of the form at a position and a velocity; in a rotation about a point, at its speed.
    fn form(&self, position: f64, velocity: f64) -> (i8, i8) {
        let of = |friction: &Friction| form_of_sliding(velocity, friction.velocity);
        (self.form_of_stop(position), self.friction.as_ref().map_or(0, of))
    }

    fn form_of_stop(&self, position: f64) -> i8 {
        let of = |stop: &Stop| i8::from(position > stop.upper) - i8::from(position < stop.lower);
        self.stop.as_ref().map_or(0, of)
    }

    /// Whether a state has the form `first`, or one that is not told from it; its velocity is known
    /// up to `round_off`.
    fn has_form(&self, first: (i8, i8), (position, velocity): (f64, f64), round_off: f64) -> bool {
        let reach = self.stop.as_ref().map_or(0.0, |stop| {
            let ends = [stop.lower, stop.upper].into_iter().filter(|end| end.is_finite());
            POSITION_SLACK * ends.fold(position.abs(), |most, end| most.max(end.abs()))
        });
        (self.form_of_stop(position - reach)..=self.form_of_stop(position + reach)).contains(&first.0)
            && self.friction.as_ref().is_none_or(|f| slides_as(first.1, velocity, round_off, f.velocity))
    }
}

/// Share of a step of size `h` at which the force along coordinate `k` of the state changes its
/// form, on the cubic between both ends.
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
    let state = |share: f64| {
        let about_a_point = kind.quaternion().filter(|w| k >= *w);
        if let Some(w) = about_a_point {
            let squared = |i: usize| (v0[i] + share * (v1[i] - v0[i])).powi(2);
            return (0.0, (w..w + 3).map(squared).sum::<f64>().sqrt());
        }
        on_cubic((p0[k], v0[k]), (p1[k], v1[k]), h, share)
    };
    let (position, velocity) = state(0.0);
    let first = force.form(position, velocity);
    let round_off = rate_round_off((p0[k], p1[k]), h);
    first_change(|share| !force.has_form(first, state(share), round_off))
}

/// Share of a step of size `h` from time `t` \[s\] at which the force along a coordinate whose
/// motion is prescribed changes its form.
pub(crate) fn change_of_driven_form(force: &CoordinateForce, t: f64, h: f64) -> Option<f64> {
    let motion = force.motion.as_ref().filter(|_| force.has_forms())?;
    let state = |share: f64| {
        let [position, velocity, _] = motion.at(t + share * h);
        (position, velocity)
    };
    let (start, end) = (state(0.0), state(1.0));
    let (first, round_off) = (force.form(start.0, start.1), rate_round_off((start.0, end.0), h));
    first_change(|share| !force.has_form(first, state(share), round_off))
}

/// Position and velocity at a share of a step of size `h`, on the cubic between both ends.
fn on_cubic((p0, v0): (f64, f64), (p1, v1): (f64, f64), h: f64, share: f64) -> (f64, f64) {
    let (a, b) = (share, 1.0 - share);
    let change = p1 - p0;
    let position = p0 + a * a * (3.0 - 2.0 * a) * change + a * b * h * (b * v0 - a * v1);
    let velocity = 6.0 * a * b * change / h + b * (1.0 - 3.0 * a) * v0 + a * (1.0 - 3.0 * b) * v1;
    (position, velocity)
}

/// Share of a step of size `h` at which a bearing of which no velocity is prescribed begins or
/// ceases to slide, as [`change_of_form`] finds it.
pub(crate) fn change_of_sliding(
    kind: JointKind,
    bearing: &JointBearing,
    (p0, v0): JointState<'_>,
    (p1, v1): JointState<'_>,
    h: f64,
) -> Option<f64> {
    let n = kind.n_velocities();
    let is_position = |k: usize| k < n && kind.quaternion().is_none_or(|w| k < w);
    let speed = |share: f64| {
        bearing.speed(&std::array::from_fn::<f64, 6, _>(|k| match k {
            _ if is_position(k) => on_cubic((p0[k], v0[k]), (p1[k], v1[k]), h, share).1,
            _ if k < n => v0[k] + share * (v1[k] - v0[k]),
            _ => 0.0,
        }))
    };
    let round_off = bearing.speed(&std::array::from_fn::<f64, 6, _>(|k| match is_position(k) {
        true => rate_round_off((p0[k], p1[k]), h),
        false => 0.0,
    }));
    let transition = bearing.transition();
    let first = form_of_sliding(speed(0.0), transition);
    first_change(|share| !slides_as(first, speed(share), round_off, transition))
}

/// Share at which `has_changed` first, just behind the change.
fn first_change(has_changed: impl Fn(f64) -> bool) -> Option<f64> {
    let later = (1..=PLACES).map(|i| f64::from(i) / f64::from(PLACES)).find(|share| has_changed(*share))?;
    let (mut before, mut behind) = (later - 1.0 / f64::from(PLACES), later);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + behind);
        if has_changed(middle) {
            behind = middle;
        } else {
            before = middle;
        }
    }
    Some(behind)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Velocity at which the second speed about the transition is passed, to the last bit.
    const BORDER: f64 = 1.0;

    fn rubbing(stop: Option<Stop>) -> CoordinateForce {
        let friction = Some(Friction { force: 1.0, velocity: BORDER / SPEEDS[1] });
        CoordinateForce { stop, friction, ..CoordinateForce::default() }
    }

    fn change(force: &CoordinateForce, (p0, v0): (f64, f64), (p1, v1): (f64, f64), h: f64) -> Option<f64> {
        change_of_form(JointKind::Revolute, force, 0, (&[p0], &[v0]), (&[p1], &[v1]), h)
    }

    #[test]
    fn a_state_on_a_border_changes_its_form_by_more_than_round_off() {
        let (force, h) = (rubbing(None), 1e-6);
        assert_eq!(form_of_sliding(BORDER, BORDER / SPEEDS[1]), 1);
        // Rates from differences of positions err by round-off over the step, some 1e-10 here.
        for shift in [0.0, 1e-17, -1e-17] {
            assert_eq!(change(&force, (0.3, BORDER), (0.3 + h * BORDER + shift, BORDER), h), None);
        }
        // Over the shortest steps nothing is left of what positions say of a velocity.
        for h in [1e-9, 1e-12, 1e-15] {
            let ends = [0.3 + h * BORDER, (0.3 + h * BORDER).next_up(), (0.3 + h * BORDER).next_down()];
            for end in ends {
                assert_eq!(change(&force, (0.3, BORDER), (end, BORDER), h), None, "{h:e}");
            }
        }
        // What leaves the border is found where it has left it.
        let ends = [(0.3, BORDER), (0.3 + 1.05 * h * BORDER, 1.1 * BORDER)];
        let share = change(&force, ends[0], ends[1], h).expect("a change");
        assert!(share > 0.0 && share < 1e-6, "{share:e}");
    }

    #[test]
    fn a_state_at_the_end_of_its_travel_meets_it_by_more_than_round_off() {
        let force = rubbing(Some(Stop { lower: -1.0, upper: 0.3, stiffness: 1.0, damping: 0.0 }));
        assert_eq!(change(&force, (0.3, 0.0), (0.3 + f64::EPSILON, 0.0), 1e-6), None);
        assert!(change(&force, (0.3, 0.01), (0.3 + 1e-8, 0.01), 1e-6).is_some_and(|share| share < 1e-3));
    }
}
