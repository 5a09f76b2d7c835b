//! Modes left out (docs/theory/uncertainty.md Eq. U.8).

use std::f64::consts::PI;

use super::law::Law;
use super::replay::{Bodies, Mode, Numbers};
use super::steps::of_velocity;

/// Rates at which an error falls when the highest frequency is doubled that are believed: a half, as of
/// forces that jump, and a quarter. So does the energy in waves beyond a frequency f: per frequency it is the square of the
/// force's, f⁻⁵ for one that begins as Hertz's and f⁻⁴ along a line, times what half spaces take up, f² and f.
const RATES: [f64; 2] = [0.25, 0.5];

/// Which of `modes` are those up to a share of the highest frequency, of each body its own; `ends`: where those of each
/// end.
pub fn kept(modes: &[Mode], ends: &[usize], share: f64) -> Vec<bool> {
    let starts = std::iter::once(0).chain(ends.iter().copied());
    let of_body = |(start, end): (usize, &usize)| {
        let modes = &modes[start..*end];
        let highest = modes.iter().map(|mode| mode.stiffness).fold(0.0, f64::max);
        modes.iter().map(move |mode| mode.stiffness <= share * share * highest * (1.0 + 1e-9))
    };
    starts.zip(ends).flat_map(of_body).collect()
}

/// The same bodies with these modes alone, and the law with what the others yield statically.
pub fn truncated(bodies: &Bodies, ends: &[usize], law: Law, share: f64) -> (Bodies, Law) {
    let is_kept = kept(&bodies.modes, ends, share);
    let which = |wanted: bool| bodies.modes.iter().zip(&is_kept).filter(move |(_, kept)| **kept == wanted);
    let more: f64 = which(false).map(|(mode, _)| mode.compliance()).sum();
    let modes = which(true).map(|(mode, _)| *mode).collect();
    (Bodies { modes, ..*bodies }, Law { more: law.more + more, ..law })
}

/// What modes beyond the highest change where those of its upper half change `last` and those of the quarter below `before`:
/// the changes go on by the rate that they show.
pub fn goes_on(last: f64, before: f64) -> f64 {
    let last = last.max(RATES[0] * before);
    let rate = (last / before).clamp(RATES[0], RATES[1]);
    if last > 0.0 { last * rate / (1.0 - rate) } else { 0.0 }
}

/// [`goes_on`] for a number that is `all` with all modes kept, `half` and `quarter` with those up to half and a quarter of the
/// highest frequency.
fn left_out([all, half, quarter]: [f64; 3]) -> f64 {
    goes_on((all - half).abs(), (half - quarter).abs())
}

/// The same for each number.
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
