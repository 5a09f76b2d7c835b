//! Balls of hexahedra or tetrahedra with small elements about both ends of the z axis, and rods with their cross-section, for the tests.
//!
//! A cube of hexahedra stands in the middle; from each of its six sides layers lead to the sphere. Lines in x and y lie densely in the
//! middle, layers densely under the sphere. Nodes stand on a lattice of half elements, those between corners in the middle of the parameters.

use std::collections::{HashMap, HashSet};

use fe_mesh::element::kind::ElementKind;
use fe_mesh::mesh::raw::{Elements, RawMesh};

/// How a ball is divided.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Radius.
    pub radius: f64,
    /// Elements across the inner cube in x and y, an even number, and in z.
    pub across: [usize; 2],
    /// Layers between cube and sphere.
    pub layers: usize,
    /// Ratio of neighbouring elements in x and y, and of neighbouring layers.
    pub growth: [f64; 2],
}

/// Half of the inner cube's side over the radius.
const CUBE: f64 = 0.45;

/// Place of a node: on the lattice of the cube, and in which half layer.
type Key = [usize; 4];

impl Ball {
    /// Numbers of half elements.
    fn counts(&self) -> [usize; 3] {
        [2 * self.across[0], 2 * self.across[0], 2 * self.across[1]]
    }

    /// Coordinate in `[-1, 1]` of half line `i` of `2 n`, growing from the middle.
    fn line(&self, d: usize, i: usize) -> f64 {
        let n = self.counts()[d] / 2;
        let corner = |k: usize| -> f64 {
            if d == 2 {
                return 2.0 * k as f64 / n as f64 - 1.0;
            }
            let half = n / 2;
            let sum = |m: usize| {
                (0..m).map(|j| self.growth[0].powi(j as i32)).sum::<f64>() / {
                    (0..half).map(|j| self.growth[0].powi(j as i32)).sum::<f64>()
                }
            };
            if k >= half { sum(k - half) } else { -sum(half - k) }
        };
        0.5 * (corner(i / 2) + corner(i.div_ceil(2)))
    }

    /// Share of the way from the cube to the sphere of half layer `l`, layers becoming thinner outwards.
    fn layer(&self, l: usize) -> f64 {
        let n = self.layers;
        let sum = |m: usize| (0..m).map(|j| self.growth[1].powi(j as i32)).sum::<f64>();
        let corner = |k: usize| 1.0 - sum(n - k) / sum(n);
        0.5 * (corner(l / 2) + corner(l.div_ceil(2)))
    }

    fn place(&self, &[i, j, k, l]: &Key) -> [f64; 3] {
        let at = [self.line(0, i), self.line(1, j), self.line(2, k)];
        let inner = at.map(|x| CUBE * self.radius * x);
        if l == 0 {
            return inner;
        }
        let direction = at.map(|x| (0.25 * std::f64::consts::PI * x).tan());
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let t = self.layer(l);
        std::array::from_fn(|d| (1.0 - t) * inner[d] + t * self.radius * direction[d] / length)
    }

    /// Corners of all hexahedra, in the order of [`ElementKind::Hex8`].
    fn cells(&self) -> Vec<[Key; 8]> {
        let n = self.counts();
        let mut cells = Vec::new();
        let square = [[0, 0], [2, 0], [2, 2], [0, 2]];
        for (i, j, k) in (0..n[0] * n[1] * n[2] / 8).map(|c| {
            let (a, b) = (n[0] / 2, n[1] / 2);
            (2 * (c % a), 2 * (c / a % b), 2 * (c / a / b))
        }) {
            cells.push(std::array::from_fn(|v| {
                let [u, w] = square[v % 4];
                [i + u, j + w, k + 2 * (v / 4), 0]
            }));
        }
        for d in 0..3 {
            for end in [0, n[d]] {
                let (a, b) = ((d + 1) % 3, (d + 2) % 3);
                for (u, w) in (0..n[a] / 2).flat_map(|u| (0..n[b] / 2).map(move |w| (2 * u, 2 * w))) {
                    for l in 0..self.layers {
                        cells.push(std::array::from_fn(|v| {
                            // Outwards is up; seen from there, the square turns the other way at the lower end.
                            let [s, t] = if end > 0 { square[v % 4] } else { square[(4 - v % 4) % 4] };
                            let mut key = [0; 4];
                            (key[d], key[a], key[b], key[3]) = (end, u + s, w + t, 2 * (l + v / 4));
                            key
                        }));
                    }
                }
            }
        }
        cells
    }

    /// The ball of elements of `kind`: hex8, hex20, tet4 or tet10; hexahedra are cut into twelve tetrahedra each.
    pub fn mesh(&self, kind: ElementKind) -> RawMesh {
        Builder::new(2 * self.layers, |key| self.place(key)).built(kind, &self.cells())
    }

    /// The ball of the hexahedra, pyramids and tetrahedra `kinds`: cells whose middle `is_hexahedron` are one, others are cut into tetrahedra, with pyramids on the sides
    /// that they share with hexahedra.
    pub fn mixed(&self, kinds: [ElementKind; 3], is_hexahedron: impl Fn([f64; 3]) -> bool) -> RawMesh {
        let is_one = |cell: &[Key; 8]| {
            let places = cell.map(|key| self.place(&key));
            is_hexahedron(std::array::from_fn(|d| places.iter().map(|p| p[d]).sum::<f64>() / 8.0))
        };
        let (hexahedra, others): (Vec<[Key; 8]>, Vec<[Key; 8]>) = self.cells().into_iter().partition(is_one);
        let mut builder = Builder::new(2 * self.layers, |key| self.place(key));
        for cell in &hexahedra {
            builder.add_hexahedron(kinds[0], cell);
        }
        others.iter().for_each(|cell| builder.add_tetrahedra([kinds[1], kinds[2]], cell));
        builder.mesh
    }
}

/// A round rod along z from the origin on, made of the elements in the middle plane of a ball of its radius.
#[derive(Debug, Clone)]
pub struct Rod {
    /// The cross-section; the whole lower half of it is the end at the origin if that is round.
    pub ball: Ball,
    /// Whether the end at the origin is half a ball.
    pub is_round: bool,
    /// Planes between the elements of the cylinder, rising from zero; a round end stands before it.
    pub planes: Vec<f64>,
}

impl Rod {
    /// Planes over `length` that are `ends` apart at both ends and become wider by the ratio `growth` up to `middle`.
    pub fn planes(length: f64, ends: f64, middle: f64, growth: f64) -> Vec<f64> {
        let (mut half, mut at, mut step) = (vec![0.0], 0.0, ends);
        while at < 0.5 * length {
            at += step;
            half.push(at);
            step = (step * growth).min(middle);
        }
        // The last one is put into the middle.
        let scale = 0.5 * length / at;
        let half: Vec<f64> = half.into_iter().map(|z| z * scale).collect();
        half.iter().copied().chain(half.iter().rev().skip(1).map(|z| length - z)).collect()
    }

    /// Half plane in which the cylinder begins.
    fn first(&self) -> usize {
        self.ball.across[1]
    }

    fn place(&self, key: &Key) -> [f64; 3] {
        let base = if self.is_round { self.ball.radius } else { 0.0 };
        let Some(above) = key[2].checked_sub(self.first()) else {
            let [x, y, z] = self.ball.place(key);
            return [x, y, z + base];
        };
        let [x, y, _] = self.ball.place(&[key[0], key[1], self.first(), key[3]]);
        [x, y, base + 0.5 * (self.planes[above / 2] + self.planes[above.div_ceil(2)])]
    }

    /// The rod of elements of `kind`, as [`Ball::mesh`].
    pub fn mesh(&self, kind: ElementKind) -> RawMesh {
        let first = self.first();
        assert!(first.is_multiple_of(2), "a plane of nodes in the middle of the ball");
        let range = |cell: &[Key; 8]| {
            let heights = cell.iter().map(|key| key[2]);
            (heights.clone().min().unwrap_or_default(), heights.max().unwrap_or_default())
        };
        let of_ball = self.ball.cells();
        let mut cells: Vec<[Key; 8]> =
            of_ball.iter().filter(|cell| self.is_round && range(cell).1 <= first).copied().collect();
        let above = of_ball.iter().filter(|cell| range(cell) == (first, first + 2));
        for n in 0..self.planes.len() - 1 {
            cells.extend(above.clone().map(|cell| cell.map(|[i, j, k, l]| [i, j, k + 2 * n, l])));
        }
        Builder::new(2 * self.ball.layers, |key| self.place(key)).built(kind, &cells)
    }
}

struct Builder<F> {
    place: F,
    /// Half layer on the sphere.
    outermost: usize,
    mesh: RawMesh,
    numbers: HashMap<Key, u32>,
    middles: HashMap<[u32; 2], u32>,
    /// Sides and edges of hexahedra by their corners, rising.
    sides: HashSet<[u32; 4]>,
    edges: HashSet<[u32; 2]>,
}

fn rising<const N: usize>(mut of: [u32; N]) -> [u32; N] {
    of.sort_unstable();
    of
}

fn middle(of: &[Key]) -> Key {
    std::array::from_fn(|d| of.iter().map(|key| key[d]).sum::<usize>() / of.len())
}

impl<F: Fn(&Key) -> [f64; 3]> Builder<F> {
    fn new(outermost: usize, place: F) -> Self {
        let mesh = RawMesh { elements: Elements::default(), ..RawMesh::default() };
        Self {
            place,
            outermost,
            mesh,
            numbers: HashMap::new(),
            middles: HashMap::new(),
            sides: HashSet::new(),
            edges: HashSet::new(),
        }
    }

    /// The mesh of elements of `kind` in `cells`.
    fn built(mut self, kind: ElementKind, cells: &[[Key; 8]]) -> RawMesh {
        for cell in cells {
            match kind {
                ElementKind::Hex8 | ElementKind::Hex20 => self.add_hexahedron(kind, cell),
                _ => self.add_tetrahedra([ElementKind::Pyramid5, kind], cell),
            }
        }
        self.mesh
    }

    fn add_hexahedron(&mut self, kind: ElementKind, cell: &[Key; 8]) {
        let corners = cell.map(|key| self.node(&key));
        self.add(kind, &corners, |b, edge| b.between(cell, edge));
        for side in kind.sides() {
            self.sides.insert(rising(std::array::from_fn(|i| corners[side[i] as usize])));
        }
        for edge in kind.edges() {
            self.edges.insert(rising(edge.map(|c| corners[c as usize])));
        }
    }

    fn node(&mut self, key: &Key) -> u32 {
        if let Some(&n) = self.numbers.get(key) {
            return n;
        }
        let n = self.push((self.place)(key));
        self.numbers.insert(*key, n);
        n
    }

    fn push(&mut self, place: [f64; 3]) -> u32 {
        self.mesh.nodes.push(place);
        let n = self.mesh.nodes.len() as u32;
        self.mesh.node_labels.push(u64::from(n));
        n - 1
    }

    /// The node between two corners of a cell.
    fn between(&mut self, cell: &[Key; 8], [a, b]: [u8; 2]) -> u32 {
        self.node(&middle(&[cell[a as usize], cell[b as usize]]))
    }

    fn add(
        &mut self,
        kind: ElementKind,
        corners: &[u32],
        mut between: impl FnMut(&mut Self, [u8; 2]) -> u32,
    ) {
        let mut nodes = corners.to_vec();
        if kind.is_quadratic() {
            for edge in kind.edges() {
                nodes.push(between(self, *edge));
            }
        }
        let label = self.mesh.elements.len() as u64 + 1;
        self.mesh.elements.push(kind, label, nodes.into_iter());
    }

    /// Twelve tetrahedra about the middle of a cell, two on each side, cut along the diagonal through the corner with the least number; a pyramid on the side of a
    /// hexahedron.
    fn add_tetrahedra(&mut self, [pyramid, kind]: [ElementKind; 2], cell: &[Key; 8]) {
        let places: Vec<[f64; 3]> = cell.iter().map(|key| (self.place)(key)).collect();
        let centre = std::array::from_fn(|d| places.iter().map(|p| p[d]).sum::<f64>() / 8.0);
        let centre = self.push(centre);
        // Edges are curved on the sphere alone, and at hexahedra: inside they would turn flat tetrahedra over.
        let end = self.outermost;
        let outer = |key: &Key| key[3] == end;
        for side in ElementKind::Hex8.sides() {
            let keys: [Key; 4] = std::array::from_fn(|i| cell[side[i] as usize]);
            let numbers = keys.map(|key| self.node(&key));
            if self.sides.contains(&rising(numbers)) {
                let at = |i: usize| (numbers[3 - i], keys[3 - i]);
                let corners = [at(0).0, at(1).0, at(2).0, at(3).0, centre];
                self.add(pyramid, &corners, |builder, [p, q]| match (p as usize, q as usize) {
                    (p, q) if p < 4 && q < 4 => builder.node(&middle(&[at(p).1, at(q).1])),
                    (p, q) => builder.halfway([corners[p], corners[q]]),
                });
                continue;
            }
            let first = (0..4).min_by_key(|i| numbers[*i]).unwrap_or_default();
            for (a, b) in [(1, 2), (2, 3)] {
                let three = [first, (first + a) % 4, (first + b) % 4];
                let on_side = three.map(|i| keys[i]);
                // Seen from the centre the side turns left-handed.
                let corners = [numbers[three[0]], numbers[three[2]], numbers[three[1]], centre];
                let on_side = [on_side[0], on_side[2], on_side[1]];
                self.add(kind, &corners, |builder, [p, q]| match (p as usize, q as usize) {
                    (p, q)
                        if p < 3
                            && q < 3
                            && (outer(&on_side[p]) && outer(&on_side[q])
                                || builder.edges.contains(&rising([corners[p], corners[q]]))) =>
                    {
                        builder.node(&middle(&[on_side[p], on_side[q]]))
                    }
                    (p, q) => builder.halfway([corners[p], corners[q]]),
                });
            }
        }
    }

    /// The node halfway between two others that are on no lattice.
    fn halfway(&mut self, [a, b]: [u32; 2]) -> u32 {
        let key = [a.min(b), a.max(b)];
        if let Some(&n) = self.middles.get(&key) {
            return n;
        }
        let [x, y] = [a, b].map(|n| self.mesh.nodes[n as usize]);
        let n = self.push(std::array::from_fn(|d| 0.5 * (x[d] + y[d])));
        self.middles.insert(key, n);
        n
    }
}
