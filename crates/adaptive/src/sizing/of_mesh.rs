//! How many modes a body of finite elements keeps: its elements are given.

use super::impact_time::ForceTime;
use super::key::mesh_key;
use super::mode_count::{ChosenModes, GROUP, ModeRange, chosen_on};
use super::spectrum::{FrequencyProblem, Known};
use crate::body::field_body::FieldBody;
use crate::body::mesh::MeshedBody;
use crate::error::AdaptiveError;
use crate::record::work;
use crate::spec::{Accuracy, MeshedSpec};
use crate::store::{ModelCache, StoredModel};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::reduction::Digits;

/// Number of modes of the mesh `spec`, the body `name`, for the fastest force on it, `time`, if
/// there is one (theory section N.4).
///
/// # Errors
/// [`AdaptiveError`] naming the body.
pub fn modes(
    name: &str,
    spec: &MeshedSpec,
    accuracy: Accuracy,
    time: Option<&ForceTime>,
    cache: &ModelCache,
) -> Result<ChosenModes, AdaptiveError> {
    let range = ModeRange::new(RigidMotion::Spatial, spec.flexible.reduction, accuracy, time);
    let (modes, highest, carried) = cache.recent(
        mesh_key(spec, accuracy, range),
        |stored| match (&stored.counts[..], &stored.values[..]) {
            ([modes], [carried, highest @ ..]) => {
                Some((usize::try_from(*modes).ok()?, highest.first().copied(), *carried))
            }
            _ => None,
        },
        || count(name, spec, range),
        |(modes, highest, carried)| StoredModel {
            counts: vec![*modes as u64],
            values: std::iter::once(*carried).chain(*highest).collect(),
        },
    )?;
    let carried = (carried < range.limit).then_some(carried);
    Ok(ChosenModes { modes, highest, carried, time: time.cloned() })
}

/// A frequency above those of all meshes \[Hz\].
const ANY: f64 = 1e15;

/// The number, the frequency of the last unless more are wanted than are ever chosen, and the
/// highest one whose waves the mesh carries \[Hz\].
fn count(
    name: &str,
    spec: &MeshedSpec,
    range: ModeRange,
) -> Result<(usize, Option<f64>, f64), AdaptiveError> {
    let _work = work::begin(format!("modes of a mesh with {} unknowns", 3 * spec.mesh.nodes().len()));
    let body = MeshedBody::build(name, spec.clone())?;
    let carried = body.carried_waves().map_or(ANY, |waves| waves.highest(ANY));
    let problem = FrequencyProblem::new(name, &body.assembled, &Digits::default())?;
    let limit = range.limit.min(carried);
    let found = if limit > 0.0 {
        problem.next_to(limit, GROUP, range.most.max(range.least))?
    } else {
        Known { first: 0, frequencies: problem.lowest(range.least + GROUP)?.frequencies }
    };
    // Not even the least number, where the mesh does not carry that many.
    let is_judged = limit <= 0.0 || carried <= range.limit;
    let most = if is_judged { found.below(carried).max(GROUP) } else { range.least };
    let range = ModeRange { limit, least: range.least.min(most), ..range };
    let (modes, highest) = chosen_on(&problem, &found, range)?;
    Ok((modes, highest, carried))
}
