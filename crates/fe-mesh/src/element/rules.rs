//! Quadrature rules of elements and sides.
//!
//! | kind | stiffness | mass |
//! |---|---|---|
//! | tet4 | 1 point, degree 1 | 4 points, degree 2 |
//! | tet10 | 4 points, degree 2 | 15 points, degree 5 |
//! | hex8 | 2 × 2 × 2 | 2 × 2 × 2 |
//! | hex20, hex27 | 3 × 3 × 3 | 3 × 3 × 3 |
//! | wedge6 | 3 × 2 | 3 × 2 |
//! | wedge15 | 3 × 3 | 7 × 3, degree 5 in the triangle |
//! | wedge18 | 7 × 3, degree 5 in the triangle | 7 × 3 |
//! | pyramid5 | 2 × 2 × 2, conical | 2 × 2 × 2 |
//! | pyramid13, pyramid14 | 3 × 3 × 3, conical | 3 × 3 × 3 |
//! | tri3, tri6 | 3 points, degree 2; axisymmetric 7 | 7 points, degree 5 |
//! | quad4 | 2 × 2 | 2 × 2 |
//! | quad8, quad9 | 3 × 3 | 3 × 3 |
//!
//! Mass matrices are exact where the map of the element is affine, total mass on curved quadratic
//! elements as well: their determinants have degree three in tetrahedra, four in the triangle of
//! wedges, five in each direction of hexahedra. The stiffness of tetrahedra and pyramids is exact
//! where the map is affine; that of other curved or tapered elements is a rational function, which
//! no rule integrates exactly. A rule that is exact to degree `2 p - 2` keeps the order `2 p` of
//! frequencies (G. Strang, G. J. Fix: An Analysis of the Finite Element Method, 4.3); those of the
//! stiffness are.
//!
//! The mass of plane elements is exact where the map is affine with the radius of axisymmetric models
//! as well, which raises the degree by one.
//!
//! Conical rules of pyramids are Gauss' rules of `ξ/(1 - ζ)` and `η/(1 - ζ)` times the rule of
//! Gauss and Jacobi for `(1 - ζ)²`; no point lies at the apex. In these three parameters the
//! rational functions of pyramids are polynomials, of degree one or two in each of them, and the
//! determinant of straight-sided ones, whatever their base looks like, is bilinear in the first
//! two: the mass is exact for all of these, total mass for curved ones as well, whose determinant
//! has degree five at most.
//!
//! CalculiX integrates the mass of tet10 and wedge15 with the points of the stiffness
//! ([`MassRule::AsStiffness`]). The order is the same, but the matrix of a mesh of few elements is
//! singular: 4 points per tetrahedron do not determine ten functions.

use iga_core::elasticity::Model;

use crate::element::kind::{ElementKind, SideKind};

/// A point with its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RulePoint<const D: usize> {
    /// Parameters.
    pub xi: [f64; D],
    /// Weight; the weights of a rule sum to the volume of the parameters' domain.
    pub weight: f64,
}

/// Points for products of functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MassRule {
    /// Exact on straight-sided elements; the matrix is positive definite.
    #[default]
    Exact,
    /// The points of the stiffness, as CalculiX has them in tet10 and wedge15, so that results can
    /// be compared digit by digit.
    AsStiffness,
}

/// Gauss' rule on `[-1, 1]` with two or three points.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    match n {
        2 => [-1.0, 1.0].map(|s| (s / 3.0_f64.sqrt(), 1.0)).to_vec(),
        _ => [(-1.0, 5.0 / 9.0), (0.0, 8.0 / 9.0), (1.0, 5.0 / 9.0)]
            .map(|(s, w)| (s * 0.6_f64.sqrt(), w))
            .to_vec(),
    }
}

/// The three points `(a, a)`, `(1 - 2 a, a)`, `(a, 1 - 2 a)` of a triangle, of area 1/2, with the
/// weight `w` each.
fn orbit(a: f64, w: f64) -> [RulePoint<2>; 3] {
    let b = 1.0 - 2.0 * a;
    [[a, a], [b, a], [a, b]].map(|xi| RulePoint { xi, weight: w })
}

/// Rules for triangles: 3 points of degree 2, 7 of degree 5 (J. Radon).
fn triangle(n: usize) -> Vec<RulePoint<2>> {
    match n {
        3 => orbit(1.0 / 6.0, 1.0 / 6.0).to_vec(),
        _ => {
            let r = 15.0_f64.sqrt();
            let centre = RulePoint { xi: [1.0 / 3.0; 2], weight: 9.0 / 80.0 };
            let near = orbit((6.0 - r) / 21.0, (155.0 - r) / 2400.0);
            let far = orbit((6.0 + r) / 21.0, (155.0 + r) / 2400.0);
            [&[centre], &near[..], &far[..]].concat()
        }
    }
}

/// The four points of a tetrahedron with three coordinates `a`, weight `w` each.
fn vertices(a: f64, w: f64) -> [RulePoint<3>; 4] {
    let b = 1.0 - 3.0 * a;
    [[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|xi| RulePoint { xi, weight: w })
}

/// Rules for tetrahedra: 1 point of degree 1, 4 of degree 2, 15 of degree 5 (A. H. Stroud:
/// Approximate Calculation of Multiple Integrals, T3:5-1).
fn tetrahedron(n: usize) -> Vec<RulePoint<3>> {
    match n {
        1 => vec![RulePoint { xi: [0.25; 3], weight: 1.0 / 6.0 }],
        4 => vertices((5.0 - 5.0_f64.sqrt()) / 20.0, 1.0 / 24.0).to_vec(),
        _ => {
            let r = 15.0_f64.sqrt();
            let mut points = vec![RulePoint { xi: [0.25; 3], weight: 8.0 / 405.0 }];
            points.extend(vertices((7.0 - r) / 34.0, (2665.0 + 14.0 * r) / 226_800.0));
            points.extend(vertices((7.0 + r) / 34.0, (2665.0 - 14.0 * r) / 226_800.0));
            let (a, b) = ((5.0 - r) / 20.0, (5.0 + r) / 20.0);
            let middles = [[a, a, b], [b, a, a], [b, b, a], [a, b, b], [a, b, a], [b, a, b]];
            points.extend(middles.map(|xi| RulePoint { xi, weight: 5.0 / 567.0 }));
            points
        }
    }
}

fn hexahedron(n: usize) -> Vec<RulePoint<3>> {
    let line = gauss(n);
    let mut points = Vec::with_capacity(n * n * n);
    for (z, w) in &line {
        for (y, v) in &line {
            points.extend(line.iter().map(|(x, u)| RulePoint { xi: [*x, *y, *z], weight: u * v * w }));
        }
    }
    points
}

fn wedge(n: usize, line: usize) -> Vec<RulePoint<3>> {
    let line = gauss(line);
    let level = |(z, w): &(f64, f64)| -> Vec<_> {
        triangle(n).iter().map(|p| RulePoint { xi: [p.xi[0], p.xi[1], *z], weight: w * p.weight }).collect()
    };
    line.iter().flat_map(level).collect()
}

/// The rule of Gauss and Jacobi on `[0, 1]` with the weight `w²`, of two or three points: roots of
/// `w² - 4/3 w + 2/5` and of `w³ - 15/8 w² + 15/14 w - 5/28`.
fn jacobi(n: usize) -> Vec<(f64, f64)> {
    match n {
        2 => {
            let half = (2.0_f64 / 45.0).sqrt();
            [-1.0, 1.0].map(|s| (2.0 / 3.0 + s * half, 1.0 / 6.0 + s / (72.0 * half))).to_vec()
        }
        _ => vec![
            (0.294_997_790_111_501_6, 0.029_950_703_008_580_698),
            (0.652_996_233_961_648_1, 0.146_246_269_259_866_02),
            (0.927_005_975_926_850_3, 0.157_136_361_064_886_62),
        ],
    }
}

/// The conical product of `n` points each way.
fn pyramid(n: usize) -> Vec<RulePoint<3>> {
    let level = |(w, weight): (f64, f64)| {
        square(n)
            .into_iter()
            .map(move |p| RulePoint { xi: [w * p.xi[0], w * p.xi[1], 1.0 - w], weight: weight * p.weight })
    };
    // From the base upwards.
    jacobi(n).into_iter().rev().flat_map(level).collect()
}

/// A rule of the plane as one of three parameters.
fn flat(rule: Vec<RulePoint<2>>) -> Vec<RulePoint<3>> {
    rule.into_iter().map(|p| RulePoint { xi: [p.xi[0], p.xi[1], 0.0], weight: p.weight }).collect()
}

impl ElementKind {
    /// Points for products of gradients.
    pub fn stiffness_rule(self) -> Vec<RulePoint<3>> {
        match self {
            Self::Tet4 => tetrahedron(1),
            Self::Tet10 => tetrahedron(4),
            Self::Hex8 => hexahedron(2),
            Self::Hex20 | Self::Hex27 => hexahedron(3),
            Self::Wedge6 => wedge(3, 2),
            Self::Wedge15 => wedge(3, 3),
            Self::Wedge18 => wedge(7, 3),
            Self::Pyramid5 => pyramid(2),
            Self::Pyramid13 | Self::Pyramid14 => pyramid(3),
            Self::Tri3 | Self::Tri6 => flat(triangle(3)),
            Self::Quad4 => flat(square(2)),
            Self::Quad8 | Self::Quad9 => flat(square(3)),
        }
    }

    /// Points for products of gradients in the kinematics `model`: with radii, which axisymmetric integrands
    /// are multiplied by and divided by, those of the mass.
    pub fn stiffness_points(self, model: &Model) -> Vec<RulePoint<3>> {
        if *model == Model::Axisymmetric { self.mass_rule() } else { self.stiffness_rule() }
    }

    /// Points for products of functions, exact ones.
    pub fn mass_rule(self) -> Vec<RulePoint<3>> {
        match self {
            Self::Tet4 => tetrahedron(4),
            Self::Tet10 => tetrahedron(15),
            Self::Wedge15 => wedge(7, 3),
            Self::Tri3 | Self::Tri6 => flat(triangle(7)),
            Self::Quad4
            | Self::Quad8
            | Self::Quad9
            | Self::Hex8
            | Self::Hex20
            | Self::Hex27
            | Self::Wedge6
            | Self::Wedge18
            | Self::Pyramid5
            | Self::Pyramid13
            | Self::Pyramid14 => self.stiffness_rule(),
        }
    }

    /// Points for products of functions as `rule` has them; CalculiX takes other points than for
    /// the stiffness in tet4.
    pub fn mass_points(self, rule: MassRule) -> Vec<RulePoint<3>> {
        match rule {
            MassRule::AsStiffness if !matches!(self, Self::Tet4 | Self::Tri3) => self.stiffness_rule(),
            _ => self.mass_rule(),
        }
    }
}

impl SideKind {
    /// Points for products of a function, a coordinate and the area element, which on curved sides
    /// is no polynomial: degree 5.
    pub fn rule(self) -> Vec<RulePoint<2>> {
        match self.n_corners() {
            2 => line(3),
            3 => triangle(7),
            _ => square(3),
        }
    }

    /// Points of contact: as few as integrate a constant pressure times every function of a flat
    /// side exactly. More would ask more conditions of a side than it has displacements to meet
    /// them by.
    pub fn contact_rule(self) -> Vec<RulePoint<2>> {
        match self.n_corners() {
            2 => line(2),
            3 => triangle(3),
            _ => square(2),
        }
    }
}

/// Gauss' rule of `n` points on a curve.
fn line(n: usize) -> Vec<RulePoint<2>> {
    gauss(n).into_iter().map(|(x, weight)| RulePoint { xi: [x, 0.0], weight }).collect()
}

/// Gauss' rule on the square with `n` by `n` points.
fn square(n: usize) -> Vec<RulePoint<2>> {
    let line = gauss(n);
    let row = |(y, v): &(f64, f64)| -> Vec<_> {
        line.iter().map(|(x, u)| RulePoint { xi: [*x, *y], weight: u * v }).collect()
    };
    line.iter().flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::kind::Form;

    fn factorial(n: usize) -> f64 {
        (1..=n).map(|k| k as f64).product()
    }

    /// `∫ x^a y^b z^c` over the domain of the form.
    fn exact(form: Form, [a, b, c]: [usize; 3]) -> f64 {
        let line = |n: usize| if n.is_multiple_of(2) { 2.0 / (n as f64 + 1.0) } else { 0.0 };
        match form {
            Form::Tetrahedron => factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3),
            Form::Hexahedron => line(a) * line(b) * line(c),
            Form::Triangle => factorial(a) * factorial(b) / factorial(a + b + 2),
            Form::Quadrilateral => line(a) * line(b),
            Form::Wedge => factorial(a) * factorial(b) / factorial(a + b + 2) * line(c),
            Form::Pyramid => {
                line(a) * line(b) * factorial(a + b + 2) * factorial(c) / factorial(a + b + c + 3)
            }
        }
    }

    fn check(form: Form, rule: &[RulePoint<3>], in_plane: usize, in_line: usize) {
        for a in 0..=in_plane {
            for b in 0..=in_plane {
                for c in 0..=in_line {
                    let counts = match form {
                        Form::Tetrahedron | Form::Pyramid => a + b + c <= in_plane,
                        Form::Wedge | Form::Triangle => a + b <= in_plane,
                        Form::Hexahedron | Form::Quadrilateral => true,
                    };
                    if counts {
                        let power =
                            |x: &[f64; 3]| x[0].powi(a as i32) * x[1].powi(b as i32) * x[2].powi(c as i32);
                        let sum: f64 = rule.iter().map(|p| p.weight * power(&p.xi)).sum();
                        // A few dozen terms of order one.
                        assert!(
                            (sum - exact(form, [a, b, c])).abs() < 1e-14,
                            "{form:?} x^{a} y^{b} z^{c}: {sum}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn rules_have_the_degrees_that_they_claim() {
        check(Form::Tetrahedron, &tetrahedron(1), 1, 1);
        check(Form::Tetrahedron, &tetrahedron(4), 2, 2);
        check(Form::Tetrahedron, &tetrahedron(15), 5, 5);
        check(Form::Hexahedron, &hexahedron(2), 3, 3);
        check(Form::Hexahedron, &hexahedron(3), 5, 5);
        check(Form::Wedge, &wedge(3, 2), 2, 3);
        check(Form::Wedge, &wedge(7, 3), 5, 5);
        check(Form::Pyramid, &pyramid(2), 3, 3);
        check(Form::Pyramid, &pyramid(3), 5, 5);
        check(Form::Triangle, &flat(triangle(3)), 2, 0);
        check(Form::Triangle, &flat(triangle(7)), 5, 0);
        check(Form::Quadrilateral, &flat(square(2)), 3, 0);
        check(Form::Quadrilateral, &flat(square(3)), 5, 0);
        for kind in ElementKind::ALL {
            for rule in [kind.stiffness_rule(), kind.mass_rule()] {
                let total: f64 = rule.iter().map(|p| p.weight).sum();
                assert!((total - exact(kind.form(), [0; 3])).abs() < 1e-14);
            }
        }
    }
}
