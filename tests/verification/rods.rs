//! Eigenfrequencies of a free rod against the Pochhammer-Chree solution.

use std::f64::consts::TAU;

use super::support::{Table, assert_close, built, parsed};

// The reference neglects the ends, which is good for 0.2 % (tests/reference/rod_alu_dispersion.csv).
const TOLERANCE: f64 = 2e-3;

#[test]
fn axisymmetric_rod_has_the_longitudinal_modes_of_pochhammer_and_chree() {
    let model = built(&parsed(
        r#"
        simulation = { end_time = 1.0 }
        materials.aluminium = { youngs_modulus = 72.8e9, poissons_ratio = 0.33, density = 2789.0 }
        [bodies.rod]
        model = "axisymmetric"
        material = "aluminium"
        geometry = { shape = "rod", radius = 10.0e-3, length = 1.0 }
        discretisation = { degree = 3, elements = [2, 60] }
        reduction = { method = "modal", modes = 20 }
        "#,
    ));
    let expected = Table::read("rod_alu_dispersion").column("frequency");
    let omega = &model.bodies[0].flexible().expect("flexible").reduced.basis.omega;
    for n in 1..=20 {
        assert_close(&format!("mode {n}"), omega[n - 1] / TAU, expected[n - 1], TOLERANCE);
    }
}
