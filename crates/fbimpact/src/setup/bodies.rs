//! Bodies that move.

use std::sync::Arc;

use adaptive::sizing::mode_count::WITHOUT_FORCES;
use adaptive::spec::ImportedSpec;
use adaptive::spec::{
    Area, BodyKind, BodySpec, Coupling, DampingSpec, DiscretisationSpec, ElasticSpec, FrameSpec,
    InitialMotion, Place as PlaceSpec, ReductionSpec, RefinementSpec, Resolution,
};
use iga_core::SplineError;
use iga_core::elasticity::Material;
use iga_core::nurbs::Shape;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::places::Markers;
use super::{geometry, rigid};
use crate::error::AppError;
use crate::scenario::{self, Place, Scenario};

/// Elements a direction in the specification of a body for which the program still has to choose them.
const FIRST_ELEMENTS: usize = 8;

/// Bodies of the scenario that move, and where each body of the file stands among them.
pub struct Bodies {
    /// Bodies that move.
    pub specs: Vec<BodySpec>,
    /// Their named places.
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
            let held = Held::of(scenario, number);
            let Some((kind, markers)) = kind(body, &held)? else {
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

    /// Parts of the body called `name` that can be held, by name.
    pub fn areas(&self, name: &str) -> Vec<(String, Area)> {
        let number = self.specs.iter().position(|body| body.name == name);
        number.map(|number| self.markers[number].areas()).unwrap_or_default()
    }

    /// A point of the moving body `number` in the components of its model \[m\].
    ///
    /// # Errors
    /// [`AppError::Model`] for an unknown marker.
    pub fn point(&self, number: usize, at: &Place) -> Result<[f64; 3], AppError> {
        self.markers[number].point(at)
    }

    /// Where the moving body `number` is observed: at a point, or on average over the extent of a marker that has one and is no
    /// point of the shape.
    ///
    /// # Errors
    /// [`AppError::Model`] for an unknown marker, and for a point on a body from a file.
    pub fn observed(&self, number: usize, at: &Place) -> Result<PlaceSpec, AppError> {
        self.place(number, at, Markers::observed)
    }

    /// Where a joint or load takes hold of the moving body `number`: of a part of it, if the place has an extent.
    ///
    /// # Errors
    /// As [`Bodies::observed`].
    pub fn held(&self, number: usize, at: &Place) -> Result<PlaceSpec, AppError> {
        self.place(number, at, Markers::held)
    }

    fn place(
        &self,
        number: usize,
        at: &Place,
        find: impl Fn(&Markers, &Place) -> Result<PlaceSpec, AppError>,
    ) -> Result<PlaceSpec, AppError> {
        let BodySpec { name, kind, .. } = &self.specs[number];
        match (kind, at) {
            (BodyKind::Imported(_), Place::Marker(marker)) => Ok(PlaceSpec::Marker(marker.clone())),
            (BodyKind::Imported(_), Place::Point(_) | Place::Area { .. }) => {
                Err(AppError::Model(format!("body \"{name}\" is from a file, name a marker of the file")))
            }
            _ => find(&self.markers[number], at),
        }
    }
}

/// Places at which a body is held.
struct Held<'a> {
    /// Those of joints.
    joints: Vec<&'a Place>,
    /// Those of loads.
    loads: Vec<&'a Place>,
}

impl<'a> Held<'a> {
    /// Places on body `index` of the file.
    fn of(scenario: &'a Scenario, index: usize) -> Self {
        let sides = scenario.joints.iter().flat_map(|j| [&j.parent, &j.child]);
        let on_body = |at: &&scenario::Attachment| at.body == Some(index);
        Self {
            joints: sides.filter(on_body).map(|side| &side.at).collect(),
            loads: scenario.loads.iter().map(|l| &l.at).filter(on_body).map(|at| &at.at).collect(),
        }
    }

    /// Parts that move like rigid bodies, each one once.
    fn rigid_areas(&self, markers: &Markers) -> Result<Vec<Area>, AppError> {
        let mut areas = Vec::new();
        for at in self.joints.iter().chain(&self.loads) {
            match markers.held(at)? {
                PlaceSpec::Area(area) if area.coupling == Coupling::Rigid && !areas.contains(&area) => {
                    areas.push(area);
                }
                _ => {}
            }
        }
        Ok(areas)
    }
}

/// What a body held at `held` is, with its markers; nothing of a plane.
fn kind(body: &scenario::Body, held: &Held<'_>) -> Result<Option<(BodyKind, Markers)>, AppError> {
    let fail = |source: SplineError| AppError::Model(format!("body \"{}\": {source}", body.name));
    match &body.kind {
        scenario::BodyKind::RigidPlane { .. } => Ok(None),
        scenario::BodyKind::Rigid(given) => {
            let (spec, shape) = rigid::rigid_body(given).map_err(fail)?;
            let markers = Markers::new(body, shape, true)?;
            Ok(Some((BodyKind::Rigid(spec), markers)))
        }
        scenario::BodyKind::Imported(given) => {
            Ok(Some((BodyKind::Imported(imported(given)), Markers::new(body, None, false)?)))
        }
        scenario::BodyKind::Elastic(elastic) => {
            let degree = elastic.discretisation.degree.iter().min().copied().unwrap_or(0);
            let shape = geometry::shape(&elastic.geometry, elastic.model, degree).map_err(fail)?;
            let model = geometry::model(elastic.model);
            let markers = Markers::new(body, Some((shape.clone(), model)), false)?;
            let m = &elastic.material;
            let material = Material::new(m.youngs_modulus, m.poissons_ratio, m.density).map_err(fail)?;
            let frame = match &elastic.frame {
                scenario::Frame::Buckens => FrameSpec::Buckens,
                scenario::Frame::Tangent(at) => FrameSpec::Tangent(markers.held(at)?),
            };
            let shape = Shape { markers: markers.points().clone(), ..shape };
            let spec = ElasticSpec {
                discretisation: discretisation(elastic, &shape, |at| markers.point(at))?,
                model,
                material,
                shape,
                reduction: reduction(elastic.reduction),
                static_answers: elastic.reduction.has_static_answers(),
                damping: damping(elastic.damping.as_ref()),
                rigid_areas: held.rigid_areas(&markers)?,
                frame,
                geometric_stiffening: elastic.geometric_stiffening,
            };
            Ok(Some((BodyKind::Elastic(Box::new(spec)), markers)))
        }
    }
}

/// A body from a file.
fn imported(body: &scenario::ImportedBody) -> ImportedSpec {
    match body {
        scenario::ImportedBody::Reduced(model) => ImportedSpec::Reduced(Arc::clone(&model.value)),
        scenario::ImportedBody::Full { body, reduction: basis, damping: damped, frame } => {
            ImportedSpec::Full {
                body: Arc::clone(&body.value),
                reduction: reduction(*basis),
                static_answers: basis.has_static_answers(),
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
    shape: &Shape,
    point: impl Fn(&Place) -> Result<[f64; 3], AppError>,
) -> Result<DiscretisationSpec, AppError> {
    let mesh = &elastic.discretisation;
    let refine = mesh.refine.iter().map(|r| {
        let (width, elements, ratio) = (r.width, r.elements, r.ratio);
        Ok(RefinementSpec { centre: point(&r.at)?, width, elements, ratio })
    });
    Ok(DiscretisationSpec {
        degrees: geometry::raised(&mesh.degree, shape),
        elements: mesh.elements.clone().unwrap_or_else(|| vec![FIRST_ELEMENTS; mesh.degree.len()]),
        knots: mesh.knots.clone(),
        refine: refine.collect::<Result<_, AppError>>()?,
    })
}

fn reduction(reduction: scenario::Reduction) -> ReductionSpec {
    match reduction {
        scenario::Reduction::Modal { modes, .. } => {
            ReductionSpec::Modal { modes: modes.unwrap_or(WITHOUT_FORCES) }
        }
        scenario::Reduction::CraigBampton { modes, fixed_interface_modes, .. } => {
            ReductionSpec::CraigBampton { modes: modes.unwrap_or(WITHOUT_FORCES), fixed_interface_modes }
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
