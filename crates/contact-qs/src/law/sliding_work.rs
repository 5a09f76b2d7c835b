//! Work of sliding friction (docs/theory.md Eqs. F.12, F.15).

use ffr_dynamics::force::ForceEnergies;

/// Power lost to sliding, and what of its work is recorded at the end of a step
/// ([`ForceEnergies::slid`]).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SlidingWork {
    pub power: f64,
    pub slid: f64,
    pub slid_rate: f64,
}

impl SlidingWork {
    pub fn plus(self, other: Self) -> Self {
        Self {
            power: self.power + other.power,
            slid: self.slid + other.slid,
            slid_rate: self.slid_rate + other.slid_rate,
        }
    }

    /// Enters it in `energies`.
    pub fn enter(self, energies: &mut ForceEnergies) {
        let Self { power, slid, slid_rate } = self;
        *energies =
            ForceEnergies { dissipated_power: power, sliding_power: power, slid, slid_rate, ..*energies };
    }
}
