//! Flanks of gear teeth in contact: Hertz' line contact with the radius of curvature of the involute where it is touched.

use std::f64::consts::PI;
use std::path::Path;

use crate::support::scenarios;

const YOUNG: f64 = 210e9;
const POISSON: f64 = 0.3;
/// Module \[m\], number of teeth, pressure angle \[rad\].
const MODULE: f64 = 5e-3;
const TEETH: f64 = 20.0;
const PRESSURE_ANGLE: f64 = 20.0 * PI / 180.0;
const THICKNESS: f64 = 0.01;
/// Radius of the roller, which lies between two teeth \[m\].
const ROLLER: f64 = 4e-3;

/// Place, outward normal and radius of curvature of the flank at `y > 0` on the circle of the radius `r`, written out independently of the shape.
fn flank(r: f64) -> ([f64; 2], [f64; 2], f64) {
    let base = 0.5 * MODULE * TEETH * PRESSURE_ANGLE.cos();
    let involute = |angle: f64| angle.tan() - angle;
    let at = (base / r).acos();
    let polar = PI / (2.0 * TEETH) + involute(PRESSURE_ANGLE) - involute(at);
    // The normal touches the base circle: it is inclined by the pressure angle there to the direction around.
    let direction = polar - at + 0.5 * PI;
    ([r * polar.cos(), r * polar.sin()], [direction.cos(), direction.sin()], base * at.tan())
}

/// A rigid roller that meets the flank on the circle of the radius `r`.
fn scenario(r: f64) -> String {
    let ([x, y], [u, v], _) = flank(r);
    let place = |distance: f64| [x + u * distance, y + v * distance];
    let ([a, b], speed) = (place(ROLLER + 1e-6), -0.5);
    format!(
        r#"
        [simulation]
        end_time = 2.0e-4
        stop_after_impacts = 1
        [bodies.tooth]
        model = "plane-strain"
        material = "steel"
        thickness = {THICKNESS}
        geometry = {{ shape = "gear-tooth", module = {MODULE}, teeth = 20, inner_radius = 0.03 }}
        [bodies.roller]
        model = "rigid"
        motion = "planar"
        material = "steel"
        thickness = {THICKNESS}
        geometry = {{ shape = "disc", radius = {ROLLER} }}
        position = [{a}, {b}, 0.0]
        velocity = [{}, {}, 0.0]
        [contacts.mesh]
        contact_body = "tooth"
        target_body = "roller"
        interval = {{ elements = 64 }}
        "#,
        speed * u,
        speed * v
    )
}

#[test]
fn a_roller_presses_the_flank_as_hertz_says_with_the_radius_of_the_involute() {
    rollers_press(&[PITCH + 3e-3]);
}

#[test]
#[ignore = "second tier: half a dozen seconds"]
fn rollers_press_the_flank_as_hertz_says_with_the_radius_of_the_involute() {
    rollers_press(&[PITCH - 2e-3, PITCH]);
}

const PITCH: f64 = 0.5 * MODULE * TEETH;

fn rollers_press(radii: &[f64]) {
    for &r in radii {
        let (_, _, radius) = flank(r);
        let found = scenarios::run(&scenarios::valid(Path::new("."), &scenario(r), &[]));
        let force = |s: &&adaptive::record::Sample| s.contacts[0].normal_force;
        let most = found.samples.iter().max_by(|a, b| force(a).total_cmp(&force(b))).unwrap();
        let (mut sum, mut squares) = (0.0, 0.0);
        for point in &most.pressures[0] {
            sum += point.pressure * point.area;
            squares += point.pressure.powi(2) * point.area;
        }
        // Of half an ellipse the mean square over the mean is 8 / (3 pi) of the largest pressure.
        let largest = 3.0 * PI / 8.0 * squares / sum;
        let relative = sum / THICKNESS * YOUNG / (1.0 - POISSON * POISSON) / (PI * largest * largest);
        let exact = 1.0 / (1.0 / radius + 1.0 / ROLLER);
        println!(
            "flank at {r:.4} m: {sum:.1} N, {:.1} MPa, radius {relative:.5e} m, involute and roller {exact:.5e} m",
            largest / 1e6
        );
        // Fifty elements across the contact. Its width is a whole number of them: from half as many on, the largest pressure changes by some 0.6 %,
        // and the radius goes with its square.
        assert!((relative / exact - 1.0).abs() < 0.02, "{relative} instead of {exact} at {r}");
    }
}
