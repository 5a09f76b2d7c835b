//! Measures of shapes by quadrature over their elements and faces.

use std::f64::consts::{PI, TAU};

use iga_core::nurbs::Face;
use iga_core::nurbs::Shape;
use iga_core::nurbs::patch::PointBasis;

/// Gauss-Legendre rule with `n` points on [0, 1], by Newton on the Legendre polynomial.
pub fn gauss(n: usize) -> Vec<(f64, f64)> {
    let rule = (0..n).map(|i| {
        let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..50 {
            let (mut p0, mut p1) = (1.0, x);
            for k in 2..=n {
                (p0, p1) = (p1, ((2 * k - 1) as f64 * x * p1 - (k - 1) as f64 * p0) / k as f64);
            }
            slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
            x -= p1 / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    });
    rule.collect()
}

/// `∫ f` over `[a, b]`.
pub fn integral(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    gauss(40).iter().map(|(s, w)| w * (b - a) * f(a + s * (b - a))).sum()
}

/// Volume, area, centre and second moments `∫ x² dV`, `∫ y² dV`, `∫ z² dV` about the origin. Of axisymmetric bodies those of the solid.
#[derive(Debug, Clone, Copy, Default)]
pub struct Measures {
    pub volume: f64,
    pub area: f64,
    pub centre: [f64; 3],
    pub second: [f64; 3],
}

/// Gauss points per direction of an element: integrands are rational, with denominators near enough to constant for round-off.
const POINTS: usize = 16;

pub fn measures(shape: &Shape, is_axisymmetric: bool) -> Measures {
    let (rule, mut scratch) = (gauss(POINTS), PointBasis::default());
    let mut sums = Measures::default();
    for patch in &shape.patches {
        let n = patch.dimension();
        for e in 0..patch.n_elements() {
            let (lower, upper) = patch.element(e);
            for q in 0..POINTS.pow(n as u32) {
                let (mut xi, mut weight) = ([0.0; 3], 1.0);
                for k in 0..n {
                    let (s, w) = rule[q / POINTS.pow(k as u32) % POINTS];
                    xi[k] = lower[k] + s * (upper[k] - lower[k]);
                    weight *= w * (upper[k] - lower[k]);
                }
                let jet = patch.jet_on(e, &xi, 1, &mut scratch);
                let [x, y, z] = jet.point;
                let mut v = weight * jet.determinant(n);
                let (first, second) = if is_axisymmetric {
                    v *= TAU * x;
                    ([0.0, 0.0, y], [0.5 * x * x, 0.5 * x * x, y * y])
                } else {
                    (jet.point, [x * x, y * y, z * z])
                };
                sums.volume += v;
                for d in 0..3 {
                    sums.centre[d] += v * first[d];
                    sums.second[d] += v * second[d];
                }
            }
        }
    }
    sums.centre = sums.centre.map(|m| m / sums.volume);
    for face in Face::outer(&shape.patches, is_axisymmetric) {
        sums.area += area(shape, &face, &rule);
    }
    sums
}

fn area(shape: &Shape, face: &Face, rule: &[(f64, f64)]) -> f64 {
    let (patch, mut scratch) = (&shape.patches[face.id.patch], PointBasis::default());
    let (mut sum, along) = (0.0, face.directions().collect::<Vec<_>>());
    let breaks: Vec<Vec<f64>> = patch.knots().iter().map(|k| k.breaks()).collect();
    let spans = |d: usize| breaks[d].windows(2).map(|w| [w[0], w[1]]).collect::<Vec<_>>();
    let whole = vec![[0.0, 1.0]];
    let second = along.get(1).map_or(whole, |d| spans(*d));
    for [a, b] in spans(along[0]) {
        for [c, d] in &second {
            for (s, w) in rule {
                for (t, v) in if along.len() == 2 { rule } else { &[(0.0, 1.0)] } {
                    let mut xi = [0.0; 3];
                    xi[along[0]] = a + s * (b - a);
                    along.get(1).into_iter().for_each(|e| xi[*e] = c + t * (d - c));
                    let size = if along.len() == 2 { (b - a) * (d - c) } else { b - a };
                    sum += w * v * size * face.at(patch, &xi, &mut scratch).area;
                }
            }
        }
    }
    sum
}
