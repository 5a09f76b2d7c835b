//! Friction of a bearing by the load that the joint transmits (docs/theory.md Eq. M.17 to M.19).
//!
//! The friction is `-μ L g`: `L` a norm of what the joint transmits in the directions that it
//! holds, `g` the direction of sliding, smooth about zero velocity. Loads stand in the axes of the
//! parent's marker, moments about the place of the child's marker, where the bearing is.

use nalgebra::Vector3;

use super::kind::{FreeDirections, JointKind};
use crate::error::DynamicsError;

/// Sliding contact within a joint (Coulomb), by the load on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// Coefficient of friction, not negative.
    pub coefficient: f64,
    /// Radius of the pin, the sleeve or the ball; of a guide the arm at which it holds the moment
    /// about its axis. Zero for a guide that holds that moment without friction \[m\].
    pub radius: f64,
    /// Distance of the two supports along the axis, in the middle between which the child's marker
    /// stands; infinite if moments across the axis are held without friction \[m\].
    pub length: f64,
    /// Mean radius of a pin's collar, which holds the force along the axis; zero if that is held
    /// without friction \[m\].
    pub collar: f64,
    /// Velocity of sliding at which 1/√2 of the friction is reached, positive [m/s].
    pub velocity: f64,
}

/// Force and moment about the bearing, or any two vectors that count like them.
pub(crate) type Load = (Vector3<f64>, Vector3<f64>);

/// What slides in a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// A pin that turns about z.
    Pin,
    /// A slider along z.
    Guide,
    /// A sleeve that turns about z and slides along it.
    Sleeve,
    /// A ball.
    Ball,
}

impl Form {
    fn of(kind: JointKind) -> Option<Self> {
        if kind == JointKind::Axial {
            return None; // nothing is held across the axis of bodies that move along it alone
        }
        let FreeDirections(free) = kind.free_directions();
        match free {
            [false, false, false, false, false, true] => Some(Self::Pin),
            [false, false, true, false, false, false] => Some(Self::Guide),
            [false, false, true, false, false, true] => Some(Self::Sleeve),
            [false, false, false, true, true, true] => Some(Self::Ball),
            _ => None,
        }
    }
}

/// Direction of sliding and its speed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Sliding {
    /// Forces along the joint's velocities by a unit of `μ L`, against which friction acts.
    pub direction: [f64; 6],
    /// Power lost by a unit of `μ L`.
    pub power: f64,
}

/// A bearing in a joint that can have one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointBearing {
    form: Form,
    bearing: Bearing,
}

impl JointBearing {
    /// Coefficient of friction.
    pub(crate) fn coefficient(&self) -> f64 {
        self.bearing.coefficient
    }

    /// Parts of the load (Eq. M.17): it is the sum of the sizes of these vectors, which are linear
    /// in force and moment.
    fn parts(&self, (force, moment): &Load) -> [Vector3<f64>; 3] {
        let Bearing { radius, length, collar, .. } = self.bearing;
        let across = |v: &Vector3<f64>| Vector3::new(v.x, v.y, 0.0);
        let none = Vector3::zeros();
        if self.form == Form::Ball {
            return [force * radius, none, none];
        }
        // Two supports share the force, and hold a moment across as a couple.
        let (half, couple) = (0.5 * across(force), Vector3::new(-moment.y, moment.x, 0.0) / length);
        let (one, other) = (half + couple, half - couple);
        match self.form {
            Form::Pin => [one * radius, other * radius, Vector3::z() * (collar * force.z)],
            Form::Guide if radius > 0.0 => [one, other, Vector3::z() * (moment.z / radius)],
            _ => [one, other, none],
        }
    }

    /// The load `L` on the bearing [N; N m where it only turns].
    pub(crate) fn load(&self, load: &Load) -> f64 {
        self.parts(load).iter().map(Vector3::norm).sum()
    }

    /// Change of the load at `load` by a small `change`; none of a part that vanishes.
    pub(crate) fn derivative(&self, load: &Load, change: &Load) -> f64 {
        let parts = self.parts(load).into_iter().zip(self.parts(change));
        let of_part = |(part, change): (Vector3<f64>, Vector3<f64>)| {
            let size = part.norm();
            if size > 0.0 { part.dot(&change) / size } else { 0.0 }
        };
        parts.map(of_part).sum()
    }

    /// For each velocity of the joint the velocity of sliding by a unit of it, and the force along
    /// it by a unit force of sliding; of what turns alone the load counts with its arm already.
    fn arms(&self) -> ([f64; 3], [f64; 3], usize) {
        let r = self.bearing.radius;
        match self.form {
            Form::Pin => ([r, 0.0, 0.0], [1.0, 0.0, 0.0], 1),
            Form::Guide => ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1),
            Form::Sleeve => ([1.0, r, 0.0], [1.0, r, 0.0], 2),
            Form::Ball => ([r; 3], [1.0; 3], 3),
        }
    }

    /// Speed of sliding [m/s]; of a single velocity with its sign.
    pub(crate) fn speed(&self, velocities: &[f64]) -> f64 {
        let (arms, _, n) = self.arms();
        if n == 1 {
            return arms[0] * velocities[0];
        }
        arms.iter().zip(velocities).take(n).map(|(a, u)| (a * u).powi(2)).sum::<f64>().sqrt()
    }

    /// Direction of sliding (Eq. M.18).
    pub(crate) fn sliding(&self, velocities: &[f64]) -> Sliding {
        let (arms, forces, n) = self.arms();
        let whole = self.speed(velocities).hypot(self.bearing.velocity);
        let mut sliding = Sliding::default();
        for k in 0..n {
            sliding.direction[k] = forces[k] * arms[k] * velocities[k] / whole;
            sliding.power += sliding.direction[k] * velocities[k];
        }
        sliding
    }

    /// Damping of the joint's velocities for small changes about the present ones under the load
    /// `load`; velocities that friction couples count for themselves.
    pub(crate) fn damping(&self, velocities: &[f64], load: f64) -> [f64; 6] {
        let (arms, forces, n) = self.arms();
        let whole = self.speed(velocities).hypot(self.bearing.velocity);
        let mut damping = [0.0; 6];
        for k in 0..n {
            let share = arms[k] * velocities[k] / whole;
            damping[k] =
                self.bearing.coefficient * load * forces[k] * arms[k] * (1.0 - share * share) / whole;
        }
        damping
    }

    /// Velocity of the transition [m/s].
    pub(crate) fn transition(&self) -> f64 {
        self.bearing.velocity
    }
}

/// The bearing in a joint of kind `kind`.
///
/// # Errors
/// [`DynamicsError::Joint`] if the joint can have none, or a number is out of its range.
pub(crate) fn bearing_of(
    joint: &str,
    kind: JointKind,
    bearing: Bearing,
) -> Result<JointBearing, DynamicsError> {
    let fail = |fault: String| Err(DynamicsError::Joint { joint: joint.to_string(), fault });
    let Some(form) = Form::of(kind) else {
        return fail(format!(
            "a {} joint has no bearing with friction by its load; revolute, prismatic, cylindrical and spherical ones have, give others the \
             size of their friction",
            kind.name()
        ));
    };
    let Bearing { coefficient, radius, length, collar, velocity } = bearing;
    let is_size = |x: f64| x >= 0.0 && x.is_finite();
    let is_sound = is_size(coefficient)
        && is_size(radius)
        && is_size(collar)
        && (radius > 0.0 || form == Form::Guide)
        && length > 0.0
        && velocity > 0.0
        && velocity.is_finite();
    if !is_sound {
        return fail(format!(
            "bearing: friction {coefficient}, radius {radius} and collar {collar} must be >= 0, the radius of what turns, length {length} \
             and velocity {velocity} > 0"
        ));
    }
    Ok(JointBearing { form, bearing })
}

#[cfg(test)]
mod tests {
    use super::{Bearing, JointBearing, Load, bearing_of};
    use crate::system::joints::JointKind;
    use nalgebra::Vector3;

    const BEARING: Bearing =
        Bearing { coefficient: 0.3, radius: 0.02, length: 0.05, collar: 0.03, velocity: 0.4 };
    const KINDS: [JointKind; 4] =
        [JointKind::Revolute, JointKind::Prismatic, JointKind::Cylindrical, JointKind::Spherical];

    fn bearing(kind: JointKind) -> JointBearing {
        bearing_of("joint", kind, BEARING).unwrap()
    }

    fn loads() -> [Load; 2] {
        [
            (Vector3::new(3.0, -5.0, 2.0), Vector3::new(0.4, 0.1, -0.3)),
            (Vector3::new(-1.0, 0.5, 4.0), Vector3::new(-0.02, 0.3, 0.2)),
        ]
    }

    #[test]
    fn the_load_is_a_norm_with_its_derivative() {
        let [a, b] = loads();
        for kind in KINDS {
            let bearing = bearing(kind);
            let sum = |s: f64| (a.0 + s * b.0, a.1 + s * b.1);
            assert!(bearing.load(&sum(1.0)) <= bearing.load(&a) + bearing.load(&b));
            let scaled = (-2.5 * a.0, -2.5 * a.1);
            assert!((bearing.load(&scaled) - 2.5 * bearing.load(&a)).abs() < 1e-14 * bearing.load(&scaled));
            let step = 1e-5;
            let difference = (bearing.load(&sum(step)) - bearing.load(&sum(-step))) / (2.0 * step);
            let exact = bearing.derivative(&a, &b);
            // The second derivative of a norm is of the order of the square of the change over the
            // norm, the third by step².
            assert!((difference - exact).abs() < 1e-8 * bearing.load(&b), "{kind:?} {difference} {exact}");
        }
    }

    #[test]
    fn damping_is_the_derivative_of_friction_and_power_that_of_sliding() {
        let velocities = [0.3, -7.0, 12.0, 0.0, 0.0, 0.0];
        let load = 8.0;
        for kind in KINDS {
            let bearing = bearing(kind);
            let step = 1e-5;
            let sliding = bearing.sliding(&velocities);
            let mut power = 0.0;
            for k in 0..kind.n_velocities() {
                let friction = |by: f64| {
                    let mut moved = velocities;
                    moved[k] += by;
                    BEARING.coefficient * load * bearing.sliding(&moved).direction[k]
                };
                let difference = (friction(step) - friction(-step)) / (2.0 * step);
                let exact = bearing.damping(&velocities, load)[k];
                // Friction bends over 0.4 m/s: its third derivative, some load/0.4³, times the
                // square of the step.
                assert!((difference - exact).abs() < 1e-7 * load, "{kind:?} {difference} {exact}");
                power += sliding.direction[k] * velocities[k];
            }
            assert!((power - sliding.power).abs() <= 1e-15 * power);
        }
    }

    #[test]
    fn two_supports_hold_force_and_moment_by_forces_across() {
        // Supports at ±ℓ/2 along the axis with the forces f1, f2: F = f1 + f2, M = ℓ/2 ẑ × (f1 -
        // f2).
        let (one, other) = (Vector3::new(4.0, -1.0, 0.0), Vector3::new(-2.0, 6.0, 0.0));
        let moment = Vector3::z().cross(&(one - other)) * (0.5 * BEARING.length);
        let load = (one + other, moment);
        let exact = one.norm() + other.norm();
        let guide = Bearing { radius: 0.0, ..BEARING };
        let guide = bearing_of("joint", JointKind::Prismatic, guide).unwrap();
        assert!((guide.load(&load) - exact).abs() < 1e-14 * exact);
        let pin = bearing(JointKind::Revolute).load(&load);
        assert!((pin - BEARING.radius * exact).abs() < 1e-14 * pin);
    }
}
