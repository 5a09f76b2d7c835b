//! `fbimpact export-body`: a body of a scenario as a body file.

use adaptive::AdaptiveError;
use adaptive::body::built;
use adaptive::body::field_body::FieldBody;
use adaptive::body::loads::StaticLoads;
use adaptive::body::reduced::Interface;
use adaptive::spec::{Area, BodySpec, FlexibleSpec, FrameSpec, Place};
use ffr_dynamics::interchange::{BodyFrame, FullBody, ReducedModel, ReducedParts};
use ffr_dynamics::kinematics::MarkerWeights;
use nalgebra::UnitQuaternion;

use crate::cache::{self, CacheSettings};
use crate::commands::scenario_file;
use crate::commands::{BodyExport, Means, body_index, gate_of, no_full_model, print, threads};
use crate::error::AppError;
use crate::interchange::body_file;
use crate::progress::while_building;
use crate::scenario::Override;
use crate::simulate::sizing::sized;

/// Writes the body with its faces and its markers that have an extent as markers, reduced to its
/// free modes and the static answers to its joints and loads in its frame, with its stiffening, or with unreduced
/// matrices (`is_full`), and with its named points for output.
///
/// # Errors
/// [`AppError::Command`] for a body that there is not and for a rigid body, [`AppError::Model`] if it cannot be built, [`AppError::Io`] for the file, also if
/// it is one that the scenario reads.
pub fn export_body(
    export: &BodyExport<'_>,
    is_full: bool,
    overrides: &[Override],
    means: Means<'_>,
) -> Result<(), AppError> {
    let n_threads = threads(means.threads)?;
    let scenario = scenario_file::read(export.scenario, overrides)?;
    gate_of(&scenario, export.force).check(export.output, body_file::KIND)?;
    let index = body_index(export.body, scenario.run.bodies.iter().map(|b| &b.name))?;
    let places = Places { areas: scenario.areas(export.body), points: scenario.points(export.body) };
    let text = while_building(means.bar, || {
        let scenario = sized(&scenario, n_threads, &cache::open(&CacheSettings::of_environment()))?;
        let turns = adaptive::model::turns(&scenario.run).map_err(AppError::model)?;
        let loads = StaticLoads::on_body(&scenario.run, index, &turns[index]);
        write((export, is_full), &scenario.run.bodies[index], loads, &places)
    });
    print(&text?)
}

/// Named places of a body.
struct Places {
    /// Parts that can be held.
    areas: Vec<(String, Area)>,
    /// Points, in the components of its model \[m\].
    points: Vec<(String, [f64; 3])>,
}

fn write(
    (export, is_full): (&BodyExport<'_>, bool),
    spec: &BodySpec,
    loads: StaticLoads,
    Places { areas, points }: &Places,
) -> Result<String, AppError> {
    let Some(body) = built(&spec.name, &spec.kind).map_err(AppError::model)? else {
        let is_rigid = spec.kind.is_rigid();
        let what = if is_rigid { "rigid" } else { "from a file already" };
        return Err(no_full_model(&spec.name, what));
    };
    let mut markers = markers(body.as_ref(), areas)?;
    let (name, path) = (export.body, export.output.display());
    let unfit = |source| AppError::model(AdaptiveError::Reduction { body: name.to_owned(), source });
    if is_full {
        let n = body.n_unknowns();
        let points = points
            .iter()
            .map(|(name, place)| Ok((name.clone(), body.point_weights(place).map_err(AppError::model)?)));
        let points = points.collect::<Result<Vec<_>, AppError>>()?;
        let full = FullBody::new(body.assembled().clone(), markers)
            .and_then(|full| full.with_points(points))
            .map_err(unfit)?;
        body_file::write_full(export.output, &full)?;
        return Ok(format!("{path}: {name}, {n} degrees of freedom, {} markers\n", full.markers().len()));
    }
    let is_answered = spec.kind.flexible().is_some_and(FlexibleSpec::has_static_answers);
    let loads = if is_answered { loads } else { StaticLoads::default() };
    let interface = Interface { loads, ..Interface::default() };
    let reduced = body.reduce(&interface).map_err(AppError::model)?;
    let frame = match spec.kind.flexible().map(|flexible| &flexible.frame) {
        Some(FrameSpec::Tangent(place)) => {
            BodyFrame::Tangent { marker: frame_marker(body.as_ref(), (place, areas), &mut markers)? }
        }
        _ => BodyFrame::Buckens,
    };
    let shapes = reduced.shapes();
    let markers =
        markers.iter().map(|(name, weights)| weights.marker(name, shapes)).collect::<Result<Vec<_>, _>>();
    let markers = markers.map_err(|e| AppError::model(AdaptiveError::Model(e)))?;
    let points = points.iter().map(|(name, place)| {
        let point = body.flexible_point(&Place::Point(*place), shapes).map_err(AppError::model)?;
        Ok((name.clone(), point))
    });
    let points = points.collect::<Result<_, AppError>>()?;
    let reduced = ReducedModel::new(ReducedParts {
        name: name.to_string(),
        frame,
        data: reduced.data.to_parts(),
        frequencies: reduced.basis.omega.iter().map(|w| w / std::f64::consts::TAU).collect(),
        markers,
        points,
    })
    .map_err(unfit)?;
    body_file::write_reduced(export.output, &reduced)?;
    let (modes, markers) = (reduced.frequencies().len(), reduced.markers().len());
    Ok(format!("{path}: {name}, {modes} modes, {markers} markers\n"))
}

/// Name of the marker that the frame follows, of the area at its place, or one of its own that is
/// added to `markers`.
fn frame_marker(
    body: &dyn FieldBody,
    (place, areas): (&Place, &[(String, Area)]),
    markers: &mut Vec<(String, MarkerWeights)>,
) -> Result<String, AppError> {
    let at_place = areas.iter().find(|(_, area)| matches!(place, Place::Area(of) if of == area));
    if let Some((name, _)) = at_place {
        return Ok(name.clone());
    }
    let names: Vec<&str> = markers.iter().map(|(name, _)| name.as_str()).collect();
    let free = std::iter::once("frame".to_owned()).chain((2..).map(|k| format!("frame-{k}")));
    let name = free.into_iter().find(|name| !names.contains(&name.as_str())).unwrap_or_default();
    let weights = body.marker_weights(place, UnitQuaternion::identity()).map_err(AppError::model)?;
    markers.push((name.clone(), weights));
    Ok(name)
}

/// The parts of the body that can be held, with the axes of the body.
fn markers(body: &dyn FieldBody, areas: &[(String, Area)]) -> Result<Vec<(String, MarkerWeights)>, AppError> {
    let weights = |area: &Area| {
        body.marker_weights(&Place::Area(area.clone()), UnitQuaternion::identity()).map_err(AppError::model)
    };
    areas.iter().map(|(name, area)| Ok((name.clone(), weights(area)?))).collect()
}
