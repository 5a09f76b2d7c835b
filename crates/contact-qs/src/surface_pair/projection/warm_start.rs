//! Where the evaluations of a surface pair start.

use super::SurfacePlace;
use super::proximity_cache::ProximityCache;

/// Results of an evaluation from which the next one starts its iterations.
#[derive(Debug, Clone)]
pub(in crate::surface_pair) struct WarmStart {
    pub forces: Vec<f64>,
    /// Displacements of the points relative to the target along their normals under these forces, by the compliance in use.
    pub deflections: Vec<f64>,
    /// Quasistatic displacements of the contact body's points, components in turn.
    pub body: Vec<f64>,
    /// Quasistatic displacements of the target's nodes.
    pub nodes: Vec<f64>,
    pub places: Vec<SurfacePlace>,
    /// Whether places are known.
    pub is_known: bool,
    pub proximity: ProximityCache,
}

impl WarmStart {
    pub fn copy_from(&mut self, other: &Self) {
        self.forces.copy_from_slice(&other.forces);
        self.deflections.copy_from_slice(&other.deflections);
        self.body.copy_from_slice(&other.body);
        self.nodes.copy_from_slice(&other.nodes);
        self.places.copy_from_slice(&other.places);
        self.is_known = other.is_known;
        self.proximity.copy_from(&other.proximity);
    }
}
