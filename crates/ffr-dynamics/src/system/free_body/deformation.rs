//! Sums over the elastic coordinates of one body (docs/theory.md Eq. D.6, D.8, M.44, M.45).
//!
//! They are what an evaluation reads most memory for. Each is the product of a matrix, made once,
//! with the elastic coordinates or with their rates; of rates only those parts of moments are
//! summed that a turn about an axis leaves.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::Vector3;

use crate::body::StandardInputData;
use crate::body::foreshortening::Foreshortening;

/// Rows `∫ ρ (..)_a φ_jb - (..)_b φ_ja` about x, y and z.
const TURNS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// The matrices of one body. Columns are those of elastic coordinates `i`; rows come in blocks of
/// one for each mode `j`.
#[derive(Debug, Clone)]
pub(in crate::system) struct DeformationMaps {
    n_modes: usize,
    /// Rows by coordinates: moments `Q_j`, then, with geometric stiffening, the change `C_t,j`
    /// along x, y and z. Empty where the moments are those of [`StandardInputData`].
    by_coordinates: Vec<f64>,
    /// Rows by rates: axial vectors of the moments' rates, then, with geometric stiffening, those
    /// of `∫ ρ X g_ijᵀ`, then `∫ ρ g_ij`.
    by_rates: Vec<f64>,
    n_axes: usize,
    is_stiffened: bool,
}

impl DeformationMaps {
    pub fn new(data: &StandardInputData) -> Self {
        let (n_modes, n_c) = (data.n_modes(), data.motion.n_components());
        let size = data.position_shape.len();
        let axes = if n_c == 3 { &TURNS[..] } else { &TURNS[2..] };
        let mut maps = Self {
            n_modes,
            by_coordinates: Vec::new(),
            by_rates: Vec::new(),
            n_axes: axes.len(),
            is_stiffened: data.foreshortening.is_some(),
        };
        if size == 0 {
            return maps; // of models that do not turn or deform nothing is asked
        }
        let turned = |block: &[f64], (a, b): (usize, usize)| -> Vec<f64> {
            let row = |a: usize, b: usize| block[(a * n_c + b) * n_modes..][..n_modes].iter();
            row(a, b).zip(row(b, a)).map(|(forth, back)| forth - back).collect()
        };
        let moved = |g: &Foreshortening, i: usize, direction: usize| -> Vec<f64> {
            g.translation[i * n_modes..(i + 1) * n_modes].iter().map(|g| g[direction]).collect()
        };
        for (i, moments) in data.shape_shape.chunks_exact(size).enumerate() {
            axes.iter().for_each(|axis| maps.by_rates.extend(turned(moments, *axis)));
            if let Some(g) = &data.foreshortening {
                let bent = &g.position[i * size..(i + 1) * size];
                maps.by_coordinates.extend(moments.iter().zip(bent).map(|(m, g)| m + g));
                axes.iter().for_each(|axis| maps.by_rates.extend(turned(bent, *axis)));
                for direction in 0..3 {
                    maps.by_coordinates.extend(moved(g, i, direction));
                    maps.by_rates.extend(moved(g, i, direction));
                }
            }
        }
        maps
    }

    /// Space for the sums.
    pub fn sums(&self, data: &StandardInputData) -> DeformationSums {
        let (n, size) = (self.n_modes, data.position_shape.len());
        let n_moved = if self.is_stiffened && size > 0 { 3 * n } else { 0 };
        let n_turned = if size > 0 { self.n_axes * n } else { 0 };
        DeformationSums {
            size,
            n_turned,
            by_coordinates: vec![0.0; size + n_moved],
            by_rates: vec![0.0; if n_moved > 0 { 2 * n_turned + n_moved } else { n_turned }],
        }
    }

    /// All sums for the elastic coordinates `q` and their rates.
    pub fn sum(&self, data: &StandardInputData, q: &[f64], rates: &[f64], sums: &mut DeformationSums) {
        if sums.size == 0 {
            return;
        }
        let (moments, moved) = sums.by_coordinates.split_at_mut(sums.size);
        moments.copy_from_slice(&data.position_shape);
        moved.fill(0.0);
        let map = if self.is_stiffened { &self.by_coordinates } else { &data.shape_shape };
        add_product(map, q, &mut sums.by_coordinates);
        sums.by_rates.fill(0.0);
        add_product(&self.by_rates, rates, &mut sums.by_rates);
    }
}

/// Sums of one body in one motion.
#[derive(Debug, Clone)]
pub(in crate::system) struct DeformationSums {
    /// Number of moments.
    size: usize,
    n_turned: usize,
    by_coordinates: Vec<f64>,
    by_rates: Vec<f64>,
}

impl DeformationSums {
    /// `∫ ρ (X + u)_a φ_jb` at `(a n_c + b) n_q + j`, with geometric stiffening its part as well.
    pub fn moments(&self) -> &[f64] {
        &self.by_coordinates[..self.size]
    }

    /// Axial vector of `∫ ρ (du/dt) φ_jᵀ` along x, y, z or, in a plane, z alone: a block for each.
    pub fn moment_rates(&self) -> &[f64] {
        &self.by_rates[..self.n_turned]
    }

    /// Geometric stiffening: `Σ_i q_i ∫ ρ g_ij` by `j`, and the same for the rates.
    pub fn moved(&self, j: usize, n_modes: usize) -> [Vector3<f64>; 2] {
        let at = |rows: &[f64]| Vector3::from_fn(|c, _| rows[c * n_modes + j]);
        [at(&self.by_coordinates[self.size..]), at(&self.by_rates[2 * self.n_turned..])]
    }

    /// Geometric stiffening: axial vector of `Σ_i dq_i/dt ∫ ρ X g_ijᵀ`, blocks as those of
    /// [`DeformationSums::moment_rates`].
    pub fn turned(&self) -> &[f64] {
        &self.by_rates[self.n_turned..2 * self.n_turned]
    }
}

/// Adds the product of a matrix, column by column, with `x` to `out`.
fn add_product(matrix: &[f64], x: &[f64], out: &mut [f64]) {
    let n = out.len();
    matmul(
        MatMut::from_column_major_slice_mut(out, n, 1),
        Accum::Add,
        MatRef::from_column_major_slice(matrix, n, x.len()),
        MatRef::from_column_major_slice(x, x.len(), 1),
        1.0,
        Par::Seq,
    );
}

/// Scalar product over the shorter list.
pub(in crate::system) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four sums at a time do not wait for each other.
    let n = a.len().min(b.len());
    let ((a, a_rest), (b, b_rest)) = (a[..n].as_chunks::<4>(), b[..n].as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        (0..4).for_each(|k| sums[k] += a[k] * b[k]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
