//! Matrices of one element.

use super::Constants;
use crate::jacobian::PointOf;
use crate::kind::ElementKind;
use crate::mesh::Mesh;
use crate::raw::Element;
use crate::rules::{MassRule, RulePoint};
use crate::ties::Ties;

/// Rules of one kind.
pub struct KindRules {
    kind: ElementKind,
    stiffness: Vec<RulePoint<3>>,
    mass: Vec<RulePoint<3>>,
}

impl KindRules {
    /// The rules of every kind.
    pub fn all(rule: MassRule) -> Vec<Self> {
        let rules =
            |kind: ElementKind| Self { kind, stiffness: kind.stiffness_rule(), mass: kind.mass_points(rule) };
        ElementKind::ALL.map(rules).into()
    }
}

/// Matrices of an element, column by column of its nodes.
pub struct ElementMatrices {
    /// Blocks of nine, each column by column: entry `9 (n b + a) + 3 c + r` couples direction `r` of node `a` with `c` of `b`.
    pub stiffness: Vec<f64>,
    /// Entry `n b + a`.
    pub mass: Vec<f64>,
}

impl ElementMatrices {
    /// Integrates the element.
    pub fn new(mesh: &Mesh, element: Element<'_>, constants: &Constants, rules: &[KindRules]) -> Self {
        let n = element.nodes.len();
        let mut out = Self { stiffness: vec![0.0; 9 * n * n], mass: vec![0.0; n * n] };
        let Some(rules) = rules.iter().find(|r| r.kind == element.kind) else { return out };
        let (mut at, mut places) = (PointOf::default(), Vec::with_capacity(n));
        mesh.places(element.nodes, &mut places);
        let Constants { lambda, mu, density } = *constants;
        for point in &rules.stiffness {
            at.evaluate(element.kind, &places, &point.xi);
            let weight = point.weight * at.determinant;
            out.add_stiffness(&at.gradients, (lambda * weight, mu * weight));
        }
        for point in &rules.mass {
            at.evaluate(element.kind, &places, &point.xi);
            let weight = density * point.weight * at.determinant;
            let values = &at.functions.values;
            for b in 0..n {
                for a in 0..n {
                    out.mass[n * b + a] += weight * values[a] * values[b];
                }
            }
        }
        out
    }

    /// The matrices of an element with the nodes `own` in terms of the free nodes `free` that these follow: with the weights `T` of
    /// (C.70), `T^T K T` and `T^T M T`.
    pub fn tied(self, own: &[u32], ties: &Ties, free: &[u32]) -> Self {
        if own.iter().all(|&node| !ties.is_tied(node)) {
            return self;
        }
        let (n, m) = (own.len(), free.len());
        let single = |node: u32| [(node, 1.0)];
        let places = |node: u32| -> Vec<(usize, f64)> {
            let own = single(node);
            let list = ties.of(node).unwrap_or(&own);
            let place = |(of, w): &(u32, f64)| free.binary_search(of).ok().map(|at| (at, *w));
            list.iter().filter_map(place).collect()
        };
        let weights: Vec<Vec<(usize, f64)>> = own.iter().map(|&node| places(node)).collect();
        let mut out = Self { stiffness: vec![0.0; 9 * m * m], mass: vec![0.0; m * m] };
        for (b, a) in (0..n).flat_map(|b| (0..n).map(move |a| (b, a))) {
            let block = &self.stiffness[9 * (n * b + a)..][..9];
            for (column, v) in &weights[b] {
                for (row, w) in &weights[a] {
                    let at = m * column + row;
                    out.mass[at] += v * w * self.mass[n * b + a];
                    let sum = &mut out.stiffness[9 * at..][..9];
                    sum.iter_mut().zip(block).for_each(|(sum, entry)| *sum += v * w * entry);
                }
            }
        }
        out
    }

    /// `λ g_a,r g_b,c + μ (g_a,c g_b,r + δ_rc g_a · g_b)` for all nodes (theory Eq. E.11).
    fn add_stiffness(&mut self, gradients: &[[f64; 3]], (lambda, mu): (f64, f64)) {
        let n = gradients.len();
        for (b, g) in gradients.iter().enumerate() {
            for (a, f) in gradients.iter().enumerate() {
                let block = &mut self.stiffness[9 * (n * b + a)..][..9];
                let trace = mu * (f[0] * g[0] + f[1] * g[1] + f[2] * g[2]);
                for c in 0..3 {
                    for r in 0..3 {
                        block[3 * c + r] += lambda * f[r] * g[c] + mu * f[c] * g[r];
                    }
                    block[4 * c] += trace;
                }
            }
        }
    }
}
