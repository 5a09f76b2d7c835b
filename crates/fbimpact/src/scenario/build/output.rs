//! Output requests: bodies, markers and points that exist.

use super::super::check::Checker;
use super::super::model::{Compression, Output, OutputPoint, StressLine, StressTime};
use super::super::section::{Checked, Section};
use super::places::{BodyFacts, body_index, marker_or_point, single};

/// The `[output]` table.
pub fn output(
    checker: &mut Checker,
    root: &Section,
    section: &Section,
    end_time: Option<f64>,
) -> Option<Output> {
    let points: Vec<OutputPoint> = section
        .named("points")
        .iter()
        .filter_map(|(name, request)| point(checker, root, name, request))
        .collect();
    let stress: Vec<StressLine> = section
        .named("stress")
        .iter()
        .filter_map(|(name, request)| stress(checker, root, name, request, end_time))
        .collect();
    Some(Output {
        free_interval: section.number("free_interval")?,
        impact_interval: section.number("impact_interval")?,
        compression: match section.text("compression")? {
            "gzip" => Compression::Gzip,
            _ => Compression::None,
        },
        points,
        stress,
    })
}

fn point(checker: &mut Checker, root: &Section, name: &str, section: &Section) -> Option<OutputPoint> {
    let body = body_index(checker, root, section, "body")?;
    let facts = BodyFacts::find(root, section.text("body")?)?.with_points();
    let at = marker_or_point(checker, section, &facts)?;
    Some(OutputPoint { name: name.to_owned(), body, at })
}

fn stress(
    checker: &mut Checker,
    root: &Section,
    name: &str,
    section: &Section,
    end_time: Option<f64>,
) -> Option<StressLine> {
    let body = body_index(checker, root, section, "body")?;
    let facts = BodyFacts::find(root, section.text("body")?)?;
    if facts.is_rigid {
        checker.fault_in(section, "body", "must be a flexible body, a rigid one has no stress".into());
        return None;
    }
    if facts.file.is_some() {
        let message = "must be a body with a shape, one from a file has no stress";
        checker.fault_in(section, "body", message.into());
        return None;
    }
    let from = single(checker, section, "from", &facts);
    let to = single(checker, section, "to", &facts);
    let at = match section.item("at")?.value {
        Checked::Number(time) => StressTime::Time(time),
        _ => StressTime::PeakForce,
    };
    if let (StressTime::Time(time), Some(end)) = (at, end_time)
        && time > end
    {
        let message = format!("must not be later than simulation.end_time, which is {end:?} s");
        checker.fault_in(section, "at", message);
    }
    let samples = section.integer("samples")?;
    Some(StressLine { name: name.to_owned(), body, from: from?, to: to?, samples, at })
}
