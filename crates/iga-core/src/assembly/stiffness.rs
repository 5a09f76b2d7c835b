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

/// Block `K_AB` of the axisymmetric model from `h[i][j] = ∫ g_A,i g_B,j dV` with `g = (∂_r R, ∂_z R, R / r)`
/// (theory Eq. E.12).
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

/// Adds one element's blocks to the columns of one node: `column` is the stretch of matrix values that holds them, one
/// component after the other, each from its diagonal entry down.
///
/// `own` is the node's place in the element, `offset` gives for every node the distance of its first row from the first
/// row of the node's first column. `G` rows of products make `D` displacement components.
pub(crate) fn add_columns<const D: usize, const G: usize>(
    element: &ElementProducts,
    own: usize,
    unknowns: &Unknowns,
    offset: &[u32],
    column: &mut [f64],
    block: impl Fn(&[[f64; G]; G]) -> [[f64; D]; D],
) {
    let n = element.nodes.len();
    let held = |node: u32| unknowns.first_component[node as usize] as usize;
    let own_held = held(element.nodes[own]);
    let mut columns = split_columns::<D>(column, own_held);
    let products: [&[f64]; G] = std::array::from_fn(|j| &element.gradients[G * n * (G * own + j)..][..G * n]);
    let block_at = |a: usize| {
        let h: [[f64; G]; G] = std::array::from_fn(|i| std::array::from_fn(|j| products[j][G * a + i]));
        block(&h)
    };
    let diagonal = block_at(own);
    for (j, values) in columns.iter_mut().enumerate().skip(own_held) {
        for i in j..D {
            values[i - j] += diagonal[i][j];
        }
    }
    for a in own + 1..n {
        let block = block_at(a);
        let node = element.nodes[a];
        let (row, first) = (offset[node as usize] as usize, held(node));
        for (j, values) in columns.iter_mut().enumerate().skip(own_held) {
            // Column j starts at its own diagonal entry, j - own_held rows below that of the node's first column.
            let values = &mut values[row + own_held - j..];
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

/// Cuts the values of a node's columns into one slice a component; a held component has an empty one.
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
