//! Readers of mesh files. Counts that a file claims are not trusted: memory grows with what is
//! there.

mod text;
mod labels;
mod numbers;
mod skipped;
mod sets;
mod foreign;
mod gmsh;
mod inp;
mod nastran;

use crate::fault::{MeshError, Place, ReadFault};
use crate::mesh::Mesh;
use crate::mesh::raw::RawMesh;
use foreign::Format;

/// What is wanted of a file.
pub struct Wanted<'a> {
    /// The part that is the body: an instance or part of an input file, a group of elements, or
    /// "element 7", all that hangs together with element 7.
    pub part: Option<&'a str>,
    /// Reads a file that the file includes, by the name that it has there, or says why it cannot.
    pub include: &'a mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
}

/// Reads a mesh from the bytes of a file, whose format shows in its beginning; `unit`: length of
/// the file's unit \[m\].
///
/// Gmsh's MSH 4.1, 4.0 and 2.2, as text or binary; input files of Abaqus and CalculiX, flat or with
/// parts and instances; bulk data of Nastran.
///
/// # Errors
/// [`MeshError::Read`] with line or byte, [`MeshError::Mesh`] with the element.
pub fn read(bytes: &[u8], unit: f64) -> Result<Mesh, MeshError> {
    Mesh::new(raw(bytes)?, unit)
}

/// The same, one part of what is in the file, with the files that it includes.
///
/// # Errors
/// As [`read`]; [`crate::fault::ReadFault::Parts`], [`crate::fault::MeshFault::Parts`] and
/// [`crate::fault::MeshFault::UnknownGroup`] name the parts that there are.
pub fn read_part(bytes: &[u8], unit: f64, wanted: &mut Wanted<'_>) -> Result<Mesh, MeshError> {
    Mesh::new(raw_part(bytes, wanted)?, unit)
}

/// Names of the parts of a file that share no node, any of which [`Wanted::part`] may be: instances of an input file, groups
/// of elements, or "element N"; none of a mesh that is one piece.
///
/// # Errors
/// As [`raw_part`].
pub fn parts(
    bytes: &[u8],
    include: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
) -> Result<Vec<String>, MeshError> {
    match raw_part(bytes, &mut Wanted { part: None, include }) {
        Ok(mesh) => Ok(mesh.pieces()),
        Err(MeshError::Read { fault: ReadFault::Parts { names, .. }, .. }) => Ok(names),
        Err(error) => Err(error),
    }
}

/// The mesh as it stands in the file.
///
/// # Errors
/// [`MeshError::Read`].
pub fn raw(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut none = |_: &str| Err("put the mesh into one file".to_owned());
    raw_part(bytes, &mut Wanted { part: None, include: &mut none })
}

/// The same of one part, with the files that the file includes.
///
/// # Errors
/// [`MeshError::Read`], [`MeshError::Mesh`] for a part that is not there.
pub fn raw_part(bytes: &[u8], wanted: &mut Wanted<'_>) -> Result<RawMesh, MeshError> {
    let format = foreign::format(bytes).map_err(|fault| MeshError::Read { place: Place::Line(1), fault })?;
    let (mesh, part) = match format {
        Format::Input => inp::read(bytes, wanted)?,
        Format::Gmsh => (gmsh::read(bytes)?, wanted.part.map(str::to_owned)),
        Format::Nastran => (nastran::read(bytes, wanted)?, wanted.part.map(str::to_owned)),
    };
    Ok(match part {
        Some(part) => mesh.part(&part)?,
        None => mesh,
    })
}
