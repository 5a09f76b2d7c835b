//! Kinds of elements and of their sides: corners, edges, sides, the order of nodes.
//!
//! Elements fill a volume or, in plane and axisymmetric models, a part of the plane of their first
//! two parameters; the third is zero there, and their sides are curves.
//!
//! Nodes stand in the order of Abaqus and CalculiX: corners, middles of edges in the order of
//! [`ElementKind::edges`], then (in solids with 14, 18 and 27 nodes) middles of four-sided sides
//! in the order of [`ElementKind::sides`], then the centre. Sides have the numbers that the input
//! files of these programs give them, S1 being 0; their corners turn right-handed about the outward
//! normal, those of a curve leave the element at the left.

/// An element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ElementKind {
    /// Linear tetrahedron.
    Tet4,
    /// Quadratic tetrahedron.
    Tet10,
    /// Trilinear hexahedron.
    Hex8,
    /// Serendipity hexahedron.
    Hex20,
    /// Triquadratic hexahedron.
    Hex27,
    /// Linear wedge.
    Wedge6,
    /// Serendipity wedge.
    Wedge15,
    /// Triangle times line, both quadratic.
    Wedge18,
    /// Pyramid between hexahedra and tetrahedra, linear along edges.
    Pyramid5,
    /// Serendipity pyramid.
    Pyramid13,
    /// Pyramid with a biquadratic base.
    Pyramid14,
    /// Linear triangle in the plane.
    Tri3,
    /// Quadratic triangle in the plane.
    Tri6,
    /// Bilinear quadrilateral in the plane.
    Quad4,
    /// Serendipity quadrilateral in the plane.
    Quad8,
    /// Biquadratic quadrilateral in the plane.
    Quad9,
}

/// The side of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SideKind {
    /// Straight line, the side of a plane element.
    Line2,
    /// Quadratic curve, the side of a plane element.
    Line3,
    /// Linear triangle.
    Tri3,
    /// Quadratic triangle.
    Tri6,
    /// Bilinear quadrilateral.
    Quad4,
    /// Serendipity quadrilateral.
    Quad8,
    /// Biquadratic quadrilateral.
    Quad9,
}

/// The shape of a kind: what its corners span.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Corners at the origin and the unit points.
    Tetrahedron,
    /// The cube `[-1, 1]³`.
    Hexahedron,
    /// A triangle in ξ, η times `[-1, 1]` in ζ.
    Wedge,
    /// The square `[-1, 1]²` at ζ = 0 under an apex at ζ = 1.
    Pyramid,
    /// Corners at the origin and the unit points of ξ, η.
    Triangle,
    /// The square `[-1, 1]²`.
    Quadrilateral,
}

type Pairs = &'static [[u8; 2]];
type Sides = &'static [&'static [u8]];

const TET_EDGES: Pairs = &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
const HEX_EDGES: Pairs =
    &[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
const WEDGE_EDGES: Pairs = &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];
const PYRAMID_EDGES: Pairs = &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]];
const TRIANGLE_EDGES: Pairs = &[[0, 1], [1, 2], [2, 0]];
const QUADRILATERAL_EDGES: Pairs = &[[0, 1], [1, 2], [2, 3], [3, 0]];

const TET_SIDES: Sides = &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]];
const HEX_SIDES: Sides =
    &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];
const WEDGE_SIDES: Sides = &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];
const PYRAMID_SIDES: Sides = &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];
const TRIANGLE_SIDES: Sides = &[&[0, 1], &[1, 2], &[2, 0]];
const QUADRILATERAL_SIDES: Sides = &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]];

const TET_CORNERS: &[[f64; 3]] = &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const HEX_CORNERS: &[[f64; 3]] = &[
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];
const WEDGE_CORNERS: &[[f64; 3]] = &[
    [0.0, 0.0, -1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, -1.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
];
const PYRAMID_CORNERS: &[[f64; 3]] =
    &[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLE_CORNERS: &[[f64; 3]] = &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const QUADRILATERAL_CORNERS: &[[f64; 3]] =
    &[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];

impl ElementKind {
    /// Those that fill a volume.
    pub const SOLID: [Self; 11] = [
        Self::Tet4,
        Self::Tet10,
        Self::Hex8,
        Self::Hex20,
        Self::Hex27,
        Self::Wedge6,
        Self::Wedge15,
        Self::Wedge18,
        Self::Pyramid5,
        Self::Pyramid13,
        Self::Pyramid14,
    ];
    /// Those that fill a part of the plane.
    pub const PLANE: [Self; 5] = [Self::Tri3, Self::Tri6, Self::Quad4, Self::Quad8, Self::Quad9];
    /// Every kind.
    pub const ALL: [Self; 16] = {
        let mut all = [Self::Tet4; 16];
        let (solid, plane) = all.split_at_mut(Self::SOLID.len());
        solid.copy_from_slice(&Self::SOLID);
        plane.copy_from_slice(&Self::PLANE);
        all
    };
    /// Most nodes of any kind.
    pub const MAX_NODES: usize = 27;

    /// Number of nodes.
    pub fn n_nodes(self) -> usize {
        match self {
            Self::Tet4 => 4,
            Self::Tet10 => 10,
            Self::Hex8 => 8,
            Self::Hex20 => 20,
            Self::Hex27 => 27,
            Self::Wedge6 => 6,
            Self::Wedge15 => 15,
            Self::Wedge18 => 18,
            Self::Pyramid5 => 5,
            Self::Pyramid13 => 13,
            Self::Pyramid14 => 14,
            Self::Tri3 => 3,
            Self::Tri6 => 6,
            Self::Quad4 => 4,
            Self::Quad8 => 8,
            Self::Quad9 => 9,
        }
    }

    /// What the corners span.
    pub fn form(self) -> Form {
        match self {
            Self::Tet4 | Self::Tet10 => Form::Tetrahedron,
            Self::Hex8 | Self::Hex20 | Self::Hex27 => Form::Hexahedron,
            Self::Wedge6 | Self::Wedge15 | Self::Wedge18 => Form::Wedge,
            Self::Pyramid5 | Self::Pyramid13 | Self::Pyramid14 => Form::Pyramid,
            Self::Tri3 | Self::Tri6 => Form::Triangle,
            Self::Quad4 | Self::Quad8 | Self::Quad9 => Form::Quadrilateral,
        }
    }

    /// Number of parameters, and of coordinates that it fills: 3, or 2 in the plane.
    pub fn dimension(self) -> usize {
        if matches!(self.form(), Form::Triangle | Form::Quadrilateral) { 2 } else { 3 }
    }

    /// As messages call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tet4 => "tet4",
            Self::Tet10 => "tet10",
            Self::Hex8 => "hex8",
            Self::Hex20 => "hex20",
            Self::Hex27 => "hex27",
            Self::Wedge6 => "wedge6",
            Self::Wedge15 => "wedge15",
            Self::Wedge18 => "wedge18",
            Self::Pyramid5 => "pyramid5",
            Self::Pyramid13 => "pyramid13",
            Self::Pyramid14 => "pyramid14",
            Self::Tri3 => "tri3",
            Self::Tri6 => "tri6",
            Self::Quad4 => "quad4",
            Self::Quad8 => "quad8",
            Self::Quad9 => "quad9",
        }
    }

    /// Whether displacements along edges are quadratic.
    pub fn is_quadratic(self) -> bool {
        match self {
            Self::Tet4 | Self::Hex8 | Self::Wedge6 | Self::Pyramid5 | Self::Tri3 | Self::Quad4 => false,
            Self::Tet10
            | Self::Hex20
            | Self::Hex27
            | Self::Wedge15
            | Self::Wedge18
            | Self::Pyramid13
            | Self::Pyramid14
            | Self::Tri6
            | Self::Quad8
            | Self::Quad9 => true,
        }
    }

    /// The kind with the same corners and no other nodes.
    pub fn linear(self) -> Self {
        match self.form() {
            Form::Tetrahedron => Self::Tet4,
            Form::Hexahedron => Self::Hex8,
            Form::Wedge => Self::Wedge6,
            Form::Pyramid => Self::Pyramid5,
            Form::Triangle => Self::Tri3,
            Form::Quadrilateral => Self::Quad4,
        }
    }

    /// Whether four-sided sides have a node in their middle.
    fn has_side_nodes(self) -> bool {
        matches!(self, Self::Hex27 | Self::Wedge18 | Self::Pyramid14)
    }

    /// Number of corners.
    pub fn n_corners(self) -> usize {
        self.corners().len()
    }

    /// Parameters of the corners.
    pub fn corners(self) -> &'static [[f64; 3]] {
        match self.form() {
            Form::Tetrahedron => TET_CORNERS,
            Form::Hexahedron => HEX_CORNERS,
            Form::Wedge => WEDGE_CORNERS,
            Form::Pyramid => PYRAMID_CORNERS,
            Form::Triangle => TRIANGLE_CORNERS,
            Form::Quadrilateral => QUADRILATERAL_CORNERS,
        }
    }

    /// Corners at the ends of each edge.
    pub fn edges(self) -> Pairs {
        match self.form() {
            Form::Tetrahedron => TET_EDGES,
            Form::Hexahedron => HEX_EDGES,
            Form::Wedge => WEDGE_EDGES,
            Form::Pyramid => PYRAMID_EDGES,
            Form::Triangle => TRIANGLE_EDGES,
            Form::Quadrilateral => QUADRILATERAL_EDGES,
        }
    }

    /// Corners of each side, right-handed about the outward normal.
    pub fn sides(self) -> Sides {
        match self.form() {
            Form::Tetrahedron => TET_SIDES,
            Form::Hexahedron => HEX_SIDES,
            Form::Wedge => WEDGE_SIDES,
            Form::Pyramid => PYRAMID_SIDES,
            Form::Triangle => TRIANGLE_SIDES,
            Form::Quadrilateral => QUADRILATERAL_SIDES,
        }
    }

    /// The corners in whose middle every other node of a straight element stands.
    pub fn middles(self) -> Vec<&'static [u8]> {
        let mut all: Vec<&[u8]> = Vec::new();
        if self.is_quadratic() {
            all.extend(self.edges().iter().map(|edge| edge.as_slice()));
        }
        if self.has_side_nodes() {
            all.extend(self.sides().iter().filter(|side| side.len() == 4));
        }
        match self {
            Self::Hex27 => all.push(&[0, 1, 2, 3, 4, 5, 6, 7]),
            Self::Quad9 => all.push(&[0, 1, 2, 3]),
            _ => {}
        }
        all
    }

    /// Parameters of all nodes.
    pub fn node_parameters(self) -> Vec<[f64; 3]> {
        let corners = self.corners();
        let mean = |of: &[u8]| {
            let share = 1.0 / of.len() as f64;
            [0, 1, 2].map(|d| of.iter().map(|&c| share * corners[c as usize][d]).sum())
        };
        let mut all = corners.to_vec();
        all.extend(self.middles().into_iter().map(mean));
        all
    }

    /// Nodes of side `number` of the element, in the order of its [`SideKind`].
    pub fn side_nodes(self, number: usize) -> (SideKind, Vec<u8>) {
        let corners = self.sides()[number];
        let mut nodes = corners.to_vec();
        if !self.is_quadratic() {
            return (SideKind::linear(corners.len()), nodes);
        }
        let n_edges = if corners.len() == 2 { 1 } else { corners.len() };
        for (i, &a) in corners.iter().enumerate().take(n_edges) {
            let b = corners[(i + 1) % corners.len()];
            let edge = self.edges().iter().position(|e| *e == [a, b] || *e == [b, a]);
            nodes.extend(edge.map(|k| (self.n_corners() + k) as u8));
        }
        match corners.len() {
            2 => return (SideKind::Line3, nodes),
            3 => return (SideKind::Tri6, nodes),
            _ if !self.has_side_nodes() => return (SideKind::Quad8, nodes),
            _ => {}
        }
        let before = self.sides()[..number].iter().filter(|side| side.len() == 4).count();
        nodes.push((self.n_corners() + self.edges().len() + before) as u8);
        (SideKind::Quad9, nodes)
    }
}

impl SideKind {
    /// The kind with `n_corners` corners and no other nodes.
    pub fn linear(n_corners: usize) -> Self {
        match n_corners {
            2 => Self::Line2,
            3 => Self::Tri3,
            _ => Self::Quad4,
        }
    }

    /// Whether it is a curve, which has its first parameter alone; its edges are its ends.
    pub fn is_curve(self) -> bool {
        matches!(self, Self::Line2 | Self::Line3)
    }

    /// The corners at the ends of edge `edge`, of which a curve has one each.
    pub fn edge(self, edge: usize) -> [usize; 2] {
        [edge, if self.is_curve() { edge } else { (edge + 1) % self.n_corners() }]
    }

    /// Parameters of the place a share of the way along edge `edge`, from its first corner.
    pub fn on_edge(self, edge: usize, share: f64) -> [f64; 2] {
        let (corners, [a, b]) = (self.node_parameters(), self.edge(edge));
        let (a, b) = (corners[a], corners[b]);
        [0, 1].map(|d| (1.0 - share) * a[d] + share * b[d])
    }

    /// Every kind.
    pub const ALL: [Self; 7] =
        [Self::Line2, Self::Line3, Self::Tri3, Self::Tri6, Self::Quad4, Self::Quad8, Self::Quad9];
    /// Most nodes of any kind.
    pub const MAX_NODES: usize = 9;

    /// Number of nodes.
    pub fn n_nodes(self) -> usize {
        match self {
            Self::Line2 => 2,
            Self::Line3 | Self::Tri3 => 3,
            Self::Tri6 => 6,
            Self::Quad4 => 4,
            Self::Quad8 => 8,
            Self::Quad9 => 9,
        }
    }

    /// Number of corners.
    pub fn n_corners(self) -> usize {
        match self {
            Self::Line2 | Self::Line3 => 2,
            Self::Tri3 | Self::Tri6 => 3,
            Self::Quad4 | Self::Quad8 | Self::Quad9 => 4,
        }
    }

    /// Parameters of all nodes: curves in `[-1, 1]`, triangles in `ξ, η, 1 - ξ - η ≥ 0`,
    /// quadrilaterals in `[-1, 1]²`.
    pub fn node_parameters(self) -> Vec<[f64; 2]> {
        let corners: &[[f64; 2]] = match self.n_corners() {
            2 => &[[-1.0, 0.0], [1.0, 0.0]],
            3 => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            _ => &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
        };
        let mut all = corners.to_vec();
        if self == Self::Line3 {
            all.push([0.0; 2]);
        } else if self.n_nodes() > corners.len() {
            let middle = |i: usize| {
                let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
            };
            all.extend((0..corners.len()).map(middle));
        }
        if self == Self::Quad9 {
            all.push([0.0; 2]);
        }
        all
    }
}
