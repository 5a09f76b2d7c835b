//! Pieces of elements: boxes, tetrahedra, wedges, triangles and squares of the element's parameters,
//! halved along every edge.

use crate::element::kind::{ElementKind, Form};
use crate::element::shape::Functions;

/// Most corners of a cell.
const MOST_CORNERS: usize = 8;

/// A piece of an element, the affine image of a whole one in the element's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// The element.
    pub element: u32,
    /// How often the element was halved.
    pub level: u8,
    /// Parameters of the corners in the element; multiples of a power of two, so that all that
    /// follows from them is exact.
    pub corners: [[f64; 3]; MOST_CORNERS],
}

/// Corners of the children of a tetrahedron, each the middle of two corners of the parent (J. Bey:
/// Tetrahedral grid refinement, Computing 55, 1995): cells of any level have at most three shapes.
const TETRAHEDRA: [[[usize; 2]; 4]; 8] = [
    [[0, 0], [0, 1], [0, 2], [0, 3]],
    [[0, 1], [1, 1], [1, 2], [1, 3]],
    [[0, 2], [1, 2], [2, 2], [2, 3]],
    [[0, 3], [1, 3], [2, 3], [3, 3]],
    [[0, 1], [0, 2], [0, 3], [1, 3]],
    [[0, 1], [0, 2], [1, 2], [1, 3]],
    [[0, 2], [0, 3], [1, 3], [2, 3]],
    [[0, 2], [1, 2], [1, 3], [2, 3]],
];
/// The four triangles into which a triangle is divided, each corner as the middle of two corners of
/// the whole.
const TRIANGLES: [[[usize; 2]; 3]; 4] =
    [[[0, 0], [0, 1], [0, 2]], [[0, 1], [1, 1], [1, 2]], [[0, 2], [1, 2], [2, 2]], [[0, 1], [1, 2], [0, 2]]];

fn mean(of: &[[f64; 3]]) -> [f64; 3] {
    let share = 1.0 / of.len() as f64;
    [0, 1, 2].map(|d| share * of.iter().map(|x| x[d]).sum::<f64>())
}

impl Cell {
    /// The whole of element `element`.
    pub fn whole(kind: ElementKind, element: u32) -> Self {
        let mut corners = [[0.0; 3]; MOST_CORNERS];
        corners.iter_mut().zip(kind.corners()).for_each(|(to, from)| *to = *from);
        Self { element, level: 0, corners }
    }

    /// Parameters in the element of the point of the cell with the parameters `xi` of a whole
    /// element.
    pub fn at(&self, kind: ElementKind, xi: &[f64; 3]) -> [f64; 3] {
        let mut functions = Functions::default();
        kind.linear().functions(xi, &mut functions);
        let mut at = [0.0; 3];
        for (value, corner) in functions.values.iter().zip(&self.corners) {
            (0..3).for_each(|d| at[d] += value * corner[d]);
        }
        at
    }

    /// The eight halves, four in the plane; none of a pyramid, six of whose pieces are pyramids and four tetrahedra.
    pub fn children(&self, kind: ElementKind) -> Option<Vec<Self>> {
        let child = |corners: &[[f64; 3]]| {
            let mut own = [[0.0; 3]; MOST_CORNERS];
            own[..corners.len()].copy_from_slice(corners);
            Self { element: self.element, level: self.level + 1, corners: own }
        };
        let c = &self.corners;
        Some(match kind.form() {
            Form::Tetrahedron => {
                let corners = |of: &[[usize; 2]; 4]| of.map(|[a, b]| mean(&[c[a], c[b]]));
                TETRAHEDRA.iter().map(|of| child(&corners(of))).collect()
            }
            Form::Triangle => {
                let corners = |of: &[[usize; 2]; 3]| of.map(|[a, b]| mean(&[c[a], c[b]]));
                TRIANGLES.iter().map(|of| child(&corners(of))).collect()
            }
            Form::Hexahedron | Form::Quadrilateral => {
                let corners = |v: usize| -> Vec<[f64; 3]> {
                    kind.corners()
                        .iter()
                        .map(|x| {
                            let towards = kind.corners()[v];
                            self.at(kind, &[0, 1, 2].map(|d| 0.5 * (x[d] + towards[d])))
                        })
                        .collect()
                };
                (0..kind.n_corners()).map(|v| child(&corners(v))).collect()
            }
            Form::Wedge => {
                let level = |at: [f64; 2], [a, b]: [usize; 2]| {
                    let line = |k: usize| {
                        let (low, high) = (c[k], c[k + 3]);
                        [0, 1, 2].map(|d| at[0] * low[d] + at[1] * high[d])
                    };
                    mean(&[line(a), line(b)])
                };
                let ends = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];
                let pieces = (0..2).flat_map(|half| TRIANGLES.map(|triangle| (half, triangle)));
                pieces
                    .map(|(half, triangle)| {
                        let of = |end: [f64; 2]| triangle.map(|pair| level(end, pair));
                        child(&[of(ends[half]), of(ends[half + 1])].concat())
                    })
                    .collect()
            }
            Form::Pyramid => return None,
        })
    }

    /// The cell with its corners in the order of its kind, which some children of tetrahedra have
    /// mirrored.
    pub fn oriented(mut self, kind: ElementKind) -> Self {
        if kind.form() == Form::Tetrahedron {
            let c = &self.corners;
            let edge = |k: usize| [0, 1, 2].map(|d| c[k][d] - c[0][d]);
            if crate::element::jacobian::determinant(&[edge(1), edge(2), edge(3)]) < 0.0 {
                self.corners.swap(2, 3);
            }
        }
        self
    }
}

/// Parameters of places on edges and sides of a whole element that are nodes of the halves beside
/// it.
pub struct Seams {
    /// Quarters of the edges, and on sides the middles of the edges between the halves: corners of
    /// a neighbour that was halved twice, nodes of a quadratic one that was halved once.
    pub second: Vec<[f64; 3]>,
    /// Middles of edges and of four-sided sides.
    pub first: Vec<[f64; 3]>,
}

impl Seams {
    /// The seams of the cells of elements of kind `kind`.
    pub fn new(kind: ElementKind) -> Self {
        let corners = kind.corners();
        let sum = |of: &[(u8, f64)]| {
            [0, 1, 2].map(|d| of.iter().map(|(c, w)| w * corners[*c as usize][d]).sum::<f64>())
        };
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for &[a, b] in kind.edges() {
            first.push(sum(&[(a, 0.5), (b, 0.5)]));
            second.extend([sum(&[(a, 0.75), (b, 0.25)]), sum(&[(a, 0.25), (b, 0.75)])]);
        }
        for side in kind.sides() {
            match **side {
                [a, b, c] => {
                    let near = |a, b, c| sum(&[(a, 0.5), (b, 0.25), (c, 0.25)]);
                    second.extend([near(a, b, c), near(b, c, a), near(c, a, b)]);
                }
                [a, b, c, d] => {
                    first.push(sum(&[(a, 0.25), (b, 0.25), (c, 0.25), (d, 0.25)]));
                    for (p, q, r, s) in [(a, b, c, d), (b, c, d, a), (c, d, a, b), (d, a, b, c)] {
                        // Between the middle of an edge and that of the side, and in the middle of
                        // a quarter.
                        second.push(sum(&[(p, 0.375), (q, 0.375), (r, 0.125), (s, 0.125)]));
                        second.push(sum(&[(p, 0.5625), (q, 0.1875), (r, 0.0625), (s, 0.1875)]));
                    }
                }
                _ => {}
            }
        }
        Self { second, first }
    }
}
