//! Readers of mesh files. Counts that a file claims are not trusted: memory grows with what is
//! there.

mod labels;
mod numbers;
mod skipped;
mod gmsh;
mod inp;

use crate::fault::{MeshError, Place, ReadFault};
use crate::mesh::Mesh;
use crate::mesh::raw::RawMesh;

/// Reads a mesh from the bytes of a file, whose format shows in its beginning; `unit`: length of
/// the file's unit \[m\].
///
/// Gmsh's MSH 4.1 and 2.2, as text or binary; input files of Abaqus and CalculiX, flat or with one
/// part and one instance.
///
/// # Errors
/// [`MeshError::Read`] with line or byte, [`MeshError::Mesh`] with the element.
pub fn read(bytes: &[u8], unit: f64) -> Result<Mesh, MeshError> {
    Mesh::new(raw(bytes)?, unit)
}

/// The mesh as it stands in the file.
///
/// # Errors
/// [`MeshError::Read`].
pub fn raw(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let start = bytes.trim_ascii_start();
    if start.starts_with(b"$") {
        return gmsh::read(bytes);
    }
    if start.starts_with(b"*") {
        return inp::read(bytes);
    }
    Err(MeshError::Read { place: Place::Line(1), fault: ReadFault::Format })
}
