//! Factors on the resolution of bodies and contacts: what a convergence study varies.
//!
//! They come after everything that is given or chosen by default, so that a doubled mesh is twice
//! the mesh in force. The penalty factor counts too: it bounds the penetration as a mesh bounds the
//! error of displacements.

use iga_core::nurbs::Shape;

use super::RunSettings;
use super::body::{DiscretisationSpec, ElasticSpec, RefinementSpec};
use super::contact::{PenaltySearch, SurfaceLaw};
use super::reduction::ReductionSpec;

/// Factors for the bodies and contacts of a run, in their order; what lies beyond the lists is left
/// as it is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Resolution {
    /// One entry per body.
    pub bodies: Vec<BodyFactors>,
    /// One entry per contact.
    pub contacts: Vec<ContactFactors>,
}

/// Factors on the model of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyFactors {
    /// On the number of elastic modes.
    pub modes: usize,
    /// On the number of elements in each direction, outside of contact zones.
    pub mesh: usize,
}

/// Factors on the model of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFactors {
    /// On the number of elements across the contact zone.
    pub zone: usize,
    /// On the penalty factor, given or first tried; a search ends at a change of the peak force
    /// smaller by the same factor.
    pub penalty: f64,
}

/// Power of a factor on the tolerance that steps are shortened by: a tenth halves them, as an error
/// of third order per step.
const STEP_POWER: f64 = std::f64::consts::LOG10_2;

/// Factor on the longest steps that goes with `factor` on their permitted errors.
pub fn shortening(factor: f64) -> f64 {
    factor.powf(STEP_POWER)
}

impl RunSettings {
    /// Applies `factor`, at most 1, to the permitted errors of steps in all phases, and shortens
    /// the longest steps to suit.
    pub fn tighten(&mut self, factor: f64) {
        let shortened = shortening(factor);
        for phase in [&mut self.free, &mut self.impact, &mut self.lasting] {
            phase.max_step *= shortened;
            phase.tolerance_factor *= factor;
        }
        self.step_share *= shortened;
    }
}

impl Default for BodyFactors {
    fn default() -> Self {
        Self { modes: 1, mesh: 1 }
    }
}

impl Default for ContactFactors {
    fn default() -> Self {
        Self { zone: 1, penalty: 1.0 }
    }
}

impl Resolution {
    /// Factors of body `index`.
    pub fn body(&self, index: usize) -> BodyFactors {
        self.bodies.get(index).copied().unwrap_or_default()
    }

    /// Factors of contact `index`.
    pub fn contact(&self, index: usize) -> ContactFactors {
        self.contacts.get(index).copied().unwrap_or_default()
    }

    /// Whether nothing is changed.
    pub fn is_identity(&self) -> bool {
        self.bodies.iter().all(|b| *b == BodyFactors::default())
            && self.contacts.iter().all(|c| *c == ContactFactors::default())
    }
}

impl BodyFactors {
    /// Divides the elements of a body of splines; refinements are left as they are (see
    /// [`BodyFactors::refinement`]).
    pub fn apply(&self, body: &mut ElasticSpec) {
        let ElasticSpec { shape, discretisation, .. } = body;
        self.divide(shape, discretisation);
    }

    /// `spec` with as many times the modes.
    pub fn reduction(&self, spec: ReductionSpec) -> ReductionSpec {
        match spec {
            ReductionSpec::Modal { modes } => ReductionSpec::Modal { modes: modes * self.modes },
            ReductionSpec::CraigBampton { modes, fixed_interface_modes } => ReductionSpec::CraigBampton {
                modes: modes * self.modes,
                fixed_interface_modes: fixed_interface_modes.map(|n| n * self.modes),
            },
            ReductionSpec::All => ReductionSpec::All,
        }
    }

    /// Divides the elements before refinement; given knots, by points at equal distances between
    /// them.
    fn divide(&self, shape: &Shape, mesh: &mut DiscretisationSpec) {
        mesh.elements.iter_mut().for_each(|n| *n *= self.mesh);
        if self.mesh == 1 {
            return;
        }
        for (d, knots) in mesh.knots.iter_mut().flatten().enumerate() {
            let own = shape.patches.iter().flat_map(|p| p.knots()[d].breaks());
            let mut breaks: Vec<f64> = knots.iter().copied().chain([0.0, 1.0]).chain(own).collect();
            breaks.sort_by(f64::total_cmp);
            breaks.dedup_by(|a, b| a.total_cmp(b).is_eq());
            let between = |w: &[f64]| {
                let (start, length) = (w[0], w[1] - w[0]);
                (1..self.mesh).map(move |k| start + length * k as f64 / self.mesh as f64)
            };
            knots.extend(breaks.windows(2).flat_map(between));
            knots.sort_by(f64::total_cmp);
        }
    }

    /// A refinement of the body with the factor of the contact zone that it is, if it is one.
    /// Elements outside it, which grow geometrically, are divided in geometric parts.
    pub fn refinement(&self, refinement: &mut RefinementSpec, zone: Option<usize>) {
        refinement.elements *= zone.unwrap_or(self.mesh);
        if self.mesh > 1 {
            refinement.ratio = refinement.ratio.powf(1.0 / self.mesh as f64);
        }
    }
}

impl ContactFactors {
    /// Applies the factors to a law, `usual` being the elements of a zone for which the law names
    /// no number, if there is one.
    pub fn apply(&self, law: &mut SurfaceLaw, usual: Option<usize>) {
        if self.zone > 1 {
            law.interval.elements = law.interval.elements.or(usual).map(|n| n * self.zone);
        }
        law.penalty = law.penalty.map(|p| p * self.penalty);
        law.stiffness_ratio *= self.penalty;
        if let PenaltySearch::UntilConverged { tolerance } = &mut law.search {
            // The change falls with the factor itself, so that the search ends later by as much as
            // it starts later.
            *tolerance /= self.penalty;
        }
    }
}

#[cfg(test)]
mod tests {
    use iga_core::nurbs::primitives::plane;

    use super::*;

    fn mesh(knots: Option<Vec<Vec<f64>>>) -> DiscretisationSpec {
        DiscretisationSpec { degrees: vec![2, 2], elements: vec![3, 5], knots, refine: Vec::new() }
    }

    #[test]
    fn elements_and_knots_are_divided_alike() {
        let shape = plane::rectangle(1.0, 1.0).expect("a shape");
        let factors = BodyFactors { modes: 1, mesh: 2 };
        let mut uniform = mesh(None);
        factors.divide(&shape, &mut uniform);
        assert_eq!(uniform.elements, [6, 10]);
        // Repeated knots stay repeated, and empty lists are one element.
        let mut given = mesh(Some(vec![vec![0.25, 0.25, 0.5], vec![]]));
        factors.divide(&shape, &mut given);
        let expected = vec![vec![0.125, 0.25, 0.25, 0.375, 0.5, 0.75], vec![0.5]];
        assert_eq!(given.knots, Some(expected));
        let mut thirds = mesh(Some(vec![vec![], vec![0.75]]));
        BodyFactors { modes: 1, mesh: 3 }.divide(&shape, &mut thirds);
        assert_eq!(
            thirds.knots,
            Some(vec![
                vec![1.0 / 3.0, 2.0 / 3.0],
                vec![0.25, 0.5, 0.75, 0.75 + 0.25 / 3.0, 0.75 + 0.5 / 3.0]
            ])
        );
        let mut same = mesh(Some(vec![vec![0.25], vec![]]));
        BodyFactors::default().divide(&shape, &mut same);
        assert_eq!(same, mesh(Some(vec![vec![0.25], vec![]])));
    }

    #[test]
    fn modes_of_every_reduction_are_multiplied_but_not_those_of_all() {
        let factors = BodyFactors { modes: 3, mesh: 1 };
        let craig_bampton =
            |modes, fixed_interface_modes| ReductionSpec::CraigBampton { modes, fixed_interface_modes };
        assert_eq!(factors.reduction(ReductionSpec::Modal { modes: 7 }), ReductionSpec::Modal { modes: 21 });
        assert_eq!(factors.reduction(craig_bampton(4, Some(9))), craig_bampton(12, Some(27)));
        assert_eq!(factors.reduction(craig_bampton(4, None)), craig_bampton(12, None));
        assert_eq!(factors.reduction(ReductionSpec::All), ReductionSpec::All);
    }

    #[test]
    fn graded_elements_about_a_refinement_are_divided_too() {
        let given = RefinementSpec { centre: [0.0; 3], width: 1.0, elements: 4, ratio: 2.25 };
        let factors = BodyFactors { modes: 1, mesh: 2 };
        let refined = |zone| {
            let mut refinement = given;
            factors.refinement(&mut refinement, zone);
            (refinement.elements, refinement.ratio)
        };
        // Two elements of sizes h and 1.5 h in the place of each: neighbours then differ by 1.5
        // everywhere.
        assert_eq!(refined(None), (8, 1.5));
        assert_eq!(refined(Some(3)), (12, 1.5), "elements of a contact zone follow its own factor");
    }
}
