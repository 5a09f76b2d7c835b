//! `fbimpact import-body`: a body file from matrices of another program.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use result_files::file::fault::{Access, FileFault};
use result_files::file::output::Gate;
use result_files::file::plain_file;

use crate::cli::{ImportArguments, ImportUnit};
use crate::commands::{print, threads};
use crate::error::{AppError, CommandFault};
use crate::interchange::body_file;
use crate::interchange::matrix_files::{Matrix, Parts, assemble, read_map, read_matrix, read_nodes};

/// Most nodes of a marker: a range of more is a slip.
const MOST_NODES: u64 = 1_000_000;
/// Longest name of a marker, which becomes a path in the body file.
const MAX_NAME: usize = 64;

/// Writes the unreduced body, and prints what was found.
///
/// # Errors
/// [`AppError::Command`] for a marker, [`AppError::Io`] for a file with the line, and for matrices that make no body.
pub fn import_body(arguments: &ImportArguments) -> Result<(), AppError> {
    threads(0)?;
    let markers = arguments.marker.iter().map(|m| marker(m)).collect::<Result<Vec<_>, _>>()?;
    Gate::of_files(&inputs(arguments), arguments.force).check(&arguments.output, body_file::KIND)?;
    let stiffness = matrix(&arguments.stiffness)?;
    let mass = matrix(&arguments.mass)?;
    let nodes = parsed(&arguments.nodes, read_nodes)?;
    let map = arguments.dof_map.as_deref().map(|path| parsed(path, read_map)).transpose()?;
    let unit = if arguments.units == ImportUnit::Mm { 1e-3 } else { 1.0 };
    let parts = Parts {
        name: &arguments.name,
        stiffness: &stiffness,
        mass: &mass,
        nodes: &nodes,
        map: map.as_deref(),
        unit,
        markers: &markers,
    };
    let (body, report) =
        assemble(&parts).map_err(|e| AppError::io(&arguments.output, FileFault::Unmade(e.into())))?;
    body_file::write_full(&arguments.output, &body)?;
    let [x, y, z] = report.mass.centre;
    let mut text = format!(
        "{}: {} nodes, {} unknowns, {} markers\n",
        arguments.output.display(),
        report.n_nodes,
        report.n_unknowns,
        markers.len()
    );
    let _ = writeln!(text, "stiffness        {}, {} entries", stiffness.format, stiffness.entries.len());
    let _ = writeln!(text, "mass matrix      {}, {} entries", mass.format, mass.entries.len());
    let _ =
        writeln!(text, "mass             {:.6e} kg, centre ({x:.6e}, {y:.6e}, {z:.6e}) m", report.mass.mass);
    let _ = writeln!(text, "rigid motions    resisted by {:.1e} of the stiffest entry", report.resistance);
    for (name, marker) in body.markers() {
        let x = marker.position();
        let _ = writeln!(text, "marker {name:<9} at ({:.6e}, {:.6e}, {:.6e}) m", x[0], x[1], x[2]);
    }
    print(&text)
}

/// Files that are read.
fn inputs(arguments: &ImportArguments) -> Vec<PathBuf> {
    let matrices = [&arguments.stiffness, &arguments.mass].map(|given| split(given).0);
    matrices.into_iter().chain([arguments.nodes.clone()]).chain(arguments.dof_map.clone()).collect()
}

/// A path and the name of a matrix behind its last colon; a path that exists as it stands has none.
fn split(given: &str) -> (PathBuf, Option<&str>) {
    match given.rsplit_once(':') {
        Some((path, name)) if !Path::new(given).exists() && !name.contains(['/', '\\']) => {
            (path.into(), Some(name))
        }
        _ => (given.into(), None),
    }
}

fn matrix(given: &str) -> Result<Matrix, AppError> {
    let (path, name) = split(given);
    parsed(&path, |text| read_matrix(text, name))
}

fn parsed<T, E: std::error::Error + Send + Sync + 'static>(
    path: &Path,
    read: impl FnOnce(&str) -> Result<T, E>,
) -> Result<T, AppError> {
    let bytes = plain_file::read(path).map_err(|e| AppError::system(path, Access::Read, e))?;
    let text =
        String::from_utf8(bytes).map_err(|_| AppError::io(path, "is no text; write it in its text form"))?;
    read(&text).map_err(|e| AppError::io(path, FileFault::contents(e)))
}

/// A marker: its name and nodes.
fn marker(given: &str) -> Result<(String, Vec<u64>), AppError> {
    let fail = |reason| {
        let reason = format!("{reason}; write NAME=NODES, as in hinge=1,2,5-9");
        Err(CommandFault::argument("--marker", given, reason).into())
    };
    let Some((name, list)) = given.split_once('=') else { return fail("there is no =") };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || name.len() > MAX_NAME || !name.chars().all(is_plain) {
        return fail("a name has 1 to 64 letters, digits, _ and -");
    }
    let mut nodes = Vec::new();
    for part in list.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (Ok(first), Ok(last)) = (first.trim().parse::<u64>(), last.trim().parse::<u64>()) else {
            return fail("nodes are numbers and ranges of them");
        };
        if last < first || last - first >= MOST_NODES {
            return fail("a range goes from a smaller to a larger number, a million nodes at most");
        }
        nodes.extend(first..=last);
    }
    nodes.sort_unstable();
    nodes.dedup();
    Ok((name.to_owned(), nodes))
}
