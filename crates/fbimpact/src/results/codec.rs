//! Numbers, texts and records as bytes, exact to the last bit: what a restart file holds.

use adaptive::plausibility::ledger::{EnergyLedger, NumericalDamping};
use adaptive::record::{
    ImpactRecord, PhaseKind, PhaseRecord, StressState, TransferDirection, TransferRecord, TrialOutcome,
    TryRecord, ZoneLoad, ZoneSite,
};
use adaptive::run_state::{ContactState, ImpactHistory, RunState};
use adaptive::warning::{Warning, WarningKind};

/// Something that is written to bytes and read back.
pub trait Code: Sized {
    /// Appends the bytes, least significant first.
    fn put(&self, out: &mut Vec<u8>);

    /// Takes the bytes from the front of `from`; `None` if there are too few, or none that mean anything.
    fn take(from: &mut &[u8]) -> Option<Self>;

    /// All bytes.
    fn bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.put(&mut out);
        out
    }

    /// Reads all of `bytes`; `None` if some are left.
    fn read(mut bytes: &[u8]) -> Option<Self> {
        let value = Self::take(&mut bytes)?;
        bytes.is_empty().then_some(value)
    }
}

fn split<'a>(from: &mut &'a [u8], n: usize) -> Option<&'a [u8]> {
    let (front, rest) = from.split_at_checked(n)?;
    *from = rest;
    Some(front)
}

macro_rules! number {
    ($($type:ty),*) => { $(
        impl Code for $type {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }

            fn take(from: &mut &[u8]) -> Option<Self> {
                let bytes = split(from, size_of::<Self>())?;
                bytes.try_into().ok().map(Self::from_le_bytes)
            }
        }
    )* };
}

number!(u8, u32, u64, f64);

impl Code for String {
    fn put(&self, out: &mut Vec<u8>) {
        (self.len() as u64).put(out);
        out.extend(self.as_bytes());
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let n = usize::try_from(u64::take(from)?).ok()?;
        String::from_utf8(split(from, n)?.to_vec()).ok()
    }
}

impl<T: Code> Code for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        (self.len() as u64).put(out);
        self.iter().for_each(|item| item.put(out));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let n = usize::try_from(u64::take(from)?).ok()?;
        // Every item has a byte at least: no length makes this reserve more than there is.
        let mut items = Vec::with_capacity(n.min(from.len()));
        for _ in 0..n {
            items.push(T::take(from)?);
        }
        Some(items)
    }
}

impl<T: Code> Code for Option<T> {
    fn put(&self, out: &mut Vec<u8>) {
        u8::from(self.is_some()).put(out);
        self.iter().for_each(|item| item.put(out));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        match u8::take(from)? {
            0 => Some(None),
            1 => T::take(from).map(Some),
            _ => None,
        }
    }
}

impl<const N: usize> Code for [f64; N] {
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|x| x.put(out));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = f64::take(from)?;
        }
        Some(values)
    }
}

impl Code for PhaseKind {
    fn put(&self, out: &mut Vec<u8>) {
        u8::from(*self == Self::Impact).put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        match u8::take(from)? {
            0 => Some(Self::Free),
            1 => Some(Self::Impact),
            _ => None,
        }
    }
}

/// Records as their fields in order.
macro_rules! fields {
    ($type:ty { $($field:ident),* $(,)? }) => {
        impl $crate::results::codec::Code for $type {
            fn put(&self, out: &mut Vec<u8>) {
                $( self.$field.put(out); )*
            }

            fn take(from: &mut &[u8]) -> Option<Self> {
                Some(Self { $( $field: $crate::results::codec::Code::take(from)? ),* })
            }
        }
    };
}
pub(super) use fields;

fields!(PhaseRecord { kind, start, end, steps, rejected, evaluations, wall_time });
fields!(ImpactRecord {
    contact,
    start,
    end,
    peak_force,
    peak_time,
    impulse,
    approach_velocity,
    separation_velocity,
    restitution,
});
fields!(TryRecord {
    impact,
    number,
    start,
    stop,
    penalty_start,
    penalty_end,
    interval_widths,
    utilisation,
    elements,
    freedoms,
    interface_freedoms,
    steps,
    rejected,
    peak_force,
    outcome,
    reason,
    wall_time,
    cpu_time,
});
fields!(TransferRecord {
    time,
    direction,
    contact,
    energy_before,
    energy_after,
    momentum_change,
    site,
    target_site,
});
/// Enumerations are stored as their numbers in the list of all.
macro_rules! enumerations {
    ($($kind:ty),*) => {$(
        impl Code for $kind {
            fn put(&self, out: &mut Vec<u8>) {
                (*self as u8).put(out);
            }

            fn take(from: &mut &[u8]) -> Option<Self> {
                Self::ALL.get(usize::from(u8::take(from)?)).copied()
            }
        }
    )*};
}
enumerations!(WarningKind, TrialOutcome, TransferDirection);

fields!(Warning { kind, subject, time, value, limit, message, remedy });
fields!(ImpactHistory { width_factor, stiffness_ratio, penalty });
fields!(ContactState { history, smallest_gap, smallest_gap_time });
fields!(NumericalDamping { removed, total });
fields!(EnergyLedger { start, scale, lowered });
fields!(StressState { time, force, elastic, interface_forces, zones });
fields!(ZoneLoad { contact, site, forces });
fields!(ZoneSite { face, centre, widths });
fields!(RunState {
    time,
    state,
    rates,
    step,
    phase,
    n_phases,
    n_impacts,
    n_refined,
    last_output,
    next_output,
    numerical,
    ledger,
    contacts,
    warned,
    stress,
});

#[cfg(test)]
mod tests {
    use super::*;

    fn point() -> RunState {
        RunState {
            time: 0.1,
            state: vec![1.0 / 3.0, -0.0, f64::MIN_POSITIVE / 8.0, f64::INFINITY],
            rates: Vec::new(),
            phase: PhaseRecord { kind: PhaseKind::Impact, steps: 7, ..PhaseRecord::default() },
            n_refined: u64::MAX,
            contacts: vec![
                ContactState::default(),
                ContactState {
                    history: ImpactHistory {
                        width_factor: Some([0.5, 2.0]),
                        stiffness_ratio: None,
                        penalty: Some(1e17),
                    },
                    smallest_gap: f64::NEG_INFINITY,
                    smallest_gap_time: 0.1,
                },
            ],
            stress: vec![
                None,
                Some(StressState {
                    elastic: vec![2.0],
                    zones: vec![ZoneLoad { contact: 1, forces: vec![3.0], ..ZoneLoad::default() }],
                    ..StressState::default()
                }),
            ],
            ..RunState::default()
        }
    }

    #[test]
    fn restart_points_are_read_back_to_the_last_bit() {
        let (bytes, before) = (point().bytes(), point());
        let after = RunState::read(&bytes).expect("readable");
        assert_eq!(after, before);
        let bits = |p: &RunState| p.state.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&after), bits(&before), "the sign of zero, too");
    }

    #[test]
    fn bytes_that_are_too_few_or_too_many_are_refused() {
        let bytes = point().bytes();
        for n in 0..bytes.len() {
            assert_eq!(RunState::read(&bytes[..n]), None, "{n} of {} bytes", bytes.len());
        }
        assert_eq!(RunState::read(&[&bytes[..], &[0]].concat()), None);
        assert_eq!(Vec::<f64>::read(&u64::MAX.bytes()), None);
        assert_eq!(String::read(&[&1_u64.bytes()[..], &[0xff]].concat()), None, "no UTF-8");
    }
}
