//! Eigenfrequencies of a free solid cylinder against a Ritz solution.

use super::support::{assert_below, built, cylinder_frequencies, parsed, steel_cylinder};
use std::f64::consts::TAU;

// Known error of the first ten frequencies on this mesh: 1.9e-6; the reference has 9 digits.
const COARSE: f64 = 3e-6;

#[test]
fn solid_steel_cylinder_has_the_first_ten_frequencies_of_a_ritz_solution() {
    let model = built(&parsed(&steel_cylinder(8, 10)));
    let expected = cylinder_frequencies();
    let omega = &model.bodies[0].flexible().expect("flexible").reduced.basis.omega;
    let errors = omega.iter().zip(&expected).map(|(w, f)| (w / TAU / f - 1.0).abs());
    assert_below("largest error of 10 frequencies", errors.fold(0.0, f64::max), COARSE);
}
