//! How many modes a body of finite elements keeps: its elements are given.

use super::impact_time::ForceTime;
use super::key::mesh_key;
use super::mode_count::{ChosenModes, GROUP, ModeRange, chosen_on};
use super::spectrum::{FrequencyProblem, Known};
use crate::body::mesh::MeshedBody;
use crate::error::AdaptiveError;
use crate::record::work;
use crate::spec::{Accuracy, MeshedSpec};
use crate::store::{ModelCache, StoredModel};
use ffr_dynamics::body::RigidMotion;

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
    let (modes, highest) = cache.recent(
        mesh_key(spec, accuracy, range),
        |stored| match (&stored.counts[..], &stored.values[..]) {
            ([modes], [highest]) => Some((usize::try_from(*modes).ok()?, *highest)),
            _ => None,
        },
        || count(name, spec, range),
        |(modes, highest)| StoredModel { counts: vec![*modes as u64], values: vec![*highest] },
    )?;
    Ok(ChosenModes { modes, highest, time: time.cloned() })
}

/// The number, and the frequency of the last \[Hz\].
fn count(name: &str, spec: &MeshedSpec, range: ModeRange) -> Result<(usize, f64), AdaptiveError> {
    let _work = work::begin(format!("modes of a mesh with {} unknowns", 3 * spec.mesh.nodes().len()));
    let body = MeshedBody::build(name, spec.clone())?.assembled;
    let problem = FrequencyProblem::new(name, &body)?;
    let found = if range.limit > 0.0 {
        problem.next_to(range.limit, GROUP)?
    } else {
        Known { first: 0, frequencies: problem.lowest(range.least + GROUP)?.frequencies }
    };
    chosen_on(&problem, &found, range, None)
}
