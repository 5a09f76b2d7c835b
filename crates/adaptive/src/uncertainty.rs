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
pub mod accuracy;

use tracing::debug;

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
const SAFETY: f64 = 1.25;

/// The bands of the numbers of an impact.
pub fn band(evidence: &Evidence<'_>) -> Band {
    match parts(evidence) {
        Ok(parts) => {
            debug!(?parts, "parts of the bands");
            sum(evidence, &parts)
        }
        Err(missing) => Band::none(missing),
    }
}

/// The parts of the band of the peak force, as shares of it; none where that has none.
pub fn shares_of_peak(evidence: &Evidence<'_>) -> Option<Vec<(Source, f64)>> {
    let found = parts(evidence).ok()?;
    let share = |part: &Numbers| SAFETY * part.peak_force / evidence.numbers.peak_force;
    let shares: Vec<_> = found.iter().map(|(source, part)| (*source, share(part))).collect();
    shares.iter().all(|(_, share)| share.is_finite()).then_some(shares)
}

/// What each source changes in the numbers of an impact.
///
/// # Errors
/// Why that is not known.
pub fn parts(evidence: &Evidence<'_>) -> Result<Vec<(Source, Numbers)>, NoBand> {
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
    let base = bodies.replay(&law, grid);
    let ringing = ringing_part(evidence);
    let smooth = Numbers { peak_force: numbers.peak_force - ringing, ..*numbers };
    if misses(&base, &smooth) > MISSED {
        return Err(NoBand::NotOneForce);
    }
    // The replay is not the run: of what it shows the ratios are taken.
    let beside = |bodies: &Bodies, law: &Law| {
        let other = bodies.replay(law, grid);
        Numbers::each(|of| (of(&other) - of(&base)).abs())
    };
    let penetration: Vec<_> = evidence.instants.iter().map(|i| (i.force, i.penetration)).collect();
    let stiffer = penalty::stiffer(law, evidence.touch, &penetration)
        .map(|law| beside(bodies, &law))
        .unwrap_or_default();
    let of_penalty = Numbers::each(|of| penalty::to_rigid(of(&stiffer)));
    let of_zone = beside(bodies, &Law { scale: 1.0 + zone.approach, ..law });
    let of_zone = Numbers { peak_force: of_zone.peak_force + zone.force * base.peak_force, ..of_zone };
    let [half, quarter] = [0.5, 0.25].map(|share| {
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
    let found = [
        (Source::Penalty, of_penalty),
        (Source::Zone, of_zone),
        (Source::Mesh, beside(&mesh::finer(bodies), &law)),
        (Source::Modes, of_modes),
        (Source::Ringing, Numbers { peak_force: ringing, ..Numbers::default() }),
        (Source::Steps, steps::of_steps(evidence.steps, speed, numbers)),
        (Source::Ledger, steps::of_ledger(evidence.energy, (mass, speed), numbers)),
    ];
    let mut parts = found.to_vec();
    if zone.has_no_limit {
        parts.iter_mut().for_each(|(_, part)| (part.peak_force, part.duration) = (f64::NAN, f64::NAN));
    }
    Ok(parts)
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
fn sum(evidence: &Evidence<'_>, parts: &[(Source, Numbers)]) -> Band {
    let all = Numbers::each(|of| SAFETY * parts.iter().map(|(_, part)| of(part)).sum::<f64>());
    let has_peak = !all.peak_force.is_nan();
    let of = |part: &Numbers| if has_peak { part.peak_force } else { part.impulse };
    let largest = parts.iter().map(|(source, part)| (*source, SAFETY * of(part)));
    Band {
        peak_force: all.peak_force,
        duration: all.duration,
        impulse: all.impulse,
        separation_velocity: all.separation_velocity,
        restitution: if evidence.numbers.restitution.is_nan() { f64::NAN } else { all.restitution },
        largest: largest.max_by(|a, b| a.1.total_cmp(&b.1)),
        missing: (!has_peak).then_some(NoBand::Edge),
    }
}
