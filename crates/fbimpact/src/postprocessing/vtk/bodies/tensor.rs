//! Stress tensors: from the components of a model to space, in the order of VTK.

use ffr_dynamics::body::RigidMotion;
use nalgebra::Matrix3;

/// The tensor with the components `stress` of a model (`xx, yy, zz, xy, yz, zx`; axisymmetric
/// `rr, zz, θθ, rz`) in the axes of its body, at angle zero.
pub fn in_body(motion: RigidMotion, stress: &[f64; 6]) -> Matrix3<f64> {
    let s = stress;
    if motion == RigidMotion::Axial {
        return Matrix3::new(s[0], 0.0, s[3], 0.0, s[2], 0.0, s[3], 0.0, s[1]);
    }
    Matrix3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2])
}

/// The tensor turned by `rotation`, as `XX, YY, ZZ, XY, YZ, XZ`.
pub fn rotated(tensor: &Matrix3<f64>, rotation: &Matrix3<f64>) -> [f64; 6] {
    let t = rotation * tensor * rotation.transpose();
    [t[(0, 0)], t[(1, 1)], t[(2, 2)], t[(0, 1)], t[(1, 2)], t[(0, 2)]]
}

#[cfg(test)]
mod tests {
    use iga_core::elasticity::kinematics::von_mises;
    use nalgebra::Rotation3;

    use super::*;

    #[test]
    fn turning_keeps_the_von_mises_stress() {
        let stress = [3.0, -1.0, 2.0, 0.5, 0.7, -0.3];
        let rotation = Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        for motion in [RigidMotion::Axial, RigidMotion::Spatial] {
            let stress = if motion == RigidMotion::Axial { [3.0, -1.0, 2.0, 0.5, 0.0, 0.0] } else { stress };
            let t = rotated(&in_body(motion, &stress), &rotation);
            assert!((von_mises(&t) - von_mises(&stress)).abs() < 1e-13);
        }
    }

    #[test]
    fn hoop_stress_points_out_of_the_section() {
        let t = rotated(&in_body(RigidMotion::Axial, &[0.0, 0.0, 5.0, 0.0, 0.0, 0.0]), &Matrix3::identity());
        assert_eq!(t.map(|c| c as i32), [0, 5, 0, 0, 0, 0]);
    }
}
