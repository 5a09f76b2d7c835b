//! Index arithmetic of tensor-product nets with one to three directions; the first direction runs
//! fastest.

/// Total number of entries of a net.
pub fn count(sizes: &[usize]) -> usize {
    sizes.iter().product()
}

/// Flat index of a multi-index.
pub fn flat_index(sizes: &[usize], index: &[usize]) -> usize {
    sizes.iter().zip(index).rev().fold(0, |acc, (&n, &i)| acc * n + i)
}

/// Multi-index of a flat index; entries beyond `sizes` are zero.
pub fn multi_index(sizes: &[usize], mut flat: usize) -> [usize; 3] {
    let mut index = [0; 3];
    for (slot, &n) in index.iter_mut().zip(sizes) {
        *slot = flat % n;
        flat /= n;
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_index_and_multi_index_are_inverse() {
        let sizes = [3, 4, 2];
        for f in 0..count(&sizes) {
            assert_eq!(flat_index(&sizes, &multi_index(&sizes, f)), f);
        }
        assert_eq!(flat_index(&sizes, &[1, 2, 1]), 1 + 3 * (2 + 4));
    }
}
