//! Bodies for tests, assembled by hand: tensor-product B-spline boxes, plane plates, axisymmetric cylinders, spring chains.

use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion};

/// Young's modulus \[Pa\], Poisson's ratio, density [kg/m^3]: steel-like.
pub const YOUNG: f64 = 2.1e11;
pub const POISSON: f64 = 0.3;
pub const DENSITY: f64 = 7800.0;

/// Open knot vector on [0, 1], basis values and derivatives by the recursion of Cox and de Boor.
struct Splines {
    degree: usize,
    knots: Vec<f64>,
}

impl Splines {
    fn new(degree: usize, elements: usize) -> Self {
        let inner = (1..elements).map(|i| i as f64 / elements as f64);
        let knots = vec![0.0; degree + 1].into_iter().chain(inner).chain(vec![1.0; degree + 1]).collect();
        Self { degree, knots }
    }

    fn count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    fn greville(&self, i: usize) -> f64 {
        self.knots[i + 1..=i + self.degree].iter().sum::<f64>() / self.degree as f64
    }

    fn value(&self, i: usize, p: usize, x: f64) -> f64 {
        let t = &self.knots;
        if p == 0 {
            return if t[i] <= x && x < t[i + 1] { 1.0 } else { 0.0 };
        }
        let part = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        part(x - t[i], t[i + p] - t[i]) * self.value(i, p - 1, x)
            + part(t[i + p + 1] - x, t[i + p + 1] - t[i + 1]) * self.value(i + 1, p - 1, x)
    }

    fn derivative(&self, i: usize, x: f64) -> f64 {
        let (t, p) = (&self.knots, self.degree);
        let part = |b: f64| if b > 0.0 { p as f64 / b } else { 0.0 };
        part(t[i + p] - t[i]) * self.value(i, p - 1, x)
            - part(t[i + p + 1] - t[i + 1]) * self.value(i + 1, p - 1, x)
    }

    /// Matrices `integral w(x) N_i^(a) N_j^(b) dx` on [0, length].
    fn integrals(&self, length: f64, weight: impl Fn(f64) -> f64) -> [[Mat<f64>; 2]; 2] {
        let n = self.count();
        let elements = n - self.degree;
        let mut out = [[Mat::zeros(n, n), Mat::zeros(n, n)], [Mat::zeros(n, n), Mat::zeros(n, n)]];
        for e in 0..elements {
            let h = 1.0 / elements as f64;
            for (point, w) in gauss(self.degree + 2) {
                let x = (e as f64 + 0.5 + 0.5 * point) * h;
                let values: Vec<[f64; 2]> = (e..=e + self.degree)
                    .map(|i| [self.value(i, self.degree, x), self.derivative(i, x) / length])
                    .collect();
                let w = 0.5 * h * length * w * weight(x * length);
                for a in 0..2 {
                    for b in 0..2 {
                        for i in 0..=self.degree {
                            for j in 0..=self.degree {
                                out[a][b][(e + i, e + j)] += w * values[i][a] * values[j][b];
                            }
                        }
                    }
                }
            }
        }
        out
    }
}

/// Gauss points and weights on [-1, 1] by Newton's method on the Legendre polynomial.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..50 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    (p0, p1) = (p1, ((2 * k - 1) as f64 * x * p1 - (k - 1) as f64 * p0) / k as f64);
                }
                slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                x -= p1 / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

fn lame() -> (f64, f64) {
    let lambda = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    (lambda, YOUNG / (2.0 * (1.0 + POISSON)))
}

/// Free box, or a plane-strain plate per metre of thickness if `elements[2] == 0`, centred at the origin.
pub fn block(degree: usize, elements: [usize; 3], size: [f64; 3]) -> AssembledBody {
    let dim = if elements[2] == 0 { 2 } else { 3 };
    let splines: Vec<Splines> = (0..dim).map(|d| Splines::new(degree, elements[d])).collect();
    let parts: Vec<_> = (0..dim).map(|d| splines[d].integrals(size[d], |_| 1.0)).collect();
    let counts: Vec<usize> = splines.iter().map(Splines::count).collect();
    let n_nodes: usize = counts.iter().product();
    let split = |a: usize| [a % counts[0], a / counts[0] % counts[1], a / (counts[0] * counts[1])];
    let (lambda, mu) = lame();
    let mut mass = Vec::new();
    let mut stiffness = Vec::new();
    for b in 0..n_nodes {
        let j = split(b);
        for a in neighbours(j, &counts, degree).filter(|&a| a >= b) {
            let i = split(a);
            // integral of d_c N_a d_d N_b, without derivative for c = 3
            let term = |c: usize, d: usize| -> f64 {
                (0..dim).map(|k| parts[k][usize::from(c == k)][usize::from(d == k)][(i[k], j[k])]).product()
            };
            mass.push(Triplet::new(a as u32, b as u32, DENSITY * term(3, 3)));
            let trace: f64 = (0..dim).map(|k| term(k, k)).sum();
            for c in 0..dim {
                for d in 0..dim {
                    let (row, col) = (dim * a + c, dim * b + d);
                    let value = lambda * term(c, d) + mu * term(d, c) + if c == d { mu * trace } else { 0.0 };
                    if row >= col {
                        stiffness.push(Triplet::new(row as u32, col as u32, value));
                    }
                }
            }
        }
    }
    let place = |a: usize| {
        let i = split(a);
        std::array::from_fn(|k| if k < dim { size[k] * (splines[k].greville(i[k]) - 0.5) } else { 0.0 })
    };
    let nodes: Vec<[f64; 3]> = (0..n_nodes).map(place).collect();
    AssembledBody {
        name: "block".into(),
        motion: if dim == 2 { RigidMotion::Planar } else { RigidMotion::Spatial },
        stiffness: lower(dim * n_nodes, &stiffness),
        mass: MassMatrix::PerComponent(lower(n_nodes, &mass)),
        dofs: (0..dim * n_nodes)
            .map(|i| Dof { node: (i / dim) as u32, component: (i % dim) as u8 })
            .collect(),
        anchors: nodes.clone(),
        nodes,
    }
}

/// Node by node matrix `∫ σ ∂R_A/∂x ∂R_B/∂x` of the plate of [`block`] for a stress `σ(x)` along x.
pub fn tension_stiffness(
    degree: usize,
    elements: [usize; 2],
    size: [f64; 2],
    stress: impl Fn(f64) -> f64,
) -> SparseColMat<u32, f64> {
    let splines = [Splines::new(degree, elements[0]), Splines::new(degree, elements[1])];
    let along = splines[0].integrals(size[0], |s| stress(s - 0.5 * size[0]));
    let across = splines[1].integrals(size[1], |_| 1.0);
    let (nx, ny) = (splines[0].count(), splines[1].count());
    let mut entries = Vec::new();
    for b in 0..nx * ny {
        for a in neighbours([b % nx, b / nx, 0], &[nx, ny], degree).filter(|&a| a >= b) {
            let value = along[1][1][(a % nx, b % nx)] * across[0][0][(a / nx, b / nx)];
            entries.push(Triplet::new(a as u32, b as u32, value));
        }
    }
    lower(nx * ny, &entries)
}

fn neighbours(j: [usize; 3], counts: &[usize], reach: usize) -> impl Iterator<Item = usize> {
    let range = move |k: usize, n: usize| j[k].saturating_sub(reach)..(j[k] + reach + 1).min(n);
    let (nx, ny, nz) = (counts[0], counts[1], counts.get(2).copied().unwrap_or(1));
    range(2, nz)
        .flat_map(move |z| range(1, ny).flat_map(move |y| range(0, nx).map(move |x| x + nx * (y + ny * z))))
}

/// Axisymmetric solid cylinder in (r, z): the axis nodes have no radial unknown, integrals carry 2 pi r.
pub fn cylinder(degree: usize, elements: [usize; 2], radius: f64, length: f64) -> AssembledBody {
    use std::f64::consts::TAU;
    let (sr, sz) = (Splines::new(degree, elements[0]), Splines::new(degree, elements[1]));
    let by_r = sr.integrals(radius, |r| TAU * r);
    let plain = sr.integrals(radius, |_| TAU);
    let over_r = sr.integrals(radius, |r| TAU / r);
    let along = sz.integrals(length, |_| 1.0);
    let (nr, nz) = (sr.count(), sz.count());
    let (lambda, mu) = lame();
    let stiff = lambda + 2.0 * mu;
    let mut number = vec![[u32::MAX; 2]; nr * nz];
    let mut dofs = Vec::new();
    for (node, numbers) in number.iter_mut().enumerate() {
        for component in 0..2u8 {
            if component == 0 && node % nr == 0 {
                continue;
            }
            numbers[component as usize] = dofs.len() as u32;
            dofs.push(Dof { node: node as u32, component });
        }
    }
    let (mut mass, mut stiffness) = (Vec::new(), Vec::new());
    for b in 0..nr * nz {
        for a in neighbours([b % nr, b / nr, 0], &[nr, nz], degree).filter(|&a| a >= b) {
            let (i, j) = ((a % nr, a / nr), (b % nr, b / nr));
            let r = |p: &[[Mat<f64>; 2]; 2], s: usize, t: usize| p[s][t][(i.0, j.0)];
            let z = |s: usize, t: usize| along[s][t][(i.1, j.1)];
            mass.push(Triplet::new(a as u32, b as u32, DENSITY * r(&by_r, 0, 0) * z(0, 0)));
            let rr = stiff * (r(&by_r, 1, 1) + r(&over_r, 0, 0)) * z(0, 0)
                + lambda * (r(&plain, 0, 1) + r(&plain, 1, 0)) * z(0, 0)
                + mu * r(&by_r, 0, 0) * z(1, 1);
            let zz = stiff * r(&by_r, 0, 0) * z(1, 1) + mu * r(&by_r, 1, 1) * z(0, 0);
            let rz = lambda * (r(&by_r, 1, 0) + r(&plain, 0, 0)) * z(0, 1) + mu * r(&by_r, 0, 1) * z(1, 0);
            let zr = lambda * (r(&by_r, 0, 1) + r(&plain, 0, 0)) * z(1, 0) + mu * r(&by_r, 1, 0) * z(0, 1);
            for (c, d, value) in [(0, 0, rr), (0, 1, rz), (1, 0, zr), (1, 1, zz)] {
                let (row, col) = (number[a][c], number[b][d]);
                if row != u32::MAX && col != u32::MAX && row >= col {
                    stiffness.push(Triplet::new(row, col, value));
                }
            }
        }
    }
    let nodes: Vec<[f64; 3]> =
        (0..nr * nz).map(|a| [radius * sr.greville(a % nr), length * sz.greville(a / nr), 0.0]).collect();
    let n = dofs.len();
    AssembledBody {
        name: "cylinder".into(),
        motion: RigidMotion::Axial,
        stiffness: lower(n, &stiffness),
        mass: MassMatrix::PerComponent(lower(nr * nz, &mass)),
        dofs,
        anchors: nodes.clone(),
        nodes,
    }
}

/// Free chain of equal masses \[kg\] and springs [N/m] along the axis; its frequencies are
/// `2 sqrt(k/m) sin(j pi / 2n)`, j = 0..n.
pub fn chain(n: usize, mass: f64, spring: f64) -> AssembledBody {
    let mut k = Vec::new();
    let mut m = Vec::new();
    for i in 0..n as u32 {
        let ends = f64::from(u8::from(i > 0)) + f64::from(u8::from(i + 1 < n as u32));
        k.push(Triplet::new(i, i, spring * ends));
        m.push(Triplet::new(i, i, mass));
        if i > 0 {
            k.push(Triplet::new(i, i - 1, -spring));
        }
    }
    let nodes: Vec<[f64; 3]> = (0..n).map(|i| [0.0, i as f64 * 0.01, 0.0]).collect();
    AssembledBody {
        name: "chain".into(),
        motion: RigidMotion::Axial,
        stiffness: lower(n, &k),
        mass: MassMatrix::General(lower(n, &m)),
        dofs: (0..n).map(|i| Dof { node: i as u32, component: 1 }).collect(),
        anchors: nodes.clone(),
        nodes,
    }
}

/// Unknowns of the nodes that `select` picks.
pub fn unknowns_at(body: &AssembledBody, select: impl Fn(&[f64; 3]) -> bool) -> Vec<usize> {
    (0..body.dofs.len()).filter(|&i| select(&body.nodes[body.dofs[i].node as usize])).collect()
}

/// `a^T b`.
pub fn gram(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    a.transpose() * b
}

/// Largest deviation of a square matrix from the identity.
pub fn from_identity(m: &Mat<f64>) -> f64 {
    let unit = Mat::<f64>::identity(m.nrows(), m.ncols());
    (m - unit).norm_max()
}

/// Sparse lower triangle from entries.
fn lower(n: usize, entries: &[Triplet<u32, u32, f64>]) -> SparseColMat<u32, f64> {
    SparseColMat::try_new_from_triplets(n, n, entries).expect("entries lie inside the matrix")
}
