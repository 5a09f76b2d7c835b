//! Bodies of finite elements.

use std::sync::Arc;

use adaptive::body::mesh::n_elastic_modes;
use adaptive::sizing::SizeRequest;
use adaptive::spec::{BodyKind, ByGroup, FlexibleSpec, MeshedSpec};
use fe_mesh::Mesh;
use iga_core::elasticity::Material;

use super::discretisation::{Basis, reduction};
use super::parts::{GivenFrame, damping, frame, optional_material, stiffening};
use crate::scenario::body_places::{BodyPlaces, GivenPlace};
use crate::scenario::build::built_bodies::MovingFacts;
use crate::scenario::section::Section;
use crate::scenario::types::FileOfBody;

/// A body of finite elements, called `name`, with `markers` added by the user.
pub fn meshed(
    root: &Section,
    section: &Section,
    name: &str,
    markers: Option<&[(String, GivenPlace)]>,
) -> Option<(BodyKind, MovingFacts)> {
    if section.item("units").is_none() {
        let message = "required key is missing: the unit of length of the mesh, which its file does not say";
        section.fault("units", message);
    }
    let frame = frame(root, section, name);
    let damping = damping(section);
    let geometric_stiffening = stiffening(section, frame.as_ref());
    let basis = section.table("reduction").and_then(reduction);
    let source = section.mesh_file()?;
    let mesh = Arc::clone(&source.mesh);
    let materials = materials(root, section, &mesh);
    let basis = basis.inspect(|basis| check_modes(section, basis, &mesh));
    let places = BodyPlaces::meshed(Arc::clone(&mesh), markers?);
    let places = places.map_err(|e| section.fault("markers", e.to_string())).ok()?;
    let follows_joint = frame == Some(GivenFrame::AtJoint);
    let frame = frame?.on_body(section, &places)?;
    section.item("units")?;
    let (material, groups) = materials?;
    let Basis { spec: reduction, static_answers, wants_modes } = basis?;
    let mass_rule = section.choice("mass_points")?;
    let flexible = FlexibleSpec {
        static_answers,
        damping: damping?,
        frame,
        geometric_stiffening: geometric_stiffening?,
        ..FlexibleSpec::new(reduction)
    };
    let spec = MeshedSpec { mesh, material, groups, mass_rule, flexible };
    let unit = source.units.length();
    let file = FileOfBody { path: source.path.clone(), sha256: source.sha256.clone(), unit };
    let wish = SizeRequest { elements: false, modes: wants_modes };
    Some((BodyKind::Meshed(Box::new(spec)), MovingFacts { places, wish, file: Some(file), follows_joint }))
}

/// The material of all elements and those of groups; every element has one.
fn materials(root: &Section, section: &Section, mesh: &Mesh) -> Option<(Option<Material>, ByGroup)> {
    let own = optional_material(root, section);
    let list = section.named("groups");
    let mut groups: ByGroup = Vec::with_capacity(list.len());
    for (name, group) in list {
        if let Err(fault) = mesh.volume_group(name) {
            group.fault_here(fault.to_string());
            continue;
        }
        let material = optional_material(root, group).ok().flatten();
        groups.extend(material.map(|m| (name.clone(), m)));
    }
    let own = own.ok()?;
    if groups.len() != list.len() {
        return None;
    }
    if own.is_none() && list.is_empty() {
        return section.refuse("material", "required key is missing: the name of a material");
    }
    let by_name: Vec<_> = groups.iter().map(|(name, _)| name.as_str()).collect();
    if let Err(fault) = mesh.by_group(&by_name, own.is_some()) {
        return section.refuse("groups", fault.to_string());
    }
    Some((own, groups))
}

/// Reports more modes than the mesh has unknowns beside rigid motions.
fn check_modes(section: &Section, basis: &Basis, mesh: &Mesh) {
    let most = n_elastic_modes(mesh);
    if !basis.wants_modes
        && basis.spec.modes().is_some_and(|modes| modes > most)
        && let Some(table) = section.table("reduction")
    {
        table.fault("modes", format!("must be at most {most}, the elastic modes of the mesh"));
    }
}
