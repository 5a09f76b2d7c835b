//! Directions and functions at the projected points: the rows that forces are spread by and compliances projected on.

use super::projection::{Projection, SurfacePlace};
use super::target::TargetSurface;

/// Normals, tangents and functions of all points. Directions are numbered 0: normal, 1 to `n_t`: tangents.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// Normal in the target's frame, for each point.
    pub normals: Vec<[f64; 3]>,
    /// The same normal in the contact body's frame.
    pub own_normals: Vec<[f64; 3]>,
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
    pub tangents: Vec<[f64; 3]>,
    pub own_tangents: Vec<[f64; 3]>,
    /// Normal parts of the target's nodal forces under unit tangential ones, `width` for each tangent (Eq. F.27).
    pub leans: Vec<f64>,
}

impl Rows {
    pub fn new(n_points: usize, width: usize, n_t: usize) -> Self {
        Self {
            normals: vec![[0.0; 3]; n_points],
            own_normals: vec![[0.0; 3]; n_points],
            places: vec![SurfacePlace::default(); n_points],
            elements: vec![0; n_points],
            values: vec![0.0; n_points * width],
            width,
            n_t,
            tangents: vec![[0.0; 3]; n_points * n_t],
            own_tangents: vec![[0.0; 3]; n_points * n_t],
            leans: vec![0.0; n_points * n_t * width],
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.normals.copy_from_slice(&other.normals);
        self.own_normals.copy_from_slice(&other.own_normals);
        self.places.copy_from_slice(&other.places);
        self.elements.copy_from_slice(&other.elements);
        self.values.copy_from_slice(&other.values);
        self.tangents.copy_from_slice(&other.tangents);
        self.own_tangents.copy_from_slice(&other.own_tangents);
        self.leans.copy_from_slice(&other.leans);
    }

    /// Whether everything is equal in every bit.
    pub fn is_same(&self, other: &Self) -> bool {
        let vectors = |a: &[[f64; 3]], b: &[[f64; 3]]| same_bits(a.as_flattened(), b.as_flattened());
        self.elements == other.elements
            && same_bits(&self.values, &other.values)
            && vectors(&self.normals, &other.normals)
            && vectors(&self.own_normals, &other.own_normals)
            && vectors(&self.tangents, &other.tangents)
            && vectors(&self.own_tangents, &other.own_tangents)
            && same_bits(&self.leans, &other.leans)
    }

    /// Sets normal and functions of point `i`, projected to `found`.
    pub fn set(
        &mut self,
        i: usize,
        found: &Projection,
        own_normal: [f64; 3],
        values: impl Iterator<Item = f64>,
    ) {
        self.normals[i] = found.normal;
        self.own_normals[i] = own_normal;
        self.elements[i] = found.element;
        self.places[i] = found.place;
        let slots = &mut self.values[i * self.width..(i + 1) * self.width];
        slots.fill(0.0);
        slots.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
    }

    /// How far the points chosen by `is_chosen` have moved since `before`: largest change of a direction (radians) or a place
    /// (elements).
    pub fn moved(&self, before: &Self, surface: &TargetSurface, is_chosen: impl Fn(usize) -> bool) -> f64 {
        let mut moved = 0.0_f64;
        for i in (0..self.normals.len()).filter(|i| is_chosen(*i)) {
            let (here, there) = (&self.places[i], &before.places[i]);
            if here.face != there.face {
                return f64::INFINITY;
            }
            let element = &surface.elements[self.elements[i] as usize];
            for a in 0..surface.n_parameters {
                moved = moved.max((here.xi[a] - there.xi[a]).abs() / (element.upper[a] - element.lower[a]));
            }
            for d in 0..=self.n_t {
                let turned = self.direction(i, d).into_iter().zip(before.direction(i, d));
                moved = turned.fold(moved, |m, (x, y)| m.max((x - y).abs()));
            }
        }
        moved
    }

    /// Direction `d` of point `i` in the target's frame.
    pub fn direction(&self, i: usize, d: usize) -> [f64; 3] {
        if d == 0 { self.normals[i] } else { self.tangents[self.n_t * i + d - 1] }
    }

    /// Direction `d` of point `i` in the contact body's frame.
    pub fn own_direction(&self, i: usize, d: usize) -> [f64; 3] {
        if d == 0 { self.own_normals[i] } else { self.own_tangents[self.n_t * i + d - 1] }
    }

    /// Nodes of the target near point `i` with their shares of a unit force in direction `d`.
    pub fn shares<'a>(
        &'a self,
        surface: &'a TargetSurface,
        i: usize,
        d: usize,
    ) -> impl Iterator<Item = (u32, [f64; 3])> + 'a {
        let nodes = &surface.elements[self.elements[i] as usize].nodes;
        let (direction, normal) = (self.direction(i, d), self.normals[i]);
        let leans: &[f64] =
            if d == 0 { &[] } else { &self.leans[(self.n_t * i + d - 1) * self.width..][..self.width] };
        nodes.iter().zip(&self.values[i * self.width..]).enumerate().map(move |(k, (&node, &value))| {
            let mut share = direction.map(|x| value * x);
            if let Some(lean) = leans.get(k) {
                share.iter_mut().zip(&normal).for_each(|(s, n)| *s += lean * n);
            }
            (node, share)
        })
    }

    /// Interface freedom and value of every entry of the row of point `i` in direction `d`.
    pub fn entries<'a>(
        &'a self,
        surface: &'a TargetSurface,
        i: usize,
        d: usize,
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        let nc = surface.motion.n_components();
        self.shares(surface, i, d).flat_map(move |(node, share)| {
            let freedoms = &surface.freedoms[nc * node as usize..][..nc];
            freedoms.iter().zip(share).filter_map(|(b, value)| b.map(|b| (b as usize, value)))
        })
    }
}

fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits())
}
