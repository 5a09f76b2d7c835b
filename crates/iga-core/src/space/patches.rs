//! The space of one or more plain NURBS patches, with coincident boundary functions tied.

use super::tensor_basis::{LocalWeights, evaluate_tensor};
use super::tie::coincident;
use super::{Cell, Element, GridBasis, Integrand, Rows, Space, SplineSpace, tabulate_spline};
use crate::SplineError;
use crate::nurbs::Patch;
use crate::nurbs::interface::FaceId;
use crate::nurbs::jet::diagonal;
use crate::nurbs::patch::PointBasis;
use crate::splines::knots::KnotVector;
use crate::splines::tensor;

/// NURBS patches whose coincident boundary control points are one function each.
///
/// Two functions are tied if their control points coincide within 1e-9 of the body's size and both
/// lie on the boundary of their control net: poles, collapsed edges, seams and matching patch
/// interfaces. Interior control points are never tied. Interfaces must match in degree, knots and
/// weights; otherwise displacements are not continuous there.
#[derive(Debug, Clone)]
pub struct PatchSpace {
    patches: Vec<Patch>,
    /// First element of each patch; the last entry is the number of elements.
    first_element: Vec<usize>,
    /// Function of each net entry, patch by patch.
    functions: Vec<Vec<u32>>,
    control_points: Vec<[f64; 3]>,
    anchors: Vec<[f64; 3]>,
    /// Rows of elements on which several net entries are one function.
    rows: Rows,
    size: f64,
}

impl PatchSpace {
    /// Ties and numbers the functions of `patches`, net entry by net entry.
    ///
    /// # Errors
    /// [`SplineError::NetSize`] if there is no patch or a patch has another number of directions than the first.
    pub fn new(patches: Vec<Patch>) -> Result<Self, SplineError> {
        let dimension = patches.first().map_or(0, Patch::dimension);
        if let Some(odd) = patches.iter().find(|p| p.dimension() != dimension) {
            let found = odd.dimension();
            return Err(SplineError::NetSize { what: "directions", found, expected: dimension });
        }
        if patches.is_empty() {
            return Err(SplineError::NetSize { what: "patches", found: 0, expected: 1 });
        }
        let points: Vec<[f64; 3]> = patches.iter().flat_map(|p| p.control_points()).copied().collect();
        let on_boundary: Vec<bool> = patches.iter().flat_map(boundary_entries).collect();
        let first = coincident(&points, |i| on_boundary[i]);
        let (mut number, mut control_points, mut anchors) =
            (vec![0u32; points.len()], Vec::new(), Vec::new());
        let sizes = patches[0].net_size();
        for (i, &j) in first.iter().enumerate() {
            if i == j {
                number[i] = control_points.len() as u32;
                control_points.push(points[i]);
                let net = tensor::multi_index(&sizes, i).map(|k| k as f64);
                anchors.push(if patches.len() == 1 { net } else { points[i] });
            } else {
                number[i] = number[j];
            }
        }
        let (mut functions, mut first_element, mut rest) = (Vec::new(), vec![0], &number[..]);
        for patch in &patches {
            let (own, others) = rest.split_at(patch.n_functions());
            functions.push(own.to_vec());
            rest = others;
            first_element.push(first_element[first_element.len() - 1] + patch.n_elements());
        }
        let size = diagonal(&control_points);
        let rows = rows(&patches, &functions);
        Ok(Self { patches, first_element, functions, control_points, anchors, rows, size })
    }

    /// The patches.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// Function of every net entry of patch `patch`.
    pub fn functions(&self, patch: usize) -> &[u32] {
        &self.functions[patch]
    }

    /// Diagonal of the bounding box of the control points \[m\].
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Patch of element `e` and the element's number there.
    fn locate(&self, e: usize) -> (usize, usize) {
        let patch = self.first_element.partition_point(|&f| f <= e) - 1;
        (patch, e - self.first_element[patch])
    }
}

/// Rows of the elements on which several entries of the patches' nets are the same of their
/// `functions`: sums of these entries.
fn rows(patches: &[Patch], functions: &[Vec<u32>]) -> Rows {
    let (mut rows, mut entries) = (Rows::default(), Vec::new());
    for (patch, numbers) in patches.iter().zip(functions) {
        for e in 0..patch.n_elements() {
            entries.clear();
            patch.active_functions(e, &mut entries);
            let numbers: Vec<u32> = entries.iter().map(|&i| numbers[i as usize]).collect();
            let mut distinct = numbers.clone();
            distinct.sort_unstable();
            distinct.dedup();
            if distinct.len() == numbers.len() {
                rows.push_plain([]);
                continue;
            }
            let is_first = |(column, function): &(usize, &u32)| !numbers[..*column].contains(function);
            let of = |f: u32| {
                let columns = numbers.iter().enumerate().filter(move |(_, g)| **g == f);
                columns.map(|(column, _)| (column as u16, 1.0))
            };
            let first = numbers.iter().enumerate().filter(is_first);
            rows.push(first.map(|(_, &f)| (f, of(f))));
        }
    }
    rows
}

/// Element `e` of a patch, direction by direction.
fn element_index(patch: &Patch, mut e: usize) -> [usize; 3] {
    let mut index = [0; 3];
    for (slot, k) in index.iter_mut().zip(patch.knots()) {
        (*slot, e) = (e % k.n_elements(), e / k.n_elements());
    }
    index
}

/// For every net entry whether it lies on the boundary of the net.
fn boundary_entries(patch: &Patch) -> Vec<bool> {
    let sizes = patch.net_size();
    let is_end = |i: usize| {
        let index = tensor::multi_index(&sizes, i);
        sizes.iter().zip(index).any(|(&n, k)| k == 0 || k + 1 == n)
    };
    (0..patch.n_functions()).map(is_end).collect()
}

impl Space for PatchSpace {
    fn dimension(&self) -> usize {
        self.patches[0].dimension()
    }

    fn n_functions(&self) -> usize {
        self.control_points.len()
    }

    fn control_points(&self) -> &[[f64; 3]] {
        &self.control_points
    }

    fn anchors(&self) -> Vec<[f64; 3]> {
        self.anchors.clone()
    }

    fn n_elements(&self) -> usize {
        self.first_element[self.patches.len()]
    }

    fn element(&self, e: usize) -> Element {
        let (patch, local) = self.locate(e);
        let (lower, upper) = self.patches[patch].element(local);
        Element { patch, cell: Cell::Box, lower, upper }
    }

    fn tabulate(&self, e: usize, integrand: Integrand, out: &mut GridBasis) {
        tabulate_spline(self, e, integrand, out);
    }

    fn active_functions(&self, e: usize, out: &mut Vec<u32>) {
        out.clear();
        if !self.rows.is_plain(e) {
            out.extend_from_slice(self.rows.functions(e));
            return;
        }
        let (patch, local) = self.locate(e);
        self.patches[patch].active_functions(local, out);
        for entry in out.iter_mut() {
            *entry = self.functions[patch][*entry as usize];
        }
    }

    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis) {
        let (patch, local) = self.locate(e);
        self.patches[patch].evaluate(local, xi, n_derivatives, out);
        if !self.rows.is_plain(e) {
            out.combine(&self.rows, e);
        }
    }

    fn evaluate_grid(&self, e: usize, grid: [&[f64]; 3], out: &mut GridBasis) {
        let (patch, local) = self.locate(e);
        let patch = &self.patches[patch];
        let index = element_index(patch, local);
        let (mut strides, mut stride, mut corner) = ([0; 3], 1, 0);
        for (d, k) in patch.knots().iter().enumerate() {
            corner += stride * (k.element_span(index[d]) - k.degree());
            (strides[d], stride) = (stride, stride * k.n_functions());
        }
        let weights = &patch.weights()[corner..];
        evaluate_tensor(patch.knots(), index, &LocalWeights { weights, strides }, grid, out);
        if !self.rows.is_plain(e) {
            out.combine(&self.rows, e);
        }
    }
}

impl SplineSpace for PatchSpace {
    fn find_element(&self, patch: usize, xi: &[f64; 3]) -> usize {
        self.first_element[patch] + self.patches[patch].find_element(xi)
    }

    /// `p` where the spline is `C^(p-1)` on both sides of the element and no edge is collapsed;
    /// `p + 1` elsewhere and also for `p = 1` or a single element between two ends, where `p`
    /// points would leave energy-free motions.
    fn gauss_counts(&self, e: usize) -> [usize; 3] {
        let (patch, local) = self.locate(e);
        let patch = &self.patches[patch];
        let index = element_index(patch, local);
        let mut counts = [1; 3];
        for (d, k) in patch.knots().iter().enumerate() {
            let p = k.degree();
            let (lower, upper) = k.element(index[d]);
            let ends = k.domain();
            let is_rough = |u: f64| u > ends.0 && u < ends.1 && k.multiplicity(u) > 1;
            let full =
                !self.rows.is_plain(e) || p == 1 || k.n_elements() == 1 || is_rough(lower) || is_rough(upper);
            counts[d] = if full { p + 1 } else { p };
        }
        counts
    }

    fn greville(&self, face: FaceId) -> Vec<(u32, [f64; 3])> {
        let patch = &self.patches[face.patch];
        let sizes = patch.net_size();
        let abscissae: Vec<Vec<f64>> = patch.knots().iter().map(KnotVector::greville).collect();
        let layer = if face.upper { sizes[face.direction] - 1 } else { 0 };
        let entries = (0..patch.n_functions()).map(|net| (net, tensor::multi_index(&sizes, net)));
        entries
            .filter(|(_, index)| index[face.direction] == layer)
            .map(|(net, index)| {
                let place = |d: usize| abscissae.get(d).map_or(0.0, |own| own[index[d]]);
                (self.functions[face.patch][net], std::array::from_fn(place))
            })
            .collect()
    }
}
