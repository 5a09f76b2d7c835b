//! Coefficients of a coarser space in a finer one (theory Eq. H.8).

use std::collections::HashMap;

use super::domain::{Leaf, Level};
use super::index_box::{IndexBox, covers};
use super::space::HierarchicalSpace;
use super::two_scale::TwoScale;
use crate::SplineError;
use crate::nurbs::jet::diagonal;
use crate::space::{Space, SplineSpace};

/// Difference of control points (relative to the body) and of weights above which the geometries
/// are not the same: round-off of nets with twelve good digits.
const SAME_GEOMETRY: f64 = 1e-9;

/// The matrix `P` with `R_j^coarse = Σ_i P_ij R_i^fine`: fine coefficients are `P` times coarse
/// ones. Rows sum to one.
#[derive(Debug, Clone)]
pub struct Prolongation {
    n_coarse: usize,
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Prolongation {
    /// Prolongation from a space over patches to one that contains it.
    ///
    /// The levels need not be the same: every region of the coarser space must lie in a region of
    /// the finer one whose knots contain its knots. So a plain patch, a globally refined one and
    /// hierarchies over either may be mixed.
    ///
    /// # Errors
    /// [`SplineError::NotContained`] if the finer space does not contain the coarser one or is of another geometry.
    pub fn between(coarse: &HierarchicalSpace, fine: &HierarchicalSpace) -> Result<Self, SplineError> {
        let mut relations = Relations { coarse, fine, known: HashMap::new() };
        relations.check_regions()?;
        let mut p =
            Self { n_coarse: coarse.n_functions(), starts: vec![0], columns: Vec::new(), values: Vec::new() };
        let mut shares = Vec::new();
        for place in places(fine)? {
            let Place { patch, level, index, leaf, weight } = place;
            let e = coarse.find_element(patch, &middle(fine, patch, &leaf));
            relations.column(patch, &coarse.leaf(e), (level, &index), &mut shares)?;
            let functions = coarse.functions_on(e);
            let values = if coarse.is_single_level(e) {
                functions
                    .iter()
                    .zip(&shares)
                    .map(|(&g, share)| share * coarse.weights()[g as usize])
                    .collect()
            } else {
                coarse.combined(e, &shares)
            };
            for (&g, value) in functions.iter().zip(values) {
                if value > 0.0 {
                    p.columns.push(g);
                    p.values.push(value / weight);
                }
            }
            p.starts.push(p.columns.len());
        }
        p.check_geometry(coarse, fine)?;
        Ok(p)
    }

    /// Number of functions of the finer space.
    pub fn n_fine(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of functions of the coarser space.
    pub fn n_coarse(&self) -> usize {
        self.n_coarse
    }

    /// Coarse functions and coefficients of fine function `i`.
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let range = self.starts[i]..self.starts[i + 1];
        (&self.columns[range.clone()], &self.values[range])
    }

    /// `P x` for vectors of `N` components per function, such as displacements.
    ///
    /// # Panics
    /// If `x` has not one entry a coarse function.
    pub fn apply<const N: usize>(&self, x: &[[f64; N]]) -> Vec<[f64; N]> {
        assert_eq!(x.len(), self.n_coarse, "one entry a coarse function");
        let row = |i| {
            let (columns, values) = self.row(i);
            let mut sum = [0.0; N];
            for (&j, v) in columns.iter().zip(values) {
                for (s, c) in sum.iter_mut().zip(&x[j as usize]) {
                    *s += v * c;
                }
            }
            sum
        };
        (0..self.n_fine()).map(row).collect()
    }

    /// Weights and control points must be prolonged to those of the finer space.
    fn check_geometry(
        &self,
        coarse: &HierarchicalSpace,
        fine: &HierarchicalSpace,
    ) -> Result<(), SplineError> {
        let size = diagonal(fine.control_points());
        let points = self.apply(coarse.control_points());
        for (i, (x, y)) in points.iter().zip(fine.control_points()).enumerate() {
            let sum: f64 = self.row(i).1.iter().sum();
            let apart = (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>().sqrt();
            if !((sum - 1.0).abs() <= SAME_GEOMETRY && apart <= SAME_GEOMETRY * size) {
                return Err(SplineError::NotContained(format!(
                    "the geometries differ, control point {i} lies {apart:.3e} m off and its weight is {sum} times the other one"
                )));
            }
        }
        Ok(())
    }
}

/// Where a function of the finer space is looked at: a leaf of its own level in its support, in one
/// of the patches that it belongs to.
struct Place {
    patch: usize,
    level: usize,
    index: [usize; 3],
    leaf: Leaf,
    weight: f64,
}

/// The first such place of every function.
fn places(fine: &HierarchicalSpace) -> Result<Vec<Place>, SplineError> {
    let mut places: Vec<Option<Place>> = (0..fine.n_functions()).map(|_| None).collect();
    for patch in 0..fine.n_patches() {
        let levels = fine.basis(patch).hierarchy().levels();
        for (f, level, index, weight) in fine.active_of(patch) {
            let place = &mut places[f as usize];
            if place.is_none()
                && let Some(leaf) = leaf_of_function(&levels[level], level, &index)
            {
                *place = Some(Place { patch, level, index, leaf, weight });
            }
        }
    }
    let found = places.into_iter().enumerate().map(|(f, place)| {
        let (level, index) = fine.level_and_index(f as u32);
        place.ok_or_else(|| {
            let fault = format!("function {index:?} of level {level} has no element of its level");
            SplineError::NotContained(fault)
        })
    });
    found.collect()
}

/// Two-scale relations between levels of the two spaces in a patch, made when first asked for.
struct Relations<'a> {
    coarse: &'a HierarchicalSpace,
    fine: &'a HierarchicalSpace,
    known: HashMap<[usize; 3], Result<Vec<TwoScale>, SplineError>>,
}

impl Relations<'_> {
    fn get(&mut self, patch: usize, coarse: usize, fine: usize) -> Result<&[TwoScale], SplineError> {
        let from = self.coarse.basis(patch).hierarchy().levels()[coarse].knots();
        let to = self.fine.basis(patch).hierarchy().levels()[fine].knots();
        let make = || from.iter().zip(to).map(|(a, b)| TwoScale::between(a, b)).collect();
        match self.known.entry([patch, coarse, fine]).or_insert_with(make) {
            Ok(list) => Ok(list),
            Err(fault) => Err(SplineError::NotContained(fault.to_string())),
        }
    }

    /// Every coarse region must lie in the region of the first fine level whose knots contain its
    /// knots.
    fn check_regions(&mut self) -> Result<(), SplineError> {
        let (coarse, fine) = (self.coarse, self.fine);
        if coarse.dimension() != fine.dimension() {
            let fault = format!("{} directions in {}", coarse.dimension(), fine.dimension());
            return Err(SplineError::NotContained(fault));
        }
        if coarse.n_patches() != fine.n_patches() {
            let fault =
                format!("it has {} patches, the coarser one {}", fine.n_patches(), coarse.n_patches());
            return Err(SplineError::NotContained(fault));
        }
        for patch in 0..coarse.n_patches() {
            let fine_levels = fine.basis(patch).hierarchy().levels();
            for (k, level) in coarse.basis(patch).hierarchy().levels().iter().enumerate() {
                let Some(m) = (0..fine_levels.len()).find(|&m| self.get(patch, k, m).is_ok()) else {
                    let fault = format!("no level has the knots of level {k} of the coarser space");
                    return Err(SplineError::NotContained(fault));
                };
                for b in level.region() {
                    if !covers(fine_levels[m].region(), &same_box(level, b, &fine_levels[m])) {
                        return Err(SplineError::NotContained(format!(
                            "level {m} does not reach over elements {:?} up to {:?} of level {k} of the coarser space",
                            b.lower, b.upper
                        )));
                    }
                }
            }
        }
        Ok(())
    }

    /// Coefficients of the coarse B-splines on a coarse leaf of `patch` in a fine function of the
    /// level and index given.
    fn column(
        &mut self,
        patch: usize,
        leaf: &Leaf,
        (level, index): (usize, &[usize; 3]),
        out: &mut Vec<f64>,
    ) -> Result<(), SplineError> {
        let here = IndexBox { lower: leaf.index, upper: leaf.index.map(|i| i + 1) };
        let functions = self.coarse.basis(patch).hierarchy().levels()[leaf.level].functions_on(&here);
        let relations = self.get(patch, leaf.level, level)?;
        out.clear();
        out.extend(functions.elements().map(|i| {
            relations.iter().enumerate().map(|(d, r)| r.coefficient(i[d], index[d])).product::<f64>()
        }));
        Ok(())
    }
}

/// The elements of `to` that fill box `b` of elements of `from`, whose breaks are breaks of `to`.
fn same_box(from: &Level, b: &IndexBox, to: &Level) -> IndexBox {
    let mut same = *b;
    for (d, (f, t)) in from.knots().iter().zip(to.knots()).enumerate() {
        same.lower[d] = t.find_element(f.element(b.lower[d]).0);
        let (inside, end) = f.element(b.upper[d] - 1);
        same.upper[d] = if end >= t.domain().1 { t.n_elements() } else { t.find_element(end) };
        debug_assert!(inside < end);
    }
    same
}

/// A leaf of a function's own level in its support: there its own B-spline stands in no other
/// function. None in a patch that is refined wherever the function is not zero.
fn leaf_of_function(level: &Level, number: usize, index: &[usize; 3]) -> Option<Leaf> {
    let is_leaf = |e: &[usize; 3]| !level.refined().iter().any(|b| b.holds(e));
    let index = level.support(index).elements().find(is_leaf)?;
    Some(Leaf { level: number, index })
}

/// Centre of a leaf of a patch in parameters.
fn middle(space: &HierarchicalSpace, patch: usize, leaf: &Leaf) -> [f64; 3] {
    let mut xi = [0.0; 3];
    for (d, k) in space.basis(patch).hierarchy().levels()[leaf.level].knots().iter().enumerate() {
        let (a, b) = k.element(leaf.index[d]);
        xi[d] = 0.5 * (a + b);
    }
    xi
}
