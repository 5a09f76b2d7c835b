//! Numbers, control points and weights of the functions of a rational space (theory Eq. H.7, section H.5).

use super::basis::HierarchicalBasis;
use super::ties::PatchTies;
use super::two_scale::TwoScale;
use crate::SplineError;
use crate::nurbs::Patch;

/// How active functions become functions of the space.
#[derive(Debug, Clone)]
pub(super) struct Numbering {
    /// Function of the space for every active function.
    pub(super) functions: Vec<u32>,
    /// Weight of every active function.
    pub(super) weights: Vec<f64>,
    /// First active function of every function of the space.
    pub(super) representatives: Vec<u32>,
    /// Control point of every function of the space \[m\].
    pub(super) control_points: Vec<[f64; 3]>,
}

impl Numbering {
    /// Numbers the active functions, tied ones once, in their order.
    ///
    /// # Errors
    /// [`SplineError::Levels`] if the levels do not refine the patch.
    pub(super) fn new(
        patch: &Patch,
        basis: &HierarchicalBasis,
        ties: &PatchTies,
    ) -> Result<Self, SplineError> {
        let (points, weights) = net_of_active(patch, basis)?;
        let first = ties.first_of_group(basis);
        let (mut functions, mut representatives) = (vec![0; first.len()], Vec::new());
        for (f, &g) in first.iter().enumerate() {
            if f == g as usize {
                functions[f] = representatives.len() as u32;
                representatives.push(g);
            } else {
                functions[f] = functions[g as usize];
            }
        }
        let control_points = representatives.iter().map(|&f| points[f as usize]).collect();
        Ok(Self { functions, weights, representatives, control_points })
    }
}

/// Control points and weights of all active functions: for each the coefficient of the patch's homogeneous map in the
/// B-splines of its own level (H.7).
fn net_of_active(patch: &Patch, basis: &HierarchicalBasis) -> Result<(Vec<[f64; 3]>, Vec<f64>), SplineError> {
    let sizes = patch.net_size();
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (l, level) in basis.hierarchy().levels().iter().enumerate() {
        let relations: Result<Vec<_>, _> =
            patch.knots().iter().zip(level.knots()).map(|(c, f)| TwoScale::between(c, f)).collect();
        let (relations, own) = (relations?, level.net_size());
        for &flat in basis.active_on_level(l) {
            let index = crate::tensor::multi_index(&own, flat);
            let mut sum = [0.0; 4];
            for_each_coarse(&relations, &index, |coarse, share| {
                let a = crate::tensor::flat_index(&sizes, &coarse[..sizes.len()]);
                let (w, x) = (share * patch.weights()[a], patch.control_points()[a]);
                for (s, v) in sum.iter_mut().zip([w * x[0], w * x[1], w * x[2], w]) {
                    *s += v;
                }
            });
            points.push([sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]]);
            weights.push(sum[3]);
        }
    }
    Ok((points, weights))
}

/// Calls `visit(coarse index, coefficient)` for the coarse tensor-product functions that meet fine function `index`.
fn for_each_coarse(relations: &[TwoScale], index: &[usize; 3], mut visit: impl FnMut([usize; 3], f64)) {
    let rows: [(usize, &[f64]); 3] =
        std::array::from_fn(|d| relations.get(d).map_or((0, &[1.0][..]), |r| r.row(index[d])));
    for (k, c) in rows[2].1.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        for (j, b) in rows[1].1.iter().enumerate().filter(|(_, b)| **b != 0.0) {
            for (i, a) in rows[0].1.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                visit([rows[0].0 + i, rows[1].0 + j, rows[2].0 + k], a * b * c);
            }
        }
    }
}
