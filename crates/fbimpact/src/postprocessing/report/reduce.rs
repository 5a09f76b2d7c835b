//! Fewer shapes for the motion of a body: the proper orthogonal decomposition of what was stored,
//! in the norm of displacement and stress.

use faer::{Mat, MatRef};
use iga_core::elasticity::kinematics::von_mises;
use nalgebra::{DMatrix, SymmetricEigen};

/// Instants that are looked at in one go; bounds the memory.
const CHUNK: usize = 64;
/// Part of the largest eigenvalue below which a combination of shapes is none.
const NOTHING: f64 = 1e-12;

/// Shapes of a body with the coordinates that they are combined by.
#[derive(Debug, Clone)]
pub struct Shapes {
    /// Displacement of the vertices, three rows each, a column a shape.
    pub displacement: Mat<f64>,
    /// Stress, six rows a vertex; no rows where it is left out.
    pub stress: Mat<f64>,
    /// Coordinates, one column for each instant.
    pub coordinates: Mat<f64>,
    /// Their rates.
    pub rates: Mat<f64>,
}

/// Sizes of the fields of a body, or of errors of them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sizes {
    /// Displacement \[m\].
    pub displacement: f64,
    /// Rate of the displacement [m/s].
    pub rate: f64,
    /// Von Mises stress \[Pa\].
    pub von_mises: f64,
}

impl Sizes {
    /// The largest part of `whole` that one of them is; what is zero has none.
    pub fn part_of(&self, whole: &Self) -> f64 {
        let part = |error: f64, size: f64| if size > 0.0 { error / size } else { 0.0 };
        part(self.displacement, whole.displacement)
            .max(part(self.rate, whole.rate))
            .max(part(self.von_mises, whole.von_mises))
    }

    fn max(self, other: Self) -> Self {
        Self {
            displacement: self.displacement.max(other.displacement),
            rate: self.rate.max(other.rate),
            von_mises: self.von_mises.max(other.von_mises),
        }
    }
}

impl Shapes {
    /// Number of instants.
    pub fn n_instants(&self) -> usize {
        self.coordinates.ncols()
    }

    /// Largest values of the fields.
    pub fn sizes(&self) -> Sizes {
        self.scan(None)
    }

    /// Largest differences of the fields from those of `exact`.
    pub fn deviation(&self, exact: &Self) -> Sizes {
        self.scan(Some(exact))
    }

    fn scan(&self, exact: Option<&Self>) -> Sizes {
        let n = self.n_instants();
        let mut found = Sizes::default();
        for start in (0..n).step_by(CHUNK) {
            let width = CHUNK.min(n - start);
            let product = |of: &Self, shapes: &Mat<f64>, by: &Mat<f64>| -> Mat<f64> {
                let columns: MatRef<'_, f64> = by.as_ref().subcols(start, width);
                if shapes.nrows() == 0 || of.displacement.ncols() == 0 {
                    return Mat::zeros(shapes.nrows(), width);
                }
                shapes * columns
            };
            let mut displacement = product(self, &self.displacement, &self.coordinates);
            let mut rate = product(self, &self.displacement, &self.rates);
            let mut stress = scalars(&product(self, &self.stress, &self.coordinates));
            if let Some(exact) = exact {
                displacement -= product(exact, &exact.displacement, &exact.coordinates);
                rate -= product(exact, &exact.displacement, &exact.rates);
                let wanted = scalars(&product(exact, &exact.stress, &exact.coordinates));
                stress.iter_mut().zip(&wanted).for_each(|(a, b)| *a -= b);
            }
            found = found.max(Sizes {
                displacement: longest(&displacement),
                rate: longest(&rate),
                von_mises: stress.iter().fold(0.0, |most, s| s.abs().max(most)),
            });
        }
        found
    }

    /// The best combinations of the shapes for the stored motion, the most important first: as many
    /// as there are shapes with an effect. `speed` is the largest of the body [m/s], which errors
    /// of the rate are compared with.
    pub fn ordered(&self, sizes: &Sizes, speed: f64) -> Self {
        let r = self.displacement.ncols();
        let by = |shapes: &Mat<f64>, size: f64| {
            let gram = shapes.transpose() * shapes;
            DMatrix::from_fn(r, r, |i, j| if size > 0.0 { gram[(i, j)] / (size * size) } else { 0.0 })
        };
        let metric = by(&self.displacement, sizes.displacement) + by(&self.stress, sizes.von_mises);
        let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(metric);
        let least = NOTHING * eigenvalues.iter().fold(0.0_f64, |most, x| most.max(*x));
        let root = |power: f64| {
            let scaled = eigenvalues.map(|x| if x > least { x.powf(power) } else { 0.0 });
            &eigenvectors * DMatrix::from_diagonal(&scaled) * eigenvectors.transpose()
        };
        let (forward, back) = (root(0.5), root(-0.5));
        let dense = |m: &Mat<f64>| DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)]);
        let (q, v) = (&forward * dense(&self.coordinates), &forward * dense(&self.rates));
        let weight = if speed > 0.0 { sizes.displacement / speed } else { 0.0 };
        let snapshots = &q * q.transpose() + &v * v.transpose() * (weight * weight);
        let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(snapshots);
        let mut order: Vec<usize> = (0..r).collect();
        order.sort_by(|a, b| eigenvalues[*b].total_cmp(&eigenvalues[*a]));
        let turned = DMatrix::from_fn(r, r, |i, j| eigenvectors[(i, order[j])]);
        let combinations = back * &turned;
        let combinations = Mat::from_fn(r, r, |i, j| combinations[(i, j)]);
        let (q, v) = (turned.transpose() * q, turned.transpose() * v);
        let sparse = |m: &DMatrix<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)]);
        Self {
            displacement: &self.displacement * &combinations,
            stress: &self.stress * &combinations,
            coordinates: sparse(&q),
            rates: sparse(&v),
        }
    }

    /// The same shapes at every `step`-th instant.
    pub fn every(&self, step: usize) -> Self {
        let n = self.n_instants().div_ceil(step.max(1));
        let columns = |m: &Mat<f64>| Mat::from_fn(m.nrows(), n, |i, j| m[(i, j * step)]);
        let (coordinates, rates) = (columns(&self.coordinates), columns(&self.rates));
        Self { coordinates, rates, ..self.clone() }
    }

    /// The first `k` shapes.
    pub fn first(&self, k: usize) -> Self {
        let rows = |m: &Mat<f64>| m.as_ref().subrows(0, k).to_owned();
        let columns = |m: &Mat<f64>| m.as_ref().subcols(0, k).to_owned();
        Self {
            displacement: columns(&self.displacement),
            stress: columns(&self.stress),
            coordinates: rows(&self.coordinates),
            rates: rows(&self.rates),
        }
    }
}

/// Von Mises stress of every column of stresses.
fn scalars(stress: &Mat<f64>) -> Vec<f64> {
    let of_column = |j: usize| {
        let column = stress.col(j);
        (0..stress.nrows() / 6).map(move |v| von_mises(&std::array::from_fn(|c| column[6 * v + c])))
    };
    (0..stress.ncols()).flat_map(of_column).collect()
}

/// Length of the longest vector, three rows each.
fn longest(vectors: &Mat<f64>) -> f64 {
    let mut most = 0.0_f64;
    for j in 0..vectors.ncols() {
        let column = vectors.col(j);
        for v in 0..vectors.nrows() / 3 {
            let square: f64 = (0..3).map(|c| column[3 * v + c] * column[3 * v + c]).sum();
            most = most.max(square);
        }
    }
    most.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_of_two_shapes_needs_two_of_five() {
        let wave = |i: usize, j: usize| ((i + 1) as f64 * 0.7 * (j + 1) as f64).sin();
        let displacement = Mat::from_fn(30, 5, wave);
        let stress = Mat::from_fn(60, 5, |i, j| 1e9 * wave(i + 3, j));
        // All coordinates move along two directions.
        let along =
            |i: usize, t: usize| wave(i, 1) * (t as f64 * 0.1).sin() + wave(i, 4) * (t as f64 * 0.33).cos();
        let coordinates = Mat::from_fn(5, 150, along);
        let rates = Mat::from_fn(5, 150, |i, t| 1e3 * along(i, t + 7));
        let all = Shapes { displacement, stress, coordinates, rates };
        let sizes = all.sizes();
        let ordered = all.ordered(&sizes, sizes.rate);
        assert!(ordered.first(1).deviation(&all).part_of(&sizes) > 1e-2);
        // Round-off of the roots of the metric.
        assert!(ordered.first(2).deviation(&all).part_of(&sizes) < 1e-9);
    }
}
