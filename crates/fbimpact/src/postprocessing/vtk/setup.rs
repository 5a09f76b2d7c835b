//! A scenario before its run, in blocks: bodies in their initial pose, frames, markers, joints,
//! contacts, loads, gravity, observed places.

use adaptive::model::{Arrangement, PlacedJoint, PlacedMarker, PlacedTouch};
use adaptive::spec::{BodySpec, ContactSpec, ImportedSpec, LoadSpec, Target};
use adaptive::touch::first::FirstTouches;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::{Unit, Vector3};

use super::bodies::assemble::{View, grid};
use super::bodies::mesh;
use super::bodies::shape_alone;
use super::bodies::splines::Cells;
use super::grid::marks;
use super::grid::{Deformation, Grid};
use crate::error::AppError;
use crate::postprocessing::replay::states::Pose;
use crate::scenario::{FileBody, Scenario};

/// Part of the size of the scene that axes of frames and joints reach.
const REACH: f64 = 0.05;
/// Instants at which loads are looked at.
const INSTANTS: u32 = 1000;

/// Grids under a common name.
pub struct Block {
    /// The name.
    pub name: &'static str,
    /// Parts by name.
    pub parts: Vec<(String, Grid)>,
}

/// The blocks of `scenario`, whose places in space are `arrangement`; blocks without parts are left
/// out.
///
/// # Errors
/// [`AppError::Model`] if a shape is folded.
pub fn blocks(
    scenario: &Scenario,
    arrangement: &Arrangement,
    (cells, view): (Cells, View),
) -> Result<Vec<Block>, AppError> {
    let bodies = bodies(scenario, &arrangement.poses, (cells, view))?;
    let scene = Scene::new(scenario, arrangement, &bodies);
    let all = [
        ("bodies", bodies),
        ("frames", scene.frames()),
        ("markers", scene.markers()),
        ("joints", arrangement.joints.iter().map(|joint| (joint.name.clone(), scene.joint(joint))).collect()),
        ("contacts", scenario.run.contacts.iter().flat_map(|contact| scene.contact(contact)).collect()),
        ("loads", scene.loads()),
        ("gravity", scene.gravity()),
        ("output", scene.observed()),
    ];
    Ok(all.into_iter().filter(|(_, p)| !p.is_empty()).map(|(name, parts)| Block { name, parts }).collect())
}

/// Bodies that have a shape or a mesh, with their velocity and the contacts that they take part in.
fn bodies(
    scenario: &Scenario,
    poses: &[BodyState],
    (cells, view): (Cells, View),
) -> Result<Vec<(String, Grid)>, AppError> {
    let mut all = Vec::new();
    for body in &scenario.bodies {
        let Some(index) = body.index else { continue };
        let pose = &pose(&poses[index]);
        let drawn = if let Some(meshed) = scenario.run.bodies[index].kind.meshed() {
            let at_rest = vec![0.0; meshed.mesh.model().dimension() * meshed.mesh.nodes().len()];
            Some(mesh::grid(&meshed.mesh, pose, Deformation { displacement: &at_rest, rate: &at_rest }, view))
        } else {
            shape(body, pose, (cells, view))?
        };
        let Some(mut drawn) = drawn else { continue };
        drawn.displacement.clear();
        drawn.scalars = sides(&scenario.run.contacts, index, drawn.points.len());
        all.push((body.name.clone(), drawn));
    }
    Ok(all)
}

fn shape(body: &FileBody, pose: &Pose, (cells, view): (Cells, View)) -> Result<Option<Grid>, AppError> {
    let Some(geometry) = shape_alone(body, cells)? else { return Ok(None) };
    let at_rest = vec![0.0; geometry.n_control_values()];
    let drawn = grid(&geometry, pose, Deformation { displacement: &at_rest, rate: &at_rest }, view).map_err(
        |source| AppError::model(adaptive::AdaptiveError::Geometry { body: body.name.clone(), source }),
    )?;
    Ok(Some(drawn))
}

/// For each contact of body `index` a field that is 1 on the contact body and 2 on the target.
fn sides(contacts: &[ContactSpec], index: usize, n: usize) -> Vec<(String, Vec<[f64; 1]>)> {
    let side = |contact: &ContactSpec| {
        contact.bodies().position(|body| body == index).map(|side| if side == 0 { 1.0 } else { 2.0 })
    };
    let named =
        |contact: &ContactSpec| Some((format!("side of {}", contact.name), vec![[side(contact)?]; n]));
    contacts.iter().filter_map(named).collect()
}

fn pose(state: &BodyState) -> Pose {
    Pose {
        position: state.position,
        rotation: state.rotation.to_rotation_matrix().into_inner(),
        velocity: state.velocity,
        angular_velocity: state.rotation * state.angular_velocity_in_body,
    }
}

/// What stands in space, and how large it is.
struct Scene<'a> {
    scenario: &'a Scenario,
    arrangement: &'a Arrangement,
    touches: FirstTouches<'a>,
    centre: Vector3<f64>,
    /// Half the diagonal of the box around everything \[m\].
    size: f64,
}

impl<'a> Scene<'a> {
    fn new(scenario: &'a Scenario, arrangement: &'a Arrangement, bodies: &[(String, Grid)]) -> Self {
        let shown = bodies.iter().flat_map(|(_, grid)| grid.points.iter().map(|p| Vector3::from(*p)));
        let joints = arrangement.joints.iter().flat_map(|j| [j.parent.point, j.child.point]);
        let frames = arrangement.poses.iter().map(|state| state.position);
        let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let (low, high) =
            shown.chain(joints).chain(frames).fold(none, |(low, high), p| (low.inf(&p), high.sup(&p)));
        let size = 0.5 * (high - low).norm();
        // A single body without a shape has no size.
        let size = if size.is_finite() && size > 0.0 { size } else { 1.0 };
        let centre = 0.5 * (low + high);
        let centre = if centre.iter().all(|x| x.is_finite()) { centre } else { Vector3::zeros() };
        let touches = FirstTouches::new(&scenario.run, arrangement.poses.clone());
        Self { scenario, arrangement, touches, centre, size }
    }

    fn reach(&self) -> f64 {
        REACH * self.size
    }

    fn frames(&self) -> Vec<(String, Grid)> {
        let frame = |(body, state): (&BodySpec, &BodyState)| {
            let mut grid = Grid::default();
            marks::point(&mut grid, &state.position, &body.name);
            for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
                let end = state.position + self.reach() * (state.rotation * Vector3::ith(k, 1.0));
                marks::line(&mut grid, [&state.position, &end], &format!("{axis} of {}", body.name));
            }
            (body.name.clone(), grid)
        };
        self.scenario.run.bodies.iter().zip(&self.arrangement.poses).map(frame).collect()
    }

    /// Named points and centres of named parts, as one part of the file for each body.
    fn markers(&self) -> Vec<(String, Grid)> {
        let mut all = Vec::new();
        for body in &self.scenario.bodies {
            let Some(index) = body.index else { continue };
            let state = &self.arrangement.poses[index];
            let kind = &self.scenario.run.bodies[index].kind;
            let motion = kind.motion();
            let mut grid = Grid::default();
            let mut add = |name: &str, at: Vector3<f64>| {
                marks::point(&mut grid, &(state.position + state.rotation * at), name);
            };
            for (name, point) in body.places.points() {
                add(name, motion.in_space(point));
            }
            for (name, area) in body.places.areas() {
                let centre = motion.in_space(&area.centre);
                let is_ring = motion == RigidMotion::Axial;
                add(&name, if is_ring { Vector3::new(0.0, 0.0, centre.z) } else { centre });
            }
            for (name, at) in kind.imported().map_or_else(Vec::new, ImportedSpec::markers) {
                add(&name, at);
            }
            if !grid.points.is_empty() {
                all.push((body.name.clone(), grid));
            }
        }
        all
    }

    /// Both sides of a joint, the line between them where they are apart, and its axes.
    fn joint(&self, joint: &PlacedJoint) -> Grid {
        let mut grid = Grid::default();
        let side = |word: &str, at: &PlacedMarker| {
            format!("{}, {word} {}", joint.name, self.body_name(at.body, "ground"))
        };
        let (parent, child) = (&joint.parent.point, &joint.child.point);
        marks::point(&mut grid, parent, &side("parent", &joint.parent));
        marks::point(&mut grid, child, &side("child", &joint.child));
        if joint.distance() > 0.0 {
            marks::line(&mut grid, [parent, child], &joint.name);
        }
        for direction in joint.directions() {
            let arm = self.reach() * direction;
            marks::line(&mut grid, [&(parent - arm), &(parent + arm)], &format!("axis of {}", joint.name));
        }
        let n = grid.points.len();
        grid.scalars.push(("held directions apart [m]".into(), vec![[joint.held_distance()]; n]));
        grid.scalars.push(("held axes turned [rad]".into(), vec![[joint.held_angle()]; n]));
        grid
    }

    /// The gap of a contact, the zone predicted for its first touch, and the plane that it meets.
    fn contact(&self, contact: &ContactSpec) -> Vec<(String, Grid)> {
        let run = &self.scenario.run;
        let mut parts = Vec::new();
        if let Target::Plane(plane) = contact.target {
            let mut grid = Grid::default();
            marks::square(&mut grid, &plane.foot(&self.centre), &plane.normal, self.size, "plane");
            parts.push((format!("{}.plane", contact.name), grid));
        }
        let Some(touch) = PlacedTouch::new(&self.touches, contact) else { return parts };
        let mut gap = Grid::default();
        let target = contact.target.body().map_or("plane", |other| self.body_name(Some(other), ""));
        marks::point(&mut gap, &touch.on_body, self.body_name(Some(contact.body), ""));
        marks::point(&mut gap, &touch.on_target, target);
        marks::line(&mut gap, [&touch.on_body, &touch.on_target], &contact.name);
        let n = gap.points.len();
        gap.scalars.push(("gap [m]".into(), vec![[(touch.on_body - touch.on_target).norm()]; n]));
        gap.vectors.push(("normal".into(), vec![touch.normal.into(); n]));
        parts.push((format!("{}.gap", contact.name), gap));
        let motion = run.bodies[contact.body].kind.motion();
        parts.extend(zone(&touch, motion).map(|grid| (format!("{}.zone", contact.name), grid)));
        parts
    }

    fn loads(&self) -> Vec<(String, Grid)> {
        let end = self.scenario.run.settings.end_time;
        let load = |(load, at): (&LoadSpec, &PlacedMarker)| {
            let mut grid = Grid::default();
            marks::point(&mut grid, &at.point, &load.name);
            let times = (0..=INSTANTS).map(|i| end * f64::from(i) / f64::from(INSTANTS));
            for (k, what, unit) in [(0, "force", "N"), (3, "moment", "N m")] {
                if load.components[k..k + 3].iter().all(Option::is_none) {
                    continue;
                }
                let vector = |t: f64| {
                    let value = |i: usize| load.components[k + i].as_ref().map_or(0.0, |c| c.at(t)[0]);
                    let vector = Vector3::from_fn(|i, _| value(i));
                    if load.is_following { at.axes * vector } else { vector }
                };
                let largest = times.clone().map(&vector).max_by(|a, b| a.norm().total_cmp(&b.norm()));
                grid.vectors.push((format!("{what} at the start [{unit}]"), vec![vector(0.0).into()]));
                grid.vectors
                    .push((format!("largest {what} [{unit}]"), vec![largest.unwrap_or_default().into()]));
            }
            (load.name.clone(), grid)
        };
        self.scenario.run.loads.iter().zip(&self.arrangement.loads).map(load).collect()
    }

    fn gravity(&self) -> Vec<(String, Grid)> {
        let gravity = self.scenario.run.settings.gravity;
        if gravity.norm() <= 0.0 {
            return Vec::new();
        }
        let mut grid = Grid::default();
        marks::point(&mut grid, &self.centre, "gravity");
        grid.vectors.push(("gravity [m/s2]".into(), vec![gravity.into()]));
        vec![("gravity".into(), grid)]
    }

    /// Observed points and lines of stress.
    fn observed(&self) -> Vec<(String, Grid)> {
        let run = &self.scenario.run;
        let points = run.points.iter().zip(&self.arrangement.points).map(|(point, at)| {
            let mut grid = Grid::default();
            marks::point(&mut grid, at, &point.name);
            (point.name.clone(), grid)
        });
        let lines = run.stress.iter().map(|stress| {
            let (motion, state) =
                (run.bodies[stress.body].kind.motion(), &self.arrangement.poses[stress.body]);
            let [from, to] = stress.ends.map(|end| state.position + state.rotation * motion.in_space(&end));
            let mut grid = Grid::default();
            marks::line(&mut grid, [&from, &to], &stress.name);
            (format!("{}.stress", stress.name), grid)
        });
        points.chain(lines).collect()
    }

    fn body_name<'b>(&'b self, body: Option<usize>, otherwise: &'b str) -> &'b str {
        body.map_or(otherwise, |i| &self.scenario.run.bodies[i].name)
    }
}

/// What Hertz's theory predicts to touch, and the zone about it; segments in the plane of a plane
/// model.
fn zone(touch: &PlacedTouch, motion: RigidMotion) -> Option<Grid> {
    let zone = touch.zone?;
    // Bodies that touch already have no gap to tell the normal; on an axis it is known.
    let on_axis = (motion == RigidMotion::Axial).then_some(Vector3::z_axis());
    let normal = Unit::try_new(touch.normal, 0.0).or(on_axis)?;
    let mut grid = Grid::default();
    for (radius, name) in [(zone.half_width, "touched at the peak"), (0.5 * zone.width, "zone")] {
        if motion == RigidMotion::Planar {
            let arm = radius * Vector3::z().cross(&normal);
            marks::line(&mut grid, [&(touch.on_body - arm), &(touch.on_body + arm)], name);
        } else {
            marks::circle(&mut grid, &touch.on_body, &normal, radius, name);
        }
    }
    let n = grid.points.len();
    grid.scalars.push(("predicted peak force [N]".into(), vec![[zone.force]; n]));
    grid.scalars.push(("predicted half width [m]".into(), vec![[zone.half_width]; n]));
    Some(grid)
}
