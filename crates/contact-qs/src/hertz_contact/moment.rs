//! What a Hertz contact exerts because its stiffness changes over the surfaces (docs/theory.md
//! Eqs. C.83 to C.85): without it the force would have no potential, and bodies that roll or spin
//! while they touch would gain or lose energy.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Normal, contact ellipse and curvatures of both surfaces at the touch, in space.
pub(super) struct Bent<'a> {
    /// Unit normal towards the contact body.
    pub normal: Vector3<f64>,
    /// Sum of the squares of the semi-axes of the contact times their dyads \[m²\].
    pub spread: Matrix3<f64>,
    /// Curvatures of the contact body and the target [1/m].
    pub bending: &'a [Matrix3<f64>; 2],
    /// Changes of the curvatures under the weights `spread` over a step along each surface,
    /// `c · u = C : ∂S/∂u` \[1\].
    pub slopes: [Vector3<f64>; 2],
    /// Unit vectors of the tangent plane.
    pub axes: [Vector3<f64>; 2],
}

/// Force at the place of the touch and couple on the contact body; on the target the opposite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StiffnessChange {
    pub force: Vector3<f64>,
    pub couple: Vector3<f64>,
}

/// Minus the gradient of the energy over all but the approach, `share` of a change of the curvature under
/// the weights `spread` \[N\]; `None` if the surfaces are flat on each other.
pub(super) fn stiffness_change(bent: &Bent<'_>, share: f64) -> Option<StiffnessChange> {
    let [t1, t2] = &bent.axes;
    let vector = |v: &Vector3<f64>| Vector2::new(t1.dot(v), t2.dot(v));
    let matrix = |m: &Matrix3<f64>| {
        let (a, b) = (m * t1, m * t2);
        Matrix2::new(t1.dot(&a), t1.dot(&b), t2.dot(&a), t2.dot(&b))
    };
    let [own, other] = bent.bending.each_ref().map(matrix);
    let [own_slope, other_slope] = bent.slopes.each_ref().map(vector);
    let inverse = (own + other).try_inverse()?;
    let in_space = |v: Vector2<f64>| t1 * v.x + t2 * v.y;
    // Rates over a tilt and a shift of the contact body (Eq. C.85).
    let tilt = in_space(inverse * (own_slope + other_slope));
    let shift = in_space(other * inverse * own_slope - own * inverse * other_slope);
    // Over a turn about the normal: C : (J S - S J).
    let spread = matrix(&bent.spread);
    let turn =
        Matrix2::new(0.0, -1.0, 1.0, 0.0) * if bent.normal.dot(&t1.cross(t2)) < 0.0 { -1.0 } else { 1.0 };
    let spin = spread.component_mul(&(turn * own - own * turn)).sum();
    Some(StiffnessChange {
        force: shift * -share,
        couple: (bent.normal.cross(&tilt) + bent.normal * spin) * share,
    })
}
