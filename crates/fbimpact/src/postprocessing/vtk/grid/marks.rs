//! Marks that stand for what has no shape: points with names, lines, circles, squares.

use std::f64::consts::TAU;

use nalgebra::{Rotation3, Unit, Vector3};

use super::Grid;
use super::order;

/// Lines of a circle.
const SIDES: usize = 64;

/// Adds a named point with a vertex on it and returns its number.
pub fn point(grid: &mut Grid, at: &Vector3<f64>, name: &str) -> usize {
    let n = corner(grid, at, name);
    grid.add_cell(order::VERTEX, n, &[0]);
    n
}

/// Adds a line between two new points of the same name.
pub fn line(grid: &mut Grid, [from, to]: [&Vector3<f64>; 2], name: &str) {
    let n = corner(grid, from, name);
    corner(grid, to, name);
    grid.add_cell(order::LINE, n, &[0, 1]);
}

/// Adds a circle about `normal`.
pub fn circle(grid: &mut Grid, centre: &Vector3<f64>, normal: &Unit<Vector3<f64>>, radius: f64, name: &str) {
    let arm = radius * across(normal);
    let first = grid.points.len();
    for i in 0..SIDES {
        let turn = Rotation3::from_axis_angle(normal, TAU * i as f64 / SIDES as f64);
        corner(grid, &(centre + turn * arm), name);
    }
    for i in 0..SIDES {
        grid.add_cell(order::LINE, first, &[i, (i + 1) % SIDES]);
    }
}

/// Adds a square with sides of twice `half`, across `normal`.
pub fn square(grid: &mut Grid, centre: &Vector3<f64>, normal: &Unit<Vector3<f64>>, half: f64, name: &str) {
    let x = half * across(normal);
    let y = normal.cross(&x);
    let first = grid.points.len();
    for corner_at in [-x - y, x - y, x + y, -x + y] {
        corner(grid, &(centre + corner_at), name);
    }
    grid.add_cell(order::LINEAR[0], first, &[0, 1, 2, 3]);
}

/// Adds a point without a cell and returns its number.
fn corner(grid: &mut Grid, at: &Vector3<f64>, name: &str) -> usize {
    grid.points.push((*at).into());
    grid.labels.push(name.to_owned());
    grid.points.len() - 1
}

/// A unit vector across `normal`: towards the axis of space that it leans to least.
fn across(normal: &Unit<Vector3<f64>>) -> Vector3<f64> {
    let least = (0..3).min_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs())).unwrap_or(0);
    let axis = Vector3::ith(least, 1.0);
    (axis - normal.into_inner() * normal[least]).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_and_squares_lie_across_their_normal() {
        let normal = Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5));
        let centre = Vector3::new(0.3, 0.2, -0.1);
        let mut grid = Grid::default();
        circle(&mut grid, &centre, &normal, 0.7, "c");
        square(&mut grid, &centre, &normal, 0.7, "s");
        for (i, p) in grid.points.iter().enumerate() {
            let arm = Vector3::from(*p) - centre;
            let reach = if i < SIDES { 0.7 } else { 0.7 * 2.0_f64.sqrt() };
            // Round-off of lengths of one.
            assert!(arm.dot(&normal).abs() < 1e-15 && (arm.norm() - reach).abs() < 1e-14);
        }
        assert_eq!(grid.labels.len(), grid.points.len());
        assert_eq!(grid.types.len(), SIDES + 1);
    }
}
