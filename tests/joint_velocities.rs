//! Initial velocities of joints with a rotation about a point: the angular velocity stands in the axes of the child, whatever those of the joint are.

use crate::support::scenarios;
use nalgebra::{UnitQuaternion, Vector3};
use std::path::Path;

#[test]
fn angular_velocities_stand_in_the_axes_of_the_child() {
    let spin = Vector3::new(3.0, -20.0, 150.0);
    for turn in [[0.0, 0.0, 0.0], [0.0, 30.0, 0.0], [40.0, -70.0, 110.0]] {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(turn).map(f64::to_radians));
        let [i, j, k, w] = <[f64; 4]>::from(rotation.into_inner().coords);
        for (kind, before, axis) in [
            ("spherical", "", ""),
            ("spherical", "", "axis = [1.0, 2.0, 3.0]\n"),
            ("free", "0.0, 0.0, 0.0, ", ""),
            ("free", "0.0, 0.0, 0.0, ", "axis = [1.0, 2.0, 3.0]\n"),
        ] {
            let text = format!(
                "[simulation]\nend_time = 1e-6\n[bodies.top]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1e-3, 2e-3, 3e-3]\n\
                 orientation = [{w}, {i}, {j}, {k}]\n[joints.foot]\ntype = \"{kind}\"\n{axis}\
                 parent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\nchild = {{ body = \"top\", point = [0.0, 0.0, 0.0] }}\n\
                 velocities = [{before}{}, {}, {}]\n",
                spin.x, spin.y, spin.z
            );
            let recording = scenarios::run(&scenarios::valid(Path::new("."), &text, &[]));
            let found = Vector3::from(recording.samples[0].angular_momentum);
            let expected = rotation * Vector3::new(1e-3 * spin.x, 2e-3 * spin.y, 3e-3 * spin.z);
            assert!(
                (found - expected).norm() < 1e-12 * expected.norm(),
                "{kind} {axis} {turn:?}: {found} {expected}"
            );
        }
    }
}
