//! What bodies of several kinds have: frame, damping, model of a shape, material.

use adaptive::spec::{DampingSpec, FrameSpec};
use contact_qs::law::Solid;
use iga_core::elasticity::{Material, Model};

use crate::scenario::body_places::{BodyPlaces, GivenPlace};
use crate::scenario::build::joints::inboard_joint;
use crate::scenario::build::places::{BodyFacts, one_of};
use crate::scenario::changes::standard_materials::STANDARD_MATERIALS;
use crate::scenario::section::{AtFault, Section};
use crate::scenario::tables::{BodyModel, FrameKind};

/// The reference frame that a body shall have.
#[derive(Debug, Clone, PartialEq)]
pub enum GivenFrame {
    /// Mean-axis frame.
    Buckens,
    /// The frame that follows the body at a place.
    Tangent(GivenPlace),
    /// The frame that follows the body where the joint holds it whose child it is.
    AtJoint,
}

/// The reference frame; a tangent one follows the place where its joint holds the body unless
/// another is given.
///
/// `name` is that of the body.
pub fn frame(root: &Section, section: &Section, name: &str) -> Option<GivenFrame> {
    let inboard_joint = inboard_joint(root, name);
    if section.choice::<FrameKind>("frame")? == FrameKind::Buckens {
        return Some(GivenFrame::Buckens);
    }
    let facts = BodyFacts::of(section)?;
    if let Some(at) = one_of(section, ["frame_marker", "frame_point"], &facts).ok()? {
        return Some(GivenFrame::Tangent(at));
    }
    if inboard_joint.is_some() {
        return Some(GivenFrame::AtJoint);
    }
    let message = "required key is missing: the tangent frame of a body without joint needs \"frame_marker\" \
                   or \"frame_point\"";
    section.refuse("frame_marker", message)
}

impl GivenFrame {
    /// The frame with its place on a body with `places`; that of a joint stands in until joints are
    /// known.
    pub fn on_body(self, section: &Section, places: &BodyPlaces) -> Option<FrameSpec> {
        match self {
            Self::Buckens | Self::AtJoint => Some(FrameSpec::Buckens),
            Self::Tangent(at) => {
                let place = places.held(&at).map_err(|e| section.fault("frame", e.to_string()));
                Some(FrameSpec::Tangent(place.ok()?))
            }
        }
    }
}

/// Damping of the elastic coordinates.
pub fn damping(section: &Section) -> Option<DampingSpec> {
    if section.item("damping").is_none() {
        return Some(DampingSpec::None);
    }
    let table = section.table("damping")?;
    if table.item("modal").is_some() {
        return Some(DampingSpec::Modal(table.numbers("modal")?.to_vec()));
    }
    if table.item("loss_factor").is_some() {
        return Some(DampingSpec::Structural(table.number("loss_factor")?));
    }
    table.require("frequencies", "\"modal\", \"frequencies\" or \"loss_factor\"")?;
    let frequencies = table.vector::<2>("frequencies")?;
    Some(DampingSpec::Rayleigh { frequencies, ratio: table.number("ratio")? })
}

/// What the components of a shape's points mean, with the thickness of a plane model; none of
/// models that are not those of a shape.
pub fn elastic_model(section: &Section, model: BodyModel) -> Option<Model> {
    let thickness = section.number("thickness")?;
    Some(match model {
        BodyModel::Solid => Model::Solid,
        BodyModel::Axisymmetric => Model::Axisymmetric,
        BodyModel::PlaneStrain => Model::PlaneStrain { thickness },
        BodyModel::PlaneStress => Model::PlaneStress { thickness },
        BodyModel::Imported | BodyModel::Mesh | BodyModel::Rigid => return None,
    })
}

/// The material of a body that needs one.
pub fn material(root: &Section, section: &Section) -> Option<Material> {
    section.require("material", "the name of a material")?;
    named_material(root, section)
}

/// The material of a body; none if it names none.
///
/// # Errors
/// [`AtFault`].
pub fn optional_material(root: &Section, section: &Section) -> Result<Option<Material>, AtFault> {
    section.optional("material", |section, _| named_material(root, section))
}

/// The material that a body names.
fn named_material(root: &Section, section: &Section) -> Option<Material> {
    let list = root.named("materials");
    let name = section.text("material")?;
    if root.place_of("materials", name).is_none() {
        let own = list.iter().map(|(n, _)| n.as_str());
        let known: Vec<&str> = own.chain(STANDARD_MATERIALS.iter().map(|m| m.name)).collect();
        section.unknown_name("material", "material", &known);
        return None;
    }
    let [young, poisson, density] = constants(root, section)?;
    let strength = yield_strength(root, section);
    let material = Material::new(young, poisson, density);
    let material = material.and_then(|material| material.with_yield_strength(strength));
    material.map_err(|error| section.fault("material", error.to_string())).ok()
}

/// The elastic constants of a body's material; none if it names none, or one at fault.
pub fn solid(root: &Section, section: &Section) -> Option<Solid> {
    let [young, poisson, _] = constants(root, section)?;
    Some(Solid { young, poisson })
}

/// Yield strength of a body's material; infinite if none is given \[Pa\].
pub fn yield_strength(root: &Section, section: &Section) -> f64 {
    let material = section.text("material").and_then(|name| root.one_of("materials", name));
    let given = material.filter(|material| material.item("yield_strength").is_some());
    given.and_then(|material| material.number("yield_strength")).unwrap_or(f64::INFINITY)
}

/// Young's modulus \[Pa\], Poisson's ratio and density [kg/m³] of a body's material.
fn constants(root: &Section, section: &Section) -> Option<[f64; 3]> {
    let name = section.text("material")?;
    let material = root.one_of("materials", name)?;
    let [young, poisson, density] =
        ["youngs_modulus", "poissons_ratio", "density"].map(|k| material.number(k));
    Some([young?, poisson?, density?])
}

/// Whether inertia forces stiffen a body whose frame is `frame`.
pub fn stiffening(section: &Section, frame: Option<&GivenFrame>) -> Option<bool> {
    let is_stiffened = section.boolean("geometric_stiffening")?;
    if is_stiffened && frame == Some(&GivenFrame::Buckens) {
        section.fault("geometric_stiffening", "needs frame = \"tangent\"");
    }
    if is_stiffened && section.choice("model") == Some(BodyModel::Axisymmetric) {
        let message = "has no meaning for model \"axisymmetric\", which does not turn";
        section.fault("geometric_stiffening", message);
    }
    Some(is_stiffened)
}
