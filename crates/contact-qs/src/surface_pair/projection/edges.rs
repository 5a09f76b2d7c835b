//! Which ends of the faces of a body are edges, and which go on smoothly (docs/theory.md Eq. C.77).

use ffr_dynamics::body::RigidMotion;
use iga_core::nurbs::SAME_PLACE;
use iga_core::nurbs::jet::{difference, dot, norm};

use super::{Displaced, Functions, Projection, Samples, SurfacePlace};
use crate::surface_pair::target::TargetSurface;

/// Cosine of the angle between normals above which two faces go on smoothly: 8 degrees, for faces
/// that only approximate one, as for the kinds of touches (Eq. C.61).
const ALONG: f64 = 0.99;
/// Shares of an end at which it is looked at.
const SHARES: [f64; 3] = [0.13, 0.48, 0.91];

impl TargetSurface {
    /// The surface as all faces of a rigid body, of which points meet smooth parts: a projection
    /// may end on any of them (section C.11). Contact that reaches an edge, where faces meet with
    /// two normals (Eq. C.77), counts as contact at an end of the target.
    #[must_use]
    pub fn complete(mut self) -> Self {
        self.is_complete = true;
        let edges = edges(&self);
        for (face, is_edge) in self.faces.iter_mut().zip(edges) {
            face.is_edge = is_edge;
        }
        self
    }
}

/// For each face of the undeformed `surface`, whether the lower and the upper end of each direction
/// are edges.
fn edges(surface: &TargetSurface) -> Vec<[[bool; 2]; 2]> {
    let displaced = Displaced { surface, nodes: &surface.nodes, normals: &[], slack: 0.0 };
    let (mut functions, mut samples) = (Functions::new(surface), Samples::new(surface));
    samples.update(displaced);
    let mut found = vec![[[false; 2]; 2]; surface.faces.len()];
    for (face, ends) in found.iter_mut().enumerate() {
        for (a, both) in ends.iter_mut().enumerate().take(surface.n_parameters) {
            for (upper, is_edge) in both.iter_mut().enumerate() {
                let places = SHARES.map(|share| place(surface, face, a, upper, share));
                let n = if surface.n_parameters == 1 { 1 } else { places.len() };
                *is_edge = places[..n].iter().any(|p| is_sharp(displaced, p, a, &samples, &mut functions));
            }
        }
    }
    found
}

/// The place at `share` of the end of direction `a` of a face.
fn place(surface: &TargetSurface, face: usize, a: usize, upper: usize, share: f64) -> SurfacePlace {
    let grid = &surface.faces[face];
    let mut xi = [0, 1].map(|d| {
        let [low, high] = grid.range(d);
        low + share * (high - low)
    });
    xi[a] = grid.range(a)[upper];
    SurfacePlace { face: face as u32, xi }
}

/// Whether no face goes on smoothly at `place`, which is an end of direction `a` of its own.
fn is_sharp(
    displaced: Displaced<'_>,
    place: &SurfacePlace,
    a: usize,
    samples: &Samples,
    functions: &mut Functions,
) -> bool {
    let surface = displaced.surface;
    let own = displaced.at(place, functions);
    if surface.motion == RigidMotion::Axial && own.point[0].abs() <= SAME_PLACE * surface.size {
        return false; // the mirror image goes on
    }
    let goes_on = |other: &Projection| {
        let is_there = norm(&difference(&other.point, &own.point)) <= SAME_PLACE * surface.size;
        is_there && dot(&other.normal, &own.normal) > ALONG
    };
    // A pole is an end of no width: the face goes on beside it.
    let [low, high] = surface.faces[place.face as usize].range(1 - a);
    let width = norm(&displaced.jet(place, functions).tangents[1 - a]) * (high - low);
    if surface.n_parameters == 2 && width <= SAME_PLACE * surface.size {
        return false;
    }
    let others = (0..surface.faces.len()).filter(|face| *face != place.face as usize);
    let mut found = others
        .map(|face| displaced.closest_from(&samples.nearest_on(face, &own.point), &own.point, functions));
    if found.any(|other| goes_on(&other)) {
        return false;
    }
    !displaced.across_seam(place, &own.point, functions).is_some_and(|other| {
        let other = displaced.at(&other, functions);
        goes_on(&other)
    })
}

impl Displaced<'_> {
    /// Whether the foot `found`, at which `functions` were evaluated last, is nearer than `reach`
    /// to an edge \[m\].
    pub fn is_at_edge(&self, found: &Projection, reach: f64, functions: &Functions) -> bool {
        let grid = &self.surface.faces[found.place.face as usize];
        if grid.is_edge.as_flattened().iter().all(|is_edge| !is_edge) {
            return false;
        }
        let jet = self.jet_of(found.element, functions);
        (0..self.surface.n_parameters).any(|a| {
            let ([low, high], xi, speed) = (grid.range(a), found.place.xi[a], norm(&jet.tangents[a]));
            let [at_low, at_high] = grid.is_edge[a];
            at_low && (xi - low) * speed < reach || at_high && (high - xi) * speed < reach
        })
    }
}
