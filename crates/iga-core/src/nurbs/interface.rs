//! Faces of patches and which of them coincide: interfaces between patches and closed seams.

use super::Patch;
use super::jet::{diagonal, difference, norm};
use crate::tensor;

/// A face of a patch (an edge in two dimensions): one parameter held at an end of its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FaceId {
    /// Index of the patch.
    pub patch: usize,
    /// The direction whose parameter is fixed.
    pub direction: usize,
    /// Whether it is fixed at the upper end.
    pub upper: bool,
}

impl FaceId {
    /// All faces of all patches.
    pub fn all(patches: &[Patch]) -> Vec<Self> {
        let of_patch = |(patch, p): (usize, &Patch)| {
            (0..p.dimension())
                .flat_map(move |direction| [false, true].map(|upper| Self { patch, direction, upper }))
        };
        patches.iter().enumerate().flat_map(of_patch).collect()
    }

    /// The value of the fixed parameter.
    pub fn parameter(&self, patches: &[Patch]) -> f64 {
        let (lower, upper) = patches[self.patch].knots()[self.direction].domain();
        if self.upper { upper } else { lower }
    }

    /// The fixed parameter as a constraint on parametric points.
    pub fn fixed(&self, patches: &[Patch]) -> [Option<f64>; 3] {
        let mut fixed = [None; 3];
        fixed[self.direction] = Some(self.parameter(patches));
        fixed
    }

    /// The directions that run along the face: none, one or two of them.
    pub fn tangents(&self, dimension: usize) -> impl Iterator<Item = usize> + use<> {
        let direction = self.direction;
        (0..dimension).filter(move |&d| d != direction)
    }
}

/// The control net of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceNet {
    sizes: [usize; 2],
    points: Vec<[f64; 3]>,
    extent: f64,
}

/// Distance between control points that count as one, relative to the size of the patch.
pub const COINCIDENT: f64 = 1e-9;

impl FaceNet {
    /// The net of face `face`.
    pub fn new(patches: &[Patch], face: FaceId) -> Self {
        let patch = &patches[face.patch];
        let all = patch.net_size();
        let mut sizes = [1; 2];
        for (size, d) in sizes.iter_mut().zip(face.tangents(patch.dimension())) {
            *size = all[d];
        }
        let layer = if face.upper { all[face.direction] - 1 } else { 0 };
        let points = (0..patch.n_functions())
            .filter(|&i| tensor::multi_index(&all, i)[face.direction] == layer)
            .map(|i| patch.control_points()[i])
            .collect();
        Self { sizes, points, extent: diagonal(patch.control_points()) }
    }

    /// Control points, the first direction along the face running fastest \[m\].
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// Size of the patch that the face belongs to \[m\].
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// Whether the two nets agree point by point in one of the eight ways to lay one on the other.
    pub fn coincides(&self, other: &Self) -> bool {
        let [m, n] = self.sizes;
        let limit = COINCIDENT * self.extent;
        (0..8).any(|way| {
            let (swap, flip_i, flip_j) = (way & 1 == 1, way & 2 == 2, way & 4 == 4);
            if other.sizes != (if swap { [n, m] } else { [m, n] }) {
                return false;
            }
            self.points.iter().enumerate().all(|(flat, p)| {
                let i = if flip_i { m - 1 - flat % m } else { flat % m };
                let j = if flip_j { n - 1 - flat / m } else { flat / m };
                let partner = if swap { j + n * i } else { i + m * j };
                norm(&difference(p, &other.points[partner])) <= limit
            })
        })
    }
}
