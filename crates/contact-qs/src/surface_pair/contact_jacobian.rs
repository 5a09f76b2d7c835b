//! Directions and functions at the projected points: the rows that forces are spread by and
//! compliances projected on.

use super::projection::{Projection, SurfacePlace};
use super::target::TargetSurface;

/// Normals, tangents and functions of all points. Directions are numbered 0: normal, 1 to `n_t`:
/// tangents.
#[derive(Debug, Clone)]
pub(super) struct ContactJacobian {
    /// Normal in the target's frame, for each point.
    pub normals_in_target: Vec<[f64; 3]>,
    /// The same normal in the contact body's frame.
    pub normals_in_body: Vec<[f64; 3]>,
    /// Places of the points' projections.
    pub places: Vec<SurfacePlace>,
    /// Element of the target for each point.
    pub elements: Vec<u32>,
    /// Functions of the target's nodes there, `width` for each point.
    pub values: Vec<f64>,
    pub width: usize,
    /// Number of tangents of a point, zero without friction.
    pub n_t: usize,
    /// Tangents in the target's frame and in the contact body's.
    pub tangents_in_target: Vec<[f64; 3]>,
    pub tangents_in_body: Vec<[f64; 3]>,
    /// Normal parts of the target's nodal forces under unit tangential ones, `width` for each
    /// tangent (Eq. F.23).
    pub normal_coupling: Vec<f64>,
}

impl ContactJacobian {
    pub fn new(n_points: usize, width: usize, n_t: usize) -> Self {
        Self {
            normals_in_target: vec![[0.0; 3]; n_points],
            normals_in_body: vec![[0.0; 3]; n_points],
            places: vec![SurfacePlace::default(); n_points],
            elements: vec![0; n_points],
            values: vec![0.0; n_points * width],
            width,
            n_t,
            tangents_in_target: vec![[0.0; 3]; n_points * n_t],
            tangents_in_body: vec![[0.0; 3]; n_points * n_t],
            normal_coupling: vec![0.0; n_points * n_t * width],
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.normals_in_target.copy_from_slice(&other.normals_in_target);
        self.normals_in_body.copy_from_slice(&other.normals_in_body);
        self.places.copy_from_slice(&other.places);
        self.elements.copy_from_slice(&other.elements);
        self.values.copy_from_slice(&other.values);
        self.tangents_in_target.copy_from_slice(&other.tangents_in_target);
        self.tangents_in_body.copy_from_slice(&other.tangents_in_body);
        self.normal_coupling.copy_from_slice(&other.normal_coupling);
    }

    /// Whether everything is equal in every bit.
    pub fn is_same(&self, other: &Self) -> bool {
        let vectors = |a: &[[f64; 3]], b: &[[f64; 3]]| same_bits(a.as_flattened(), b.as_flattened());
        self.elements == other.elements
            && same_bits(&self.values, &other.values)
            && vectors(&self.normals_in_target, &other.normals_in_target)
            && vectors(&self.normals_in_body, &other.normals_in_body)
            && vectors(&self.tangents_in_target, &other.tangents_in_target)
            && vectors(&self.tangents_in_body, &other.tangents_in_body)
            && same_bits(&self.normal_coupling, &other.normal_coupling)
    }

    /// Sets normal and functions of point `i`, projected to `found`.
    pub fn set(
        &mut self,
        i: usize,
        found: &Projection,
        normal_in_body: [f64; 3],
        values: impl Iterator<Item = f64>,
    ) {
        self.normals_in_target[i] = found.normal;
        self.normals_in_body[i] = normal_in_body;
        self.elements[i] = found.element;
        self.places[i] = found.place;
        let slots = &mut self.values[i * self.width..(i + 1) * self.width];
        slots.fill(0.0);
        slots.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
    }

    /// How far the points chosen by `is_chosen` have moved since `before`: largest change of a
    /// direction (radians) or a place (elements).
    pub fn moved(&self, before: &Self, surface: &TargetSurface, is_chosen: impl Fn(usize) -> bool) -> f64 {
        let mut moved = 0.0_f64;
        for i in (0..self.normals_in_target.len()).filter(|i| is_chosen(*i)) {
            let (here, there) = (&self.places[i], &before.places[i]);
            let element = &surface.elements[self.elements[i] as usize];
            if here.face != there.face {
                if !surface.is_joined() {
                    return f64::INFINITY;
                }
                // Over the seam, which both are as far from as from an end of their faces.
                let from =
                    |place, element: u32| surface.distance_to_end(place, &surface.elements[element as usize]);
                moved = moved.max(from(here, self.elements[i]) + from(there, before.elements[i]));
            } else {
                for a in 0..surface.n_parameters {
                    moved =
                        moved.max((here.xi[a] - there.xi[a]).abs() / (element.upper[a] - element.lower[a]));
                }
            }
            for d in 0..=self.n_t {
                let turned = self.direction_in_target(i, d).into_iter().zip(before.direction_in_target(i, d));
                moved = turned.fold(moved, |m, (x, y)| m.max((x - y).abs()));
            }
        }
        moved
    }

    /// Direction `d` of point `i` in the target's frame.
    pub fn direction_in_target(&self, i: usize, d: usize) -> [f64; 3] {
        if d == 0 { self.normals_in_target[i] } else { self.tangents_in_target[self.n_t * i + d - 1] }
    }

    /// Direction `d` of point `i` in the contact body's frame.
    pub fn direction_in_body(&self, i: usize, d: usize) -> [f64; 3] {
        if d == 0 { self.normals_in_body[i] } else { self.tangents_in_body[self.n_t * i + d - 1] }
    }

    /// Nodes of the target near point `i` with their shares of a unit force in direction `d`.
    pub fn shares<'a>(
        &'a self,
        surface: &'a TargetSurface,
        i: usize,
        d: usize,
    ) -> impl Iterator<Item = (u32, [f64; 3])> + 'a {
        let nodes = &surface.elements[self.elements[i] as usize].nodes;
        let (direction, normal) = (self.direction_in_target(i, d), self.normals_in_target[i]);
        let normal_coupling: &[f64] = if d == 0 {
            &[]
        } else {
            &self.normal_coupling[(self.n_t * i + d - 1) * self.width..][..self.width]
        };
        nodes.iter().zip(&self.values[i * self.width..]).enumerate().map(move |(k, (&node, &value))| {
            let mut share = direction.map(|x| value * x);
            if let Some(coupling) = normal_coupling.get(k) {
                share.iter_mut().zip(&normal).for_each(|(s, n)| *s += coupling * n);
            }
            (node, share)
        })
    }

    /// Interface degree of freedom and value of every entry of the row of point `i` in direction
    /// `d`.
    pub fn entries<'a>(
        &'a self,
        surface: &'a TargetSurface,
        i: usize,
        d: usize,
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        let nc = surface.motion.n_components();
        self.shares(surface, i, d).flat_map(move |(node, share)| {
            let dofs = &surface.dofs[nc * node as usize..][..nc];
            dofs.iter().zip(share).filter_map(|(b, value)| b.map(|b| (b as usize, value)))
        })
    }
}

fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits())
}
