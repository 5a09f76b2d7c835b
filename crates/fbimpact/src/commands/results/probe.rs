//! `fbimpact probe`: histories at points of a stored result.

use std::ops::Range;

use ffr_dynamics::body::RigidMotion;

use crate::cache;
use crate::cli::ProbeArguments;
use crate::commands::{print, threads};
use crate::error::{AppError, CommandFault};
use crate::postprocessing::probe::places::{Line, WantedPoint};
use crate::postprocessing::probe::series::Probe;
use crate::postprocessing::probe::table::{modes_csv, modes_json, points_csv, points_json};
use crate::postprocessing::replay::states::States;

/// Prints the histories that are asked for.
///
/// # Errors
/// [`AppError::Command`] for a body that there is not and for points and times that there are not, [`AppError::Io`] for the file,
/// [`AppError::Scenario`], [`AppError::Model`] and [`AppError::OtherModes`] if its models cannot be built again.
pub fn probe(arguments: &ProbeArguments) -> Result<(), AppError> {
    let states = States::read(&arguments.file)?;
    let rows = rows(&states.time, (arguments.from, arguments.to))?;
    let time = &states.time[rows.clone()];
    let bodies = &states.scenario.bodies;
    let Some(body) = bodies.iter().find(|body| body.name == arguments.body) else {
        let known: Vec<String> = bodies.iter().map(|body| body.name.clone()).collect();
        return Err(CommandFault::unknown_body("--body", &arguments.body, "result", &known).into());
    };
    let Some(number) = body.index else {
        return Err(CommandFault::argument(
            "--body",
            &body.name,
            "is a plane at rest, name a body that moves",
        )
        .into());
    };
    if arguments.modes {
        let motion = states.motion(&body.name)?;
        if motion.eigenfrequencies.is_empty() {
            let reason = format!("--modes: body {} is rigid and has no elastic coordinates", body.name);
            return Err(CommandFault::request(reason).into());
        }
        return match arguments.json {
            true => print(&format!("{}\n", modes_json(&body.name, &states.time, rows, &motion))),
            false => print(&modes_csv(&states.time, rows, &motion)),
        };
    }
    let lines = arguments.line.iter().flat_map(Line::points).map(WantedPoint::On);
    let points = arguments.point.iter().cloned().map(WantedPoint::At).chain(lines);
    let wanted: Vec<WantedPoint> =
        points.chain(arguments.marker.iter().cloned().map(WantedPoint::Marker)).collect();
    let n_threads = threads(arguments.threads)?;
    let cache = cache::open(&arguments.cache.settings());
    let mut probe = Probe::new(&states, (body, &wanted), n_threads, &cache)?;
    for left_out in probe.left_out() {
        tracing::warn!("{left_out}");
    }
    let series = probe.series(rows)?;
    if probe.deviations() > 0 {
        tracing::warn!(
            "at {} instants a contact zone could not be solved again as in the run; local deformation and stress are left out there",
            probe.deviations()
        );
    }
    let is_axisymmetric = probe.motion(number) == RigidMotion::Axial;
    match arguments.json {
        true => print(&format!("{}\n", points_json(&body.name, time, &series, is_axisymmetric))),
        false => print(&points_csv(time, &series, is_axisymmetric)),
    }
}

/// The stored instants between `from` and `to`, both included.
fn rows(time: &[f64], (from, to): (Option<f64>, Option<f64>)) -> Result<Range<usize>, AppError> {
    let (first, last) = (time[0], time[time.len() - 1]);
    let (from, to) = (from.unwrap_or(first), to.unwrap_or(last));
    let rows = time.partition_point(|t| *t < from)..time.partition_point(|t| *t <= to);
    if rows.is_empty() {
        let reason = format!(
            "no instant is stored from {from:e} s to {to:e} s, the result holds {first:e} s to {last:e} s"
        );
        return Err(CommandFault::request(reason).into());
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_lie_between_both_times() {
        let time = [0.0, 0.1, 0.2, 0.2, 0.5];
        assert_eq!(rows(&time, (None, None)).expect("all"), 0..5);
        assert_eq!(rows(&time, (Some(0.1), Some(0.2))).expect("three"), 1..4);
        for range in [(Some(0.3), Some(0.4)), (Some(0.5), Some(0.1)), (Some(1.0), None)] {
            assert!(rows(&time, range).is_err(), "{range:?}");
        }
    }
}
