//! The map of an element from its parameters to space.

use crate::element::kind::ElementKind;
use crate::element::shape::Functions;

/// Position of the point with the function values `values`.
pub fn position(values: &[f64], places: &[[f64; 3]]) -> [f64; 3] {
    let mut point = [0.0; 3];
    for (value, place) in values.iter().zip(places) {
        (0..3).for_each(|d| point[d] += value * place[d]);
    }
    point
}

/// Derivatives `∂x_i/∂ξ_j` from the slopes of the functions.
pub fn derivatives<const D: usize>(slopes: &[[f64; D]], places: &[[f64; 3]]) -> [[f64; D]; 3] {
    let mut map = [[0.0; D]; 3];
    for (slope, place) in slopes.iter().zip(places) {
        for (row, x) in map.iter_mut().zip(place) {
            row.iter_mut().zip(slope).for_each(|(entry, s)| *entry += x * s);
        }
    }
    map
}

/// Vector product.
pub fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Scalar product.
pub fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Difference `a - b`.
pub fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Length.
pub fn norm(a: &[f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Determinant of a map.
pub fn determinant(map: &[[f64; 3]; 3]) -> f64 {
    dot(&map[0], &cross(&map[1], &map[2]))
}

/// Inverse of a map with the determinant `determinant`.
pub fn inverse(map: &[[f64; 3]; 3], determinant: f64) -> [[f64; 3]; 3] {
    let cofactors = [cross(&map[1], &map[2]), cross(&map[2], &map[0]), cross(&map[0], &map[1])];
    std::array::from_fn(|i| std::array::from_fn(|j| cofactors[j][i] / determinant))
}

/// Derivatives of functions by the coordinates in space, from their slopes by parameters and the
/// inverse map.
pub fn gradient(slope: &[f64; 3], inverse: &[[f64; 3]; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|j| slope[j] * inverse[j][i]).sum())
}

/// Derivatives `∂x_i/∂ξ_j` of the map of an element of `kind`; of one in the plane with the identity
/// in the third direction.
pub fn element_map(kind: ElementKind, slopes: &[[f64; 3]], places: &[[f64; 3]]) -> [[f64; 3]; 3] {
    let mut map = derivatives(slopes, places);
    if kind.dimension() == 2 {
        map[2][2] = 1.0;
    }
    map
}

/// Position, determinant and gradients at one point of an element.
#[derive(Debug, Clone, Default)]
pub struct PointOf {
    /// Functions by parameters.
    pub functions: Functions<3>,
    /// Position \[m\].
    pub position: [f64; 3],
    /// Jacobian determinant \[m³, in the plane m²\].
    pub determinant: f64,
    /// Gradients of the functions in space [1/m]; no numbers where the determinant vanishes.
    pub gradients: Vec<[f64; 3]>,
}

impl PointOf {
    /// Evaluates everything at the parameters `xi` of an element with nodes at `places`.
    pub fn evaluate(&mut self, kind: ElementKind, places: &[[f64; 3]], xi: &[f64; 3]) {
        kind.functions(xi, &mut self.functions);
        let map = element_map(kind, &self.functions.slopes, places);
        self.position = position(&self.functions.values, places);
        self.determinant = determinant(&map);
        let inverse = inverse(&map, self.determinant);
        self.gradients.clear();
        self.gradients.extend(self.functions.slopes.iter().map(|s| gradient(s, &inverse)));
    }
}
