//! Rigid bodies: planes at rest, bodies with given mass, bodies whose mass follows from their shape.

use std::path::Path;

use ffr_dynamics::body::RigidMotion;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::super::check::Checker;
use super::super::model::{BodyKind, ElasticModel, RigidBody, RigidMass};
use super::super::section::{Checked, Section};
use super::body_parts::{elastic_model, material, optional_material};
use super::geometry;
use super::places::BodyFacts;

/// Keys that only flexible bodies have.
const ELASTIC_KEYS: [&str; 7] = [
    "discretisation",
    "reduction",
    "damping",
    "frame",
    "frame_marker",
    "frame_point",
    "geometric_stiffening",
];
/// Keys that say what follows from a shape.
const MASS_KEYS: [&str; 3] = ["mass", "centre_of_mass", "inertia"];
/// Asymmetry and negative moments that numbers written with many digits leave.
const ROUND_OFF: f64 = 1e-9;

/// A rigid body.
pub fn rigid(
    checker: &mut Checker,
    root: &Section,
    section: &Section,
    orientation: Option<[f64; 4]>,
    directory: &Path,
) -> Option<BodyKind> {
    for key in ELASTIC_KEYS.into_iter().filter(|key| section.given(key)) {
        checker.fault_in(section, key, "has no meaning for a body with model \"rigid\"".into());
    }
    let facts = BodyFacts::of(section)?;
    if facts.is_plane() {
        return plane(checker, root, section, orientation);
    }
    if section.given("normal") {
        checker.fault_in(section, "normal", "has a meaning for the shape \"plane\" only".into());
    }
    let motion = match section.text("motion")? {
        "planar" => RigidMotion::Planar,
        "axial" => RigidMotion::Axial,
        _ => RigidMotion::Spatial,
    };
    let mass = if section.item("geometry").is_some() {
        from_shape(checker, root, section, &facts, directory)?
    } else {
        given(checker, section, motion)?
    };
    Some(BodyKind::Rigid(Box::new(RigidBody { motion, mass })))
}

fn plane(
    checker: &mut Checker,
    root: &Section,
    section: &Section,
    orientation: Option<[f64; 4]>,
) -> Option<BodyKind> {
    for key in ["thickness", "motion", "markers"].into_iter().chain(MASS_KEYS) {
        if section.given(key) {
            checker.fault_in(
                section,
                key,
                "has no meaning for a plane, which is unbounded and at rest".into(),
            );
        }
    }
    let material = optional_material(checker, root, section)?;
    let turned = section.given("orientation");
    if section.item("normal").is_none() {
        let [w, i, j, k] = orientation?;
        let q = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        return Some(BodyKind::RigidPlane { normal: (q * Vector3::z()).into(), material });
    }
    let n = Vector3::from(section.vector::<3>("normal")?);
    if turned {
        let message = "either \"normal\" or \"orientation\" can be given, not both".into();
        checker.fault_in(section, "normal", message);
        return None;
    }
    // The square of anything shorter than this would underflow.
    if n.norm() < 1e-150 {
        checker.fault_in(section, "normal", "must not be the zero vector".into());
        return None;
    }
    Some(BodyKind::RigidPlane { normal: n.normalize().into(), material })
}

fn from_shape(
    checker: &mut Checker,
    root: &Section,
    section: &Section,
    facts: &BodyFacts<'_>,
    directory: &Path,
) -> Option<RigidMass> {
    for key in MASS_KEYS.into_iter().filter(|key| section.given(key)) {
        let message = "follows from \"geometry\" and \"material\", give either these or the mass".into();
        checker.fault_in(section, key, message);
    }
    let model = elastic_model(checker, section, facts.components);
    let geometry = geometry::geometry(checker, section, facts.components, directory);
    let material = material(checker, root, section);
    let (model, geometry, material): (ElasticModel, _, _) = (model?, geometry?, material?);
    Some(RigidMass::Shape { model, geometry, material })
}

fn given(checker: &mut Checker, section: &Section, motion: RigidMotion) -> Option<RigidMass> {
    for key in ["material", "thickness"] {
        if section.given(key) {
            checker.fault_in(section, key, "has no meaning for a rigid body without \"geometry\"".into());
        }
    }
    if section.item("mass").is_none() {
        let message =
            "required key is missing: \"geometry\" and \"material\", or \"mass\" and \"inertia\"".into();
        checker.fault(&section.origin, section.path_of("geometry"), None, message);
        return None;
    }
    let centre = match section.item("centre_of_mass") {
        Some(_) => section.vector("centre_of_mass")?,
        None => [0.0; 3],
    };
    let inertia = inertia(checker, section, motion);
    Some(RigidMass::Given { mass: section.number("mass")?, centre, inertia: inertia? })
}

fn inertia(checker: &mut Checker, section: &Section, motion: RigidMotion) -> Option<[[f64; 3]; 3]> {
    let rows: [[f64; 3]; 3] = match section.item("inertia").map(|i| &i.value) {
        None if motion == RigidMotion::Axial => return Some([[0.0; 3]; 3]),
        None => {
            let message = "required key is missing: 3 moments or 3 rows of 3 numbers".into();
            checker.fault(&section.origin, section.path_of("inertia"), None, message);
            return None;
        }
        Some(Checked::Numbers(d)) => {
            let d: [f64; 3] = d.as_slice().try_into().ok()?;
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { d[i] } else { 0.0 }))
        }
        Some(Checked::Lists(rows)) => {
            let rows: [Vec<f64>; 3] = rows.clone().try_into().ok()?;
            let [a, b, c] = rows.map(|row| row.try_into().ok());
            [a?, b?, c?]
        }
        Some(_) => return None,
    };
    let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
    let size = matrix.norm();
    if (matrix - matrix.transpose()).norm() > ROUND_OFF * size {
        checker.fault_in(section, "inertia", "must be symmetric".into());
        return None;
    }
    let symmetric = (matrix + matrix.transpose()) * 0.5;
    let second_moment = Matrix3::identity() * (0.5 * symmetric.trace()) - symmetric;
    let smallest = second_moment.symmetric_eigenvalues().min();
    if motion == RigidMotion::Spatial && smallest < -ROUND_OFF * size {
        let message = format!(
            "no distribution of mass has this inertia: a principal moment exceeds the sum of the others by {:.3e} kg m²",
            -2.0 * smallest
        );
        checker.fault_in(section, "inertia", message);
        return None;
    }
    if symmetric.diagonal().min() < 0.0 {
        checker.fault_in(section, "inertia", "moments of inertia must be >= 0".into());
        return None;
    }
    Some(std::array::from_fn(|i| std::array::from_fn(|j| symmetric[(i, j)])))
}
