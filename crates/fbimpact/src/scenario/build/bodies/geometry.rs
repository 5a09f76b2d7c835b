//! Exact shapes: which go with which model, sizes that fit together, patches of one's own.

use iga_core::SplineError;
use iga_core::nurbs::joining::{face_name, join};
use iga_core::nurbs::primitives::gear_tooth::GearTooth;
use iga_core::nurbs::primitives::round::{self, Round};
use iga_core::nurbs::primitives::rounded_box::rounded_box;
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{axisymmetric, plane, profile, solid, sphere};
use iga_core::nurbs::{FaceId, Shape};

use crate::scenario::files::spline_nets;
use crate::scenario::keys::{Named, names};
use crate::scenario::section::Section;
use crate::scenario::tables::{BodyModel, ShapeName};

/// Reports a shape that does not go with the model.
fn check_model(body: &Section, model: BodyModel, shape: ShapeName) -> Option<()> {
    if shape.fits(model) {
        return Some(());
    }
    let fitting = names(ShapeName::VALUES.iter().filter(|s| s.fits(model)).map(|s| s.name()));
    let models = names(shape.models().iter().map(|m| m.model.name()));
    let message = match body.text("motion") {
        Some(motion) if body.choice("model") == Some(BodyModel::Rigid) => {
            format!("does not go with motion \"{motion}\" of a rigid body: choose {fitting}")
        }
        _ => format!("does not go with model \"{}\": choose {fitting}, or model {models}", model.name()),
    };
    body.table("geometry")?.fault("shape", message);
    None
}

/// The exact shape of a body whose points have the components of `model`; `degree` decides on the
/// net of a ball where none is named.
pub fn shape(body: &Section, model: BodyModel, degree: usize) -> Option<Shape> {
    let section = body.table("geometry")?;
    let name = section.choice("shape")?;
    let fits = check_model(body, model, name);
    if name == ShapeName::Nurbs {
        let own = nurbs(section, model).filter(|_| fits.is_some())?;
        return cut(body, section, own);
    }
    if name == ShapeName::PlateWithHole && is_missing(section, model, "thickness")
        || name == ShapeName::GearTooth && is_missing(section, model, "width")
    {
        return None;
    }
    let built = form(section, name, model, degree)?;
    let shape = built.map_err(|error| report(section, &error)).ok()?;
    // Of other shapes nets are turned, or regular where they can be touched.
    if name == ShapeName::TubeSector { cut(body, section, shape) } else { Some(shape) }
}

/// Reports the key of solid and spatial rigid bodies of a shape that is plane as well if it is not
/// there.
fn is_missing(section: &Section, model: BodyModel, key: &str) -> bool {
    let is_missing = model == BodyModel::Solid && section.item(key).is_none();
    if is_missing {
        let message =
            format!("required key is missing: solid and spatial rigid bodies of this shape have a {key}");
        section.fault(key, message);
    }
    is_missing
}

/// Reports sizes that do not fit together at the key that is to blame.
fn report(section: &Section, error: &SplineError) {
    match error {
        SplineError::Dimension { name, reason, .. } if section.item(name).is_some() => {
            section.fault(name, (*reason).to_owned());
        }
        _ => section.fault("shape", error.to_string()),
    }
}

type Built = Result<Shape, SplineError>;

/// The shape in the components of `model`: a solid, half a meridian in `(r, z)` or plane; `None`
/// where a key is at fault already, or [`ShapeName::fits`] says that it has no such form.
fn form(section: &Section, name: ShapeName, model: BodyModel, degree: usize) -> Option<Built> {
    let number = |key: &str| section.number(key);
    let is_solid = model == BodyModel::Solid;
    if !name.fits(model) {
        return None;
    }
    Some(match name {
        ShapeName::Sphere => {
            let net = section.optional("net", Section::choice).ok()?; // wrong in any form
            if is_solid {
                sphere::sphere(number("radius")?, net.unwrap_or(SphereNet::for_degree(degree)))
            } else {
                axisymmetric::sphere(number("radius")?)
            }
        }
        ShapeName::Ellipsoid if is_solid => sphere::ellipsoid(section.vector("semi_axes")?),
        ShapeName::Ellipsoid => spheroid(section.vector("semi_axes")?),
        ShapeName::Cylinder if is_solid => solid::cylinder(number("radius")?, number("length")?),
        ShapeName::Rod | ShapeName::Cylinder => axisymmetric::rod(number("radius")?, number("length")?),
        ShapeName::RodSphericalEnd => axisymmetric::rod_spherical_end(number("radius")?, number("length")?),
        ShapeName::HollowCylinder => {
            let hollow = if is_solid { solid::hollow_cylinder } else { axisymmetric::hollow_cylinder };
            hollow(number("inner_radius")?, number("outer_radius")?, number("length")?)
        }
        ShapeName::TubeSector => profile::tube_sector(
            number("inner_radius")?,
            number("outer_radius")?,
            number("length")?,
            number("angle")?,
        ),
        ShapeName::Torus => {
            let torus = if is_solid { round::torus } else { round::axisymmetric_torus };
            torus(number("radius")?, number("tube_radius")?)
        }
        ShapeName::Cone => revolved(&cone(section)?, is_solid),
        ShapeName::Capsule => revolved(&capsule(section)?, is_solid),
        ShapeName::RoundedCylinder => revolved(&rounded_cylinder(section)?, is_solid),
        ShapeName::Box => solid::cuboid(section.vector("size")?),
        ShapeName::RoundedBox => rounded_box(section.vector("size")?, number("fillet_radius")?),
        ShapeName::Rectangle => {
            let [width, height] = section.vector("size")?;
            plane::rectangle(width, height)
        }
        ShapeName::Disc => plane::disc(number("radius")?),
        ShapeName::PlateWithHole => {
            let (size, hole) = (section.vector("size")?, number("hole_radius")?);
            if is_solid {
                profile::solid_plate_with_hole(size, hole, number("thickness")?)
            } else {
                profile::plate_with_hole(size, hole)
            }
        }
        ShapeName::GearTooth if is_solid => gear_tooth(section)?.solid(number("width")?),
        ShapeName::GearTooth => gear_tooth(section)?.plane(),
        ShapeName::LBeam => {
            profile::l_beam(number("width")?, number("height")?, number("thickness")?, number("length")?)
        }
        ShapeName::TBeam => profile::t_beam(
            number("width")?,
            number("height")?,
            number("flange_thickness")?,
            number("web_thickness")?,
            number("length")?,
        ),
        // Nets are of any model and are read elsewhere; planes are of rigid bodies alone.
        ShapeName::Nurbs | ShapeName::Plane => return None,
    })
}

/// A body of revolution, as a solid or as half its meridian.
fn revolved(round: &Round, is_solid: bool) -> Built {
    if is_solid { round.solid() } else { round.axisymmetric() }
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

/// A tooth, `None` where a key is at fault.
fn gear_tooth(section: &Section) -> Option<GearTooth> {
    let module = section.number("module")?;
    let given = |key: &str, otherwise: f64| {
        section.optional(key, Section::number).ok().map(|given| given.unwrap_or(otherwise))
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

/// A truncated cone; like other bodies of revolution `None` where a key is at fault.
fn cone(section: &Section) -> Option<Round> {
    Some(Round::Cone {
        radius: section.number("radius")?,
        end_radius: section.number("end_radius")?,
        length: section.number("length")?,
    })
}

fn capsule(section: &Section) -> Option<Round> {
    Some(Round::Capsule { radius: section.number("radius")?, length: section.number("length")? })
}

fn rounded_cylinder(section: &Section) -> Option<Round> {
    let given = |key: &str| section.optional(key, Section::number).ok();
    Some(Round::RoundedCylinder {
        radius: section.number("radius")?,
        length: section.number("length")?,
        crown_radius: given("crown_radius")?,
        fillet_radius: given("fillet_radius")?,
    })
}

/// The shape with its patches cut along lines of lower continuity, which are faces between patches
/// then; not where the scenario divides the one patch by its own parameters.
fn cut(body: &Section, section: &Section, own: Shape) -> Option<Shape> {
    let mesh = body.table("discretisation");
    if mesh.is_some_and(|mesh| ["knots", "refine"].iter().any(|key| mesh.given(key))) {
        return Some(own);
    }
    own.cut().map_err(|error| report(section, &error)).ok()
}

/// The shape of patches of one's own, which joined are a body.
fn nurbs(section: &Section, model: BodyModel) -> Option<Shape> {
    let (given, key) = match section.item("file") {
        Some(_) => (section.spline_file()?.given.clone(), "file"),
        None => {
            let key = if section.item("patches").is_some() { "patches" } else { "control_points" };
            (spline_nets::patches(section, model.dimension())?, key)
        }
    };
    let joined = join(&given.patches, &given.joined);
    let joined = joined.map_err(|fault| section.fault(key, fault.to_string())).ok()?;
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
        section.fault("faces", message);
    }
    shape.faces.extend(added);
    Some(shape)
}
