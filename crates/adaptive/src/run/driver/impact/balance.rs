//! What a change of the model in the course of an impact costs: energy and momentum before and
//! after, penalty factors lowered on the way.

use nalgebra::Vector3;

use crate::adaptivity::penalty_search::{PenaltyAction, RunOutcome};
use crate::error::AdaptiveError;
use crate::record::{Sample, TransferDirection, TransferRecord};
use crate::run::driver::Driver;
use crate::state::simulation::fill_sample;

/// Energy and momentum, which a change of the model should leave alone.
#[derive(Debug, Clone)]
pub(crate) struct Balance {
    /// Total energy \[J\].
    pub energy: f64,
    /// Linear momentum [kg m/s].
    pub momentum: Vector3<f64>,
}

impl Driver<'_> {
    /// Goes on in the present state with lower penalty factors after an error of the contact
    /// solver, if the search says so: as low as the present state asks for (\[A\] section 4.1).
    /// Records the jump of energy.
    pub(crate) fn lower_penalty(&mut self) -> Result<bool, AdaptiveError> {
        let (t, y) = (self.integrator.time(), self.integrator.state().to_vec());
        let before = self.stored_balance();
        let mut lowered = Vec::new();
        loop {
            lowered.clear();
            for i in 0..self.slots.len() {
                let Some(search) = self.slots[i].fine_mut().map(|f| &mut f.search) else { continue };
                if !search.is_resuming() {
                    continue;
                }
                if let PenaltyAction::Resume { penalty } = search.next(RunOutcome::SolverError) {
                    self.set_penalty(i, penalty)?;
                    lowered.push(i);
                }
            }
            if lowered.is_empty() {
                return Ok(false);
            }
            match self.model.system.evaluate_forces(t, &y) {
                Ok(()) => break,
                Err(refusal) if refusal.kind().may_depend_on_penalty() => {}
                Err(refusal) => return Err(AdaptiveError::refused(t, refusal)),
            }
        }
        // The forces were evaluated just now; Algorithm 1 may refuse a second time what it took
        // once.
        let after = self.evaluated_balance();
        // One jump, recorded with the first contact.
        for (n, i) in lowered.into_iter().enumerate() {
            self.record_transfer(
                i,
                TransferDirection::Penalty,
                if n == 0 { &before } else { &after },
                &after,
            );
        }
        self.run.ledger.lowered += after.energy - before.energy;
        self.lowered = Some((t, after));
        self.measure_dents(t);
        self.local_deformation.restart_differences(t);
        self.integrator.restart(t, &y);
        // No curve through forces of both factors.
        self.begin_monitors(0..self.slots.len())?;
        Ok(true)
    }

    /// Gives contact `i` another penalty factor [N/m³].
    pub(crate) fn set_penalty(&mut self, i: usize, penalty: f64) -> Result<(), AdaptiveError> {
        let outcome = self.model.system.forces_mut()[i].contact.set_penalty(penalty);
        outcome
            .map_err(|source| AdaptiveError::Contact { contact: self.model.contacts[i].name.clone(), source })
    }

    /// Energy and momentum of the present state as it was found when the state was reached or the
    /// factor lowered last: forces may not be evaluated any more.
    fn stored_balance(&mut self) -> Balance {
        let is_now = |t: f64| t.to_bits() == self.integrator.time().to_bits();
        if let Some((_, balance)) = self.lowered.as_ref().filter(|(t, _)| is_now(*t)) {
            return balance.clone();
        }
        // At the start of a trial the sample is the last one of the trial before.
        if !is_now(self.output.sample.time)
            && let Ok(balance) = self.present_balance()
        {
            return balance;
        }
        let momentum = Vector3::from(self.output.sample.linear_momentum);
        let energies = &self.output.sample.energies;
        Balance { energy: energies.total() - energies.numerical, momentum }
    }

    /// Energy and momentum of the present state, whose forces are evaluated for it.
    pub(crate) fn present_balance(&mut self) -> Result<Balance, AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.state());
        self.evaluate(self.integrator.time())?;
        Ok(self.evaluated_balance())
    }

    /// Energy and momentum of the present state, which the forces were evaluated at last.
    fn evaluated_balance(&mut self) -> Balance {
        let (t, mut sample) = (self.integrator.time(), Sample::default());
        self.interpolated.copy_from_slice(self.integrator.state());
        fill_sample(&mut self.model.system, &self.model.observed, t, &self.interpolated, &mut sample);
        sample.energies.gravity -= self.gravity_datum;
        Balance { energy: sample.energies.total(), momentum: Vector3::from(sample.linear_momentum) }
    }

    /// Records a change of the model of contact `i`, with what the balance was before and after.
    pub(crate) fn record_transfer(
        &mut self,
        i: usize,
        direction: TransferDirection,
        before: &Balance,
        after: &Balance,
    ) {
        // Where a fine model lies is recorded when it is activated.
        let coming = self.slots[i].fine().filter(|_| direction == TransferDirection::CoarseToFine);
        let site = |k: usize| coming.and_then(|fine| fine.zones.get(k)).map(|zone| zone.site);
        let record = TransferRecord {
            time: self.integrator.time(),
            direction,
            contact: i as u32,
            energy_before: before.energy,
            energy_after: after.energy,
            momentum_change: (after.momentum - before.momentum).norm(),
            site: site(0),
            target_site: site(1),
            offset: coming.map_or(0.0, |fine| fine.offset),
        };
        self.output.transfer(record);
    }
}
