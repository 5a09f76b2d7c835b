//! Sparse matrices and unknowns as another program lists them: any order, one triangle or both
//! (docs/body-file.md).

use faer::sparse::{SparseColMat, Triplet};

use super::assembled::Dof;
use crate::data_error::{DataError, EntryFault};
use crate::error::DynamicsError;

/// Deviation from symmetry of a given matrix, against the root of the product of both diagonal
/// entries: files written with single precision or summed in another order.
const ASYMMETRY: f64 = 1e-6;

/// Which entries of a symmetric matrix are listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Triangle {
    /// Entries on and below the diagonal.
    Lower,
    /// All.
    Full,
}

/// Lower triangle of the symmetric `n x n` matrix called `name` in messages, from entries (row,
/// column, value) in any order; repeated entries add up. Of full matrices the mean of both
/// triangles is taken, which changes no bit where they agree.
///
/// # Errors
/// [`DynamicsError::Data`] with the entry if an index is too large, a value is not finite, an entry lies above the
/// diagonal of a lower triangle, or the matrix is not symmetric.
pub fn symmetric_matrix(
    name: &str,
    n: usize,
    entries: impl Iterator<Item = (u32, u32, f64)>,
    triangle: Triangle,
) -> Result<SparseColMat<u32, f64>, DynamicsError> {
    let fail = |row: u32, column: u32, fault: EntryFault| {
        let (row, column) = (row as usize, column as usize);
        Err(DataError::Entry { matrix: name.to_owned(), row, column, fault }.into())
    };
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    for (i, j, value) in entries {
        if i as usize >= n || j as usize >= n {
            return fail(i, j, EntryFault::Outside(n));
        }
        if !value.is_finite() {
            return fail(i, j, EntryFault::NotFinite(value));
        }
        match (i >= j, triangle) {
            (true, _) => lower.push(Triplet::new(i, j, value)),
            (false, Triangle::Full) => upper.push(Triplet::new(j, i, value)),
            (false, Triangle::Lower) => {
                return fail(i, j, EntryFault::AboveDiagonal);
            }
        }
    }
    let assemble = |entries: &[Triplet<u32, u32, f64>]| {
        SparseColMat::try_new_from_triplets(n, n, entries)
            .map_err(|source| DynamicsError::Assembly { matrix: name.to_owned(), source })
    };
    if triangle == Triangle::Lower {
        return assemble(&lower);
    }
    // Entries of one triangle alone are zero in the other, which the test of symmetry then finds.
    let zeros = |of: &[Triplet<u32, u32, f64>]| -> Vec<_> {
        of.iter().filter(|t| t.row != t.col).map(|t| Triplet::new(t.row, t.col, 0.0)).collect()
    };
    let (more_below, more_above) = (zeros(&upper), zeros(&lower));
    lower.extend(more_below);
    upper.extend(more_above);
    let (mut below, above) = (assemble(&lower)?, assemble(&upper)?);
    let diagonal: Vec<f64> = (0..n).map(|j| entry(&below, j, j).abs()).collect();
    for j in 0..n {
        for p in below.symbolic().col_range(j) {
            let i = below.row_idx()[p] as usize;
            if i == j {
                continue;
            }
            let (value, mirrored) = (below.val()[p], entry(&above, i, j));
            if (value - mirrored).abs() > ASYMMETRY * (diagonal[i] * diagonal[j]).sqrt() {
                let (matrix, row, column) = (name.to_owned(), i, j);
                return Err(DataError::Asymmetric { matrix, row, column, value, mirrored }.into());
            }
            below.val_mut()[p] = 0.5 * (value + mirrored);
        }
    }
    Ok(below)
}

/// Entry `(i, j)` of a matrix with sorted columns, zero where nothing is stored.
fn entry(matrix: &SparseColMat<u32, f64>, i: usize, j: usize) -> f64 {
    let range = matrix.symbolic().col_range(j);
    let rows = &matrix.row_idx()[range.clone()];
    rows.binary_search(&(i as u32)).map_or(0.0, |at| matrix.val()[range.start + at])
}

/// Sorts unknowns by node and component; `numbers[k]` is the new number of the unknown listed as
/// `k`.
///
/// # Errors
/// [`DynamicsError::Data`] if an unknown is listed twice.
pub fn sorted_unknowns(listed: &[Dof]) -> Result<(Vec<Dof>, Vec<u32>), DynamicsError> {
    let mut order: Vec<usize> = (0..listed.len()).collect();
    order.sort_by_key(|&k| (listed[k].node, listed[k].component));
    let sorted: Vec<Dof> = order.iter().map(|&k| listed[k]).collect();
    if let Some(twice) = sorted.windows(2).find(|w| w[0] == w[1]) {
        let what = format!("unknowns of component {}, node", twice[0].component);
        return Err(DataError::Index { what, number: twice[0].node as usize, count: listed.len() }.into());
    }
    let mut numbers = vec![0; listed.len()];
    order.iter().enumerate().for_each(|(new, &old)| numbers[old] = new as u32);
    Ok((sorted, numbers))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_triangles_and_one_give_the_same_matrix_bit_by_bit() {
        let lower = [(0, 0, 2.0), (2, 1, -0.3), (1, 1, 3.0), (2, 2, 0.1), (2, 2, 0.2)];
        let full: Vec<_> = lower
            .iter()
            .flat_map(|&(i, j, v)| if i == j { vec![(i, j, v)] } else { vec![(j, i, v), (i, j, v)] })
            .collect();
        let a = symmetric_matrix("K", 3, lower.into_iter(), Triangle::Lower).unwrap();
        let b = symmetric_matrix("K", 3, full.into_iter(), Triangle::Full).unwrap();
        assert_eq!(a.val(), b.val());
        assert_eq!(a.row_idx(), b.row_idx());
    }

    #[test]
    fn faulty_entries_are_named() {
        let refused = |entries: &[(u32, u32, f64)], triangle| {
            symmetric_matrix("K", 2, entries.iter().copied(), triangle).unwrap_err().to_string()
        };
        let diagonal = [(0, 0, 1.0), (1, 1, 1.0)];
        let with = |e| [&diagonal[..], &[e]].concat();
        assert!(refused(&with((2, 0, 1.0)), Triangle::Full).contains("K[2, 0] lies outside"));
        assert!(refused(&with((1, 0, f64::NAN)), Triangle::Full).contains("K[1, 0] = NaN"));
        assert!(refused(&with((0, 1, 1.0)), Triangle::Lower).contains("above the diagonal"));
        assert!(
            refused(&with((0, 1, 0.5)), Triangle::Full)
                .contains("not symmetric: K[1, 0] = 0e0, K[0, 1] = 5e-1")
        );
        assert!(refused(&with((1, 0, 0.5)), Triangle::Full).contains("not symmetric"));
    }

    #[test]
    fn unknowns_are_sorted_and_numbered() {
        let dof = |node, component| Dof { node, component };
        let listed = [dof(0, 0), dof(1, 0), dof(0, 1), dof(1, 1)];
        let (sorted, numbers) = sorted_unknowns(&listed).unwrap();
        assert!(sorted.is_sorted_by_key(|d| (d.node, d.component)));
        assert!(listed.iter().zip(&numbers).all(|(d, n)| sorted[*n as usize] == *d));
        assert!(sorted_unknowns(&[dof(0, 0), dof(0, 0)]).is_err());
    }
}
