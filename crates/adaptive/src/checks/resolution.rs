//! What a result leaves out: modes against the duration of impacts, elements against waves and
//! against places of joints and loads, stored instants against vibrations (docs/theory.md Eqs. P.6
//! to P.9).

use std::f64::consts::{FRAC_PI_2, TAU};

use ffr_dynamics::force::BodyState;

use crate::body::field_body::{CARRIED, FieldBody, LongestElement};
use crate::body::loads::{HeldPlace, PLACE_ERROR};
use crate::body::whole::indentation::pressed_width;
use crate::body::zone::PointsAbout;
use crate::record::warning::{Warning, WarningKind};
use crate::record::{ImpactRecord, ZoneSite};
use crate::sizing::impact_time::ForceNeeds;
use crate::spec::Coupling;
use crate::state::impact_monitor::Ringing;
use crate::system::body::BodyModel;

/// Product of the highest frequency kept and the duration of an impact from which on the spectrum
/// of the force, that of a half sine, is below `1/(4·3.57² - 1)`, a fiftieth of its mean (Eq. P.6):
/// twice what the program allows where it chooses the modes (Eq. N.9).
const CYCLES: f64 = 3.57;
/// Relative error of a frequency above which a mesh is too coarse for its wave (Eq. P.7).
const FREQUENCY_ERROR: f64 = 1e-2;
/// Share of a body's vibration that a mode must carry to be worth storing (Eq. P.8).
const AUDIBLE: f64 = 1e-2;
/// Share of the largest energy of the run that the vibration of a body must carry.
const STRONG: f64 = 1e-3;

/// Share of the duration of an impact between flat faces by which it may end late (Eq. P.11).
const LATE: f64 = 0.02;
/// Share of the impulse up to which what a slow rise costs is told: the next term of the estimate, its square, is a fifth of it there.
const FIRST_ORDER: f64 = 0.2;

/// How many times stiffer springs between flat faces may be than the modes follow, without a word
/// on the largest force: three times as stiff ones ring by a quarter of it (theory section A.9).
const TOO_STIFF: f64 = 2.0;
/// Periods of the highest mode over which a mean of the force shows no more of that ringing than a
/// tenth.
const PERIODS: f64 = 3.0;

/// Duration of the half sine with the peak and the impulse of an impact, and no longer than the
/// impact \[s\].
pub fn pulse_duration(impact: &ImpactRecord) -> f64 {
    let duration = impact.end - impact.start;
    let pulse = FRAC_PI_2 * impact.impulse.abs() / impact.peak_force;
    if pulse > 0.0 && pulse < duration { pulse } else { duration }
}

/// Highest frequency of the free modes kept \[Hz\]: static answers and modes of an interface stand
/// for what follows its forces.
pub fn highest_free_mode(body: &BodyModel) -> Option<f64> {
    body.frequencies().into_iter().take(body.coordinates().free).reduce(f64::max)
}

/// The warning of body `number` whose modes end below what an impact excites, if they do (Eq. P.6).
/// `needs` has the frequency up to which the program would take modes for a touch along a line
/// (Eq. N.9), and for what waves take up (Eq. N.11); the half of either is enough.
pub fn few_modes(
    (number, body): (usize, &BodyModel),
    impact: &ImpactRecord,
    needs: &ForceNeeds,
) -> Option<Warning> {
    let highest = highest_free_mode(body)?;
    let duration = pulse_duration(impact);
    let radiated = needs.radiated(number, (impact.impulse, impact.approach_velocity, duration));
    let limit =
        (CYCLES / duration).min(0.5 * radiated).max(needs.line.map_or(0.0, |frequency| 0.5 * frequency));
    let is_few = duration > 0.0 && highest < limit;
    is_few.then(|| Warning {
        kind: WarningKind::FewModes,
        subject: subject(body),
        time: impact.end,
        value: highest,
        limit,
        message: format!(
            "the impact that ended at t = {:.6e} s was a pulse of {duration:.3e} s and excites frequencies up to {limit:.4e} Hz, the \
             highest mode kept has {highest:.4e} Hz",
            impact.end
        ),
        remedy: match body.flexible() {
            // Splines become finer with the number of modes, a mesh that is given does not.
            Some(flexible) if carries_not(flexible.body.as_ref(), limit) => {
                format!("{}: that of body \"{}\" carries no such waves", flexible.body.finer_mesh(), body.name)
            }
            Some(_) => format!("raise bodies.{}.reduction.modes", body.name),
            None => format!("give the file of body \"{}\" more modes", body.name),
        },
    })
}

/// The warning of an impact between flat faces of `bodies` that ends late because its force cannot
/// rise faster (Eq. P.11).
pub fn slow_rise(contact: &str, bodies: &[&BodyModel], impact: &ImpactRecord) -> Option<Warning> {
    let lowest = bodies.iter().filter_map(|body| highest_free_mode(body)).reduce(f64::min)?;
    let duration = impact.end - impact.start;
    let share = 1.0 / (lowest * duration);
    let rise = 0.5 / lowest;
    // The force of waves stays at its peak, impulse over peak its time: the exact impulse is that of a jump.
    let cost = rise * impact.peak_force / impact.impulse.abs();
    let of_waves = (cost < FIRST_ORDER).then(|| {
        format!(
            "; between bars of one impedance that puts impulse and separating speeds off by {:.1} %",
            100.0 * cost
        )
    });
    let value = if of_waves.is_some() { share.max(cost) } else { share };
    (value > LATE).then(|| Warning {
        kind: WarningKind::SlowRise,
        subject: format!("contact \"{contact}\""),
        time: impact.end,
        value,
        limit: LATE,
        message: format!(
            "modes up to {lowest:.4e} Hz let the force between its flat faces rise within {rise:.2e} s and end the impact {:.1} % of its duration late{}",
            100.0 * share,
            of_waves.unwrap_or_default()
        ),
        remedy: "raise reduction.modes of its bodies, or take time, impulse and shape of the force as no sharper than that, and the restitution of a compact body as an upper bound".into(),
    })
}

/// The warning of an impact between flat faces of `bodies` whose springs are `beyond_modes` times
/// stiffer than the modes follow (theory section P.3).
pub fn ringing_force(
    contact: &str,
    bodies: &[&BodyModel],
    impact: &ImpactRecord,
    beyond_modes: f64,
) -> Option<Warning> {
    let lowest = bodies.iter().filter_map(|body| highest_free_mode(body)).reduce(f64::min)?;
    // What began in equilibrium has nothing that rings.
    (beyond_modes > TOO_STIFF && impact.approach_velocity > 0.0).then(|| Warning {
        kind: WarningKind::RingingForce,
        subject: format!("contact \"{contact}\""),
        time: impact.peak_time,
        value: beyond_modes,
        limit: TOO_STIFF,
        message: format!(
            "its springs are {beyond_modes:.1} times stiffer than modes up to {lowest:.4e} Hz follow: the force between its flat faces rings \
             about its mean, by a quarter and more, and its peak of {:.4e} N is too high; impulse, motion and energy do not depend on it",
            impact.peak_force
        ),
        remedy: format!(
            "read the force as a mean over {:.1e} s, or raise reduction.modes of its bodies",
            PERIODS / lowest
        ),
    })
}

/// Share of the mean of a force that rings by which its peak may be above it without a word.
const RINGS: f64 = 0.02;

/// The warning of contact `contact`, whose force rings about its mean at the peak; `is_rigid`: between bodies without
/// modes.
pub fn ringing_peak(contact: &str, ringing: &Ringing, is_rigid: bool) -> Option<Warning> {
    let Ringing { mean, time, share, period } = *ringing;
    (share > RINGS).then(|| Warning {
        kind: WarningKind::RingingForce,
        subject: format!("contact \"{contact}\""),
        time,
        value: share,
        limit: RINGS,
        message: format!(
            "its force rings at {:.3e} Hz by {:.1} % about a mean of {mean:.4e} N at t = {time:.6e} s, the peak; impulse, motion and energy do \
             not depend on that",
            1.0 / period,
            100.0 * share
        ),
        remedy: if is_rigid {
            format!("read the force as that mean, begin at rest (simulation.start = \"static\"), or give contacts.{contact}.damping")
        } else {
            "read the force as that mean, or damp the modes of the body that ring (bodies.NAME.damping)".into()
        },
    })
}

/// The warning of an impact of the contact `contact` whose peak force has no band, or one wider than `wanted`, a share of it.
pub fn wide_band(contact: &str, impact: &ImpactRecord, wanted: f64) -> Option<Warning> {
    let share = impact.band.peak_force / impact.peak_force;
    if share <= wanted {
        return None;
    }
    let message = match share.is_nan() {
        true => format!("the peak force has no band, {:.2} % are wanted", 100.0 * wanted),
        false => format!(
            "the band of the peak force is {:.2} % of it, {:.2} % are wanted",
            100.0 * share,
            100.0 * wanted
        ),
    };
    let (subject, time, remedy) =
        (format!("contact \"{contact}\""), impact.peak_time, impact.band.note(contact));
    Some(Warning { kind: WarningKind::WideBand, subject, time, value: share, limit: wanted, message, remedy })
}

/// Length of the longest side of an element of a body; none of one without elements \[m\].
pub fn longest_element_of(body: &BodyModel) -> Option<f64> {
    let elements = body.flexible()?.body.longest_elements();
    elements.iter().map(|e| e.length).reduce(f64::max)
}

/// The warning of a contact in which an edge or a corner touches at a time \[s\], or with
/// `keeps_sides` a place too long for finer elements, on the elements that the body has; `crossed`: the target that a line of it lies across.
pub fn edge_touch(
    (contact, time): (&str, f64),
    (body, site): (&BodyModel, Option<&ZoneSite>),
    crossed: Option<&BodyModel>,
    keeps_sides: bool,
) -> Option<Warning> {
    let elastic = &body.flexible()?.body;
    let about = site.and_then(|site| PointsAbout::of(elastic.undeformed(), site));
    let finer =
        || format!("compare with smaller elements of body \"{}\": {}", body.name, elastic.finer_there());
    let width = about.and_then(|about| pressed_width(elastic.as_ref(), &about));
    let length = width.or_else(|| longest_element_of(body))?;
    let depends = "peak force and duration depend on how far it yields, impulse and motion too where the bodies bend meanwhile";
    let elements = format!("elements of up to {length:.3e} m yield as a whole");
    let over = format!("as over a width of {length:.3e} m");
    let (message, remedy) = match (width, keeps_sides) {
        (Some(_), true) => (
            format!(
                "a line touches that is too long for finer elements: what these leave out of the indentation is added, {over}, to some six per cent \
                 of the approach; pressure there is not resolved"
            ),
            finer(),
        ),
        (Some(_), false) => (
            format!("an edge touches along a face, {over}: {depends}; pressure there has no limit"),
            "compare with an edge that is rounded, as all are".to_owned(),
        ),
        (None, true) => (
            format!(
                "a place touches that is too long for finer elements: {depends}, and {elements}; pressure there is not resolved"
            ),
            format!("{}, or have a strip of short sides along it and model = \"quasistatic\"", finer()),
        ),
        (None, false) => (
            format!("an edge or a corner touches: {depends}, and {elements}; pressure there has no limit"),
            match crossed.filter(|target| target.flexible().is_some()) {
                Some(target) => format!(
                    "\"{}\" lies with a line across \"{}\", which ends before it: make \"{}\" the contact_body",
                    body.name, target.name, target.name
                ),
                None => finer(),
            },
        ),
    };
    let (kind, subject) = (WarningKind::EdgeTouch, format!("contact \"{contact}\""));
    Some(Warning { kind, subject, time, value: length, limit: 0.0, message, remedy })
}

/// The warning of a body whose mesh puts the frequency of its highest mode off by more than one per
/// cent: by the estimate of Eq. P.7, or as it is `known` of a mesh that the program has chosen.
pub fn coarse_mesh(body: &BodyModel, known: Option<f64>) -> Option<Warning> {
    let flexible = body.flexible()?;
    let highest = highest_free_mode(body).filter(|f| *f > 0.0)?;
    let (error, mesh, remedy) = match known {
        Some(error) => (
            error,
            "is not resolved by the mesh that the program has chosen, which puts".to_owned(),
            format!("give bodies.{}.discretisation.elements, or keep fewer modes", body.name),
        ),
        None => {
            let (error, wave, worst) = flexible.body.carried_waves()?.error(highest)?;
            let direction = worst.direction.map_or_else(String::new, |d| format!(" in direction {d}"));
            let (wave, LongestElement { degree, .. }) = (wave.length, worst);
            let length = worst.mean.unwrap_or(worst.length);
            let what = format!(
                "has waves {wave:.3e} m long; elements of {length:.3e} m and degree {degree}{direction} put"
            );
            // Fewer modes leave out what follows the force; they help where the mesh carries no such waves.
            let fewer = if worst.mean.is_none() || error > CARRIED { ", or keep fewer modes" } else { "" };
            (error, what, format!("{}{fewer}", flexible.body.finer_mesh()))
        }
    };
    let shown = if error < 1.0 { format!("{:.0} %", 100.0 * error) } else { "more than its half".to_owned() };
    (error > FREQUENCY_ERROR).then(|| Warning {
        kind: WarningKind::CoarseMesh,
        subject: subject(body),
        time: 0.0,
        value: error,
        limit: FREQUENCY_ERROR,
        message: format!(
            "its highest mode, {highest:.4e} Hz, {mesh} its frequency off by some {shown}, {:.0} % are allowed",
            100.0 * FREQUENCY_ERROR
        ),
        remedy,
    })
}

/// Whether the finite elements of a body are too large for waves of the frequency `frequency` \[Hz\] (Eq. P.20).
fn carries_not(body: &dyn FieldBody, frequency: f64) -> bool {
    let error = body.carried_waves().and_then(|waves| waves.error(frequency));
    error.is_some_and(|(error, _, worst)| worst.mean.is_some() && error > CARRIED)
}

/// The warning of a body on which joints or loads hold a disc or ball that its elements do not
/// resolve: of the worst one (Eq. P.9).
pub fn coarse_place(body: &BodyModel) -> Option<Warning> {
    let flexible = body.flexible()?;
    // Elements over the radius that a place has and needs.
    let sizes = flexible.interface.loads.markers.iter().filter_map(|load| {
        let HeldPlace { area, radius, elements, .. } = load.held_place()?;
        Some((load, area, radius / flexible.body.longest_element_at(area)?, elements))
    });
    let (load, area, found, limit) = sizes.min_by(|a, b| (a.2 / a.3).total_cmp(&(b.2 / b.3)))?;
    let there = format!("{} there or give the place a larger radius", flexible.body.finer_there());
    let remedy = match area.coupling {
        Coupling::Average => there,
        Coupling::Rigid => format!("take coupling = \"average\", hold a whole face, {there}"),
    };
    (found < limit).then(|| Warning {
        kind: WarningKind::CoarsePlace,
        subject: subject(body),
        time: 0.0,
        value: found,
        limit,
        message: format!(
            "{}, held by {}, has {found:.2} elements over its radius; {limit:.1} give what it yields to {:.0} %",
            area.extent.name(),
            load.name,
            100.0 * PLACE_ERROR
        ),
        remedy,
    })
}

/// The highest frequency at which a body vibrates strongly in the motion `state`, if it does so at
/// all; `scale`: largest energy of the run \[J\] (Eq. P.8) \[Hz\].
pub fn highest_vibration(body: &BodyModel, state: &BodyState, scale: f64) -> Option<f64> {
    let frequencies = body.frequencies();
    if frequencies.len() != state.elastic.len() {
        return None; // a fine model with modes of its own
    }
    let coordinates = state.elastic.iter().zip(&state.elastic_rates);
    let energies: Vec<f64> = frequencies
        .iter()
        .zip(coordinates)
        .map(|(f, (q, rate))| 0.5 * ((TAU * f * q).powi(2) + rate * rate))
        .collect();
    let total: f64 = energies.iter().sum();
    if total < STRONG * scale {
        return None;
    }
    let audible = frequencies.iter().zip(&energies).filter(|(_, e)| **e >= AUDIBLE * total);
    let highest = audible.map(|(f, _)| *f).fold(0.0, f64::max);
    (highest > 0.0).then_some(highest)
}

/// Time between stored states that shows vibrations of a frequency \[Hz\] well: half of what P.8
/// allows \[s\].
pub fn shown_interval(frequency: f64) -> f64 {
    0.25 / frequency
}

/// The warning of a body that vibrates at the frequency `highest` \[Hz\] after the time `time`,
/// faster than its states are stored, `interval` apart (Eq. P.8).
pub fn sparse_output(body: &BodyModel, highest: f64, (time, interval): (f64, f64)) -> Option<Warning> {
    let limit = 0.5 / highest;
    (interval > limit).then(|| Warning {
        kind: WarningKind::SparseOutput,
        subject: subject(body),
        time,
        value: interval,
        limit,
        message: format!(
            "it vibrates at frequencies up to {highest:.4e} Hz after the impact that ended at t = {time:.6e} s, states are stored every \
             {interval:.3e} s and show no more than {:.4e} Hz",
            0.5 / interval
        ),
        remedy: format!(
            "leave output.free_interval to the program or lower it to {limit:.2e} or less"
        ),
    })
}

fn subject(body: &BodyModel) -> String {
    format!("body \"{}\"", body.name)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn the_spectrum_of_a_half_sine_is_a_fiftieth_beyond_the_limit() {
        // |F(f)|/F(0) = |cos(π f T)/(1 - 4 f² T²)|, its bound at the limit; to three digits.
        assert!((1.0 / (4.0 * CYCLES * CYCLES - 1.0) - 0.02).abs() < 1e-4);
        let impact = |duration: f64, peak: f64, impulse: f64| ImpactRecord {
            end: duration,
            peak_force: peak,
            impulse,
            ..ImpactRecord::default()
        };
        // A half sine of 2 s and peak 3 has the impulse 2/π · 3 · 2; round-off.
        assert!((pulse_duration(&impact(10.0, 3.0, 12.0 / PI)) - 2.0).abs() < 1e-12);
        assert!(
            (pulse_duration(&impact(1.0, 3.0, 12.0 / PI)) - 1.0).abs() < 1e-12,
            "no longer than the impact"
        );
        assert!((pulse_duration(&impact(1.0, 0.0, 0.0)) - 1.0).abs() < 1e-12, "without force");
    }
}
