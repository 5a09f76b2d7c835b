//! What the parts of a search between two bodies share: buffers, the two bodies in one frame, pairs
//! of points.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use super::boxes::Placement;
use super::deformed::{Deformed, Side, Site};
use super::surface_model::SurfaceModel;

/// Largest distance \[m\] of two axes, or of two planes, that count as one.
const APART: f64 = 1e-9;

/// The way between the positions `first` and `second` of bodies of models with `motion`, along what
/// they share: the axis of axisymmetric models, the plane of plane ones, space \[m\]. What is left
/// out is round-off.
///
/// # Errors
/// A text if they share no axis or no plane.
pub fn way_between(motion: RigidMotion, [first, second]: [&Vector3<f64>; 2]) -> Result<Vector3<f64>, String> {
    let way = second - first;
    let (within, places) = match motion {
        RigidMotion::Axial => {
            (Vector3::new(0.0, 0.0, way.z), "axisymmetric bodies in contact have axes, in x and y,")
        }
        RigidMotion::Planar => {
            (Vector3::new(way.x, way.y, 0.0), "bodies of plane models in contact have planes, in z,")
        }
        RigidMotion::Spatial => return Ok(way),
    };
    let distance = (way - within).norm();
    // Asked this way round, a NaN fails.
    if distance <= APART {
        Ok(within)
    } else {
        Err(format!("{places} {distance:.3e} m apart, they must share one"))
    }
}

/// The second body's frame in the first one's.
///
/// # Errors
/// Those of [`way_between`].
pub(super) fn in_first_frame(motion: RigidMotion, states: [&BodyState; 2]) -> Result<Placement, String> {
    let back = states[0].rotation.inverse();
    let rotation = (back * states[1].rotation).to_rotation_matrix().into_inner();
    Ok(Placement::new(rotation, back * way_between(motion, states.map(|state| &state.position))?))
}

/// Work of the last search.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SearchReport {
    /// Pairs of boxes compared.
    pub n_boxes: usize,
    /// Newton searches on pairs of pieces.
    pub n_newton: usize,
    /// Whether the last answer was at hand.
    pub is_warm: bool,
}

/// Buffers of a search between two bodies, and where it ended last.
#[derive(Debug, Clone, Default)]
pub struct SearchWorkspace {
    pub(super) deformed: [Deformed; 2],
    pub(super) pairs: Vec<(f64, u32, u32)>,
    pub(super) stack: Vec<(f64, u32)>,
    pub(super) marks: [Vec<bool>; 2],
    pub(super) chosen: Vec<u32>,
    pub(super) last: Option<[Site; 2]>,
    pub(super) report: SearchReport,
}

impl SearchWorkspace {
    /// Empty buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets where the last search ended; needed when a body's surface model is exchanged.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Empties the buffers and makes them large enough for any search, so that later ones do not
    /// allocate.
    pub(super) fn begin(&mut self, models: [&SurfaceModel; 2]) {
        /// Depth-first descents hold one entry per level: two trees of less than 2^64 pieces,
        /// halved at each level.
        const DEPTH: usize = 130;
        for (deformed, model) in self.deformed.iter_mut().zip(models) {
            deformed.begin(model);
        }
        self.pairs.clear();
        self.pairs.reserve(DEPTH);
        self.stack.clear();
        self.stack.reserve(DEPTH);
        let n_pieces = models.map(SurfaceModel::n_pieces);
        self.chosen.clear();
        self.chosen.reserve(n_pieces[0].max(n_pieces[1]));
        for (marks, n) in self.marks.iter_mut().zip(n_pieces) {
            marks.clear();
            marks.reserve(n);
        }
    }

    /// Makes sure that a piece of each body is there.
    pub(super) fn load(&mut self, query: &Query<'_>, pieces: [u32; 2]) {
        for ((deformed, side), piece) in self.deformed.iter_mut().zip(&query.sides).zip(pieces) {
            deformed.load(side, piece);
        }
    }

    /// Where the last search ended.
    pub fn last(&self) -> Option<[Site; 2]> {
        self.last
    }

    /// Has the next search begin where one between the same surfaces ended: buffers serve any two, one pair after the other.
    pub fn begin_at(&mut self, last: Option<[Site; 2]>) {
        self.last = last;
    }

    /// Work of the last search.
    pub fn report(&self) -> SearchReport {
        self.report
    }
}

/// A search between two bodies, both placed in the frame of the first.
pub(super) struct Query<'a> {
    pub sides: [Side<'a>; 2],
    pub placement: &'a Placement,
    /// Differences of length that round-off may make \[m\].
    pub resolution: f64,
}

impl<'a> Query<'a> {
    pub fn new(models: [&'a SurfaceModel; 2], states: &[&'a BodyState; 2], placement: &'a Placement) -> Self {
        let sides = [0, 1].map(|b| Side {
            model: models[b],
            elastic: &states[b].elastic,
            placement: (b == 1).then_some(placement),
            inflation: models[b].displacement_bound(&states[b].elastic),
        });
        let mut query = Self { sides, placement, resolution: 0.0 };
        // Round-off of sums of coordinates of this size.
        query.resolution = 64.0 * f64::EPSILON * query.size();
        query
    }

    /// Size of both bodies together \[m\].
    pub fn size(&self) -> f64 {
        self.sides[0].model.size() + self.sides[1].model.size()
    }
}

/// A pair of surface points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    pub sites: [Site; 2],
    /// Positions in the frame of the search.
    pub points: [Vector3<f64>; 2],
    /// Unit vector from the second to the first, if they are apart.
    pub direction: Option<Vector3<f64>>,
    pub distance: f64,
}

/// How far the control points of two pieces are apart along a unit vector: no pair of surface
/// points is nearer.
pub(super) fn separation(points: [&[Vector3<f64>]; 2], n: &Vector3<f64>) -> f64 {
    let lowest = points[0].iter().map(|p| n.dot(p)).fold(f64::INFINITY, f64::min);
    let highest = points[1].iter().map(|p| n.dot(p)).fold(f64::NEG_INFINITY, f64::max);
    lowest - highest
}
