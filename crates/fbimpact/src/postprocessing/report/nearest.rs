//! Nearest of many points.

/// Points sorted along x, so that a search ends where x alone is farther away than the best.
pub struct Nearest<'a> {
    points: &'a [[f64; 3]],
    order: Vec<u32>,
}

impl<'a> Nearest<'a> {
    /// Prepares the search among `points`.
    pub fn new(points: &'a [[f64; 3]]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        order.sort_by(|a, b| points[*a as usize][0].total_cmp(&points[*b as usize][0]));
        Self { points, order }
    }

    /// Number of the point nearest to `x`; none where there are no points.
    pub fn find(&self, x: &[f64; 3]) -> Option<usize> {
        let start = self.order.partition_point(|i| self.points[*i as usize][0] < x[0]);
        let mut best: Option<(f64, usize)> = None;
        let (before, after) = self.order.split_at(start);
        let sides: [&mut dyn Iterator<Item = &u32>; 2] = [&mut after.iter(), &mut before.iter().rev()];
        for side in sides {
            for &i in side {
                let p = &self.points[i as usize];
                let along = (p[0] - x[0]) * (p[0] - x[0]);
                if best.is_some_and(|(least, _)| along > least) {
                    break;
                }
                let square = along + (p[1] - x[1]) * (p[1] - x[1]) + (p[2] - x[2]) * (p[2] - x[2]);
                if best.is_none_or(|(least, _)| square < least) {
                    best = Some((square, i as usize));
                }
            }
        }
        best.map(|(_, i)| i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn search_finds_what_looking_at_all_finds() {
        let at = |i: usize| [(i as f64 * 0.7).sin(), (i as f64 * 1.3).cos(), (i as f64 * 2.1).sin()];
        let points: Vec<[f64; 3]> = (0..500).map(at).collect();
        let near = Nearest::new(&points);
        for k in 0..100 {
            let x = at(1000 + k).map(|c| 1.2 * c);
            let square = |p: &[f64; 3]| (0..3).map(|c| (p[c] - x[c]) * (p[c] - x[c])).sum::<f64>();
            let all = (0..500).min_by(|a, b| square(&points[*a]).total_cmp(&square(&points[*b])));
            assert_eq!(near.find(&x), all);
        }
        assert_eq!(Nearest::new(&[]).find(&[0.0; 3]), None);
    }
}
