//! Bézier extraction of faces: the functions of a space on a part of an element's side as Bernstein
//! polynomials (theory Eqs. C.27, C.37).

use crate::nurbs::Patch;
use crate::nurbs::face::Face;
use crate::nurbs::patch::PointBasis;
use crate::space::Space;
use crate::splines::bernstein::{Interpolation, apply};
use crate::splines::knots::MAX_DEGREE;

/// Finds the Bernstein coefficients of the functions of a space on faces.
///
/// Whatever the space, its functions on an element are `N_A / W` with the weight function `W` of
/// the patch and polynomials `N_A` of its degrees, so that interpolation finds them exactly.
pub struct Extraction<'a> {
    space: &'a dyn Space,
    patches: &'a [Patch],
    rules: Vec<Interpolation>,
    basis: PointBasis,
}

/// A box of parameters on the side of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementSide {
    /// The face that it lies on.
    pub face: Face,
    /// Element of the space.
    pub element: usize,
    /// Lower corner in the parameters of the patch; the fixed direction has equal ends.
    pub lower: [f64; 3],
    /// Upper corner.
    pub upper: [f64; 3],
}

impl ElementSide {
    /// Whether a place with the parameters `xi` lies on the side, ends included.
    pub fn holds(&self, xi: &[f64; 3]) -> bool {
        self.face.directions().all(|d| (self.lower[d]..=self.upper[d]).contains(&xi[d]))
    }

    /// The sides of the elements of `space` that lie on `face`.
    pub fn all<'a>(space: &'a dyn Space, face: &Face) -> impl Iterator<Item = Self> + use<'a> {
        let face = *face;
        let d = face.id.direction;
        (0..space.n_elements()).filter_map(move |e| {
            let element = space.element(e);
            let end = if face.id.upper { element.upper[d] } else { element.lower[d] };
            // Ends of ranges are copied, not computed: equal in every bit.
            let is_there = element.patch == face.id.patch && end.total_cmp(&face.parameter).is_eq();
            let (lower, upper) = (face.on_face(&element.lower), face.on_face(&element.upper));
            is_there.then_some(Self { face, element: e, lower, upper })
        })
    }

    /// Parameters in the patch of the place `s` in `[0, 1]²`, the directions along the face rising.
    pub fn parameters(&self, s: [f64; 2]) -> [f64; 3] {
        let mut xi = self.lower;
        for (d, s) in self.face.directions().zip(s) {
            xi[d] += s * (self.upper[d] - self.lower[d]);
        }
        xi
    }
}

impl<'a> Extraction<'a> {
    /// Extraction of `space` over `patches`, which carry its weight function: the refined ones of a
    /// plain space, the coarsest of a hierarchical one.
    pub fn new(space: &'a dyn Space, patches: &'a [Patch]) -> Self {
        let rules = (0..=MAX_DEGREE).map(Interpolation::new).collect();
        Self { space, patches, rules, basis: PointBasis::default() }
    }

    /// Degrees along `face`, see [`Face::degrees`].
    pub fn degrees(&self, face: &Face) -> [usize; 2] {
        face.degrees(&self.patches[face.id.patch])
    }

    /// Values of the polynomials `N_A = R_A W` of the element's active functions at the nodes of
    /// `side`, node by node.
    pub fn numerators(&mut self, side: &ElementSide) -> Vec<Vec<f64>> {
        let [a, b] = self.degrees(&side.face);
        let mut all = Vec::with_capacity((a + 1) * (b + 1));
        for t in &self.rules[b].nodes {
            for s in &self.rules[a].nodes {
                let xi = side.parameters([*s, *t]);
                self.space.evaluate(side.element, &xi, 0, &mut self.basis);
                let weight = self.patches[side.face.id.patch].weight_function(&xi);
                all.push(self.basis.values.iter().map(|r| r * weight).collect());
            }
        }
        all
    }

    /// Bernstein coefficients of a polynomial with the degrees of `face` from its values at the
    /// nodes, first direction fastest.
    pub fn coefficients<const N: usize>(&self, face: &Face, values: &[[f64; N]]) -> Vec<[f64; N]> {
        let [a, b] = self.degrees(face).map(|p| &self.rules[p].coefficients);
        apply(&[a, b], values)
    }
}
