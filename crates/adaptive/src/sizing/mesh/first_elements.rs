//! Elements from which the check of a mesh starts (theory section N.1), from the proportions of the
//! body.

use std::f64::consts::{PI, TAU};

use iga_core::elasticity::Model;
use iga_core::nurbs::shape::lengths::lengths;

use super::proportions::{groups, half_wave, is_closed, longest, shortest};
use crate::spec::ElasticSpec;
use crate::touch::wave::Wave;

/// Least number of elements over half a wave at the start (Eq. N.1): four over a wave, which
/// splines of degree 3 follow to some 1e-3.
const ELEMENTS_PER_HALF_WAVE: f64 = 2.0;
/// The degree to which that number belongs.
const CUBIC: usize = 3;
/// Error of the frequency of the highest wave of bending that elements at the start make in a
/// direction: a quarter of what the check allows.
const FIRST_ERROR: f64 = 2.5e-4;
/// Elements per direction at the start.
const LEAST: usize = 2;
/// Degree that follows the shear over the thickness of a plate with one element.
const OF_SHEAR: usize = 3;
/// Error of one element of degree 3 across a wall, of the fourth power of wave number times thickness.
const ACROSS: f64 = 1e-3;
/// Part of half a wave below which a length is thin.
const THIN: f64 = 0.5;
/// Width over thickness from which a section is that of a wall.
const FLAT: f64 = 4.0;
/// Elements per direction at the start that are never exceeded.
const MOST: usize = 1000;
/// Half waves around of an oval with three waves.
const OVALS: f64 = 6.0;

/// Elements per direction for `n_modes` modes, from which the check starts; never fewer than the
/// shape has itself. Each of several patches has its part of the modes, and the same number in
/// directions that shared faces turn into one another.
///
/// Thin walls have as many along them as the bending of the highest mode needs (Eq. P.7), and one
/// element across them.
pub fn first_elements(spec: &ElasticSpec, n_modes: usize) -> Vec<usize> {
    let (shape, degrees) = (&spec.shape, &spec.discretisation.degrees);
    let own = |d: usize| shape.patches.iter().map(|p| p.knots()[d].breaks().len() - 1).max().unwrap_or(1);
    if shape.patches.len() > 1 {
        let lengths = lengths(shape);
        let half_wave = half_wave(&lengths, n_modes.div_ceil(shape.patches.len()));
        let wanted = |d: usize| elements_over(lengths[d] / half_wave, degrees[d]).max(own(d)).max(LEAST);
        let mut elements = vec![LEAST; degrees.len()];
        for group in groups(shape) {
            let most = group.iter().map(|&d| wanted(d)).max().unwrap_or(LEAST);
            group.iter().for_each(|&d| elements[d] = most);
        }
        return elements;
    }
    let body = Proportions::new(spec, n_modes);
    let wanted = |d: usize| {
        let is_across = body.is_across_wall(d) && degrees[d] >= OF_SHEAR;
        body.along(d, degrees[d]).max(if is_across { 1 } else { LEAST }).max(own(d))
    };
    (0..degrees.len()).map(wanted).collect()
}

/// Largest relative error that one element across a wall makes in the frequencies of `n_modes` modes
/// (Eq. N.12), per direction; `None` where it does not follow from the proportions.
pub fn errors_across(spec: &ElasticSpec, n_modes: usize) -> Vec<Option<f64>> {
    let degrees = &spec.discretisation.degrees;
    if spec.shape.patches.len() > 1 {
        return vec![None; degrees.len()];
    }
    let body = Proportions::new(spec, n_modes);
    let error = |d: usize| ACROSS * (PI * body.lengths[d] / body.half_wave).powi(4);
    (0..degrees.len()).map(|d| (body.is_across_wall(d) && degrees[d] >= OF_SHEAR).then(|| error(d))).collect()
}

/// Elements of degree `p` over a number of half waves, four a wave of cubic ones; of a higher
/// degree fewer, which err as much (Eq. N.2).
fn elements_over(half_waves: f64, p: usize) -> usize {
    // Of the amplitude of a wave and its nearest copy on `n` elements a wave, 1 / (n - 1), the
    // error goes with the power 2 p.
    let per_wave = |p: f64| 1.0 + (2.0 * ELEMENTS_PER_HALF_WAVE - 1.0).powf(CUBIC as f64 / p);
    (0.5 * per_wave(p.max(CUBIC) as f64) * half_waves - 0.1).ceil() as usize
}

/// A body of a single patch and the waves of its highest mode.
struct Proportions {
    /// Lengths of the parameter lines, of slender tubes the diameter in place of the way around
    /// \[m\].
    lengths: Vec<f64>,
    /// The direction that runs around a hole and ends where it begins; none of slender tubes, which
    /// move as bars.
    around: Option<usize>,
    /// Thickness of the wall or bar that waves bend \[m\].
    thickness: f64,
    /// Half a wave of the highest mode \[m\].
    half_wave: f64,
    /// Whether waves along the body bend it: axisymmetric rods do not.
    bends: bool,
    poissons_ratio: f64,
}

impl Proportions {
    fn new(spec: &ElasticSpec, n_modes: usize) -> Self {
        let mut lengths = lengths(&spec.shape);
        let mut around = (0..lengths.len()).find(|d| spec.shape.patches.iter().all(|p| is_closed(p, *d)));
        let mut thickness = shortest(&lengths);
        if let Some(d) = around {
            let bar = longest(&lengths) / n_modes.div_ceil(2) as f64;
            if longest(&lengths) > lengths[d] && !has_ovals(lengths[d], thickness, bar) {
                lengths[d] *= 2.0 / TAU;
                thickness = lengths[d];
                around = None;
            }
        }
        let mut half = half_wave(&lengths, n_modes);
        // What is long in one direction only bends to two sides: every second mode has another
        // wave.
        if lengths.len() == 3 && lengths.iter().filter(|l| **l > half).count() == 1 {
            half = half_wave(&lengths, n_modes.div_ceil(2));
        }
        let (bends, poissons_ratio) = (spec.model != Model::Axisymmetric, spec.material.poissons_ratio());
        Self { lengths, around, thickness, half_wave: half, bends, poissons_ratio }
    }

    /// Whether direction `d` runs through a wall: it is thin, and the others are not or are much
    /// longer than it is.
    fn is_across_wall(&self, d: usize) -> bool {
        let (length, thin) = (self.lengths[d], THIN * self.half_wave);
        let is_longer = |e: usize| self.lengths[e] > thin.min(FLAT * length);
        length < thin && (0..self.lengths.len()).all(|e| e == d || is_longer(e))
    }

    /// Half waves of the highest mode in direction `d`.
    fn half_waves(&self, d: usize) -> f64 {
        let along = self.lengths[d] / self.half_wave;
        if self.around != Some(d) || !self.is_bent() {
            return along;
        }
        // The first whole wave around is a rigid motion.
        let around = if along > 1.0 { along + 2.0 } else { along };
        if has_ovals(self.lengths[d], self.thickness, self.half_wave) { around.max(OVALS) } else { around }
    }

    /// Whether the body is thin in any direction, so that its waves bend it.
    fn is_bent(&self) -> bool {
        self.bends && self.thickness < THIN * self.half_wave
    }

    /// Elements of degree `p` along direction `d`; a length below half a wave has none of it.
    fn along(&self, d: usize, p: usize) -> usize {
        let half_waves = self.half_waves(d);
        let mut n = elements_over(half_waves, p).max(1);
        if !self.is_bent() {
            return n;
        }
        let length = self.lengths[d];
        let wave = Wave::bending(2.0 * length / half_waves, self.thickness, self.poissons_ratio);
        while half_waves > 1.0 && n < MOST && wave.error(length / n as f64, p) > FIRST_ERROR {
            n += 1;
        }
        n
    }
}

/// Whether a tube of the length `around` \[m\] about its axis and a wall of some `thickness` \[m\]
/// turns oval before it bends in half waves of `bar` \[m\] along its axis: the wall in two waves
/// around has the frequency of `c k² t/√12`, the tube of `c k² R/√2`.
fn has_ovals(around: f64, thickness: f64, bar: f64) -> bool {
    let radius = around / TAU;
    PI / bar > 2.0 / radius * (thickness / (6.0_f64.sqrt() * radius)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{DiscretisationSpec, ReductionSpec};
    use iga_core::elasticity::Material;
    use iga_core::nurbs::Shape;
    use iga_core::nurbs::primitives::rounded_box::rounded_box;
    use iga_core::nurbs::primitives::{SphereNet, profile, round, solid, sphere};

    fn steel(shape: Shape, dimension: usize) -> ElasticSpec {
        let model = if dimension == 3 { Model::Solid } else { Model::PlaneStress { thickness: 1.0 } };
        let material = Material::new(210e9, 0.3, 7850.0).unwrap();
        let (degrees, elements) = (vec![3; dimension], vec![1; dimension]);
        let mesh = DiscretisationSpec { degrees, elements, knots: None, refine: Vec::new() };
        ElasticSpec::new(shape, model, material, mesh, ReductionSpec::Modal { modes: 20 })
    }

    #[test]
    fn patches_that_share_faces_have_the_same_elements_in_all_directions() {
        let shells = sphere::sphere(0.01, SphereNet::Shells).unwrap();
        // A radius from the inner cube to the surface is shorter than the arcs beside it.
        let lengths = lengths(&shells);
        assert!(lengths[2] < 0.9 * lengths[0], "{lengths:?}");
        let elements = first_elements(&steel(shells, 3), 700);
        assert!(elements.iter().all(|n| *n == elements[0]), "{elements:?}");
    }

    #[test]
    fn higher_degrees_have_fewer_elements_over_a_wave() {
        // The nearest copy of the wave has the same amplitude in the power 2 p: (1/3)^6 =
        // (1/2.28)^8.
        assert_eq!([2, 3, 4, 5].map(|p| elements_over(10.0, p)), [20, 20, 17, 15]);
    }

    #[test]
    fn patches_with_one_section_all_along_have_a_number_along_and_one_across() {
        let groups_of = |shape: &Shape| groups(shape);
        assert_eq!(groups_of(&round::torus(1.0, 0.1).unwrap()), [vec![0, 1], vec![2]]);
        assert_eq!(groups_of(&profile::l_beam(1.0, 1.0, 0.1, 9.0).unwrap()), [[0], [1], [2]]);
        assert_eq!(groups_of(&rounded_box([1.0; 3], 0.1).unwrap()), [[0, 1, 2]]);
        assert_eq!(groups_of(&solid::cuboid([1.0; 3]).unwrap()), [[0], [1], [2]]);
        let beam = first_elements(&steel(profile::l_beam(1.0, 1.0, 0.2, 30.0).unwrap(), 3), 20);
        assert!(beam[2] > 2 * beam[0] && beam[0] == beam[1], "{beam:?}");
    }

    #[test]
    fn walls_have_one_element_across_and_more_along_the_thinner_they_are() {
        let of = |size| first_elements(&steel(solid::cuboid(size).unwrap(), 3), 20);
        assert_eq!(of([1.0, 1.0, 1.0]), [6, 6, 6], "no wall");
        let [thick, thin] = [30.0, 200.0].map(|l| of([1.0, l, l]));
        assert_eq!((thick[0], thin[0]), (1, 1), "across");
        assert!(thin[1] > thick[1] && thick[1] > 9, "{thick:?}, {thin:?}");
        // Two lengths are thin: torsion warps a square section, and a flat one as it does a wall.
        assert_eq!((&of([1.0, 1.0, 200.0])[..2], &of([1.0, 5.0, 200.0])[..2]), (&[2, 2][..], &[1, 2][..]));
    }

    #[test]
    fn slender_tubes_are_bars_and_others_turn_oval() {
        let of = |length| first_elements(&steel(solid::hollow_cylinder(0.3, 0.5, length).unwrap(), 3), 20);
        // The arcs of the shape itself do around a bar.
        assert_eq!((of(200.0)[0], of(200.0)[1]), (1, 4));
        let thin = solid::hollow_cylinder(0.05, 0.055, 1.0).unwrap();
        let elements = first_elements(&steel(thin, 3), 20);
        assert!(
            elements[0] == 1 && elements[1] >= 12,
            "two elements over each of six half waves: {elements:?}"
        );
    }
}
