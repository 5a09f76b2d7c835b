//! Axes of joints, and whether they suit the models of the bodies.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::system::joints::JointKind;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::super::super::section::Section;
use super::super::places::{BodyFacts, motion_in_words};

/// Deviation of unit vectors that ten digits of a typed axis leave.
const ALIGNMENT: f64 = 1e-9;
/// The square of anything shorter than this would underflow.
const SHORTEST: f64 = 1e-150;

/// Rotation from the joint's axes to space.
pub fn axes(section: &Section, kind: JointKind) -> Option<UnitQuaternion<f64>> {
    match kind {
        JointKind::Fixed => Some(UnitQuaternion::identity()),
        JointKind::Universal => universal(section),
        JointKind::Spherical | JointKind::Free | JointKind::Axial | JointKind::Generic(_)
            if section.item("axis").is_none() =>
        {
            if section.item("reference").is_some() {
                return section.refuse("reference", "needs \"axis\" beside it");
            }
            Some(UnitQuaternion::identity())
        }
        JointKind::Revolute
        | JointKind::Prismatic
        | JointKind::Cylindrical
        | JointKind::Spherical
        | JointKind::Planar
        | JointKind::Free
        | JointKind::Axial
        | JointKind::Generic(_) => about_axis(section),
    }
}

/// The unit vector of key `key`, which must be given.
fn direction(section: &Section, key: &str) -> Option<Vector3<f64>> {
    section.require(key, "3 components of a vector")?;
    let vector = Vector3::from(section.vector::<3>(key)?);
    if vector.norm() < SHORTEST {
        return section.refuse(key, "must not be the zero vector");
    }
    Some(vector.normalize())
}

/// Rotation with the columns `x`, `y` and `x × y`.
fn rotation(x: Vector3<f64>, y: Vector3<f64>) -> UnitQuaternion<f64> {
    let columns = Matrix3::from_columns(&[x, y, x.cross(&y)]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns))
}

fn universal(section: &Section) -> Option<UnitQuaternion<f64>> {
    let (first, second) = (direction(section, "axis"), direction(section, "second_axis"));
    let (first, second) = (first?, second?);
    let cosine = first.dot(&second);
    if cosine.abs() > ALIGNMENT {
        let degrees = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        let message = format!("must be perpendicular to \"axis\", the angle between them is {degrees:.6}°");
        return section.refuse("second_axis", message);
    }
    let second = (second - first * cosine).normalize();
    Some(rotation(first, second))
}

/// `z` along the axis, `x` along the part of `reference` across it.
fn about_axis(section: &Section) -> Option<UnitQuaternion<f64>> {
    let z = direction(section, "axis")?;
    let reference = match section.item("reference") {
        Some(_) => direction(section, "reference")?,
        None => {
            let farthest = (0..3).min_by(|&i, &j| z[i].abs().total_cmp(&z[j].abs())).unwrap_or(0);
            Vector3::ith(farthest, 1.0)
        }
    };
    let across = reference - z * z.dot(&reference);
    if across.norm() < ALIGNMENT {
        return section.refuse("reference", "must not be parallel to \"axis\"");
    }
    let x = across.normalize();
    Some(rotation(x, z.cross(&x)))
}

/// Reports joints that lead out of the plane of a plane model or off the axis of an axisymmetric
/// one, and joints between different models.
pub fn check_models(
    root: &Section,
    section: &Section,
    kind: JointKind,
    axes: &UnitQuaternion<f64>,
) -> Option<()> {
    let name = |side: &str| section.table(side).and_then(|s| s.text("body"));
    let child = BodyFacts::find(root, name("child")?)?.motion();
    let parent = BodyFacts::find(root, name("parent")?).map(|p| p.motion());
    if let Some(parent) = parent.filter(|p| *p != child) {
        let side = section.table("parent")?;
        let message = format!(
            "is {}, the child is {}: only bodies of one kind, or a body and ground, are joined",
            motion_in_words(parent),
            motion_in_words(child)
        );
        return side.refuse("body", message);
    }
    let kinds: &[JointKind] = match child {
        RigidMotion::Axial => &[JointKind::Fixed, JointKind::Axial],
        RigidMotion::Planar => {
            &[JointKind::Fixed, JointKind::Revolute, JointKind::Prismatic, JointKind::Planar]
        }
        RigidMotion::Spatial => return Some(()),
    };
    let child = motion_in_words(child);
    // A generic joint frees the directions of the model alone.
    if !kinds.contains(&kind) && !matches!(kind, JointKind::Generic(_)) {
        let known: Vec<String> = kinds.iter().map(|k| format!("\"{}\"", k.name())).collect();
        let message = format!("does not go with bodies that are {child}, choose {}", known.join(" or "));
        return section.refuse("type", message);
    }
    let cosine = (axes * Vector3::z()).z;
    let (fits, words) = match kind {
        JointKind::Fixed => (true, ""),
        JointKind::Prismatic => (cosine.abs() < ALIGNMENT, "in the plane (x, y)"),
        _ => (cosine.abs() > 1.0 - ALIGNMENT, "along z"),
    };
    if !fits {
        return section.refuse("axis", format!("must be {words} for bodies that are {child}"));
    }
    Some(())
}
