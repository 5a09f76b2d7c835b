//! Exact shapes: which go with which model, sizes that fit together, patches of one's own.

use iga_core::SplineError;
use iga_core::nurbs::joining::{face_name, join};
use iga_core::nurbs::primitives::gear_tooth::GearTooth;
use iga_core::nurbs::primitives::round::{self, Round};
use iga_core::nurbs::primitives::rounded_box::rounded_box;
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{axisymmetric, plane, profile, solid, sphere};
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

/// The exact shape of a body whose points have the components of `model`; `degree` decides on the
/// net of a ball where none is named.
pub fn shape(checker: &mut Checker, body: &Section, model: &str, degree: usize) -> Option<Shape> {
    let section = body.table("geometry")?;
    let name = section.text("shape")?;
    let fits = check_model(checker, body, model, name);
    let built = match name {
        "nurbs" => {
            let own = nurbs(checker, section, model).filter(|_| fits.is_some())?;
            return cut(checker, body, section, own);
        }
        "plate-with-hole" if is_missing(checker, section, model, "thickness") => return None,
        "gear-tooth" if is_missing(checker, section, model, "width") => return None,
        _ => match model {
            "axisymmetric" => meridian(section, name)?,
            "solid" => solid(section, name, degree)?,
            _ => plane(section, name)?,
        },
    };
    fits?;
    let shape = built.map_err(|error| report(checker, section, &error)).ok()?;
    // Of other shapes nets are turned, or regular where they can be touched.
    if name == "tube-sector" { cut(checker, body, section, shape) } else { Some(shape) }
}

/// Reports the key of solid and spatial rigid bodies of a shape that is plane as well if it is not
/// there.
fn is_missing(checker: &mut Checker, section: &Section, model: &str, key: &str) -> bool {
    let is_missing = model == "solid" && section.item(key).is_none();
    if is_missing {
        let message =
            format!("required key is missing: solid and spatial rigid bodies of this shape have a {key}");
        checker.fault(&section.origin, section.path_of(key), None, message);
    }
    is_missing
}

/// Reports sizes that do not fit together at the key that is to blame.
fn report(checker: &mut Checker, section: &Section, error: &SplineError) {
    match error {
        SplineError::Dimension { name, reason, .. } if section.item(name).is_some() => {
            checker.fault_in(section, name, (*reason).to_owned());
        }
        _ => checker.fault_in(section, "shape", error.to_string()),
    }
}

type Built = Result<Shape, SplineError>;

/// Shapes with points in `(x, y, z)`; `None` where a key is at fault already, or the shape has no
/// such form.
fn solid(section: &Section, name: &str, degree: usize) -> Option<Built> {
    let number = |key: &str| section.number(key);
    if let Some(round) = round(section, name) {
        return Some(round?.solid());
    }
    Some(match name {
        "sphere" => sphere::sphere(number("radius")?, net(section)?.unwrap_or(SphereNet::for_degree(degree))),
        "ellipsoid" => sphere::ellipsoid(section.vector("semi_axes")?),
        "cylinder" => solid::cylinder(number("radius")?, number("length")?),
        "hollow-cylinder" => {
            solid::hollow_cylinder(number("inner_radius")?, number("outer_radius")?, number("length")?)
        }
        "tube-sector" => profile::tube_sector(
            number("inner_radius")?,
            number("outer_radius")?,
            number("length")?,
            number("angle")?,
        ),
        "torus" => round::torus(number("radius")?, number("tube_radius")?),
        "box" => solid::cuboid(section.vector("size")?),
        "rounded-box" => rounded_box(section.vector("size")?, number("fillet_radius")?),
        "plate-with-hole" => profile::solid_plate_with_hole(
            section.vector("size")?,
            number("hole_radius")?,
            number("thickness")?,
        ),
        "gear-tooth" => gear_tooth(section)?.solid(number("width")?),
        "l-beam" => {
            profile::l_beam(number("width")?, number("height")?, number("thickness")?, number("length")?)
        }
        "t-beam" => profile::t_beam(
            number("width")?,
            number("height")?,
            number("flange_thickness")?,
            number("web_thickness")?,
            number("length")?,
        ),
        _ => return None,
    })
}

/// Meridian halves of shapes, in `(r, z)`.
fn meridian(section: &Section, name: &str) -> Option<Built> {
    let number = |key: &str| section.number(key);
    if let Some(round) = round(section, name) {
        return Some(round?.axisymmetric());
    }
    Some(match name {
        "sphere" => {
            net(section)?; // reports a wrong value
            axisymmetric::sphere(number("radius")?)
        }
        "ellipsoid" => spheroid(section.vector("semi_axes")?),
        "rod" | "cylinder" => axisymmetric::rod(number("radius")?, number("length")?),
        "rod-spherical-end" => axisymmetric::rod_spherical_end(number("radius")?, number("length")?),
        "hollow-cylinder" => {
            axisymmetric::hollow_cylinder(number("inner_radius")?, number("outer_radius")?, number("length")?)
        }
        "torus" => round::axisymmetric_torus(number("radius")?, number("tube_radius")?),
        _ => return None,
    })
}

/// Meridian half of an ellipsoid, which is one of revolution about z.
#[expect(clippy::float_cmp, reason = "two numbers of the scenario, written alike")]
fn spheroid([x, y, z]: [f64; 3]) -> Built {
    if x == y {
        return axisymmetric::spheroid(x, z);
    }
    let reason = "the first two must be equal for a body that is axisymmetric about z";
    Err(SplineError::Dimension { name: "semi_axes", value: y, reason })
}

/// Plane shapes, in `(x, y)`.
fn plane(section: &Section, name: &str) -> Option<Built> {
    Some(match name {
        "rectangle" => {
            let [width, height] = section.vector("size")?;
            plane::rectangle(width, height)
        }
        "disc" => plane::disc(section.number("radius")?),
        "plate-with-hole" => {
            profile::plate_with_hole(section.vector("size")?, section.number("hole_radius")?)
        }
        "gear-tooth" => gear_tooth(section)?.plane(),
        _ => return None,
    })
}

/// A tooth, `None` where a key is at fault.
fn gear_tooth(section: &Section) -> Option<GearTooth> {
    let module = section.number("module")?;
    let given = |key: &str, otherwise: f64| match section.item(key) {
        Some(_) => section.number(key),
        None => Some(otherwise),
    };
    Some(GearTooth {
        module,
        teeth: section.integer("teeth")?,
        pressure_angle: given("pressure_angle", 20f64.to_radians())?,
        addendum: given("addendum", module)?,
        dedendum: given("dedendum", 1.25 * module)?,
        inner_radius: section.number("inner_radius")?,
    })
}

/// The shape called `name` if it is one of those that are solid or axisymmetric alike, `Some(None)`
/// where a key is at fault.
fn round(section: &Section, name: &str) -> Option<Option<Round>> {
    let radius = || Some((section.number("radius")?, section.number("length")?));
    // A key that is not given, or `Some(None)` for one at fault.
    let given = |key: &str| section.item(key).map(|_| section.number(key));
    match name {
        "cone" => {
            Some(
                radius()
                    .zip(section.number("end_radius"))
                    .map(|((radius, length), end_radius)| Round::Cone { radius, end_radius, length }),
            )
        }
        "capsule" => Some(radius().map(|(radius, length)| Round::Capsule { radius, length })),
        "rounded-cylinder" => Some(radius().and_then(|(radius, length)| {
            let crown_radius = given("crown_radius").map_or(Some(None), |value| value.map(Some))?;
            let fillet_radius = given("fillet_radius").map_or(Some(None), |value| value.map(Some))?;
            Some(Round::RoundedCylinder { radius, length, crown_radius, fillet_radius })
        })),
        _ => None,
    }
}

/// The net of a ball, `Some(None)` if it is left to the program.
fn net(section: &Section) -> Option<Option<SphereNet>> {
    if section.item("net").is_none() {
        return Some(None);
    }
    Some(Some(section.choice("net")?))
}

/// The shape with its patches cut along lines of lower continuity, which are faces between patches
/// then; not where the scenario divides the one patch by its own parameters.
fn cut(checker: &mut Checker, body: &Section, section: &Section, own: Shape) -> Option<Shape> {
    let mesh = body.table("discretisation");
    if mesh.is_some_and(|mesh| ["knots", "refine"].iter().any(|key| mesh.given(key))) {
        return Some(own);
    }
    own.cut().map_err(|error| report(checker, section, &error)).ok()
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
        // Names are in the sense of the file, patches that were turned have theirs kept; faces
        // between patches are none of the surface.
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
