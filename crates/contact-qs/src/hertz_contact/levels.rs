//! Tangential springs of a Hertz contact: one for the part of the stiffness that comes in between
//! two depths of approach (docs/theory.md Eqs. C.86 to C.88).

use crate::law::TouchLaw;

/// Levels for each doubling of the approach: lengths across the contact differ by 4.4 % from one to
/// the next.
pub(super) const PER_OCTAVE: usize = 8;
/// Approach over the size of the bodies at which the first level ends: below it gaps are round-off.
const LEAST: f64 = 1e-14;
/// Doublings from there: to 0.7 times the size.
const OCTAVES: usize = 46;

/// Depths between which springs lie \[m\].
#[derive(Debug, Clone)]
pub(super) struct Depths(Vec<f64>);

impl Depths {
    /// For bodies of the size `size`.
    pub fn new(size: f64) -> Self {
        let grow = |i: usize| size * LEAST * (i as f64 / PER_OCTAVE as f64).exp2();
        Self(std::iter::once(0.0).chain((0..=PER_OCTAVE * OCTAVES).map(grow)).collect())
    }

    pub fn n_levels(&self) -> usize {
        self.0.len() - 1
    }

    /// Shares of the levels that take part at the approach `approach` in its force under the law `law` (Eq. C.87); of whole
    /// levels, however deep, at an infinite one, the forces say nothing.
    pub fn shares(&self, law: TouchLaw, approach: f64) -> impl Iterator<Item = Share> {
        // Force of the springs down to a depth, and their stiffness.
        let down_to = move |depth: f64| {
            let (force, _, stiffness) = law.at(depth);
            (stiffness * (approach - depth) + force, stiffness)
        };
        let ends = self.0.windows(2).take_while(move |range| range[0] < approach);
        ends.scan(down_to(0.0), move |upper, range| {
            let lower = std::mem::replace(upper, down_to(range[1].min(approach)));
            Some(Share { depth: range[0], force: upper.0 - lower.0, rate: upper.1 - lower.1 })
        })
    }
}

/// A level's share of the normal force and of its rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Share {
    /// Approach at which the level begins \[m\].
    pub depth: f64,
    /// \[N\].
    pub force: f64,
    /// Over the approach: of a whole level its stiffness [N/m].
    pub rate: f64,
}

/// Force of a spring and what it slides (Eq. C.88).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Returned {
    /// Force along both tangents \[N\].
    pub force: [f64; 2],
    /// Slip over the bound, along minus the force [m/N]; zero where the spring sticks.
    pub slip: f64,
}

/// Iterations of Newton's method for the slip, which begins below the root of a concave function
/// and takes one of them where both compliances are equal.
const MAX_ITERATIONS: usize = 60;

/// The force of a spring with the compliances `compliance` along the tangents [m/N] that is
/// stretched by `stretch` \[m\] and holds `bound` at most \[N\]: `(D + γ) τ = -c`, `|τ| <= b`,
/// `γ >= 0`, `γ (|τ| - b) = 0`.
pub(super) fn returned(stretch: [f64; 2], compliance: [f64; 2], bound: f64) -> Returned {
    let force = |slip: f64| [0, 1].map(|a| -stretch[a] / (compliance[a] + slip));
    let held = force(0.0);
    if held[0].hypot(held[1]) <= bound {
        return Returned { force: held, slip: 0.0 };
    }
    if bound <= 0.0 {
        return Returned { force: [0.0; 2], slip: 0.0 };
    }
    let mut slip = (stretch[0].hypot(stretch[1]) / bound - compliance[0].max(compliance[1])).max(0.0);
    for _ in 0..MAX_ITERATIONS {
        let tau = force(slip);
        let size = tau[0].hypot(tau[1]);
        let bend: f64 = (0..2).map(|a| tau[a] * tau[a] / (compliance[a] + slip)).sum();
        let step = size * size / bend * (size / bound - 1.0);
        slip += step;
        if step.abs() <= 4.0 * f64::EPSILON * (slip + compliance[0]) {
            break;
        }
    }
    let tau = force(slip);
    let scale = bound / tau[0].hypot(tau[1]);
    Returned { force: tau.map(|t| t * scale), slip }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{HertzEllipse, LineLaw};

    fn ball() -> TouchLaw {
        TouchLaw::Point(HertzEllipse::new(100.0, 100.0, 4.3e-12).unwrap())
    }

    #[test]
    fn levels_share_the_force_and_its_rate() {
        let depths = Depths::new(0.02);
        let line = TouchLaw::Line(LineLaw::new(50.0, 4.3e-12, 0.02, 0.01).unwrap());
        for law in [ball(), line] {
            for approach in [1e-15, 3e-9, 1e-6, 2.5e-5, 9e-4] {
                let sum =
                    |of: fn(&Share) -> f64| depths.shares(law, approach).map(|share| of(&share)).sum::<f64>();
                let (force, _, stiffness) = law.at(approach);
                // Round-off of sums of hundreds of terms.
                assert!((sum(|s| s.force) / force - 1.0).abs() < 1e-11);
                assert!((sum(|s| s.rate) / stiffness - 1.0).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn springs_obey_coulombs_law() {
        for (stretch, compliance) in
            [([3e-6, -1e-6], [1e-8, 1.3e-8]), ([1e-6, 4e-6], [2e-8, 1e-8]), ([1e-7, 0.0], [1e-8, 1e-8])]
        {
            let bound = 50.0;
            let Returned { force, slip } = returned(stretch, compliance, bound);
            let size = force[0].hypot(force[1]);
            assert!(slip >= 0.0 && size <= bound * (1.0 + 1e-12));
            assert!(slip == 0.0 || (size / bound - 1.0).abs() < 1e-12, "slides below its bound");
            for a in 0..2 {
                // The slip along minus the force: round-off.
                assert!((stretch[a] + (compliance[a] + slip) * force[a]).abs() < 1e-12 * stretch[0].abs());
            }
        }
    }

    /// Cattaneo (1938) and Mindlin (1949): force over displacement of a circular contact under a
    /// normal force that stays, `T = μN (1 - (1 - s/s_1)^(3/2))` with gross slip at
    /// `s_1 = 3 μ N/(2 k_T)`.
    #[test]
    fn shear_of_a_pressed_contact_is_that_of_cattaneo_and_mindlin() {
        let (depths, law, ratio, friction) = (Depths::new(0.02), ball(), 0.8, 0.3);
        for approach in [1.0e-6, 1.05e-6, 1.09e-6] {
            let (normal, _, stiffness) = law.at(approach);
            let gross = 1.5 * friction * normal / (ratio * stiffness);
            for share in [0.1, 0.3, 0.6, 0.9, 1.2] {
                let slide = share * gross;
                let mut force = 0.0;
                let whole = depths.shares(law, f64::INFINITY).map(|share| share.rate);
                for (level, stiffness) in depths.shares(law, approach).zip(whole) {
                    let compliance = 1.0 / (ratio * stiffness);
                    force -= returned([slide, 0.0], [compliance; 2], friction * level.force).force[0];
                }
                let exact = friction * normal * (1.0 - (1.0 - f64::min(share, 1.0)).powf(1.5));
                // The outermost level has its whole stiffness, half of it too much in the mean: 4.4
                // % / 2.
                assert!((force / exact - 1.0).abs() < 0.025, "{share}: {}", force / exact);
            }
        }
    }
}
