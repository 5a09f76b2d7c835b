//! Patches and small helpers of these tests.

use iga_core::ParameterBox;
use iga_core::hierarchical::{PatchTies, SubdomainHierarchy, TwoScale};
use iga_core::nurbs::Patch;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::{Element, SplineSpace};
use iga_core::splines::knots::KnotVector;
use iga_core::splines::tensor;

/// Adds a level with elements split into `parts` around each of `regions`, grown by the degree so that the functions there really
/// are refined. Called level after level with the same regions the levels are nested.
pub fn refine_around(
    hierarchy: &mut SubdomainHierarchy,
    parts: [usize; 3],
    regions: &[ParameterBox],
    ties: &PatchTies,
) {
    let knots = hierarchy.levels()[0].knots();
    let degrees = std::array::from_fn(|d| knots.get(d).map_or(0, KnotVector::degree));
    let boxes = hierarchy.elements_around(regions, degrees, ties).unwrap();
    hierarchy.refine(parts, &boxes).unwrap();
}

/// Uniform B-splines on the unit cube with the identity as geometry.
pub fn unit_patch(degrees: &[usize], elements: &[usize]) -> Patch {
    let knots = degrees.iter().zip(elements).map(|(&p, &n)| KnotVector::uniform(p, n).unwrap()).collect();
    identity_patch(knots)
}

/// B-splines with given knots and the identity as geometry.
pub fn identity_patch(knots: Vec<KnotVector>) -> Patch {
    let sizes: Vec<usize> = knots.iter().map(KnotVector::n_functions).collect();
    let greville: Vec<Vec<f64>> = knots.iter().map(KnotVector::greville).collect();
    let point = |a: usize| {
        let index = tensor::multi_index(&sizes, a);
        std::array::from_fn(|d| greville.get(d).map_or(0.0, |g| g[index[d]]))
    };
    let n = sizes.iter().product();
    Patch::new(knots, (0..n).map(point).collect(), vec![1.0; n]).unwrap()
}

/// Control points and weights of arcs of 90°, `arcs` of them, starting on the x axis.
fn arcs(arcs: usize) -> Vec<([f64; 2], f64)> {
    let s = 0.5f64.sqrt();
    let corner = |k: usize| [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][k % 4];
    let mut net = vec![(corner(0), 1.0)];
    for k in 0..arcs {
        let (a, b): ([f64; 2], [f64; 2]) = (corner(k), corner(k + 1));
        net.push(([a[0] + b[0], a[1] + b[1]], s));
        net.push((b, 1.0));
    }
    net
}

/// Ring sector, disc or block of 90° arcs: angle, radius from `inner` to 1 and, in 3D, height from 0 to 0.5; degree 2
/// in each direction, `elements` a quarter and direction.
pub fn ring(dimension: usize, n_arcs: usize, inner: f64, elements: &[usize]) -> Patch {
    let mut angle = vec![0.0; 3];
    for k in 1..n_arcs {
        angle.extend([k as f64 / n_arcs as f64; 2]);
    }
    angle.extend([1.0; 3]);
    let mut knots = vec![KnotVector::new(2, angle).unwrap()];
    knots.extend((1..dimension).map(|_| KnotVector::uniform(2, 1).unwrap()));
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for z in [0.0, 0.25, 0.5].iter().take(if dimension == 3 { 3 } else { 1 }) {
        for r in [inner, 0.5 * (inner + 1.0), 1.0] {
            for (x, w) in arcs(n_arcs) {
                points.push([r * x[0], r * x[1], *z]);
                weights.push(w);
            }
        }
    }
    let coarse = Patch::new(knots, points, weights).unwrap();
    let fine = coarse.knots().iter().zip(elements).map(|(k, &n)| split(k, n)).collect();
    refined(&coarse, fine)
}

/// Splits every element into equal parts.
pub fn split(k: &KnotVector, parts: usize) -> KnotVector {
    let mut knots = k.knots().to_vec();
    for e in 0..k.n_elements() {
        let (a, b) = k.element(e);
        knots.extend((1..parts).map(|i| a + (b - a) * (i as f64 / parts as f64)));
    }
    knots.sort_by(f64::total_cmp);
    KnotVector::new(k.degree(), knots).unwrap()
}

/// The same patch with more knots.
pub fn refined(patch: &Patch, knots: Vec<KnotVector>) -> Patch {
    let relations: Vec<TwoScale> =
        patch.knots().iter().zip(&knots).map(|(a, b)| TwoScale::between(a, b).unwrap()).collect();
    let (coarse, fine) = (patch.net_size(), knots.iter().map(KnotVector::n_functions).collect::<Vec<_>>());
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for a in 0..tensor::count(&fine) {
        let j = tensor::multi_index(&fine, a);
        let mut h = [0.0; 4];
        for (b, (x, w)) in patch.control_points().iter().zip(patch.weights()).enumerate() {
            let i = tensor::multi_index(&coarse, b);
            let c: f64 = relations.iter().enumerate().map(|(d, r)| r.coefficient(i[d], j[d])).product();
            (0..3).for_each(|k| h[k] += c * w * x[k]);
            h[3] += c * w;
        }
        points.push([h[0] / h[3], h[1] / h[3], h[2] / h[3]]);
        weights.push(h[3]);
    }
    Patch::new(knots, points, weights).unwrap()
}

/// Point of an element at relative coordinates `s`.
pub fn inside(element: &Element, s: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|d| element.lower[d] + s[d] * (element.upper[d] - element.lower[d]))
}

/// Some places in an element, no two coordinates alike.
pub const PLACES: [[f64; 3]; 2] = [[0.137, 0.761, 0.418], [0.913, 0.294, 0.652]];

/// `Σ R_i c_i` at a point.
pub fn field<const N: usize>(space: &dyn SplineSpace, coefficients: &[[f64; N]], xi: &[f64; 3]) -> [f64; N] {
    let e = space.find_element(0, xi);
    let (mut basis, mut active) = (PointBasis::default(), Vec::new());
    space.evaluate(e, xi, 0, &mut basis);
    space.active_functions(e, &mut active);
    let mut sum = [0.0; N];
    for (&f, r) in active.iter().zip(&basis.values) {
        for (s, c) in sum.iter_mut().zip(&coefficients[f as usize]) {
            *s += r * c;
        }
    }
    sum
}

/// Numbers between -1 and 1 without pattern.
pub fn noise(n: usize) -> Vec<[f64; 3]> {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| [next(), next(), next()]).collect()
}
