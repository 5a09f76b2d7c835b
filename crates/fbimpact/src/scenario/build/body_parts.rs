//! What bodies of several kinds have: frame, damping, model of a shape, material.

use std::path::Path;

use super::super::check::Checker;
use super::super::model::{Damping, ElasticModel, Frame, Joint, Material};
use super::super::section::Section;
use super::joints::hanging_joint;
use super::places::{BodyFacts, one_of};

/// Thickness of a plane model when none is given \[m\].
const UNIT_THICKNESS: f64 = 1.0;

/// What bodies refer to.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// The whole scenario.
    pub root: &'a Section,
    /// Its joints, as far as they are valid.
    pub joints: &'a [Joint],
    /// Where files are sought.
    pub directory: &'a Path,
}

/// The reference frame; a tangent one follows the place where the body hangs unless another is given.
///
/// `name` is that of the body.
pub fn frame(checker: &mut Checker, context: Context<'_>, section: &Section, name: &str) -> Option<Frame> {
    let hangs_on = hanging_joint(context.root, name);
    let keys = ["frame_marker", "frame_point"];
    if section.text("frame")? == "buckens" {
        for key in keys.into_iter().filter(|key| section.given(key)) {
            checker.fault_in(section, key, "has a meaning for frame = \"tangent\" only".into());
        }
        return Some(Frame::Buckens);
    }
    let facts = BodyFacts::of(section)?;
    if let Some(at) = one_of(checker, section, keys, &facts)? {
        return Some(Frame::Tangent(at));
    }
    if let Some(joint) = context.joints.iter().find(|j| Some(j.name.as_str()) == hangs_on) {
        return Some(Frame::Tangent(joint.child.at.clone()));
    }
    if hangs_on.is_none() {
        let message = "required key is missing: the tangent frame of a body without joint needs \"frame_marker\" \
                       or \"frame_point\"";
        checker.fault(&section.origin, section.path_of("frame_marker"), None, message.into());
    }
    None
}

/// Damping, `Some(None)` if there is none.
pub fn damping(checker: &mut Checker, section: &Section) -> Option<Option<Damping>> {
    if section.item("damping").is_none() {
        return Some(None);
    }
    let table = section.table("damping")?;
    if table.item("modal").is_some() {
        for key in ["frequencies", "ratio"].into_iter().filter(|key| table.given(key)) {
            checker.fault_in(table, key, "either \"modal\" or \"frequencies\" can be given, not both".into());
        }
        return Some(Some(Damping::Modal(table.numbers("modal")?.to_vec())));
    }
    if table.item("frequencies").is_none() {
        let message = "required key is missing: either \"frequencies\" or \"modal\"".into();
        checker.fault(&table.origin, table.path_of("frequencies"), None, message);
        return None;
    }
    let frequencies = table.vector::<2>("frequencies")?;
    Some(Some(Damping::Rayleigh { frequencies, ratio: table.number("ratio")? }))
}

/// What the components of a shape's points mean, with the thickness of a plane model.
pub fn elastic_model(checker: &mut Checker, section: &Section, model: &str) -> Option<ElasticModel> {
    let plane = matches!(model, "plane-strain" | "plane-stress");
    if section.given("thickness") && !plane {
        let message =
            format!("has a meaning for \"plane-strain\" and \"plane-stress\" only, the model is \"{model}\"");
        checker.fault_in(section, "thickness", message);
        return None;
    }
    let thickness = match section.item("thickness") {
        Some(_) => section.number("thickness")?,
        None => UNIT_THICKNESS,
    };
    Some(match model {
        "axisymmetric" => ElasticModel::Axisymmetric,
        "plane-strain" => ElasticModel::PlaneStrain { thickness },
        "plane-stress" => ElasticModel::PlaneStress { thickness },
        _ => ElasticModel::Solid,
    })
}

/// The material of a body that needs one.
pub fn material(checker: &mut Checker, root: &Section, section: &Section) -> Option<Material> {
    if section.item("material").is_none() {
        let message = "required key is missing: the name of a material".into();
        checker.fault(&section.origin, section.path_of("material"), None, message);
        return None;
    }
    optional_material(checker, root, section)?
}

/// The material of a body, `Some(None)` if it names none.
pub fn optional_material(
    checker: &mut Checker,
    root: &Section,
    section: &Section,
) -> Option<Option<Material>> {
    if section.item("material").is_none() {
        return Some(None);
    }
    let list = root.named("materials");
    let name = section.text("material")?;
    let Some((_, material)) = list.iter().find(|(n, _)| n == name) else {
        let known: Vec<&str> = list.iter().map(|(n, _)| n.as_str()).collect();
        checker.unknown_name(section, "material", "material", &known);
        return None;
    };
    Some(Some(Material {
        name: name.to_owned(),
        youngs_modulus: material.number("youngs_modulus")?,
        poissons_ratio: material.number("poissons_ratio")?,
        density: material.number("density")?,
    }))
}
