//! Checks of a mesh: what makes no body is an error, what is doubtful a note.

use crate::element::jacobian::{PointOf, minus, norm};
use crate::element::kind::ElementKind;
use crate::fault::MeshFault;
use crate::mesh::raw::{Elements, NO_NODE};

/// Numbers that a note lists.
const LISTED: usize = 5;
/// Sizes between which a unit of length is believed \[m\]: a grain of sand and a ship.
const PLAUSIBLE: [f64; 2] = [1e-4, 50.0];
/// Share of the mean determinant below which an element counts as flat.
const FLAT: f64 = 1e-9;

/// Length of the diagonal of the box around `nodes` \[m\].
pub fn diagonal(nodes: &[[f64; 3]]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for node in nodes {
        for d in 0..3 {
            low[d] = low[d].min(node[d]);
            high[d] = high[d].max(node[d]);
        }
    }
    if nodes.is_empty() { 0.0 } else { norm(&minus(&high, &low)) }
}

/// Refuses a mesh without elements, and one with linear and quadratic ones.
///
/// # Errors
/// [`MeshFault::NoElements`], [`MeshFault::MixedOrders`].
pub fn orders(elements: &Elements) -> Result<(), MeshFault> {
    let named = |is_quadratic: bool| {
        let found = elements.iter().find(|e| e.kind.is_quadratic() == is_quadratic);
        found.map(|e| (e.label, e.kind.name()))
    };
    match (named(false), named(true)) {
        (None, None) => Err(MeshFault::NoElements),
        (Some(first), Some(second)) => Err(MeshFault::MixedOrders { first, second }),
        _ => Ok(()),
    }
}

/// New numbers of the nodes that elements have, [`NO_NODE`] for the others, which are noted.
pub fn used_nodes(elements: &Elements, labels: &[u64], notes: &mut Vec<String>) -> Vec<u32> {
    let mut numbers = vec![NO_NODE; labels.len()];
    elements.iter().flat_map(|e| e.nodes).for_each(|&n| numbers[n as usize] = 0);
    let loose: Vec<u64> =
        numbers.iter().zip(labels).filter(|(n, _)| **n == NO_NODE).map(|(_, l)| *l).collect();
    if !loose.is_empty() {
        let first: Vec<String> = loose.iter().take(LISTED).map(u64::to_string).collect();
        let more = if loose.len() > LISTED { ", …" } else { "" };
        notes.push(format!(
            "{} nodes belong to no solid element and are left out: {}{more}",
            loose.len(),
            first.join(", ")
        ));
    }
    for (next, number) in (0..).zip(numbers.iter_mut().filter(|n| **n != NO_NODE)) {
        *number = next;
    }
    numbers
}

/// Refuses elements that name a node twice.
///
/// # Errors
/// [`MeshFault::Collapsed`].
pub fn distinct_nodes(elements: &Elements, labels: &[u64]) -> Result<(), MeshFault> {
    let mut sorted = Vec::with_capacity(ElementKind::MAX_NODES);
    for element in elements.iter() {
        sorted.clear();
        sorted.extend_from_slice(element.nodes);
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|w| w[0] == w[1]) {
            return Err(MeshFault::Collapsed { element: element.label, node: labels[pair[0] as usize] });
        }
    }
    Ok(())
}

/// Refuses a mesh of several parts.
///
/// # Errors
/// [`MeshFault::Parts`].
pub fn one_part(elements: &Elements, n_nodes: usize) -> Result<(), MeshFault> {
    let mut parent: Vec<u32> = (0..n_nodes as u32).collect();
    fn root(parent: &mut [u32], mut n: u32) -> u32 {
        while parent[n as usize] != n {
            parent[n as usize] = parent[parent[n as usize] as usize];
            n = parent[n as usize];
        }
        n
    }
    for element in elements.iter() {
        let mut first = root(&mut parent, element.nodes[0]);
        for &n in &element.nodes[1..] {
            let other = root(&mut parent, n);
            let (low, high) = (first.min(other), first.max(other));
            parent[high as usize] = low;
            first = low;
        }
    }
    let mut parts: Vec<(u32, u64)> = Vec::new();
    let mut is_known = vec![false; n_nodes];
    for element in elements.iter() {
        let own = root(&mut parent, element.nodes[0]);
        if !std::mem::replace(&mut is_known[own as usize], true) {
            parts.push((own, element.label));
        }
    }
    match parts[..] {
        [(_, first), (_, second), ..] => {
            Err(MeshFault::Parts { parts: parts.len(), elements: [first, second] })
        }
        _ => Ok(()),
    }
}

/// Whether a determinant is positive beside the `largest` one; no number is not.
fn is_positive(determinant: f64, largest: f64) -> bool {
    determinant > FLAT * largest
}

/// Refuses elements whose map turns inside out at a point of a rule; notes those where it does so
/// at a node, at the apex of pyramids along the axis.
///
/// # Errors
/// [`MeshFault::Inverted`].
pub fn orientation(
    elements: &Elements,
    nodes: &[[f64; 3]],
    notes: &mut Vec<String>,
) -> Result<(), MeshFault> {
    let mut at = PointOf::default();
    let mut places = Vec::new();
    let mut bad_nodes: Vec<u64> = Vec::new();
    for kind in ElementKind::ALL {
        let mut points: Vec<[f64; 3]> = kind.stiffness_rule().iter().map(|p| p.xi).collect();
        points.extend(kind.mass_rule().iter().map(|p| p.xi));
        let ends = kind.node_parameters();
        for element in elements.iter().filter(|e| e.kind == kind) {
            places.clear();
            places.extend(element.nodes.iter().map(|&n| nodes[n as usize]));
            let mut values = Vec::with_capacity(points.len());
            for xi in &points {
                at.evaluate(kind, &places, xi);
                values.push((at.determinant, at.position));
            }
            let largest = values.iter().fold(0.0f64, |m, (d, _)| m.max(d.abs()));
            let worst = values.iter().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((determinant, point)) = worst.copied().filter(|(d, _)| !is_positive(*d, largest)) {
                let is_mirrored = values.iter().all(|(d, _)| *d < 0.0);
                let remedy = if is_mirrored {
                    "its nodes stand in the order of a mirrored element: reorient the mesh"
                } else {
                    "mesh finer there or optimise the high-order mesh (Mesh.HighOrderOptimize = 2 in Gmsh)"
                };
                let (element, kind) = (element.label, kind.name());
                return Err(MeshFault::Inverted { element, kind, point, determinant, remedy });
            }
            let turns = |xi: &[f64; 3]| {
                at.evaluate(kind, &places, xi);
                !is_positive(at.determinant, largest)
            };
            if kind.is_quadratic() && ends.iter().any(turns) {
                bad_nodes.push(element.label);
            }
        }
    }
    if !bad_nodes.is_empty() {
        let first: Vec<String> = bad_nodes.iter().take(LISTED).map(u64::to_string).collect();
        notes.push(format!(
            "{} elements are inside out at a node, stress there is meaningless: {}; optimise the high-order mesh (Mesh.HighOrderOptimize = 2 in Gmsh)",
            bad_nodes.len(),
            first.join(", ")
        ));
    }
    Ok(())
}

/// Notes kinds of elements that are too stiff.
pub fn stiffness_of_kinds(elements: &Elements, notes: &mut Vec<String>) {
    let count = |kind| elements.iter().filter(|e| e.kind == kind).count();
    for kind in [ElementKind::Tet4, ElementKind::Wedge6, ElementKind::Pyramid5] {
        let n = count(kind);
        if n > 0 {
            notes.push(format!(
                "{n} elements are {}, linear ones whose strain hardly varies: bodies are far too stiff in bending; mesh with quadratic elements (gmsh -order 2, C3D10, C3D15)",
                kind.name()
            ));
        }
    }
    let n = count(ElementKind::Hex8);
    if n > 0 {
        notes.push(format!(
            "{n} elements are hex8, too stiff in bending unless there are several over the thickness; hex20 is much better"
        ));
    }
}

/// Notes sizes that a wrong unit of length makes.
pub fn size(nodes: &[[f64; 3]], notes: &mut Vec<String>) {
    let size = diagonal(nodes);
    if !(PLAUSIBLE[0]..=PLAUSIBLE[1]).contains(&size) {
        notes.push(format!("the part is {size:.3e} m across; is its unit of length right?"));
    }
}
