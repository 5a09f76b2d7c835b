//! Modes left out (docs/theory/uncertainty.md Eq. U.8).

use std::f64::consts::PI;

use super::law::Law;
use super::replay::{Bodies, Mode, Numbers};
use super::steps::of_velocity;

/// Rates at which an error falls when the highest frequency is doubled that are believed: a half, as of
/// forces that jump, and an eighth.
const RATES: [f64; 2] = [0.125, 0.5];

/// The same bodies with the modes up to a share of the highest frequency, each body its own, and the law
/// with what the others yield statically.
pub fn truncated(bodies: &Bodies, ends: &[usize], law: Law, share: f64) -> (Bodies, Law) {
    let (mut kept, mut more) = (Vec::new(), 0.0);
    let mut start = 0;
    for end in ends {
        let modes = &bodies.modes[start..*end];
        let highest = modes.iter().map(|mode| mode.stiffness).fold(0.0, f64::max);
        let stays = |mode: &&Mode| mode.stiffness <= share * share * highest * (1.0 + 1e-9);
        kept.extend(modes.iter().filter(stays));
        more += modes.iter().filter(|mode| !stays(mode)).map(Mode::compliance).sum::<f64>();
        start = *end;
    }
    (Bodies { modes: kept, ..*bodies }, Law { more: law.more + more, ..law })
}

/// What modes beyond the highest change in a number that is `all` with all modes kept, `half` and `quarter`
/// with those up to half and a quarter of the highest frequency: the changes go on by the rate that they
/// show.
pub fn left_out([all, half, quarter]: [f64; 3]) -> f64 {
    let [last, before] = [all - half, half - quarter].map(f64::abs);
    let last = last.max(RATES[0] * before);
    let rate = (last / before).clamp(RATES[0], RATES[1]);
    if last > 0.0 { last * rate / (1.0 - rate) } else { 0.0 }
}

/// [`left_out`] for each number.
pub fn change(all: &Numbers, half: &Numbers, quarter: &Numbers) -> Numbers {
    Numbers::each(|of| left_out([of(all), of(half), of(quarter)]))
}

/// `change` between flat faces, where no mode is the last that counts: the restitution at least that of the
/// energy of a step of the velocity beyond the highest mode (Eq. C.70), of which `periods` is the period over
/// the time of the force.
pub fn of_jump(change: &Numbers, periods: f64, speed: f64, numbers: &Numbers) -> Numbers {
    let least = of_velocity(speed * periods / (PI * PI), speed, numbers);
    Numbers {
        impulse: change.impulse.max(least.impulse),
        separation_velocity: change.separation_velocity.max(least.separation_velocity),
        restitution: change.restitution.max(least.restitution),
        ..*change
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_go_on_by_their_rate() {
        // Errors of 1, 2, 4: the last is 1.
        assert!((left_out([10.0, 11.0, 13.0]) - 1.0).abs() < 1e-15);
        // A change that happens to vanish is no error of zero.
        assert!(left_out([10.0, 10.0, 11.0]) > 0.01);
        assert!(left_out([1.0; 3]).abs() <= 0.0);
    }

    #[test]
    fn what_is_cut_off_yields_statically() {
        let mode = |stiffness: f64| Mode {
            stiffness,
            damping: 0.0,
            share: 1.0,
            carried: 0.0,
            start: [0.0; 2],
            error: 0.0,
        };
        let bodies = Bodies {
            mass: 1.0,
            speed: 1.0,
            approach: 1.0,
            modes: vec![mode(1.0), mode(4.0), mode(1.0), mode(100.0)],
        };
        let law = Law::shown(super::super::law::Power { factor: 1.0, exponent: 1.0 });
        let (kept, law) = truncated(&bodies, &[2, 4], law, 0.5);
        assert_eq!(kept.modes.len(), 2);
        assert!((law.more - 0.26).abs() < 1e-12);
    }
}
