//! A part from a file as a body: meshed where it is a shape, described, and put above a floor.

use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use adaptive::sizing::impact_time::mass_properties;
use adaptive::spec::{BodyKind, MeshedSpec};
use adaptive::surface;
use clap::ValueEnum;
use ffr_dynamics::body::RigidMotion;
use nalgebra::Vector3;
use result_files::file::fault::Access;
use result_files::file::whole_file;

use super::digits::short;
use super::tied::{self, Joints, PartBody};
use crate::cli::{LengthUnit, PartArguments, SectionModel};
use crate::error::{AppError, CommandFault};
use crate::scenario::{self, Scenario};
use crate::studies::orientations::{Floor, Ground};

/// Gap to the floor over the size of a part: a fall of microseconds.
pub const GAP: f64 = 1e-4;
/// Endings of files that hold a shape without a mesh.
const SHAPES: [&str; 5] = ["step", "stp", "brep", "iges", "igs"];
/// The line that installs what meshes them.
const INSTALL: &str = "a shape is meshed by Gmsh, which was not found, neither the program nor the package of python3: pip install gmsh";
/// The body of the scenarios that are written.
pub const BODY: &str = "part";
const FLOOR: &str = "floor";
/// Parts that become bodies of one scenario; of a file with more one is to be chosen.
const MOST_PARTS: usize = 50;
/// Modes of a layer on rigid ground, which follows a contact that is slower than waves through it as a spring does.
const LAYER_MODES: usize = 20;
/// Characters of the name of a part that the name of its body has.
const LONGEST: usize = 40;

/// Whether `path` holds a shape that is to be meshed.
fn is_shape(path: &Path) -> bool {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    SHAPES.contains(&ending.as_str())
}

/// Files that a part makes beside `scenario`: a mesh and the script that meshes it; none of a mesh.
pub fn companions(part: &Path, scenario: &Path) -> Vec<PathBuf> {
    if !is_shape(part) {
        return Vec::new();
    }
    ["msh", "geo"].map(|ending| scenario.with_extension(ending)).to_vec()
}

/// What a scenario is made of.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    /// The part.
    pub arguments: &'a PartArguments,
    /// Kinematics of a mesh in the plane.
    pub section: Option<SectionModel>,
    /// Whether all parts of a file with several become bodies.
    pub is_assembly: bool,
    /// What the part falls on.
    pub ground: &'a Ground,
}

/// A scenario at `path` in which a part falls on a rigid floor, as text, and as it is read.
pub struct PartScenario {
    /// The text.
    pub text: String,
    /// What it says.
    pub scenario: Scenario,
    /// Names of its bodies that are parts.
    names: Vec<String>,
    /// What the file ties, in words.
    told: Vec<String>,
}

/// Makes the scenario of the part of `part`, a mesh that is beside `path` then if it is a shape, of a mesh in
/// the plane with its kinematics. Parts of an assembly become bodies, joined where the file ties them.
///
/// # Errors
/// [`AppError::Io`] for files that cannot be read, written or meshed, [`AppError::Command`] without a unit of length,
/// [`AppError::Scenario`] for a part that is no body.
pub fn scenario(
    part: &Path,
    &Wanted { arguments, section, is_assembly, ground }: &Wanted<'_>,
    path: &Path,
    title: &str,
) -> Result<PartScenario, AppError> {
    let unit = unit(part, arguments)?;
    let mesh = if is_shape(part) {
        let mesh = path.with_extension("msh");
        meshed(part, &mesh, arguments.size)?;
        mesh
    } else {
        part.to_owned()
    };
    let file = from_folder(path.parent().unwrap_or(Path::new("")), &mesh);
    let parts = match &arguments.part {
        Some(part) => vec![part.clone()],
        None if is_assembly => scenario::mesh_parts(&mesh).map_err(|reason| AppError::io(&mesh, reason))?,
        None => Vec::new(),
    };
    let parts = if (1..=MOST_PARTS).contains(&parts.len()) { parts } else { vec![String::new()] };
    let names = names(&parts);
    let model = section.and_then(|section| Some(section.to_possible_value()?.get_name().to_owned()));
    let is_plane = matches!(section, Some(SectionModel::PlaneStrain | SectionModel::PlaneStress));
    let up = if is_plane { Vector3::y_axis() } else { Vector3::z_axis() };
    let mut text = TEXT.replace("MODEL", &quoted(model.as_deref().unwrap_or("mesh")));
    for (what, factor) in [("GRAVITY", -9.81), ("VELOCITY", -1.0), ("NORMAL", 1.0)] {
        text = text
            .replace(what, &format!("{:?}", up.map(|x| if x == 0.0 { 0.0 } else { factor * x }).as_slice()));
    }
    text = text.replace("TITLE", &quoted(title)).replace("FILE", &quoted(&file.to_string_lossy()));
    text = text.replace("MATERIAL", &quoted(&arguments.material));
    text = text
        .replace("UNITS", &quoted(unit.to_possible_value().as_ref().map_or("mm", |value| value.get_name())));
    let written = |position: &Vector3<f64>, lowest: &str, joints: &Joints, floor: Option<&str>| {
        let (before, rest) = text.split_once("[bodies.BODY]").unwrap_or((&text, ""));
        let (body, after) = rest.split_once("[bodies.floor]").unwrap_or((rest, ""));
        let mut bodies = String::new();
        for (i, (part, name)) in parts.iter().zip(&names).enumerate() {
            let part = if part.is_empty() { String::new() } else { format!("part = {}\n", quoted(part)) };
            let is_child = joints.is_child.get(i) == Some(&true);
            let moves =
                |line: &&str| ["position", "orientation", "velocity"].iter().any(|key| line.starts_with(key));
            bodies += &format!("[bodies.{name}]");
            body.split_inclusive('\n')
                .filter(|line| !(is_child && moves(line)))
                .for_each(|line| bodies += line);
            bodies = bodies.replace("PART\n", &part);
        }
        let after = after.replace("LOWEST", lowest).replace("HOLD", &joints.text);
        let (own, after) = after.split_once("[contacts").unwrap_or((&after, ""));
        let all = format!("{before}{bodies}[bodies.{FLOOR}]{}[contacts{after}", floor.unwrap_or(own));
        all.replace("POSITION", &format!("{:?}", position.as_slice()))
    };
    // Where it stands depends on what is read.
    let at_origin = written(&Vector3::zeros(), &names[0], &Joints::default(), None);
    let read = scenario::parse(path, at_origin.as_bytes(), &[])?;
    let kinds = || read.run.bodies.iter().take(parts.len()).map(|body| &body.kind);
    let meshes = parts.iter().zip(&names).zip(kinds()).filter_map(|((part, name), kind)| {
        Some(PartBody { name: name.clone(), part, mesh: &kind.meshed()?.mesh })
    });
    let mut joints = tied::joints(&meshes.collect::<Vec<_>>());
    if joints.told.is_empty() && parts.len() == 1 {
        joints.text = kinds().next().and_then(BodyKind::meshed).map_or_else(String::new, hold);
    }
    let floor = Floor { point: Vector3::zeros(), up };
    let gap = |kind: &BodyKind| GAP * kind.diagonal().unwrap_or(1.0);
    let position = |kind: &BodyKind| {
        let (surface, motion) = (surface::of_body(kind)?, kind.motion());
        if motion == RigidMotion::Spatial && parts.len() == 1 {
            let (gap, centre) = (gap(kind), mass_and_centre(kind).1);
            let pose = crate::studies::orientations::pose(&*surface, &-floor.up, (&floor, gap), &centre);
            return pose.map(|(position, _)| position);
        }
        // As the file has it, above the floor's point.
        let lowest = surface.lowest(&motion.components(up.as_ref().as_ref()).into())?.point;
        Some(up.into_inner() * (gap(kind) - up.dot(&motion.in_space(&lowest))))
    };
    let highest =
        |a: &(usize, Vector3<f64>), b: &(usize, Vector3<f64>)| up.dot(&a.1).total_cmp(&up.dot(&b.1));
    let lowest = kinds().enumerate().filter_map(|(i, kind)| Some((i, position(kind)?))).max_by(highest);
    let (lowest, position) = lowest.unwrap_or_default();
    let layer = kinds().nth(lowest).and_then(|kind| layer(ground, kind, model.as_deref()));
    let text = written(&position, &names[lowest], &joints, layer.as_deref());
    let scenario = scenario::parse(path, text.as_bytes(), &[])?;
    Ok(PartScenario { text, scenario, names, told: joints.told })
}

/// The table of a floor that is no rigid plane, below the `body`: twice as wide as that is long, so that waves from its sides come late,
/// and held at its base.
fn layer(ground: &Ground, body: &BodyKind, section: Option<&str>) -> Option<String> {
    let Ground::Layer(material, thickness) = ground else { return None };
    let (side, material) = (2.0 * body.diagonal()?.max(*thickness), quoted(material));
    let (model, geometry, elements, point, face) = match body.motion() {
        RigidMotion::Spatial => {
            let shape = format!("shape = \"box\", size = [{side:?}, {side:?}, {thickness:?}]");
            (
                "solid",
                shape,
                "\ndiscretisation = { degree = 2, elements = [8, 8, 3] }",
                [0.0, 0.0, -thickness],
                "z-",
            )
        }
        RigidMotion::Planar => {
            let shape = format!("shape = \"rectangle\", size = [{side:?}, {thickness:?}]");
            (section?, shape, "", [0.0, -thickness, 0.0], "y-")
        }
        RigidMotion::Axial => {
            let shape = format!("shape = \"rod\", radius = {:?}, length = {thickness:?}", 0.5 * side);
            ("axisymmetric", shape, "", [0.0, 0.0, -thickness], "z-")
        }
    };
    Some(format!(
        "\nmodel = \"{model}\"\ngeometry = {{ {geometry} }}\nmaterial = {material}{elements}\n\
         reduction = {{ modes = {LAYER_MODES} }}    # it yields as a spring to contacts slower than waves through it\n\n[joints.base]\ntype = \"fixed\"\n\
         parent = {{ body = \"ground\", point = {point:?} }}\nchild = {{ body = \"{FLOOR}\", face = \"{face}\", coupling = \"rigid\" }}\n\n"
    ))
}

/// Names of the bodies of `parts`.
fn names(parts: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for part in parts {
        let name = if parts.len() > 1 { plain(part) } else { BODY.to_owned() };
        let mut others = (2..).map(|i| format!("{name}-{i}"));
        let is_free = |name: &String| name != FLOOR && !names.contains(name);
        let name = Some(name.clone()).filter(is_free).or_else(|| others.find(is_free));
        names.extend(name);
    }
    names
}

/// A name of a part as one that a body can have.
fn plain(name: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let name: String = name.chars().map(|c| if is_plain(c) { c } else { '-' }).take(LONGEST).collect();
    name.to_lowercase()
}

/// The unit of length of a part that is there.
///
/// # Errors
/// [`AppError::Io`] if it is not there, [`AppError::Command`] for a mesh without a unit.
pub fn unit(part: &Path, arguments: &PartArguments) -> Result<LengthUnit, AppError> {
    std::fs::metadata(part).map_err(|e| AppError::system(part, Access::Read, e))?;
    match arguments.units {
        Some(unit) => Ok(unit),
        // As Gmsh reads them, whatever their own unit is.
        None if is_shape(part) => Ok(LengthUnit::Mm),
        None => {
            let reason = format!(
                "{} does not say its unit of length, name it: --units mm, or m, cm, in",
                part.display()
            );
            Err(CommandFault::request(reason).into())
        }
    }
}

/// The scenario, with what is filled in in capitals.
const TEXT: &str = include_str!("../../templates/part.toml");

/// A text as TOML has it.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// The joint that holds the first face of a part, as a remark.
fn hold(part: &MeshedSpec) -> String {
    let Some(face) = part.mesh.face_names().next() else { return String::new() };
    format!(
        "\n# Held at a face in place of its free fall: take out position and velocity above, and the marks below.\n#[joints.hold]\n#type = \"fixed\"\n\
         #parent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\n#child = {{ body = \"{BODY}\", face = {} }}\n",
        quoted(face)
    )
}

/// Mass and centre of mass of a body in its own frame.
pub fn mass_and_centre(body: &BodyKind) -> (f64, Vector3<f64>) {
    match (body, mass_properties(body)) {
        (BodyKind::Rigid(rigid), _) => (rigid.mass, rigid.centre_of_mass),
        (_, Some(found)) => (found.volume, found.centre().into()),
        (_, None) => (f64::NAN, Vector3::zeros()),
    }
}

/// What is in the parts of a scenario, and what ties them, for people.
pub fn description(made: &PartScenario) -> String {
    let bodies = made.names.iter().zip(&made.scenario.run.bodies);
    let told = |(name, body): (&String, &adaptive::spec::BodySpec)| {
        let title = if made.names.len() > 1 { format!("body            {name}\n") } else { String::new() };
        title + &described(&body.kind)
    };
    let all: Vec<String> = bodies.map(told).collect();
    let ties: String = made.told.iter().map(|tie| format!("tied            {tie}\n")).collect();
    all.join("\n") + &ties
}

fn described(body: &BodyKind) -> String {
    let (mass, centre) = mass_and_centre(body);
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "mass            {} kg", short(mass));
    let _ = writeln!(
        out,
        "centre of mass  {} m",
        centre.iter().map(|x| short(*x)).collect::<Vec<_>>().join(", ")
    );
    let Some(meshed) = body.meshed() else { return out };
    let mesh = &meshed.mesh;
    let side = |i: usize| {
        let ends = mesh.nodes().iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p[i]), b.max(p[i])));
        // Round-off of the program that wrote the file.
        let told = |x: f64| short(if x.abs() < 1e-9 * mesh.size() { 0.0 } else { x });
        format!("{} to {}", told(ends.0), told(ends.1))
    };
    let _ = writeln!(out, "box             {} m", [0, 1, 2].map(side).join(", "));
    let _ = writeln!(
        out,
        "mesh            {} nodes, {} elements, {} sides on the surface",
        mesh.nodes().len(),
        mesh.elements().len(),
        mesh.surface().len()
    );
    for (name, elements) in mesh.volumes() {
        let _ = writeln!(out, "volume          {name:?}: {} elements", elements.len());
    }
    for (name, faces) in mesh.faces().iter().filter(|(_, faces)| !faces.is_empty()) {
        let nodes: Vec<u32> = faces.iter().flat_map(|face| mesh.face(*face).1).collect();
        let mut places = Vec::new();
        mesh.places(&nodes, &mut places);
        let middle = [0, 1, 2].map(|i| {
            let ends = places.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p[i]), b.max(p[i])));
            short(0.5 * (ends.0 + ends.1))
        });
        let _ =
            writeln!(out, "face            {name:?}: {} sides about {} m", faces.len(), middle.join(", "));
    }
    out
}

/// Meshes the shape of `part` by Gmsh into `mesh`, with sides of `size` at most.
fn meshed(part: &Path, mesh: &Path, size: Option<f64>) -> Result<(), AppError> {
    let whole = std::fs::canonicalize(part).map_err(|e| AppError::system(part, Access::Read, e))?;
    let longest = size
        .map_or("0.08 * Sqrt((b(3) - b(0))^2 + (b(4) - b(1))^2 + (b(5) - b(2))^2)".to_owned(), |s| {
            s.to_string()
        });
    let script = mesh.with_extension("geo");
    let text = GEO.replace("FILE", &whole.display().to_string().replace('\\', "/")).replace("SIZE", &longest);
    let time = |path: &Path| std::fs::metadata(path).and_then(|m| m.modified()).ok();
    if time(mesh) > time(part) && std::fs::read(&script).is_ok_and(|known| known == text.as_bytes()) {
        return Ok(());
    }
    whole_file::write(&script, text.as_bytes())?;
    let name = |path: &Path| path.file_name().unwrap_or_default().to_owned();
    let folder = script.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut by_program = Command::new("gmsh");
    by_program.arg(name(&script)).args(["-3", "-v", "2", "-o"]).arg(name(mesh));
    let mut by_package = Command::new("python3");
    by_package.args(["-c", PYTHON]).arg(name(&script)).arg(name(mesh));
    tracing::info!("{}: meshed by Gmsh", part.display());
    for command in [&mut by_program, &mut by_package] {
        let output = match command.current_dir(folder).output() {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            Err(error) => return Err(AppError::system(part, Access::Start, error)),
            Ok(output) => output,
        };
        if output.status.code() == Some(NO_PACKAGE) {
            continue;
        }
        let told = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
        let faults: Vec<&str> = told.lines().filter(|line| line.starts_with("Error")).collect();
        if !output.status.success() || !mesh.is_file() || !faults.is_empty() {
            let reason = if faults.is_empty() { told.trim().to_owned() } else { faults.join("; ") };
            let script = script.display();
            return Err(AppError::io(
                part,
                format!("Gmsh cannot mesh it: {reason}; see what gmsh {script} shows"),
            ));
        }
        return Ok(());
    }
    // Nothing made it of use.
    let _ = std::fs::remove_file(&script);
    Err(AppError::io(part, INSTALL))
}

/// What python3 ends with where it has no Gmsh.
const NO_PACKAGE: i32 = 97;
const PYTHON: &str = "import sys\ntry:\n    import gmsh\nexcept ImportError:\n    sys.exit(97)\ngmsh.initialize()\ngmsh.option.setNumber('General.Verbosity', 2)\n\
                      gmsh.open(sys.argv[1])\ngmsh.model.mesh.generate(3)\ngmsh.write(sys.argv[2])\n";
/// Meshes all solids of a file, with groups for each of them and for each face.
const GEO: &str = "\
// Meshes a shape: gmsh THIS.geo -3 -o THIS.msh
SetFactory(\"OpenCASCADE\");
v() = ShapeFromFile(\"FILE\");
b() = BoundingBox Volume{ v() };
Mesh.MeshSizeMax = SIZE;
Mesh.MeshSizeFromCurvature = 12;     // elements around a circle
Mesh.ElementOrder = 2;
Mesh.HighOrderOptimize = 2;          // curved sides that are not inside out
Mesh.MshFileVersion = 4.1;
For i In {0 : #v() - 1}
  Physical Volume(Sprintf(\"solid %g\", i + 1)) = {v(i)};
EndFor
s() = Surface{:};
For i In {0 : #s() - 1}
  Physical Surface(Sprintf(\"face %g\", s(i))) = {s(i)};
EndFor
";

/// `path` as a file in `folder` names it: as short as it is where both lie in the working directory or below, whole otherwise.
fn from_folder(folder: &Path, path: &Path) -> PathBuf {
    if let Ok(below) = path.strip_prefix(folder) {
        return below.to_owned();
    }
    let is_plain = |path: &Path| path.components().all(|part| matches!(part, Component::Normal(_)));
    if is_plain(folder) && is_plain(path) {
        let up: PathBuf = folder.components().map(|_| Component::ParentDir).collect();
        return up.join(path);
    }
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}
