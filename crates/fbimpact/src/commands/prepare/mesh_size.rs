//! `fbimpact mesh-size`: how fine meshes are to be where they are touched.

use std::fmt::Write as _;
use std::path::Path;

use adaptive::prepared::Prepared;
use adaptive::sizing::mesh_touch::{GROWTH, MeshTouch, touches, usual_length};
use result_files::file::output::Kind;
use result_files::file::whole_file;

use crate::commands::scenario_file;
use crate::commands::{body_index, gate_of, print};
use crate::error::{AppError, CommandFault};
use crate::scenario::{Override, Scenario};

/// A script for Gmsh, by the words with which it begins.
const SIZES: Kind =
    Kind::marked("a field of sizes for Gmsh that fbimpact wrote", "// Sizes of elements for body ");

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct MeshSize<'a> {
    /// Scenario file.
    pub scenario: &'a Path,
    /// Name of the body; the only one that is touched otherwise.
    pub body: Option<&'a str>,
    /// Gmsh script with the sizes; only a table is printed otherwise.
    pub output: Option<&'a Path>,
    /// Whether it may replace a file of others.
    pub force: bool,
}

/// Prints the predicted radius of every contact on a mesh, the length of the sides there and the
/// one that resolves it, and writes a field of sizes for Gmsh.
///
/// # Errors
/// [`AppError::Command`] if no mesh is touched, or several and none is named; [`AppError::Model`] if the motions at the start are not known;
/// [`AppError::Io`] for the file.
pub fn mesh_size(asked: &MeshSize<'_>, overrides: &[Override]) -> Result<(), AppError> {
    let scenario = scenario_file::read(asked.scenario, overrides)?;
    if let Some(output) = asked.output {
        gate_of(&scenario, asked.force).check(output, SIZES)?;
    }
    let run = Prepared::new(&scenario.run).map_err(AppError::model)?;
    let mut all: Vec<MeshTouch> =
        scenario.run.contacts.iter().flat_map(|contact| touches(&run.touches, contact)).collect();
    if let Some(name) = asked.body {
        let index = body_index(name, scenario.run.bodies.iter().map(|b| &b.name))?;
        all.retain(|touch| touch.body == index);
    }
    if all.is_empty() {
        return Err(CommandFault::request(
            "no contact of a body with model \"mesh\" has a radius that Hertz's theory predicts; there must be one, with surfaces that are curved against each other",
        )
        .into());
    }
    let text = table(&all);
    if let Some(output) = asked.output {
        let body = all[0].body;
        if all.iter().any(|touch| touch.body != body) {
            let mut names: Vec<String> = all.iter().map(|touch| touch.name.clone()).collect();
            names.dedup();
            let names = names.join(" and ");
            let reason = format!("contacts touch the meshes of {names}; choose one with --body");
            return Err(CommandFault::request(reason).into());
        }
        whole_file::write(output, field(&scenario, body, &all).as_bytes())?;
    }
    print(&text)
}

/// The table for people; writing to a string cannot fail.
fn table(all: &[MeshTouch]) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{:<16} {:<16} {:>12} {:>12} {:>12} {:>12}",
        "contact", "body", "force [N]", "radius [m]", "sides [m]", "wanted [m]"
    );
    for t in all {
        let verdict = if t.is_coarse() { "too coarse" } else { "fine enough" };
        let _ = writeln!(
            out,
            "{:<16} {:<16} {:>12.4e} {:>12.4e} {:>12.4e} {:>12.4e}  {verdict}",
            t.contact, t.name, t.force, t.radius, t.length, t.wanted
        );
    }
    out
}

/// A script for Gmsh with one ball of small elements a touch of body `index`, in the unit of its
/// mesh.
fn field(scenario: &Scenario, index: usize, all: &[MeshTouch]) -> String {
    let Some(meshed) = scenario.run.bodies[index].kind.meshed() else { return String::new() };
    let of_file = scenario.bodies.iter().find(|b| b.index == Some(index)).and_then(|b| b.file.as_ref());
    let unit = of_file.map_or(1.0, |file| file.unit);
    let usual = usual_length(meshed, all) / unit;
    let mut out = String::new();
    let _ = writeln!(
        out,
        "// Sizes of elements for body \"{}\", in the unit of its mesh, {unit} m: Include this file after the geometry.",
        all[0].name
    );
    for (i, t) in all.iter().enumerate() {
        let n = i + 1;
        let [x, y, z] = t.point.map(|x| x / unit);
        let size = (t.wanted / unit).min(usual);
        // Edges of elements that Gmsh makes are up to twice as long as asked for.
        let size = 0.5 * size;
        let (reach, slope) = (1.5 * t.radius / unit, (usual - size) / GROWTH);
        let _ = writeln!(
            out,
            "// contact \"{}\": radius {:.4e} m at {:.4e} N\nField[{n}] = Ball;\nField[{n}].XCenter = {x:e};\nField[{n}].YCenter = {y:e};\n\
             Field[{n}].ZCenter = {z:e};\nField[{n}].Radius = {reach:e};\nField[{n}].Thickness = {slope:e};\nField[{n}].VIn = {size:e};\n\
             Field[{n}].VOut = {usual:e};",
            t.contact, t.radius, t.force
        );
    }
    let n = all.len() + 1;
    let list: Vec<String> = (1..n).map(|i| i.to_string()).collect();
    let _ = writeln!(
        out,
        "Field[{n}] = Min;\nField[{n}].FieldsList = {{{}}};\nBackground Field = {n};\nMesh.MeshSizeExtendFromBoundary = 0;\n\
         Mesh.MeshSizeFromPoints = 0;\nMesh.MeshSizeFromCurvature = 0;",
        list.join(", ")
    );
    out
}
