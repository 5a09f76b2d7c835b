//! Check that the functions agree on both sides of seams and shared faces and around collapsed
//! edges (theory sections H.5, H.8).

use super::HierarchicalSpace;
use crate::SplineError;
use crate::hierarchical::neighbours::SharedFace;
use crate::hierarchical::ties::CollapsedSet;
use crate::nurbs::patch::PointBasis;
use crate::space::{Space, SplineSpace};

/// Largest difference of a function between the two sides: round-off of nets with twelve good
/// digits.
const AGREEMENT: f64 = 1e-9;

/// Places of sample points inside an element, irrational so that no difference happens to vanish
/// there.
const SAMPLES: [f64; 2] = [std::f64::consts::FRAC_1_PI, std::f64::consts::LN_2];

impl HierarchicalSpace {
    /// Compares all functions at sample points of every element at a seam, a collapsed edge or a
    /// shared face.
    ///
    /// # Errors
    /// [`SplineError::OpenSeam`] where they differ.
    pub(super) fn check_seams(&self) -> Result<(), SplineError> {
        if (0..self.n_patches()).all(|patch| self.basis(patch).hierarchy().levels().len() == 1) {
            return Ok(());
        }
        for patch in 0..self.n_patches() {
            self.check_ties(patch)?;
            for face in self.neighbours().of(patch) {
                let mut ends = [None; 3];
                ends[face.own.direction] = Some(face.own.upper);
                self.compare("face between patches", (patch, &ends), |xi| {
                    *xi = self.across(face, xi);
                    face.other.patch
                })?;
            }
        }
        Ok(())
    }

    fn check_ties(&self, patch: usize) -> Result<(), SplineError> {
        for d in (0..self.dimension()).filter(|&d| self.ties(patch).seams[d]) {
            for upper in [false, true] {
                let mut ends = [None; 3];
                ends[d] = Some(upper);
                self.compare("seam", (patch, &ends), |xi| {
                    xi[d] = self.end(patch, d, !upper);
                    patch
                })?;
            }
        }
        for set in self.ties(patch).collapsed.iter().filter(|s| !s.is_point()) {
            let CollapsedSet { ends, along } = set;
            for d in (0..self.dimension()).filter(|&d| along[d]) {
                self.compare("collapsed edge", (patch, ends), |xi| {
                    xi[d] = self.end(patch, d, false);
                    patch
                })?;
            }
        }
        Ok(())
    }

    fn end(&self, patch: usize, d: usize, upper: bool) -> f64 {
        let (a, b) = self.basis(patch).hierarchy().levels()[0].knots()[d].domain();
        if upper { b } else { a }
    }

    /// The parameters in the other patch of the place `xi` of a shared face.
    fn across(&self, face: &SharedFace, xi: &[f64; 3]) -> [f64; 3] {
        let (own, other) = (face.own.patch, face.other.patch);
        let mut there = [0.0; 3];
        there[face.other.direction] = self.end(other, face.other.direction, face.other.upper);
        for (d, u) in xi.iter().enumerate() {
            let Some((along, is_reversed)) = face.direction(d) else { continue };
            let [first, last] = [false, true].map(|upper| self.end(own, d, upper));
            let share = (u - first) / (last - first);
            let [first, last] = [false, true].map(|upper| self.end(other, along, upper != is_reversed));
            there[along] = first + share * (last - first);
        }
        there
    }

    /// Compares the functions on a face or edge of a patch with those at the points that `partner`
    /// makes of its points, in the patch that it tells.
    fn compare(
        &self,
        what: &'static str,
        (patch, ends): (usize, &[Option<bool>; 3]),
        partner: impl Fn(&mut [f64; 3]) -> usize,
    ) -> Result<(), SplineError> {
        let mut basis = PointBasis::default();
        let mut difference = vec![0.0; self.n_functions()];
        for e in self.elements_of(patch) {
            let element = self.element(e);
            let touches = (0..self.dimension()).all(|d| match ends[d] {
                None => true,
                Some(false) => element.lower[d] <= self.end(patch, d, false),
                Some(true) => element.upper[d] >= self.end(patch, d, true),
            });
            for s in SAMPLES.iter().filter(|_| touches) {
                let here: [f64; 3] = std::array::from_fn(|d| match ends[d] {
                    Some(upper) if d < self.dimension() => self.end(patch, d, upper),
                    _ => element.lower[d] + s * (element.upper[d] - element.lower[d]),
                });
                let mut there = here;
                let other = partner(&mut there);
                let other = self.find_element(other, &there);
                for (e, xi, sign) in [(e, &here, 1.0), (other, &there, -1.0)] {
                    self.evaluate(e, xi, 0, &mut basis);
                    for (&f, v) in self.functions_on(e).iter().zip(&basis.values) {
                        difference[f as usize] += sign * v;
                    }
                }
                for &f in self.functions_on(e).iter().chain(self.functions_on(other)) {
                    if difference[f as usize].abs() > AGREEMENT {
                        return Err(SplineError::OpenSeam { what, parameters: here });
                    }
                    difference[f as usize] = 0.0;
                }
            }
        }
        Ok(())
    }
}
