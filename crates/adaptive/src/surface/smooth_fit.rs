//! A smooth surface through the nodes around a place of a mesh (docs/theory.md Eq. C.74).

use nalgebra::{DMatrix, DVector, Vector3};

use crate::surface::primitive::{MISFIT, Primitive};
use crate::surface::{LocalShape, MeshSurface, SurfacePlace};

/// Functions of a polynomial of two variables of degree four.
const FUNCTIONS: usize = 15;
/// Those of them that are functions of the first variable, for a curve.
const OF_CURVE: &[usize] = &[0, 1, 3, 6, 10];
const ALL: &[usize] = &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14];
/// Nodes for each of them, at least.
const NODES: usize = 3;
/// Ratio of singular values below which nodes do not tell the functions apart.
const SINGULAR: f64 = 1e-10;

/// The surface of a part about a place of its mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct SmoothFit {
    /// Outward normal at the place.
    normal: Vector3<f64>,
    fitted: Fitted,
}

/// What goes through the nodes.
#[derive(Debug, Clone, PartialEq)]
enum Fitted {
    Primitive(Primitive),
    Heights(Heights),
}

/// Heights over a plane.
#[derive(Debug, Clone, PartialEq)]
struct Heights {
    centre: Vector3<f64>,
    shape: LocalShape,
    /// Unit of lengths \[m\].
    size: f64,
    /// Functions with their coefficients.
    terms: Vec<(usize, f64)>,
}

/// All products of powers up to degree four.
fn functions(u: f64, v: f64) -> [f64; FUNCTIONS] {
    let (u2, v2) = (u * u, v * v);
    [
        1.0,
        u,
        v,
        u2,
        u * v,
        v2,
        u2 * u,
        u2 * v,
        u * v2,
        v2 * v,
        u2 * u2,
        u2 * u * v,
        u2 * v2,
        u * v2 * v,
        v2 * v2,
    ]
}

impl SmoothFit {
    /// The surface through the nodes around `site`, where the surface has the shape `shape`: of a
    /// simple shape if those of all sides that are smoothly connected with it and have a place that `is_within` lie on one, else one
    /// near it, which has to reach to the distance `reach`, else a simple one through the sides alone that have such a place, as of a
    /// fillet beside a face. None if no smooth one goes through them.
    pub fn new(
        surface: &MeshSurface,
        (site, shape): (&SurfacePlace, &LocalShape),
        reach: f64,
        is_within: impl Fn(&[f64; 3]) -> bool,
    ) -> Option<Self> {
        let wide = surface.primitive(&surface.sides_within(site.face, &is_within));
        let heights = || Heights::new(surface, site, shape, reach).map(Fitted::Heights);
        let narrow = || surface.primitive_within(site.face, &is_within).map(Fitted::Primitive);
        let fitted = wide.map(Fitted::Primitive).or_else(heights).or_else(narrow)?;
        Some(Self { normal: shape.normal, fitted })
    }

    /// Outward normal at its centre.
    pub fn normal(&self) -> Vector3<f64> {
        self.normal
    }

    /// Height of the surface over `x`, towards the outside \[m\].
    pub fn above(&self, x: &[f64; 3]) -> f64 {
        match &self.fitted {
            Fitted::Primitive(of) => -of.height(&Vector3::from(*x)).0,
            Fitted::Heights(of) => of.above(x),
        }
    }

    /// The place of the surface over `x` \[m\].
    pub fn onto(&self, x: &[f64; 3]) -> Vector3<f64> {
        let from = Vector3::from(*x);
        match &self.fitted {
            Fitted::Primitive(of) => of.onto(&from),
            Fitted::Heights(of) => from + of.above(x) * self.normal,
        }
    }
}

impl Heights {
    fn new(surface: &MeshSurface, site: &SurfacePlace, shape: &LocalShape, reach: f64) -> Option<Self> {
        let centre = Vector3::from(site.point);
        // Rings end where edges do: the nearest nodes of more of them lie on a disc.
        let terms = if surface.mesh().model().dimension() == 2 { OF_CURVE } else { ALL };
        let mut places = surface.around(site, 2 * NODES * terms.len());
        places.sort_by(|a, b| (a - centre).norm_squared().total_cmp(&(b - centre).norm_squared()));
        places.truncate(NODES * terms.len());
        let size = places.iter().map(|x| (x - centre).norm()).fold(0.0, f64::max);
        if places.len() < NODES * terms.len() || size < reach {
            return None;
        }
        let mut fit = Self { centre, shape: *shape, size, terms: Vec::new() };
        // Zero beyond the farthest node, without a jump.
        let weight = |x: &Vector3<f64>| (1.0 - (x - centre).norm_squared() / (1.1 * size * size)).powi(2);
        let rows: Vec<([f64; FUNCTIONS], f64, f64)> = places
            .iter()
            .map(|x| {
                let [u, v, z] = fit.local(x);
                (functions(u, v), z, weight(x))
            })
            .collect();
        let matrix = DMatrix::from_fn(rows.len(), terms.len(), |i, j| rows[i].2 * rows[i].0[terms[j]]);
        let heights = DVector::from_fn(rows.len(), |i, _| rows[i].2 * rows[i].1);
        let svd = matrix.clone().svd(true, true);
        let [least, most] = [svd.singular_values.min(), svd.singular_values.max()];
        if least <= SINGULAR * most {
            return None;
        }
        let found = svd.solve(&heights, 0.0).ok()?;
        let misfit = (&matrix * &found - &heights).norm();
        fit.terms = terms.iter().copied().zip(found.iter().copied()).collect();
        (misfit <= MISFIT * heights.norm()).then_some(fit)
    }

    /// Coordinates of `x` in units of the size.
    fn local(&self, x: &Vector3<f64>) -> [f64; 3] {
        let from = (x - self.centre) / self.size;
        let [s, t] = self.shape.tangents;
        [from.dot(&s), from.dot(&t), from.dot(&self.shape.normal)]
    }

    /// Height of the surface over `x`, along the normal at its centre \[m\].
    fn above(&self, x: &[f64; 3]) -> f64 {
        let [u, v, z] = self.local(&Vector3::from(*x));
        let functions = functions(u, v);
        let height: f64 = self.terms.iter().map(|(k, c)| functions[*k] * c).sum();
        self.size * (height - z)
    }
}
