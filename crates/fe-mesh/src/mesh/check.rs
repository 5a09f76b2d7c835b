//! Checks of a mesh: what makes no body is an error, what is doubtful a note.

use crate::element::jacobian::{PointOf, cross, dot, minus, norm};
use crate::element::kind::ElementKind;
use crate::fault::MeshFault;
use crate::mesh::raw::{Element, Elements, NO_NODE};

/// Numbers that a note lists.
const LISTED: usize = 5;
/// Sizes between which a unit of length is believed \[m\]: a grain of sand and a ship.
const PLAUSIBLE: [f64; 2] = [1e-4, 50.0];
/// Share of the mean determinant below which an element counts as flat.
const FLAT: f64 = 1e-9;
/// Longest edge over least height up to which quadratic tetrahedra bend as they should: free plates of one layer have frequencies within 1 %
/// at 8 times; 3 to 5 % too high at 16, up to 12 % at 31.
const SLENDER: f64 = 10.0;
/// Share of the tetrahedra that may be longer: single ones at an edge bend with their neighbours.
const THIN_SHARE: f64 = 0.05;

/// Length of the diagonal of the box around `nodes` \[m\].
pub fn diagonal(nodes: &[[f64; 3]]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for node in nodes {
        for d in 0..3 {
            low[d] = low[d].min(node[d]);
            high[d] = high[d].max(node[d]);
        }
    }
    if nodes.is_empty() { 0.0 } else { norm(&minus(&high, &low)) }
}

/// Refuses a mesh without elements, and one with linear and quadratic ones.
///
/// # Errors
/// [`MeshFault::NoElements`], [`MeshFault::MixedOrders`].
pub fn orders(elements: &Elements) -> Result<(), MeshFault> {
    let named = |is_quadratic: bool| {
        let found = elements.iter().find(|e| e.kind.is_quadratic() == is_quadratic);
        found.map(|e| (e.label, e.kind.name()))
    };
    match (named(false), named(true)) {
        (None, None) => Err(MeshFault::NoElements),
        (Some(first), Some(second)) => Err(MeshFault::MixedOrders { first, second }),
        _ => Ok(()),
    }
}

/// New numbers of the nodes that elements have, [`NO_NODE`] for the others, which are noted.
pub fn used_nodes(elements: &Elements, labels: &[u64], notes: &mut Vec<String>) -> Vec<u32> {
    let mut numbers = vec![NO_NODE; labels.len()];
    elements.iter().flat_map(|e| e.nodes).for_each(|&n| numbers[n as usize] = 0);
    let loose: Vec<u64> =
        numbers.iter().zip(labels).filter(|(n, _)| **n == NO_NODE).map(|(_, l)| *l).collect();
    if !loose.is_empty() {
        let first: Vec<String> = loose.iter().take(LISTED).map(u64::to_string).collect();
        let more = if loose.len() > LISTED { ", …" } else { "" };
        notes.push(format!(
            "{} nodes belong to no element of the body and are left out: {}{more}",
            loose.len(),
            first.join(", ")
        ));
    }
    for (next, number) in (0..).zip(numbers.iter_mut().filter(|n| **n != NO_NODE)) {
        *number = next;
    }
    numbers
}

/// Refuses elements that name a node twice.
///
/// # Errors
/// [`MeshFault::Collapsed`].
pub fn distinct_nodes(elements: &Elements, labels: &[u64]) -> Result<(), MeshFault> {
    let mut sorted = Vec::with_capacity(ElementKind::MAX_NODES);
    for element in elements.iter() {
        sorted.clear();
        sorted.extend_from_slice(element.nodes);
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|w| w[0] == w[1]) {
            return Err(MeshFault::Collapsed { element: element.label, node: labels[pair[0] as usize] });
        }
    }
    Ok(())
}

/// Points at which an element must not be inside out: those of its rules.
pub fn points(kind: ElementKind) -> Vec<[f64; 3]> {
    kind.stiffness_rule().iter().chain(&kind.mass_rule()).map(|p| p.xi).collect()
}

/// Those points, the nodes of the element and the middles between any two of them: where pieces of the element may have points.
pub fn points_of_pieces(kind: ElementKind) -> Vec<[f64; 3]> {
    let nodes = kind.node_parameters();
    let middle = |(a, b): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|d| 0.5 * (a[d] + b[d]));
    let mut all: Vec<[f64; 3]> =
        nodes.iter().flat_map(|a| nodes.iter().map(move |b| middle((a, b)))).collect();
    all.sort_unstable_by(|a, b| a.partial_cmp(b).expect("parameters are numbers"));
    all.dedup();
    all.extend(points(kind));
    all
}

/// Looks for places where elements are inside out.
#[derive(Default)]
pub struct Turned {
    at: PointOf,
    places: Vec<[f64; 3]>,
    /// Greatest of the last determinants.
    greatest: f64,
}

impl Turned {
    /// The least determinant at `points` of an element with the nodes `own`, with its place, unless it is positive.
    pub fn of(
        &mut self,
        kind: ElementKind,
        own: &[u32],
        nodes: &[[f64; 3]],
        points: &[[f64; 3]],
    ) -> Option<(f64, [f64; 3])> {
        self.places.clear();
        self.places.extend(own.iter().map(|&n| nodes[n as usize]));
        let mut least = None::<(f64, [f64; 3])>;
        self.greatest = f64::NEG_INFINITY;
        for xi in points {
            self.at.evaluate(kind, &self.places, xi);
            let (determinant, place) = (self.at.determinant, self.at.position);
            self.greatest = self.greatest.max(determinant);
            if least.is_none_or(|(least, _)| determinant.total_cmp(&least).is_lt()) {
                least = Some((determinant, place));
            }
        }
        least.filter(|(determinant, _)| !is_positive(*determinant, self.greatest.max(-determinant)))
    }

    /// Whether the corners alone make an element that is inside out, and if so, everywhere.
    pub fn corners(&mut self, kind: ElementKind, own: &[u32], nodes: &[[f64; 3]]) -> Option<bool> {
        let linear = kind.linear();
        self.of(linear, &own[..kind.n_corners()], nodes, &points(linear))?;
        Some(self.greatest < 0.0)
    }
}

/// Whether a determinant is positive beside the `largest` one; no number is not.
fn is_positive(determinant: f64, largest: f64) -> bool {
    determinant > FLAT * largest
}

/// Refuses elements whose map turns inside out at a point of a rule; notes those where it does so
/// at a node, at the apex of pyramids along the axis.
///
/// # Errors
/// [`MeshFault::Inverted`].
pub fn orientation(
    elements: &Elements,
    nodes: &[[f64; 3]],
    notes: &mut Vec<String>,
) -> Result<(), MeshFault> {
    let mut turned = Turned::default();
    let mut bad_nodes: Vec<u64> = Vec::new();
    for kind in ElementKind::ALL {
        let (points, ends) = (points(kind), kind.node_parameters());
        for element in elements.iter().filter(|e| e.kind == kind) {
            if let Some((determinant, point)) = turned.of(kind, element.nodes, nodes, &points) {
                let remedy = match turned.corners(kind, element.nodes, nodes) {
                    Some(true) => "its corners stand in the order of a mirrored element: reorient the mesh",
                    Some(false) => "it is folded at a corner: mesh again, finer there",
                    None => "optimise the high-order mesh (Mesh.HighOrderOptimize = 2 in Gmsh)",
                };
                let (element, kind) = (element.label, kind.name());
                return Err(MeshFault::Inverted { element, kind, point, determinant, remedy });
            }
            if kind.is_quadratic() && turned.of(kind, element.nodes, nodes, &ends).is_some() {
                bad_nodes.push(element.label);
            }
        }
    }
    if !bad_nodes.is_empty() {
        let first: Vec<String> = bad_nodes.iter().take(LISTED).map(u64::to_string).collect();
        notes.push(format!(
            "{} elements are inside out at a node, stress there is meaningless: {}; optimise the high-order mesh (Mesh.HighOrderOptimize = 2 in Gmsh)",
            bad_nodes.len(),
            first.join(", ")
        ));
    }
    Ok(())
}

/// Longest edge of a tetrahedron over its least height.
fn slenderness(corners: [[f64; 3]; 4]) -> f64 {
    let edges =
        [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].map(|[a, b]| minus(&corners[b], &corners[a]));
    let longest = edges.iter().map(norm).fold(0.0, f64::max);
    // Six times the volume over twice the largest side.
    let sides = [[0, 1], [0, 2], [1, 2], [3, 4]].map(|[a, b]| norm(&cross(&edges[a], &edges[b])));
    longest * sides.iter().fold(0.0f64, |m, a| m.max(*a)) / dot(&edges[0], &cross(&edges[1], &edges[2])).abs()
}

/// Notes kinds and shapes of elements that are too stiff.
pub fn stiffness(elements: &Elements, nodes: &[[f64; 3]], notes: &mut Vec<String>) {
    let of_tetrahedron = |e: Element<'_>| slenderness([0, 1, 2, 3].map(|i| nodes[e.nodes[i] as usize]));
    let tetrahedra: Vec<f64> =
        elements.iter().filter(|e| e.kind == ElementKind::Tet10).map(of_tetrahedron).collect();
    let thin: Vec<f64> = tetrahedra.iter().copied().filter(|r| *r > SLENDER).collect();
    if thin.len() as f64 > THIN_SHARE * tetrahedra.len() as f64 {
        let most = thin.iter().fold(0.0f64, |m, r| m.max(*r));
        notes.push(format!(
            "{} of {} tetrahedra are more than {SLENDER} times as long as high, up to {most:.0} times: thin walls of them bend too stiffly, frequencies are \
             a few per cent too high at 15 times, ten and more at 30; make elements no longer than {SLENDER} times the wall is thick, or take hex20 or wedge15 there",
            thin.len(),
            tetrahedra.len()
        ));
    }
    let count = |kind| elements.iter().filter(|e| e.kind == kind).count();
    for kind in [ElementKind::Tet4, ElementKind::Wedge6, ElementKind::Pyramid5, ElementKind::Tri3] {
        let n = count(kind);
        if n > 0 {
            notes.push(format!(
                "{n} elements are {}, linear ones whose strain hardly varies: bodies are far too stiff in bending; mesh with quadratic elements (gmsh -order 2, C3D10, C3D15, CPS6)",
                kind.name()
            ));
        }
    }
    for (kind, better) in [(ElementKind::Hex8, "hex20"), (ElementKind::Quad4, "quad8")] {
        let n = count(kind);
        if n > 0 {
            notes.push(format!(
                "{n} elements are {}, too stiff in bending unless there are several over the thickness; {better} is much better",
                kind.name()
            ));
        }
    }
}

/// Notes sizes that a wrong unit of length makes.
pub fn size(nodes: &[[f64; 3]], notes: &mut Vec<String>) {
    let size = diagonal(nodes);
    if !(PLAUSIBLE[0]..=PLAUSIBLE[1]).contains(&size) {
        notes.push(format!("the part is {size:.3e} m across; is its unit of length right?"));
    }
}
