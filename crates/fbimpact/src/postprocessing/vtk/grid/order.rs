//! Order of nodes in cells of VTK (file version 2.2): corners, edges, faces, interior.

/// `VTK_BEZIER_CURVE` is not needed: bodies have two or three directions. Cell types by number of
/// directions.
pub const BEZIER: [u8; 2] = [77, 79]; // VTK_BEZIER_QUADRILATERAL, VTK_BEZIER_HEXAHEDRON
/// Linear cells by number of directions.
pub const LINEAR: [u8; 2] = [9, 12]; // VTK_QUAD, VTK_HEXAHEDRON

/// A line of two points as a cell.
pub const LINE: u8 = 3; // VTK_LINE

/// A point as a cell.
pub const VERTEX: u8 = 1; // VTK_VERTEX

/// Corners of a cell, counted around the bottom and then around the top.
const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// Nodes of a higher-order cell of the degrees `degrees` (two or three directions), each as its
/// number in a net whose first direction runs fastest.
pub fn higher_order(degrees: &[usize]) -> Vec<usize> {
    let is_flat = degrees.len() == 2;
    let [p, q, r] = [degrees[0], degrees[1], if is_flat { 0 } else { degrees[2] }];
    let net = |i: usize, j: usize, k: usize| i + (p + 1) * (j + (q + 1) * k);
    let corners = if is_flat { 4 } else { 8 };
    let mut nodes: Vec<usize> =
        CORNERS[..corners].iter().map(|c| net(c[0] * p, c[1] * q, c[2] * r)).collect();
    let layers = if is_flat { vec![0] } else { vec![0, r] };
    for &k in &layers {
        nodes.extend((1..p).map(|i| net(i, 0, k)));
        nodes.extend((1..q).map(|j| net(p, j, k)));
        nodes.extend((1..p).map(|i| net(i, q, k)));
        nodes.extend((1..q).map(|j| net(0, j, k)));
    }
    if is_flat {
        nodes.extend((1..q).flat_map(|j| (1..p).map(move |i| net(i, j, 0))));
        return nodes;
    }
    for [i, j, _] in &CORNERS[..4] {
        nodes.extend((1..r).map(|k| net(i * p, j * q, k)));
    }
    for i in [0, p] {
        nodes.extend((1..r).flat_map(|k| (1..q).map(move |j| net(i, j, k))));
    }
    for j in [0, q] {
        nodes.extend((1..r).flat_map(|k| (1..p).map(move |i| net(i, j, k))));
    }
    for k in [0, r] {
        nodes.extend((1..q).flat_map(|j| (1..p).map(move |i| net(i, j, k))));
    }
    nodes.extend((1..r).flat_map(|k| (1..q).flat_map(move |j| (1..p).map(move |i| net(i, j, k)))));
    nodes
}

/// Linear cells that fill a net with `cells` cells per direction, each as the numbers of its
/// corners.
pub fn linear(cells: &[usize]) -> Vec<Vec<usize>> {
    let is_flat = cells.len() == 2;
    let [p, q, r] = [cells[0], cells[1], if is_flat { 1 } else { cells[2] }];
    let net = |i: usize, j: usize, k: usize| i + (p + 1) * (j + (q + 1) * k);
    let corners = if is_flat { 4 } else { 8 };
    let mut all = Vec::with_capacity(p * q * r);
    for k in 0..r {
        for j in 0..q {
            for i in 0..p {
                all.push(CORNERS[..corners].iter().map(|c| net(i + c[0], j + c[1], k + c[2])).collect());
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_occurs_once() {
        for degrees in [&[1, 1][..], &[3, 2], &[1, 1, 1], &[2, 3, 4], &[4, 1, 2]] {
            let mut nodes = higher_order(degrees);
            assert_eq!(nodes.len(), degrees.iter().map(|p| p + 1).product::<usize>());
            nodes.sort_unstable();
            assert!(nodes.iter().enumerate().all(|(i, n)| i == *n), "{degrees:?}");
        }
    }

    #[test]
    fn linear_cells_fill_the_net() {
        assert_eq!(linear(&[2, 1]), [[0, 1, 4, 3], [1, 2, 5, 4]]);
        assert_eq!(linear(&[1, 1, 1]), [[0, 1, 3, 2, 4, 5, 7, 6]]);
        assert_eq!(linear(&[2, 3, 4]).len(), 24);
    }
}
