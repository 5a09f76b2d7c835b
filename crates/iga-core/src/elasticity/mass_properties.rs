//! Volume, first and second moments of a body by quadrature over its exact geometry (theory
//! Eq. S.16).
//!
//! The integrands are polynomials for shapes without weights, which the rule integrates exactly.
//! Weights make them rational; sixteen points per direction leave an error far below round-off for
//! arcs of up to 90°, and what may be more, a direction of one element alone, is taken in two
//! parts.

use crate::SplineError;
use crate::elasticity::Model;
use crate::elasticity::mapping::PointMap;
use crate::nurbs::patch::PointBasis;
use crate::nurbs::{Patch, Shape};
use crate::quadrature::{GaussRule, MAX_GAUSS};
use crate::space::{GridBasis, Integrand, Space};

/// Integrals over a body, in the axes of its frame in space.
///
/// Plane models lie in `(x, y)`, their thickness symmetric about `z = 0`; axisymmetric ones turn
/// about `z`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MassProperties {
    /// `∫ dV` \[m³\].
    pub volume: f64,
    /// `∫ x dV` \[m⁴\].
    pub first_moment: [f64; 3],
    /// `∫ x xᵀ dV` \[m⁵\].
    pub second_moment: [[f64; 3]; 3],
}

impl MassProperties {
    /// Integrals over `shape`, whose control points are in the components of `model`.
    ///
    /// # Errors
    /// [`SplineError::Dimension`] for an impossible thickness, or if the volume is not positive and finite (a shape that is
    /// inside out, or too small or large for double precision).
    pub fn of(shape: &Shape, model: &Model) -> Result<Self, SplineError> {
        model.validate()?;
        let mut sum = Self::default();
        for patch in &shape.patches {
            sum.add_patch(patch, model);
        }
        let moments = sum.second_moment.iter().flatten().chain(&sum.first_moment);
        if !(sum.volume > 0.0 && sum.volume.is_finite() && moments.into_iter().all(|x| x.is_finite())) {
            let reason = "must be positive, and it and its moments finite";
            return Err(SplineError::Dimension { name: "volume", value: sum.volume, reason });
        }
        Ok(sum)
    }

    /// Integrals over the elements of `space` by the rules of their masses, each multiplied by what
    /// `factor` has for the element: one, or a density, which makes masses of the volumes.
    ///
    /// # Errors
    /// [`SplineError::Folded`] where the Jacobian determinant is not positive.
    pub fn of_space(
        space: &dyn Space,
        model: &Model,
        factor: &dyn Fn(usize) -> f64,
    ) -> Result<Self, SplineError> {
        let (mut sum, mut basis) = (Self::default(), GridBasis::default());
        let (mut active, mut places) = (Vec::new(), Vec::new());
        for e in 0..space.n_elements() {
            space.tabulate(e, Integrand::Mass, &mut basis);
            space.active_functions(e, &mut active);
            places.clear();
            places.extend(active.iter().map(|&a| space.control_points()[a as usize]));
            for q in 0..basis.n_points {
                let map = PointMap::new(space.dimension(), &places, basis.values_at(q), basis.first_at(q));
                let volume = basis.weights[q] * map.volume_ratio(basis.parameters[q])?;
                sum.add_point(factor(e) * volume * model.measure(&map.position), &map.position, model);
            }
        }
        Ok(sum)
    }

    /// The same times `density`, the same everywhere: the volume becomes the mass.
    pub fn times(&self, density: f64) -> Self {
        Self {
            volume: density * self.volume,
            first_moment: self.first_moment.map(|s| density * s),
            second_moment: self.second_moment.map(|row| row.map(|s| density * s)),
        }
    }

    /// Centre of volume \[m\].
    pub fn centre(&self) -> [f64; 3] {
        self.first_moment.map(|s| s / self.volume)
    }

    /// `∫ (|d|² 1 - d dᵀ) dV` with `d` from the centre of volume \[m⁵\]; times the density, the
    /// inertia.
    pub fn central_inertia(&self) -> [[f64; 3]; 3] {
        let c = self.centre();
        let mut central = self.second_moment;
        for (i, row) in central.iter_mut().enumerate() {
            for (j, s) in row.iter_mut().enumerate() {
                *s -= self.volume * c[i] * c[j];
            }
        }
        let trace = central[0][0] + central[1][1] + central[2][2];
        let mut inertia = central.map(|row| row.map(|s| -s));
        for (i, row) in inertia.iter_mut().enumerate() {
            row[i] += trace;
        }
        inertia
    }

    fn add_patch(&mut self, patch: &Patch, model: &Model) {
        let n = patch.dimension();
        let first = patch.weights().first().copied().unwrap_or(1.0);
        let is_polynomial = patch.weights().iter().all(|w| w.to_bits() == first.to_bits());
        let rules: Vec<GaussRule> = patch
            .knots()
            .iter()
            .map(|k| {
                // Quadratic moments, times r or another coordinate at most, times a determinant of
                // degree n p - 1.
                let degree = (n + 3) * k.degree();
                GaussRule::new(if is_polynomial { (degree / 2 + 1).min(MAX_GAUSS) } else { MAX_GAUSS })
            })
            .collect();
        // A single element may be an arc of 180°.
        let parts: Vec<usize> =
            patch.knots().iter().map(|k| if is_polynomial || k.n_elements() > 1 { 1 } else { 2 }).collect();
        let mut scratch = PointBasis::default();
        for e in 0..patch.n_elements() {
            let (lower, upper) = patch.element(e);
            for part in 0..parts.iter().product() {
                let (mut lower, mut upper, mut rest) = (lower, upper, part);
                for (d, n) in parts.iter().enumerate() {
                    let size = (upper[d] - lower[d]) / *n as f64;
                    lower[d] += (rest % n) as f64 * size;
                    upper[d] = lower[d] + size;
                    rest /= n;
                }
                self.add_box((patch, e), (&lower, &upper), &rules, model, &mut scratch);
            }
        }
    }

    /// Adds the part of element `e` between the parameters `lower` and `upper`.
    fn add_box(
        &mut self,
        (patch, e): (&Patch, usize),
        (lower, upper): (&[f64; 3], &[f64; 3]),
        rules: &[GaussRule],
        model: &Model,
        scratch: &mut PointBasis,
    ) {
        for q in 0..rules.iter().map(GaussRule::len).product() {
            let (mut xi, mut weight, mut rest) = ([0.0; 3], 1.0, q);
            for (d, rule) in rules.iter().enumerate() {
                let half = 0.5 * (upper[d] - lower[d]);
                let i = rest % rule.len();
                rest /= rule.len();
                xi[d] = 0.5 * (lower[d] + upper[d]) + half * rule.points[i];
                weight *= half * rule.weights[i];
            }
            let jet = patch.jet_on(e, &xi, 1, scratch);
            let volume = weight * jet.determinant(rules.len()) * model.measure(&jet.point);
            self.add_point(volume, &jet.point, model);
        }
    }

    /// Adds the ring, line through the thickness, or point at `x` with the volume `volume`.
    fn add_point(&mut self, volume: f64, x: &[f64; 3], model: &Model) {
        self.volume += volume;
        match *model {
            Model::Solid => {
                for i in 0..3 {
                    self.first_moment[i] += volume * x[i];
                    for j in 0..3 {
                        self.second_moment[i][j] += volume * x[i] * x[j];
                    }
                }
            }
            Model::PlaneStrain { thickness } | Model::PlaneStress { thickness } => {
                for i in 0..2 {
                    self.first_moment[i] += volume * x[i];
                    for j in 0..2 {
                        self.second_moment[i][j] += volume * x[i] * x[j];
                    }
                }
                self.second_moment[2][2] += volume * thickness * thickness / 12.0; // ∫ z² over the thickness
            }
            Model::Axisymmetric => {
                let [r, z, _] = *x;
                self.first_moment[2] += volume * z;
                self.second_moment[0][0] += 0.5 * volume * r * r; // mean of x² on a ring
                self.second_moment[1][1] += 0.5 * volume * r * r;
                self.second_moment[2][2] += volume * z * z;
            }
        }
    }
}
