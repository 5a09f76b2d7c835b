//! The energy ledger as a judge of the run (docs/theory.md Eqs. P.1, P.2).

use serde::{Deserialize, Serialize};

use crate::error::AdaptiveError;
use crate::record::Energies;
use crate::record::finding::LedgerCause;

/// Share of the potential of gravity about the inertial origin that counts as a scale: with
/// tolerances down to 1e-6 its round-off is never taken for an open ledger.
const POTENTIAL: f64 = 1e-9;

/// Share of the largest energy that an implicit integrator may add: at its default tolerance one of
/// order two adds 0.013 in the spin-up of a beam before it takes it back.
const ADDED: f64 = 0.1;

/// How far the ledger is from closing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Imbalance {
    /// Energy that is not accounted for \[J\].
    pub energy: f64,
    /// Largest energy seen, which it is a share of \[J\].
    pub scale: f64,
}

impl Imbalance {
    /// The one as a share of the other; zero where nothing moves.
    pub fn share(&self) -> f64 {
        if self.energy > 0.0 || self.energy.is_nan() { self.energy / self.scale } else { 0.0 }
    }
}

/// Follows the ledger through a run.
///
/// Open is what the total energy has changed by since the start, and what a dissipative integrator
/// has added beyond a tenth of the largest size. The rest of what it does is recorded, shown in the
/// results and not counted: it damps what it does not resolve, and its error is far larger. Jumps
/// at changes of models and of penalty factors are part of the total and do count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyLedger {
    /// Total energy at the start \[J\].
    pub start: Option<f64>,
    /// Largest size of the entries so far, and of the kinetic energy between them \[J\].
    pub scale: f64,
    /// Largest energy of deformation so far, of bodies and contacts \[J\].
    pub elastic: f64,
    /// Energy that changes of penalty factors have taken \[J\].
    pub lowered: f64,
}

impl EnergyLedger {
    /// A ledger of bodies of the mass `mass` \[kg\] whose motion is resolved down to
    /// `velocity_floor` [m/s], with the potential of gravity `potential` about the inertial origin
    /// at the start \[J\].
    pub fn new(mass: f64, velocity_floor: f64, potential: f64) -> Self {
        // A body that is the child of a fixed joint has a finite mass as well; infinite ones do not
        // move.
        let mass = if mass.is_finite() { mass } else { 0.0 };
        let scale = 0.5 * mass * velocity_floor * velocity_floor + POTENTIAL * potential.abs();
        Self { scale, ..Self::default() }
    }

    /// Takes a kinetic energy between two states that are recorded as a scale \[J\].
    pub fn see(&mut self, kinetic: f64) {
        self.scale = self.scale.max(kinetic);
    }

    /// Records a state; how far the ledger is from closing there.
    pub fn record(&mut self, energies: &Energies) -> Imbalance {
        let total = energies.total();
        let start = *self.start.get_or_insert(total);
        self.scale = self.scale.max(energies.size());
        self.elastic = self.elastic.max(energies.elastic_low + energies.elastic_high + energies.penalty);
        let energy = (total - start).abs() + (-energies.numerical - ADDED * self.scale).max(0.0);
        Imbalance { energy, scale: self.scale }
    }

    /// The error of a ledger that misses `imbalance` at time `time`, if that is more than the share
    /// `tolerance`.
    ///
    /// # Errors
    /// [`AdaptiveError::LedgerOpen`].
    pub fn check(&self, imbalance: Imbalance, time: f64, tolerance: f64) -> Result<(), AdaptiveError> {
        let share = imbalance.share();
        if !share.is_nan() && share <= tolerance {
            return Ok(());
        }
        let is_lowered = self.lowered.abs() >= 0.5 * imbalance.energy;
        let cause = if is_lowered { LedgerCause::LoweredPenalty } else { LedgerCause::Resolution };
        Err(AdaptiveError::LedgerOpen {
            time,
            energy: imbalance.energy,
            scale: imbalance.scale,
            share: imbalance.share(),
            tolerance,
            cause,
        })
    }
}

/// Energy that a dissipative integrator removed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct NumericalDamping {
    /// Removed so far \[J\].
    pub removed: f64,
    /// Total energy of the state reported last \[J\].
    pub total: Option<f64>,
}

impl NumericalDamping {
    /// Enters what was removed since the state reported last; `is_dissipative`: an integrator that
    /// damps led from there to here.
    pub fn record(&mut self, energies: &mut Energies, is_dissipative: bool) {
        energies.numerical = self.removed;
        let total = energies.total();
        if let Some(before) = self.total.filter(|_| is_dissipative) {
            self.removed += before - total;
            energies.numerical = self.removed;
        }
        self.total = Some(energies.total());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn energies(kinetic: f64, dissipated: f64, numerical: f64) -> Energies {
        Energies { kinetic, dissipated, numerical, ..Energies::default() }
    }

    #[test]
    fn energy_booked_as_lost_or_removed_leaves_the_ledger_closed() {
        let mut ledger = EnergyLedger::new(1.0, 1e-6, 0.0);
        for (kinetic, dissipated, removed) in [(2.0, 0.0, 0.0), (1.5, 0.5, 0.0), (1.0, 0.5, 0.5)] {
            let imbalance = ledger.record(&energies(kinetic, dissipated, removed));
            // Sums of exact halves.
            assert!(imbalance.energy <= 0.0 && ledger.check(imbalance, 0.0, 1e-6).is_ok(), "{imbalance:?}");
        }
    }

    #[test]
    fn energy_from_nothing_opens_it_whoever_made_it() {
        for (second, by) in [
            (energies(2.1, 0.0, 0.0), "a force"),
            (energies(2.1 / 0.9, 0.0, 2.0 - 2.1 / 0.9), "the integrator"),
        ] {
            let mut ledger = EnergyLedger::new(1.0, 1e-6, 0.0);
            ledger.record(&energies(2.0, 0.0, 0.0));
            let imbalance = ledger.record(&second);
            // The integrator has added a third, of which a tenth of the scale is its error.
            let expected = if by == "a force" { 0.1 / 2.1 } else { 1.0 - 0.9 * 2.0 / 2.1 - 0.1 };
            assert!((imbalance.share() - expected).abs() < 1e-12, "{by}: {imbalance:?}");
            let error = ledger.check(imbalance, 0.5, 1e-3).expect_err(by).to_string();
            assert!(error.contains("simulation.energy_tolerance"), "{error}");
        }
        let mut ledger = EnergyLedger::default();
        let imbalance = ledger.record(&energies(f64::NAN, 0.0, 0.0));
        assert!(ledger.check(imbalance, 0.0, 1e-3).is_err(), "no number");
    }

    #[test]
    fn round_off_of_bodies_at_rest_is_no_energy_from_nothing() {
        // 2 kg at rest a metre above the origin: the potential of 20 J is known to 4e-15 J.
        let mut ledger = EnergyLedger::new(2.0, 1e-6, 20.0);
        ledger.record(&energies(0.0, 0.0, 0.0));
        let imbalance = ledger.record(&energies(4e-15, 0.0, 0.0));
        assert!(ledger.check(imbalance, 1.0, 1e-3).is_ok(), "{imbalance:?}");
    }
}
