//! Bodies that move, with their markers.

use std::collections::BTreeMap;
use std::sync::Arc;

use adaptive::imported::ImportedSpec;
use adaptive::spec::{
    BodyKind, BodySpec, DampingSpec, DiscretisationSpec, ElasticSpec, FrameSpec, InitialMotion,
    Place as PlaceSpec, ReductionSpec, RefinementSpec, Resolution,
};
use iga_core::SplineError;
use iga_core::elasticity::Material;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{geometry, rigid};
use crate::error::AppError;
use crate::scenario::{self, Place, Scenario};

/// Points by name, in the components of a body's model \[m\].
pub type Markers = BTreeMap<String, [f64; 3]>;

/// Bodies of the scenario that move, and where each body of the file stands among them.
pub struct Bodies {
    /// Bodies that move.
    pub specs: Vec<BodySpec>,
    /// Their markers.
    markers: Vec<Markers>,
    /// Number among them of every body of the file; none of a plane.
    index: Vec<Option<usize>>,
}

impl Bodies {
    /// All bodies of `scenario`.
    ///
    /// # Errors
    /// [`AppError::Model`] naming the body that cannot be built.
    pub fn new(scenario: &Scenario) -> Result<Self, AppError> {
        let mut bodies = Self { specs: Vec::new(), markers: Vec::new(), index: Vec::new() };
        for (number, body) in scenario.bodies.iter().enumerate() {
            let Some((kind, markers)) = kind(body, &joint_places(scenario, number))? else {
                bodies.index.push(None);
                continue;
            };
            bodies.index.push(Some(bodies.specs.len()));
            bodies.specs.push(BodySpec { name: body.name.clone(), kind, motion: motion(body) });
            bodies.markers.push(markers);
        }
        Ok(bodies)
    }

    /// Factors of the bodies that move, and of the contacts.
    pub fn resolution(&self, of_file: &scenario::Resolution) -> Resolution {
        let moving = self.index.iter().zip(&of_file.bodies).filter(|(index, _)| index.is_some());
        Resolution {
            bodies: moving.map(|(_, factors)| *factors).collect(),
            contacts: of_file.contacts.clone(),
        }
    }

    /// Number among the moving bodies of body `index` of the file.
    ///
    /// # Errors
    /// [`AppError::Model`] with `subject` for a plane.
    pub fn moving(&self, index: usize, subject: &str) -> Result<usize, AppError> {
        let plane =
            || AppError::Model(format!("{subject}: the body is a plane at rest, name one that moves"));
        self.index[index].ok_or_else(plane)
    }

    /// Number among the moving bodies of body `index` of the file, which must be flexible and have a shape.
    ///
    /// # Errors
    /// [`AppError::Model`] with `subject` if it is not.
    pub fn flexible(&self, index: usize, subject: &str) -> Result<usize, AppError> {
        let number = self.index[index].filter(|&n| self.specs[n].elastic().is_some());
        let refused = "the body is rigid or from a file, name a flexible one with a shape";
        number.ok_or_else(|| AppError::Model(format!("{subject}: {refused}")))
    }

    /// Rotation to space of the moving body `number` at the start, or with all joint coordinates at zero.
    pub fn rotation(&self, number: usize) -> UnitQuaternion<f64> {
        self.specs[number].motion.rotation
    }

    /// A place on the moving body `number` in the components of its model \[m\].
    ///
    /// # Errors
    /// [`AppError::Model`] for an unknown marker.
    pub fn point(&self, number: usize, at: &Place) -> Result<[f64; 3], AppError> {
        named_point(&self.specs[number].name, &self.markers[number], at)
    }

    /// The same as a place of the specification.
    ///
    /// # Errors
    /// [`AppError::Model`] for an unknown marker, and for a point on a body from a file.
    pub fn place(&self, number: usize, at: &Place) -> Result<PlaceSpec, AppError> {
        let BodySpec { name, kind, .. } = &self.specs[number];
        match (kind, at) {
            (BodyKind::Imported(_), Place::Marker(marker)) => Ok(PlaceSpec::Marker(marker.clone())),
            (BodyKind::Imported(_), Place::Point(_)) => {
                Err(AppError::Model(format!("body \"{name}\" is from a file, name a marker of the file")))
            }
            _ => self.point(number, at).map(PlaceSpec::Point),
        }
    }
}

/// A place on the body called `name` that has `markers`.
fn named_point(name: &str, markers: &Markers, at: &Place) -> Result<[f64; 3], AppError> {
    match at {
        Place::Point(point) => Ok(*point),
        Place::Marker(marker) => markers.get(marker).copied().ok_or_else(|| {
            let known: Vec<&str> = markers.keys().map(String::as_str).collect();
            AppError::Model(format!(
                "body \"{name}\" has no marker \"{marker}\", it has {}",
                known.join(", ")
            ))
        }),
    }
}

/// Places of the joints on body `index` of the file.
fn joint_places(scenario: &Scenario, index: usize) -> Vec<&Place> {
    let sides = scenario.joints.iter().flat_map(|j| [&j.parent, &j.child]);
    sides.filter(|side| side.body == Some(index)).map(|side| &side.at).collect()
}

/// What a body with joints at `joints` is, with its markers; nothing of a plane.
fn kind(body: &scenario::Body, joints: &[&Place]) -> Result<Option<(BodyKind, Markers)>, AppError> {
    let fail = |source: SplineError| AppError::Model(format!("body \"{}\": {source}", body.name));
    let added = || body.markers.iter().map(|m| (m.name.clone(), m.point));
    match &body.kind {
        scenario::BodyKind::RigidPlane { .. } => Ok(None),
        scenario::BodyKind::Rigid(rigid) => {
            let (spec, mut markers) = rigid::rigid_body(rigid).map_err(fail)?;
            markers.extend(added());
            Ok(Some((BodyKind::Rigid(spec), markers)))
        }
        scenario::BodyKind::Imported(body) => {
            Ok(Some((BodyKind::Imported(imported(body, joints)), Markers::new())))
        }
        scenario::BodyKind::Elastic(elastic) => {
            let degree = elastic.discretisation.degree.iter().min().copied().unwrap_or(0);
            let mut shape = geometry::shape(&elastic.geometry, elastic.model, degree).map_err(fail)?;
            shape.markers.extend(added());
            let markers = shape.markers.clone();
            let m = &elastic.material;
            let material = Material::new(m.youngs_modulus, m.poissons_ratio, m.density).map_err(fail)?;
            let frame = match &elastic.frame {
                scenario::Frame::Buckens => FrameSpec::Buckens,
                scenario::Frame::Tangent(at) => {
                    FrameSpec::Tangent(PlaceSpec::Point(named_point(&body.name, &markers, at)?))
                }
            };
            let interface = match elastic.reduction {
                scenario::Reduction::CraigBampton { joint_interface: true, .. } => joints
                    .iter()
                    .map(|at| named_point(&body.name, &markers, at).map(PlaceSpec::Point))
                    .collect::<Result<_, AppError>>()?,
                _ => Vec::new(),
            };
            let spec = ElasticSpec {
                discretisation: discretisation(elastic, &shape, |at| named_point(&body.name, &markers, at))?,
                model: geometry::model(elastic.model),
                material,
                shape,
                reduction: reduction(elastic.reduction),
                damping: damping(elastic.damping.as_ref()),
                interface,
                frame,
                geometric_stiffening: elastic.geometric_stiffening,
            };
            Ok(Some((BodyKind::Elastic(Box::new(spec)), markers)))
        }
    }
}

/// A body from a file with joints at `joints`.
fn imported(body: &scenario::ImportedBody, joints: &[&Place]) -> ImportedSpec {
    match body {
        scenario::ImportedBody::Reduced(model) => ImportedSpec::Reduced(Arc::clone(&model.value)),
        scenario::ImportedBody::Full { body, reduction: basis, damping: damped, frame } => {
            let mut interface = Vec::new();
            if matches!(basis, scenario::Reduction::CraigBampton { joint_interface: true, .. }) {
                // Other places are faults of the scenario.
                let markers = joints.iter().filter_map(|at| match at {
                    Place::Marker(marker) => Some(marker.clone()),
                    Place::Point(_) => None,
                });
                interface.extend(markers);
            }
            ImportedSpec::Full {
                body: Arc::clone(&body.value),
                reduction: reduction(*basis),
                interface,
                damping: damping(damped.as_ref()),
                frame: frame.clone(),
            }
        }
    }
}

fn motion(body: &scenario::Body) -> InitialMotion {
    InitialMotion {
        position: Vector3::from(body.position),
        rotation: rotation(body.orientation),
        velocity: Vector3::from(body.velocity),
        angular_velocity: Vector3::from(body.angular_velocity),
    }
}

/// The rotation of a unit quaternion `w x y z`.
pub fn rotation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

fn discretisation(
    elastic: &scenario::ElasticBody,
    shape: &iga_core::nurbs::Shape,
    point: impl Fn(&Place) -> Result<[f64; 3], AppError>,
) -> Result<DiscretisationSpec, AppError> {
    let mesh = &elastic.discretisation;
    let refine = mesh.refine.iter().map(|r| {
        let (width, elements, ratio) = (r.width, r.elements, r.ratio);
        Ok(RefinementSpec { centre: point(&r.at)?, width, elements, ratio })
    });
    Ok(DiscretisationSpec {
        degrees: geometry::raised(&mesh.degree, shape),
        elements: mesh.elements.clone(),
        knots: mesh.knots.clone(),
        refine: refine.collect::<Result<_, AppError>>()?,
    })
}

fn reduction(reduction: scenario::Reduction) -> ReductionSpec {
    match reduction {
        scenario::Reduction::Modal { modes } => ReductionSpec::Modal { modes },
        scenario::Reduction::CraigBampton { modes, fixed_interface_modes, .. } => {
            ReductionSpec::CraigBampton { modes, fixed_interface_modes }
        }
        scenario::Reduction::All => ReductionSpec::All,
    }
}

fn damping(damping: Option<&scenario::Damping>) -> DampingSpec {
    match damping {
        None => DampingSpec::None,
        Some(scenario::Damping::Rayleigh { frequencies, ratio }) => {
            DampingSpec::Rayleigh { frequencies: *frequencies, ratio: *ratio }
        }
        Some(scenario::Damping::Modal(ratios)) => DampingSpec::Modal(ratios.clone()),
    }
}
