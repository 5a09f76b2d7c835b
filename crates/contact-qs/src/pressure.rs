//! Contact pressure from point forces (docs/theory.md Eq. C.48).

use std::collections::HashMap;

use crate::points::SurfacePoint;
use crate::submodel::SparseRows;

/// Pressures of contact points from their forces.
///
/// Forces at Greville points are those whose nodal forces `Σ_j R_A(x_j) λ_j` are the nodal forces `∫ R_A p dA` of a pressure `p`. They
/// are not `p w_j` where Greville points and areas do not make a quadrature rule: beside repeated knots and at the axis they
/// alternate between a third and five quarters of it. Nodal forces over the areas `w_A = ∫ R_A dA` are means of `p`, weighted with `R_A`:
/// exact for a constant pressure on every net, smooth for a smooth one. What falls on points without force stays where it is. Gauss points make a quadrature rule; there it is force over area.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureRecovery {
    /// For every point the points among which its force is shared, with the shares.
    shares: SparseRows,
    areas: Vec<f64>,
    pressures: Vec<f64>,
}

impl PressureRecovery {
    /// The recovery at `points`. Shares of functions that are not among the points' own stay where they are, so that areas times
    /// pressures sum to the sum of the forces.
    pub fn new(points: &[SurfacePoint]) -> Self {
        let own: HashMap<u32, usize> =
            points.iter().enumerate().filter_map(|(i, p)| p.function.map(|f| (f, i))).collect();
        let mut shares = SparseRows::new(points.len());
        for (j, point) in points.iter().enumerate() {
            let known =
                |f: &(u32, f64)| own.get(&f.0).filter(|_| point.function.is_some()).map(|&a| (a, f.1));
            let mut row: Vec<(usize, f64)> = point.functions.iter().filter_map(known).collect();
            let rest = 1.0 - row.iter().map(|(_, share)| share).sum::<f64>();
            match row.iter_mut().find(|(a, _)| *a == j) {
                Some((_, share)) => *share += rest,
                None => row.push((j, rest)),
            }
            shares.push(row);
        }
        let n = points.len();
        Self { shares, areas: points.iter().map(|p| p.area).collect(), pressures: vec![0.0; n] }
    }

    /// Pressures of all points under the normal forces `forces` \[Pa\].
    ///
    /// # Panics
    /// If there is not one force per point.
    pub fn pressures(&mut self, forces: &[f64]) -> &[f64] {
        assert_eq!(forces.len(), self.areas.len(), "one force per contact point");
        self.pressures.fill(0.0);
        for (j, force) in forces.iter().enumerate().filter(|(_, force)| **force > 0.0) {
            for &(a, share) in self.shares.row(j) {
                // Points without force are beyond the edge of the contact.
                let taker = if forces[a] > 0.0 { a } else { j };
                self.pressures[taker] += share * force;
            }
        }
        self.pressures.iter_mut().zip(&self.areas).for_each(|(p, area)| *p /= area);
        &self.pressures
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of the quadratic functions on the knots 0 0 0 1 2 2 3 4 4 4, a double knot in the middle, with the forces of a constant pressure 1:
    /// those whose nodal forces are `∫ R_A dx`, worked out by hand.
    fn double_knot() -> (Vec<SurfacePoint>, Vec<f64>) {
        let point = |x: f64, own, area, functions: &[(u32, f64)]| SurfacePoint {
            position: [x, 0.0, 0.0],
            area,
            functions: functions.to_vec(),
            on_rim: false,
            function: Some(own),
            facing: None,
        };
        let third = 1.0 / 3.0;
        let points = vec![
            point(0.0, 0, third, &[(0, 1.0)]),
            point(0.5, 1, 2.0 * third, &[(0, 0.25), (1, 0.625), (2, 0.125)]),
            point(1.5, 2, 2.0 * third, &[(1, 0.125), (2, 0.625), (3, 0.25)]),
            point(2.0, 3, 2.0 * third, &[(3, 1.0)]),
            point(2.5, 4, 2.0 * third, &[(3, 0.25), (4, 0.625), (5, 0.125)]),
            point(3.5, 5, 2.0 * third, &[(4, 0.125), (5, 0.625), (6, 0.25)]),
            point(4.0, 6, third, &[(6, 1.0)]),
        ];
        // 0.625 f + 0.125 f = 2/3; ends and middle take what is left.
        let f = 8.0 / 9.0;
        let forces = vec![third - 0.25 * f, f, f, 2.0 * third - 0.5 * f, f, f, third - 0.25 * f];
        (points, forces)
    }

    #[test]
    fn constant_pressure_is_found_beside_a_double_knot_and_at_ends() {
        let (points, forces) = double_knot();
        // Force over area is a third beside four thirds there.
        let plain: Vec<f64> = forces.iter().zip(&points).map(|(f, p)| f / p.area).collect();
        assert!((plain[3] - third()).abs() < 1e-15 && (plain[2] - 4.0 * third()).abs() < 1e-15, "{plain:?}");
        let mut recovery = PressureRecovery::new(&points);
        let found = recovery.pressures(&forces);
        assert!(found.iter().all(|p| (p - 1.0).abs() < 1e-14), "{found:?}"); // round-off
    }

    fn third() -> f64 {
        1.0 / 3.0
    }

    #[test]
    fn pressures_times_areas_sum_to_the_force_on_a_part_of_the_points() {
        let (points, forces) = double_knot();
        let (points, forces) = (&points[1..5], &forces[1..5]);
        let mut recovery = PressureRecovery::new(points);
        let sum: f64 = recovery.pressures(forces).iter().zip(points).map(|(p, x)| p * x.area).sum();
        assert!((sum - forces.iter().sum::<f64>()).abs() < 1e-14);
    }

    #[test]
    fn at_gauss_points_pressure_is_force_over_area() {
        let (mut points, forces) = double_knot();
        points.iter_mut().for_each(|p| p.function = None);
        let mut recovery = PressureRecovery::new(&points);
        let found = recovery.pressures(&forces).to_vec();
        assert!(found.iter().zip(&forces).zip(&points).all(|((p, f), x)| (p - f / x.area).abs() < 1e-15));
    }
}
