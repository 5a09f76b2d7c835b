//! Volumes and moments of the named shapes against closed forms.

use std::f64::consts::PI;

use iga_core::elasticity::Model;
use iga_core::elasticity::mass_properties::MassProperties;
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};

/// Sums of some ten thousand terms of one sign lose three digits at most.
const ROUND_OFF: f64 = 1e-12;

/// Compares volume, centre and the diagonal of the central inertia, and asks for no products of inertia.
fn assert_properties(
    shape: &Shape,
    model: &Model,
    volume: f64,
    centre: [f64; 3],
    inertia: [f64; 3],
    what: &str,
) {
    let found = MassProperties::of(shape, model).expect("a sound shape");
    let length = volume.cbrt();
    assert!((found.volume / volume - 1.0).abs() < ROUND_OFF, "{what}: volume {} {volume}", found.volume);
    let size = inertia.iter().fold(0.0_f64, |a, b| a.max(*b));
    let (c, j) = (found.centre(), found.central_inertia());
    for i in 0..3 {
        assert!((c[i] - centre[i]).abs() < ROUND_OFF * length, "{what}: centre {c:?} {centre:?}");
        for k in 0..3 {
            let expected = if i == k { inertia[i] } else { 0.0 };
            assert!((j[i][k] - expected).abs() < ROUND_OFF * size, "{what}: inertia {j:?} {inertia:?}");
        }
    }
}

#[test]
fn balls_have_two_fifths_of_mass_times_radius_squared() {
    let r: f64 = 0.013;
    let volume = 4.0 / 3.0 * PI * r.powi(3);
    let inertia = [0.4 * volume * r * r; 3];
    for net in [SphereNet::Cube, SphereNet::Spindle, SphereNet::Shells] {
        let shape = sphere::sphere(r, net).unwrap();
        assert_properties(&shape, &Model::Solid, volume, [0.0; 3], inertia, &format!("{net:?}"));
    }
    let half_disc = axisymmetric::sphere(r).unwrap();
    assert_properties(&half_disc, &Model::Axisymmetric, volume, [0.0; 3], inertia, "half-disc");
}

#[test]
fn cylinders_agree_with_closed_forms_as_solid_and_as_axisymmetric_models() {
    let (a, b, l) = (0.4, 0.7, 1.9);
    for inner in [0.0, a] {
        let volume = PI * (b * b - inner * inner) * l;
        let across = volume * (b * b + inner * inner) / 4.0 + volume * l * l / 12.0;
        let inertia = [across, across, volume * (b * b + inner * inner) / 2.0];
        let (spatial, meridian) = if inner > 0.0 {
            (
                solid::hollow_cylinder(inner, b, l).unwrap(),
                axisymmetric::hollow_cylinder(inner, b, l).unwrap(),
            )
        } else {
            (solid::cylinder(b, l).unwrap(), axisymmetric::rod(b, l).unwrap())
        };
        let centre = [0.0, 0.0, 0.5 * l];
        assert_properties(&spatial, &Model::Solid, volume, centre, inertia, "cylinder");
        assert_properties(&meridian, &Model::Axisymmetric, volume, centre, inertia, "meridian");
    }
}

#[test]
fn rod_with_spherical_end_is_a_cylinder_on_a_half_ball() {
    let (r, l): (f64, f64) = (0.2, 1.1);
    let (ball, rod) = (2.0 / 3.0 * PI * r.powi(3), PI * r * r * (l - r));
    // The half ball has its centre 3/8 r below its flat face, the rod in its middle.
    let (z_ball, z_rod) = (r - 0.375 * r, 0.5 * (r + l));
    let volume = ball + rod;
    let z = (ball * z_ball + rod * z_rod) / volume;
    let along = 0.4 * ball * r * r + 0.5 * rod * r * r;
    // 83/320 m r² about the centre of a half ball.
    let across = 83.0 / 320.0 * ball * r * r
        + ball * (z_ball - z).powi(2)
        + rod * (r * r / 4.0 + (l - r).powi(2) / 12.0)
        + rod * (z_rod - z).powi(2);
    let shape = axisymmetric::rod_spherical_end(r, l).unwrap();
    assert_properties(&shape, &Model::Axisymmetric, volume, [0.0, 0.0, z], [across, across, along], "bullet");
}

#[test]
fn boxes_rectangles_and_discs_agree_with_closed_forms() {
    let [a, b, c] = [0.3, 1.1, 2.0];
    let volume = a * b * c;
    let square = |x: f64, y: f64| volume * (x * x + y * y) / 12.0;
    let inertia = [square(b, c), square(a, c), square(a, b)];
    assert_properties(&solid::cuboid([a, b, c]).unwrap(), &Model::Solid, volume, [0.0; 3], inertia, "box");
    // A rectangle with a thickness is the same box.
    for model in [Model::PlaneStrain { thickness: c }, Model::PlaneStress { thickness: c }] {
        assert_properties(&plane::rectangle(a, b).unwrap(), &model, volume, [0.0; 3], inertia, "rectangle");
    }
    let volume = PI * a * a * c;
    let across = volume * (a * a / 4.0 + c * c / 12.0);
    let inertia = [across, across, 0.5 * volume * a * a];
    let model = Model::PlaneStrain { thickness: c };
    assert_properties(&plane::disc(a).unwrap(), &model, volume, [0.0; 3], inertia, "disc");
}

#[test]
fn turning_a_shape_turns_its_inertia() {
    let shape = solid::cylinder(0.2, 0.5).unwrap();
    let coarse = MassProperties::of(&shape, &Model::Solid).unwrap();
    let turned = shape.rotated(&[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).unwrap();
    let found = MassProperties::of(&turned, &Model::Solid).unwrap();
    // The turn takes z to x, x to y and y to z.
    let (before, after) = (coarse.central_inertia(), found.central_inertia());
    assert!((before[2][2] - after[0][0]).abs() < ROUND_OFF * before[0][0]);
    assert!((coarse.centre()[2] - found.centre()[0]).abs() < ROUND_OFF);
}

#[test]
fn sizes_beyond_double_precision_are_refused() {
    for edge in [1e-200, 1e200] {
        let shape = solid::cuboid([edge; 3]).unwrap();
        assert!(MassProperties::of(&shape, &Model::Solid).is_err(), "{edge}");
    }
}
