//! What formats a file may have, and which command makes one that is read of those that are not.

use crate::fault::ReadFault;

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Gmsh,
    Input,
    Nastran,
}

/// Gmsh reads it with its groups.
const BY_GMSH: &str =
    "gmsh PART -save -format msh41 -o PART.msh writes one with its groups (pip install gmsh)";
/// Gmsh meshes it.
const MESHED: &str = "gmsh PART -3 -order 2 -format msh41 -o PART.msh meshes it (pip install gmsh)";
/// Meshio reads it; integers of its cells become sets.
const BY_MESHIO: &str = "python3 -c \"import meshio; m = meshio.read('PART'); [m.cell_data_to_sets(k) for k, d in list(m.cell_data.items()) \
     if d[0].dtype.kind in 'iu']; m.write('PART.inp')\" writes one with integers of its cells as sets (pip install meshio)";
const UNKNOWN: &str = "export it as one of them";

/// How files of other formats begin, what they are, and what to do.
const OTHERS: &[(&[u8], &str, &str)] = &[
    (b"# vtk DataFile", "a legacy VTK file", BY_MESHIO),
    (b"<VTKFile", "a VTK file in XML", BY_MESHIO),
    (b"<?xml", "a file in XML, as VTU", BY_MESHIO),
    (b"\x89HDF", "an HDF5 file, as MED", BY_GMSH),
    (b"-1\n", "a universal file (UNV)", BY_GMSH),
    (b"-1\r\n", "a universal file (UNV)", BY_GMSH),
    (b"MeshVersionFormatted", "a Medit file", BY_GMSH),
    (b"CDF", "an Exodus file", BY_MESHIO),
    (b"ISO-10303-21", "a STEP file, a shape without a mesh", MESHED),
    (b"DBRep_DrawableShape", "a BREP file, a shape without a mesh", MESHED),
    (
        b"solid",
        "an STL file, a surface without a mesh",
        "mesh the volume in Gmsh (Merge, Create Topology, Volume)",
    ),
];

/// The format of a file.
///
/// # Errors
/// [`ReadFault::Format`].
pub fn format(bytes: &[u8]) -> Result<Format, ReadFault> {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if start.starts_with(b"$MeshFormat") || start.starts_with(b"$Comments") {
        return Ok(Format::Gmsh);
    }
    if start.starts_with(b"*") {
        return Ok(Format::Input);
    }
    if let Some((_, found, remedy)) = OTHERS.iter().find(|(begin, ..)| start.starts_with(begin)) {
        return Err(ReadFault::Format { found, remedy });
    }
    let begins = |line: &[u8], word: &[u8]| {
        line.get(..word.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(word))
            && line.get(word.len()).is_none_or(|c| !c.is_ascii_alphanumeric())
    };
    // Remarks may stand before the first card.
    for line in start.split(|b| *b == b'\n') {
        if line.strip_prefix(b"*").is_some_and(|card| begins(card.trim_ascii_start(), b"NODE")) {
            return Ok(Format::Input);
        }
        if begins(line, b"GRID") || begins(line, b"BEGIN BULK") {
            return Ok(Format::Nastran);
        }
    }
    Err(ReadFault::Format { found: "not a mesh that is known", remedy: UNKNOWN })
}
