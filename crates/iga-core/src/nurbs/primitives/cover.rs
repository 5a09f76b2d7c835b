//! Surfaces across a body of revolution: plane or spherical about the axis, with a fillet at the
//! rim or without.
//!
//! On solids such a surface is divided into a square about the axis and four pieces around it,
//! without singular places. A plane is divided by straight lines and quarters of circles, of degree
//! 2. A sphere of the curvature `κ` is the image of the complex plane: the point `w = z₀/z₁` is
//! mapped to `(z₀ z̄₁, κ |z₀|²/2, |z₁|² + κ² |z₀|²/4)`, homogeneous, the stereographic projection
//! from the plane that touches its pole (theory Eq. S.11). It is of degree 4: with biquadratic
//! pieces the lines between them could not be one for both neighbours.

use std::f64::consts::FRAC_PI_8;

/// A homogeneous control point: coordinates times weight, weight.
pub type Homogeneous = [f64; 4];
/// Radius and height of a point of a meridian, and its weight.
pub type Meridian = [f64; 3];

/// A surface across a body of revolution about the z axis.
#[derive(Debug, Clone, Copy)]
pub struct Cover {
    /// Height of its pole \[m\].
    pub pole: f64,
    /// Curvature \[1/m\], positive where the surface rises away from the pole.
    pub curvature: f64,
    /// Radius up to which it is plane or spherical \[m\].
    pub rim: f64,
    /// What follows beyond: a second arc of the meridian, from the rim to the jacket.
    pub fillet: Option<[Meridian; 3]>,
}

/// How the covers of a body are divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Division {
    /// Plane ones, of degree 2.
    Straight,
    /// Plane and spherical ones, by the projection, of degree 4.
    Projected,
}

/// Control points of a cover, homogeneous.
pub struct CoverNet {
    /// The square about the axis: 3 x 3, projected 5 x 5.
    pub core: Vec<Homogeneous>,
    /// The four pieces around it, each 3 or 5 outwards x 3 around (projected 5), from the one about
    /// `x > 0` on.
    pub rings: [Vec<Homogeneous>; 4],
}

/// Half the edge of the square over the radius of the rim: the four pieces have lines of about
/// equal length in both directions.
const SQUARE: f64 = 0.55;

impl Cover {
    /// A plane cover at the height `z` with the division of one that has its rim at `rim` and ends
    /// at `radius`.
    pub fn plane(z: f64, rim: f64, radius: f64) -> Self {
        let line = [[rim, z, 1.0], [0.5 * (rim + radius), z, 1.0], [radius, z, 1.0]];
        Self { pole: z, curvature: 0.0, rim, fillet: (rim < radius).then_some(line) }
    }

    /// Radius of the projection of what has the radius `radius` on the surface.
    fn projected(&self, radius: f64) -> f64 {
        let sine = (self.curvature * radius).clamp(-1.0, 1.0);
        if sine == 0.0 { radius } else { 2.0 * (0.5 * sine.asin()).tan() / self.curvature }
    }

    /// The meridian from the axis outwards: 3 or 5 points.
    pub fn meridian(&self) -> Vec<Meridian> {
        let (w, k) = (self.projected(self.rim), self.curvature);
        let weight = (1.0 + 0.25 * (k * w).powi(2)).sqrt().recip();
        let end = self.pole + 0.5 * k * w * w * weight * weight;
        let mut points =
            vec![[0.0, self.pole, 1.0], [0.5 * w, self.pole, weight], [w * weight * weight, end, 1.0]];
        points.extend(self.fillet.iter().flat_map(|arc| &arc[1..]));
        points
    }

    /// Whether it ends along the jacket of a cylinder, without an edge.
    pub fn is_tangent_to_jacket(&self) -> bool {
        match self.fillet {
            // The last line of the arc's control points stands upright.
            Some([_, middle, end]) => middle[0] >= end[0],
            None => (self.curvature * self.rim).abs() >= 1.0 - 1e-12, // round-off of the product
        }
    }

    /// Height of the outermost point \[m\].
    pub fn outer_height(&self) -> f64 {
        self.meridian().last().map_or(self.pole, |p| p[1])
    }

    /// The net of a solid's cover; `division` is that of all covers of a body.
    pub fn net(&self, division: Division) -> CoverNet {
        match division {
            Division::Straight => self.plane_net(),
            Division::Projected => self.projected_net(),
        }
    }

    /// A plane cover by straight lines and quarters of circles.
    fn plane_net(&self) -> CoverNet {
        let half = SQUARE * self.rim;
        let at = |x: f64, y: f64| [x, y, self.pole, 1.0];
        let core = (0..9).map(|i| at(half * ((i % 3) as f64 - 1.0), half * ((i / 3) as f64 - 1.0))).collect();
        let ring = |turn: usize| {
            let circle = quarter(turn);
            let corner = circle[0][2];
            let mut net = Vec::with_capacity(15);
            for (t, arc) in circle.map(|p| p.map(|x| x / corner)).iter().enumerate() {
                let [x, y] = turned([half, half * (t as f64 - 1.0)], turn);
                let (inner, outer) = (at(x, y), revolved(&[self.rim, self.pole, 1.0], arc));
                let between = std::array::from_fn(|c| 0.5 * (inner[c] + outer[c]));
                net.extend([inner, between, outer]);
                net.extend(self.beyond().map(|p| revolved(p, arc)));
            }
            net
        };
        CoverNet { core, rings: [0, 1, 2, 3].map(ring) }
    }

    /// A plane or spherical cover by the projection. The factor by which both numbers are
    /// multiplied about the axis makes the weights on the edges of the square those of the arcs, so
    /// that the lines from its corners outwards are meridians.
    fn projected_net(&self) -> CoverNet {
        let (half, rim) = (self.projected(SQUARE * self.rim), self.projected(self.rim));
        let k = FRAC_PI_8.tan();
        let ends = [-1.0, 1.0];
        let linear = |size: [usize; 2], of: &dyn Fn(f64, f64) -> Complex| {
            let values = (0..size[0] * size[1]).map(|i| of(ends[i % size[0]], ends[i / size[0]]));
            Bernstein { size, values: values.collect() }
        };
        let factor = linear([2, 2], &|u, v| {
            let size = (1.0 + k * k).sqrt();
            multiplied([1.0, -k * u], [1.0 / size, -k * v / size])
        });
        let place = linear([2, 2], &|u, v| [half * u, half * v]);
        let core = self.mapped(&place.times(&factor), &factor.times(&Bernstein::one([2, 2])), rim);
        // Over `v` alone, along the edge of the square and along the circle.
        let below = linear([1, 2], &|_, v| [1.0, -k * v]);
        let edge = linear([1, 2], &|_, v| [half, half * v]).times(&below);
        let circle = linear([1, 2], &|_, v| [rim, rim * k * v]).times(&Bernstein::one([1, 2]));
        let below = below.times(&Bernstein::one([1, 2]));
        let ring = |turn: usize| {
            let above = edge.beside(&circle);
            let above =
                Bernstein { values: above.values.iter().map(|z| turned(*z, turn)).collect(), ..above };
            let inner = self.mapped(&above, &below.beside(&below), rim);
            let arcs = raised(&quarter(turn));
            let mut net = Vec::with_capacity(25);
            for (line, arc) in inner.chunks(3).zip(arcs) {
                net.extend(line);
                net.extend(self.beyond().map(|p| revolved(p, &arc)));
            }
            net
        };
        CoverNet { core, rings: [0, 1, 2, 3].map(ring) }
    }

    /// The points of the meridian beyond the rim.
    fn beyond(&self) -> impl Iterator<Item = &Meridian> {
        self.fillet.iter().flat_map(|arc| &arc[1..])
    }

    /// The control points of the surface over `z₀/z₁`, so scaled that the circle at the projected
    /// radius `rim` has the weights of [`quarter`].
    fn mapped(&self, above: &Bernstein, below: &Bernstein, rim: f64) -> Vec<Homogeneous> {
        let k = self.curvature;
        let scale = (1.0 + 0.25 * (k * rim).powi(2)).recip();
        let conjugate = [above, below].map(Bernstein::conjugate);
        let products = [above.times(&conjugate[1]), above.times(&conjugate[0]), below.times(&conjugate[1])];
        let point = |i: usize| {
            let [[x, y], [upper, _], [lower, _]] = [0, 1, 2].map(|p| products[p].values[i]);
            let weight = lower + 0.25 * k * k * upper;
            [x, y, self.pole * weight + 0.5 * k * upper, weight].map(|c| scale * c)
        };
        (0..products[0].values.len()).map(point).collect()
    }
}

/// A complex number: real part, imaginary part.
type Complex = [f64; 2];

fn multiplied(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// A complex polynomial of two parameters by its Bernstein coefficients, the first direction
/// fastest.
struct Bernstein {
    /// Number of coefficients in each direction, one more than the degree.
    size: [usize; 2],
    values: Vec<Complex>,
}

impl Bernstein {
    /// The number one.
    fn one(size: [usize; 2]) -> Self {
        Self { size, values: vec![[1.0, 0.0]; size[0] * size[1]] }
    }

    fn conjugate(&self) -> Self {
        Self { values: self.values.iter().map(|[x, y]| [*x, -y]).collect(), ..*self }
    }

    /// The polynomial that is linear in the first direction, between two that do not depend on it.
    fn beside(&self, other: &Self) -> Self {
        let values = self.values.iter().zip(&other.values).flat_map(|(a, b)| [*a, *b]).collect();
        Self { size: [2, self.size[1]], values }
    }

    fn times(&self, other: &Self) -> Self {
        let size = [0, 1].map(|d| self.size[d] + other.size[d] - 1);
        let mut values = vec![[0.0; 2]; size[0] * size[1]];
        for (i, a) in self.values.iter().enumerate() {
            for (j, b) in other.values.iter().enumerate() {
                let (of_a, of_b) =
                    ([i % self.size[0], i / self.size[0]], [j % other.size[0], j / other.size[0]]);
                let share = (0..2).map(|d| {
                    let (p, q) = (self.size[d] - 1, other.size[d] - 1);
                    choose(p, of_a[d]) * choose(q, of_b[d]) / choose(p + q, of_a[d] + of_b[d])
                });
                let share: f64 = share.product();
                let sum = &mut values[of_a[0] + of_b[0] + size[0] * (of_a[1] + of_b[1])];
                let [x, y] = multiplied(*a, *b);
                sum[0] += share * x;
                sum[1] += share * y;
            }
        }
        Self { size, values }
    }
}

/// Binomial coefficient.
fn choose(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

/// A quadratic curve with the control points of degree 4.
fn raised(points: &[[f64; 3]; 3]) -> [[f64; 3]; 5] {
    let line = |c: usize| Bernstein { size: [1, 3], values: points.iter().map(|p| [p[c], 0.0]).collect() };
    let [x, y, w] = [0, 1, 2].map(|c| line(c).times(&Bernstein::one([1, 3])).values);
    std::array::from_fn(|i| [x[i][0], y[i][0], w[i][0]])
}

/// `z` turned by so many quarters.
fn turned([x, y]: Complex, turn: usize) -> Complex {
    [[x, y], [-y, x], [-x, -y], [y, -x]][turn % 4]
}

/// The quarter of the unit circle about the direction at `turn` quarters from x: `[x, y, weight]`,
/// homogeneous.
pub fn quarter(turn: usize) -> [[f64; 3]; 3] {
    let k = FRAC_PI_8.tan();
    let point = |[x, y]: Complex, weight: f64| {
        let [x, y] = turned([x, y], turn);
        [x, y, weight]
    };
    let (c, w) = (1.0 - k * k, 1.0 + k * k);
    [point([c, -2.0 * k], w), point([w, 0.0], c), point([c, 2.0 * k], w)]
}

/// A point of a meridian swept along an arc.
pub fn revolved([r, z, weight]: &Meridian, [x, y, w]: &[f64; 3]) -> Homogeneous {
    [r * weight * x, r * weight * y, z * weight * w, weight * w]
}
