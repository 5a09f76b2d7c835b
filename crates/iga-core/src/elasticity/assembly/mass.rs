//! How value products enter the consistent mass matrix (theory Eq. E.10).

use super::element::ElementProducts;

/// Adds `ρ ∫ R_A R_B dV` of one element to the column of the node at place `own`; `position` gives
/// the place of every row node in that column.
pub(crate) fn add_column(
    element: &ElementProducts,
    own: usize,
    density: f64,
    position: &[u32],
    column: &mut [f64],
) {
    let n = element.nodes.len();
    let products = &element.values[n * own..n * (own + 1)];
    for (&node, product) in element.nodes[own..].iter().zip(&products[own..]) {
        column[position[node as usize] as usize] += density * product;
    }
}
