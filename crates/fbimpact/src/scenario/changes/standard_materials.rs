//! Materials that a body may name without a table of the scenario's own.

use result_files::toml_text::document::{Entry, Node, Origin, Value};

/// A material with the source of its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandardMaterial {
    /// Name.
    pub name: &'static str,
    /// Young's modulus \[Pa\].
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
    /// Density [kg/m³].
    pub density: f64,
    /// Yield strength, 0.2 % proof stress; infinite of what breaks before it yields \[Pa\].
    pub yield_strength: f64,
    /// Where the values are from.
    pub source: &'static str,
}

const fn material(name: &'static str, constants: [f64; 4], source: &'static str) -> StandardMaterial {
    let [youngs_modulus, poissons_ratio, density, yield_strength] = constants;
    StandardMaterial { name, youngs_modulus, poissons_ratio, density, yield_strength, source }
}

/// All of them; alloys of one kind differ by some percent in Young's modulus and density.
pub const STANDARD_MATERIALS: [StandardMaterial; 8] = [
    material(
        "steel",
        [210e9, 0.3, 7850.0, 355e6],
        "EN 1993-1-1, 3.2.6; EN 1991-1-1, table A.4; yield: EN 10025-2, S355 up to 16 mm",
    ),
    material(
        "stainless-steel",
        [200e9, 0.3, 7900.0, 210e6],
        "EN 1993-1-4, 2.1.3; EN 10088-1, grade 1.4301; proof stress: EN 10088-2, hot rolled plate",
    ),
    material(
        "cast-iron",
        [110e9, 0.26, 7200.0, 165e6],
        "EN 1561, annex A, EN-GJL-250 (103 to 118 GPa; 0.1 % proof stress 165 to 228 MPa)",
    ),
    material(
        "aluminium",
        [70e9, 0.3, 2700.0, 240e6],
        "EN 1999-1-1, 3.2.5; proof stress: its table 3.2, EN AW-6082 T6 (240 to 260 MPa)",
    ),
    material("titanium", [113.8e9, 0.342, 4430.0, 880e6], "ASM data sheet of Ti-6Al-4V, annealed"),
    material(
        "copper",
        [129.8e9, 0.343, 8960.0, 69e6],
        "Kaye and Laby, tables of physical constants, 2.2.2; CRC handbook; proof stress: CDA data sheet of C11000, annealed (OS050)",
    ),
    material(
        "brass",
        [100.6e9, 0.35, 8530.0, 105e6],
        "Kaye and Laby, 2.2.2, 70 % copper; CDA data sheet of C26000; proof stress: the same, annealed (OS050)",
    ),
    material(
        "glass",
        [70e9, 0.2, 2500.0, f64::INFINITY],
        "EN 572-1, soda lime silicate, which breaks before it yields",
    ),
];

/// Adds a table `[materials.NAME]` for every standard material that a body names and the scenario
/// does not define; what `--set` has given of one stays.
pub fn fill(document: &mut Node) {
    let Value::Table(root) = &mut document.value else { return };
    let mut named = Vec::new();
    if let Some(bodies) = root.iter().find(|e| e.key == "bodies") {
        materials_in(&bodies.node, &mut named);
    }
    for material in STANDARD_MATERIALS.iter().filter(|m| named.iter().any(|name| name == m.name)) {
        let Some(list) = table(root, "materials") else { return };
        let is_given = |e: &Entry| e.key == material.name && !matches!(e.origin, Origin::Override(_));
        if list.iter().any(is_given) {
            continue;
        }
        let Some(keys) = table(list, material.name) else { continue };
        let values = [
            ("youngs_modulus", material.youngs_modulus),
            ("poissons_ratio", material.poissons_ratio),
            ("density", material.density),
            ("yield_strength", material.yield_strength),
        ];
        for (key, value) in values.into_iter().filter(|(_, value)| value.is_finite()) {
            if keys.iter().all(|e| e.key != key) {
                keys.push(entry(key, Value::Float(value)));
            }
        }
    }
}

/// The texts of all keys `material` below `node`.
fn materials_in(node: &Node, named: &mut Vec<String>) {
    let Value::Table(entries) = &node.value else { return };
    for Entry { key, node, .. } in entries {
        match &node.value {
            Value::Text(name) if key == "material" => named.push(name.clone()),
            _ => materials_in(node, named),
        }
    }
}

/// The table `key` of `entries`, made if there is none; `None` if something else stands there.
fn table<'a>(entries: &'a mut Vec<Entry>, key: &str) -> Option<&'a mut Vec<Entry>> {
    let place = entries.iter().position(|e| e.key == key).unwrap_or_else(|| {
        entries.push(entry(key, Value::Table(Vec::new())));
        entries.len() - 1
    });
    match &mut entries[place].node.value {
        Value::Table(table) => Some(table),
        _ => None,
    }
}

fn entry(key: &str, value: Value) -> Entry {
    let node = Node { value, origin: Origin::Default };
    Entry { key: key.to_owned(), origin: Origin::Default, node }
}
