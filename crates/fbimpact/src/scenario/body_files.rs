//! Body files and meshes that a scenario names: read once each, so that their markers, groups and models can be checked like keys.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::body_source::{BodySource, MeshSource};
use super::check::Checker;
use super::hex;
use super::section::{Checked, Item, Section};
use crate::body_file;

/// Bytes read at a time.
const BLOCK: usize = 1 << 16;

/// Files read so far; bodies that name the same one share it.
#[derive(Default)]
struct Known {
    bodies: Vec<Arc<BodySource>>,
    meshes: Vec<Arc<MeshSource>>,
}

/// Reads the files of all bodies with model "imported" or "mesh", and writes their checksums beside them.
pub fn read_all(checker: &mut Checker, root: &mut Section, directory: &Path) {
    let bodies = root.items.iter_mut().find(|item| item.name == "bodies");
    let Some(Checked::Named(bodies)) = bodies.map(|item| &mut item.value) else { return };
    let mut known = Known::default();
    for (_, body) in bodies {
        match body.text("model") {
            Some("imported") => read_one(checker, body, "body file", |_, path| known.body(directory, path)),
            Some("mesh") => {
                read_one(checker, body, "mesh", |units, path| known.mesh(directory, path, units));
            }
            _ => {}
        }
    }
}

impl Known {
    fn body(&mut self, directory: &Path, text: &str) -> Result<(Checked, String), String> {
        let path = directory.join(text);
        let source = match self.bodies.iter().find(|source| source.path == path) {
            Some(source) => Arc::clone(source),
            None => {
                let source = Arc::new(read(path)?);
                self.bodies.push(Arc::clone(&source));
                source
            }
        };
        let sha256 = source.sha256.clone();
        Ok((Checked::BodyFile { text: text.to_owned(), source }, sha256))
    }

    fn mesh(
        &mut self,
        directory: &Path,
        text: &str,
        units: Option<&str>,
    ) -> Result<(Checked, String), String> {
        let path = directory.join(text);
        // Without a unit, which is a fault of its own, the mesh is read to find others.
        let units = units.unwrap_or("m");
        let source = match self.meshes.iter().find(|source| source.path == path && source.units == units) {
            Some(source) => Arc::clone(source),
            None => {
                let source = Arc::new(read_mesh(path, units)?);
                self.meshes.push(Arc::clone(&source));
                source
            }
        };
        let sha256 = source.sha256.clone();
        Ok((Checked::MeshFile { text: text.to_owned(), source }, sha256))
    }
}

/// Reads the file of one body, of the kind `what`, by `read`, which is given the unit of length and the path as it stands there.
fn read_one(
    checker: &mut Checker,
    body: &mut Section,
    what: &str,
    mut read: impl FnMut(Option<&str>, &str) -> Result<(Checked, String), String>,
) {
    let Some(position) = body.items.iter().position(|item| item.name == "file") else {
        let message = format!("required key is missing: the path of a {what}");
        checker.fault(&body.origin, body.path_of("file"), None, message);
        return;
    };
    let Some(text) = body.text("file").map(str::to_owned) else { return };
    let (value, sha256) = match read(body.text("units"), &text) {
        Ok(found) => found,
        Err(message) => {
            checker.fault_in(body, "file", message);
            body.items[position].value = Checked::Invalid;
            return;
        }
    };
    if body.item("file_sha256").is_some() {
        let wanted = body.text("file_sha256").unwrap_or(&sha256);
        if !wanted.eq_ignore_ascii_case(&sha256) {
            let path = match &value {
                Checked::BodyFile { source, .. } => &source.path,
                Checked::MeshFile { source, .. } => &source.path,
                _ => Path::new(&text),
            };
            let message = format!("{} has changed, it has {sha256}", path.display());
            checker.fault_in(body, "file_sha256", message);
        }
    } else {
        let (shown, origin) = (format!("{sha256:?}"), body.origin.clone());
        let value = Checked::Text(sha256);
        let item = Item { name: "file_sha256", when: &[], value, origin, shown, given: false };
        body.items.insert(position + 1, item);
    }
    body.items[position].value = value;
}

/// Length of a unit that a scenario names \[m\].
pub fn length(units: &str) -> f64 {
    match units {
        "cm" => 1e-2,
        "mm" => 1e-3,
        "in" => 0.0254,
        _ => 1.0,
    }
}

/// Reads the mesh `path`; what is doubtful about it is said.
fn read_mesh(path: PathBuf, units: &str) -> Result<MeshSource, String> {
    let cannot = |reason: String| format!("{}: {reason}", path.display());
    check_file(&path).map_err(cannot)?;
    let bytes = std::fs::read(&path).map_err(|e| cannot(format!("cannot be read: {e}")))?;
    let sha256 = hex(&Sha256::digest(&bytes));
    let mesh = fe_mesh::read::read(&bytes, length(units)).map_err(|e| cannot(e.to_string()))?;
    for note in mesh.notes() {
        tracing::warn!("{}: {note}", path.display());
    }
    Ok(MeshSource { path, sha256, units: units.to_owned(), mesh: Arc::new(mesh) })
}

fn check_file(path: &Path) -> Result<(), String> {
    let metadata = std::fs::metadata(path).map_err(|e| format!("cannot be read: {e}"))?;
    if metadata.is_file() { Ok(()) } else { Err("is no file".into()) }
}

/// Reads the body file `path`.
fn read(path: PathBuf) -> Result<BodySource, String> {
    let cannot = |reason: String| format!("{}: {reason}", path.display());
    check_file(&path).map_err(cannot)?;
    let sha256 = checksum(&path).map_err(|e| cannot(format!("cannot be read: {e}")))?;
    let body = body_file::read(&path).map_err(|e| e.to_string())?;
    Ok(BodySource { path, sha256, body })
}

fn checksum(path: &Path) -> std::io::Result<String> {
    let mut file = std::fs::File::open(path)?;
    let (mut hash, mut block) = (Sha256::new(), vec![0; BLOCK]);
    loop {
        match file.read(&mut block)? {
            0 => return Ok(hex(&hash.finalize())),
            n => hash.update(&block[..n]),
        }
    }
}
