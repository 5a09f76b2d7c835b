//! First guess of an impact's contact width (theory section A.5).
//!
//! The width is that of Hertz's contact at the peak of an impact of two masses. It only starts a
//! search: bodies that are no half spaces, or waves, make it inexact.

pub mod local_surface;
pub mod preview;

pub use contact_qs::law::line::{LineLaw, NO_CURVATURE, line_impact};
use contact_qs::law::{HertzEllipse, TouchLaw};
use ffr_dynamics::body::RigidMotion;
use nalgebra::{Matrix3, Vector3};

use crate::touch::tolerances::{FLAT, STRAIGHT};

/// Surface of one partner at the point of first contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalSurface {
    /// Principal curvatures, positive where the body is convex [1/m].
    pub curvatures: [f64; 2],
    /// Direction in space of the first curvature, a unit vector in the tangent plane; any one where
    /// both are equal.
    pub direction: Vector3<f64>,
    /// `(1 - ν²)/E`, zero for a rigid partner [1/Pa].
    pub compliance: f64,
}

impl LocalSurface {
    /// A plane.
    pub fn plane(compliance: f64) -> Self {
        Self { curvatures: [0.0; 2], direction: Vector3::zeros(), compliance }
    }

    /// A surface that is curved alike in both directions; `radius` is infinite for a plane and
    /// negative for a hollow \[m\].
    pub fn sphere(radius: f64, compliance: f64) -> Self {
        Self { curvatures: [1.0 / radius; 2], direction: Vector3::zeros(), compliance }
    }

    /// Curvature in the plane of a plane model, across which there is none [1/m].
    pub fn in_plane(&self) -> f64 {
        self.curvatures[0] + self.curvatures[1]
    }
}

/// The answer of a Hertz impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzPrediction {
    /// Semi-axes of the contact ellipse at the peak, larger first \[m\].
    pub semi_axes: [f64; 2],
    /// Direction in space of the smaller one; zero for a circle.
    pub minor: Vector3<f64>,
    /// Largest force \[N\].
    pub peak_force: f64,
    /// Largest approach \[m\].
    pub approach: f64,
}

/// Modulus `E*` of two materials with the given moduli and Poisson's ratios, those of rigid bodies
/// infinite \[Pa\].
pub fn contact_modulus(materials: &[(f64, f64)]) -> f64 {
    1.0 / materials.iter().map(|(young, poisson)| (1.0 - poisson * poisson) / young).sum::<f64>()
}

/// Inverse effective mass `1/m + (r × n)ᵀ I⁻¹ (r × n)` of a free rigid body with the motions
/// `motion` against a push along `normal` at `arm` from its centre of mass (theory Eq. A.23)
/// [1/kg]; `inertia` is about that, in space. Zero for bodies that cannot move; a singular inertia
/// counts as no rotation, and axisymmetric bodies do not turn.
pub fn inverse_effective_mass(
    motion: RigidMotion,
    mass: f64,
    inertia: &Matrix3<f64>,
    arm: &Vector3<f64>,
    normal: &Vector3<f64>,
) -> f64 {
    if motion == RigidMotion::Axial {
        return 1.0 / mass;
    }
    let lever = arm.cross(normal);
    let rotation = inertia.try_inverse().map_or(0.0, |inverse| lever.dot(&(inverse * lever)));
    1.0 / mass + rotation
}

/// Peak of the Hertz impact of two surfaces (theory Eqs. A.18 to A.22).
///
/// `inverse_mass`: sum of the partners' inverse effective masses [1/kg]; `speed`: closing speed
/// [m/s]. `None` where Hertz's theory has no answer: rigid partners, surfaces without relative
/// curvature in one direction, no closing motion.
pub fn hertz_impact(partners: &[LocalSurface; 2], inverse_mass: f64, speed: f64) -> Option<HertzPrediction> {
    let energy = 0.5 * speed * speed / inverse_mass;
    if !(speed > 0.0 && energy.is_finite()) {
        return None;
    }
    let law = HertzLaw::new(partners)?;
    // Energy `2/5 k δ^(5/2)`.
    let approach = (2.5 * energy / law.stiffness()).powf(0.4);
    Some(law.at_force(law.stiffness() * approach.powf(1.5)))
}

/// Hertz's contact of two surfaces, with the directions of its ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzLaw {
    ellipse: HertzEllipse,
    minor: Vector3<f64>,
}

impl HertzLaw {
    /// The law of two partners; `None` where there is none: rigid ones, or without relative
    /// curvature in one direction.
    pub fn new(partners: &[LocalSurface; 2]) -> Option<Self> {
        let relative = RelativeCurvature::new(partners);
        let compliance = partners[0].compliance + partners[1].compliance;
        let ellipse = HertzEllipse::new(relative.small, relative.large, compliance)?;
        let minor = if ellipse.is_circle() { Vector3::zeros() } else { relative.bent_direction };
        Some(Self { ellipse, minor })
    }

    /// `k` of `F = k δ^(3/2)` [N/m^1.5].
    pub fn stiffness(&self) -> f64 {
        self.ellipse.stiffness()
    }

    /// The contact under the force `force` \[N\].
    pub fn at_force(&self, force: f64) -> HertzPrediction {
        HertzPrediction {
            semi_axes: self.ellipse.semi_axes(force),
            minor: self.minor,
            peak_force: force,
            approach: (force / self.stiffness()).powf(2.0 / 3.0),
        }
    }
}

/// Curvature of the gap across the line along which two surfaces touch [1/m], and the unit vector
/// in space across it; `None` if they are curved against each other both ways, or none over the
/// length `size` \[m\].
pub fn across_line(partners: &[LocalSurface; 2], size: f64) -> Option<(f64, Vector3<f64>)> {
    let RelativeCurvature { small, large, bent_direction } = RelativeCurvature::new(partners);
    let is_line = large * size > FLAT && small.abs() <= STRAIGHT * large;
    is_line.then_some((large, bent_direction))
}

/// Curvatures of the gap between the surfaces: `gap = ½ (small x² + large y²)` [1/m].
struct RelativeCurvature {
    small: f64,
    large: f64,
    /// Direction of the larger one, along which the contact is shorter.
    bent_direction: Vector3<f64>,
}

impl RelativeCurvature {
    fn new(partners: &[LocalSurface; 2]) -> Self {
        let mean: f64 = partners.iter().map(|p| 0.5 * (p.curvatures[0] + p.curvatures[1])).sum();
        // Half the differences of the principal curvatures add up as vectors of twice the angle.
        let [first, second] = partners;
        let main = if second.spread() >= first.spread() { second } else { first };
        let (mut along, mut across) = (0.0, 0.0);
        for p in partners {
            let cosine = if p.direction == main.direction { 1.0 } else { p.direction.dot(&main.direction) };
            let double = 2.0 * cosine.clamp(-1.0, 1.0).acos();
            along += p.spread() * double.cos();
            across += p.spread() * double.sin();
        }
        let deviation = along.hypot(across);
        let (small, large) = (mean - deviation, mean + deviation);
        // The normal of the tangent plane, from two directions that differ; without such directions
        // nothing is turned.
        let normal = partners.iter().map(|p| p.direction.cross(&main.direction)).find(|v| v.norm() > 1e-6);
        let bent_direction = most_bent(&main.direction, normal, 0.5 * across.atan2(along));
        Self { small, large, bent_direction }
    }
}

/// The most curved direction, which lies at `angle` from `main` about `normal`; without a normal
/// `main` itself.
fn most_bent(main: &Vector3<f64>, normal: Option<Vector3<f64>>, angle: f64) -> Vector3<f64> {
    let Some(normal) = normal.map(|n| n.normalize()) else { return *main };
    // A partner's direction is `main` turned by -angle about its cross product with `main`.
    main * angle.cos() - normal.cross(main) * angle.sin()
}

impl LocalSurface {
    /// Half the difference of the curvatures [1/m].
    fn spread(&self) -> f64 {
        0.5 * (self.curvatures[0] - self.curvatures[1])
    }
}

/// Force between two touching bodies as a function of their approach: the force of a preview, in
/// which no contact zone is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImpactLaw {
    /// Hertz's contact of curved surfaces.
    Point(HertzLaw),
    /// Line contact of a plane model.
    Line(LineLaw),
}

impl ImpactLaw {
    /// Force at `approach` \[N\] and the energy stored by then \[J\]; `approach` is not negative
    /// \[m\].
    pub fn force(&self, approach: f64) -> (f64, f64) {
        let law = match *self {
            Self::Point(law) => TouchLaw::Point(law.ellipse),
            Self::Line(law) => TouchLaw::Line(law),
        };
        let (force, energy, _) = law.at(approach);
        (force, energy)
    }
}

/// Contact of solid bodies along a straight line, across which alone their surfaces are curved
/// (theory Eq. C.67).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StraightLine {
    /// Its law.
    pub law: LineLaw,
    /// Direction across it in space.
    pub across: Vector3<f64>,
}

/// Height of the ends of a line over its middle, as a share of that of the surface at the rim of the contact, up to which it is straight.
const NEARLY: f64 = 0.1;

impl StraightLine {
    /// The line contact of two partners of the size `size` over the length `length` \[m\]; `None`
    /// unless their relative curvature vanishes in exactly one direction. `half_width` tells by its law how wide a contact is, 0 if that is not
    /// known: a line is straight if its ends are higher than its middle by no more than a tenth of what the surface is at the rim of that.
    pub fn new(
        partners: &[LocalSurface; 2],
        (size, length): (f64, f64),
        half_width: impl Fn(&LineLaw) -> f64,
    ) -> Option<Self> {
        let relative = RelativeCurvature::new(partners);
        let compliance = partners[0].compliance + partners[1].compliance;
        let law = LineLaw::new(relative.large, compliance, size, length)?;
        let nearly = NEARLY * (half_width(&law) / (0.5 * length)).powi(2);
        let is_straight = relative.small.abs() <= NO_CURVATURE.max(nearly) * relative.large;
        is_straight.then_some(Self { law, across: relative.bent_direction })
    }

    /// Whether `tangent`, a direction along the surface, is nearer to the direction across the line
    /// than to the line.
    pub fn is_across(&self, tangent: &Vector3<f64>) -> bool {
        tangent.dot(&self.across).abs() > 0.5_f64.sqrt() * tangent.norm()
    }
}

/// Width of an interval whose utilisation is `target`, for a contact that reaches `half_width` on
/// both sides of the centre; measured from the axis outwards with `from_axis` (theory Eq. A.22)
/// \[m\].
pub fn interval_width(half_width: f64, target: f64, from_axis: bool) -> f64 {
    let extent = if from_axis { half_width } else { 2.0 * half_width };
    extent / target
}

/// Half extents of an ellipse along two directions `tangents` in the plane of contact, not
/// necessarily of unit length \[m\].
pub fn half_extents(prediction: &HertzPrediction, tangents: &[Vector3<f64>; 2]) -> [f64; 2] {
    let [a, b] = prediction.semi_axes;
    tangents.map(|t| {
        let cosine = t.try_normalize(0.0).map_or(0.0, |t| t.dot(&prediction.minor)).abs().min(1.0);
        extent_of_ellipse([a, b], [(1.0 - cosine * cosine).sqrt(), cosine])
    })
}

/// Extent of an ellipse with the axes `axes` in a direction that has the `components` along them
/// (theory Eq. A.22).
fn extent_of_ellipse(axes: [f64; 2], components: [f64; 2]) -> f64 {
    (axes[0] * components[0]).hypot(axes[1] * components[1])
}

/// Widths along the directions `target` of an area of contact that has the `widths` along the
/// directions `contact`: of the ellipse with these as axes \[m\]. Directions lie in the plane of
/// contact and need not be of unit length.
pub fn widths_along(widths: [f64; 2], contact: &[Vector3<f64>; 2], target: &[Vector3<f64>; 2]) -> [f64; 2] {
    let unit = |v: &Vector3<f64>| v.try_normalize(0.0).unwrap_or_default();
    let axes = contact.each_ref().map(unit);
    target.each_ref().map(|t| extent_of_ellipse(widths, axes.map(|axis| unit(t).dot(&axis))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hertz_impact::HertzImpact;
    use approx::assert_relative_eq;
    use contact_qs::law::hertz::{HertzPair, Solid};

    const STEEL: Solid = Solid { young: 210e9, poisson: 0.3 };
    const ALUMINIUM: Solid = Solid { young: 72.8e9, poisson: 0.33 };

    #[test]
    fn widths_follow_the_directions_of_the_other_body() {
        let (x, y) = (Vector3::x(), Vector3::y());
        let widths = |target: [Vector3<f64>; 2]| widths_along([3.0, 1.0], &[2.0 * x, y], &target);
        let is = |found: [f64; 2], expected: [f64; 2]| {
            found.iter().zip(expected).for_each(|(f, e)| assert_relative_eq!(*f, e, max_relative = 1e-14));
        };
        is(widths([x, -y]), [3.0, 1.0]);
        is(widths([5.0 * y, x]), [1.0, 3.0]);
        // An ellipse of axes 3 and 1, seen from 45 degrees.
        widths([x + y, x - y])
            .iter()
            .for_each(|w| assert_relative_eq!(*w, 5f64.sqrt(), max_relative = 1e-14));
        // A circle is as wide in every direction.
        is(widths_along([2.0; 2], &[x, y], &[x + 3.0 * y, 3.0 * x - y]), [2.0; 2]);
    }

    #[test]
    fn spheres_give_hertz_in_closed_form() {
        for (radii, solids) in [
            ([0.01, f64::INFINITY], [STEEL, ALUMINIUM]),
            ([0.01, 0.03], [STEEL, Solid::RIGID]),
            ([0.01, -0.05], [ALUMINIUM, STEEL]),
        ] {
            let (masses, speed) = ([0.0329, 0.876], 0.1);
            let exact = HertzImpact::new(HertzPair::new(solids, radii), masses, speed);
            let partners = [0, 1].map(|i| LocalSurface::sphere(radii[i], solids[i].compliance()));
            let found = hertz_impact(&partners, 1.0 / masses[0] + 1.0 / masses[1], speed).unwrap();
            assert_relative_eq!(found.peak_force, exact.peak_force(), max_relative = 1e-12);
            assert_relative_eq!(found.approach, exact.peak_approach(), max_relative = 1e-12);
            let radius = exact.pair.contact_radius(exact.peak_approach());
            assert_relative_eq!(found.semi_axes[0], radius, max_relative = 1e-12);
        }
    }

    #[test]
    fn crossed_equal_cylinders_are_a_sphere_on_a_plane() {
        let c = STEEL.compliance();
        let cylinder =
            |axis: Vector3<f64>| LocalSurface { curvatures: [50.0, 0.0], direction: axis, compliance: c };
        let crossed = [cylinder(Vector3::x()), cylinder(Vector3::y())];
        let equal = [LocalSurface::sphere(0.02, c), LocalSurface::plane(c)];
        let (a, b) = (hertz_impact(&crossed, 2.0, 0.3).unwrap(), hertz_impact(&equal, 2.0, 0.3).unwrap());
        assert_relative_eq!(a.peak_force, b.peak_force, max_relative = 1e-9);
        assert_relative_eq!(a.semi_axes[1], b.semi_axes[0], max_relative = 1e-6);
        assert!(
            hertz_impact(&[crossed[0], crossed[0]], 2.0, 0.3).is_none(),
            "parallel cylinders touch along a line"
        );
    }

    #[test]
    fn an_ellipse_lies_across_the_larger_curvature() {
        let c = STEEL.compliance();
        let body = LocalSurface { curvatures: [100.0, 20.0], direction: Vector3::y(), compliance: c };
        let found = hertz_impact(&[body, LocalSurface::plane(c)], 3.0, 0.2).unwrap();
        let [a, b] = found.semi_axes;
        assert!((2.5..3.5).contains(&(a / b)), "about (100/20)^(2/3) = 2.9: {}", a / b);
        // The plane has no direction: the body's own says which way the contact is longer.
        let extents = half_extents(&found, &[Vector3::x(), Vector3::y()]);
        assert_relative_eq!(extents[0], a, max_relative = 1e-12);
        assert_relative_eq!(extents[1], b, max_relative = 1e-12);
    }

    #[test]
    fn the_long_axis_lies_where_the_gap_is_flattest() {
        let c = STEEL.compliance();
        let turned = Vector3::new(0.5f64.cos(), 0.5f64.sin(), 0.0);
        let one = LocalSurface { curvatures: [100.0, 20.0], direction: Vector3::x(), compliance: c };
        let other = LocalSurface { curvatures: [60.0, 10.0], direction: turned, compliance: c };
        for partners in [[one, other], [other, one]] {
            let found = hertz_impact(&partners, 3.0, 0.2).unwrap();
            // Smallest bend by search over all angles.
            let bend = |angle: f64| {
                let t = Vector3::new(angle.cos(), angle.sin(), 0.0);
                let of = |p: &LocalSurface| {
                    let c2 = t.dot(&p.direction).powi(2);
                    p.curvatures[0] * c2 + p.curvatures[1] * (1.0 - c2)
                };
                of(&one) + of(&other)
            };
            let angle = (0..3141).map(|i| f64::from(i) * 1e-3).min_by(|a, b| bend(*a).total_cmp(&bend(*b)));
            let best = angle.map(|a| Vector3::new(a.cos(), a.sin(), 0.0)).unwrap();
            // The search finds the angle to 1e-3.
            assert!(found.minor.dot(&best).abs() < 1e-3, "{} and {best}", found.minor);
            let along = half_extents(&found, &[2.0 * Vector3::z().cross(&found.minor), found.minor]);
            assert_relative_eq!(along[0], found.semi_axes[0], max_relative = 1e-9);
            assert_relative_eq!(along[1], found.semi_axes[1], max_relative = 1e-9);
        }
    }

    #[test]
    fn what_hertz_cannot_answer_is_none() {
        let (c, ball) = (STEEL.compliance(), LocalSurface::sphere(0.01, STEEL.compliance()));
        let none = |partners: [LocalSurface; 2], inverse_mass, speed| {
            assert!(hertz_impact(&partners, inverse_mass, speed).is_none());
        };
        none([LocalSurface::plane(c); 2], 1.0, 0.1);
        none([ball, LocalSurface::plane(c)], 1.0, 0.0);
        none([ball, LocalSurface::plane(c)], 0.0, 0.1);
        none([ball, LocalSurface::sphere(-0.01, c)], 1.0, 0.1);
        none([LocalSurface::sphere(0.01, 0.0), LocalSurface::plane(0.0)], 1.0, 0.1);
        none([ball, LocalSurface::plane(c)], 1.0, f64::NAN);
    }

    #[test]
    fn the_first_interval_of_the_rod_is_used_to_the_target() {
        // \[A\] section 5: peak 73.4 N with a steel sphere of 10 mm on a flat aluminium end.
        let partners =
            [LocalSurface::sphere(0.01, STEEL.compliance()), LocalSurface::plane(ALUMINIUM.compliance())];
        let found = hertz_impact(&partners, 1.0 / 0.032_88 + 1.0 / 0.876, 0.1).unwrap();
        let width = interval_width(found.semi_axes[0], 0.7, true);
        let pair = HertzPair::new([STEEL, ALUMINIUM], [0.01, f64::INFINITY]);
        let true_radius = pair.contact_radius(pair.approach(73.4));
        let utilisation = true_radius / width;
        assert!((0.6..0.8).contains(&utilisation), "utilisation {utilisation}");
        assert_relative_eq!(interval_width(1.0, 0.5, false), 4.0);
    }

    #[test]
    fn a_push_off_centre_meets_less_mass() {
        let inertia = Matrix3::identity() * 0.4 * 2.0 * 0.01; // sphere of 2 kg and radius 0.1 m
        let arm = Vector3::new(0.1, 0.0, 0.0);
        let central = inverse_effective_mass(RigidMotion::Spatial, 2.0, &inertia, &arm, &Vector3::x());
        let tangential = inverse_effective_mass(RigidMotion::Spatial, 2.0, &inertia, &arm, &Vector3::y());
        assert_relative_eq!(central, 0.5, max_relative = 1e-14);
        assert_relative_eq!(tangential, 3.5 / 2.0, max_relative = 1e-14); // (1 + 5/2)/m
    }
}
