//! Body files that a scenario names: read once each, so that their markers and models can be checked like keys.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::body_source::BodySource;
use super::check::Checker;
use super::hex;
use super::section::{Checked, Item, Section};
use crate::body_file;

/// Bytes read at a time.
const BLOCK: usize = 1 << 16;

/// Reads the files of all bodies with model "imported", and writes their checksums beside them.
pub fn read_all(checker: &mut Checker, root: &mut Section, directory: &Path) {
    let bodies = root.items.iter_mut().find(|item| item.name == "bodies");
    let Some(Checked::Named(bodies)) = bodies.map(|item| &mut item.value) else { return };
    let mut known: Vec<Arc<BodySource>> = Vec::new();
    for (_, body) in bodies {
        if body.text("model") == Some("imported") {
            read_one(checker, body, directory, &mut known);
        }
    }
}

fn read_one(checker: &mut Checker, body: &mut Section, directory: &Path, known: &mut Vec<Arc<BodySource>>) {
    let Some(position) = body.items.iter().position(|item| item.name == "file") else {
        let message = "required key is missing: the path of a body file".into();
        checker.fault(&body.origin, body.path_of("file"), None, message);
        return;
    };
    let Some(text) = body.text("file").map(str::to_owned) else { return };
    let path = directory.join(&text);
    let source = match known.iter().find(|source| source.path == path) {
        Some(source) => Arc::clone(source),
        None => match read(path) {
            Ok(source) => {
                known.push(Arc::new(source));
                Arc::clone(&known[known.len() - 1])
            }
            Err(message) => {
                checker.fault_in(body, "file", message);
                body.items[position].value = Checked::Invalid;
                return;
            }
        },
    };
    if body.item("file_sha256").is_some() {
        let wanted = body.text("file_sha256").unwrap_or(&source.sha256);
        if !wanted.eq_ignore_ascii_case(&source.sha256) {
            let message = format!("{} has changed, it has {}", source.path.display(), source.sha256);
            checker.fault_in(body, "file_sha256", message);
        }
    } else {
        let (value, origin) = (Checked::Text(source.sha256.clone()), body.origin.clone());
        let shown = format!("{:?}", source.sha256);
        body.items.insert(
            position + 1,
            Item { name: "file_sha256", when: &[], value, origin, shown, given: false },
        );
    }
    body.items[position].value = Checked::BodyFile { text, source };
}

/// Reads the body file `path`.
fn read(path: PathBuf) -> Result<BodySource, String> {
    let cannot = |reason: String| format!("{}: {reason}", path.display());
    let metadata = std::fs::metadata(&path).map_err(|e| cannot(format!("cannot be read: {e}")))?;
    if !metadata.is_file() {
        return Err(cannot("is no file".into()));
    }
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
