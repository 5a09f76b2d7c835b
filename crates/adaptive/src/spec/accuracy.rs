//! How much error the program allows itself in what it chooses: one knob, whose levels scale its
//! defaults together.
//!
//! What is given by the user is not touched. [`Accuracy::Normal`] multiplies by one everywhere,
//! which changes no bit.

use crate::adaptivity::penalty_search::PEAK_TOLERANCE;

/// A level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Accuracy {
    /// Coarser: for a first look and for wide sweeps.
    Fast,
    /// The defaults as they are.
    #[default]
    Normal,
    /// Finer: to see what the defaults leave out.
    Fine,
}

impl Accuracy {
    /// All levels, the fastest first.
    pub const ALL: [Self; 3] = [Self::Fast, Self::Normal, Self::Fine];

    /// Its name in scenarios.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Normal => "normal",
            Self::Fine => "fine",
        }
    }

    const fn of(self, [fast, normal, fine]: [f64; 3]) -> f64 {
        match self {
            Self::Fast => fast,
            Self::Normal => normal,
            Self::Fine => fine,
        }
    }

    /// Factor on the error of frequencies that a chosen mesh may make.
    pub const fn mesh_error(self) -> f64 {
        self.of([3.0, 1.0, 0.3])
    }

    /// Factor on the frequency up to which modes are chosen for a force, which `jumps` where flat
    /// faces meet. With `fast` it stays above the half at which a run warns of too few modes
    /// (Eq. P.6); of a force that jumps it stays as it is: penalty springs are as stiff as its
    /// modes can follow, and softer ones let the faces overlap by more than
    /// [`crate::adaptivity::overlap::MOST_OVERLAP`].
    pub const fn frequency(self, jumps: bool) -> f64 {
        self.of([if jumps { 1.0 } else { 0.6 }, 1.0, 1.5])
    }

    /// A chosen number of modes that follows no frequency: the least, those of a body without
    /// contacts, the most for a force that jumps. The least stays for `fast`, as few modes cost
    /// little.
    pub fn modes(self, usual: usize) -> usize {
        scaled(usual, self.of([1.0, 1.0, 1.5]))
    }

    /// Elements across a contact zone in place of the `usual` ones: those that touch are as many
    /// fewer or more, the part of the zone that shall touch stays.
    pub fn zone_elements(self, usual: usize) -> usize {
        scaled(usual, self.of([0.625, 1.0, 1.5]))
    }

    /// Factor on the ratio of the stiffness of penalty springs to that of the bodies: as much less
    /// penetration.
    pub const fn stiffness(self) -> f64 {
        self.of([1.0, 1.0, 4.0])
    }

    /// Change of the peak force at which a search for the penalty factor ends.
    pub const fn peak_tolerance(self) -> f64 {
        PEAK_TOLERANCE * self.of([5.0, 1.0, 0.25])
    }

    /// Factor on the error that a time step may make.
    pub const fn step_error(self) -> f64 {
        self.of([10.0, 1.0, 0.1])
    }
}

/// `n` times `factor`, rounded to the nearest.
fn scaled(n: usize, factor: f64) -> usize {
    (n as f64 * factor).round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_level_leaves_every_default_as_it_is() {
        let level = Accuracy::default();
        let frequencies = [true, false].map(|jumps| level.frequency(jumps));
        let others = [level.mesh_error(), level.stiffness(), level.step_error()];
        assert!(frequencies.iter().chain(&others).all(|factor| factor.to_bits() == 1f64.to_bits()));
        assert_eq!([6, 16, 20, 300].map(|n| level.zone_elements(n)), [6, 16, 20, 300]);
        assert_eq!([10, 20, 80].map(|n| level.modes(n)), [10, 20, 80]);
        assert_eq!(level.peak_tolerance().to_bits(), PEAK_TOLERANCE.to_bits());
    }

    #[test]
    fn each_level_is_at_least_as_fine_as_the_one_before() {
        for pair in Accuracy::ALL.windows(2) {
            let [coarse, fine] = [pair[0], pair[1]];
            assert!(coarse.mesh_error() > fine.mesh_error());
            assert!([true, false].iter().all(|jumps| coarse.frequency(*jumps) <= fine.frequency(*jumps)));
            assert!(coarse.modes(20) <= fine.modes(20) && coarse.zone_elements(16) < fine.zone_elements(16));
            assert!(coarse.stiffness() <= fine.stiffness() && coarse.step_error() > fine.step_error());
            assert!(coarse.peak_tolerance() > fine.peak_tolerance());
        }
    }
}
