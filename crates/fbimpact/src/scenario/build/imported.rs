//! Bodies from files: keys that a full body takes, and those that have no meaning.

use std::sync::Arc;

use ffr_dynamics::body::{AssembledBody, RigidMotion};

use super::super::body_source::BodySource;
use super::super::check::Checker;
use super::super::model::{BodyKind, Frame, FromFile, ImportedBody, Place, Reduction};
use super::super::section::Section;
use super::body_parts::{Context, damping, frame};
use super::discretisation::reduction;
use crate::body_file::BodyFile;

/// Keys that follow from the file, or need a shape.
const SHAPE_KEYS: [&str; 10] = [
    "material",
    "motion",
    "mass",
    "centre_of_mass",
    "inertia",
    "thickness",
    "geometry",
    "discretisation",
    "geometric_stiffening",
    "normal",
];
/// Keys that say how matrices are reduced.
const REDUCTION_KEYS: [&str; 5] = ["reduction", "damping", "frame", "frame_marker", "frame_point"];

/// A body from a file, called `name`.
pub fn imported(
    checker: &mut Checker,
    context: Context<'_>,
    section: &Section,
    name: &str,
) -> Option<BodyKind> {
    for key in SHAPE_KEYS.into_iter().filter(|key| section.given(key)) {
        checker.fault_in(section, key, "has no meaning for a body with model \"imported\"".into());
    }
    if section.given("markers") {
        let message = "the markers of a body with model \"imported\" are those of its file".into();
        checker.fault_in(section, "markers", message);
    }
    let source = section.body_file()?;
    let imported = match &source.body {
        BodyFile::Reduced(model) => {
            for key in REDUCTION_KEYS.into_iter().filter(|key| section.given(key)) {
                let path = source.path.display();
                let message = format!("has no meaning for a body that is reduced already, as in {path}");
                checker.fault_in(section, key, message);
            }
            ImportedBody::Reduced(from_file(source, model))
        }
        BodyFile::Full(body) => {
            let table = section.table("reduction");
            if let Some(table) = table.filter(|table| table.given("fixed_interface_modes")) {
                let message = "has no meaning for a body from a file, which has no contact zone".into();
                checker.fault_in(table, "fixed_interface_modes", message);
            }
            let reduction = table.and_then(|table| reduction(checker, table));
            if let (
                Some(
                    Reduction::Modal { modes: Some(modes), .. }
                    | Reduction::CraigBampton { modes: Some(modes), .. },
                ),
                Some(table),
            ) = (reduction, table)
            {
                check_modes(checker, table, modes, body.body());
            }
            let damping = damping(checker, section);
            let frame = match frame(checker, context, section, name)? {
                Frame::Buckens => None,
                Frame::Tangent(Place::Marker(marker)) => Some(marker),
                Frame::Tangent(_) => return None, // other places on this body are faults
            };
            let body = from_file(source, body);
            ImportedBody::Full { body, reduction: reduction?, damping: damping?, frame }
        }
    };
    Some(BodyKind::Imported(Box::new(imported)))
}

/// Reports more modes than the matrices have unknowns beside rigid motions.
fn check_modes(checker: &mut Checker, section: &Section, modes: usize, body: &AssembledBody) {
    let n_rigid = match body.motion {
        RigidMotion::Spatial => 6,
        RigidMotion::Planar => 3,
        RigidMotion::Axial => 1,
    };
    let most = body.dofs.len().saturating_sub(n_rigid);
    if modes > most {
        let message = format!("must be at most {most}, the elastic modes of body \"{}\"", body.name);
        checker.fault_in(section, "modes", message);
    }
}

fn from_file<T>(source: &BodySource, value: &Arc<T>) -> FromFile<T> {
    FromFile { path: source.path.clone(), sha256: source.sha256.clone(), value: Arc::clone(value) }
}
