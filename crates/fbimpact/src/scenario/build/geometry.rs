//! Exact shapes: which go with which model, sizes that fit together, control nets inline or from a file.

use std::path::Path;
use std::sync::Arc;

use iga_core::SplineError;
use iga_core::knots::KnotVector;
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{axisymmetric, plane, solid, sphere};
use iga_core::nurbs::{Patch, Shape};

use super::super::check::Checker;
use super::super::document::{Node, Origin, SourceText, Value, parse_json, parse_toml};
use super::super::fault::Fault;
use super::super::keys::names;
use super::super::section::Section;
use super::super::tables::{NURBS_FILE, SHAPES, ShapeFacts};
use super::discretisation::per_direction;
use super::places::{dimension, padded};

/// Largest file with a control net: 64 MiB are a million control points.
const MAX_FILE: u64 = 64 << 20;

/// Reports a shape that does not go with the model.
pub fn check_model(checker: &mut Checker, body: &Section, model: &str, shape: &str) -> Option<()> {
    let facts = ShapeFacts::find(shape)?;
    if facts.fits(model) {
        return Some(());
    }
    let fitting = names(SHAPES.iter().filter(|s| s.fits(model)).map(|s| s.name));
    let models = names(facts.models.iter().map(|m| m.model));
    let message = match body.text("motion") {
        Some(motion) if body.text("model") == Some("rigid") => {
            format!("does not go with motion \"{motion}\" of a rigid body: choose {fitting}")
        }
        _ => format!("does not go with model \"{model}\": choose {fitting}, or model {models}"),
    };
    checker.fault_in(body.table("geometry")?, "shape", message);
    None
}

/// The exact shape of a body whose points have the components of `model`; `degree` decides on the net of a ball where none is named.
pub fn shape(
    checker: &mut Checker,
    body: &Section,
    model: &str,
    degree: usize,
    directory: &Path,
) -> Option<Shape> {
    let section = body.table("geometry")?;
    let name = section.text("shape")?;
    let fits = check_model(checker, body, model, name);
    let is_axisymmetric = model == "axisymmetric";
    let length = || section.number("length");
    let radius = || section.number("radius");
    let built = match name {
        "sphere" => {
            let (radius, net) = (radius()?, net(section)?);
            if is_axisymmetric {
                axisymmetric::sphere(radius)
            } else {
                sphere::sphere(radius, net.unwrap_or(SphereNet::for_degree(degree)))
            }
        }
        "rod" => axisymmetric::rod(radius()?, length()?),
        "rod-spherical-end" => {
            let (radius, length) = (radius()?, length()?);
            if length <= radius {
                let message = format!("must be > radius, which is {radius:?} m");
                checker.fault_in(section, "length", message);
                return None;
            }
            axisymmetric::rod_spherical_end(radius, length)
        }
        "cylinder" => solid::cylinder(radius()?, length()?),
        "hollow-cylinder" => {
            let (inner, outer) = (section.number("inner_radius")?, section.number("outer_radius")?);
            if outer <= inner {
                let message = format!("must be > inner_radius, which is {inner:?} m");
                checker.fault_in(section, "outer_radius", message);
                return None;
            }
            let build = if is_axisymmetric { axisymmetric::hollow_cylinder } else { solid::hollow_cylinder };
            build(inner, outer, length()?)
        }
        "box" => solid::cuboid(section.vector("size")?),
        "rectangle" => {
            let [width, height] = section.vector("size")?;
            plane::rectangle(width, height)
        }
        "disc" => plane::disc(radius()?),
        "nurbs" => nurbs(checker, section, model, directory)?,
        _ => return None,
    };
    fits?;
    built.map_err(|error| checker.fault_in(section, "shape", error.to_string())).ok()
}

/// The net of a ball, `Some(None)` if it is left to the program.
fn net(section: &Section) -> Option<Option<SphereNet>> {
    if section.item("net").is_none() {
        return Some(None);
    }
    Some(Some(match section.text("net")? {
        "spindle" => SphereNet::Spindle,
        "shells" => SphereNet::Shells,
        _ => SphereNet::Cube,
    }))
}

fn nurbs(
    checker: &mut Checker,
    section: &Section,
    model: &str,
    directory: &Path,
) -> Option<Result<Shape, SplineError>> {
    let Some(file) = section.item("file") else { return patch(checker, section, model) };
    let path = directory.join(section.text("file")?);
    let source = match read_limited(&path) {
        Ok(text) => Arc::new(SourceText { name: path.display().to_string(), text }),
        Err(reason) => {
            checker.fault_in(section, file.name, format!("{}: {reason}", path.display()));
            return None;
        }
    };
    let table = match parse_net(&source) {
        Ok(node) => node,
        Err(faults) => {
            checker.faults.extend(faults);
            return None;
        }
    };
    let Value::Table(entries) = &table.value else {
        let message = "must hold a table with the keys of a control net".into();
        checker.fault(&Origin::File(source, 0..0), section.path_of("file"), None, message);
        return None;
    };
    let net = checker.section(NURBS_FILE, entries, &section.path, &table.origin, None);
    patch(checker, &net, model)
}

fn parse_net(source: &Arc<SourceText>) -> Result<Node, Vec<Fault>> {
    if source.name.ends_with(".json") { parse_json(source) } else { parse_toml(source) }
}

fn read_limited(path: &Path) -> Result<String, String> {
    let size = std::fs::metadata(path).map_err(|e| format!("cannot be read: {e}"))?.len();
    if size > MAX_FILE {
        return Err(format!("has {size} bytes, at most {MAX_FILE} are read"));
    }
    std::fs::read_to_string(path).map_err(|e| format!("cannot be read: {e}"))
}

fn patch(checker: &mut Checker, section: &Section, model: &str) -> Option<Result<Shape, SplineError>> {
    let directions = dimension(model);
    let mut complete = true;
    for key in ["degrees", "knots", "control_points"] {
        if section.item(key).is_none() {
            let message = "required key is missing for shape \"nurbs\" without \"file\"".into();
            checker.fault(&section.origin, section.path_of(key), None, message);
            complete = false;
        }
    }
    if !complete {
        return None;
    }
    let degrees = per_direction(checker, section, "degrees", directions)?;
    let lists = section.lists("knots")?;
    if lists.len() != directions {
        let message = format!("{} knot vectors, the model has {directions} directions", lists.len());
        checker.fault_in(section, "knots", message);
        return None;
    }
    let (mut knots, mut expected) = (Vec::with_capacity(directions), 1);
    for (i, (&degree, list)) in degrees.iter().zip(lists).enumerate() {
        match KnotVector::new(degree, list.clone()) {
            Ok(vector) => knots.push(vector),
            Err(error) => {
                checker.fault_in(section, "knots", format!("direction {i}: {error}"));
                return None;
            }
        }
        expected *= list.len() - degree - 1;
    }
    let points = section.lists("control_points")?;
    let fits = points.len() == expected && points.iter().all(|p| p.len() == directions);
    if !fits {
        let message = format!(
            "{} control points, degrees and knots ask for {expected} with {directions} coordinates each",
            points.len()
        );
        checker.fault_in(section, "control_points", message);
        return None;
    }
    let weights = match section.item("weights") {
        Some(_) => section.numbers("weights")?.to_vec(),
        None => vec![1.0; expected],
    };
    if weights.len() != expected {
        let message = format!("{} weights, there are {expected} control points", weights.len());
        checker.fault_in(section, "weights", message);
        return None;
    }
    let points = points.iter().map(|p| padded(p)).collect();
    let oriented = |shape: Shape| shape.check_orientation().map(|()| shape);
    let patch = Patch::new(knots, points, weights);
    Some(patch.and_then(|patch| Shape::from_patches(vec![patch])).and_then(oriented))
}
