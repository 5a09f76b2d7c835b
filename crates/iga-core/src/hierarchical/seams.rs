//! Check that the functions agree on both sides of seams and around collapsed edges (theory section H.5).

use super::space::HierarchicalSpace;
use super::ties::CollapsedSet;
use crate::SplineError;
use crate::nurbs::patch::PointBasis;
use crate::space::Space;

/// Largest difference of a function between the two sides: round-off of nets with twelve good digits.
const AGREEMENT: f64 = 1e-9;

/// Places of sample points inside an element, irrational so that no difference happens to vanish there.
const SAMPLES: [f64; 2] = [std::f64::consts::FRAC_1_PI, std::f64::consts::LN_2];

impl HierarchicalSpace {
    /// Compares all functions at sample points of every element at a seam or collapsed edge.
    ///
    /// # Errors
    /// [`SplineError::OpenSeam`] where they differ.
    pub(super) fn check_seams(&self) -> Result<(), SplineError> {
        if self.ties().is_empty() || self.basis().hierarchy().levels().len() == 1 {
            return Ok(());
        }
        for d in (0..self.dimension()).filter(|&d| self.ties().seams[d]) {
            for upper in [false, true] {
                let mut ends = [None; 3];
                ends[d] = Some(upper);
                self.compare("seam", &ends, |xi| xi[d] = self.end(d, !upper))?;
            }
        }
        for set in self.ties().collapsed.iter().filter(|s| !s.is_point()) {
            let CollapsedSet { ends, along } = set;
            for d in (0..self.dimension()).filter(|&d| along[d]) {
                self.compare("collapsed edge", ends, |xi| xi[d] = self.end(d, false))?;
            }
        }
        Ok(())
    }

    fn end(&self, d: usize, upper: bool) -> f64 {
        let (a, b) = self.basis().hierarchy().levels()[0].knots()[d].domain();
        if upper { b } else { a }
    }

    /// Compares the functions on a face or edge with those at the points that `partner` makes of its points.
    fn compare(
        &self,
        what: &'static str,
        ends: &[Option<bool>; 3],
        partner: impl Fn(&mut [f64; 3]),
    ) -> Result<(), SplineError> {
        let mut basis = PointBasis::default();
        let mut difference = vec![0.0; self.n_functions()];
        for e in 0..self.n_elements() {
            let element = self.element(e);
            let touches = (0..self.dimension()).all(|d| match ends[d] {
                None => true,
                Some(false) => element.lower[d] <= self.end(d, false),
                Some(true) => element.upper[d] >= self.end(d, true),
            });
            for s in SAMPLES.iter().filter(|_| touches) {
                let here: [f64; 3] = std::array::from_fn(|d| match ends[d] {
                    Some(upper) if d < self.dimension() => self.end(d, upper),
                    _ => element.lower[d] + s * (element.upper[d] - element.lower[d]),
                });
                let mut there = here;
                partner(&mut there);
                let other = self.find_element(0, &there);
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
