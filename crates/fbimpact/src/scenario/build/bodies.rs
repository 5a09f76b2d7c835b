//! Bodies: which keys go with which model, materials by name, initial states that the model can take.

use std::path::Path;

use super::super::check::Checker;
use super::super::model::{
    Body, BodyKind, Damping, Discretisation, ElasticBody, ElasticModel, Frame, Material, Reduction,
    Refinement,
};
use super::super::section::Section;
use super::{dimension, geometry, marker_or_point};

/// Thickness of a plane model when none is given \[m\].
const UNIT_THICKNESS: f64 = 1.0;

/// All bodies; `None` if one of them is at fault.
pub fn bodies(checker: &mut Checker, root: &Section, directory: &Path) -> Option<Vec<Body>> {
    let list = root.named("bodies");
    let built: Vec<Body> =
        list.iter().filter_map(|(name, section)| body(checker, root, name, section, directory)).collect();
    (built.len() == list.len()).then_some(built)
}

fn body(
    checker: &mut Checker,
    root: &Section,
    name: &str,
    section: &Section,
    directory: &Path,
) -> Option<Body> {
    let orientation = orientation(checker, section);
    let kind = match section.text("model") {
        Some("rigid") => rigid(checker, section, orientation),
        Some(model) => elastic(checker, root, section, model, directory).map(Box::new).map(BodyKind::Elastic),
        None => None,
    };
    let body = Body {
        name: name.to_owned(),
        kind: kind?,
        position: section.vector("position")?,
        orientation: orientation?,
        velocity: section.vector("velocity")?,
        angular_velocity: section.vector("angular_velocity")?,
    };
    check_motion(checker, section, &body);
    Some(body)
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
    let BodyKind::Elastic(elastic) = &body.kind else {
        let moves = matches!(key, "velocity" | "angular_velocity") && value.iter().any(|x| x.abs() > 0.0);
        return moves.then(|| "a rigid plane is at rest, moving ones are not supported yet".to_owned());
    };
    let turns = matches!(key, "angular_velocity" | "orientation");
    // Components that must vanish.
    let (zero, words): (&[usize], &str) = match (elastic.model, turns) {
        (ElasticModel::Solid, _) => (&[], ""),
        (ElasticModel::Axisymmetric, false) => (&[0, 1], "along z"),
        (ElasticModel::Axisymmetric, true) => (&[0, 1, 2], "zero"),
        (_, false) => (&[2], "in the plane (x, y)"),
        (_, true) => (&[0, 1], "about z"),
    };
    let vector = if value.len() == 4 { &value[1..] } else { value };
    let leaves = zero.iter().any(|&i| vector[i].abs() > 0.0);
    let model = if matches!(elastic.model, ElasticModel::Axisymmetric) { "axisymmetric" } else { "plane" };
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

fn rigid(checker: &mut Checker, section: &Section, orientation: Option<[f64; 4]>) -> Option<BodyKind> {
    for key in ["material", "thickness", "discretisation", "reduction", "damping", "frame"] {
        if section.given(key) {
            checker.fault_in(section, key, "has no meaning for a body with model \"rigid\"".into());
        }
    }
    let shape = section.table("geometry")?.text("shape")?;
    geometry::check_model(checker, section, "rigid", shape)?;
    let turned = section.given("orientation");
    let Some(normal) = section.item("normal") else {
        let [w, i, j, k] = orientation?;
        let q = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, i, j, k));
        return Some(BodyKind::RigidPlane { normal: (q * nalgebra::Vector3::z()).into() });
    };
    let path = normal.name;
    let n = nalgebra::Vector3::from(section.vector::<3>(path)?);
    if turned {
        checker.fault_in(section, path, "either \"normal\" or \"orientation\" can be given, not both".into());
        return None;
    }
    // The square of anything shorter than this would underflow.
    if n.norm() < 1e-150 {
        checker.fault_in(section, path, "must not be the zero vector".into());
        return None;
    }
    Some(BodyKind::RigidPlane { normal: n.normalize().into() })
}

fn elastic(
    checker: &mut Checker,
    root: &Section,
    section: &Section,
    model: &str,
    directory: &Path,
) -> Option<ElasticBody> {
    if section.given("normal") {
        checker.fault_in(section, "normal", "has a meaning for the shape \"plane\" only".into());
    }
    let kind = elastic_model(checker, section, model);
    let material = material(checker, root, section);
    let geometry = geometry::geometry(checker, section, model, directory);
    let shape = section.table("geometry").and_then(|g| g.text("shape"));
    let discretisation =
        section.table("discretisation").and_then(|d| discretisation(checker, d, model, shape?));
    let reduction = section.table("reduction").and_then(|r| reduction(checker, r));
    let damping = match section.table("damping") {
        Some(table) => {
            Some(Damping { frequencies: table.vector::<2>("frequencies")?, ratio: table.number("ratio")? })
        }
        None if section.given("damping") => return None,
        None => None,
    };
    section.text("frame")?;
    Some(ElasticBody {
        model: kind?,
        material: material?,
        geometry: geometry?,
        discretisation: discretisation?,
        reduction: reduction?,
        damping,
        frame: Frame::Buckens,
    })
}

fn elastic_model(checker: &mut Checker, section: &Section, model: &str) -> Option<ElasticModel> {
    let plane = matches!(model, "plane-strain" | "plane-stress");
    if section.given("thickness") && !plane {
        let message =
            format!("has a meaning for \"plane-strain\" and \"plane-stress\" only, the model is \"{model}\"");
        checker.fault_in(section, "thickness", message);
        return None;
    }
    let thickness = match section.item("thickness") {
        Some(_) => section.number("thickness")?,
        None => UNIT_THICKNESS,
    };
    Some(match model {
        "axisymmetric" => ElasticModel::Axisymmetric,
        "plane-strain" => ElasticModel::PlaneStrain { thickness },
        "plane-stress" => ElasticModel::PlaneStress { thickness },
        _ => ElasticModel::Solid,
    })
}

fn material(checker: &mut Checker, root: &Section, section: &Section) -> Option<Material> {
    if section.item("material").is_none() {
        let message = "required key is missing: the name of a material".into();
        checker.fault(&section.origin, section.path_of("material"), None, message);
        return None;
    }
    let list = root.named("materials");
    let name = section.text("material")?;
    let Some((_, material)) = list.iter().find(|(n, _)| n == name) else {
        let known: Vec<&str> = list.iter().map(|(n, _)| n.as_str()).collect();
        checker.unknown_name(section, "material", "material", &known);
        return None;
    };
    Some(Material {
        name: name.to_owned(),
        youngs_modulus: material.number("youngs_modulus")?,
        poissons_ratio: material.number("poissons_ratio")?,
        density: material.number("density")?,
    })
}

/// One entry a direction from a single integer or a list.
pub fn per_direction(
    checker: &mut Checker,
    section: &Section,
    key: &str,
    directions: usize,
) -> Option<Vec<usize>> {
    let counts = section.counts(key)?;
    match counts.len() {
        1 => Some(vec![counts[0]; directions]),
        n if n == directions => Some(counts),
        n => {
            let message = format!("{n} entries, the model has {directions} directions");
            checker.fault_in(section, key, message);
            None
        }
    }
}

fn discretisation(
    checker: &mut Checker,
    section: &Section,
    model: &str,
    shape: &str,
) -> Option<Discretisation> {
    let directions = dimension(model);
    let degree = per_direction(checker, section, "degree", directions);
    let elements = per_direction(checker, section, "elements", directions);
    let given_knots = section.item("knots").is_some();
    let knots =
        if given_knots { Some(knots(checker, section, directions, degree.as_deref())?) } else { None };
    if given_knots && section.given("elements") {
        let message = "either \"knots\" or \"elements\" can be given, not both".into();
        checker.fault_in(section, "knots", message);
    }
    let list = section.tables("refine");
    let refine: Vec<Refinement> = list.iter().filter_map(|r| refinement(checker, r, model, shape)).collect();
    if refine.len() != list.len() {
        return None;
    }
    Some(Discretisation { degree: degree?, elements: elements?, knots, refine })
}

fn knots(
    checker: &mut Checker,
    section: &Section,
    directions: usize,
    degree: Option<&[usize]>,
) -> Option<Vec<Vec<f64>>> {
    let lists = section.lists("knots")?;
    if lists.len() != directions {
        let message = format!("{} lists, the model has {directions} directions", lists.len());
        checker.fault_in(section, "knots", message);
        return None;
    }
    for (i, list) in lists.iter().enumerate() {
        if let Some(pair) = list.windows(2).find(|w| w[0] > w[1]) {
            let message = format!("knots of direction {i} fall from {} to {}", pair[0], pair[1]);
            checker.fault_in(section, "knots", message);
            return None;
        }
        let p = degree?[i];
        let same = |w: &&[f64]| w[0].total_cmp(&w[p]).is_eq();
        if let Some(run) = list.windows(p + 1).find(same) {
            let message = format!("knot {} of direction {i} stands more than {p} times, its degree", run[0]);
            checker.fault_in(section, "knots", message);
            return None;
        }
    }
    Some(lists.to_vec())
}

fn refinement(checker: &mut Checker, section: &Section, model: &str, shape: &str) -> Option<Refinement> {
    let at = marker_or_point(checker, section, model, shape);
    Some(Refinement {
        at: at?,
        width: section.number("width")?,
        elements: section.integer("elements")?,
        ratio: section.number("ratio")?,
    })
}

fn reduction(checker: &mut Checker, section: &Section) -> Option<Reduction> {
    let method = section.text("method")?;
    let mut meaningless = |key: &str| {
        if section.given(key) {
            checker.fault_in(section, key, format!("has no meaning for method \"{method}\""));
        }
    };
    if method != "craig-bampton" {
        meaningless("fixed_interface_modes");
    }
    if method == "all" {
        meaningless("modes");
        return Some(Reduction::All);
    }
    let modes = section.integer("modes")?;
    if method == "modal" {
        return Some(Reduction::Modal { modes });
    }
    let fixed_interface_modes = match section.item("fixed_interface_modes") {
        Some(_) => Some(section.integer("fixed_interface_modes")?),
        None => None,
    };
    if fixed_interface_modes.is_some_and(|n| n < modes) {
        let message = format!("must be at least \"modes\", which is {modes}");
        checker.fault_in(section, "fixed_interface_modes", message);
    }
    Some(Reduction::CraigBampton { modes, fixed_interface_modes })
}
