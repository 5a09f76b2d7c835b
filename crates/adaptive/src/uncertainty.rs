//! By how much the numbers of an impact may be off because of what a run is resolved to: penalty factor,
//! zone, mesh, modes, time steps (docs/theory/uncertainty.md).
//!
//! Knows what a run recorded of one impact; does not know the run, which is not changed by what is found
//! here. Each source has its file: what it changes in the impact as it is repeated with one force along one
//! normal ([`replay`]).

pub mod trace;
pub mod law;
pub mod replay;
pub mod penalty;
pub mod zone;
pub mod mesh;
pub mod steps;
pub mod modes;
pub mod ringing;
pub mod response;
pub mod accuracy;

use serde::{Deserialize, Serialize};

use crate::record::band::{Band, NoBand, Source};
use crate::touch::parts::TouchKind;
use law::{Law, Power};
use replay::{Bodies, Grid, Mode, Numbers};
use trace::Instant;
use zone::ZoneEstimate;

/// What a run recorded of an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence<'a> {
    /// Its numbers.
    pub numbers: Numbers,
    /// First contact \[s\].
    pub start: f64,
    /// The force from there on.
    pub instants: &'a [Instant],
    /// Masses and modes of its bodies, modes in the order of the bodies.
    pub bodies: Bodies,
    /// Where the modes of each body end in that list.
    pub ends: Vec<usize>,
    /// How the yield at the touch is known.
    pub zone: ZoneEstimate,
    /// Which parts touched.
    pub touch: TouchKind,
    /// Points across that carried the peak.
    pub across: f64,
    /// The lower of the highest frequencies of the bodies' modes; none of rigid ones \[Hz\].
    pub cut_off: Option<f64>,
    /// How far the peak is above the mean about which it rings, if it does \[N\].
    pub ringing: Option<f64>,
    /// Sum of the errors that the steps were allowed, as a share of the velocity.
    pub steps: f64,
    /// By how much the ledger is open after the impact and was not before \[J\].
    pub energy: f64,
}

impl Evidence<'_> {
    /// Period of the highest frequency that all bodies follow, where the force jumps: within it a peak says
    /// nothing \[s\].
    fn jump_window(&self) -> Option<f64> {
        self.cut_off.filter(|_| self.touch.is_jump()).map(f64::recip)
    }
}

/// Steps of the replay over the duration of the impact, and over a period of the highest mode.
const STEPS: f64 = 600.0;
const STEPS_OF_PERIOD: f64 = 10.0;
/// Steps at most for each step of the run, so that a replay costs a small part of it; and at least and at most
/// of all.
const STEPS_OF_RUN: f64 = 2.0;
const FEWEST_STEPS: f64 = 100.0;
const MOST_STEPS: f64 = 4000.0;
/// Steps times modes of a replay at most: some milliseconds.
const MOST_WORK: f64 = 1.5e6;
/// How long a replay goes on, in durations of the impact.
const LONGER: f64 = 1.25;
/// Share by which the replay may miss what the run did and still say how that depends on the model.
const MISSED: f64 = 0.15;
/// Factor on estimates of an error by differences, so that 95 in 100 are no smaller than the error: that of
/// Roache's grid convergence index where three meshes show the rate (1997, Annu. Rev. Fluid Mech. 29).
pub const SAFETY: f64 = 1.25;

/// The force of an impact as it is repeated with each source changed, at instants from the first contact on \[N\].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Histories {
    /// Time between instants \[s\].
    pub step: f64,
    /// As it is.
    pub base: Vec<f64>,
    /// With springs twice as stiff; none without springs.
    pub stiffer: Option<Vec<f64>>,
    /// With the zone's error.
    pub zone: Vec<f64>,
    /// With the frequencies of a finer mesh.
    pub mesh: Vec<f64>,
    /// With the modes up to half of the highest frequency.
    pub half: Vec<f64>,
    /// With those up to a quarter.
    pub quarter: Vec<f64>,
}

/// What each source changes in an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts {
    /// In its numbers.
    pub of_numbers: Vec<(Source, Numbers)>,
    /// In its force.
    pub histories: Histories,
}

impl Parts {
    /// Share by which steps and ledger may put the impulse off.
    pub fn of_ends(&self, impulse: f64) -> f64 {
        let is_end = |source: &Source| matches!(source, Source::Steps | Source::Ledger);
        let parts = self.of_numbers.iter().filter(|(source, _)| is_end(source));
        parts.map(|(_, part)| part.impulse).sum::<f64>() / impulse
    }
}

/// The parts of the band of the peak force, as shares of it; none where that has none.
pub fn shares_of_peak(evidence: &Evidence<'_>) -> Option<Vec<(Source, f64)>> {
    let found = parts(evidence).ok()?.of_numbers;
    let share = |part: &Numbers| SAFETY * part.peak_force / evidence.numbers.peak_force;
    let shares: Vec<_> = found.iter().map(|(source, part)| (*source, share(part))).collect();
    shares.iter().all(|(_, share)| share.is_finite()).then_some(shares)
}

/// What each source changes in an impact.
///
/// # Errors
/// Why that is not known.
pub fn parts(evidence: &Evidence<'_>) -> Result<Parts, NoBand> {
    let Evidence { numbers, bodies, .. } = evidence;
    let speed = bodies.approach;
    let zone = zone::error(evidence.zone, evidence.touch, evidence.across).ok_or(NoBand::Coarse)?;
    let mass = numbers.impulse / (speed + numbers.separation_velocity);
    if !(mass > 0.0 && mass.is_finite() && speed > 0.0 && numbers.duration > 0.0) {
        return Err(NoBand::Unended);
    }
    let highest = bodies.modes.iter().map(Mode::frequency).fold(0.0, f64::max);
    let end = LONGER * numbers.duration;
    let wanted = STEPS.max(STEPS_OF_PERIOD * highest * numbers.duration);
    let most = (STEPS_OF_RUN * evidence.instants.len() as f64).clamp(FEWEST_STEPS, MOST_STEPS);
    let fine = numbers.duration / wanted.min(most);
    let h = fine.max(end * (bodies.modes.len() + 1) as f64 / MOST_WORK);
    let window = evidence.jump_window().unwrap_or(0.0);
    let grid = Grid { step: h, end, window };
    let law = shown_law(evidence, bodies, h).ok_or(NoBand::NotOneForce)?;
    let (base, base_force) = bodies.replay(&law, grid);
    let ringing = ringing_part(evidence);
    let smooth = Numbers { peak_force: numbers.peak_force - ringing, ..*numbers };
    if misses(&base, &smooth) > MISSED {
        return Err(NoBand::NotOneForce);
    }
    // The replay is not the run: of what it shows the differences are taken.
    let beside = |other: &Numbers| Numbers::each(|of| (of(other) - of(&base)).abs());
    let penetration: Vec<_> = evidence.instants.iter().map(|i| (i.force, i.penetration)).collect();
    let stiffer = penalty::stiffer(law, evidence.touch, &penetration).map(|law| bodies.replay(&law, grid));
    let of_penalty = stiffer.as_ref().map(|(other, _)| beside(other)).unwrap_or_default();
    let of_penalty = Numbers::each(|of| penalty::to_rigid(of(&of_penalty)));
    let (of_zone, zone_force) = bodies.replay(&Law { scale: 1.0 + zone.approach, ..law }, grid);
    let of_zone = ringing::in_force(zone.force * base.peak_force, &base, beside(&of_zone));
    let (of_mesh, mesh_force) = mesh::finer(bodies).replay(&law, grid);
    let [(half, half_force), (quarter, quarter_force)] = [0.5, 0.25].map(|share| {
        let (bodies, law) = modes::truncated(bodies, &evidence.ends, law, share);
        bodies.replay(&law, grid)
    });
    let of_modes = modes::change(&base, &half, &quarter);
    let of_modes = match evidence.jump_window() {
        Some(window) => {
            modes::of_jump(&of_modes, window * numbers.peak_force / numbers.impulse, speed, numbers)
        }
        None => of_modes,
    };
    let mut of_numbers = vec![
        (Source::Penalty, of_penalty),
        (Source::Zone, of_zone),
        (Source::Mesh, beside(&of_mesh)),
        (Source::Modes, of_modes),
        (Source::Ringing, ringing::in_force(ringing, numbers, Numbers::default())),
        (Source::Steps, steps::of_steps(evidence.steps, speed, numbers)),
        (Source::Ledger, steps::of_ledger(evidence.energy, (mass, speed), numbers)),
    ];
    if zone.has_no_limit {
        let none = |part: &mut Numbers| [part.peak_force, part.peak_time, part.duration] = [f64::NAN; 3];
        of_numbers.iter_mut().for_each(|(_, part)| none(part));
    }
    let histories = Histories {
        step: h,
        base: base_force,
        stiffer: stiffer.map(|(_, force)| force),
        zone: zone_force,
        mesh: mesh_force,
        half: half_force,
        quarter: quarter_force,
    };
    Ok(Parts { of_numbers, histories })
}

/// The law that the recorded force shows beside what the modes yield (Eq. U.3).
fn shown_law(evidence: &Evidence<'_>, bodies: &Bodies, h: f64) -> Option<Law> {
    let (start, duration) = (evidence.start, evidence.numbers.duration);
    let force = |time: f64| {
        let k = evidence.instants.partition_point(|i| i.time <= time);
        match (k.checked_sub(1).map(|k| evidence.instants[k]), evidence.instants.get(k)) {
            (Some(a), Some(b)) => a.force + (b.force - a.force) * (time - a.time) / (b.time - a.time),
            _ => 0.0,
        }
    };
    let n = (duration / h).floor() as usize;
    let forces: Vec<f64> = (0..=n).map(|i| force(start + h * i as f64)).collect();
    let approaches = bodies.approaches(&forces, h);
    let samples: Vec<(f64, f64)> = forces.into_iter().zip(approaches).collect();
    Power::fit(&samples).map(Law::shown)
}

/// The largest share by which the numbers of a replay miss those of the run.
fn misses(found: &Numbers, numbers: &Numbers) -> f64 {
    let share = |of: fn(&Numbers) -> f64| (of(found) / of(numbers) - 1.0).abs();
    let shares = [share(|n| n.peak_force), share(|n| n.duration), share(|n| n.impulse)];
    shares.into_iter().fold(0.0, |most, share| if share > most || share.is_nan() { share } else { most })
}

/// How far the peak is above what its ringing stands on.
fn ringing_part(evidence: &Evidence<'_>) -> f64 {
    let of_jump = evidence.jump_window().map_or(0.0, |window| {
        let samples: Vec<_> = evidence.instants.iter().map(|i| (i.time, i.force)).collect();
        ringing::above_mean(&samples, window)
    });
    of_jump.max(evidence.ringing.unwrap_or(0.0))
}

/// The bands: parts add by magnitude, for those of penalty, zone and modes are often of one sign.
pub fn sum(evidence: &Evidence<'_>, parts: &[(Source, Numbers)]) -> Band {
    let all = Numbers::each(|of| SAFETY * parts.iter().map(|(_, part)| of(part)).sum::<f64>());
    let has_peak = !all.peak_force.is_nan();
    let of = |part: &Numbers| if has_peak { part.peak_force } else { part.impulse };
    let largest = parts.iter().map(|(source, part)| (*source, SAFETY * of(part)));
    Band {
        peak_force: all.peak_force,
        peak_time: all.peak_time,
        duration: all.duration,
        impulse: all.impulse,
        separation_velocity: all.separation_velocity,
        restitution: if evidence.numbers.restitution.is_nan() { f64::NAN } else { all.restitution },
        largest: largest.max_by(|a, b| a.1.total_cmp(&b.1)),
        missing: (!has_peak).then_some(NoBand::Edge),
    }
}
