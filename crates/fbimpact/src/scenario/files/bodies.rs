//! Body files, meshes and files of splines that a scenario names: read once each, so that their
//! markers, groups and models can be checked like keys.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fe_mesh::read::{Wanted, parts, read_part};
use iga_core::elasticity::Model;
use result_files::file::plain_file;
use result_files::toml_text::document::{Origin, SourceText, Value, parse_json, parse_toml};
use sha2::{Digest, Sha256};

use super::spline_nets;
use crate::interchange::body_file;
use crate::scenario::body_source::{BodySource, GivenPatches, MeshSource, SplineSource};
use crate::scenario::check::Checker;
use crate::scenario::hex;
use crate::scenario::section::{Checked, Item, Section};
use crate::scenario::tables::{BodyModel, LengthUnit, NURBS_FILE, ShapeName};

/// Largest file with control nets: 64 MiB are a million control points.
const MAX_NET: u64 = 64 << 20;

/// Bytes read at a time.
const BLOCK: usize = 1 << 16;

/// Files read so far; bodies that name the same one share it.
#[derive(Default)]
struct Known {
    bodies: Vec<Arc<BodySource>>,
    meshes: Vec<Arc<MeshSource>>,
}

/// Reads the files of all bodies with model "imported" or "mesh" and of shapes of splines, and
/// writes their checksums beside them.
pub fn read_all(checker: &mut Checker, root: &mut Section, directory: &Path) {
    let bodies = root.items.iter_mut().find(|item| item.name == "bodies");
    let Some(Checked::Named(bodies)) = bodies.map(|item| &mut item.value) else { return };
    let mut known = Known::default();
    for (_, body) in bodies.iter_mut() {
        if is_meshed(body) {
            let (part, model) = (body.text("part").map(str::to_owned), kinematics(body));
            read_one(checker, body, "mesh", |_, units, path| {
                known.mesh(directory, path, (units, part.as_deref()), model).map_err(Some)
            });
            continue;
        }
        match body.choice("model") {
            Some(BodyModel::Imported) => {
                read_one(checker, body, "body file", |_, _, path| known.body(directory, path).map_err(Some));
            }
            Some(
                BodyModel::Mesh
                | BodyModel::Solid
                | BodyModel::Axisymmetric
                | BodyModel::PlaneStrain
                | BodyModel::PlaneStress
                | BodyModel::Rigid,
            )
            | None => read_shape(checker, body, directory),
        }
    }
}

/// Whether the body of the table `section` is of finite elements: solid ones, or those of a plane or
/// axisymmetric model that names a file.
pub fn is_meshed(section: &Section) -> bool {
    match section.choice("model") {
        Some(BodyModel::Mesh) => true,
        Some(BodyModel::Axisymmetric | BodyModel::PlaneStrain | BodyModel::PlaneStress) => {
            section.given("file") && !section.given("geometry")
        }
        _ => false,
    }
}

/// The kinematics of a body of finite elements; a thickness at fault is told elsewhere.
fn kinematics(body: &Section) -> Model {
    let thickness = body.number("thickness").unwrap_or(1.0);
    match body.choice("model") {
        Some(BodyModel::Axisymmetric) => Model::Axisymmetric,
        Some(BodyModel::PlaneStrain) => Model::PlaneStrain { thickness },
        Some(BodyModel::PlaneStress) => Model::PlaneStress { thickness },
        _ => Model::Solid,
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
        (units, part): (Option<LengthUnit>, Option<&str>),
        model: Model,
    ) -> Result<(Checked, String), String> {
        let path = directory.join(text);
        // Without a unit, which is a fault of its own, the mesh is read to find others.
        let units = units.unwrap_or(LengthUnit::Metre);
        let is_known = |source: &&Arc<MeshSource>| {
            let is_read_so = source.units == units && source.part.as_deref() == part;
            source.path == path && is_read_so && *source.mesh.model() == model
        };
        let source = match self.meshes.iter().find(is_known) {
            Some(source) => Arc::clone(source),
            None => {
                let source = Arc::new(read_mesh(path, (units, part), model)?);
                self.meshes.push(Arc::clone(&source));
                source
            }
        };
        let sha256 = source.sha256.clone();
        Ok((Checked::MeshFile { text: text.to_owned(), source }, sha256))
    }
}

/// Reads the file of the shape of a body if it is one of splines.
fn read_shape(checker: &mut Checker, body: &mut Section, directory: &Path) {
    let directions = spline_nets::directions(body);
    let geometry = body.items.iter_mut().find(|item| item.name == "geometry");
    let Some(Checked::Table(geometry)) = geometry.map(|item| &mut item.value) else { return };
    if geometry.choice("shape") != Some(ShapeName::Nurbs) || geometry.item("file").is_none() {
        return;
    }
    let place = geometry.path.clone();
    read_one(checker, geometry, "file of splines", |checker, units, text| {
        let source = read_splines(checker, directory.join(text), units, directions, &place)?;
        let sha256 = source.sha256.clone();
        Ok((Checked::SplineFile { text: text.to_owned(), source: Arc::new(source) }, sha256))
    });
}

/// Reads the file of one body, of the kind `what`, by `read`, which is given the unit of length and
/// the path as it stands there, and says what is wrong unless it has reported it.
fn read_one(
    checker: &mut Checker,
    body: &mut Section,
    what: &str,
    mut read: impl FnMut(&mut Checker, Option<LengthUnit>, &str) -> Result<(Checked, String), Option<String>>,
) {
    let Some(position) = body.items.iter().position(|item| item.name == "file") else {
        body.fault("file", format!("required key is missing: the path of a {what}"));
        return;
    };
    let Some(text) = body.text("file").map(str::to_owned) else { return };
    let (value, sha256) = match read(checker, body.choice("units"), &text) {
        Ok(found) => found,
        Err(message) => {
            message.into_iter().for_each(|message| body.fault("file", message));
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
                Checked::SplineFile { source, .. } => &source.path,
                _ => Path::new(&text),
            };
            body.fault("file_sha256", format!("{} has changed, it has {sha256}", path.display()));
        }
    } else {
        let (shown, origin) = (format!("{sha256:?}"), body.origin.clone());
        let value = Checked::Text(sha256);
        body.items.insert(position + 1, Item::new("file_sha256", value, origin, shown));
    }
    body.items[position].value = value;
}

/// Reads the splines in `path`, for the geometry at `place` of a body with so many directions.
fn read_splines(
    checker: &mut Checker,
    path: PathBuf,
    units: Option<LengthUnit>,
    directions: Option<usize>,
    place: &str,
) -> Result<SplineSource, Option<String>> {
    let cannot = |reason: String| Some(format!("{}: {reason}", path.display()));
    let size = std::fs::metadata(&path).map_err(|e| cannot(format!("cannot be read: {e}")))?.len();
    if size > MAX_NET {
        return Err(cannot(format!("has {size} bytes, at most {MAX_NET} are read")));
    }
    let bytes = plain_file::read(&path).map_err(|e| cannot(format!("cannot be read: {e}")))?;
    let sha256 = hex(&Sha256::digest(&bytes));
    let start = bytes.trim_ascii_start();
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let Some(directions) = directions else { return Err(None) };
    let (unit, given) = if start.starts_with(b"<") || start.starts_with(b"MFEM") {
        let units = units.ok_or_else(|| {
            cannot("does not say its unit of length; give \"units\" beside the file: m, cm, mm or in".into())
        })?;
        let unit = units.length();
        let file = iga_core::files::read(&bytes, unit).map_err(|e| cannot(e.to_string()))?;
        file.notes.iter().for_each(|note| tracing::warn!("{}: {note}", path.display()));
        if let Some(found) =
            file.patches.iter().map(iga_core::nurbs::Patch::dimension).find(|n| *n != directions)
        {
            let reason = format!("has patches of {found} directions, the model of the body has {directions}");
            return Err(cannot(reason));
        }
        (unit, GivenPatches { patches: file.patches, joined: file.joined, faces: file.faces })
    } else {
        if units.is_some() {
            let reason = "numbers in TOML and JSON are in metres or have their unit; take \"units\" away";
            return Err(cannot(reason.into()));
        }
        (1.0, read_tables(checker, &path, bytes, directions, place).map_err(|m| m.and_then(cannot))?)
    };
    Ok(SplineSource { path, sha256, unit, given })
}

/// The splines in a TOML or JSON file.
fn read_tables(
    checker: &mut Checker,
    path: &Path,
    bytes: Vec<u8>,
    directions: usize,
    place: &str,
) -> Result<GivenPatches, Option<String>> {
    let text = String::from_utf8(bytes).map_err(|_| Some("must be UTF-8 text".to_owned()))?;
    let source = Arc::new(SourceText { name: path.display().to_string(), text });
    let parsed = if source.name.ends_with(".json") { parse_json(&source) } else { parse_toml(&source) };
    let table = parsed.map_err(|faults| {
        faults.into_iter().for_each(|fault| checker.faults.push(fault));
        None
    })?;
    let Value::Table(entries) = &table.value else {
        let message = "must hold a table with the keys of a control net".into();
        checker.fault(&Origin::File(source, 0..0), format!("{place}.file"), None, message);
        return Err(None);
    };
    let net = checker.section(NURBS_FILE, entries, place, &table.origin, None);
    if net.given("patches")
        && let Some(item) = net.items.iter().find(|item| item.given && item.name != "patches")
    {
        net.fault(item.name, "has a meaning without \"patches\" only");
        return Err(None);
    }
    spline_nets::patches(&net, directions).ok_or(None)
}

/// Reads the mesh `path`, or a part of it; what is doubtful about it is logged as a warning.
fn read_mesh(
    path: PathBuf,
    (units, part): (LengthUnit, Option<&str>),
    model: Model,
) -> Result<MeshSource, String> {
    let cannot = |reason: String| format!("{}: {reason}", path.display());
    let bytes = plain_file::read(&path).map_err(|e| cannot(format!("cannot be read: {e}")))?;
    let mut hash = Sha256::new_with_prefix(&bytes);
    let mut include = |name: &str| {
        let included = included(&path, name)?;
        hash.update(&included);
        Ok(included)
    };
    let mut wanted = Wanted { part, include: &mut include };
    let mesh = read_part(&bytes, units.length(), &mut wanted).map_err(|e| cannot(e.to_string()))?;
    let mesh = mesh.of_model(model).map_err(|e| cannot(e.to_string()))?;
    for note in mesh.notes() {
        tracing::warn!("{}: {note}", path.display());
    }
    let (sha256, part) = (hex(&hash.finalize()), part.map(str::to_owned));
    Ok(MeshSource { path, sha256, units, part, mesh: Arc::new(mesh) })
}

/// The file `name` that the file `path` includes: names are relative to its folder.
fn included(path: &Path, name: &str) -> Result<Vec<u8>, String> {
    plain_file::read(&path.with_file_name(name)).map_err(|e| e.to_string())
}

/// Names of the parts of the mesh file `path`, none if it is one.
///
/// # Errors
/// Why it cannot be read.
pub fn mesh_parts(path: &Path) -> Result<Vec<String>, String> {
    let bytes = plain_file::read(path).map_err(|e| format!("cannot be read: {e}"))?;
    parts(&bytes, &mut |name| included(path, name)).map_err(|e| e.to_string())
}

/// Reads the body file `path`.
fn read(path: PathBuf) -> Result<BodySource, String> {
    let cannot = |reason: String| format!("{}: {reason}", path.display());
    let sha256 = checksum(&path).map_err(|e| cannot(format!("cannot be read: {e}")))?;
    let body = body_file::read(&path).map_err(|e| e.to_string())?;
    Ok(BodySource { path, sha256, body })
}

fn checksum(path: &Path) -> std::io::Result<String> {
    let mut file = plain_file::open(path)?;
    let (mut hash, mut block) = (Sha256::new(), vec![0; BLOCK]);
    loop {
        match file.read(&mut block)? {
            0 => return Ok(hex(&hash.finalize())),
            n => hash.update(&block[..n]),
        }
    }
}
