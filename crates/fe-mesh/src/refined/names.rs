//! Names of places that do not depend on the element that they are seen from.

use std::collections::HashMap;

use crate::element::kind::ElementKind;
use crate::element::shape::Functions;
use crate::mesh::raw::Element;

/// Levels up to which weights of corners are exact: products of three multiples of a power of two.
pub const MOST_LEVELS: u8 = 16;

/// Corners of an element with their weights in the linear interpolation of a place, bit by bit:
/// elements that share a side or an edge give a place on it the same name.
pub type Name = Vec<(u32, u64)>;

/// The name of the place with parameters `xi` in `element`.
pub fn name(element: Element<'_>, xi: &[f64; 3]) -> Name {
    let mut functions = Functions::default();
    element.kind.linear().functions(xi, &mut functions);
    let weights = element.nodes.iter().copied().zip(functions.values);
    let mut name: Name = weights.filter(|(_, w)| *w != 0.0).map(|(n, w)| (n, w.to_bits())).collect();
    name.sort_unstable();
    name
}

/// Whether the place with parameters `xi` of an element of `kind` lies on its side `side`.
pub fn is_on_side(kind: ElementKind, side: usize, xi: &[f64; 3]) -> bool {
    let mut functions = Functions::default();
    kind.linear().functions(xi, &mut functions);
    let corners = kind.sides()[side];
    functions.values.iter().enumerate().all(|(c, w)| *w == 0.0 || corners.contains(&(c as u8)))
}

/// Nodes by their names.
#[derive(Default)]
pub struct Numbers {
    known: HashMap<Name, u32>,
}

impl Numbers {
    /// Gives the node `number` its name.
    pub fn set(&mut self, name: Name, number: u32) {
        self.known.insert(name, number);
    }

    /// The node called `name`.
    pub fn get(&self, name: &Name) -> Option<u32> {
        self.known.get(name).copied()
    }

    /// The node called `name`, `next` if there is none yet.
    pub fn get_or(&mut self, name: Name, next: u32) -> u32 {
        *self.known.entry(name).or_insert(next)
    }
}
