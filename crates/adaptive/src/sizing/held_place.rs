//! Fine elements about the discs and balls on which joints and loads act, in a mesh that the
//! program has chosen (theory Eq. P.9).

use iga_core::space::PatchSpace;

use super::ChosenZone;
use crate::body::loads::{HeldPlace, MarkerLoads};
use crate::body::splines::refined_shape;
use crate::spec::{DiscretisationSpec, RefinementSpec, RunSpec};

/// Growth of elements outside the place.
const RATIO: f64 = 2.0;
/// Elements across a place that the program adds at most: a lattice has them in all directions.
/// What needs more, as rigid places do, is told when the body is built.
const MOST: f64 = 10.0;

/// What the places of body `index` need in a mesh of `elements` a direction. A place that lies off
/// the body, or on a shape that cannot be refined, gets nothing: building the body says why.
pub(super) fn zones(spec: &RunSpec, index: usize, elements: &[usize]) -> Vec<ChosenZone> {
    let Some(elastic) = spec.bodies[index].elastic() else { return Vec::new() };
    let mut mesh = DiscretisationSpec { elements: elements.to_vec(), ..elastic.discretisation.clone() };
    let mut chosen = Vec::new();
    for load in MarkerLoads::on_body(spec, index) {
        let Some(HeldPlace { area, point, radius, elements }) = load.held_place() else { continue };
        let across = (2.0 * elements).ceil();
        let longest = || {
            let shape = refined_shape(&elastic.shape, &elastic.model, &mesh).ok()?;
            let space = PatchSpace::new(shape.patches).ok()?;
            area.extent.longest_element(&elastic.shape, &space, &elastic.model).ok()?
        };
        if across > MOST || longest().is_none_or(|longest| longest * elements <= radius) {
            continue;
        }
        let refinement =
            RefinementSpec { centre: point, width: 2.0 * radius, elements: across as usize, ratio: RATIO };
        mesh.refine.push(refinement);
        chosen.push(ChosenZone { refinement, reason: format!("elements for what {} holds", load.name) });
    }
    chosen
}
