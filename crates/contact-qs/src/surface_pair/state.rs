//! State, workspace and findings of a surface pair.

use super::contact_jacobian::ContactJacobian;
use super::friction::PairFriction;
use super::projection::proximity_cache::ProximityCache;
use super::projection::warm_start::WarmStart;
use super::projection::{Functions, Projection, Samples, SurfacePlace};
use super::search::SearchBuffers;
use super::solver::PairZone;
use super::target::TargetSurface;
use crate::contact_element::ContactReport;
use crate::quasistatic::PointState;

/// State of a surface pair: where evaluations start, the solvers' sets, the history of every point.
pub struct PairState {
    pub(super) start: WarmStart,
    pub(super) saved: WarmStart,
    pub(super) zone: Option<PairZone>,
    pub(super) friction: Option<Box<PairFriction>>,
}

impl PairState {
    /// Before the first evaluation of `n` points with `nc` components each on a target with
    /// `n_nodes` nodes, any point of which moves by `spread` times what a node moves at most.
    pub(super) fn new(
        n: usize,
        nc: usize,
        (n_nodes, spread): (usize, f64),
        zone: Option<PairZone>,
        friction: Option<Box<PairFriction>>,
    ) -> Self {
        let start = WarmStart {
            forces: vec![0.0; n],
            deflections: vec![0.0; n],
            body: vec![0.0; n * nc],
            nodes: vec![0.0; n_nodes * nc],
            places: vec![SurfacePlace::default(); n],
            is_known: false,
            proximity: ProximityCache::new(n, n_nodes, spread),
        };
        Self { saved: start.clone(), start, zone, friction }
    }

    /// Forgets the last evaluation.
    pub(super) fn forget_evaluation(&mut self) {
        if let Some(friction) = &mut self.friction {
            friction.is_evaluated = false;
            friction.clear_forces();
        }
        self.start.is_known = false;
        self.start.forces.fill(0.0);
        self.start.deflections.fill(0.0);
        self.start.body.fill(0.0);
        self.start.nodes.fill(0.0);
    }

    /// Gaps of the last evaluation, quasistatic displacements included; of points beyond an end of
    /// the target the distance from it; of points that are open for certain as found at an earlier
    /// evaluation \[m\].
    pub fn gaps(&self) -> &[f64] {
        &self.start.proximity.gaps
    }

    /// Places of the points' projections on the target in the last evaluation.
    pub fn places(&self) -> &[SurfacePlace] {
        &self.start.places
    }

    /// Tangential point forces of the last evaluation, one (plane models, axisymmetric ones) or two
    /// per point; empty without friction \[N\].
    pub fn tangential_forces(&self) -> &[f64] {
        self.friction.as_ref().map_or(&[], |f| f.stick_slip.forces())
    }

    /// States of the points in the last evaluation, where they carry force; empty without friction.
    pub fn point_states(&self) -> &[PointState] {
        self.friction.as_ref().map_or(&[], |f| f.stick_slip.states())
    }
}

/// Buffers of a surface pair.
pub struct PairWorkspace {
    pub(super) buffers: Buffers,
    pub(super) search: SearchBuffers,
}

/// Buffers of projections and solutions.
pub(super) struct Buffers {
    pub functions: Functions,
    pub samples: Samples,
    /// Continuous normals at the target's nodes; none of splines.
    pub normals: Vec<[f64; 3]>,
    /// Points of the contact body and nodes of the target without quasistatic displacement, in
    /// their frames.
    pub low_points: Vec<[f64; 3]>,
    pub low_nodes: Vec<[f64; 3]>,
    /// Rows of the last loads.
    pub loaded: ContactJacobian,
    pub free_gaps: Vec<f64>,
    pub rates: RateBuffers,
}

/// Rates of the points along normals and tangents, of the forces there, and of their components on both bodies.
pub(super) struct RateBuffers {
    pub along: [Vec<f64>; 2],
    pub normal: Vec<f64>,
    pub tangential: Vec<f64>,
    pub loads: Vec<f64>,
    pub node_loads: Vec<f64>,
}

impl PairWorkspace {
    pub(super) fn new(surface: &TargetSurface, n: usize, n_t: usize) -> Self {
        let nc = surface.motion.n_components();
        let buffers = Buffers {
            functions: Functions::new(surface),
            samples: Samples::new(surface),
            normals: vec![[0.0; 3]; surface.n_normals()],
            low_points: vec![[0.0; 3]; n],
            low_nodes: vec![[0.0; 3]; surface.nodes.len()],
            loaded: ContactJacobian::new(n, surface.n_functions, n_t),
            free_gaps: vec![0.0; n],
            rates: RateBuffers {
                along: [vec![0.0; n], vec![0.0; n * n_t]],
                normal: vec![0.0; n],
                tangential: vec![0.0; n * n_t],
                loads: vec![0.0; n * nc],
                node_loads: vec![0.0; surface.nodes.len() * nc],
            },
        };
        Self { buffers, search: SearchBuffers::new(surface, n) }
    }
}

/// Results of an evaluation of a surface pair.
pub struct PairFound {
    /// Points of the contact body with quasistatic displacement, in its frame.
    pub(super) points: Vec<[f64; 3]>,
    /// Nodes of the target with quasistatic displacement.
    pub(super) nodes: Vec<[f64; 3]>,
    /// Displaced points in the target's frame.
    pub(super) points_in_target: Vec<[f64; 3]>,
    /// Points that were projected.
    pub(super) is_wanted: Vec<bool>,
    pub(super) projections: Vec<Projection>,
    pub(super) jacobian: ContactJacobian,
    /// Forces on the contact body's points, components in turn.
    pub(super) loads: Vec<f64>,
    /// Forces on the target's nodes.
    pub(super) node_loads: Vec<f64>,
    /// Forces on the target's interface degrees of freedom and their displacements.
    pub(super) interface_loads: Vec<f64>,
    pub(super) interface_displacements: Vec<f64>,
    /// Whether the state knows the places of the projections.
    pub(super) is_known: bool,
    /// Solutions that it took.
    pub(super) n_passes: usize,
    pub(super) report: ContactReport,
}

impl PairFound {
    pub(super) fn new(surface: &TargetSurface, n: usize, n_t: usize) -> Self {
        let (nc, n_nodes) = (surface.motion.n_components(), surface.nodes.len());
        Self {
            points: vec![[0.0; 3]; n],
            nodes: vec![[0.0; 3]; n_nodes],
            points_in_target: vec![[0.0; 3]; n],
            is_wanted: vec![true; n],
            projections: vec![Projection::default(); n],
            jacobian: ContactJacobian::new(n, surface.n_functions, n_t),
            loads: vec![0.0; n * nc],
            node_loads: vec![0.0; n_nodes * nc],
            interface_loads: vec![0.0; surface.n_interface()],
            interface_displacements: vec![0.0; surface.n_interface()],
            is_known: false,
            n_passes: 0,
            report: ContactReport::default(),
        }
    }

    /// Solutions that the evaluation took until projection and deformation met.
    pub fn n_passes(&self) -> usize {
        self.n_passes
    }
}

/// All that one evaluation writes to.
pub(super) struct Work<'a> {
    pub state: &'a mut PairState,
    pub buffers: &'a mut Buffers,
    pub found: &'a mut PairFound,
}
