//! Reading a body file.

use std::path::Path;
use std::sync::Arc;

use ffr_dynamics::body::RigidMotion;
use result_files::file::hdf5_integrity;

use super::dataset::Node;
use super::fault::{BodyFault, BodyFileError};
use super::{BodyFile, FORMAT, FORMAT_VERSION, full, reduced};

/// Models by the attribute `model`.
pub const MODELS: [(&str, RigidMotion); 3] =
    [("axisymmetric", RigidMotion::Axial), ("plane", RigidMotion::Planar), ("solid", RigidMotion::Spatial)];

/// Reads and checks a body file.
///
/// # Errors
/// [`BodyFileError`] with the file and the dataset at fault.
pub fn read(path: &Path) -> Result<BodyFile, BodyFileError> {
    let result = open(path).and_then(|root| contents(&root, path));
    result.map_err(|fault| BodyFileError { path: path.to_owned(), fault: Box::new(fault) })
}

fn open(path: &Path) -> Result<Node, BodyFault> {
    let file = hdf5_integrity::open(path)?;
    Ok(Node { group: file.group("/")?, path: "/".into() })
}

fn contents(root: &Node, path: &Path) -> Result<BodyFile, BodyFault> {
    root.choice("format", &[FORMAT])?;
    let version = root.group.attr("format_version").and_then(|a| a.read_scalar::<u32>());
    if !version.as_ref().is_ok_and(|v| (1..=FORMAT_VERSION).contains(v)) {
        return Err(BodyFault::Attribute {
            at: "/".into(),
            name: "format_version".into(),
            expected: format!("1 to {FORMAT_VERSION}, use a newer version of this program"),
            found: version.map_or("missing or no integer".into(), |v| v.to_string()),
        });
    }
    let motion = MODELS[root.choice("model", &MODELS.map(|m| m.0))?].1;
    let name = match root.find_text("name")? {
        Some(name) => name,
        None => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
    };
    match root.choice("kind", &["full", "reduced"])? {
        0 => full::read(root, name, motion).map(|b| BodyFile::Full(Arc::new(b))),
        _ => reduced::read(root, name, motion).map(|b| BodyFile::Reduced(Arc::new(b))),
    }
}
