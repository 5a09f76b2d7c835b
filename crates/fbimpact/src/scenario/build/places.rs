//! Places on bodies: what other tables need to know about a body before it is built, markers,
//! points, parts.

use adaptive::spec::{Coupling, Extent};
use ffr_dynamics::body::RigidMotion;

use super::super::body_places::GivenPlace;
use super::super::body_source::{BodySource, MeshSource};
use super::super::files::bodies::is_meshed;
use super::super::files::spline_nets::{self, padded};
use super::super::keys::{Named, names};
use super::super::section::{AtFault, Checked, Section};
use super::super::tables::{BodyModel, ModelFacts, ShapeName};

/// What other tables need to know about a body.
#[derive(Debug, Clone, Copy)]
pub struct BodyFacts<'a> {
    /// Its table.
    pub section: &'a Section,
    /// Whether it is rigid.
    pub is_rigid: bool,
    /// The model whose components its points have; that of rigid bodies for a plane, which has none.
    pub components: BodyModel,
    /// Its shape; bodies from files and rigid bodies with a given mass have none.
    pub shape: Option<ShapeName>,
    /// Its body file, if it is from one.
    pub file: Option<&'a BodySource>,
    /// Its mesh, if it is of finite elements.
    pub mesh: Option<&'a MeshSource>,
    /// Whether points of the body file can be named beside its markers.
    has_points: bool,
}

impl<'a> BodyFacts<'a> {
    /// Facts of the body in `section`, unless what they follow from is at fault.
    pub fn of(section: &'a Section) -> Option<Self> {
        let model = section.choice("model")?;
        let shape = section.optional("geometry", |body, key| body.table(key)?.choice("shape")).ok()?;
        let file = section.body_file().map(AsRef::as_ref);
        let mesh = section.mesh_file().map(AsRef::as_ref);
        let of_motion = |motion: RigidMotion| match motion {
            RigidMotion::Planar => BodyModel::PlaneStrain,
            RigidMotion::Axial => BodyModel::Axisymmetric,
            RigidMotion::Spatial => BodyModel::Solid,
        };
        let components = match model {
            BodyModel::Solid | BodyModel::Axisymmetric | BodyModel::PlaneStrain | BodyModel::PlaneStress => {
                model
            }
            BodyModel::Imported => of_motion(file?.body.motion()),
            BodyModel::Mesh => BodyModel::Solid,
            BodyModel::Rigid if shape == Some(ShapeName::Plane) => BodyModel::Rigid,
            BodyModel::Rigid => of_motion(section.choice("motion")?),
        };
        // A mesh that cannot be read is a fault already.
        if is_meshed(section) && mesh.is_none() {
            return None;
        }
        Some(Self {
            section,
            is_rigid: model == BodyModel::Rigid,
            components,
            shape,
            file,
            mesh,
            has_points: false,
        })
    }

    /// Facts of the body called `name`, as far as they are known.
    pub fn find(root: &'a Section, name: &str) -> Option<Self> {
        Self::of(root.one_of("bodies", name)?)
    }

    /// The same with the points of the body file, which are for output.
    pub fn with_points(self) -> Self {
        Self { has_points: true, ..self }
    }

    /// Whether it is an unbounded plane.
    pub fn is_plane(&self) -> bool {
        self.shape == Some(ShapeName::Plane)
    }

    /// How it moves.
    pub fn motion(&self) -> RigidMotion {
        match self.components {
            BodyModel::Axisymmetric => RigidMotion::Axial,
            BodyModel::PlaneStrain | BodyModel::PlaneStress => RigidMotion::Planar,
            BodyModel::Solid | BodyModel::Imported | BodyModel::Mesh | BodyModel::Rigid => {
                RigidMotion::Spatial
            }
        }
    }

    /// Name of its shape; empty where it has none.
    pub fn shape_name(&self) -> &'static str {
        self.shape.map_or("", ShapeName::name)
    }

    /// Names of the markers of its shape.
    pub fn shape_markers(&self) -> &'static [&'static str] {
        self.in_model().map_or(&[], |facts| facts.markers)
    }

    /// Names of the faces of its shape.
    fn faces(&self) -> Vec<String> {
        if let Some(source) = self.mesh {
            return source.mesh.face_names().map(str::to_owned).collect();
        }
        if let (Some(ShapeName::Nurbs), Some(geometry)) = (self.shape, self.section.table("geometry")) {
            return spline_nets::face_names(geometry, self.components.dimension());
        }
        self.in_model().map_or(Vec::new(), |facts| facts.faces.iter().map(|f| (*f).to_owned()).collect())
    }

    /// What has its faces, in words.
    fn holder(&self) -> String {
        match self.mesh {
            Some(source) => source.path.display().to_string(),
            None => format!("shape \"{}\"", self.shape_name()),
        }
    }

    fn in_model(&self) -> Option<&'static ModelFacts> {
        self.shape?.in_model(self.components)
    }

    /// Whether a joint or load on it needs a part of it: a point of an elastic continuum carries no
    /// force.
    fn needs_extent(&self) -> bool {
        !self.is_rigid && self.file.is_none()
    }

    /// Whether its marker `name` has an extent, as the ends of bars have and markers with a face or
    /// radius.
    fn has_extent(&self, name: &str) -> bool {
        let added = self.section.named("markers").iter().find(|(marker, _)| marker == name);
        match added {
            Some((_, marker)) => marker.item("face").is_some() || marker.item("radius").is_some(),
            None => self.faces().iter().any(|face| face == name),
        }
    }

    /// Names of its markers.
    fn markers(&self) -> Vec<&'a str> {
        let own = self.shape_markers();
        let added = self.section.named("markers").iter().map(|(name, _)| name.as_str());
        let markers = self.file.map(|f| f.body.markers()).unwrap_or_default();
        let points = self.file.filter(|_| self.has_points).map(|f| f.body.points()).unwrap_or_default();
        let faces = self.mesh.into_iter().flat_map(|source| source.mesh.face_names());
        own.iter().copied().chain(added).chain(markers).chain(points).chain(faces).collect()
    }
}

/// Index of the body that key `key` of `section` names; an unknown one is a fault.
pub fn body_index(root: &Section, section: &Section, key: &str) -> Option<usize> {
    let name = section.text(key)?;
    let index = root.place_of("bodies", name);
    if index.is_none() {
        let known: Vec<&str> = root.named("bodies").iter().map(|(n, _)| n.as_str()).collect();
        section.unknown_name(key, "body", &known);
    }
    index
}

/// The place that exactly one of the keys `marker` and `point` gives.
pub fn marker_or_point(section: &Section, body: &BodyFacts<'_>) -> Option<GivenPlace> {
    if section.item("marker").is_none() && section.item("point").is_none() {
        return section.refuse("marker", "required key is missing: either \"marker\" or \"point\"");
    }
    one_of(section, ["marker", "point"], body).ok()?
}

/// The place that joints and loads take hold of: a marker, a face, or a point, of flexible bodies
/// with an extent.
pub fn held(section: &Section, body: &BodyFacts<'_>) -> Option<GivenPlace> {
    let key = given_place(section, &["marker", "face", "point"])?;
    if body.is_plane() {
        return place(section, key, body); // which says that it has none
    }
    if key != "marker" {
        return part(section, key, body).filter(|at| can_be_held(section, key, body, at));
    }
    let at = place(section, key, body)?;
    can_be_held(section, key, body, &at).then_some(at)
}

/// Reports a place of a flexible body that has no extent.
fn can_be_held(section: &Section, key: &str, body: &BodyFacts<'_>, at: &GivenPlace) -> bool {
    let has_extent = match at {
        GivenPlace::Part { .. } => true,
        GivenPlace::Point(_) => false,
        GivenPlace::Marker(name) => body.has_extent(name),
    };
    if has_extent || !body.needs_extent() {
        return true;
    }
    let faces = body.faces().iter().map(|f| format!("\"{f}\"")).collect::<Vec<_>>().join(", ");
    let message = format!(
        "a point of a flexible body carries no force, it yields without bound as elements shrink; give a \"face\" ({faces}), \
         a \"radius\" beside \"point\", or a marker that has one of them"
    );
    section.fault(key, message);
    false
}

/// The point or part of the body that the keys `point` or `face` with `radius` and `coupling` give;
/// `key` is the one of the first two that is there.
pub fn part(section: &Section, key: &str, body: &BodyFacts<'_>) -> Option<GivenPlace> {
    let radius = section.optional("radius", Section::number).ok()?;
    let coupling = section.optional("coupling", Section::choice).ok()?.unwrap_or(Coupling::Average);
    if key == "point" && radius.is_none() {
        return place(section, key, body);
    }
    let at = || match place(section, "point", body)? {
        GivenPlace::Point(point) => Some(point),
        GivenPlace::Marker(_) | GivenPlace::Part { .. } => None,
    };
    if let Some(radius) = radius {
        let extent = Extent::Around { point: at()?, radius };
        return Some(GivenPlace::Part { extent, coupling, at: None });
    }
    let at = if section.item("point").is_some() { Some(at()?) } else { None };
    Some(GivenPlace::Part { extent: Extent::Face(face(section, body)?), coupling, at })
}

/// The one of `keys` that is given and says what a place is: a point beside a face says where its marker is.
pub fn given_place(section: &Section, keys: &[&'static str]) -> Option<&'static str> {
    let given: Vec<&str> = keys.iter().copied().filter(|key| section.item(key).is_some()).collect();
    let names = keys.iter().map(|key| format!("\"{key}\"")).collect::<Vec<_>>();
    let choice = format!("one of {} and {}", names[..names.len() - 1].join(", "), names[names.len() - 1]);
    match given[..] {
        [key] | [key @ "face", "point"] => Some(key),
        [] => section.refuse(keys[0], format!("required key is missing: {choice}")),
        [.., last] => {
            section.refuse(last, format!("only {choice} can be given, and \"point\" beside \"face\""))
        }
    }
}

/// The name of key `face`, which the body must have.
fn face(section: &Section, body: &BodyFacts<'_>) -> Option<String> {
    let known = body.faces();
    if known.is_empty() {
        let message = match body.file {
            Some(_) => {
                let markers = names(body.markers().into_iter());
                format!("a body from a file has no named faces, name a marker of the file: {markers}")
            }
            None if body.mesh.is_some() => {
                "the mesh has no group of faces: give surfaces, in the plane curves, a physical group or write *SURFACE or *NSET, or give a \"point\"".into()
            }
            None => "the body has no shape with faces, give a \"point\"".into(),
        };
        return section.refuse("face", message);
    }
    let name = section.text("face")?;
    if !known.iter().any(|face| face == name) {
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        section.unknown_name("face", &format!("face of {}", body.holder()), &known);
        return None;
    }
    Some(name.to_owned())
}

/// The single point that key `key` gives; a whole face has none.
pub fn single(section: &Section, key: &str, body: &BodyFacts<'_>) -> Option<GivenPlace> {
    let at = place(section, key, body)?;
    let GivenPlace::Marker(name) = &at else { return Some(at) };
    let added = body.section.named("markers").iter().find(|(marker, _)| marker == name);
    let is_face = added.is_none() && body.mesh.is_some() && body.faces().contains(name);
    if is_face || added.is_some_and(|(_, marker)| marker.item("face").is_some()) {
        return section.refuse(key, "the marker is a whole face, a point is needed here");
    }
    Some(at)
}

/// The place that one of two keys gives; none if there is neither.
///
/// # Errors
/// [`AtFault`].
pub fn one_of(
    section: &Section,
    [marker, point]: [&'static str; 2],
    body: &BodyFacts<'_>,
) -> Result<Option<GivenPlace>, AtFault> {
    if section.item(marker).is_some() && section.item(point).is_some() {
        let message = format!("either \"{marker}\" or \"{point}\" can be given, not both");
        section.fault(point, message);
        return Err(AtFault);
    }
    let key = if section.item(marker).is_some() { marker } else { point };
    section.optional(key, |section, key| place(section, key, body))
}

/// The marker or point of key `key` on a body.
pub fn place(section: &Section, key: &str, body: &BodyFacts<'_>) -> Option<GivenPlace> {
    if body.is_plane() {
        return section.refuse(key, "a plane is unbounded and at rest, it has no points to name");
    }
    match &section.item(key)?.value {
        Checked::Text(name) => {
            let known = body.markers();
            if !known.contains(&name.as_str()) {
                let what = if let Some(file) = body.file {
                    format!("marker of {}", file.path.display())
                } else if let Some(mesh) = body.mesh {
                    format!("marker or face of {}", mesh.path.display())
                } else if let Some(shape) = body.shape {
                    format!("marker of shape \"{}\"", shape.name())
                } else {
                    "marker of the body".to_owned()
                };
                section.unknown_name(key, &what, &known);
                return None;
            }
            Some(GivenPlace::Marker(name.clone()))
        }
        Checked::Numbers(_) if body.file.is_some() => {
            let known = names(body.markers().into_iter());
            let message = format!("a body from a file has no shape, name a marker of the file: {known}");
            section.refuse(key, message)
        }
        Checked::Numbers(x) => point(section, key, x, body).map(GivenPlace::Point),
        _ => None,
    }
}

/// A point with as many coordinates as the body's model has, padded with zeros.
pub fn point(section: &Section, key: &str, x: &[f64], body: &BodyFacts<'_>) -> Option<[f64; 3]> {
    let dimension = body.components.dimension();
    if x.len() != dimension {
        let model = if body.is_rigid { "motion" } else { "model" };
        let name = body.section.text(model)?;
        let message = format!("a point of a body with {model} \"{name}\" has {dimension} coordinates");
        return section.refuse(key, message);
    }
    Some(padded(x))
}

/// How a body moves, in words.
pub fn motion_in_words(motion: RigidMotion) -> &'static str {
    match motion {
        RigidMotion::Spatial => "spatial",
        RigidMotion::Planar => "plane",
        RigidMotion::Axial => "axisymmetric",
    }
}
