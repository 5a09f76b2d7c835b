//! Where a mesh is divided about a touch, and how far (docs/theory.md section C.10).

use fe_mesh::SideKind;
use fe_mesh::element::kind::Form;
use fe_mesh::fault::MeshFault;
use fe_mesh::refined::{CellBall, RefinedMesh};
use nalgebra::Vector3;

use crate::spec::RefinementSpec;
use crate::surface::{LocalShape, MeshSurface, Surface, SurfacePlace};

/// Sides of quadratic elements across the narrower width of a zone, at least: twice as many at
/// most, since elements are halved. With seven tenths of the width in contact, 2.1 to 4.2 on the
/// contact radius, where two make the force right to 0.2 %
/// ([`crate::sizing::mesh_touch::QUADRATIC`]).
pub const QUADRATIC: usize = 6;
/// Sides of linear elements across the narrower width of a zone, at least.
pub const LINEAR: usize = 16;
/// Edges of quadratic tetrahedra across each width where they are longest; on average they are seven tenths as long.
pub const TETRAHEDRA: usize = 5;
/// Lengths of edges of tetrahedra over their distances from an ellipse and from a line, at most: a line has many times the edges.
const GROWTH: [f64; 2] = [0.7, 1.0];
/// Area of a triangle whose edges are halved as long as they are longer than one: between a quarter, of a right angle with two equal
/// legs under an edge of one, and the half of that.
const TRIANGLE: f64 = 0.18;
/// Elements by which a zone is wider with the ring of sides around it.
const RING: f64 = 3.0;
/// Elements of the finest of whole levels beyond the zone: a side that meets it, the ring around, and one
/// between these and the next level, whose nodes others would be tied to.
const FINEST: f64 = 3.0;
/// Elements of every other level beyond the zone.
const COARSER: f64 = 2.0;

/// Quadratic and linear elements across a line: with one to three on the half width of the contact its force is right to one per cent.
const ACROSS_LINE: [usize; 2] = [2, 6];
/// Sine of the angle about the axis of a surface up to which a strip along it is told by its width over the tangential plane.
const BENT: f64 = 0.34;

/// Places on the rim of a zone by which the sides that it reaches are told.
const RIM: usize = 16;

/// Pieces more than the part has elements beyond which a line is not divided: a long thin one has some tens of thousands, and its model
/// takes a minute to be built.
const MOST_ALONG: usize = 12_000;

/// The zone that a fine model is to have: its middle, its widths, its elements.
#[derive(Debug, Clone, PartialEq)]
pub struct WantedZone {
    /// The middle of the zone; of one at several places that of each, about which it is alike.
    pub sites: Vec<SurfacePlace>,
    /// Widths along the principal directions of the surface there; one that is not below the size of the body stands for a
    /// strip along a line, from edge to edge \[m\].
    pub widths: [f64; 2],
    /// Elements across the narrower one; `None`: as many as the elements need.
    pub elements: Option<usize>,
    /// Direction of the first width on a surface without directions of its own; zero of others.
    pub across: [f64; 3],
}

impl WantedZone {
    /// Elements across the narrower width unless the scenario says otherwise.
    pub fn usual_elements(&self, surface: &MeshSurface) -> usize {
        let is_quadratic = surface.mesh().elements().iter().next().is_some_and(|e| e.kind.is_quadratic());
        let [quadratic, linear] = if self.is_line(surface) != [false; 2] {
            ACROSS_LINE
        } else {
            [if is_of_tetrahedra(surface) { TETRAHEDRA } else { QUADRATIC }, LINEAR]
        };
        if is_quadratic { quadratic } else { linear }
    }

    /// Elements across the narrower width.
    pub(super) fn elements(&self, surface: &MeshSurface) -> usize {
        self.elements.unwrap_or_else(|| self.usual_elements(surface))
    }

    /// Directions in which the zone reaches from one edge of the part to the other: along a line.
    pub fn is_line(&self, surface: &MeshSurface) -> [bool; 2] {
        let is_long = self.widths.map(|width| width >= surface.length());
        if surface.mesh().model().dimension() == 3 && is_long != [true; 2] { is_long } else { [false; 2] }
    }

    /// The ellipses, or the strip, about its places; none where the surface has no shape.
    pub fn footprints(&self, surface: &MeshSurface) -> Option<Vec<Footprint>> {
        self.sites.iter().map(|site| Footprint::new(surface, site, self)).collect()
    }

    /// Longest edge of the sides about its `footprints` \[m\], and how often elements there are halved by whole levels (theory Eq. C.72).
    fn levels(&self, surface: &MeshSurface, footprints: &[Footprint]) -> (f64, f64) {
        let longest_at = |(site, of): (&SurfacePlace, &Footprint)| {
            // A strip is narrower than what tells that a side is reached.
            let is_line = of.half.iter().any(|half| half.is_infinite());
            let is_within = |x: &[f64; 3]| of.contains(x);
            let sides = if is_line {
                surface.sides_within(site.face, is_within)
            } else {
                surface.sides_reached(site.face, is_within)
            };
            let rim = if is_line { Vec::new() } else { of.rim() };
            let on_rim = rim.iter().filter_map(|x| Some(surface.nearest(x)?.place.face));
            sides.into_iter().chain(on_rim).map(|i| surface.longest_edge(i as usize)).fold(0.0, f64::max)
        };
        let longest = self.sites.iter().zip(footprints).map(longest_at).fold(0.0, f64::max);
        let n_directions = surface.mesh().model().dimension() - 1;
        let narrow = self.widths[..n_directions].iter().fold(f64::INFINITY, |least, w| least.min(*w));
        let levels = (longest * self.elements(surface) as f64 / narrow).log2().ceil().max(0.0);
        (longest, levels)
    }

    /// The mesh divided about its `footprints`, into `most` pieces at most: tetrahedra edge by edge (theory Eq. C.110), others by
    /// whole levels (Eq. C.72); and the longest edge that is wanted \[m\].
    ///
    /// # Errors
    /// As [`RefinedMesh::at_edges`] and [`RefinedMesh::new`].
    pub fn divided(
        &self,
        surface: &MeshSurface,
        footprints: &[Footprint],
        most: usize,
    ) -> Result<(RefinedMesh, f64), MeshFault> {
        let mesh = surface.mesh();
        if is_of_tetrahedra(surface) {
            let m = self.elements(surface);
            let length = |ends: [&[f64; 3]; 2]| {
                footprints.iter().filter_map(|of| of.length(ends, of.lengths(m))).reduce(f64::max)
            };
            let least = footprints.iter().flat_map(|of| of.lengths(m));
            let finest = least.fold(f64::INFINITY, f64::min);
            return Ok((RefinedMesh::at_edges(mesh, length, most)?, finest));
        }
        let (longest, levels) = self.levels(surface, footprints);
        let is_wanted = |ball: &CellBall| {
            let level = f64::from(ball.level) + 1.0;
            let beyond = if level < levels { COARSER } else { FINEST };
            let reach = ball.radius + beyond * longest * (-level).exp2();
            level <= levels && footprints.iter().any(|of| of.distance(&ball.centre) <= reach)
        };
        Ok((RefinedMesh::new(mesh, is_wanted, most)?, longest * (-levels).exp2()))
    }

    /// Unknowns of its interface, from the areas of zone and sides; infinite along a line where the part has no known shape, of which
    /// the surface bends away in the zone, or which would take too many pieces. Without effect in a plane.
    pub fn interface(&self, surface: &MeshSurface) -> f64 {
        let Some(footprints) = self.footprints(surface).filter(|_| surface.mesh().model().dimension() == 3)
        else {
            return 0.0;
        };
        let is_at_edges = is_of_tetrahedra(surface);
        let m = self.elements(surface);
        let halved = (!is_at_edges).then(|| self.levels(surface, &footprints));
        let is_line = self.is_line(surface);
        let at = |(site, of): (&SurfacePlace, &Footprint)| {
            let sides = surface.sides_within(site.face, |x| of.contains(x));
            let is_bent = (0..2).any(|d| is_line[1 - d] && of.half[d] * of.shape.curvatures[d].abs() > BENT);
            if is_line != [false; 2] && (is_bent || surface.primitive(&sides).is_none()) {
                return f64::INFINITY;
            }
            let [mut area, mut unknowns] = [0.0; 2];
            for &i in &sides {
                let kind = surface.sides()[i as usize].kind;
                area += kind
                    .rule()
                    .iter()
                    .map(|p| p.weight * Vector3::from(surface.at(i as usize, &p.xi).area).norm())
                    .sum::<f64>();
                unknowns += 3.0 * nodes_per_side(kind);
            }
            let (size, finer) = match halved {
                Some((longest, levels)) => ([longest * (-levels).exp2(); 2], (2.0 * levels).exp2()),
                None => {
                    let size = of.lengths(m);
                    (size, (area / sides.len() as f64 / (TRIANGLE * size[0] * size[1])).max(1.0))
                }
            };
            let extent = |d: usize| {
                if is_line[d] { of.extent(surface, &sides, d) } else { 2.0 * of.half[d] + RING * size[d] }
            };
            let shape = if is_line == [false; 2] { 0.25 * std::f64::consts::PI } else { 1.0 };
            shape * extent(0) * extent(1) * unknowns / area * finer
        };
        let unknowns: f64 = self.sites.iter().zip(&footprints).map(at).sum();
        if !(unknowns.is_finite() && is_at_edges && is_line != [false; 2]) {
            return unknowns;
        }
        // How many pieces there are is known when they are there.
        let most = surface.mesh().elements().len() + MOST_ALONG;
        if self.divided(surface, &footprints, most).is_ok() { 0.0 } else { f64::INFINITY }
    }
}

/// Whether the elements can be halved edge by edge.
fn is_of_tetrahedra(surface: &MeshSurface) -> bool {
    surface.mesh().elements().iter().all(|e| e.kind.form() == Form::Tetrahedron)
}

/// Nodes of a large surface of such sides, for each of them.
fn nodes_per_side(kind: SideKind) -> f64 {
    match kind {
        SideKind::Tri3 => 0.5,
        SideKind::Line2 | SideKind::Quad4 => 1.0,
        SideKind::Line3 | SideKind::Tri6 => 2.0,
        SideKind::Quad8 => 3.0,
        SideKind::Quad9 => 4.0,
    }
}

/// The ellipse of a zone, bent as the surface is, or a strip; a part of a curve is as wide across it as you like.
pub struct Footprint {
    /// Its middle \[m\].
    pub centre: Vector3<f64>,
    /// The surface there.
    pub shape: LocalShape,
    /// Half widths, infinite along a line \[m\].
    pub half: [f64; 2],
    /// Number of directions of the surface.
    pub n_directions: usize,
    /// Whether the zone begins at the axis of symmetry.
    pub from_axis: bool,
}

impl Footprint {
    fn new(surface: &MeshSurface, site: &SurfacePlace, wanted: &WantedZone) -> Option<Self> {
        let shape = surface.shape_at(site)?.turned(&Vector3::from(wanted.across));
        let (model, point, [width, other]) = (surface.mesh().model(), &site.point, wanted.widths);
        let n_directions = model.dimension() - 1;
        let along = RefinementSpec::half_width(model, point, width);
        let mut half = [along, if n_directions == 1 { f64::INFINITY } else { 0.5 * other }];
        let lines = half.iter_mut().zip(wanted.is_line(surface)).filter(|(_, is_line)| *is_line);
        lines.for_each(|(half, _)| *half = f64::INFINITY);
        let from_axis = along > 0.5 * width;
        Some(Self { centre: Vector3::from(*point), shape, half, n_directions, from_axis })
    }

    /// Distance of its farthest end from its middle, of a strip across it \[m\].
    pub fn reach(&self) -> f64 {
        self.half.iter().filter(|half| half.is_finite()).fold(0.0, |most, half| most.max(*half))
    }

    /// Places around its rim, near the surface.
    fn rim(&self) -> Vec<[f64; 3]> {
        let place = |k: usize| {
            let (sin, cos) = (k as f64 * std::f64::consts::TAU / RIM as f64).sin_cos();
            let along = [cos * self.half[0], sin * self.half[1]];
            let sag: f64 = along.iter().zip(self.shape.curvatures).map(|(x, c)| 0.5 * c * x * x).sum();
            let [s, t] = self.shape.tangents;
            (self.centre + along[0] * s + along[1] * t - sag * self.shape.normal).into()
        };
        (0..RIM).map(place).collect()
    }

    /// The longest edges of which `m` have place across it in each direction, infinite along a line \[m\].
    pub fn lengths(&self, m: usize) -> [f64; 2] {
        self.half.map(|half| 2.0 * half / m as f64)
    }

    /// Length of an edge between two places in units of the one that is wanted there with `lengths` on the zone, if it is above one,
    /// times the shorter of these (theory Eq. C.110) \[m\].
    fn length(&self, [a, b]: [&[f64; 3]; 2], lengths: [f64; 2]) -> Option<f64> {
        let edge = Vector3::from(*b) - Vector3::from(*a);
        let growth = GROWTH[usize::from(self.half.iter().any(|half| half.is_infinite()))];
        let beyond = growth * self.distance(&[0, 1, 2].map(|d| 0.5 * (a[d] + b[d])));
        let ([s, t], least) = (self.shape.tangents, lengths[0].min(lengths[1]));
        let ways = [(s, lengths[0]), (t, lengths[1]), (self.shape.normal, least)];
        let share = |(way, wanted): (Vector3<f64>, f64)| (way.dot(&edge) / wanted.max(beyond)).powi(2);
        let length = ways.into_iter().map(share).sum::<f64>().sqrt();
        (length > 1.0).then(|| length * least.max(beyond))
    }

    /// Extent of the nodes of `sides` in direction `d` \[m\].
    fn extent(&self, surface: &MeshSurface, sides: &[u32], d: usize) -> f64 {
        let nodes = sides.iter().flat_map(|&i| &surface.sides()[i as usize].nodes);
        let along = nodes.map(|&n| self.along(&surface.mesh().nodes()[n as usize])[d]);
        let (low, high) =
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (f64::min(a, x), f64::max(b, x)));
        high - low
    }

    /// Coordinates along the principal directions.
    pub fn along(&self, x: &[f64; 3]) -> [f64; 2] {
        let from = Vector3::from(*x) - self.centre;
        self.shape.tangents.map(|t| from.dot(&t))
    }

    /// Distance along the surface in units of the ellipse.
    fn share(&self, [u, v]: [f64; 2]) -> f64 {
        (u / self.half[0]).hypot(v / self.half[1])
    }

    /// Whether `x` lies in it.
    pub fn contains(&self, x: &[f64; 3]) -> bool {
        self.share(self.along(x)) <= 1.0
    }

    /// Distance of a point from the zone, to the order of the curvature (theory Eq. C.72) \[m\].
    pub fn distance(&self, x: &[f64; 3]) -> f64 {
        let [u, v] = self.along(x);
        let inside = 1.0 / self.share([u, v]).max(1.0);
        let within = |x: f64, half: f64| if half.is_finite() { x * inside } else { x };
        let [a, b] = [within(u, self.half[0]), within(v, self.half[1])];
        let aside = (u - a).hypot(v - b);
        let [k, l] = self.shape.curvatures;
        let height = (Vector3::from(*x) - self.centre).dot(&self.shape.normal);
        aside.hypot(height + 0.5 * (k * a * a + l * b * b))
    }
}
