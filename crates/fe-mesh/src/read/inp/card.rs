//! Cards of an input file, and the element types that they name.

use crate::kind::ElementKind;

/// Parameters of cards that say something of the mesh; a file may have any number of others.
const PARAMETERS: &[&str] = &["TYPE", "ELSET", "NSET", "NAME", "GENERATE", "SYSTEM", "INPUT", "FILE"];

/// A card with its parameters.
#[derive(Debug, Clone, Default)]
pub(super) struct Card {
    pub name: String,
    pub line: usize,
    parameters: Vec<(&'static str, String)>,
}

impl Card {
    /// The card of the line, or lines, `text`.
    pub fn new(text: &str, line: usize) -> Self {
        let mut fields = text.trim_start_matches('*').split(',').map(str::trim);
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
pub(super) enum Type {
    Solid(ElementKind),
    /// Corners and nodes of an element on the surface.
    Side(usize, usize),
    /// Something else of so many nodes, left out.
    Other,
}

/// What an element type of a file is; `None` if nothing is known of it.
pub(super) fn element_type(name: &str) -> Option<Type> {
    // Letters behind the number of nodes choose an integration or a mixed formulation; the
    // displacement element is computed.
    let bare = name.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    Some(match bare {
        "C3D4" => Type::Solid(ElementKind::Tet4),
        "C3D10" => Type::Solid(ElementKind::Tet10),
        "C3D8" => Type::Solid(ElementKind::Hex8),
        "C3D20" => Type::Solid(ElementKind::Hex20),
        "C3D27" => Type::Solid(ElementKind::Hex27),
        "C3D6" => Type::Solid(ElementKind::Wedge6),
        "C3D15" => Type::Solid(ElementKind::Wedge15),
        "C3D5" => Type::Solid(ElementKind::Pyramid5),
        "C3D13" => Type::Solid(ElementKind::Pyramid13),
        "S3" | "CPS3" | "CPE3" | "CAX3" | "M3D3" | "SFM3D3" => Type::Side(3, 3),
        "S4" | "CPS4" | "CPE4" | "CAX4" | "M3D4" | "SFM3D4" => Type::Side(4, 4),
        "S6" | "STRI65" | "CPS6" | "CPE6" | "CAX6" | "M3D6" | "SFM3D6" => Type::Side(3, 6),
        "S8" | "CPS8" | "CPE8" | "CAX8" | "M3D8" | "SFM3D8" => Type::Side(4, 8),
        _ if name.starts_with("T3D") || name.starts_with("B3") => Type::Other,
        _ => return None,
    })
}
