//! Stiffness blocks from gradient products, and how they enter the sparse matrix.

use super::element::ElementProducts;
use super::pattern::Unknowns;

/// Block `K_AB` of a plane or solid model from `h[i][j] = ∫ ∂_i R_A ∂_j R_B dV` (theory Eq. E.11).
pub(crate) fn solid_block<const D: usize>(lambda: f64, mu: f64, h: &[[f64; D]; D]) -> [[f64; D]; D] {
    let trace: f64 = mu * (0..D).map(|k| h[k][k]).sum::<f64>();
    let mut block = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            block[i][j] = lambda * h[i][j] + mu * h[j][i];
        }
        block[i][i] += trace;
    }
    block
}

/// Block `K_AB` of the axisymmetric model from `h[i][j] = ∫ g_A,i g_B,j dV` with
/// `g = (∂_r R, ∂_z R, R / r)` (theory Eq. E.12).
pub(crate) fn axisymmetric_block(lambda: f64, mu: f64, h: &[[f64; 3]; 3]) -> [[f64; 2]; 2] {
    let normal = lambda + 2.0 * mu;
    [
        [
            normal * (h[0][0] + h[2][2]) + lambda * (h[0][2] + h[2][0]) + mu * h[1][1],
            lambda * (h[0][1] + h[2][1]) + mu * h[1][0],
        ],
        [lambda * (h[1][0] + h[1][2]) + mu * h[0][1], normal * h[1][1] + mu * h[0][0]],
    ]
}

/// The columns of one node in the matrix, one component after the other, each from its diagonal
/// entry down.
pub(crate) struct NodeColumns<'a, const D: usize> {
    columns: [&'a mut [f64]; D],
    node: u32,
    unknowns: &'a Unknowns,
}

impl<'a, const D: usize> NodeColumns<'a, D> {
    /// `column` is the stretch of matrix values that holds them.
    pub fn new(column: &'a mut [f64], node: u32, unknowns: &'a Unknowns) -> Self {
        let columns = split_columns(column, unknowns.first_component[node as usize] as usize);
        Self { columns, node, unknowns }
    }

    /// Adds `block[i][j]` to row component `i` and column component `j` at node `row`, which is not
    /// above the diagonal; its first row in the matrix lies `offset` below the first row of the
    /// node's first column.
    #[inline]
    pub fn add(&mut self, row: u32, offset: u32, block: &[[f64; D]; D]) {
        let held = |node: u32| self.unknowns.first_component[node as usize] as usize;
        let (own_held, first) = (held(self.node), held(row));
        for (j, values) in self.columns.iter_mut().enumerate().skip(own_held) {
            if row == self.node {
                for i in j..D {
                    values[i - j] += block[i][j];
                }
                continue;
            }
            // Column j starts at its own diagonal entry, j - own_held rows below that of the node's
            // first column.
            let values = &mut values[offset as usize + own_held - j..];
            match values.first_chunk_mut::<D>() {
                Some(rows) if first == 0 => {
                    for i in 0..D {
                        rows[i] += block[i][j];
                    }
                }
                _ => {
                    for (value, line) in values.iter_mut().zip(&block[first..]) {
                        *value += line[j];
                    }
                }
            }
        }
    }
}

/// Adds one element's blocks to the columns `column` of one node.
///
/// `own` is the node's place in the element, `offset` gives for every node the distance of its
/// first row from the first row of the node's first column. `G` rows of products make `D`
/// displacement components.
pub(crate) fn add_columns<const D: usize, const G: usize>(
    element: &ElementProducts,
    own: usize,
    unknowns: &Unknowns,
    offset: &[u32],
    column: &mut [f64],
    block: impl Fn(&[[f64; G]; G]) -> [[f64; D]; D],
) {
    let n = element.nodes.len();
    let mut columns = NodeColumns::<D>::new(column, element.nodes[own], unknowns);
    let products: [&[f64]; G] = std::array::from_fn(|j| &element.gradients[G * n * (G * own + j)..][..G * n]);
    for a in own..n {
        let h: [[f64; G]; G] = std::array::from_fn(|i| std::array::from_fn(|j| products[j][G * a + i]));
        let node = element.nodes[a];
        columns.add(node, offset[node as usize], &block(&h));
    }
}

/// Cuts the values of a node's columns into one slice a component; a held component has an empty
/// one.
fn split_columns<const D: usize>(column: &mut [f64], held: usize) -> [&mut [f64]; D] {
    let free = D - held;
    // Lengths l, l - 1, ..., l - free + 1 add up to the length of the slice.
    let longest = (column.len() + free * (free - 1) / 2) / free;
    let mut rest = column;
    std::array::from_fn(|j| {
        if j < held {
            return Default::default();
        }
        let (own, others) = std::mem::take(&mut rest).split_at_mut(longest - (j - held));
        rest = others;
        own
    })
}
