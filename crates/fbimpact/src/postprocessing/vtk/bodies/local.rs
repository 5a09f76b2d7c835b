//! The quasistatic displacement of contact zones, as bodies are drawn with it.

use adaptive::model::RunModel;

use super::shown::ZoneGeometry;
use crate::postprocessing::replay::local::{LocalForces, own_residual};
use crate::postprocessing::replay::zones::RefinedZones;

/// Quasistatic displacement of a body.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LocalDisplacement {
    /// Displacement of the unknowns of its own model \[m\]; empty where there is none.
    pub own: Vec<f64>,
    /// Displacement of the unknowns of a fine model \[m\], with the index of the contact that this
    /// belongs to.
    pub zone: Option<(usize, Vec<f64>)>,
}

/// Quasistatic displacement of each body by `forces`. Of several fine models of a body that of the
/// largest force counts.
pub fn displacements(
    model: &RunModel,
    zones: &RefinedZones<ZoneGeometry>,
    forces: &LocalForces,
) -> Vec<LocalDisplacement> {
    let mut all = vec![LocalDisplacement::default(); model.bodies.len()];
    let mut largest = vec![0.0; model.bodies.len()];
    for load in &forces.zones {
        let zone = &zones.of_contact(load.contact)[load.zone];
        let displacement = || zone.model.residual.displacement(&load.forces);
        let found = &mut all[zone.body];
        if zone.model.model.is_own() {
            add(&mut found.own, &displacement());
        } else if load.total > largest[zone.body] {
            largest[zone.body] = load.total;
            found.zone = Some((load.contact, displacement()));
        }
    }
    for (body, forces) in forces.own.iter().enumerate().filter(|(_, forces)| !forces.is_empty()) {
        if let Some(residual) = own_residual(model, body) {
            add(&mut all[body].own, &residual.displacement(forces));
        }
    }
    all
}

/// Adds `part` to `sum`, which is empty where it is zero.
fn add(sum: &mut Vec<f64>, part: &[f64]) {
    sum.resize(part.len(), 0.0);
    sum.iter_mut().zip(part).for_each(|(sum, u)| *sum += u);
}
