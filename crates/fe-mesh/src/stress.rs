//! Stress and strain averaged at nodes, from the displacements of a mesh.

use std::collections::BTreeMap;

use iga_core::SplineError;
use iga_core::elasticity::MaterialField;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::recovery::RecoveryWorkspace;
use nalgebra::{Matrix3, Vector3};

use crate::element::kind::ElementKind;
use crate::element::shape::Functions;
use crate::space::MeshSpace;

impl MeshSpace {
    /// Stress at every node, `xx, yy, zz, xy, yz, zx`, of an axisymmetric mesh in the order of its model, of the mesh under the displacements `u` of the
    /// functions: what the points of the stiffness rule show, continued linearly to the nodes of
    /// each element by least squares and averaged over the elements of a node, the apex of pyramids
    /// among them, where gradients themselves have no single value \[Pa\]. The points of the rule
    /// are where the stress of displacement elements is best (J. Barlow, Int. J. Numer. Meth. Eng.
    /// 10, 1976).
    ///
    /// # Errors
    /// [`SplineError::Folded`] where the Jacobian determinant is not positive.
    pub fn nodal_stress(
        &self,
        materials: &dyn MaterialField,
        u: &[f64],
    ) -> Result<Vec<[f64; 6]>, SplineError> {
        let mut sums = vec![([0.0; 6], 0.0); self.mesh().nodes().len()];
        let (mut work, mut continued) = (RecoveryWorkspace::default(), Continued::default());
        for (e, element) in self.mesh().elements().iter().enumerate() {
            let continuation = continued.of(element.kind);
            let state = |xi| work.stress(self, self.mesh().model(), materials.on(e), u, e, xi);
            let at_points = continuation.points.iter().map(state).collect::<Result<Vec<_>, _>>()?;
            for (&node, weights) in element.nodes.iter().zip(&continuation.to_nodes) {
                let sum = &mut sums[node as usize];
                for (k, component) in sum.0.iter_mut().enumerate() {
                    let parts = at_points.iter().zip(weights);
                    *component += parts.map(|(state, w)| state.stress[k] * w).sum::<f64>();
                }
                sum.1 += 1.0;
            }
        }
        Ok(sums.into_iter().map(|(sum, n)| sum.map(|s| s / n)).collect())
    }

    /// Strain and stress at the parameters `xi` of element `e` by a unit of the displacement of
    /// every function that they depend on, along each direction [1/m], rising by function: the
    /// values at the nodes of the element as [`MeshSpace::nodal_stress`] has them, but averaged
    /// over elements of its own material alone, and interpolated by its shape functions.
    ///
    /// # Errors
    /// [`SplineError::Folded`] where the Jacobian determinant is not positive.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn unit_states(
        &self,
        materials: &dyn MaterialField,
        e: usize,
        xi: &[f64; 3],
    ) -> Result<Vec<(u32, Vec<PointState>)>, SplineError> {
        let elements = self.mesh().elements();
        let element = elements.get(e);
        let mut functions = Functions::default();
        element.kind.functions(xi, &mut functions);
        let own = materials.on(e);
        let value =
            |node: u32| element.nodes.iter().position(|&n| n == node).map(|i| (i, functions.values[i]));
        let around = || elements.iter().enumerate().filter(|(k, _)| materials.on(*k) == own);
        let mut n_around = vec![0.0; element.nodes.len()];
        for node in around().flat_map(|(_, other)| other.nodes) {
            value(*node).into_iter().for_each(|(i, _)| n_around[i] += 1.0);
        }
        let (mut work, mut continued) = (RecoveryWorkspace::default(), Continued::default());
        let mut sums: BTreeMap<u32, Vec<PointState>> = BTreeMap::new();
        for (k, other) in around().filter(|(_, other)| other.nodes.iter().any(|&n| value(n).is_some())) {
            let continuation = continued.of(other.kind);
            for (g, point) in continuation.points.iter().enumerate() {
                let shared = other.nodes.iter().zip(&continuation.to_nodes);
                let shared =
                    shared.filter_map(|(&n, weights)| value(n).map(|(i, v)| v / n_around[i] * weights[g]));
                let weight: f64 = shared.sum();
                for (function, states) in work.unit_states(self, self.mesh().model(), own, k, point)? {
                    let sum =
                        sums.entry(function).or_insert_with(|| vec![PointState::default(); states.len()]);
                    sum.iter_mut().zip(&states).for_each(|(sum, state)| sum.add_scaled(state, weight));
                }
            }
        }
        Ok(sums.into_iter().collect())
    }
}

/// How values at the points of the stiffness rule are continued to the nodes of an element:
/// linearly, by least squares.
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
        let mut moment = points.iter().map(|xi| arm(xi) * arm(xi).transpose()).sum::<Matrix3<f64>>();
        if kind.dimension() == 2 {
            moment[(2, 2)] = 1.0;
        }
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
