//! Shape functions of elements and sides with their derivatives by the parameters.
//!
//! Sources: O. C. Zienkiewicz, R. L. Taylor, J. Z. Zhu: The Finite Element Method, Its Basis and
//! Fundamentals, chapter on standard and hierarchical shape functions; products of quadratic
//! Lagrange functions for the kinds with 9, 18 and 27 nodes.
//!
//! Pyramids: G. Bedrosian, Shape functions and integration formulas for three-dimensional finite
//! element analysis, Int. J. Numer. Meth. Eng. 35, 1992, with 5 and 13 nodes: rational functions
//! that are those of triangles and of the quadrilateral on the sides. With 14 nodes
//! `(w² - ξ²)(w² - η²)/w²`, `w = 1 - ζ`, belongs to the middle of the base, which makes the optimal
//! space of second order of M. Bergot, G. Cohen, M. Duruflé, J. Sci. Comput. 42, 2010. Derivatives
//! have a limit at the apex for each direction from which it is approached; there they are those
//! along the axis.

use crate::element::kind::{ElementKind, SideKind};

/// Values and derivatives of the functions of an element at one point, by node.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Functions<const D: usize> {
    /// Values.
    pub values: Vec<f64>,
    /// Derivatives by the `D` parameters.
    pub slopes: Vec<[f64; D]>,
}

/// Value of a product with its slopes, from the values and slopes of its factors.
fn product<const D: usize>(factors: &[(f64, [f64; D])]) -> (f64, [f64; D]) {
    let mut out = (1.0, [0.0; D]);
    for (value, slope) in factors {
        out.1 = std::array::from_fn(|d| out.1[d] * value + out.0 * slope[d]);
        out.0 *= value;
    }
    out
}

fn scaled<const D: usize>((value, slope): (f64, [f64; D]), by: f64) -> (f64, [f64; D]) {
    (by * value, slope.map(|s| by * s))
}

/// The function of `x` alone among `D` parameters.
fn along<const D: usize>(d: usize, (value, slope): (f64, f64)) -> (f64, [f64; D]) {
    let mut slopes = [0.0; D];
    slopes[d] = slope;
    (value, slopes)
}

/// Barycentric coordinates of the first two parameters, of three if `D` of them count.
fn barycentric<const D: usize>(n: usize, xi: &[f64; D]) -> [(f64, [f64; D]); 4] {
    let mut all = [(0.0, [0.0; D]); 4];
    all[0] = (1.0 - xi[..n].iter().sum::<f64>(), std::array::from_fn(|d| if d < n { -1.0 } else { 0.0 }));
    for d in 0..n {
        all[d + 1] = along(d, (xi[d], 1.0));
    }
    all
}

/// Quadratic Lagrange function on `[-1, 1]` of the node at `at`, -1, 0 or 1.
fn line3(at: f64, x: f64) -> (f64, f64) {
    if at == 0.0 { (1.0 - x * x, -2.0 * x) } else { (0.5 * x * (x + at), x + 0.5 * at) }
}

/// Linear function on `[-1, 1]` of the node at `at`, -1 or 1.
fn line2(at: f64, x: f64) -> (f64, f64) {
    (0.5 * (1.0 + at * x), 0.5 * at)
}

/// `(1 - x²)`.
fn bubble(x: f64) -> (f64, f64) {
    (1.0 - x * x, -2.0 * x)
}

/// `L (2 L - 1)`.
fn corner<const D: usize>((value, slope): (f64, [f64; D])) -> (f64, [f64; D]) {
    (value * (2.0 * value - 1.0), slope.map(|s| (4.0 * value - 1.0) * s))
}

/// Distance from the apex of a pyramid, in its height, within which a point is the apex: round-off.
const APEX: f64 = 1e-14;

/// What the functions of pyramids are made of, with `w = 1 - ζ`.
struct Collapsed {
    w: f64,
    /// `ξ/w` and `η/w`, zero at the apex: on the axis.
    ratios: [f64; 2],
    xi: [f64; 3],
}

impl Collapsed {
    fn new(xi: &[f64; 3]) -> Self {
        let w = 1.0 - xi[2];
        if w.abs() < APEX {
            return Self { w: 0.0, ratios: [0.0; 2], xi: [0.0, 0.0, 1.0] };
        }
        Self { w, ratios: [xi[0] / w, xi[1] / w], xi: *xi }
    }

    /// `w + s ξ_d`, zero on a triangular side.
    fn side(&self, d: usize, s: f64) -> (f64, [f64; 3]) {
        let mut slope = [0.0, 0.0, -1.0];
        slope[d] = s;
        (self.w + s * self.xi[d], slope)
    }

    /// `(w + s ξ)(w + t η)/w`, which on a side is a polynomial, exactly so where parameters are
    /// multiples of a power of two.
    fn quotient(&self, [s, t]: [f64; 2]) -> (f64, [f64; 3]) {
        let value = if self.w == 0.0 { 0.0 } else { self.side(0, s).0 * self.side(1, t).0 / self.w };
        let [a, b] = [s * self.ratios[0], t * self.ratios[1]];
        (value, [s * (1.0 + b), t * (1.0 + a), a * b - 1.0])
    }
}

impl<const D: usize> Functions<D> {
    fn clear(&mut self) {
        self.values.clear();
        self.slopes.clear();
    }

    fn push(&mut self, (value, slope): (f64, [f64; D])) {
        self.values.push(value);
        self.slopes.push(slope);
    }

    /// The serendipity functions of a cube or square, of the first `n` parameters, with nodes at
    /// `nodes`.
    fn serendipity(&mut self, n: usize, nodes: &[[f64; D]], xi: &[f64; D]) {
        for node in nodes {
            let factor =
                |d: usize| along(d, if node[d] == 0.0 { bubble(xi[d]) } else { line2(node[d], xi[d]) });
            let factors: [(f64, [f64; D]); D] = std::array::from_fn(factor);
            let mut function = product(&factors[..n]);
            if node[..n].iter().all(|c| *c != 0.0) {
                let sum = (0..n).map(|d| node[d] * xi[d]).sum::<f64>() - (n as f64 - 1.0);
                function = product(&[function, (sum, *node)]);
            }
            self.push(function);
        }
    }

    /// Products of Lagrange functions along each of the first `n` directions.
    fn lagrange(
        &mut self,
        n: usize,
        nodes: &[[f64; D]],
        xi: &[f64; D],
        line: impl Fn(f64, f64) -> (f64, f64),
    ) {
        for node in nodes {
            let factors: [(f64, [f64; D]); D] = std::array::from_fn(|d| along(d, line(node[d], xi[d])));
            self.push(product(&factors[..n]));
        }
    }

    /// The quadratic functions of the triangle of the first two parameters.
    fn triangle(&mut self, xi: &[f64; D]) {
        let l = barycentric(2, xi);
        (0..3).for_each(|a| self.push(corner(l[a])));
        (0..3).for_each(|a| self.push(scaled(product(&[l[a], l[(a + 1) % 3]]), 4.0)));
    }
}

impl ElementKind {
    /// Functions at the parameters `xi`, into `out`.
    pub fn functions(self, xi: &[f64; 3], out: &mut Functions<3>) {
        out.clear();
        match self {
            Self::Tet4 => barycentric(3, xi).into_iter().for_each(|l| out.push(l)),
            Self::Tet10 => {
                let l = barycentric(3, xi);
                l.into_iter().for_each(|l| out.push(corner(l)));
                for [a, b] in self.edges() {
                    out.push(scaled(product(&[l[*a as usize], l[*b as usize]]), 4.0));
                }
            }
            Self::Hex8 => out.lagrange(3, self.corners(), xi, line2),
            Self::Hex20 => out.serendipity(3, &self.node_parameters(), xi),
            Self::Hex27 => out.lagrange(3, &self.node_parameters(), xi, line3),
            Self::Tri3 => barycentric(2, xi).into_iter().take(3).for_each(|l| out.push(l)),
            Self::Tri6 => out.triangle(xi),
            Self::Quad4 => out.lagrange(2, self.corners(), xi, line2),
            Self::Quad8 => out.serendipity(2, &self.node_parameters(), xi),
            Self::Quad9 => out.lagrange(2, &self.node_parameters(), xi, line3),
            Self::Wedge6 | Self::Wedge15 | Self::Wedge18 => self.wedge(xi, out),
            Self::Pyramid5 | Self::Pyramid13 | Self::Pyramid14 => self.pyramid(xi, out),
        }
    }

    fn pyramid(self, xi: &[f64; 3], out: &mut Functions<3>) {
        let at = Collapsed::new(xi);
        let height = along(2, (at.xi[2], 1.0));
        let base = &self.corners()[..4];
        let quotient = |of: &[f64; 3]| at.quotient([of[0], of[1]]);
        if self == Self::Pyramid5 {
            base.iter().for_each(|of| out.push(scaled(quotient(of), 0.25)));
            out.push(height);
            return;
        }
        // The function of the middle of the base, in the kind that has none zero.
        let middle = if self == Self::Pyramid14 {
            product(&[at.quotient([1.0, 1.0]), at.quotient([-1.0, -1.0])])
        } else {
            (0.0, [0.0; 3])
        };
        let mut with_middle = |(value, slope): (f64, [f64; 3]), share: f64| {
            out.push((value + share * middle.0, [0, 1, 2].map(|d| slope[d] + share * middle.1[d])));
        };
        for of in base {
            let line = (of[0] * at.xi[0] + of[1] * at.xi[1] - 1.0, [of[0], of[1], 0.0]);
            with_middle(scaled(product(&[quotient(of), line]), 0.25), 0.25);
        }
        with_middle(corner(height), 0.0);
        for (k, edge) in self.edges()[..4].iter().enumerate() {
            // The direction along the edge, and the end at -1.
            let (d, of) = (k % 2, base[edge[0] as usize]);
            let mut end = [of[0], of[1]];
            end[d] = -1.0;
            with_middle(scaled(product(&[at.side(d, 1.0), at.quotient(end)]), 0.5), -0.5);
        }
        for of in base {
            with_middle(product(&[height, quotient(of)]), 0.0);
        }
        if self == Self::Pyramid14 {
            out.push(middle);
        }
    }

    fn wedge(self, xi: &[f64; 3], out: &mut Functions<3>) {
        let l = barycentric(2, xi);
        let linear = |at: f64| along(2, line2(at, xi[2]));
        let quadratic = |at: f64| along(2, line3(at, xi[2]));
        let ends = [-1.0, 1.0];
        let middle = |a: usize| scaled(product(&[l[a], l[(a + 1) % 3]]), 4.0);
        match self {
            Self::Wedge6 => {
                ends.iter().for_each(|&at| (0..3).for_each(|a| out.push(product(&[l[a], linear(at)]))));
            }
            Self::Wedge15 => {
                for at in ends {
                    for l in &l[..3] {
                        let (value, slope) = product(&[corner(*l), linear(at)]);
                        let (less, less_slope) = scaled(product(&[*l, along(2, bubble(xi[2]))]), 0.5);
                        out.push((value - less, std::array::from_fn(|d| slope[d] - less_slope[d])));
                    }
                }
                ends.iter().for_each(|&at| (0..3).for_each(|a| out.push(product(&[middle(a), linear(at)]))));
                (0..3).for_each(|a| out.push(product(&[l[a], along(2, bubble(xi[2]))])));
            }
            _ => {
                for at in ends {
                    (0..3).for_each(|a| out.push(product(&[corner(l[a]), quadratic(at)])));
                }
                for at in ends {
                    (0..3).for_each(|a| out.push(product(&[middle(a), quadratic(at)])));
                }
                (0..3).for_each(|a| out.push(product(&[corner(l[a]), quadratic(0.0)])));
                (0..3).for_each(|a| out.push(product(&[middle(a), quadratic(0.0)])));
            }
        }
    }
}

impl SideKind {
    /// Functions at the parameters `xi`, into `out`.
    pub fn functions(self, xi: &[f64; 2], out: &mut Functions<2>) {
        out.clear();
        match self {
            Self::Tri3 => barycentric(2, xi).into_iter().take(3).for_each(|l| out.push(l)),
            Self::Tri6 => out.triangle(xi),
            Self::Line2 => out.lagrange(1, &self.node_parameters(), xi, line2),
            Self::Line3 => out.lagrange(1, &self.node_parameters(), xi, line3),
            Self::Quad4 => out.lagrange(2, &self.node_parameters(), xi, line2),
            Self::Quad8 => out.serendipity(2, &self.node_parameters(), xi),
            Self::Quad9 => out.lagrange(2, &self.node_parameters(), xi, line3),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INSIDE: [[f64; 3]; 3] = [[0.2, 0.3, 0.1], [0.05, 0.6, 0.25], [0.31, 0.17, -0.4]];

    fn at(kind: ElementKind, xi: &[f64; 3]) -> Functions<3> {
        let mut f = Functions::default();
        kind.functions(xi, &mut f);
        f
    }

    #[test]
    fn functions_sum_to_one_and_reproduce_the_parameters() {
        for kind in ElementKind::ALL {
            let nodes = kind.node_parameters();
            assert_eq!(nodes.len(), kind.n_nodes());
            for xi in &INSIDE {
                let f = at(kind, xi);
                // Some thirty terms of order one: round-off below 1e-14.
                assert!((f.values.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{kind:?}");
                for d in 0..kind.dimension() {
                    let sum: f64 = f.values.iter().zip(&nodes).map(|(v, n)| v * n[d]).sum();
                    assert!((sum - xi[d]).abs() < 1e-14, "{kind:?}");
                    for e in 0..3 {
                        let slope: f64 = f.slopes.iter().zip(&nodes).map(|(s, n)| s[e] * n[d]).sum();
                        assert!((slope - f64::from(u8::from(d == e))).abs() < 1e-14, "{kind:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_function_is_one_at_its_node_and_zero_at_the_others() {
        for kind in ElementKind::ALL {
            for (a, node) in kind.node_parameters().iter().enumerate() {
                for (b, value) in at(kind, node).values.iter().enumerate() {
                    assert!((value - f64::from(u8::from(a == b))).abs() < 1e-15, "{kind:?}: {a}, {b}");
                }
            }
        }
        for kind in SideKind::ALL {
            let mut f = Functions::default();
            for (a, node) in kind.node_parameters().iter().enumerate() {
                kind.functions(node, &mut f);
                for (b, value) in f.values.iter().enumerate() {
                    assert!((value - f64::from(u8::from(a == b))).abs() < 1e-15, "{kind:?}: {a}, {b}");
                }
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_values() {
        // Central differences: error h² f''' / 6 + round-off / h, about 1e-10 at h = 1e-5.
        let h = 1e-5;
        for kind in ElementKind::ALL {
            for xi in &INSIDE {
                let f = at(kind, xi);
                for d in 0..3 {
                    let shifted = |by: f64| {
                        let mut x = *xi;
                        x[d] += by;
                        at(kind, &x).values
                    };
                    let (more, less) = (shifted(h), shifted(-h));
                    for a in 0..kind.n_nodes() {
                        let slope = (more[a] - less[a]) / (2.0 * h);
                        assert!((slope - f.slopes[a][d]).abs() < 1e-9, "{kind:?}");
                    }
                }
            }
        }
        for kind in SideKind::ALL {
            let (mut f, mut more, mut less) =
                (Functions::default(), Functions::default(), Functions::default());
            for xi in INSIDE.map(|x| [x[0], x[1]]) {
                kind.functions(&xi, &mut f);
                for d in 0..2 {
                    let mut x = xi;
                    x[d] += h;
                    kind.functions(&x, &mut more);
                    x[d] -= 2.0 * h;
                    kind.functions(&x, &mut less);
                    for a in 0..kind.n_nodes() {
                        let slope = (more.values[a] - less.values[a]) / (2.0 * h);
                        assert!((slope - f.slopes[a][d]).abs() < 1e-9, "{kind:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_side_has_the_functions_that_its_element_has_there() {
        for kind in ElementKind::ALL {
            let parameters = kind.node_parameters();
            for number in 0..kind.sides().len() {
                let (side, nodes) = kind.side_nodes(number);
                assert_eq!(nodes.len(), side.n_nodes());
                let (mut f, eta) = (Functions::default(), [0.3, 0.25]);
                side.functions(&eta, &mut f);
                let places = nodes.iter().map(|&n| parameters[n as usize]);
                let mut xi = [0.0; 3];
                for (value, place) in f.values.iter().zip(places) {
                    (0..3).for_each(|d| xi[d] += value * place[d]);
                }
                let whole = at(kind, &xi);
                for (node, value) in whole.values.iter().enumerate() {
                    let own = nodes.iter().position(|&n| n as usize == node).map_or(0.0, |k| f.values[k]);
                    assert!((value - own).abs() < 1e-14, "{kind:?} side {number} node {node}");
                }
            }
        }
    }
}
