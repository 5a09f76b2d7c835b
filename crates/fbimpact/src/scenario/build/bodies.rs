//! Bodies: which keys go with which model, materials by name, initial states that the model can take.

use ffr_dynamics::body::RigidMotion;

use super::super::check::Checker;
use super::super::model::{Body, BodyKind, ElasticBody, Frame, Marker};
use super::super::section::Section;
use super::body_parts::{Context, damping, elastic_model, frame, material};
use super::discretisation::{discretisation, reduction};
use super::joints::{GROUND, hanging_joint};
use super::places::{BodyFacts, part};
use super::{geometry, imported, rigid};

/// All bodies; `None` if one of them is at fault.
pub fn bodies(checker: &mut Checker, context: Context<'_>) -> Option<Vec<Body>> {
    let list = context.root.named("bodies");
    let built: Vec<Body> =
        list.iter().filter_map(|(name, section)| body(checker, context, name, section)).collect();
    (built.len() == list.len()).then_some(built)
}

fn body(checker: &mut Checker, context: Context<'_>, name: &str, section: &Section) -> Option<Body> {
    let Context { root, directory, .. } = context;
    if name == GROUND {
        let message = "\"ground\" is the name of space, choose another".into();
        checker.fault(&section.origin, section.path.clone(), None, message);
        return None;
    }
    let hangs_on = hanging_joint(root, name);
    if let Some(joint) = hangs_on {
        for key in ["position", "velocity", "angular_velocity"].into_iter().filter(|key| section.given(key)) {
            checker.fault_in(section, key, format!("follows from joint \"{joint}\" on which the body hangs"));
        }
    }
    let orientation = orientation(checker, section);
    let is_imported = section.text("model") == Some("imported");
    let markers = if is_imported { Some(Vec::new()) } else { markers(checker, section) };
    let kind = match section.text("model") {
        Some("rigid") => rigid::rigid(checker, root, section, orientation, directory),
        Some("imported") => imported::imported(checker, context, section, name),
        Some(model) => {
            let frame = frame(checker, context, section, name);
            elastic(checker, context, section, model, frame).map(Box::new).map(BodyKind::Elastic)
        }
        None => None,
    };
    let body = Body {
        name: name.to_owned(),
        kind: kind?,
        markers: markers?,
        position: section.vector("position")?,
        orientation: orientation?,
        velocity: section.vector("velocity")?,
        angular_velocity: section.vector("angular_velocity")?,
    };
    check_motion(checker, section, &body);
    Some(body)
}

/// Markers that the user has added.
fn markers(checker: &mut Checker, section: &Section) -> Option<Vec<Marker>> {
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
                format!("shape \"{}\" has a marker of this name already, choose another", facts.shape);
            checker.fault(&marker.origin, marker.path.clone(), None, message);
            continue;
        }
        let keys = ["face", "point"].into_iter().filter(|key| marker.item(key).is_some());
        let at = match keys.collect::<Vec<_>>()[..] {
            [key] => part(checker, marker, key, &facts),
            [] => {
                let message = "required key is missing: either \"face\" or \"point\"".into();
                checker.fault(&marker.origin, marker.path_of("point"), None, message);
                None
            }
            _ => {
                let message = "either \"face\" or \"point\" can be given, not both".into();
                checker.fault_in(marker, "face", message);
                None
            }
        };
        built.extend(at.map(|at| Marker { name: name.clone(), at }));
    }
    (built.len() == list.len()).then_some(built)
}

/// Rejects initial motions that the model of the body cannot take.
fn check_motion(checker: &mut Checker, section: &Section, body: &Body) {
    let checks: [(&str, &[f64]); 3] = [
        ("velocity", &body.velocity),
        ("angular_velocity", &body.angular_velocity),
        ("orientation", &body.orientation),
    ];
    for (key, value) in checks {
        if let Some(message) = leaves_model(body, key, value) {
            checker.fault_in(section, key, message);
        }
    }
}

/// Why the vector `key` leaves the space in which the model of `body` moves, if it does.
///
/// A quaternion leaves it when its vector part does.
pub fn leaves_model(body: &Body, key: &str, value: &[f64]) -> Option<String> {
    let motion = match &body.kind {
        BodyKind::RigidPlane { .. } => {
            let moves = matches!(key, "velocity" | "angular_velocity") && value.iter().any(|x| x.abs() > 0.0);
            return moves.then(|| "a rigid plane is at rest, moving ones are not supported yet".to_owned());
        }
        BodyKind::Rigid(rigid) => rigid.motion,
        BodyKind::Elastic(elastic) => elastic.model.motion(),
        BodyKind::Imported(imported) => imported.motion(),
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
    let model = if motion == RigidMotion::Axial { "axisymmetric" } else { "plane" };
    leaves.then(|| format!("must be {words} for a body that is {model}"))
}

fn orientation(checker: &mut Checker, section: &Section) -> Option<[f64; 4]> {
    let v = section.numbers("orientation")?;
    if let Ok(quaternion) = <[f64; 4]>::try_from(v) {
        let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        // Four digits typed by hand are accepted and normalised.
        if (norm - 1.0).abs() > 1e-3 {
            let message = format!("a quaternion must have unit length within 0.001, this one has {norm:.6}");
            checker.fault_in(section, "orientation", message);
            return None;
        }
        return Some(quaternion.map(|x| x / norm));
    }
    let r: [f64; 3] = v.try_into().ok()?;
    let rotation = nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::from(r));
    Some([rotation.w, rotation.i, rotation.j, rotation.k])
}

fn elastic(
    checker: &mut Checker,
    context: Context<'_>,
    section: &Section,
    model: &str,
    frame: Option<Frame>,
) -> Option<ElasticBody> {
    for key in ["normal", "motion", "mass", "centre_of_mass", "inertia"] {
        if section.given(key) {
            let owner = if key == "normal" { "the shape \"plane\"" } else { "bodies with model \"rigid\"" };
            checker.fault_in(section, key, format!("has a meaning for {owner} only"));
        }
    }
    let kind = elastic_model(checker, section, model);
    let material = material(checker, context.root, section);
    if section.item("geometry").is_none() {
        let message = "required key is missing: a table with a \"shape\"".into();
        checker.fault(&section.origin, section.path_of("geometry"), None, message);
    }
    let geometry = geometry::geometry(checker, section, model, context.directory);
    let facts = BodyFacts::of(section);
    let discretisation = section.table("discretisation").and_then(|d| discretisation(checker, d, &facts?));
    let reduction = section.table("reduction").and_then(|r| reduction(checker, r));
    let damping = damping(checker, section);
    let geometric_stiffening = section.boolean("geometric_stiffening")?;
    if geometric_stiffening && frame == Some(Frame::Buckens) {
        checker.fault_in(section, "geometric_stiffening", "needs frame = \"tangent\"".into());
    }
    if geometric_stiffening && model == "axisymmetric" {
        let message = "has no meaning for model \"axisymmetric\", which does not turn".into();
        checker.fault_in(section, "geometric_stiffening", message);
    }
    Some(ElasticBody {
        model: kind?,
        material: material?,
        geometry: geometry?,
        discretisation: discretisation?,
        reduction: reduction?,
        damping: damping?,
        frame: frame?,
        geometric_stiffening,
    })
}
