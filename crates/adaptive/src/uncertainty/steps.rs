//! Time steps and the energy ledger (docs/theory/uncertainty.md Eqs. U.10, U.11).

use super::replay::Numbers;

/// What `share`, the sum of the errors that the steps were allowed as shares of the velocity, changes in the
/// numbers of an impact.
pub fn of_steps(share: f64, speed: f64, numbers: &Numbers) -> Numbers {
    let change = of_velocity(share * speed, speed, numbers);
    Numbers {
        peak_force: share * numbers.peak_force,
        peak_time: share * numbers.duration,
        duration: share * numbers.duration,
        ..change
    }
}

/// What `energy` \[J\] by which the ledger is open changes in the numbers of an impact of the effective mass
/// `mass` \[kg\]: as kinetic energy at the end, and half of its share in the peak.
pub fn of_ledger(energy: f64, (mass, speed): (f64, f64), numbers: &Numbers) -> Numbers {
    let share = energy.abs() / (0.5 * mass * speed * speed);
    let left = numbers.separation_velocity.abs();
    // From a small speed on the energy is the whole of the change.
    let change = ((left * left + share * speed * speed).sqrt() - left).max(0.0);
    let of_end = of_velocity(change, speed, numbers);
    Numbers {
        peak_force: 0.5 * share * numbers.peak_force,
        peak_time: 0.5 * share * numbers.duration,
        duration: 0.5 * share * numbers.duration,
        ..of_end
    }
}

/// What an error of the separating speed means for what follows from it.
pub fn of_velocity(error: f64, speed: f64, numbers: &Numbers) -> Numbers {
    let closing = speed + numbers.separation_velocity;
    Numbers {
        impulse: numbers.impulse.abs() * error / closing,
        separation_velocity: error,
        restitution: error / speed,
        ..Numbers::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_is_that_of_the_separating_speed() {
        let numbers = Numbers {
            peak_force: 1.0,
            peak_time: 0.5,
            duration: 1.0,
            impulse: 4.0,
            separation_velocity: 1.0,
            restitution: 1.0,
        };
        // 2 kg at 1 m/s: 0.01 J more is half a per cent of the speed.
        let found = of_ledger(0.01, (2.0, 1.0), &numbers);
        assert!((found.separation_velocity - (1.01_f64.sqrt() - 1.0)).abs() < 1e-12);
        assert!((found.impulse / 4.0 - 0.5 * found.separation_velocity).abs() < 1e-12);
        let steps = of_steps(1e-6, 1.0, &numbers);
        assert!(steps.impulse > 0.0 && steps.duration > 0.0 && steps.peak_force > 0.0);
    }
}
