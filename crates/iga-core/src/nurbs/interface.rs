//! Faces of patches and which of them coincide: interfaces between patches and closed seams.

pub mod linked;

use super::Patch;
use super::jet::{diagonal, difference, norm};
use crate::splines::tensor;

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

    /// Number of control points along each of the directions of the face, rising; 1 for one that it
    /// does not have.
    pub fn sizes(&self) -> [usize; 2] {
        self.sizes
    }

    /// The way to lay the net on `other` so that no point is farther than `limit` \[m\] from its
    /// partner.
    pub fn way_onto(&self, other: &Self, limit: f64) -> Option<Way> {
        Way::all().find(|way| {
            way.sizes(self.sizes) == other.sizes
                && self.points.iter().enumerate().all(|(flat, p)| {
                    norm(&difference(p, &other.points[way.partner(self.sizes, flat)])) <= limit
                })
        })
    }

    /// Mean of the control points \[m\].
    fn centroid(&self) -> [f64; 3] {
        let sum = self.points.iter().fold([0.0; 3], |s, p| [0, 1, 2].map(|c| s[c] + p[c]));
        sum.map(|x| x / self.points.len() as f64)
    }
}

/// One of the eight ways to lay the net of a face on that of another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Way {
    /// Whether the first direction along the one face runs along the second of the other.
    pub swap: bool,
    /// Whether the first and second direction along the one face run backwards along the other.
    pub flip: [bool; 2],
}

impl Way {
    /// All of them, the plainest first.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..8).map(|way| Self { swap: way & 1 == 1, flip: [way & 2 == 2, way & 4 == 4] })
    }

    /// Sizes of the net on which one of the sizes `[m, n]` can be laid.
    pub fn sizes(self, [m, n]: [usize; 2]) -> [usize; 2] {
        if self.swap { [n, m] } else { [m, n] }
    }

    /// Index in the other net of the entry `flat` of a net with the sizes `[m, n]`.
    pub fn partner(self, [m, n]: [usize; 2], flat: usize) -> usize {
        let i = if self.flip[0] { m - 1 - flat % m } else { flat % m };
        let j = if self.flip[1] { n - 1 - flat / m } else { flat / m };
        if self.swap { j + n * i } else { i + m * j }
    }

    /// The direction along the other face, 0 or 1, of direction `along` of the one, and whether it
    /// runs backwards.
    pub fn direction(self, along: usize) -> (usize, bool) {
        (if self.swap { 1 - along } else { along }, self.flip[along])
    }
}

/// Pairs of faces, as indices into `nets`, whose control points agree within `share` of the smaller
/// of their patches, and how the first lies on the second. Sorting keeps the work linear in the
/// number of faces of a body whose parts lie apart.
pub fn coinciding_pairs(nets: &[FaceNet], share: f64) -> Vec<(usize, usize, Way)> {
    let centroids: Vec<[f64; 3]> = nets.iter().map(FaceNet::centroid).collect();
    let mut order: Vec<usize> = (0..nets.len()).collect();
    order.sort_by(|&a, &b| centroids[a][0].total_cmp(&centroids[b][0]).then(a.cmp(&b)));
    let mut pairs = Vec::new();
    for (place, &a) in order.iter().enumerate() {
        let reach = share * nets[a].extent;
        for &b in order[place + 1..].iter().take_while(|&&b| centroids[b][0] - centroids[a][0] <= reach) {
            let limit = share * nets[a].extent.min(nets[b].extent);
            let (first, second) = (a.min(b), a.max(b));
            let apart = norm(&difference(&centroids[a], &centroids[b]));
            // The mean of points moves no more than they do; a little for round-off of the sums.
            if apart <= 2.0 * limit
                && let Some(way) = nets[first].way_onto(&nets[second], limit)
            {
                pairs.push((first, second, way));
            }
        }
    }
    pairs.sort_by_key(|&(a, b, _)| (a, b));
    pairs
}
