//! Safeguarded Newton minimisation over a parameter box with a few variables.
//!
//! Variables at a bound that the descent direction would leave are held; the free block of the
//! Hessian is shifted until it is positive definite; steps are cut back until the objective falls.
//! Never panics, never leaves the box.

use std::array::from_fn;

use crate::nurbs::jet::{difference, dot, norm};

/// Objective at a point, with derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<const N: usize = 3> {
    /// Value.
    pub value: f64,
    /// Round-off of the value: differences below it carry no information.
    pub noise: f64,
    /// First derivatives.
    pub gradient: [f64; N],
    /// Second derivatives, symmetric.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Default for Sample<N> {
    fn default() -> Self {
        Self { value: 0.0, noise: 0.0, gradient: [0.0; N], hessian: [[0.0; N]; N] }
    }
}

impl<const N: usize> Sample<N> {
    /// Half the squared distance of a moving point from `target` (theory Eq. S.21): of its place
    /// `point` with `first` derivatives for the parameters, and second ones.
    pub fn half_square(
        point: &[f64; 3],
        first: &[[f64; 3]; N],
        second: impl Fn(usize, usize) -> [f64; 3],
        target: &[f64; 3],
    ) -> Self {
        let r = difference(point, target);
        let rounding = 4.0 * f64::EPSILON * (norm(point) + norm(target));
        Self {
            value: 0.5 * dot(&r, &r),
            noise: rounding * (norm(&r) + rounding),
            gradient: from_fn(|a| dot(&r, &first[a])),
            hessian: from_fn(|a| from_fn(|b| dot(&first[a], &first[b]) + dot(&r, &second(a, b)))),
        }
    }

    /// Height `n · x` of a moving point along `direction`, as [`Sample::half_square`].
    pub fn height(
        point: &[f64; 3],
        first: &[[f64; 3]; N],
        second: impl Fn(usize, usize) -> [f64; 3],
        direction: &[f64; 3],
    ) -> Self {
        Self {
            value: dot(point, direction),
            noise: 4.0 * f64::EPSILON * norm(point) * norm(direction),
            gradient: from_fn(|a| dot(direction, &first[a])),
            hessian: from_fn(|a| from_fn(|b| dot(direction, &second(a, b)))),
        }
    }
}

const MAX_ITERATIONS: usize = 60;
const MAX_CUTS: usize = 30;
/// Share of a Newton step that leaves more than half of the squared gradient, 0.29, and so can no
/// more improve a value that is round-off; the next power of a half.
const TOO_SHORT: f64 = 0.25;

/// A local minimum of `objective` in the closed box, from `start` (clamped into it), with the
/// objective's value there. Directions with `lower == upper` are fixed. If the iteration stalls,
/// the best point so far is returned.
pub fn minimize<const N: usize>(
    mut objective: impl FnMut(&[f64; N]) -> Sample<N>,
    start: &[f64; N],
    lower: &[f64; N],
    upper: &[f64; N],
) -> ([f64; N], f64) {
    let into_box = |xi: [f64; N]| from_fn(|d| xi[d].max(lower[d]).min(upper[d]));
    let mut xi = into_box(*start);
    let mut here = objective(&xi);
    for _ in 0..MAX_ITERATIONS {
        let free = from_fn(|d| {
            let (at_lower, at_upper) = (xi[d] <= lower[d], xi[d] >= upper[d]);
            let g = here.gradient[d];
            lower[d] < upper[d] && g != 0.0 && !(at_lower && g > 0.0) && !(at_upper && g < 0.0)
        });
        if free == [false; N] {
            break;
        }
        let scale = diagonal_scale(&here.hessian, &free);
        let newton = newton_step(&here, &free, &scale);
        let resolution = |d: usize| 4.0 * f64::EPSILON * (upper[d] - lower[d]);
        if (0..N).all(|d| newton[d].abs() <= resolution(d)) {
            break;
        }
        let gradient_step = from_fn(|d| if free[d] { -here.gradient[d] / scale[d] } else { 0.0 });
        let mut accepted = None;
        'directions: for step in [newton, gradient_step] {
            let mut length = 1.0;
            for _ in 0..MAX_CUTS {
                let trial = into_box(from_fn(|d| xi[d] + length * step[d]));
                let there = objective(&trial);
                if improves(&here, &there, &xi, &trial, &free, &scale) {
                    accepted = Some((trial, there));
                    break 'directions;
                }
                if length <= TOO_SHORT && slope(&here, &xi, &trial).abs() <= here.noise {
                    break;
                }
                length *= 0.5;
            }
        }
        let Some((next, there)) = accepted else { break };
        let still = (0..N).all(|d| (next[d] - xi[d]).abs() <= resolution(d));
        (xi, here) = (next, there);
        if still {
            break;
        }
    }
    (xi, here.value)
}

/// Sufficient decrease; below the noise of the value, a smaller scaled gradient.
fn improves<const N: usize>(
    here: &Sample<N>,
    there: &Sample<N>,
    from: &[f64; N],
    to: &[f64; N],
    free: &[bool; N],
    scale: &[f64; N],
) -> bool {
    let slope = slope(here, from, to);
    if slope < 0.0 && there.value < here.value + 1e-4 * slope {
        return true;
    }
    let size = |s: &Sample<N>| -> f64 {
        (0..N).filter(|&d| free[d]).map(|d| s.gradient[d] * s.gradient[d] / scale[d]).sum()
    };
    (there.value - here.value).abs() <= here.noise && size(there) < 0.5 * size(here)
}

/// Change of the value between two points to first order.
fn slope<const N: usize>(here: &Sample<N>, from: &[f64; N], to: &[f64; N]) -> f64 {
    (0..N).map(|d| here.gradient[d] * (to[d] - from[d])).sum()
}

/// Positive scales of the directions: the diagonal of the Hessian, kept off zero.
fn diagonal_scale<const N: usize>(hessian: &[[f64; N]; N], free: &[bool; N]) -> [f64; N] {
    let largest = (0..N).filter(|&d| free[d]).map(|d| hessian[d][d].abs()).fold(0.0, f64::max);
    let floor = if largest > 0.0 { 1e-10 * largest } else { 1.0 };
    from_fn(|d| hessian[d][d].abs().max(floor))
}

/// Solves `(H + λ D) δ = -g` on the free directions with the least λ of a rising sequence that
/// makes it positive definite.
fn newton_step<const N: usize>(here: &Sample<N>, free: &[bool; N], scale: &[f64; N]) -> [f64; N] {
    let mut shift = 0.0;
    for _ in 0..12 {
        let mut matrix = here.hessian;
        for d in 0..N {
            matrix[d][d] += shift * scale[d];
        }
        if let Some(step) = solve_free(matrix, &here.gradient, free, scale) {
            return step;
        }
        shift = if shift == 0.0 { 1e-3 } else { 10.0 * shift };
    }
    [f64::NAN; N] // never accepted: the gradient step takes over
}

/// Solution on the free block by elimination, `None` unless every pivot is safely positive.
fn solve_free<const N: usize>(
    mut a: [[f64; N]; N],
    gradient: &[f64; N],
    free: &[bool; N],
    scale: &[f64; N],
) -> Option<[f64; N]> {
    let mut x = gradient.map(|g| -g);
    for (d, row) in a.iter_mut().enumerate() {
        for (k, entry) in row.iter_mut().enumerate() {
            if !(free[d] && free[k]) {
                *entry = if d == k { 1.0 } else { 0.0 };
            }
        }
        x[d] = if free[d] { x[d] } else { 0.0 };
    }
    for k in 0..N {
        let limit = if free[k] { 1e-12 * scale[k] } else { 0.0 };
        let above = a[k];
        if above[k].is_nan() || above[k] <= limit {
            return None;
        }
        for i in k + 1..N {
            let factor = a[i][k] / above[k];
            for (entry, pivot_row) in a[i].iter_mut().zip(&above).skip(k + 1) {
                *entry -= factor * pivot_row;
            }
            x[i] -= factor * x[k];
        }
    }
    for k in (0..N).rev() {
        let known: f64 = a[k].iter().zip(&x).skip(k + 1).map(|(c, v)| c * v).sum();
        x[k] = (x[k] - known) / a[k][k];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `(u - 0.3)^2 + (v - u^2)^2`-like valley with a saddle, minimum at (0.3, 0.09).
    fn valley(xi: &[f64; 3]) -> Sample {
        let (u, v) = (xi[0], xi[1]);
        let r = v - u * u;
        Sample {
            value: (u - 0.3).powi(2) + 100.0 * r * r,
            noise: 1e-15,
            gradient: [2.0 * (u - 0.3) - 400.0 * u * r, 200.0 * r, 0.0],
            hessian: [[2.0 - 400.0 * r + 800.0 * u * u, -400.0 * u, 0.0], [-400.0 * u, 200.0, 0.0], [0.0; 3]],
        }
    }

    #[test]
    fn round_off_ends_the_search_at_once() {
        // A parabola that is known to 1e-10, and its gradient to 1e-5.
        let mut n_samples = 0;
        let noisy = |xi: &[f64; 1]| {
            n_samples += 1;
            let x = xi[0] - 0.3;
            let waves = 1e-10 * (1e9 * x).sin();
            Sample {
                value: x * x + waves,
                noise: 2e-10,
                gradient: [2.0 * x + 1e-5 * (1e9 * x).cos()],
                hessian: [[2.0]],
            }
        };
        let (xi, _) = minimize(noisy, &[0.9], &[0.0], &[1.0]);
        // A few steps, then three lengths of two directions each that tell nothing more; all thirty
        // of both would be sixty.
        assert!((xi[0] - 0.3).abs() < 1e-5 && n_samples <= 20, "{xi:?} {n_samples}");
    }

    #[test]
    fn interior_minima_are_found_from_everywhere() {
        for start in [[-1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 0.0]] {
            let (xi, value) = minimize(valley, &start, &[-1.0, -1.0, 0.0], &[1.0, 1.0, 0.0]);
            assert!((xi[0] - 0.3).abs() < 1e-8 && (xi[1] - 0.09).abs() < 1e-8, "{start:?} {xi:?}");
            assert!(value < 1e-15);
        }
    }

    #[test]
    fn bounds_hold_the_minimum_back() {
        let (xi, _) = minimize(valley, &[1.0, 1.0, 0.0], &[0.5, -1.0, 0.0], &[1.0, 1.0, 0.0]);
        assert!((xi[0] - 0.5).abs() < 1e-12 && (xi[1] - 0.25).abs() < 1e-8, "{xi:?}");
        // A fixed direction stays where it is.
        let (xi, _) = minimize(valley, &[1.0, 0.0, 0.0], &[-1.0, 0.2, 0.0], &[1.0, 0.2, 0.0]);
        assert!((xi[1] - 0.2).abs() < 1e-15);
        assert!(valley(&xi).gradient[0].abs() < 1e-8);
    }

    #[test]
    fn not_a_number_ends_the_search_quietly() {
        let broken = |_: &[f64; 3]| Sample {
            value: f64::NAN,
            noise: f64::NAN,
            gradient: [f64::NAN; 3],
            hessian: [[f64::NAN; 3]; 3],
        };
        let (xi, value) = minimize(broken, &[0.5; 3], &[0.0; 3], &[1.0; 3]);
        assert!(xi.iter().all(|u| (u - 0.5).abs() < 1e-15));
        assert!(value.is_nan());
    }
}
