//! The bodies of a result, built again from its scenario.

pub mod bernstein;
pub mod splines;
pub mod revolution;
pub mod tensor;
pub mod assemble;
pub mod mesh;
pub mod shown;
pub mod local;

use std::sync::Arc;

use adaptive::AdaptiveError;
use adaptive::body::field::Field;
use adaptive::impact::ZoneModel;
use adaptive::model::RunModel;
use adaptive::spec::body::rigid_motion;
use faer::{Mat, MatRef};
use ffr_dynamics::body::RigidMotion;
use iga_core::space::PatchSpace;

use super::grid::{Deformation, Grid};
use crate::error::{AppError, CommandFault};
use crate::postprocessing::replay::local::LeftOut;
use crate::postprocessing::replay::rebuilt::Rebuilt;
use crate::postprocessing::replay::states::{BodyMotion, Pose, States};
use crate::scenario::{FileBody, Scenario};
use adaptive::store::ModelCache;
use assemble::{PointShapes, View, grid};
use local::{LocalDisplacement, displacements};
use mesh::MeshGeometry;
use shown::{ShownGeometry, ZoneGeometry};
use splines::{BodyGeometry, Cells, Elasticity};

/// Linear cells per element of a shape that is not refined.
const RIGID_CELLS: usize = 8;

/// A body to be shown.
pub struct Shown {
    /// Name.
    pub name: String,
    /// Shape.
    pub geometry: ShownGeometry,
    /// Motion.
    pub motion: BodyMotion,
    /// Number among the moving bodies.
    number: usize,
}

/// Bodies and contacts of a result.
pub struct Bodies {
    /// Bodies to be shown.
    pub shown: Vec<Shown>,
    rebuilt: Rebuilt<ZoneGeometry>,
}

/// Elements of a body, its own or those of a fine model.
#[derive(Clone, Copy)]
enum DrawnGeometry<'a> {
    Splines(&'a BodyGeometry),
    Mesh(&'a MeshGeometry),
}

impl ShownGeometry {
    fn drawn(&self) -> DrawnGeometry<'_> {
        match self {
            Self::Splines(geometry) => DrawnGeometry::Splines(geometry),
            Self::Mesh(geometry) => DrawnGeometry::Mesh(geometry),
        }
    }
}

/// A body at an instant, on its own elements or on those of a fine model.
pub struct Drawn<'a> {
    /// The body.
    pub body: &'a Shown,
    /// Elements.
    geometry: DrawnGeometry<'a>,
    /// Control values of the displacement \[m\].
    pub displacement: Vec<f64>,
    /// Control values of its rate [m/s].
    pub rate: Vec<f64>,
    /// Which fine model it is drawn on; none: its own.
    pub mesh: Option<(usize, usize)>,
    /// The displacements on the elements that it is drawn on; none of a rigid body.
    elements: Option<&'a dyn Field>,
}

impl Bodies {
    /// Builds the bodies called `wanted`, or all that have a shape, on so many threads, with the
    /// models that the cache has; notes name those that have none.
    ///
    /// # Errors
    /// [`AppError::Command`] for a body that there is not and for a body without shape, [`AppError::Model`] if a body cannot be built,
    /// [`AppError::OtherModes`] if it is not that of the run, [`AppError::Io`].
    pub fn build(
        states: &States,
        wanted: &[String],
        cells: Cells,
        (threads, cache): (usize, &ModelCache),
    ) -> Result<Self, AppError> {
        let scenario = &states.scenario;
        check_names(scenario, wanted)?;
        let rebuilt = Rebuilt::new(states, threads, cache, Box::new(zone_geometry(cells)))?;
        let (model, motions) = (&rebuilt.model, &rebuilt.motions);
        let mut shown = Vec::new();
        for body in &scenario.bodies {
            let is_wanted = wanted.is_empty() || wanted.contains(&body.name);
            let shape = match body.index.filter(|_| is_wanted) {
                Some(number) => shape(body, model, number, cells)?.map(|g| (number, g)),
                None => None,
            };
            if let Some((number, geometry)) = shape {
                let motion = motions[number].clone();
                shown.push(Shown { name: body.name.clone(), geometry, motion, number });
            } else if is_wanted {
                without_shape(scenario, body, wanted)?;
            }
        }
        if shown.is_empty() {
            return Err(CommandFault::request(
                "no body of the result has a shape, there is nothing to export",
            )
            .into());
        }
        Ok(Self { shown, rebuilt })
    }

    /// Each shown body at instant `i`, at time `time` \[s\].
    ///
    /// # Errors
    /// [`AppError::Model`] if a fine model of the run cannot be built again.
    pub fn at(&mut self, time: f64, i: usize) -> Result<Vec<Drawn<'_>>, AppError> {
        let Rebuilt { model, motions, contacts } = &mut self.rebuilt;
        let forces = contacts.forces(model, motions, time, i)?;
        let local = displacements(model, &contacts.zones, &forces);
        Ok(self.shown.iter().map(|body| self.drawn(body, &local[body.number], i)).collect())
    }

    /// Body `body` of [`Self::shown`] displaced by the elastic coordinates `elastic` with the rates
    /// `rates` on its own elements, without what contact zones add.
    pub fn displaced<'a>(&'a self, body: &'a Shown, elastic: &[f64], rates: &[f64]) -> Drawn<'a> {
        self.on_own_elements(body, (elastic, rates), &[])
    }

    /// Displacement and stress by a unit of each elastic coordinate of body `body` of [`Self::shown`] at the rising `points` of its grid at rest,
    /// in its own axes.
    ///
    /// # Errors
    /// [`AppError::Model`] where the geometry is folded.
    pub fn shapes(&self, body: &Shown, points: &[u32]) -> Result<Vec<PointShapes>, AppError> {
        let Some(flexible) = self.rebuilt.model.bodies[body.number].flexible() else { return Ok(Vec::new()) };
        let column = |shape| {
            let unknowns: Vec<f64> = flexible.reduced.shapes().col(shape).iter().copied().collect();
            flexible.body.drawn_values(&unknowns)
        };
        let all: Vec<Vec<f64>> = (0..flexible.reduced.shapes().ncols()).map(column).collect();
        let found = match body.geometry.drawn() {
            DrawnGeometry::Splines(geometry) => assemble::shapes(geometry, &all, points),
            DrawnGeometry::Mesh(geometry) => geometry.shapes(&all, points),
        };
        found.map_err(|source| AppError::model(AdaptiveError::Geometry { body: body.name.clone(), source }))
    }

    fn drawn<'a>(&'a self, body: &'a Shown, local: &LocalDisplacement, i: usize) -> Drawn<'a> {
        let coordinates = (body.motion.elastic(i), body.motion.rates(i));
        if let Some((contact, displacement)) = &local.zone {
            let zones = self.rebuilt.contacts.zones.of_contact(*contact);
            let of_body = zones.iter().find(|z| z.body == body.number);
            if let Some((zone, geometry)) = of_body.and_then(|z| Some((&z.model, z.view.as_ref()?))) {
                let (displacement, rate) = fields(zone.shapes.as_ref(), coordinates, displacement);
                let field = zone.model.field();
                return Drawn {
                    body,
                    geometry: geometry.drawn(),
                    displacement: field.drawn_values(&displacement),
                    rate: field.drawn_values(&rate),
                    mesh: self.rebuilt.contacts.zones.number(*contact).map(|n| (*contact, n)),
                    elements: Some(field),
                };
            }
        }
        self.on_own_elements(body, coordinates, &local.own)
    }

    /// A body on its own elements, `local` what contact zones add to the displacement of its
    /// unknowns; empty: nothing.
    fn on_own_elements<'a>(
        &'a self,
        body: &'a Shown,
        coordinates: (&[f64], &[f64]),
        local: &[f64],
    ) -> Drawn<'a> {
        let geometry = body.geometry.drawn();
        let Some(flexible) = self.rebuilt.model.bodies[body.number].flexible() else {
            let n = match geometry {
                DrawnGeometry::Splines(geometry) => geometry.n_control_values(),
                DrawnGeometry::Mesh(_) => 0,
            };
            let at_rest = vec![0.0; n];
            let (displacement, rate) = (at_rest.clone(), at_rest);
            return Drawn { body, geometry, displacement, rate, mesh: None, elements: None };
        };
        let (displacement, rate) = fields(flexible.reduced.shapes(), coordinates, local);
        Drawn {
            body,
            geometry,
            displacement: flexible.body.drawn_values(&displacement),
            rate: flexible.body.drawn_values(&rate),
            mesh: None,
            elements: Some(flexible.body.as_ref()),
        }
    }

    /// Contacts of the shown bodies whose zones are not solved again.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let shown: Vec<usize> = self.shown.iter().map(|shown| shown.number).collect();
        self.rebuilt.left_out(&shown)
    }

    /// Instants at which a contact zone could not be solved again.
    pub fn deviations(&self) -> usize {
        self.rebuilt.contacts.deviations
    }
}

impl Drawn<'_> {
    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        match self.geometry {
            DrawnGeometry::Splines(geometry) => geometry.motion,
            DrawnGeometry::Mesh(geometry) => rigid_motion(geometry.mesh.model()),
        }
    }

    /// The grid of the body in the motion `pose` of its frame.
    ///
    /// # Errors
    /// [`AppError::Model`] where the geometry is folded.
    pub fn grid(&self, pose: &Pose, view: View) -> Result<Grid, AppError> {
        let deformation = Deformation { displacement: &self.displacement, rate: &self.rate };
        let grid = match self.geometry {
            DrawnGeometry::Splines(geometry) => grid(geometry, pose, deformation, view),
            DrawnGeometry::Mesh(geometry) => geometry.grid(pose, deformation, view),
        };
        grid.map_err(|source| {
            AppError::model(AdaptiveError::Geometry { body: self.body.name.clone(), source })
        })
    }

    /// Functions that are not zero at an undeformed point of the body, in the model's components;
    /// none for a rigid body.
    ///
    /// # Errors
    /// [`AppError::Model`] if the point is not on the body.
    pub fn functions_at(&self, point: &[f64; 3]) -> Result<Vec<(u32, f64)>, AppError> {
        self.elements.map_or(Ok(Vec::new()), |field| field.functions_at(point).map_err(AppError::model))
    }
}

/// Displacement, `local` added to it, and its rate, of the unknowns with the shapes `shapes`.
fn fields(shapes: MatRef<'_, f64>, (q, rates): (&[f64], &[f64]), local: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut displacement = combined(shapes, q);
    displacement.iter_mut().zip(local).for_each(|(u, v)| *u += v);
    (displacement, combined(shapes, rates))
}

/// `Φ q`.
fn combined(shapes: MatRef<'_, f64>, q: &[f64]) -> Vec<f64> {
    let q = Mat::from_fn(q.len(), 1, |i, _| q[i]);
    (shapes * q).col(0).iter().copied().collect()
}

fn check_names(scenario: &Scenario, wanted: &[String]) -> Result<(), AppError> {
    let known: Vec<String> = scenario.bodies.iter().map(|b| b.name.clone()).collect();
    match wanted.iter().find(|name| !known.contains(name)) {
        None => Ok(()),
        Some(name) => Err(CommandFault::unknown_body("--bodies", name, "result", &known).into()),
    }
}

/// The geometry of fine models in cells of the kind `cells`.
fn zone_geometry(cells: Cells) -> impl Fn(&RunModel, usize, &ZoneModel) -> Result<ZoneGeometry, AppError> {
    move |_, _, zone| {
        if let Some(mesh) = zone.model.splines() {
            let elasticity = Elasticity { model: mesh.model, material: mesh.material };
            let (patches, space) = (mesh.patches.as_slice(), Box::new(mesh.space.clone()));
            let geometry = BodyGeometry::new(space, patches, mesh.motion, Some(elasticity), cells);
            return Ok(Some(ShownGeometry::Splines(Box::new(geometry))));
        }
        Ok(zone.model.mesh().map(|fine| {
            let (mesh, materials) = (Arc::clone(fine.divided()), fine.materials.clone());
            ShownGeometry::Mesh(Box::new(MeshGeometry { mesh, materials }))
        }))
    }
}

/// Shape of body `number`, if it has one.
fn shape(
    of_file: &FileBody,
    model: &RunModel,
    number: usize,
    cells: Cells,
) -> Result<Option<ShownGeometry>, AppError> {
    if let Some(flexible) = model.bodies[number].flexible() {
        if let Some(full) = flexible.body.splines() {
            let elasticity = Some(Elasticity { model: full.spec.model, material: full.spec.material });
            let (space, motion) = (Box::new(full.space.clone()), full.assembled.motion);
            let geometry = BodyGeometry::new(space, &full.shape.patches, motion, elasticity, cells);
            return Ok(Some(ShownGeometry::Splines(Box::new(geometry))));
        }
        if let Some(full) = flexible.body.mesh() {
            let (mesh, materials) = (Arc::clone(&full.spec.mesh), full.materials.clone());
            return Ok(Some(ShownGeometry::Mesh(Box::new(MeshGeometry { mesh, materials }))));
        }
    }
    Ok(shape_alone(of_file, cells)?.map(|geometry| ShownGeometry::Splines(Box::new(geometry))))
}

/// The exact shape of a body on the elements of its patches, without displacement or stress; none
/// of a body without one.
///
/// # Errors
/// [`AppError::Model`] if its patches make no body.
pub fn shape_alone(of_file: &FileBody, cells: Cells) -> Result<Option<BodyGeometry>, AppError> {
    let Some((shape, model)) = of_file.places.shape() else { return Ok(None) };
    let fail = |source| AppError::model(AdaptiveError::Geometry { body: of_file.name.clone(), source });
    let space = Box::new(PatchSpace::new(shape.patches.clone()).map_err(fail)?);
    let cells = if cells == Cells::Bezier { cells } else { Cells::Linear(RIGID_CELLS) };
    let motion: RigidMotion = adaptive::body::splines::rigid_motion(model);
    Ok(Some(BodyGeometry::new(space, &shape.patches, motion, None, cells)))
}

/// A note on a body without shape, or an error if it was asked for by name. That a plane has no end
/// is what everybody expects: no word of it.
fn without_shape(scenario: &Scenario, body: &FileBody, wanted: &[String]) -> Result<(), AppError> {
    let name = &body.name;
    let reason = match body.index.map(|index| &scenario.run.bodies[index].kind) {
        None => "it is a plane without end",
        Some(kind) if kind.is_rigid() => "it is rigid and only its mass is given",
        Some(_) => "it comes from a body file, which holds no shape",
    };
    if wanted.is_empty() && body.index.is_none() {
        tracing::debug!("body \"{name}\" is left out: {reason}");
        return Ok(());
    }
    if wanted.is_empty() {
        tracing::warn!("body \"{name}\" is left out: {reason}");
        return Ok(());
    }
    Err(CommandFault::argument("--bodies", name, reason).into())
}
