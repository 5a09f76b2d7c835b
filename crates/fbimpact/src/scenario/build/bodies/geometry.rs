//! Exact shapes: which go with which model, sizes that fit together, patches of one's own.

use iga_core::SplineError;
use iga_core::nurbs::joining::{face_name, join};
use iga_core::nurbs::primitives::gear_tooth::GearTooth;
use iga_core::nurbs::primitives::round::{self, Round};
use iga_core::nurbs::primitives::rounded_box::rounded_box;
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{axisymmetric, plane, profile, solid, sphere};
use iga_core::nurbs::{FaceId, Shape};

use crate::scenario::check::Checker;
use crate::scenario::files::spline_nets;
use crate::scenario::keys::{Named, names};
use crate::scenario::section::{AtFault, Section};
use crate::scenario::tables::{BodyModel, ShapeName};

/// Reports a shape that does not go with the model.
fn check_model(checker: &mut Checker, body: &Section, model: BodyModel, shape: ShapeName) -> Option<()> {
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
    checker.fault_in(body.table("geometry")?, "shape", message);
    None
}

/// The exact shape of a body whose points have the components of `model`; `degree` decides on the
/// net of a ball where none is named.
pub fn shape(checker: &mut Checker, body: &Section, model: BodyModel, degree: usize) -> Option<Shape> {
    let section = body.table("geometry")?;
    let name = section.choice("shape")?;
    let fits = check_model(checker, body, model, name);
    if name == ShapeName::Nurbs {
        let own = nurbs(checker, section, model).filter(|_| fits.is_some())?;
        return cut(checker, body, section, own);
    }
    if name == ShapeName::PlateWithHole && is_missing(checker, section, model, "thickness")
        || name == ShapeName::GearTooth && is_missing(checker, section, model, "width")
    {
        return None;
    }
    let built = match model {
        BodyModel::Solid => solid(section, name, degree)?,
        BodyModel::Axisymmetric => meridian(section, name)?,
        BodyModel::PlaneStrain | BodyModel::PlaneStress => plane(section, name)?,
        BodyModel::Imported | BodyModel::Mesh | BodyModel::Rigid => return None,
    };
    fits?;
    let shape = built.map_err(|error| report(checker, section, &error)).ok()?;
    // Of other shapes nets are turned, or regular where they can be touched.
    if name == ShapeName::TubeSector { cut(checker, body, section, shape) } else { Some(shape) }
}

/// Reports the key of solid and spatial rigid bodies of a shape that is plane as well if it is not
/// there.
fn is_missing(checker: &mut Checker, section: &Section, model: BodyModel, key: &str) -> bool {
    let is_missing = model == BodyModel::Solid && section.item(key).is_none();
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
fn solid(section: &Section, name: ShapeName, degree: usize) -> Option<Built> {
    let number = |key: &str| section.number(key);
    Some(match name {
        ShapeName::Sphere => {
            sphere::sphere(number("radius")?, net(section).ok()?.unwrap_or(SphereNet::for_degree(degree)))
        }
        ShapeName::Ellipsoid => sphere::ellipsoid(section.vector("semi_axes")?),
        ShapeName::Cylinder => solid::cylinder(number("radius")?, number("length")?),
        ShapeName::HollowCylinder => {
            solid::hollow_cylinder(number("inner_radius")?, number("outer_radius")?, number("length")?)
        }
        ShapeName::TubeSector => profile::tube_sector(
            number("inner_radius")?,
            number("outer_radius")?,
            number("length")?,
            number("angle")?,
        ),
        ShapeName::Torus => round::torus(number("radius")?, number("tube_radius")?),
        ShapeName::Box => solid::cuboid(section.vector("size")?),
        ShapeName::RoundedBox => rounded_box(section.vector("size")?, number("fillet_radius")?),
        ShapeName::PlateWithHole => profile::solid_plate_with_hole(
            section.vector("size")?,
            number("hole_radius")?,
            number("thickness")?,
        ),
        ShapeName::GearTooth => gear_tooth(section)?.solid(number("width")?),
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
        ShapeName::Cone => cone(section)?.solid(),
        ShapeName::Capsule => capsule(section)?.solid(),
        ShapeName::RoundedCylinder => rounded_cylinder(section)?.solid(),
        ShapeName::Rod
        | ShapeName::RodSphericalEnd
        | ShapeName::Rectangle
        | ShapeName::Disc
        | ShapeName::Nurbs
        | ShapeName::Plane => return None,
    })
}

/// Meridian halves of shapes, in `(r, z)`.
fn meridian(section: &Section, name: ShapeName) -> Option<Built> {
    let number = |key: &str| section.number(key);
    Some(match name {
        ShapeName::Sphere => {
            net(section).ok()?; // a wrong value is at fault all the same
            axisymmetric::sphere(number("radius")?)
        }
        ShapeName::Ellipsoid => spheroid(section.vector("semi_axes")?),
        ShapeName::Rod | ShapeName::Cylinder => axisymmetric::rod(number("radius")?, number("length")?),
        ShapeName::RodSphericalEnd => axisymmetric::rod_spherical_end(number("radius")?, number("length")?),
        ShapeName::HollowCylinder => {
            axisymmetric::hollow_cylinder(number("inner_radius")?, number("outer_radius")?, number("length")?)
        }
        ShapeName::Torus => round::axisymmetric_torus(number("radius")?, number("tube_radius")?),
        ShapeName::Cone => cone(section)?.axisymmetric(),
        ShapeName::Capsule => capsule(section)?.axisymmetric(),
        ShapeName::RoundedCylinder => rounded_cylinder(section)?.axisymmetric(),
        ShapeName::TubeSector
        | ShapeName::RoundedBox
        | ShapeName::PlateWithHole
        | ShapeName::LBeam
        | ShapeName::TBeam
        | ShapeName::GearTooth
        | ShapeName::Box
        | ShapeName::Rectangle
        | ShapeName::Disc
        | ShapeName::Nurbs
        | ShapeName::Plane => return None,
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
fn plane(section: &Section, name: ShapeName) -> Option<Built> {
    Some(match name {
        ShapeName::Rectangle => {
            let [width, height] = section.vector("size")?;
            plane::rectangle(width, height)
        }
        ShapeName::Disc => plane::disc(section.number("radius")?),
        ShapeName::PlateWithHole => {
            profile::plate_with_hole(section.vector("size")?, section.number("hole_radius")?)
        }
        ShapeName::GearTooth => gear_tooth(section)?.plane(),
        ShapeName::Sphere
        | ShapeName::Ellipsoid
        | ShapeName::Rod
        | ShapeName::RodSphericalEnd
        | ShapeName::Cylinder
        | ShapeName::HollowCylinder
        | ShapeName::TubeSector
        | ShapeName::Cone
        | ShapeName::Capsule
        | ShapeName::RoundedCylinder
        | ShapeName::Torus
        | ShapeName::RoundedBox
        | ShapeName::LBeam
        | ShapeName::TBeam
        | ShapeName::Box
        | ShapeName::Nurbs
        | ShapeName::Plane => return None,
    })
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

/// The net of a ball; none if it is left to the program.
fn net(section: &Section) -> Result<Option<SphereNet>, AtFault> {
    section.optional("net", Section::choice)
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
fn nurbs(checker: &mut Checker, section: &Section, model: BodyModel) -> Option<Shape> {
    let (given, key) = match section.item("file") {
        Some(_) => (section.spline_file()?.given.clone(), "file"),
        None => {
            let key = if section.item("patches").is_some() { "patches" } else { "control_points" };
            (spline_nets::patches(checker, section, model.dimension())?, key)
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
