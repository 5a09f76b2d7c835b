//! Stress from the displacements of nodes.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use crate::jacobian::PointOf;
use crate::kind::ElementKind;
use crate::matrices::{Constants, Materials};
use crate::mesh::Mesh;
use crate::raw::Element;
use crate::shape::Functions;

/// Stress from the gradient of the displacement, Hooke's law (theory Eq. E.3) \[Pa\].
pub fn stress(constants: &Constants, gradient: &Matrix3<f64>) -> Matrix3<f64> {
    let strain = 0.5 * (gradient + gradient.transpose());
    Matrix3::identity() * (constants.lambda * strain.trace()) + strain * (2.0 * constants.mu)
}

impl Mesh {
    /// Stress at every node: what the points of the stiffness rule show, continued linearly to the nodes of each element by least
    /// squares and averaged over the elements of a node \[Pa\]. The points of the rule are where the stress of displacement elements is best
    /// (J. Barlow, Int. J. Numer. Meth. Eng. 10, 1976).
    pub fn nodal_stress(&self, materials: &Materials, u: &[f64]) -> Vec<Matrix3<f64>> {
        let mut sums = vec![(Matrix3::zeros(), 0.0); self.nodes().len()];
        let (mut at, mut places) = (PointOf::default(), Vec::new());
        let mut continued = Continued::default();
        for (e, element) in self.elements().iter().enumerate() {
            self.places(element.nodes, &mut places);
            let continuation = continued.of(element.kind);
            let at_points: Vec<Matrix3<f64>> = continuation
                .points
                .iter()
                .map(|xi| {
                    at.evaluate(element.kind, &places, xi);
                    stress(materials.of(e), &gradient(element, &at, u))
                })
                .collect();
            for (&node, weights) in element.nodes.iter().zip(&continuation.to_nodes) {
                let sum = &mut sums[node as usize];
                sum.0 += at_points.iter().zip(weights).map(|(value, w)| value * *w).sum::<Matrix3<f64>>();
                sum.1 += 1.0;
            }
        }
        sums.into_iter().map(|(sum, n)| sum / n).collect()
    }

    /// Strain and stress at the parameters `xi` of element `e` by a unit of the displacement of every node that they depend on, along each
    /// direction [1/m], rising by node: the values at the nodes of the element as [`Mesh::nodal_stress`] has them, but averaged over
    /// elements of its own material alone, and interpolated by its functions.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn unit_states(&self, e: usize, xi: &[f64; 3], materials: &Materials) -> Vec<(u32, [PointState; 3])> {
        let element = self.elements().get(e);
        let mut functions = Functions::default();
        element.kind.functions(xi, &mut functions);
        let own = materials.of(e);
        let value =
            |node: u32| element.nodes.iter().position(|&n| n == node).map(|i| (i, functions.values[i]));
        let around = || self.elements().iter().enumerate().filter(|(k, _)| materials.of(*k) == own);
        let mut n_around = vec![0.0; element.nodes.len()];
        for node in around().flat_map(|(_, other)| other.nodes) {
            value(*node).into_iter().for_each(|(i, _)| n_around[i] += 1.0);
        }
        let (mut at, mut places) = (PointOf::default(), Vec::new());
        let mut continued = Continued::default();
        let mut sums: BTreeMap<u32, [PointState; 3]> = BTreeMap::new();
        for (_, other) in around().filter(|(_, other)| other.nodes.iter().any(|&n| value(n).is_some())) {
            self.places(other.nodes, &mut places);
            let continuation = continued.of(other.kind);
            for (g, point) in continuation.points.iter().enumerate() {
                let shared = other.nodes.iter().zip(&continuation.to_nodes);
                let shared =
                    shared.filter_map(|(&n, weights)| value(n).map(|(i, v)| v / n_around[i] * weights[g]));
                let weight: f64 = shared.sum();
                at.evaluate(other.kind, &places, point);
                for (&node, slope) in other.nodes.iter().zip(&at.gradients) {
                    let states = sums.entry(node).or_default();
                    for (c, state) in states.iter_mut().enumerate() {
                        let gradient = Vector3::ith(c, weight) * Vector3::from(*slope).transpose();
                        state.strain += 0.5 * (gradient + gradient.transpose());
                        state.stress += stress(own, &gradient);
                    }
                }
            }
        }
        sums.into_iter().collect()
    }
}

/// Strain and stress at a point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PointState {
    /// Strain tensor.
    pub strain: Matrix3<f64>,
    /// Stress tensor \[Pa\].
    pub stress: Matrix3<f64>,
}

/// How values at the points of the stiffness rule are continued to the nodes of an element: linearly, by least squares.
struct Continuation {
    points: Vec<[f64; 3]>,
    /// For each node a weight for every point.
    to_nodes: Vec<Vec<f64>>,
}

impl Continuation {
    fn new(kind: ElementKind) -> Self {
        let points: Vec<[f64; 3]> = kind.stiffness_rule().iter().map(|p| p.xi).collect();
        let share = 1.0 / points.len() as f64;
        let centre = points.iter().map(|xi| Vector3::from(*xi)).sum::<Vector3<f64>>() * share;
        let arm = |xi: &[f64; 3]| Vector3::from(*xi) - centre;
        let moment = points.iter().map(|xi| arm(xi) * arm(xi).transpose()).sum::<Matrix3<f64>>();
        // A single point tells a constant.
        let inverse = moment.try_inverse().unwrap_or_else(Matrix3::zeros);
        let to_node = |xi: &[f64; 3]| {
            let slope = inverse * arm(xi);
            points.iter().map(|point| share + slope.dot(&arm(point))).collect()
        };
        let to_nodes = kind.node_parameters().iter().map(to_node).collect();
        Self { points, to_nodes }
    }
}

/// Continuations of the kinds met so far.
#[derive(Default)]
struct Continued(Vec<(ElementKind, Continuation)>);

impl Continued {
    fn of(&mut self, kind: ElementKind) -> &Continuation {
        let at = self.0.iter().position(|(k, _)| *k == kind).unwrap_or_else(|| {
            self.0.push((kind, Continuation::new(kind)));
            self.0.len() - 1
        });
        &self.0[at].1
    }
}

fn gradient(element: Element<'_>, at: &PointOf, u: &[f64]) -> Matrix3<f64> {
    let mut gradient = Matrix3::zeros();
    for (&node, g) in element.nodes.iter().zip(&at.gradients) {
        let own = Vector3::from_column_slice(&u[3 * node as usize..][..3]);
        gradient += own * Vector3::from(*g).transpose();
    }
    gradient
}
