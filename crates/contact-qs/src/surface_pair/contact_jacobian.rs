//! Directions and functions at the projected points: the rows that forces are spread by and
//! compliances projected on.

use iga_core::nurbs::jet::{difference, norm};

use super::projection::Projection;
use super::target::TargetSurface;

/// Normals, tangents and functions of all points. Directions are numbered 0: normal, 1 to `n_t`:
/// tangents.
#[derive(Debug, Clone)]
pub(super) struct ContactJacobian {
    /// Normal in the target's frame, for each point.
    pub normals_in_target: Vec<[f64; 3]>,
    /// The same normal in the contact body's frame.
    pub normals_in_body: Vec<[f64; 3]>,
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
        self.elements.copy_from_slice(&other.elements);
        self.values.copy_from_slice(&other.values);
        self.tangents_in_target.copy_from_slice(&other.tangents_in_target);
        self.tangents_in_body.copy_from_slice(&other.tangents_in_body);
        self.normal_coupling.copy_from_slice(&other.normal_coupling);
    }

    /// Takes over the rows of point `i`.
    pub fn copy_point(&mut self, i: usize, other: &Self) {
        let (n_t, width) = (self.n_t, self.width);
        self.normals_in_target[i] = other.normals_in_target[i];
        self.normals_in_body[i] = other.normals_in_body[i];
        self.elements[i] = other.elements[i];
        let (values, tangents) = (width * i..width * (i + 1), n_t * i..n_t * (i + 1));
        self.values[values.clone()].copy_from_slice(&other.values[values]);
        self.tangents_in_target[tangents.clone()]
            .copy_from_slice(&other.tangents_in_target[tangents.clone()]);
        self.tangents_in_body[tangents.clone()].copy_from_slice(&other.tangents_in_body[tangents]);
        let coupling = width * n_t * i..width * n_t * (i + 1);
        self.normal_coupling[coupling.clone()].copy_from_slice(&other.normal_coupling[coupling]);
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
        let slots = &mut self.values[i * self.width..(i + 1) * self.width];
        slots.fill(0.0);
        slots.iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
    }

    /// How far the points chosen by `is_chosen` have moved since `before`: largest change of a
    /// direction (radians) or a place (elements).
    pub fn moved(&self, before: &Self, surface: &TargetSurface, is_chosen: impl Fn(usize) -> bool) -> f64 {
        let mut moved = 0.0_f64;
        for i in (0..self.normals_in_target.len()).filter(|i| is_chosen(*i)) {
            let way = difference(&self.material_point(i, surface), &before.material_point(i, surface));
            moved = moved.max(norm(&way) / surface.length(self.elements[i]));
            for d in 0..=self.n_t {
                let turned = self.direction_in_target(i, d).into_iter().zip(before.direction_in_target(i, d));
                moved = turned.fold(moved, |m, (x, y)| m.max((x - y).abs()));
            }
        }
        moved
    }

    /// The material point that point `i` stands on, in the unloaded target.
    fn material_point(&self, i: usize, surface: &TargetSurface) -> [f64; 3] {
        let nodes = &surface.elements[self.elements[i] as usize].nodes;
        let shares = nodes.iter().zip(&self.values[i * self.width..(i + 1) * self.width]);
        shares.fold([0.0; 3], |sum, (node, value)| {
            let node = &surface.nodes[*node as usize];
            [0, 1, 2].map(|c| sum[c] + value * node[c])
        })
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
