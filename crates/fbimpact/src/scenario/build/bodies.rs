//! Bodies: which keys go with which model, materials by name, initial states that the model can
//! take.

pub(super) mod parts;
mod discretisation;
mod geometry;
mod imported;
mod known_shapes;
mod meshed;
mod rigid;

use adaptive::sizing::SizeRequest;
use adaptive::spec::{BodyKind, BodySpec, ElasticSpec, FlexibleSpec, InitialMotion};
use contact_qs::Plane;
use ffr_dynamics::body::RigidMotion;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use super::super::body_places::{BodyPlaces, GivenPlace};
use super::super::files::bodies::is_meshed;
use super::super::section::Section;
use super::super::tables::BodyModel;
use super::super::types::FileOfBody;
use super::built_bodies::{Built, BuiltBodies, Moving, MovingFacts};
use super::joints::GROUND;
use super::places::{BodyFacts, given_place, motion_in_words, part};
use discretisation::{discretisation, reduction};
use known_shapes::KnownShapes;
use parts::{GivenFrame, damping, elastic_model, frame, material, stiffening};
use rigid::Rigid;

/// Markers that the user has added, by name.
type Markers = Vec<(String, GivenPlace)>;

/// All bodies, as far as their own tables say.
pub fn bodies(root: &Section) -> BuiltBodies {
    let list = root.named("bodies").iter();
    let mut known = KnownShapes::default();
    let built = list.map(|(name, section)| body(root, &mut known, name, section));
    BuiltBodies::new(built.collect())
}

fn body(root: &Section, known: &mut KnownShapes, name: &str, section: &Section) -> Option<Built> {
    if name == GROUND {
        section.fault_here("\"ground\" is the name of space, choose another");
        return None;
    }
    let orientation = orientation(section);
    let is_imported = section.choice("model") == Some(BodyModel::Imported);
    let markers = if is_imported { Some(Vec::new()) } else { markers(section) };
    let made = match section.choice("model") {
        Some(_) if is_meshed(section) => meshed::meshed(root, section, name, markers.as_deref())
            .map(|(kind, facts)| Made::Moving(kind, Box::new(facts))),
        Some(BodyModel::Rigid) => {
            let made = rigid::rigid(root, known, section, orientation, markers.as_deref());
            made.map(|rigid| match rigid {
                Rigid::Moving(moving) => {
                    let (kind, places) = *moving;
                    let file = spline_file(section);
                    Made::Moving(kind, Box::new(MovingFacts { places, file, ..Default::default() }))
                }
                Rigid::Plane(normal) => {
                    Made::Plane(Plane { point: Vector3::zeros(), normal: Unit::new_normalize(normal) })
                }
            })
        }
        Some(BodyModel::Imported) => {
            imported::imported(root, section, name).map(|(kind, facts)| Made::Moving(kind, Box::new(facts)))
        }
        Some(
            model @ (BodyModel::Solid
            | BodyModel::Axisymmetric
            | BodyModel::PlaneStrain
            | BodyModel::PlaneStress),
        ) => {
            let frame = frame(root, section, name);
            let made = elastic(root, section, model, frame, markers.as_deref());
            made.map(|(spec, facts)| Made::Moving(BodyKind::Elastic(Box::new(spec)), Box::new(facts)))
        }
        Some(BodyModel::Mesh) | None => None,
    };
    let made = made?;
    markers?;
    let (position, velocity) = (section.vector("position")?, section.vector("velocity")?);
    let (orientation, angular_velocity) = (orientation?, section.vector("angular_velocity")?);
    check_motion(section, made.motion(), &velocity, &angular_velocity, &orientation);
    Some(match made {
        Made::Plane(plane) => Built::Plane(Plane { point: position.into(), ..plane }),
        Made::Moving(kind, facts) => {
            let facts = *facts;
            let motion = InitialMotion {
                position: position.into(),
                rotation: rotation(orientation),
                velocity: velocity.into(),
                angular_velocity: angular_velocity.into(),
            };
            Built::Moving(Box::new(Moving { spec: BodySpec { name: name.to_owned(), kind, motion }, facts }))
        }
    })
}

/// The file that the shape of a body comes from.
fn spline_file(section: &Section) -> Option<FileOfBody> {
    let source = section.table("geometry")?.spline_file()?;
    Some(FileOfBody { path: source.path.clone(), sha256: source.sha256.clone(), unit: source.unit })
}

/// What a body is, without its motion.
enum Made {
    Moving(BodyKind, Box<MovingFacts>),
    Plane(Plane),
}

impl Made {
    /// Rigid motions of the body; none of a plane.
    fn motion(&self) -> Option<RigidMotion> {
        match self {
            Self::Moving(kind, _) => Some(kind.motion()),
            Self::Plane(_) => None,
        }
    }
}

/// The rotation of a unit quaternion `w x y z`.
fn rotation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// Markers that the user has added.
fn markers(section: &Section) -> Option<Markers> {
    let list = section.named("markers");
    if list.is_empty() {
        return section.item("markers").map(|_| Vec::new());
    }
    let facts = BodyFacts::of(section)?;
    let own = facts.shape_markers();
    let mut built = Vec::with_capacity(list.len());
    for (name, marker) in list {
        if own.contains(&name.as_str()) {
            let message =
                format!("shape \"{}\" has a marker of this name already, choose another", facts.shape_name());
            marker.fault_here(message);
            continue;
        }
        let key = given_place(marker, &["face", "point"]);
        let at = key.and_then(|key| part(marker, key, &facts));
        built.extend(at.map(|at| (name.clone(), at)));
    }
    (built.len() == list.len()).then_some(built)
}

/// Rejects initial motions that the model of the body cannot take.
fn check_motion(
    section: &Section,
    motion: Option<RigidMotion>,
    velocity: &[f64; 3],
    angular_velocity: &[f64; 3],
    orientation: &[f64; 4],
) {
    let checks: [(&str, &[f64]); 3] =
        [("velocity", velocity), ("angular_velocity", angular_velocity), ("orientation", orientation)];
    for (key, value) in checks {
        if let Some(message) = leaves_model(motion, key, value) {
            section.fault(key, message);
        }
    }
}

/// Why the vector `key` leaves the space in which a body of the motions `motion` moves, if it does;
/// a plane has none.
///
/// A quaternion leaves it when its vector part does.
pub fn leaves_model(motion: Option<RigidMotion>, key: &str, value: &[f64]) -> Option<String> {
    let Some(motion) = motion else {
        let moves = matches!(key, "velocity" | "angular_velocity") && value.iter().any(|x| x.abs() > 0.0);
        return moves.then(|| "a rigid plane is at rest, moving ones are not supported yet".to_owned());
    };
    let turns = matches!(key, "angular_velocity" | "orientation");
    // Components that must vanish.
    let (zero, words): (&[usize], &str) = match (motion, turns) {
        (RigidMotion::Spatial, _) => (&[], ""),
        (RigidMotion::Axial, false) => (&[0, 1], "along z"),
        (RigidMotion::Axial, true) => (&[0, 1, 2], "zero"),
        (RigidMotion::Planar, false) => (&[2], "in the plane (x, y)"),
        (RigidMotion::Planar, true) => (&[0, 1], "about z"),
    };
    let vector = if value.len() == 4 { &value[1..] } else { value };
    let leaves = zero.iter().any(|&i| vector[i].abs() > 0.0);
    leaves.then(|| format!("must be {words} for a body that is {}", motion_in_words(motion)))
}

fn orientation(section: &Section) -> Option<[f64; 4]> {
    let v = section.numbers("orientation")?;
    if let Ok(quaternion) = <[f64; 4]>::try_from(v) {
        let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        // Four digits typed by hand are accepted and normalised.
        if (norm - 1.0).abs() > 1e-3 {
            let message = format!("a quaternion must have unit length within 0.001, this one has {norm:.6}");
            return section.refuse("orientation", message);
        }
        return Some(quaternion.map(|x| x / norm));
    }
    let r: [f64; 3] = v.try_into().ok()?;
    let rotation = nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::from(r));
    Some([rotation.w, rotation.i, rotation.j, rotation.k])
}

fn elastic(
    root: &Section,
    section: &Section,
    model: BodyModel,
    frame: Option<GivenFrame>,
    markers: Option<&[(String, GivenPlace)]>,
) -> Option<(ElasticSpec, MovingFacts)> {
    let kind = elastic_model(section, model);
    let material = material(root, section);
    if section.item("geometry").is_none() {
        let or_mesh = if model == BodyModel::Solid { "" } else { ", or \"file\", a mesh in the plane" };
        let message = format!("required key is missing: a table with a \"shape\"{or_mesh}");
        section.fault("geometry", message);
    }
    let degree = section.table("discretisation").and_then(|d| d.counts("degree")?.into_iter().min());
    let shape = geometry::shape(section, model, degree.unwrap_or(0));
    let places = shape.zip(kind).zip(markers).and_then(|((shape, model), markers)| {
        let places = BodyPlaces::flexible(shape, model, markers);
        places.map_err(|e| section.fault("markers", e.to_string())).ok()
    });
    let facts = BodyFacts::of(section);
    let mesh = section.table("discretisation");
    let mesh = mesh.and_then(|d| discretisation(d, &facts?, places.as_ref()));
    let basis = section.table("reduction").and_then(reduction);
    let damping = damping(section);
    let geometric_stiffening = stiffening(section, frame.as_ref())?;
    let (places, (discretisation, wants_elements), basis) = (places?, mesh?, basis?);
    let follows_joint = frame == Some(GivenFrame::AtJoint);
    let frame = frame?.on_body(section, &places)?;
    let (shape, model) = places.shape()?.clone();
    let flexible = FlexibleSpec {
        static_answers: basis.static_answers,
        damping: damping?,
        frame,
        geometric_stiffening,
        ..FlexibleSpec::new(basis.spec)
    };
    let spec = ElasticSpec { shape, model, material: material?, discretisation, flexible };
    let wish = SizeRequest { elements: wants_elements, modes: basis.wants_modes };
    Some((spec, MovingFacts { places, wish, file: spline_file(section), follows_joint }))
}
