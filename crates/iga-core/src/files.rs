//! Splines in files of other programs: G+Smo's XML and MFEM's NURBS meshes, read and written.
//!
//! Nothing is guessed, and counts that a file claims are not trusted: memory grows with what is
//! there. Lengths are in the file's unit, which neither format says.

mod fault;
mod words;
mod gismo;
mod mfem_topology;
mod mfem;

pub use fault::{ReadError, ReadFault};
pub use gismo::write as write_gismo;
pub use mfem::write as write_mfem;

use crate::nurbs::{FaceId, Patch};
use crate::splines::knots::KnotVector;

/// Patches as they stand in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SplineFile {
    /// In the order of the file \[m\]; parameters over any range, any orientation.
    pub patches: Vec<Patch>,
    /// Pairs of faces that the file says are joined.
    pub joined: Vec<[FaceId; 2]>,
    /// Faces that the file gives a name, the attributes of MFEM's boundary.
    pub faces: Vec<(String, Vec<FaceId>)>,
    /// What was left out.
    pub notes: Vec<String>,
}

/// Reads patches from the bytes of a file, whose format shows in its beginning; `unit`: length of
/// the file's unit \[m\].
///
/// G+Smo: `Geometry` of type `TensorBSpline2`, `3` and `TensorNurbs2`, `3`, and a `MultiPatch` of
/// them. MFEM: `NURBS mesh v1.0` and `v1.1` with patches or with weights and nodes. Patches are
/// solids in space or surfaces in the plane.
///
/// # Errors
/// [`ReadError`] with the line.
pub fn read(bytes: &[u8], unit: f64) -> Result<SplineFile, ReadError> {
    let at_first = |fault| ReadError { line: 1, fault };
    let text = std::str::from_utf8(bytes).map_err(|e| ReadError {
        line: 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count(),
        fault: ReadFault::NoText,
    })?;
    let start = text.trim_start_matches('\u{feff}').trim_start();
    let mut file = if start.starts_with("MFEM") {
        mfem::read(text)?
    } else if start.starts_with('<') {
        gismo::read(text)?
    } else {
        return Err(at_first(ReadFault::Format));
    };
    file.patches = file
        .patches
        .into_iter()
        .map(|patch| patch.scaled(unit))
        .collect::<Result<_, _>>()
        .map_err(|e| at_first(e.into()))?;
    Ok(file)
}

/// Number of control points that knot vectors ask for; more than there can be if that is beyond all
/// numbers.
fn net_size(knots: &[KnotVector]) -> usize {
    knots.iter().map(KnotVector::n_functions).fold(1, usize::saturating_mul)
}

/// Patches in which a length of the file's unit is `unit` metres.
fn in_unit(patches: &[Patch], unit: f64) -> impl Iterator<Item = (&Patch, Vec<[f64; 3]>)> {
    patches.iter().map(move |p| (p, p.control_points().iter().map(|x| x.map(|c| c / unit)).collect()))
}
