//! Output requests: bodies, markers and points that exist.

use adaptive::spec::GaugeRequest;
use adaptive::spec::{Place, PointSpec, StressInstant, StressSpec};

use super::super::body_places::{BodyPlaces, GivenPlace};
use super::super::section::{Checked, Section};
use super::super::types::Compression;
use super::built_bodies::BuiltBodies;
use super::places::{BodyFacts, body_index, marker_or_point, single};

/// What is stored.
#[derive(Debug)]
pub struct Output {
    /// Observed points.
    pub points: Vec<PointSpec>,
    /// Stress along lines.
    pub stress: Vec<StressSpec>,
    /// Compression of the result file.
    pub compression: Compression,
    /// Whether bodies share datasets, if it is given.
    pub arrays: Option<bool>,
}

/// The requests of the `[output]` table; `None` if one of them, or its body, is at fault.
pub fn output(
    root: &Section,
    section: &Section,
    bodies: &BuiltBodies,
    end_time: Option<f64>,
) -> Option<Output> {
    let (points, lines) = (section.named("points"), section.named("stress"));
    let built_points: Vec<PointSpec> =
        points.iter().filter_map(|(name, request)| point(root, name, request, bodies)).collect();
    let stress: Vec<StressSpec> =
        lines.iter().filter_map(|(name, request)| stress(root, name, request, bodies, end_time)).collect();
    let compression = section.choice("compression")?;
    let is_complete = built_points.len() == points.len() && stress.len() == lines.len();
    let arrays = section.boolean("arrays");
    is_complete.then_some(Output { points: built_points, stress, compression, arrays })
}

fn point(root: &Section, name: &str, section: &Section, bodies: &BuiltBodies) -> Option<PointSpec> {
    let body = body_index(root, section, "body")?;
    let facts = BodyFacts::find(root, section.text("body")?)?.with_points();
    let at = marker_or_point(section, &facts)?;
    let place = bodies.place(section, body, &at, BodyPlaces::observed)?;
    let is_asked = |key: &str| section.boolean(key).unwrap_or(false);
    let gauge = GaugeRequest { strain: is_asked("strain"), stress: is_asked("stress") };
    if gauge.is_any() {
        let key = if gauge.stress { "stress" } else { "strain" };
        let refusal = if facts.is_rigid {
            Some("a rigid body has no stress and no strain; leave it out, or observe a flexible body")
        } else if facts.file.is_some() {
            Some("a body from a file has no shape, by which stress and strain could be told; leave it out")
        } else if matches!(place, Place::Area(_)) {
            Some("stress and strain belong to a single point, this marker has an extent; give a `point`")
        } else {
            None
        };
        if let Some(refusal) = refusal {
            return section.refuse(key, refusal);
        }
    }
    Some(PointSpec { name: name.to_owned(), body: bodies.index(body)?, place, gauge })
}

fn stress(
    root: &Section,
    name: &str,
    section: &Section,
    bodies: &BuiltBodies,
    end_time: Option<f64>,
) -> Option<StressSpec> {
    let body = body_index(root, section, "body")?;
    let facts = BodyFacts::find(root, section.text("body")?)?;
    if facts.is_rigid {
        return section.refuse("body", "must be a flexible body, a rigid one has no stress");
    }
    if facts.file.is_some() {
        let message = "must be a body with a shape or a mesh, one from a body file has no stress";
        return section.refuse("body", message);
    }
    let from = single(section, "from", &facts);
    let to = single(section, "to", &facts);
    let at = match section.item("at")?.value {
        Checked::Number(time) => StressInstant::Time(time),
        _ => StressInstant::PeakForce,
    };
    if let (StressInstant::Time(time), Some(end)) = (at, end_time)
        && time > end
    {
        let message = format!("must not be later than simulation.end_time, which is {end:?} s");
        section.fault("at", message);
    }
    let samples = section.integer("samples")?;
    let places = &bodies.moving(body)?.facts.places;
    let end = |key: &str, at: &GivenPlace| {
        places.inside(at).map_err(|error| section.fault(key, error.to_string())).ok()
    };
    let ends = [end("from", &from?)?, end("to", &to?)?];
    Some(StressSpec { name: name.to_owned(), body: bodies.index(body)?, ends, samples, at })
}
