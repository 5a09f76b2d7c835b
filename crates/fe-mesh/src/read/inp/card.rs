//! Cards of an input file, and the element types that they name.

use super::super::text::split;
use crate::element::kind::ElementKind;
use crate::mesh::raw::StatedModel;

/// Parameters of cards that say something of the mesh; a file may have any number of others.
const PARAMETERS: &[&str] = &[
    "TYPE",
    "ELSET",
    "NSET",
    "NAME",
    "GENERATE",
    "SYSTEM",
    "INPUT",
    "FILE",
    "PART",
    "INSTANCE",
    "COMBINE",
    "REF NODE",
    "SURFACE",
    "CONSTRAINT NAME",
    "TIE NSET",
    "PIN NSET",
    "CYCLIC SYMMETRY",
    "MULTISTAGE",
];

/// A card with its parameters.
#[derive(Debug, Clone, Default)]
pub struct Card {
    pub name: String,
    pub line: usize,
    parameters: Vec<(&'static str, String)>,
}

impl Card {
    /// The card of the line, or lines, `text`.
    pub fn new(text: &str, line: usize) -> Self {
        let mut fields = split(text.trim_start_matches('*'));
        let mut name = String::new();
        for word in fields.next().unwrap_or_default().split_whitespace() {
            name += if name.is_empty() { "" } else { " " };
            name += word;
        }
        let parameter = |field: &str| {
            let (key, value) = field.split_once('=').unwrap_or((field, ""));
            let key = PARAMETERS.iter().copied().find(|known| known.eq_ignore_ascii_case(key.trim()))?;
            Some((key, value.trim().trim_matches('"').to_owned()))
        };
        let mut parameters: Vec<(&'static str, String)> = Vec::new();
        for (key, value) in fields.filter_map(parameter) {
            if parameters.iter().all(|(known, _)| *known != key) {
                parameters.push((key, value));
            }
        }
        Self { name: name.to_ascii_uppercase(), line, parameters }
    }

    /// Value of a parameter, empty if it has none.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|(k, _)| *k == key).map(|(_, v)| v.as_str())
    }
}

/// What an element type is here.
#[derive(Debug, Clone, Copy)]
pub enum Type {
    Solid(ElementKind),
    /// An element of a plane or axisymmetric model, or on the surface of solids.
    Plane(ElementKind, StatedModel),
    /// An element of so many nodes on the surface.
    Side(usize),
    /// A line of so many nodes, on the surface of plane elements.
    Line(usize),
    /// Something else, left out.
    Other,
}

/// Name of an element type in Abaqus and CalculiX; none where they have no such element.
fn name_of(kind: ElementKind) -> Option<&'static str> {
    match kind {
        ElementKind::Tet4 => Some("C3D4"),
        ElementKind::Tet10 => Some("C3D10"),
        ElementKind::Hex8 => Some("C3D8"),
        ElementKind::Hex20 => Some("C3D20"),
        ElementKind::Hex27 => Some("C3D27"),
        ElementKind::Wedge6 => Some("C3D6"),
        ElementKind::Wedge15 => Some("C3D15"),
        ElementKind::Pyramid5 => Some("C3D5"),
        ElementKind::Pyramid13 => Some("C3D13"),
        ElementKind::Wedge18 | ElementKind::Pyramid14 => None,
        // Named after their models.
        ElementKind::Tri3
        | ElementKind::Tri6
        | ElementKind::Quad4
        | ElementKind::Quad8
        | ElementKind::Quad9 => None,
    }
}

/// What the element type `name`, in capitals, is; none for a solid that is not known. Letters behind
/// the number of nodes choose an integration or a mixed formulation; the displacement element is computed.
pub fn element_type(name: &str) -> Option<Type> {
    let bare = name.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    if let Some(kind) = ElementKind::ALL.into_iter().find(|kind| name_of(*kind) == Some(bare)) {
        return Some(Type::Solid(kind));
    }
    let models = [
        ("CPS", StatedModel::PlaneStress),
        ("CPE", StatedModel::PlaneStrain),
        ("CAX", StatedModel::Axisymmetric),
    ];
    for (family, model) in models {
        let kind = match bare.strip_prefix(family) {
            Some("3") => ElementKind::Tri3,
            Some("4") => ElementKind::Quad4,
            Some("6") => ElementKind::Tri6,
            Some("8") => ElementKind::Quad8,
            _ => continue,
        };
        return Some(Type::Plane(kind, model));
    }
    match bare {
        "T2D2" | "T3D2" | "B21" | "B31" => return Some(Type::Line(2)),
        "T2D3" | "T3D3" | "B22" | "B32" => return Some(Type::Line(3)),
        _ => {}
    }
    let n_nodes = ["S", "M3D", "SFM3D", "STRI", "R3D"].iter().find_map(|family| {
        let n = bare.strip_prefix(family)?.parse().ok()?;
        match n {
            65 => Some(6),
            3 | 4 | 6 | 8 => Some(n),
            _ => None,
        }
    });
    match n_nodes {
        Some(n) => Some(Type::Side(n)),
        None if bare.starts_with("C3D") || name.is_empty() => None,
        None => Some(Type::Other),
    }
}
