//! The strictly convex problem for the point forces.
//!
//! `min ½ λᵀ(A + D)λ + λᵀg⁰` over `λ >= 0` (docs/theory.md Eq. C.5): `A` is the normal compliance
//! of the points, `D` holds the compliances `1/(c_p w_i)` of the penalty springs, zero for the
//! exact constraint, and `g⁰` the gaps without quasistatic displacement. The gaps that come out are
//! `g = g⁰ + Aλ`.

use faer::Mat;

/// Gap that points have in the problem for the forces which nothing can press: farther than any
/// displacement brings them \[m\].
pub(crate) const OPEN: f64 = 1e6;

/// Data of one quasistatic contact problem.
#[derive(Debug, Clone, Copy)]
pub struct Problem<'a> {
    /// Normal compliance `A` of the points, `n × n`, symmetric positive semidefinite [m/N].
    pub compliance: &'a Mat<f64>,
    /// Compliances `1/(c_p w_i)` of the penalty springs; zero: exact constraint [m/N].
    pub springs: &'a [f64],
    /// Gaps `g⁰_i` without quasistatic displacement, negative in contact \[m\].
    pub gaps: &'a [f64],
}

/// Elastic energy of the contact zone and energy of the penalty springs \[J\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ProblemEnergies {
    /// `½ λᵀAλ` \[J\].
    pub elastic: f64,
    /// `Σ ½ λ_i²/(c_p w_i)` \[J\].
    pub penalty: f64,
}

impl Problem<'_> {
    /// Number of points.
    pub fn n_points(&self) -> usize {
        self.gaps.len()
    }

    /// Replaces `out` by the gaps `g⁰ + Aλ` with quasistatic displacement \[m\].
    pub fn deformed_gaps(&self, forces: &[f64], out: &mut [f64]) {
        out.copy_from_slice(self.gaps);
        add_product(self.compliance, forces, out);
    }

    /// Energies under `forces`, whose deformed gaps are `deformed` (Eq. C.7).
    pub fn energies(&self, forces: &[f64], deformed: &[f64]) -> ProblemEnergies {
        let mut energies = ProblemEnergies::default();
        for (i, &force) in forces.iter().enumerate() {
            energies.elastic += 0.5 * force * (deformed[i] - self.gaps[i]);
            energies.penalty += 0.5 * force * force * self.springs[i];
        }
        energies
    }

    /// Deepest penetration without quasistatic displacement, zero if no point penetrates, NaN if a
    /// gap is not finite \[m\].
    pub fn depth(&self) -> f64 {
        depth(self.gaps)
    }
}

/// `max(0, -min g)`; NaN if any gap is not finite.
pub(crate) fn depth(gaps: &[f64]) -> f64 {
    let mut deepest = 0.0;
    for &gap in gaps {
        if !gap.is_finite() {
            return f64::NAN;
        }
        deepest = f64::max(deepest, -gap);
    }
    deepest
}

/// Scalar product over the shorter list, in four sums: none waits for the other.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let ((a, rest_a), (b, rest_b)) = (a[..n].as_chunks::<4>(), b[..n].as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (x, y) in a.iter().zip(b) {
        (0..4).for_each(|k| sums[k] += x[k] * y[k]);
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// `out += matrix * x`; columns with `x_j = 0` left out.
pub(crate) fn add_product(matrix: &Mat<f64>, x: &[f64], out: &mut [f64]) {
    add_columns(matrix, x.iter().copied().enumerate().filter(|(_, factor)| *factor != 0.0), out);
}

/// Adds the columns `(number, factor)` of `matrix` to `out`.
pub(crate) fn add_columns(matrix: &Mat<f64>, columns: impl Iterator<Item = (usize, f64)>, out: &mut [f64]) {
    add_multiples(columns.map(|(j, factor)| (matrix.col_as_slice(j), factor)), out);
}

/// Adds the first entries of `columns` times their factors to `out`, four columns at a time: a sum is
/// loaded and stored once for them.
pub(crate) fn add_multiples<'a>(columns: impl Iterator<Item = (&'a [f64], f64)>, out: &mut [f64]) {
    let n = out.len();
    let (mut waiting, mut n_waiting) = ([(&[][..], 0.0); 4], 0);
    for (column, factor) in columns {
        waiting[n_waiting] = (&column[..n], factor);
        n_waiting += 1;
        if n_waiting == 4 {
            let [(a, x), (b, y), (c, z), (d, w)] = waiting;
            let (a, b, c, d) = (&a[..n], &b[..n], &c[..n], &d[..n]);
            for (k, o) in out.iter_mut().enumerate() {
                *o += (x * a[k] + y * b[k]) + (z * c[k] + w * d[k]);
            }
            n_waiting = 0;
        }
    }
    for (column, factor) in &waiting[..n_waiting] {
        out.iter_mut().zip(*column).for_each(|(o, a)| *o += a * factor);
    }
}
