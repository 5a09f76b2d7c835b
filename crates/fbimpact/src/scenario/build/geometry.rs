//! Exact shapes: which go with which model, sizes that fit together, patches of one's own.

use iga_core::nurbs::joining::{face_name, join};
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{axisymmetric, plane, solid, sphere};
use iga_core::nurbs::{FaceId, Shape};

use super::super::check::Checker;
use super::super::keys::names;
use super::super::section::Section;
use super::super::spline_nets;
use super::super::tables::{SHAPES, ShapeFacts};
use super::places::dimension;

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
pub fn shape(checker: &mut Checker, body: &Section, model: &str, degree: usize) -> Option<Shape> {
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
        "ellipsoid" => sphere::ellipsoid(section.vector("semi_axes")?),
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
        "nurbs" => return nurbs(checker, section, model).filter(|_| fits.is_some()),
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

/// The shape of patches of one's own, which joined are a body.
fn nurbs(checker: &mut Checker, section: &Section, model: &str) -> Option<Shape> {
    let (given, key) = match section.item("file") {
        Some(_) => (section.spline_file()?.given.clone(), "file"),
        None => {
            let key = if section.item("patches").is_some() { "patches" } else { "control_points" };
            (spline_nets::patches(checker, section, dimension(model))?, key)
        }
    };
    let joined = join(&given.patches, &given.joined);
    let joined = joined.map_err(|fault| checker.fault_in(section, key, fault.to_string())).ok()?;
    for note in joined.notes {
        tracing::info!("{}: {note}", section.path);
    }
    let mut shape = joined.shape;
    for (name, faces) in &given.faces {
        // Names are in the sense of the file, patches that were turned have theirs kept; faces between patches are none of the surface.
        let outer = faces.iter().filter_map(|id| shape.faces.get(&face_name(*id, given.patches.len())));
        let ids: Vec<FaceId> = outer.flatten().copied().collect();
        if !ids.is_empty() {
            shape.faces.insert(name.clone(), ids);
        }
    }
    let mut added = Vec::new();
    for (name, parts) in section.name_lists("faces") {
        let unknown = parts.iter().find(|part| !shape.faces.contains_key(*part));
        let message = if shape.faces.contains_key(name) {
            format!("the shape has a face \"{name}\" already, choose another name")
        } else if let Some(part) = unknown {
            let known = names(shape.faces.keys().map(String::as_str));
            format!("\"{name}\" is made from \"{part}\", which is no outer face: choose {known}")
        } else {
            let mut ids: Vec<FaceId> = parts.iter().flat_map(|part| &shape.faces[part]).copied().collect();
            ids.sort_unstable();
            ids.dedup();
            added.push((name.clone(), ids));
            continue;
        };
        checker.fault_in(section, "faces", message);
    }
    shape.faces.extend(added);
    Some(shape)
}
