//! Rigid bodies: planes at rest, bodies with given mass, bodies whose mass follows from their
//! shape.

use std::sync::Arc;

use adaptive::spec::{BodyKind, RigidSpec};
use ffr_dynamics::body::RigidMotion;
use iga_core::elasticity::Model;
use iga_core::nurbs::Shape;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::geometry;
use super::known_shapes::KnownShapes;
use super::parts::{elastic_model, material, optional_material};
use crate::scenario::body_places::{BodyPlaces, GivenPlace};
use crate::scenario::build::places::BodyFacts;
use crate::scenario::section::{Checked, Section};

/// Asymmetry and negative moments that numbers written with many digits leave.
const ROUND_OFF: f64 = 1e-9;

/// Degree of the net of a ball where none is named: every net is exact, this one has the mildest
/// weights and no poles.
const DEGREE: usize = 4;

/// What a rigid body is.
pub enum Rigid {
    /// A body of the run, with its places.
    Moving(Box<(BodyKind, BodyPlaces)>),
    /// A plane at rest with its unit normal.
    Plane(Vector3<f64>),
}

/// A rigid body with the markers that the user has added.
pub fn rigid(
    root: &Section,
    known: &mut KnownShapes,
    section: &Section,
    orientation: Option<[f64; 4]>,
    markers: Option<&[(String, GivenPlace)]>,
) -> Option<Rigid> {
    let facts = BodyFacts::of(section)?;
    if facts.is_plane() {
        return plane(root, section, orientation);
    }
    let motion = section.choice("motion")?;
    let (spec, shape) = if section.item("geometry").is_some() {
        let (spec, shape) = from_shape(root, known, section, &facts, motion)?;
        (spec, Some(shape))
    } else {
        (given(section, motion)?, None)
    };
    let places = BodyPlaces::rigid(shape, markers?);
    let places = places.map_err(|e| section.fault("markers", e.to_string())).ok()?;
    let spec = RigidSpec { shape: places.shape().cloned(), ..spec };
    Some(Rigid::Moving(Box::new((BodyKind::Rigid(spec), places))))
}

fn plane(root: &Section, section: &Section, orientation: Option<[f64; 4]>) -> Option<Rigid> {
    optional_material(root, section).ok()?;
    if section.item("normal").is_none() {
        let [w, i, j, k] = orientation?;
        let q = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        return Some(Rigid::Plane(q * Vector3::z()));
    }
    let n = Vector3::from(section.vector::<3>("normal")?);
    // The square of anything shorter than this would underflow.
    if n.norm() < 1e-150 {
        return section.refuse("normal", "must not be the zero vector");
    }
    Some(Rigid::Plane(n.normalize()))
}

fn from_shape(
    root: &Section,
    known: &mut KnownShapes,
    section: &Section,
    facts: &BodyFacts<'_>,
    motion: RigidMotion,
) -> Option<(RigidSpec, (Arc<Shape>, Model))> {
    let model = elastic_model(section, facts.components);
    let shape = geometry::shape(section, facts.components, DEGREE);
    let material = material(root, section);
    let (model, shape, material) = (model?, shape?, material?);
    if !section.faults.is_empty() {
        return None; // integrals take a while, and nothing can be run
    }
    let found = known.measured(shape, &model);
    let (shape, properties) = found.map_err(|e| section.fault("geometry", e.to_string())).ok()?;
    let spec = RigidSpec {
        motion,
        mass: material.density() * properties.volume,
        centre_of_mass: Vector3::from(properties.centre()),
        inertia: matrix(&properties.central_inertia(), material.density()),
        density: Some(material.density()),
        shape: None,
    };
    Some((spec, (shape, model)))
}

fn matrix(rows: &[[f64; 3]; 3], factor: f64) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| factor * rows[i][j])
}

fn given(section: &Section, motion: RigidMotion) -> Option<RigidSpec> {
    if section.item("mass").is_none() {
        let message = "required key is missing: \"geometry\" and \"material\", or \"mass\" and \"inertia\"";
        return section.refuse("geometry", message);
    }
    let centre = section.optional("centre_of_mass", Section::vector).ok()?.unwrap_or([0.0; 3]);
    let inertia = inertia(section, motion);
    Some(RigidSpec {
        motion,
        mass: section.number("mass")?,
        centre_of_mass: Vector3::from(centre),
        inertia: inertia?,
        density: None,
        shape: None,
    })
}

fn inertia(section: &Section, motion: RigidMotion) -> Option<Matrix3<f64>> {
    let rows: [[f64; 3]; 3] = match section.item("inertia").map(|i| &i.value) {
        None if motion == RigidMotion::Axial => return Some(Matrix3::zeros()),
        None => {
            let message = "required key is missing: 3 moments or 3 rows of 3 numbers";
            return section.refuse("inertia", message);
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
        return section.refuse("inertia", "must be symmetric");
    }
    let symmetric = (matrix + matrix.transpose()) * 0.5;
    let second_moment = Matrix3::identity() * (0.5 * symmetric.trace()) - symmetric;
    let smallest = second_moment.symmetric_eigenvalues().min();
    if motion == RigidMotion::Spatial && smallest < -ROUND_OFF * size {
        let message = format!(
            "no distribution of mass has this inertia: a principal moment exceeds the sum of the others by {:.3e} kg m²",
            -2.0 * smallest
        );
        return section.refuse("inertia", message);
    }
    if symmetric.diagonal().min() < 0.0 {
        return section.refuse("inertia", "moments of inertia must be >= 0");
    }
    Some(symmetric)
}
