//! Unit quaternions as generalised positions (docs/theory.md Eq. D.1).
//!
//! A state vector holds `w x y z` of the rotation from the body's frame to the inertial frame. Its
//! length drifts within the integration error; everything read from it is normalised first, and
//! [`renormalise`] takes the drift away.

pub mod exponential;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Drift of the squared length at which a quaternion is worth normalising.
///
/// All uses normalise by themselves, so that the drift spoils no result; normalising costs one more
/// evaluation.
const LENGTH_TOLERANCE: f64 = 1e-8;

/// Rotation that the four components `w x y z` stand for, whatever their length.
///
/// # Panics
/// In debug builds, if there are not four components.
pub fn rotation_from_slice(q: &[f64]) -> UnitQuaternion<f64> {
    debug_assert_eq!(q.len(), 4);
    UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3]))
}

/// Rate of the quaternion `q` of a body that turns with `angular_velocity`, expressed in the body's
/// frame (Eq. D.1) [1/s].
pub fn quaternion_rate(q: &[f64], angular_velocity: &Vector3<f64>, rate: &mut [f64]) {
    let q = Quaternion::new(q[0], q[1], q[2], q[3]);
    let half = q * Quaternion::from_imag(0.5 * angular_velocity);
    rate.copy_from_slice(&[half.w, half.i, half.j, half.k]);
}

/// Normalises `w x y z` if its length has drifted noticeably; returns whether it did.
pub fn renormalise(q: &mut [f64]) -> bool {
    let squared: f64 = q.iter().map(|c| c * c).sum();
    let has_drifted = (squared - 1.0).abs() > LENGTH_TOLERANCE; // false for NaN
    if !has_drifted || squared <= 0.0 {
        return false;
    }
    let factor = 1.0 / squared.sqrt();
    q.iter_mut().for_each(|c| *c *= factor);
    true
}

/// The matrix `a~` with `a~ b = a × b`.
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    a.cross_matrix()
}

/// `Σ a × b` from `Σ a bᵀ`.
pub fn axial(sum: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(sum[(1, 2)] - sum[(2, 1)], sum[(2, 0)] - sum[(0, 2)], sum[(0, 1)] - sum[(1, 0)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    // Products of numbers of order one: a few round-offs.
    const ROUND_OFF: f64 = 1e-14;

    /// Writes a rotation as `w x y z`.
    fn write_rotation(rotation: &UnitQuaternion<f64>, q: &mut [f64]) {
        q.copy_from_slice(&[rotation.w, rotation.i, rotation.j, rotation.k]);
    }

    #[test]
    fn axial_of_a_dyad_is_the_cross_product() {
        let (a, b) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.7, -1.1));
        assert_relative_eq!(axial(&(a * b.transpose())), a.cross(&b), epsilon = ROUND_OFF);
        assert_relative_eq!(skew(&a) * b, a.cross(&b), epsilon = ROUND_OFF);
    }

    proptest! {
        #[test]
        fn quaternion_rate_is_the_derivative_of_a_rotation_about_body_axes(
            axis in prop::array::uniform3(-2.0..2.0f64),
            omega in prop::array::uniform3(-3.0..3.0f64),
        ) {
            let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(axis));
            let omega = Vector3::from(omega);
            let mut q = [0.0; 4];
            write_rotation(&rotation, &mut q);
            let mut rate = [0.0; 4];
            quaternion_rate(&q, &omega, &mut rate);
            // Central differences of step 1e-5: truncation |omega|³ h² / 48 plus round-off eps / h.
            let h = 1e-5;
            let mut ends = [[0.0; 4]; 2];
            for (end, sign) in ends.iter_mut().zip([-1.0, 1.0]) {
                write_rotation(&(rotation * UnitQuaternion::from_scaled_axis(sign * h * omega)), end);
            }
            for i in 0..4 {
                prop_assert!(((ends[1][i] - ends[0][i]) / (2.0 * h) - rate[i]).abs() < 1e-9);
            }
        }

        #[test]
        fn rotation_survives_the_way_through_a_slice_of_any_length(
            axis in prop::array::uniform3(-3.0..3.0f64),
            scale in 0.5..2.0f64,
        ) {
            let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(axis));
            let mut q = [0.0; 4];
            write_rotation(&rotation, &mut q);
            q.iter_mut().for_each(|c| *c *= scale);
            prop_assert!(rotation_from_slice(&q).angle_to(&rotation) < 1e-7); // angle from a cosine: sqrt(eps)
            let drifted = (scale * scale - 1.0).abs() > LENGTH_TOLERANCE;
            prop_assert_eq!(renormalise(&mut q), drifted);
            prop_assert!((q.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < LENGTH_TOLERANCE);
        }
    }
}
