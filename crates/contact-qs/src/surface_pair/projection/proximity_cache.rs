//! Which points need to be projected: not those that are open for certain (docs/theory.md
//! Eq. C.46).

use iga_core::nurbs::jet::{difference, norm};

/// More points than these beside those near make it worthwhile to project all of them.
const FEW: usize = 16;

/// Distances as they were last found, with what is needed to bound how they have changed since.
///
/// The distance of a point from a surface changes by no more than the point moves, and by no more
/// than the surface moves anywhere: its points are mean values of its nodes, or of a mesh
/// combinations with weights whose absolute values have the sum `spread` at most. So a point that
/// was `g` away is open as long as `g > |x - x₀| + max_A |y_A - y_A⁰|`.
#[derive(Debug, Clone)]
pub(in crate::surface_pair) struct ProximityCache {
    /// Gaps as last found \[m\].
    pub gaps: Vec<f64>,
    /// Where the points were then, in the target's frame.
    places: Vec<[f64; 3]>,
    /// How far the nodes were from `nodes` then; infinite where the bound does not hold.
    shifts: Vec<f64>,
    /// Nodes at the last projection of all points.
    nodes: Vec<[f64; 3]>,
    /// Bound of the displacement of a point of the surface over the largest one of a node.
    spread: f64,
}

impl ProximityCache {
    pub fn new(n_points: usize, n_nodes: usize, spread: f64) -> Self {
        Self {
            gaps: vec![0.0; n_points],
            places: vec![[0.0; 3]; n_points],
            shifts: vec![f64::INFINITY; n_points],
            nodes: vec![[0.0; 3]; n_nodes],
            spread,
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.gaps.copy_from_slice(&other.gaps);
        self.places.copy_from_slice(&other.places);
        self.shifts.copy_from_slice(&other.shifts);
        self.nodes.copy_from_slice(&other.nodes);
    }

    /// Marks the points that may be nearer than `margin` at `points` and `nodes`, all of them if
    /// there is none; returns how far the nodes have moved.
    pub fn choose(
        &mut self,
        points: &[[f64; 3]],
        nodes: &[[f64; 3]],
        forces: &[f64],
        margin: Option<f64>,
        is_wanted: &mut [bool],
    ) -> f64 {
        if let Some(margin) = margin {
            let shift = self.shift(nodes);
            let (mut n_near, mut n_wanted) = (0, 0);
            for (i, wanted) in is_wanted.iter_mut().enumerate() {
                let is_near = forces[i] > 0.0 || self.gaps[i] <= margin;
                let least =
                    self.gaps[i] - norm(&difference(&points[i], &self.places[i])) - self.shifts[i] - shift;
                // Asked this way round, a NaN is projected.
                let is_open = least > margin;
                *wanted = is_near || !is_open;
                n_near += usize::from(is_near);
                n_wanted += usize::from(*wanted);
            }
            if n_wanted <= 2 * n_near + FEW && shift.is_finite() {
                return shift;
            }
        }
        is_wanted.fill(true);
        self.nodes.copy_from_slice(nodes);
        0.0
    }

    /// How far the surface may be from where it was at the last projection of all points; infinite
    /// if a place is not a number \[m\].
    pub fn shift(&self, nodes: &[[f64; 3]]) -> f64 {
        let mut largest = 0.0_f64;
        for (a, b) in nodes.iter().zip(&self.nodes) {
            let moved = square(a, b);
            if moved.is_nan() {
                return f64::INFINITY;
            }
            largest = largest.max(moved);
        }
        self.spread * largest.sqrt()
    }

    /// How far `place` is from where point `i` was last seen \[m\].
    pub fn moved(&self, i: usize, place: &[f64; 3]) -> f64 {
        norm(&difference(place, &self.places[i]))
    }

    /// Lower bound of the gap of point `i` at `place`, the nodes being `shift` away from those of
    /// the last projection of all points (Eq. C.46) \[m\].
    pub fn least_gap(&self, i: usize, place: &[f64; 3], shift: f64) -> f64 {
        self.gaps[i] - self.moved(i, place) - self.shifts[i] - shift
    }

    /// Notes the gap of point `i` at `place`, the nodes being `shift` away from those of the last
    /// projection of all points.
    pub fn note(&mut self, i: usize, place: &[f64; 3], gap: f64, shift: f64) {
        self.gaps[i] = gap;
        self.places[i] = *place;
        self.shifts[i] = shift;
    }
}

/// Square of the distance of two places.
#[inline]
pub(super) fn square(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
