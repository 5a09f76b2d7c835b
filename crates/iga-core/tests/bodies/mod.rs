//! Patches for tests and benchmarks, refined by interpolation.
#![allow(clippy::unwrap_used, reason = "each test file uses some of the helpers; a failure fails the test")]

use faer::sparse::SparseColMat;
use iga_core::nurbs::Patch;
use iga_core::splines::basis::basis_derivatives;
use iga_core::splines::knots::KnotVector;
use nalgebra::DMatrix;

/// The same geometry with other knot vectors, whose spaces must contain the old one: interpolation of the homogeneous
/// control points at the Greville points, one direction after the other. Exact to round-off.
pub fn refined(patch: &Patch, knots: &[KnotVector]) -> Patch {
    let mut net: Vec<[f64; 4]> = patch
        .control_points()
        .iter()
        .zip(patch.weights())
        .map(|(p, &w)| [w * p[0], w * p[1], w * p[2], w])
        .collect();
    let mut sizes = patch.net_size();
    for (d, fine) in knots.iter().enumerate() {
        let coarse = &patch.knots()[d];
        let points = fine.greville();
        let transfer = collocation(fine, &points).lu().solve(&collocation(coarse, &points)).unwrap();
        let (inner, outer): (usize, usize) = (sizes[..d].iter().product(), sizes[d + 1..].iter().product());
        let (old, new) = (sizes[d], fine.n_functions());
        let mut next = vec![[0.0; 4]; inner * new * outer];
        for o in 0..outer {
            for i in 0..new {
                for k in 0..old {
                    for s in 0..inner {
                        for c in 0..4 {
                            next[s + inner * (i + new * o)][c] +=
                                transfer[(i, k)] * net[s + inner * (k + old * o)][c];
                        }
                    }
                }
            }
        }
        (net, sizes[d]) = (next, new);
    }
    let points = net.iter().map(|h| [h[0] / h[3], h[1] / h[3], h[2] / h[3]]).collect();
    Patch::new(knots.to_vec(), points, net.iter().map(|h| h[3]).collect()).unwrap()
}

fn collocation(knots: &KnotVector, points: &[f64]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(points.len(), knots.n_functions());
    let mut row = vec![0.0; knots.degree() + 1];
    for (i, &u) in points.iter().enumerate() {
        let e = knots.find_element(u);
        basis_derivatives(knots, e, u, 0, &mut row);
        let first = knots.element_span(e) - knots.degree();
        for (j, v) in row.iter().enumerate() {
            matrix[(i, first + j)] = *v;
        }
    }
    matrix
}

/// `n[d]` equal elements of degree `degree` a direction.
pub fn uniform(patch: &Patch, degree: usize, n: &[usize]) -> Patch {
    let knots: Vec<_> = n.iter().map(|&n| KnotVector::uniform(degree, n).unwrap()).collect();
    refined(patch, &knots)
}

fn bezier(degrees: &[usize], points: Vec<[f64; 3]>, weights: Vec<f64>) -> Patch {
    let knots = degrees.iter().map(|&p| KnotVector::uniform(p, 1).unwrap()).collect();
    Patch::new(knots, points, weights).unwrap()
}

/// Bilinear quadrilateral; corners with the first direction fastest.
pub fn quadrilateral(corners: [[f64; 2]; 4]) -> Patch {
    bezier(&[1, 1], corners.iter().map(|c| [c[0], c[1], 0.0]).collect(), vec![1.0; 4])
}

/// Trilinear brick with one corner pulled out.
pub fn brick(size: [f64; 3], pull: f64) -> Patch {
    let mut points: Vec<[f64; 3]> = (0..8)
        .map(|i| [(i & 1) as f64 * size[0], (i >> 1 & 1) as f64 * size[1], (i >> 2) as f64 * size[2]])
        .collect();
    for x in &mut points[7] {
        *x += pull;
    }
    bezier(&[1, 1, 1], points, vec![1.0; 8])
}

/// Quarter annulus between radii `a < b` about `centre`: radius first, angle second; exact with degree (1, 2).
pub fn quarter_annulus(a: f64, b: f64, centre: [f64; 2]) -> Patch {
    let w = 0.5f64.sqrt();
    let mut points = Vec::new();
    for (x, y) in [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        points.extend([a, b].map(|r| [centre[0] + r * x, centre[1] + r * y, 0.0]));
    }
    bezier(&[1, 2], points, vec![1.0, 1.0, w, w, 1.0, 1.0])
}

/// The 3 x 3 disc of radius 1; its four corners lie on the circle and are singular.
fn disc_net() -> (Vec<[f64; 2]>, Vec<f64>) {
    let s = 0.5f64.sqrt();
    let points = [
        [-s, -s],
        [0.0, -2.0 * s],
        [s, -s],
        [-2.0 * s, 0.0],
        [0.0, 0.0],
        [2.0 * s, 0.0],
        [-s, s],
        [0.0, 2.0 * s],
        [s, s],
    ];
    (points.to_vec(), vec![1.0, s, 1.0, s, 1.0, s, 1.0, s, 1.0])
}

/// Disc as one patch.
pub fn disc(radius: f64) -> Patch {
    let (points, weights) = disc_net();
    bezier(&[2, 2], points.iter().map(|p| [radius * p[0], radius * p[1], 0.0]).collect(), weights)
}

/// Cylinder along `z`: the disc, extruded.
pub fn cylinder(radius: f64, length: f64) -> Patch {
    let (points, weights) = disc_net();
    let layer = |z: f64| points.iter().map(move |p| [radius * p[0], radius * p[1], z]).collect::<Vec<_>>();
    bezier(&[2, 2, 1], [layer(0.0), layer(length)].concat(), [weights.clone(), weights].concat())
}

/// Box whose cross-section shrinks along `z`; all faces are plane, the map is not affine.
pub fn frustum() -> Patch {
    let corner = |i: usize| {
        let (x, y, z) = ((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        [x * (1.0 - 0.3 * z), y * (1.0 - 0.2 * z), z]
    };
    bezier(&[1, 1, 1], (0..8).map(corner).collect(), vec![1.0; 8])
}

/// Product of a symmetric matrix, stored as lower triangle, and a vector.
pub fn multiply(matrix: &SparseColMat<u32, f64>, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    for t in matrix.triplet_iter() {
        let (i, j) = (t.row, t.col);
        y[i] += t.val * x[j];
        if i != j {
            y[j] += t.val * x[i];
        }
    }
    y
}

/// `xᵀ y`.
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// Largest magnitude.
pub fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Numbers between -1 and 1 from a fixed seed.
pub fn noise(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = || {
        // xorshift64 (Marsaglia 2003)
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| next()).collect()
}

/// Values of a vector field at the unknowns.
pub fn at_unknowns(dofs: &[(u32, u8)], nodal: &[f64], n_components: usize) -> Vec<f64> {
    dofs.iter().map(|&(n, c)| nodal[n as usize * n_components + c as usize]).collect()
}

/// Node-major control values of a field that is linear in the position.
pub fn linear_field(
    points: &[[f64; 3]],
    n_components: usize,
    gradient: [[f64; 3]; 3],
    shift: [f64; 3],
) -> Vec<f64> {
    let value = |p: &[f64; 3], c: usize| shift[c] + dot(&gradient[c], p);
    points.iter().flat_map(|p| (0..n_components).map(move |c| value(p, c))).collect()
}

/// Slope of `log(error)` over `log(size)` by least squares.
pub fn slope(sizes: &[f64], errors: &[f64]) -> f64 {
    let n = sizes.len() as f64;
    let (x, y): (Vec<f64>, Vec<f64>) =
        (sizes.iter().map(|h| h.ln()).collect(), errors.iter().map(|e| e.ln()).collect());
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(&y).map(|(a, b)| (a - mx) * (b - my)).sum();
    covariance / x.iter().map(|a| (a - mx) * (a - mx)).sum::<f64>()
}
