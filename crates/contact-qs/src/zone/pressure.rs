//! Contact pressure from point forces (docs/theory.md Eqs. C.49, C.50).

use std::collections::HashMap;

use crate::quasistatic::compliance::sparse_rows::SparseRows;
use crate::zone::points::{PressureMean, SurfacePoint};

/// Share of the area of a corner's function on points with force from which on the corner lies
/// inside the contact: at a straight edge through it, it is a half, and noise leaves less than a
/// half of the points inside without force.
const INSIDE: f64 = 0.5;

/// Pressures of contact points from their forces.
///
/// Forces at Greville points are those whose nodal forces `Σ_j R_A(x_j) λ_j` are the nodal forces
/// `∫ R_A p dA` of a pressure `p`. They are not `p w_j` where Greville points and areas do not make
/// a quadrature rule: beside repeated knots and at the axis they alternate between a third and five
/// quarters of it. Nodal forces over the areas `w_A = ∫ R_A dA` are means of `p`, weighted with
/// `R_A`: exact for a constant pressure on every net, smooth for a smooth one. What falls on points
/// without force stays where it is.
///
/// Gauss points on the sides of a mesh are more than the displacements of its nodes; what forces do
/// in the null space of the compliance is decided by the penalty factor alone and is noise. Means
/// weighted with the linear functions of the corners are free of it (Eq. C.50); the pressure at a
/// point is what these means are there. Points without force take part where all corners around
/// them lie inside the contact, most of their areas under force.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureRecovery {
    /// For every point the points among which its force is shared, with the shares.
    shares: SparseRows,
    /// For every point the corners around it, with the values of their functions.
    corners: SparseRows,
    areas: Vec<f64>,
    pressures: Vec<f64>,
    /// For every corner the area of its function, and how much of it lies on points with force
    /// \[m²\].
    weights: Vec<f64>,
    loaded: Vec<f64>,
}

impl PressureRecovery {
    /// The recovery at `points`. Shares of functions that are not among the points' own stay where
    /// they are, so that areas times pressures sum to the sum of the forces.
    pub fn new(points: &[SurfacePoint]) -> Self {
        let number =
            |p: &SurfacePoint| if let PressureMean::Function(f) = p.pressure { Some(f) } else { None };
        let own: HashMap<u32, usize> =
            points.iter().enumerate().filter_map(|(i, p)| number(p).map(|f| (f, i))).collect();
        let corners = corners(points);
        let mut around = vec![Vec::new(); corners.n_columns()];
        for (q, point) in points.iter().enumerate() {
            corners.row(q).iter().for_each(|&(a, value)| around[a].push((q, value * point.area)));
        }
        let mut shares = SparseRows::new(points.len());
        for (j, point) in points.iter().enumerate() {
            let mut row: Vec<(usize, f64)> = match &point.pressure {
                PressureMean::Area => Vec::new(),
                PressureMean::Function(_) => {
                    point.functions.iter().filter_map(|f| own.get(&f.0).map(|&a| (a, f.1))).collect()
                }
                PressureMean::Hats(_) => shares_by_corners(corners.row(j), &corners, &around, points),
            };
            let rest = 1.0 - row.iter().map(|(_, share)| share).sum::<f64>();
            match row.iter_mut().find(|(a, _)| *a == j) {
                Some((_, share)) => *share += rest,
                None => row.push((j, rest)),
            }
            shares.push(row);
        }
        let weights: Vec<f64> = around.iter().map(|points| points.iter().map(|(_, w)| w).sum()).collect();
        let (n, loaded) = (points.len(), vec![0.0; weights.len()]);
        let areas = points.iter().map(|p| p.area).collect();
        Self { shares, corners, areas, pressures: vec![0.0; n], weights, loaded }
    }

    /// Pressures of all points under the normal forces `forces` \[Pa\].
    ///
    /// # Panics
    /// If there is not one force per point.
    pub fn pressures(&mut self, forces: &[f64]) -> &[f64] {
        assert_eq!(forces.len(), self.areas.len(), "one force per contact point");
        self.pressures.fill(0.0);
        self.loaded.fill(0.0);
        let loaded = || forces.iter().enumerate().filter(|(_, force)| **force > 0.0);
        for (j, _) in loaded() {
            self.corners.row(j).iter().for_each(|&(a, value)| self.loaded[a] += value * self.areas[j]);
        }
        for (j, force) in loaded() {
            for &(a, share) in self.shares.row(j) {
                // Points without force are beyond the edge of the contact, but for those whose
                // corners all are inside.
                let corners = self.corners.row(a);
                let is_inside = !corners.is_empty()
                    && corners.iter().all(|&(c, _)| self.loaded[c] > INSIDE * self.weights[c]);
                let taker = if forces[a] > 0.0 || is_inside { a } else { j };
                self.pressures[taker] += share * force;
            }
        }
        self.pressures.iter_mut().zip(&self.areas).for_each(|(p, area)| *p /= area);
        &self.pressures
    }
}

/// For every point the corners around it, numbered from zero, with the values of their functions.
fn corners(points: &[SurfacePoint]) -> SparseRows {
    let mut numbers = HashMap::new();
    let mut rows = Vec::with_capacity(points.len());
    for point in points {
        let hats = if let PressureMean::Hats(hats) = &point.pressure { hats.as_slice() } else { &[] };
        let mut row = Vec::with_capacity(hats.len());
        for &(corner, value) in hats {
            let next = numbers.len();
            row.push((*numbers.entry(corner).or_insert(next), value));
        }
        rows.push(row);
    }
    let mut corners = SparseRows::new(numbers.len());
    rows.into_iter().for_each(|row| corners.push(row));
    corners
}

/// Shares of a force among `points`, a point with the functions `hats` of its corners:
/// `Σ_a ψ_a ψ_a(x_q) ω_q / w_a` of point `q`, `w_a = Σ_q ψ_a(x_q) ω_q`; `around` has for every
/// corner its points with `ψ_a(x_q) ω_q`.
fn shares_by_corners(
    hats: &[(usize, f64)],
    corners: &SparseRows,
    around: &[Vec<(usize, f64)>],
    points: &[SurfacePoint],
) -> Vec<(usize, f64)> {
    let total = |a: usize| around[a].iter().map(|(_, weight)| weight).sum::<f64>();
    let mut found: Vec<usize> = hats.iter().flat_map(|&(a, _)| around[a].iter().map(|&(q, _)| q)).collect();
    found.sort_unstable();
    found.dedup();
    let share = |q: usize| {
        let values = corners.row(q).iter();
        let common = values.filter_map(|&(a, there)| {
            hats.iter().find(|(b, _)| *b == a).map(|(_, here)| here * there / total(a))
        });
        common.sum::<f64>() * points[q].area
    };
    found.into_iter().map(|q| (q, share(q))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of the quadratic functions on the knots 0 0 0 1 2 2 3 4 4 4, a double knot in the
    /// middle, with the forces of a constant pressure 1: those whose nodal forces are `∫ R_A dx`,
    /// worked out by hand.
    fn double_knot() -> (Vec<SurfacePoint>, Vec<f64>) {
        let point = |x: f64, own, area, functions: &[(u32, f64)]| SurfacePoint {
            position: [x, 0.0, 0.0],
            area,
            functions: functions.to_vec(),
            on_rim: false,
            pressure: PressureMean::Function(own),
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
        points.iter_mut().for_each(|p| p.pressure = PressureMean::Area);
        let mut recovery = PressureRecovery::new(&points);
        let found = recovery.pressures(&forces).to_vec();
        assert!(found.iter().zip(&forces).zip(&points).all(|((p, f), x)| (p - f / x.area).abs() < 1e-15));
    }

    /// A strip of squares of side one, with four Gauss points each.
    fn strip(n: u32) -> Vec<SurfacePoint> {
        let g = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
        let point = |k: u32, x: f64, y: f64| SurfacePoint {
            position: [f64::from(k) + x, y, 0.0],
            area: 0.25,
            functions: Vec::new(),
            on_rim: false,
            pressure: PressureMean::Hats(vec![
                (2 * k, (1.0 - x) * (1.0 - y)),
                (2 * k + 1, (1.0 - x) * y),
                (2 * k + 2, x * (1.0 - y)),
                (2 * k + 3, x * y),
            ]),
            facing: None,
        };
        (0..n).flat_map(|k| [0, 1].map(|i| [0, 1].map(|j| point(k, g[i], g[j])))).flatten().collect()
    }

    #[test]
    fn means_over_corners_keep_sums_and_constants_and_leave_out_noise() {
        let points = strip(5);
        let sum = |p: &[f64]| p.iter().zip(&points).map(|(p, x)| p * x.area).sum::<f64>();
        let mut recovery = PressureRecovery::new(&points);
        // A constant pressure, with what no displacement of the corners sees: four points of a
        // square in turns.
        let noise = [0.2, -0.2, -0.2, 0.2];
        let forces: Vec<f64> = (0..20).map(|i| 0.25 + noise[i % 4]).collect();
        let found = recovery.pressures(&forces).to_vec();
        // Neighbours cancel at their common corners; round-off.
        assert!(found[4..16].iter().all(|p| (p - 1.0).abs() < 1e-13), "{found:?}");
        assert!((sum(&found) - 5.0).abs() < 1e-13);
        // A point without force inside is filled, one beyond the edge is not.
        let forces: Vec<f64> = (0..20).map(|i| if i == 5 || i >= 12 { 0.0 } else { 0.25 }).collect();
        let found = recovery.pressures(&forces).to_vec();
        assert!(found[5] > 0.5, "{found:?}");
        assert!(found[16..].iter().all(|p| *p == 0.0), "{found:?}");
        assert!((sum(&found) - forces.iter().sum::<f64>()).abs() < 1e-13);
    }
}
