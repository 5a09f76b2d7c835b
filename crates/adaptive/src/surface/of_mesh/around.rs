//! Sides and nodes around a place of a mesh, and the simple shape on which they lie.

use ffr_dynamics::body::RigidMotion;
use nalgebra::Vector3;

use super::{EDGE_PARTS, MeshSurface, SAME_PLANE};
use crate::surface::primitive::{MISFIT, Primitive};
use crate::surface::{Surface, SurfacePlace};

impl MeshSurface {
    /// The sides `chosen` with their neighbours over smooth edges, in ascending order.
    pub fn with_ring(&self, chosen: &[u32]) -> Vec<u32> {
        let ring = chosen.iter().flat_map(|i| self.neighbours(*i as usize)).filter(|n| n.is_smooth);
        let mut all: Vec<u32> = chosen.iter().copied().chain(ring.map(|n| n.side)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The sides that are smoothly connected with `first` and have a place that `is_within`, with those beside them.
    pub fn sides_within(&self, first: u32, is_within: impl Fn(&[f64; 3]) -> bool) -> Vec<u32> {
        let is_chosen = |i: usize| self.places_on(i).iter().any(&is_within);
        self.with_ring(&self.smooth_part(first as usize, is_chosen))
    }

    /// The plane, sphere, cylinder, cone or torus on which all nodes of `sides` lie, if there is one.
    pub fn primitive(&self, sides: &[u32]) -> Option<Primitive> {
        let places = self.places_with_normals(sides);
        Primitive::through(&places, self.mesh.model().dimension(), SAME_PLANE * self.length())
    }

    /// The same of few sides, which a face of another shape may lie beside: their nodes tell a shape by how far they bend, so that those of
    /// linear sides and of straight quadratic ones tell none.
    fn primitive_of_few(&self, sides: &[u32]) -> Option<Primitive> {
        if sides.iter().any(|&i| self.sides()[i as usize].kind.degrees()[0] < 2) {
            return None;
        }
        let places = self.places_with_normals(sides);
        let normal = places.iter().map(|[_, n]| n).sum::<Vector3<f64>>().try_normalize(0.0)?;
        let heights = places.iter().map(|[x, _]| x.dot(&normal));
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (f64::min(a, z), f64::max(b, z)));
        let misfit = (MISFIT * (high - low)).min(SAME_PLANE * self.length());
        Primitive::through(&places, self.mesh.model().dimension(), misfit).filter(|of| !of.is_plane())
    }

    /// The simple shape of the sides around `place` until they have `enough` nodes, else of those beside its own, else of this.
    pub fn primitive_around(&self, place: &SurfacePlace, enough: usize) -> Option<Primitive> {
        let own = [place.face];
        let few = || self.primitive_of_few(&self.with_ring(&own)).or_else(|| self.primitive_of_few(&own));
        self.primitive(&self.sides_around(place, enough)).or_else(few)
    }

    /// The sides alone that have a place that `is_within`, smoothly connected with `first`.
    pub fn sides_reached(&self, first: u32, is_within: impl Fn(&[f64; 3]) -> bool) -> Vec<u32> {
        let parts = EDGE_PARTS as u32;
        let is_chosen = |i: usize| {
            let n_edges = self.sides()[i].n_edges();
            let eta = |j: u32, k: u32| {
                let [x, y] = [j, k].map(|n| f64::from(n) / f64::from(parts));
                match n_edges {
                    2 => [2.0 * x - 1.0, 0.0],
                    3 => [x, y * (1.0 - x)],
                    _ => [2.0 * x - 1.0, 2.0 * y - 1.0],
                }
            };
            (0..=parts).any(|j| (0..=parts).any(|k| is_within(&self.at(i, &eta(j, k)).position)))
        };
        self.smooth_part(first as usize, is_chosen)
    }

    /// The simple shape of these sides.
    pub fn primitive_within(&self, first: u32, is_within: impl Fn(&[f64; 3]) -> bool) -> Option<Primitive> {
        self.primitive_of_few(&self.sides_reached(first, is_within))
    }

    /// The nodes of `sides` with the normals there of each of them.
    fn places_with_normals(&self, sides: &[u32]) -> Vec<[Vector3<f64>; 2]> {
        let on_side = |&i: &u32| {
            let side = &self.sides()[i as usize];
            side.kind.node_parameters().into_iter().map(move |eta| {
                let at = self.at(i as usize, &eta);
                [at.position, at.area].map(Vector3::from)
            })
        };
        sides.iter().flat_map(on_side).filter_map(|[x, area]| Some([x, area.try_normalize(0.0)?])).collect()
    }

    fn nodes_of(&self, sides: &[u32]) -> Vec<u32> {
        let mut all: Vec<u32> =
            sides.iter().flat_map(|&i| self.sides()[i as usize].nodes.iter().copied()).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The sides around `place`, ring after ring over smooth edges until they have `enough` nodes, or there are no more.
    pub fn sides_around(&self, place: &SurfacePlace, enough: usize) -> Vec<u32> {
        let mut rings = vec![place.face];
        while self.nodes_of(&rings).len() < enough {
            let wider = self.with_ring(&rings);
            if wider.len() == rings.len() {
                break;
            }
            rings = wider;
        }
        rings
    }

    /// Nodes of the sides around `place`, ring after ring over smooth edges until there are
    /// `enough`, or no more; where they reach an axis of symmetry, with their mirror images.
    pub fn around(&self, place: &SurfacePlace, enough: usize) -> Vec<Vector3<f64>> {
        let found = self.nodes_of(&self.sides_around(place, enough)).into_iter();
        let found: Vec<Vector3<f64>> = found.map(|n| Vector3::from(self.mesh.nodes()[n as usize])).collect();
        let is_axial = self.motion() == RigidMotion::Axial && found.iter().any(|x| x[0] == 0.0);
        let beyond = found.iter().filter(|x| is_axial && x[0] > 0.0).map(|x| Vector3::new(-x[0], x[1], 0.0));
        let beyond: Vec<_> = beyond.collect();
        [found, beyond].concat()
    }
}
