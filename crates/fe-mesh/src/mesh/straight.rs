//! Quadratic elements that are folded though their corners are not: their edges are made straighter.

use std::collections::HashMap;

use crate::element::jacobian::{PointOf, minus, norm};
use crate::element::kind::ElementKind;
use crate::mesh::check::{Turned, points_of_pieces};
use crate::mesh::raw::{Element, Elements};

/// How often elements are looked at, for straighter edges fold others.
const PASSES: usize = 16;
/// Passes in which middles of edges go a quarter of the way to where straight edges have them, to a tenth of the distance, before they go all
/// of it: what is curved stays so where it can.
const PART_OF_THE_WAY: usize = 8;
/// Share of an edge by which the middle of a straight one may be off: files have six digits and more.
const STRAIGHT: f64 = 1e-6;
/// Numbers that a note lists.
const LISTED: usize = 5;

/// Puts the middles of edges of folded elements towards where straight edges have them, as far as it takes, which their
/// neighbours follow, and notes what that changes. Elements with corners in a wrong order stay. Folded are those
/// that are inside out anywhere, for a contact divides elements and has points all over them.
pub fn straighten(elements: &Elements, nodes: &mut [[f64; 3]], notes: &mut Vec<String>) {
    let mut before: HashMap<u32, [f64; 3]> = HashMap::new();
    let (mut turned, mut mended) = (Turned::default(), Vec::new());
    for pass in 0..PASSES {
        let share = if pass < PART_OF_THE_WAY { 0.25 } else { 1.0 };
        let mut folded = Vec::new();
        for kind in ElementKind::ALL.into_iter().filter(|kind| kind.is_quadratic()) {
            let points = points_of_pieces(kind);
            let all = elements.iter().enumerate().filter(|(_, e)| e.kind == kind && is_curved(e, nodes));
            folded.extend(all.filter_map(|(e, element)| {
                turned.of(kind, element.nodes, nodes, &points)?;
                turned.corners(kind, element.nodes, nodes).is_none().then_some(e)
            }));
        }
        for &e in &folded {
            let element = elements.get(e);
            for (node, straight) in middles(&element, nodes).collect::<Vec<_>>() {
                let at = &mut nodes[node as usize];
                before.entry(node).or_insert(*at);
                *at = [0, 1, 2].map(|d| (1.0 - share) * at[d] + share * straight[d]);
            }
        }
        if folded.is_empty() {
            break;
        }
        mended.extend(folded);
    }
    if before.is_empty() {
        return;
    }
    let (mut change, mut total) = (0.0, 0.0);
    let old = |n: &u32| before.get(n).copied();
    for element in elements.iter() {
        let now: Vec<[f64; 3]> = element.nodes.iter().map(|&n| nodes[n as usize]).collect();
        let volume_now = volume(element.kind, &now);
        total += volume_now;
        if element.nodes.iter().any(|n| before.contains_key(n)) {
            let then: Vec<_> = element.nodes.iter().zip(&now).map(|(n, x)| old(n).unwrap_or(*x)).collect();
            change += volume_now - volume(element.kind, &then);
        }
    }
    let furthest = before.iter().map(|(&n, x)| norm(&minus(x, &nodes[n as usize]))).fold(0.0, f64::max);
    mended.sort_unstable();
    mended.dedup();
    let first: Vec<String> = mended.iter().take(LISTED).map(|&e| elements.get(e).label.to_string()).collect();
    let more = if mended.len() > LISTED { ", …" } else { "" };
    notes.push(format!(
        "{} elements were folded by their curved edges, which are straighter now: {}{more}; middles of edges moved by up to {furthest:.2e} m, which \
         changes the volume of the part by {:+.1e} of it; a finer mesh there or Mesh.HighOrderOptimize = 2 of Gmsh keeps edges curved",
        mended.len(),
        first.join(", "),
        change / total
    ));
}

/// Nodes of `element` that are no corners, and where straight edges would have them.
fn middles<'a>(element: &Element<'a>, nodes: &'a [[f64; 3]]) -> impl Iterator<Item = (u32, [f64; 3])> + 'a {
    let (kind, own) = (element.kind, element.nodes);
    own[kind.n_corners()..].iter().zip(kind.middles()).map(move |(&node, of)| {
        let share = 1.0 / of.len() as f64;
        let corner = |&c: &u8| nodes[own[c as usize] as usize];
        (node, [0, 1, 2].map(|d| of.iter().map(|c| share * corner(c)[d]).sum()))
    })
}

/// Whether an edge of `element` is curved beyond what digits of a file leave.
fn is_curved(element: &Element<'_>, nodes: &[[f64; 3]]) -> bool {
    let [a, b] = [0, 1].map(|corner| nodes[element.nodes[corner] as usize]);
    let straight_to = STRAIGHT * norm(&minus(&a, &b));
    middles(element, nodes).any(|(node, x)| norm(&minus(&nodes[node as usize], &x)) > straight_to)
}

/// Volume of an element with nodes at `places` \[m³\].
fn volume(kind: ElementKind, places: &[[f64; 3]]) -> f64 {
    let mut at = PointOf::default();
    let at_point = |p: &crate::element::rules::RulePoint<3>| {
        at.evaluate(kind, places, &p.xi);
        p.weight * at.determinant
    };
    kind.mass_rule().iter().map(at_point).sum()
}
