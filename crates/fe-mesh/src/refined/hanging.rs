//! Nodes on edges and sides of larger pieces.

use std::collections::{BTreeMap, HashMap};

use super::cell::{Cell, Seams};
use super::names::{Numbers, name};
use crate::element::kind::ElementKind;
use crate::element::shape::Functions;
use crate::mesh::Mesh;

/// Values of functions below which they are round-off of zero.
const ZERO: f64 = 1e-14;

/// The nodes that hang on edges and sides of larger `cells`, with the free nodes that they follow
/// (theory Eq. C.71).
pub fn ties(mesh: &Mesh, cells: &[Cell], numbers: &Numbers) -> HashMap<u32, Vec<(u32, f64)>> {
    let seams: Vec<(ElementKind, Seams)> = ElementKind::ALL.map(|kind| (kind, Seams::new(kind))).into();
    let mut cells: Vec<&Cell> = cells.iter().collect();
    // The largest first: what their nodes follow is known then.
    cells.sort_by_key(|cell| cell.level);
    let mut found: HashMap<u32, Vec<(u32, f64)>> = HashMap::new();
    let mut functions = Functions::default();
    for cell in cells {
        let element = mesh.elements().get(cell.element as usize);
        let kind = element.kind;
        let Some((_, seams)) = seams.iter().find(|(k, _)| *k == kind) else { continue };
        let number = |xi: &[f64; 3]| numbers.get(&name(element, &cell.at(kind, xi)));
        let own: Vec<Option<u32>> = kind.node_parameters().iter().map(number).collect();
        for xi in seams.first.iter().chain(&seams.second) {
            let Some(node) = number(xi).filter(|n| !own.contains(&Some(*n)) && !found.contains_key(n)) else {
                continue;
            };
            kind.functions(xi, &mut functions);
            let mut list: BTreeMap<u32, f64> = BTreeMap::new();
            for (value, master) in functions.values.iter().zip(&own).filter(|(v, _)| v.abs() > ZERO) {
                let Some(master) = *master else { continue };
                match found.get(&master) {
                    None => *list.entry(master).or_default() += value,
                    Some(tied) => tied.iter().for_each(|(m, w)| *list.entry(*m).or_default() += value * w),
                }
            }
            found.insert(node, list.into_iter().collect());
        }
    }
    found
}
