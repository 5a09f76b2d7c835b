//! Quadratic elements that are folded though their corners are not: their edges are made straight.

use std::collections::HashMap;

use crate::element::jacobian::{PointOf, minus, norm};
use crate::element::kind::ElementKind;
use crate::mesh::check::{Turned, points};
use crate::mesh::raw::Elements;

/// How often elements are looked at that straight edges of others have folded.
const PASSES: usize = 8;
/// Numbers that a note lists.
const LISTED: usize = 5;

/// Puts the middles of edges of folded elements where straight edges have them, which their
/// neighbours follow, and notes what that changes. Elements with corners in a wrong order stay.
pub fn straighten(elements: &Elements, nodes: &mut [[f64; 3]], notes: &mut Vec<String>) {
    let mut before: HashMap<u32, [f64; 3]> = HashMap::new();
    let (mut turned, mut mended) = (Turned::default(), Vec::new());
    for _ in 0..PASSES {
        let mut folded = Vec::new();
        for kind in ElementKind::ALL.into_iter().filter(|kind| kind.is_quadratic()) {
            let points = points(kind);
            let all = elements.iter().enumerate().filter(|(_, e)| e.kind == kind);
            folded.extend(all.filter_map(|(e, element)| {
                turned.of(kind, element.nodes, nodes, &points)?;
                turned.corners(kind, element.nodes, nodes).is_none().then_some(e)
            }));
        }
        let n = before.len();
        for &e in &folded {
            let element = elements.get(e);
            let shape = element.kind.middles();
            for (of, &node) in shape.iter().zip(&element.nodes[element.kind.n_corners()..]) {
                let share = 1.0 / of.len() as f64;
                let corner = |&c: &u8| nodes[element.nodes[c as usize] as usize];
                let straight = [0, 1, 2].map(|d| of.iter().map(|c| share * corner(c)[d]).sum());
                let at = &mut nodes[node as usize];
                if norm(&minus(at, &straight)) > 0.0 {
                    before.entry(node).or_insert(std::mem::replace(at, straight));
                }
            }
        }
        mended.extend(folded);
        if before.len() == n {
            break;
        }
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
        "{} elements were folded by their curved edges, which are straight now: {}{more}; middles of edges moved by up to {furthest:.2e} m, which \
         changes the volume of the part by {:+.1e} of it; a finer mesh there or Mesh.HighOrderOptimize = 2 of Gmsh keeps edges curved",
        mended.len(),
        first.join(", "),
        change / total
    ));
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
