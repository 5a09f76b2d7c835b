//! What two equal results may still differ in: signs of quaternions and of modes, and the choice
//! among modes of one frequency.

/// Frequencies closer than this, relative, belong to one eigenspace: rounding of an eigensolver
/// mixes their modes.
const SAME_FREQUENCY: f64 = 1e-5;

/// Turns the sign of quaternions so that each continues the one before; the first one gets a
/// positive product with `first`.
pub fn quaternions(values: &mut [f64], first: &[f64]) {
    let mut before = [0.0; 4];
    for (k, x) in before.iter_mut().zip(first) {
        *k = *x;
    }
    for row in values.chunks_exact_mut(4) {
        let product: f64 = row.iter().zip(&before).map(|(a, b)| a * b).sum();
        if product < 0.0 {
            row.iter_mut().for_each(|x| *x = -*x);
        }
        before.copy_from_slice(row);
    }
}

/// Rows of elastic coordinates with their instants.
pub struct Coordinates<'a> {
    /// Instants \[s\].
    pub times: &'a [f64],
    /// Numbers in the order of rows.
    pub values: &'a mut [f64],
}

/// Replaces the coordinates of each set of modes with one frequency by their norm, and turns the
/// sign of every other mode of `new` to that of `reference`.
pub fn modes(reference: &mut Coordinates<'_>, new: &mut Coordinates<'_>, frequencies: &[f64]) {
    let width = frequencies.len();
    let mut start = 0;
    for end in 1..=width {
        let is_same = |i: usize| frequencies[i] - frequencies[i - 1] <= SAME_FREQUENCY * frequencies[i].abs();
        if end < width && is_same(end) {
            continue;
        }
        if end - start > 1 {
            norms(reference.values, width, start..end);
            norms(new.values, width, start..end);
        } else if product(reference, new, width, start) < 0.0 {
            new.values.iter_mut().skip(start).step_by(width).for_each(|x| *x = -*x);
        }
        start = end;
    }
}

fn norms(values: &mut [f64], width: usize, columns: std::ops::Range<usize>) {
    for row in values.chunks_exact_mut(width) {
        let norm = row[columns.clone()].iter().map(|x| x * x).sum::<f64>().sqrt();
        row[columns.clone()].fill(0.0);
        row[columns.start] = norm;
    }
}

/// Sum of products of a column at the instants of the reference, with the sample of `new` that
/// follows each.
fn product(reference: &Coordinates<'_>, new: &Coordinates<'_>, width: usize, column: usize) -> f64 {
    let last = new.times.len().saturating_sub(1);
    let at = |t: f64| new.times.partition_point(|x| *x < t).min(last);
    let rows = reference.times.iter().zip(reference.values.chunks_exact(width));
    rows.filter_map(|(t, row)| new.values.get(at(*t) * width + column).map(|v| v * row[column]))
        .filter(|p| p.is_finite())
        .sum()
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact by construction")]
mod tests {
    use super::*;

    #[test]
    fn quaternions_become_continuous() {
        let mut values = [1.0, 0.0, 0.0, 0.0, -0.9, 0.1, 0.0, 0.0, 0.8, -0.2, 0.0, 0.0];
        quaternions(&mut values, &[-1.0, 0.0, 0.0, 0.0]);
        assert_eq!(values, [-1.0, 0.0, 0.0, 0.0, -0.9, 0.1, 0.0, 0.0, -0.8, 0.2, 0.0, 0.0]);
    }

    #[test]
    fn mode_signs_and_rotations_among_equal_frequencies_make_no_difference() {
        let times = [0.0, 1.0];
        let mut a = [1.0, 3.0, 4.0, 2.0, 6.0, 8.0];
        let mut b = [-1.0, 5.0, 0.0, -2.0, 0.0, -10.0];
        let mut reference = Coordinates { times: &times, values: &mut a };
        let mut new = Coordinates { times: &times, values: &mut b };
        modes(&mut reference, &mut new, &[10.0, 20.0, 20.0]);
        assert_eq!(a, [1.0, 5.0, 0.0, 2.0, 10.0, 0.0]);
        assert_eq!(b, a);
    }
}
