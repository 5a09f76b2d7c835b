//! Frequencies of free bodies by the Ritz method with polynomials over the whole body: an answer that shares no mesh, no basis
//! and no eigensolver with the program.
//!
//! Boxes have products of Legendre polynomials (Visscher, Migliori, Bell & Reinert 1991, *J. Acoust. Soc. Am.* 90), eight
//! parities apart. Bodies of revolution have polynomials across and along and one harmonic around at a time. Both converge
//! faster than any power of the order, from above.

use std::f64::consts::TAU;

use iga_core::elasticity::Material;
use nalgebra::{DMatrix, SymmetricEigen};

/// Gauss points and weights on [-1, 1].
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let nodes = (0..n).map(|i| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        // Newton's iteration doubles its digits: five rounds from three digits.
        for _ in 0..8 {
            let p = legendre(n + 1, x);
            x -= p[n].0 / p[n].1;
        }
        (x, 2.0 / ((1.0 - x * x) * legendre(n + 1, x)[n].1.powi(2)))
    });
    nodes.collect()
}

/// The first `n` Legendre polynomials and their derivatives at `x`.
fn legendre(n: usize, x: f64) -> Vec<(f64, f64)> {
    let mut p = vec![(1.0, 0.0), (x, 1.0)];
    for k in 2..n.max(2) {
        let ((a, da), (b, _)) = (p[k - 2], p[k - 1]);
        let kf = k as f64;
        p.push((((2.0 * kf - 1.0) * x * b - (kf - 1.0) * a) / kf, da + (2.0 * kf - 1.0) * b));
    }
    p.truncate(n);
    p
}

/// Eigenfrequencies \[Hz\] of `K x = ω² M x`; what round-off leaves of rigid motions counts as zero.
fn frequencies(k: &DMatrix<f64>, m: &DMatrix<f64>) -> Vec<f64> {
    let scale: Vec<f64> = (0..m.nrows()).map(|i| 1.0 / m[(i, i)].sqrt()).collect();
    let scaled =
        |a: &DMatrix<f64>| DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * scale[i] * scale[j]);
    let l = scaled(m).cholesky().expect("independent polynomials").l();
    let half = l.solve_lower_triangular(&scaled(k)).expect("regular");
    let reduced = l.solve_lower_triangular(&half.transpose()).expect("regular");
    let reduced = 0.5 * (&reduced + reduced.transpose());
    SymmetricEigen::new(reduced).eigenvalues.iter().map(|w| w.max(0.0).sqrt() / TAU).collect()
}

/// The `n` lowest of `found` behind `rigid` zeros.
fn lowest(mut found: Vec<f64>, rigid: usize, n: usize) -> Vec<f64> {
    found.sort_by(f64::total_cmp);
    found.into_iter().skip(rigid).take(n).collect()
}

fn lame(material: &Material) -> (f64, f64) {
    let (e, nu) = (material.youngs_modulus(), material.poissons_ratio());
    (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
}

/// The `n` lowest frequencies \[Hz\] of a free box with polynomials below the `orders`.
pub fn cuboid(size: [f64; 3], material: &Material, orders: [usize; 3], n: usize) -> Vec<f64> {
    let groups = (0..8).flat_map(|parity| box_group(size, material, orders, parity));
    lowest(groups.collect(), 6, n)
}

/// Of a box, the frequencies of motions whose component `c` has the parity of bit `d` of `parity`, turned over for `c = d`, along `d`.
fn box_group(size: [f64; 3], material: &Material, orders: [usize; 3], parity: usize) -> Vec<f64> {
    let (lambda, mu) = lame(material);
    let mut functions = Vec::new();
    for c in 0..3 {
        let start = |d: usize| (parity >> d & 1) ^ usize::from(c == d);
        for i in (start(0)..orders[0]).step_by(2) {
            for j in (start(1)..orders[1]).step_by(2) {
                functions.extend((start(2)..orders[2]).step_by(2).map(|k| (c, [i, j, k])));
            }
        }
    }
    // ∫P_i P_j, ∫P_i' P_j, ∫P_i' P_j' along direction d.
    let mass = |d: usize, i: usize, j: usize| if i == j { size[d] / (2 * i + 1) as f64 } else { 0.0 };
    let mixed = |i: usize, j: usize| if i > j && (i + j) % 2 == 1 { 2.0 } else { 0.0 };
    let slopes = |d: usize, i: usize, j: usize| {
        let low = i.min(j);
        if (i + j).is_multiple_of(2) { 2.0 / size[d] * (low * (low + 1)) as f64 } else { 0.0 }
    };
    // ∫ ∂_a φ ∂_b ψ.
    let product = |p: &[usize; 3], q: &[usize; 3], a: usize, b: usize| -> f64 {
        let factor = |d: usize| match (d == a, d == b) {
            (true, true) => slopes(d, p[d], q[d]),
            (true, false) => mixed(p[d], q[d]),
            (false, true) => mixed(q[d], p[d]),
            (false, false) => mass(d, p[d], q[d]),
        };
        (0..3).map(factor).product()
    };
    let n = functions.len();
    let k = DMatrix::from_fn(n, n, |i, j| {
        let ((a, p), (b, q)) = (&functions[i], &functions[j]);
        let shear = if a == b { (0..3).map(|d| product(p, q, d, d)).sum() } else { 0.0 };
        lambda * product(p, q, *a, *b) + mu * (product(p, q, *b, *a) + shear)
    });
    let m = DMatrix::from_fn(n, n, |i, j| {
        let ((a, p), (b, q)) = (&functions[i], &functions[j]);
        if a == b { material.density() * (0..3).map(|d| mass(d, p[d], q[d])).product::<f64>() } else { 0.0 }
    });
    frequencies(&k, &m)
}

/// A body of revolution with a rectangle as its section: a cylinder (`inner` zero), tube, ring or disc.
#[derive(Clone, Copy)]
pub struct Revolved {
    pub inner: f64,
    pub outer: f64,
    pub length: f64,
    /// Number of polynomials across and along.
    pub orders: [usize; 2],
}

/// A motion: amplitudes across, around and along as functions of the radius, each with its slope, and the number along.
struct Motion {
    /// At every Gauss point of the radius.
    across: Vec<[(f64, f64); 3]>,
    along: usize,
}

impl Revolved {
    /// The `n` lowest frequencies \[Hz\] of the free solid.
    pub fn solid(&self, material: &Material, n: usize) -> Vec<f64> {
        // Ten frequencies come in pairs: harmonics beyond the tenth are higher.
        let mut found = Vec::new();
        for harmonic in 0..=10 {
            for parity in 0..2 {
                let group = self.group(material, harmonic, parity);
                let copies = if harmonic == 0 { 1 } else { 2 };
                found.extend(group.iter().flat_map(|f| std::iter::repeat_n(*f, copies)));
            }
        }
        lowest(found, 6, n)
    }

    fn group(&self, material: &Material, harmonic: usize, parity: usize) -> Vec<f64> {
        let (lambda, mu) = lame(material);
        let [n_r, n_z] = self.orders;
        let radii = self.radii(2 * n_r + harmonic + 2);
        let heights = gauss(n_z + 1);
        let along: Vec<Vec<(f64, f64)>> = heights.iter().map(|(x, _)| legendre(n_z, *x)).collect();
        let motions = self.motions(&radii, harmonic, parity);
        let (n, m) = (motions.len(), harmonic as f64);
        let (mut stiffness, mut mass) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        for (i, (r, weight_r)) in radii.iter().enumerate() {
            for (values, (_, weight_z)) in along.iter().zip(&heights) {
                let weight = weight_r * weight_z * 0.5 * self.length;
                // Strains rr, tt, zz, rz, rt, tz, then displacements.
                let (mut strain, mut shift) = (DMatrix::zeros(6, n), DMatrix::zeros(3, n));
                for (j, motion) in motions.iter().enumerate() {
                    let [(u, du), (v, dv), (w, dw)] = motion.across[i];
                    let (p, dp) = values[motion.along];
                    let dp = 2.0 * dp / self.length;
                    let column = [
                        du * p,
                        (u + m * v) / r * p,
                        w * dp,
                        u * dp + dw * p,
                        (dv - (v + m * u) / r) * p,
                        v * dp - m * w / r * p,
                    ];
                    column.iter().enumerate().for_each(|(row, x)| strain[(row, j)] = *x);
                    [u, v, w].iter().enumerate().for_each(|(row, x)| shift[(row, j)] = x * p);
                }
                let elasticity = DMatrix::from_fn(6, 6, |a, b| {
                    let normal = if a < 3 && b < 3 { lambda } else { 0.0 };
                    normal + if a == b { if a < 3 { 2.0 * mu } else { mu } } else { 0.0 }
                });
                stiffness += weight * strain.transpose() * elasticity * &strain;
                mass += material.density() * weight * shift.transpose() * &shift;
            }
        }
        frequencies(&stiffness, &mass)
    }

    /// Gauss points of the radius, their weights times the radius.
    fn radii(&self, n: usize) -> Vec<(f64, f64)> {
        let (middle, half) = (0.5 * (self.outer + self.inner), 0.5 * (self.outer - self.inner));
        gauss(n).into_iter().map(|(x, w)| (middle + half * x, w * half * (middle + half * x))).collect()
    }

    fn motions(&self, radii: &[(f64, f64)], harmonic: usize, parity: usize) -> Vec<Motion> {
        let [n_r, n_z] = self.orders;
        let mut motions = Vec::new();
        for k in 0..n_r {
            let lists =
                if self.inner > 0.0 { self.of_ring(radii, k) } else { self.of_disc(radii, harmonic, k) };
            for (kind, across) in lists.into_iter().enumerate() {
                let start = if kind == 2 { 1 - parity } else { parity };
                let of_heights =
                    (start..n_z).step_by(2).map(|along| Motion { across: across.clone(), along });
                motions.extend(of_heights);
            }
        }
        motions
    }

    /// Legendre polynomials over the wall, for each component.
    fn of_ring(&self, radii: &[(f64, f64)], k: usize) -> [Vec<[(f64, f64); 3]>; 3] {
        let half = 0.5 * (self.outer - self.inner);
        let middle = 0.5 * (self.outer + self.inner);
        let value = |r: f64| {
            let (p, dp) = legendre(k + 1, (r - middle) / half)[k];
            (p, dp / half)
        };
        std::array::from_fn(|component| {
            let at = |(r, _): &(f64, f64)| {
                let mut all = [(0.0, 0.0); 3];
                all[component] = value(*r);
                all
            };
            radii.iter().map(at).collect()
        })
    }

    /// Even polynomials over the disc times the powers that regular fields have at its centre: `u + v` with `m + 1`, `u - v`
    /// with `|m - 1|`, `w` with `m`; without a harmonic `u` and `v` apart.
    fn of_disc(&self, radii: &[(f64, f64)], m: usize, k: usize) -> [Vec<[(f64, f64); 3]>; 3] {
        let value = |r: f64, power: usize| {
            let s = r / self.outer;
            let (p, dp) = legendre(k + 1, 2.0 * s * s - 1.0)[k];
            let (root, slope) = (s.powi(power as i32), power as f64 * s.powi(power as i32 - 1));
            (root * p, (slope * p + root * dp * 4.0 * s) / self.outer)
        };
        let negative = |(p, dp): (f64, f64)| (-p, -dp);
        let zero = (0.0, 0.0);
        let of = |at: &dyn Fn(f64) -> [(f64, f64); 3]| radii.iter().map(|(r, _)| at(*r)).collect::<Vec<_>>();
        if m == 0 {
            return [
                of(&|r| [value(r, 1), zero, zero]),
                of(&|r| [zero, value(r, 1), zero]),
                of(&|r| [zero, zero, value(r, 0)]),
            ];
        }
        [
            of(&|r| [value(r, m - 1), negative(value(r, m - 1)), zero]),
            of(&|r| [value(r, m + 1), value(r, m + 1), zero]),
            of(&|r| [zero, zero, value(r, m)]),
        ]
    }
}
