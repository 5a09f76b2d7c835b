//! Stress from the displacements of nodes.

use nalgebra::{Matrix3, Vector3};

use crate::jacobian::PointOf;
use crate::matrices::{Constants, Materials};
use crate::mesh::Mesh;
use crate::raw::Element;

/// Stress from the gradient of the displacement, Hooke's law (theory Eq. E.3) \[Pa\].
pub fn stress(constants: &Constants, gradient: &Matrix3<f64>) -> Matrix3<f64> {
    let strain = 0.5 * (gradient + gradient.transpose());
    Matrix3::identity() * (constants.lambda * strain.trace()) + strain * (2.0 * constants.mu)
}

impl Mesh {
    /// Stress at the parameters `xi` of element `e` under the displacements `u`, three a node \[m\], as the functions have it \[Pa\].
    ///
    /// # Panics
    /// If there is no such element.
    pub fn stress_at(&self, e: usize, xi: &[f64; 3], materials: &Materials, u: &[f64]) -> Matrix3<f64> {
        let element = self.elements().get(e);
        let (mut at, mut places) = (PointOf::default(), Vec::new());
        self.places(element.nodes, &mut places);
        at.evaluate(element.kind, &places, xi);
        stress(materials.of(e), &gradient(element, &at, u))
    }

    /// Stress at every node: what the points of the stiffness rule show, continued linearly to the nodes of each element by least
    /// squares and averaged over the elements of a node \[Pa\]. The points of the rule are where the stress of displacement elements is best
    /// (J. Barlow, Int. J. Numer. Meth. Eng. 10, 1976).
    pub fn nodal_stress(&self, materials: &Materials, u: &[f64]) -> Vec<Matrix3<f64>> {
        let mut sums = vec![(Matrix3::zeros(), 0.0); self.nodes().len()];
        let (mut at, mut places) = (PointOf::default(), Vec::new());
        for (e, element) in self.elements().iter().enumerate() {
            self.places(element.nodes, &mut places);
            let rule = element.kind.stiffness_rule();
            let centre = rule.iter().map(|p| Vector3::from(p.xi)).sum::<Vector3<f64>>() / rule.len() as f64;
            let (mut mean, mut moment) = (Matrix3::zeros(), Matrix3::zeros());
            let mut first = [Matrix3::zeros(); 3];
            for point in &rule {
                at.evaluate(element.kind, &places, &point.xi);
                let value = stress(materials.of(e), &gradient(element, &at, u));
                let arm = Vector3::from(point.xi) - centre;
                mean += value / rule.len() as f64;
                moment += arm * arm.transpose();
                (0..3).for_each(|d| first[d] += value * arm[d]);
            }
            let inverse = moment.try_inverse().unwrap_or_else(Matrix3::zeros);
            for (&node, xi) in element.nodes.iter().zip(element.kind.node_parameters()) {
                let weights = inverse * (Vector3::from(xi) - centre);
                let value = mean + first[0] * weights[0] + first[1] * weights[1] + first[2] * weights[2];
                let sum = &mut sums[node as usize];
                sum.0 += value;
                sum.1 += 1.0;
            }
        }
        sums.into_iter().map(|(sum, n)| sum / n).collect()
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
