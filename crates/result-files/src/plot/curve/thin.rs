//! Thins a curve to what a picture can show.

/// Curve with at most four points in each of `columns` equal parts of its x range: first, lowest,
/// highest and last, so that peaks stay. A curve whose x does not rise, or that is short already,
/// is returned as it is.
pub fn thinned(x: &[f64], y: &[f64], columns: usize) -> (Vec<f64>, Vec<f64>) {
    let n = x.len().min(y.len());
    let rises = x[..n].windows(2).all(|w| w[0] <= w[1]);
    if n <= 4 * columns || !rises || columns == 0 {
        return (x[..n].to_vec(), y[..n].to_vec());
    }
    let width = (x[n - 1] - x[0]) / columns as f64;
    let column = |i: usize| (((x[i] - x[0]) / width) as usize).min(columns - 1);
    let mut keep = Vec::with_capacity(4 * columns);
    let mut start = 0;
    while start < n {
        let mut end = start;
        let (mut low, mut high) = (start, start);
        while end < n && column(end) == column(start) {
            low = if y[end] < y[low] { end } else { low };
            high = if y[end] > y[high] { end } else { high };
            end += 1;
        }
        let mut part = [start, low.min(high), low.max(high), end - 1].to_vec();
        part.dedup();
        keep.extend(part);
        start = end;
    }
    (keep.iter().map(|&i| x[i]).collect(), keep.iter().map(|&i| y[i]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_and_ends_survive() {
        let n = 100_000;
        let x: Vec<f64> = (0..n).map(|i| f64::from(i) / f64::from(n)).collect();
        let mut y: Vec<f64> = x.iter().map(|t| (40.0 * t).sin()).collect();
        (y[31_415], y[n as usize - 1]) = (7.0, -9.0);
        let (tx, ty) = thinned(&x, &y, 500);
        assert!(tx.len() <= 2000 && tx.len() > 500);
        assert!(tx.windows(2).all(|w| w[0] < w[1]));
        assert!(ty.contains(&7.0) && ty.contains(&-9.0) && tx.contains(&x[31_415]));
    }

    #[test]
    fn short_curves_stay() {
        assert_eq!(
            thinned(&[0.0, 1.0, 0.5], &[1.0, 2.0, 3.0], 1),
            (vec![0.0, 1.0, 0.5], vec![1.0, 2.0, 3.0])
        );
    }
}
