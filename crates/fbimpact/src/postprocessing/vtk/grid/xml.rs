//! Writes grids as `.vtu`, series of them as `.pvd` and groups of them as `.vtm`.
//!
//! Arrays follow the text as raw bytes (`AppendedData`), little-endian, each after its length:
//! exact and compact. Weights and degrees of rational cells are named in attributes of their
//! sections; by the array names alone VTK ignores them.

use std::fmt::Write as _;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::Grid;

/// Stands in all files that are written here.
pub const MARK: &str = "<!-- written by fbimpact -->";

/// Arrays of a file: their description in the text, and their bytes.
#[derive(Default)]
struct Appended {
    bytes: Vec<u8>,
}

impl Appended {
    /// Takes an array and returns its tag.
    fn array<const N: usize>(
        &mut self,
        name: &str,
        kind: &str,
        components: usize,
        values: impl Iterator<Item = [u8; N]>,
    ) -> String {
        let offset = self.bytes.len();
        self.bytes.extend([0; 8]);
        values.for_each(|value| self.bytes.extend(value));
        let length = (self.bytes.len() - offset - 8) as u64;
        self.bytes[offset..offset + 8].copy_from_slice(&length.to_le_bytes());
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }

    fn floats<const N: usize>(&mut self, name: &str, rows: &[[f64; N]]) -> String {
        self.array(name, "Float64", N, rows.iter().flatten().map(|v| v.to_le_bytes()))
    }

    /// Fields: single precision halves the files and shows in no picture.
    fn singles<const N: usize>(&mut self, name: &str, rows: &[[f64; N]]) -> String {
        self.array(name, "Float32", N, rows.iter().flatten().map(|v| (*v as f32).to_le_bytes()))
    }

    fn scalars(&mut self, name: &str, values: &[f64]) -> String {
        self.array(name, "Float64", 1, values.iter().map(|v| v.to_le_bytes()))
    }
}

/// The file of a grid at time `time` \[s\].
fn vtu(grid: &Grid, time: f64) -> (String, Vec<u8>) {
    let mut data = Appended::default();
    let is_rational = !grid.weights.is_empty();
    // Version 2.2 has the present order of nodes in higher-order cells; for linear ones every
    // reader knows version 1.0.
    let version = if is_rational { "2.2" } else { "1.0" };
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<!-- written by fbimpact -->\n<VTKFile type=\"UnstructuredGrid\" version=\"{version}\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n",
    );
    let _ = write!(
        text,
        "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time:e}</DataArray>\n</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        grid.points.len(),
        grid.types.len()
    );
    text += "<Points>\n";
    text += &data.floats("Points", &grid.points);
    text += "</Points>\n<Cells>\n";
    text += &data.array("connectivity", "Int64", 1, grid.connectivity.iter().map(|v| v.to_le_bytes()));
    text += &data.array("offsets", "Int64", 1, grid.offsets.iter().map(|v| v.to_le_bytes()));
    text += &data.array("types", "UInt8", 1, grid.types.iter().map(|v| v.to_le_bytes()));
    text += "</Cells>\n";
    let attributes = if is_rational { " RationalWeights=\"RationalWeights\"" } else { "" };
    let _ = writeln!(text, "<PointData{attributes}>");
    if is_rational {
        text += &data.scalars("RationalWeights", &grid.weights);
    }
    let n = grid.points.len();
    if grid.displacement.len() == n {
        text += &data.singles("displacement [m]", &grid.displacement);
    }
    if grid.velocity.len() == n {
        text += &data.singles("velocity [m/s]", &grid.velocity);
    }
    for (name, values) in &grid.scalars {
        text += &data.floats(name, values);
    }
    for (name, values) in &grid.vectors {
        text += &data.floats(name, values);
    }
    if !grid.labels.is_empty() {
        text += &strings("name", &grid.labels);
    }
    if !grid.stress.is_empty() {
        text += &data.singles("von Mises stress [Pa]", &grid.von_mises);
        text += &data.singles("stress [Pa]", &grid.stress);
    }
    if let Some(contact) = &grid.contact {
        text += &data.floats("contact pressure [Pa]", &contact.pressure);
        text += &data.floats("area [m2]", &contact.area);
    }
    text += "</PointData>\n";
    if !grid.degrees.is_empty() {
        text += "<CellData HigherOrderDegrees=\"HigherOrderDegrees\">\n";
        text += &data.floats("HigherOrderDegrees", &grid.degrees);
        text += "</CellData>\n";
    }
    text += "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
    (text, data.bytes)
}

/// An array of texts, which VTK has as the codes of their bytes with a zero after each.
fn strings(name: &str, values: &[String]) -> String {
    let mut codes = String::new();
    for byte in values.iter().flat_map(|text| text.bytes().chain([0])) {
        let _ = write!(codes, "{byte} ");
    }
    format!(
        "<DataArray type=\"String\" Name=\"{name}\" NumberOfComponents=\"1\" format=\"ascii\">{codes}</DataArray>\n"
    )
}

/// Writes `grid` to `path`.
///
/// # Errors
/// Those of the file system.
pub fn write_vtu(path: &Path, grid: &Grid, time: f64) -> io::Result<()> {
    let (text, bytes) = vtu(grid, time);
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    file.write_all(text.as_bytes())?;
    file.write_all(&bytes)?;
    file.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
    file.flush()
}

/// A file of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesEntry {
    /// Time \[s\].
    pub time: f64,
    /// Number of the body.
    pub part: usize,
    /// Its name.
    pub name: String,
    /// The file, relative to the series.
    pub file: String,
}

/// The text of a `.pvd` file.
pub fn pvd(entries: &[SeriesEntry]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<!-- written by fbimpact -->\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for e in entries {
        let _ = writeln!(
            text,
            "<DataSet timestep=\"{:e}\" part=\"{}\" name=\"{}\" file=\"{}\"/>",
            e.time,
            e.part,
            escaped(&e.name),
            escaped(&e.file)
        );
    }
    text + "</Collection>\n</VTKFile>\n"
}

/// Files under a common name.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockEntry {
    /// The name.
    pub name: String,
    /// Name and file of each part, relative to the file that lists the blocks.
    pub parts: Vec<(String, String)>,
}

/// The text of a `.vtm` file.
pub fn vtm(blocks: &[BlockEntry]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<!-- written by fbimpact -->\n<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" byte_order=\"LittleEndian\">\n<vtkMultiBlockDataSet>\n",
    );
    for (i, block) in blocks.iter().enumerate() {
        let _ = writeln!(text, "<Block index=\"{i}\" name=\"{}\">", escaped(&block.name));
        for (k, (name, file)) in block.parts.iter().enumerate() {
            let (name, file) = (escaped(name), escaped(file));
            let _ = writeln!(text, "<DataSet index=\"{k}\" name=\"{name}\" file=\"{file}\"/>");
        }
        text += "</Block>\n";
    }
    text + "</vtkMultiBlockDataSet>\n</VTKFile>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
