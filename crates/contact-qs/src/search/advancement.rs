//! No contact is jumped over: speed bounds, safe times, and the first touching time (theory
//! Eqs. C.33 to C.35).

use ffr_dynamics::force::BodyState;

use super::surface_model::SurfaceModel;
use crate::ContactError;

/// Bound of the speed of any surface point relative to the origin of its body's frame (theory
/// Eq. C.33) [m/s].
///
/// With the frequencies of the modes it holds for the whole free vibration, otherwise for this
/// instant.
pub fn surface_speed_bound(model: &SurfaceModel, state: &BodyState) -> f64 {
    let rates = state.elastic.iter().zip(&state.elastic_rates);
    let amplitude = |(k, (q, rate)): (usize, (&f64, &f64))| {
        let frequency = model.frequencies().get(k).copied().unwrap_or(0.0);
        model.mode_bounds()[k] * (rate * rate + (frequency * q).powi(2)).sqrt()
    };
    let elastic: f64 = rates.enumerate().take(model.n_modes()).map(amplitude).sum();
    let radius = model.radius() + model.displacement_bound(&state.elastic);
    state.angular_velocity_in_body.norm() * radius + elastic
}

/// Bound of the speed at which any two surface points of the bodies approach each other (theory
/// Eq. C.33) [m/s]. NaN for a state that is not a number.
pub fn closing_speed_bound(models: [&SurfaceModel; 2], states: [&BodyState; 2]) -> f64 {
    let frames = (states[0].velocity - states[1].velocity).norm();
    frames + surface_speed_bound(models[0], states[0]) + surface_speed_bound(models[1], states[1])
}

/// A time during which surfaces `gap` apart cannot touch: they approach at `speed` at most now, and
/// that speed grows by `acceleration` at most (theory Eq. C.34) \[s\].
///
/// Zero for a gap that is not positive, infinite if nothing moves, NaN if an argument is.
pub fn safe_time(gap: f64, speed: f64, acceleration: f64) -> f64 {
    if gap.is_nan() || speed.is_nan() || acceleration.is_nan() {
        return f64::NAN;
    }
    if gap <= 0.0 {
        return 0.0;
    }
    // The root of speed t + acceleration t^2 / 2 = gap without cancellation.
    2.0 * gap / (speed + (speed * speed + 2.0 * acceleration * gap).sqrt())
}

/// How closely a touch is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchSettings {
    /// Surfaces that are no farther apart count as touching, >= 0 \[m\].
    pub gap: f64,
    /// Width to which the touching time is enclosed, > 0 \[s\].
    pub time: f64,
    /// The shortest step between two samples, > 0: overlaps that last longer are never missed
    /// \[s\].
    pub shortest: f64,
    /// Bound of the growth of the closing speed, >= 0 [m/s²].
    pub acceleration: f64,
}

/// The first touch of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Last time at which they are known to be apart, or touching within the tolerance \[s\].
    pub time: f64,
    /// Gap there \[m\].
    pub gap: f64,
    /// Time at which they were seen to overlap or to touch, at most the tolerance later \[s\].
    pub seen: f64,
    /// Number of samples.
    pub n_samples: usize,
}

/// The first touch in the time from `start` to `end`, none if there is none: the first time at
/// which the surfaces close. Surfaces that touch at `start` while their gap grows, as at the end of
/// an impact, are on their way apart, and those that touch without moving lie beside each other;
/// both touch when their gap shrinks by more than the tolerance of `settings`, and overlapping ones
/// when it does not grow (theory Eq. C.36).
///
/// `sample` gives the gap and the bound of the closing speed at a time, from the dense output of a
/// step say. Between samples time passes by [`safe_time`], or by the shortest step; once an overlap
/// is seen the root of the gap is enclosed by bisection and false position (theory Eq. C.35).
///
/// # Errors
/// [`ContactError::Motion`] for a gap or speed that is not a number, or settings that are out of range; errors of `sample`.
pub fn first_touch(
    [start, end]: [f64; 2],
    settings: &TouchSettings,
    mut sample: impl FnMut(f64) -> Result<(f64, f64), ContactError>,
) -> Result<Option<Touch>, ContactError> {
    check_settings(settings)?;
    let (mut time, mut n_samples) = (start, 1);
    let (mut gap, mut speed) = checked(start, sample(start)?)?;
    // Steps of surfaces that touch from the start: each twice as long as the one before.
    let mut opening = settings.shortest;
    let mut widest = gap;
    loop {
        if gap <= settings.gap {
            // At the end of the interval nothing tells whether they open: the next one does.
            if time >= end {
                return Ok(None);
            }
            let next = (time + opening).max(time.next_up()).min(end);
            let there = checked(next, sample(next)?)?;
            n_samples += 1;
            let is_overlap = gap < -settings.gap && there.0 <= gap;
            if is_overlap || there.0 < widest - settings.gap {
                return Ok(Some(Touch { time, gap, seen: next, n_samples }));
            }
            (time, gap, speed) = (next, there.0, there.1);
            (opening, widest) = (2.0 * opening, widest.max(gap));
            continue;
        }
        if time >= end {
            return Ok(None);
        }
        let step = safe_time(gap, speed, settings.acceleration).max(settings.shortest);
        // The shortest step may vanish beside the time itself.
        let next = (time + step).max(time.next_up()).min(end);
        let there = checked(next, sample(next)?)?;
        n_samples += 1;
        if there.0 < 0.0 {
            let found = enclose([(time, gap), (next, there.0)], settings, n_samples, sample)?;
            return Ok(Some(found));
        }
        (time, gap, speed) = (next, there.0, there.1);
    }
}

/// Shrinks a bracket of the touching time: false position with halved ordinates (Illinois),
/// bisection where that is slow.
fn enclose(
    [mut apart, mut overlap]: [(f64, f64); 2],
    settings: &TouchSettings,
    mut n_samples: usize,
    mut sample: impl FnMut(f64) -> Result<(f64, f64), ContactError>,
) -> Result<Touch, ContactError> {
    /// Looks after which only bisection is used: false position takes about ten.
    const PATIENCE: usize = 30;
    let (mut weights, mut bisect) = ([1.0, 1.0], 0);
    while overlap.0 - apart.0 > settings.time && apart.1 > settings.gap {
        let (a, b) = (weights[0] * apart.1, weights[1] * overlap.1);
        let middle = 0.5 * (apart.0 + overlap.0);
        // Not at the ends themselves, or the bracket shrinks from one side only.
        let margin = 0.25 * settings.time;
        let guess =
            (apart.0 + (overlap.0 - apart.0) * a / (a - b)).max(apart.0 + margin).min(overlap.0 - margin);
        let time = if bisect < PATIENCE && guess.is_finite() { guess } else { middle };
        if time <= apart.0 || time >= overlap.0 {
            break; // neighbouring numbers
        }
        let (gap, _) = checked(time, sample(time)?)?;
        (n_samples, bisect) = (n_samples + 1, bisect + 1);
        if gap < 0.0 {
            overlap = (time, gap);
            weights = [0.5 * weights[0], 1.0];
        } else {
            apart = (time, gap);
            weights = [1.0, 0.5 * weights[1]];
        }
    }
    Ok(Touch { time: apart.0, gap: apart.1, seen: overlap.0, n_samples })
}

fn checked(time: f64, (gap, speed): (f64, f64)) -> Result<(f64, f64), ContactError> {
    if gap.is_finite() && speed.is_finite() {
        return Ok((gap, speed));
    }
    Err(ContactError::Motion(format!(
        "first touch: gap {gap} m, closing speed {speed} m/s at t = {time:.6e} s"
    )))
}

fn check_settings(settings: &TouchSettings) -> Result<(), ContactError> {
    let TouchSettings { gap, time, shortest, acceleration } = *settings;
    if gap >= 0.0 && time > 0.0 && shortest > 0.0 && acceleration >= 0.0 {
        return Ok(());
    }
    Err(ContactError::Motion(format!(
        "settings of the first touch: gap {gap} m and acceleration {acceleration} m/s^2 must be >= 0, time {time} s and shortest step \
         {shortest} s > 0"
    )))
}
