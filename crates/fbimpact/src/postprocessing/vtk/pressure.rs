//! Contact pressure as points on the contact bodies.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use ffr_dynamics::body::RigidMotion;
use result_files::stored::pressure_series::PressureSeries;

use super::bodies::assemble::{View, placed};
use super::bodies::revolution::{ArcNode, rings};
use super::bodies::{Bodies, Drawn};
use super::grid::order;
use super::grid::{ContactFields, Grid};
use crate::error::AppError;
use crate::postprocessing::replay::states::States;
use crate::scenario::Scenario;

/// Points around the axis of an axisymmetric body that is revolved, a quarter turn.
const POINTS_A_QUARTER: usize = 12;

/// Functions that are not zero at a point, with their values.
type Functions = Vec<(u32, f64)>;

/// Pressures of a contact whose contact body is shown.
pub struct ContactPressure {
    /// Name of the contact.
    pub name: String,
    /// Its contact body, among those shown.
    body: usize,
    series: PressureSeries,
    /// What moves the points that were shown so far, on the meshes that they were shown on.
    functions: HashMap<(Option<(usize, usize)>, u32), Functions>,
}

/// The contacts of `states` that hold pressures on a body in `bodies`.
///
/// # Errors
/// [`AppError::Io`] if the pressures of a contact do not fit together.
pub fn contact_pressures(states: &States, bodies: &Bodies) -> Result<Vec<ContactPressure>, AppError> {
    let scenario: &Scenario = &states.scenario;
    let mut all = Vec::new();
    for contact in &scenario.run.contacts {
        let name = &scenario.run.bodies[contact.body].name;
        let Some(body) = bodies.shown.iter().position(|b| b.name == *name) else { continue };
        let Some(series) = states.pressures(&contact.name)? else { continue };
        all.push(ContactPressure { name: contact.name.clone(), body, series, functions: HashMap::new() });
    }
    Ok(all)
}

impl ContactPressure {
    /// Number of the contact body among those shown.
    pub fn body(&self) -> usize {
        self.body
    }

    /// The points that carry force at instant `i`, when the contact body is as `drawn`.
    ///
    /// # Errors
    /// [`AppError::Model`] if a point does not lie on its body.
    pub fn grid(&mut self, drawn: &Drawn<'_>, i: usize, view: View) -> Result<Grid, AppError> {
        let motion = drawn.motion();
        let pose = drawn.body.motion.pose(i);
        let revolved = view.revolve.filter(|_| motion == RigidMotion::Axial);
        // The area of a ring is that of all its points, and of the whole ring.
        let (nodes, share) = match revolved {
            None => (vec![ArcNode::SECTION], 1.0),
            Some(degrees) => {
                let nodes = rings(degrees, POINTS_A_QUARTER);
                let share = degrees / 360.0 / nodes.len() as f64;
                (nodes, share)
            }
        };
        let mut grid = Grid { contact: Some(ContactFields::default()), ..Grid::default() };
        for k in self.series.range(i) {
            let point = self.series.point[k];
            let position = motion.components(&self.series.position[point as usize]);
            let functions = match self.functions.entry((drawn.mesh, point)) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(drawn.functions_at(&position)?),
            };
            let at = |values: &[f64]| interpolated(functions, values, motion.n_components());
            let (displacement, rate) = (at(&drawn.displacement), at(&drawn.rate));
            let area = self.series.area[point as usize] * share;
            for node in &nodes {
                let first = grid.points.len();
                placed(&mut grid, (&pose, view), (motion, node), (&position, &displacement, &rate));
                grid.add_cell(order::VERTEX, first, &[0]);
                if let Some(contact) = &mut grid.contact {
                    contact.pressure.push([self.series.pressure[k]]);
                    contact.area.push([area]);
                }
            }
        }
        Ok(grid)
    }
}

/// A field with the control values `values`, `n` a function, where `functions` have their values.
fn interpolated(functions: &Functions, values: &[f64], n: usize) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for &(node, weight) in functions {
        for (c, x) in sum.iter_mut().enumerate().take(n) {
            *x += weight * values[node as usize * n + c];
        }
    }
    sum
}
