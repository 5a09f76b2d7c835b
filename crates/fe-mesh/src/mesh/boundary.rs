//! Sides of elements that no other element shares.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::fault::MeshFault;
use crate::mesh::raw::{Elements, NO_NODE};

/// A side of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Face {
    /// The element.
    pub element: u32,
    /// Number of the side, from 0.
    pub side: u8,
}

/// Corners of a side, rising, as a name that does not depend on the element.
pub fn key(corners: impl Iterator<Item = u32>) -> [u32; 4] {
    let mut all = [NO_NODE; 4];
    corners.take(4).enumerate().for_each(|(i, n)| all[i] = n);
    all.sort_unstable();
    all
}

/// Name of side `side` of element `e`.
pub fn key_of(elements: &Elements, e: usize, side: usize) -> [u32; 4] {
    let element = elements.get(e);
    key(element.kind.sides()[side].iter().map(|&c| element.nodes[c as usize]))
}

/// All nodes of a side, rising.
fn nodes_of(elements: &Elements, face: Face) -> Vec<u32> {
    let element = elements.get(face.element as usize);
    let (_, local) = element.kind.side_nodes(face.side as usize);
    let mut nodes: Vec<u32> = local.iter().map(|&k| element.nodes[k as usize]).collect();
    nodes.sort_unstable();
    nodes
}

/// The elements that have a side in common.
struct Owners {
    first: Face,
    second: Option<u32>,
}

/// Sides by their corners.
pub type ByCorners = HashMap<[u32; 4], Face>;

/// The sides that bound the mesh, in the order of the elements, and all of them by their corners.
///
/// # Errors
/// [`MeshFault::SharedSide`] if three elements share a side, [`MeshFault::TornSide`] if two share its corners and not all of its nodes.
pub fn boundary(elements: &Elements) -> Result<(Vec<Face>, ByCorners), MeshFault> {
    let mut owners: HashMap<[u32; 4], Owners> = HashMap::with_capacity(2 * elements.len());
    for e in 0..elements.len() {
        for side in 0..elements.get(e).kind.sides().len() {
            let face = Face { element: e as u32, side: side as u8 };
            match owners.entry(key_of(elements, e, side)) {
                Entry::Vacant(entry) => {
                    entry.insert(Owners { first: face, second: None });
                }
                Entry::Occupied(mut entry) => {
                    let owners = entry.get_mut();
                    if nodes_of(elements, owners.first) != nodes_of(elements, face) {
                        let label = |e: u32| elements.get(e as usize).label;
                        let all = [owners.first.element, face.element].map(label);
                        return Err(MeshFault::TornSide { elements: all });
                    }
                    if let Some(second) = owners.second.replace(face.element) {
                        let label = |e: u32| elements.get(e as usize).label;
                        let all = [owners.first.element, second, face.element].map(label);
                        return Err(MeshFault::SharedSide { elements: all });
                    }
                }
            }
        }
    }
    owners.retain(|_, owners| owners.second.is_none());
    let by_corners: ByCorners = owners.into_iter().map(|(k, o)| (k, o.first)).collect();
    let mut faces: Vec<Face> = by_corners.values().copied().collect();
    faces.sort_unstable();
    Ok((faces, by_corners))
}
