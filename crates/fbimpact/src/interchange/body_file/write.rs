//! Writing a body file: under another name first, so that a file is complete or not there.

use std::path::Path;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::interchange::{FullBody, ReducedModel};
use result_files::file::whole_file;

use super::dataset::Node;
use super::fault::{BodyFault, BodyFileError};
use super::read::MODELS;
use super::{FORMAT, FORMAT_VERSION, full, reduced};
use crate::process::provenance;

/// Writes an unreduced body; an existing file is replaced.
///
/// # Errors
/// [`BodyFileError`] if the file cannot be written or a name cannot be stored.
pub fn write_full(path: &Path, body: &FullBody) -> Result<(), BodyFileError> {
    let (name, motion) = (&body.body().name, body.body().motion);
    write(path, "full", name, motion, |root| full::write(root, body))
}

/// Writes a reduced body; an existing file is replaced.
///
/// # Errors
/// [`BodyFileError`] if the file cannot be written or a name cannot be stored.
pub fn write_reduced(path: &Path, body: &ReducedModel) -> Result<(), BodyFileError> {
    write(path, "reduced", body.name(), body.data().motion, |root| reduced::write(root, body))
}

fn write(
    path: &Path,
    kind: &str,
    name: &str,
    motion: RigidMotion,
    contents: impl Fn(&Node) -> Result<(), BodyFault>,
) -> Result<(), BodyFileError> {
    let stored = whole_file::replace(path, |part| -> Result<(), BodyFault> {
        let file = hdf5::File::with_options().with_fapl(|p| p.file_locking(false)).create(part)?;
        let root = Node { group: file.group("/")?, path: "/".into() };
        root.text("format", FORMAT)?;
        root.group.new_attr::<u32>().create("format_version")?.write_scalar(&FORMAT_VERSION)?;
        root.text("kind", kind)?;
        root.text("name", name)?;
        root.text("program_version", provenance::VERSION)?;
        if let Some((model, _)) = MODELS.iter().find(|m| m.1 == motion) {
            root.text("model", model)?;
        }
        contents(&root)?;
        drop(root);
        Ok(whole_file::close(file)?)
    });
    stored.map_err(|fault| BodyFileError { path: path.to_owned(), fault: Box::new(fault) })
}
