//! Joints, loads and markers of a run as a multibody system.

use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::system as multibody;
use ffr_dynamics::system::{CoordinateForce, FreeDirections, GROUND, JointKind, SystemSpec};
use iga_core::elasticity::kinematics::PointState;
use nalgebra::{UnitQuaternion, Vector3};

use crate::error::AdaptiveError;
use crate::record::NameAndUnit;
use crate::spec::{Area, Attachment, CoordinateSpec, GearSpec, JointSpec, Place, RunSpec, TimeCurve};
use crate::system::body::{BodyForm, BodyModel};

impl BodyModel {
    /// The material point at `place`.
    ///
    /// # Errors
    /// [`AdaptiveError`] if there is no such place.
    pub fn point(&self, place: &Place) -> Result<FlexiblePoint, AdaptiveError> {
        match &self.form {
            BodyForm::Flexible(flexible) => {
                let (field, shapes) = flexible.in_use();
                field.flexible_point(place, shapes)
            }
            BodyForm::Imported(imported) => imported.point(&self.name, place),
            BodyForm::Rigid(_) => Ok(FlexiblePoint::rigid(self.rigid_place(place)?)),
        }
    }

    /// Whether there are strain and stress at `place`.
    pub fn has_gauge(&self, place: &Place) -> bool {
        matches!(self.form, BodyForm::Flexible(_)) && !matches!(place, Place::Area(_))
    }

    /// Strain and stress at the single point `place` by a unit of each elastic coordinate (theory
    /// Eq. Q.7).
    ///
    /// # Errors
    /// [`AdaptiveError`] if there is no such place, if it has an extent, or if the body has no elements.
    pub fn gauge(&self, place: &Place) -> Result<Vec<PointState>, AdaptiveError> {
        let refuse = |what| Err(AdaptiveError::unsupported_body(&self.name, what));
        let at = match place {
            Place::Point(at) => *at,
            Place::Area(_) => {
                return refuse(
                    "strain and stress belong to a single point, this place has an extent; give a point"
                        .into(),
                );
            }
            Place::Marker(_) => self.data.motion.components(self.point(place)?.position.as_ref()),
        };
        let Some(flexible) = self.flexible() else {
            return refuse("strain and stress need a flexible body with a shape or a mesh".into());
        };
        let (field, shapes) = flexible.in_use();
        Ok(field.gauge_at(&at)?.of_modes(field.lookup(), shapes))
    }

    fn marker(
        &self,
        name: &str,
        place: &Place,
        rotation: UnitQuaternion<f64>,
    ) -> Result<Marker, AdaptiveError> {
        match &self.form {
            BodyForm::Flexible(_) if !matches!(place, Place::Area(_)) => {
                let what = format!(
                    "{name} is a point of a flexible body, which yields without bound under a force as elements shrink; give it an extent: \
                     a face, or a radius"
                );
                Err(AdaptiveError::unsupported_body(&self.name, what))
            }
            BodyForm::Flexible(flexible) => {
                let (field, shapes) = flexible.in_use();
                field.marker(name, place, rotation, shapes)
            }
            BodyForm::Imported(imported) => imported.marker(&self.name, name, place, rotation),
            BodyForm::Rigid(_) => Ok(Marker::rigid(name, self.rigid_place(place)?, rotation)),
        }
    }

    fn rigid_place(&self, place: &Place) -> Result<Vector3<f64>, AdaptiveError> {
        match place {
            Place::Point(point) | Place::Area(Area { centre: point, .. }) => {
                Ok(self.data.motion.in_space(point))
            }
            Place::Marker(name) => {
                let what = format!("a rigid body has no marker \"{name}\", give a point");
                Err(AdaptiveError::unsupported_body(&self.name, what))
            }
        }
    }
}

/// The system of `spec` with the given bodies.
///
/// A free body is joined to ground by a joint that has its name and starts at zero: its ground
/// marker stands where the body does.
///
/// # Errors
/// [`AdaptiveError`] if a place does not exist.
pub fn system_spec(spec: &RunSpec, bodies: &[BodyModel]) -> Result<SystemSpec, AdaptiveError> {
    let mut builder = Builder { bodies, markers: vec![Vec::new(); bodies.len()], ground: Vec::new() };
    let mut joints = Vec::new();
    for joint in &spec.joints {
        joints.push(builder.joint(joint)?);
    }
    for (i, body) in spec.bodies.iter().enumerate() {
        if spec.joints.iter().any(|j| j.child.body == Some(i)) {
            continue;
        }
        let kind = JointKind::freest(bodies[i].data.motion);
        let name = format!("start of {}", body.name);
        builder.ground.push(Marker::rigid(&name, body.motion.position, body.motion.rotation));
        builder.markers[i].push(Marker::rigid("frame", Vector3::zeros(), UnitQuaternion::identity()));
        let parent = multibody::Attachment::new(GROUND, &name);
        let child = multibody::Attachment::new(&body.name, "frame");
        joints.push(multibody::JointSpec::new(&body.name, kind, parent, child));
    }
    let loops = spec.loops.iter().map(|j| builder.joint(j)).collect::<Result<_, AdaptiveError>>()?;
    let coordinate = |(joint, k): (usize, usize)| (spec.joints[joint].name.clone(), k);
    let gear = |gear: &GearSpec| multibody::GearSpec {
        name: gear.name.clone(),
        first: coordinate(gear.first),
        second: coordinate(gear.second),
        ratio: gear.ratio,
        offset: gear.offset(&spec.joints),
    };
    let gears = spec.gears.iter().map(gear).collect();
    let mut loads = Vec::new();
    for load in &spec.loads {
        loads.push(multibody::LoadSpec {
            name: load.name.clone(),
            at: builder.attach(&load.name, &load.at)?,
            components: load.components.each_ref().map(|c| c.as_ref().map(TimeCurve::function)),
            is_following: load.is_following,
        });
    }
    let Builder { markers, ground, .. } = builder;
    let bodies = bodies.iter().zip(markers).map(|(body, markers)| multibody::BodySpec {
        name: body.name.clone(),
        data: body.data.clone(),
        markers,
    });
    Ok(SystemSpec {
        bodies: bodies.collect(),
        ground,
        joints,
        loops,
        gears,
        loads,
        gravity: spec.settings.gravity,
    })
}

struct Builder<'a> {
    bodies: &'a [BodyModel],
    markers: Vec<Vec<Marker>>,
    ground: Vec<Marker>,
}

impl Builder<'_> {
    fn joint(&mut self, joint: &JointSpec) -> Result<multibody::JointSpec, AdaptiveError> {
        Ok(multibody::JointSpec {
            name: joint.name.clone(),
            kind: joint.kind,
            parent: self.attach(&format!("parent of {}", joint.name), &joint.parent)?,
            child: self.attach(&format!("child of {}", joint.name), &joint.child)?,
            coordinates: joint.coordinates.iter().map(coordinate_force).collect(),
            bearing: joint.bearing,
        })
    }

    fn attach(&mut self, name: &str, at: &Attachment) -> Result<multibody::Attachment, AdaptiveError> {
        let Some(body) = at.body else {
            let Place::Point(point) = &at.place else {
                let what = "places on ground are given by points".into();
                return Err(AdaptiveError::Unsupported { subject: name.to_owned(), what });
            };
            self.ground.push(Marker::rigid(name, Vector3::from(*point), at.rotation));
            return Ok(multibody::Attachment::new(GROUND, name));
        };
        self.markers[body].push(self.bodies[body].marker(name, &at.place, at.rotation)?);
        Ok(multibody::Attachment::new(&self.bodies[body].name, name))
    }
}

fn coordinate_force(spec: &CoordinateSpec) -> CoordinateForce {
    CoordinateForce {
        stiffness: spec.stiffness,
        rest: spec.rest,
        damping: spec.damping,
        stop: spec.stop,
        friction: spec.friction,
        drive: spec.drive.as_ref().map(TimeCurve::function),
        motion: spec.motion.as_ref().map(TimeCurve::function),
    }
}

/// Names and units of the positions and of the velocities of a joint.
pub fn coordinate_names(kind: JointKind) -> (Vec<NameAndUnit>, Vec<NameAndUnit>) {
    let pair = |name: &str, unit: &str| (name.to_owned(), unit.to_owned());
    let axes = ["x", "y", "z"];
    let displacement = |c: &str| pair(&format!("displacement {c}"), "m");
    let velocity = |c: &str| pair(&format!("velocity {c}"), "m/s");
    let quaternion = || ["w", "x", "y", "z"].map(|c| pair(&format!("quaternion {c}"), "–"));
    let spin = || axes.map(|c| pair(&format!("angular velocity {c}"), "rad/s"));
    let FreeDirections(free) = kind.free_directions();
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    for axis in (0..3).filter(|&axis| free[axis]) {
        positions.push(displacement(axes[axis]));
        velocities.push(velocity(axes[axis]));
    }
    match free[3..].iter().filter(|free| **free).count() {
        0 => {}
        1 => {
            positions.push(pair("angle", "rad"));
            velocities.push(pair("angular velocity", "rad/s"));
        }
        3 => {
            positions.extend(quaternion());
            velocities.extend(spin());
        }
        several => {
            positions.extend((1..=several).map(|k| pair(&format!("angle {k}"), "rad")));
            velocities.extend((1..=several).map(|k| pair(&format!("angular velocity {k}"), "rad/s")));
        }
    }
    (positions, velocities)
}
