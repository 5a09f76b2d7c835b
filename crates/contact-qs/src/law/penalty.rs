//! Penalty law of a contact point, and what a compliance tells of its penalty factor.
//!
//! `p = c_p <-g>`, `λ = w p` (docs/theory.md Eq. C.3; \[A\] section 3, \[B\] Eqs. 18 and 22). With
//! tributary areas `w` the factor `c_p` is a pressure per length [N/m³]; the papers print "N/m" for
//! the same numbers.

use faer::Mat;

use crate::ContactError;

/// Penalty factor times `max_i(A_ii w_i)` (Eq. A.25), the ratio of the surface's own compliance to
/// that of the penalty springs: at this one the peak force of the sphere impact (\[B\] section 5)
/// is within 0.1 % of its limit.
pub const DEFAULT_STIFFNESS_RATIO: f64 = 40.0;

/// Contact pressure `c_p <-g>` at normal gap `gap` (negative: penetration) \[Pa\].
pub fn pressure(penalty: f64, gap: f64) -> f64 {
    if gap < 0.0 { -penalty * gap } else { 0.0 }
}

/// Compliance `1/(c_p w)` of the penalty spring of a point with area `area` [m/N]; zero for an
/// infinite factor, which is the exact constraint.
pub fn spring_compliance(penalty: f64, area: f64) -> f64 {
    1.0 / (penalty * area)
}

/// Checks that a penalty factor is positive; infinity stands for the exact constraint.
///
/// # Errors
/// [`ContactError::Penalty`] if it is zero, negative or not a number.
pub fn check(penalty: f64) -> Result<(), ContactError> {
    if penalty > 0.0 { Ok(()) } else { Err(ContactError::Penalty { value: penalty }) }
}

/// Replaces `springs` by the compliances of the penalty springs of points with areas `areas`, and of what is `left_out` of the
/// indentation at them in series with these, empty if nothing is [m/N].
/// `needs_springs`: whether the solver of the quasistatic zone works with finite factors only; none
/// where all modes are dynamic.
///
/// # Errors
/// [`ContactError::Penalty`] as [`check`], [`ContactError::ExactConstraint`] if the factor is infinite where springs are needed.
pub(crate) fn set_springs(
    penalty: f64,
    needs_springs: Option<bool>,
    (areas, left_out): (&[f64], &[f64]),
    springs: &mut [f64],
) -> Result<(), ContactError> {
    check(penalty)?;
    let method = match needs_springs {
        None => Some("contact with all modes dynamic"),
        Some(true) => Some("Algorithm 1"),
        Some(false) => None,
    };
    if let (true, Some(method)) = (penalty.is_infinite(), method) {
        return Err(ContactError::ExactConstraint { method });
    }
    for (spring, &area) in springs.iter_mut().zip(areas) {
        *spring = spring_compliance(penalty, area);
    }
    springs.iter_mut().zip(left_out).for_each(|(spring, left_out)| *spring += left_out);
    Ok(())
}

/// Largest product `max_i(A_ii w_i)` of compliance and area [m³/N]: `β` over it is the penalty
/// factor that makes every penalty spring at least `β` times stiffer than the surface under it
/// (Eq. C.4). Of the points whose gap is the smallest one or wider by `reach` at most, which are going to
/// touch: what yields elsewhere does not press. Zero if none of them yields.
///
/// `compliance`: normal compliance of the points, `n_points × n_points` [m/N]; `areas`: tributary
/// areas \[m²\]; `gap` of a point \[m\].
///
/// # Panics
/// If `compliance` has fewer rows than there are `areas`.
pub fn compliance_weight(
    compliance: &Mat<f64>,
    areas: &[f64],
    gap: impl Fn(usize) -> f64,
    reach: f64,
) -> f64 {
    let least = (0..areas.len()).map(&gap).fold(f64::INFINITY, f64::min);
    let near = areas.iter().enumerate().filter(|(i, _)| gap(*i) <= least + reach);
    near.map(|(i, &w)| compliance[(i, i)] * w).fold(0.0, f64::max)
}

/// Penalty factor that makes penalty springs `stiffness_ratio` times stiffer than the softest point
/// (Eq. A.25) [N/m³]; `weight`: its [`compliance_weight`] [m³/N].
///
/// # Errors
/// [`ContactError::NoCompliance`] if no point yields.
pub fn from_weight(stiffness_ratio: f64, weight: f64) -> Result<f64, ContactError> {
    if weight > 0.0 { Ok(stiffness_ratio / weight) } else { Err(ContactError::NoCompliance) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_softest_point_weighs_most() {
        let compliance = Mat::from_fn(2, 2, |i, j| if i == j { [1e-8, 3e-8][i] } else { 1.0 });
        let weight =
            |gaps: [f64; 2], reach| compliance_weight(&compliance, &[2e-9, 1e-9], |i| gaps[i], reach);
        assert!((weight([0.0, 1.0], f64::INFINITY) - 3e-17).abs() < 1e-31);
        // Of those that are going to touch.
        assert!((weight([1.0, 1.5], 0.1) - 2e-17).abs() < 1e-31);
        assert!((weight([1.05, 1.0], 0.1) - 3e-17).abs() < 1e-31);
        assert!(compliance_weight(&Mat::zeros(2, 2), &[1.0, 1.0], |_| 0.0, 0.0).abs() < f64::MIN_POSITIVE);
        assert!((from_weight(40.0, 4e-17).unwrap() / 1e18 - 1.0).abs() < 1e-15);
        // Round-off of a compliance that cancels may be negative.
        let lost = compliance_weight(&Mat::from_fn(1, 1, |_, _| -1e-9), &[1.0], |_| 0.0, 0.0);
        assert_eq!(from_weight(40.0, lost), Err(ContactError::NoCompliance));
        assert_eq!(from_weight(40.0, f64::NAN), Err(ContactError::NoCompliance));
    }

    #[test]
    fn factors_that_are_not_positive_are_refused() {
        assert!(check(f64::INFINITY).is_ok() && check(1e17).is_ok());
        assert!([0.0, -1.0, f64::NAN].iter().all(|&c| check(c).is_err()));
    }
}
